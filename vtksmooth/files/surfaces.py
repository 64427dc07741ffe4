"""One surface of whatever data set a reader of VTK gave: polydata, grid or composite."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import (
    VTK_POLYGON,
    VTK_QUAD,
    VTK_TRIANGLE,
    vtkCompositeDataSet,
    vtkDataObjectTreeIterator,
    vtkDataSet,
    vtkPolyData,
    vtkUnstructuredGrid,
)
from vtkmodules.vtkFiltersCore import vtkAppendPolyData
from vtkmodules.vtkFiltersGeometry import vtkGeometryFilter

from ..errors import MeshFileError
from . import vtk_messages
from .damage import check


def surface_of(name: str, data: Any, notes: list[str]) -> vtkPolyData:
    """Make one surface of whatever a reader gave."""
    if isinstance(data, vtkPolyData):
        check(name, data)
        return data
    if isinstance(data, vtkCompositeDataSet):
        return _combined(name, data, notes)
    if not isinstance(data, vtkDataSet):
        raise MeshFileError(f"{name} holds no mesh ({data.GetClassName()[3:]}); export it as a surface mesh.")
    check(name, data)
    if isinstance(data, vtkUnstructuredGrid) and _only_faces(data):
        notes.append(f"{Path(name).name} holds an unstructured grid of faces; they were taken as they are.")
        return _faces_of(data)
    # Not vtkDataSetSurfaceFilter: of structured grids that gives six sides that share no points.
    surface = vtkGeometryFilter()
    surface.SetInputDataObject(data)
    with vtk_messages.collected() as messages:
        vtk_messages.run(surface)
    if messages:
        raise MeshFileError(f"{name} has no outer surface ({messages[0]}); export the surface itself.")
    kind = re.sub(r"(?<!^)([A-Z])", r" \1", data.GetClassName()[3:]).lower()
    mesh: vtkPolyData = surface.GetOutput()
    notes.append(
        f"{Path(name).name} holds {_article(kind)} of {data.GetNumberOfCells()} cells; "
        f"its outer surface was taken ({mesh.GetNumberOfCells()} faces)."
    )
    return mesh


def _only_faces(grid: vtkUnstructuredGrid) -> bool:
    types = (
        {*np.unique(vtk_to_numpy(grid.GetCellTypesArray())).tolist()} if grid.GetNumberOfCells() else set()
    )
    return bool(types) and types <= {VTK_TRIANGLE, VTK_QUAD, VTK_POLYGON}


def _faces_of(grid: vtkUnstructuredGrid) -> vtkPolyData:
    """Make polydata of a grid of faces: the surface filter would drop and renumber points."""
    mesh = vtkPolyData()
    mesh.SetPoints(grid.GetPoints())
    mesh.SetPolys(grid.GetCells())
    mesh.GetPointData().ShallowCopy(grid.GetPointData())
    mesh.GetCellData().ShallowCopy(grid.GetCellData())
    mesh.GetFieldData().ShallowCopy(grid.GetFieldData())
    return mesh


def _article(noun: str) -> str:
    return f"{'an' if noun[0] in 'aeiou' else 'a'} {noun}"


def _combined(name: str, data: Any, notes: list[str]) -> vtkPolyData:
    iterator = data.NewIterator()
    if isinstance(iterator, vtkDataObjectTreeIterator):
        iterator.SkipEmptyNodesOn()
    append = vtkAppendPolyData()
    blocks = 0
    iterator.InitTraversal()
    inner: list[str] = []
    while not iterator.IsDoneWithTraversal():
        block = iterator.GetCurrentDataObject()
        if isinstance(block, vtkDataSet) and block.GetNumberOfCells():
            append.AddInputDataObject(surface_of(name, block, inner))
            blocks += 1
        iterator.GoToNextItem()
    if not blocks:
        raise MeshFileError(f"{name} holds no block with faces; export it as a surface mesh.")
    append.Update()
    if blocks > 1:
        notes.append(
            f"{Path(name).name} holds {blocks} blocks; they were combined into one mesh, "
            "with the arrays that all of them have, and share no points."
        )
    notes += (
        inner[:1]
        if blocks == 1
        else [f"{Path(name).name}: outer surfaces of grids were taken."] * bool(inner)
    )
    combined: vtkPolyData = append.GetOutput()
    return combined
