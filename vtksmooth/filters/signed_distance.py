"""Signed distance to an installation space, by VTK."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkDoubleArray
from vtkmodules.vtkCommonDataModel import vtkPolyData
from vtkmodules.vtkFiltersCore import vtkCleanPolyData, vtkImplicitPolyDataDistance

from ..errors import InvalidMeshError
from ..kernels.containment.arrangement import arrange
from ..kernels.distance.closest_point import ClosestPoint
from ..kernels.distance.signed_distance import SignedDistanceTree
from ..kernels.distance.winding_number import WindingNumber
from ..kernels.mesh.hole_filling import lid, rims
from ..kernels.mesh.mesh import Mesh
from ..kernels.mesh.triangulate import triangulate
from ..report import figure
from .arrays import points_of, surface_of, vtk_array, vtk_cells, vtk_points, vtk_triangles

Float64 = npt.NDArray[np.float64]

#: A mesh that many times larger than the space it should fit in is in other units; one that many times
#: smaller may be.
_OTHER_UNITS, _PERHAPS_OTHER_UNITS = 10.0, 100.0


#: Points in one call of VTK's: a call for each would cost more than the distances, one for all could not
#: be interrupted.
_BATCH = 16_384


class SignedDistance:
    """The distance of points to the boundary of an installation space, negative inside.

    Inside is where the winding number of the space is 1 or more. So solids that overlap, touch or lie within
    each other are one, without walls between them; a shell whose normals point inwards, within a solid, is a
    cavity; and an opening is closed by a lid, of least area on triangles between the points of its rim, which
    is a wall as any other.

    Distances come from VTK's cell locator. Where all faces bound the inside, signs come from angle-weighted
    pseudonormals (vtkImplicitPolyDataDistance; J. A. Baerentzen, H. Aanaes, "Signed Distance Computation
    Using the Angle Weighted Pseudonormal", 2005), otherwise, and where compiled code finds another sign, from
    the winding number.

    Parameters
    ----------
    space : vtkPolyData
        The surface, normals outwards. Points in one place count as one; polygons are taken as triangles. A
        surface that is inside out is turned.
    name : str
        What errors and notes call it.
    beside : Mesh, optional
        A mesh that distances will be asked for. If there is one, all coordinates, of what is asked as well,
        are relative to an origin.

    Attributes
    ----------
    mesh : Mesh
        The triangles that distances are measured to, normals outwards. If faces cross, overlap or touch along
        lines, those of the parts that bound the inside, which need not share points.
    origin : (3,) float64
        See :func:`common_origin`; 0 without a mesh beside.
    closed : bool
        Whether every edge has faces on both sides, without lids.
    turned : bool
        Whether the surface was inside out.
    notes : list of str
        What a user should know about the surface.

    Raises
    ------
    InvalidMeshError
        The surface has no faces, encloses nothing even with lids, has faces that are turned against
        their neighbours, solids that are turned against others, or polygons that cross themselves.

    Examples
    --------
    >>> from vtkmodules.vtkFiltersSources import vtkCubeSource
    >>> cube = vtkCubeSource()
    >>> _ = cube.Update()
    >>> distance = SignedDistance(cube.GetOutput())
    >>> distance([[0, 0, 0], [0.5, 0, 0.25], [0, 0, 2]]).round(12) + 0.0
    array([-0.5,  0. ,  1.5])
    """

    def __init__(self, space: Any, name: str = "installation space", beside: Mesh | None = None) -> None:
        self.notes: list[str] = []
        self.origin: Float64 = np.zeros(3)
        try:
            surface = surface_of(space).mesh
            if beside is not None:
                self.origin = common_origin(surface, beside)
            polygons = _merged(relative(surface, self.origin))
            boundaries, clashes, crowded = _edges(polygons)
            if crowded:
                polygons = _without_double_walls(polygons)
                boundaries, clashes, _ = _edges(polygons)
            triangles, _ = triangulate(polygons)
        except InvalidMeshError as error:
            raise InvalidMeshError(f"The {name} is no usable surface: {error}") from error
        mesh = Mesh.from_faces(polygons.points, triangles)
        if clashes:
            raise InvalidMeshError(
                f"{clashes} edges of the {name} join faces that are turned against each other or "
                "doubled; clean it and orient its faces so that all normals point outwards."
            )
        self.closed = not len(boundaries)
        least = 1e-12 * mesh.diagonal**3
        self.turned = _enclosed_volume(mesh, boundaries) < -least
        if self.turned:
            self.notes.append(f"The {name} is inside out: it was turned.")
            mesh, boundaries = _turned(mesh), boundaries[:, ::-1]
        if not self.closed:
            openings = rims(boundaries[:, ::-1])
            lids = [lid(mesh.points, rim) for rim in openings]
            mesh = Mesh.from_faces(mesh.points, np.concatenate((mesh.connectivity.reshape(-1, 3), *lids)))
            self.notes.append(
                f"The {name} is open ({len(boundaries)} boundary edges): {len(openings)} "
                + (
                    "lid closes it, and counts as a wall."
                    if len(openings) == 1
                    else "lids close it, and count as walls."
                )
            )
        self._surface = ClosestPoint(mesh)
        near = max(1e-10 * mesh.diagonal, 0.25 * touching_distance(0.0, mesh, space))
        found = arrange(mesh, self._surface, near)
        if found.mesh is None or not _enclosed_volume(found.mesh) > least:
            raise InvalidMeshError(
                f"The {name} is closed but encloses no volume."
                if self.closed
                else f"The {name} is open and encloses no volume; close its openings."
            )
        if found.inverted:
            raise InvalidMeshError(
                f"Faces of the {name} point into it and are not those of a cavity; orient every solid so "
                "that its normals point outwards."
            )
        self.mesh, self._cut = found.mesh, found.winding
        if found.mesh is not mesh:
            self._surface = ClosestPoint(found.mesh)

    @cached_property
    def _unit(self) -> float:
        """VTK takes fifth powers of lengths, which overflow: by this it gets lengths near 1, not rounded."""
        return float(np.ldexp(1.0, -int(np.frexp(self.mesh.diagonal)[1])))

    @cached_property
    def _function(self) -> vtkImplicitPolyDataDistance:
        polydata = vtkPolyData()
        polydata.SetPoints(vtk_points(self._unit * self.mesh.points))
        polydata.SetPolys(vtk_triangles(self.mesh.connectivity.reshape(-1, 3)))
        function = vtkImplicitPolyDataDistance()
        function.SetInput(polydata)
        return function

    @cached_property
    def tree(self) -> SignedDistanceTree:
        """The same distances in compiled code, on all threads, for whoever asks for millions."""
        return SignedDistanceTree(self._surface, self._cut)

    @cached_property
    def _winding(self) -> WindingNumber:
        return self._cut or WindingNumber(self.mesh.points, self.mesh.connectivity.reshape(-1, 3))

    def __call__(
        self, points: npt.ArrayLike, progress: Callable[[float], None] = lambda fraction: None
    ) -> Float64:
        """Return the signed distances (q,) of `points` (q, 3), model units.

        `progress` is called with the part done, 0 to 1, several times a second; what it raises ends the call.
        """
        points = np.ascontiguousarray(points, dtype=np.float64).reshape(-1, 3)
        result, found = np.empty(len(points)), vtkDoubleArray()
        for first in range(0, len(points), _BATCH):
            progress(first / len(points))
            batch = slice(first, first + _BATCH)
            self._function.FunctionValue(vtk_array(self._unit * points[batch]), found)
            result[batch] = vtk_to_numpy(found) / self._unit
        return result if self._cut is None else self.with_signs(points, result)

    def with_signs(self, points: Float64, distances: Float64) -> Float64:
        """Return the distances (q,) of `points` (q, 3) with signs by the winding number."""
        away = np.abs(distances)
        return np.where(self._winding.inside(points, away), -away, away)


class Inside(NamedTuple):
    """A mesh and the installation space that it should be in.

    Attributes
    ----------
    mesh : Mesh
        Relative to the origin of the space, see :func:`common_origin`.
    space : SignedDistance
        Its notes say what is unusual about the two together, too.
    tolerance : float
        The distance that counts as touching, see :func:`touching_distance`.
    measured : (n,) float64 and (m,) bool, optional
        Signed distances of the points, 0 for those that no face uses, and which triangles cross the space's
        surface, where that is known.
    """

    mesh: Mesh
    space: SignedDistance
    tolerance: float
    measured: tuple[Float64, npt.NDArray[np.bool_]] | None = None


def opened(source: Any, installation: Any, fraction: float) -> Inside:
    """Read two polydata: a mesh, and the installation space it should be in.

    Raises
    ------
    InvalidMeshError
        One of them is no usable surface, or they cannot be inside each other.
    """
    mesh = surface_of(source).mesh
    space = SignedDistance(installation, beside=mesh)
    mesh = relative(mesh, space.origin)
    space.notes += check_sizes(mesh, space.mesh, space.origin)
    return Inside(mesh, space, touching_distance(fraction, space.mesh, source, installation))


def common_origin(space: Mesh, mesh: Mesh) -> Float64:
    """Return what the coordinates of both surfaces are taken relative to, (3,).

    Far from 0 products of coordinates lose the digits that tell inside from outside. The lowest coordinate of
    the space on each axis; 0 where subtracting that would round a coordinate of a face. So wherever the two
    surfaces are moved to without rounding, what is computed is the same.
    """
    corners = [one.points[used_points(one)] for one in (space, mesh)]
    if not len(corners[0]):
        return np.zeros(3)
    places, low = np.concatenate(corners), corners[0].min(axis=0)
    return np.where((_rounding_of_difference(places, low) == 0.0).all(axis=0), low, 0.0)


def relative(mesh: Mesh, origin: Float64) -> Mesh:
    """Return the mesh with coordinates relative to an origin."""
    return mesh.with_points(mesh.points - origin) if origin.any() else mesh


def _rounding_of_difference(a: Float64, b: Float64) -> Float64:
    """Return by how much the floating-point number a - b is off (D. Knuth, TAOCP 2, section 4.2.2)."""
    difference = a - b
    part = a - difference
    return (a - (difference + part)) + (part - b)  # type: ignore[no-any-return]


def used_points(mesh: Mesh) -> npt.NDArray[np.int64]:
    """Return the points that faces use, by rising number."""
    used = np.zeros(mesh.n_points, np.bool_)
    used[mesh.connectivity] = True
    return np.flatnonzero(used)


def check_sizes(sim: Mesh, space: Mesh, origin: Float64 | float = 0.0) -> list[str]:
    """Refuse two surfaces that cannot be inside each other: apart, or one far larger than its space.

    Coordinates are relative to `origin`.

    Returns
    -------
    list of str
        What looks wrong but may be right: a mesh far smaller than its space.

    Raises
    ------
    InvalidMeshError
        The message names both sizes.
    """
    boxes = [
        np.array([used.min(axis=0), used.max(axis=0)])
        for used in (sim.points[used_points(sim)], space.points[used_points(space)])
    ]
    (low, high), (space_low, space_high) = boxes
    margin = 1e-6 * np.linalg.norm(space_high - space_low)
    sizes = [" x ".join(figure(size) for size in box[1] - box[0]) for box in boxes]
    if (low > space_high + margin).any() or (high < space_low - margin).any():
        raise InvalidMeshError(
            f"The mesh ({sizes[0]}, from {_place(low + origin)}) and the installation space ({sizes[1]}, "
            f"from {_place(space_low + origin)}) are apart; check units and positions."
        )
    size, space_size = np.linalg.norm(high - low), np.linalg.norm(space_high - space_low)
    if size > _OTHER_UNITS * space_size:
        raise InvalidMeshError(
            f"The mesh ({sizes[0]}) is far larger than the installation space ({sizes[1]}) it should fit in; "
            "check their units."
        )
    if size * _PERHAPS_OTHER_UNITS < space_size:
        return [f"The mesh ({sizes[0]}) is far smaller than the installation space ({sizes[1]}); same units?"]
    return []


def touching_distance(fraction: float, space: Mesh, *sources: Any) -> float:
    """Return the distance, model units, within which points of faces of `sources` count as on the `space`.

    `fraction` of the space's diagonal, as if it were a box (of its span: the pose must not matter), but no
    less than what rounding the largest coordinate leaves open.
    """
    roundings = [
        4.0 * float(np.finfo(points.dtype).eps) * float(np.abs(points[used_points(mesh)]).max(initial=0.0))
        for points, mesh in ((points_of(source), surface_of(source).mesh) for source in sources)
        if points.dtype.kind == "f"
    ]
    return max([fraction * space.span, *roundings])


def _place(point: Float64) -> str:
    return "(" + ", ".join(figure(x) for x in point) + ")"


def _merged(surface: Mesh) -> Mesh:
    raw, clean = vtkPolyData(), vtkCleanPolyData()
    raw.SetPoints(vtk_points(surface.points))
    raw.SetPolys(vtk_cells(surface.offsets, surface.connectivity))
    clean.SetInputData(raw)
    clean.ToleranceIsAbsoluteOn()
    clean.SetAbsoluteTolerance(0.0)
    clean.Update()  # polygons with fewer than three places become lines: they have no area and no say
    return surface_of(clean.GetOutput()).mesh


def _edges(mesh: Mesh) -> tuple[npt.NDArray[np.int64], int, int]:
    """Look at the edges.

    Returns those with one face, (b, 2), from where to where it runs; how many others do not run as often back
    as forth; and how many have more than two faces.
    """
    start = mesh.connectivity.astype(np.int64)
    after = np.arange(1, len(start) + 1)
    full = mesh.face_sizes > 0
    after[mesh.offsets[1:][full] - 1] = mesh.offsets[:-1][full]
    end = start[after]
    keys = np.minimum(start, end) * mesh.n_points + np.maximum(start, end)
    _, edge, count = np.unique(keys, return_inverse=True, return_counts=True)
    balance = np.bincount(edge, weights=np.where(start < end, 1.0, -1.0))
    boundaries = np.column_stack((start, end))[count[edge] == 1]
    return boundaries, int(((count > 1) & (balance != 0.0)).sum()), int((count > 2).sum())


def _without_double_walls(mesh: Mesh) -> Mesh:
    """Leave out faces that another one covers, turned the other way: where solids touch there is no wall."""
    kept = np.ones(mesh.n_faces, np.bool_)
    for size in np.unique(mesh.face_sizes):
        rows = np.flatnonzero(mesh.face_sizes == size)
        corners = mesh.connectivity[mesh.offsets[rows][:, None] + np.arange(size)]
        # From the smallest point on, in the direction of its smaller neighbour.
        first = corners.argmin(axis=1)[:, None]
        forth = np.take_along_axis(corners, (first + np.arange(size)) % size, axis=1)
        back = np.take_along_axis(corners, (first - np.arange(size)) % size, axis=1)
        turned = forth[:, 1] > forth[:, -1]
        _, group = np.unique(np.where(turned[:, None], back, forth), axis=0, return_inverse=True)
        balance = np.bincount(group.ravel(), weights=np.where(turned, -1.0, 1.0))
        kept[rows] = balance[group.ravel()] != 0.0
    sizes = mesh.face_sizes[kept]
    offsets = np.concatenate(([0], np.cumsum(sizes)))
    return Mesh.from_arrays(mesh.points, offsets, mesh.connectivity[np.repeat(kept, mesh.face_sizes)])


def _enclosed_volume(mesh: Mesh, boundaries: npt.ArrayLike = ()) -> float:
    """Return the signed volume; of an open surface with its holes closed by cones to the rims' middle."""
    rim = np.asarray(boundaries, np.int64).ravel()
    middle = mesh.points[rim if len(rim) else mesh.connectivity].mean(axis=0)
    a, b, c = (mesh.points[mesh.connectivity[i::3]] - middle for i in range(3))
    return float(np.einsum("ij,ij", a, np.cross(b, c)) / 6.0)


def _turned(mesh: Mesh) -> Mesh:
    return Mesh(
        mesh.points, mesh.offsets, np.ascontiguousarray(mesh.connectivity.reshape(-1, 3)[:, ::-1]).ravel()
    )
