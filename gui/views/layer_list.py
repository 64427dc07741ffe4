"""The list of layers: what is open, what it is for, what is shown and worked on."""

from __future__ import annotations

from typing import Any

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QAction, QKeySequence, QMouseEvent, QShortcut
from PySide6.QtWidgets import QComboBox, QHeaderView, QStyle, QTreeWidget, QTreeWidgetItem

from ..model.layer import Layer, Role
from .theme import share_palette
from .wheel import only_with_focus


class LayerList(QTreeWidget):
    """Layers; the tick shows or hides; the highlighted layer is the active one."""

    activated_layer = Signal(object)
    visibility_asked = Signal(object, bool)
    role_asked = Signal(object, object)

    def __init__(self, close: QAction, *actions: QAction) -> None:
        super().__init__()
        self.setContextMenuPolicy(Qt.ContextMenuPolicy.ActionsContextMenu)
        self.addActions([*actions, close])
        delete = QShortcut(QKeySequence(Qt.Key.Key_Delete), self)
        delete.setContext(Qt.ShortcutContext.WidgetShortcut)
        delete.activated.connect(close.trigger)
        self.setHeaderLabels(["Layer", "Role"])
        self.setRootIsDecorated(False)
        self.setMinimumHeight(70)
        self.header().setStretchLastSection(False)
        self.header().setSectionResizeMode(0, QHeaderView.ResizeMode.Stretch)
        self.header().setSectionResizeMode(1, QHeaderView.ResizeMode.ResizeToContents)
        self.itemChanged.connect(self._changed)
        self.currentItemChanged.connect(self._activated)
        self._layers: list[Layer] = []

    def show_layers(self, layers: list[Layer], active: Layer | None) -> None:
        """Show the layers."""
        self.blockSignals(True)
        if layers != self._layers:
            self._layers = list(layers)
            self.clear()
            for layer in layers:
                self._add(layer)
        for row, layer in enumerate(layers):
            item = self.topLevelItem(row)
            assert item is not None
            assert layer.state is not None
            item.setText(0, layer.name + (" *" if layer.unsaved else ""))
            item.setCheckState(0, Qt.CheckState.Checked if layer.visible else Qt.CheckState.Unchecked)
            font = item.font(0)
            font.setBold(layer is active)
            item.setFont(0, font)
            if layer is active:
                self.setCurrentItem(item)
            saved = " (not saved)" if layer.unsaved else ""
            item.setToolTip(
                0,
                f"{layer.path or layer.name}{saved}: {layer.state.n_points:,} points, "
                f"{layer.state.n_faces:,} faces",
            )
            box: Any = self.itemWidget(item, 1)
            box.setCurrentText(layer.role.value)
        self.blockSignals(False)

    def _add(self, layer: Layer) -> None:
        item = QTreeWidgetItem([layer.name, ""])
        item.setFlags(item.flags() | Qt.ItemFlag.ItemIsUserCheckable)
        self.addTopLevelItem(item)
        box = only_with_focus(QComboBox())
        box.addItems([role.value for role in Role])
        box.setToolTip("Mesh: worked on. Reference: compared with. Installation space: to stay inside of.")
        box.activated.connect(
            lambda _, layer=layer, box=box: self.role_asked.emit(layer, Role(box.currentText()))
        )
        self.setItemWidget(item, 1, box)
        share_palette(box)

    def mousePressEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        """Show or hide by the tick, without working on that layer; otherwise choose the layer."""
        place = event.position().toPoint()
        item = self.itemAt(place)
        if item is None or place.x() > self._tick_end(item) or event.button() != Qt.MouseButton.LeftButton:
            super().mousePressEvent(event)
            return
        shown = item.checkState(0) == Qt.CheckState.Checked
        item.setCheckState(0, Qt.CheckState.Unchecked if shown else Qt.CheckState.Checked)

    def _tick_end(self, item: QTreeWidgetItem) -> int:
        style = self.style()
        margin = style.pixelMetric(QStyle.PixelMetric.PM_FocusFrameHMargin, None, self) + 1
        width = style.pixelMetric(QStyle.PixelMetric.PM_IndicatorWidth, None, self)
        return self.visualItemRect(item).left() + width + 2 * margin

    def _activated(self, item: QTreeWidgetItem | None) -> None:
        if item is not None:
            self.activated_layer.emit(self._layers[self._row(item)])

    def _row(self, item: QTreeWidgetItem) -> int:
        return self.indexOfTopLevelItem(item)

    def _changed(self, item: QTreeWidgetItem, column: int) -> None:
        layer = self._layers[self._row(item)]
        visible = item.checkState(0) == Qt.CheckState.Checked
        if column == 0 and visible != layer.visible:
            self.visibility_asked.emit(layer, visible)
