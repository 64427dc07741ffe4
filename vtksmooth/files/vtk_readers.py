"""VTK's readers: which one reads a format, and what is done with what it reads.

Used in a process of its own, see ``vtk_process``; hence without PyVista and the filters, whose import takes
long.
"""

from __future__ import annotations

import importlib
import os
from pathlib import Path
from typing import Any

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import VTK_FLOAT, VTK_UNSIGNED_CHAR, vtkDataArray

from ..errors import MeshFileError
from . import vtk_messages
from .polygons import colours
from .surfaces import surface_of

#: The readers of VTK that are used, by extension: module and class.
READERS = {
    ".glb": ("vtkIOGeometry", "vtkGLTFReader"),
    ".gltf": ("vtkIOGeometry", "vtkGLTFReader"),
    ".pvtu": ("vtkIOXML", "vtkXMLPUnstructuredGridReader"),
    ".vti": ("vtkIOXML", "vtkXMLImageDataReader"),
    ".vtk": ("vtkIOLegacy", "vtkDataSetReader"),
    ".vtkhdf": ("vtkIOHDF", "vtkHDFReader"),
    ".vtm": ("vtkIOXML", "vtkXMLMultiBlockDataReader"),
    ".vtmb": ("vtkIOXML", "vtkXMLMultiBlockDataReader"),
    ".vtp": ("vtkIOXML", "vtkXMLPolyDataReader"),
    ".vtr": ("vtkIOXML", "vtkXMLRectilinearGridReader"),
    ".vts": ("vtkIOXML", "vtkXMLStructuredGridReader"),
    ".vtu": ("vtkIOXML", "vtkXMLUnstructuredGridReader"),
}

#: What the reader of legacy files leaves out unless it is told.
_ALL_OF_LEGACY = ("Scalars", "ColorScalars", "Normals", "TCoords", "Vectors", "Fields", "Tensors")


def read(path: Path, name: str, extension: str) -> tuple[Any, list[str]]:
    """Read the surface of a file with VTK.

    Parameters
    ----------
    path : Path
    name : str
        What messages call the file.
    extension : str
        A key of :data:`READERS`.

    Returns
    -------
    vtkPolyData
        Not checked: cells may refer to points that are not there.
    list of str
        What was done to the file's content, one sentence each.

    Raises
    ------
    MeshFileError
        The file is damaged, truncated or holds no surface.
    """
    reader, data = run(READERS[extension], path, name, extension)
    notes: list[str] = []
    surface = surface_of(name, data, notes)
    if extension == ".vtkhdf":
        # Such files do not say what an array is for.
        for role, components in (("Normals", 3), ("TCoords", 2)):
            array = surface.GetPointData().GetArray(role)
            if array is not None and array.GetNumberOfComponents() == components:
                getattr(surface.GetPointData(), f"SetActive{role}")(role)
    if extension in (".glb", ".gltf"):
        _as_elsewhere(surface.GetPointData())
        if reader.GetNumberOfTextures():
            notes.append(
                f"{Path(name).name}: the pictures of textures were left out; texture coordinates are kept."
            )
    return surface, notes


def run(home: tuple[str, str], path: Path, name: str, extension: str) -> tuple[Any, Any]:
    """Return a reader of VTK, by module and class, that has read a file; and what it has read.

    Raises
    ------
    MeshFileError
        The file is damaged or truncated.
    """
    module, cls = home
    reader: Any = None
    data: Any = None
    with vtk_messages.collected() as messages:
        try:
            reader = getattr(importlib.import_module(f"vtkmodules.{module}"), cls)()
            reader.SetFileName(file_name(path))
            for kind in _ALL_OF_LEGACY if extension == ".vtk" else ():
                getattr(reader, f"ReadAll{kind}On")()
            vtk_messages.run(reader)
            data = reader.GetOutputDataObject(0)
        # Whatever a reader trips over, an attribute of the file is the cause.
        except (AttributeError, KeyError, RuntimeError, TypeError, ValueError) as error:
            messages.append(vtk_messages.printable(str(error).split("\n")[0]) or type(error).__name__)
    if not messages and data is None:
        messages.append("nothing could be read")
    if messages:
        raise MeshFileError(f"{name} is damaged or truncated ({messages[0]}); export it again.")
    return reader, data


def _as_elsewhere(data: Any) -> None:
    """Give what glTF files hold of points the names and the meaning that other formats give it."""
    for old, new in (("NORMAL", "Normals"), ("TEXCOORD_0", "TCoords")):
        if data.HasArray(old) and not data.HasArray(new):
            data.GetArray(old).SetName(new)
    textures = data.GetArray("TCoords")
    if textures is not None and textures.GetNumberOfComponents() == 2:
        # There, pictures begin at the top; in all other formats, at the bottom.
        values = vtk_to_numpy(textures)
        values[:, 1] = 1.0 - values[:, 1]
        data.SetActiveTCoords("TCoords")
    found = data.GetArray("COLOR_0")
    values = None if found is None else colours(vtk_to_numpy(found))
    if values is not None:
        if values.shape[1] == 4 and (values[:, 3] == (255 if values.dtype == np.uint8 else 1)).all():
            values = np.ascontiguousarray(values[:, :3])
        array = vtkDataArray.CreateDataArray(VTK_UNSIGNED_CHAR if values.dtype == np.uint8 else VTK_FLOAT)
        array.SetNumberOfComponents(values.shape[1])
        array.SetNumberOfTuples(len(values))
        vtk_to_numpy(array)[:] = values
        array.SetName("RGB" if values.shape[1] == 3 else "RGBA")
        data.RemoveArray("COLOR_0")
        data.AddArray(array)


def file_name(path: Path) -> str | bytes:
    """Return a path as VTK takes it: it knows no names but UTF-8, or the bytes of the name."""
    return str(path) if os.name == "nt" else os.fsencode(path)
