"""A soak test of the desktop app: at random apply, cancel, undo, preview, switch, for some minutes.

    python benchmarks/soak.py [--minutes N] [--seed N] [--output FILE] [MESH ...]

After each step the state is compared with what it must be. Ends with status 1 at the first thing that is
wrong, and otherwise writes docs/soak.md. Memory must stay flat, which takes some twenty minutes to be shown:
the page says whether it did, and the status is 1 where it did not. Needs a display (or xvfb-run).
"""

from __future__ import annotations

import argparse
import contextlib
import ctypes
import faulthandler
import gc
import random
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
import pyvista as pv
from PySide6.QtGui import QPixmapCache
from vtkmodules.util.numpy_support import vtk_to_numpy

from vtksmooth.filters import FILTERS, SmoothingFilter
from vtksmooth_gui import start  # before Qt: it chooses how Qt draws
from vtksmooth_gui.commands import COMMANDS
from vtksmooth_gui.controllers.application import Application
from vtksmooth_gui.model.layer import Layer
from vtksmooth_gui.model.state import State
from vtksmooth_gui.settings import Settings
from vtksmooth_gui.tour import pause
from vtksmooth_gui.views.questions import Answer

_SWITCHES = (
    "toggle_before",
    "split",
    "swipe",
    "edges",
    "bad_faces",
    "bands",
    "dark",
    "papers_bins",
    "parallel",
    "section",
)
_REGIONS = ("region_grow", "region_shrink", "region_invert", "region_soften", "region_clear")
#: The beginning, in which caches fill, is no part of the line through the memory: a share of the time.
_WARM_UP = 0.5
#: After so many seconds everything is closed and opened anew, and the memory looked at.
_ANEW = 6.0
#: How much memory may grow in an hour of this, megabytes: then it is not told apart from a plateau.
_GROWTH = 30.0
_OVERLAYS = tuple(command.id for command in COMMANDS if command.group == "overlay")
_SMOOTHING = tuple(cls for cls in FILTERS if issubclass(cls, SmoothingFilter) and len(cls.inputs) == 1)


def resident(which: str = "VmRSS") -> float:
    """Return the memory of this process, megabytes; VmHWM is the most that it has been."""
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith(which):
            return int(line.split()[1]) / 1024
    return 0.0


class _Mallinfo(ctypes.Structure):
    """What glibc's mallinfo2 returns."""

    _fields_ = tuple(
        (name, ctypes.c_size_t)
        for name in (
            "arena", "ordblks", "smblks", "hblks", "hblkhd", "usmblks", "fsmblks", "uordblks", "fordblks",
            "keepcost",
        )
    )  # fmt: skip


def handed_out() -> float:
    """Return what malloc has handed out and not got back, megabytes: what is in use, without the gaps.

    Python's small objects have memory of their own, and so have threads' stacks and machine code. With
    another C library it is not known.
    """
    try:
        ask = ctypes.CDLL("libc.so.6").mallinfo2
    except (OSError, AttributeError):
        return float("nan")
    ask.restype = _Mallinfo
    found = ask()
    return float(found.uordblks + found.hblkhd) / (1 << 20)


def tidy() -> None:
    """Let go of what nobody holds: it is no leak, and comes and goes by chance.

    Objects in cycles, Qt's cache of pixmaps (10 MB at most), and pages that malloc keeps for later.
    """
    gc.collect()
    QPixmapCache.clear()
    with contextlib.suppress(OSError, AttributeError):  # another C library
        ctypes.CDLL("libc.so.6").malloc_trim(0)


