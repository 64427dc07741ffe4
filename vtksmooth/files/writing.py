"""Writing a surface mesh so that the file is there completely, or as it was before."""

from __future__ import annotations

import contextlib
import os
import stat
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import IO, Any

import numpy as np
import numpy.typing as npt
import pyvista as pv
from vtkmodules.vtkCommonDataModel import vtkPolyData

from ..errors import MeshFileError
from ..filters.arrays import cells_of, points_of
from . import off, ply, vtk_formats
from .polygons import Polygons

#: The formats that can be written, by extension.
WRITABLE = (*sorted([*vtk_formats.WRITERS, ".off", ".ply"]),)

#: Those of them that hold polylines.
HOLDING_LINES = tuple(extension for extension in WRITABLE if extension not in (".off", ".ply", ".stl"))

_unfinished: set[Path] = set()


def remove_unfinished() -> None:
    """Remove the temporary files of writes that are under way; for a process about to be ended."""
    for path in list(_unfinished):
        path.unlink(missing_ok=True)


def check_writable(path: str | os.PathLike[str], lines: bool = False) -> None:
    """Refuse a path that :func:`write_surface` could not write, before the work is done.

    Parameters
    ----------
    path : path-like
    lines : bool
        Whether polylines are to be written.

    Raises
    ------
    MeshFileError
        The extension is not one of :data:`WRITABLE` (of ``HOLDING_LINES``); or see
        :func:`check_place`.
    """
    path = Path(path).expanduser()
    extensions = HOLDING_LINES if lines else WRITABLE
    if path.suffix.lower() not in extensions:
        raise MeshFileError(
            f"cannot write {path}: the extension {path.suffix or '(none)'!r} is no format that can be "
            f"written{' with lines' if lines else ''}; use one of {' '.join(extensions)}."
        )
    check_place(path)


def check_place(path: Path) -> None:
    """Refuse a path at which no file can be written, whatever its format.

    Raises
    ------
    MeshFileError
        The folder is missing or not writable; the path is a folder, or a file that may not be changed.
    """
    try:
        target = path.resolve(strict=False)
        if not target.parent.is_dir():
            raise MeshFileError(f"cannot write {path}: there is no folder {target.parent}; create it first.")
        if target.is_dir():
            raise MeshFileError(f"cannot write {path}: it is a folder; name a file.")
        if target.exists() and not target.is_file():
            raise MeshFileError(f"cannot write {path}: it is not a regular file; name another one.")
        if target.exists() and not os.access(target, os.W_OK):
            raise MeshFileError(
                f"cannot write {path}: the file is write-protected; unprotect it or name another one."
            )
        if not os.access(target.parent, os.W_OK | os.X_OK):
            raise MeshFileError(
                f"cannot write {path}: the folder {target.parent} is not writable; choose another one."
            )
    except MeshFileError:
        raise
    except (OSError, RuntimeError) as error:  # a name too long, a loop of links
        raise MeshFileError(f"cannot write {path}: {error}; choose another path.") from error


