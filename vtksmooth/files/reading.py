"""Reading a surface mesh: whatever is wrong with a file becomes one message."""

from __future__ import annotations

import os
import stat
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyvista as pv

from ..errors import MeshFileError
from ..filters.arrays import cells_of, point_array_names
from . import off, ply, vtk_formats
from .damage import check_indices
from .polygons import Polygons
from .signatures import OF_VTK, stl_triangles, wrong_signature

_HEAD = 1 << 16

#: The formats that can be read, by extension.
READABLE = (*sorted([*OF_VTK, ".off", ".ply"]),)


def read_surface(
    path: str | os.PathLike[str], cancelled: Callable[[], bool] = lambda: False
) -> tuple[pv.PolyData, list[str]]:
    """Read a surface mesh.

    Parameters
    ----------
    path : path-like
        A file whose extension is one of :data:`READABLE`.
    cancelled : callable
        Asked ten times a second or more, while VTK reads the file, whether to stop.

    Returns
    -------
    pyvista.PolyData
        The surface, with all of its data arrays and in the precision of the file.
    list of str
        What was done to the file's content, one sentence each: STL's points merged, points that an
        OBJ file's texture indices had split merged again, the outer surface of a grid taken, the
        blocks of a composite file combined.

    Raises
    ------
    MeshFileError
        There is no such file, it cannot be read, is not what its extension says, is damaged or
        truncated, or holds no faces.
    Cancelled
        `cancelled` returned True.

    Guarantees
    ----------
    No file ends the process: readers of VTK, which damage can lead into foreign memory, run in another one
    (where Python can start one; a program that is frozen into one file cannot).

    Examples
    --------
    >>> import pyvista as pv
    >>> mesh, notes = read_surface(pv.examples.planefile)
    >>> mesh.n_cells, notes
    (2452, [])
    """
    path = Path(path).expanduser()
    try:
        return _read(path, cancelled)
    except MeshFileError:
        raise
    except OSError as error:
        raise MeshFileError(f"cannot read {path}: {error.strerror or error}; {_advice(error)}.") from error
    except MemoryError as error:
        raise MeshFileError(
            f"{path} does not fit into memory; use a smaller mesh or a larger machine."
        ) from error


def _advice(error: OSError) -> str:
    if isinstance(error, FileNotFoundError):
        return "check the path"
    if isinstance(error, PermissionError):
        return "change its permissions"
    return "check the file and its disk"


def _read(path: Path, cancelled: Callable[[], bool]) -> tuple[pv.PolyData, list[str]]:
    extension = path.suffix.lower()
    status = path.stat()
    if stat.S_ISDIR(status.st_mode):
        raise MeshFileError(f"{path} is a folder; name a mesh file in it.")
    # A pipe would wait for a writer, a device might never end.
    if not stat.S_ISREG(status.st_mode):
        raise MeshFileError(f"{path} is not a regular file; copy its content into one.")
    if extension not in READABLE:
        raise MeshFileError(
            f"{path} has the extension {extension or '(none)'!r}, which is not known; "
            f"known are {' '.join(READABLE)}."
        )
    with path.open("rb") as file:
        head = file.read(_HEAD)
    if not head:
        raise MeshFileError(f"{path} is empty; export it again.")

    notes: list[str] = []
    if extension in (".off", ".ply"):
        polygons, notes = (off.read(path), notes) if extension == ".off" else ply.read(path)
        mesh = _polydata(path, polygons, notes)
    else:
        wrong = wrong_signature(extension, head, status.st_size)
        if wrong:
            raise MeshFileError(f"{path} {wrong}.")
        mesh, notes = vtk_formats.read(path, extension, cancelled)
    if extension == ".obj":
        mesh = _merge_split_points(path, mesh, notes)
    elif extension == ".stl":
        _note_merged(path, mesh, head, status.st_size, notes)
    if mesh.GetNumberOfPolys() + mesh.GetNumberOfStrips() == 0:
        raise MeshFileError(f"{path} holds {mesh.n_points} points but no faces; export it as a surface mesh.")
    return mesh, notes


def _polydata(path: Path, polygons: Polygons, notes: list[str]) -> pv.PolyData:
    check_indices(path, polygons.connectivity, len(polygons.points))
    sizes, connectivity, cell_data = polygons.sizes, polygons.connectivity, polygons.cell_data
    small = sizes < 3
    if small.any():
        connectivity = connectivity[np.repeat(~small, sizes)]
        sizes, cell_data = sizes[~small], {name: array[~small] for name, array in cell_data.items()}
        notes.append(f"{path.name}: {int(small.sum())} faces with less than three corners were left out.")
    # VTK's layout: the size of each face before its corners.
    starts = np.cumsum(sizes) - sizes
    mesh = (
        pv.PolyData(polygons.points, np.insert(connectivity, starts, sizes)) if len(sizes) else pv.PolyData()
    )
    if not len(sizes):
        mesh.points = polygons.points
    mesh.point_data.update(polygons.point_data)
    mesh.cell_data.update(cell_data)
    return mesh


def _note_merged(path: Path, mesh: pv.PolyData, head: bytes, size: int, notes: list[str]) -> None:
    triangles = stl_triangles(head, size)
    if triangles is None:
        last = b""
        triangles = 0
        with path.open("rb") as file:
            for line in file:
                word = line.lstrip()[:8].lower()
                triangles += word.startswith(b"facet")
                last = word or last
        if not last.startswith(b"endsolid"):
            raise MeshFileError(f"{path} does not end with endsolid; it is truncated, export it again.")
    dropped = triangles - mesh.n_cells
    notes.append(
        f"{path.name}: STL has no shared points; equal ones were merged ({3 * triangles} to {mesh.n_points})"
        + (f", and {dropped} triangles with two equal corners left out." if dropped > 0 else ".")
    )


def _merge_split_points(path: Path, mesh: pv.PolyData, notes: list[str]) -> pv.PolyData:
    """Undo what VTK's OBJ reader does to points with several texture or normal indices.

    It repeats such a point for each of them, which tears the surface open there.
    """
    with path.open("rb") as file:
        listed = sum(line.lstrip()[:2] in (b"v ", b"v\t") for line in file)
    if mesh.n_points <= listed:
        return mesh
    points = mesh.points
    order = np.lexsort(points.T)
    ahead = points[order]
    new = np.concatenate(([True], (ahead[1:] != ahead[:-1]).any(axis=1)))
    # lexsort is stable: the first of each group is the first in the file, and names the group.
    first = order[new]
    group = np.empty(len(points), dtype=np.int64)
    group[order] = np.cumsum(new) - 1
    by_file = np.argsort(first)
    number = np.empty(len(first), dtype=np.int64)
    number[by_file] = np.arange(len(first))
    target = number[group]
    merged = pv.PolyData()
    merged.points = points[first[by_file]]
    for get, put in (("GetVerts", "SetVerts"), ("GetLines", "SetLines"), ("GetPolys", "SetPolys")):
        cells = getattr(mesh, get)()
        if cells.GetNumberOfCells():
            offsets, corners = cells_of(cells)
            getattr(merged, put)(pv.CellArray.from_arrays(offsets, target[corners]))
    merged.GetCellData().ShallowCopy(mesh.GetCellData())
    merged.GetFieldData().ShallowCopy(mesh.GetFieldData())
    lost = [name or "texture coordinates" for name in point_array_names(mesh)]
    notes.append(
        f"{path.name}: points that the reader had split at texture or normal seams were merged again "
        f"({mesh.n_points} to {merged.n_points})"
        + (f"; {', '.join(lost)} left out, as they differ across seams." if lost else ".")
    )
    return merged
