"""What OBJ, OFF, PLY and STL have in common: meshes as arrays, colours, and what belongs to corners."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]
Ints = npt.NDArray[np.int64]

#: Odd numbers whose multiples are spread over 64 bits.
_MIXING = tuple(np.uint64(i) for i in (0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9))

#: The field array of texture coordinates that differ at a point between the faces there: for each corner of
#: the faces, one after the other, the point and the two coordinates, NaN where a corner has none.
CORNER_TEXTURES = "CornerTCoords"

NONE: tuple[Ints, Ints] = (np.empty(0, np.int64), np.empty(0, np.int64))


class Polygons(NamedTuple):
    """A mesh as a file holds it.

    Attributes
    ----------
    points : (n, 3) float32 or float64
    sizes : (m,) int64
        Corners of each face.
    connectivity : (sum(sizes),) int64
        Point indices, face after face.
    point_data, cell_data : dict of str to array
        Arrays with one row for each point or cell; cells are the verts, the lines, the faces, in this order.
    verts, lines : pair of (k,) and (sum(sizes),) int64
        Sizes and point indices of the cells that are no faces.
    field_data : dict of str to array
        Arrays that belong to the mesh as a whole: numbers, or strings.
    roles : dict of str to str
        Names of the point arrays that are the mesh's ``Normals`` and ``TCoords``, if they have others.
    """

    points: Array
    sizes: Ints
    connectivity: Ints
    point_data: dict[str, Array]
    cell_data: dict[str, Array]
    verts: tuple[Ints, Ints] = NONE
    lines: tuple[Ints, Ints] = NONE
    field_data: dict[str, Array] = {}  # noqa: RUF012 (never written to)
    roles: dict[str, str] = {}  # noqa: RUF012

    def without_verts(self) -> Polygons:
        """Return the mesh without the cells that are points."""
        cells = {name: array[len(self.verts[0]) :] for name, array in self.cell_data.items()}
        return self._replace(verts=NONE, cell_data=cells)

    def only_faces(self) -> Polygons:
        """Return the mesh without the cells that are no faces."""
        before = len(self.verts[0]) + len(self.lines[0])
        cells = {name: array[before:] for name, array in self.cell_data.items()}
        return self._replace(verts=NONE, lines=NONE, cell_data=cells)

    def without_short_faces(self) -> tuple[Polygons, int]:
        """Return the mesh without faces of less than three corners, and how many these are."""
        kept = self.sizes >= 3
        if kept.all():
            return self, 0
        before = len(self.verts[0]) + len(self.lines[0])
        chosen = np.concatenate((np.ones(before, bool), kept))
        cells = {name: array[chosen] for name, array in self.cell_data.items()}
        corners = self.connectivity[np.repeat(kept, self.sizes)]
        return self._replace(sizes=self.sizes[kept], connectivity=corners, cell_data=cells), int(
            (~kept).sum()
        )

    def name_of(self, role: str, components: int) -> str | None:
        """Return the name of the point array that plays a role, None where there is none that can."""
        name = self.roles.get(role, role)
        array = self.point_data.get(name)
        fits = array is not None and array.ndim == 2 and array.shape[1] >= components
        return name if fits else None

    def corner_textures(self) -> Array | None:
        """Return texture coordinates of the faces' corners, (k, 2); None without any for these faces."""
        array = self.field_data.get(CORNER_TEXTURES)
        if array is None or array.shape != (len(self.connectivity), 3):
            return None
        return array[:, 1:] if np.array_equal(array[:, 0], self.connectivity) else None

    def colours(self, data: dict[str, Array]) -> str | None:
        """Return the name of the array of colours among `data` that text formats can hold, or None."""
        for name, components in (("RGBA", 4), ("RGB", 3)):
            array = data.get(name)
            if array is None or array.shape[1:] != (components,):
                continue
            if array.dtype == np.uint8 or (array.dtype.kind == "f" and ((array >= 0) & (array <= 1)).all()):
                return name
        return None


class Kept(NamedTuple):
    """Names of the arrays that a writer kept."""

    point_data: set[str]
    cell_data: set[str]
    field_data: set[str]


