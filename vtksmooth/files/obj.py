"""The OBJ file format: lines of points, texture coordinates and normals, and of elements that refer to them.

VTK's own reader trusts the indices of a file, refuses much of what other programs write, and repeats points
that have several texture coordinates or normals; its writer loses cells. Reference: Wavefront, "Object Files
(.obj)", appendix B1 of the Advanced Visualizer's manual.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import IO, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..errors import MeshFileError
from .polygons import (
    CORNER_TEXTURES,
    NONE,
    Kept,
    Polygons,
    at_points,
    colours,
    merged,
    numbered,
    parts,
)
from .text import (
    Ints,
    Lines,
    Rows,
    Text,
    blocks,
    corner_numbers,
    decoded,
    first_bad_line,
    quoted,
    rows,
    unified,
    without_comments,
    write_elements,
    write_table,
)

#: Statements that have no effect on the mesh.
_IGNORED = (
    *(b"s", b"mg", b"usemap", b"maplib", b"bevel", b"c_interp", b"d_interp", b"lod", b"shadow_obj"),
    *(b"trace_obj", b"vp", b"end"),
    # Parts of curves and surfaces in free form.
    *(b"cstype", b"deg", b"bmat", b"step", b"parm", b"trim", b"hole", b"scrv", b"sp", b"con", b"ctech"),
    b"stech",
)

#: Curves and surfaces in free form, which are no polygons.
_FREE_FORM = (b"curv", b"curv2", b"surf")

#: Statements that name the part to which the elements after them belong, and what the part is called.
_PARTS = ((b"usemtl", "Material"), (b"g", "Group"), (b"o", "Object"))

#: A line may go on behind a backslash; names and comments may end with one.
_CONTINUED = re.compile(rb"(?m)^[ \t]*(?:v[tn]?|fo?|l|p)[ \t][^\n#\\]*(?:\\[ \t]*\n[^\n#\\]*)+")


class _Corners(NamedTuple):
    """The elements of one kind: the lines that they stand on, their sizes, and the indices of each corner."""

    lines: Ints
    sizes: Ints
    points: Ints
    textures: Ints
    normals: Ints


def read(path: Path) -> tuple[Polygons, list[str]]:
    """Read an OBJ file.

    Returns
    -------
    Polygons
        All points in the order of the file; points, lines and faces as cells. Materials, groups and objects
        become the cell arrays ``MaterialIds``, ``GroupIds`` and ``ObjectIds``, with their names in the field
        arrays ``MaterialNames``, … Colours of points become ``RGB``; texture coordinates and normals become
        ``TCoords`` and ``Normals`` where each point has one. Texture coordinates of corners otherwise become
        the field array ``CornerTCoords``.
    list of str
        What was left out, one sentence each.

    Raises
    ------
    MeshFileError
        The file is no OBJ file, or is damaged.
    """
    name = path.name
    with path.open("rb") as file:
        head = file.read(1 << 16)
        if b"\0" in head:
            raise MeshFileError(f"{path} is not an OBJ file, as its extension says; check its name.")
        file.seek(0)
        text = unified(file.read())
    if b"\\" in text:
        text = _CONTINUED.sub(lambda line: line[0].replace(b"\\", b" ").replace(b"\n", b" "), text)
    lines = Lines(text)
    if len(lines.beginning(b"fo")):  # an old word for f
        lines = Lines(re.sub(rb"(?m)^fo(?=\s)", b"f", lines.text))
    at = {word: lines.beginning(word) for word in (b"v", b"vt", b"vn", b"p", b"l", b"f")}
    if not len(at[b"v"]):
        raise MeshFileError(
            f"{path} is not an OBJ file, as its extension says (it has no points); check its name."
        )
    notes: list[str] = []
    defined = (at[b"v"], at[b"vt"], at[b"vn"])
    verts, segments, polygons = (_elements(name, lines, at[word], defined) for word in (b"p", b"l", b"f"))
    points, point_data = _points(name, lines, at[b"v"], notes)
    cell_data, field_data = _parts(lines, np.concatenate((verts.lines, segments.lines, polygons.lines)))
    for skip, key, role, what in (
        (b"vt", polygons.textures, "TCoords", "texture coordinates"),
        (b"vn", polygons.normals, "Normals", "normals"),
    ):
        if len(at[skip]):
            found, why = _attribute(name, lines, at[skip], key, polygons.points, len(points), what)
            if found is not None and not why:
                point_data[role] = found
            elif role == "TCoords" and found is not None:
                field_data[CORNER_TEXTURES] = np.column_stack((polygons.points, found)).astype(np.float64)
                notes.append(f"{name}: {what} are kept in the field array {CORNER_TEXTURES} only, as {why}.")
            else:
                notes.append(f"{name}: {what} left out, as {why}.")
    _say_ignored(name, lines, at, notes)
    return (
        Polygons(
            points,
            polygons.sizes,
            polygons.points,
            point_data,
            cell_data,
            (verts.sizes, verts.points),
            (segments.sizes, segments.points),
            field_data,
        ),
        notes,
    )


def _table(name: str, lines: Lines, which: Ints, skip: int, least: int, what: str) -> Rows:
    """Parse the numbers of all lines of one kind, which must have at least so many."""
    text = without_comments(lines.after(which, skip))
    table = rows(text)
    if table is None:
        number, line = first_bad_line(text)
        raise MeshFileError(
            f"{name}: the line of {what} {number + 1} ({quoted(line)}) holds something else than numbers; "
            "export the file again."
        )
    if len(which) and table.counts.min() < least:
        number = int(np.argmax(table.counts < least))
        raise MeshFileError(
            f"{name}: the line of {what} {number + 1} has {table.counts[number]} numbers instead of {least}; "
            "export the file again."
        )
    return table


def _points(
    name: str, lines: Lines, which: Ints, notes: list[str]
) -> tuple[npt.NDArray[np.float64], dict[str, npt.NDArray[Any]]]:
    table = _table(name, lines, which, 1, 3, "point")
    if table.commas:
        notes.append(f"{name}: decimal commas were taken for points.")
    points = np.ascontiguousarray(table.columns(3))
    least, most = int(table.counts.min()), int(table.counts.max())
    if most == 3:
        return points, {}
    lost = []
    found: dict[str, npt.NDArray[Any]] = {}
    if least >= 6:
        more = table.columns(min(least, 7))[:, 3:]
        # Behind a weight of 1, or before a transparency.
        values = more[:, 1:] if more.shape[1] == 4 and (more[:, 0] == 1).all() else more
        array = colours(values)
        if array is not None:
            found["RGB" if array.shape[1] == 3 else "RGBA"] = array
        else:
            lost.append("colours of points, which are not from 0 to 1")
    elif most >= 6:
        lost.append("colours of points, as not all have one")
    elif (table.columns(4)[table.counts > 3, 3] != 1).any():
        lost.append("weights of points")
    if lost:
        notes.append(f"{name}: {', '.join(lost)} left out.")
    return points, found


def _elements(name: str, lines: Lines, which: Ints, defined: tuple[Ints, Ints, Ints]) -> _Corners:
    """Read all elements of one kind: corners of one to three indices, as in 1, 1/2, 1//3 and 1/2/3."""
    if not len(which):
        return _Corners(which, *NONE, *NONE)
    text = without_comments(lines.after(which, 1))
    found = corner_numbers(text)
    sizes, indices = _indices(name, text) if found is None else found
    columns = []
    for row, kind in zip(indices, defined, strict=True):
        if not row.any():
            columns.append(np.broadcast_to(np.int64(-1), len(row)))
            continue
        if row.min() < 0:
            negative = row < 0
            # Counted back from the element's own line; what reaches too far back stays negative.
            there = np.repeat(np.searchsorted(kind, which), sizes)[negative]
            back = there + row[negative] + 1
            row[negative] = np.where(back > 0, back, row[negative])
        row -= 1
        columns.append(row)
    points = columns[0]
    if len(points) and (points.min() < 0 or points.max() >= len(defined[0])):
        wrong = (points < 0) | (points >= len(defined[0]))
        raise MeshFileError(
            f"{name} is damaged: an element refers to point {points[wrong][0] + 1}, but the points are "
            f"numbered 1 to {len(defined[0])}; export it again."
        )
    return _Corners(which, sizes, *columns)


