"""Which two layers to compare."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QComboBox, QDialog, QDialogButtonBox, QFormLayout, QLabel, QWidget

from ..model.layer import Layer
from .wheel import only_with_focus


class CompareDialog(QDialog):
    """Choose the layer to look at, and the one that it is compared with."""

    #: Compare the first layer with the second.
    asked = Signal(object, object)

    def __init__(self, layers: Sequence[Layer], first: Layer, second: Layer, parent: QWidget) -> None:
        super().__init__(parent)
        self.setWindowTitle("Compare layers")
        self._layers = list(layers)
        self.first, self.second = only_with_focus(QComboBox()), only_with_focus(QComboBox())
        for box, layer in ((self.first, first), (self.second, second)):
            box.addItems([one.name for one in layers])
            box.setCurrentIndex(self._layers.index(layer))
            box.currentIndexChanged.connect(self._chosen)
        self.how = QLabel(wordWrap=True)
        self.buttons = QDialogButtonBox(
            QDialogButtonBox.StandardButton.Ok | QDialogButtonBox.StandardButton.Cancel
        )
        self.buttons.accepted.connect(self.accept)
        self.buttons.rejected.connect(self.reject)
        self.accepted.connect(lambda: self.asked.emit(*self._pair()))
        form = QFormLayout(self)
        form.addRow("Show on", self.first)
        form.addRow("Compare with", self.second)
        form.addRow(self.how)
        form.addRow(self.buttons)
        self.setMinimumWidth(360)
        self._chosen()

    def _pair(self) -> tuple[Layer, Layer]:
        return self._layers[self.first.currentIndex()], self._layers[self.second.currentIndex()]

    def _chosen(self) -> None:
        first, second = self._pair()
        ok = self.buttons.button(QDialogButtonBox.StandardButton.Ok)
        ok.setEnabled(first is not second)
        if first is second or first.state is None or second.state is None:
            self.how.setText("Choose two different layers.")
        elif first.state.has_same_faces(second.state):
            self.how.setText("They have the same faces: compared point by point.")
        else:
            self.how.setText("Their faces differ: the distance from each point to the other surface.")
