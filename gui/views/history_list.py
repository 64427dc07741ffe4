"""The history as a list to click in."""

from __future__ import annotations

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QLabel, QListWidget, QListWidgetItem, QVBoxLayout, QWidget

from ..model.history import History


def megabytes(size: int) -> str:
    """Return bytes as people read them."""
    return f"{size / (1 << 20):,.0f} MB" if size < 10 << 30 else f"{size / (1 << 30):,.0f} GB"


class HistoryList(QWidget):
    """All steps; those undone are grey, and a click goes there."""

    #: So many steps shall be in effect.
    asked = Signal(int)

    def __init__(self) -> None:
        super().__init__()
        self.list = QListWidget()
        self.list.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.memory = QLabel()
        self.memory.setToolTip("Memory of the states that can be gone back to; the limit is in the menu Edit")
        layout = QVBoxLayout(self)
        layout.setContentsMargins(4, 4, 4, 4)
        layout.addWidget(self.list)
        layout.addWidget(self.memory)
        self.list.itemClicked.connect(lambda item: self.asked.emit(self.list.row(item)))

    def show_history(self, history: History) -> None:
        """Show the steps."""
        self.list.clear()
        self._add("Start", "", history.first == 0, history.index == 0, True)
        for number, step in enumerate(history.steps, 1):
            reachable = number >= history.first
            self._add(step.title, step.summary, reachable, number == history.index, number <= history.index)
        self.list.scrollToItem(self.list.item(history.index))
        self.memory.setText(f"{megabytes(history.memory)} of {megabytes(history.limit)}")

    def _add(self, title: str, tip: str, reachable: bool, current: bool, done: bool) -> None:
        item = QListWidgetItem(title)
        gone = "" if reachable else "Its memory has been given up."
        item.setToolTip("\n".join(text for text in (title, tip, gone) if text))
        if not reachable:
            item.setFlags(Qt.ItemFlag.NoItemFlags)
        elif not done:
            item.setForeground(self.palette().placeholderText())
        font = item.font()
        font.setBold(current)
        font.setItalic(not done)
        item.setFont(font)
        self.list.addItem(item)
        if current:
            self.list.setCurrentItem(item)
