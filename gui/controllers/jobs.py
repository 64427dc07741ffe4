"""Jobs: work in worker threads, with progress and cancelling.

A job owns its pipeline: it makes its filters, runs them on meshes of its own and hands over what comes
out. Windows are only touched in their own thread, by signals.
"""

from __future__ import annotations

import contextlib
import threading
import time
from collections import deque
from collections.abc import Callable
from functools import partial
from typing import Any

from PySide6.QtCore import QObject, Qt, QThreadPool, QTimer, Signal, Slot

from vtksmooth.errors import Cancelled
from vtksmooth.jit.compiled import on_compile

#: What a job does: it is given its context and returns its result.
Work = Callable[["Context"], Any]

#: How often progress is shown, milliseconds.
_PROGRESS_INTERVAL = 30


class Context:
    """A job as its worker sees it: it runs filters, tells its progress, and learns that it was cancelled.

    The worker has nothing of Qt's in its hands: who lets go of an object last destroys it, and Qt's must
    be destroyed in the thread of the windows.

    Attributes
    ----------
    cancelled : bool
    told : tuple of float and str, or None
        The progress that was told last; who shows it takes it away.
    parts : collections.deque
        What was sent and not taken yet.
    outcome : tuple of (object, BaseException or None), or None
        What the work returned and what it raised, once it has ended.
    ended_at : float
        When the work ended, seconds of time.perf_counter: for measurements.
    """

    def __init__(self, wake: Callable[[], None]) -> None:
        self._wake = wake
        self._part = (0.0, 1.0, "")
        self._lock = threading.Lock()
        self._running: Any = None
        self.cancelled = False
        self.told: tuple[float, str] | None = None
        self.parts: deque[Any] = deque()
        self.outcome: tuple[Any, BaseException | None] | None = None
        self.ended_at = 0.0

    def do(self, work: Work) -> None:
        """Do the work, in a thread of the pool."""
        try:
            self.check()
            with on_compile(self._compiling):
                result = work(self)
        except BaseException as error:  # whatever happens in a worker is told in the window
            # What was cancelled has nothing to tell: its frames would keep the meshes they worked on.
            self._end(None, error.with_traceback(None) if isinstance(error, Cancelled) else error)
        else:
            self._end(result, None)

    def _compiling(self, name: str) -> None:
        self.told = 0.0, f"compiling {name}, once per installation"

    def _end(self, result: Any, error: BaseException | None) -> None:
        self.ended_at = time.perf_counter()
        self.outcome = result, error
        self._wake()

    def send(self, part: Any) -> None:
        """Hand over a part of the result before the work is done."""
        self.parts.append(part)
        self._wake()

    def run(self, algorithm: Any, *meshes: Any) -> Any:
        """Run a filter of ours on `meshes`, and return the filter."""
        observer = algorithm.AddObserver(
            "ProgressEvent",
            lambda *_: self._tell(algorithm.GetProgress(), algorithm.GetProgressText() or ""),
        )
        with self._lock:
            self.check()
            self._running = algorithm
        try:
            algorithm(*meshes)
        finally:
            with self._lock:
                self._running = None
            algorithm.RemoveObserver(observer)
        return algorithm

    def part(self, number: int, count: int, what: str = "") -> None:
        """Say that what comes next is one of `count` equal parts; `what` is said before its progress."""
        self._part = (number / count, 1.0 / count, what)
        self.tell(0.0, "")

    def _tell(self, fraction: float, what: str) -> None:
        begin, share, before = self._part
        self.told = begin + share * fraction, ": ".join(words for words in (before, what) if words)

    def check(self) -> None:
        """Raise Cancelled if the job was cancelled."""
        if self.cancelled:
            raise Cancelled("cancelled")

    def tell(self, fraction: float, what: str) -> None:
        """Tell the progress, 0 to 1."""
        self.check()
        self._tell(fraction, what)

    def cancel(self) -> None:
        """Ask the job to stop."""
        with self._lock:
            self.cancelled = True
            if self._running is not None:
                self._running.SetAbortExecute(1)


