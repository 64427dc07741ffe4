"""Which constraints go together, and random sets of them with every scheme, each promise checked.

    python benchmarks/promises.py [--runs N] [--seed N] [--scheme NAME] [--output FILE]

Writes docs/promises.md: the table is that of the constraints' own declarations; the figures are those of N
runs on random meshes. Ends with status 1 where a promise was broken. Every run follows from the seed and its
number.
"""

from __future__ import annotations

import argparse
import sys
import textwrap
from collections import Counter
from collections.abc import Callable, Sequence
from itertools import combinations
from pathlib import Path

import numpy as np
import pyvista as pv
import tables

from vtksmooth.errors import InvalidMeshError, ParameterError
from vtksmooth.filters.arrays import surface_of
from vtksmooth.filters.laplacian_smoothing import SCHEMES
from vtksmooth.filters.laplacian_smoothing import LaplacianSmoothing as Laplacian
from vtksmooth.kernels.distance.signed_distance import SignedDistanceTree
from vtksmooth.kernels.features.detection import detect
from vtksmooth.kernels.mesh import adjacency
from vtksmooth.kernels.mesh.mesh import Mesh
from vtksmooth.kernels.smoothing import loop
from vtksmooth.kernels.smoothing.constraints import Constraint, Phase
from vtksmooth.kernels.smoothing.constraints.back_to_surface import BackToSurface
from vtksmooth.kernels.smoothing.constraints.blend import Blend
from vtksmooth.kernels.smoothing.constraints.boundary import Boundary
from vtksmooth.kernels.smoothing.constraints.containment import Containment
from vtksmooth.kernels.smoothing.constraints.creases import Creases
from vtksmooth.kernels.smoothing.constraints.curvature_bound import CurvatureBound
from vtksmooth.kernels.smoothing.constraints.deviation_bound import DeviationBound
from vtksmooth.kernels.smoothing.constraints.directions import Directions
from vtksmooth.kernels.smoothing.constraints.displacement_bound import DisplacementBound
from vtksmooth.kernels.smoothing.constraints.feature_lines import FeatureLines
from vtksmooth.kernels.smoothing.constraints.fixed import Fixed
from vtksmooth.kernels.smoothing.constraints.gate import Gate
from vtksmooth.kernels.smoothing.constraints.local_volume import LocalVolume
from vtksmooth.kernels.smoothing.constraints.no_inversion import NoInversion
from vtksmooth.kernels.smoothing.constraints.null_space import NullSpace
from vtksmooth.kernels.smoothing.constraints.on_source import OnSource
from vtksmooth.kernels.smoothing.constraints.self_intersection import NoNewSelfIntersections
from vtksmooth.kernels.smoothing.constraints.smoothed_boundary import SmoothedBoundary
from vtksmooth.kernels.smoothing.constraints.tangent_plane import TangentPlane
from vtksmooth.kernels.smoothing.phases import Disposal
from vtksmooth.kernels.smoothing.schemes import EdgeScheme, Scheme
from vtksmooth.kernels.smoothing.schemes.angle_based import AngleBased
from vtksmooth.kernels.smoothing.schemes.equilateral import Equilateral
from vtksmooth.kernels.smoothing.schemes.feature_preserving import FeaturePreserving
from vtksmooth.kernels.smoothing.schemes.pairwise import Pairwise
from vtksmooth.kernels.smoothing.schemes.trapezium import TrapeziumDrawing
from vtksmooth.kernels.smoothing.schemes.umbrella import Umbrella

Random = np.random.Generator

#: What each phase does, for people.
_PHASES = {
    Phase.PIN: "holds points",
    Phase.DIRECT: "turns steps",
    Phase.SCALE: "takes a part of each step",
    Phase.RETRACT: "puts points on a surface",
    Phase.LIMIT: "shortens steps",
    Phase.CONSERVE: "corrects steps",
    Phase.JUDGE: "accepts or refuses steps",
    Phase.LOOK: "takes steps back",
}


_ABOVE = """Any scheme can have any constraint, and every constraint keeps its promise in the company of
all others, but for the pairs that this table names: these are refused in one sentence, before anything moves
({refused} of {pairs} pairs). The scheme pairwise moves both ends of an edge at once and keeps the volume by
itself; constraints that turn the step of one point, or put it on a surface, are refused with it."""

_BELOW = """Measured by `python benchmarks/promises.py`: {runs:,} runs on random meshes (closed and open, of
triangles, quadrilaterals and both, up to a few hundred faces), each with a random scheme and two to five
constraints; afterwards each promise is measured from scratch, on the points before and after. A run is
refused where the table says so, or where exact containment meets faces that are no triangles."""


def _space(mesh: Mesh) -> SignedDistanceTree:
    # Its walls touch the outermost points.
    used = mesh.points[mesh.used_points]
    low, high = used.min(axis=0), used.max(axis=0)
    high = np.maximum(high, low + 1e-3 * mesh.diagonal)
    box = pv.Box(tuple(np.column_stack((low, high)).ravel())).triangulate()
    return SignedDistanceTree(surface_of(box).mesh)


