"""Reading files with VTK in a process of its own.

VTK's readers trust what files say: a count, an offset or an index that is wrong makes them read and write
foreign memory, ask for all memory there is, or go on for ever. Here that ends a process that has nothing to
lose, and becomes one sentence. The process serves one file after another; what ended it is followed by a
new one. Where none can be started (a program that is not run by a Python of its own) files are read in the
same process.

The module imports nothing but the standard library, so that :func:`prepare` can start the process while the
rest is being imported.
"""

from __future__ import annotations

import atexit
import contextlib
import json
import os
import re
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import IO, Any

from ..errors import Cancelled, MeshFileError

#: How long a file may take, seconds: so much at least, and more for each byte.
_SECONDS, _SECONDS_PER_BYTE = 20.0, 1e-5

#: How long the process may take to start besides, seconds: VTK may come from a slow disk.
_SECONDS_TO_START = 60.0

#: How much memory reading a file may take, bytes: so much at least, and so many times its size.
_MEMORY, _MEMORY_PER_BYTE = 4 << 30, 3000

#: From this size on, bytes, a file may well need more memory than there is.
_LARGE = 1 << 28

#: How often is looked whether to go on, seconds.
_INTERVAL = 0.05

#: Files that name other files with what they hold.
_NAMING_OTHERS = (".gltf", ".pvtu", ".vtm", ".vtmb")

_COMMAND = "import sys; sys.path[:] = {path!r}; from vtksmooth.files.vtk_child import serve; serve()"


class Unavailable(Exception):
    """No process can be started."""


class _Died(Exception):
    """The process has ended without an answer."""


class _Child:
    """A process that reads files."""

    def __init__(self) -> None:
        program = Path(sys.executable or "")
        if getattr(sys, "frozen", False) or "python" not in program.name.lower():
            raise Unavailable
        places = [os.path.abspath(place) for place in sys.path]
        try:
            self._process = subprocess.Popen(
                # -P: nothing is imported from the current folder, whatever is in it.
                [program, "-P", "-c", _COMMAND.format(path=places)],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
            )
        except OSError as error:
            raise Unavailable from error
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._requests: IO[bytes] = self._process.stdin
        self._answers: IO[bytes] = self._process.stdout
        self.ready = self.served = False

    def ask(self, request: dict[str, Any]) -> dict[str, Any]:
        """Return the first line of the answer."""
        if not self.ready:
            self._line()
            self.ready = True
        try:
            self._requests.write(json.dumps(request).encode() + b"\n")
            self._requests.flush()
        except OSError as error:
            raise _Died from error
        return self._line()

    def _line(self) -> dict[str, Any]:
        line = self._answers.readline()
        if not line.endswith(b"\n"):
            raise _Died
        answer: dict[str, Any] = json.loads(line)
        return answer

    def fill(self, array: Any) -> None:
        """Fill an array of NumPy's with what the process sends after that line."""
        if array.nbytes:
            octets = memoryview(array).cast("B")
            if self._answers.readinto(octets) < len(octets):  # type: ignore[attr-defined]
                raise _Died

    def kill(self) -> None:
        """End the process; callers that wait for an answer learn that it has died."""
        self._process.kill()

    def end(self) -> None:
        """End the process and tidy up."""
        self.kill()
        self._process.wait()
        self.forget()

    def forget(self) -> None:
        """Leave the process to others."""
        if self._process.returncode is None:
            self._process.returncode = 0
        for file in (self._requests, self._answers):
            with contextlib.suppress(OSError):
                file.close()


class _Children:
    """The process that waits for a file, if there is one; threads that read at once have one each."""

    def __init__(self) -> None:
        self._idle: _Child | None = None
        self._lock = threading.Lock()
        atexit.register(self.end)
        if hasattr(os, "register_at_fork"):
            os.register_at_fork(after_in_child=self._forget)

    def take(self) -> _Child:
        with self._lock:
            child, self._idle = self._idle, None
        return child or _Child()

    def give_back(self, child: _Child) -> None:
        with self._lock:
            before, self._idle = self._idle, child
        if before is not None:
            before.end()

    def end(self) -> None:
        with self._lock:
            child, self._idle = self._idle, None
        if child is not None:
            child.end()

    def _forget(self) -> None:
        """Leave the process to the one that this one has been forked from."""
        self._lock = threading.Lock()
        if self._idle is not None:
            self._idle.forget()
            self._idle = None


