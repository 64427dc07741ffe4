"""The table of figures, before and after."""

from __future__ import annotations

from PySide6.QtGui import QAction
from PySide6.QtWidgets import QHeaderView, QPushButton, QVBoxLayout, QWidget

from ..model.numbers import Row
from .figure_table import FigureTable


class NumbersTable(QWidget):
    """Figures of the active mesh."""

    def __init__(self, copy: QAction) -> None:
        super().__init__()
        self.table = FigureTable(["", "before", "after"])
        self.table.horizontalHeader().setSectionResizeMode(0, QHeaderView.ResizeMode.Stretch)
        button = QPushButton("Copy as Markdown")
        button.setToolTip(copy.shortcut().toString())
        button.clicked.connect(copy.trigger)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(4, 4, 4, 4)
        layout.addWidget(self.table)
        layout.addWidget(button)
        self.rows: list[Row] = []

    def show_rows(self, rows: list[Row]) -> None:
        """Show figures."""
        if rows != self.rows:
            self.rows = rows
            self.table.show_texts([(row.name, row.before, row.after) for row in rows])
