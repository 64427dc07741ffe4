"""Recipes: what was done to a mesh is edited, run again, kept, copied and reported."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Callable
from pathlib import Path
from typing import Any

from PySide6.QtCore import QObject, Signal, Slot
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QFileDialog

from vtksmooth.errors import Cancelled, RecipeError, VtksmoothError
from vtksmooth.files import atomic
from vtksmooth.filters.arrays import point_array_names
from vtksmooth.pages.measures import measure
from vtksmooth.pages.page import Page, make_page, said
from vtksmooth.pages.writing import FORMATS, check_format, write_page
from vtksmooth.recipe import Apply, Recipe

from ..model.document import Document
from ..model.draft import Draft
from ..model.layer import Layer
from ..model.replay import Replay
from ..model.state import Source, State
from ..settings import Settings
from ..views.filter_form import title
from ..views.main_window import MainWindow
from .files import explain
from .jobs import Context, Job, Jobs

#: Ways to write a recipe, by what the file dialog calls them.
JSON, VTK, PYVISTA = "Recipe (*.json)", "VTK script (*.py)", "PyVista script (*.py)"


def role_files(recipe: Recipe) -> dict[str, str]:
    """Return names of files for the roles of a recipe, for scripts and command lines."""
    return {role: f"{role}.vtp" for role in recipe.sources if not isinstance(role, Path)}


def report_maker(layer: Layer) -> Callable[[Apply], Page]:
    """Return what measures and draws a layer as it is now, beside the mesh as it was opened."""
    opened, state = layer.opened, layer.state
    assert state is not None
    before = layer.source.name if layer.source else f"{layer.name} as opened"
    after = layer.path.name if layer.path and not layer.unsaved else f"{layer.name} (not saved)"

    def make(run: Apply) -> Page:
        measured = measure(opened.input(), state.input(), run)
        return make_page(measured, (before, after), state.recipe, state.did)

    return make


def work_of(replay: Replay) -> Callable[[Context], Replay]:
    """Return what a worker has to do for a replay: with progress, and errors that name the step."""

    def work(context: Context) -> Replay:
        steps, todo, count = replay.recipe.steps, iter(replay.todo), itertools.count()

        def apply(algorithm: Any, *meshes: Any) -> None:
            index = next(todo)
            context.part(next(count), len(replay.todo), f"step {index + 1} of {len(steps)}")
            try:
                context.run(algorithm, *meshes)
            except Cancelled:
                raise
            except VtksmoothError as error:
                raise RecipeError(f"Step {index + 1}, {title(steps[index].cls)}: {error}") from error

        return replay.run(apply, said)

    return work


class Recipes(QObject):
    """The commands of the menu Recipe that deal with the recipe of the active layer."""

    #: A report has been written.
    reported = Signal(object)

    def __init__(self, document: Document, window: MainWindow, jobs: Jobs, settings: Settings) -> None:
        super().__init__(window)
        self._document, self._window, self._jobs, self._settings = document, window, jobs, settings
        self.draft = Draft(document)
        self._list = window.recipe
        self._list.switched.connect(self._switch)
        self._list.moved.connect(self._move)
        self._list.removed.connect(self._remove)
        self._list.changed.connect(self._change)
        self._list.input_changed.connect(self._change_input)
        self._list.selected.connect(self._offer)
        document.changed.connect(self.refresh)
        self.draft.changed.connect(self.refresh)
        jobs.changed.connect(self._enable)
        self.refresh()

    def refresh(self) -> None:
        """Show the recipe and the log as they are now."""
        draft = self.draft
        did = () if draft.state is None else draft.state.did
        self._list.show_recipe(draft.recipe, draft.first_to_run, draft.edited, did)
        done = "" if draft.state is None else self._script(draft.state.recipe, VTK)
        self._window.log.show_lines(done.splitlines())
        self._enable()

    def _enable(self) -> None:
        action, layer = self._window.action, self._document.active
        busy = self._jobs.busy("apply")
        action("run_recipe").setEnabled(self.draft.edited and not busy)
        action("revert_recipe").setEnabled(self.draft.edited and not busy)
        for id in ("open_recipe", "save_recipe", "copy_script", "copy_pyvista", "copy_command", "report"):
            action(id).setEnabled(layer is not None)

    @Slot()
    def _offer(self) -> None:
        state = self.draft.state
        names = [] if state is None else [name for name in point_array_names(state.mesh) if name]
        self._list.show_targets([(name, source) for name, source, _ in self.draft.offers()], names)

    # -- editing -----------------------------------------------------------------------------------

    @Slot(int, bool)
    def _switch(self, index: int, on: bool) -> None:
        if self.draft.recipe.steps[index].enabled != on:
            self.draft.set(self.draft.recipe.switched(index, on))

    @Slot(int, int)
    def _move(self, index: int, to: int) -> None:
        self.draft.set(self.draft.recipe.moved(index, to))

    @Slot(int)
    def _remove(self, index: int) -> None:
        self.draft.set(self.draft.recipe.removed(index))

    @Slot(int, object)
    def _change(self, index: int, values: dict[str, Any]) -> None:
        self.draft.set(self.draft.recipe.changed(index, **values))

    @Slot(int, str, object)
    def _change_input(self, index: int, name: str, source: Source | None) -> None:
        state = next((state for _, one, state in self.draft.offers() if one == source), None)
        step = self.draft.recipe.steps[index]
        inputs = {other: one for other, one in step.inputs.items() if other != name}
        step = dataclasses.replace(step, inputs=inputs if source is None else {**inputs, name: source})
        given: dict[Source, State] = {}
        layer = self._document.active
        if source is not None and state is not None and layer is not None and state is not layer.opened:
            given[source] = state
        self.draft.set(self.draft.recipe.replaced(index, step), given)

    def revert_recipe(self) -> None:
        """Forget the edits."""
        self.draft.drop(self._document.active)

    # -- running -----------------------------------------------------------------------------------

    def run_recipe(self) -> Job | None:
        """Run the recipe as it has been edited, from the first edited step on."""
        layer = self._document.active
        if layer is None:
            return None
        try:
            sources = self.draft.meshes()
        except RecipeError as error:
            self._window.notification.say(explain(error), "warning")
            return None
        replay = Replay(self._document, layer, self.draft.recipe, sources)
        job = self._jobs.start("apply", work_of(replay))
        job.progressed.connect(self._list.set_progress)
        job.progressed.connect(self._window.filters.set_progress)
        job.done.connect(self._ran)
        job.failed.connect(self._failed)
        job.stopped.connect(self._end_progress)
        return job

    @Slot(object)
    def _ran(self, replay: Replay) -> None:
        self._end_progress()
        layer = replay.layer
        if layer.state is not replay.before:
            self._window.notification.say("The mesh has changed meanwhile; nothing was run.", "warning")
            return
        count = len(replay.todo)
        steps = f"{count} step{'' if count == 1 else 's'}"
        again = f"{steps} from step {replay.todo[0] + 1} on" if count else "no step had to be run"
        self.draft.drop(layer)
        summary = "\n".join(words for words in replay.states[-1].did if words)
        self._document.replay(layer, replay.states, f"Recipe on {layer.name}: {again}", summary)
        self._window.notification.say(f"Recipe: {again}.")

    @Slot(object)
    def _failed(self, error: Exception) -> None:
        self._end_progress()
        self._window.notification.say(explain(error), "error")

    @Slot()
    def _end_progress(self) -> None:
        self._list.set_progress(None)
        self._window.filters.set_progress(None)

    # -- files -------------------------------------------------------------------------------------

    def open_recipe(self) -> None:
        """Ask for a recipe, to be run on the active layer."""
        name, _ = QFileDialog.getOpenFileName(
            self._window, "Open recipe", self._settings.get("folder", ""), f"{JSON};;All files (*)"
        )
        if name:
            self.load(Path(name))

    @Slot(object)
    def load(self, path: Path) -> None:
        """Show the recipe of a file as the one that shall make the active layer."""
        try:
            recipe = Recipe.load(path)
        except RecipeError as error:
            self._window.notification.say(explain(error), "error")
            return
        if self.draft.state is None:
            self._window.notification.say("Open a mesh first, to run the recipe on.", "warning")
            return
        self.draft.set(recipe)
        self._window.show_panel("Recipe")
        self._window.notification.say(f"{path.name}: {len(recipe)} steps; run them with Run Recipe.")

    def save_recipe(self) -> None:
        """Ask for a file, and write the recipe as JSON or as a script."""
        layer = self._document.active
        assert layer is not None
        start = (layer.source or Path(layer.name)).with_suffix(".json")
        name, kind = QFileDialog.getSaveFileName(
            self._window, "Save recipe", str(start), ";;".join((JSON, VTK, PYVISTA))
        )
        if name:
            self.write(Path(name), kind)

    def write(self, path: Path, kind: str = JSON) -> None:
        """Write the recipe as :data:`JSON`, or as a script for :data:`VTK` or :data:`PYVISTA`.

        The extension of `path`, if it has one, is what counts.
        """
        extension = path.suffix.lower() or (".json" if kind == JSON else ".py")
        path = path.with_suffix(extension)
        if (extension == ".py") != (kind != JSON):
            kind = VTK if extension == ".py" else JSON
        recipe = self.draft.recipe
        try:
            if kind == JSON:
                recipe.save(path)
            else:
                with atomic(path) as temporary:
                    temporary.write_text(self._script(recipe, kind), encoding="utf-8")
        except VtksmoothError as error:
            self._window.notification.say(explain(error), "error")
            return
        self._say_written(f"Saved {path.name}.", recipe)

    def copy_script(self) -> None:
        """Put the recipe on the clipboard, as a VTK pipeline."""
        self._copy(self._script(self.draft.recipe, VTK), "a Python script for VTK")

    def copy_pyvista(self) -> None:
        """Put the recipe on the clipboard, as a script for PyVista."""
        self._copy(self._script(self.draft.recipe, PYVISTA), "a Python script for PyVista")

    def copy_command(self) -> None:
        """Put the recipe on the clipboard, as command lines."""
        recipe = self.draft.recipe
        try:
            lines = recipe.command_lines(*self._ends(), role_files(recipe))
        except RecipeError as error:
            self._window.notification.say(explain(error), "error")
            return
        self._copy("".join(f"{line}\n" for line in lines), "command lines")

    def _copy(self, text: str, what: str) -> None:
        QGuiApplication.clipboard().setText(text)
        self._say_written(f"The recipe is on the clipboard, as {what}.", self.draft.recipe)

    def _say_written(self, text: str, recipe: Recipe) -> None:
        roles = ", ".join(role_files(recipe))
        told = f" It needs meshes that are no files yet, by their roles: {roles}." if roles else ""
        self._window.notification.say(text + told, "warning" if roles else "note")

    def _ends(self) -> tuple[Path, Path]:
        """Return the files that a script reads and writes."""
        layer = self._document.active
        assert layer is not None
        source = layer.source.absolute() if layer.source else Path(f"{layer.name}.vtp")
        return source, source.with_name(f"{source.stem}_result.vtp")

    def _script(self, recipe: Recipe, kind: str) -> str:
        make = recipe.pyvista_script if kind == PYVISTA else recipe.vtk_script
        return make(*self._ends(), role_files(recipe))

    # -- reports -----------------------------------------------------------------------------------

    def report(self) -> None:
        """Ask for a file, and write a report of the active layer."""
        layer = self._document.active
        assert layer is not None
        start = (layer.path or Path(layer.name)).with_suffix(".html")
        formats = ";;".join(f"{extension[1:].upper()} (*{extension})" for extension in FORMATS)
        name, kind = QFileDialog.getSaveFileName(self._window, "Save report", str(start), formats)
        if name:
            chosen = next((extension for extension in FORMATS if extension in kind), start.suffix)
            self.write_report(Path(name) if Path(name).suffix else Path(name).with_suffix(chosen))

    def write_report(self, path: Path) -> Job | None:
        """Write a report of what the recipe has made of the active layer; `path` chooses the format."""
        layer = self._document.active
        if layer is None or layer.state is None:
            return None
        make = report_maker(layer)

        def work(context: Context) -> Path:
            check_format(path)
            page = make(context.run)
            context.check()
            write_page(page, path)
            return path

        self._window.statusBar().showMessage(f"Writing {path.name} …")
        job = self._jobs.start("report", work)
        job.done.connect(self._reported)
        job.failed.connect(self._report_failed)
        return job

    @Slot(object)
    def _reported(self, path: Path) -> None:
        self._window.statusBar().clearMessage()
        self._window.notification.say(f"Wrote {path.name}.")
        self.reported.emit(path)

    @Slot(object)
    def _report_failed(self, error: Exception) -> None:
        self._window.statusBar().clearMessage()
        self._window.notification.say(explain(error), "error")