def _indices(name: str, text: Text) -> tuple[Ints, Ints]:
    """Return how many corners each line has, and the indices of each corner, (3, k), 0 where missing."""
    table = rows(text.replace(b"/", b" "))
    if table is None:
        raise _bad_element(name, text)
    with np.errstate(invalid="ignore"):
        values = table.values.astype(np.int64)
    if (values != table.values).any():
        raise _bad_element(name, text)
    if b"/" not in text:
        indices = np.zeros((3, len(values)), np.int64)
        indices[0] = values
        return table.counts, indices
    found = []
    read = 0
    for block in blocks(bytes(text)):
        codes = np.frombuffer(block, np.uint8)
        slash, blank = codes == ord("/"), codes <= 32
        corners = np.flatnonzero(~blank & np.concatenate(([True], blank[:-1])))
        sizes = np.diff(np.searchsorted(corners, np.flatnonzero(codes == ord("\n"))), prepend=0)
        between = blank | slash
        begins = np.flatnonzero(~between & np.concatenate(([True], between[:-1])))
        corner = np.searchsorted(corners, begins, "right") - 1
        slashes = np.cumsum(slash, dtype=np.int32)
        place = slashes[begins] - slashes[corners[corner]] + slash[corners[corner]]
        here = values[read : read + len(begins)]
        read += len(begins)
        if int((place == 0).sum()) < len(corners):
            raise _bad_element(name, block)
        indices = np.zeros((3, len(corners)), np.int64)
        for i in range(3):
            chosen = place == i
            indices[i, corner[chosen]] = here[chosen]
        found.append((sizes, indices))
    return np.concatenate([part[0] for part in found]), np.concatenate([part[1] for part in found], axis=1)