def _source(mesh: Mesh, random: Random) -> OnSource:
    thrown = 0.02 * mesh.diagonal * random.normal(size=mesh.points.shape)
    other = mesh.with_points(mesh.points + thrown)
    return OnSource(other, detect(other, adjacency.build(other)))


def _directions(mesh: Mesh, random: Random) -> Directions:
    axis, vertex = int(random.integers(3)), mesh.points[int(random.integers(mesh.n_points))]
    planes = [(axis, float(vertex[axis]))] if random.random() < 0.5 else []
    if random.random() < 0.4:
        return Directions(about=axis, center=random.normal(size=3), planes=planes)
    return Directions(str(random.choice(["x", "z", "xy", "yz", "xyz"])), planes=planes)


#: Makes each constraint for a mesh, with numbers from a generator.
CONSTRAINTS: dict[str, Callable[[Mesh, Random], Constraint]] = {
    "fixed": lambda mesh, random: Fixed(random.random(mesh.n_points) < 0.2),
    "blend": lambda mesh, random: Blend(random.choice([0.0, 0.3, 1.0], mesh.n_points)),
    "displacement": lambda mesh, random: DisplacementBound(
        mesh.diagonal * random.choice([0.0, 0.002, 0.02, np.inf], mesh.n_points)
    ),
    "fixed boundary": lambda mesh, random: Boundary(sliding=False),
    "sliding boundary": lambda mesh, random: Boundary(sliding=True),
    "smoothed boundary": lambda mesh, random: SmoothedBoundary(random.choice([30.0, 180.0])),
    "features held": lambda mesh, random: FeatureLines(sliding=False),
    "features slide": lambda mesh, random: FeatureLines(sliding=True),
    "null space": lambda mesh, random: NullSpace(),
    "tangent plane": lambda mesh, random: TangentPlane(),
    "back to surface": lambda mesh, random: BackToSurface(),
    "source": lambda mesh, random: _source(mesh, random),
    "directions": lambda mesh, random: _directions(mesh, random),
    "creases": lambda mesh, random: Creases(random.uniform(10.0, 60.0)),
    "deviation": lambda mesh, random: DeviationBound(mesh.diagonal * 10.0 ** random.uniform(-4, -1)),
    "curvature": lambda mesh, random: CurvatureBound(mesh.diagonal * random.uniform(0.1, 1.0)),
    "space": lambda mesh, random: Containment(_space(mesh), 1e-9 * mesh.diagonal),
    "exact space": lambda mesh, random: Containment(_space(mesh), 1e-9 * mesh.diagonal, exact=True),
    "no inversion": lambda mesh, random: NoInversion(),
    "volume": lambda mesh, random: LocalVolume(int(random.integers(0, 3))),
    "self-intersection": lambda mesh, random: NoNewSelfIntersections(),
    "gate": lambda mesh, random: Gate(str(random.choice(["aspect", "floor", "angle"]))),
}

#: Two ways of one parameter.
_ALTERNATIVES = [
    {"fixed boundary", "sliding boundary", "smoothed boundary"},
    {"features held", "features slide"},
    {"space", "exact space"},
    {"back to surface", "source"},
]


def schemes() -> dict[str, Scheme]:
    """Return all schemes with their usual parameters."""
    made = {name: Laplacian(scheme=name).make_scheme() for name in SCHEMES}
    others = {
        "trapezium-drawing": TrapeziumDrawing(),
        "angle-based": AngleBased(),
        "equilateral": Equilateral(),
        "feature-preserving": FeaturePreserving(),
        "umbrella, implicit": Laplacian(implicit_step=4.0).make_scheme(),
        "thin-plate, implicit": Laplacian(scheme="thin-plate", implicit_step=2.0).make_scheme(),
    }
    return made | others


def _refused(scheme: Scheme, constraints: Sequence[Constraint]) -> str:
    try:
        Disposal(constraints, scheme.keeps, isinstance(scheme, EdgeScheme))
    except ParameterError as error:
        return str(error)
    return ""


def declared() -> list[str]:
    """Return the table of the constraints, by their declarations alone."""
    plain = surface_of(pv.Sphere(theta_resolution=6, phi_resolution=6)).mesh
    made = {name: make(plain, np.random.default_rng(0)) for name, make in CONSTRAINTS.items()}
    rows = []
    for name, one in made.items():
        refusing = [
            str(other).lower()
            for another, other in made.items()
            if {name, another} not in _ALTERNATIVES and name != another and _refused(Umbrella(), [one, other])
        ]
        pairwise = "refused" if _refused(Pairwise(), [one]) else "kept by itself"
        if one.topic not in Pairwise.keeps and pairwise != "refused":
            pairwise = "yes"
        exact = ", triangles too" if name == "exact space" else ""
        rows.append([f"{one}{exact}", _PHASES[one.phase], ", ".join(refusing) or "all", pairwise])
        if refusing:
            rows[-1][2] = "all but " + rows[-1][2]
    lines = tables.table(["constraint", "what it does", "goes with", "with the scheme pairwise"], rows)
    return [line.replace("---:", "---") for line in lines]


