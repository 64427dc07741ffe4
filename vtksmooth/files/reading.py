"""Reading a surface mesh: whatever is wrong with a file becomes one message."""

from __future__ import annotations

import os
import stat
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pyvista as pv
from vtkmodules.vtkCommonCore import vtkStringArray

from ..errors import MeshFileError
from ..filters.arrays import vtk_array, vtk_cells, vtk_points
from . import obj, off, ply, stl, vtk_formats
from .damage import check_indices
from .names import path_of
from .polygons import Polygons
from .signatures import OF_VTK, wrong_signature

_HEAD = 1 << 16

#: The formats that are read here, and not by VTK.
_POLYGONS: dict[str, Callable[[Path], tuple[Polygons, list[str]]]] = {
    ".obj": obj.read,
    ".off": off.read,
    ".ply": ply.read,
    ".stl": stl.read,
}

#: The formats that can be read, by extension.
READABLE = (*sorted([*OF_VTK, *_POLYGONS]),)


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
        What was done to the file's content, one sentence each: STL's points merged, the outer surface of
        a grid taken, the blocks of a composite file combined, arrays left out.

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
    path = path_of(path)
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
    if extension in _POLYGONS:
        polygons, notes = _POLYGONS[extension](path)
        mesh = _polydata(path, polygons, notes)
    else:
        wrong = wrong_signature(extension, head, status.st_size)
        if wrong:
            raise MeshFileError(f"{path} {wrong}.")
        mesh, notes = vtk_formats.read(path, extension, cancelled)
    if mesh.GetNumberOfPolys() + mesh.GetNumberOfStrips() == 0:
        raise MeshFileError(f"{path} holds {mesh.n_points} points and no faces; export it as a surface mesh.")
    return mesh, notes


def _polydata(path: Path, mesh: Polygons, notes: list[str]) -> pv.PolyData:
    for _, corners in (mesh.verts, mesh.lines, (mesh.sizes, mesh.connectivity)):
        check_indices(path, corners, len(mesh.points))
    kinds = [(mesh.verts, 1), (mesh.lines, 2), ((mesh.sizes, mesh.connectivity), 3)]
    whole = np.concatenate([sizes >= least for (sizes, _), least in kinds])
    if not whole.all():
        notes.append(
            f"{path.name}: {int((~whole).sum())} faces with less than three corners were left out."
            if len(whole) == len(mesh.sizes)
            else f"{path.name}: {int((~whole).sum())} faces and lines with too few corners were left out."
        )
    result = pv.PolyData()
    result.SetPoints(vtk_points(mesh.points))
    for ((sizes, corners), least), put in zip(
        kinds, (result.SetVerts, result.SetLines, result.SetPolys), strict=True
    ):
        kept = sizes >= least
        if kept.any():
            offsets = np.concatenate(([0], np.cumsum(sizes[kept])))
            put(vtk_cells(offsets, corners if kept.all() else corners[np.repeat(kept, sizes)]))
    for data, arrays, chosen in (
        (result.GetPointData(), mesh.point_data, slice(None)),
        (result.GetCellData(), mesh.cell_data, slice(None) if whole.all() else whole),
        (result.GetFieldData(), mesh.field_data, slice(None)),
    ):
        for name, array in arrays.items():
            data.AddArray(_array(array[chosen], name))
    for role in ("Normals", "TCoords"):
        values = mesh.point_data.get(role)
        if values is not None and values.dtype.kind == "f" and values.ndim == 2:
            getattr(result.GetPointData(), f"SetActive{role}")(role)
    return result


def _array(values: npt.NDArray[Any], name: str) -> Any:
    if values.dtype.kind != "O":
        return vtk_array(values, name)
    array = vtkStringArray()
    array.SetName(name)
    for value in values:
        array.InsertNextValue(value)
    return array
