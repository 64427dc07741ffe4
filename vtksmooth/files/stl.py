"""The STL file format: triangles without shared points, as text or binary.

VTK's own reader knows no solids and takes slips of other programs for damage. Reference: 3D Systems,
"StereoLithography Interface Specification", 1989.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..errors import MeshFileError
from .polygons import Kept, Polygons, merged, parts
from .text import Ints, Lines, Text, blocks, decoded, first_bad_line, quoted, rows, unified

_HEAD = 1 << 16
_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_RECORD = np.dtype([("numbers", "V48"), ("attribute", "<u2")])

#: So many triangles are written at once.
_AT_ONCE = 4096

#: Texts can hold coordinates beyond single precision.
_LARGEST = np.finfo(np.float32).max

#: The array of what binary files hold behind each triangle: colours, of a kind that varies.
ATTRIBUTE = "StlAttribute"

#: Where a text that has everything on one line can be cut; names of solids hold none of these.
_STATEMENTS = re.compile(
    rb"(?i)\s+(?=facet\s+normal\s|outer\s+loop\s|vertex\s+[-+.\d]|end\s?loop\s|end\s?facet\s|end\s?solid\b)"
)


def read(path: Path) -> tuple[Polygons, list[str]]:
    """Read an STL file, text or binary; points that are equal become one.

    Returns
    -------
    Polygons
        Points in single precision, unless a text has larger ones, in the order of their first appearance. Of
        several solids, or of one with a name, the cell array ``SolidIds`` holds the number of each face's
        solid, the field array ``SolidNames`` the names. Attributes of binary files that are not all 0 become
        ``StlAttribute``.
    list of str
        What was merged or left out, one sentence each.

    Raises
    ------
    MeshFileError
        The file is no STL file, is truncated or damaged.
    """
    with path.open("rb") as file:
        head = file.read(_HEAD)
        size = path.stat().st_size
        text = _is_text(head, size)
        if not text:
            _check_binary(path, head, size)
        raw = head + file.read()
    notes: list[str] = []
    sizes, points, cell_data, field_data = (_read_text if text else _read_binary)(path, raw, notes)
    listed = len(points)
    points, number = merged(points)
    corners = number
    triangles = sizes == 3
    starts = (np.cumsum(sizes) - sizes)[triangles]
    a, b, c = (corners[starts + i] for i in range(3))
    flat = np.zeros(len(sizes), bool)
    flat[triangles] = (a == b) | (b == c) | (c == a)
    dropped = int(flat.sum())
    if dropped:
        corners = corners[np.repeat(~flat, sizes)]
        sizes, cell_data = sizes[~flat], {name: array[~flat] for name, array in cell_data.items()}
    notes.insert(
        0,
        f"{path.name}: STL has no shared points; equal ones were merged ({listed} to {len(points)})"
        + (f", and {dropped} triangles with two equal corners left out." if dropped else "."),
    )
    return Polygons(points, sizes, corners, {}, cell_data, field_data=field_data), notes


def _is_text(head: bytes, size: int) -> bool:
    """Say whether a file is text: some binary files begin with "solid", too."""
    if size == 84 + 50 * int.from_bytes(head[80:84], "little"):
        return False
    return b"\0" not in head and re.search(rb"(?i)\bfacet\b|\bend ?solid\b", head) is not None


def _check_binary(path: Path, head: bytes, size: int) -> None:
    """Refuse what is no binary STL file before all of it is read."""
    count = int.from_bytes(head[80:84], "little")
    if len(head) < 84 or (count == 0 and not head[84:].strip(b"\0")) or size < 84 + 50 * min(count, 1):
        raise MeshFileError(
            f"{path} is not an STL file, or has no triangles (it announces {count} in {size} bytes); "
            "check its name, or export it again."
        )
    if count not in (0, 2**32 - 1) and size < 84 + 50 * count:
        raise MeshFileError(
            f"{path} is not an STL file, or truncated (it announces {count} triangles in {size} bytes); "
            "check its name, or export it again."
        )


def _read_binary(
    path: Path, raw: bytes, notes: list[str]
) -> tuple[Ints, npt.NDArray[Any], dict[str, npt.NDArray[Any]], dict[str, npt.NDArray[Any]]]:
    count, room = int.from_bytes(raw[80:84], "little"), len(raw) - 84
    if count in (0, 2**32 - 1):
        # Programs that write while they compute do not know the number beforehand.
        if room % 50:
            raise MeshFileError(
                f"{path} is not an STL file (it announces {count} triangles and goes on for {room} bytes); "
                "check its name, or export it again."
            )
        notes.append(f"{path.name} announces {count} triangles and holds {room // 50}; all were read.")
        count = room // 50
    behind = room - 50 * count
    table = np.frombuffer(raw, _TRIANGLE, count, 84)
    if behind:
        # The attribute of a triangle may be a number of bytes that follow it.
        length, extra = 84, 0
        for _ in range(count):
            if length + 50 > len(raw):
                break
            extra = int.from_bytes(raw[length + 48 : length + 50], "little")
            length += 50 + extra
        else:
            if length == len(raw):
                return _read_with_bytes(path, raw, count, notes)
        notes.append(f"{path.name}: {behind} bytes behind the triangles left out.")
    cell_data: dict[str, npt.NDArray[Any]] = {}
    if table["attribute"].any():
        cell_data[ATTRIBUTE] = table["attribute"].astype(np.uint16)
    return np.full(count, 3, np.int64), table["corners"].reshape(-1, 3).astype(np.float32), cell_data, {}


def _read_with_bytes(
    path: Path, raw: bytes, count: int, notes: list[str]
) -> tuple[Ints, npt.NDArray[Any], dict[str, npt.NDArray[Any]], dict[str, npt.NDArray[Any]]]:
    pieces = []
    at = 84
    for _ in range(count):
        pieces.append(raw[at + 12 : at + 48])
        at += 50 + int.from_bytes(raw[at + 48 : at + 50], "little")
    notes.append(f"{path.name}: the attribute bytes of the triangles left out.")
    points = np.frombuffer(b"".join(pieces), "<f4").reshape(-1, 3).astype(np.float32)
    return np.full(count, 3, np.int64), points, {}, {}


def _read_text(
    path: Path, raw: bytes, notes: list[str]
) -> tuple[Ints, npt.NDArray[Any], dict[str, npt.NDArray[Any]], dict[str, npt.NDArray[Any]]]:
    text = unified(raw)
    scanned = _scanned(text)
    if not scanned.regular:
        text = _STATEMENTS.sub(b"\n", text)
        scanned = _scanned(text)
    facets, corners, begins, names, behind, _ = scanned
    last = text[-_HEAD:].rstrip().rpartition(b"\n")[2].lower().split()
    if not b"".join(last[:2]).startswith(b"endsolid"):
        raise MeshFileError(f"{path} does not end with endsolid; it is truncated, export it again.")
    sizes = np.diff(np.searchsorted(corners, facets), append=len(corners))
    if len(facets) and (sizes < 3).any():
        number = int(np.argmax(sizes < 3))
        raise MeshFileError(
            f"{path} is damaged: facet {number + 1} has {sizes[number]} vertices instead of 3; "
            "export it again."
        )
    if sizes.sum() != len(corners):
        raise MeshFileError(f"{path} is damaged: a vertex stands before the first facet; export it again.")
    table = rows(behind)
    if table is None or (len(corners) and (table.counts != 3).any()):
        number, line = first_bad_line(behind) if table is None else _first_wrong(behind, table.counts)
        raise MeshFileError(
            f"{path.name}: the line of vertex {number + 1} ({quoted(line)}) does not hold three numbers; "
            "export the file again."
        )
    if table.commas:
        notes.append(f"{path.name}: decimal commas were taken for points.")
    points = table.values.reshape(-1, 3)
    if np.abs(points, where=np.isfinite(points), out=np.zeros_like(points)).max(initial=0.0) <= _LARGEST:
        points = points.astype(np.float32)
    solid = np.maximum(np.searchsorted(begins, facets) - 1, 0)
    names = names or [""]
    if len(np.unique(solid)) < 2 and not any(names):
        return sizes, points, {}, {}
    if len(names) > 1:
        notes.append(
            f"{path.name} has {len(names)} solids; the cell array SolidIds says to which each face belongs, "
            "the field array SolidNames what they are called."
        )
    cell_data = {"SolidIds": solid.astype(np.int32)}
    return sizes, points, cell_data, {"SolidNames": np.array(names, dtype=object)}


class _Scanned(NamedTuple):
    """What a text holds: the numbers of lines by their first word, and what stands behind it.

    Attributes
    ----------
    facets, corners, begins : (k,) int64
        The lines of facets, of vertices, and those at which solids begin.
    names : list of str
        What the solids are called.
    behind : bytes
        The text of the vertices' lines, without their first word.
    regular : bool
        Whether statements have lines of their own.
    """

    facets: Ints
    corners: Ints
    begins: Ints
    names: list[str]
    behind: bytes
    regular: bool


def _scanned(text: bytes) -> _Scanned:
    found: list[tuple[Ints, Ints, Ints, Text]] = []
    names: list[str] = []
    before = words = 0
    for block in blocks(text):
        lower = block.lower()
        low = Lines(lower)
        lines = low if lower == block else Lines(block)
        facets, corners, begins = (low.beginning(word) for word in (b"facet", b"vertex", b"solid"))
        names += [decoded(name) for name in lines.words(begins, len(b"solid"))]
        behind = lines.after(corners, len(b"vertex"))
        found.append((facets + before, corners + before, begins + before, behind))
        before += len(lines.starts)
        words += low.text.count(b"vertex")
    facets, corners, begins = (np.concatenate([part[i] for part in found]) for i in range(3))
    regular = len(corners) == words and 3 * len(facets) <= before
    return _Scanned(facets, corners, begins, names, b"".join(part[3] for part in found), regular)


def _first_wrong(text: bytes, counts: Ints) -> tuple[int, bytes]:
    number = int(np.argmax(counts != 3))
    return number, text.split(b"\n")[number]


def write(file: IO[bytes], mesh: Polygons) -> Kept:
    """Write an STL file of a mesh of triangles: binary, or text where solids have names or are several.

    In text, the faces of a solid come together; else they keep their order.
    """
    solids = parts(mesh, ("Solid", "Group"))
    kept = Kept(set(), set(), set())
    if solids is None:
        attribute = mesh.cell_data.get(ATTRIBUTE)
        if attribute is not None and (attribute.dtype != np.uint16 or attribute.ndim != 1):
            attribute = None
        if attribute is not None:
            kept.cell_data.add(ATTRIBUTE)
        # Not beginning with "solid", which is how text begins.
        file.write(b"STL of vtksmooth".ljust(80) + len(mesh.sizes).to_bytes(4, "little"))
        for numbers, rows in _numbers(mesh, np.arange(len(mesh.sizes))):
            table = np.zeros(len(rows), _RECORD)
            table["numbers"] = numbers.view("V48")[:, 0]
            if attribute is not None:
                table["attribute"] = attribute[rows]
            file.write(table.data)
        return kept
    kind, which, names = solids
    kept.cell_data.add(f"{kind}Ids")
    kept.field_data.add(f"{kind}Names")
    # Nine digits give the same number in single precision.
    facet = "facet normal %.9g %.9g %.9g\n outer loop\n" + "  vertex %.9g %.9g %.9g\n" * 3
    facet += " endloop\nendfacet\n"
    for i, name in enumerate(names):
        title = " ".join(name.split()).encode()
        file.write(b"solid " + title + b"\n")
        for numbers, _ in _numbers(mesh, np.flatnonzero(which == i)):
            file.write((facet * len(numbers) % tuple(numbers.ravel().tolist())).encode())
        file.write(b"endsolid " + title + b"\n")
    return kept


def _numbers(mesh: Polygons, rows: Ints) -> Iterator[tuple[npt.NDArray[np.float32], Ints]]:
    """Give the normal and the corners of some triangles, (k, 12), so many at once as stay in the cache."""
    corners = mesh.connectivity.reshape(-1, 3)
    for begin in range(0, len(rows), _AT_ONCE):
        which = rows[begin : begin + _AT_ONCE]
        # take() is several times as fast as indexing.
        points = mesh.points.take(corners.take(which, axis=0).ravel(), axis=0).reshape(-1, 9)
        a, b, c = points.T.astype(np.float64).reshape(3, 3, -1)
        numbers = np.empty((len(which), 12), "<f4")
        numbers[:, 3:] = points
        with np.errstate(all="ignore"):
            b -= a
            c -= a
            normal = np.stack(
                (b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0])
            )
            length = np.sqrt(normal[0] ** 2 + normal[1] ** 2 + normal[2] ** 2)
            flat = ~(length > 0)
            if flat.any():
                normal[:, flat], length[flat] = 0.0, 1.0
            normal /= length
            numbers[:, :3] = normal.T
        yield numbers, which
