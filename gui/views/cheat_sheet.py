"""The cheat sheet: all keys, from the table of commands."""

from __future__ import annotations

from html import escape

from PySide6.QtGui import QKeySequence, QShortcut
from PySide6.QtWidgets import QDialog, QDialogButtonBox, QLabel, QScrollArea, QVBoxLayout, QWidget

from ..commands import COMMANDS, MENUS

#: The column of each menu.
_COLUMNS = {
    **dict.fromkeys(("File", "Edit", "Filters", "Help"), 0),
    **dict.fromkeys(("View", "Recipe"), 1),
    **dict.fromkeys(("Overlay", "Measure"), 2),
    "Regions": 3,
}


def html() -> str:
    """Return the keys by menu, as columns."""
    columns = [[], [], [], []]  # type: list[list[str]]
    for menu in MENUS:
        rows = "".join(
            f"<tr><td style='padding-right:12px'><b>{escape(c.key.replace('Return', 'Enter'))}</b></td>"
            f"<td>{escape(c.title.rstrip('…'))}</td></tr>"
            for c in COMMANDS
            if c.menu.split(" > ")[0] == menu and c.key
        )
        column = _COLUMNS[menu]
        columns[column].append(f"<h3>{escape(menu)}</h3><table>{rows}</table>" if rows else "")
    columns[0].append(
        "<h3>Mouse</h3><table><tr><td style='padding-right:12px'><b>drag</b></td><td>turn</td></tr>"
        "<tr><td><b>Shift drag</b></td><td>move</td></tr><tr><td><b>wheel</b></td><td>zoom</td></tr>"
        "<tr><td><b>rest</b></td><td>values there</td></tr>"
        "<tr><td style='padding-right:12px'><b>drag in histogram</b></td><td>select faces</td></tr></table>"
    )
    columns[3].append(
        "<h3>Mouse, with a tool for regions</h3><table>"
        "<tr><td><b>drag</b></td><td>paint, draw round</td></tr>"
        "<tr><td style='padding-right:12px'><b>drag beside</b></td><td>turn</td></tr>"
        "<tr><td><b>right drag</b></td><td>turn</td></tr><tr><td><b>click</b></td><td>pick, draw</td></tr>"
        "<tr><td><b>Ctrl</b></td><td>free, remove</td></tr><tr><td><b>Esc</b></td><td>end</td></tr></table>"
    )
    cells = "".join(
        f"<td style='padding-right:28px' valign='top'>{''.join(column)}</td>" for column in columns
    )
    return f"<table><tr>{cells}</tr></table>"


class CheatSheet(QDialog):
    """All keys; H or Esc closes it."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.setWindowTitle("Keyboard shortcuts")
        QShortcut(QKeySequence("H"), self, activated=self.close)  # type: ignore[call-overload]
        label = QLabel(html())
        label.setContentsMargins(16, 4, 16, 12)
        area = QScrollArea(widgetResizable=True)
        area.setWidget(label)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        buttons.rejected.connect(self.reject)
        layout = QVBoxLayout(self)
        layout.addWidget(area)
        layout.addWidget(buttons)
        size = label.sizeHint()
        self.resize(size.width() + 60, min(size.height() + 90, 800))
