"""The page on self-intersection: what a mesher accepts, beside what other tools make, and what it costs.

python benchmarks/mesher.py [--output docs] [--quick]

TetGen and MeshLib judge, where they are installed (extra `peers`). TetGen may end its process on a surface
that it refuses, so each surface is given to one of its own.
"""

from __future__ import annotations

import argparse
import importlib.util
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pyvista as pv
from tables import number, table
from vtkmodules.vtkFiltersCore import vtkSurfaceNets3D

from vtksmooth import (
    EquilateralSmoothing,
    LaplacianSmoothing,
    NullSpaceSmoothing,
    SegmentationSurface,
    SelfIntersection,
    TrapeziumDrawing,
    ValenceTriangulation,
)
from vtksmooth.filters.arrays import surface_of
from vtksmooth.jit import parallel
from vtksmooth.kernels.containment.self_intersection import SelfIntersections
from vtksmooth.kernels.distance.closest_point import ClosestPoint, triangles
from vtksmooth.kernels.distance.hausdorff import farthest
from vtksmooth.kernels.measures.comparison import dihedral_angles, is_closed, signed_volume
from vtksmooth.kernels.mesh import adjacency

#: Labels of the frog's tissues that are tried alone, and the part of the image that is tried as a whole.
_TISSUES, _PART = (8, 3, 9, 11, 10, 15, 6), (180, 330, 150, 300, 40, 100)

#: What a process of its own does with TetGen: nothing, or an exit code.
_TETGEN = """
import sys, numpy as np, pyvista as pv, tetgen
given = np.load(sys.argv[1])
mesh = pv.PolyData.from_regular_faces(given["points"], given["triangles"])
tetgen.TetGen(mesh).tetrahedralize(plc=True, nobisect=True, quality=False)
"""

#: Seconds that TetGen may take.
_PATIENCE = 600.0


class Judged(NamedTuple):
    """What is to be said of a surface."""

    crossing: int
    touching: int
    accepted: str
    colliding: str


def tetgen_accepts(mesh: pv.PolyData) -> str:
    """Say whether TetGen fills a surface of triangles, as it is."""
    if importlib.util.find_spec("tetgen") is None:
        return "-"
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "mesh.npz")
        np.savez(path, points=np.asarray(mesh.points, float), triangles=mesh.regular_faces)
        done = subprocess.run(
            [sys.executable, "-W", "ignore", "-c", _TETGEN, str(path)],
            capture_output=True, timeout=_PATIENCE, check=False, cwd=folder,
        )  # fmt: skip
    return "no" if done.returncode else "yes"


def meshlib_collides(mesh: pv.PolyData) -> str:
    """Return how many faces MeshLib finds colliding with others."""
    if importlib.util.find_spec("meshlib") is None:
        return "-"
    from meshlib import mrmeshnumpy, mrmeshpy

    made = mrmeshnumpy.meshFromFacesVerts(
        mesh.regular_faces.astype(np.int32), np.asarray(mesh.points, np.float32)
    )
    return f"{mrmeshpy.findSelfCollidingTrianglesBS(mrmeshpy.MeshPart(made)).count()}"


def judge(mesh: Any) -> Judged:
    """Judge a surface of triangles."""
    mesh, check = pv.wrap(mesh), SelfIntersection()
    check(mesh)
    summary = check.summary
    return Judged(
        summary["crossing_pairs"], summary["touching_pairs"], tetgen_accepts(mesh), meshlib_collides(mesh)
    )


def tissue(image: pv.ImageData, label: int, smoothing: bool) -> pv.PolyData:
    """Return the surface of one label by SurfaceNets: quadrilaterals, or the triangles it smoothed."""
    padded = np.pad((image.active_scalars == label).reshape(image.dimensions, order="F"), 1)
    given = pv.ImageData(dimensions=padded.shape, spacing=image.spacing)
    given["labels"] = padded.astype(np.uint8).ravel(order="F")
    nets = vtkSurfaceNets3D()
    nets.SetInputData(given)
    nets.SetSmoothing(smoothing)
    if smoothing:
        nets.SetOutputMeshTypeToTriangles()
    else:
        nets.SetOutputMeshTypeToQuads()
    nets.SetValue(0, 1)
    nets.Update()
    mesh = pv.wrap(nets.GetOutput()).clean()
    mesh.clear_data()
    return mesh