_children = _Children()


def prepare() -> None:
    """Start a process, so that the first file does not wait for it."""
    with contextlib.suppress(Unavailable):
        _children.give_back(_children.take())


def read(
    path: Path,
    extension: str,
    unpack: Callable[[dict[str, Any], Callable[[Any], None]], Any],
    cancelled: Callable[[], bool],
    kind: str = "surface",
) -> tuple[Any, list[str]]:
    """Read a file in a process of its own.

    Parameters
    ----------
    path : Path
    extension : str
    unpack : callable
        Makes the mesh of its description and of a function that fills arrays, see ``vtk_transfer``.
    cancelled : callable
        Asked every now and then whether to stop.
    kind : {"surface", "image"}
        What to read of it.

    Returns
    -------
    mesh : vtkPolyData
        Not checked.
    list of str
        What was done to the file's content.

    Raises
    ------
    MeshFileError
        The file is damaged, and may have ended the process.
    MemoryError
        It does not fit into memory.
    Cancelled
    Unavailable
        There is no process.
    """
    size = _size(path, extension)
    allowed = _SECONDS + _SECONDS_PER_BYTE * size
    request = {
        "path": os.path.abspath(path),
        "name": str(path),
        "extension": extension,
        "kind": kind,
        "memory": _MEMORY + _MEMORY_PER_BYTE * size,
    }
    while True:
        child = _children.take()
        served_before, child.served = child.served, True
        seconds = allowed if child.ready else allowed + _SECONDS_TO_START
        watch = _Watch(child, seconds, cancelled)
        try:
            with watch:
                answer = child.ask(request)
                mesh = unpack(answer["mesh"], child.fill) if "mesh" in answer else None
        except _Died as error:
            child.end()
            if watch.cancelled:
                raise Cancelled("cancelled") from error
            if watch.late:
                raise MeshFileError(
                    f"reading {path} was stopped, as it had not ended after {seconds:.0f} s: it is damaged, "
                    "or on a very slow disk; export it again, or copy it to another disk."
                ) from error
            if not child.ready:
                raise Unavailable from error
            if served_before:
                continue  # perhaps because of a file before this one
            large = ", or too large for this machine's memory" if size > _LARGE else ""
            raise MeshFileError(
                f"{path} is damaged{large}: reading it ended the reader; export it again."
            ) from error
        except BaseException:
            child.end()
            raise
        if mesh is None:
            child.end()  # whose memory the file may have damaged
            if "error" in answer:
                raise MeshFileError(answer["error"])
            raise MemoryError
        _children.give_back(child)
        return mesh, answer["notes"]


class _Watch:
    """While open, ends a process that takes too long, or whose answer is not wanted any more.

    Attributes
    ----------
    late, cancelled : bool
        Whether it has done so, and why.
    """

    def __init__(self, child: _Child, seconds: float, cancelled: Callable[[], bool]) -> None:
        self._child, self._end, self._cancelled = child, time.monotonic() + seconds, cancelled
        self._over = threading.Event()
        self.late = self.cancelled = False

    def __enter__(self) -> None:
        threading.Thread(target=self._watch, name="vtksmooth-reading", daemon=True).start()

    def __exit__(self, *_: object) -> None:
        self._over.set()

    def _watch(self) -> None:
        while not self._over.wait(_INTERVAL):
            self.cancelled = self._cancelled()
            self.late = time.monotonic() > self._end
            if self.cancelled or self.late:
                self._child.kill()
                return


def _size(path: Path, extension: str) -> int:
    """Return how many bytes a file has, with those of the files that it names."""
    size = path.stat().st_size
    if extension in _NAMING_OTHERS:
        with path.open("rb") as file:
            head = file.read(1 << 24)
        for name in set(re.findall(rb"""(?:\bfile|\bSource|"uri")\s*[=:]\s*["']([^"']{1,1000})["']""", head)):
            with contextlib.suppress(OSError, ValueError):
                size += (path.parent / os.fsdecode(name)).stat().st_size
    return size
