"""Measuring: distances, angles and radii at picked vertices, cross-sections, and the unit of lengths."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from PySide6.QtCore import QObject, Slot

from ..model import picking, regions
from ..model.document import Document
from ..model.measure import PICKS, Kind, Measurement
from ..model.section import Plane, outline
from ..model.selection import patch, points_of_faces
from ..model.state import State
from ..model.units import UNITS
from ..views.main_window import MainWindow
from ..views.measure_marks import Mark, MeasureMarks
from ..views.plane_handle import PlaneHandle
from ..views.theme import DARK, LIGHT
from .display import Display
from .files import explain
from .jobs import Context, Jobs

_HINTS = {
    Kind.DISTANCE: ("Click the first point.", "Click the second point."),
    Kind.ANGLE: ("Click a point on the first side.", "Click the apex.", "Click a point on the second side."),
    Kind.RADIUS: ("Click a face: it is measured with all around it, as far as the next sharp edges.",),
}
#: Edges sharper than that end the patch whose radius is measured, degrees.
_SHARP = 40.0
#: Of larger regions only some points are drawn.
_DRAWN = 3000


class Measuring(QObject):
    """The commands of the menu Measure."""

    def __init__(self, document: Document, window: MainWindow, jobs: Jobs, display: Display) -> None:
        super().__init__(window)
        self._document, self._window, self._jobs, self._display = document, window, jobs, display
        self._marks = MeasureMarks(window.view)
        self.handle = PlaneHandle(window.view)
        self.kind: Kind | None = None
        #: Vertices picked so far, on this layer.
        self._picked: list[int] = []
        self._on: Any = None
        self._again = False
        window.view.clicked.connect(self._click)
        window.section.moved.connect(self._slide)
        self.handle.moved.connect(self._move)
        document.changed.connect(self.refresh)
        display.subject_changed.connect(self._cut)
        for id, command in self.commands().items():
            window.action(id).triggered.connect(command)
        window.action("dark").triggered.connect(self._dress)
        self._dress()
        self.refresh()

    def commands(self) -> dict[str, Callable[..., Any]]:
        """Return commands that differ by an argument only."""
        found: dict[str, Callable[..., Any]] = {
            f"measure_{kind}": lambda on, kind=kind: self._choose(kind if on else None) for kind in Kind
        }
        for unit in UNITS:
            found[f"unit_{unit or 'none'}"] = lambda _=False, unit=unit: self._document.set_unit(unit)
        for name, normal in zip("xyz", np.eye(3).tolist(), strict=True):
            found[f"section_{name}"] = lambda _=False, normal=normal: self.cut_across(normal)
        found["section_view"] = lambda _=False: self.cut_across(self._window.view.across)
        return found

    def refresh(self) -> None:
        """Show measurements and the section as they are now."""
        document, window = self._document, self._window
        window.action(f"unit_{document.unit or 'none'}").setChecked(True)
        for form in (window.filters.form, window.recipe.form):
            form.set_unit(document.unit)
        if self._on is not None and self._on is not document.active:
            self._picked = []
        missing = [
            (one, state)
            for one in document.measurements
            for state in (one.layer.opened, one.layer.state)
            if state is not None and one.known(state) is None
        ]
        self._show()
        self._cut()
        if not missing:
            return

        def work(context: Context) -> None:
            for one, state in missing:
                context.check()
                one.compute(state)

        job = self._jobs.start("measure", work)
        job.done.connect(self._show)
        job.failed.connect(self._failed)

    @Slot(object)
    def _failed(self, error: Exception) -> None:
        self._window.notification.say(explain(error), "error")

    @Slot(object)
    def _show(self, _: Any = None) -> None:
        """Show what is known of the measurements, in the table and in the view."""
        document = self._document
        self._window.measurements.show_measurements(document.measurements, document.unit)
        marks = []
        for one in document.measurements:
            state = one.layer.state
            places = None if state is None or not one.layer.visible else one.places(state)
            if places is None:
                continue
            figures = one.known(state) or []
            best = min(figures, key=lambda figure: figure.rms or 0.0, default=None)
            text = best.text(document.unit) if best else ""
            if one.kind is Kind.RADIUS:
                at = places[np.argmax(places[:, 2])]  # not where other labels are
                places = places[:: -(-len(places) // _DRAWN)]
            else:
                at = places[1] if one.kind is Kind.ANGLE else places.mean(axis=0)
            marks.append(Mark(places, one.kind is not Kind.RADIUS, text, at))
        active = document.active
        if self._picked and active is not None and active.state is not None:
            places = active.state.points[self._picked].astype(np.float64)
            marks.append(Mark(places, True, "", places[0]))
        self._marks.show_marks(marks)

    def _dress(self, *_: Any) -> None:
        theme = DARK if self._window.action("dark").isChecked() else LIGHT
        self._marks.set_theme(theme)
        self.handle.set_theme(theme)
        self._window.section.set_theme(theme)

    # -- picking -----------------------------------------------------------------------------------

    def _choose(self, kind: Kind | None) -> None:
        """Begin to pick for a measurement, or end it."""
        for one in Kind:
            self._window.action(f"measure_{one}").setChecked(one is kind)
        self.kind, self._picked = kind, []
        self._window.view.set_picking(kind is not None)
        if kind is not None:
            self._window.show_panel("Measurements")
        subject, faces = self._display.subject, self._display.selected
        if kind is Kind.RADIUS and subject is not None and faces is not None and len(faces):
            # What the histogram's brush has selected is the region.
            self._add(Kind.RADIUS, points_of_faces(subject.state, faces))
            self._choose(None)
            return
        self._say()
        self._show()

    def _say(self) -> None:
        hints = _HINTS[self.kind] if self.kind is not None else ("",)
        self._window.measurements.say(hints[min(len(self._picked), len(hints) - 1)])

    @Slot(object, object, bool)
    def _click(self, origin: Any, direction: Any, before: bool) -> None:
        document, kind = self._document, self.kind
        layer = document.active
        if kind is None or layer is None or layer.state is None:
            return
        shown, earlier = layer.state, document.before
        state = earlier if before and earlier is not None and earlier.n_points == shown.n_points else shown

        def work(context: Context) -> Any:
            found = picking.probe(state, origin, direction)
            if found is None:
                return None
            region = patch(state, found.face, _SHARP) if kind is Kind.RADIUS else np.array([found.point])
            return shown, kind, region

        job = self._jobs.start("pick", work)
        job.done.connect(self._take)
        job.failed.connect(self._failed)

    @Slot(object)
    def _take(self, found: tuple[State, Kind, Any] | None) -> None:
        layer = self._document.active
        if found is None or layer is None or layer.state is not found[0] or self.kind is not found[1]:
            return
        kind, vertices = found[1:]
        if kind in PICKS:
            point = int(vertices[0])
            if self._picked[-1:] != [point]:
                self._picked.append(point)
            self._on = layer
            if len(self._picked) < PICKS[kind]:
                self._say()
                self._show()
                return
            vertices = np.array(self._picked)
        self._add(kind, vertices)
        self._choose(kind)  # for the next one

    def _add(self, kind: Kind, vertices: Any) -> None:
        layer = self._document.active
        assert layer is not None
        assert layer.state is not None
        self._picked = []
        if not len(vertices):
            self._window.notification.say("There are no points to measure.", "warning")
            return
        self._document.measure(Measurement(kind, layer, np.asarray(vertices, np.int64), layer.state.n_points))

    def fixed_radius(self) -> None:
        """Measure the radius of the points that are fixed, however they were chosen."""
        layer = self._document.active
        held = None if layer is None or layer.state is None else np.flatnonzero(regions.fixed(layer.state))
        if held is None or not len(held):
            self._window.notification.say("Fix points first: paint or pick them with the regions.", "warning")
            return
        self._window.show_panel("Measurements")
        self._add(Kind.RADIUS, held)

    def remove_measurements(self) -> None:
        """Remove the measurements that are selected in the table, or all."""
        selected = self._window.measurements.selected
        self._document.forget(selected or self._document.measurements)

    # -- cross-sections ----------------------------------------------------------------------------

    def section(self) -> None:
        """Cut the mesh with a plane, or end that."""
        window = self._window
        if window.action("section").isChecked():
            window.show_panel("Cross-section")
        else:
            window.section.clear()
            self.handle.hide()
        self._cut()

    def cut_across(self, normal: Any) -> None:
        """Cut at right angles to a direction, through the middle."""
        subject = self._display.subject
        if subject is None:
            self._window.notification.say("Open a mesh first.", "warning")
            return
        middle = np.array(subject.state.bounds).reshape(3, 2).mean(axis=1)
        self._document.plane = Plane.of(middle, normal)
        self._window.action("section").setChecked(True)
        self.section()

    @Slot(float)
    def _slide(self, fraction: float) -> None:
        plane, span = self._document.plane, self._span()
        if plane is None or span is None:
            return
        normal, origin = plane.frame[2], np.array(plane.origin)
        place = span[0] + fraction * (span[1] - span[0])
        self._document.plane = Plane.of(origin + (place - origin @ normal) * normal, plane.normal)
        self._cut()

    @Slot(object)
    def _move(self, plane: Plane) -> None:
        self._document.plane = plane
        self._cut()

    def _span(self) -> tuple[float, float] | None:
        """Return where along the normal the mesh begins and ends."""
        subject, plane = self._display.subject, self._document.plane
        if subject is None or plane is None:
            return None
        x, y, z = np.array(subject.state.bounds).reshape(3, 2)
        along = np.array(np.meshgrid(x, y, z)).reshape(3, -1).T @ plane.frame[2]
        return float(along.min()), float(along.max())

    def _cut(self, *_: Any) -> None:
        """Have the outlines made; while some are being made, once more after that."""
        subject, window, document = self._display.subject, self._window, self._document
        if not window.action("section").isChecked():
            return
        if subject is None or subject.state.surface is None:
            window.section.clear()
            self.handle.hide()
            return
        if document.plane is None:
            size = np.diff(np.array(subject.state.bounds).reshape(3, 2), axis=1).ravel()
            self.cut_across(np.eye(3)[int(np.argmax(size))])
            return
        plane, span = document.plane, self._span()
        assert span is not None
        window.section.set_place(
            (float(np.array(plane.origin) @ plane.frame[2]) - span[0]) / ((span[1] - span[0]) or 1.0)
        )
        self.handle.show_plane(plane, subject.state.bounds)
        if self._jobs.busy("section"):
            self._again = True
            return

        def work(context: Context) -> Any:
            states = (subject.before if subject.before is not subject.state else None, subject.state)
            return plane, [None if state is None else outline(state, plane) for state in states]

        job = self._jobs.start("section", work)
        job.done.connect(self._show_section)
        job.failed.connect(self._failed)

    @Slot(object)
    def _show_section(self, result: Any) -> None:
        plane, (before, after) = result
        if self._window.action("section").isChecked():
            self._window.section.show_outlines(before, after, plane.names, self._document.unit)
        if self._again:
            self._again = False
            self._cut()
