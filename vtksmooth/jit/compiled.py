"""Compilation: how a Python function becomes a kernel, once per installation.

Kernels release the interpreter lock and are cached on disk, so only the first use after an
installation waits for the compiler. That wait is announced through :func:`on_compile`.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import logging
import os
import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
from numba.core import event
from numba.core.compiler_lock import global_compiler_lock

from .caching import KernelCache

_log = logging.getLogger("vtksmooth")

#: The versions of numba, from the first to before the second, whose insides are as ``compilation`` needs
#: them: the tests run with the first and the last. Others compile as they do by themselves, in more time and
#: into slower kernels with the same results.
_KNOWN_NUMBA = (0, 63), (0, 69)

#: Strict IEEE arithmetic (no ``fastmath``): a kernel that is composed of parts must give the same bits
#: as the parts. Division by zero gives inf, as in NumPy, instead of an exception branch.
_OPTIONS: dict[str, Any] = {"nogil": True, "error_model": "numpy"}

#: For what only kernels call; and for what of it makes no arrays and becomes part of its caller.
_INNER: dict[str, Any] = _OPTIONS
_WITHOUT_ARRAYS: dict[str, Any] = {}
_INLINED: dict[str, Any] = {}

if _KNOWN_NUMBA[0] <= numba.version_info.short < _KNOWN_NUMBA[1]:
    from .compilation import Passes, compiling_kernels, for_any_number

    # Nothing in C calls kernels, and nothing in Python their parts: the compiler need not make that possible.
    _OPTIONS = {**_OPTIONS, "no_cfunc_wrapper": True, "pipeline_class": Passes}
    _INNER = {**_OPTIONS, "no_cpython_wrapper": True}
    _WITHOUT_ARRAYS = {"_nrt": False}
    _INLINED = {"forceinline": True}
else:
    compiling_kernels: Any = contextlib.nullcontext  # type: ignore[no-redef]

    def for_any_number(helper: Any) -> Any:
        """Leave `helper` as it is."""
        return helper


#: An import from this package: its dots, module and names. Parsing the sources would take a third of the time
#: that it takes to import all kernels.
_IMPORT = re.compile(r"^ *from (\.+)([\w.]*) import (\([^)]*\)|.*)", re.MULTILINE)


@functools.cache
def _read(source: Path) -> bytes:
    return source.read_bytes()


@functools.cache
def _imported(source: Path) -> list[Path]:
    """Return the sources in this package that `source` imports."""
    found = []
    for dots, module, names in _IMPORT.findall(_read(source).decode()):
        home = source.parents[len(dots) - 1].joinpath(*module.split("."))
        found += [home.with_suffix(".py"), home / "__init__.py"]
        found += [home / f"{name}.py" for name in re.findall(r"\w+", names)]
    return [path for path in found if path.is_file()]


@functools.cache
def _cache_folder(source: Path) -> Path | None:
    """Return the folder for the machine code of the kernels in `source`, or None where none can be written.

    It is named after the content of `source` and of all that it imports: numba itself would miss that
    a helper in another file has changed, and run old code after an update.
    """
    sources = {source}
    waiting = [source]
    while waiting:
        new = set(_imported(waiting.pop())) - sources
        sources |= new
        waiting += new
    content = b"".join(_read(path) for path in sorted(sources))
    name = f"{source.parent.name}.{source.stem}"
    asked = os.environ.get("NUMBA_CACHE_DIR")
    package = Path(__file__).parent / "__pycache__"
    for home in [Path(asked)] if asked else [package, *_user_cache()]:
        folder = home / f"{name}-{hashlib.sha256(content).hexdigest()[:16]}"
        try:
            first = not folder.exists()
            folder.mkdir(parents=True, exist_ok=True)
        except OSError:
            continue
        if os.access(folder, os.W_OK | os.X_OK):
            if first and home == package:  # here only one version lives
                for old in set(home.glob(f"{name}-*")) - {folder}:
                    shutil.rmtree(old, ignore_errors=True)
            return folder
    return None


def _user_cache() -> list[Path]:
    """Return the user's folder for caches, or nothing where the user has no home."""
    by_name = os.environ.get("LOCALAPPDATA" if os.name == "nt" else "XDG_CACHE_HOME")
    if by_name:
        return [Path(by_name) / "vtksmooth"]
    try:
        home = Path.home()
    except RuntimeError:
        return []
    return [home.joinpath(*(("AppData", "Local") if os.name == "nt" else (".cache",)), "vtksmooth")]


