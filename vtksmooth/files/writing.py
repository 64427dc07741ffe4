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
from vtkmodules.vtkFiltersCore import vtkTriangleFilter

from ..errors import MeshFileError
from ..filters.arrays import cells_of, name_of, points_of, strip_triangles
from . import damage, gltf, names, obj, off, ply, stl, threemf, vtk_formats
from .polygons import Kept, Polygons

#: The formats of which not all of a mesh is written.
_WRITE_POLYGONS: dict[str, Callable[[IO[bytes], Polygons], Kept]] = {
    ".3mf": threemf.write,
    ".glb": gltf.write,
    ".obj": obj.write,
    ".off": off.write,
    ".ply": ply.write,
    ".stl": stl.write,
}

#: Those of them that hold faces only.
_FACES_ONLY = (".3mf", ".glb", ".off", ".stl")

#: Those of them that hold triangles only, and those that do so in single precision.
_TRIANGLES_ONLY = (".3mf", ".glb", ".stl")
_SINGLE_PRECISION = (".glb", ".stl")

#: Those of them that cannot hold coordinates that are infinite or no numbers.
_FINITE = (".3mf", ".glb")

#: The formats that can be written, by extension.
WRITABLE = (*sorted([*vtk_formats.WRITERS, *_WRITE_POLYGONS]),)

#: Those of them that hold polylines.
HOLDING_LINES = tuple(extension for extension in WRITABLE if extension not in (*_FACES_ONLY, ".ply"))

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
        The extension is not one of :data:`WRITABLE` (of ``HOLDING_LINES``), or needs a package that is not
        installed; or see :func:`check_place`.
    """
    path = names.path_of(path)
    extensions = HOLDING_LINES if lines else WRITABLE
    if path.suffix.lower() not in extensions:
        raise MeshFileError(
            f"cannot write {path}: the extension {path.suffix or '(none)'!r} is no format that can be "
            f"written{' with lines' if lines else ''}; use one of {' '.join(extensions)}."
        )
    if path.suffix.lower() == ".3mf":
        threemf.check_installed(path)
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
    except (OSError, RuntimeError, ValueError) as error:  # a name too long, a loop of links, a null character
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
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else error
        raise MeshFileError(
            f"cannot make the folder {path}: {reason}; name another with --output."
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
        What the format cannot hold: arrays, double precision, lines, faces with more than three corners.

    Raises
    ------
    MeshFileError
        See :func:`check_writable`; the format holds none of the mesh's cells; or the disk is full or failed.
    """
    path = names.path_of(path)
    check_writable(path)
    surface = names.decoded(mesh)
    surface, notes = _without_variants(surface, path.name)
    try:
        damage.check("the mesh", surface)
    except MeshFileError as error:
        reason = str(error).replace("export it again", "mend it first")
        raise MeshFileError(f"cannot write {path.name}: {reason}") from error
    surface = surface if isinstance(surface, pv.PolyData) else pv.wrap(surface)
    with atomic(path) as temporary:
        notes += _write(surface, temporary, path.name)
    return notes


def _without_variants(mesh: Any, name: str) -> tuple[Any, list[str]]:
    """Leave out arrays of neither numbers nor texts, which no format holds."""
    copy = mesh.NewInstance()
    copy.ShallowCopy(mesh)
    lost = []
    for data in (copy.GetPointData(), copy.GetCellData(), copy.GetFieldData()):
        for i in reversed(range(data.GetNumberOfArrays())):
            array = data.GetAbstractArray(i)
            if not (array.IsA("vtkDataArray") or array.IsA("vtkStringArray")):
                lost.append(name_of(array) or "(unnamed)")
                data.RemoveArray(i)
    if not lost:
        return mesh, []
    return copy, [f"{name}: arrays of neither numbers nor texts left out: {', '.join(lost)}."]


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
    if extension not in _WRITE_POLYGONS:
        return vtk_formats.write(mesh, temporary, name)
    format_name = extension[1:].upper()
    others = _count(mesh.n_lines, "lines") + _count(mesh.n_verts, "vertex cells")
    notes = []
    if extension in _FACES_ONLY and others:
        if mesh.n_cells == mesh.n_lines + mesh.n_verts:
            raise MeshFileError(
                f"cannot write {name}: {format_name} holds faces only, and the mesh has "
                f"{' and '.join(others)} but no faces; use .obj or .vtp."
            )
        notes.append(f"{name}: {format_name} holds faces only; {' and '.join(others)} were left out.")
    if extension in _TRIANGLES_ONLY and not mesh.n_cells:
        raise MeshFileError(f"cannot write {name}: the mesh has no faces; use .vtp.")
    polygons, short = _polygons(mesh).without_short_faces()
    if short:
        notes.append(f"{name}: {short} faces with less than three corners were left out.")
    if extension in _FACES_ONLY:
        polygons = polygons.only_faces()
    if extension == ".ply":
        if mesh.n_verts:
            notes.append(f"{name}: PLY holds points without cells; {others[-1]} of them were left out.")
        if (polygons.lines[0] > 2).any():
            notes.append(f"{name}: PLY holds edges; longer lines were written as their segments.")
    _check_coordinates(polygons, name, extension)
    if extension in _SINGLE_PRECISION and mesh.points.dtype != np.float32:
        notes.append(f"{name}: {format_name} keeps single precision only; the points were rounded.")
    if extension in _TRIANGLES_ONLY and (polygons.sizes != 3).any():
        notes.append(f"{name}: {format_name} holds triangles only; larger faces were split.")
        polygons = _polygons(_triangulated(mesh)).only_faces()
    if extension == ".stl":
        loose = int((np.bincount(polygons.connectivity, minlength=len(polygons.points)) == 0).sum())
        if loose:
            notes.append(f"{name}: STL holds no points without a face; {loose} of them were left out.")
    if extension == ".3mf":
        polygons, flat = threemf.proper(polygons)
        if flat:
            notes.append(f"{name}: {flat} triangles with two equal corners were left out.")
    if mesh.n_strips:
        notes.append(f"{name}: triangle strips were written as their triangles.")
    with temporary.open("wb") as file:
        kept = _WRITE_POLYGONS[extension](file, polygons)
    return _lost_arrays(mesh, kept, name, format_name) + notes


