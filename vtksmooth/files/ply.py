"""The PLY file format: a header that declares elements and their properties, then the values.

VTK's own reader keeps single precision only, drops most properties, and ends the process on a
truncated file; hence this one. Reference: Greg Turk, "The PLY Polygon File Format", 1994.
"""

from __future__ import annotations

import re
import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any

import numpy as np
import numpy.typing as npt

from ..errors import MeshFileError
from .polygons import CORNER_TEXTURES, NONE, Kept, Polygons, at_points
from .text import decoded, quoted, rows

_HEAD = 1 << 20

#: Some programs put it before text.
_MARK = b"\xef\xbb\xbf"

_TYPES = {
    **{"char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4"},
    **{"float": "f4", "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2"},
    **{"int32": "i4", "uint32": "u4", "float32": "f4", "float64": "f8"},
    **{"int64": "i8", "uint64": "u8", "longlong": "i8", "ulonglong": "u8"},  # of some programs
}
_NAMES = {"i1": "char", "u1": "uchar", "i2": "short", "u2": "ushort", "i4": "int", "u4": "uint"} | {
    "f4": "float",
    "f8": "double",
}

#: Properties that belong together, and the array VTK makes of them; the last names are those written.
_GROUPS = (
    (("nx", "ny", "nz"), "Normals"),
    (("diffuse_red", "diffuse_green", "diffuse_blue"), "RGB"),
    (("red", "green", "blue", "alpha"), "RGBA"),
    (("red", "green", "blue"), "RGB"),
    (("s", "t"), "TCoords"),
    (("texture_u", "texture_v"), "TCoords"),
)

Array = npt.NDArray[Any]


@dataclass
class _Property:
    name: str
    type: str
    count_type: str | None = None  # of a list


@dataclass
class _Element:
    name: str
    count: int
    properties: list[_Property] = field(default_factory=list)


def _read_header(path: Path, head: bytes) -> tuple[str, list[_Element], int]:
    """Return the byte order ("<", ">" or "" for text), the elements, and where the values begin."""

    def broken(what: str) -> MeshFileError:
        return MeshFileError(f"{path.name} is no proper PLY file: {what}; export it again.")

    if not re.match(rb"ply[ \t]*[\r\n]", head):
        raise MeshFileError(f"{path.name} does not begin with ply, so it is no PLY file; check its name.")
    last = re.search(rb"[\r\n]end_header[ \t]*(\r\n|\n|\r)", head)
    if not last:
        raise broken("its header has no end_header")
    start = last.end()
    if last[1] == b"\r\n" and re.match(rb"ply[ \t]*\r[^\n]", head):
        start -= 1  # lines end with CR: the LF is the first value
    order: str | None = None
    elements: list[_Element] = []
    for line in head[: last.start()].splitlines()[1:]:
        match decoded(line).split():
            case ["format", "ascii", _]:
                order = ""
            case ["format", "binary_little_endian", _]:
                order = "<"
            case ["format", "binary_big_endian", _]:
                order = ">"
            case ["element", name, count] if re.fullmatch("[0-9]{1,18}", count):
                if any(name == element.name for element in elements):
                    raise broken(f"its header has the element {quoted(name.encode())} twice")
                elements.append(_Element(name, int(count)))
            case ["property", *_, name] if elements and name in [p.name for p in elements[-1].properties]:
                raise broken(f"its header has the property {quoted(name.encode())} twice")
            case ["property", "list", count_type, item, name] if (
                elements and item in _TYPES and _TYPES.get(count_type, "f")[0] != "f"
            ):
                elements[-1].properties.append(_Property(name, _TYPES[item], _TYPES[count_type]))
            case ["property", item, name] if elements and item in _TYPES:
                elements[-1].properties.append(_Property(name, _TYPES[item]))
            case ["comment" | "obj_info", *_] | []:
                pass
            case _:
                raise broken(f"its header has the line {quoted(line)}")
    if order is None:
        raise broken("its header has no known format line")
    return order, elements, start


