"""The OFF file format: a header, the counts, one line for each point and one for each face.

Reference: Geomview's manual, "OFF Files" (the ASCII variants in three dimensions).
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import IO, Any

import numpy as np
import numpy.typing as npt

from ..errors import MeshFileError
from .polygons import Kept, Polygons, colours
from .text import (
    Rows,
    Text,
    first_bad_line,
    quoted,
    rows,
    unified,
    without_comments,
    write_cells,
    write_table,
)

_HEAD = 65536

#: Texture coordinates, colours and normals of points are announced before OFF, in any order and case.
_HEADER = re.compile(rb"((?:ST|C|N|st|c|n)*)(?:OFF|off|Off)(?=\s|\d|$)")

#: A 4 or n before OFF means other spaces.
_OTHER_SPACE = re.compile(rb"(ST|C|N)*(4n?|n)OFF")


def _header(path: Path, text: Text) -> tuple[bytes, int, int, int]:
    """Return what is announced of points, the numbers of points and faces, and where the counts end."""
    start = len(text) - len(text.lstrip())
    if _OTHER_SPACE.match(text, start):
        raise MeshFileError(f"{path.name} is an OFF file of another dimension than 3; project it to 3.")
    found = _HEADER.match(text, start)
    if found:
        start = found.end()
        if re.match(rb"\s+BINARY", text[start:]):
            raise MeshFileError(
                f"{path.name} is a binary OFF file, which is not supported; save it as ASCII."
            )
    # The number of edges is often missing, the word OFF now and then.
    count = rb"(\d{1,18})"
    counts = re.compile(rb"\s*" + count + rb"[ \t]+" + count + rb"(?:[ \t]+-?\d+)?[ \t]*(?:\n|$)").match(
        text, start
    ) or re.compile(rb"\s*" + count + rb"\s+" + count + rb"\s+-?\d+\s").match(text, start)
    if not counts and not found:
        raise MeshFileError(f"{path.name} does not begin with OFF, so it is no OFF file; check its name.")
    if not counts:
        raise MeshFileError(
            f"{path.name} has no line with the numbers of points and faces after OFF; export it again."
        )
    return found[1].upper() if found else b"", int(counts[1]), int(counts[2]), counts.end()


def read(path: Path) -> tuple[Polygons, list[str]]:
    """Read an ASCII OFF file.

    Returns
    -------
    Polygons
        Colours of points and faces as ``RGB`` or ``RGBA``, normals and texture coordinates of points as
        ``Normals`` and ``TCoords``.
    list of str
        What was left out, one sentence each.

    Raises
    ------
    MeshFileError
        The file is no OFF file, a variant that is not supported, truncated, or damaged.
    """
    with path.open("rb") as file:
        head = file.read(_HEAD)
        if b"\0" in head and not re.match(rb"\s*\w*OFF\s+BINARY", head):
            raise MeshFileError(f"{path.name} is binary, so it is no OFF file; check its name.")
        _, n_points, n_faces, _ = _header(path, without_comments(unified(head)))
        # A point is at least "0 0 0", a face "1 0", each with its line's end.
        if 6 * n_points + 4 * n_faces > path.stat().st_size + 1:
            raise MeshFileError(
                f"{path.name} announces {n_points} points and {n_faces} faces but is too short for them; "
                "it is truncated, export it again."
            )
        text = without_comments(unified(head + file.read()))
    announced, *_, start = _header(path, text)
    text = text[start:]
    table = rows(text)
    if table is None:
        raise _not_numbers(path, text, n_points)
    table = table._replace(counts=table.counts[table.counts > 0])
    notes = [f"{path.name}: decimal commas were taken for points."] if table.commas else []
    fault = _fault(path, table, n_points, n_faces)
    if fault is not None:
        free = _without_lines(table, announced, n_points, n_faces)
        if free is None or _fault(path, free, n_points, n_faces) is not None:
            raise fault
        table = free
    points, point_data = _points(path, table, announced, n_points, notes)
    sizes, connectivity, cell_data = _faces(path, table, n_points, n_faces, notes)
    more = len(table.counts) - n_points - n_faces
    if more:
        notes.append(f"{path.name}: {more} lines behind the faces left out.")
    return Polygons(points, sizes, connectivity, point_data, cell_data), notes


def _not_numbers(path: Path, text: Text, n_points: int) -> MeshFileError:
    at, line = first_bad_line(text)
    row = sum(bool(before.strip()) for before in text.split(b"\n")[:at])
    what = f"point {row}" if row < n_points else f"face {row - n_points}"
    return MeshFileError(
        f"{path.name}: the line of {what} ({quoted(line)}) holds something else than numbers; "
        "export the file again."
    )


def _fault(path: Path, table: Rows, n_points: int, n_faces: int) -> MeshFileError | None:
    """Return what is wrong with a file of one line for each point and face, or None."""
    counts = table.counts
    if len(counts) < n_points + n_faces:
        return MeshFileError(
            f"{path.name} announces {n_points} points and {n_faces} faces but has only {len(counts)} lines "
            "for them; it is truncated, export it again."
        )
    if n_points and counts[:n_points].min() < 3:
        row = int(np.argmax(counts[:n_points] < 3))
        return MeshFileError(
            f"{path.name}: the line of point {row} has {counts[row]} numbers instead of 3; "
            "export the file again."
        )
    of_faces = slice(n_points, n_points + n_faces)
    begins, room = table.starts[of_faces], counts[of_faces] - 1
    size = table.values[begins]
    wrong = ~((size >= 0) & (size <= room) & (size == np.round(size)))
    corners = _behind(begins + 1, np.where(wrong, 0, size).astype(np.int64))
    whole = table.values[corners] == np.round(table.values[corners])
    if not whole.all() and not wrong.any():
        wrong[np.searchsorted(begins, corners[~whole][0], "right") - 1] = True
    if wrong.any():
        row = int(np.argmax(wrong))
        line = " ".join(
            f"{value:g}" for value in table.values[begins[row] : begins[row] + room[row] + 1][:12]
        )
        return MeshFileError(
            f"{path.name}: the line of face {row} ({line}) is not a number of corners and that many point "
            "indices; export the file again."
        )
    return None


def _behind(begins: npt.NDArray[np.int64], lengths: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """Return the places ``begins[i], begins[i] + 1, ...``, so many as the length says, row after row."""
    ends = np.cumsum(lengths)
    inside = np.arange(ends[-1] if len(ends) else 0) - np.repeat(ends - lengths, lengths)
    places: npt.NDArray[np.int64] = np.repeat(begins, lengths) + inside
    return places


def _without_lines(table: Rows, announced: bytes, n_points: int, n_faces: int) -> Rows | None:
    """Cut a file into points and faces whose lines say nothing; None where that does not come out even."""
    values = table.values
    fixed = 3 + 3 * announced.count(b"N") + 2 * announced.count(b"ST")
    for width in (fixed + 3, fixed + 4) if b"C" in announced else (fixed,):
        at = width * n_points
        counts = [width] * n_points
        for _ in range(n_faces):
            if at >= len(values) or not 0 <= values[at] < len(values) - at:
                break
            counts.append(int(values[at]) + 1)
            at += counts[-1]
        if len(counts) == n_points + n_faces and at == len(values):
            return table._replace(counts=np.array(counts, np.int64))
    return None


def _points(
    path: Path, table: Rows, announced: bytes, n_points: int, notes: list[str]
) -> tuple[npt.NDArray[np.float64], dict[str, npt.NDArray[Any]]]:
    """Return the points, and what the header announces of each: normals, colours, texture coordinates."""
    counts = table.counts[:n_points]
    own = Rows(table.values[: counts.sum()], counts, False)
    points = np.ascontiguousarray(own.columns(3))
    if n_points == 0 or (not announced and counts.max() == 3):
        return points, {}
    data: dict[str, npt.NDArray[Any]] = {}
    lost = []
    values = own.columns(int(counts.min()))
    at, end = 3, values.shape[1] - 2 * (b"ST" in announced)
    if b"N" in announced:
        if at + 3 <= end:
            with np.errstate(over="ignore"):
                data["Normals"] = values[:, at : at + 3].astype(np.float32)
            at += 3
        else:
            lost.append("normals of points, as not all have one")
    if b"C" in announced:
        array = colours(values[:, at : at + 4][:, : end - at]) if 3 <= end - at <= 4 else None
        if array is None:
            lost.append("colours of points, as not all have one of three or four numbers up to 255")
        else:
            data["RGB" if array.shape[1] == 3 else "RGBA"] = array
        at = end
    if b"ST" in announced:
        if at <= end and counts.min() == counts.max():
            with np.errstate(over="ignore"):
                data["TCoords"] = values[:, end : end + 2].astype(np.float32)
        else:
            lost.append("texture coordinates of points, as not all have one")
    elif not lost and counts.max() > at:
        lost.append("numbers behind the points that the header does not announce")
    if lost:
        notes.append(f"{path.name}: {'; '.join(lost)}: left out.")
    return points, data


def _faces(
    path: Path, table: Rows, n_points: int, n_faces: int, notes: list[str]
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64], dict[str, npt.NDArray[Any]]]:
    """Return sizes, point indices and colours of the faces."""
    of_faces = slice(n_points, n_points + n_faces)
    begins, counts = table.starts[of_faces], table.counts[of_faces]
    sizes = table.values[begins].astype(np.int64)
    corners = table.values[_behind(begins + 1, sizes)]
    # Beyond any number of points, and not beyond the integers.
    connectivity = np.clip(corners, -(2.0**53), 2.0**53).astype(np.int64)
    more = counts - 1 - sizes
    data: dict[str, npt.NDArray[Any]] = {}
    if len(more) and more.any():
        width = int(more[0])
        array = None
        if (more == width).all() and width in (3, 4):
            at = _behind(begins + 1 + sizes, more)
            array = colours(table.values[at].reshape(-1, width))
        if array is None:
            notes.append(
                f"{path.name}: colours of faces left out, as not all have three or four numbers up to 255."
            )
        else:
            data["RGB" if width == 3 else "RGBA"] = array
    return sizes, connectivity, data


def write(file: IO[bytes], mesh: Polygons) -> Kept:
    """Write an ASCII OFF file; reading it gives exactly the same coordinates."""
    normals, textures = mesh.name_of("Normals", 3), mesh.name_of("TCoords", 2)
    colour, of_faces = mesh.colours(mesh.point_data), mesh.colours(mesh.cell_data)
    columns = [mesh.points.astype(object)]
    if normals:
        columns.append(mesh.point_data[normals][:, :3].astype(object))
    if colour:
        columns.append(_colour_numbers(mesh.point_data[colour]).astype(object))
    if textures:
        columns.append(mesh.point_data[textures][:, :2].astype(object))
    header = b"ST" * bool(textures) + b"C" * bool(colour) + b"N" * bool(normals) + b"OFF"
    file.write(b"%s\n%d %d 0\n" % (header, len(mesh.points), len(mesh.sizes)))
    write_table(file, "", np.column_stack(columns) if len(columns) > 1 else mesh.points)
    sizes, values = mesh.sizes, mesh.connectivity
    ends = np.cumsum(sizes)
    behind = 0
    if of_faces:
        numbers = _colour_numbers(mesh.cell_data[of_faces])
        behind = numbers.shape[1]
        values = np.insert(values.astype(object), np.repeat(ends, behind), numbers.ravel().astype(object))
    lines = {size + behind: f"{size}{' %d' * size}{' %r' * behind}\n" for size in np.unique(sizes).tolist()}
    write_cells(file, sizes + behind, values, lines)
    kept = {name for name in (normals, colour, textures) if name}
    return Kept(kept, {of_faces} if of_faces else set(), set())


def _colour_numbers(array: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Return colours so that they read back the same: numbers up to 1 are fractions."""
    return array / 255.0 if array.dtype == np.uint8 and array.max(initial=0) <= 1 else array