def _check_coordinates(polygons: Polygons, name: str, extension: str) -> None:
    """Refuse coordinates that a format does not hold."""
    points, format_name = polygons.points, extension[1:].upper()
    largest = max(-points.min(initial=0.0), points.max(initial=0.0))
    if extension in _FINITE and not np.isfinite(largest):
        raise MeshFileError(
            f"cannot write {name}: {format_name} holds finite coordinates only; remove the points that have "
            "others, or use .vtp."
        )
    if extension not in _SINGLE_PRECISION or largest <= np.finfo(np.float32).max:
        return
    if extension == ".stl":  # has no points without a face
        points = points[polygons.connectivity]
    largest = np.abs(points[np.isfinite(points)]).max(initial=0.0)
    if largest > np.finfo(np.float32).max:
        raise MeshFileError(
            f"cannot write {name}: {format_name} keeps single precision only, which ends at 3.4e38; scale "
            "the mesh, or use .vtp."
        )


def _count(number: int, what: str) -> list[str]:
    return [f"{number} {what}"] * bool(number)


def _triangulated(mesh: pv.PolyData) -> pv.PolyData:
    """Return the faces of a mesh as triangles, with its arrays."""
    split = vtkTriangleFilter()
    split.PassVertsOff()
    split.PassLinesOff()
    split.SetInputDataObject(mesh)
    split.Update()
    return pv.wrap(split.GetOutput())


def _polygons(mesh: pv.PolyData) -> Polygons:
    """Return the cells and arrays of a mesh; the triangles of strips come behind the other faces."""
    points = points_of(mesh)
    kinds = [cells_of(cells) for cells in (mesh.GetVerts(), mesh.GetLines(), mesh.GetPolys())]
    verts, lines, faces = (
        (np.diff(offsets).astype(np.int64), corners.astype(np.int64, copy=False))
        for offsets, corners in kinds
    )
    chosen = None
    if mesh.n_strips:
        triangles, strips = strip_triangles(*cells_of(mesh.GetStrips()))
        before = mesh.n_cells - mesh.n_strips
        chosen = np.concatenate((np.arange(before), before + strips))
        faces = (
            np.concatenate((faces[0], np.full(len(triangles), 3, np.int64))),
            np.concatenate((faces[1], triangles.ravel().astype(np.int64))),
        )
    cell_data = _numeric(mesh.cell_data)
    if chosen is not None:
        cell_data = {name: array[chosen] for name, array in cell_data.items()}
    point_data = _numeric(mesh.point_data)
    active = {"Normals": mesh.GetPointData().GetNormals(), "TCoords": mesh.GetPointData().GetTCoords()}
    roles = {role: name_of(array) for role, array in active.items() if array is not None}
    fields = {name: np.asarray(array) for name, array in mesh.field_data.items() if name}
    return Polygons(points, *faces, point_data, cell_data, verts, lines, fields, roles)


def _numeric(data: pv.DataSetAttributes) -> dict[str, npt.NDArray[Any]]:
    return {name: np.asarray(array) for name, array in data.items() if name and array.dtype.kind in "biuf"}


def _lost_arrays(mesh: pv.PolyData, kept: Kept, name: str, format_name: str) -> list[str]:
    """Say which arrays the format does not keep, and which it keeps in pieces."""
    # What a run reports about itself is told to the user anyway.
    told = {array for array in mesh.field_data.keys() if array.startswith("Smoothing")}  # noqa: SIM118
    lost = [
        array or "(unnamed)"
        for data, names in (
            (mesh.point_data, kept.point_data),
            (mesh.cell_data, kept.cell_data),
            (mesh.field_data, kept.field_data | told),
        )
        for array in data.keys()  # noqa: SIM118 (iterating skips no unnamed ones)
        if array not in names
    ]
    notes = [f"{name}: {format_name} does not keep the arrays {', '.join(lost)}."] if lost else []
    if format_name == "PLY":
        roles = (mesh.GetPointData().GetNormals(), mesh.GetPointData().GetTCoords())
        whole = {
            "Normals",
            "RGB",
            "RGBA",
            "TCoords",
            *(name_of(array) for array in roles if array is not None),
        }
        split = [
            n
            for n, a in [*mesh.point_data.items(), *mesh.cell_data.items()]
            if a.ndim > 1 and a.shape[1] > 1 and n not in whole
        ]
        if split:
            notes.append(f"{name}: PLY keeps arrays with several components as one each: {', '.join(split)}.")
    return notes
