"""Sessions: saving and opening everything, and recovering what an application that ended had not saved."""

from __future__ import annotations

import contextlib
import shutil
import time
import uuid
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from PySide6.QtCore import QLockFile, QObject, QTimer, Signal, Slot
from PySide6.QtWidgets import QFileDialog

from vtksmooth.errors import VtksmoothError
from vtksmooth.filters import FILTERS

from ..model import session, session_reader
from ..model.document import Document
from ..model.draft import Draft
from ..model.session import SUFFIX
from ..model.session_reader import Restored, Stored
from ..settings import Settings
from ..views import questions
from ..views.main_window import MainWindow
from ..views.questions import Answer
from .display import Display
from .files import Files, explain
from .filtering import Filtering
from .jobs import Context, Job, Jobs

#: How long to wait after a change until it is kept for recovery, milliseconds.
PAUSE = 1500
#: What users are told about saving before they lose something.
WHAT_SAVE_DOES = "Save keeps everything, with the history, in a session file."
#: The keys of the JSON that are the windows'.
_KNOWN = frozenset({"view", "filter", "section", "session"})


class Sessions(QObject):
    """The commands that save and open sessions; autosave; questions about what is not saved."""

    #: A session has been written.
    saved = Signal()
    #: A session is open, or cannot be opened.
    opened = Signal()
    #: What is not saved has been kept for recovery.
    kept = Signal()
    #: Whether there are unsaved changes may be another than before.
    changed = Signal()

    def __init__(
        self, document: Document, window: MainWindow, jobs: Jobs, settings: Settings, files: Files,
        filtering: Filtering, display: Display, draft: Draft,
    ) -> None:  # fmt: skip
        super().__init__(window)
        self._document, self._window, self._jobs, self._settings = document, window, jobs, settings
        self._files, self._filtering, self._display = files, filtering, display
        self._draft = draft
        #: The file that the session was opened from, or saved to.
        self.path: Path | None = None
        self._saved: tuple[Any, ...] | None = None
        self._view: dict[str, Any] = {}
        self._folder: Path | None = None
        self._lock: QLockFile | None = None
        #: What is being recovered, until it is open.
        self._recovered: tuple[Path, QLockFile] | None = None
        #: Meshes to open beside the session.
        self._further: list[Path] = []
        self._timer = QTimer(self, singleShot=True, interval=PAUSE)
        self._timer.timeout.connect(self._keep)
        document.changed.connect(self._document_changed)
        draft.changed.connect(self._document_changed)
        files.session_asked.connect(self.open)

    # -- what is not saved -------------------------------------------------------------------------

    @property
    def modified(self) -> bool:
        """Whether something would be lost: it is neither in the session's file nor in those of the meshes."""
        document = self._document
        if self.path is not None:
            return self._saved != document.content
        return bool(document.measurements) or any(layer.unsaved for layer in document.layers)

    def title(self) -> str:
        """Return the window's title."""
        layer, mark = self._document.active, " *" if self.modified else ""
        session_name = f" ({self.path.name})" if self.path is not None else ""
        if layer is None:
            return f"{self.path.name}{mark} - vtksmooth" if self.path is not None else "vtksmooth"
        return f"{layer.name}{mark}{session_name} - vtksmooth"

    def ask_unsaved(self, names: list[str], save: str) -> Answer:
        """Ask what to do with changes."""
        return questions.ask_unsaved(self._window, names, save)

    def may_lose(self, then: Callable[[], object]) -> bool:
        """Return whether nothing is lost, or may be; if it is to be saved, do that, and `then` after it."""
        if not self.modified:
            return True
        document = self._document
        names = [layer.name for layer in document.layers if layer.unsaved]
        if self.path is not None or not names:
            names = [self.path.name if self.path is not None else "Measurements"]
        answer = self.ask_unsaved(names, WHAT_SAVE_DOES)
        if answer is Answer.SAVE:
            job = self.save_session()
            if job is not None:
                job.done.connect(lambda _: QTimer.singleShot(0, then))
        return answer is Answer.DISCARD

    # -- saving ------------------------------------------------------------------------------------

    def save_session(self) -> Job | None:
        """Write the session to its file, or ask for one."""
        return self.save_session_as() if self.path is None else self.write(self.path)

    def save_session_as(self) -> Job | None:
        """Ask for a file and write the session to it."""
        layer = self._document.active
        name = self.path.name if self.path is not None else f"{layer.name if layer else 'session'}{SUFFIX}"
        beside = layer.path.parent if layer is not None and layer.path is not None else None
        folder = beside or Path(self._settings.get("folder", ""))
        chosen, _ = QFileDialog.getSaveFileName(
            self._window, "Save session", str(self.path or folder / name), f"Sessions (*{SUFFIX})"
        )
        if not chosen:
            return None
        path = Path(chosen)
        return self.write(path if path.suffix == SUFFIX else path.with_name(path.name + SUFFIX))

    def write(self, path: Path) -> Job:
        """Write the session."""
        snapshot, content = self._snapshot(), self._document.content

        def work(context: Context) -> Any:
            session.save(snapshot, path, lambda fraction: context.tell(fraction, f"writing {path.name}"))
            return path, content

        job = self._jobs.start("session", work)
        job.done.connect(self._written)
        job.failed.connect(self._failed)
        return job

    @Slot(object)
    def _written(self, result: Any) -> None:
        self.path, self._saved = result
        assert self.path is not None
        self._settings.add_recent(self.path)
        self._window.notification.say(f"Saved {self.path.name}.")
        self._document_changed()
        self.saved.emit()

    def _snapshot(self) -> session.Snapshot:
        window = self._window
        more = {
            "view": {**self._view, **self._display.look()},
            "filter": {
                "name": window.filters.filter.__name__,
                "parameters": window.filters.values(),
            },
            "section": window.action("section").isChecked(),
            "session": self.path,
        }
        return session.capture(self._document, more, self._draft.every)

    @Slot(object)
    def _failed(self, error: Exception) -> None:
        self._window.notification.say(explain(error), "error")
        self._end()

    def _end(self) -> None:
        """Be done with opening; what could not be recovered waits for the next start."""
        self._window.statusBar().clearMessage()
        if self._recovered is not None:
            self._recovered[1].unlock()
            self._recovered = None
        further, self._further = self._further, []
        self._files.open_paths(further)
        self.opened.emit()

    # -- opening -----------------------------------------------------------------------------------

    def open_session(self) -> None:
        """Ask for a session and open it."""
        name, _ = QFileDialog.getOpenFileName(
            self._window, "Open session", self._settings.get("folder", ""), f"Sessions (*{SUFFIX})"
        )
        if name:
            self.open(Path(name))

    @Slot(object, object)
    def open(self, path: Path, further: Sequence[Path] = ()) -> None:
        """Open a session in place of what is open, and after it further meshes."""
        if not self.may_lose(lambda: self.open(path, further)):
            return
        self._further = list(further)

        def work(context: Context) -> Stored:
            return session_reader.find(path)

        job = self._jobs.start("session", work)
        job.done.connect(self._found)
        job.failed.connect(self._failed)
        self._window.statusBar().showMessage(f"Opening {path.name} …")

    def ask_missing(self, path: Path) -> Path | None:
        """Ask where a mesh is; see :func:`~vtksmooth_gui.views.questions.ask_missing`."""
        return questions.ask_missing(self._window, path)

    @Slot(object)
    def _found(self, stored: Stored) -> None:
        """Ask for the meshes that are missing, then read everything."""
        located: dict[Path, Path | None] = {}
        try:
            for path in stored.missing:
                # What was moved was often moved together.
                beside = [found.parent / path.name for found in located.values() if found is not None]
                there = next((place for place in beside if place.is_file()), None)
                located[path] = there or self.ask_missing(path)
        except InterruptedError:
            self._end()
            return
        except VtksmoothError as error:
            self._failed(error)
            return

        def work(context: Context) -> tuple[Stored, Restored]:
            return stored, session_reader.restore(
                stored, located, lambda fraction: context.tell(fraction, "reading the session")
            )

        job = self._jobs.start("session", work)
        job.done.connect(self._show)
        job.failed.connect(self._failed)

    @Slot(object)
    def _show(self, result: tuple[Stored, Restored]) -> None:
        stored, restored = result
        recovered = stored.path.is_dir()
        more, window = restored.more, self._window
        self._jobs.cancel("apply")
        window.action("preview").setChecked(False)
        self._view = dict(more.get("view", {}))
        kept_for = more.get("session")
        self.path = stored.path if not recovered else stored.find(kept_for) if kept_for else None
        try:
            session_reader.apply(restored, self._document, _KNOWN)
            self._draft.restore(restored.drafts)
            self._set_filter(more.get("filter", {}))
            self._display.set_look(self._view)
            if bool(more.get("section", False)) != window.action("section").isChecked():
                window.action("section").trigger()
        except (AttributeError, KeyError, TypeError, ValueError) as error:
            # The meshes are there; how they were looked at is of another version, or damaged.
            restored.notes.append(f"Not everything of the view could be restored ({error}).")
        self._saved = None if recovered else self._document.content
        if not recovered:
            self._settings.add_recent(stored.path)
        if recovered:
            # From now on it is this window's own: what is there is kept there.
            self._throw_away()
            assert self._recovered is not None
            self._folder, self._lock = self._recovered
            self._recovered = None
        said = " ".join(restored.notes)
        name = "what was not saved" if recovered else stored.path.name
        window.notification.say(said or f"Opened {name}.", "warning" if said else "note")
        self._document_changed()
        self._end()

    def _set_filter(self, chosen: dict[str, Any]) -> None:
        for cls in FILTERS:
            if cls.__name__ == chosen.get("name"):
                self._window.filters.choose(cls)
                self._window.filters.set_values(chosen.get("parameters", {}))

    # -- recovery ----------------------------------------------------------------------------------

    def _document_changed(self) -> None:
        self.changed.emit()
        if not self._timer.isActive():
            self._timer.start()

    @Slot()
    def _keep(self) -> None:
        """Keep what is not saved, so that it can be recovered."""
        if self._jobs.busy("autosave"):
            self._timer.start()
            return
        if not self.modified:
            kept = self._give_up()
            if kept is not None:
                self._jobs.start("autosave", lambda context: _remove(*kept))
            return
        folder, snapshot = self._own_folder(), self._snapshot()
        job = self._jobs.start(
            "autosave", lambda context: session.update(snapshot, folder, lambda _: context.check())
        )
        job.done.connect(lambda _: self.kept.emit())
        job.failed.connect(self._not_kept)

    @Slot(object)
    def _not_kept(self, error: Exception) -> None:
        self._window.notification.say(f"Autosave failed, save yourself: {explain(error)}", "warning")

    def _own_folder(self) -> Path:
        """Return the folder that this window keeps in what is not saved; others leave it alone."""
        if self._folder is None:
            folder = self._settings.state_folder / "autosave" / uuid.uuid4().hex
            folder.mkdir(parents=True)
            lock = _lock(folder)
            lock.tryLock(0)
            self._folder, self._lock = folder, lock
        return self._folder

    def ask_recovery(self, name: str, when: str) -> Answer:
        """Ask whether to recover; see :func:`~vtksmooth_gui.views.questions.ask_recovery`."""
        return questions.ask_recovery(self._window, name, when)

    def offer_recovery(self, further: Sequence[Path] = ()) -> None:
        """Offer what windows that ended unexpectedly had kept, the latest first; then open further meshes."""
        place = self._settings.state_folder / "autosave"
        found = []
        for folder in place.iterdir() if place.is_dir() else ():
            lock = _lock(folder)
            if folder.is_dir() and lock.tryLock(0):
                found.append((folder, lock))
        for folder, lock in sorted(found, key=lambda one: -_time_of(one[0])):
            try:
                stored = session_reader.find(folder)
                name = stored.name
            except VtksmoothError:  # it ended before the first was complete
                _remove(folder, lock)
                continue
            if self._recovered is not None:  # the others wait for the next start
                lock.unlock()
                continue
            when = time.strftime("%Y-%m-%d %H:%M", time.localtime(_time_of(folder)))
            answer = self.ask_recovery(name, when)
            if answer is Answer.DISCARD:
                _remove(folder, lock)
            elif answer is Answer.SAVE:
                self._recovered, self._further = (folder, lock), list(further)
                self._found(stored)
            else:
                lock.unlock()
        if self._recovered is None:
            self._files.open_paths(further)

    def _give_up(self) -> tuple[Path, QLockFile] | None:
        """Have no folder any more: everything is saved, or need not be. Return what is to be removed."""
        folder, lock = self._folder, self._lock
        self._folder = self._lock = None
        return None if folder is None or lock is None else (folder, lock)

    def _throw_away(self) -> None:
        """Remove what was kept for recovery."""
        kept = self._give_up()
        if kept is not None:
            _remove(*kept)

    def close(self) -> None:
        """End: nothing is to be recovered. To be called when no job runs any more."""
        self._timer.stop()
        self._throw_away()


def _lock(folder: Path) -> QLockFile:
    lock = QLockFile(str(folder / "lock"))
    lock.setStaleLockTime(0)  # it is stale when its process has ended, not after a time
    return lock


def _time_of(folder: Path) -> float:
    with contextlib.suppress(OSError):
        return (folder / "session.json").stat().st_mtime
    return 0.0


def _remove(folder: Path, lock: QLockFile) -> None:
    # First what makes it a session: whatever is left is swept up at the next start.
    (folder / "session.json").unlink(missing_ok=True)
    lock.unlock()
    shutil.rmtree(folder, ignore_errors=True)
