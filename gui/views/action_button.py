"""Push buttons for commands: a tool button would take the action itself, a push button does not."""

from __future__ import annotations

from PySide6.QtGui import QAction
from PySide6.QtWidgets import QPushButton


def action_button(action: QAction, text: str = "") -> QPushButton:
    """Return a button that does what an action does, and can be pressed when the action can."""
    button = QPushButton(text or action.text())
    button.setToolTip(action.toolTip())
    button.clicked.connect(action.trigger)
    button.setEnabled(action.isEnabled())
    action.enabledChanged.connect(button.setEnabled)
    return button
