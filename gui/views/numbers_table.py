"""The table of figures, before and after."""

from __future__ import annotations

from PySide6.QtGui import QAction
from PySide6.QtWidgets import QVBoxLayout, QWidget

from ..model.numbers import Row
from .action_button import action_button
from .figure_table import FigureTable


class NumbersTable(QWidget):
    """Figures of the active mesh."""

    def __init__(self, copy: QAction) -> None:
        super().__init__()
        self.table = FigureTable(["", "before", "after"])
        self.table.setToolTip("Before: the mesh as it was opened, or the reference, with faces of its own")
        layout = QVBoxLayout(self)
        layout.setContentsMargins(4, 4, 4, 4)
        layout.addWidget(self.table)
        layout.addWidget(action_button(copy, "Copy as Markdown"))
        self.rows: list[Row] = []

    def show_rows(self, rows: list[Row]) -> None:
        """Show figures."""
        if rows != self.rows:
            self.rows = rows
            self.table.show_texts([(row.name, row.before, row.after) for row in rows])
