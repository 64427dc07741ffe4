"""Running a kernel over ranges of vertices on several threads.

Kernels release the interpreter lock, so plain Python threads serve: no threading layer of numba's is
involved, whose default one aborts the process when two Python threads enter it. Which thread takes
which range never matters to a result; the ranges themselves do not depend on the number of threads.
"""

from __future__ import annotations

import functools
import itertools
import os
import threading
from collections.abc import Callable
from queue import SimpleQueue
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import ParameterError

Int64 = npt.NDArray[np.int64]

#: Below this many vertices for each thread handing work over costs more than it saves: where a vertex takes
#: some ten nanoseconds, and where it takes hundreds.
SMALLEST_SHARE, COSTLY = 20_000, 300

_threads = 0
_helpers: list[threading.Thread] = []
_tasks: SimpleQueue[Callable[[], None]] = SimpleQueue()


def number_of_threads() -> int:
    """Return how many threads kernels run on.

    What :func:`set_number_of_threads` or the environment variable VTKSMOOTH_THREADS says, otherwise the
    processors that this process may use.
    """
    if _threads:
        return _threads
    asked = os.environ.get("VTKSMOOTH_THREADS", "")
    if asked.isdigit() and int(asked) > 0:
        return int(asked)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def set_number_of_threads(threads: int) -> None:
    """Set the number of threads for this process; 0 goes back to the default. Results do not depend on it."""
    global _threads
    if threads < 0:
        raise ParameterError(f"The number of threads must be 0 (all) or more, not {threads}.")
    _threads = threads


def _serve() -> None:
    while True:
        _tasks.get()()


def _ask(task: Callable[[], None], helpers: int) -> None:
    # Helpers are daemons: idle ones hold up nobody's exit, and run() leaves none at work.
    while len(_helpers) < helpers:
        helper = threading.Thread(target=_serve, name=f"vtksmooth-{len(_helpers) + 1}", daemon=True)
        try:
            helper.start()
        except RuntimeError:  # no more threads in this process, or it ends: those that are there do it all
            break
        _helpers.append(helper)
    for _ in range(min(helpers, len(_helpers))):
        _tasks.put(task)


def _begin_anew() -> None:
    """Forget the helpers: a forked process has none of its parent's threads, and nobody takes their tasks."""
    global _tasks
    _helpers.clear()
    _tasks = SimpleQueue()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_begin_anew)


@functools.lru_cache
def _shares(count: int, threads: int) -> tuple[list[int], list[slice]]:
    """Cut `count` ranges into shares; return each thread's first one, and all.

    Every thread has a part of its own, the same in every run: what it wrote last time is in its cache.
    Who is ready takes from the others: a thread that wakes late, or is held up, holds up nobody. Shares
    get smaller towards the end of a part, so that all threads end together.
    """
    firsts: list[int] = []
    shares: list[slice] = []
    begin = 0
    for thread in range(threads):
        firsts.append(len(shares))
        end = (thread + 1) * count // threads
        while begin < end:
            size = (2 * (end - begin) + 2) // 3
            shares.append(slice(begin, begin + size))
            begin += size
    return firsts, shares


def ranges(n: int, size: int = 1024) -> tuple[Int64, Int64]:
    """Cut 0..n into ranges of `size`; return their starts and ends, int64."""
    starts = np.arange(0, n, size, dtype=np.int64)
    return starts, np.minimum(starts + size, n)


def run(
    kernel: Callable[..., Any], starts: Int64, ends: Int64, *arguments: Any, smallest_share: int | None = None
) -> list[Any]:
    """Call ``kernel(starts, ends, *arguments)`` for shares of the ranges, on all threads.

    The ranges must rise, and the kernel must write only to places that belong to its ranges. What the calls
    return comes back as a list. Kernels that do much for each vertex gain from threads with fewer of them:
    for them `smallest_share` is :data:`COSTLY`.
    """
    smallest = SMALLEST_SHARE if smallest_share is None else min(smallest_share, SMALLEST_SHARE)
    # Where the mesh is small nothing needs to be counted: that takes a tenth of a quick kernel's time.
    few = len(starts) < 2 or ends[-1] - starts[0] < 2 * smallest or int((ends - starts).sum()) < 2 * smallest
    threads = 1 if few else number_of_threads()
    if threads < 2:
        return [kernel(starts, ends, *arguments)]
    firsts, cut = _shares(len(starts), threads)
    shares = dict(enumerate(cut))
    results: list[Any] = [None] * len(shares)
    idle = list(firsts[1:])
    ended: SimpleQueue[BaseException | None] = SimpleQueue()

    def work(first: int) -> None:
        for number in itertools.chain(range(first, len(results)), range(first)):
            share = shares.pop(number, None)
            if share is None:
                continue
            try:
                results[number] = kernel(starts[share], ends[share], *arguments)
            except BaseException as error:  # raised below, in the thread of the caller
                ended.put(error)
            else:
                ended.put(None)

    # A helper that comes when all is taken finds nothing to do, and is not waited for.
    _ask(lambda: work(idle.pop()), threads - 1)
    work(0)
    errors = [ended.get() for _ in results]  # whoever has begun must end before anybody else uses the arrays
    for error in filter(None, errors):
        raise error
    return results
