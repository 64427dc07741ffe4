"""What filters promise, checked from outside: with NumPy where possible, else by what they measure."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import odd_meshes
import pyvista as pv
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkCompositeDataSet, vtkDataObjectTreeIterator, vtkPolyData

from vtksmooth.errors import Cancelled, InvalidMeshError, VtksmoothError
from vtksmooth.filters import (
    FILTERS,
    ContainmentCheck,
    FeatureDetection,
    InstallationSpaceRegions,
    InstallationSpaceSmoothing,
    LaplacianSmoothing,
    Parameter,
    RegionMarking,
    SelfIntersection,
    SmoothingFilter,
    SurfaceComparison,
    SurfaceQuality,
    ValenceTriangulation,
)
from vtksmooth.filters.usual_measures import USUAL_MEASURES

Random = np.random.Generator
Float64 = npt.NDArray[np.float64]

#: Arrays that filters write, and may replace.
_WRITTEN = {
    "AspectRatio", "NormalDeviation", "DihedralChange", "Displacement", "Deviation", "FeatureClass",
    "RidgeNeighbours", "EigenvalueRatios", "Fixed", "BlendWeight", "OriginalCell", "SignedDistance",
    "AddedFeatureEdges", "RemovedFeatureEdges", *USUAL_MEASURES,
}  # fmt: skip

#: Parameters by which a constraint is switched on, and the values that leave it off.
_CONSTRAINTS = {
    "features": ("ignore",),
    "crease_angle": (None,),
    "gate": ("none",),
    "max_deviation_fraction": (None,),
    "null_space": (False,),
    "corrections": (0,),
    "preserve_volume": (False,),
    "tangent_plane": (False,),
    "back_to_surface": (False,),
    "containment": ("none", None),
    "curvature_radius": (None,),
}


@dataclass(frozen=True)
class Finding:
    """Something that is wrong.

    Attributes
    ----------
    kind : str
    where : str
        The filter or the command.
    text : str
    meets : bool
        Whether it is a promise that another constraint of the same run may have broken.
    """

    kind: str
    where: str
    text: str
    meets: bool = False


# -------------------------------------------------------------------------------------- parameters


def _number(random: Random, parameter: Parameter) -> Any:
    low = 0.0 if parameter.low is None else parameter.low
    if parameter.type is int:
        return int(low + random.choice([0, 1, 2, 3, 5, 10]))
    high = parameter.high
    if random.random() < 0.3:  # the ends
        ends = [low, float(np.nextafter(low, np.inf)), 1e300 if high is None else high]
        return float(random.choice(ends))
    if high is None:
        return float(low + 10.0 ** random.uniform(-8, 2))
    return float(random.uniform(low, high))


def _points(random: Random, n: int) -> str:
    if random.random() < 0.2 or n == 0:
        return str(
            random.choice(["all", "0", f"0-{n}", f"{max(0, n - 1)}", "7-3", "x", "0-99999999999", "bits:x"])
        )
    a = int(random.integers(n))
    return f"{a},{a // 2}-{a}"


def _lines(random: Random, mesh: Any) -> str:
    n = mesh.GetNumberOfPoints()
    if isinstance(mesh, vtkPolyData) and mesh.GetNumberOfPolys() and random.random() < 0.7:
        corners = vtk_to_numpy(mesh.GetPolys().GetConnectivityArray())
        return "-".join(map(str, corners[:2].tolist()))
    return str(random.choice(["0-1", "0", f"0-{n}", "a-b", "1-1", "99999999999-0", "-1"]))


def _array(random: Random, mesh: Any, name: str, default: str | None) -> str | None:
    if random.random() < 0.05:
        return str(random.choice(["none such", "é", "Normals", "labels"]))
    wanted = "Flow" if name == "flow" else default or "Fixed"
    there = isinstance(mesh, vtkPolyData) and any(
        data.HasArray(wanted) for data in (mesh.GetPointData(), mesh.GetCellData(), mesh.GetFieldData())
    )
    return wanted if there else default


def random_parameters(random: Random, cls: type, mesh: Any) -> dict[str, Any]:
    """Return legal values for some of a filter's parameters, the ends of their ranges among them."""
    values: dict[str, Any] = {}
    share = random.choice([0.0, 0.1, 0.35, 0.8])
    for name, parameter in cls.parameters().items():
        if name == "iterations":
            values[name] = int(random.choice([0, 1, 2, 5, 20]))
        elif random.random() > share:
            continue
        elif parameter.optional and random.random() < 0.3:
            values[name] = None
        elif parameter.automatic and random.random() < 0.5:
            values[name] = "auto"
        elif parameter.choices:
            values[name] = str(random.choice(parameter.choices))
        elif parameter.type is bool:
            values[name] = bool(random.random() < 0.5)
        elif parameter.type is not str:
            values[name] = _number(random, parameter)
        elif parameter.text == "points":
            values[name] = _points(random, mesh.GetNumberOfPoints())
        elif parameter.text == "lines":
            values[name] = _lines(random, mesh)
        elif parameter.text == "coordinates":
            values[name] = ",".join(f"{x:.3g}" for x in random.normal(size=3))
        elif parameter.text == "planes":
            values[name] = str(random.choice(["x=0", "z=0.5", "x=0,y=1", "y=-0.25,z=0"]))
        else:
            values[name] = _array(random, mesh, name, parameter.default)
    if random.random() < 0.9:  # otherwise they are refused, if one has no effect
        _drop_what_has_no_say(cls, values)
    return values


