"""The page on surfaces between labels: volumes, lines and junctions, beside what VTK does.

python benchmarks/labels.py [--output docs] [--quick]

Grains with known walls, lines and junctions, and PyVista's bundled frog.
"""

from __future__ import annotations

import argparse
import itertools
import time
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import pyvista as pv
from tables import table
from vtkmodules.vtkCommonDataModel import vtkPolyData
from vtkmodules.vtkFiltersCore import vtkSurfaceNets3D, vtkWindowedSincPolyDataFilter

from vtksmooth import LaplacianSmoothing, SegmentationSurface, ValenceTriangulation, samples
from vtksmooth.filters.arrays import points_of, surface_of
from vtksmooth.filters.labels import BOUNDARY_LABELS, with_labels
from vtksmooth.kernels.measures import aspect_ratio
from vtksmooth.kernels.measures.comparison import dihedral_angles
from vtksmooth.kernels.measures.label_volumes import label_volumes
from vtksmooth.kernels.mesh import adjacency
from vtksmooth.kernels.mesh.mesh import Mesh

Float64 = npt.NDArray[np.float64]

#: Voxels along an edge of the image, grains, and their places.
_SIZE, _GRAINS, _SEED = 48, 24, 1


class Grains(NamedTuple):
    """Voronoi cells of `seeds` in a ball round the middle of an image."""

    image: pv.ImageData
    seeds: Float64
    radius: float


def grains(size: int = _SIZE, count: int = _GRAINS, seed: int = _SEED) -> Grains:
    """Return grains whose seeds are no nearer than neighbours in a regular packing would be."""
    random = np.random.default_rng(seed)
    radius = 0.44 * size
    gap = 2.0 * radius * (np.pi / 6.0 / count) ** (1.0 / 3.0)
    seeds = np.empty((0, 3))
    while len(seeds) < count:
        place = random.uniform(-radius, radius, 3)
        if np.linalg.norm(place) < 0.95 * radius and (np.linalg.norm(seeds - place, axis=1) > gap).all():
            seeds = np.vstack((seeds, place))
    axis = np.arange(size) - (size - 1) / 2
    places = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1)
    labels = 1 + ((places[..., None, :] - seeds) ** 2).sum(axis=-1).argmin(axis=-1)
    labels[(places**2).sum(axis=-1) > radius**2] = 0
    image = pv.ImageData(dimensions=(size,) * 3, origin=(axis[0],) * 3)
    image["labels"] = labels.astype(np.uint8).ravel(order="F")
    return Grains(image, seeds, radius)


def true_distance(truth: Grains, labels: Sequence[int], point: Float64) -> float:
    """Return how far a point is from where the labels really meet (Newton's method)."""
    inner = [label - 1 for label in labels if label > 0]
    foot = point.copy()
    for _ in range(10):
        rows, left = [], []
        for other in inner[1:]:
            a, b = truth.seeds[inner[0]], truth.seeds[other]
            rows.append(2.0 * (b - a))
            left.append(2.0 * (b - a) @ foot - (b @ b - a @ a))
        if 0 in labels:
            rows.append(2.0 * foot)
            left.append(foot @ foot - truth.radius**2)
        foot = foot - np.linalg.lstsq(np.array(rows), np.array(left), rcond=None)[0]
    return float(np.linalg.norm(foot - point))


class Measured(NamedTuple):
    """Figures of one result."""

    worst: float
    turning: float
    dihedral: float
    rms: tuple[float, ...]
    inverted: int
    smallest_k: float


def measure(before: Mesh, points: Float64, truth: Grains | None) -> Measured:
    """Compare `points` with those of the voxels, and with the truth if that is known."""
    near, after = adjacency.build(before), before.with_points(points)
    old, new = label_volumes(before), label_volumes(after)
    at = np.flatnonzero(near.kinds == adjacency.LINE)
    first, second = (points[near.row[near.row_offsets[at] + i]] for i in (0, 1))
    a, b = points[at] - first, second - points[at]
    turning = np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), (a * b).sum(axis=1)))
    ends, faces = adjacency.edges(near)
    folds = np.abs(dihedral_angles(after, ends, faces))[faces[:, 0] >= 0]
    k = aspect_ratio.aspect_ratios(after, aspect_ratio.reference_directions(before))
    rms: list[float] = []
    if truth is not None and before.face_labels is not None:
        sides = before.face_labels
        around: list[set[int]] = [set() for _ in range(before.n_points)]
        for corners, pair in zip(before.connectivity.reshape(-1, 3), sides, strict=True):
            for v in corners:
                around[v].update(pair.tolist())
        for kind in (adjacency.INTERIOR, adjacency.LINE, adjacency.JUNCTION):
            chosen = [v for v in np.flatnonzero(near.kinds == kind) if kind < 5 or len(around[v]) > 3]
            distances = np.array([true_distance(truth, sorted(around[v]), points[v]) for v in chosen])
            # Labels that meet in voxels only, far from where they would really meet, are no junction.
            rms.append(float(np.sqrt(np.mean(distances[distances < 2.0] ** 2))))
    return Measured(
        float(np.abs(new / old - 1.0).max()), float(turning.mean()), float(folds.mean()), tuple(rms),
        int((k < 0).sum()), float(k.min()),
    )  # fmt: skip