def measures(before: Any, after: Any) -> list[str]:
    """Return the change of the volume and the mean fold of a closed surface."""
    mesh, first = surface_of(pv.wrap(after)).mesh, surface_of(pv.wrap(before)).mesh
    near = adjacency.build(mesh)
    fold = np.abs(dihedral_angles(mesh, *adjacency.edges(near))).mean()
    change = abs(signed_volume(mesh) / signed_volume(first) - 1.0)
    closed = is_closed(near) or not len(adjacency.boundary_loops(near))
    return [f"{change:.1e}" if closed else "open", f"{fold:.2f}"]


def tissues(quick: bool) -> list[str]:
    """Return the part on single tissues."""
    image = pv.read(pv.examples.frogtissuesfile)
    ways: dict[str, Callable[[pv.PolyData, int], Any]] = {
        "pairwise": lambda mesh, label: LaplacianSmoothing(scheme="pairwise", iterations=20)(mesh),
        "**pairwise, none new**": lambda mesh, label: LaplacianSmoothing(
            scheme="pairwise", iterations=20, self_intersection="none-new"
        )(mesh),
        "SurfaceNets' smoothing": lambda mesh, label: tissue(image, label, True),
        "vtkWindowedSinc .1/20": lambda mesh, label: mesh.smooth_taubin(n_iter=20, pass_band=0.1),
    }
    rows = []
    for label in _TISSUES[:1] if quick else _TISSUES:
        rough = pv.wrap(ValenceTriangulation()(tissue(image, label, False)))
        for name, way in ways.items():
            smooth = pv.wrap(way(rough, label))
            judged = judge(smooth)
            rows.append(
                [label, f"{rough.n_points:,}", name, judged.crossing, judged.touching, judged.accepted,
                 judged.colliding, *measures(rough, smooth)]
            )  # fmt: skip
    head = ["label", "points", "method", "crossing pairs", "touching", "TetGen accepts", "MeshLib: colliding"]
    return [
        "## Single tissues",
        "",
        "Tissues of PyVista's bundled frog, each by itself: SurfaceNets' quadrilaterals, cut into triangles "
        "by ValenceTriangulation. MeshLib counts faces, SelfIntersection pairs.",
        "",
        *table([*head, "volume changes by", "mean fold, °"], rows),
    ]


def whole(quick: bool) -> list[str]:
    """Return the part on all labels at once."""
    image = pv.read(pv.examples.frogtissuesfile)
    image = image.extract_subset((200, 240, 170, 210, 50, 80) if quick else _PART)
    rows = []
    for name, parameters in {
        "as voxels": {"iterations": 0},
        "smoothed": {"self_intersection": "ignore"},
        "**smoothed, none new** (default)": {},
    }.items():
        segmentation = SegmentationSurface(**parameters)
        began = time.process_time()
        surface = pv.wrap(segmentation(image))
        seconds = time.process_time() - began
        judged = judge(surface)
        blocks = pv.wrap(SegmentationSurface(separate=True, **parameters)(image))
        accepted = [tetgen_accepts(blocks[key]) for key in blocks.keys()]  # noqa: SIM118
        report = segmentation.report
        rows.append(
            [name, f"{surface.n_points:,}", judged.crossing, judged.accepted,
             f"{accepted.count('yes')} of {len(accepted)}", f"{report.worst_label[0]:.1e}",
             f"{report.taken_back:,}", f"{seconds:.1f}"]
        )  # fmt: skip
    head = ["surface", "points", "crossing pairs", "TetGen accepts the whole", "and single labels"]
    return [
        "## All labels at once",
        "",
        "A part of the frog, all labels in one surface with the walls between them, and one closed surface "
        "for each label.",
        "",
        *table([*head, "worst label", "steps taken back", "processor, s"], rows),
    ]


