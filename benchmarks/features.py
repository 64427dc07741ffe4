"""The page on feature detection: precision and recall against labels, and pictures, made anew.

python benchmarks/features.py [--data FOLDER] [--output docs]

FOLDER (or the environment variable VTKSMOOTH_DATA) holds the mechanical parts named in ``PARTS`` and a folder
``generated`` of labelled polyhedra. Without it the polyhedra are generated and the parts left out.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pyvista as pv
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

sys.path.insert(0, str(Path(__file__).parent))

import shapes
import tables

from vtksmooth import FeatureDetection
from vtksmooth.files import read_surface

Float64 = npt.NDArray[np.float64]
Bool = npt.NDArray[np.bool_]

#: Parts that are detected at 15 degrees, as in Jiao's figure 6.
PARTS = ("fandisk.obj", "flange.stl", "universal_joint.off", "casting.off")

#: Standard deviation of each coordinate's noise, in edge lengths.
LEVELS = (0.0, 0.05, 0.1, 0.2, 0.3)

#: Angles that detectors by dihedral angle are tried at, for each mesh, degrees.
ANGLES = range(5, 180, 5)

#: Runs with different noise.
SEEDS = 3


@dataclass(frozen=True)
class Labelled:
    """A mesh whose features are known.

    Attributes
    ----------
    name : str
    angle : float
        Smallest angle that normals turn by at its ridges, degrees.
    edge : float
        The edge length.
    mesh : PolyData
    labels : (points,) int64
        Above 0 for features; points below 0 do not count.
    """

    name: str
    angle: float
    edge: float
    mesh: pv.PolyData
    labels: npt.NDArray[np.int64]

    def noisy(self, level: float, seed: int) -> pv.PolyData:
        """Return the mesh with noise of `level` edge lengths."""
        points = np.asarray(self.mesh.points, dtype=float)
        noise = np.random.default_rng(seed).normal(0.0, level * self.edge, points.shape)
        return pv.PolyData.from_regular_faces(points + noise, self.mesh.regular_faces)

    def noisy_half(self, level: float, axis: int, above: bool, seed: int) -> pv.PolyData:
        """Return the mesh with noise on the points above or below their median along an axis."""
        mesh, place = self.noisy(level, seed), np.asarray(self.mesh.points)[:, axis]
        quiet = (place > np.median(place)) != above
        mesh.points[quiet] = self.mesh.points[quiet]
        return mesh

    def score(self, found: Bool) -> tuple[float, float, float]:
        """Return F1, precision and recall over the vertices that count."""
        counted, there = self.labels >= 0, self.labels > 0
        right = int((found & there).sum())
        precision = right / max(int((found & counted).sum()), 1)
        recall = right / int(there.sum())
        return 2 * precision * recall / max(precision + recall, 1e-300), precision, recall


def labelled(data: Path | None, size: int = 20) -> list[Labelled]:
    """Return the labelled meshes: those of the folder, or generated ones."""
    found = []
    if data is not None:
        for path in sorted((data / "generated").glob("*_s0.vtp")):
            mesh = pv.read(path)
            if "label" in mesh.point_data:
                fields = mesh.field_data
                clean = np.asarray(mesh["clean"], dtype=float)
                found.append(
                    Labelled(
                        path.stem.removesuffix("_s0").replace("_", " "),
                        float(np.min(fields["ridge_normal_angle"])), float(fields["h"][0]),
                        pv.PolyData.from_regular_faces(clean, mesh.regular_faces),
                        np.asarray(mesh["label"], dtype=np.int64),
                    )
                )  # fmt: skip
        return found
    for angle in range(10, 180, 20):
        mesh, labels = shapes.wedge(angle, size)
        found.append(Labelled(f"wedge {angle:03d}", 180.0 - angle, 1.0, mesh, labels))
    bodies = {"cube": [[0, 0, 0]], "L block": [[0, 0, 0], [1, 0, 0], [0, 1, 0]]}
    for name, cells in bodies.items():
        mesh, labels = shapes.blocks(np.array(cells, float), size // 2)
        found.append(Labelled(name, 90.0, 2.0 / size, mesh, labels))
    return found


# -- detectors: from a mesh to whether each vertex is a feature, for one or several settings ----------


def ours(**parameters: Any) -> Callable[[pv.PolyData], list[Bool]]:
    """Return our detection with the given parameters."""

    def detect(mesh: pv.PolyData) -> list[Bool]:
        return [np.asarray(pv.wrap(FeatureDetection(**parameters)(mesh)[0])["FeatureClass"]) > 0]

    return detect


def vtk_feature_edges(mesh: pv.PolyData) -> list[Bool]:
    """Return what vtkFeatureEdges finds at each of the angles."""
    mesh = mesh.copy()
    mesh["number"] = np.arange(mesh.n_points)
    found = []
    for angle in ANGLES:
        edges = mesh.extract_feature_edges(
            float(angle), boundary_edges=False, non_manifold_edges=False, manifold_edges=False
        )
        sharp = np.zeros(mesh.n_points, bool)
        if edges.n_points:
            sharp[edges["number"]] = True
        found.append(sharp)
    return found


def meshlib(mesh: pv.PolyData) -> list[Bool]:
    """Return what MeshLib's crease edges are at each of the angles, its filter for short lines included."""
    from meshlib import mrmeshnumpy, mrmeshpy

    points = np.asarray(mesh.points, dtype=np.float32)
    native = mrmeshnumpy.meshFromFacesVerts(mesh.regular_faces.astype(np.int32), points)
    length = 4.0 * float(np.sqrt(mesh.area / mesh.n_cells))
    found = []
    for angle in ANGLES:
        edges = native.findCreaseEdges(float(np.radians(angle)))
        for filtered in (False, True):
            if filtered:
                mrmeshpy.filterCreaseEdges(native, edges, length, True, False)
            vertices = mrmeshpy.getIncidentVerts(native.topology, edges)
            sharp = np.zeros(mesh.n_points, bool)
            bits = np.asarray(mrmeshnumpy.getNumpyBitSet(vertices), dtype=bool)
            sharp[: len(bits)] = bits[: mesh.n_points]
            found.append(sharp)
    return found


