"""Regions: painting, picking and drawing what smoothing may do where."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt
from PySide6.QtCore import QObject, QPointF, Qt, QTimer, Slot
from PySide6.QtGui import QAction, QKeySequence, QShortcut

from vtksmooth.filters import RegionMarking
from vtksmooth.filters.point_lists import format_lines, format_points
from vtksmooth.kernels.distance import visibility
from vtksmooth.kernels.mesh import adjacency, paths
from vtksmooth.kernels.mesh import regions as kernels
from vtksmooth.pages.page import said

from ..model import numbers, overlays, picking, regions
from ..model.document import Document
from ..model.overlays import Subject
from ..model.selection import points_of_faces
from ..model.state import State
from ..settings import Settings
from ..views.main_window import MainWindow
from ..views.mesh_view import SPLIT, SWIPE
from ..views.pen import CLICK, OUTLINE, PAINT, RADII, Pen
from .display import Display
from .files import explain
from .jobs import Context, Jobs

#: What the pen does for each tool.
_TOOLS = {
    "camera": "",
    "brush": PAINT,
    "lasso": OUTLINE,
    "line": CLICK,
    "patch": CLICK,
    "component": CLICK,
    "edges": CLICK,
}
#: Tools that go by the feature lines.
_WITH_LINES = ("line", "patch", "edges")
#: How near to a line a click must be, pixels of a usual screen.
_REACH = 14.0

Place = tuple[float, float]
Ray = tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]


class Nothing(Exception):
    """A tool has found nothing to do; the message says why."""


@dataclass(frozen=True)
class _Found:
    """What is to be marked: a title for the history, parameters of RegionMarking, the next line's start."""

    title: str
    values: dict[str, Any] = field(default_factory=dict)
    anchor: int | None = None


#: Finds in a worker what is to be marked on a state.
Find = Callable[[Context, State], _Found]


@dataclass(frozen=True, eq=False)
class _Look:
    """The mesh as it stands on the screen: as long as nothing moves, it is computed once."""

    key: Any
    places: npt.NDArray[np.float32]
    depths: npt.NDArray[np.float32]
    seen: npt.NDArray[np.bool_]
    allowed: npt.NDArray[np.bool_]

    def on_mesh(self, place: Place) -> bool:
        """Return whether something is drawn at a place."""
        rows, columns = self.depths.shape
        column, row = int(place[0]), int(place[1])
        return 0 <= row < rows and 0 <= column < columns and bool(self.depths[row, column] < 1.0)


