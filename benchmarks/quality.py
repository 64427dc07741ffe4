"""How good elements become, and what that costs the surface: our presets beside the tools people use.

python benchmarks/quality.py [--data FOLDER] [--output docs/quality.md]
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

sys.path.insert(0, str(Path(__file__).parent))

import peers
import shapes
from speed import machine, versions
from tables import number, table

from vtksmooth.files import read_surface
from vtksmooth.kernels.distance.closest_point import ClosestPoint
from vtksmooth.kernels.measures import aspect_ratio, comparison
from vtksmooth.kernels.mesh import adjacency
from vtksmooth.kernels.mesh.mesh import Mesh

Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]

#: Read from the data folder.
FILES = {"fandisk": "fandisk.obj", "rocker arm": "rocker-arm.obj", "bunny": "bunny.off"}

#: What the mean k must reach on each mesh.
MEANS = {"fandisk": 0.93, "rocker arm": 0.91, "bunny": 0.91, "gyroid": 0.90}

ITERATIONS = 50

#: An edge above the first angle is a crease; it is kept if it still is above the second, degrees.
CREASE, KEPT = 40.0, 30.0

#: Points along a side of each triangle at which distances are taken.
_SAMPLES = 4

#: What TrapeziumDrawing needs to keep features as EquilateralSmoothing does.
KEEPING_FEATURES = {
    "features": "slide", "ridge_angle": CREASE, "boundary": "sliding", "crease_angle": CREASE,
}  # fmt: skip

OURS: dict[str, tuple[str, dict[str, Any]]] = {
    "EquilateralSmoothing": ("EquilateralSmoothing", {}),
    "TrapeziumDrawing, features sliding": ("TrapeziumDrawing", KEEPING_FEATURES),
    "TrapeziumDrawing": ("TrapeziumDrawing", {}),
}

#: What every scheme is run with.
CONSTRAINTS = {**KEEPING_FEATURES, "gate": "floor"}

_FULL_STEPS = ("umbrella", "scale-dependent", "cotangent", "area-weighted", "angle-weighted", "odt")
SCHEMES: dict[str, tuple[str, dict[str, Any]]] = {
    **{
        name: ("LaplacianSmoothing", {"scheme": name, "relaxation_factor": 1.0, "tangent_plane": True})
        for name in _FULL_STEPS
    },
    **{
        name: ("LaplacianSmoothing", {"scheme": name, "tangent_plane": True})
        for name in ("thin-plate", "taubin")
    },
    "angle-based": ("AngleBasedSmoothing", {}),
    "weighted angle-based": ("AngleBasedSmoothing", {"weighted": True}),
    "Trapezium Drawing": ("TrapeziumDrawing", {}),
    "equilateral": ("EquilateralSmoothing", {}),
}


@dataclass(frozen=True)
class Figures:
    """What a result is worth.

    Attributes
    ----------
    mean, least : float
        Of k over the faces.
    inverted : int
    kept, still_sharp : float or None
        Percentage of the creases still above `KEPT`, and still above `CREASE`; None where there were none.
    deviation : float
        Percent of the diagonal.
    """

    mean: float
    least: float
    inverted: int
    kept: float | None
    still_sharp: float | None
    deviation: float

    def row(self) -> list[str]:
        """Return the cells of a table."""
        kept = "-" if self.kept is None else f"{self.kept:.1f} / {self.still_sharp:.1f}"
        return [f"{self.mean:.3f}", f"{self.least:.3f}", str(self.inverted), kept, number(self.deviation, 2)]


class Judge:
    """A mesh, and how results are compared with it."""

    def __init__(self, points: Float64, faces: Int32) -> None:
        self.points, self.faces = points, faces
        self.mesh = Mesh.from_arrays(points, np.arange(0, faces.size + 1, 3), faces.ravel())
        self.directions = aspect_ratio.reference_directions(self.mesh)
        self.edges = adjacency.edges(adjacency.build(self.mesh))
        self.angles = comparison.dihedral_angles(self.mesh, *self.edges)
        self.surface = ClosestPoint(self.mesh)

    def figures(self, points: Float64) -> Figures:
        """Measure a result."""
        after = self.mesh.with_points(np.ascontiguousarray(points, dtype=np.float64))
        k = aspect_ratio.aspect_ratios(after, self.directions)
        sharp = np.abs(self.angles) > CREASE
        now = np.abs(comparison.dihedral_angles(after, *self.edges)[sharp])
        back = ClosestPoint(after)
        there = _mean_distance(self.surface, after)
        here = _mean_distance(back, self.mesh)
        return Figures(
            float(k.mean()),
            float(k.min()),
            int((k < 0).sum()),
            100.0 * float((now > KEPT).mean()) if sharp.any() else None,
            100.0 * float((now > CREASE).mean()) if sharp.any() else None,
            100.0 * max(there, here) / self.mesh.diagonal,
        )


def _mean_distance(surface: ClosestPoint, mesh: Mesh) -> float:
    """Mean distance of a mesh from a surface, by area."""
    a, b, c = (mesh.points[corners] for corners in mesh.connectivity.reshape(-1, 3).T)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    total = 0.0
    shares = [
        ((i + 1 / 3) / _SAMPLES, (j + 1 / 3) / _SAMPLES) for i in range(_SAMPLES) for j in range(_SAMPLES - i)
    ]
    for s, t in shares:
        total += float(area @ surface.query((1 - s - t) * a + s * b + t * c)[1])
    return total / float(area.sum()) / len(shares)


def run(make: type[peers.Case], judge: Judge) -> Figures | str:
    """Run one tool; what it does not manage is said in words."""
    case = make(judge.points, judge.faces)
    points = case.points(case.run(case.fresh(), ITERATIONS))
    if points.shape != judge.points.shape:
        return "changes the number of points"
    return judge.figures(points)


def ours(name: str, parameters: dict[str, Any], judge: Judge) -> Figures:
    """Run one of our filters."""
    result = run(peers.ours(name, **parameters), judge)
    assert isinstance(result, Figures)
    return result


def section(name: str, judge: Judge) -> list[str]:
    """Return the section of one mesh."""
    head = ["", "k mean", "k min", "inverted", "creases kept, % (30° / 40°)", "deviation, % of the diagonal"]
    rows: list[list[str]] = [["as it is", *judge.figures(judge.points).row()]]
    found = {label: ours(*what, judge) for label, what in OURS.items()}
    rows += [[f"**{label}**", *figures.row()] for label, figures in found.items()]
    keeping: list[Figures] = []
    for label, (make, package, keeps) in peers.KEEPING.items():
        if find_spec(package) is None:
            rows.append([label, "not installed", *[""] * 4])
            continue
        result = run(make, judge)
        if isinstance(result, str):
            rows.append([label, result, *[""] * 4])
            continue
        rows.append([label, *result.row()])
        if keeps:
            keeping.append(result)
    lines = [f"## {name.capitalize()}", ""]
    creases = int((np.abs(judge.angles) > CREASE).sum())
    lines += [f"{len(judge.points)} points, {len(judge.faces)} triangles, {creases} creases.", ""]
    lines += table(head, rows)
    if keeping:
        lines += [verdict(found["EquilateralSmoothing"], MEANS[name], keeping), ""]
    return lines


def verdict(figures: Figures, mean: float, keeping: Sequence[Figures]) -> str:
    """Hold the preset against its five bounds."""
    least = max(peer.least for peer in keeping)
    # Who hardly moves hardly deviates: what counts is the best of those that make the elements better.
    best = max(peer.mean for peer in keeping)
    nearest = min(peer.deviation for peer in keeping if peer.mean >= best - 0.02)
    bounds = {
        f"mean k at least {mean}": figures.mean >= mean,
        f"smallest k above every feature-keeping peer's ({least:.3f})": figures.least > least,
        "0 inverted": figures.inverted == 0,
        "at least 99 % of the creases kept": figures.kept is None or figures.kept >= 99.0,
        f"deviation at most twice the best such peer's ({number(nearest, 2)} %)": figures.deviation
        <= 2.0 * nearest,
    }
    said = "; ".join(f"{text}: {'yes' if holds else '**no**'}" for text, holds in bounds.items())
    return f"EquilateralSmoothing: {said}."


def all_schemes(judges: dict[str, Judge]) -> list[str]:
    """Return the section that compares the schemes under the same constraints."""
    rows = []
    gains, means = {}, {}
    for label, (name, parameters) in SCHEMES.items():
        cells, ratios, reached = [], [], []
        for judge in judges.values():
            before = float(aspect_ratio.aspect_ratios(judge.mesh, judge.directions).mean())
            figures = ours(name, {**parameters, **CONSTRAINTS}, judge)
            cells.append(f"{figures.mean:.3f} / {figures.least:.2f} / {number(figures.deviation, 2)}")
            reached.append(figures.mean)
            ratios.append((figures.mean - before) / max(figures.deviation, 1e-6))
        means[label] = float(np.mean(reached))
        gains[label] = float(np.exp(np.mean(np.log(np.maximum(ratios, 1e-6)))))
        rows.append([label, *cells, number(gains[label], 2)])
    best = max(gains, key=lambda label: gains[label])
    highest = [label for label, mean in means.items() if mean > max(means.values()) - 0.001]
    return [
        "## Every scheme with the same constraints",
        "",
        "Ridges and boundaries slide, corners stay, creases stay, the gate has its floor at 0.6, steps are "
        f"tangential where the scheme leaves a choice; {ITERATIONS} iterations. Cells: k mean / k min / "
        "deviation in % of the diagonal. The last column is the gain in mean k for each percent of "
        "deviation, the geometric mean over the meshes.",
        "",
        *table(["scheme", *judges, "gain / deviation"], rows),
        f"The most quality for the deviation: {best}. The highest mean k, within 0.001: "
        f"{', '.join(highest)}.",
        "",
    ]


def page(judges: dict[str, Judge]) -> str:
    """Return the whole page."""
    lines = [
        "# Quality",
        "",
        "Written by `python benchmarks/quality.py`, figures, verdicts and all, in one run.",
        "",
        machine(),
        "",
        versions(),
        "",
        f"Every tool does {ITERATIONS} iterations (mmgs decides itself) at the setting that keeps the shape "
        f"best and still improves the elements; tools that know features take an angle of {peers.CREASE:g}°. "
        "Ours run with their defaults, or with what the row says.",
        "",
        "- **k** is the signed aspect ratio, against directions frozen on the mesh as it is.",
        f"- **Creases** are the edges with a dihedral angle above {CREASE:g}° on the mesh as it is. Two "
        f"percentages: those still above {KEPT:g}°, which is what *kept* means in the verdicts, and those "
        f"still above {CREASE:g}°.",
        "- **Deviation** is the mean distance between the surfaces, by area, taken at ten points of every "
        "triangle; from the result to the original and back, the larger of the two.",
        "- *The best such peer* of a verdict is the nearest among the feature-keeping ones whose mean k is "
        "within 0.02 of the best of them: who does not move does not deviate.",
        "",
    ]
    for name, judge in judges.items():
        lines += section(name, judge)
    return "\n".join(lines + all_schemes(judges))


def load(data: Path | None) -> dict[str, Judge]:
    """Read the meshes, and make those that are generated."""
    meshes = {}
    if data is not None:
        meshes = {name: read_surface(data / file)[0] for name, file in FILES.items()}
    meshes["gyroid"] = shapes.gyroid() if data is not None else shapes.gyroid(24, 1)
    return {
        name: Judge(np.asarray(mesh.points, dtype=float), mesh.regular_faces.astype(np.int32))
        for name, mesh in meshes.items()
    }


def main(arguments: Sequence[str] | None = None) -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description="Compare our presets with others by quality.")
    given = os.environ.get("VTKSMOOTH_DATA")
    parser.add_argument("--data", type=Path, default=Path(given) if given else None, help="folder of meshes")
    parser.add_argument("--output", type=Path, default=Path("docs/quality.md"))
    options = parser.parse_args(arguments)
    if options.data is not None:
        missing = [name for name in FILES.values() if not (options.data / name).is_file()]
        if missing:
            parser.error(f"{options.data} lacks {', '.join(missing)}")
    text = page(load(options.data))
    options.output.parent.mkdir(parents=True, exist_ok=True)
    options.output.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
