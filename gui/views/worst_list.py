"""The list of the worst faces."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import Signal
from PySide6.QtWidgets import QAbstractItemView, QHeaderView

from vtksmooth.report import figure

from ..model.field import Field
from .figure_table import FigureTable


class WorstList(FigureTable):
    """The worst faces by the overlay's values, the worst first."""

    #: A face has been chosen, or None.
    chosen = Signal(object)

    def __init__(self) -> None:
        super().__init__(["face", "value"])
        self.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.horizontalHeader().setSectionResizeMode(QHeaderView.ResizeMode.Stretch)
        self.itemSelectionChanged.connect(self._chosen)
        self._field: Field | None = None

    def show_field(self, field: Field | None, title: str, classes: tuple[str, ...] = ()) -> None:
        """List the worst faces of a field; `classes` are the names of the values 0, 1, 2 ..."""
        if field is self._field:
            return
        self._field = field
        self.blockSignals(True)
        self.clearSelection()
        self.setCurrentItem(None)  # type: ignore[call-overload]
        faces = np.empty(0, int) if field is None else field.worst
        values = () if field is None else field.of_faces[faces]
        texts = [classes[int(value)] if classes else figure(value) for value in values]
        self.show_texts([(f"{face}", text) for face, text in zip(faces, texts, strict=True)])
        self.setToolTip(f"The worst faces by: {title}")
        self.blockSignals(False)

    def go(self, steps: int) -> None:
        """Choose the next face, or with -1 the one before."""
        if self.rowCount():
            row = self.currentRow()
            self.selectRow(0 if row < 0 else (row + steps) % self.rowCount())

    def _chosen(self) -> None:
        rows = self.selectionModel().selectedRows()
        face = None if not rows or self._field is None else int(self._field.worst[rows[0].row()])
        self.chosen.emit(face)