def random_mesh(random: Random) -> pv.PolyData:
    """Return a small mesh, closed or open, of triangles or quadrilaterals or both, rough."""
    kind = int(random.integers(5))
    if kind == 0:
        mesh = pv.Icosphere(nsub=2)
    elif kind == 1:
        mesh = pv.ParametricTorus(
            u_res=int(random.integers(6, 14)), v_res=int(random.integers(5, 10))
        ).clean()
    elif kind == 2:
        cells = np.zeros((5, 5, 5), np.uint8)
        cells[1:-1, 1:-1, 1:-1] = random.random((3, 3, 3)) < 0.6
        cells[2, 2, 2] = 1
        grid = pv.ImageData(dimensions=(6, 6, 6))
        grid.cell_data["cells"] = cells.ravel(order="F")
        mesh = grid.threshold(0.5, scalars="cells").extract_surface(algorithm="dataset_surface").clean()
    elif kind == 3:
        mesh = pv.Plane(i_resolution=int(random.integers(3, 9)), j_resolution=int(random.integers(3, 9)))
    else:
        mesh = pv.Cylinder(resolution=int(random.integers(5, 12)), capping=bool(random.integers(2))).clean()
    mesh = pv.PolyData(np.asarray(mesh.points, float), mesh.faces)
    if random.random() < 0.4:
        mesh = mesh.triangulate()
    used = surface_of(mesh).mesh
    edge = used.diagonal / max(2.0, np.sqrt(used.n_faces))
    rough = random.uniform(0.0, 0.4) * edge * random.normal(size=mesh.points.shape)
    if kind == 3:
        # Borders stay straight, so that they can slide.
        low, high = mesh.points.min(axis=0), mesh.points.max(axis=0)
        rough[((mesh.points == low) | (mesh.points == high))[:, :2].any(axis=1)] = 0.0
    mesh.points = mesh.points + rough
    return mesh


def run(number: int, seed: int, named: dict[str, Scheme], only: str | None) -> tuple[str, str, list[str]]:
    """Do one run; return the scheme, what came of it, and the promises that were broken."""
    random = np.random.default_rng((seed, number))
    polydata = random_mesh(random)
    name = str(random.choice(list(named)))
    if only not in (None, name):
        return name, "left out", []
    if isinstance(named[name], EdgeScheme):  # these need triangles
        polydata = polydata.triangulate()
    mesh = surface_of(polydata).mesh
    chosen = random.choice(list(CONSTRAINTS), int(random.integers(2, 6)), replace=False).tolist()
    for two in _ALTERNATIVES:
        if two <= set(chosen):
            chosen.remove(min(two))
    constraints = [CONSTRAINTS[constraint](mesh, random) for constraint in chosen]
    try:
        points, report = loop.smooth(
            mesh, named[name], constraints, iterations=int(random.integers(1, 10)), checked=True
        )
    except (ParameterError, InvalidMeshError):
        return name, "refused", []
    broken = list(report.broken)
    if not np.isfinite(points).all():
        broken.append("points are not finite")
    return name, "broken" if broken else "kept", [f"{number} {name} {chosen}: {said}" for said in broken]


def main(arguments: Sequence[str] | None = None) -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description="Check the promises of random sets of constraints.")
    parser.add_argument("--runs", type=int, default=20_000)
    parser.add_argument("--first", type=int, default=0, help="number of the first run")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--scheme", help="do only the runs that have this scheme")
    parser.add_argument("--output", type=Path, default=Path("docs/promises.md"))
    options = parser.parse_args(arguments)
    named = schemes()
    counts = {name: Counter[str]() for name in named}
    found: list[str] = []
    for number in range(options.first, options.first + options.runs):
        name, what, broken = run(number, options.seed, named, options.scheme)
        counts[name][what] += 1
        found += broken
        for said in broken:
            print(said, flush=True)
    made = [CONSTRAINTS[name](surface_of(pv.Sphere()).mesh, np.random.default_rng(0)) for name in CONSTRAINTS]
    pairs = [
        (one, other)
        for (a, one), (b, other) in combinations(zip(CONSTRAINTS, made, strict=True), 2)
        if {a, b} not in _ALTERNATIVES
    ]
    refused = sum(bool(_refused(Umbrella(), pair)) for pair in pairs)
    kinds = ("kept", "refused", "broken")
    rows = [[name, *(f"{count[kind]:,}" for kind in kinds)] for name, count in counts.items()]
    total = sum(counts.values(), Counter[str]())
    rows.append(["all", *(f"{total[kind]:,}" for kind in kinds)])
    above, below = _ABOVE.format(refused=refused, pairs=len(pairs)), _BELOW.format(runs=options.runs)
    lines = ["# What goes together", "", *textwrap.wrap(above, 100), "", *declared()]
    lines += [*textwrap.wrap(below, 100), "", *tables.table(["scheme", *kinds], rows)]
    options.output.write_text("\n".join(lines).rstrip() + "\n", encoding="utf-8")
    sys.exit(bool(found))


if __name__ == "__main__":
    main()