class Job(QObject):
    """One piece of work, as the windows see it.

    Exactly one of `done`, `failed` and `stopped` is emitted; after :meth:`cancel` it is `stopped`, at
    once: the worker ends as soon as it can, and nobody waits for it.
    """

    progressed = Signal(float, str)
    #: A part of the result.
    sent = Signal(object)
    done = Signal(object)
    failed = Signal(object)
    stopped = Signal()
    #: The work has ended, after a cancel some time later than `stopped`.
    ended = Signal(object)

    def __init__(self, context: Context) -> None:
        super().__init__()
        self.context = context
        self.over = False

    def cancel(self) -> None:
        """Stop: the result is not wanted any more."""
        self.context.cancel()
        if not self.over:
            self.over = True
            self.stopped.emit()

    def show(self, progress: bool = True) -> None:
        """Hand on what was sent, and what came out in the end; with `progress`, what was told last too."""
        context, told = self.context, None
        ended = context.outcome is not None  # asked first: all that was told and sent came before
        if progress or ended:
            told, context.told = context.told, None
        while context.parts:  # sent before it was told
            part = context.parts.popleft()
            if not self.over:
                self.sent.emit(part)
        if told is not None and not self.over:
            self.progressed.emit(*told)
        if ended and context.outcome is not None:  # who was told of a part may have let events through
            outcome, context.outcome = context.outcome, None
            self._end(*outcome)

    def _end(self, result: Any, error: BaseException | None) -> None:
        wanted, self.over = not self.over, True
        if wanted and isinstance(error, Cancelled):
            self.stopped.emit()
        elif wanted and error is not None:
            self.failed.emit(error)
        elif wanted:
            self.done.emit(result)
        self.ended.emit(self)


class Jobs(QObject):
    """All jobs of a window, in lanes: a new job of a lane takes the place of the one before it.

    Lanes do not wait for each other.
    """

    #: A lane has begun or ended to be busy.
    changed = Signal()

    #: A worker has something to hand over.
    _woken = Signal()

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._pool = QThreadPool(self)
        self._pool.setMaxThreadCount(6)
        self._lanes: dict[str, Job] = {}
        self._kept: set[Job] = set()
        # Asked for, not sent: Qt deals with all events that wait before it looks at its timers or at the
        # mouse, and where each took longer than the next took to come, the window would stand still.
        self._progress = QTimer(self, interval=_PROGRESS_INTERVAL)
        self._progress.timeout.connect(self._show_progress)
        self._woken.connect(self._show, Qt.ConnectionType.QueuedConnection)

    def start(self, lane: str, work: Work) -> Job:
        """Cancel what runs in `lane`, and return a job that begins once the caller returns."""
        self.cancel(lane)
        job = Job(Context(self._wake))
        self._lanes[lane] = job
        for signal in (job.done, job.failed, job.stopped):
            signal.connect(self._tidy)
        job.ended.connect(self._release)
        # A job lives until its work has ended, wanted or not.
        self._kept.add(job)
        self._progress.start()
        # Of a QRunnable the pool would keep the Python side for good.
        self._pool.start(partial(job.context.do, work))
        self.changed.emit()
        return job

    def busy(self, lane: str) -> bool:
        """Return whether a job of `lane` is under way."""
        return lane in self._lanes and not self._lanes[lane].over

    def job(self, lane: str) -> Job | None:
        """Return the job of `lane`, until its thread has ended or it is cancelled."""
        return self._lanes.get(lane)

    def move(self, lane: str, other: str) -> Job | None:
        """Let what runs in `lane` go on in `other`, and return it; None where nothing runs."""
        if not self.busy(lane):
            return None
        self.cancel(other)
        self._lanes[other] = self._lanes.pop(lane)
        self.changed.emit()
        return self._lanes[other]

    def cancel(self, lane: str) -> None:
        """Cancel the job of `lane`, if there is one."""
        job = self._lanes.pop(lane, None)
        if job is not None and not job.over:
            job.cancel()

    @property
    def idle(self) -> bool:
        """Whether nothing is under way, not even what nobody waits for."""
        return not self._kept and all(job.over for job in self._lanes.values())

    def close(self) -> None:
        """Cancel everything and wait until the threads have ended."""
        for lane in list(self._lanes):
            self.cancel(lane)
        for job in self._kept:
            job.context.cancel()
        self._pool.waitForDone()

    def _wake(self) -> None:
        """Have a look at the jobs, soon; called from a worker, which :meth:`close` waits for."""
        with contextlib.suppress(RuntimeError):  # the application is gone
            self._woken.emit()

    @Slot()
    def _tidy(self) -> None:
        self.changed.emit()

    @Slot()
    def _show(self) -> None:
        for job in [*self._kept]:
            job.show(progress=False)

    @Slot()
    def _show_progress(self) -> None:
        for job in [*self._kept]:
            job.show()
        if not self._kept:
            self._progress.stop()

    @Slot(object)
    def _release(self, job: Job) -> None:
        self._kept.discard(job)
        # What it worked on is in its hands: nothing may hold it.
        self._lanes = {lane: other for lane, other in self._lanes.items() if other is not job}
