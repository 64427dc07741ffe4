"""Buttons for commands: a tool button takes the action itself, a push button does not."""

from __future__ import annotations

from functools import partial

from PySide6.QtCore import SIGNAL, QObject, Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QPushButton, QToolButton


def action_button(action: QAction, text: str = "") -> QPushButton:
    """Return a button that does what an action does, and can be pressed when the action can."""
    button = QPushButton(text or action.text())
    button.setToolTip(action.toolTip())
    button.clicked.connect(action.trigger)
    button.setEnabled(action.isEnabled())
    action.enabledChanged.connect(button.setEnabled)
    return button


def connect_once(button: QToolButton) -> None:
    """Let a tool button be connected with its action once, however often the action changes.

    Qt 6.11 connects them once more at every change, which takes memory, and time at each change after it.
    """
    button.defaultAction().changed.connect(
        partial(_disconnect, button), Qt.ConnectionType.QueuedConnection
    )  # when Qt has told the button


def _disconnect(button: QToolButton) -> None:
    QObject.disconnect(button.defaultAction(), SIGNAL("changed()"), button, None)  # type: ignore[call-overload]
