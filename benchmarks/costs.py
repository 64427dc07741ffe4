"""What steps cost that other tools do not have, as a page."""

from __future__ import annotations

import argparse
import datetime
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyvista as pv
import shapes
import speed
import tables

from vtksmooth import (
    FeatureDetection,
    InstallationSpaceSmoothing,
    NullSpaceSmoothing,
    ValenceTriangulation,
    samples,
)
from vtksmooth.filters.arrays import surface_of
from vtksmooth.jit import parallel
from vtksmooth.kernels.mesh import adjacency

#: Iterations of a short and a long run: what lies between them is what iterations cost. The first sweep of an
#: installation space finds the distances that the next ones go by; twenty make a surface smooth.
SHORT, LONG = 1, 20


def _seconds(filter_: Any, *meshes: pv.PolyData) -> float:
    start = time.perf_counter()
    filter_(*meshes)
    return time.perf_counter() - start


def _least_and_median(times: Sequence[float], units: int) -> tuple[float, float]:
    return 1e9 * min(times) / units, 1e9 * float(np.median(times)) / units


def _iterations(
    make: Sequence[Callable[[int], Any]], meshes: Sequence[pv.PolyData], units: int, repeats: int
) -> list[tuple[float, float]]:
    """Return nanoseconds for a unit and an iteration of each filter, all by turns: least and median."""
    times: list[list[float]] = [[] for _ in make]
    for _ in range(repeats):
        for of_one, filter_ in zip(times, make, strict=True):
            short, long = (_seconds(filter_(count), *meshes) for count in (SHORT, LONG))
            of_one.append((long - short) / (LONG - SHORT))
    return [_least_and_median(of_one, units) for of_one in times]


def _row(what: str, threads: int, unit: str, cost: tuple[float, float], added: str = "") -> list[str]:
    return [what, str(threads), unit, *(f"{value:.0f}" for value in cost), added]


def volume(triangles: int, repeats: int) -> list[list[str]]:
    """Time null-space smoothing that keeps the volume, and the detection of features, on a sphere."""
    sphere = shapes.sphere(triangles, speed.NOISE)
    on = f"sphere, {sphere.n_points:,} points"
    rows = []
    for threads in (1, 2):
        parallel.set_number_of_threads(threads)
        (cost,) = _iterations(
            [lambda count: NullSpaceSmoothing(iterations=count, corrections=2, gate="none")],
            [sphere],
            sphere.n_points,
            repeats,
        )
        rows.append(_row(f"conservative iteration, two corrections: {on}", threads, "vertex", cost))
        times = [_seconds(FeatureDetection(), sphere) for _ in range(repeats)]
        cost = _least_and_median(times, sphere.n_points)
        rows.append(_row(f"detection of features: {on}", threads, "vertex", cost))
    return rows


def space(skins: dict[str, tuple[pv.PolyData, pv.PolyData]], repeats: int) -> list[list[str]]:
    """Time the triangulation, and sweeps over edges without and with containment, on one thread."""
    parallel.set_number_of_threads(1)
    rows = []
    for name, (skin, around) in skins.items():
        times = [_seconds(ValenceTriangulation(), skin) for _ in range(repeats)]
        cost = _least_and_median(times, skin.n_cells)
        rows.append(_row(f"triangulation: {name}, {skin.n_cells:,} polygons", 1, "polygon", cost))
        edges = len(adjacency.edges(adjacency.build(surface_of(ValenceTriangulation()(skin)).mesh))[0])
        kinds = ("none", "vertices", "exact")
        costs = _iterations(
            [
                lambda count, kind=kind: InstallationSpaceSmoothing(iterations=count, containment=kind)
                for kind in kinds
            ],
            [skin, around],
            edges,
            repeats,
        )
        for kind, cost in zip(kinds, costs, strict=True):
            added = "" if kind == "none" else f"+{100 * (cost[1] / costs[0][1] - 1):.0f} %"
            rows.append(_row(f"sweep, containment {kind}: {name}, {edges:,} edges", 1, "edge", cost, added))
    return rows


def _rows(quick: bool, repeats: int) -> list[list[str]]:
    torus = samples.voxel_torus(*((5.0, 12.0) if quick else (28.0, 80.0)))
    skins = {
        "channel": samples.channel(1 if quick else 3),
        "torus of voxels in a box that it touches": (torus, pv.Box(torus.bounds).triangulate()),
    }
    try:
        return [*volume(2_000 if quick else 1_310_720, repeats), *space(skins, repeats)]
    finally:
        parallel.set_number_of_threads(0)


def make(output: Path, quick: bool = False) -> None:
    """Write ``costs.md`` into the folder `output`; `quick`: on small meshes."""
    described = speed.machine()
    repeats = 1 if quick else 5
    if not quick:
        _rows(quick=True, repeats=1)  # nothing is compiled within a time
    rows = _rows(quick, repeats)
    page = [
        "# What our own steps cost",
        "",
        f"Made by `python benchmarks/costs.py` on {datetime.date.today():%B %Y}: {described}. "
        f"{speed.versions()}.",
        "",
        "Nanoseconds for each vertex, edge or polygon, filters as people call them. An iteration is what "
        f"{LONG} iterations take more than {SHORT}, divided by {LONG - SHORT}: set-up and the first sweep "
        f"are not in it; least and median of {repeats}, kinds of containment by turns. Added: to the median "
        "without containment.",
        "",
        *tables.table(["step", "threads", "for each", "least, ns", "median, ns", "added"], rows),
    ]
    output.mkdir(parents=True, exist_ok=True)
    (output / "costs.md").write_text("\n".join(page).rstrip() + "\n", encoding="utf-8")


def main(arguments: Sequence[str] | None = None) -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description="Make the page on what our own steps cost anew.")
    parser.add_argument("--output", type=Path, default=Path("docs"), help="folder to write to")
    make(parser.parse_args(arguments).output)


if __name__ == "__main__":
    main()