def _bad_element(name: str, text: Text) -> MeshFileError:
    for line in text.split(b"\n"):
        if not all(re.fullmatch(rb"[-+]?\d{1,15}(/([-+]?\d{1,15})?)*", word) for word in line.split()):
            break
    return MeshFileError(
        f"{name}: the line of an element ({quoted(line)}) holds something else than point numbers; "
        "export the file again."
    )


def _attribute(
    name: str, lines: Lines, which: Ints, indices: Ints, corners: Ints, n_points: int, what: str
) -> tuple[npt.NDArray[np.float32] | None, str]:
    """Return texture coordinates or normals of points.

    Where they cannot be those of points, return those of corners, NaN where one has none, or None; and why.
    """
    if indices.max(initial=-1) == indices.min(initial=-1) == -1:
        # No element refers to them; some programs write one for each point, all the same.
        if len(which) != n_points:
            return None, "no face refers to them"
        indices, corners = np.arange(n_points), np.arange(n_points)
    least = int(indices.min())
    if least < -1 or indices.max() >= len(which):
        wrong = (indices < -1) | (indices >= len(which))
        worst = int(indices[wrong][0]) + 1
        raise MeshFileError(
            f"{name} is damaged: an element refers to number {worst} of its {what}, which are "
            f"numbered 1 to {len(which)}; export it again."
        )
    columns = 2 if what == "texture coordinates" else 3
    table = rows(without_comments(lines.after(which, 2)))
    if table is None:
        return None, "they are not all numbers"
    with np.errstate(over="ignore"):
        values = table.columns(columns).astype(np.float32)
    if least == -1:
        return np.where(indices[:, None] < 0, np.float32(np.nan), values[indices]), "not every corner has one"
    if len(values) == n_points and np.array_equal(indices, corners):
        return values, ""  # one for each point, also for those without a face
    array = at_points(n_points, corners, values[indices])
    return (
        (values[indices], "they differ at points between the faces there") if array is None else (array, "")
    )


def _parts(lines: Lines, elements: Ints) -> tuple[dict[str, npt.NDArray[Any]], dict[str, npt.NDArray[Any]]]:
    """Return the numbers of each element's material, group and object, and their names."""
    cell_data, field_data = {}, {}
    for word, kind in _PARTS:
        which = lines.beginning(word)
        if len(which) and len(elements):
            # Before the first, and where the name is missing, the format's own word.
            names = ["default", *(_name(raw) for raw in lines.words(which, len(word)))]
            cell_data[f"{kind}Ids"], field_data[f"{kind}Names"] = numbered(
                names, np.searchsorted(which, elements)
            )
    libraries = lines.words(lines.beginning(b"mtllib"), len(b"mtllib"))
    if libraries:
        field_data["MaterialLibraries"] = np.array([_name(raw) for raw in libraries], dtype=object)
    return cell_data, field_data