def detectors() -> dict[str, Callable[[pv.PolyData], list[Bool]]]:
    """Return the detectors that can be run here, by what the page calls them."""
    found = {
        "FeatureDetection, auto": ours(),
        'Jiao as printed, at 20° and 35° (`method="paper"`)': ours(method="paper"),
        "vtkFeatureEdges at the best angle for each mesh": vtk_feature_edges,
    }
    try:
        import meshlib as _  # noqa: F401
    except ImportError:
        return found
    return found | {"MeshLib's crease edges at the best angle for each mesh, filtered or not": meshlib}


def scores(detect: Callable[[pv.PolyData], list[Bool]], meshes: Sequence[Labelled]) -> Float64:
    """Return F1, precision and recall, (meshes, levels, 3): at the best setting for each mesh."""
    result = np.zeros((len(meshes), len(LEVELS), 3))
    for i, one in enumerate(meshes):
        for j, level in enumerate(LEVELS):
            seeds = range(SEEDS if level else 1)
            runs = [max(map(one.score, detect(one.noisy(level, seed)))) for seed in seeds]
            result[i, j] = np.mean(runs, axis=0)
    return result


# -- the page ----------------------------------------------------------------------------------------


def _cells(row: Float64) -> list[str]:
    return [f"{f1:.3f} ({precision:.2f}/{recall:.2f})" for f1, precision, recall in row]


def against_labels(meshes: Sequence[Labelled], source: str) -> list[str]:
    """Return the section on precision and recall."""
    measured = {name: scores(detect, meshes) for name, detect in detectors().items()}
    clear = np.array([one.angle >= 30.0 for one in meshes])
    noise = [f"{100 * level:.0f} %" for level in LEVELS]
    lines = [
        "## Against labels",
        "",
        f"{source} Gaussian noise is added to every coordinate, its standard deviation in percent of the "
        f"edge length; {SEEDS} runs each. A vertex counts as found if it is of any class but smooth. Each "
        "figure is F1, the harmonic mean of precision and recall, the two in brackets behind it. Detectors "
        f"by dihedral angle are given, for each mesh and each run, the best of {len(ANGLES)} angles by the "
        "labels, which nobody has; ours gets nothing.",
        "",
        "Mean over the meshes whose normals turn by 30° or more:",
        "",
        *tables.table(
            ["noise", *noise], [[name, *_cells(all_[clear].mean(axis=0))] for name, all_ in measured.items()]
        ),
    ]
    for name, all_ in measured.items():
        rows = [
            [f"{one.name} (from {one.angle:.0f}°)", *_cells(row)]
            for one, row in zip(meshes, all_, strict=True)
        ]
        lines += [f"### {name}", "", *tables.table(["mesh (normals turn)", *noise], rows)]
    return lines


def on_one_half(meshes: Sequence[Labelled]) -> list[str]:
    """Return the section on noise on one half."""
    levels = [level for level in LEVELS if level]
    clear = [one for one in meshes if one.angle >= 30.0]
    rows, worst = [], []
    for name, detect in detectors().items():
        f1 = np.array(
            [
                [
                    [
                        max(map(one.score, detect(one.noisy_half(level, axis, above, 0))))[0]
                        for level in levels
                    ]
                    for axis in range(3)
                    for above in (True, False)
                ]
                for one in clear
            ]
        )
        rows.append([name, *(f"{mean:.3f}" for mean in f1.mean(axis=(0, 1)))])
        worst.append([name, *(f"{least:.3f}" for least in f1.mean(axis=1).min(axis=0))])
    head = [f"{100 * level:.0f} %" for level in levels]
    return [
        "## Noise on one half",
        "",
        "The same meshes with noise on one half only, the points above or below their median along each "
        "axis: six runs each. Where a part is much noisier than the rest, `auto` goes by the noise about "
        "each vertex. F1, mean over the meshes whose normals turn by 30° or more:",
        "",
        *tables.table(["noise on one half", *head], rows),
        "The mesh with the lowest mean:",
        "",
        *tables.table(["noise on one half", *head], worst),
    ]