class _Values:
    """The values behind the header: bytes of a binary file, numbers of a text file.

    Either way an element is a table whose rows have a width that is known once the lengths of their
    lists are; only the unit of the width differs.
    """

    def __init__(self, path: Path, order: str, raw: Array) -> None:
        self.path, self.order, self.raw, self.position = path, order, raw, 0
        #: Names of properties of text files with values that their types do not hold.
        self.changed: set[str] = set()

    def width(self, kind: str) -> int:
        return int(kind[1]) if self.order else 1

    def convert(self, raw: Array, kind: str, name: str = "") -> Array:
        """Turn (rows, columns * width) of raw values into (rows, columns) in the machine's byte order.

        Values of a property with a name are looked at, whether the type holds them.
        """
        if not self.order:
            with np.errstate(invalid="ignore", over="ignore"):
                values = raw.astype(kind)
            if name and (kind[0] != "f" or np.isinf(values).any()):
                lost = values != raw if kind[0] != "f" else np.isinf(values) & np.isfinite(raw)
                self.changed |= {name} if lost.any() else set()
            return values
        return np.ascontiguousarray(raw).view(self.order + kind).astype(kind, copy=False)

    def truncated(self, element: _Element) -> MeshFileError:
        return MeshFileError(
            f"{self.path.name} ends in the middle of its {element.count} elements {element.name!r}; "
            "it is truncated, export it again."
        )

    def _length(self, element: _Element, kind: str, position: int) -> int:
        width = self.width(kind)
        if position + width > len(self.raw):
            raise self.truncated(element)
        length = int(self.convert(self.raw[position : position + width].reshape(1, width), kind)[0, 0])
        if length < 0:
            raise MeshFileError(f"{self.path.name} has a list of {length} values; export it again.")
        return length

    def table(self, element: _Element) -> dict[str, tuple[Array, Array]]:
        """Read all rows of an element: for each property the lengths (rows,) and the values, flat.

        A single value is a list of length 1.
        """
        rows, first = element.count, self.position
        if rows == 0:
            return {p.name: (np.empty(0, np.int64), np.empty(0, p.type)) for p in element.properties}
        if rows * sum(self.width(p.count_type or p.type) for p in element.properties) > len(self.raw) - first:
            raise self.truncated(element)
        # Nearly always all rows are as long as the first one: read them as one rectangle.
        columns: list[tuple[_Property, int, int]] = []  # property, start in the row, length
        width = 0
        for p in element.properties:
            length = 1
            if p.count_type:
                length = self._length(element, p.count_type, first + width)
                width += self.width(p.count_type)
            columns.append((p, width, length))
            width += length * self.width(p.type)
        if rows * width <= len(self.raw) - first:
            block = self.raw[first : first + rows * width].reshape(rows, width)
            if all(
                (self.convert(block[:, at - self.width(p.count_type) : at], p.count_type) == length).all()
                for p, at, length in columns
                if p.count_type
            ):
                self.position += rows * width
                return {
                    p.name: (
                        np.full(rows, length, np.int64),
                        self.convert(block[:, at : at + length * self.width(p.type)], p.type, p.name).ravel(),
                    )
                    for p, at, length in columns
                }
        return self._ragged(element)

    def _ragged(self, element: _Element) -> dict[str, tuple[Array, Array]]:
        """Read rows of different lengths: walk over the lengths, then gather property by property."""
        starts: list[list[int]] = [[] for _ in element.properties]
        lengths: list[list[int]] = [[] for _ in element.properties]
        plan = [
            (p.count_type, p.count_type and self.width(p.count_type), self.width(p.type), s, n)
            for p, s, n in zip(element.properties, starts, lengths, strict=True)
        ]
        one_byte = bytes(self.raw) if self.order else b""
        at = self.position
        for _ in range(element.count):
            for count_type, count_width, width, start, length in plan:
                n = 1
                if count_type:
                    # One byte nearly always, and this is the innermost loop.
                    if count_type == "u1" and self.order and at < len(one_byte):
                        n = one_byte[at]
                    else:
                        n = self._length(element, count_type, at)
                    at += count_width or 0
                start.append(at)
                length.append(n)
                at += n * width
            if at > len(self.raw):
                raise self.truncated(element)
        self.position = at
        return {
            p.name: (
                np.array(n, np.int64),
                self._gather(np.array(s, np.int64), np.array(n, np.int64), p),
            )
            for p, s, n in zip(element.properties, starts, lengths, strict=True)
        }

    def _gather(self, starts: Array, lengths: Array, p: _Property) -> Array:
        width = self.width(p.type)
        ends = np.cumsum(lengths)
        inside = np.arange(ends[-1]) - np.repeat(ends - lengths, lengths)
        at = np.repeat(starts, lengths) + width * inside
        return self.convert(self.raw[at[:, None] + np.arange(width)], p.type, p.name).ravel()


