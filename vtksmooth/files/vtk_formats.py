"""The formats that VTK's own readers and writers handle."""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Any

import pyvista as pv
from vtkmodules.vtkFiltersCore import vtkAppendFilter

from ..errors import MeshFileError
from . import vtk_messages

#: The writers of VTK that are used, by extension: module and class.
WRITERS = {
    ".obj": ("vtkIOGeometry", "vtkOBJWriter"),
    ".stl": ("vtkIOGeometry", "vtkSTLWriter"),
    ".vtk": ("vtkIOLegacy", "vtkPolyDataWriter"),
    ".vtkhdf": ("vtkIOHDF", "vtkHDFWriter"),
    ".vtp": ("vtkIOXML", "vtkXMLPolyDataWriter"),
    ".vtu": ("vtkIOXML", "vtkXMLUnstructuredGridWriter"),
}

#: Writers that report success on a full disk: what they wrote is read again.
_VERIFIED = (".obj", ".vtkhdf")


def read(path: Path, extension: str) -> Any:
    """Read a file with VTK; return the data object of whatever kind."""
    data = None
    with vtk_messages.collected() as messages, vtk_messages.hdf_silence(extension):
        try:
            reader = pv.get_reader(str(path), force_ext=extension).reader
            vtk_messages.run(reader)
            data = reader.GetOutputDataObject(0)
        # Whatever a reader trips over, an attribute of the file is the cause.
        except (AttributeError, KeyError, RuntimeError, TypeError, ValueError) as error:
            messages.append(vtk_messages.printable(str(error).split("\n")[0]) or type(error).__name__)
    if not messages and data is None:
        messages.append("nothing could be read")
    if messages:
        raise MeshFileError(f"{path} is damaged or truncated ({messages[0]}); export it again.")
    return data


def write(mesh: pv.PolyData, temporary: Path, name: str) -> None:
    """Write a mesh; `name` is what messages call the file."""
    extension = temporary.suffix.lower()
    module, cls = WRITERS[extension]
    writer = getattr(importlib.import_module(f"vtkmodules.{module}"), cls)()
    data: Any = mesh
    if extension == ".vtu":
        append = vtkAppendFilter()
        append.AddInputDataObject(mesh)
        append.Update()
        data = append.GetOutput()
    writer.SetFileName(str(temporary))
    writer.SetInputDataObject(data)
    if hasattr(writer, "SetFileTypeToBinary"):
        writer.SetFileTypeToBinary()
    # Update() and not Write(): it lets other Python threads run.
    with vtk_messages.collected() as messages, vtk_messages.hdf_silence(extension):
        vtk_messages.run(writer)
    code = writer.GetErrorCode()
    if messages or code:
        raise MeshFileError(
            f"cannot write {name}: {messages[0] if messages else f'error {code} of VTK'}; "
            "make room or choose another folder."
        )
    if extension in _VERIFIED:
        incomplete = MeshFileError(f"cannot write {name}: it came out incomplete; make room on the disk.")
        try:
            written = read(temporary, extension)
        except MeshFileError:
            raise incomplete from None
        if written.GetNumberOfCells() != data.GetNumberOfCells():
            raise incomplete
