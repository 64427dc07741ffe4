"""Normals that fit the surface they are on: computed again where points have moved or faces have changed."""

from __future__ import annotations

import re
from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import VTK_DOUBLE, VTK_FLOAT

from ..kernels.measures.aspect_ratio import area_vectors
from ..kernels.mesh.places import distinct_places
from .arrays import Surface, points_of, surface_of, vtk_array

Float64 = npt.NDArray[np.float64]
Int64 = npt.NDArray[np.int64]

#: How VTK calls the normals that it makes.
_USUAL = "Normals"
_NAMES = re.compile(r".*normals?", re.IGNORECASE)
_FLOATS = (VTK_FLOAT, VTK_DOUBLE)


def renew(before: Sequence[Any], after: Sequence[Any], place: Int64 | None) -> list[str]:
    """Give blocks the normals of their new surface, and return what a user should know.

    The active normals of points and cells, or those called ``Normals`` where none are active, are computed
    again where faces have turned, with the same name and precision; other arrays of normals go. The normal
    of a point is the mean of its faces' unit normals, as in VTK. Points in one place whose normals were equal
    have equal ones again, if that is how the normals were made; so edges that were drawn sharp stay sharp,
    and seams that could not be seen stay so. Normals that pointed against the faces do so again.

    Parameters
    ----------
    before, after : sequence of vtkPolyData
        The blocks as they were, and as they are; the latter are changed.
    place : (n,) int64 or None
        Place of each point, block after block; None where no two points are in one place.
    """
    notes: list[str] = []
    changes = []
    start = 0
    for old, new in zip(before, after, strict=True):
        for data in (new.GetPointData(), new.GetCellData()):
            _drop_others(data, notes)
        changes.append(_Change(old, new, start))
        start += new.GetNumberOfPoints()
    for change in changes:
        change.renew_cells()
    pointed = [change for change in changes if change.with_point_normals]
    if pointed:
        _renew_points(pointed, place)
    return list(dict.fromkeys(notes))


def _drop_others(data: Any, notes: list[str]) -> None:
    normals = _normals_of(data)
    for i in reversed(range(data.GetNumberOfArrays())):
        array, name = data.GetArray(i), data.GetArrayName(i) or ""
        of_normals = array is not None and array.GetNumberOfComponents() == 3 and _NAMES.fullmatch(name)
        if array is not normals and (of_normals or array is data.GetNormals()):
            data.RemoveArray(i)
            notes.append(f"The array {name!r} holds normals of the surface before and was left out.")


def _normals_of(data: Any) -> Any:
    """Return the array of normals that can be computed again, or None."""
    array = data.GetNormals() or data.GetArray(_USUAL)
    fits = array is not None and array.GetNumberOfComponents() == 3 and array.GetDataType() in _FLOATS
    return array if fits else None


class _Change:
    """One block before and after."""

    def __init__(self, before: Any, after: Any, start: int) -> None:
        self._before, self._after, self.start = before, after, start
        self.with_point_normals = _normals_of(after.GetPointData()) is not None
        #: Of a block, all faces may have been left out.
        self._bare = after.GetNumberOfPolys() + after.GetNumberOfStrips() == 0

    @cached_property
    def _surface(self) -> Surface:
        return surface_of(self._after)

    @cached_property
    def _unit_normals(self) -> tuple[Float64, Float64]:
        """The unit normals of the faces before and after."""
        mesh = self._surface.mesh
        earlier = mesh.with_points(np.ascontiguousarray(points_of(self._before), dtype=np.float64))
        return _unit(area_vectors(earlier)), _unit(area_vectors(mesh))

    @property
    def places(self) -> slice:
        return slice(self.start, self.start + self._after.GetNumberOfPoints())

    @property
    def point_normals(self) -> npt.NDArray[Any]:
        return np.asarray(vtk_to_numpy(_normals_of(self._after.GetPointData())))

    def sums(self) -> tuple[Float64, Float64]:
        """Return the sums of the unit normals of each point's faces, before and after."""
        if self._bare:
            nothing = np.zeros((self._after.GetNumberOfPoints(), 3))
            return nothing, nothing
        mesh = self._surface.mesh
        face = np.repeat(np.arange(mesh.n_faces), mesh.face_sizes)
        was, now = (_added(mesh.connectivity, side[face], mesh.n_points) for side in self._unit_normals)
        return was, now

    def renew_points(self, was: Float64, now: Float64) -> None:
        _put(self._after.GetPointData(), was, now, (_unit(was) != _unit(now)).any(axis=1))

    def renew_cells(self) -> None:
        if self._bare or _normals_of(self._after.GetCellData()) is None:
            return
        surface = self._surface
        was, now = (_added(surface.cells, normals, surface.n_cells) for normals in self._unit_normals)
        split = self._before.GetPolys() is not self._after.GetPolys()
        _put(self._after.GetCellData(), was, now, split | (_unit(was) != _unit(now)).any(axis=1))


