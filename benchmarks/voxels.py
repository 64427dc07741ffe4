"""The page on voxel skins: how near smoothing comes to the surface under the voxels, beside VTK.

python benchmarks/voxels.py [--output docs] [--quick]
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import installation_space
import numpy as np
import numpy.typing as npt
import pyvista as pv
import tables
from vtkmodules.vtkFiltersCore import vtkWindowedSincPolyDataFilter

from vtksmooth import (
    ContainmentCheck,
    InstallationSpaceSmoothing,
    LaplacianSmoothing,
    SurfaceComparison,
    ValenceTriangulation,
    samples,
)

Float64 = npt.NDArray[np.float64]
Distance = Callable[[Float64], Float64]

#: Settings of vtkWindowedSincPolyDataFilter that are tried for each skin.
TERMS, BANDS = (20, 50, 100), (0.001, 0.005, 0.01, 0.02, 0.05, 0.1)

#: How an oblique box is turned: its edges are along no axis of the voxels.
_TURN = (20.0, 35.0, 10.0)


class Case(NamedTuple):
    """A voxel skin and the surface that it stands for.

    Attributes
    ----------
    name : str
    skin : PolyData
        Triangles, double precision, voxels of size 1.
    distance : callable
        Distance of points from the true surface, in voxels.
    space : PolyData, optional
        What the surface must stay inside.
    voxel : float
        Size of a voxel, model units.
    """

    name: str
    skin: pv.PolyData
    distance: Distance
    space: pv.PolyData | None = None
    voxel: float = 1.0


def triangles(skin: pv.PolyData) -> pv.PolyData:
    """Return a skin of squares as triangles with valences near six, in double precision."""
    mesh = pv.wrap(ValenceTriangulation()(skin))
    mesh.points = np.asarray(mesh.points, dtype=float)
    return mesh


def box(cells: float, length: float = 30.0) -> Case:
    """Return an oblique box of voxels, `cells` thick and wide twice that, and `length` long."""
    half = 0.5 * np.array([cells, 2.0 * cells, length])
    turn = pv.Transform()
    for axis, angle in zip("xyz", _TURN, strict=True):
        getattr(turn, f"rotate_{axis}")(angle)
    matrix = turn.matrix[:3, :3]
    reach = int(np.ceil(np.linalg.norm(half))) + 2

    def distance(points: Float64) -> Float64:
        local = np.abs(np.asarray(points, float) @ matrix) - half
        outside = np.linalg.norm(np.maximum(local, 0.0), axis=-1)
        return np.asarray(outside + np.minimum(local.max(axis=-1), 0.0))

    centres = np.stack(np.meshgrid(*[np.arange(-reach, reach) + 0.5] * 3, indexing="ij"), axis=-1)
    skin = samples.voxel_skin(distance(centres) < 0.0, origin=(-reach,) * 3)
    return Case(f"oblique box, {cells:g} voxels thick", triangles(skin), distance)


def cases(quick: bool) -> list[Case]:
    """Return the skins of the page."""
    found = [Case("torus, tube of 14 voxels", triangles(samples.voxel_torus()), samples.torus_distance)]
    if quick:
        return found
    found.append(
        Case(
            "torus, tube of 30 voxels",
            triangles(samples.voxel_torus(30.0, 90.0)),
            lambda points: samples.torus_distance(points, 30.0, 90.0),
        )
    )
    quarter = triangles(samples.voxel_torus(quarter=True))
    found.append(Case("quarter of a torus, open", quarter, samples.torus_distance))
    found += [box(cells) for cells in (6.0, 3.0, 2.0, 1.5)]
    for refinement in (1, 2):
        skin, space = samples.channel(refinement)
        true = installation_space.channel_distance(space)
        found.append(
            Case(
                f"channel in its space, refinement {refinement}", skin,
                lambda points, true=true, voxel=1.0 / refinement: true(points) / voxel, space,
                1.0 / refinement,
            )
        )  # fmt: skip
    return found


def windowed_sinc(terms: int, pass_band: float) -> Callable[[Case], pv.PolyData]:
    """Return VTK's smoothing with some terms and a pass band."""

    def smooth(case: Case) -> pv.PolyData:
        sinc = vtkWindowedSincPolyDataFilter()
        sinc.SetInputData(case.skin.triangulate())
        sinc.SetNumberOfIterations(terms)
        sinc.SetPassBand(pass_band)
        sinc.NormalizeCoordinatesOn()
        sinc.BoundarySmoothingOff()
        sinc.Update()
        return pv.wrap(sinc.GetOutput())

    return smooth