class Regions(QObject):
    """The commands of the menu Regions."""

    def __init__(
        self, document: Document, window: MainWindow, jobs: Jobs, display: Display, settings: Settings
    ) -> None:
        super().__init__(window)
        self._document, self._window, self._jobs = document, window, jobs
        self._display, self._settings = display, settings
        self._panel, self._view = window.regions, window.view
        self.pen = Pen(self._view.plotter.interactor, self._on_mesh)
        self.tool = "camera"
        self._look: _Look | None = None
        self._stroke: npt.NDArray[np.bool_] | None = None
        self._frees = False
        self._from: Place = (0.0, 0.0)
        self._anchor: int | None = None
        self._waiting: list[Find] = []
        self._running = self._shown = False
        self._rings: tuple[Any, kernels.Rings] | None = None
        self._timer = QTimer(self, singleShot=True, interval=15)
        self._timer.timeout.connect(self._show_stroke)
        self.pen.begun.connect(self._begin)
        self.pen.moved.connect(self._move)
        self.pen.ended.connect(self._end)
        self.pen.outlined.connect(self._outlined)
        self.pen.clicked.connect(self._clicked)
        self._panel.radius_changed.connect(self._set_radius)
        self._panel.radius.setValue(settings.get("brush", self.pen.radius))
        self._escape = QShortcut(QKeySequence(Qt.Key.Key_Escape), window)
        self._escape.activated.connect(self._step_back)
        window.action("cancel").enabledChanged.connect(self._share_escape)
        for action in self._measuring():
            action.toggled.connect(self._make_way)
        window.docks["Regions"].visibilityChanged.connect(self._panel_shown)
        window.histogram.brushed.connect(self._offer_threshold)
        display.shown.connect(self._offer_threshold)
        document.changed.connect(self._document_changed)
        self._share_escape()
        self._document_changed()

    # -- tools -------------------------------------------------------------------------------------

    def region_camera(self) -> None:
        """Leave the tools."""
        self._choose("camera")

    def region_brush(self) -> None:
        """Paint."""
        self._choose("brush")

    def region_lasso(self) -> None:
        """Draw an outline round points."""
        self._choose("lasso")

    def region_line(self) -> None:
        """Click on feature lines."""
        self._choose("line")

    def region_patch(self) -> None:
        """Click on patches between feature lines."""
        self._choose("patch")

    def region_component(self) -> None:
        """Click on connected components."""
        self._choose("component")

    def region_edges(self) -> None:
        """Draw feature lines."""
        self._choose("edges")

    def _choose(self, tool: str) -> None:
        self.tool = tool
        self._anchor = None
        self._drop_stroke()
        self._window.action(f"region_{tool}").setChecked(True)
        self.pen.set_use(_TOOLS[tool])
        if tool != "camera":
            for action in self._measuring():
                if action.isChecked():
                    action.trigger()  # one click, one tool
            self._window.show_panel("Regions")
        self._share_escape()
        self._show_marks()

    def _measuring(self) -> list[QAction]:
        """Return the actions that pick with clicks as well."""
        actions = self._window.actions_by_id
        return [actions[id] for id in actions if id.startswith("measure_")]

    @Slot(bool)
    def _make_way(self, on: bool) -> None:
        if on:
            self._choose("camera")

    @Slot()
    def _step_back(self) -> None:
        """Esc: end the line that is drawn, then leave the tool."""
        if self.pen.busy:
            self.pen.drop()
            self._drop_stroke()
        elif self._anchor is not None:
            self._anchor = None
            self._show_marks()
        else:
            self._choose("camera")

    @Slot()
    def _share_escape(self) -> None:
        # While something runs, Esc cancels that.
        self._escape.setEnabled(self.tool != "camera" and not self._window.action("cancel").isEnabled())

    def region_free(self) -> None:
        """Free points instead of fixing them; Ctrl does the opposite."""

    def region_through(self) -> None:
        """Reach points that are hidden, too."""

    def region_smaller(self) -> None:
        """Make the brush smaller."""
        self._panel.radius.setValue(max(RADII[0], round(self.pen.radius / 1.25) - 1))

    def region_larger(self) -> None:
        """Make the brush larger."""
        self._panel.radius.setValue(min(RADII[1], round(self.pen.radius * 1.25) + 1))

    @Slot(int)
    def _set_radius(self, radius: int) -> None:
        self.pen.set_radius(radius)
        self._settings.set("brush", radius)

    # -- the mesh on the screen --------------------------------------------------------------------

    def _looked(self) -> _Look | None:
        """Return how the mesh stands on the screen now."""
        subject, view = self._display.subject, self._view
        if subject is None or subject.state.surface is None:
            return None
        points = subject.state.surface.mesh.points
        through = self._window.action("region_through").isChecked()
        # What stands before the mesh hides it; and points are held on to, or others may take their place.
        active = self._document.active
        others = tuple(x.state for x in self._document.layers if x.visible and x is not active)
        shown = (subject.state.mesh.GetPoints().GetData(), *others)
        key = (shown, view.standpoint, through)
        if self._look is None or self._look.key != key:
            depths = view.depths()
            matrix, viewport = view.projection()  # of the frame that has just been drawn
            places = visibility.project(points, matrix, viewport)
            seen = visibility.seen(places, depths)
            allowed = np.isfinite(places[:, 2]) if through else seen
            if view.mode in (SPLIT, SWIPE):
                edge = viewport[0] + (view.swipe_at * viewport[2] if view.mode == SWIPE else 0.0)
                allowed = allowed & (places[:, 0] >= edge)
            self._look = _Look(key, places, depths, seen, allowed)
        return self._look

    def _on_mesh(self, at: QPointF) -> bool:
        place = self._view.pixel(at.x(), at.y())
        look = self._looked() if self._view.shows_after(place) else None
        return look is not None and look.on_mesh(place)

    def _freeing(self, opposite: bool) -> bool:
        return self._window.action("region_free").isChecked() != opposite

    # -- painting ----------------------------------------------------------------------------------

    @Slot(QPointF, bool)
    def _begin(self, at: QPointF, opposite: bool) -> None:
        look = self._looked()
        assert look is not None
        self._stroke, self._frees = np.zeros(len(look.places), np.bool_), self._freeing(opposite)
        self._from = self._view.pixel(at.x(), at.y())
        self._move(at)

    @Slot(QPointF)
    def _move(self, at: QPointF) -> None:
        if self._stroke is None or self._look is None:
            return
        place = self._view.pixel(at.x(), at.y())
        radius = self.pen.radius * self._view.plotter.interactor.devicePixelRatioF()
        look = self._look
        if visibility.add_stroke(look.places, look.allowed, self._from, place, radius, self._stroke):
            self._timer.start()
        self._from = place

    @Slot()
    def _end(self) -> None:
        stroke, self._stroke = self._stroke, None
        if stroke is None:
            return
        self._timer.stop()
        self._show(stroke)
        if stroke.any():
            self._mark_points("Paint", np.flatnonzero(stroke), self._frees)
        else:
            self._window.notification.say("No point is under the brush; make it larger, or come nearer.")

    def _show_stroke(self) -> None:
        if self._stroke is not None:
            self._show(self._stroke)

    def _show(self, stroke: npt.NDArray[np.bool_]) -> None:
        subject = self._display.subject
        if subject is not None:
            self._view.mark("stroke", regions.mark_of(subject.state, stroke))

    def _drop_stroke(self) -> None:
        self._stroke = None
        self._timer.stop()
        self._view.mark("stroke", None)

    @Slot(list, bool)
    def _outlined(self, outline: list[QPointF], opposite: bool) -> None:
        look = self._looked()
        if look is None:
            return
        corners = [self._view.pixel(at.x(), at.y()) for at in outline]
        chosen = visibility.inside_outline(look.places, look.allowed, corners)
        self._mark_points("Lasso", np.flatnonzero(chosen), self._freeing(opposite))

    # -- clicking ----------------------------------------------------------------------------------

    @Slot(QPointF, bool)
    def _clicked(self, at: QPointF, opposite: bool) -> None:
        place = self._view.pixel(at.x(), at.y())
        look = self._looked() if self._view.shows_after(place) else None
        if look is None:
            return
        find = {
            "line": self._find_line,
            "patch": self._find_patch,
            "component": self._find_component,
            "edges": self._find_edges,
        }[self.tool]
        self._submit(partial(find, place, self._view.ray(place), look, self._freeing(opposite)))

    def _hit(self, ray: Ray, state: State) -> picking.Probe:
        found = picking.probe(state, *ray)
        if found is None:
            raise Nothing("There is no face; click on the mesh.")
        return found

    def _lines(self, context: Context, state: State) -> regions.Lines:
        found = overlays.compute(overlays.overlay("feature-class"), Subject(state), context.run)
        return regions.Lines.of(found.lines)

    def _line_at(self, place: Place, look: _Look, context: Context, state: State) -> Any:
        lines = self._lines(context, state)
        reach = _REACH * self._view.plotter.interactor.devicePixelRatioF()
        found = lines.nearest(look.places, look.seen, place, reach)
        if found is None:
            raise Nothing("There is no feature line here; Draw Feature Lines makes one.")
        return lines.chain(found)

    def _find_line(
        self, place: Place, ray: Ray, look: _Look, frees: bool, context: Context, state: State
    ) -> _Found:
        chain = self._line_at(place, look, context, state)
        return self._points("Pick feature line", np.unique(chain), frees, state)

    def _find_patch(
        self, place: Place, ray: Ray, look: _Look, frees: bool, context: Context, state: State
    ) -> _Found:
        face = self._hit(ray, state).face
        assert state.surface is not None
        mesh = state.surface.mesh
        labels = kernels.patches(adjacency.build(mesh), self._lines(context, state).pairs)
        points = points_of_faces(state, np.flatnonzero(labels == labels[face]))
        return self._points("Pick patch", points, frees, state)

    def _find_component(
        self, place: Place, ray: Ray, look: _Look, frees: bool, context: Context, state: State
    ) -> _Found:
        point = self._hit(ray, state).point
        assert state.surface is not None
        labels = kernels.components(state.surface.mesh)
        return self._points("Pick component", np.flatnonzero(labels == labels[point]), frees, state)

    def _find_edges(
        self, place: Place, ray: Ray, look: _Look, frees: bool, context: Context, state: State
    ) -> _Found:
        anchor = self._anchor
        if frees and anchor is None:
            chain = self._line_at(place, look, context, state)
            return _Found(
                f"Remove a feature line of {len(chain)} points", {"remove_lines": format_lines([chain])}
            )
        point = self._hit(ray, state).point
        if anchor is None or point == anchor:
            return _Found("", anchor=None if point == anchor else point)
        assert state.surface is not None
        path = paths.shortest_path(state.surface.mesh.points, self._rings_of(state), anchor, point)
        if not len(path):
            raise Nothing("No way along edges leads there.")
        word, name = ("Remove", "remove_lines") if frees else ("Draw", "add_lines")
        return _Found(f"{word} a feature line of {len(path)} points", {name: format_lines([path])}, point)

    def _rings_of(self, state: State) -> kernels.Rings:
        assert state.surface is not None
        faces = state.surface.mesh.connectivity
        if self._rings is None or self._rings[0] is not faces:
            self._rings = faces, kernels.rings_of(state.surface.mesh)
        return self._rings[1]

    # -- the region as a whole ---------------------------------------------------------------------

    def region_grow(self) -> None:
        """Fix the points round the region."""
        self._ask("Grow the region", grow=1)

    def region_shrink(self) -> None:
        """Free the points at the region's rim."""
        self._ask("Shrink the region", shrink=1)

    def region_invert(self) -> None:
        """Free what is fixed, and fix what is free."""
        self._ask("Invert the region", invert=True)

    def region_clear(self) -> None:
        """Free all points."""
        self._ask("Clear the region", clear="region")

    def region_clear_lines(self) -> None:
        """Forget the feature lines that were added and removed."""
        self._anchor = None
        self._ask("Clear the drawn feature lines", clear="lines")

    def region_soften(self) -> None:
        """Give the region a soft edge."""
        softness = self._panel.softness()
        ((name, width),) = softness.items()
        unit = "rings" if name == "blend_rings" else "model units"
        self._ask(f"Soft edge of {width:g} {unit}" if width else "No soft edge", **softness)

    def region_threshold(self) -> None:
        """Fix or free the points with values of the overlay within a span."""
        values, one = self._display.fields[0], self._display.overlay
        layer = self._document.active
        if values is None or one is None or layer is None or layer.state is None:
            self._window.notification.say("Show an overlay with values first.", "warning")
            return
        points = regions.points_between(values, *self._panel.threshold(values.span))
        span = f"from {self._panel.low.text()} to {self._panel.high.text()}"
        self._mark_points(f"{one.title} {span}", points, self._freeing(False))

    def _offer_threshold(self, span: tuple[float, float] | None = None) -> None:
        values, one = self._display.fields[0], self._display.overlay
        if values is None or one is None or self._display.subject is None:
            self._panel.show_threshold("", None)
            return
        if span is None and not one.judged:
            span = values.span
        elif span is None:
            bad = self._display.thresholds()[2]
            low, high = values.span
            span = (min(low, bad), bad) if one.low_is_bad else (bad, max(high, bad))
        self._panel.show_threshold(one.title, span)

    # -- marking -----------------------------------------------------------------------------------

    def _ask(self, title: str, **values: Any) -> None:
        self._submit(lambda context, state: _Found(title, values))

    def _mark_points(self, title: str, points: npt.NDArray[np.int64], frees: bool) -> None:
        self._submit(lambda context, state: self._points(title, points, frees, state))

    @staticmethod
    def _points(title: str, points: npt.NDArray[Any], frees: bool, state: State) -> _Found:
        changed = points[regions.fixed(state)[points] == frees]
        if not len(changed):
            raise Nothing(f"{title}: no point there is {'fixed' if frees else 'free'}.")
        word = "free" if frees else "fix"
        return _Found(f"{title}: {word} {len(changed):,} points", {word: format_points(changed)})

    def _submit(self, find: Find) -> None:
        """Have something marked, after what was asked for before."""
        if self._jobs.busy("apply"):
            self._drop_stroke()
            self._window.notification.say("A filter is running; wait, or cancel it with Esc.", "warning")
            return
        self._waiting.append(find)
        self._start()

    def _start(self) -> None:
        layer = self._document.active
        if self._running or not self._waiting:
            return
        if layer is None or layer.state is None or layer.state.surface is None:
            self._waiting.clear()
            self._window.notification.say("Open a mesh with faces first.", "warning")
            return
        find, state = self._waiting.pop(0), layer.state

        def work(context: Context) -> Any:
            found = find(context, state)
            if not found.values:
                return layer, state, found, None, None
            marking = context.run(RegionMarking(**found.values), state.input())
            return layer, state, found, marking, State.of(marking.GetOutput(), state)

        self._running = True
        job = self._jobs.start("region", work)
        job.done.connect(self._done)
        job.failed.connect(self._failed)
        job.stopped.connect(self._stopped)

    @Slot(object)
    def _done(self, result: Any) -> None:
        layer, state, found, marking, after = result
        self._running, self._anchor = False, found.anchor
        if layer.state is not state:
            self._window.notification.say("The mesh has changed meanwhile; nothing was marked.", "warning")
            self._drop_stroke()
        elif marking is None:
            self._show_marks()
        else:
            step, sources = self._document.step(layer, RegionMarking, found.values, ())
            self._document.apply(
                layer, [after], step, sources, f"{found.title} on {layer.name}",
                said(marking), numbers.line(marking.figures),
            )  # fmt: skip
        self._start()

    @Slot(object)
    def _failed(self, error: Exception) -> None:
        self._running = False
        self._drop_stroke()
        nothing = isinstance(error, (Nothing, overlays.Unavailable))
        self._window.notification.say(
            str(error) if nothing else explain(error), "note" if nothing else "error"
        )
        self._start()

    @Slot()
    def _stopped(self) -> None:
        self._running = False
        self._drop_stroke()

    # -- what is seen ------------------------------------------------------------------------------

    @Slot(bool)
    def _panel_shown(self, shown: bool) -> None:
        self._shown = shown
        self._show_marks()

    def _document_changed(self) -> None:
        layer = self._document.active
        there = layer is not None and layer.state is not None and layer.state.n_faces > 0
        for id, action in self._window.actions_by_id.items():
            if id.startswith("region_"):
                action.setEnabled(there)
        if not there and self.tool != "camera":
            self._choose("camera")
        self._show_marks()

    def _show_marks(self) -> None:
        """Show the region and the lines, if somebody works on them."""
        layer = self._document.active
        state = layer.state if layer is not None else None
        self._panel.counts.setText(regions.counts(state) if state is not None else "")
        if state is None or not (self._shown or self.tool != "camera"):
            self._jobs.cancel("region marks")
            for name in ("region", "stroke", "drawn", "features"):
                self._view.mark(name, None)
            return
        anchor, with_lines = self._anchor, self.tool in _WITH_LINES

        def work(context: Context) -> Any:
            drawn = regions.drawing_of(state, regions.edits(state)[0], anchor)
            lines = None
            if with_lines and state.surface is not None:
                lines = overlays.compute(overlays.overlay("feature-class"), Subject(state), context.run).lines
            return state, regions.mark_of(state, regions.fixed(state)), drawn, lines

        job = self._jobs.start("region marks", work)
        job.done.connect(self._show_found)
        job.failed.connect(self._failed_to_show)

    @Slot(object)
    def _show_found(self, result: Any) -> None:
        _, region, drawn, lines = result
        view = self._view
        for name, mesh in (("region", region), ("drawn", drawn), ("features", lines)):
            view.mark(name, mesh)
        if self._stroke is None and not self._running:
            view.mark("stroke", None)

    @Slot(object)
    def _failed_to_show(self, error: Exception) -> None:
        self._window.notification.say(explain(error), "error")
