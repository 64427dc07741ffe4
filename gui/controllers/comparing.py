"""Comparing any two layers."""

from __future__ import annotations

from PySide6.QtCore import QObject, Slot

from ..model import overlays
from ..model.document import Document
from ..model.layer import Layer
from ..views.compare_dialog import CompareDialog
from ..views.main_window import MainWindow
from .display import Display


class Comparing(QObject):
    """The command that compares two layers; the overlays Difference and Signed difference show it."""

    def __init__(self, document: Document, window: MainWindow, display: Display) -> None:
        super().__init__(window)
        self._document, self._window, self._display = document, window, display
        self.dialog: CompareDialog | None = None

    def compare_layers(self) -> None:
        """Ask for the two layers."""
        layers = [layer for layer in self._document.layers if layer.state and layer.state.n_faces]
        if len(layers) < 2:
            self._window.notification.say("Open another mesh first: it takes two to compare.", "warning")
            return
        first = self._document.active if self._document.active in layers else layers[0]
        assert first is not None
        other = self._document.other
        second = other if other in layers else next(layer for layer in layers if layer is not first)
        assert second is not None
        self.dialog = CompareDialog(layers, first, second, self._window)
        self.dialog.asked.connect(self.compare)
        self.dialog.show()

    @Slot(object, object)
    def compare(self, layer: Layer, other: Layer) -> None:
        """Show how far `layer` is from `other`."""
        self._document.compare(layer, other)
        self._display.show_overlay(overlays.overlay("difference"))