def _picture(mesh: pv.PolyData, lines: pv.PolyData, path: Path) -> None:
    figure = Figure(figsize=(10.4, 5.0), layout="constrained", dpi=100)
    FigureCanvasAgg(figure)
    corners = np.isin(mesh["FeatureClass"], (2, 3))
    for view, camera in zip(figure.subplots(1, 2), ((1.0, -1.4, 0.9), (-1.2, 1.0, -0.8)), strict=True):
        plotter = pv.Plotter(off_screen=True, window_size=(1800, 1680))
        plotter.add_mesh(mesh, color="#e4e4e4", show_scalar_bar=False, ambient=0.35, diffuse=0.65)
        thickness = 0.0018 * mesh.length
        if lines.n_cells:
            plotter.add_mesh(lines.tube(radius=thickness), color="#0040c0", show_scalar_bar=False)
        if corners.any():
            balls = pv.PolyData(mesh.points[corners]).glyph(
                geom=pv.Sphere(radius=3.0 * thickness), orient=False, scale=False
            )
            plotter.add_mesh(balls, color="#d02000", show_scalar_bar=False)
        middle = np.asarray(mesh.center)
        plotter.camera_position = [middle + mesh.length * np.array(camera), middle, (0.0, 0.0, 1.0)]
        plotter.reset_camera()
        plotter.enable_parallel_projection()
        plotter.camera.zoom(1.1)
        plotter.enable_anti_aliasing("ssaa")
        view.imshow(plotter.screenshot(None, return_img=True))
        plotter.close()
        view.axis("off")
    tables.save(figure, path)


def of_parts(parts: Sequence[tuple[str, pv.PolyData]], folder: Path) -> list[str]:
    """Return the section with pictures."""
    rows, pictures = [], []
    for name, source in parts:
        detection = FeatureDetection(ridge_angle=15.0)
        mesh, lines = (pv.wrap(output) for output in detection(source))
        classes, lines_of, length_of = (detection.summary[key] for key in ("vertices", "lines", "length"))
        counts = [classes[name] for name in ("ridge", "corner", "cusp")]
        length = tables.number(sum(length_of.values()), 4)
        rows.append([name, mesh.n_points, *counts, sum(lines_of.values()), length])
        picture = folder / "pictures" / f"features_{Path(name).stem}.png"
        _picture(mesh, lines, picture)
        pictures += [f"![{name}: ridge lines and corners](pictures/{picture.name})", ""]
    return [
        "## Parts at 15°",
        "",
        "Ridge lines blue, corners and cusps red, at the ridge angle of Jiao's figure 6. Facets of coarsely "
        "cut cylinders that turn by more than 15° are ridges, as they must be at this angle.",
        "",
        *tables.table(["mesh", "points", "ridge", "corner", "cusp", "lines", "length"], rows),
        *pictures,
    ]


def make(folder: Path, data: Path | None, size: int = 20) -> None:
    """Write the page and its pictures to `folder`."""
    if data is None:
        source = "Generated wedges, a cube and an L-shaped block, points thrown about in their planes."
        mesh, _ = shapes.blocks(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], float), size // 2)
        parts = [("L block", mesh)]
    else:
        source = "Labelled polyhedra: wedges by the angle inside, a cube, an L-shaped block, a spike."
        parts = [(name, read_surface(data / name)[0]) for name in PARTS]
    shapes_with_labels = labelled(data, size)
    page = [
        "# Feature detection",
        "",
        "Made by `python benchmarks/features.py`. What it is: the detection of X. Jiao, *Volume and feature "
        "preservation in surface mesh optimization*, section 4, on face normals that are filtered as far as "
        "the mesh's own noise asks, with thresholds that rise with that noise (`auto`). The detection as "
        'printed is `method="paper"`.',
        "",
        *against_labels(shapes_with_labels, source),
        *on_one_half(shapes_with_labels),
        *of_parts(parts, folder),
    ]
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "features.md").write_text("\n".join(page).rstrip() + "\n", encoding="utf-8")


def main(arguments: Sequence[str] | None = None) -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description="Make the page on feature detection anew.")
    given = os.environ.get("VTKSMOOTH_DATA")
    parser.add_argument("--data", type=Path, default=Path(given) if given else None, help="folder of meshes")
    parser.add_argument("--output", type=Path, default=Path("docs"), help="folder to write to")
    options = parser.parse_args(arguments)
    if options.data is not None:
        missing = [name for name in (*PARTS, "generated") if not (options.data / name).exists()]
        if missing:
            parser.error(f"{options.data} lacks {', '.join(missing)}")
    make(options.output, options.data)


if __name__ == "__main__":
    main()
