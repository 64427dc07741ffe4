"""The panel of the tools that say what smoothing may do where."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QAction
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QGridLayout,
    QGroupBox,
    QHBoxLayout,
    QLabel,
    QScrollArea,
    QSizePolicy,
    QSlider,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from .parameter_row import NumberBox
from .pen import RADII
from .wheel import only_with_focus

#: What a soft edge is as wide as.
RINGS, DISTANCE = "rings of points", "model units"


def _short(value: float, toward: Callable[[float], int]) -> float:
    """Return a value with the six digits that there is room for, rounded by `toward`."""
    if not value:
        return 0.0
    unit = 10.0 ** (math.floor(math.log10(abs(value))) - 5)
    return float(f"{toward(round(value / unit, 6)) * unit:.6g}")


class RegionPanel(QScrollArea):
    """Tools, and what they are set to."""

    #: The radius of the brush, pixels.
    radius_changed = Signal(int)

    def __init__(self, action: Callable[[str], QAction]) -> None:
        super().__init__(widgetResizable=True)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self._action = action
        page = QWidget()
        column = QVBoxLayout(page)
        column.setContentsMargins(6, 6, 6, 6)
        self.counts = QLabel(wordWrap=True)
        column.addWidget(self.counts)
        column.addWidget(self._tools())
        column.addWidget(self._threshold())
        column.addWidget(self._whole())
        column.addWidget(self._lines())
        column.addStretch(1)
        self.setWidget(page)
        self.show_threshold("", None)

    # -- making it ---------------------------------------------------------------------------------

    def _button(self, id: str) -> QToolButton:
        button = QToolButton()
        button.setDefaultAction(self._action(id))
        button.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        return button

    def _group(self, title: str, *ids: str) -> tuple[QGroupBox, QGridLayout]:
        box = QGroupBox(title)
        grid = QGridLayout(box)
        grid.setContentsMargins(6, 6, 6, 6)
        grid.setSpacing(4)
        for number, id in enumerate(ids):
            grid.addWidget(self._button(id), number // 2, number % 2)
        return box, grid

    def _switch(self, id: str) -> QCheckBox:
        action, box = self._action(id), QCheckBox(self._action(id).text())
        box.setToolTip(action.toolTip())
        box.setChecked(action.isChecked())
        box.toggled.connect(action.setChecked)
        action.toggled.connect(box.setChecked)
        return box

    def _tools(self) -> QGroupBox:
        box, grid = self._group(
            "Tools",
            *(f"region_{tool}" for tool in ("camera", "brush", "lasso", "line", "patch", "component")),
        )
        grid.addWidget(self._switch("region_free"), 3, 0, 1, 2)
        grid.addWidget(self._switch("region_through"), 4, 0, 1, 2)
        self.radius = only_with_focus(QSlider(Qt.Orientation.Horizontal))
        self.radius.setRange(*RADII)
        self.radius.setToolTip("Radius of the brush, pixels ([ and ])")
        self.radius.valueChanged.connect(self.radius_changed)
        line = QHBoxLayout()
        line.addWidget(QLabel("Brush"))
        line.addWidget(self.radius)
        grid.addLayout(line, 5, 0, 1, 2)
        return box

    def _threshold(self) -> QGroupBox:
        box, grid = self._group("By threshold")
        self.what = QLabel()
        self.low, self.high = only_with_focus(NumberBox()), only_with_focus(NumberBox())
        for number in (self.low, self.high):
            number.setRange(-1e300, 1e300)
            number.setMinimumWidth(60)
        line = QHBoxLayout()
        line.addWidget(self.low, 1)
        line.addWidget(QLabel("to"))
        line.addWidget(self.high, 1)
        grid.addWidget(self.what, 0, 0, 1, 2)
        grid.addLayout(line, 1, 0, 1, 2)
        grid.addWidget(self._button("region_threshold"), 2, 0, 1, 2)
        return box

    def _whole(self) -> QGroupBox:
        box, grid = self._group("Region", "region_grow", "region_shrink", "region_invert", "region_clear")
        self.width_box, self.unit = only_with_focus(NumberBox()), only_with_focus(QComboBox())
        self.width_box.setRange(0.0, 1e300)
        self.width_box.setValue(3.0)
        self.width_box.setToolTip("How wide the soft edge is; 0: none")
        self.unit.addItems([RINGS, DISTANCE])
        line = QHBoxLayout()
        line.addWidget(QLabel("Soft edge"))
        line.addWidget(self.width_box, 1)
        line.addWidget(self.unit)
        grid.addLayout(line, 2, 0, 1, 2)
        grid.addWidget(self._button("region_soften"), 3, 0, 1, 2)
        return box

    def _lines(self) -> QGroupBox:
        box, grid = self._group("Feature lines", "region_edges", "region_clear_lines")
        hint = QLabel(
            "Click from point to point to add a line, click the last point again to end it. With Ctrl a "
            "click on a line removes it.",
            wordWrap=True,
        )
        grid.addWidget(hint, 1, 0, 1, 2)
        return box

    # -- what it says ------------------------------------------------------------------------------

    def show_threshold(self, title: str, span: tuple[float, float] | None) -> None:
        """Offer a span of the overlay's values; None: it has none."""
        self.what.setText(title or "No overlay with values is shown")
        for box in (self.low, self.high):
            box.setEnabled(span is not None)
            box.clear()
        if span is not None:
            self.low.setValue(_short(span[0], math.floor))
            self.high.setValue(_short(span[1], math.ceil))

    def threshold(self, span: tuple[float, float]) -> tuple[float, float]:
        """Return the span of values that is set; an end that is that of `span` has no limit.

        The boxes show rounded numbers, which may leave out the very worst values.
        """
        low, high = self.low.value(), self.high.value()
        return (
            -np.inf if low <= span[0] or np.isclose(low, span[0], rtol=1e-9, atol=1e-14) else low,
            np.inf if high >= span[1] or np.isclose(high, span[1], rtol=1e-9, atol=1e-14) else high,
        )

    def softness(self) -> dict[str, float | int]:
        """Return the width of the soft edge, as the filter takes it."""
        if self.unit.currentText() == RINGS:
            return {"blend_rings": round(self.width_box.value())}
        return {"blend_distance": self.width_box.value()}
