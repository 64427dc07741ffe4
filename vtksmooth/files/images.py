"""Reading a label image: in the process of ``vtk_process``, as surfaces are."""

from __future__ import annotations

import os
import stat
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkPolyData

from ..errors import MeshFileError
from . import nrrd, vtk_image_readers, vtk_process, vtk_transfer
from .vtk_image_readers import READERS

#: The formats that are read here, and not by VTK.
_NRRD = (".nhdr", ".nrrd")

#: The formats of images that can be read, by extension.
READABLE_IMAGES = (*sorted([*READERS, *_NRRD]),)


def extension_of(path: Path) -> str:
    """Return the extension of a file, in lower case; ".nii.gz" is one."""
    name = path.name.lower()
    return ".nii.gz" if name.endswith(".nii.gz") else path.suffix.lower()


def read_image(
    path: str | os.PathLike[str], cancelled: Callable[[], bool] = lambda: False
) -> tuple[vtkImageData, list[str]]:
    """Read a label image.

    Parameters
    ----------
    path : path-like
        A file whose extension is one of :data:`READABLE_IMAGES`; TIFF files hold a stack of slices.
    cancelled : callable
        Asked ten times a second or more whether to stop.

    Returns
    -------
    vtkImageData
    list of str
        What was done to the file's content, one sentence each.

    Raises
    ------
    MeshFileError
        There is no such file, or it cannot be read as an image.
    Cancelled
        `cancelled` returned True.
    """
    path = Path(path).expanduser()
    extension = extension_of(path)
    try:
        status = path.stat()
    except OSError as error:
        raise MeshFileError(f"cannot read {path}: {error.strerror or error}; check the path.") from error
    if not stat.S_ISREG(status.st_mode):
        raise MeshFileError(f"{path} is not a regular file; name the file of an image.")
    if extension not in READABLE_IMAGES:
        raise MeshFileError(
            f"{path} has the extension {extension or '(none)'!r}, which is no image that can be read; known "
            f"are {' '.join(READABLE_IMAGES)}."
        )
    if not status.st_size:
        raise MeshFileError(f"{path} is empty; export it again.")
    try:
        if extension in _NRRD:
            return nrrd.read(path), []
        packed, notes = vtk_process.read(path, extension, vtk_transfer.unpack, cancelled, kind="image")
    except vtk_process.Unavailable:
        found, notes = vtk_image_readers.read(path, str(path), extension)
        description, arrays = vtk_transfer.pack(found)
        waiting = iter(arrays)
        packed = vtk_transfer.unpack(description, lambda values: np.copyto(values, next(waiting)))
    except OSError as error:
        if isinstance(error, MeshFileError):
            raise
        raise MeshFileError(f"cannot read {path}: {error.strerror or error}; check the file.") from error
    except MemoryError as error:
        raise MeshFileError(f"{path} does not fit into memory; use a larger machine.") from error
    return _image_of(packed), notes


def _image_of(packed: vtkPolyData) -> vtkImageData:
    """Return the image that :func:`~vtksmooth.files.vtk_image_readers.read` has packed."""
    fields = packed.GetFieldData()
    grid: Any = fields.GetArray(0)
    values = [grid.GetValue(i) for i in range(grid.GetNumberOfValues())]
    image = vtkImageData()
    image.SetExtent([int(value) for value in values[:6]])
    image.SetOrigin(values[6:9])
    image.SetSpacing(values[9:12])
    image.SetDirectionMatrix(values[12:21])
    of_points = int(values[21])
    for number in range(1, fields.GetNumberOfArrays()):
        data = image.GetPointData() if number <= of_points else image.GetCellData()
        data.AddArray(fields.GetAbstractArray(number))
    for data, active in ((image.GetPointData(), values[22]), (image.GetCellData(), values[23])):
        if active >= 0:
            data.SetActiveScalars(data.GetArrayName(int(active)))
    return image