def colours(values: Array) -> Array | None:
    """Return (n, 3 or 4) numbers of a text file as colours: uint8, or float32 from 0 to 1; None if neither.

    Files count from 0 to 255 or from 0 to 1; numbers that are all at most 1 are of the second kind.
    """
    if not ((values >= 0) & (values <= 255)).all():
        return None
    scaled = values * 255.0 if values.max(initial=0.0) <= 1 else values
    rounded = np.round(scaled)
    # Six digits are written of numbers up to 1.
    if (np.abs(scaled - rounded) < 2e-3).all():
        return rounded.astype(np.uint8)
    return values.astype(np.float32) if values.max(initial=0.0) <= 1 else None


def at_points(n_points: int, connectivity: Ints, values: Array) -> Array | None:
    """Return (n, c) values at points of (k, c) values at corners; None where a point has several.

    Points without a face have 0.
    """
    result = np.zeros((n_points, values.shape[1]), values.dtype)
    result[connectivity] = values
    return result if np.array_equal(result[connectivity], values, equal_nan=True) else None


def numbered(names: Sequence[str], which: Ints) -> tuple[Array, Array]:
    """Return for each ``names[which[i]]`` its number among the distinct names in use, and these names.

    Returns
    -------
    numbers : (k,) int32
    distinct : (j,) str
        In the order of the sequence.
    """
    first: dict[str, int] = {}
    for i in np.unique(which).tolist():
        first.setdefault(names[i], len(first))
    table = np.array([first.get(name, 0) for name in names], np.int32)
    return table[which], np.array(list(first), dtype=object)


def parts(mesh: Polygons, kinds: Sequence[str]) -> tuple[str, Array, list[str]] | None:
    """Return which named part of the mesh each cell belongs to.

    The first of the `kinds` that the mesh has counts: its cell array ``<kind>Ids`` holds the number of each
    cell's part, its field array ``<kind>Names`` the names by number. A mesh of one part needs the names only.

    Returns
    -------
    kind : str
    numbers : (k,) int64
        For each cell, the part among those in use.
    names : list of str
    """
    n_cells = len(mesh.verts[0]) + len(mesh.lines[0]) + len(mesh.sizes)
    for kind in kinds:
        ids, names = mesh.cell_data.get(f"{kind}Ids"), mesh.field_data.get(f"{kind}Names")
        if ids is None and names is not None and len(names) == 1:
            ids = np.zeros(n_cells, np.int64)
        if ids is None or ids.ndim != 1 or not (np.isfinite(ids) & (ids == np.round(ids))).all():
            continue
        used, numbers = np.unique(ids.astype(np.int64), return_inverse=True)
        known = [] if names is None else [str(name) for name in names]
        labels = [known[i] if 0 <= i < len(known) else f"{kind.lower()}_{i}" for i in used.tolist()]
        return kind, numbers.astype(np.int64), labels
    return None


def merged(points: Array) -> tuple[Array, Ints]:
    """Return the distinct points, in the order of their first appearance, and the number of each point."""
    n = len(points)
    if n == 0:
        return points, np.empty(0, np.int64)
    # 0 and -0 are equal.
    bits = (points + points.dtype.type(0)).view(f"u{points.dtype.itemsize}")
    key = np.zeros(n, np.uint64)
    for column, odd in zip(bits.T, _MIXING, strict=True):
        key += column * odd
    # Sorting one number, the key above the place, is several times as fast as sorting by the coordinates.
    room = np.uint64(n.bit_length())
    key >>= room
    key <<= room
    key |= np.arange(n, dtype=np.uint64)
    key.sort()
    order = (key & ((np.uint64(1) << room) - np.uint64(1))).astype(np.int64)
    key >>= room
    found = _numbered(points, order, np.concatenate(([True], key[1:] != key[:-1])))
    if not np.array_equal(found[0][found[1]], points):  # different points have one key
        order = np.lexsort(points.T)
        ahead = points[order]
        found = _numbered(points, order, np.concatenate(([True], (ahead[1:] != ahead[:-1]).any(axis=1))))
    return found


def _numbered(points: Array, order: Ints, new: npt.NDArray[np.bool_]) -> tuple[Array, Ints]:
    """Return the first point of each group, and the group of each point, numbered by the first points.

    The groups come one after the other in `order`, each in the order of the points; `new` says where in it
    one begins.
    """
    first = order[new]
    by_file = np.argsort(first)
    number = np.empty(len(first), dtype=np.int64)
    number[by_file] = np.arange(len(first))
    group = np.empty(len(order), dtype=np.int64)
    group[order] = number[np.cumsum(new) - 1]
    return points[first[by_file]], group
