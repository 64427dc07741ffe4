"""Two versions by turns: what an iteration takes in each, processor time on one thread.

    python benchmarks/turns.py --before FOLDER [--turns N] [--output FILE]

FOLDER is a checkout of an earlier commit (``git worktree add FOLDER COMMIT``). Each turn measures both
versions, each in a process of its own; of all turns the least is taken. Writes docs/turns.md.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import tables

_AFTER = Path(__file__).resolve().parent.parent

#: Run in both versions, with what both of them have. An iteration is what 20 take more than 1, divided by 19.
_MEASURE = """
import json, time
import numpy as np, pyvista as pv
from vtksmooth import LaplacianSmoothing, NullSpaceSmoothing, TrapeziumDrawing

mesh = pv.Sphere(theta_resolution=204, phi_resolution=204)
points = np.asarray(mesh.points, float)
mesh = pv.PolyData(points + 2e-4 * np.random.default_rng(0).normal(size=points.shape), mesh.faces)
steps = {
    "Trapezium Drawing": lambda n: TrapeziumDrawing(iterations=n),
    "umbrella": lambda n: LaplacianSmoothing(iterations=n),
    "conservative iteration (null space, two corrections, no gate)":
        lambda n: NullSpaceSmoothing(iterations=n, features="ignore", gate="none"),
    "pairwise": lambda n: LaplacianSmoothing(scheme="pairwise", iterations=n),
}

def taken(make, iterations):
    smoothing = make(iterations)
    began = time.process_time()
    smoothing(mesh)
    return time.process_time() - began

found = {}
for name, make in steps.items():
    taken(make, 1)
    few, many = zip(*((taken(make, 1), taken(make, 20)) for _ in range(3)))
    found[name] = (min(many) - min(few)) / 19
print(json.dumps(found))
"""


def measured(checkout: Path) -> dict[str, float]:
    """Return the seconds of an iteration of each step in a checkout."""
    environment = os.environ | {"PYTHONPATH": str(checkout), "NUMBA_NUM_THREADS": "1"}
    done = subprocess.run(
        [sys.executable, "-c", _MEASURE],
        cwd=checkout, env=environment, capture_output=True, text=True, check=True,
    )  # fmt: skip
    found: dict[str, float] = json.loads(done.stdout)
    return found


def main(arguments: Sequence[str] | None = None) -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description="Measure two versions by turns.")
    parser.add_argument("--before", type=Path, required=True, help="checkout of the earlier version")
    parser.add_argument("--turns", type=int, default=5)
    parser.add_argument("--output", type=Path, default=Path("docs/turns.md"))
    options = parser.parse_args(arguments)
    turns = [(measured(options.before), measured(_AFTER)) for _ in range(options.turns)]
    rows = []
    for name in turns[0][0]:
        before, after = (min(turn[version][name] for turn in turns) for version in range(2))
        rows.append(
            [name, f"{1e3 * before:.3f}", f"{1e3 * after:.3f}", f"{100 * (after / before - 1):+.0f} %"]
        )
    commit = subprocess.run(
        ["git", "log", "-1", "--format=%h of %cs"],
        cwd=options.before, capture_output=True, text=True, check=True,
    )  # fmt: skip
    lines = [
        "# Two versions by turns",
        "",
        f"Made by `python benchmarks/turns.py --before FOLDER`, a checkout of {commit.stdout.strip()}: a "
        "noisy sphere of 41,210 points, processor time of an iteration on one thread, the least of "
        f"{options.turns} turns of both versions.",
        "",
        *tables.table(["step", "before, ms", "after, ms", "change"], rows),
        "What to read next: [what our own steps cost](costs.md).",
    ]
    options.output.write_text("\n".join(lines).rstrip() + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
