"""What one process compiles, no other compiles at the same time."""

import numba
import pytest
from filelock import FileLock

from vtksmooth.jit import compiled
from vtksmooth.jit.caching import BusyError, KernelCache


def triple(x):
    return 3.0 * x


@pytest.fixture
def kernel(tmp_path, monkeypatch):
    monkeypatch.setattr(compiled, "_cache_folder", lambda source: tmp_path)
    return compiled.kernel(triple)


def misses(kernel):
    return sum(kernel.stats.cache_misses.values())


def free(kernel):
    lock = FileLock(kernel._cache.path)
    lock.acquire(timeout=0.0)
    lock.release()


def test_it_is_locked_until_it_is_kept(kernel):
    assert kernel(2.0) == 6.0
    assert misses(kernel) == 1
    free(kernel)
    other = compiled.kernel(triple)
    assert other(2.0) == 6.0
    assert misses(other) == 0
    free(kernel)


def test_who_does_not_wait_is_told(kernel, monkeypatch):
    monkeypatch.setattr(KernelCache, "waits", False)
    with FileLock(kernel._cache.path), pytest.raises(BusyError):
        kernel(2.0)
    assert kernel(2.0) == 6.0


def test_who_waits_takes_what_another_has_made(kernel, monkeypatch):
    lock = FileLock(kernel._cache.path)
    lock.acquire()
    done = []

    def meanwhile():
        done.append(misses(kernel))
        if len(done) == 3:
            # As another process would, which has the lock.
            other = numba.njit(**compiled._OPTIONS)(triple)
            assert other(2.0) == 6.0
            [signature] = other.signatures
            kernel._cache.save_overload(signature, other.overloads[signature])
            lock.release()
        return True

    monkeypatch.setattr(KernelCache, "meanwhile", meanwhile)
    assert kernel(2.0) == 6.0
    assert done == [0, 0, 0]
    assert misses(kernel) == 0
    free(kernel)


def test_who_has_waited_for_too_long_compiles(kernel, monkeypatch):
    monkeypatch.setattr(KernelCache, "patience", 0.05)
    with FileLock(kernel._cache.path):
        assert kernel(2.0) == 6.0
        assert misses(kernel) == 1
        assert KernelCache.patience == 0.0  # a lock that was held too long is not waited for again


def test_a_kernel_that_cannot_be_compiled_holds_up_nobody(kernel, tmp_path):
    with pytest.raises(numba.core.errors.TypingError):
        kernel("a text")

    def double(x):
        return 2.0 * x

    assert compiled.kernel(double)(2.0) == 4.0
    free(kernel)