def _name(raw: bytes) -> str:
    return " ".join(decoded(raw).split()) or "default"


def _say_ignored(name: str, lines: Lines, at: dict[bytes, Ints], notes: list[str]) -> None:
    """Say what there is beside the mesh, in one note."""
    lost = []
    if any(word not in (b"", b"0", b"off") for word in set(lines.words(lines.beginning(b"s"), 1))):
        lost.append("smoothing groups")
    if any(len(lines.beginning(word)) for word in _FREE_FORM):
        lost.append("curves and surfaces in free form")
    known = sum(map(len, at.values())) + sum(
        len(lines.beginning(word))
        for word in (*_IGNORED, *_FREE_FORM, b"mtllib", *(word for word, _ in _PARTS))
    )
    first = lines.codes[lines.starts]
    unknown = len(lines.starts) - known - int(((first == ord("#")) | (first == ord("\n"))).sum())
    if unknown:
        lost.append(f"{unknown} lines that are not of the format")
    if lost:
        notes.append(f"{name}: {', '.join(lost)} left out.")


def write(file: IO[bytes], mesh: Polygons) -> Kept:
    """Write an OBJ file; reading it gives exactly the same coordinates.

    The cells keep their order: points, lines, faces. What is kept of the arrays is returned.
    """
    normals, textures = mesh.name_of("Normals", 3), mesh.name_of("TCoords", 2)
    colour = mesh.colours(mesh.point_data)
    kept = Kept({name for name in (normals, textures, colour) if name}, set(), set())
    if colour == "RGBA":
        opaque = 255 if mesh.point_data[colour].dtype == np.uint8 else 1
        if (mesh.point_data[colour][:, 3] != opaque).any():
            kept.point_data.discard(colour)  # its transparency is lost
    libraries = mesh.field_data.get("MaterialLibraries")
    if libraries is not None:
        file.writelines(f"mtllib {' '.join(str(one).split())}\n".encode() for one in libraries)
        kept.field_data.add("MaterialLibraries")
    table: npt.NDArray[Any] = mesh.points
    if colour:
        values = mesh.point_data[colour][:, :3]
        table = np.column_stack((table, values / 255.0 if values.dtype == np.uint8 else values))
    write_table(file, "v", table)
    if textures:
        write_table(file, "vt", mesh.point_data[textures][:, :2])
    of_corners = None if textures else mesh.corner_textures()
    if of_corners is not None:
        there = np.asarray(~np.isnan(of_corners).any(axis=1))
        distinct, numbers = merged(np.column_stack((of_corners[there], np.zeros(there.sum()))))
        write_table(file, "vt", distinct[:, :2])
        texture = np.zeros(len(there), np.int64)
        texture[there] = numbers + 1
        kept.field_data.add(CORNER_TEXTURES)
    else:
        texture = mesh.connectivity + 1 if textures else np.zeros(len(mesh.connectivity), np.int64)
    if normals:
        write_table(file, "vn", mesh.point_data[normals][:, :3])
    named = {}
    for word, wanted in (("o", ("Object",)), ("g", ("Group", "Solid")), ("usemtl", ("Material",))):
        found = parts(mesh, wanted)
        if found:
            named[word] = found
            kept.cell_data.add(f"{found[0]}Ids")
            kept.field_data.add(f"{found[0]}Names")
    first = 0
    points = mesh.connectivity + 1
    for word, sizes, corners in (
        ("p", mesh.verts[0], mesh.verts[1][:, None] + 1),
        ("l", mesh.lines[0], mesh.lines[1][:, None] + 1),
        ("f", mesh.sizes, np.column_stack((points, texture, points if normals else np.zeros_like(points)))),
    ):
        before: dict[int, str] = {}
        for statement, (_, which, names) in named.items():
            here = which[first : first + len(sizes)]
            changes = np.flatnonzero(np.diff(here, prepend=which[first - 1] if first else -1))
            for i in changes.tolist():
                part = " ".join(names[here[i]].split()) or f"part_{here[i]}"
                before[i] = f"{before.get(i, '')}{statement} {part}\n"
        write_elements(file, word, sizes, corners, before)
        first += len(sizes)
    return kept