def row(name: str, found: Measured, seconds: float | None) -> list[str]:
    """Return a row of a table."""
    worst = f"{found.worst:.1e}" if found.worst < 1e-6 else f"{100 * found.worst:.2g} %"
    return [
        name, worst, f"{found.turning:.1f}", f"{found.dihedral:.1f}",
        " / ".join(f"{value:.3f}" for value in found.rms) or "-",
        str(found.inverted), f"{found.smallest_k:.2f}", "-" if seconds is None else f"{seconds:.1f}",
    ]  # fmt: skip


HEAD = (
    "method", "worst label", "line turning, °", "dihedral, °", "rms face / line / junction, voxels",
    "inverted", "min k", "processor, s",
)  # fmt: skip


def windowed_sinc(surface: vtkPolyData) -> Float64:
    """Return the points as VTK's windowed sinc leaves them, non-manifold edges included."""
    sinc = vtkWindowedSincPolyDataFilter()
    sinc.SetInputData(surface)
    sinc.SetPassBand(0.1)
    sinc.SetNumberOfIterations(20)
    sinc.NonManifoldSmoothingOn()
    sinc.NormalizeCoordinatesOn()
    sinc.Update()
    return points_of(sinc.GetOutput()).astype(np.float64)


def surface_nets(image: pv.ImageData) -> tuple[float, float]:
    """Return the worst and the median change of volumes by SurfaceNets' own smoothing, as parts of them."""
    labels = np.unique(image["labels"])
    volumes = []
    for smoothing in (False, True):
        nets = vtkSurfaceNets3D()
        nets.SetInputData(image)
        nets.SetSmoothing(smoothing)
        nets.SetOutputMeshTypeToTriangles()
        for number, label in enumerate(labels[labels > 0]):
            nets.SetValue(number, float(label))
        nets.Update()
        mesh = surface_of(nets.GetOutput())
        volumes.append(label_volumes(with_labels(nets.GetOutput(), mesh, BOUNDARY_LABELS)[0]))
    change = np.abs(volumes[1] / volumes[0] - 1.0)[1:]
    return float(change.max()), float(np.median(change))


def gaps(surface: vtkPolyData, mesh: Mesh) -> tuple[float, float]:
    """Smooth each label alone; return rms and largest distance between copies of points on lines."""
    corners = mesh.connectivity.reshape(-1, 3)
    assert mesh.face_labels is not None
    places: dict[int, list[Float64]] = {}
    near = adjacency.build(mesh)
    for label in range(1, int(mesh.face_labels.max()) + 1):
        mine = (mesh.face_labels == label).any(axis=1)
        turned = mesh.face_labels[mine, 1] == label
        faces = np.where(turned[:, None], corners[mine][:, ::-1], corners[mine])
        used, local = np.unique(faces, return_inverse=True)
        shell = pv.PolyData.from_regular_faces(mesh.points[used], local.reshape(-1, 3))
        smooth = pv.wrap(LaplacianSmoothing(scheme="pairwise", iterations=20)(shell))
        for v, point in zip(used.tolist(), smooth.points, strict=True):
            if near.kinds[v] >= adjacency.LINE:
                places.setdefault(v, []).append(np.asarray(point))
    distances = [
        float(np.linalg.norm(a - b)) for many in places.values() for a, b in itertools.combinations(many, 2)
    ]
    return float(np.sqrt(np.mean(np.square(distances)))), max(distances)


def _surface(image: pv.ImageData, iterations: int) -> tuple[SegmentationSurface, vtkPolyData, Mesh, float]:
    segmentation = SegmentationSurface(iterations=iterations)
    start = time.process_time()
    surface = segmentation(image)
    seconds = time.process_time() - start
    return segmentation, surface, with_labels(surface, surface_of(surface), BOUNDARY_LABELS)[0], seconds


def contacts(frog: pv.ImageData, tissue: int) -> list[list[str]]:
    """Smooth the skin of one tissue, whose voxels touch along edges; return rows, without and with labels."""
    voxels = np.asarray(frog["MetaImage"]).reshape(frog.dimensions, order="F") == tissue
    skin = samples.voxel_skin(voxels, spacing=frog.spacing)
    skin.clear_data()
    skin = pv.wrap(ValenceTriangulation()(skin))
    skin.clear_data()
    mesh = surface_of(skin).mesh
    near = adjacency.build(mesh)
    ends, faces = adjacency.edges(near)
    touching = near.kinds == adjacency.NON_MANIFOLD
    owner = np.repeat(np.arange(mesh.n_points), np.diff(near.ring_offsets))
    close = touching.copy()
    close[owner[touching[near.ring]]] = True
    regular = faces[:, 0] >= 0
    rows = []
    for name, labels in (("contacts held", None), ("contacts as lines", 1)):
        skin.clear_data()
        if labels is not None:
            skin.cell_data[BOUNDARY_LABELS] = np.full(skin.n_cells, labels)
        smoothing = LaplacianSmoothing(
            scheme="pairwise", iterations=20, relaxation_factor=0.2 if labels else 0.7
        )
        points = points_of(smoothing(skin)).astype(np.float64)
        folds = np.abs(dihedral_angles(mesh.with_points(points), ends, faces))
        rows.append(
            [
                f"tissue {tissue}, {name}", str(smoothing.report.irregular), f"{folds[regular].mean():.1f}",
                f"{folds[regular & close[ends].any(axis=1)].mean():.1f}", str(smoothing.report.inverted[1]),
            ]
        )  # fmt: skip
    return rows


