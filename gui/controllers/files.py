"""Opening and saving, in worker threads."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import Any
from weakref import WeakKeyDictionary

from PySide6.QtCore import QObject, Signal, Slot
from PySide6.QtWidgets import QFileDialog

from vtksmooth.errors import Cancelled, VtksmoothError
from vtksmooth.files import READABLE, WRITABLE, atomic, check_writable, read_surface, write_surface
from vtksmooth.files.vtk_process import prepare

from ..model.document import Document
from ..model.layer import Layer
from ..model.session import SUFFIX
from ..model.state import State
from ..settings import Settings
from ..views import questions
from ..views.main_window import MainWindow
from .jobs import Context, Jobs

#: What is done after a layer has been written.
Then = Callable[[], object]


def explain(error: Exception) -> str:
    """Return what went wrong as a sentence for a notification."""
    text = " ".join(str(error).split()).rstrip(".")
    if isinstance(error, VtksmoothError):
        return f"{text}."
    if isinstance(error, MemoryError):
        return "Out of memory; close layers, lower the memory of the history, or use a smaller mesh."
    return f"Unexpected {type(error).__name__}: {text}. Please report it, with what Help > About shows."


class _Losses(Exception):
    """A file would not hold everything: what it would not, as sentences."""


class Files(QObject):
    """The commands of the menu File that read and write meshes."""

    #: Files have been read, or could not be: the layers that came of them.
    opened = Signal(list)
    #: A session shall be opened, and meshes after it: their paths.
    session_asked = Signal(object, object)
    #: A recipe shall be opened: its path.
    recipe_asked = Signal(object)
    #: A layer has been written.
    saved = Signal(object)

    def __init__(self, document: Document, window: MainWindow, jobs: Jobs, settings: Settings) -> None:
        super().__init__(window)
        self._document, self._window, self._jobs, self._settings = document, window, jobs, settings
        self._numbers = itertools.count()
        #: What layers have lost in their files, with the user's consent.
        self._accepted: WeakKeyDictionary[Layer, list[str]] = WeakKeyDictionary()
        window.dropped.connect(self.open_paths)
        window.menus["File"].aboutToShow.connect(self._list_recent)

    # -- opening -----------------------------------------------------------------------------------

    def open(self) -> None:
        """Ask for files and open them."""
        prepare()
        patterns = " ".join(f"*{extension}" for extension in READABLE)
        paths, _ = QFileDialog.getOpenFileNames(
            self._window,
            "Open meshes",
            self._settings.get("folder", ""),
            f"Meshes and sessions ({patterns} *{SUFFIX});;All files (*)",
        )
        self.open_paths(paths)

    @Slot(list)
    def open_paths(self, names: Iterable[str | Path]) -> None:
        """Open files, meshes each as a layer; a session takes the place of what is open.

        A recipe takes the place of the active layer's.
        """
        paths = [Path(name) for name in names]
        recipes = [path for path in paths if path.suffix.lower() == ".json"]
        if recipes:
            self.recipe_asked.emit(recipes[-1])
        sessions = [path for path in paths if path.suffix.lower() == SUFFIX]
        paths = [path for path in paths if path not in (*recipes, *sessions)]
        if sessions:
            self.session_asked.emit(sessions[-1], paths)
            return
        if not paths:
            return

        def read(context: Context) -> list[tuple[Path, Any]]:
            found: list[tuple[Path, Any]] = []
            for number, path in enumerate(paths):
                context.tell(number / len(paths), f"reading {path.name}")
                try:
                    mesh, notes = read_surface(path, lambda: context.cancelled)
                    found.append((path, (State.of(mesh), notes)))
                except Cancelled:
                    raise
                except Exception as error:
                    found.append((path, error))
            return found

        job = self._jobs.start(f"open {next(self._numbers)}", read)
        job.done.connect(self._read)
        job.failed.connect(self._failed)
        self._window.statusBar().showMessage(f"Reading {', '.join(path.name for path in paths)} …")

    @Slot(object)
    def _read(self, found: list[tuple[Path, Any]]) -> None:
        self._window.statusBar().clearMessage()
        said, wrong, layers = [], [], []
        for path, result in found:
            if isinstance(result, Exception):
                wrong.append(explain(result))
                self._settings.remove_recent(path)
                continue
            state, notes = result
            layers.append(self._document.open(state, path))
            self._settings.add_recent(path)
            self._settings.set("folder", str(path.resolve().parent))
            said += notes
        if layers:
            self._document.activate(layers[0])  # a skin and the space for it are named in that order
        if wrong:
            self._window.notification.say(" ".join(wrong), "error")
        elif said:
            self._window.notification.say(" ".join(said))
        elif len(self._document.layers) > 1:
            self._window.notification.say(
                "Several layers are open. What each is for (mesh, reference, installation space) is chosen "
                "in the list of layers."
            )
        self.opened.emit(layers)

    def _list_recent(self) -> None:
        menu = self._window.recent
        menu.clear()
        for name in self._settings.recent:
            menu.addAction(name).triggered.connect(partial(self._open_again, name))
        menu.setEnabled(bool(self._settings.recent))

    def _open_again(self, name: str, *_: Any) -> None:
        self.open_paths([name])

    # -- saving ------------------------------------------------------------------------------------

    def save(self, then: Then | None = None) -> None:
        """Write the active layer to its file; at first, ask for one: what was opened stays as it is.

        `then` is called when it has been written.
        """
        layer = self._document.active
        if layer is None:
            return
        untouched = layer.path == layer.source and layer.saved is layer.opened
        if layer.path is None or untouched or layer.path.suffix.lower() not in WRITABLE:
            self.save_as(then)
        else:
            self.write(layer, layer.path, then)

    def save_as(self, then: Then | None = None) -> None:
        """Ask for a file and write the active layer to it."""
        layer = self._document.active
        if layer is None:
            return
        start = layer.path or Path(self._settings.get("folder", "")) / f"{layer.name}.vtp"
        if start == layer.source:
            start = start.with_stem(f"{start.stem}_smoothed")
        if start.suffix.lower() not in WRITABLE:
            start = start.with_suffix(".vtp")
        patterns = ";;".join(f"{extension[1:].upper()} (*{extension})" for extension in WRITABLE)
        name, _ = QFileDialog.getSaveFileName(
            self._window,
            f"Save {layer.name}",
            str(start),
            f"All formats (*{' *'.join(WRITABLE)});;{patterns}",
        )
        if name:
            path = Path(name)
            self.write(layer, path if path.suffix else path.with_suffix(start.suffix), then)

    def write(self, layer: Layer, path: Path, then: Then | None = None, accepted: Sequence[str] = ()) -> None:
        """Write a layer as it is now, once the user has accepted what the format drops."""
        state = layer.state
        assert state is not None
        known = {*accepted, *self._accepted.get(layer, ())}

        def write(context: Context) -> Any:
            check_writable(path)
            with atomic(path) as temporary:
                notes = write_surface(state.input(), temporary)
                notes = [note.replace(f"{temporary.name}: ", "", 1) for note in notes]
                if not known.issuperset(notes):
                    raise _Losses(notes)
            return layer, state, path, notes

        job = self._jobs.start(f"save {path}", write)
        job.done.connect(self._written)
        if then is not None:
            job.done.connect(lambda _: then())
        job.failed.connect(lambda error: self._not_written(layer, path, then, error))

    def ask_losses(self, name: str, notes: Sequence[str]) -> bool:
        """Ask whether to write a file that does not hold everything."""
        return questions.ask_losses(self._window, name, notes)

    @Slot(object)
    def _written(self, result: Any) -> None:
        layer, state, path, notes = result
        self._accepted[layer] = notes
        self._document.set_saved(layer, state, path)
        self._settings.add_recent(path)
        lost = " " + " ".join(notes) if notes else ""
        self._window.notification.say(f"Saved {path.name}.{lost}", "warning" if notes else "note")
        self.saved.emit(layer)

    def _not_written(self, layer: Layer, path: Path, then: Then | None, error: Exception) -> None:
        if not isinstance(error, _Losses):
            self._failed(error)
        elif layer.state is not None and self.ask_losses(path.name, error.args[0]):
            self.write(layer, path, then, error.args[0])

    @Slot(object)
    def _failed(self, error: Exception) -> None:
        self._window.statusBar().clearMessage()
        self._window.notification.say(explain(error), "error")
