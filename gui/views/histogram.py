"""The histogram of an overlay, before and after, with a brush to select faces."""

from __future__ import annotations

from typing import Any

import numpy as np
import pyqtgraph
from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QColor
from PySide6.QtWidgets import QLabel, QVBoxLayout, QWidget

from ..model.field import Field
from ..model.numbers import BINS
from .scale import AFTER, BEFORE, THRESHOLDS
from .theme import Theme

_BINS = 60
_BRUSH = (214, 39, 140)


class _BrushBox(pyqtgraph.ViewBox):  # type: ignore[misc]
    """Dragging in the plot spans the brush, a click removes it."""

    spanned = Signal(object)

    def mouseDragEvent(self, event: Any, axis: Any = None) -> None:  # noqa: N802
        event.accept()
        ends = [self.mapSceneToView(place).x() for place in (event.buttonDownScenePos(), event.scenePos())]
        self.spanned.emit((min(ends), max(ends)))

    def mouseClickEvent(self, event: Any) -> None:  # noqa: N802
        event.accept()
        self.spanned.emit(None)


class Histogram(QWidget):
    """Shares of the faces or points by value."""

    #: The brush covers these values; None: nothing.
    brushed = Signal(object)

    def __init__(self) -> None:
        super().__init__()
        box = _BrushBox(enableMenu=False)
        self.plot = pyqtgraph.PlotWidget(viewBox=box)
        self.plot.setMenuEnabled(False)
        self.plot.setMouseEnabled(x=False, y=False)
        self.plot.hideButtons()
        self.plot.getAxis("left").setLabel("%")
        # The last number stands at the end of the axis, half of it beyond.
        self.plot.getAxis("bottom").setStyle(hideOverlappingLabels=False)
        self.plot.getPlotItem().setContentsMargins(0, 6, 14, 0)
        self.plot.getAxis("bottom").enableAutoSIPrefix(False)
        self.plot.getAxis("left").enableAutoSIPrefix(False)
        #: Outside of the plot, where it hides nothing and nothing is to be dragged.
        self.legend = QLabel(
            "&nbsp; ".join(
                f'<span style="color: {QColor(*colour).name()}">▬</span> {name}'
                for name, colour in (("after", AFTER), ("before", BEFORE))
            ),
            alignment=Qt.AlignmentFlag.AlignRight,
        )
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(0)
        layout.addWidget(self.legend)
        layout.addWidget(self.plot, 1)
        self.setMinimumHeight(110)
        self.papers_bins = False
        #: Whether what is shown is k, which the papers' bins are for.
        self._is_k = False
        self._classes: tuple[str, ...] = ()
        self._after: Any = None
        self._fields: tuple[Field | None, Field | None] = (None, None)
        self._span = (0.0, 1.0)
        self._thresholds: tuple[float, ...] = ()
        self.brush = pyqtgraph.LinearRegionItem(
            brush=QColor(*_BRUSH, 55),
            hoverBrush=QColor(*_BRUSH, 80),
            pen=QColor(*_BRUSH),
            hoverPen=QColor(*_BRUSH),
        )
        self.brush.sigRegionChanged.connect(self._brushed)
        box.spanned.connect(self.set_brush)
        self.locked = False
        #: What is shown, and what a locked brush was put over.
        self._title = self._brushed_title = ""
        self._marks: list[Any] = []

    def show_fields(
        self,
        before: Field | None,
        after: Field | None,
        title: str,
        span: tuple[float, float],
        thresholds: tuple[float, ...],
        is_k: bool = False,
        classes: tuple[str, ...] = (),
    ) -> None:
        """Show the values of a mesh, and of the one before it, between the ends of `span`.

        With `classes`, the names of the values 0, 1, 2 ..., each has a bin.
        """
        same = (before, after, span) == (*self._fields, self._span)
        self._is_k, self._title, self._classes = is_k, title, classes
        self.legend.setVisible(before is not None)
        self.brush.setVisible(not self.locked or title == self._brushed_title)
        self._fields, self._span, self._thresholds = (before, after), span, thresholds
        what = "points" if after is not None and after.on_points else "faces"
        self.plot.getAxis("bottom").setLabel(title)
        self.plot.getAxis("left").setLabel(f"% of the {what}")
        if same:
            self._draw_thresholds()
        else:
            self.draw()

    @property
    def coarse(self) -> bool:
        """Whether the papers' bins are drawn."""
        return self.papers_bins and self._is_k

    def edges(self) -> np.ndarray:
        """Return the bins' edges."""
        if self.coarse:
            return np.array(BINS)
        if self._classes:
            return np.arange(len(self._classes) + 1) - 0.5
        low, high = self._span
        for field in self._fields:
            if field is not None and self._span == (0.0, 1.0) and field.span[0] < 0:
                low = max(-1.0, field.span[0])
        return np.linspace(low, high, _BINS + 1)

    def draw(self) -> None:
        """Draw anew."""
        for item in [*self.plot.listDataItems()]:
            self.plot.removeItem(item)
        edges = self.edges()
        widths = np.arange(len(edges)) if self.coarse else edges
        for field, colour, filled in ((self._fields[1], AFTER, True), (self._fields[0], BEFORE, False)):
            if field is None:
                continue
            shares = field.histogram(edges)
            brush = QColor(*colour, 170) if filled else None
            self.plot.plot(
                widths, shares, stepMode="center", fillLevel=0 if filled else None, brush=brush,
                pen=pyqtgraph.mkPen(QColor(*colour), width=2),
            )  # fmt: skip
        names = [f"{edge:g}" for edge in edges] if self.coarse else self._classes
        ticks = [list(enumerate(names))] if names else None
        self.plot.getAxis("bottom").setTicks(ticks)
        self.plot.setXRange(widths[0], widths[-1], padding=0.01)
        self.plot.enableAutoRange(axis="y")
        self._draw_thresholds()

    def _draw_thresholds(self) -> None:
        for mark in self._marks:
            self.plot.removeItem(mark)
        self._marks = []
        if self.coarse:
            return
        for value, colour in zip(self._thresholds, THRESHOLDS, strict=False):
            if self._span[0] <= value <= self._span[1]:
                pen = pyqtgraph.mkPen(QColor(*colour), width=1.5, style=Qt.PenStyle.DashLine)
                mark = pyqtgraph.InfiniteLine(value, pen=pen)
                self._marks.append(mark)
                self.plot.addItem(mark)

    # -- the brush ---------------------------------------------------------------------------------

    def set_brush(self, span: tuple[float, float] | None) -> None:
        """Put the brush over these places of the axis; None removes it. A locked brush stays."""
        if self.locked:
            return
        if span is None:
            if self.brush.scene() is not None:
                self.plot.removeItem(self.brush)
            self.brushed.emit(None)
            return
        if self.brush.scene() is None:
            self.plot.addItem(self.brush)
        self.brush.setRegion(span)
        self._brushed()

    def _brushed(self, *_: Any) -> None:
        if self.brush.scene() is None:
            return
        low, high = self.brush.getRegion()
        if self.coarse:
            # The bins are drawn equally wide; what lies between them is in proportion.
            low, high = np.interp((low, high), np.arange(len(BINS)), BINS)
        self.brushed.emit((float(low), float(high)))

    def set_locked(self, locked: bool) -> None:
        """Keep what is selected, whatever is shown; the brush is seen over the values that it selects by."""
        self.locked = locked
        self.brush.setMovable(not locked)
        if locked:
            self._brushed_title = self._title
        elif not self.brush.isVisible():
            self.set_brush(None)
            self.brush.show()

    def set_theme(self, theme: Theme) -> None:
        """Show light or dark."""
        self.plot.setBackground(theme.base)
        for name in ("left", "bottom"):
            axis = self.plot.getAxis(name)
            axis.setPen(theme.muted)
            axis.setTextPen(theme.text_colour)
        self.draw()
