"""Some faces of a mesh as a mesh of their own, to be drawn over it."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkPolyData
from vtkmodules.vtkFiltersCore import vtkPolyDataConnectivityFilter, vtkPolyDataNormals

from vtksmooth.filters.arrays import vtk_array, vtk_cells

from .state import State

Faces = npt.NDArray[np.int64]


def faces_as_mesh(state: State, faces: Faces) -> vtkPolyData:
    """Return the `faces` of a state; the points are shared."""
    mesh = vtkPolyData()
    surface = state.surface
    if surface is None or not len(faces):
        return mesh
    if surface.mesh.only_triangles:
        corners = surface.mesh.connectivity.reshape(-1, 3)[faces].ravel()
        starts = np.arange(0, 3 * len(faces) + 1, 3)
    else:
        offsets = surface.mesh.offsets.astype(np.int64)
        sizes = offsets[faces + 1] - offsets[faces]
        starts = np.concatenate(([0], np.cumsum(sizes)))
        inside = np.arange(starts[-1]) - np.repeat(starts[:-1], sizes)
        corners = surface.mesh.connectivity[np.repeat(offsets[faces], sizes) + inside]
    mesh.SetPoints(state.mesh.GetPoints())
    mesh.SetPolys(vtk_cells(starts, corners))
    return mesh


def points_of_faces(state: State, faces: Faces) -> npt.NDArray[np.int64]:
    """Return the numbers of the corners of `faces`, each once."""
    assert state.surface is not None
    mesh = state.surface.mesh
    chosen = np.zeros(mesh.n_faces, np.bool_)
    chosen[faces] = True
    return np.flatnonzero(np.bincount(mesh.connectivity[np.repeat(chosen, mesh.face_sizes)]))


def patch(state: State, face: int, angle: float) -> npt.NDArray[np.int64]:
    """Return the points of the faces that are connected to `face` without an edge sharper than `angle`.

    `angle` is the largest dihedral angle, degrees. VTK does it: it doubles the points at sharp edges, and
    follows what is connected then.
    """
    assert state.surface is not None
    mesh, faces = state.surface.mesh, vtkPolyData()
    faces.SetPoints(state.mesh.GetPoints())
    faces.SetPolys(vtk_cells(mesh.offsets, mesh.connectivity))
    faces.GetPointData().AddArray(vtk_array(np.arange(mesh.n_points, dtype=np.int64), "number"))
    split, connected = vtkPolyDataNormals(), vtkPolyDataConnectivityFilter()
    split.SetInputData(faces)
    split.SetFeatureAngle(angle)
    split.SplittingOn()
    split.ConsistencyOff()
    connected.SetInputConnection(split.GetOutputPort())
    connected.SetExtractionModeToCellSeededRegions()
    connected.AddSeed(face)
    connected.Update()
    found = connected.GetOutput()
    numbers = vtk_to_numpy(found.GetPointData().GetArray("number"))
    # The filter keeps all points.
    used = vtk_to_numpy(found.GetPolys().GetConnectivityArray())
    return np.flatnonzero(np.bincount(numbers[used]))


def face_points(state: State, face: int) -> npt.NDArray[Any]:
    """Return the corners of a face, (corners, 3)."""
    assert state.surface is not None
    mesh = state.surface.mesh
    corners: npt.NDArray[Any] = mesh.points[mesh.connectivity[mesh.offsets[face] : mesh.offsets[face + 1]]]
    return corners
