"""What VTK and HDF5 have to say about a file, collected instead of printed."""

from __future__ import annotations

import contextlib
import os
import re
from collections.abc import Iterator
from typing import Any

from vtkmodules.vtkCommonCore import vtkLogger, vtkOutputWindow, vtkStringOutputWindow

#: The pipeline's own messages repeat that an algorithm failed; why is said elsewhere.
_PIPELINE = ("vtkExecutive", "vtkStreamingDemandDriven", "vtkDemandDriven", "vtkCompositeDataPipeline")


@contextlib.contextmanager
def collected() -> Iterator[list[str]]:
    """Collect VTK's error messages in the list, which is complete when the context ends.

    Objects inside a reader do not pass their errors on as events, so the output window is what sees
    all of them; the log to stderr is silenced meanwhile.
    """
    messages: list[str] = []
    before = vtkOutputWindow.GetInstance()
    window = vtkStringOutputWindow()
    vtkOutputWindow.SetInstance(window)
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)
    try:
        yield messages
    finally:
        vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_INFO)
        vtkOutputWindow.SetInstance(before)
        messages += _errors(window.GetOutput())


def _errors(text: str | bytes) -> list[str]:
    if isinstance(text, bytes):  # a message that quotes a damaged file
        text = text.decode("utf-8", "replace")
    found = re.findall(r"ERROR: In (\S+), line \d+\n(?:\S+ \(\w+\)|\(nullptr\)): ([^\n]*)", text)
    return [printable(message) for source, message in found if not source.startswith(_PIPELINE)] or [
        "VTK gave up on it" for _ in found[:1]
    ]


def printable(message: str) -> str:
    """Return a message as one short line that any terminal shows."""
    return "".join(c if c.isprintable() else "?" for c in message.strip().rstrip("."))[:200]


def run(algorithm: Any) -> None:
    """Update a VTK algorithm and collect what it reports as an error in the output window."""

    def show(caller: Any, event: str, message: str) -> None:
        # An observed error event is kept from the window, where the others are collected.
        vtkOutputWindow.GetInstance().DisplayErrorText(message)

    show.CallDataType = "string0"  # type: ignore[attr-defined]
    algorithm.AddObserver("ErrorEvent", show)
    algorithm.Update()


@contextlib.contextmanager
def hdf_silence(extension: str) -> Iterator[None]:
    """Keep the HDF5 library, which knows nothing of VTK's messages, from writing to stderr."""
    if extension != ".vtkhdf":
        yield
        return
    stderr = os.dup(2)
    try:
        with open(os.devnull, "wb") as nothing:
            os.dup2(nothing.fileno(), 2)
        yield
    finally:
        os.dup2(stderr, 2)
        os.close(stderr)