def is_cached(source: Path) -> bool:
    """Return whether the machine code of kernels in `source` can be kept on disk."""
    return _cache_folder(source) is not None


def kernel(function: Callable[..., Any]) -> Any:
    """Compile `function` on first call, and keep the machine code on disk.

    Where neither the package's folder nor the user's cache can be written, the kernel still works
    and is compiled again in every process.
    """
    folder = _cache_folder(Path(function.__code__.co_filename))
    dispatcher: Any = numba.njit(**_OPTIONS)(function)
    if folder is None:
        return dispatcher
    dispatcher._cache = cache = KernelCache(function.__name__, folder)

    def compile_and_release(signature: Any) -> Any:
        try:
            return type(dispatcher).compile(dispatcher, signature)
        finally:  # also after an interruption, and where it cannot be compiled
            cache.release()

    dispatcher.compile = compile_and_release
    return dispatcher


def device(function: Callable[..., Any]) -> Any:
    """Compile a helper of kernels, always part of its caller's machine code.

    Left to itself the compiler makes calls of them, at half the speed. It counts no references, which takes
    a third of the time of those that are handed many arrays: it must make no arrays, nor return any.
    """
    return for_any_number(numba.njit(**_INNER, **_WITHOUT_ARRAYS, **_INLINED)(function))


def routine(function: Callable[..., Any]) -> Any:
    """Compile the same, but called: for what is seldom needed, so that the loop round it stays small."""
    return for_any_number(numba.njit(**_INNER, **_WITHOUT_ARRAYS)(function))


def allocating(function: Callable[..., Any]) -> Any:
    """Compile a helper of kernels that makes arrays."""
    return for_any_number(numba.njit(**_INNER)(function))


class _Announcer(event.Listener):
    """Tells every listener the name of each kernel that is about to be compiled."""

    def __init__(self) -> None:
        #: Listeners, and whether they tell the user.
        self.listeners: list[tuple[Callable[[str], None], bool]] = []
        self.depth = 0
        self.said = False
        #: Whether what is compiled is ours.
        self.ours = False
        self.compiling = compiling_kernels()

    def on_start(self, event: Any) -> None:
        self.depth += 1
        dispatcher = event.data["dispatcher"]
        if self.depth > 1 or not dispatcher.py_func.__module__.startswith("vtksmooth."):
            return
        self.ours = True
        self.compiling.__enter__()
        name = dispatcher.py_func.__name__
        if not self.said and not any(telling for _, telling in self.listeners):
            self.said = True
            _log.warning("vtksmooth compiles its kernels, once per installation; this takes some seconds.")
        for listener, _ in list(self.listeners):
            listener(name)

    def on_end(self, event: Any) -> None:
        self.depth -= 1
        if self.depth == 0 and self.ours:
            self.ours = False
            self.compiling.__exit__()


_announcer = _Announcer()
event.register("numba:compile", _announcer)

if hasattr(os, "register_at_fork"):
    # A process that is forked while another thread compiles would have the compiler's lock, a switched-off
    # garbage collector and the lock of a file, but not the thread that gives them back.
    os.register_at_fork(
        before=global_compiler_lock.acquire,
        after_in_parent=global_compiler_lock.release,
        after_in_child=global_compiler_lock.release,
    )


class on_compile:  # noqa: N801 (used like a function)
    """While this context is open, call ``listener(name)`` before each kernel is compiled.

    Without a listener that tells the user, the log does; one that works `silently` is none.
    """

    def __init__(self, listener: Callable[[str], None], *, silently: bool = False) -> None:
        self._listener = (listener, not silently)

    def __enter__(self) -> None:
        _announcer.listeners.append(self._listener)

    def __exit__(self, *exc: object) -> None:
        _announcer.listeners.remove(self._listener)
