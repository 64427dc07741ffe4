"""VTK's readers of images: which one reads a format, and where the image is.

Used in a process of its own, see ``vtk_process``.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from vtkmodules.vtkCommonCore import vtkDoubleArray
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkPolyData

from ..errors import MeshFileError
from . import vtk_readers

#: The readers of VTK that are used for images.
READERS = {
    ".mha": ("vtkIOImage", "vtkMetaImageReader"),
    ".mhd": ("vtkIOImage", "vtkMetaImageReader"),
    ".nii": ("vtkIOImage", "vtkNIFTIImageReader"),
    ".nii.gz": ("vtkIOImage", "vtkNIFTIImageReader"),
    ".tif": ("vtkIOImage", "vtkTIFFReader"),
    ".tiff": ("vtkIOImage", "vtkTIFFReader"),
    ".vti": ("vtkIOXML", "vtkXMLImageDataReader"),
    ".vtk": ("vtkIOLegacy", "vtkDataSetReader"),
}


def read(path: Path, name: str, extension: str) -> tuple[Any, list[str]]:
    """Read an image with VTK.

    Returns
    -------
    vtkPolyData
        The arrays as field data, the first of which says where the image is: extent, origin, spacing,
        direction; how many of the arrays are of points; and which of the points and cells are active.
    list of str
        What was done to the file's content, one sentence each.

    Raises
    ------
    MeshFileError
        The file is damaged, or holds no image.
    """
    reader, image = vtk_readers.run(READERS[extension], path, name, extension)
    if not isinstance(image, vtkImageData):
        raise MeshFileError(f"{name} holds no image ({image.GetClassName()[3:]}); give an image of labels.")
    direction = [image.GetDirectionMatrix().GetElement(i, j) for i in range(3) for j in range(3)]
    origin, notes = list(image.GetOrigin()), list[str]()
    if extension.startswith(".nii"):
        origin, direction, notes = _place_of_nifti(reader, origin, direction, Path(name).name)
    values = [*image.GetExtent(), *origin, *image.GetSpacing(), *direction]
    homes = [image.GetPointData(), image.GetCellData()]
    values.append(homes[0].GetNumberOfArrays())
    for data in homes:
        there = [data.GetAbstractArray(i) for i in range(data.GetNumberOfArrays())]
        values.append(next((i for i, each in enumerate(there) if each is data.GetScalars()), -1))
    grid = vtkDoubleArray()
    grid.SetName("Grid")
    for value in values:
        grid.InsertNextValue(value)
    packed = vtkPolyData()
    packed.GetFieldData().AddArray(grid)
    for number, data in enumerate(homes):
        for i in range(data.GetNumberOfArrays()):
            array = data.GetAbstractArray(i)
            # Field data has one array of a name only.
            if not array.GetName() or packed.GetFieldData().HasArray(array.GetName()):
                array.SetName(f"Labels{number}{i}")
            packed.GetFieldData().AddArray(array)
    return packed, notes


def _place_of_nifti(
    reader: Any, origin: list[float], direction: list[float], name: str
) -> tuple[list[float], list[float], list[str]]:
    """Return where the header of a NIfTI file says that its image is, which VTK leaves to the caller."""
    for matrix in (reader.GetQFormMatrix(), reader.GetSFormMatrix()):
        if matrix is None:
            continue
        axes = [[matrix.GetElement(i, j) for j in range(3)] for i in range(3)]
        products = [
            sum(axes[k][i] * axes[k][j] for k in range(3)) - (i == j) for i in range(3) for j in range(3)
        ]
        if max(map(abs, products)) < 1e-4:
            placed = [matrix.GetElement(i, 3) for i in range(3)]
            return placed, [value for row in axes for value in row], []
    note = [f"{name}: no rigid placement is given in the header; the image begins at the origin."]
    return origin, direction, note
