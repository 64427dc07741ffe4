"""The mouse wheel: it scrolls, and changes a value only where the keyboard does so too."""

from __future__ import annotations

from typing import TypeVar

from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtWidgets import QWidget

_Widget = TypeVar("_Widget", bound=QWidget)


class _Guard(QObject):
    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        assert isinstance(watched, QWidget)
        if event.type() == QEvent.Type.Wheel and not watched.hasFocus():
            event.ignore()  # what lies around the widget scrolls instead
            return True
        return False


def only_with_focus(widget: _Widget) -> _Widget:
    """Let a spin box, combo box or slider take the wheel only while it has the focus; return it."""
    widget.setFocusPolicy(Qt.FocusPolicy.StrongFocus)  # the wheel itself does not give it
    widget.installEventFilter(_Guard(widget))
    return widget
