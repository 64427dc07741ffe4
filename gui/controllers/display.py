"""What is shown: overlays, thresholds, before and after, the brush, the worst faces, the figures."""

from __future__ import annotations

from typing import Any

import numpy as np
from PySide6.QtCore import QObject, QTimer, Signal, Slot

from ..commands import COLOURS, overlay_id
from ..model import numbers, overlays, picking
from ..model.document import Document
from ..model.field import Field
from ..model.layer import Layer, Role
from ..model.overlays import OVERLAYS, Overlay, Subject, Unavailable
from ..model.selection import face_points, faces_as_mesh
from ..model.state import State, ready
from ..model.units import labelled
from ..settings import Settings
from ..views import scale
from ..views.main_window import MainWindow
from ..views.mesh_view import SINGLE, SPLIT, SWIPE
from ..views.theme import DARK, LIGHT
from .files import explain
from .jobs import Context, Jobs

#: Colour and opacity of the layers that are not worked on.
_CONTEXT = {
    Role.MESH: ((0.72, 0.75, 0.80), 0.45),
    Role.REFERENCE: ((0.55, 0.58, 0.62), 0.45),
    Role.SPACE: ((0.25, 0.50, 0.80), 0.35),
}
_LINES = ((0.1, 0.1, 0.12), 1.0)

#: Switches that belong to what is looked at.
_SWITCHES = ("toggle_before", "split", "swipe", "edges", "bad_faces", "bands", "parallel", "papers_bins")

_CAMERAS = {
    "px": ((1, 0, 0), (0, 0, 1)),
    "nx": ((-1, 0, 0), (0, 0, 1)),
    "py": ((0, 1, 0), (0, 0, 1)),
    "ny": ((0, -1, 0), (0, 0, 1)),
    "pz": ((0, 0, 1), (0, 1, 0)),
    "nz": ((0, 0, -1), (0, 1, 0)),
}


