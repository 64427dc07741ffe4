"""Polydata as one surface: points in one place are one point, across blocks too; ghost cells are left out.

What a filter works on is a polydata with one point for each place. What it changes there goes back to every
copy of the point, in every block; topology and order of points and cells stay those of the blocks.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData

from ..errors import Cancelled, InvalidMeshError, VtksmoothError
from ..kernels.mesh.mesh import Mesh
from ..kernels.mesh.places import distinct_places, join_points
from .arrays import (
    Surface,
    edge_array,
    output_like,
    point_array,
    points_of,
    rows_of,
    surface_of,
    vtk_array,
    vtk_cells,
    vtk_points,
    vtk_triangles,
)

Int64 = npt.NDArray[np.int64]
Bool = npt.NDArray[np.bool_]

#: The array by which VTK marks ghosts.
GHOSTS = "vtkGhostType"

#: Its bits: cells that are duplicates of another piece's, and those that are refined or hidden; points that
#: are duplicates or hidden.
DUPLICATES, HIDDEN = 1, 8 | 32
_GHOST_POINTS = 1 | 2

#: The cell array that says which cell each cell of a result with other faces was part of.
ORIGINAL_CELL = "OriginalCell"


class Merge(NamedTuple):
    """What becomes of a point array where several points are one.

    Attributes
    ----------
    rule : {"any", "least", "greatest", "mean", "neighbours"}
        One if any value is nonzero; the least or greatest value; the mean; or (n, 2) numbers of
        neighbours, -1 for none.
    missing : float or None
        The value of blocks without the array. None: the array counts only if all blocks have it.
    components : int
        How many the array has.
    """

    rule: str
    missing: float | None = 0.0
    components: int = 1


@dataclass(frozen=True)
class Block:
    """One polydata with faces, and where it stands in composite data (None: it is all there is)."""

    index: int | None
    data: Any


class Joined:
    """Blocks as one surface.

    Attributes
    ----------
    polydata : vtkPolyData
        One point for each place, in the order of the first points there; the faces (strips as triangles), and
        the arrays.
    place : (n,) int64
        For each point of the blocks, one block after another, the point of the polydata.
    first : (p,) int64
        For each point of the polydata the first of those.
    starts : list of int
        Number of the first point of each block, and the number of all points.
    pinned : (p,) bool
        Points of the polydata that must not move: those of ghosts, and several ones in one place, see
        :class:`~vtksmooth.kernels.mesh.places.Joint`.
    """

    def __init__(
        self, blocks: Sequence[Block], surfaces: Sequence[Surface], place: Int64, first: Int64
    ) -> None:
        self.blocks, self._surfaces, self.place, self.first = blocks, surfaces, place, first
        sizes = [surface.mesh.n_points for surface in surfaces]
        self.starts = [0, *np.cumsum(sizes).tolist()]
        faces = [surface.mesh for surface in surfaces]
        self._corners = np.concatenate(
            [
                mesh.connectivity.astype(np.int64) + start
                for mesh, start in zip(faces, self.starts, strict=False)
            ]
        )
        self._sizes = np.concatenate([mesh.face_sizes for mesh in faces])
        self._offsets = np.concatenate(([0], np.cumsum(self._sizes, dtype=np.int64)))
        self._owner = np.repeat(np.arange(len(faces)), [mesh.n_faces for mesh in faces])
        self._cell = np.concatenate([surface.cells for surface in surfaces])
        self.polydata = vtkPolyData()

    # -- what filters ask --------------------------------------------------------------------------

    @property
    def merged_points(self) -> int:
        """How many points lie where another one is already."""
        return len(self.place) - len(self.first)

    @cached_property
    def counted(self) -> Bool:
        """The points that are not only those of ghost cells, (n,)."""
        used = np.zeros(len(self.place), np.bool_)
        used[self._corners] = True
        own = ~used
        own[self._corners[np.repeat(~self._ghost, self._sizes)]] = True
        return own

    @property
    def counted_places(self) -> Bool:
        """The places of the points that are counted, (p,)."""
        own = np.zeros(len(self.first), np.bool_)
        own[self.place[self.counted]] = True
        return own

    def copies(self, block: int | None = None) -> Int64:
        """Return how many counted points, of all blocks or of one, each point of the polydata is, (p,)."""
        mine = self.counted.copy()
        if block is not None:
            mine[: self.starts[block]] = mine[self.starts[block + 1] :] = False
        return np.bincount(self.place[mine], minlength=len(self.first))

    @property
    def block_of_faces(self) -> Int64:
        """The block of each face of the polydata."""
        return np.asarray(self._owner[self._faces])

    @property
    def cell_of_faces(self) -> Int64:
        """The cell of its block that each face of the polydata is, or is part of."""
        return np.asarray(self._cell[self._faces])

    def places_of(self, block: int, points: Int64) -> Int64:
        """Return the places of points that are numbered as in a block."""
        places: Int64 = self.place[self.starts[block] + points]
        return places

    def points_in(self, block: int, places: Int64) -> Int64:
        """Return for each place the number of the first point there in a block, -1 for none; of -1, -1."""
        known = np.full(len(self.first) + 1, -1, np.int64)
        start, end = self.starts[block : block + 2]
        known[self.place[start:end][::-1]] = np.arange(end - start)[::-1]
        return known[places]

    # -- before the run ----------------------------------------------------------------------------

    def take_faces(self, clean: bool, skipped: int) -> None:
        """Choose the faces that the filter sees.

        Parameters
        ----------
        clean : bool
            Leave out faces without area and those that cover another one, and keep points apart where the
            faces there are no surface, see :func:`~vtksmooth.kernels.mesh.places.join_points`.
        skipped : int
            Bits of the ghost cells that are left out.
        """
        pinned = np.zeros(len(self.first), np.bool_)
        kinds = np.zeros(len(self._cell), np.uint8)
        for number, (block, surface) in enumerate(zip(self.blocks, self._surfaces, strict=True)):
            of_cells, of_points = (ghost_kinds(block.data, home) for home in ("GetCellData", "GetPointData"))
            if of_cells is not None:
                kinds[self._owner == number] = of_cells[surface.cells]
            if of_points is not None:
                pinned[self.places_of(number, np.flatnonzero(of_points & _GHOST_POINTS))] = True
        self._ghost = (kinds & (DUPLICATES | HIDDEN)) != 0
        pinned[self.place[self._corners[np.repeat(self._ghost, self._sizes)]]] = True
        kept = (kinds & skipped) == 0
        self._faces = np.flatnonzero(kept)
        corners = self._corners[np.repeat(kept, self._sizes)]
        offsets = np.concatenate(([0], np.cumsum(self._sizes[kept])))
        points = _in_common_precision([block.data for block in self.blocks])
        if clean and self.merged_points:
            # Both numberings name all points of a place, so that what is pinned is pinned at all of them.
            place = self.place
            joint = join_points(Mesh.from_arrays(points, offsets, corners), place, self.first)
            self.place, self.first, self._faces = joint.vertex, joint.first, self._faces[joint.faces]
            offsets, corners = joint.offsets, joint.connectivity
            pinned = pinned[place[self.first]] | joint.apart
        else:
            corners = self.place[corners]
        self.pinned = pinned
        self.polydata.SetPoints(vtk_points(points[self.first]))
        self.polydata.SetPolys(vtk_cells(offsets, corners))

    def take_arrays(self, merges: Mapping[str, Merge], edges: Sequence[str]) -> None:
        """Give the polydata the arrays of the blocks.

        Parameters
        ----------
        merges : mapping of str to Merge
            The point arrays that filters go by. Others have the values of the first point.
        edges : sequence of str
            Field arrays of pairs of points.
        """
        self._edges, self._merges = edges, merges
        data = self.polydata.GetPointData()
        for name in self._names("GetPointData"):
            merge = merges.get(name)
            values = self._merged(name, merge) if merge else self._of_all("GetPointData", name, self.first)
            if values is not None:
                data.AddArray(vtk_array(values, name))
        rows = self._faces
        for name in self._names("GetCellData"):
            values = self._of_all("GetCellData", name, rows, merges.get(name))
            if values is not None:
                self.polydata.GetCellData().AddArray(vtk_array(values, name))
        for name in edges:
            pairs = [self._edges_of(number, name) for number in range(len(self.blocks))]
            if any(part is not None for part in pairs):
                both = np.concatenate([part for part in pairs if part is not None])
                self.polydata.GetFieldData().AddArray(vtk_array(both[both[:, 0] != both[:, 1]], name))

    def like(self, others: Sequence[Any]) -> vtkPolyData:
        """Return the same faces over the points of other polydata, one for each block."""
        other = vtkPolyData()
        other.SetPoints(vtk_points(_in_common_precision(others)[self.first]))
        other.SetPolys(self.polydata.GetPolys())
        return other

    def _names(self, home: str) -> list[str]:
        names: dict[str, None] = {}
        for block in self.blocks:
            data = getattr(block.data, home)()
            names |= dict.fromkeys(data.GetArrayName(i) for i in range(data.GetNumberOfArrays()))
        return [name for name in names if name and name != GHOSTS]

    def _merged(self, name: str, merge: Merge) -> npt.NDArray[Any] | None:
        components = merge.components
        parts = []
        for block in self.blocks:
            with named(block):
                values = point_array(block.data, name, components)
            if values is None:
                if merge.missing is None:
                    return None
                values = np.full((block.data.GetNumberOfPoints(), components)[:components], merge.missing)
            parts.append(values)
        if merge.rule == "neighbours":
            return self._merged_neighbours(parts)
        values = np.concatenate(parts)
        if not self.merged_points:
            return values
        if merge.rule == "any":
            result = np.zeros(len(self.first), np.uint8)
            result[self.place[values != 0]] = 1
            return result
        result = values[self.first]
        if merge.rule == "mean":
            columns = values.reshape(len(values), -1).T
            total = [np.bincount(self.place, column, len(self.first)) for column in columns]
            mean = np.column_stack(total) / np.bincount(self.place, minlength=len(self.first))[:, None]
            return mean.reshape(-1, *values.shape[1:])
        (np.minimum if merge.rule == "least" else np.maximum).at(result, self.place, values)
        return result

    def _merged_neighbours(self, parts: Sequence[npt.NDArray[Any]]) -> npt.NDArray[Any]:
        everywhere = np.concatenate(
            [self._places_of_numbers(number, rows) for number, rows in enumerate(parts)]
        )
        result = everywhere[self.first]
        # Lines that end at a copy may go on at another.
        new = ((everywhere >= 0) & (everywhere[:, :, None] != result[self.place][:, None]).all(axis=2)).any(1)
        for v in np.flatnonzero(new):
            row = result[self.place[v]]
            for neighbour in everywhere[v]:
                if neighbour >= 0 and neighbour not in row and (row == -1).any():
                    row[np.argmax(row == -1)] = neighbour
        return result

    def _places_of_numbers(self, number: int, values: npt.NDArray[Any]) -> Int64:
        """Return the places of points named by numbers in a block: -1 for -1, and -2 for what is none."""
        values = values.astype(np.int64)
        known = (values >= 0) & (values < self.starts[number + 1] - self.starts[number])
        places = self.places_of(number, np.where(known, values, 0))
        return np.where(known, places, np.where(values == -1, -1, -2))

    def _edges_of(self, number: int, name: str) -> Int64 | None:
        block = self.blocks[number]
        with named(block):
            pairs = edge_array(block.data, name)
            if pairs is None:
                return None
            n = block.data.GetNumberOfPoints()
            if not ((pairs >= 0) & (pairs < n)).all():
                raise InvalidMeshError(
                    f"The field array {name!r} names points that are not there; it belongs to another mesh, "
                    "remove it."
                )
        return self.places_of(number, pairs.astype(np.int64))

    def _of_all(
        self, home: str, name: str, rows: Int64, merge: Merge | None = None
    ) -> npt.NDArray[Any] | None:
        """Return rows of an array that all blocks have in the same form, otherwise None.

        Of points, or of the cells of faces. With a `merge` blocks may do without it.
        """
        parts: list[npt.NDArray[Any] | None] = []
        for block, surface in zip(self.blocks, self._surfaces, strict=True):
            array = getattr(block.data, home)().GetArray(name)
            plain = array is not None and not array.IsA("vtkBitArray")
            values = vtk_to_numpy(array) if plain else None
            count = surface.n_cells if home == "GetCellData" else surface.mesh.n_points
            if values is not None and len(values) != count:
                return None
            parts.append(values[surface.cells] if values is not None and home == "GetCellData" else values)
        shapes = {part.shape[1:] for part in parts if part is not None}
        if len(shapes) != 1 or (merge is None and any(part is None for part in parts)):
            return None
        shape = shapes.pop()
        whole = [
            np.zeros((surface.mesh.n_faces, *shape)) if part is None else part
            for part, surface in zip(parts, self._surfaces, strict=True)
        ]
        return np.concatenate(whole)[rows]

    # -- after the run -----------------------------------------------------------------------------

    def spread(self, result: Any, keep_precision: bool) -> list[vtkPolyData]:
        """Return the blocks with what a filter has made of them: points, faces, arrays.

        Parameters
        ----------
        result : vtkPolyData
            What the filter has made of :attr:`polydata`.
        keep_precision : bool
            Whether points of blocks in single precision stay in it.
        """
        outputs = [output_like(block.data) for block in self.blocks]
        if result.GetPoints() is not self.polydata.GetPoints():
            self._spread_points(points_of(result), outputs, keep_precision)
        if result.GetPolys() is not self.polydata.GetPolys():
            self._spread_faces(result, outputs)
        else:
            self._spread_cell_arrays(result, outputs)
        for name, array in _changed(self.polydata.GetPointData(), result.GetPointData()):
            for number, output in enumerate(outputs):
                start, end = self.starts[number : number + 2]
                output.GetPointData().RemoveArray(name)
                if array is not None:
                    values = vtk_to_numpy(array)[self.place[start:end]]
                    if name in self._merges and self._merges[name].rule == "neighbours":
                        values = self.points_in(number, values).astype(values.dtype)
                    output.GetPointData().AddArray(vtk_array(values, name))
        for name, array in _changed(self.polydata.GetFieldData(), result.GetFieldData()):
            for number, output in enumerate(outputs):
                output.GetFieldData().RemoveArray(name)
                if array is None:
                    continue
                if name in self._edges:
                    pairs = vtk_to_numpy(array)
                    mine = self.points_in(number, pairs).astype(pairs.dtype)
                    mine = mine[(mine >= 0).all(axis=1)]
                    if len(mine):
                        output.GetFieldData().AddArray(vtk_array(mine, name))
                else:
                    output.GetFieldData().AddArray(array)
        return outputs

    def _spread_points(
        self, points: npt.NDArray[Any], outputs: Sequence[vtkPolyData], keep_precision: bool
    ) -> None:
        single = [
            points.dtype == np.float32 or (keep_precision and points_of(block.data).dtype == np.float32)
            for block in self.blocks
        ]
        if any(single) and not all(single):
            # Copies must not part by rounding.
            points = points.copy()
            for number in [number for number, is_single in enumerate(single) if is_single]:
                mine = self.place[self.starts[number] : self.starts[number + 1]]
                points[mine] = points[mine].astype(np.float32)
        for number, output in enumerate(outputs):
            mine = points[self.place[self.starts[number] : self.starts[number + 1]]]
            # Points that move keep the bits of those that do not: -0.0 stays what it is, and so does NaN.
            given = points_of(self.blocks[number].data)
            mine = mine.astype(np.float32 if single[number] else mine.dtype)
            stays = mine == given
            mine[stays] = given[stays]
            output.SetPoints(vtk_points(mine))

    def _spread_cell_arrays(self, result: Any, outputs: Sequence[vtkPolyData]) -> None:
        """Give cells that the filter has not seen 1 in new arrays, strips the least of their triangles."""
        for name, array in _changed(self.polydata.GetCellData(), result.GetCellData()):
            values = np.ones(len(self._cell))
            values[self._faces] = vtk_to_numpy(array)
            for number, output in enumerate(outputs):
                mine = self._owner == number
                cells = np.ones(output.GetNumberOfCells())
                np.minimum.at(cells, self._cell[mine], values[mine])
                output.GetCellData().AddArray(vtk_array(cells, name))

    def _spread_faces(self, result: Any, outputs: Sequence[vtkPolyData]) -> None:
        """Triangles over places become triangles over the points of the faces that they are part of."""
        triangles = vtk_to_numpy(result.GetPolys().GetConnectivityArray()).reshape(-1, 3).astype(np.int64)
        face = self._faces[vtk_to_numpy(result.GetCellData().GetArray(ORIGINAL_CELL))]
        n = len(self.first)
        keys = np.repeat(np.arange(len(self._sizes)), self._sizes) * n + self.place[self._corners]
        known, corner = np.unique(keys, return_index=True)
        points = self._corners[corner[np.searchsorted(known, face[:, None] * n + triangles)]]
        whole = self._sizes[face] == 3
        points[whole] = self._corners[self._offsets[face[whole]][:, None] + np.arange(3)]
        for number, output in enumerate(outputs):
            mine = self._owner[face] == number
            data = self.blocks[number].data
            others = data.GetNumberOfVerts() + data.GetNumberOfLines()
            original = np.concatenate((np.arange(others, dtype=np.int64), self._cell[face[mine]]))
            output.SetStrips(vtkCellArray())
            output.SetPolys(vtk_triangles(points[mine] - self.starts[number]))
            output.GetCellData().ShallowCopy(rows_of(data.GetCellData(), original))
            output.GetCellData().AddArray(vtk_array(original, ORIGINAL_CELL))


def joined(blocks: Sequence[Block], others: Sequence[Any] | None, clean: bool, skipped: int) -> Joined | None:
    """Return blocks as one surface; None where that is the only block just as it is.

    Parameters
    ----------
    blocks : sequence of Block
    others : sequence of vtkPolyData, optional
        For each block the same faces over other points: points are one if they coincide in both.
    clean, skipped
        See :meth:`Joined.take_faces`.

    Raises
    ------
    InvalidMeshError
        A block is no usable surface; the message names it.
    """
    surfaces = []
    for block in blocks:
        with named(block):
            surfaces.append(surface_of(block.data))
    coordinates = np.concatenate([surface.mesh.points for surface in surfaces])
    if others is not None:
        more = np.concatenate([points_of(data) for data in others])
        coordinates = np.column_stack((coordinates, more.astype(np.float64)))
    place, first = distinct_places(coordinates)
    if len(first) < len(place):
        # Points that no face uses are in no place.
        used = [np.bincount(s.mesh.connectivity, minlength=s.mesh.n_points) > 0 for s in surfaces]
        coordinates = np.where(np.concatenate(used)[:, None], coordinates, np.nan)
        place, first = distinct_places(coordinates)
    ghosts = any(
        kinds is not None and (kinds & bits).any()
        for block in blocks
        for home, bits in (("GetCellData", DUPLICATES | HIDDEN), ("GetPointData", _GHOST_POINTS))
        for kinds in [ghost_kinds(block.data, home)]
    )
    if len(blocks) == 1 and len(first) == len(place) and not ghosts:
        return None
    result = Joined(blocks, surfaces, place, first)
    result.take_faces(clean, skipped)
    if result.polydata.GetNumberOfPolys():
        return result
    if len(blocks) == 1 and not ghosts:
        return None  # only faces without area: filters know what to say of them
    result = Joined(blocks, surfaces, place, first)
    result.take_faces(False, 0)
    return result


def ghost_kinds(polydata: Any, home: str) -> npt.NDArray[np.uint8] | None:
    """Return the ghost array of the points ("GetPointData") or cells ("GetCellData"); None without one."""
    data = getattr(polydata, home)()
    array = data.GetArray(GHOSTS)
    count = polydata.GetNumberOfCells() if home == "GetCellData" else polydata.GetNumberOfPoints()
    if array is None or array.GetNumberOfTuples() != count or array.GetNumberOfComponents() != 1:
        return None
    return np.asarray(vtk_to_numpy(array).astype(np.uint8))


@contextmanager
def named(block: Block) -> Iterator[None]:
    """While this context is open, errors name the block."""
    try:
        yield
    except Cancelled:
        raise
    except VtksmoothError as error:
        if block.index is None:
            raise
        raise type(error)(f"Block {block.index}: {error}") from error


def _in_common_precision(polydata: Sequence[Any]) -> npt.NDArray[Any]:
    points = [points_of(data) for data in polydata]
    single = all(array.dtype == np.float32 for array in points)
    return np.concatenate([array.astype(np.float32 if single else np.float64) for array in points])


def _changed(before: Any, after: Any) -> list[tuple[str, Any]]:
    """Return the names of arrays that are new or others in field data, with the array; None: it is gone."""
    old = {before.GetArrayName(i): before.GetAbstractArray(i) for i in range(before.GetNumberOfArrays())}
    new = {after.GetArrayName(i): after.GetAbstractArray(i) for i in range(after.GetNumberOfArrays())}
    changed = [(name, array) for name, array in new.items() if array is not old.get(name)]
    return changed + [(name, None) for name in old if name not in new]
