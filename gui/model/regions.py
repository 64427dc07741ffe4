"""Regions: what is marked on a mesh by hand, and what the tools find there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkPolyData

from vtksmooth.errors import InvalidMeshError
from vtksmooth.filters.arrays import cells_of, edge_array, point_array, vtk_cells
from vtksmooth.filters.smoothing import ADDED_EDGES, BLEND_WEIGHT, FIXED, REMOVED_EDGES
from vtksmooth.kernels.mesh.regions import marked_faces

from .field import Field
from .selection import faces_as_mesh
from .state import State, ready

Bool = npt.NDArray[np.bool_]
Int64 = npt.NDArray[np.int64]


def fixed(state: State) -> Bool:
    """Return which points are fixed, (n,)."""
    array = _array(state, FIXED)
    return np.zeros(state.n_points, np.bool_) if array is None else array != 0


def edits(state: State) -> tuple[Int64, Int64]:
    """Return the feature edges added and removed by hand, (k, 2) each."""
    found = []
    for name in (ADDED_EDGES, REMOVED_EDGES):
        try:
            pairs = edge_array(state.mesh, name)
        except InvalidMeshError:
            pairs = None  # what uses it says so
        found.append(np.empty((0, 2), np.int64) if pairs is None else pairs.astype(np.int64))
    return found[0], found[1]


def counts(state: State) -> str:
    """Return how much is marked, in two lines."""
    held, weights = fixed(state), _array(state, BLEND_WEIGHT)
    blended = 0 if weights is None else int(((weights < 1.0) & ~held).sum())
    count = int(held.sum())
    added, removed = (len(pairs) for pairs in edits(state))
    return (
        f"{count:,} fixed, {blended:,} blended, {state.n_points - count - blended:,} free\n"
        f"{added:,} feature edges added, {removed:,} removed"
    )


def _array(state: State, name: str) -> npt.NDArray[Any] | None:
    try:
        return point_array(state.mesh, name)
    except InvalidMeshError:
        return None  # what uses it says so


def mark_of(state: State, chosen: Bool) -> vtkPolyData | None:
    """Return chosen points as a mesh to draw: the faces between them, and points that no such face has."""
    if state.surface is None or not chosen.any():
        return None
    mesh = state.surface.mesh
    faces = marked_faces(mesh, chosen)
    drawn = faces_as_mesh(state, faces)
    alone = chosen.copy()
    alone[vtk_to_numpy(drawn.GetPolys().GetConnectivityArray()) if len(faces) else []] = False
    single = np.flatnonzero(alone)
    drawn.SetPoints(state.mesh.GetPoints())
    drawn.SetVerts(vtk_cells(np.arange(len(single) + 1), single))
    return ready(drawn)


def drawing_of(state: State, pairs: Int64, anchor: int | None) -> vtkPolyData | None:
    """Return edges as a mesh to draw, with a point where the next line begins."""
    if not len(pairs) and anchor is None:
        return None
    drawn = vtkPolyData()
    drawn.SetPoints(state.mesh.GetPoints())
    drawn.SetLines(vtk_cells(2 * np.arange(len(pairs) + 1), pairs.ravel()))
    points = np.array([] if anchor is None else [anchor], np.int64)
    drawn.SetVerts(vtk_cells(np.arange(len(points) + 1), points))
    return drawn


def points_between(values: Field, low: float, high: float) -> Int64:
    """Return the points with a value from `low` to `high`; of face values, the corners of such faces."""
    inside = (values.values >= low) & (values.values <= high)
    if values.on_points:
        return np.flatnonzero(inside)
    mesh = values.surface.mesh
    return np.flatnonzero(np.bincount(mesh.connectivity[np.repeat(inside, mesh.face_sizes)]))


@dataclass(frozen=True, eq=False)
class Lines:
    """Feature lines, as chains of points of the mesh.

    Attributes
    ----------
    offsets : (l + 1,) int array
    points : (k,) int array
        Line i has the points ``points[offsets[i]:offsets[i + 1]]``.
    """

    offsets: Int64
    points: Int64

    @classmethod
    def of(cls, lines: Any) -> Lines:
        """Return the lines of the second output of FeatureDetection."""
        offsets, along = cells_of(lines.GetLines())
        ids = vtk_to_numpy(lines.GetPointData().GetArray("PointIds"))
        return cls(np.asarray(offsets, np.int64), ids[along].astype(np.int64))

    def chain(self, line: int) -> Int64:
        """Return the points of a line."""
        return self.points[self.offsets[line] : self.offsets[line + 1]]

    @property
    def pairs(self) -> Int64:
        """The edges of all lines, (r, 2)."""
        inner = np.ones(max(0, len(self.points) - 1), np.bool_)
        inner[self.offsets[1:-1] - 1] = False
        return np.column_stack((self.points[:-1], self.points[1:]))[inner]

    @property
    def lines(self) -> Int64:
        """For each edge of `pairs` the number of its line, (r,)."""
        return np.repeat(np.arange(len(self.offsets) - 1), np.diff(self.offsets) - 1)

    def nearest(
        self, places: npt.NDArray[np.float32], seen: Bool, at: tuple[float, float], reach: float
    ) -> int | None:
        """Return the line that is nearest to a place on the screen, of those with a seen edge there.

        Parameters
        ----------
        places : (n, 4) float32
            Where the points stand on the screen.
        seen : (n,) bool
        at : tuple of float
            Pixels.
        reach : float
            How near it must be, pixels.
        """
        pairs = self.pairs
        if not len(pairs):
            return None
        a, b = (places[pairs[:, end], :2].astype(np.float64) for end in (0, 1))
        along, away = b - a, np.asarray(at) - a
        square = np.maximum((along**2).sum(axis=1), 1e-300)
        part = np.clip((along * away).sum(axis=1) / square, 0.0, 1.0)
        distance = np.linalg.norm(away - part[:, None] * along, axis=1)
        distance[~(seen[pairs].any(axis=1) & np.isfinite(distance))] = np.inf
        nearest = int(np.argmin(distance))
        return int(self.lines[nearest]) if distance[nearest] <= reach else None