def _in_space(cls: type, values: dict[str, Any]) -> bool:
    """Return whether a filter is given the installation space that it may have: if its values speak of it."""
    return bool(cls.optional_inputs) and not values.keys().isdisjoint({"containment", "tolerance_fraction"})


def _drop_what_has_no_say(cls: type, values: dict[str, Any]) -> None:
    parameters = cls.parameters()

    def value_of(name: str) -> Any:
        if name not in parameters:  # an optional input
            return _in_space(cls, values) or None
        return values.get(name, parameters[name].default)

    while idle := [name for name in values if not parameters[name].has_say(value_of)]:
        for name in idle:
            del values[name]


# --------------------------------------------------------------------------------------- snapshots


def _leaves(data: Any) -> Iterator[Any]:
    if not isinstance(data, vtkCompositeDataSet):
        yield data
        return
    leaves = vtkDataObjectTreeIterator()
    leaves.SetDataSet(data)
    leaves.SkipEmptyNodesOff()
    leaves.VisitOnlyLeavesOn()
    leaves.InitTraversal()
    while not leaves.IsDoneWithTraversal():
        yield leaves.GetCurrentDataObject()
        leaves.GoToNextItem()


def _bytes(array: Any) -> Any:
    if array is None:
        return None
    if array.IsA("vtkStringArray"):
        return tuple(array.GetValue(i) for i in range(array.GetNumberOfValues()))
    if array.IsA("vtkBitArray") or not array.IsNumeric():
        return tuple(array.GetTuple1(i) for i in range(array.GetNumberOfTuples()))
    values = vtk_to_numpy(array)
    return values.dtype.str, values.shape, values.tobytes()


def _arrays(data: Any) -> dict[Any, Any]:
    arrays = [data.GetAbstractArray(i) for i in range(data.GetNumberOfArrays())]
    found = {array.GetName(): _bytes(array) for array in arrays if array.GetName()}
    nameless = [_bytes(array) for array in arrays if not array.GetName()]
    return {**found, **dict(enumerate(nameless))}


def _lists(cells: Any) -> tuple[bytes, bytes]:
    n = cells.GetNumberOfCells()
    sizes = [cells.GetCellSize(i) for i in range(n)]
    corners = []
    if cells.GetNumberOfConnectivityIds():
        one = odd_meshes.vtkCellArray()
        one.DeepCopy(cells)
        one.ConvertToDefaultStorage() if hasattr(
            one, "ConvertToDefaultStorage"
        ) else one.ConvertTo64BitStorage()
        corners = vtk_to_numpy(one.GetConnectivityArray()).astype(np.int64)
    return np.array(sizes, np.int64).tobytes(), np.asarray(corners, np.int64).tobytes()


_CELLS = ("Verts", "Lines", "Polys", "Strips")


def snapshot(data: Any) -> list[Any]:
    """Return all that a data object holds, so that two of them can be compared."""
    made: list[Any] = []
    for leaf in _leaves(data):
        if not isinstance(leaf, vtkPolyData):
            made.append(None if leaf is None else leaf.GetClassName())
            continue
        points = leaf.GetPoints()
        made.append(
            {
                "points": None if points is None else _bytes(points.GetData()),
                "cells": {name: _lists(getattr(leaf, f"Get{name}")()) for name in _CELLS},
                "point data": _arrays(leaf.GetPointData()),
                "cell data": _arrays(leaf.GetCellData()),
                "field data": _arrays(leaf.GetFieldData()),
            }
        )
    return made


# ------------------------------------------------------------------------------ numpy's own measures


@dataclass
class Plain:
    """A mesh as arrays, its strips as triangles."""

    points: Float64
    faces: list[list[int]]

    @property
    def triangles(self) -> npt.NDArray[np.int64] | None:
        """The faces, if all are triangles with three different corners."""
        if not all(len(set(face)) == len(face) == 3 for face in self.faces):
            return None
        return np.array(self.faces, np.int64).reshape(-1, 3)

    @property
    def used(self) -> npt.NDArray[np.int64]:
        """The points of faces."""
        return np.unique([p for face in self.faces for p in face]).astype(np.int64)


def _cell_lists(cells: Any) -> list[list[int]]:
    sizes, corners = (np.frombuffer(one, np.int64) for one in _lists(cells))
    ends = np.cumsum(sizes)
    return [corners[end - size : end].tolist() for size, end in zip(sizes, ends, strict=True)]


