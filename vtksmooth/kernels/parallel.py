"""Running a kernel over ranges of vertices on several threads.

Kernels release the interpreter lock, so plain Python threads serve: no threading layer of numba's is
involved, whose default one aborts the process when two Python threads enter it. Which thread takes
which range never matters to a result; the ranges themselves do not depend on the number of threads.
"""

from __future__ import annotations

import itertools
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, wait
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import ParameterError

Int64 = npt.NDArray[np.int64]

#: Below this many vertices handing work to threads costs more than it saves.
SMALLEST_SHARE = 20_000

_threads = 0
_pool: ThreadPoolExecutor | None = None


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
    global _threads, _pool
    if threads < 0:
        raise ParameterError(f"The number of threads must be 0 (all) or more, not {threads}.")
    _threads = threads
    _pool = None


def _executor(threads: int) -> ThreadPoolExecutor:
    global _pool
    if _pool is None or _pool._max_workers != threads:
        _pool = ThreadPoolExecutor(threads, thread_name_prefix="vtksmooth")
    return _pool


def ranges(n: int, size: int = 4096) -> tuple[Int64, Int64]:
    """Cut 0..n into ranges of `size`; return their starts and ends, int64."""
    starts = np.arange(0, n, size, dtype=np.int64)
    return starts, np.minimum(starts + size, n)


def run(
    kernel: Callable[..., Any], starts: Int64, ends: Int64, *arguments: Any, smallest_share: int | None = None
) -> list[Any]:
    """Call ``kernel(starts, ends, *arguments)`` for shares of the ranges, on all threads.

    The kernel must write only to places that belong to its ranges. What the calls return comes back
    as a list. Kernels that do much for each vertex gain from threads with fewer of them: they say so by
    `smallest_share`.
    """
    smallest = SMALLEST_SHARE if smallest_share is None else min(smallest_share, SMALLEST_SHARE)
    threads = number_of_threads()
    total = int((ends - starts).sum())
    if threads < 2 or len(starts) < 2 or total < 2 * smallest:
        return [kernel(starts, ends, *arguments)]
    # Every thread has a part of its own, the same in every run: what it wrote last time is in its cache.
    # Who is ready takes from the others: a thread that wakes late, or is held up, holds up nobody. Shares
    # get smaller towards the end of a part, so that all threads end together.
    bounds, firsts = [0], []
    for thread in range(threads):
        firsts.append(len(bounds) - 1)
        end = (thread + 1) * len(starts) // threads
        while bounds[-1] < end:
            bounds.append(bounds[-1] + (end - bounds[-1] + 1) // 2)
    shares = dict(enumerate(itertools.pairwise(bounds)))
    count = len(shares)
    results: list[Any] = [None] * count

    def work(first: int) -> None:
        for number in itertools.chain(range(first, count), range(first)):
            share = shares.pop(number, None)
            if share is not None:
                results[number] = kernel(starts[slice(*share)], ends[slice(*share)], *arguments)

    executor = _executor(threads - 1)
    helpers = [executor.submit(work, first) for first in firsts[1:]]
    try:
        work(0)
    finally:  # whoever has begun must end before anybody else uses the arrays
        begun = [helper for helper in helpers if not helper.cancel()]
        wait(begun)
    for helper in begun:
        helper.result()
    return results
