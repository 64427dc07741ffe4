"""Compiling ahead: while a filter waits for its first kernel, other processes compile those it needs later.

One process compiles on one processor only. Which kernels each filter needs, in which order and with arguments
of which types, stands in ``signatures.json`` beside this file; ``python -m vtksmooth.signatures`` makes it.
Machine code changes hands by the cache on disk; what a helper is about to compile is waited for. What is not
in the list is compiled when it is called, as ever.
"""

from __future__ import annotations

import contextlib
import gc
import importlib
import inspect
import json
import logging
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from numba import types
from numba.core.dispatcher import Dispatcher

from . import parallel
from .caching import BusyError, KernelCache
from .compiled import is_cached, on_compile

_log = logging.getLogger("vtksmooth")

#: Where the list of kernels belongs.
PATH = Path(__file__).with_name("signatures.json")

#: What the names of all modules of this package begin with.
_OWN = __name__.partition(".")[0] + "."

#: More processes than this spend their time on what they all need.
_MOST_HELPERS = 3


def spelled(kind: types.Type) -> str:
    """Return how a type of numba's is written in the list."""
    if isinstance(kind, types.Array):
        if kind.layout != "C" or not kind.mutable or not kind.aligned:
            raise ValueError(f"Kernels take writable C-contiguous arrays, not {kind}.")
        return f"{spelled(kind.dtype)}[{':,' * (kind.ndim - 1)}::1]"
    if isinstance(kind, types.BaseTuple):
        members = "".join(f"{spelled(member)}," for member in kind)
        made = getattr(kind, "instance_class", None)
        name = f"{made.__module__}:{made.__qualname__}" if made else ""
        return f"group(({members}),{name!r})" if name else f"group(({members}))"
    return "boolean" if kind == types.boolean else str(kind)


def _group(members: Sequence[types.Type], name: str = "") -> types.Type:
    made: Any = tuple
    if name:
        module, _, qualified = name.partition(":")
        made = getattr(importlib.import_module(module), qualified)
    return types.BaseTuple.from_types(members, made)


def understood(text: str) -> tuple[types.Type, ...]:
    """Return the types of arguments that are written in the list.

    Examples
    --------
    >>> understood("float64[:,::1],int64,")
    (Array(float64, 2, 'C', False, aligned=True), int64)
    """
    names = {**vars(types), "group": _group, "__builtins__": {}}
    return tuple(eval(f"({text})", names))


@contextlib.contextmanager
def noted() -> Iterator[list[list[str]]]:
    """While this context is open, note the kernels that are used for the first time in this process.

    As they are listed: module, name, types of arguments. Kernels that are part of others are not noted, and
    none is compiled before it is used.
    """
    found: list[list[str]] = []
    depth = 0
    original: Any = Dispatcher.compile
    another: Any = compiling_ahead._compile_another

    def compile_and_note(self: Any, arguments: Sequence[types.Type]) -> Any:
        nonlocal depth
        function = self.py_func
        if depth == 0 and function.__module__.startswith(_OWN):
            text = "".join(f"{spelled(argument)}," for argument in arguments)
            found.append([function.__module__, function.__name__, text])
        depth += 1
        try:
            return original(self, arguments)
        finally:
            depth -= 1

    Dispatcher.compile = compile_and_note  # type: ignore[assignment, method-assign]
    compiling_ahead._compile_another = lambda self: False  # type: ignore[method-assign]
    try:
        yield found
    finally:
        Dispatcher.compile = original  # type: ignore[method-assign]
        compiling_ahead._compile_another = another  # type: ignore[method-assign]


def _parts_of(function: Any) -> dict[Any, int]:
    """Return the code of a kernel and of the helpers in it, with the sizes: what it takes to compile them."""
    found: dict[Any, int] = {}
    waiting = [function]
    while waiting:
        function = waiting.pop()
        code = function.__code__
        if code in found:
            continue
        found[code] = len(code.co_code)
        named = [function.__globals__.get(name) for name in code.co_names]
        named += [vars(each).get(name) for each in named if inspect.ismodule(each) for name in code.co_names]
        waiting += [each.py_func for each in named if isinstance(each, Dispatcher)]
    return found