class Soak:
    """A restless user, who remembers what every state of the history was."""

    def __init__(self, application: Application, meshes: list[Path], seed: int) -> None:
        self.application, self.meshes, self.random = application, meshes, random.Random(seed)
        self.window, self.document = application.window, application.document
        self.expected: list[dict[Layer, tuple[State, bytes]]] = []
        self.counts: dict[str, int] = {}
        self.switches = {id: self.window.action(id).isChecked() for id in _SWITCHES}
        self.filter, self.overlay = self.window.filters.filter, application.display.overlay
        #: Minutes, and megabytes then, resident and handed out by malloc, always with an empty history.
        self.memory: list[tuple[float, float, float]] = []

    def wait(self, seconds: float = 0.0) -> None:
        """Let things happen; with 0 until all is done."""
        pause(seconds or 0.005)
        deadline = time.monotonic() + 120
        while not seconds and not self.application.jobs.idle:
            pause(0.005)
            assert time.monotonic() < deadline, "a job does not end"

    def now(self) -> dict[Layer, tuple[State, bytes]]:
        """Return the states of the layers, with their points."""
        states = [(layer, layer.state) for layer in self.document.layers]
        return {layer: (state, state.points.tobytes()) for layer, state in states if state is not None}

    def remember(self) -> None:
        """Note what the steps that are in effect have led to."""
        index = self.document.history.index
        del self.expected[index:]
        while len(self.expected) <= index:
            self.expected.append(self.now())
        self.expected[index] = self.now()

    def check(self) -> None:
        """Compare the document and the window with what they must be."""
        index = self.document.history.index
        if index < len(self.expected):
            assert self.now() == self.expected[index], "a state is not what it was"
        assert len(self.document.history.steps) + 1 == len(self.expected), "the history has another length"
        assert self.document.history.memory <= self.document.history.limit
        subject, active = self.application.display.subject, self.document.active
        assert (subject is None) == (active is None)
        if subject is not None and self.application.display._preview is None:
            assert active is not None
            assert subject.state is active.state, "another mesh is shown"
            surface = self.window.view._surfaces["after"].data
            shown = vtk_to_numpy(surface.GetPoints().GetData())
            assert np.array_equal(shown, subject.state.points), "other points are drawn"

    # -- what it does ------------------------------------------------------------------------------

    def choose(self, iterations: int) -> None:
        """Choose a filter."""
        self.window.filters.choose(self.random.choice(_SMOOTHING))
        self.window.filters.set_values({"iterations": iterations})

    def apply(self) -> None:
        """Apply a filter and let it end."""
        if self.document.active is None:
            return
        self.choose(self.random.randint(0, 8))
        self.window.action("apply").trigger()
        self.wait()
        self.remember()

    def cancel(self) -> None:
        """Begin to apply a filter and cancel it."""
        if self.document.active is None:
            return
        self.choose(1_000_000)
        before = self.document.active.state
        self.window.action("apply").trigger()
        self.wait(self.random.choice((0.001, 0.02, 0.1, 0.3)))
        if self.application.jobs.busy("apply"):
            self.window.action("cancel").trigger()
            assert self.document.active.state is before
        else:
            self.remember()  # it converged

    def preview(self) -> None:
        """Preview, change parameters, and end it."""
        if self.document.active is None:
            return
        self.choose(2)
        self.window.action("preview").trigger()
        for _ in range(self.random.randint(0, 4)):
            self.window.filters.rows["iterations"].editor.setValue(self.random.randint(1, 9))  # type: ignore[attr-defined]
            self.wait(self.random.choice((0.01, 0.2)))
        if self.window.action("preview").isChecked():
            self.window.action("preview").trigger()

    def undo(self) -> None:
        """Undo or redo a few steps."""
        for _ in range(self.random.randint(1, 4)):
            action = self.window.action(self.random.choice(("undo", "redo")))
            if action.isEnabled():
                action.trigger()

    def jump(self) -> None:
        """Go somewhere in the history."""
        history = self.document.history
        self.application._go(self.random.randint(history.first, len(history.steps)))

    def switch(self) -> None:
        """Switch overlays and views, faster than they can be computed."""
        for _ in range(self.random.randint(1, 6)):
            self.window.action(self.random.choice(_OVERLAYS + _SWITCHES)).trigger()
            self.wait(self.random.choice((0.001, 0.03)))

    def brush(self) -> None:
        """Brush, lock and go to the worst faces."""
        ends = sorted(self.random.random() for _ in range(2))
        self.window.histogram.set_brush((ends[0], ends[1]))
        self.window.action(self.random.choice(("lock_brush", "next_worst", "previous_worst"))).trigger()

    def mark(self) -> None:
        """Fix points by the overlay's values, and change which."""
        if self.document.active is None:
            return
        self.wait()
        for command in ("region_threshold", self.random.choice(_REGIONS)):
            steps = list(self.document.history.steps)
            self.window.action(command).trigger()
            self.wait()
            if self.document.history.steps != steps:  # else it would have changed nothing
                self.remember()

    def close(self) -> None:
        """Close a layer, and bring it back or not."""
        if self.document.active is not None and len(self.document.layers) > 1:
            self.window.action("close_layer").trigger()
            self.remember()

    def begin_anew(self) -> None:
        """Let go of everything, and open the meshes."""
        self.wait()
        self.document.restore([], None, [], 0)
        self.expected.clear()
        self.remember()
        for path in self.meshes:
            self.application.files.open_paths([path])
            self.wait()
            self.remember()

    def look_at_memory(self, minutes: float) -> None:
        """Note the memory while all is shown as at first: forms and what is drawn take some megabytes."""
        changed = [id for id, on in self.switches.items() if self.window.action(id).isChecked() != on]
        for id in changed:
            self.window.action(id).trigger()
        filter, overlay = self.window.filters.filter, self.application.display.overlay
        self.window.filters.choose(self.filter)
        self.application.display.show_overlay(self.overlay)
        self.wait(0.1)
        self.wait()
        tidy()
        self.memory.append((minutes, resident(), handed_out()))
        self.window.filters.choose(filter)
        self.application.display.show_overlay(overlay)
        for id in changed:
            self.window.action(id).trigger()

    def run(self, seconds: float) -> None:
        """Do all this at random."""
        actions = [
            self.apply,
            self.cancel,
            self.preview,
            self.undo,
            self.jump,
            self.switch,
            self.brush,
            self.mark,
            self.close,
        ]
        weights = [5, 4, 3, 5, 2, 5, 3, 2, 1]
        began = told = begun_anew = time.monotonic()
        while time.monotonic() - began < seconds:
            action = self.random.choices(actions, weights)[0]
            self.counts[action.__name__] = self.counts.get(action.__name__, 0) + 1
            action()
            if self.random.random() < 0.5:
                self.wait()
            self.check()
            if time.monotonic() - begun_anew > _ANEW:
                self.begin_anew()
                begun_anew = time.monotonic()
                self.look_at_memory((begun_anew - began) / 60)
            if time.monotonic() - told > 20:
                told = time.monotonic()
                print(f"{told - began:5.0f} s  {resident():6.0f} MB  {self.counts}", flush=True)
        self.wait()

    @property
    def settled(self) -> np.ndarray:
        """The memory after the beginning, one row for each time that it was looked at."""
        memory = np.array(self.memory)
        return memory[memory[:, 0] > _WARM_UP * memory[-1, 0]]

    def growth(self, column: int = 1) -> tuple[float, float]:
        """Return how much the memory grows, and the standard error of that, megabytes in an hour."""
        rows = self.settled
        if np.isnan(rows[:, column]).any():
            return float("nan"), float("nan")
        (slope, _), covariance = np.polyfit(rows[:, 0], rows[:, column], 1, cov=True)
        return 60 * float(slope), 60 * float(covariance[0, 0] ** 0.5)

    @property
    def flat(self) -> bool:
        """Whether the memory is flat."""
        growth, error = self.growth()
        return growth + 2 * error <= _GROWTH

    def lines(self) -> list[str]:
        """Return the page."""
        (growth, error), (of_heap, error_of_heap) = self.growth(), self.growth(2)
        (least, heap_least), (most, heap_most) = (
            one[1:] for one in (self.settled.min(axis=0), self.settled.max(axis=0))
        )
        steps = sum(self.counts.values())
        hourly = steps / self.memory[-1][0] * 60 / 1000  # thousand steps: kB of MB
        names = " and ".join(path.name for path in self.meshes)
        return [
            "# The desktop app under a restless user",
            "",
            f"`python benchmarks/soak.py` used the app for {self.memory[-1][0]:.1f} minutes on {names},",
            "in a real window and at random: filters applied, cancelled and previewed, steps undone and",
            "redone, overlays and views switched faster than they can be computed, faces brushed, points",
            "fixed, layers closed. After each step all meshes were compared with what the history says, byte",
            "for byte, and what was drawn with the active mesh. It ends at the first thing that is wrong.",
            "",
            "| what | how often |",
            "| --- | ---: |",
            *(f"| {name} | {count:,} |" for name, count in sorted(self.counts.items())),
            f"| all | {steps:,} |",
            "",
            "No crash, no error, no wrong state. Memory was looked at whenever all was closed and opened",
            f"anew, {len(self.memory)} times, without what Qt and malloc keep for later (with it, it was",
            f"{resident('VmHWM'):.0f} MB at most). After the first {100 * _WARM_UP:.0f} % of the time,",
            f"in which caches fill, it was {least:.0f} to {most:.0f} MB; the line through it",
            f"rises by {growth:.0f} ± {error:.0f} MB an hour, {growth / hourly:.1f} kB a step.",
            f"Up to {_GROWTH:.0f} MB an hour, with twice the error, count as flat: "
            f"this run {'was' if self.flat else 'was not'}.",
            "",
            "What malloc had handed out tells what is in use from gaps between: it was",
            f"{heap_least:.1f} to {heap_most:.1f} MB, and the line through it rises by",
            f"{of_heap:.1f} ± {error_of_heap:.1f} MB an hour, {of_heap / hourly:.2f} kB a step.",
            "",
            "| minutes | MB | handed out, MB |",
            "| ---: | ---: | ---: |",
            *(
                f"| {at:.1f} | {size:.0f} | {heap:.1f} |"
                for at, size, heap in self.memory[:: max(1, len(self.memory) // 12)]
            ),
        ]


def main() -> int:
    """Run the soak test."""
    faulthandler.enable()
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("meshes", nargs="*", type=Path)
    parser.add_argument("--minutes", type=float, default=20.0)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--output", type=Path, default=Path(__file__).parents[1] / "docs" / "soak.md")
    options = parser.parse_args()
    meshes = options.meshes or [Path(pv.examples.antfile), Path(pv.examples.planefile)]
    wrong: list[Any] = []
    start.set_up()
    with tempfile.TemporaryDirectory() as folder:
        application = start.open_window(Settings(Path(folder) / "settings.ini"))
        application.sessions.ask_unsaved = lambda names, save: Answer.DISCARD  # type: ignore[method-assign]
        sys.excepthook = lambda *error: (wrong.append(error), sys.__excepthook__(*error))
        application.window.resize(1100, 750)
        soak = Soak(application, meshes, options.seed)
        soak.begin_anew()
        soak.run(60 * options.minutes)
        application.window.close()
    text = "\n".join(soak.lines())
    print(text)
    if not wrong:
        options.output.write_text(text + "\n", encoding="utf-8")
    return int(bool(wrong) or not soak.flat)


if __name__ == "__main__":
    sys.exit(main())
