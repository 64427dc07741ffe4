"""RegionMarking: points fixed or freed by hand, soft edges round them, feature lines added or removed."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt
from vtkmodules.vtkCommonDataModel import vtkPolyData

from ..errors import InvalidMeshError, ParameterError
from ..kernels.features.edits import check_edges
from ..kernels.mesh.mesh import Mesh
from ..kernels.mesh.paths import edge_distances
from ..kernels.mesh.regions import Rings, blend_weights, edge_numbers, grown, rings_of, shrunk
from .arrays import edge_array, output_like, point_array, surface_of, vtk_array
from .base import Filter
from .parameter import Parameter
from .places import Merge, named
from .point_lists import parse_lines, parse_points
from .smoothing import ADDED_EDGES, BLEND_WEIGHT, FIXED, REMOVED_EDGES

Bool = npt.NDArray[np.bool_]


class RegionMarking(Filter):
    """Mark by hand what smoothing may do: points that stay, soft edges round them, feature lines.

    The point array ``Fixed`` (uint8) says which points stay; ``BlendWeight`` (float64), which part of its
    steps a point takes; the field arrays ``AddedFeatureEdges`` and ``RemovedFeatureEdges`` (pairs of points)
    say which edges are features, and which are none, whatever a detection finds. All smoothing filters go by
    these arrays. What is asked for is done in the order of the parameters, to the marks that are there.
    Points are numbers and ranges, ``0-14,20``; lines are chains of points along edges, ``3-17-19,40-41``.

    Guarantees
    ----------
    Points, cells and all other data stay. The weight of every fixed point is 0.

    Attributes
    ----------
    summary : dict
        How many points are ``fixed``, ``blended`` (not fixed, with a weight below 1) and ``free``, and how
        many ``edges_added`` and ``edges_removed`` there are.

    Examples
    --------
    >>> from vtkmodules.vtkFiltersSources import vtkPlaneSource
    >>> from vtksmooth import RegionMarking
    >>> plane = vtkPlaneSource(x_resolution=4, y_resolution=4)
    >>> _ = plane.Update()
    >>> marking = RegionMarking(fix="0-4", grow=1, blend_rings=1)
    >>> mesh = marking(plane.GetOutput())
    >>> marking.summary["fixed"], marking.summary["blended"], marking.summary["free"]
    (10, 5, 10)
    """

    command = "mark"
    skipped = 0

    clear = Parameter(
        "nothing",
        "What to forget first: the region (fixed points and their weights), the lines, or all.",
        choices=("nothing", "region", "lines", "all"),
    )
    free = Parameter(
        None, "Points to free: numbers and ranges, as 0-14,20, or all.",
        optional=True, type=str, text="points",
    )  # fmt: skip
    fix = Parameter(
        None, "Points to fix: numbers and ranges, as 0-14,20, or all.",
        optional=True, type=str, text="points",
    )  # fmt: skip
    invert = Parameter(False, "Free what is fixed, and fix what is free.")
    grow = Parameter(0, "Fix this many rings of points round the fixed ones.", low=0)
    shrink = Parameter(0, "Free this many rings of fixed points, from the free ones on.", low=0)
    blend_rings = Parameter(
        None, "Rings of points round the fixed ones over which weights rise to 1; 0: no weights.",
        low=0, optional=True, type=int,
    )  # fmt: skip
    blend_distance = Parameter(
        None, "Way along edges from the fixed points over which weights rise evenly to 1.",
        low=0.0, unit="model units", optional=True, type=float,
    )  # fmt: skip
    add_lines = Parameter(
        None, "Lines along edges that are features, as 3-17-19,40-41.",
        optional=True, type=str, text="lines",
    )  # fmt: skip
    remove_lines = Parameter(
        None, "Lines along edges that are no features, as 3-17-19,40-41.",
        optional=True, type=str, text="lines",
    )  # fmt: skip

    def merges(self) -> dict[str, Merge]:
        """Return what becomes of marks: a place is fixed if any of its points is."""
        return {FIXED: Merge("any"), BLEND_WEIGHT: Merge("least", 1.0)}

    def edge_arrays(self) -> list[str]:
        """Return the arrays of edges."""
        return [ADDED_EDGES, REMOVED_EDGES]

    def execute(self, *inputs: Any) -> vtkPolyData:
        """Mark one polydata."""
        (source,) = inputs
        if not source.GetNumberOfPoints():
            raise InvalidMeshError("The mesh is empty: it has no points.")
        self.progress(0.0, "marking")
        output = output_like(source)
        mesh = _Lazy(source)
        fixed, weights = self._mark_region(source, output, mesh)
        lines = self._mark_lines(source, output, mesh)
        part = np.zeros_like(fixed) if weights is None else (weights < 1.0) & ~fixed
        if self.whole is not None:
            fixed, part = fixed[self.whole.place], part[self.whole.place]
        self.summary = {
            "fixed": int(fixed.sum()),
            "blended": int(part.sum()),
            "free": int(len(fixed) - fixed.sum() - part.sum()),
            "edges_added": len(lines[0]),
            "edges_removed": len(lines[1]),
        }
        self.progress(1.0)
        return output

    def _mark_region(self, source: Any, output: Any, mesh: _Lazy) -> tuple[Bool, npt.NDArray[Any] | None]:
        n = source.GetNumberOfPoints()
        forget = self.clear in ("region", "all")
        array = None if forget else point_array(source, FIXED)
        weights = None if forget else point_array(source, BLEND_WEIGHT)
        before = np.zeros(n, np.bool_) if array is None else array != 0
        fixed = before.copy()
        if self.free is not None:
            fixed[self._numbers(parse_points, "free", n)] = False
        if self.fix is not None:
            fixed[self._numbers(parse_points, "fix", n)] = True
        if self.invert:
            fixed = ~fixed
        if self.grow:
            fixed = grown(mesh.rings, fixed, self.grow)
        if self.shrink:
            fixed = shrunk(mesh.rings, fixed, self.shrink)
        weights = self._weigh(fixed, before, weights, mesh)
        data = output.GetPointData()
        for name, values in ((FIXED, fixed.astype(np.uint8)), (BLEND_WEIGHT, weights)):
            data.RemoveArray(name)
            if values is not None and (name == BLEND_WEIGHT or array is not None or fixed.any()):
                data.AddArray(vtk_array(values, name))
        return fixed, weights

    def _numbers(
        self, parse: Callable[..., npt.NDArray[np.int64]], name: str, n: int
    ) -> npt.NDArray[np.int64]:
        """Return the points that a parameter names; in composite data they are numbered in each block."""
        text = getattr(self, name)
        if self.whole is None:
            return parse(name, text, n)
        parts = []
        for number, block in enumerate(self.whole.blocks):
            with named(block):
                points = parse(name, text, block.data.GetNumberOfPoints())
            parts.append(self.whole.places_of(number, points))
        return np.concatenate(parts)

    def _weigh(
        self, fixed: Bool, before: Bool, weights: npt.NDArray[Any] | None, mesh: _Lazy
    ) -> npt.NDArray[Any] | None:
        rings, distance = self.blend_rings, self.blend_distance
        if rings is not None and distance is not None:
            raise ParameterError("Weights rise over rings or over a distance; set the other to None (off).")
        if rings == 0 or distance == 0.0:
            return None
        if rings is not None:
            # The blending of the installation-space paper, into the free part.
            return np.asarray(1.0 - blend_weights(mesh.mesh, ~fixed, rings, self.progress))
        if distance is not None:
            away = edge_distances(mesh.mesh.points, mesh.rings, np.flatnonzero(fixed), distance)
            with np.errstate(over="ignore"):  # of a distance that is next to none
                return np.asarray(np.minimum(1.0, away / distance))
        if weights is None:
            return None
        kept = np.where(before & ~fixed, 1.0, weights.astype(np.float64))
        kept[fixed] = 0.0
        return kept

    def _mark_lines(self, source: Any, output: Any, mesh: _Lazy) -> list[npt.NDArray[Any]]:
        n = source.GetNumberOfPoints()
        lines = []
        for name in (ADDED_EDGES, REMOVED_EDGES):
            pairs = None if self.clear in ("lines", "all") else edge_array(source, name)
            lines.append(np.empty((0, 2), np.int32) if pairs is None else pairs)
        for number, name in enumerate(("add_lines", "remove_lines")):
            if getattr(self, name) is None:
                continue
            pairs = np.sort(self._numbers(parse_lines, name, n), axis=1)
            check_edges(pairs, mesh.rings)
            together = np.concatenate((lines[number], pairs)).astype(np.int32)
            lines[number] = np.unique(together, axis=0)
            other = lines[1 - number]
            lines[1 - number] = other[~np.isin(edge_numbers(other, n), edge_numbers(pairs, n))]
        fields = output.GetFieldData()
        for name, pairs in zip((ADDED_EDGES, REMOVED_EDGES), lines, strict=True):
            fields.RemoveArray(name)
            if len(pairs):
                fields.AddArray(vtk_array(pairs, name))
        return lines


class _Lazy:
    """A mesh and its rings, read when first asked for: fixing and freeing points needs neither."""

    def __init__(self, source: Any) -> None:
        self._source = source
        self._mesh: Mesh | None = None
        self._rings: Rings | None = None

    @property
    def mesh(self) -> Mesh:
        if self._mesh is None:
            self._mesh = surface_of(self._source).mesh
        return self._mesh

    @property
    def rings(self) -> Rings:
        if self._rings is None:
            self._rings = rings_of(self.mesh)
        return self._rings
