"""Damage that VTK's readers let pass, and that would make VTK read foreign memory later."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from vtkmodules.vtkCommonDataModel import (
    vtkCellArray,
    vtkGenericCell,
    vtkPointSet,
    vtkPolyData,
    vtkUnstructuredGrid,
)

from ..errors import MeshFileError
from ..filters.arrays import cells_of


def check(path: Path, data: Any) -> None:
    """Refuse cells that point outside the points, and short arrays: VTK would read foreign memory."""
    for attributes, expected in (
        (data.GetPointData(), data.GetNumberOfPoints()),
        (data.GetCellData(), data.GetNumberOfCells()),
    ):
        for i in range(attributes.GetNumberOfArrays()):
            array = attributes.GetAbstractArray(i)
            if array.GetNumberOfTuples() != expected:
                raise MeshFileError(
                    f"{path} is damaged: the array {array.GetName() or '(unnamed)'} has "
                    f"{array.GetNumberOfTuples()} values for {expected} points or cells; export it again."
                )
    arrays: list[vtkCellArray] = []
    if isinstance(data, vtkPolyData):
        arrays = [data.GetVerts(), data.GetLines(), data.GetPolys(), data.GetStrips()]
    elif isinstance(data, vtkUnstructuredGrid):
        arrays = [data.GetCells()]
    n_points = data.GetNumberOfPoints() if isinstance(data, vtkPointSet) else 0
    for cells in arrays:
        if cells is None:  # of an empty grid
            continue
        if not cells.IsValid():
            raise MeshFileError(f"{path} is damaged (broken cell offsets); export it again.")
        check_indices(path, cells_of(cells)[1], n_points)
    if isinstance(data, vtkUnstructuredGrid) and data.GetNumberOfCells():
        _check_cell_types(path, data)


def _check_cell_types(path: Path, grid: vtkUnstructuredGrid) -> None:
    """Refuse cells of unknown types, and cells with another number of points than their type has."""
    sizes = np.diff(cells_of(grid.GetCells())[0])
    types = np.array([grid.GetCellType(i) for i in range(grid.GetNumberOfCells())])
    for kind in np.unique(types).tolist():
        cell = vtkGenericCell.InstantiateCell(kind)
        # 0: any number, as of polygons and of the higher-order cells from 60 on.
        size = cell.GetNumberOfPoints() if cell is not None and kind < 60 else 0
        if cell is None or (size and (sizes[types == kind] != size).any()):
            raise MeshFileError(f"{path} is damaged (broken cells of type {kind}); export it again.")


def check_indices(path: Path, connectivity: npt.NDArray[Any], n_points: int) -> None:
    """Refuse faces that name a point that is not there."""
    if len(connectivity) and (connectivity.min() < 0 or connectivity.max() >= n_points):
        worst = connectivity.max() if connectivity.min() >= 0 else connectivity.min()
        raise MeshFileError(
            f"{path} is damaged: a face refers to point {worst}, but the points are numbered "
            f"0 to {n_points - 1}; export it again."
        )
