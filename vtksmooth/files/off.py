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
from .polygons import Polygons, numbers

_HEAD = 65536

#: Texture coordinates, colours and normals may follow a point; a 4 or n before OFF means other spaces.
_HEADER = re.compile(rb"(ST)?C?N?OFF(?=\s|$)")


def _header(path: Path, text: bytes) -> tuple[int, int, int]:
    """Return the numbers of points and faces, and where the counts end in `text`."""
    found = _HEADER.match(text.lstrip(b"\xef\xbb\xbf \t\r\n"))
    if not found:
        if re.match(rb"\s*(ST)?C?N?(4n?|n)OFF", text):
            raise MeshFileError(f"{path.name} is an OFF file of another dimension than 3; project it to 3.")
        raise MeshFileError(f"{path.name} does not begin with OFF, so it is no OFF file; check its name.")
    start = text.index(b"OFF") + 3
    if re.match(rb"\s+BINARY", text[start:]):
        raise MeshFileError(f"{path.name} is a binary OFF file, which is not supported; save it as ASCII.")
    counts = re.match(rb"\s*(\d+)[ \t]+(\d+)(?:[ \t]+-?\d+)?[ \t]*\r?(?:\n|$)", text[start:])
    if not counts:
        raise MeshFileError(
            f"{path.name} has no line with the numbers of points and faces after OFF; export it again."
        )
    return int(counts[1]), int(counts[2]), start + counts.end()


def _without_comments(text: bytes) -> bytes:
    return re.sub(rb"#[^\n]*", b"", text) if b"#" in text else text


def read(path: Path) -> Polygons:
    """Read an ASCII OFF file; colours, normals and texture coordinates are skipped.

    Raises
    ------
    MeshFileError
        The file is no OFF file, a variant that is not supported, truncated, or damaged.
    """
    with path.open("rb") as file:
        head = _without_comments(file.read(_HEAD))
        n_points, n_faces, _ = _header(path, head)
        # A point is at least "0 0 0", a face "1 0", each with its line's end.
        if 6 * n_points + 4 * n_faces > path.stat().st_size + 1:
            raise MeshFileError(
                f"{path.name} announces {n_points} points and {n_faces} faces but is too short for them; "
                "it is truncated, export it again."
            )
        file.seek(0)
        text = _without_comments(file.read())
    *_, start = _header(path, text)
    plain = _plain(text[start:], n_points, n_faces)
    if plain:
        return plain
    lines = [line for line in text[start:].splitlines() if line and not line.isspace()]
    if len(lines) < n_points + n_faces:
        raise MeshFileError(
            f"{path.name} announces {n_points} points and {n_faces} faces but has only {len(lines)} lines "
            "for them; it is truncated, export it again."
        )
    points = _points(path, lines[:n_points])
    sizes, connectivity = _faces(path, lines[n_points : n_points + n_faces])
    return Polygons(points, sizes, connectivity, {}, {})


def _plain(text: bytes, n_points: int, n_faces: int) -> Polygons | None:
    """Parse points of three numbers and faces of one size, what nearly all files have; else None."""
    first = text.lstrip().split(b"\n", 1)[0]
    values = numbers(text) if n_points and n_faces and len(first.split()) == 3 else None
    if values is None or (len(values) - 3 * n_points) % n_faces:
        return None
    faces = values[3 * n_points :].reshape(n_faces, -1)
    size = faces.shape[1] - 1
    if size < 1 or (faces[:, 0] != size).any():
        return None
    connectivity = faces[:, 1:].astype(np.int64)
    if (connectivity != faces[:, 1:]).any():
        return None
    points = values[: 3 * n_points].reshape(n_points, 3)
    return Polygons(points, np.full(n_faces, size, dtype=np.int64), connectivity.ravel(), {}, {})


def _points(path: Path, lines: list[bytes]) -> npt.NDArray[np.float64]:
    if not lines:
        return np.empty((0, 3))
    values = numbers(b" ".join(lines))
    columns = len(lines[0].split())
    if values is None or columns < 3 or len(values) != columns * len(lines):
        # Colours may stand behind some points and be missing behind others: line by line.
        table = np.empty((len(lines), 3))
        for row, line in enumerate(lines):
            try:
                table[row] = [float(word) for word in line.split()[:3]]
            except ValueError:
                raise MeshFileError(
                    f"{path.name}: the line of point {row} ({_quoted(line)}) does not begin with three "
                    "numbers; export the file again."
                ) from None
        return table
    return np.ascontiguousarray(values.reshape(len(lines), columns)[:, :3])


def _faces(path: Path, lines: list[bytes]) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    sizes: list[int] = []
    connectivity: list[int] = []
    for row, line in enumerate(lines):
        words = line.split()
        try:
            face = [int(word) for word in words[1 : int(words[0]) + 1]]
            if len(face) != int(words[0]):
                raise ValueError
        except ValueError:
            raise MeshFileError(
                f"{path.name}: the line of face {row} ({_quoted(line)}) is not a number of corners and "
                "that many point indices; export the file again."
            ) from None
        sizes.append(len(face))
        connectivity += face
    return np.array(sizes, dtype=np.int64), np.array(connectivity, dtype=np.int64)


def _quoted(line: bytes) -> str:
    return repr(line[:40].decode("ascii", "replace"))


def write(
    file: IO[bytes],
    points: npt.NDArray[Any],
    sizes: npt.NDArray[np.int64],
    connectivity: npt.NDArray[np.int64],
) -> None:
    """Write an ASCII OFF file; reading it gives exactly the same coordinates."""
    file.write(b"OFF\n%d %d 0\n" % (len(points), len(sizes)))
    # The text of a Python float is the shortest that reads back the same.
    write_row = "{} {} {}\n".format
    file.writelines(write_row(*row).encode() for row in points.tolist())
    corners = connectivity.tolist()
    start = 0
    for size in sizes.tolist():
        file.write(f"{size} {' '.join(map(str, corners[start : start + size]))}\n".encode())
        start += size
