"""Light and dark: Qt's Fusion style with palettes of our own, the same on every system."""

from __future__ import annotations

from dataclasses import dataclass

from PySide6.QtGui import QColor, QPalette
from PySide6.QtWidgets import QToolButton, QWidget

Rgb = tuple[float, float, float]


@dataclass(frozen=True)
class Theme:
    """Colours of the window and of the view.

    Attributes
    ----------
    window, base, text_colour, highlight, muted : str
        For widgets.
    top, bottom, text : tuple of float
        Background of the view, and what is written there.
    """

    window: str
    base: str
    text_colour: str
    highlight: str
    muted: str
    top: Rgb
    bottom: Rgb
    text: Rgb

    def box_palette(self) -> QPalette:
        """Return the palette of what has boxes to tick, whose outline Fusion draws darker than the window.

        In a dark window nobody would see that.
        """
        palette = self.palette()
        if QColor(self.window).lightness() < 128:
            palette.setColor(QPalette.ColorRole.Window, QColor(self.muted).lighter(140))
        return palette

    def palette(self) -> QPalette:
        """Return the palette of the widgets."""
        palette = QPalette(QColor(self.window))
        role = QPalette.ColorRole
        for roles, colour in (
            ((role.Window, role.Button, role.ToolTipBase), self.window),
            ((role.Base,), self.base),
            ((role.AlternateBase,), self.window),
            ((role.WindowText, role.Text, role.ButtonText, role.ToolTipText), self.text_colour),
            ((role.PlaceholderText,), self.muted),
            ((role.Highlight, role.Link), self.highlight),
            ((role.HighlightedText,), "#ffffff"),
        ):
            for one in roles:
                palette.setColor(one, QColor(colour))
        for one in (role.WindowText, role.Text, role.ButtonText):
            palette.setColor(QPalette.ColorGroup.Disabled, one, QColor(self.muted))
        return palette


LIGHT = Theme(
    "#f2f3f5",
    "#ffffff",
    "#1c1f24",
    "#0b6fa4",
    "#9299a3",
    (0.90, 0.92, 0.95),
    (1.0, 1.0, 1.0),
    (0.1, 0.11, 0.13),
)
DARK = Theme(
    "#2a2d33",
    "#1f2226",
    "#e6e8eb",
    "#2a8fc7",
    "#7d848e",
    (0.16, 0.18, 0.21),
    (0.09, 0.10, 0.12),
    (0.93, 0.94, 0.95),
)


def show_checked(button: QToolButton, on: bool) -> None:
    """Show that a button is switched on or off: Fusion's difference is not seen in a dark window."""
    palette = QPalette()
    if on:
        palette.setColor(QPalette.ColorRole.Button, QColor(LIGHT.highlight))
        palette.setColor(QPalette.ColorRole.ButtonText, QColor("#ffffff"))
    button.setPalette(palette)


def share_palette(widget: QWidget) -> None:
    """Let a new widget and all in it have the palette of the window itself, not copies of their own.

    Qt draws buttons and boxes anew for each copy, and keeps the name of each drawing until the theme changes.
    """
    widget.setPalette(QPalette(QColor("black")))  # an equal one would not be taken
    widget.setPalette(QPalette())