def _arrays(table: dict[str, tuple[Array, Array]], properties: list[_Property]) -> dict[str, Array]:
    """Make data arrays of the single-valued properties."""
    single = {p.name: table[p.name][1] for p in properties if p.count_type is None}
    arrays: dict[str, Array] = {}
    for names, joined in _GROUPS:
        if all(name in single for name in names):
            arrays[joined] = np.column_stack([single.pop(name) for name in names])
    return arrays | single


def read(path: Path) -> tuple[Polygons, list[str]]:
    """Read a PLY file, text or binary of either byte order.

    Returns
    -------
    Polygons
        Points in the file's precision; faces, strips as their triangles, edges as lines; every
        single-valued property of points and faces as an array, normals, colours and texture coordinates
        joined as ``Normals``, ``RGB`` or ``RGBA``, ``TCoords``. What edges and strips have no value of is 0.
    list of str
        What was left out, one sentence each.

    Raises
    ------
    MeshFileError
        The file is no PLY file, truncated, damaged, or has no points or faces.
    """
    with path.open("rb") as file:
        head = file.read(_HEAD)
        mark = len(_MARK) if head.startswith(_MARK) else 0
        order, elements, start = _read_header(path, head[mark:])
        # Every element takes a byte at least: what cannot be is refused before it is read.
        if sum(e.count for e in elements if e.properties) > path.stat().st_size:
            raise MeshFileError(
                f"{path.name} announces more elements than it has bytes; it is truncated, export it again."
            )
        file.seek(mark + start)
        raw: Array
        notes: list[str] = []
        if order:
            raw = np.fromfile(file, dtype=np.uint8)
        else:
            found = rows(file.read())
            if found is None:
                raise MeshFileError(
                    f"{path.name} has something else than numbers after its header; export it again."
                )
            raw = found.values
            notes += [f"{path.name}: decimal commas were taken for points."] * found.commas
    values = _Values(path, order, raw)
    tables: dict[str, dict[str, tuple[Array, Array]]] = {}
    kinds: dict[str, list[_Property]] = {}
    for element in elements:
        kinds[element.name] = element.properties
        tables[element.name] = values.table(element)
    if values.position < len(raw):
        behind = f"{len(raw) - values.position} {'bytes' if order else 'numbers'}"
        notes.append(f"{path.name}: {behind} behind the last element left out.")
    if values.changed:
        notes.append(
            f"{path.name}: numbers that the types in the header do not hold were changed: "
            f"{', '.join(sorted(values.changed))}."
        )
    vertex, face, edge = (tables.get(name, {}) for name in ("vertex", "face", "edge"))
    strips = tables.get("tristrips", {})
    corners, strip = (_corners(kinds.get(name, [])) for name in ("face", "tristrips"))
    single = {name: {p.name for p in properties if not p.count_type} for name, properties in kinds.items()}
    if not {"x", "y", "z"} <= single.get("vertex", set()):
        raise MeshFileError(f"{path.name} has no points with x, y and z; export it as a surface mesh.")
    if corners is None and strip is None:
        raise MeshFileError(f"{path.name} has no faces; export it as a mesh of polygons.")
    if not len(vertex["x"][1]):
        raise MeshFileError(f"{path.name} has no points; export it as a surface mesh.")
    point_data = _arrays(vertex, kinds["vertex"])
    points = np.column_stack([point_data.pop(axis) for axis in "xyz"])
    if points.dtype not in (np.float32, np.float64):
        points = points.astype(np.float64)
    cell_data: dict[str, Array] = {}
    sizes, connectivity = NONE
    if corners is not None:
        sizes, connectivity = face[corners][0], _indices(path, face[corners][1])
        cell_data = _arrays(face, kinds["face"])
    field_data: dict[str, Array] = {}
    used: set[str | None] = {corners}
    textures = None if corners is None else _corner_textures(face, corners, len(points), connectivity)
    if textures is not None and "TCoords" not in point_data:
        used.add("texcoord")
        array = at_points(len(points), connectivity, textures)
        if array is not None:
            point_data["TCoords"] = array
        elif strip is None:
            field_data[CORNER_TEXTURES] = np.column_stack((connectivity, textures)).astype(np.float64)
            notes.append(
                f"{path.name}: texture coordinates are kept in the field array {CORNER_TEXTURES} only, as "
                "they differ at points between the faces there."
            )
        else:
            used.discard("texcoord")
    if strip is not None:
        triangles = _triangles(strips[strip][0], _indices(path, strips[strip][1]))
        notes.append(f"{path.name}: triangle strips were taken as their {len(triangles)} triangles.")
        sizes = np.concatenate((sizes, np.full(len(triangles), 3, np.int64)))
        connectivity = np.concatenate((connectivity, triangles.ravel()))
        cell_data = {name: _padded(array, 0, len(triangles)) for name, array in cell_data.items()}
    lines = NONE
    if {"vertex1", "vertex2"} <= single.get("edge", set()):
        ends = np.column_stack([_indices(path, edge[name][1]) for name in ("vertex1", "vertex2")])
        lines = np.full(len(ends), 2, np.int64), ends.ravel()
        of_edges = _arrays(edge, [p for p in kinds["edge"] if p.name not in ("vertex1", "vertex2")])
        n_faces = len(sizes)
        others = [
            name
            for name, array in of_edges.items()
            if name in cell_data and cell_data[name].ndim != array.ndim
        ]
        if others:
            notes.append(f"{path.name}: {', '.join(others)} of edges left out, as those of faces are others.")
        cell_data = {
            name: np.concatenate((of_edges[name], array))
            if name in of_edges and name not in others
            else _padded(array, len(ends), 0)
            for name, array in cell_data.items()
        } | {name: _padded(array, 0, n_faces) for name, array in of_edges.items() if name not in cell_data}
    ignored = [
        *(
            name
            for name in tables
            if name not in ("vertex", "face")
            and not (name == "tristrips" and strip is not None)
            and not (name == "edge" and len(lines[0]))
        ),
        *(p.name for p in kinds["vertex"] if p.count_type),
        *(p.name for p in kinds.get("face", []) if p.count_type and p.name not in used),
    ]
    if ignored:
        notes.append(f"{path.name}: {', '.join(ignored)} left out (kept: points, faces, single values).")
    return Polygons(
        points, sizes, connectivity, point_data, cell_data, lines=lines, field_data=field_data
    ), notes


