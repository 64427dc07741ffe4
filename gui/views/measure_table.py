"""The table of measurements, before and after."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from PySide6.QtGui import QAction
from PySide6.QtWidgets import (
    QAbstractItemView,
    QLabel,
    QMenu,
    QToolBar,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from ..model.measure import Measurement, row_texts
from .figure_table import FigureTable


class MeasureTable(QWidget):
    """What was measured; above it what can be measured, and the unit of lengths."""

    def __init__(self, actions: Sequence[QAction], units: QMenu) -> None:
        super().__init__()
        self.table = FigureTable(["", "before", "after"])
        self.table.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        tools = QToolBar()  # where it is too narrow for all, it offers the rest in a menu
        tools.addActions([*actions, units.menuAction()])
        button = tools.widgetForAction(units.menuAction())
        assert isinstance(button, QToolButton)
        button.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
        self.hint = QLabel("", wordWrap=True)
        self.hint.hide()
        layout = QVBoxLayout(self)
        layout.setContentsMargins(4, 4, 4, 4)
        layout.addWidget(tools)
        layout.addWidget(self.hint)
        layout.addWidget(self.table)
        self._of_rows: list[Measurement] = []

    def show_measurements(self, measurements: Sequence[Measurement], unit: str) -> None:
        """Show measurements, with the unit of lengths."""
        rows = [(one, texts) for one in measurements for texts in row_texts(one, unit)]
        self._of_rows = [one for one, _ in rows]
        numbers = {one: number for number, one in enumerate(measurements, 1)}
        self.table.show_texts(
            [(f"{numbers[one]}  {name}, {one.layer.name}", *values) for one, (name, *values) in rows]
        )

    def say(self, text: str) -> None:
        """Say what to do next; an empty text says nothing."""
        self.hint.setText(text)
        self.hint.setVisible(bool(text))

    @property
    def selected(self) -> list[Measurement]:
        """The measurements of the rows that are selected, each once."""
        rows: list[Any] = self.table.selectionModel().selectedRows()
        return list(dict.fromkeys(self._of_rows[index.row()] for index in rows))
