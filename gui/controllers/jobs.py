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
from vtksmooth.kernels.compiled import on_compile

#: What a job does: it is given its context and returns its result.
Work = Callable[["Context"], Any]

#: How often progress is shown, milliseconds.
_PROGRESS_INTERVAL = 30


class Context:
    """What a job may do: run filters, tell its progress, learn that it was cancelled.

    Attributes
    ----------
    send : callable
        Hands over a part of the result before the job is done.
    cancelled : bool
    """

    def __init__(self, tell: Callable[[float, str], None], send: Callable[[Any], None]) -> None:
        self._told = tell
        self.send = send
        self._part = (0.0, 1.0, "")
        self._lock = threading.Lock()
        self._running: Any = None
        self.cancelled = False

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
        self._told(begin + share * fraction, ": ".join(words for words in (before, what) if words))

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
    """One piece of work.

    Exactly one of `done`, `failed` and `stopped` is emitted, in the thread of the windows; after
    :meth:`cancel` it is `stopped`, at once: the worker ends as soon as it can, and nobody waits for it.
    """

    progressed = Signal(float, str)
    #: A part of the result.
    sent = Signal(object)
    done = Signal(object)
    failed = Signal(object)
    stopped = Signal()
    #: The thread has ended, after a cancel some time later than `stopped`.
    ended = Signal(object)

    _sent = Signal()
    _ended = Signal(object, object)

    def __init__(self, work: Work) -> None:
        super().__init__()
        self.work = work
        self.context = Context(self.tell, self.send)
        self._told: tuple[float, str] | None = None
        self._parts: deque[Any] = deque()
        self.over = False
        #: When the work ended, seconds of time.perf_counter: for measurements.
        self.stopped_at = 0.0
        self._sent.connect(self._receive, Qt.ConnectionType.QueuedConnection)
        self._ended.connect(self._end, Qt.ConnectionType.QueuedConnection)

    def cancel(self) -> None:
        """Stop: the result is not wanted any more."""
        self.context.cancel()
        if not self.over:
            self.over = True
            self.stopped.emit()

    def tell(self, fraction: float, what: str) -> None:
        """Tell the progress, from the worker's thread."""
        self._told = (fraction, what)

    def send(self, part: Any) -> None:
        """Send a part of the result, from the worker's thread."""
        self._parts.append(part)
        self._sent.emit()

    def show_progress(self) -> None:
        """Hand on what has been told last, after what was sent before it."""
        told, self._told = self._told, None
        self._receive()
        if told is not None and not self.over:
            self.progressed.emit(*told)

    @Slot()
    def _receive(self) -> None:
        while self._parts:
            part = self._parts.popleft()
            if not self.over:
                self.sent.emit(part)

    @Slot(object, object)
    def _end(self, result: Any, error: BaseException | None) -> None:
        self.show_progress()
        wanted, self.over = not self.over, True
        if wanted and isinstance(error, Cancelled):
            self.stopped.emit()
        elif wanted and error is not None:
            self.failed.emit(error)
        elif wanted:
            self.done.emit(result)
        self.ended.emit(self)


def _run(job: Job) -> None:
    """Do the work of a job, in a thread of the pool."""
    result = error = None
    try:
        job.context.check()
        with on_compile(lambda name: job.tell(0.0, f"compiling {name}, once per installation")):
            result = job.work(job.context)
    except BaseException as raised:  # whatever happens in a worker is told in the window
        error = raised
    job.stopped_at = time.perf_counter()
    with contextlib.suppress(RuntimeError):  # the application is gone
        job._ended.emit(result, error)


class Jobs(QObject):
    """All jobs of a window, in lanes: a new job of a lane takes the place of the one before it.

    Lanes do not wait for each other.
    """

    #: A lane has begun or ended to be busy.
    changed = Signal()

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

    def start(self, lane: str, work: Work) -> Job:
        """Cancel what runs in `lane`, and return a job that begins once the caller returns."""
        self.cancel(lane)
        job = Job(work)
        self._lanes[lane] = job
        for signal in (job.done, job.failed, job.stopped):
            signal.connect(self._tidy)
        job.ended.connect(self._release)
        # A job lives until its thread has ended, wanted or not.
        self._kept.add(job)
        self._progress.start()
        self._pool.start(partial(_run, job))  # of a QRunnable the pool would keep the Python side for good
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

    @Slot()
    def _tidy(self) -> None:
        self.changed.emit()

    @Slot()
    def _show_progress(self) -> None:
        for job in [*self._kept]:
            job.show_progress()
        if not self._kept:
            self._progress.stop()

    @Slot(object)
    def _release(self, job: Job) -> None:
        self._kept.discard(job)
        # What it worked on is in its hands: nothing may hold it.
        self._lanes = {lane: other for lane, other in self._lanes.items() if other is not job}
