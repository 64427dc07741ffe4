"""Batches: a recipe on many files, as ``vtksmooth run`` does it."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path
from typing import Any

from PySide6.QtCore import QObject, Signal, Slot
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QFileDialog

from vtksmooth import batch
from vtksmooth.errors import VtksmoothError
from vtksmooth.files import READABLE, WRITABLE, make_folder, read_surface
from vtksmooth.pages.writing import FORMATS
from vtksmooth.recipe import Recipe

from ..model.draft import Draft
from ..settings import Settings
from ..views.batch_dialog import BatchDialog
from ..views.main_window import MainWindow
from .files import explain
from .jobs import Context, Job, Jobs
from .recipes import JSON


class Batches(QObject):
    """The dialog of batches, and what runs in it."""

    #: A batch has ended, in whatever way.
    ended = Signal()
    #: Results are to be opened: their paths.
    opened = Signal(list)

    def __init__(self, draft: Draft, window: MainWindow, jobs: Jobs, settings: Settings) -> None:
        super().__init__(window)
        self._draft, self._window, self._jobs, self._settings = draft, window, jobs, settings
        self._job: Job | None = None
        self._todo: list[batch.Job] = []
        self.outcomes: list[batch.Outcome] = []

    @cached_property
    def dialog(self) -> BatchDialog:
        """The dialog, made when it is wanted first."""
        dialog = BatchDialog(batch.HEAD, WRITABLE, FORMATS, self._window)
        dialog.recipe_wanted.connect(self._choose_recipe)
        dialog.files_wanted.connect(self._choose_files)
        dialog.folder_wanted.connect(self._choose_folder)
        dialog.output_wanted.connect(self._choose_output)
        dialog.start_wanted.connect(self.start)
        dialog.cancel_wanted.connect(self.cancel)
        dialog.copy_wanted.connect(self.copy)
        dialog.opened.connect(self._open)
        dialog.output.setText(self._settings.get("batch", ""))
        return dialog

    def batch(self) -> None:
        """Show the dialog."""
        count = len(self._draft.recipe)
        if count:
            words = f"that of the active layer, {count} step{'' if count == 1 else 's'}"
            self.dialog.offer_recipe(words, None)
        self.dialog.show()
        self.dialog.raise_()

    # -- choosing ----------------------------------------------------------------------------------

    def _folder(self) -> str:
        return str(self._settings.get("folder", ""))

    @Slot()
    def _choose_recipe(self) -> None:
        name, _ = QFileDialog.getOpenFileName(self.dialog, "Recipe", self._folder(), f"{JSON};;All files (*)")
        if name:
            self.dialog.offer_recipe(Path(name).name, Path(name))

    @Slot()
    def _choose_files(self) -> None:
        patterns = " ".join(f"*{extension}" for extension in READABLE)
        names, _ = QFileDialog.getOpenFileNames(
            self.dialog, "Meshes", self._folder(), f"Meshes ({patterns});;All files (*)"
        )
        self.dialog.add_sources(names)

    @Slot()
    def _choose_folder(self) -> None:
        name = QFileDialog.getExistingDirectory(self.dialog, "Folder of meshes", self._folder())
        if name:
            self.dialog.add_sources([name])

    @Slot()
    def _choose_output(self) -> None:
        name = QFileDialog.getExistingDirectory(self.dialog, "Folder for the results", self._folder())
        if name:
            self.dialog.output.setText(name)

    # -- running -----------------------------------------------------------------------------------

    @Slot()
    def start(self) -> None:
        """Run the recipe on the files."""
        dialog, chosen = self.dialog, self.dialog.recipes.currentData()
        sources, output = dialog.paths(), Path(dialog.output.text().strip()).expanduser()
        extension, report = dialog.format.currentData(), dialog.report.currentData()
        try:
            recipe = self._draft.recipe if chosen is None else Recipe.load(chosen)
            given = {source: state.input() for source, state in self._draft.meshes(recipe).items()}
        except VtksmoothError as error:
            dialog.said.setText(explain(error))
            return
        self._settings.set("batch", dialog.output.text().strip())
        files = [path for path in recipe.sources if isinstance(path, Path)]

        def work(context: Context) -> None:
            todo = batch.plan(sources, output, extension, [*files, *([chosen] if chosen else [])])
            context.send(todo)
            inputs = given | {path: read_surface(path)[0] for path in files if path not in given}
            make_folder(output)
            for number, job in enumerate(todo):
                context.part(number, len(todo), f"{number + 1} of {len(todo)}, {job.source.name}")
                context.send(batch.attempt(recipe, job, inputs, context.run, report=report))

        self._todo, self.outcomes = [], []
        dialog.show_files([])
        dialog.set_running(True)
        dialog.copy.setEnabled(False)
        job = self._job = self._jobs.start("batch", work)
        job.progressed.connect(self._progress)
        job.sent.connect(self._receive)
        job.done.connect(self._done)
        job.failed.connect(self._failed)
        job.stopped.connect(self._stopped)

    @Slot()
    def cancel(self) -> None:
        """Stop after what can be stopped; what is done stays done."""
        if self._job is not None:
            # Not by its lane: what has been written by then is to be told.
            self._job.context.cancel()
            self.dialog.said.setText("Cancelling …")

    @Slot(float, str)
    def _progress(self, fraction: float, what: str) -> None:
        self.dialog.set_progress(fraction, what)
        number = len(self.outcomes)
        if number < len(self._todo):
            share = 100.0 * (fraction * len(self._todo) - number)
            words = f"running, {min(max(share, 0.0), 100.0):.0f} %"
            self.dialog.set_cells(number, [self._todo[number].source.name, words])

    @Slot(object)
    def _receive(self, part: Any) -> None:
        if isinstance(part, batch.Outcome):
            self.outcomes.append(part)
            name, *figures = batch.row(part)
            if part.error:
                self.dialog.set_cells(len(self.outcomes) - 1, [name, "failed", part.error], failed=True)
            else:
                self.dialog.set_cells(len(self.outcomes) - 1, [name, "done", *figures])
        else:
            self._todo = part
            self.dialog.show_files([job.source.name for job in part])

    @Slot(object)
    def _done(self, _: None) -> None:
        self._end("")

    @Slot(object)
    def _failed(self, error: Exception) -> None:
        self._end(explain(error))

    @Slot()
    def _stopped(self) -> None:
        for row in range(len(self.outcomes), len(self._todo)):
            self.dialog.set_cells(row, [self._todo[row].source.name, "not done"])
        self._end("Cancelled.")

    def _end(self, words: str) -> None:
        failed = sum(bool(outcome.error) for outcome in self.outcomes)
        counted = f"{len(self.outcomes) - failed} done, {failed} failed." if self._todo else ""
        said = f"{words} {counted}".strip()
        self._job = None
        self.dialog.set_running(False)
        self.dialog.said.setText(said)
        if not self.dialog.isVisible():
            self._window.notification.say(f"Batch: {said}", "warning" if failed or words else "note")
        self.dialog.copy.setEnabled(bool(self.outcomes))
        self.ended.emit()

    @Slot(int)
    def _open(self, row: int) -> None:
        if row < len(self.outcomes) and not self.outcomes[row].error:
            self.opened.emit([self.outcomes[row].job.target])

    @Slot()
    def copy(self) -> None:
        """Put the table on the clipboard."""
        QGuiApplication.clipboard().setText("\n".join(batch.table(self.outcomes)) + "\n")
        self.dialog.said.setText("The table is on the clipboard, as Markdown.")