def costs(quick: bool) -> list[str]:
    """Return the part on time."""
    threads = parallel.number_of_threads()
    parallel.set_number_of_threads(1)
    rows = []
    sphere = pv.Icosphere(nsub=4 if quick else 7)
    random = np.random.default_rng(0)
    sphere.points = np.asarray(sphere.points, float) * (
        1.0 + 0.1 * 2.0 ** -(4 if quick else 7) * random.normal(size=(sphere.n_points, 1))
    )
    image = pv.read(pv.examples.frogtissuesfile)
    frog = pv.wrap(ValenceTriangulation()(tissue(image, 8 if quick else 15, False)))
    filters: dict[str, Callable[..., Any]] = {
        "umbrella": lambda **how: LaplacianSmoothing(iterations=20, **how),
        "pairwise": lambda **how: LaplacianSmoothing(scheme="pairwise", iterations=20, **how),
        "null space, exact volume": lambda **how: NullSpaceSmoothing(iterations=20, **how),
        "umbrella, volume preserved": lambda **how: LaplacianSmoothing(
            iterations=20, preserve_volume=True, **how
        ),
        "Trapezium Drawing": lambda **how: TrapeziumDrawing(iterations=20, **how),
        "equilateral": lambda **how: EquilateralSmoothing(iterations=20, **how),
    }
    for kind, mesh in {"sphere, nothing crosses": sphere, "frog's label 15": frog}.items():
        faces = surface_of(mesh).mesh
        pairs = SelfIntersections(faces, adjacency.build(faces))
        pairs.find(faces.points)
        began = time.process_time()
        pairs.find(faces.points)
        look = (time.process_time() - began) / faces.n_faces * 1e6
        for name, make in filters.items():
            spent: dict[str, list[float]] = {"ignore": [], "none-new": []}
            back = 0
            for _ in range(1 if quick else 3):
                for how, times in spent.items():
                    smoothing = make(self_intersection=how)
                    began = time.process_time()
                    smoothing(mesh)
                    times.append(time.process_time() - began)
                    back = max(back, smoothing.report.taken_back)
            plain, looked = (min(times) for times in spent.values())
            rows.append(
                [kind, name, f"{faces.n_faces:,}", number(plain), number(looked),
                 f"{100 * (looked / plain - 1):+.0f} %", back, number(look, 2)]
            )  # fmt: skip
    parallel.set_number_of_threads(threads)
    head = [
        "surface",
        "filter, 20 iterations",
        "faces",
        "ignore, s",
        "none-new, s",
        "cost",
        "steps taken back",
    ]
    return [
        "## What it costs",
        "",
        "Processor time on one thread, the least of three, by turns. A look is one search for all pairs, its "
        "tree known from before.",
        "",
        *table([*head, "a look, µs a face"], rows),
    ]


def distances(quick: bool) -> list[str]:
    """Return the part on the bound on the distance of surfaces."""
    random = np.random.default_rng(0)
    rows = []
    paths = {"ant": pv.examples.antfile, "airplane": pv.examples.planefile, "nut": pv.examples.nutfile}
    for name, path in paths.items():
        mesh = pv.read(path).triangulate().clean()
        for smoothing in (EquilateralSmoothing(iterations=20), LaplacianSmoothing(iterations=10)):
            surfaces = [surface_of(each).mesh for each in (mesh, pv.wrap(smoothing(mesh)))]
            for way, (one, other) in {"back": surfaces, "there": surfaces[::-1]}.items():
                surface = ClosestPoint(other)
                began = time.process_time()
                lower, upper = farthest(one, surface)
                spent = time.process_time() - began
                corners = one.points[triangles(one)]
                area = np.linalg.norm(
                    np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
                )
                weights = random.dirichlet(np.ones(3), 10_000 if quick else 1_000_000)
                chosen = random.choice(len(corners), len(weights), p=area / area.sum())
                found = surface.query((corners[chosen] * weights[:, :, None]).sum(axis=1))[1].max()
                rows.append(
                    [name, type(smoothing).__name__, way, number(found), number(lower), number(upper),
                     f"{100 * (upper / found - 1):.1f} %", number(spent / one.n_faces * 1e6, 2)]
                )  # fmt: skip
    head = [
        "surface",
        "filter",
        "way",
        "largest of 10⁶ samples",
        "lower bound",
        "upper bound",
        "above samples",
    ]
    return [
        "## How far apart",
        "",
        "Bounds on the distance (`compare --hausdorff`) beside a million random points of the faces.",
        "",
        *table([*head, "µs a face"], rows),
    ]


def make(folder: Path, quick: bool = False) -> None:
    """Write the page."""
    LaplacianSmoothing(scheme="pairwise", iterations=1, self_intersection="none-new")(pv.Sphere())
    lines = [
        "# Surfaces that a mesher accepts",
        "",
        "Made by `python benchmarks/mesher.py`. {doc}`How it works <algorithms/self_intersection>`. TetGen "
        "fills surfaces as they are (`-pY`); what it refuses crosses itself.",
        "",
        *tissues(quick),
        *whole(quick),
        *costs(quick),
        *distances(quick),
    ]
    (folder / "mesher.md").write_text("\n".join(lines).rstrip() + "\n", encoding="utf-8")


def main(arguments: Sequence[str] | None = None) -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--output", type=Path, default=Path("docs"))
    parser.add_argument("--quick", action="store_true", help="small meshes, to see that it runs")
    options = parser.parse_args(arguments)
    make(options.output, options.quick)


if __name__ == "__main__":
    main()