def order(functions: Sequence[Any], part: int) -> list[int]:
    """Return the numbers of kernels in the order in which helper number `part` had better compile them.

    `functions` are what the kernels are made of, in the order in which they are needed. A helper begins with
    the biggest kernel that is not for the helpers before it, and those that have most of what is in them in
    common with it: what they share would be compiled in each process. It goes on with the last.
    """
    parts = [_parts_of(function) for function in functions]
    left = sorted(range(len(parts)), key=lambda number: -sum(parts[number].values()))
    first: list[int] = []
    for _ in range(part + 1):
        left = [number for number in left if number not in first]
        shared = [sum(size for code, size in parts[n].items() if code in parts[left[0]]) for n in left]
        first = [n for n, size in zip(left, shared, strict=True) if 2 * size > sum(parts[n].values())]
    return [*sorted(first), *(n for n in reversed(range(len(parts))) if n not in first)]


def _listed(name: str) -> list[tuple[Any, tuple[types.Type, ...]]]:
    """Return the kernels that the filter `name` needs (all there are for ''), and the types of arguments."""
    listed = json.loads(PATH.read_text(encoding="utf-8"))
    numbers = listed["filters"].get(name, []) if name else range(len(listed["kernels"]))
    kernels = [listed["kernels"][number] for number in numbers]
    return [
        (getattr(importlib.import_module(module), kernel), understood(a)) for module, kernel, a in kernels
    ]


def compile_for(name: str, part: int = 0) -> None:
    """Compile what the filter `name` needs (all there is for ''), as helper number `part`."""
    kernels = _listed(name)
    for number in order([kernel.py_func for kernel, _ in kernels], part):
        if not KernelCache.writable:  # nothing can be handed over
            return
        kernel, arguments = kernels[number]
        with contextlib.suppress(BusyError):
            kernel.compile(arguments)


class compiling_ahead:  # noqa: N801 (used like a function)
    """While this context is open, the first kernel that has to be compiled starts helpers; they end with it.

    Parameters
    ----------
    name : str
        The filter's name, or '' for all kernels there are.
    """

    _helpers: list[subprocess.Popen[bytes]] = []  # noqa: RUF012 (one set for the process, whoever began)

    def __init__(self, name: str) -> None:
        self._name = name
        self._began = False
        self._left: list[tuple[Any, tuple[types.Type, ...]]] | None = None
        self._listening = on_compile(self._begin, silently=True)

    def _begin(self, kernel: str) -> None:
        count = min(parallel.number_of_threads() - 1, _MOST_HELPERS)
        # In ParaView and the like the executable is no Python; without a cache nothing can be handed over.
        program = Path(sys.executable or "").name.lower()  # where Python is embedded it may not know one
        if self._helpers or count < 1 or not program.startswith("python"):
            return
        if not is_cached(Path(__file__)):
            return
        self._began = True
        folders = [path or os.getcwd() for path in sys.path if isinstance(path, str)]
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join(folders)}
        for part in range(count):
            command = [sys.executable, "-P", "-m", __name__, self._name, str(part)]
            try:
                helper = subprocess.Popen(
                    command, env=environment, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL
                )
            except OSError as error:
                _log.info("No other process could be started to compile kernels: %s", error)
                return
            self._helpers.append(helper)

    def _compile_another(self) -> bool:
        """Compile the last of the kernels that nobody has yet, and return whether there was one."""
        if self._left is None:
            self._left = _listed(self._name)
        KernelCache.waits = False
        try:
            while self._left:
                kernel, arguments = self._left.pop()
                if arguments not in kernel.overloads:
                    with contextlib.suppress(BusyError):
                        kernel.compile(arguments)
                        return True
        finally:
            KernelCache.waits = True
        return False

    def __enter__(self) -> None:
        self._listening.__enter__()
        self._before = KernelCache.meanwhile
        KernelCache.meanwhile = self._compile_another

    def __exit__(self, *exc: object) -> None:
        KernelCache.meanwhile = self._before
        self._listening.__exit__(*exc)
        while self._began and self._helpers:
            with self._helpers.pop() as helper:
                helper.terminate()  # caches are written to files of other names first, and then renamed


def _end_with_the_other_end() -> None:
    """End this process as soon as the one that started it has ended, however that came."""
    os.read(0, 1)  # not of sys.stdin, whose lock a thread may not hold when the interpreter ends
    os._exit(0)


if __name__ == "__main__":
    # Whoever began tells the user what goes on.
    threading.Thread(target=_end_with_the_other_end, daemon=True).start()
    logging.disable()
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    gc.disable()  # it ends soon
    KernelCache.waits = False  # there is enough else to do
    with on_compile(lambda kernel: None):
        compile_for(sys.argv[1], int(sys.argv[2]))
