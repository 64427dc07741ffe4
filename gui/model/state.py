"""States: one mesh as it was at one moment. Nothing of a state ever changes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkPolyData

from vtksmooth.errors import InvalidMeshError
from vtksmooth.filters.arrays import Surface, output_like, points_of, surface_of
from vtksmooth.recipe import Recipe

from .field import Field

#: What a recipe calls the mesh of a further input: a file, or a role.
Source = str | Path


def _cells(mesh: Any) -> tuple[Any, ...]:
    return mesh.GetVerts(), mesh.GetLines(), mesh.GetPolys(), mesh.GetStrips()


def _share_cells(a: vtkPolyData, b: vtkPolyData) -> bool:
    return all(
        x.GetNumberOfCells() == y.GetNumberOfCells() == 0
        or x.GetConnectivityArray() is y.GetConnectivityArray()
        for x, y in zip(_cells(a), _cells(b), strict=True)
    )


def shares_geometry(a: vtkPolyData, b: vtkPolyData) -> bool:
    """Return whether two meshes have their points and cells in the same memory."""
    if a.GetPoints() is None or b.GetPoints() is None:
        return False
    return a.GetPoints().GetData() is b.GetPoints().GetData() and _share_cells(a, b)


def ready(mesh: vtkPolyData) -> vtkPolyData:
    """Return a mesh whose bounds VTK knows: it looks at all cells before it first draws them."""
    mesh.GetCellsBounds([0.0] * 6)
    return mesh


@dataclass(eq=False, repr=False)
class State:
    """A mesh at one moment, and what made it.

    Attributes
    ----------
    mesh : vtkPolyData
        Shares with the states before it whatever a filter passed through, so that a state of the history
        costs its points only.
    fields : dict
        Values computed on this mesh for overlays, by what they depend on.
    summaries : dict
        Figures computed on this mesh, by what they depend on.
    recipe : Recipe
        What made it of the mesh as its layer was opened.
    sources : mapping of str or Path to State
        The meshes of the recipe's further inputs.
    did : tuple of str
        What each of the recipe's steps did, as a report says it.
    """

    mesh: vtkPolyData
    fields: dict[Any, Field | None] = field(default_factory=dict)
    summaries: dict[Any, dict[str, Any]] = field(default_factory=dict)
    recipe: Recipe = field(default_factory=Recipe)
    sources: Mapping[Source, State] = field(default_factory=dict)
    did: tuple[str, ...] = ()

    @classmethod
    def of(cls, mesh: Any, like: State | None = None, **made: Any) -> State:
        """Return a mesh as a state, ready to be shown; to be called by the worker.

        Where it has the faces of `like`, both share them here as they do in VTK; `made` says what made it.
        """
        if isinstance(mesh, State):
            return mesh
        state = cls(mesh, **made)
        if like is not None and like.surface is not None and state.shares_geometry(like):
            state.surface, state.scene = like.surface, like.scene
        elif like is not None and like.surface is not None and state._shares_faces(like):
            points = np.ascontiguousarray(state.points, dtype=np.float64)
            if np.isfinite(points).all():
                faces = like.surface
                state.surface = replace(faces, mesh=faces.mesh.with_points(points))
        _ = state.surface, state.memory, state.scene
        return state

    def __post_init__(self) -> None:
        self.mesh = output_like(self.mesh)
        # VTK computes these when first asked and keeps them: not in two threads at a time.
        self.bounds = tuple(self.mesh.GetBounds())
        self.mesh.GetNumberOfCells()

    @property
    def n_points(self) -> int:
        """Number of points."""
        return int(self.mesh.GetNumberOfPoints())

    @property
    def n_faces(self) -> int:
        """Number of polygons, with the triangles of strips."""
        return self.surface.mesh.n_faces if self.surface else 0

    @cached_property
    def surface(self) -> Surface | None:
        """The faces, or None where the mesh has none that can be worked on (lines, points)."""
        try:
            return surface_of(self.mesh)
        except InvalidMeshError:
            return None

    @property
    def fault(self) -> str:
        """Why there are no faces that can be worked on, or ""."""
        try:
            surface_of(self.mesh)
        except InvalidMeshError as error:
            return str(error)
        return ""

    @property
    def points(self) -> np.ndarray:
        """The points, (n, 3), never to be written to."""
        return points_of(self.mesh)

    @property
    def diagonal(self) -> float:
        """Length of the bounding box's diagonal."""
        low, high = np.array(self.bounds[::2]), np.array(self.bounds[1::2])
        return float(np.linalg.norm(high - low)) if (high >= low).all() else 0.0

    @cached_property
    def memory(self) -> dict[str, int]:
        """Bytes of every array that this state holds, by the array's identity."""
        arrays = []
        if self.mesh.GetPoints():
            arrays.append(self.mesh.GetPoints().GetData())
        for cells in _cells(self.mesh):
            if cells.GetNumberOfCells():
                arrays += [cells.GetConnectivityArray(), cells.GetOffsetsArray()]
        for data in (self.mesh.GetPointData(), self.mesh.GetCellData()):
            arrays += [data.GetAbstractArray(i) for i in range(data.GetNumberOfArrays())]
        return {a.__this__: a.GetDataSize() * a.GetDataTypeSize() for a in arrays if a is not None}

    @cached_property
    def scene(self) -> vtkPolyData:
        """The mesh to be drawn, without the data arrays: of those only an overlay's values are."""
        mesh = vtkPolyData()
        mesh.CopyStructure(self.mesh)
        return ready(mesh)

    def input(self) -> vtkPolyData:
        """Return a polydata of its own over the same arrays, for a worker thread."""
        return output_like(self.mesh)

    def _shares_faces(self, other: State) -> bool:
        """Return whether `other` has as many points, and its cells are the same in memory."""
        return self.n_points == other.n_points and _share_cells(self.mesh, other.mesh)

    def shares_geometry(self, other: State) -> bool:
        """Return whether points and cells are those of `other`, in the same memory: only data differ."""
        return shares_geometry(self.mesh, other.mesh)

    def has_same_faces(self, other: State) -> bool:
        """Return whether `other` has the same points by number and the same faces."""
        if self._shares_faces(other):
            return True
        mine, its = self.surface, other.surface
        if mine is None or its is None or self.n_points != other.n_points or self.n_faces != other.n_faces:
            return False
        return np.array_equal(mine.mesh.offsets, its.mesh.offsets) and np.array_equal(
            mine.mesh.connectivity, its.mesh.connectivity
        )

    def comparable(self, other: State) -> vtkPolyData | None:
        """Return `other` as a mesh that this one can be compared with point by point, or None.

        Filters that cut faces keep the points and their order: then it is the points of `other` on the
        faces of this mesh.
        """
        if self.surface is None or self.n_points != other.n_points:
            return None
        if self.has_same_faces(other):
            return other.input()
        mesh = self.input()
        mesh.SetPoints(other.mesh.GetPoints())
        return mesh
