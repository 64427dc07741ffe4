"""A kernel over ranges, on several threads: everything once, nothing swallowed, nobody waits for ever."""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from vtksmooth.errors import ParameterError
from vtksmooth.jit import parallel


@pytest.fixture(autouse=True)
def default_threads():
    yield
    parallel.set_number_of_threads(0)


def count(starts, ends, times):
    """What a kernel does that visits its ranges; in Python, so that threads get in each other's way."""
    for start, end in zip(starts, ends, strict=True):
        times[start:end] += 1
    return int((ends - starts).sum())


@pytest.mark.parametrize("threads", [1, 2, 3, 7])
@pytest.mark.parametrize("n", [0, 1, 16, 17, 1000])
def test_every_range_is_visited_once(threads, n):
    parallel.set_number_of_threads(threads)
    times = np.zeros(n, int)
    counts = parallel.run(count, *parallel.ranges(n, 16), times, smallest_share=1)
    assert (times == 1).all()
    assert sum(counts) == n


def test_results_come_in_the_order_of_the_ranges():
    parallel.set_number_of_threads(3)
    firsts = parallel.run(lambda starts, ends: starts[0], *parallel.ranges(1000, 8), smallest_share=1)
    assert firsts == sorted(firsts)


def test_few_vertices_stay_on_the_calling_thread():
    parallel.set_number_of_threads(4)
    seen = parallel.run(lambda starts, ends: threading.get_ident(), *parallel.ranges(10_000, 16))
    assert seen == [threading.get_ident()]


@pytest.mark.parametrize("bad", [0, 5, 61])
def test_an_error_on_any_thread_is_raised_and_the_next_run_works(bad):
    parallel.set_number_of_threads(3)

    def kernel(starts, ends):
        if (starts == 16 * bad).any():
            raise ValueError("this range")

    ranges = parallel.ranges(1000, 16)
    with pytest.raises(ValueError, match="this range"):
        parallel.run(kernel, *ranges, smallest_share=1)
    times = np.zeros(1000, int)
    parallel.run(count, *ranges, times, smallest_share=1)
    assert (times == 1).all()


def test_a_run_within_a_run_and_runs_from_several_threads_end():
    parallel.set_number_of_threads(2)
    ranges = parallel.ranges(200, 8)

    def outer(starts, ends):
        return sum(parallel.run(lambda a, b: int((b - a).sum()), *ranges, smallest_share=1))

    with ThreadPoolExecutor(4) as callers:
        runs = [callers.submit(parallel.run, outer, *ranges, smallest_share=1) for _ in range(8)]
        for run in runs:
            assert set(run.result(timeout=60)) == {200}


def test_the_number_of_threads_is_what_was_asked(monkeypatch):
    parallel.set_number_of_threads(3)
    assert parallel.number_of_threads() == 3
    parallel.set_number_of_threads(0)
    monkeypatch.setenv("VTKSMOOTH_THREADS", "5")
    assert parallel.number_of_threads() == 5
    monkeypatch.setenv("VTKSMOOTH_THREADS", "many")
    assert parallel.number_of_threads() >= 1
    with pytest.raises(ParameterError, match="threads"):
        parallel.set_number_of_threads(-1)


def test_ranges_do_not_depend_on_threads_and_cover_everything():
    starts, ends = parallel.ranges(10_000, 4096)
    assert starts.tolist() == [0, 4096, 8192]
    assert ends.tolist() == [4096, 8192, 10_000]
    assert len(parallel.ranges(0)[0]) == 0
