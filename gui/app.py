"""The program ``vtksmooth-gui``."""

from __future__ import annotations

import argparse
import gc
import os
import sys
from collections.abc import Sequence
from pathlib import Path

from vtksmooth.errors import VtksmoothError

_QT = ("PySide6", "shiboken6", "pyvistaqt", "qtpy", "pyqtgraph")


def start(meshes: list[Path]) -> int:
    """Open the window with `meshes`; return the exit code when it is closed.

    Raises
    ------
    VtksmoothError
        Qt is not installed, or there is no display.
    """
    gc.disable()  # from here on the window collects garbage: see controllers/garbage.py
    try:
        from .start import run
    except ImportError as error:
        if (error.name or "").split(".")[0] not in _QT:
            raise
        raise VtksmoothError(
            'the desktop app needs Qt; install it with: python -m pip install "vtksmooth[gui]"'
        ) from error
    if sys.platform.startswith("linux") and not (
        os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    ):
        raise VtksmoothError(
            "there is no display; run it in a desktop session, with ssh -X, or with xvfb-run"
        )
    return run(meshes)


def main(argv: Sequence[str] | None = None) -> int:
    """Run the application until its window is closed; return the exit code."""
    parser = argparse.ArgumentParser(
        prog="vtksmooth-gui", description="Smoothing of surface meshes in a window."
    )
    parser.add_argument("meshes", nargs="*", type=Path, metavar="MESH", help="files to open as layers")
    options = parser.parse_args(argv)
    try:
        return start(options.meshes)
    except VtksmoothError as error:
        print(f"vtksmooth-gui: error: {error}", file=sys.stderr)
        return 1