def page(quick: bool) -> list[str]:
    """Return the lines of the page."""
    truth = grains(24, 6) if quick else grains()
    _surface(truth.image, 1)  # compiles
    _, voxels, before, _ = _surface(truth.image, 0)
    rows = [row("as voxels", measure(before, before.points, truth), None)]
    rows.append(
        row("vtkWindowedSinc .1/20, all together", measure(before, windowed_sinc(voxels), truth), None)
    )
    for name, smoothing in (
        ("Taubin 20, volumes of all labels", {"scheme": "taubin", "iterations": 20}),
        ("umbrella 10, volumes of all labels", {"scheme": "umbrella", "iterations": 10}),
    ):
        one = LaplacianSmoothing(preserve_volume=True, **smoothing)
        one(voxels)
        start = time.process_time()
        result = points_of(one(voxels))
        rows.append(row(name, measure(before, result, truth), time.process_time() - start))
    _, _, after, seconds = _surface(truth.image, 20)
    rows.append(row("**SegmentationSurface**, 20 sweeps", measure(before, after.points, truth), seconds))
    worst, median = surface_nets(truth.image)
    rms, largest = gaps(voxels, before)
    lines = [
        "# Surfaces between labels",
        "",
        "Made by `python benchmarks/labels.py`. A label image becomes one surface between all labels; see "
        "{py:class}`vtksmooth.SegmentationSurface`. Smaller is better, but for the smallest k.",
        "",
        "## Grains with known walls",
        "",
        f"{len(truth.seeds)} Voronoi grains in a ball, {truth.image.dimensions[0]}³ voxels, "
        f"{before.n_points} points. Distances are those of faces, lines and junctions from where they really "
        "are; on lines the turning angle from edge to edge is a mean.",
        "",
        *table(HEAD, rows),
        f"SurfaceNets' own smoothing (VTK's defaults) changes volumes by {100 * worst:.2g} % at worst, "
        f"{100 * median:.2g} % in the median. Where each label is smoothed alone, as is usual, gaps and "
        f"overlaps of {rms:.2f} voxels (rms), {largest:.2f} at most, open along the lines; here there is one "
        "surface, and none.",
        "",
    ]
    frog = pv.read(pv.examples.frogtissuesfile)
    if quick:
        frog = frog.extract_subset((180, 260, 150, 230, 40, 80))
    segmentation, _, after, seconds = _surface(frog, 20)
    _, _, before, _ = _surface(frog, 0)
    lines += [
        "## The frog",
        "",
        f"PyVista's bundled frog, {frog.n_points} voxels; {before.n_points} points. "
        f"{seconds:.1f} s of processor time for all, from the image to the surface.",
        "",
        *table(
            HEAD,
            [
                row("as voxels", measure(before, before.points, None), None),
                row("**SegmentationSurface**, 20 sweeps", measure(before, after.points, None), seconds),
            ],
        ),
        *table(
            ("label", "voxels", "volume before", "volume after", "change"),
            [
                [
                    str(each.label),
                    str(each.voxels),
                    f"{each.volume_before:.8g}",
                    f"{each.volume:.8g}",
                    f"{each.change:.1e}",
                ]
                for each in segmentation.report.labels
            ],
        ),
    ]
    frog = pv.read(pv.examples.frogtissuesfile)
    touching = [row for tissue in ((17,) if quick else (1, 12)) for row in contacts(frog, tissue)]
    return [
        *lines,
        "## Voxels that touch along edges",
        "",
        "Skins of single tissues, smoothed by the pairwise scheme, 20 iterations. Four faces meet where "
        "voxels touch along an edge; without labels the points there are held. With one label for each face "
        "(the cell array `BoundaryLabels`, the other side is 0) these edges are lines, and nothing is held.",
        "",
        *table(("case", "held points", "dihedral, °", "near contacts, °", "inverted"), touching),
    ]


def main(arguments: Sequence[str] | None = None) -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description="Make the page on surfaces between labels anew.")
    parser.add_argument("--output", type=Path, default=Path("docs"), help="folder to write to")
    parser.add_argument("--quick", action="store_true", help="small images, to see whether it works")
    options = parser.parse_args(arguments)
    text = "\n".join(page(options.quick)).rstrip() + "\n"
    (options.output / "labels.md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
