"""Applying filters, and previewing them."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

from PySide6.QtCore import QObject, QTimer, Signal, Slot

from vtksmooth.filters import INPUTS, Filter
from vtksmooth.filters.arrays import point_array_names
from vtksmooth.pages.page import said

from ..model import numbers
from ..model.document import Document
from ..model.layer import Layer
from ..model.state import State
from ..settings import Settings
from ..views.filter_form import title
from ..views.main_window import MainWindow
from ..views.recipe_list import parameters
from .files import explain
from .jobs import Context, Job, Jobs

#: Larger meshes are previewed when a slider is let go of, not while it moves.
_LIVE = 100_000
#: How long to wait for the next change before a preview starts, milliseconds.
_PAUSE = 150


@dataclass(frozen=True)
class _Request:
    """What is to be run: a filter with its parameters, on states."""

    cls: type[Filter]
    values: dict[str, Any]
    layer: Layer
    #: None for optional inputs that are none.
    states: list[State | None]

    def work(self, context: Context) -> _Result:
        """Run it; the filter belongs to the worker alone until it has ended."""
        began = time.perf_counter()
        filter: Any = context.run(
            self.cls(**self.values), *(None if state is None else state.input() for state in self.states)
        )
        seconds = time.perf_counter() - began
        outputs = [State.of(filter.GetOutput(port), self.states[0]) for port in range(len(self.cls.outputs))]
        report = str(getattr(filter, "report", "") or numbers.line(filter.figures))
        return _Result(self, outputs, seconds, report, said(filter), filter.notes)


@dataclass(frozen=True)
class _Result:
    """What came out of a request."""

    request: _Request
    outputs: list[State]
    seconds: float
    report: str
    did: str
    notes: list[str]


class Filtering(QObject):
    """The commands of the menu Filters."""

    #: What would come out; None: nothing is previewed.
    previewed = Signal(object)
    #: A filter has been applied.
    applied = Signal()

    def __init__(self, document: Document, window: MainWindow, jobs: Jobs, settings: Settings) -> None:
        super().__init__(window)
        self._document, self._window, self._jobs, self._settings = document, window, jobs, settings
        self._panel = window.filters
        self._timer = QTimer(self, singleShot=True, interval=_PAUSE)
        self._timer.timeout.connect(self._start_preview)
        #: What a preview was asked for, and what came out if it has ended.
        self._previewing: _Request | None = None
        self._preview: _Result | None = None
        self._panel.edited.connect(self._edited)
        self._panel.chosen.connect(self._chosen)
        document.changed.connect(self._document_changed)
        jobs.changed.connect(self._show_state)
        last = settings.get("filter", "TrapeziumDrawing")
        for cls in self._panel._filters:
            if cls.__name__ == last:
                self._panel.choose(cls)
        self._recall()
        self._show_state()

    # -- commands ----------------------------------------------------------------------------------

    def apply(self) -> None:
        """Run the filter on the active layer."""
        request = self._request()
        if request is None:
            return
        self.remember()
        # What a preview of the same has found, or is about to find, is not computed again.
        if self._preview is not None and self._preview.request == request:
            self._done(self._preview)
            return
        job = self._jobs.move("preview", "apply") if self._previewing == request else None
        self._window.action("preview").setChecked(False)
        self._drop_preview()
        if job is not None:
            job.done.disconnect(self._show_preview)
        else:
            job = self._start("apply", request)
            self._panel.set_progress(0.0, f"{title(request.cls)} …")
        job.done.connect(self._done)
        self._show_state()

    def cancel(self) -> None:
        """Stop what runs."""
        if self._jobs.busy("apply"):
            self._jobs.cancel("apply")
            self._window.notification.say("Cancelled; the mesh is as it was.")
        elif self._window.action("preview").isChecked():
            self._window.action("preview").setChecked(False)
            self._drop_preview()

    def preview(self) -> None:
        """Begin or end to show what the filter would do."""
        if self._window.action("preview").isChecked():
            self._start_preview()
        else:
            self._drop_preview()

    # -- a run -------------------------------------------------------------------------------------

    def _request(self) -> _Request | None:
        layer, panel = self._document.active, self._panel
        if layer is None or layer.state is None:
            self._window.notification.say("Open a mesh first.", "warning")
            return None
        states: list[State | None] = [layer.state]
        for name, target in zip(panel.inputs, panel.further_inputs(), strict=True):
            state = target.state if isinstance(target, Layer) else target
            if state is None and name not in panel.filter.optional_inputs:
                self._window.notification.say(
                    f"{title(panel.filter)} needs a second mesh, the {INPUTS[name].title}: "
                    "open it as a layer.",
                    "warning",
                )
                return None
            states.append(state)
        return _Request(panel.filter, panel.values(), layer, states)

    def _start(self, lane: str, request: _Request) -> Job:
        job = self._jobs.start(lane, request.work)
        job.progressed.connect(self._panel.set_progress)
        job.failed.connect(self._failed)
        job.stopped.connect(self._stopped)
        return job

    @Slot(object)
    def _done(self, result: _Result) -> None:
        request, report, notes = result.request, result.report, result.notes
        self._panel.set_progress(None)
        if request.layer.state is not request.states[0]:
            self._window.notification.say("The mesh has changed meanwhile; nothing was applied.", "warning")
            return
        step, sources = self._document.step(request.layer, request.cls, request.values, request.states[1:])
        given = parameters(step)
        name = f"{title(request.cls)} on {request.layer.name}" + (f": {given}" if given else "")
        self._document.apply(request.layer, result.outputs, step, sources, name, result.did, report)
        words = report or f"done in {result.seconds:.2f} s."
        self._window.notification.say(
            " ".join([f"{title(request.cls)}:", *notes, words]), "warning" if notes else "note"
        )
        self.applied.emit()

    @Slot(object)
    def _failed(self, error: Exception) -> None:
        self._panel.set_progress(None)
        self._window.notification.say(explain(error), "error")

    @Slot()
    def _stopped(self) -> None:
        self._panel.set_progress(None)

    # -- previews ----------------------------------------------------------------------------------

    @Slot(bool)
    def _edited(self, sliding: bool) -> None:
        if not self._window.action("preview").isChecked():
            return
        layer = self._document.active
        if sliding and layer is not None and layer.state is not None and layer.state.n_faces > _LIVE:
            return
        self._timer.start()

    @Slot()
    def _start_preview(self) -> None:
        request = self._request()
        if request is None:
            self._window.action("preview").setChecked(False)
            return
        self._previewing = request
        self._start("preview", request).done.connect(self._show_preview)

    @Slot(object)
    def _show_preview(self, result: _Result) -> None:
        report = result.report or f"{result.seconds:.2f} s"
        self._panel.set_progress(None, f"preview: {report.partition(chr(10))[0]}")
        self._panel.doing.setToolTip(report)
        self._preview = result
        self.previewed.emit(result.outputs[0])

    def _drop_preview(self) -> None:
        self._timer.stop()
        self._jobs.cancel("preview")
        self._previewing = self._preview = None
        self._panel.set_progress(None)
        self.previewed.emit(None)

    # -- keeping the panel up to date --------------------------------------------------------------

    def _document_changed(self) -> None:
        document, layer = self._document, self._document.active
        targets: list[tuple[str, Any]] = []
        names: list[str] = []
        if layer is not None and layer.state is not None:
            others = [other for other in document.layers if other is not layer]
            space = document.space
            others.sort(key=lambda other: other is not space)
            targets = [(other.name, other) for other in others]
            targets.insert(0 if space is None else 1, (f"{layer.name} as opened", layer.opened))
            names = [name for name in point_array_names(layer.state.mesh) if name]
        self._panel.set_targets(targets, names)
        previewed = self._previewing.states[0] if self._previewing is not None else None
        if previewed is not None and (layer is None or layer.state is not previewed):
            self._window.action("preview").setChecked(False)
            self._drop_preview()
        self._show_state()

    def _chosen(self) -> None:
        self._recall()
        self._document_changed()
        self._edited(False)

    def remember(self) -> None:
        """Remember the filter and its parameters."""
        self._settings.set("filter", self._panel.filter.__name__)
        self._settings.set(f"parameters/{self._panel.filter.__name__}", self._panel.values())

    def _recall(self) -> None:
        self._panel.set_values(self._settings.get(f"parameters/{self._panel.filter.__name__}", {}))

    def _show_state(self) -> None:
        busy = self._jobs.busy("apply")
        layer = self._document.active
        self._window.action("apply").setEnabled(not busy and layer is not None)
        self._window.action("preview").setEnabled(not busy and layer is not None)
        self._window.action("cancel").setEnabled(busy or self._window.action("preview").isChecked())
