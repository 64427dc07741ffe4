"""The view of the meshes: one, before and after side by side, or with a line to swipe between them."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from PySide6.QtCore import QEvent, QObject, QPoint, Qt, QTimer, Signal
from PySide6.QtGui import QImage, QMouseEvent
from PySide6.QtWidgets import QGridLayout, QWidget
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkFloatArray, vtkLookupTable
from vtkmodules.vtkCommonDataModel import vtkPlane, vtkPlaneCollection, vtkPolyData
from vtkmodules.vtkRenderingCore import (
    vtkActor,
    vtkPolyDataMapper,
    vtkRenderer,
    vtkTextActor,
    vtkWindowToImageFilter,
)

from vtksmooth.filters.arrays import vtk_array

from ..model.field import Field
from ..model.state import State, shares_geometry
from .canvas import Canvas
from .scale import BEYOND, UNKNOWN, Scale
from .theme import Theme

#: Ways to show before and after.
SINGLE, SPLIT, SWIPE = "single", "split", "swipe"

_VALUES = "vtksmooth values"
_SURFACE = (0.78, 0.81, 0.85)
#: What is drawn over the mesh: its colour, and the width of its lines, pixels of a usual screen.
_MARKS = {
    "bad": (BEYOND, 2.0),
    "bad before": (BEYOND, 2.0),
    "brush": ((214, 39, 140), 2.0),
    "worst": ((255, 0, 120), 4.0),
    "lines": ((20, 20, 20), 3.0),
    "region": ((235, 140, 20), 1.0),
    "stroke": ((255, 205, 70), 1.0),
    "features": ((20, 20, 20), 3.0),
    "drawn": ((0, 90, 230), 4.0),
}
#: How near to the swipe line the pointer must be to take it, pixels.
_GRIP = 8
#: How far the pointer may move in a click, pixels.
_STILL = 3


class _Surface:
    """A mesh in the scene."""

    def __init__(self) -> None:
        self.data = vtkPolyData()
        self.mapper = vtkPolyDataMapper()
        self.mapper.SetInputData(self.data)
        self.mapper.ScalarVisibilityOff()
        self.mapper.UseLookupTableScalarRangeOn()
        self.actor = vtkActor()
        self.actor.SetMapper(self.mapper)
        look = self.actor.GetProperty()
        look.SetInterpolationToFlat()
        look.SetColor(*_SURFACE)
        look.SetEdgeColor(0.15, 0.17, 0.2)
        look.SetEdgeOpacity(0.45)
        look.SetSpecular(0.05)
        look.SetAmbient(0.3)
        look.SetDiffuse(0.75)
        self.mesh: vtkPolyData | None = None

    def show(self, mesh: vtkPolyData | None) -> None:
        """Show another mesh, without data arrays; None shows nothing."""
        known, self.mesh = self.mesh, mesh
        if mesh is known or (mesh is not None and known is not None and shares_geometry(mesh, known)):
            return
        self.data = vtkPolyData() if mesh is None else mesh
        self.mapper.SetInputData(self.data)
        self.mapper.ScalarVisibilityOff()

    def colour(self, field: Field | None, table: vtkLookupTable | None) -> None:
        """Colour by a field, or plainly."""
        data = self.data
        if field is None or table is None or self.mesh is None:
            self.mapper.ScalarVisibilityOff()
            return
        array = vtk_array(field.values if field.on_points else field.of_cells, _VALUES)
        (data.GetCellData() if field.on_points else data.GetPointData()).Initialize()
        (data.GetPointData() if field.on_points else data.GetCellData()).SetScalars(array)
        self.mapper.SetLookupTable(table)
        self.mapper.SetScalarRange(table.GetRange())
        if field.on_points:
            self.mapper.SetScalarModeToUsePointData()
            self.mapper.SetInterpolateScalarsBeforeMapping(True)
        else:
            self.mapper.SetScalarModeToUseCellData()
            self.mapper.SetInterpolateScalarsBeforeMapping(False)
        self.mapper.ScalarVisibilityOn()
        self.mapper.Modified()


def _lookup_table(scale: Scale) -> vtkLookupTable:
    table = vtkLookupTable()
    alpha = np.full((len(scale.colours), 1), 255, np.uint8)
    colours = vtk_array(np.hstack((scale.colours, alpha)))
    table.SetNumberOfTableValues(len(scale.colours))
    table.SetTable(colours)
    table.SetRange(scale.low, scale.high)
    table.SetNanColor([*(c / 255 for c in UNKNOWN), 1.0])
    if scale.beyond is not None:
        table.SetBelowRangeColor([*(c / 255 for c in scale.beyond), 1.0])
        table.UseBelowRangeColorOn()
    return table


class MeshView(QWidget):
    """The meshes."""

    #: The pointer rests: a ray through it, and whether it is on the side of "before".
    pointed = Signal(object, object, bool)
    #: A click, as `pointed`.
    clicked = Signal(object, object, bool)
    #: The pointer has left the view.
    left = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.plotter = Canvas(self, shape=(1, 2), border=False, auto_update=False)
        self._cell = QGridLayout(self)
        self._cell.setContentsMargins(0, 0, 0, 0)
        self._cell.addWidget(self.plotter.interactor, 0, 0)
        self.setMinimumSize(240, 180)
        self._renderers = [self.plotter.renderers[0], self.plotter.renderers[1]]
        self._renderers[1].SetActiveCamera(self._renderers[0].GetActiveCamera())
        # What must be seen even behind other faces is drawn last, in a layer of its own.
        self._top = vtkRenderer()
        self._top.SetLayer(1)
        self._top.SetActiveCamera(self._renderers[0].GetActiveCamera())
        self._top.InteractiveOff()
        self.plotter.render_window.SetNumberOfLayers(2)
        self.plotter.render_window.AddRenderer(self._top)
        self._surfaces = {"after": _Surface(), "before": _Surface()}
        self._labels = {side: self._label(side) for side in ("before", "after")}
        self._context: dict[Any, _Surface] = {}
        self._marks = {name: self._mark(name) for name in _MARKS}
        self.mode, self.shows_before, self.swipe_at = SINGLE, False, 0.5
        self._is_preview = False
        self._moving_line = False
        self._planes = {"before": vtkPlane(), "after": vtkPlane()}
        self._line = self._swipe_line()
        #: When the last frame was issued, seconds of time.perf_counter: for measurements.
        self.issued = 0.0
        self.frames = 0
        self._rest = QTimer(self, singleShot=True, interval=80)
        self._rest.timeout.connect(self._point)
        self._pointer = QPoint()
        self._pressed: QPoint | None = None
        # VTK's own keys would do what no menu tells.
        self.plotter.interactor.installEventFilter(self)
        self.plotter.interactor.setMouseTracking(True)
        self._renderers[0].AddObserver("StartEvent", self._cut)
        self.plotter.render_window.AddObserver("StartEvent", self._issue)
        self._arrange()

    def put_over(self, label: QWidget) -> None:
        """Put a label over the middle of the view."""
        label.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self._cell.addWidget(label, 0, 0, Qt.AlignmentFlag.AlignCenter)

    # -- what is shown -----------------------------------------------------------------------------

    def show_meshes(self, after: State | None, before: State | None) -> None:
        """Show a mesh, and the one that it is compared with."""
        for side, state in (("after", after), ("before", before)):
            self._surfaces[side].show(state.scene if state is not None else None)
        self.render_soon()

    def colour(self, side: str, field: Field | None, scale: Scale | None) -> None:
        """Colour "after" or "before" by a field."""
        table = _lookup_table(scale) if scale is not None else None
        self._surfaces[side].colour(field, table)
        self.render_soon()

    def show_context(self, meshes: dict[Any, tuple[State, tuple[float, float, float], float]]) -> None:
        """Show further meshes by key, each with its colour and opacity."""
        for key in [*self._context]:
            if key not in meshes:
                surface = self._context.pop(key)
                for renderer in self._renderers:
                    renderer.RemoveActor(surface.actor)
        for key, (state, colour, opacity) in meshes.items():
            if key not in self._context:
                self._context[key] = _Surface()
                self._context[key].actor.PickableOff()
                for renderer in self._renderers:
                    renderer.AddActor(self._context[key].actor)
            surface = self._context[key]
            surface.show(state.scene)
            look = surface.actor.GetProperty()
            look.SetColor(*colour)
            look.SetOpacity(opacity)
            look.SetLineWidth(3.0 * self.devicePixelRatioF())
            # Of a translucent hull only the far side: what is inside stays readable.
            look.SetFrontfaceCulling(opacity < 1.0)
        self.render_soon()

    def mark(self, name: str, mesh: Any) -> None:
        """Draw some faces or lines over the mesh, as one of :data:`_MARKS`; None removes them."""
        surface = self._marks[name]
        surface.show(mesh)
        surface.actor.SetVisibility(mesh is not None)
        self.render_soon()

    def set_edges(self, visible: bool) -> None:
        """Show or hide the edges of the faces."""
        for surface in self._surfaces.values():
            surface.actor.GetProperty().SetEdgeVisibility(visible)
        self.render_soon()

    def set_theme(self, theme: Theme) -> None:
        """Show light or dark."""
        for renderer in self._renderers:
            renderer.SetBackground(*theme.bottom)
            renderer.SetBackground2(*theme.top)
            renderer.GradientBackgroundOn()
        for label in self._labels.values():
            label.GetTextProperty().SetColor(*theme.text)
        self._line.GetProperty().SetColor(*theme.text)
        self.render_soon()

    # -- before and after --------------------------------------------------------------------------

    def set_mode(self, mode: str) -> None:
        """Show one view, two, or a line between both meshes: SINGLE, SPLIT or SWIPE."""
        if (mode == SPLIT) != (self.mode == SPLIT):
            # Half as wide: from as much farther away as it takes to see as much.
            width, height = self.width(), self.height()
            factor = min(width / 2, height) / min(width, height)
            factor = factor if mode == SPLIT else 1 / factor
            if self.camera.GetParallelProjection():
                self.camera.SetParallelScale(self.camera.GetParallelScale() / factor)
            else:
                self.camera.Dolly(factor)
        self.mode = mode
        self._arrange()

    def set_before(self, shown: bool) -> None:
        """In the single view, show the mesh before."""
        self.shows_before = shown
        self._arrange()

    def set_preview(self, on: bool) -> None:
        """Say that what is shown is a preview, or the mesh itself."""
        if on != self._is_preview:
            self._is_preview = on
            self._labels["after"].SetInput("preview" if on else "after")
            self._arrange()

    def set_swipe(self, fraction: float) -> None:
        """Put the swipe line at this fraction of the width."""
        self.swipe_at = min(max(fraction, 0.0), 1.0)
        self.render_soon()

    def _arrange(self) -> None:
        first, second = self._renderers
        before, after = self._surfaces["before"].actor, self._surfaces["after"].actor
        marks = {name: surface.actor for name, surface in self._marks.items()}
        bad_before = marks.pop("bad before")
        for renderer in (*self._renderers, self._top):
            for actor in (before, after, bad_before, *marks.values(), self._line, *self._labels.values()):
                renderer.RemoveViewProp(actor)
        split, swipe = self.mode == SPLIT, self.mode == SWIPE
        first.SetViewport(0.0, 0.0, 0.5 if split else 1.0, 1.0)
        second.SetViewport(*((0.5, 0.0, 1.0, 1.0) if split else (0.0, 0.0, 0.0, 0.0)))
        second.SetDraw(split)
        after_renderer = second if split else first
        if split or swipe or self.shows_before:
            first.AddActor(before)
            first.AddActor(bad_before)
        if split or swipe or not self.shows_before:
            after_renderer.AddActor(after)
            for name, actor in marks.items():
                (self._top if name == "worst" else after_renderer).AddActor(actor)
        self._top.SetViewport(*after_renderer.GetViewport())
        for side, planes in self._planes.items():
            collection = vtkPlaneCollection()
            if swipe:
                collection.AddItem(planes)
            self._surfaces[side].mapper.SetClippingPlanes(collection)
            for name, surface in self._marks.items():
                if (name == "bad before") == (side == "before"):
                    surface.mapper.SetClippingPlanes(collection)
        if swipe:
            first.AddViewProp(self._line)
        if split or swipe or self.shows_before:
            first.AddViewProp(self._labels["before"])
        if split or swipe or (self._is_preview and not self.shows_before):
            after_renderer.AddViewProp(self._labels["after"])
        self._labels["after"].SetPosition(0.98 if swipe else 0.02, 0.03)
        self._labels["after"].GetTextProperty().SetJustification(2 if swipe else 0)
        self.render_soon()

    def _label(self, text: str) -> vtkTextActor:
        label = vtkTextActor()
        label.SetInput(text)
        look = label.GetTextProperty()
        look.SetFontSize(15)  # points, of which VTK knows how many pixels they are
        label.GetPositionCoordinate().SetCoordinateSystemToNormalizedViewport()
        label.SetPosition(0.02, 0.03)
        return label

    def _mark(self, name: str) -> _Surface:
        surface = _Surface()
        look = surface.actor.GetProperty()
        scale = self.devicePixelRatioF()
        colour, width = _MARKS[name]
        look.SetColor(*(c / 255 for c in colour))
        look.LightingOff()
        look.SetLineWidth(width * scale)
        look.SetPointSize((11.0 if name == "drawn" else 7.0) * scale)
        if name in ("bad", "bad before", "worst"):
            look.SetRepresentationToWireframe()
        if name == "brush":
            # With edges of its own: slivers are thinner than a pixel.
            look.EdgeVisibilityOn()
            look.SetEdgeOpacity(1.0)
            look.SetEdgeColor(*(c / 255 for c in colour))
        if name in ("region", "stroke"):
            look.SetOpacity(0.7)  # what the overlay shows there stays readable
        # Drawn over the faces that they lie on.
        surface.mapper.SetResolveCoincidentTopologyToPolygonOffset()
        surface.mapper.SetRelativeCoincidentTopologyPolygonOffsetParameters(-2.0, -2.0)
        before = -8.0 if name == "drawn" else -4.0  # lines by hand cover those found
        surface.mapper.SetRelativeCoincidentTopologyLineOffsetParameters(before, before)
        surface.mapper.SetRelativeCoincidentTopologyPointOffsetParameter(before)
        surface.actor.PickableOff()
        surface.actor.VisibilityOff()
        return surface

    def _swipe_line(self) -> Any:
        from vtkmodules.vtkCommonCore import vtkPoints
        from vtkmodules.vtkCommonDataModel import vtkCellArray
        from vtkmodules.vtkRenderingCore import vtkActor2D, vtkCoordinate, vtkPolyDataMapper2D

        self._line_ends = vtkPoints()
        self._line_ends.SetNumberOfPoints(2)
        cells = vtkCellArray()
        cells.InsertNextCell(2, (0, 1))
        data = vtkPolyData()
        data.SetPoints(self._line_ends)
        data.SetLines(cells)
        mapper = vtkPolyDataMapper2D()
        mapper.SetInputData(data)
        coordinate = vtkCoordinate()
        coordinate.SetCoordinateSystemToNormalizedViewport()
        mapper.SetTransformCoordinate(coordinate)
        actor = vtkActor2D()
        actor.SetMapper(mapper)
        actor.GetProperty().SetLineWidth(2.0 * self.devicePixelRatioF())
        return actor

    def _cut(self, *_: Any) -> None:
        """Before each frame: let the planes go through the eye and the swipe line."""
        if self.mode != SWIPE:
            return
        x, height = self.swipe_at * self._width(), self._height()
        near, far = self._world(x, 0.0, 0.0), self._world(x, 0.0, 1.0)
        normal = np.cross(self._world(x, height, 0.0) - near, far - near)
        length = np.linalg.norm(normal)
        if length == 0:
            return
        normal /= length
        # Towards the right side of the view, whatever the handedness.
        if normal @ (self._world(self._width() + x + 1.0, 0.0, 0.0) - near) < 0:
            normal = -normal
        for side, sign in (("after", 1.0), ("before", -1.0)):
            self._planes[side].SetOrigin(*near)
            self._planes[side].SetNormal(*(sign * normal))
        self._line_ends.SetPoint(0, self.swipe_at, 0.0, 0.0)
        self._line_ends.SetPoint(1, self.swipe_at, 1.0, 0.0)
        self._line_ends.Modified()

    # -- the camera --------------------------------------------------------------------------------

    @property
    def camera(self) -> Any:
        """The camera of both views."""
        return self._renderers[0].GetActiveCamera()

    @property
    def first_renderer(self) -> Any:
        """The renderer of the single view, and of the left one."""
        return self._renderers[0]

    @property
    def top(self) -> Any:
        """The renderer of what must be seen even behind faces."""
        return self._top

    @property
    def across(self) -> np.ndarray:
        """The direction to the right of the view."""
        camera = self.camera
        return np.cross(camera.GetDirectionOfProjection(), camera.GetViewUp())

    def frame(self, bounds: tuple[float, ...] | None = None) -> None:
        """Bring everything, or a box, into view."""
        renderer = self._renderers[0]
        box = bounds or renderer.ComputeVisiblePropBounds()
        if box[0] <= box[1]:
            renderer.ResetCamera(box)
        self.render_soon()

    def sees(self, bounds: tuple[float, ...]) -> bool:
        """Return whether a box is in view, and neither a dot nor all round the camera."""
        corners = np.array(np.meshgrid(*np.reshape(bounds, (3, 2)), [1.0])).reshape(4, -1)
        x, y, _, depth = self.projection()[0] @ corners
        if depth.min() <= 0:
            return False
        places = np.array((x, y)) / depth  # -1 to 1 is the view
        size = np.ptp(places, axis=1).max()
        return bool(np.abs(places.mean(axis=1)).max() < 1.0 and 0.1 < size < 4.0)

    def look_from(self, direction: tuple[float, float, float], up: tuple[float, float, float]) -> None:
        """Look at the meshes from a direction."""
        camera = self.camera
        focus = np.array(camera.GetFocalPoint())
        camera.SetPosition(*(focus + np.array(direction)))
        camera.SetViewUp(*up)
        self.frame()

    def look_at(self, corners: Any, outward: Any, size: float) -> None:
        """Go to a face: its corners, a direction out of the surface there, the size of what to see."""
        camera = self.camera
        centre = np.asarray(corners).mean(axis=0)
        normal = np.asarray(outward, dtype=float)
        if not np.linalg.norm(normal) > 0:
            normal = np.array(camera.GetPosition()) - np.array(camera.GetFocalPoint())
        normal = normal / np.linalg.norm(normal)
        up = np.array(camera.GetViewUp())
        if abs(up @ normal) > 0.95:
            up = np.eye(3)[np.argmin(np.abs(normal))]
        camera.SetFocalPoint(*centre)
        camera.SetPosition(*(centre + normal * size))
        camera.SetViewUp(*up)
        reach = np.repeat(centre, 2) + np.tile([-size, size], 3) / 2
        self._renderers[0].ResetCamera(*reach)
        self.render_soon()

    def set_parallel(self, on: bool) -> None:
        """Use a parallel projection, or a perspective one."""
        self.camera.SetParallelProjection(on)
        self.render_soon()

    # -- frames ------------------------------------------------------------------------------------

    def render_soon(self) -> None:
        """Draw once, when all that is being changed has been."""
        self.plotter.interactor.update()

    def render_now(self) -> None:
        """Draw."""
        self.plotter.interactor.repaint()

    def _issue(self, *_: Any) -> None:
        """Before each frame: nothing of what either view shows is cut off; they have one camera."""
        boxes = np.array([renderer.ComputeVisiblePropBounds() for renderer in self._renderers])
        boxes = boxes[boxes[:, 0] <= boxes[:, 1]]
        if len(boxes):
            ends = np.where(np.arange(6) % 2, boxes.max(axis=0), boxes.min(axis=0))
            self._renderers[0].ResetCameraClippingRange(*ends)
        self.issued = time.perf_counter()
        self.frames += 1

    def picture(self, width: int, height: int, transparent: bool) -> QImage:
        """Return what is shown as a picture of any size."""
        window = self.plotter.render_window
        size, gradient = window.GetSize(), [r.GetGradientBackground() for r in self._renderers]
        window.SetAlphaBitPlanes(1)
        if transparent:
            for renderer in self._renderers:
                renderer.GradientBackgroundOff()
                renderer.SetBackgroundAlpha(0.0)
        scale = max(1, -(-max(width * 1.0 / size[0], height * 1.0 / size[1]) // 1))
        grab = vtkWindowToImageFilter()
        grab.SetInput(window)
        grab.SetScale(int(scale))
        grab.SetInputBufferTypeToRGBA()
        grab.ReadFrontBufferOff()
        with self.plotter.drawing():
            grab.Update()
        for renderer, before in zip(self._renderers, gradient, strict=True):
            renderer.SetGradientBackground(before)
            renderer.SetBackgroundAlpha(1.0)
        output = grab.GetOutput()
        w, h, _ = output.GetDimensions()
        pixels = np.ascontiguousarray(vtk_to_numpy(output.GetPointData().GetScalars()).reshape(h, w, 4)[::-1])
        if not transparent:
            pixels[..., 3] = 255
        image = QImage(pixels.tobytes(), w, h, 4 * w, QImage.Format.Format_RGBA8888).copy()
        self.render_soon()
        return image.scaled(
            width, height, Qt.AspectRatioMode.KeepAspectRatioByExpanding,
            Qt.TransformationMode.SmoothTransformation,
        ).copy(0, 0, width, height)  # fmt: skip

    def close_view(self) -> None:
        """Let go of the graphics; before the widget is closed."""
        self._rest.stop()
        self.plotter.interactor.removeEventFilter(self)
        self.plotter.close()

    # -- the pointer -------------------------------------------------------------------------------

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        """Take the swipe line, and watch the pointer; keys belong to the menus."""
        kind = event.type()
        if kind in (QEvent.Type.KeyPress, QEvent.Type.KeyRelease):
            event.ignore()
            return True
        if kind == QEvent.Type.Leave:
            self._rest.stop()
            self.left.emit()
        if isinstance(event, QMouseEvent) and self._swipe_event(event):
            return True
        if isinstance(event, QMouseEvent) and event.button() == Qt.MouseButton.LeftButton:
            place = event.position().toPoint()
            if kind == QEvent.Type.MouseButtonPress:
                self._pressed = place
            elif kind == QEvent.Type.MouseButtonRelease and self._pressed is not None:
                if (place - self._pressed).manhattanLength() <= _STILL:
                    self.clicked.emit(*self._ray(place))
                self._pressed = None
        if kind == QEvent.Type.MouseMove and isinstance(event, QMouseEvent):
            self._pointer = event.position().toPoint()
            if event.buttons() == Qt.MouseButton.NoButton:
                self._rest.start()
        return super().eventFilter(watched, event)

    def _swipe_event(self, event: QMouseEvent) -> bool:
        if self.mode != SWIPE:
            return False
        width = max(1, self.plotter.interactor.width())
        x = event.position().x()
        near = abs(x - self.swipe_at * width) <= _GRIP
        kind = event.type()
        if kind == QEvent.Type.MouseButtonPress and near:
            self._moving_line = True
            return True
        if kind == QEvent.Type.MouseButtonRelease and self._moving_line:
            self._moving_line = False
            return True
        if kind == QEvent.Type.MouseMove:
            shape = Qt.CursorShape.SplitHCursor if near or self._moving_line else Qt.CursorShape.ArrowCursor
            self.plotter.interactor.setCursor(shape)
            if self._moving_line:
                self.set_swipe(x / width)
                return True
        return False

    def _point(self) -> None:
        self.pointed.emit(*self._ray(self._pointer))

    def _ray(self, place: QPoint) -> tuple[np.ndarray, np.ndarray, bool]:
        """Return origin and direction of the ray through a place, and whether "before" is shown there."""
        ratio = self.plotter.interactor.devicePixelRatioF()
        x = place.x() * ratio
        y = self._height() - 1 - place.y() * ratio
        fraction = x / max(1, self._width())
        before = self.shows_before if self.mode == SINGLE else fraction < 0.5
        renderer = self._renderers[0]
        if self.mode == SWIPE:
            before = fraction < self.swipe_at
        elif self.mode == SPLIT and not before:
            renderer = self._renderers[1]
        near, far = self._world(x, y, 0.0, renderer), self._world(x, y, 1.0, renderer)
        return near, far - near, before

    def set_picking(self, on: bool) -> None:
        """Show by the pointer that a click picks something."""
        self.plotter.interactor.setCursor(Qt.CursorShape.CrossCursor if on else Qt.CursorShape.ArrowCursor)

    # -- what stands where -------------------------------------------------------------------------

    def pixel(self, x: float, y: float) -> tuple[float, float]:
        """Return a place of the widget in pixels of the screen, from the lower left."""
        ratio = self.plotter.interactor.devicePixelRatioF()
        return x * ratio, self._height() - y * ratio

    def ray(self, place: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
        """Return where a ray into the mesh "after" starts, and its direction."""
        near, far = (self._world(*place, depth, self._renderer_of_after) for depth in (0.0, 1.0))
        return near, far - near

    @property
    def _renderer_of_after(self) -> Any:
        return self._renderers[1 if self.mode == SPLIT else 0]

    def shows_after(self, place: tuple[float, float]) -> bool:
        """Return whether at a place, in pixels, it is the mesh "after" that is shown, or would be."""
        fraction = place[0] / max(1, self._width())
        if self.mode == SINGLE:
            return not self.shows_before
        return fraction >= (0.5 if self.mode == SPLIT else self.swipe_at)

    @property
    def standpoint(self) -> tuple[Any, ...]:
        """Whatever places on the screen depend on, beside the mesh."""
        camera, renderer = self.camera, self._renderer_of_after
        return (
            camera.GetPosition(), camera.GetFocalPoint(), camera.GetViewUp(), camera.GetViewAngle(),
            camera.GetParallelScale(), camera.GetParallelProjection(), renderer.GetOrigin(),
            renderer.GetSize(), self.mode, self.swipe_at,
        )  # fmt: skip

    def projection(self) -> tuple[np.ndarray, tuple[float, float, float, float]]:
        """Return the matrix from the world to the view "after", and that view's rectangle, in pixels."""
        renderer = self._renderer_of_after
        matrix = self.camera.GetCompositeProjectionTransformMatrix(renderer.GetTiledAspectRatio(), 0.0, 1.0)
        rows = np.array([[matrix.GetElement(i, j) for j in range(4)] for i in range(4)])
        return rows, (*renderer.GetOrigin(), *renderer.GetSize())

    def depths(self) -> np.ndarray:
        """Draw the meshes alone, unseen, and return the depth buffer, (rows, columns) float32."""
        window, marks = self.plotter.render_window, [mark.actor for mark in self._marks.values()]
        shown = [actor.GetVisibility() for actor in marks]
        for actor in marks:
            actor.VisibilityOff()
        self._top.DrawOff()
        window.SwapBuffersOff()
        depths = vtkFloatArray()
        with self.plotter.drawing():
            window.Render()
            window.GetZbufferData(0, 0, self._width() - 1, self._height() - 1, depths)
        window.SwapBuffersOn()
        self._top.DrawOn()
        for actor, visible in zip(marks, shown, strict=True):
            actor.SetVisibility(visible)
        self.render_soon()
        return np.asarray(vtk_to_numpy(depths).reshape(self._height(), self._width()))

    def _width(self) -> int:
        return int(self.plotter.render_window.GetSize()[0])

    def _height(self) -> int:
        return int(self.plotter.render_window.GetSize()[1])

    def _world(self, x: float, y: float, depth: float, renderer: Any = None) -> np.ndarray:
        """Return the point in the world of a place in the window, in pixels of the screen."""
        renderer = renderer or self._renderers[0]
        renderer.SetDisplayPoint(x, y, depth)
        renderer.DisplayToWorld()
        world = np.array(renderer.GetWorldPoint())
        return world[:3] / world[3] if world[3] else world[:3]
