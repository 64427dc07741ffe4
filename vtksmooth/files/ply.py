"""The PLY file format: a header that declares elements and their properties, then the values.

VTK's own reader keeps single precision only, drops most properties, and ends the process on a
truncated file; hence this one. Reference: Greg Turk, "The PLY Polygon File Format", 1994.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any

import numpy as np
import numpy.typing as npt

from ..errors import MeshFileError
from .polygons import Polygons, numbers

_HEAD = 1 << 20

_TYPES = {
    **{"char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4"},
    **{"float": "f4", "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2"},
    **{"int32": "i4", "uint32": "u4", "float32": "f4", "float64": "f8"},
}
_NAMES = {"i1": "char", "u1": "uchar", "i2": "short", "u2": "ushort", "i4": "int", "u4": "uint"} | {
    "f4": "float",
    "f8": "double",
}

#: Properties that belong together, and the array VTK makes of them.
_GROUPS = (
    (("nx", "ny", "nz"), "Normals"),
    (("red", "green", "blue", "alpha"), "RGBA"),
    (("red", "green", "blue"), "RGB"),
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

    if not head.startswith((b"ply\n", b"ply\r", b"ply ")):
        raise MeshFileError(f"{path.name} does not begin with ply, so it is no PLY file; check its name.")
    end = head.find(b"end_header")
    start = head.find(b"\n", end) + 1
    if end < 0 or start == 0:
        raise broken("its header has no end_header")
    order: str | None = None
    elements: list[_Element] = []
    for line in head[:end].decode("latin-1").splitlines()[1:]:
        match line.split():
            case ["format", "ascii", _]:
                order = ""
            case ["format", "binary_little_endian", _]:
                order = "<"
            case ["format", "binary_big_endian", _]:
                order = ">"
            case ["element", name, count] if count.isdecimal():
                elements.append(_Element(name, int(count)))
            case ["property", "list", count_type, item, name] if (
                elements and item in _TYPES and _TYPES.get(count_type, "f")[0] != "f"
            ):
                elements[-1].properties.append(_Property(name, _TYPES[item], _TYPES[count_type]))
            case ["property", item, name] if elements and item in _TYPES:
                elements[-1].properties.append(_Property(name, _TYPES[item]))
            case ["comment" | "obj_info", *_] | []:
                pass
            case _:
                raise broken(f"its header has the line {line[:60]!r}")
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

    def width(self, kind: str) -> int:
        return int(kind[1]) if self.order else 1

    def convert(self, raw: Array, kind: str) -> Array:
        """Turn (rows, columns * width) of raw values into (rows, columns) in the machine's byte order."""
        if not self.order:
            with np.errstate(invalid="ignore"):
                return raw.astype(kind)
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
                        self.convert(block[:, at : at + length * self.width(p.type)], p.type).ravel(),
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
                self._gather(np.array(s, np.int64), np.array(n, np.int64), p.type),
            )
            for p, s, n in zip(element.properties, starts, lengths, strict=True)
        }

    def _gather(self, starts: Array, lengths: Array, kind: str) -> Array:
        width = self.width(kind)
        ends = np.cumsum(lengths)
        inside = np.arange(ends[-1]) - np.repeat(ends - lengths, lengths)
        at = np.repeat(starts, lengths) + width * inside
        return self.convert(self.raw[at[:, None] + np.arange(width)], kind).ravel()


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
        Points in the file's precision; every single-valued property of points and faces as an
        array, normals and colours joined as ``Normals``, ``RGB`` or ``RGBA``.
    list of str
        What was left out, one sentence each.

    Raises
    ------
    MeshFileError
        The file is no PLY file, truncated, damaged, or has no points or faces.
    """
    with path.open("rb") as file:
        order, elements, start = _read_header(path, file.read(_HEAD))
        # Every element takes a byte at least: what cannot be is refused before it is read.
        if sum(e.count for e in elements if e.properties) > path.stat().st_size:
            raise MeshFileError(
                f"{path.name} announces more elements than it has bytes; it is truncated, export it again."
            )
        file.seek(start)
        raw: Array | None
        raw = np.fromfile(file, dtype=np.uint8) if order else numbers(file.read())
    if raw is None:
        raise MeshFileError(f"{path.name} has something else than numbers after its header; export it again.")
    values = _Values(path, order, raw)
    notes: list[str] = []
    tables: dict[str, dict[str, tuple[Array, Array]]] = {}
    kinds: dict[str, list[_Property]] = {}
    for element in elements:
        kinds[element.name] = element.properties
        tables[element.name] = values.table(element)
    vertex, face = tables.get("vertex", {}), tables.get("face", {})
    corners = next((name for name in ("vertex_indices", "vertex_index") if name in face), None)
    if not {"x", "y", "z"} <= vertex.keys():
        raise MeshFileError(f"{path.name} has no points with x, y and z; export it as a surface mesh.")
    if corners is None:
        what = "triangle strips instead of faces" if "tristrips" in tables else "no faces"
        raise MeshFileError(f"{path.name} has {what}; export it as a mesh of polygons.")
    ignored = [
        *(name for name in tables if name not in ("vertex", "face")),
        *(p.name for p in kinds["vertex"] if p.count_type),
        *(p.name for p in kinds["face"] if p.count_type and p.name != corners),
    ]
    if ignored:
        notes.append(f"{path.name}: {', '.join(ignored)} left out (kept: points, faces, single values).")
    point_data = _arrays(vertex, kinds["vertex"])
    points = np.column_stack([point_data.pop(axis) for axis in "xyz"])
    if points.dtype not in (np.float32, np.float64):
        points = points.astype(np.float64)
    sizes, connectivity = face[corners]
    polygons = Polygons(
        points, sizes, connectivity.astype(np.int64), point_data, _arrays(face, kinds["face"])
    )
    return polygons, notes


def _columns(data: dict[str, Array]) -> list[tuple[str, Array]]:
    """Cut data arrays into named columns of types that PLY knows."""
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
        if len(groups.get(name, ())) == table.shape[1]:
            names = list(groups[name])
        columns += zip(names, table.T, strict=True)
    return columns


def write(file: IO[bytes], mesh: Polygons) -> None:
    """Write a binary PLY file in the machine's byte order, points in their own precision.

    Arrays with several components become one property each, ``name_0``, ``name_1``, …
    """
    order = sys.byteorder
    header = [f"ply\nformat binary_{order}_endian 1.0\nelement vertex {len(mesh.points)}"]
    vertex = [*zip("xyz", mesh.points.T, strict=True), *_columns(mesh.point_data)]
    vertex_type = np.dtype([(f"{i}", column.dtype) for i, (_, column) in enumerate(vertex)])
    header += [f"property {_NAMES[column.dtype.str[1:]]} {name}" for name, column in vertex]
    face = _columns(mesh.cell_data)
    largest = int(mesh.sizes.max(initial=0))
    count_type = "u1" if largest < 256 else "i4"
    header.append(f"element face {len(mesh.sizes)}\nproperty list {_NAMES[count_type]} int vertex_indices")
    header += [f"property {_NAMES[column.dtype.str[1:]]} {name}" for name, column in face]
    file.write(("\n".join(header) + "\nend_header\n").encode("ascii", "replace"))
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
        row_type += [(f"{i}", column.dtype) for i, (_, column) in enumerate(face)]  # type: ignore[misc]
        table = np.empty(b - a, dtype=row_type)
        table["count"] = size
        table["corners"] = mesh.connectivity[starts[a] : starts[b]].reshape(b - a, size)
        for i, (_, column) in enumerate(face):
            table[f"{i}"] = column[a:b]
        file.write(table.tobytes())