class Display(QObject):
    """The commands of the menus View and Overlay."""

    #: The overlay that was asked for is shown (or cannot be).
    shown = Signal()
    #: Another mesh is shown, or another one before it.
    subject_changed = Signal()
    #: The figures are complete.
    measured = Signal()

    def __init__(self, document: Document, window: MainWindow, jobs: Jobs, settings: Settings) -> None:
        super().__init__(window)
        self._document, self._window, self._jobs, self._settings = document, window, jobs, settings
        self.overlay: Overlay | None = OVERLAYS[0]
        self.fields: tuple[Field | None, Field | None] = (None, None)
        self._preview: State | None = None
        self._thresholds: dict[str, list[float]] = settings.get("thresholds", {})
        name = settings.get("colours", COLOURS[0])
        self._colours: str = name if name in COLOURS else COLOURS[0]
        window.action(f"colours_{self._colours}").setChecked(True)
        self.selected: np.ndarray | None = None
        self._brush: tuple[float, float] | None = None
        self._brush_when_shown: tuple[float, float] | None = None
        self._framed = False
        #: The mesh that is shown, and why the overlay cannot be: for what is said to be about them.
        self._shown: tuple[Layer | None, State | None] = (None, None)
        self._reason = ""
        self._brush_timer = QTimer(self, singleShot=True, interval=25)
        self._brush_timer.timeout.connect(self._select)
        view = window.view
        view.pointed.connect(self._probe)
        view.left.connect(self._leave)
        window.colour_bar.edited.connect(self._set_thresholds)
        window.histogram.brushed.connect(self._brushed)
        window.worst.chosen.connect(self._go_to_face)
        document.changed.connect(self.refresh)
        for id, command in self.commands().items():
            window.action(id).triggered.connect(command)
        dark = settings.get("dark", False)
        window.action("dark").setChecked(dark)
        for id in ("bands", "edges", "parallel", "bad_faces", "papers_bins"):
            action = window.action(id)
            action.setChecked(settings.get(id, action.isChecked()))
        self.dark()
        self.edges()
        self.parallel()
        self.papers_bins()
        self.refresh()

    def commands(self) -> dict[str, Any]:
        """Return commands that differ by an argument only."""
        found: dict[str, Any] = {
            overlay_id(one.id): lambda _=False, one=one: self.show_overlay(one) for one in OVERLAYS
        }
        found[overlay_id("none")] = lambda _=False: self.show_overlay(None)
        for name in COLOURS:
            found[f"colours_{name}"] = lambda _=False, name=name: self._set_colours(name)
        for name, (direction, up) in _CAMERAS.items():
            found[f"view_{name}"] = lambda _=False, d=direction, u=up: self._window.view.look_from(d, u)
        return found

    # -- what is shown -----------------------------------------------------------------------------

    @property
    def subject(self) -> Subject | None:
        """What overlays are computed from."""
        layer = self._document.active
        state = self._preview or (layer.state if layer is not None else None)
        if state is None:
            return None
        space = self._document.space
        other = self._document.other
        return Subject(
            state,
            self._document.before,
            space.state if space is not None and space is not layer else None,
            other.state if other is not None else None,
        )

    @Slot(object)
    def set_preview(self, state: State | None) -> None:
        """Show this instead of the active mesh."""
        if state is not self._preview:
            self._preview = state
            self.refresh()
            self.subject_changed.emit()

    def refresh(self) -> None:
        """Show the document as it is now."""
        window, document, subject = self._window, self._document, self.subject
        layer = document.active
        self._leave()
        shown = layer, layer.state if layer is not None else None
        if shown != self._shown:
            self._shown = shown
            window.notification.hide()  # it is about another mesh, or about this one as it was
        window.hint.setVisible(subject is None)
        window.view.set_preview(self._preview is not None)
        visible = layer is not None and layer.visible
        before = document.before
        window.view.show_meshes(subject.state if subject and visible else None, before if visible else None)
        context = {}
        for other in document.layers:
            if other is layer or not other.visible or other.state is None:
                continue
            colour, opacity = _CONTEXT[other.role] if other.state.n_faces else _LINES
            context[other] = (other.state, colour, opacity)
        window.view.show_context(context)
        if subject is not None and not self._framed:
            window.view.look_from((1.0, -1.6, 0.9), (0, 0, 1))
        self._framed = subject is not None
        if window.histogram.locked:
            self._select()
        else:
            window.histogram.set_brush(None)
        window.view.mark("worst", None)
        self._show_numbers()
        self._request()

    def show_overlay(self, one: Overlay | None) -> None:
        """Show an overlay, or None: the plain mesh."""
        window = self._window
        if not window.histogram.locked:
            window.histogram.set_brush(None)  # of the values that are still shown
        self.overlay = one
        self._leave()
        if window.notification.text == self._reason:
            window.notification.hide()
        window.action(overlay_id(one.id if one else "none")).setChecked(True)
        window.overlays.setCurrentIndex(window.overlays.findData(overlay_id(one.id if one else "none")))
        window.view.mark("worst", None)
        self._request()

    def _request(self) -> None:
        """Show the overlay if its values are there, and have them computed otherwise."""
        one, subject = self.overlay, self.subject
        self._jobs.cancel("overlay")
        self._window.statusBar().clearMessage()
        if one is None or subject is None:
            self._show(None, None)
            self._measure()
            return
        before = self._subject_before(one, subject)
        try:
            overlays.check_available(one, subject)
        except Unavailable as reason:
            self._explain(reason)
            return
        fields = (overlays.cached(one, subject), overlays.cached(one, before) if before else None)
        if fields[0] is not None and (before is None or fields[1] is not None):
            self._show(*fields)
            self._measure()
            return

        def work(context: Context) -> Any:
            values = overlays.compute(one, subject, context.run)
            try:
                values_before = overlays.compute(one, before, context.run) if before else None
            except Unavailable:
                values_before = None
            return one, subject, values, values_before

        # Until they come, what is shown belongs to another mesh or overlay: nobody may go by it.
        self.fields = (None, None)
        job = self._jobs.start("overlay", work)
        job.done.connect(self._computed)
        job.failed.connect(self._explain)
        self._window.statusBar().showMessage(f"Computing {one.title} …")

    @staticmethod
    def _subject_before(one: Overlay, subject: Subject) -> Subject | None:
        """Return what the overlay of "before" is computed from; a comparison has none."""
        if subject.before is None or subject.before is subject.state or one.needs == "before":
            return None
        return Subject(subject.before, None, subject.space, subject.other)

    @Slot(object)
    def _computed(self, result: Any) -> None:
        one, subject, after, before = result
        self._window.statusBar().clearMessage()
        if one is self.overlay and subject == self.subject:
            self._show(after, before)
            self._measure()

    @Slot(object)
    def _explain(self, reason: Exception) -> None:
        self._window.statusBar().clearMessage()
        text = str(reason) if isinstance(reason, Unavailable) else explain(reason)
        assert self.overlay is not None
        self._reason = f"{self.overlay.title}: {text}"
        self._window.notification.say(self._reason, "warning")
        self._show(None, None)
        self._measure()

    def _show(self, after: Field | None, before: Field | None) -> None:
        """Colour the meshes and show the values everywhere."""
        window, one, subject = self._window, self.overlay, self.subject
        self.fields = (after, before)
        if one is None or after is None or subject is None:
            window.view.colour("after", None, None)
            window.view.colour("before", None, None)
            window.colour_bar.show_scale(None, "", None)
            window.histogram.show_fields(None, None, "", (0.0, 1.0), ())
            window.worst.show_field(None, "value")
            self.bad_faces()
            window.view.mark("lines", None)
        else:
            window.worst.show_field(after if one.kind != "amount" else None, one.title, one.classes)
            window.view.mark("lines", after.lines)
            self._colour()
            if self._brush is not None and not window.histogram.locked:
                self._select()  # it was set while the values were on their way
            if self._brush_when_shown is not None:
                window.histogram.set_brush(self._brush_when_shown)
                self._brush_when_shown = None
        self.shown.emit()

    @property
    def _drawn(self) -> tuple[Field | None, Field | None]:
        """The values of the mesh and of the one before, which may be the same."""
        subject, (after, before) = self.subject, self.fields
        return after, after if subject is not None and subject.before is subject.state else before

    def thresholds(self) -> tuple[float, float, float]:
        """Return good, warning and bad of the overlay that is shown."""
        one, subject = self.overlay, self.subject
        assert one is not None
        assert subject is not None
        kept = self._thresholds.get(one.id)
        if kept is None:
            return one.default_thresholds(subject, self.fields[0])
        good, warning, bad = (value * self._unit() for value in kept)
        return good, warning, bad

    def _unit(self) -> float:
        one, subject = self.overlay, self.subject
        assert one is not None
        assert subject is not None
        return (subject.before or subject.state).diagonal if one.relative else 1.0

    def _colour(self, dragging: bool = False) -> None:
        """Colour by the values that are there."""
        window, one = self._window, self.overlay
        after, before = self._drawn
        if one is None or after is None:
            return
        thresholds = self.thresholds()
        bands = one.judged and window.action("bands").isChecked()
        colours = scale.make(one, after, thresholds, self._colours, bands)
        window.view.colour("after", after, colours)
        window.view.colour("before", before, colours)
        heading = labelled(one.title, one.unit_of(self._document.unit))
        window.colour_bar.show_scale(colours, heading, thresholds if one.judged else None)
        span = (colours.low, colours.high)
        lines = thresholds if one.judged else ()
        window.histogram.show_fields(
            self.fields[1], after, heading, span, lines, one is OVERLAYS[0], one.classes
        )
        if not dragging:
            self.bad_faces()

    @Slot(tuple, bool)
    def _set_thresholds(self, values: tuple[float, float, float], dragging: bool) -> None:
        assert self.overlay is not None
        unit = self._unit() or 1.0
        self._thresholds[self.overlay.id] = [value / unit for value in values]
        self._settings.set("thresholds", self._thresholds)
        self._colour(dragging)

    # -- figures -----------------------------------------------------------------------------------

    def _measure(self) -> None:
        """Have the figures computed that are missing; meanwhile show those that are there."""
        subject = self.subject
        self._show_numbers()
        if subject is None:
            return

        def work(context: Context) -> Any:
            overlays.summarise(subject, context.run)
            return subject

        job = self._jobs.start("numbers", work)
        job.done.connect(self._measured)
        job.failed.connect(lambda error: None)  # what is wrong with the mesh, the overlay has said

    @Slot(object)
    def _measured(self, subject: Subject) -> None:
        if subject == self.subject:
            self._show_numbers()
            self.measured.emit()

    def _show_numbers(self) -> None:
        subject, unit = self.subject, self._document.unit
        self._window.numbers.show_rows(numbers.rows(subject, unit) if subject else [])
        words = numbers.status(subject, unit) if subject else []
        if self._preview is not None:
            words.insert(0, "PREVIEW")
        self._window.figures.setText("  │  ".join(words))

    # -- how things are looked at ------------------------------------------------------------------

    def look(self) -> dict[str, Any]:
        """Return what a session keeps of the view: camera, overlay, thresholds, switches."""
        window, camera = self._window, self._window.view.camera
        return {
            "overlay": self.overlay.id if self.overlay else None,
            "thresholds": self._thresholds,
            "colours": self._colours,
            "switches": {id: window.action(id).isChecked() for id in _SWITCHES},
            "brush": self._brush,
            "swipe_at": window.view.swipe_at,
            "camera": {
                "position": camera.GetPosition(),
                "focal_point": camera.GetFocalPoint(),
                "view_up": camera.GetViewUp(),
                "view_angle": camera.GetViewAngle(),
                "parallel_scale": camera.GetParallelScale(),
            },
        }

    def set_look(self, look: dict[str, Any]) -> None:
        """Look at things as a session says; what it does not say stays."""
        window, camera = self._window, self._window.view.camera
        for id, on in look.get("switches", {}).items():
            if id in _SWITCHES and window.action(id).isChecked() != bool(on):
                window.action(id).trigger()
        self._thresholds = {
            id: [float(value) for value in values] for id, values in look.get("thresholds", {}).items()
        }
        if look.get("colours") in COLOURS:
            window.action(f"colours_{look['colours']}").trigger()
        window.view.set_swipe(float(look.get("swipe_at", window.view.swipe_at)))
        places = look.get("camera", {})
        for name, put in (
            ("position", camera.SetPosition),
            ("focal_point", camera.SetFocalPoint),
            ("view_up", camera.SetViewUp),
            ("view_angle", camera.SetViewAngle),
            ("parallel_scale", camera.SetParallelScale),
        ):
            if name in places:
                put(places[name])
        if "overlay" in look:
            self.show_overlay(next((one for one in OVERLAYS if one.id == look["overlay"]), None))
        window.view.render_soon()
        brush = look.get("brush")
        if brush is not None:
            self._brush_when_shown = (float(brush[0]), float(brush[1]))

    # -- commands ----------------------------------------------------------------------------------

    def toggle_before(self) -> None:
        """Show the mesh before, or after."""
        self._window.view.set_before(self._window.action("toggle_before").isChecked())

    def split(self) -> None:
        """Show before and after side by side."""
        self._set_mode("split", SPLIT, "swipe")

    def swipe(self) -> None:
        """Show before and after left and right of a line."""
        self._set_mode("swipe", SWIPE, "split")

    def _set_mode(self, id: str, mode: str, other: str) -> None:
        on = self._window.action(id).isChecked()
        if on:
            self._window.action(other).setChecked(False)
        self._window.view.set_mode(mode if on else SINGLE)

    def frame(self) -> None:
        """Bring the whole mesh into view."""
        subject = self.subject
        self._window.view.frame(subject.state.bounds if subject else None)

    @Slot(list)
    def bring_into_view(self, layers: list[Layer]) -> None:
        """Frame the mesh, one of the layers that have been opened, unless it can be seen from here."""
        subject = self.subject
        if layers and subject is not None and not self._window.view.sees(subject.state.bounds):
            self.frame()

    def edges(self) -> None:
        """Show or hide the edges."""
        self._window.view.set_edges(self._window.action("edges").isChecked())

    def bad_faces(self) -> None:
        """Outline faces beyond the bad threshold, of the mesh and of the one before, or not."""
        subject, one = self.subject, self.overlay
        on = self._window.action("bad_faces").isChecked()
        self._jobs.cancel("bad faces")
        if not on or subject is None or one is None or not one.judged or self.fields[0] is None:
            self._outline((None, None))
            return
        bad, states = self.thresholds()[2], (subject.state, subject.before)
        todo = list(zip(states, self._drawn, strict=True))

        def work(context: Context) -> Any:
            return [
                None if state is None or field is None
                else ready(faces_as_mesh(state, field.faces_beyond(bad)))
                for state, field in todo
            ]  # fmt: skip

        self._jobs.start("bad faces", work).done.connect(self._outline)

    @Slot(object)
    def _outline(self, meshes: Any) -> None:
        for name, mesh in zip(("bad", "bad before"), meshes, strict=True):
            self._window.view.mark(name, mesh)

    def bands(self) -> None:
        """Four colours, or a scale."""
        self._colour()

    def _set_colours(self, name: str) -> None:
        self._colours = name
        self._settings.set("colours", name)
        self._colour()

    def parallel(self) -> None:
        """Parallel projection, or perspective."""
        self._window.view.set_parallel(self._window.action("parallel").isChecked())

    def dark(self) -> None:
        """Light, or dark."""
        from PySide6.QtWidgets import QApplication

        theme = DARK if self._window.action("dark").isChecked() else LIGHT
        application = QApplication.instance()
        assert isinstance(application, QApplication)
        application.setPalette(theme.palette())
        for name in ("QCheckBox", "QListWidget", "QTreeWidget"):
            application.setPalette(theme.box_palette(), name)  # type: ignore[arg-type]
        self._window.set_theme(theme)

    def reset_thresholds(self) -> None:
        """Good, warning and bad as they were."""
        if self.overlay is not None and self.subject is not None:
            self._thresholds.pop(self.overlay.id, None)
            self._settings.set("thresholds", self._thresholds)
            self._colour()

    def papers_bins(self) -> None:
        """Show the histogram in the bins of the papers, or in fine ones."""
        histogram = self._window.histogram
        histogram.set_brush(None)
        histogram.papers_bins = self._window.action("papers_bins").isChecked()
        histogram.draw()
        self._colour()

    # -- the brush ---------------------------------------------------------------------------------

    @Slot(object)
    def _brushed(self, span: tuple[float, float] | None) -> None:
        self._brush = span
        self._brush_timer.start()
        if span is None:
            self._brush_timer.stop()
            self._select()

    def _select(self) -> None:
        subject, field = self.subject, self.fields[0]
        kept = self.selected if self._window.histogram.locked else None
        self._jobs.cancel("brush")
        if self._brush is None or subject is None or (field is None and kept is None):
            self.selected = None
            self._window.view.mark("brush", None)
            return
        low, high = self._brush
        # The outermost bins hold what lies beyond the scale as well.
        edges = self._window.histogram.edges()
        low = -np.inf if low <= edges[0] else low
        high = np.inf if high >= edges[-1] else high
        state = subject.state

        def work(context: Context) -> Any:
            if kept is None:
                assert field is not None
                faces = field.faces_between(low, high)
            else:
                faces = kept[kept < state.n_faces]
            return faces, ready(faces_as_mesh(state, faces)), state.n_faces

        self._jobs.start("brush", work).done.connect(self._selected)

    @Slot(object)
    def _selected(self, result: Any) -> None:
        self.selected, mesh, count = result
        self._window.view.mark("brush", mesh)
        self._window.statusBar().showMessage(f"{len(result[0]):,} of {count:,} faces selected", 5000)

    def lock_brush(self) -> None:
        """Keep the faces selected, whatever is shown."""
        self._window.histogram.set_locked(self._window.action("lock_brush").isChecked())

    # -- faces -------------------------------------------------------------------------------------

    def next_worst(self) -> None:
        """Go to the next worst face."""
        self._window.worst.go(1)

    def previous_worst(self) -> None:
        """Go to the worst face before."""
        self._window.worst.go(-1)

    @Slot(object)
    def _go_to_face(self, face: int | None) -> None:
        subject = self.subject
        if face is None or subject is None or self.fields[0] is None:
            self._window.view.mark("worst", None)
            return
        corners = face_points(subject.state, face)
        around = np.roll(corners, -1, axis=0)
        normal = np.cross(corners - corners[0], around - corners[0]).sum(axis=0)
        size = 10.0 * float(np.linalg.norm(around - corners, axis=1).max())
        self._window.view.look_at(corners, normal, size)
        self._window.view.mark("worst", faces_as_mesh(subject.state, np.array([face])))

    @Slot()
    def _leave(self) -> None:
        """Forget what is under the pointer; it is of another mesh, or of other values."""
        self._jobs.cancel("probe")
        self._window.probe.setText(" ")

    @Slot(object, object, bool)
    def _probe(self, origin: Any, direction: Any, before: bool) -> None:
        subject = self.subject
        if subject is None:
            return
        state = subject.before if before and subject.before is not None else subject.state
        field = self.fields[1] if state is not subject.state else self.fields[0]
        one, length = self.overlay, self._document.unit

        def work(context: Context) -> str:
            found = picking.probe(state, origin, direction)
            if found is None:
                return " "
            return found.describe(one.title if one else "", one.unit_of(length) if one else "", field, length)

        job = self._jobs.start("probe", work)
        job.done.connect(self._window.probe.setText)