def make_folder(path: Path) -> None:
    """Make a folder for results, and those above it, where they are missing.

    Raises
    ------
    MeshFileError
        It cannot be made.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise MeshFileError(
            f"cannot make the folder {path}: {error.strerror}; name another with --output."
        ) from error


def write_surface(mesh: vtkPolyData, path: str | os.PathLike[str]) -> list[str]:
    """Write a surface mesh so that the file is there completely, or as it was before.

    The mesh is written to a temporary file in the same folder, which then takes the place of `path`.

    Parameters
    ----------
    mesh : vtkPolyData
        The surface; it is not changed.
    path : path-like
        Where to; the extension, one of :data:`WRITABLE`, chooses the format.

    Returns
    -------
    list of str
        What the format cannot hold: arrays, double precision, faces with more than three corners.

    Raises
    ------
    MeshFileError
        See :func:`check_writable`; or the disk is full or failed.
    """
    path = Path(path).expanduser()
    check_writable(path)
    surface = mesh if isinstance(mesh, pv.PolyData) else pv.wrap(mesh)
    with atomic(path) as temporary:
        notes = _write(surface, temporary, path.name)
    return notes


@contextlib.contextmanager
def atomic(path: Path) -> Iterator[Path]:
    """Give a temporary file in the folder of `path` that takes its place when all went well.

    Raises
    ------
    MeshFileError
        See :func:`check_place`; or the disk is full or failed.
    """
    check_place(path)
    target = path.resolve()
    temporary: Path | None = None
    try:
        handle, name = tempfile.mkstemp(target.suffix, f".{target.stem[:100]}.", target.parent)
        temporary = Path(name)
        _unfinished.add(temporary)
        os.close(handle)
        yield temporary
        with temporary.open("rb+") as file:
            os.fsync(file.fileno())
        temporary.chmod(_mode(target))
        temporary.replace(target)
    except OSError as error:
        if isinstance(error, MeshFileError):
            raise
        raise MeshFileError(
            f"cannot write {path}: {error.strerror or error}; make room or choose another folder."
        ) from error
    finally:
        if temporary is not None:
            temporary.unlink(missing_ok=True)
            _unfinished.discard(temporary)


def _mode(target: Path) -> int:
    """Return the permissions of the file that is replaced, or those of any new file."""
    if target.exists():
        return stat.S_IMODE(target.stat().st_mode)
    umask = os.umask(0)
    os.umask(umask)
    return 0o666 & ~umask


def _write(mesh: pv.PolyData, temporary: Path, name: str) -> list[str]:
    extension = temporary.suffix.lower()
    notes = _losses(mesh, extension, name)
    if extension in (".off", ".ply"):
        polygons = _polygons(mesh)
        with temporary.open("wb") as file:
            _WRITE_POLYGONS[extension](file, polygons)
    else:
        notes += vtk_formats.write(mesh, temporary, name)
    return notes


def _polygons(mesh: pv.PolyData) -> Polygons:
    offsets, corners = cells_of(mesh.GetPolys())
    before = mesh.n_verts + mesh.n_lines
    inside = slice(before, before + len(offsets) - 1)
    return Polygons(
        points_of(mesh),
        np.diff(offsets).astype(np.int64),
        corners.astype(np.int64, copy=False),
        _numeric(mesh.point_data),
        {name: array[inside] for name, array in _numeric(mesh.cell_data).items()},
    )


def _numeric(data: pv.DataSetAttributes) -> dict[str, npt.NDArray[Any]]:
    return {name: np.asarray(array) for name, array in data.items() if name and array.dtype.kind in "biuf"}


def _write_off(file: IO[bytes], polygons: Polygons) -> None:
    off.write(file, polygons.points, polygons.sizes, polygons.connectivity)


_WRITE_POLYGONS: dict[str, Callable[[IO[bytes], Polygons], None]] = {
    ".off": _write_off,
    ".ply": ply.write,
}


def _losses(mesh: pv.PolyData, extension: str, name: str) -> list[str]:
    """Say what the format does not keep."""
    notes = []
    point, cell, fields = (
        [name or "(unnamed)" for name in data.keys()]  # noqa: SIM118 (iterating skips no unnamed ones)
        for data in (mesh.point_data, mesh.cell_data, mesh.field_data)
    )
    # What a run reports about itself is told to the user anyway.
    fields = [name for name in fields if not name.startswith("Smoothing")]
    lost = {
        ".obj": [n for n in point if n not in ("Normals", "TCoords")] + cell + fields,
        ".off": point + cell + fields,
        ".ply": [
            *(
                n
                for n, a in [*mesh.point_data.items(), *mesh.cell_data.items()]
                if a.dtype.kind not in "biuf"
            ),
            *fields,
        ],
        ".stl": point + cell + fields,
    }.get(extension, [])
    format_name = extension[1:].upper()
    if lost:
        notes.append(f"{name}: {format_name} does not keep the arrays {', '.join(lost)}.")
    if extension == ".ply":
        split = [
            n
            for n, a in [*mesh.point_data.items(), *mesh.cell_data.items()]
            if a.ndim > 1 and a.shape[1] > 1 and n not in ("Normals", "RGB", "RGBA")
        ]
        if split:
            notes.append(f"{name}: PLY keeps arrays with several components as one each: {', '.join(split)}.")
    if extension == ".stl":
        if mesh.points.dtype != np.float32:
            notes.append(f"{name}: STL keeps single precision only; the points were rounded.")
        if not mesh.is_all_triangles:
            notes.append(f"{name}: STL holds triangles only; larger faces were split.")
    if extension in (".off", ".ply", ".stl", ".obj") and mesh.n_verts + mesh.n_lines + mesh.n_strips:
        notes.append(f"{name}: only the polygons were written, not verts, lines and strips.")
    return notes
