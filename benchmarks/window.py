"""How the desktop app feels at a million faces: measured inside it, written to docs/window.md.

    python benchmarks/window.py [--faces N] [--output FILE]

Needs a display (or xvfb-run). Drawing itself is told apart: it depends on the graphics card.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pyvista as pv
from PySide6.QtCore import Qt, QTimer
from PySide6.QtTest import QTest

from vtksmooth.files import write_surface
from vtksmooth.filters import LaplacianSmoothing, TrapeziumDrawing
from vtksmooth_gui import start  # before Qt: it chooses how Qt draws
from vtksmooth_gui.commands import COMMANDS
from vtksmooth_gui.settings import Settings
from vtksmooth_gui.tour import pause
from vtksmooth_gui.views.questions import Answer

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
    """Watches the event loop: how long nothing else was done, and what of that was drawing.

    Drawing is what the render window does between the beginning and the end of a frame (uploading to the
    graphics card is in it), waiting for the graphics card, and what Qt does to put the frame onto the screen.
    """

    def __init__(self, view: Any) -> None:
        self.longest = self.drawing = 0.0
        self._last, self._began, self._drawn = time.perf_counter(), 0.0, 0.0
        self._window = view.plotter.render_window
        self._window.AddObserver("StartEvent", self._start)
        self._window.AddObserver("EndEvent", self._end)
        view.plotter.interactor.aboutToCompose.connect(self._start)
        view.plotter.interactor.frameSwapped.connect(self._end)
        self._timer = QTimer()
        self._timer.timeout.connect(self._beat)
        self._timer.start(2)

    def _start(self, *_: Any) -> None:
        self._began = time.perf_counter()

    def _end(self, *_: Any) -> None:
        # Whoever looks at the frame would wait for it, in the middle of something else.
        self._window.WaitForCompletion()
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
        self._last, self._drawn = time.perf_counter(), 0.0
        return found


class User:
    """Does one thing after the other, and notes how long the window could do nothing else."""

    def __init__(self, application: Any) -> None:
        self.application, self.window = application, application.window
        self.watch = Watch(self.window.view)
        #: Longest block and longest drawing of every operation, seconds.
        self.blocks: dict[str, tuple[float, float]] = {}

    def wait(self) -> None:
        """Let all end that is under way."""
        pause(0.2)
        while not self.application.jobs.idle:
            pause(0.02)
        pause(0.1)

    @contextlib.contextmanager
    def doing(self, what: str, to_the_end: bool = True) -> Iterator[None]:
        """Note how long what is done in this context, and what comes of it, keeps the window."""
        self.watch.take()
        yield
        if to_the_end:
            self.wait()
        found = self.watch.take()
        known = self.blocks.get(what, (0.0, 0.0))
        self.blocks[what] = (max(known[0], found[0]), max(known[1], found[1]))

    def do(self, *commands: str) -> None:
        """Choose commands from the menus."""
        for command in commands:
            action = self.window.action(command)
            with self.doing(f"{action.text().rstrip('…')} ({self.menu(command)})"):
                action.trigger()

    @staticmethod
    def menu(id: str) -> str:
        """Return the menu that a command is in."""
        return next(command.menu for command in COMMANDS if command.id == id)

    def apply(self, cls: Any, **values: Any) -> None:
        """Apply a filter; the caller waits."""
        self.window.filters.choose(cls)
        self.window.filters.set_values(values)
        self.window.action("apply").trigger()

    def switch_overlays(self) -> list[float]:
        """Go through the overlays by their keys; return how long each frame took to be issued."""
        view, seconds = self.window.view, []
        for what in ("an overlay is computed", "an overlay is switched"):
            seconds.clear()
            for key in _OVERLAYS:
                frames, began = view.frames, time.perf_counter()
                with self.doing(what):
                    QTest.keyClick(self.window, getattr(Qt.Key, key))
                    while view.frames == frames:
                        pause(0.001)
                    seconds.append(view.issued - began)
        return seconds

    def cancel(self) -> list[float]:
        """Begin and cancel a long run; return how long the worker went on."""
        seconds = []
        # First once to the end, which loads the kernels: their machine code cannot be loaded by halves.
        with self.doing("Laplacian Smoothing runs and is measured"):
            self.apply(LaplacianSmoothing, iterations=1, scheme="cotangent")
        for _ in range(5):
            with self.doing("a filter runs", to_the_end=False):
                self.apply(LaplacianSmoothing, iterations=100_000, scheme="cotangent")
                job = self.application.jobs.job("apply")
                pause(1.5)
            with self.doing("a filter is cancelled"):
                began = time.perf_counter()
                self.window.action("cancel").trigger()
            seconds.append(job.context.ended_at - began)
        return seconds

    def use(self, path: Path) -> Iterator[tuple[str, str, str]]:
        """Do everything once, and yield rows: what, how long, what of that was drawing."""
        window, view = self.window, self.window.view
        with self.doing("a file is opened"):
            self.application.files.open_paths([path])
        with self.doing("Trapezium Drawing runs and is measured"):
            self.apply(TrapeziumDrawing, iterations=2)
        seconds = self.switch_overlays()
        text = f"median {1000 * statistics.median(seconds):.0f} ms, longest {1000 * max(seconds):.0f} ms"
        yield "overlay switch, from the key to the frame being issued", text, ""
        window.action("overlay_aspect_ratio").trigger()
        self.wait()
        self.do("toggle_before", "toggle_before", "split", "split", "swipe")
        with self.doing("the swipe line is moved"):
            for place in np.linspace(0.2, 0.8, 4):
                view.set_swipe(float(place))
                pause(0.1)
        self.do("swipe", "edges", "edges", "parallel", "parallel", "frame", "view_px", "colours_plasma")
        self.do("colours_viridis", "undo", "redo", "bad_faces", "bands", "bands")
        with self.doing("a threshold is dragged"):
            for value in (0.25, 0.3, 0.35):
                window.colour_bar.set_threshold(2, value, dragging=True)
                pause(0.1)
            window.colour_bar.set_threshold(2, 0.3)
        self.do("reset_thresholds", "bad_faces")
        for span in ((0.0, 0.5), (0.2, 0.9), (0.0, 1.0), None):
            with self.doing("the brush selects faces, or none"):
                window.histogram.set_brush(span)
        self.do("papers_bins", "papers_bins", "next_worst", "next_worst", "dark", "dark")
        window.action("frame").trigger()
        self.wait()
        with self.doing("the pointer rests on the mesh"):
            QTest.mouseMove(view.plotter.interactor, view.plotter.interactor.rect().center())
            pause(0.3)
        self.do("section", "section_x", "section")
        self.do("region_threshold", "region_grow", "region_soften", "region_clear")
        with self.doing("a filter is previewed"):
            window.filters.choose(TrapeziumDrawing)
            window.action("preview").trigger()
        with self.doing("the preview ends"):
            window.action("preview").trigger()
        with self.doing("a file is written"):
            layer = self.application.document.active
            assert layer is not None
            self.application.files.write(layer, path.with_name("written.vtp"))
        with self.doing("a session is written"):
            self.application.sessions.write(path.with_name("written.vtksmooth"))
        seconds = self.cancel()
        yield "cancel: until the worker has stopped", f"longest of 5: {1000 * max(seconds):.0f} ms", ""
        self.do("close_layer")
        worst = sorted(self.blocks.items(), key=lambda item: -item[1][0])
        for what, (block, drawing) in worst:
            yield f"{what}", f"{1000 * block:.0f} ms", f"{1000 * drawing:.0f} ms"


def first_window(folder: str, settings: str) -> float:
    """Return how long it takes from the first import to the first frame, warm, seconds."""
    # Byte code is kept, as an installation does; the first start makes it.
    environment = {**os.environ, "PYTHONPYCACHEPREFIX": folder, "PYTHONDONTWRITEBYTECODE": ""}
    program = [sys.executable, "-c", _START.format(settings=settings)]
    seconds = [
        float(subprocess.run(program, text=True, capture_output=True, check=True, env=environment).stdout)
        for _ in range(4)
    ]
    return min(seconds[1:])


def measure(faces: int) -> list[tuple[str, str, str]]:
    """Return rows: what, how long, what of that was drawing."""
    with tempfile.TemporaryDirectory() as folder:
        settings = str(Path(folder) / "settings.ini")
        rows = [("first window, warm, from the first import", f"{first_window(folder, settings):.2f} s", "")]
        path = Path(folder) / "sphere.vtp"
        write_surface(noisy_sphere(faces), path)
        start.set_up()
        application = start.open_window(Settings(Path(settings)))
        application.sessions.ask_unsaved = lambda names, save: Answer.DISCARD  # type: ignore[method-assign]
        application.window.activateWindow()
        QTest.qWaitForWindowActive(application.window)
        user = User(application)
        user.wait()
        rows += user.use(path)
        application.window.close()
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