def _indices(path: Path, values: Array) -> npt.NDArray[np.int64]:
    """Return point indices of any type as integers."""
    if values.dtype.kind == "f" and not (np.abs(values) < 2**53).all():
        raise MeshFileError(f"{path.name} is damaged: a point index is no number; export it again.")
    whole = values.astype(np.int64)
    if values.dtype.kind == "f" and (whole != values).any():
        raise MeshFileError(f"{path.name} is damaged: a point index has a fraction; export it again.")
    return whole


def _corners(properties: list[_Property]) -> str | None:
    """Return the name of the list of point indices."""
    lists = {p.name for p in properties if p.count_type}
    return next((name for name in ("vertex_indices", "vertex_index") if name in lists), None)


def _padded(array: Array, before: int, behind: int) -> Array:
    """Return an array with rows of 0 for cells that have no value of it."""
    padded: Array = np.pad(array, [(before, behind), *[(0, 0)] * (array.ndim - 1)])
    return padded


def _corner_textures(
    face: dict[str, tuple[Array, Array]], corners: str, n_points: int, connectivity: Array
) -> Array | None:
    """Return the texture coordinates of the faces' corners, (k, 2); None without one for each."""
    lengths, values = face.get("texcoord", NONE)
    if (
        not len(values)
        or not np.array_equal(lengths, 2 * face[corners][0])
        or connectivity.min() < 0
        or connectivity.max() >= n_points
    ):
        return None
    return values.reshape(-1, 2)


