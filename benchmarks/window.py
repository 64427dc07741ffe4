"""How the desktop app feels at a million faces: measured inside it, written to docs/window.md.

    python benchmarks/window.py [--faces N] [--output FILE]

Needs a display (or xvfb-run). Drawing itself is told apart: it depends on the graphics card.
"""

from __future__ import annotations

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
import pyvista as pv

from vtksmooth.files import write_surface
from vtksmooth.filters import LaplacianSmoothing, TrapeziumDrawing

_OVERLAYS = ("Key_2", "Key_1", "Key_3", "Key_5", "Key_4", "Key_1", "Key_M", "Key_0", "Key_1", "Key_2")

_START = """
import time; began = time.perf_counter()
import gc; gc.disable()  # as vtksmooth_gui.app does
from vtksmooth_gui import start
from vtksmooth_gui.settings import Settings
from pathlib import Path
qt = start.set_up()
application = start.open_window(Settings(Path({settings!r})))
view = application.window.view
while not view.frames:
    qt.processEvents()
print(time.perf_counter() - began)
application.window.close()
"""


def noisy_sphere(faces: int) -> Any:
    """Return a closed sphere of about `faces` triangles with some noise."""
    size = round((faces / 2) ** 0.5) + 2
    mesh = pv.Sphere(theta_resolution=size, phi_resolution=size)
    noise = np.random.default_rng(0).normal(scale=0.0005, size=mesh.points.shape)
    mesh.points += noise.astype(np.float32)
    return mesh


class Watch:
    """Watches the event loop: how long nothing else was done, but for drawing."""

    def __init__(self, view: Any) -> None:
        from PySide6.QtCore import QTimer

        self.longest = self.drawing = 0.0
        self._last, self._began, self._drawn = time.perf_counter(), 0.0, 0.0
        view.plotter.render_window.AddObserver("StartEvent", self._start)
        view.plotter.render_window.AddObserver("EndEvent", self._end)
        self._timer = QTimer()
        self._timer.timeout.connect(self._beat)
        self._timer.start(2)

    def _start(self, *_: Any) -> None:
        self._began = time.perf_counter()

    def _end(self, *_: Any) -> None:
        self._drawn += time.perf_counter() - self._began

    def _beat(self) -> None:
        now = time.perf_counter()
        self.longest = max(self.longest, now - self._last - self._drawn)
        self.drawing = max(self.drawing, self._drawn)
        self._last, self._drawn = now, 0.0

    def take(self) -> tuple[float, float]:
        """Return the longest block and the longest drawing since last asked, seconds."""
        found = self.longest, self.drawing
        self.longest = self.drawing = 0.0
        self._last = time.perf_counter()
        return found


def measure(faces: int) -> list[tuple[str, str, str]]:
    """Return rows: what, how long, what of that was drawing."""
    from PySide6.QtCore import Qt
    from PySide6.QtTest import QTest

    from vtksmooth_gui import start
    from vtksmooth_gui.settings import Settings
    from vtksmooth_gui.tour import pause
    from vtksmooth_gui.views.questions import Answer

    rows = []
    with tempfile.TemporaryDirectory() as folder:
        settings = str(Path(folder) / "settings.ini")
        # Byte code is kept, as an installation does; the first start makes it.
        environment = {**os.environ, "PYTHONPYCACHEPREFIX": folder, "PYTHONDONTWRITEBYTECODE": ""}
        seconds = [
            float(subprocess.run([sys.executable, "-c", _START.format(settings=settings)], text=True,
                                 capture_output=True, check=True, env=environment).stdout)
            for _ in range(4)
        ]  # fmt: skip
        rows.append(("first window, warm, from the first import", f"{min(seconds[1:]):.2f} s", ""))
        mesh = noisy_sphere(faces)
        path = Path(folder) / "sphere.vtp"
        write_surface(mesh, path)
        start.set_up()
        application = start.open_window(Settings(Path(settings)))
        application.sessions.ask_unsaved = lambda names, save: Answer.DISCARD  # type: ignore[method-assign]
        window, view = application.window, application.window.view
        window.activateWindow()
        QTest.qWaitForWindowActive(window)
        watch = Watch(view)

        def wait() -> None:
            pause(0.2)
            while not application.jobs.idle:
                pause(0.02)
            pause(0.1)

        def row(what: str) -> None:
            blocked, drawing = watch.take()
            rows.append((what, f"{1000 * blocked:.0f} ms", f"{1000 * drawing:.0f} ms"))

        wait()
        watch.take()
        application.files.open_paths([path])
        wait()
        row("longest block while a file is opened")
        window.filters.choose(TrapeziumDrawing)
        window.filters.set_values({"iterations": 2})
        window.action("apply").trigger()
        wait()
        row("longest block while Trapezium Drawing runs and is measured")
        switches = []
        for round_ in range(2):
            for key in _OVERLAYS:
                frames, began = view.frames, time.perf_counter()
                QTest.keyClick(window, getattr(Qt.Key, key))
                while view.frames == frames:
                    pause(0.001)
                if round_ or application.jobs.idle:
                    switches.append(view.issued - began)
                wait()
            if not round_:
                row("longest block while overlays are computed")
                switches.clear()
        row("longest block while overlays are switched")
        text = f"median {1000 * statistics.median(switches):.0f} ms, longest {1000 * max(switches):.0f} ms"
        rows.append(("overlay switch, from the key to the frame being issued", text, ""))
        for command in ("split", "swipe", "swipe", "bad_faces", "undo", "redo"):
            window.action(command).trigger()
            wait()
        row("longest block: split, swipe, bad faces, undo, redo")
        window.action("overlay_aspect_ratio").trigger()
        wait()
        watch.take()
        for span in ((0.0, 0.5), (0.2, 0.9), (0.0, 1.0), None):
            window.histogram.set_brush(span)
            wait()
        for command in ("papers_bins", "bands", "next_worst", "next_worst", "dark"):
            window.action(command).trigger()
            wait()
        row("longest block: brush, bins of the papers, bands, next worst face, dark")
        reactions = []
        window.filters.choose(LaplacianSmoothing)
        # First once to the end, which loads the kernels: their machine code cannot be loaded by halves.
        for iterations in (1, *5 * (100_000,)):
            window.filters.set_values({"iterations": iterations, "scheme": "cotangent"})
            window.action("apply").trigger()
            if iterations == 1:
                wait()
                continue
            job = application.jobs.job("apply")
            pause(1.5)
            began = time.perf_counter()
            window.action("cancel").trigger()
            wait()
            reactions.append(job.stopped_at - began)
        rows.append(
            ("cancel: until the worker has stopped", f"longest of 5: {1000 * max(reactions):.0f} ms", "")
        )
        row("longest block while a filter runs and is cancelled")
        window.close()
    return rows


def main() -> None:
    """Measure and write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--faces", type=int, default=1_000_000)
    parser.add_argument("--output", type=Path, default=Path(__file__).parents[1] / "docs" / "window.md")
    options = parser.parse_args()
    rows = measure(options.faces)
    lines = [
        "# How the desktop app feels",
        "",
        f"Measured inside it by `python benchmarks/window.py`, on a sphere of {options.faces:,} faces. A",
        "block is time in which the window could do nothing else; drawing frames (by a processor, without a",
        "graphics card) is told apart.",
        "",
        "| what | time | longest drawing meanwhile |",
        "| --- | ---: | ---: |",
        *(f"| {what} | {text} | {drawing} |" for what, text, drawing in rows),
    ]
    options.output.write_text("\n".join(lines) + "\n", encoding="utf-8")
    print("\n".join(lines))


if __name__ == "__main__":
    main()