def plain(mesh: vtkPolyData) -> Plain:
    """Return a polydata as arrays."""
    points = mesh.GetPoints()
    places = np.empty((0, 3)) if points is None else vtk_to_numpy(points.GetData()).astype(np.float64)
    faces = _cell_lists(mesh.GetPolys())
    for strip in _cell_lists(mesh.GetStrips()):
        for i in range(len(strip) - 2):
            a, b, c = strip[i : i + 3]
            faces.append([b, a, c] if i % 2 else [a, b, c])
    return Plain(places.reshape(-1, 3), faces)


def distance_to(points: Float64, corners: Float64) -> Float64:
    """Return the distance of points, (n, 3), to triangles, (m, 3, 3), by brute force."""
    a, ab, ac = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    least = np.full(len(points), np.inf)
    normal = np.cross(ab, ac)
    area = np.einsum("ij,ij->i", normal, normal)
    for i, p in enumerate(points):
        ap = p - a
        best = np.inf
        with np.errstate(divide="ignore", invalid="ignore"):
            u = np.einsum("ij,ij->i", np.cross(ap, ac), normal) / area
            v = np.einsum("ij,ij->i", np.cross(ab, ap), normal) / area
            height = np.abs(np.einsum("ij,ij->i", ap, normal)) / np.sqrt(area)
        over = (u >= 0) & (v >= 0) & (u + v <= 1) & (area > 0)
        if over.any():
            best = float(height[over].min())
        for start, end in ((0, 1), (1, 2), (2, 0)):
            edge = corners[:, end] - corners[:, start]
            length = np.einsum("ij,ij->i", edge, edge)
            t = np.einsum("ij,ij->i", p - corners[:, start], edge) / np.where(length > 0, length, 1)
            foot = corners[:, start] + np.clip(t, 0, 1)[:, None] * edge
            best = min(best, float(np.linalg.norm(p - foot, axis=1).min()))
        least[i] = best
    return least


def closed_bodies(mesh: Plain) -> list[npt.NDArray[np.int64]] | None:
    """Return the triangles of the bodies that are closed 2-manifolds of one orientation.

    Points in one place are one point. None where not all faces are triangles.
    """
    if mesh.triangles is None or len(mesh.triangles) == 0:
        return None
    _, same = np.unique(mesh.points + 0.0, axis=0, return_inverse=True)
    triangles = same.ravel()[mesh.triangles]
    root = np.arange(len(mesh.points))

    def find(p: int) -> int:
        while root[p] != p:
            root[p] = root[root[p]]
            p = root[p]
        return p

    for triangle in triangles.tolist():
        for p in triangle[1:]:
            root[find(p)] = find(triangle[0])
    body = np.array([find(p) for p in triangles[:, 0].tolist()])
    bodies = []
    for number in np.unique(body):
        mine = triangles[body == number]
        ends = np.vstack([mine[:, [i, (i + 1) % 3]] for i in range(3)])
        pairs, counts = np.unique(ends, axis=0, return_counts=True)
        if (counts == 1).all() and {(a, b) for a, b in pairs.tolist()} == {(b, a) for a, b in pairs.tolist()}:
            bodies.append(mesh.triangles[body == number])
    return bodies


def volume(points: Float64, triangles: npt.NDArray[np.int64]) -> float:
    """Return the volume of a closed body."""
    corners = points[triangles] - points[triangles].reshape(-1, 3).mean(axis=0)
    return float(np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6)


def _area(corners: Float64) -> float:
    spans = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return 0.5 * float(np.linalg.norm(spans, axis=1).sum())


def places(points: Float64) -> npt.NDArray[np.int64]:
    """Return the number of the place of each point, (n,); 0.0 and -0.0 are one."""
    return np.unique(points + 0.0, axis=0, return_inverse=True)[1].ravel()


def boundary_points(mesh: Plain) -> npt.NDArray[np.int64]:
    """Return the points on edges that one face has."""
    counts: dict[tuple[int, int], int] = {}
    for face in mesh.faces:
        for a, b in zip(face, [*face[1:], *face[:1]], strict=True):
            key = (min(a, b), max(a, b))
            counts[key] = counts.get(key, 0) + 1
    ends = [p for edge, count in counts.items() if count == 1 and edge[0] != edge[1] for p in edge]
    return np.unique(ends).astype(np.int64)