def _triangles(lengths: Array, corners: Array) -> Array:
    """Return the triangles of strips, (t, 3): a strip ends with its list, or before a -1."""
    ends = np.cumsum(lengths)
    number = np.repeat(np.arange(len(lengths)), lengths)
    # A new strip begins with each list and behind each -1.
    begins = np.concatenate(((ends - lengths)[lengths > 0], np.flatnonzero(corners == -1) + 1))
    begin = np.zeros(len(corners) + 1, np.int64)
    begin[begins] = begins
    begin = np.maximum.accumulate(begin)[:-1]
    at = np.arange(max(0, len(corners) - 2))
    inside = (number[at] == number[at + 2]) & (begin[at] == begin[at + 2]) & (corners[at + 2] != -1)
    at = at[inside & (corners[at] != -1)]
    odd = (at - begin[at]) % 2
    a, b, c = corners[at + odd], corners[at + 1 - odd], corners[at + 2]
    triangles = np.column_stack((a, b, c))
    # Those without an area only lead from one part of a strip to the next.
    proper: Array = triangles[(a != b) & (b != c) & (c != a)]
    return proper


def _columns(data: dict[str, Array], roles: dict[str, str], taken: set[str]) -> list[tuple[str, Array]]:
    """Cut data arrays into columns of types that PLY knows, with names of their own."""
    columns: list[tuple[str, Array]] = []
    groups = {joined: names for names, joined in _GROUPS}
    for name, array in data.items():
        table = array.reshape(len(array), -1)
        if table.dtype == np.bool_:
            table = table.astype(np.uint8)
        elif table.dtype.str[1:] not in _NAMES:  # 64-bit integers
            fits = table.size == 0 or (table.min() >= -(2**31) and table.max() < 2**31)
            table = table.astype(np.int32 if fits else np.float64)
        plain = "_".join(name.split()) or "unnamed"
        names = [plain] if table.shape[1] == 1 else [f"{plain}_{i}" for i in range(table.shape[1])]
        group: tuple[str, ...] = groups.get(roles.get(name, name), ())
        if len(group) == table.shape[1] and group[0] not in taken:
            names = list(group)
        else:
            while taken & set(names):
                names = [f"{one}_" for one in names]
        taken = taken | set(names)
        columns += zip(names, table.T, strict=True)
    return columns


