"""The colour bar, with the thresholds good, warning and bad to be dragged or typed."""

from __future__ import annotations

from PySide6.QtCore import QPointF, QRectF, Qt, Signal
from PySide6.QtGui import QColor, QImage, QMouseEvent, QPainter, QPaintEvent, QPolygonF
from PySide6.QtWidgets import QInputDialog, QWidget

from vtksmooth.report import figure

from .scale import THRESHOLDS, Scale

_NAMES = ("good", "warning", "bad")


class ColourBar(QWidget):
    """A colour scale; above it the title, beside it values and thresholds."""

    #: The thresholds have been changed by the user. True: still being dragged.
    edited = Signal(tuple, bool)

    def __init__(self) -> None:
        super().__init__()
        # As wide as the longest that may stand beside the bar.
        self.setFixedWidth(46 + self.fontMetrics().horizontalAdvance("≥-0.000505 warning"))
        # The view keeps its size when there is nothing to show here.
        keep = self.sizePolicy()
        keep.setRetainSizeWhenHidden(True)
        self.setSizePolicy(keep)
        self.setMouseTracking(True)
        self.setToolTip("Drag a threshold, or double-click it to type a value")
        self._scale: Scale | None = None
        self.title = ""
        self.thresholds: tuple[float, float, float] | None = None
        self._held: int | None = None

    def show_scale(
        self, scale: Scale | None, title: str, thresholds: tuple[float, float, float] | None
    ) -> None:
        """Show a scale; None shows nothing."""
        self._scale, self.title = scale, title
        self.thresholds = thresholds
        self.setVisible(scale is not None)
        self.update()

    # -- drawing -----------------------------------------------------------------------------------

    def _bar(self) -> QRectF:
        return QRectF(10, 64, 20, max(20, self.height() - 98))

    def place(self, value: float) -> float:
        """Return the height in pixels at which a value is drawn."""
        assert self._scale is not None
        bar = self._bar()
        share = (value - self._scale.low) / (self._scale.high - self._scale.low)
        return bar.bottom() - min(max(share, 0.0), 1.0) * bar.height()

    def _value(self, y: float) -> float:
        assert self._scale is not None
        bar = self._bar()
        share = min(max((bar.bottom() - y) / bar.height(), 0.0), 1.0)
        return self._scale.low + share * (self._scale.high - self._scale.low)

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802
        """Draw."""
        if self._scale is None:
            return
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        self.draw(painter, self.palette().windowText().color())
        painter.end()

    def draw(self, painter: QPainter, ink: QColor) -> None:
        """Draw with a painter, here or into a picture."""
        assert self._scale is not None
        scale, bar = self._scale, self._bar()
        painter.setPen(ink)
        painter.drawText(
            QRectF(4, 8, self.width() - 8, 44),
            int(Qt.TextFlag.TextWordWrap | Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter),
            self.title,
        )
        column = QImage(
            scale.colours[::-1].copy().data, 1, len(scale.colours), 3, QImage.Format.Format_RGB888
        )
        painter.drawImage(bar, column)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.drawRect(bar)
        if scale.classes:
            for number, name in enumerate(scale.classes):
                y = self.place(float(number))
                painter.drawText(QPointF(bar.right() + 8, y + 4), name)
            return
        if scale.beyond is not None:
            below = QRectF(bar.left(), bar.bottom() + 10, bar.width(), 10)
            painter.fillRect(below, QColor(*scale.beyond))
            painter.drawText(QPointF(bar.right() + 8, below.bottom()), "inverted")
        taken: list[float] = []
        for value, name, colour in self._handles():
            y = self.place(value)
            tip = QPolygonF(
                [
                    QPointF(bar.right() + 1, y),
                    QPointF(bar.right() + 9, y - 5),
                    QPointF(bar.right() + 9, y + 5),
                ]
            )
            painter.setBrush(QColor(*colour))
            painter.drawPolygon(tip)
            text = y + 4
            while any(abs(text - other) < 13 for other in taken):
                text -= 1
            taken.append(text)
            beyond = "≥" if value > scale.high * (1 + 1e-9) else ""
            painter.drawText(QPointF(bar.right() + 13, text), f"{beyond}{figure(value, 3)} {name}")
        painter.setBrush(Qt.BrushStyle.NoBrush)
        for value in (scale.low, scale.high):
            text = self.place(value) + 4
            if all(abs(text - other) >= 13 for other in taken):
                painter.drawText(QPointF(bar.right() + 13, text), figure(value, 3))

    def _handles(self) -> list[tuple[float, str, tuple[int, int, int]]]:
        if self.thresholds is None:
            return []
        return list(zip(self.thresholds, _NAMES, THRESHOLDS, strict=True))

    # -- changing the thresholds -------------------------------------------------------------------

    def _near(self, y: float) -> int | None:
        if self._scale is None or self.thresholds is None:
            return None
        gaps = [abs(self.place(value) - y) for value in self.thresholds]
        return gaps.index(min(gaps)) if min(gaps) <= 8 else None

    def set_threshold(self, number: int, value: float, dragging: bool = False) -> None:
        """Change one threshold: 0 good, 1 warning, 2 bad; it does not go past its neighbours."""
        assert self.thresholds is not None
        values = list(self.thresholds)
        falling = values[0] > values[2]
        others = [values[i] for i in (number - 1, number + 1) if 0 <= i < 3]
        if number > 0:
            value = min(value, values[number - 1]) if falling else max(value, values[number - 1])
        if number < 2:
            value = max(value, values[number + 1]) if falling else min(value, values[number + 1])
        if value in others and not dragging:
            value = values[number] if values[number] not in others else value
        values[number] = value
        self.thresholds = (values[0], values[1], values[2])
        self.update()
        self.edited.emit(self.thresholds, dragging)

    def mousePressEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        """Take a threshold."""
        self._held = self._near(event.position().y())

    def mouseMoveEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        """Drag it."""
        y = event.position().y()
        if self._held is not None:
            self.set_threshold(self._held, self._value(y), True)
        grip = self._held is not None or self._near(y) is not None
        self.setCursor(Qt.CursorShape.SizeVerCursor if grip else Qt.CursorShape.ArrowCursor)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        """Leave it there."""
        if self._held is not None and self.thresholds is not None:
            self._held = None
            self.edited.emit(self.thresholds, False)

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        """Type a value."""
        number = self._near(event.position().y())
        self._held = None
        if number is None or self.thresholds is None:
            return
        value, given = QInputDialog.getDouble(
            self, self.title, f"Threshold “{_NAMES[number]}”:", self.thresholds[number], -1e300, 1e300, 9
        )
        if given:
            self.set_threshold(number, value)
