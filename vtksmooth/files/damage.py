"""Damage that readers let pass, and that would make VTK read foreign memory later."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import (
    vtkCellArray,
    vtkGenericCell,
    vtkPolyData,
    vtkRectilinearGrid,
    vtkStructuredGrid,
    vtkUnstructuredGrid,
)

from ..errors import MeshFileError


def check(name: object, data: Any) -> None:
    """Refuse cells that point outside the points, and arrays of another length than the mesh.

    Parameters
    ----------
    name : str or path
        What messages call the file.
    data : vtkDataSet
    """
    n_points = data.GetNumberOfPoints()
    if isinstance(data, vtkPolyData):
        for kind in ("Verts", "Lines", "Polys", "Strips"):
            check_cells(name, getattr(data, f"Get{kind}")(), n_points)
    elif isinstance(data, vtkUnstructuredGrid):
        check_cells(name, data.GetCells(), n_points)
        if data.GetNumberOfCells():
            _check_cell_types(name, data)
    elif isinstance(data, vtkStructuredGrid | vtkRectilinearGrid):
        _check_dimensions(name, data)
    for attributes, expected in (
        (data.GetPointData(), n_points),
        (data.GetCellData(), data.GetNumberOfCells()),
    ):
        for i in range(attributes.GetNumberOfArrays()):
            array = attributes.GetAbstractArray(i)
            if array.GetNumberOfTuples() != expected:
                raise MeshFileError(
                    f"{name} is damaged: the array {text(array.GetName()) or '(unnamed)'} has "
                    f"{array.GetNumberOfTuples()} values for {expected} points or cells; export it again."
                )


def plain(cells: vtkCellArray) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Return offsets and corners of cells, after their storage was made the usual one."""
    cells.ConvertTo64BitStorage()
    return vtk_to_numpy(cells.GetOffsetsArray()), vtk_to_numpy(cells.GetConnectivityArray())


def text(name: str | bytes | None) -> str:
    """Return a name that VTK gave; where it is not UTF-8, as in old files, it is taken as Latin-1."""
    return name.decode("latin-1") if isinstance(name, bytes) else name or ""


def check_cells(name: object, cells: vtkCellArray | None, n_points: int) -> None:
    """Refuse cells that do not follow each other or name a point that is not there."""
    if cells is None or cells.GetNumberOfCells() <= 0:  # the grid, or this kind of cells, is empty
        return
    offsets, corners = plain(cells)
    if offsets[0] != 0 or offsets[-1] != len(corners) or (np.diff(offsets) < 0).any():
        raise MeshFileError(f"{name} is damaged (broken cell offsets); export it again.")
    check_indices(name, corners, n_points)


def _check_dimensions(name: object, grid: Any) -> None:
    """Refuse a grid that has not as many points, or coordinates, as its dimensions say."""
    # Not GetDimensions(), which VTK's versions and grids have with other arguments.
    extent = grid.GetExtent()
    dimensions = [last - first + 1 for first, last in zip(extent[::2], extent[1::2], strict=True)]
    total = dimensions[0] * dimensions[1] * dimensions[2]
    if isinstance(grid, vtkStructuredGrid):
        points = grid.GetPoints()
        have, need = [points.GetNumberOfPoints() if points else 0], [total]
    else:
        have = [getattr(grid, f"Get{axis}Coordinates")().GetNumberOfValues() for axis in "XYZ"]
        need = dimensions
    if (have != need and total) or min(dimensions) < 0:  # an empty grid has 0
        raise MeshFileError(f"{name} is damaged: it has {have} points and needs {need}; export it again.")


def _check_cell_types(name: object, grid: vtkUnstructuredGrid) -> None:
    """Refuse cells of unknown types, and cells with another number of points than their type has."""
    sizes = np.diff(plain(grid.GetCells())[0])
    types = vtk_to_numpy(grid.GetCellTypesArray())
    if len(types) != len(sizes):
        raise MeshFileError(
            f"{name} is damaged: {len(sizes)} cells have {len(types)} types; export it again."
        )
    for kind in np.unique(types).tolist():
        cell = vtkGenericCell.InstantiateCell(kind)
        # 0: any number, as of polygons and of the higher-order cells from 60 on.
        size = cell.GetNumberOfPoints() if cell is not None and kind < 60 else 0
        if cell is None or (size and (sizes[types == kind] != size).any()):
            raise MeshFileError(f"{name} is damaged (broken cells of type {kind}); export it again.")


def check_indices(name: object, connectivity: npt.NDArray[Any], n_points: int) -> None:
    """Refuse faces that name a point that is not there."""
    if len(connectivity) and (connectivity.min() < 0 or connectivity.max() >= n_points):
        worst = connectivity.max() if connectivity.min() >= 0 else connectivity.min()
        raise MeshFileError(
            f"{name} is damaged: a face refers to point {worst}, but the points are numbered "
            f"0 to {n_points - 1}; export it again."
        )
