"""The machine code of kernels on disk. What one process compiles, no other compiles at the same time."""

from __future__ import annotations

from pathlib import Path
from typing import Any, ClassVar

from numba.core.caching import FunctionCache

#: For how long another process is waited for, seconds. Then it hangs.
_LONGEST = 120.0


class BusyError(Exception):
    """Another process compiles this kernel."""


class KernelCache(FunctionCache):  # type: ignore[misc]
    """numba's cache of one function, locked from when it lacks something to when that has been compiled.

    Attributes
    ----------
    waits : bool
        Whether to wait for another process that holds the lock, for all kernels; otherwise it is an error.
    meanwhile : callable
        What to do first in place of waiting, again and again, as long as it returns True.
    """

    waits: ClassVar[bool] = True
    meanwhile: ClassVar[Any] = None

    #: The only lock that is held: one kernel is compiled at a time.
    _lock: ClassVar[Any] = None

    def __init__(self, function: Any) -> None:
        super().__init__(function)
        self.path = Path(self.cache_path) / f"{function.__name__}.lock"

    def load_overload(self, signature: Any, context: Any) -> Any:
        """Return what has been compiled for a signature, by now, or None: then whoever asked must do it."""
        found = super().load_overload(signature, context)
        if found is None and self._acquire():
            found = super().load_overload(signature, context)
            if found is not None:
                self._release()
        return found

    def save_overload(self, signature: Any, compiled: Any) -> None:
        """Keep what has been compiled."""
        super().save_overload(signature, compiled)
        self._release()

    def _acquire(self) -> bool:
        self._release()  # the kernel before this one could not be compiled
        from filelock import FileLock, Timeout  # late: hardly any process compiles anything

        lock, wait = FileLock(self.path), 0.0
        while True:
            try:
                self.path.parent.mkdir(parents=True, exist_ok=True)
                lock.acquire(timeout=wait, poll_interval=0.01)
            except Timeout:
                if not self.waits:
                    raise BusyError(self.path.stem) from None
                if wait > 0.0:
                    return False
                if not KernelCache.meanwhile or not KernelCache.meanwhile():
                    wait = _LONGEST
            except (OSError, NotImplementedError):  # some file systems have no locks
                return False
            else:
                KernelCache._lock = lock
                return True

    def _release(self) -> None:
        if self._lock is not None:
            self._lock.release()
            KernelCache._lock = None