def inner_edges(triangles: npt.NDArray[np.int64]) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Return the ends of edges that two triangles have, one in each direction, and these triangles."""
    found: dict[tuple[int, int], list[int]] = {}
    for number, (a, b, c) in enumerate(triangles.tolist()):
        for edge in ((a, b), (b, c), (c, a)):
            found.setdefault(edge, []).append(number)
    both = [
        (edge, sides[0], found[edge[::-1]][0])
        for edge, sides in found.items()
        if edge[0] < edge[1] and len(sides) == len(found.get(edge[::-1], ())) == 1
    ]
    ends = np.array([edge for edge, _, _ in both], np.int64).reshape(-1, 2)
    return ends, np.array([sides for _, *sides in both], np.int64).reshape(-1, 2)


def dihedral_degrees(
    points: Float64,
    triangles: npt.NDArray[np.int64],
    ends: npt.NDArray[np.int64],
    faces: npt.NDArray[np.int64],
) -> tuple[Float64, npt.NDArray[np.bool_]]:
    """Return the signed angle between the normals of the faces of each edge, and whether it is clear."""
    corners = points[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    length = np.linalg.norm(normals, axis=1)
    clear = (length > 1e-6 * sides.max(axis=1) ** 2) & (sides.min(axis=1) > 1e-9)
    first, second = (normals[faces[:, side]] for side in (0, 1))
    along = points[ends[:, 1]] - points[ends[:, 0]]
    along /= np.maximum(np.linalg.norm(along, axis=1), 1e-300)[:, None]
    sine = (np.cross(first, second) * along).sum(axis=1)
    degrees = np.degrees(np.arctan2(sine, (first * second).sum(axis=1)))
    return degrees, clear[faces].all(axis=1)


# ------------------------------------------------------------------------------------------- checks


class Check:
    """One run of a filter on one polydata, and what is to be said of it."""

    def __init__(self, algorithm: Any, source: vtkPolyData, output: vtkPolyData, further: list[Any]) -> None:
        self.algorithm, self.source, self.output, self.further = algorithm, source, output, further
        self.where = type(algorithm).__name__
        self.before, self.after = plain(source), plain(output)
        self.findings: list[Finding] = []
        #: The surface that points are put on, if it is not the input's own.
        self.onto = further[1] if isinstance(algorithm, SmoothingFilter) and len(further) > 1 else None

    def say(self, kind: str, text: str, alone: bool = True) -> None:
        """Note a finding; not `alone`: another constraint was active."""
        self.findings.append(Finding(kind, self.where, text, not alone))

    def value(self, name: str) -> Any:
        """Return the value of a parameter or of what a filter has in its place."""
        return getattr(self.algorithm, name, None)

    def alone(self, *names: str) -> bool:
        """Say whether no constraints but these are on, and no arrays that constrain."""
        on = [
            name
            for name, off in _CONSTRAINTS.items()
            if hasattr(self.algorithm, name) and self.value(name) not in off
        ]
        return set(on) <= set(names) and (
            "max_displacement" in names or self.array(self.value("max_displacement")) is None
        )

    def array(self, name: str | None) -> npt.NDArray[Any] | None:
        """Return a point array of the input."""
        found = None if name is None else self.source.GetPointData().GetArray(name)
        return None if found is None else vtk_to_numpy(found)

    # -- what all filters keep

    def everything(self, before: Any, after: Any) -> None:
        """Compare what stays whatever the filter does."""
        cuts = isinstance(self.algorithm, (ValenceTriangulation, InstallationSpaceSmoothing))
        had = len(self.before.faces)
        if had and not self.after.faces:
            said = any("are left out" in note for note in self.algorithm.notes)
            if not (cuts and (said or all(len(face) < 3 for face in self.before.faces))):
                self.say("silent empty", f"{had} faces in, none out")
            return
        for name in _CELLS:
            if before["cells"][name] != after["cells"][name] and not (cuts and name in ("Polys", "Strips")):
                self.say("topology changed", name)
        if len(self.before.points) != len(self.after.points):
            self.say("topology changed", f"{len(self.before.points)} points in, {len(self.after.points)} out")
            return
        for home in ("point data", "cell data", "field data"):
            for name, values in before[home].items():
                if name in _WRITTEN or str(name).startswith("Smoothing") or name == "Normals":
                    continue
                if name not in after[home]:
                    self.say("array lost", f"{home}: {name!r}")
                elif not (cuts and home == "cell data") and after[home][name] != values:
                    self.say("array changed", f"{home}: {name!r}")
        finite = np.isfinite(self.before.points)
        if not np.isfinite(self.after.points[finite]).all():
            self.say("NaN", f"points: {int((~np.isfinite(self.after.points[finite])).sum())} coordinates")
        used = self.after.used
        data = self.output.GetPointData()
        for i in range(data.GetNumberOfArrays()):
            array = data.GetArray(i)
            name = "" if array is None else array.GetName() or ""
            if array is not None and (name in _WRITTEN or name == "Normals") and len(used):
                values = vtk_to_numpy(array)
                given = before["point data"].get(name)
                if given is None and len(values) > used.max() and not np.isfinite(values[used]).all():
                    self.say("NaN", f"point array {name!r}")

    # -- smoothing

    def smoothing(self) -> None:
        """Check what smoothing filters promise."""
        before, after = self.before, self.after
        precision = self.value("output_points_precision")
        kept = vtk_to_numpy(self.source.GetPoints().GetData())
        made = vtk_to_numpy(self.output.GetPoints().GetData())
        expected = {"single": np.float32, "double": np.float64}.get(precision, kept.dtype)
        if made.dtype != expected:
            self.say("precision", f"{made.dtype} points, {np.dtype(expected)} expected")
        report = self.algorithm.report
        exact = made.dtype == np.float64
        with np.errstate(over="ignore"):
            kept = kept.astype(made.dtype)
        moved = (kept != made).any(axis=1) & np.isfinite(kept).all(axis=1)
        place = places(kept)
        # Points in one place count as one, and move as one, unless nothing would be left of the faces.
        count = len(np.unique(place[moved])) if report.merged_points else int(moved.sum())
        if exact and count != report.moved and isinstance(self.source, vtkPolyData):
            self.say("report", f"{report.moved} vertices moved by the report, {count} in the output")
        if report.iterations > self.value("iterations"):
            self.say("report", f"{report.iterations} iterations, {self.value('iterations')} asked for")
        held = np.zeros(len(moved), bool)
        fixed = self.array(self.value("fixed"))
        if fixed is not None and fixed.ndim == 1:
            held |= fixed != 0
        if (moved & held).any():
            self.say("fixed points moved", f"{int((moved & held).sum())} of {int(held.sum())}")
        # Where points lie in one place the boundary is that of what they make together.
        if self.value("boundary") == "fixed" and len(np.unique(place)) == len(place):
            rim = boundary_points(before)
            if moved[rim].any():
                self.say("boundary moved", f"{int(moved[rim].sum())} of {len(rim)} points")
        if (
            self.value("relaxation_factor") == 0.0
            and moved.any()
            and self.onto is None  # on that points are put
            and self.value("scheme") not in _WITHOUT_FACTOR
        ):
            self.say("moved with relaxation 0", f"{int(moved.sum())} points", alone=False)
        used = before.used
        if not len(used) or not np.isfinite(before.points[used]).all():
            return
        size = float(np.ptp(before.points[used], axis=0).max())
        if not 1e-60 < size < 1e60:
            return
        rounding = np.abs(before.points[used]).max() * float(np.finfo(made.dtype).eps) * 4 + 1e-10 * size
        way = np.linalg.norm(after.points - before.points, axis=1)
        distances = self.array(self.value("max_displacement"))
        if distances is not None and distances.ndim == 1 and (way[used] > distances[used] + rounding).any():
            excess = float((way[used] - distances[used]).max() / size)
            self.say(
                "max_displacement exceeded",
                f"by {excess:.2g} of the size",
                self.alone("max_displacement", "gate"),
            )
        self.surface(size, rounding, moved, used)
        self.elements(exact, report)
        if exact and self.value("crease_angle") is not None:
            self.creases(size)
        cut = isinstance(self.algorithm, InstallationSpaceSmoothing) and self.before.triangles is None
        if self.value("self_intersection") == "none-new" and self.distinct() and not cut:
            self.crossings()
        self.volumes(size, rounding, report)

    def surface(self, size: float, rounding: float, moved: npt.NDArray[np.bool_], used: Any) -> None:
        """Check what keeps points at the original surface."""
        bound, stop = self.value("max_deviation_fraction"), self.value("stop_deviation_fraction")
        back = self.value("back_to_surface")
        triangles = self.before.triangles
        if self.onto is not None:
            back = False
            self.on_source(plain(self.onto), size, rounding, moved, used)
        if triangles is None or not len(triangles) or (bound is None and stop is None and not back):
            return
        some = used[moved[used]][:40]
        if not len(some):
            return
        corners = (self.before.points - self.before.points[used[0]])[triangles] / size
        away = distance_to((self.after.points[some] - self.before.points[used[0]]) / size, corners)
        largest, slack = float(away.max()), rounding / size + 1e-9
        diagonal = float(np.linalg.norm(np.ptp(self.before.points[used], axis=0))) / size
        if bound is not None and largest > bound * diagonal * (1 + 1e-9) + slack:
            self.say(
                "max_deviation_fraction exceeded",
                f"{largest / diagonal:.3g}, bound {bound:.3g}",
                self.alone("max_deviation_fraction", "gate", "tangent_plane"),
            )
        if back and largest > slack:
            self.say(
                "off the surface",
                f"by {largest:.2g} of the size",
                self.alone("back_to_surface", "tangent_plane", "gate"),
            )
        if (
            stop is not None
            and self.value("stop_statistic") == "max"
            and largest > stop * diagonal * (1 + 1e-9) + slack
        ):
            self.say("stop_deviation_fraction exceeded", f"{largest / diagonal:.3g}, bound {stop:.3g}")

    def on_source(
        self, onto: Plain, size: float, rounding: float, moved: npt.NDArray[np.bool_], used: Any
    ) -> None:
        """Check that the points that moved are on the source."""
        some = used[moved[used]][:40]
        triangles = onto.triangles
        if not len(some) or triangles is None:
            return
        origin = self.before.points[used[0]]
        away = distance_to(
            (self.after.points[some] - origin) / size, ((onto.points - origin) / size)[triangles]
        )
        if away.max() > rounding / size + 1e-9:
            self.say("off the source", f"by {away.max():.2g} of the size", self.alone("tangent_plane"))

    def elements(self, exact: bool, report: Any) -> None:
        """Check what gates promise of elements, by the k that SurfaceComparison measures."""
        gate, null_space = self.value("gate"), self.value("null_space")
        if not exact or isinstance(self.algorithm, InstallationSpaceSmoothing):
            return
        if gate not in ("aspect", "floor") and not null_space and self.value("crease_angle") is None:
            return
        # Ghosts, blocks and arrays do not matter to what is measured here.
        k = []
        for mesh in (self.source, self.output):
            measured = SurfaceComparison()(mesh, self.source)
            values = vtk_to_numpy(measured.GetCellData().GetArray("AspectRatio"))
            k.append(values[self.source.GetNumberOfVerts() + self.source.GetNumberOfLines() :])
        inverted = [int((one < -1e-12).sum()) for one in k]
        together = self.alone("gate", "tangent_plane")
        # Of faces that cover each other one side is smoothed; k here is that of all.
        apart = self.distinct()
        if gate in ("aspect", "floor") and apart:
            least = [float(one.min()) for one in k]
            floor = least[0] if gate == "aspect" else min(least[0], self.value("gate_floor"))
            if least[1] < floor - 1e-9:
                self.say(f"gate={gate}: k lowered", f"{least[0]:.6g} -> {least[1]:.6g}", together)
            if inverted[1] > inverted[0]:
                self.say(f"gate={gate}: inverted", f"{inverted[0]} -> {inverted[1]} faces", together)
        elif null_space and apart and ((k[1] < -1e-9) & (k[0] > 1e-9)).any():
            self.say(
                "null space: inverted", f"{inverted[0]} -> {inverted[1]} faces",
                self.alone("null_space", "corrections", "preserve_volume", "features"),
            )  # fmt: skip

    def distinct(self) -> bool:
        """Return whether no points lie in one place, and no faces cover each other."""
        faces = {tuple(sorted(face)) for face in self.before.faces}
        return len(faces) == len(self.before.faces) and len(np.unique(places(self.before.points))) == len(
            self.before.points
        )

    def crossings(self) -> None:
        """Check that no faces cross or touch that did not; the measure's tests are in rational numbers."""
        pairs: list[dict[tuple[int, ...], int]] = []
        # What writing in single precision makes of the input is not the filter's.
        written = pv.wrap(self.source).copy()
        written.points = written.points.astype(vtk_to_numpy(self.output.GetPoints().GetData()).dtype)
        for mesh in (written, self.output):
            made = SelfIntersection()(mesh).GetFieldData()
            found = {}
            for level, name in enumerate(("TouchingCells", "CrossingCells"), 1):
                for pair in vtk_to_numpy(made.GetArray(name)).reshape(-1, 2).tolist():
                    found[tuple(pair)] = level
            pairs.append(found)
        new = [pair for pair, level in pairs[1].items() if level > pairs[0].get(pair, 0)]
        if new:
            self.say("new self-intersections", f"{len(new)} pairs, one of cells {new[0]}", self.alone())

    def creases(self, size: float) -> None:
        """Check that edges that were sharp are, where slivers do not leave that to rounding."""
        triangles, angle = self.before.triangles, self.value("crease_angle")
        # Of faces that cover each other one is smoothed: its edges may be those of a boundary. Ghost cells
        # are left out, which makes boundaries, too.
        ghosts = self.source.GetCellData().GetArray("vtkGhostType")
        if triangles is None or not self.distinct() or (ghosts is not None and vtk_to_numpy(ghosts).any()):
            return
        ends, faces = inner_edges(triangles)
        degrees, clear = zip(
            *(
                dihedral_degrees(mesh.points / size, triangles, ends, faces)
                for mesh in (self.before, self.after)
            ),
            strict=True,
        )
        sharp = clear[0] & clear[1] & (np.abs(degrees[0]) > angle + 1e-4)
        now = np.sign(degrees[0][sharp]) * degrees[1][sharp]
        # An angle of 180 degrees has no sign.
        flat = (now < angle - 1e-4) & (np.abs(degrees[0][sharp]) < 179.0)
        if flat.any():
            self.say(
                "creases flattened",
                f"{int(flat.sum())} of {len(flat)}, one to {now[flat].min():.4g} degrees, bound {angle:.4g}",
                self.alone("crease_angle", "gate", "tangent_plane"),
            )

    def volumes(self, size: float, rounding: float, report: Any) -> None:
        """Check the volume of closed bodies."""
        keeps = self.value("preserve_volume") or (
            self.value("scheme") == "pairwise" and self.value("implicit_step") is None
        )
        bound = self.value("stop_volume_percent")
        bodies = closed_bodies(self.before) if keeps or bound is not None else None
        if not bodies:
            return
        for triangles in bodies:
            # Rounding gives faces without an area one.
            area = max(_area(each.points[triangles]) for each in (self.before, self.after))
            was, is_ = volume(self.before.points, triangles), volume(self.after.points, triangles)
            slack = area * (rounding - 1e-10 * size + 1e-13 * size) * (1 + report.iterations)
            slack += 1e-15 * size**3  # of the sum itself
            if keeps and abs(is_ - was) > slack:
                change = abs(is_ - was) / max(abs(was), 1e-300)
                self.say(
                    "volume not kept", f"relative change {change:.2g}",
                    self.alone("null_space", "corrections", "preserve_volume", "features", "gate",
                               "containment", "curvature_radius"),
                )  # fmt: skip
            whole = len(bodies) == 1 and len(triangles) == len(self.before.faces)
            if bound is not None and whole and abs(is_ - was) > bound / 100 * abs(was) * (1 + 1e-9) + slack:
                self.say("stop_volume_percent exceeded", f"{was:.6g} -> {is_:.6g}, bound {bound:.3g} %")

    # -- the others

    def quality(self) -> None:
        """Check that k is a finite number from -1 to 1, for every cell."""
        k = vtk_to_numpy(self.output.GetCellData().GetArray("AspectRatio"))
        if len(k) != self.source.GetNumberOfCells():
            self.say("array length", f"{len(k)} values for {self.source.GetNumberOfCells()} cells")
        if not (np.isfinite(k).all() and (np.abs(k) <= 1 + 1e-12).all()):
            self.say("k out of its range", f"{np.nanmin(k):.6g} to {np.nanmax(k):.6g}")
        self.numbers(self.algorithm.summary)

    def numbers(self, summary: dict[str, Any], path: str = "") -> None:
        """No number of a summary is NaN or infinite."""
        for name, value in summary.items():
            if isinstance(value, dict):
                self.numbers(value, f"{path}{name}.")
            elif isinstance(value, float) and not np.isfinite(value):
                self.say("NaN", f"summary: {path}{name}")

    def comparison(self) -> None:
        """Check that what did not change has not changed."""
        self.quality()
        if np.array_equal(self.before.points, plain(self.further[0]).points):
            for name in ("NormalDeviation", "Displacement", "DihedralChange"):
                if vtk_to_numpy(self.output.GetPointData().GetArray(name)).any():
                    self.say("change where none is", name)

    def features(self) -> None:
        """Classes and neighbours along ridges are what they say."""
        classes = vtk_to_numpy(self.output.GetPointData().GetArray("FeatureClass"))
        ring = vtk_to_numpy(self.output.GetPointData().GetArray("RidgeNeighbours"))
        if not np.isin(classes, range(4)).all():
            self.say("classes", "other than 0 to 3")
        if not ((ring >= -1) & (ring < len(ring))).all():
            self.say("ridge neighbours", "points that are not there")
        self.numbers(self.algorithm.summary)

    def marking(self) -> None:
        """Check that the weight of every fixed point is 0."""
        fixed, weights = (self.output.GetPointData().GetArray(name) for name in ("Fixed", "BlendWeight"))
        if (
            fixed is not None
            and weights is not None
            and vtk_to_numpy(weights)[vtk_to_numpy(fixed) != 0].any()
        ):
            self.say("weights", "fixed points with a weight above 0")
        if sum(self.algorithm.summary[name] for name in ("fixed", "blended", "free")) != len(
            self.after.points
        ):
            self.say("summary", "fixed, blended and free are not all points")

    def triangulation(self) -> None:
        """Triangles only, as many as the polygons ask for; those of the input stay."""
        polygons = [face for face in self.before.faces if len(face) >= 3]
        if any(len(face) != 3 for face in self.after.faces):
            self.say("topology", "not only triangles")
        place = places(self.before.points)
        polygons = [face for face in polygons if len(set(place[list(face)])) == len(face)]
        plain_ones = len(polygons) == len(self.before.faces)
        if plain_ones and len(self.after.faces) != sum(len(face) - 2 for face in polygons):
            self.say("topology", f"{len(self.after.faces)} triangles of {len(polygons)} polygons")
        whole = {tuple(sorted(face)) for face in polygons if len(face) == 3}
        if not whole <= {tuple(sorted(face)) for face in self.after.faces}:
            self.say("topology", "triangles of the input are gone")
        if not np.array_equal(self.before.points, self.after.points, equal_nan=True):
            self.say("points moved", "")

    def containment(self) -> None:
        """Check that what was inside the space is inside it."""
        if isinstance(self.algorithm, SmoothingFilter):
            if not self.further or self.value("containment") == "none":
                return
            sides = []
            for mesh in (self.source, self.output):
                check = ContainmentCheck(tolerance_fraction=self.value("tolerance_fraction"))
                try:
                    made = check(mesh, self.further[0])
                except InvalidMeshError:  # what was outside may have shrunk away from the space
                    return
                sides.append(vtk_to_numpy(made.GetPointData().GetArray("SignedDistance")))
            used = self.before.used
            was, is_ = sides
            size = float(np.nanmax(np.abs(was[used])) + np.ptp(self.before.points[used], axis=0).max())
            single = vtk_to_numpy(self.output.GetPoints().GetData()).dtype == np.float32
            places = vtk_to_numpy(self.further[0].GetPoints().GetData()).astype(np.float64)
            diagonal = float(np.linalg.norm(np.nanmax(places, axis=0) - np.nanmin(places, axis=0)))
            slack = (2e-6 if single else 1e-6) * size + 2 * self.value("tolerance_fraction") * diagonal
            if single:  # far off the origin that is what rounding moves points by
                slack += float(np.finfo(np.float32).eps) * np.abs(self.before.points[used]).max()
            escaped = (was[used] <= slack) & (is_[used] > np.maximum(was[used], 0) + 2 * slack)
            if escaped.any():
                self.say(
                    "inside before, outside after",
                    f"{int(escaped.sum())} points, by {is_[used][escaped].max() / size:.2g}",
                )
        elif isinstance(self.algorithm, ContainmentCheck):
            self.numbers(self.algorithm.summary)

    def run(self, before: Any, after: Any) -> list[Finding]:
        """Check everything; return the findings."""
        self.everything(before, after)
        if self.findings and self.findings[0].kind in ("silent empty", "topology changed"):
            return self.findings
        if not self.after.faces:
            return self.findings
        if isinstance(self.algorithm, SmoothingFilter):
            self.smoothing()
        kinds: list[tuple[type, Callable[[], None]]] = [
            (SurfaceQuality, self.quality),
            (SurfaceComparison, self.comparison),
            (FeatureDetection, self.features),
            (RegionMarking, self.marking),
            (ValenceTriangulation, self.triangulation),
            (SmoothingFilter, self.containment),
            (ContainmentCheck, self.containment),
        ]
        for cls, check in kinds:
            if isinstance(self.algorithm, cls):
                check()
        return self.findings


