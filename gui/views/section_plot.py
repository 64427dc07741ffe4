"""The cross-section in two dimensions: the outline of the mesh before over that of the mesh after."""

from __future__ import annotations

from typing import Any

import numpy as np
import pyqtgraph
from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QAction, QColor
from PySide6.QtWidgets import QLabel, QSlider, QToolBar, QVBoxLayout, QWidget

from vtksmooth.report import figure

from ..model.section import Outline
from ..model.units import labelled, quantity
from .scale import AFTER, BEFORE
from .theme import Theme
from .wheel import only_with_focus

#: Positions of the slider.
_STEPS = 1000


class SectionPlot(QWidget):
    """Outlines in a plane, with equal scales on both axes; a slider moves the plane through the mesh."""

    #: The plane shall go this part of the way through the mesh, 0 to 1.
    moved = Signal(float)

    def __init__(self, actions: list[QAction]) -> None:
        super().__init__()
        self.plot = pyqtgraph.PlotWidget()
        self.plot.setMenuEnabled(False)
        self.plot.setAspectLocked(True)
        self.plot.hideButtons()
        self.plot.showGrid(x=True, y=True, alpha=0.15)
        for name in ("left", "bottom"):
            self.plot.getAxis(name).enableAutoSIPrefix(False)
        self.slider = only_with_focus(QSlider(Qt.Orientation.Horizontal))
        self.slider.setRange(0, _STEPS)
        self.slider.setToolTip("Move the plane; in the view it can be dragged and turned")
        self.slider.valueChanged.connect(lambda place: self.moved.emit(place / _STEPS))
        self.slider.setMinimumWidth(80)
        #: A legend outside of the plot, where it hides nothing.
        self.lengths = QLabel(" ")
        tools = QToolBar()  # where it is too narrow for all, it offers the rest in a menu
        tools.addWidget(self.slider)
        for action in actions:
            action.setIconText(action.text().removeprefix("Across ").removeprefix("the "))
            tools.addAction(action)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(4, 4, 4, 4)
        layout.addWidget(tools)
        layout.addWidget(self.lengths)
        layout.addWidget(self.plot, 1)
        self.setMinimumHeight(130)
        self.outlines: tuple[Outline | None, Outline | None] = (None, None)
        self._shown: Any = None

    def show_outlines(
        self, before: Outline | None, after: Outline | None, names: tuple[str, str], unit: str
    ) -> None:
        """Show outlines; None leaves one out. `names` are those of the axes."""
        self.outlines = (before, after)
        words = []
        for item in [*self.plot.listDataItems()]:
            self.plot.removeItem(item)
        for one, title, colour, width in (
            (after, "after", AFTER, 2.0),
            (before, "before", BEFORE, 1.5),
        ):
            if one is None:
                continue
            x, y = one.segments.reshape(-1, 2).T
            length = quantity(figure(one.length, 5), unit)
            words.append(f'<span style="color: {QColor(*colour).name()}">▬</span> {title}, {length} long')
            pen = pyqtgraph.mkPen(QColor(*colour), width=width)
            self.plot.plot(x, y, connect="pairs", pen=pen, name=title)
        self.lengths.setText("&nbsp; ".join(words) or " ")
        for axis, name in zip(("bottom", "left"), names, strict=True):
            self.plot.getAxis(axis).setLabel(labelled(name, unit))
        if names != self._shown and any(one is not None and len(one.segments) for one in self.outlines):
            # Once for each direction: whoever has come near wants to stay there while the plane moves.
            self._shown = names
            self.frame()

    def frame(self) -> None:
        """Bring the outlines into view."""
        points = [one.segments.reshape(-1, 2) for one in self.outlines if one is not None]
        every = np.concatenate(points) if points else np.empty((0, 2))
        if len(every):
            low, high = every.min(axis=0), every.max(axis=0)
            self.plot.setRange(xRange=(low[0], high[0]), yRange=(low[1], high[1]), padding=0.05)

    def set_place(self, fraction: float) -> None:
        """Show how far the plane is through the mesh."""
        self.slider.blockSignals(True)
        self.slider.setValue(round(_STEPS * min(max(fraction, 0.0), 1.0)))
        self.slider.blockSignals(False)

    def clear(self) -> None:
        """Show nothing, and forget what was looked at."""
        self._shown = None
        self.show_outlines(None, None, ("", ""), "")

    def set_theme(self, theme: Theme) -> None:
        """Show light or dark."""
        self.plot.setBackground(theme.base)
        for name in ("left", "bottom"):
            axis = self.plot.getAxis(name)
            axis.setPen(theme.muted)
            axis.setTextPen(theme.text_colour)