def _renew_points(changes: Sequence[_Change], place: Int64 | None) -> None:
    sums = [change.sums() for change in changes]
    if place is not None:
        was, now = (np.concatenate(side) for side in zip(*sums, strict=True))
        given = np.concatenate([change.point_normals for change in changes]).astype(np.float64)
        group = _groups(np.concatenate([place[change.places] for change in changes]), given)
        together = [_added(group, side, len(group))[group] for side in (was, now)]
        # The normals themselves tell whether a point has those of its own faces, or of all faces there.
        differ = (np.abs(_unit(was) - _unit(together[0])) > 1e-6).any(axis=1)
        apart, joint = (np.abs(_cosines(side[differ], given[differ])).sum() for side in (was, together[0]))
        if joint > apart:
            ends = np.cumsum([len(side) for side, _ in sums])[:-1]
            sums = list(zip(*(np.split(side, ends) for side in together), strict=True))
    for change, (was, now) in zip(changes, sums, strict=True):
        change.renew_points(was, now)


def _groups(places: Int64, normals: Float64) -> Int64:
    """Return for each point the first one in its place with the same normal."""
    rows = np.column_stack((places.astype(np.float64), np.round(normals, 3)))
    group, first = distinct_places(rows)
    return np.asarray(first[group])


def _put(data: Any, was: Float64, now: Float64, changed: npt.NDArray[np.bool_]) -> None:
    """Put normals into `data` where they have changed; what has none keeps what it had."""
    array = _normals_of(data)
    old, active = vtk_to_numpy(array), data.GetNormals() is array
    turned = -1.0 if _cosines(was, old).sum() < 0.0 else 1.0
    now = turned * _unit(now)
    new = np.where((changed & (now != 0.0).any(axis=1))[:, None], now, old).astype(old.dtype)
    renewed = vtk_array(new, array.GetName() or _USUAL)
    data.SetNormals(renewed) if active else data.AddArray(renewed)


def _added(to: npt.NDArray[np.integer], vectors: Float64, n: int) -> Float64:
    """Return the sums of vectors for each of n things."""
    return np.column_stack([np.bincount(to, vectors[:, axis], n) for axis in range(3)])


def _unit(vectors: Float64) -> Float64:
    # By the largest component first: squares of areas of tiny or giant meshes leave float64.
    largest = np.abs(vectors).max(axis=1, keepdims=True, initial=0.0)
    vectors = vectors / np.where(largest > 0.0, largest, 1.0)
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.asarray(vectors / np.where(length > 0.0, length, 1.0))


def _cosines(a: Float64, b: npt.NDArray[Any]) -> Float64:
    """Return the cosines of the angles between vectors; 0 where one is not finite."""
    return np.asarray(np.nan_to_num((_unit(a) * _unit(b.astype(np.float64))).sum(axis=1)))
