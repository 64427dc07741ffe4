"""The machine code of kernels on disk. What one process compiles, no other compiles at the same time.

The cache saves time and nothing else: what is missing, damaged or of another version is compiled again and
replaced, and where nothing can be written kernels are compiled in every process.
"""

from __future__ import annotations

import contextlib
import hashlib
import logging
import pickle
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, ClassVar

import llvmlite
import numba
from numba.core.compiler import CompileResult
from numba.core.serialize import dumps

_log = logging.getLogger("vtksmooth")

#: For how long another process is waited for, seconds. Then it hangs, or the file system's locks do not work.
_LONGEST = 120.0


class BusyError(Exception):
    """Another process compiles this kernel."""


class KernelCache:
    """The files of one kernel, one for each signature; what numba asks in place of its own cache.

    From when a signature is missing to the end of its compilation the kernel is locked. A file begins with
    the checksum of the rest: machine code that has changed would end the process.

    Attributes
    ----------
    waits : bool
        Whether to wait for another process that holds the lock, for all kernels; otherwise it is an error.
    meanwhile : callable
        What to do first in place of waiting, again and again, as long as it returns True.
    writable : bool
        Whether to lock and keep anything, for all kernels: until a file cannot be written.
    patience : float
        For how long to wait, seconds: nothing once that was in vain.
    """

    waits: ClassVar[bool] = True
    meanwhile: ClassVar[Callable[[], bool] | None] = None
    writable: ClassVar[bool] = True
    patience: ClassVar[float] = _LONGEST

    def __init__(self, name: str, folder: Path) -> None:
        self.name, self.folder = name, folder
        self.path = folder / f"{name}.lock"
        self._lock: Any = None

    @property
    def cache_path(self) -> str:
        """The folder, as numba's statistics name it."""
        return str(self.folder)

    def load_overload(self, signature: Any, context: Any) -> Any:
        """Return what has been compiled for a signature, by now, or None: then whoever asked must do it."""
        context.refresh()  # a process that compiles nothing has not told the context of numba's functions yet
        file = self._file(signature, context)
        found = self._read(file, context)
        if found is None and self._acquire():
            found = self._read(file, context)
        return found

    def save_overload(self, signature: Any, compiled: Any) -> None:
        """Keep what has been compiled."""
        if not self.writable or compiled.library.has_dynamic_globals:  # addresses in this process
            return
        file = self._file(signature, compiled.target_context)
        unfinished = file.with_suffix(".tmp")
        try:
            data = dumps(compiled._reduce())
            self.folder.mkdir(parents=True, exist_ok=True)
            unfinished.write_bytes(hashlib.sha256(data).digest() + data)
            unfinished.replace(file)
        except Exception as error:  # a full disk, or a version of numba that packs its results in another way
            KernelCache.writable = False
            with contextlib.suppress(OSError):
                unfinished.unlink()
            _log.warning(
                "vtksmooth cannot keep compiled kernels in %s (%s), so every process compiles them again; "
                "make room there, or set NUMBA_CACHE_DIR to another folder.",
                self.folder, getattr(error, "strerror", None) or error,
            )  # fmt: skip

    def release(self) -> None:
        """Let other processes compile this kernel."""
        if self._lock is not None:
            self._lock.release()
            self._lock = None

    def _file(self, signature: Any, context: Any) -> Path:
        """Return the file for a signature, this processor and these versions."""
        kind = (
            str(signature), context.codegen().magic_tuple(), numba.config.BOUNDSCHECK,
            numba.__version__, llvmlite.__version__, sys.implementation.cache_tag,
        )  # fmt: skip
        return self.folder / f"{self.name}.{hashlib.sha256(repr(kind).encode()).hexdigest()[:16]}.nbc"

    def _read(self, file: Path, context: Any) -> Any:
        try:
            content = file.read_bytes()
            if hashlib.sha256(content[32:]).digest() != content[:32]:
                raise ValueError("its checksum is wrong")
            return CompileResult._rebuild(context, *pickle.loads(content[32:]))
        except FileNotFoundError:
            return None
        except Exception as error:
            _log.info("The kernel in %s is not usable and compiled again: %s", file, error)
            return None

    def _acquire(self) -> bool:
        """Lock the kernel, and return whether another process may have compiled it until then."""
        if not self.writable:
            return False
        from filelock import FileLock, Timeout  # late: hardly any process compiles anything

        lock, wait = FileLock(self.path), 0.0
        while True:
            self._lock = lock  # before it is acquired: an interruption may come at any time
            try:
                self.folder.mkdir(parents=True, exist_ok=True)
                lock.acquire(timeout=wait, poll_interval=0.01)
            except Timeout:
                if not self.waits:
                    raise BusyError(self.name) from None
                if wait >= self.patience:
                    KernelCache.patience = 0.0
                    return False
                if not KernelCache.meanwhile or not KernelCache.meanwhile():
                    wait = self.patience
            except (OSError, NotImplementedError):  # some file systems have no locks
                return False
            else:
                return True