#: Schemes of which relaxation_factor is no part.
_WITHOUT_FACTOR = ("trapezium-drawing", "angle-based", "weighted-angle-based")


def exercise(cls: type, odd: odd_meshes.Odd, parameters: dict[str, Any]) -> tuple[str, list[Finding]]:
    """Run a filter on an odd mesh.

    Returns
    -------
    str
        "done" or "refused".
    list of Finding
    """
    where = cls.__name__
    further: list[Any] = [odd.further[name] for name in cls.inputs[1:]]
    if "installation" in cls.optional_inputs:
        further.append(odd.further["installation"] if _in_space(cls, parameters) else None)
    if "source" in cls.optional_inputs and parameters.get("ridge_angle") == "auto":
        further.append(odd.further["installation"])
    inputs = [odd.data, *further]
    before = [snapshot(data) for data in inputs]
    algorithm = cls(**parameters)
    try:
        made = algorithm(*inputs)
        error = None
    except Cancelled as cancelled:
        return "refused", [Finding("cancelled", where, str(cancelled))]
    except VtksmoothError as refusal:
        error = refusal
    except Exception as unexpected:
        return "refused", [
            Finding("unexpected exception", where, f"{type(unexpected).__name__}: {unexpected}"[:300])
        ]
    if [snapshot(data) for data in inputs] != before:
        return "done", [Finding("input changed", where, "")]
    if error is not None:
        text = str(error)
        if "\n" in text or len(text) < 15:
            return "refused", [Finding("no sentence", where, text)]
        return "refused", []
    output = made[0] if isinstance(made, tuple) else made
    leaves = list(_leaves(output))
    if output.GetClassName() != odd.data.GetClassName() or len(leaves) != len(before[0]):
        return "done", [Finding("structure", where, f"{output.GetClassName()} of {len(leaves)} leaves")]
    findings: list[Finding] = []
    composite = isinstance(odd.data, vtkCompositeDataSet)
    for source, leaf, given, taken in zip(
        _leaves(odd.data), leaves, before[0], snapshot(output), strict=True
    ):
        if not isinstance(source, vtkPolyData):
            continue
        if leaf is None:
            findings.append(Finding("silent empty", where, "a block has gone"))
            continue
        if given == taken and not plain(source).faces:
            continue
        check = Check(algorithm, source, leaf, inputs[1:])
        if composite:
            check.everything(given, taken)
            findings += check.findings
        else:
            findings += check.run(given, taken)
    return "done", findings


def every_filter(random: Random, odd: odd_meshes.Odd) -> Iterator[tuple[type, dict[str, Any]]]:
    """Return every filter with parameters for an odd mesh."""
    for cls in FILTERS:
        yield cls, random_parameters(random, cls, odd.data)


#: Filters that the checks know.
KNOWN = {cls.__name__ for cls in (*FILTERS, LaplacianSmoothing, InstallationSpaceRegions)}