def best_windowed_sinc(case: Case) -> pv.PolyData:
    """Smooth as VTK does with the one of 18 settings that comes nearest to the true surface of this skin."""
    results = [windowed_sinc(terms, band)(case) for terms in TERMS for band in BANDS]
    return min(
        results, key=lambda result: float((case.distance(np.asarray(result.points, float)) ** 2).mean())
    )


def ours(**values: Any) -> Callable[[Case], pv.PolyData]:
    """Return our smoothing, inside the space where there is one."""

    def smooth(case: Case) -> pv.PolyData:
        if case.space is not None:
            return pv.wrap(InstallationSpaceSmoothing(**values)(case.skin, case.space))
        values_here = {"iterations": 20, **values}
        if values_here["scheme"] == "pairwise":
            values_here["relaxation_factor"] = 1.0
        return pv.wrap(LaplacianSmoothing(**values_here)(case.skin))

    return smooth


#: What is compared.
METHODS: dict[str, Callable[[Case], pv.PolyData]] = {
    "low-pass, preserve_volume": ours(scheme="low-pass", preserve_volume=True),
    "pairwise, 20 sweeps": ours(scheme="pairwise"),
    "vtkWindowedSinc at its defaults": windowed_sinc(20, 0.1),
    "vtkWindowedSinc, the best of 18 settings for each skin": best_windowed_sinc,
}


def measured(case: Case) -> list[list[Any]]:
    """Return the rows of a case."""
    rows = []
    rim = case.skin.extract_feature_edges(
        boundary_edges=True, feature_edges=False, manifold_edges=False, non_manifold_edges=False
    )
    counted = np.ones(case.skin.n_points, bool)
    if rim.n_points:
        away = np.linalg.norm(case.skin.points[:, None] - rim.points[None], axis=2).min(axis=1)
        counted = away > case.voxel
    for name, method in METHODS.items():
        begin = time.process_time()
        result = method(case)
        seconds = time.process_time() - begin
        free = counted & ~_held(case)
        off = case.distance(np.asarray(result.points, float))[free]
        before = result.copy()
        before.points = np.asarray(case.skin.points, dtype=float)
        comparison, outside = SurfaceComparison(), "-"
        comparison(result, before)
        if case.space is not None:
            check = ContainmentCheck()
            check(result.triangulate(), case.space)
            outside = f"{check.summary['vertices_outside']} / {check.summary['triangles_crossing']}"
        summary = comparison.summary
        rows.append(
            [
                case.name if not rows else "", name, f"{np.sqrt((off**2).mean()):.3f}",
                f"{abs(summary['swept_volume'] / case.skin.volume):.0e}", summary["inverted"], outside,
                "-" if method is best_windowed_sinc else f"{1e6 * seconds / case.skin.n_points:.0f}",
            ]
        )  # fmt: skip
    return rows


def _held(case: Case) -> npt.NDArray[np.bool_]:
    """Return which points are on the walls of the space, or at its ends."""
    if case.space is None:
        return np.zeros(case.skin.n_points, bool)
    smoothing = InstallationSpaceSmoothing(iterations=0)
    x = case.skin.points[:, 0]
    return (np.asarray(pv.wrap(smoothing(case.skin, case.space))["Fixed"]) != 0) | (x < 1.0) | (x > 45.0)


def make(output: Path, quick: bool = False) -> None:
    """Write the page and its picture."""
    (output / "pictures").mkdir(parents=True, exist_ok=True)
    rows = [row for case in cases(quick) for row in measured(case)]
    page = [
        "# Voxel skins",
        "",
        "Made by `python benchmarks/voxels.py`. How near smoothing comes to the surface that the "
        "voxels stand for: root mean square of the distances of the points, in voxels; points on "
        "rims, on the walls of a space and at its ends do not count. Swept: the volume between the "
        "skin and the result, over that of the body. Inverted: faces against the skin's directions. "
        "Outside, crossing: points and triangles, of what must stay inside a space. Time is the "
        "processor's, of all threads, checks of a space and of self-intersections included. Ours have "
        "one setting for all; vtkWindowedSincPolyDataFilter has its defaults, and then, for each "
        "skin, the best of 18 settings by the true surface, which nobody has. It knows no space.",
        "",
        *tables.table(
            ["skin", "smoothing", "rms, voxels", "swept", "inverted", "outside / crossing", "µs a point"],
            rows,
        ),
        "",
    ]
    (output / "voxels.md").write_text("\n".join(page).rstrip() + "\n", encoding="utf-8")


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the program."""
    parser = argparse.ArgumentParser(description="Make the page on voxel skins.")
    parser.add_argument("--output", type=Path, default=Path("docs"))
    parser.add_argument("--quick", action="store_true", help="one small skin only")
    options = parser.parse_args(arguments)
    make(options.output, options.quick)


if __name__ == "__main__":
    main()
