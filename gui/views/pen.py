"""The pen: what the mouse does in the view of the meshes while a tool for regions is chosen."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QEvent, QObject, QPointF, Qt, Signal
from PySide6.QtGui import QColor, QMouseEvent, QPainter, QPaintEvent, QPen, QPolygonF
from PySide6.QtWidgets import QApplication, QWidget

#: Ways to use the pen: paint with a round brush, draw an outline, click.
PAINT, OUTLINE, CLICK = "paint", "outline", "click"

#: A button that is let go of within so many pixels has been clicked.
_CLICK = 5.0

#: Smallest and largest radius of the brush, pixels.
RADII = (2, 200)


class Pen(QWidget):
    """A transparent sheet over the view, on which the brush and the outline are seen.

    The left button paints, draws or clicks; the wheel zooms and Shift moves as ever. What is beside the mesh
    cannot be painted, so there the left button turns the view; the right one turns it everywhere. With Ctrl
    points are freed instead of fixed.

    Parameters
    ----------
    canvas : QWidget
        The widget that VTK draws into.
    on_mesh : callable
        Returns whether a place of the canvas is on the mesh.
    """

    #: A stroke begins, goes on, has ended: where, and whether Ctrl is held.
    begun = Signal(QPointF, bool)
    moved = Signal(QPointF)
    ended = Signal()
    #: An outline has been closed: its corners, and whether Ctrl is held.
    outlined = Signal(list, bool)
    clicked = Signal(QPointF, bool)

    def __init__(self, canvas: QWidget, on_mesh: Callable[[QPointF], bool]) -> None:
        super().__init__(canvas)
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self._canvas, self._on_mesh = canvas, on_mesh
        self.use = ""
        self.radius = 24
        self._at: QPointF | None = None
        self._down: QPointF | None = None
        self._painting = False
        self._outline: list[QPointF] = []
        self._free = False
        self._turning = self._passing_on = False
        canvas.installEventFilter(self)
        self.hide()

    def set_use(self, use: str) -> None:
        """Use the pen for :data:`PAINT`, :data:`OUTLINE` or :data:`CLICK`; "": not at all."""
        self.drop()
        self.use = use
        self.setVisible(bool(use))
        self.setGeometry(self._canvas.rect())
        shapes = {PAINT: Qt.CursorShape.BlankCursor, OUTLINE: Qt.CursorShape.CrossCursor}
        self._canvas.setCursor(
            shapes.get(use, Qt.CursorShape.PointingHandCursor if use else Qt.CursorShape.ArrowCursor)
        )
        self.raise_()
        self.update()

    def set_radius(self, radius: int) -> None:
        """Set the radius of the brush, pixels."""
        self.radius = radius
        self.update()

    @property
    def busy(self) -> bool:
        """Whether a stroke or an outline is being drawn."""
        return self._painting or bool(self._outline)

    def drop(self) -> None:
        """Forget what is being drawn."""
        self._painting, self._down = False, None
        self._outline.clear()
        self.update()

    # -- the mouse ---------------------------------------------------------------------------------

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        """Take what belongs to the pen."""
        kind = event.type()
        if kind == QEvent.Type.Resize:
            self.setGeometry(self._canvas.rect())
        if not self.use or self._passing_on or watched is not self._canvas:
            return False
        if kind == QEvent.Type.Leave and not self.busy:
            self._at = None
            self.update()
        if not isinstance(event, QMouseEvent):
            return False
        self._at = event.position()
        self.update()
        if kind in (QEvent.Type.MouseButtonPress, QEvent.Type.MouseButtonDblClick):
            return self._press(event)
        if kind == QEvent.Type.MouseMove:
            return self._move(event)
        return kind == QEvent.Type.MouseButtonRelease and self._release(event)

    def _press(self, event: QMouseEvent) -> bool:
        if event.button() == Qt.MouseButton.RightButton and self.use != CLICK:
            self._turning = True
            return self._turn(event)
        if (
            event.button() != Qt.MouseButton.LeftButton
            or event.modifiers() & Qt.KeyboardModifier.ShiftModifier
        ):
            return False
        free = bool(event.modifiers() & Qt.KeyboardModifier.ControlModifier)
        if self.use == CLICK:
            self._down = event.position()
            return False
        if self.use == PAINT:
            if not self._on_mesh(event.position()):
                return False
            self._painting = True
            self.begun.emit(event.position(), free)
        else:
            self._free, self._outline = free, [event.position()]
        return True

    def _move(self, event: QMouseEvent) -> bool:
        if self._turning:
            return self._turn(event)
        if self._painting:
            self.moved.emit(event.position())
        elif self._outline:
            self._outline.append(event.position())
        return self.busy

    def _release(self, event: QMouseEvent) -> bool:
        if self._turning and event.button() == Qt.MouseButton.RightButton:
            self._turn(event)
            self._turning = False
            return True
        if event.button() != Qt.MouseButton.LeftButton:
            return False
        down, self._down = self._down, None
        if down is not None and (event.position() - down).manhattanLength() <= _CLICK:
            self.clicked.emit(down, bool(event.modifiers() & Qt.KeyboardModifier.ControlModifier))
        if self._painting:
            self._painting = False
            self.ended.emit()
            return True
        if self._outline:
            outline, self._outline = self._outline, []
            self.outlined.emit(outline, self._free)
            return True
        return False

    def _turn(self, event: QMouseEvent) -> bool:
        """Let the canvas have an event of the right button as one of the left, which turns the view."""
        left, none = Qt.MouseButton.LeftButton, Qt.MouseButton.NoButton
        kind = event.type()
        moving, released = kind == QEvent.Type.MouseMove, kind == QEvent.Type.MouseButtonRelease
        self._passing_on = True
        QApplication.sendEvent(
            self._canvas,
            QMouseEvent(
                kind, event.position(), event.globalPosition(), none if moving else left,
                none if released else left, event.modifiers(),
            ),
        )  # fmt: skip
        self._passing_on = False
        return True

    # -- what is seen ------------------------------------------------------------------------------

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802
        """Draw the brush, or the outline."""
        if self._at is None:
            return
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        # Dark in light: it is seen on anything.
        for colour, width in ((QColor(255, 255, 255, 210), 3.5), (QColor(20, 20, 20), 1.5)):
            painter.setPen(QPen(colour, width))
            if self.use == PAINT:
                painter.drawEllipse(self._at, self.radius, self.radius)
            elif self._outline:
                painter.drawPolygon(QPolygonF(self._outline))
        painter.end()
