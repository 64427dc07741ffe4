"""Some faces of a mesh as a mesh of their own, to be drawn over it."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from vtkmodules.util.numpy_support import numpy_to_vtkIdTypeArray
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData

from .state import State

Faces = npt.NDArray[np.int64]


def faces_as_mesh(state: State, faces: Faces) -> vtkPolyData:
    """Return the `faces` of a state; the points are shared."""
    mesh = vtkPolyData()
    surface = state.surface
    if surface is None or not len(faces):
        return mesh
    offsets = surface.mesh.offsets.astype(np.int64)
    sizes = offsets[faces + 1] - offsets[faces]
    starts = np.concatenate(([0], np.cumsum(sizes)))
    inside = np.arange(starts[-1]) - np.repeat(starts[:-1], sizes)
    corners = surface.mesh.connectivity[np.repeat(offsets[faces], sizes) + inside].astype(np.int64)
    cells = vtkCellArray()
    cells.SetData(numpy_to_vtkIdTypeArray(starts, deep=1), numpy_to_vtkIdTypeArray(corners, deep=1))
    mesh.SetPoints(state.mesh.GetPoints())
    mesh.SetPolys(cells)
    return mesh


def face_points(state: State, face: int) -> npt.NDArray[Any]:
    """Return the corners of a face, (corners, 3)."""
    assert state.surface is not None
    mesh = state.surface.mesh
    corners: npt.NDArray[Any] = mesh.points[mesh.connectivity[mesh.offsets[face] : mesh.offsets[face + 1]]]
    return corners
