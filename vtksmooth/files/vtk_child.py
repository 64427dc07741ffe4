"""The process that reads files with VTK for another one: see ``vtk_process``, which starts it."""

from __future__ import annotations

import contextlib
import json
import os
import queue
import signal
import sys
import threading
from pathlib import Path
from typing import IO, Any

from ..errors import MeshFileError
from . import vtk_image_readers, vtk_readers, vtk_transfer

try:
    import resource
except ImportError:  # Windows has no such limits
    resource = None  # type: ignore[assignment]


def serve() -> None:
    """Answer requests from stdin on stdout until stdin ends.

    A request is a line of JSON with the file's ``path``, its ``name`` in messages, the ``extension``, the
    ``kind`` ("surface" or "image") and the ``memory``, bytes, that reading it may take. An answer is a line
    of JSON with an ``error``, or with ``notes`` and a ``mesh``, after which the mesh's arrays follow as they
    are in memory.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # meant for the other process, which decides
    answers = _quiet_stdout()
    _leave_no_dumps()
    requests: queue.SimpleQueue[dict[str, Any]] = queue.SimpleQueue()
    threading.Thread(target=_listen, args=(requests,), daemon=True).start()
    _send(answers, {"ready": True}, [])
    while True:
        request = requests.get()
        with _limited_memory(request["memory"]):
            _send(answers, *_answer(request))


def _answer(request: dict[str, Any]) -> tuple[dict[str, Any], list[Any]]:
    try:
        read = vtk_image_readers.read if request["kind"] == "image" else vtk_readers.read
        mesh, notes = read(Path(request["path"]), request["name"], request["extension"])
        description, arrays = vtk_transfer.pack(mesh)
        return {"notes": notes, "mesh": description}, arrays
    except MeshFileError as error:
        return {"error": str(error)}, []
    except MemoryError:
        return {"memory": True}, []


def _send(answers: IO[bytes], head: dict[str, Any], arrays: list[Any]) -> None:
    answers.write(json.dumps(head).encode() + b"\n")
    for array in arrays:
        answers.write(array.data)
    answers.flush()


def _listen(requests: queue.SimpleQueue[dict[str, Any]]) -> None:
    for line in sys.stdin.buffer:
        requests.put(json.loads(line))
    # The other process has gone, and nobody waits for what is being read.
    os._exit(0)


def _quiet_stdout() -> IO[bytes]:
    """Return stdout, and keep what libraries print from getting into it."""
    sys.stdout.flush()
    answers = os.fdopen(os.dup(1), "wb")
    nothing = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nothing, 1)
    os.close(nothing)
    return answers


def _leave_no_dumps() -> None:
    """Let the death of this process, which the other one deals with, leave no files and no dialogs."""
    if resource is not None:
        resource.setrlimit(resource.RLIMIT_CORE, (0, resource.getrlimit(resource.RLIMIT_CORE)[1]))
    if sys.platform == "win32":
        import ctypes

        # SEM_FAILCRITICALERRORS | SEM_NOGPFAULTERRORBOX
        ctypes.windll.kernel32.SetErrorMode(0x0001 | 0x0002)


@contextlib.contextmanager
def _limited_memory(size: int) -> Any:
    """Let no more than `size` bytes be allocated, where the system knows such limits."""
    try:
        used = int(Path("/proc/self/statm").read_text().split()[0]) * os.sysconf("SC_PAGE_SIZE")
    except (OSError, ValueError, AttributeError):
        used = 0
    if resource is None or not used:
        yield
        return
    before = resource.getrlimit(resource.RLIMIT_AS)
    wanted = used + size
    if before[1] != resource.RLIM_INFINITY:
        wanted = min(wanted, before[1])
    resource.setrlimit(resource.RLIMIT_AS, (wanted, before[1]))
    yield
    resource.setrlimit(resource.RLIMIT_AS, before)
