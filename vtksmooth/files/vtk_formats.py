"""The formats that VTK's own readers and writers handle."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyvista as pv
from vtkmodules.vtkFiltersCore import vtkAppendFilter

from ..errors import MeshFileError
from . import vtk_messages, vtk_process, vtk_readers, vtk_transfer
from .damage import check
from .vtk_hdf import for_hdf
from .vtk_xml import for_xml

#: The writers of VTK that are used, by extension: module and class.
WRITERS = {
    ".vtk": ("vtkIOLegacy", "vtkPolyDataWriter"),
    ".vtkhdf": ("vtkIOHDF", "vtkHDFWriter"),
    ".vtp": ("vtkIOXML", "vtkXMLPolyDataWriter"),
    ".vtu": ("vtkIOXML", "vtkXMLUnstructuredGridWriter"),
}

#: Writers that report success on a full disk: what they wrote is read again.
_VERIFIED = (".vtkhdf",)


def read(
    path: Path, extension: str, cancelled: Callable[[], bool] = lambda: False
) -> tuple[pv.PolyData, list[str]]:
    """Read a file with VTK; return its surface, and what was done to the file's content."""
    try:
        mesh, notes = vtk_process.read(path, extension, vtk_transfer.unpack, cancelled)
    except vtk_process.Unavailable:
        with vtk_messages.hdf_silence(extension):
            found, notes = vtk_readers.read(path, str(path), extension)
        description, arrays = vtk_transfer.pack(found)
        waiting = iter(arrays)
        mesh = vtk_transfer.unpack(description, lambda values: np.copyto(values, next(waiting)))
    check(str(path), mesh)
    return pv.PolyData(mesh), notes


def write(mesh: pv.PolyData, temporary: Path, name: str) -> list[str]:
    """Write a mesh; return what the format cannot hold. `name` is what messages call the file."""
    extension = temporary.suffix.lower()
    module, cls = WRITERS[extension]
    writer = getattr(importlib.import_module(f"vtkmodules.{module}"), cls)()
    data: Any = mesh
    notes: list[str] = []
    if extension == ".vtkhdf":
        data, notes = for_hdf(mesh, name)
    elif extension in (".vtp", ".vtu"):
        data, notes = for_xml(mesh, name)
    if extension == ".vtu":
        notes += [f"{name}: VTU holds no polygonal data; the faces were written as an unstructured grid."]
        append = vtkAppendFilter()
        append.AddInputDataObject(data)
        append.Update()
        data = append.GetOutput()
    writer.SetFileName(vtk_readers.file_name(temporary))
    writer.SetInputDataObject(data)
    if hasattr(writer, "SetFileTypeToBinary"):
        writer.SetFileTypeToBinary()
    # Update() and not Write(): it lets other Python threads run.
    with vtk_messages.collected() as messages, vtk_messages.hdf_silence(extension):
        vtk_messages.run(writer)
    code = writer.GetErrorCode()
    del writer  # VTK 9.4's writer of HDF files writes the end of the file when it goes
    if messages or code:
        raise MeshFileError(
            f"cannot write {name}: {messages[0] if messages else f'error {code} of VTK'}; "
            "make room or choose another folder."
        )
    if extension in _VERIFIED:
        try:
            written, _ = read(temporary, extension)
            cells = written.GetNumberOfCells()
        except MeshFileError:
            cells = -1
        if cells != data.GetNumberOfCells():
            raise MeshFileError(
                f"cannot write {name}: what was written cannot be read again; "
                "make room if the disk is full, or choose another format."
            )
    return notes