def write(file: IO[bytes], mesh: Polygons) -> Kept:
    """Write a binary PLY file in the machine's byte order, points in their own precision.

    Arrays with several components become one property each, ``name_0``, ``name_1``, … Lines are written as
    their segments, in the element ``edge``.
    """
    order = sys.byteorder
    kept = Kept(set(mesh.point_data), set(mesh.cell_data), set())
    header = [f"ply\nformat binary_{order}_endian 1.0\nelement vertex {len(mesh.points)}"]
    roles = {name: role for role, name in mesh.roles.items()}
    vertex = [*zip("xyz", mesh.points.T, strict=True), *_columns(mesh.point_data, roles, set("xyz"))]
    vertex_type = np.dtype([(f"{i}", column.dtype) for i, (_, column) in enumerate(vertex)])
    header += [f"property {_NAMES[column.dtype.str[1:]]} {name}" for name, column in vertex]
    mesh = mesh.without_verts()
    n_lines = len(mesh.lines[0])
    columns = _columns(
        mesh.cell_data, {}, {"vertex_indices", "vertex_index", "vertex1", "vertex2", "texcoord"}
    )
    properties = [f"property {_NAMES[column.dtype.str[1:]]} {name}" for name, column in columns]
    face = [(name, column[n_lines:]) for name, column in columns]
    largest = int(mesh.sizes.max(initial=0))
    count_type = "u1" if largest < 256 else "i4"
    header.append(f"element face {len(mesh.sizes)}\nproperty list {_NAMES[count_type]} int vertex_indices")
    textures = None if mesh.name_of("TCoords", 2) else mesh.corner_textures()
    textures_type = "u1" if 2 * largest < 256 else "i4"
    if textures is not None:
        header.append(f"property list {_NAMES[textures_type]} float texcoord")
        kept.field_data.add(CORNER_TEXTURES)
    header += properties
    line, ends = _segments(*mesh.lines)
    if len(line):
        header += [f"element edge {len(line)}", "property int vertex1", "property int vertex2", *properties]
    file.write(("\n".join(header) + "\nend_header\n").encode())
    rows = np.empty(len(mesh.points), dtype=vertex_type)
    for i, (_, column) in enumerate(vertex):
        rows[f"{i}"] = column
    file.write(rows.tobytes())
    # Faces: runs of one size are written as one table.
    bounds = np.flatnonzero(np.diff(mesh.sizes, prepend=-1, append=-1))
    starts = np.concatenate(([0], np.cumsum(mesh.sizes)))
    for a, b in zip(bounds[:-1].tolist(), bounds[1:].tolist(), strict=True):
        size = int(mesh.sizes[a])
        row_type = [("count", count_type), ("corners", "i4", (size,))]
        if textures is not None:
            row_type += [("texcoords", textures_type), ("texcoord", "f4", (2 * size,))]
        row_type += [(f"{i}", column.dtype) for i, (_, column) in enumerate(face)]  # type: ignore[misc]
        table = np.empty(b - a, dtype=row_type)
        table["count"] = size
        table["corners"] = mesh.connectivity[starts[a] : starts[b]].reshape(b - a, size)
        if textures is not None:
            table["texcoords"] = 2 * size
            with np.errstate(over="ignore"):
                table["texcoord"] = textures[starts[a] : starts[b]].reshape(b - a, 2 * size)
        for i, (_, column) in enumerate(face):
            table[f"{i}"] = column[a:b]
        file.write(table.tobytes())
    edge_type = [("ends", "i4", (2,)), *((f"{i}", column.dtype) for i, (_, column) in enumerate(columns))]
    table = np.empty(len(line), dtype=edge_type)
    table["ends"] = ends
    for i, (_, column) in enumerate(columns):
        table[f"{i}"] = column[:n_lines][line]
    file.write(table.tobytes())
    return kept


def _segments(sizes: Array, corners: Array) -> tuple[Array, Array]:
    """Return the segments of polylines, (k, 2), and the number of each one's line."""
    ends = np.cumsum(sizes)
    behind = np.ones(len(corners), bool)
    behind[ends[sizes > 0] - 1] = False
    at = np.flatnonzero(behind)
    line = np.repeat(np.arange(len(sizes)), sizes)[at]
    return line, np.column_stack((corners[at], corners[np.minimum(at + 1, len(corners) - 1)]))
