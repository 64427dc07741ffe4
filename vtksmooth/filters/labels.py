"""Labels of surfaces between several labels: which cell array holds them, and what becomes of it."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import numpy.typing as npt
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkPolyData

from ..errors import InvalidMeshError, ParameterError
from ..kernels.mesh.labels import labelled
from ..kernels.mesh.mesh import Mesh
from .arrays import Surface, output_like, rows_of, vtk_cells, vtk_points
from .parameter import Parameter

Labels = npt.NDArray[np.integer[Any]]

#: The cell array of labels when it is there and no other is named: that of VTK's vtkSurfaceNets3D, or of
#: PyVista's contour_labels.
BOUNDARY_LABELS, _OF_PYVISTA = "BoundaryLabels", "boundary_labels"

BOUNDARY_LABELS_PARAMETER = Parameter(
    BOUNDARY_LABELS,
    "Cell array of the labels on the two sides of each face, normals from the first to the second (or of "
    "one label, the other is 0); absent, the surface is one between two sides.",
    optional=True, type=str,
)  # fmt: skip

_RANGE = re.compile(r"\s*(-?\d{1,19})\s*(?:-\s*(-?\d{1,19}))?\s*")


def labels_name(polydata: Any, name: str | None) -> str | None:
    """Return the name of the cell array of labels, or None where there is none.

    Parameters
    ----------
    polydata : vtkPolyData
    name : str or None
        The value of a parameter: None is none, and an array of the default's name need not be there.

    Raises
    ------
    ParameterError
        There is no array of that name.
    """
    data = polydata.GetCellData()
    if name is None or data.GetArray(name) is not None:
        return name
    if name != BOUNDARY_LABELS:
        raise ParameterError(f"labels: there is no cell array {name!r}; name one, or leave the labels out.")
    return _OF_PYVISTA if data.GetArray(_OF_PYVISTA) is not None else None


def with_labels(polydata: Any, surface: Surface, name: str | None) -> tuple[Mesh, Labels]:
    """Return the mesh of a surface with its labels, and their values; as it is, and none, without labels.

    Raises
    ------
    InvalidMeshError
        The array does not hold a label, or two, for each cell; or see
        :func:`~vtksmooth.kernels.mesh.labels.labelled`.
    """
    if name is None:
        return surface.mesh, np.empty(0, np.int64)
    values = vtk_to_numpy(polydata.GetCellData().GetArray(name))
    if len(values) != surface.n_cells or values.ndim > 2 or values.shape[1:] not in ((), (2,)):
        raise InvalidMeshError(
            f"The cell array {name!r} has the shape {values.shape}; it must hold the labels on both sides of "
            f"each of the {surface.n_cells} cells, or one label for each."
        )
    return labelled(surface.mesh, values[surface.cells])


def parse_labels(name: str, text: str, there: Labels) -> Labels:
    """Return those of the labels `there` that a text names, "1,3,5-9" or "all".

    Raises
    ------
    ParameterError
        The text is written otherwise, or names a label that is not there.

    Examples
    --------
    >>> parse_labels("labels", "1,-3--1", np.array([-2, 0, 1])).tolist()
    [-2, 1]
    """
    if text == "all":
        return there
    chosen = np.zeros(len(there), np.bool_)
    for part in text.split(","):
        match = _RANGE.fullmatch(part)
        if match is None:
            raise ParameterError(f"{name} must be 'all', or labels and ranges of them such as '1,3,5-9'.")
        low = int(match[1])
        high = low if match[2] is None else int(match[2])
        inside = (there >= low) & (there <= high)
        if not inside.any():
            known = ", ".join(map(str, there[:20].tolist())) + ("" if len(there) <= 20 else ", …")
            raise ParameterError(f"{name}: the image has no label {part.strip()}; it has {known}.")
        chosen |= inside
    return np.asarray(there[chosen])


def closed_surface(polydata: Any, corners: npt.NDArray[Any], sides: Labels, label: int) -> vtkPolyData:
    """Return the surface of one label, its normals outwards, with the points that it uses.

    Parameters
    ----------
    polydata : vtkPolyData
        Triangles between labels, whose cell arrays are taken.
    corners : (m, 3) int
        Its triangles.
    sides : (m, 2) int
        Labels of both sides; normals run from the first to the second.
    label : int
    """
    mine = np.flatnonzero((sides == label).any(axis=1))
    faces = corners[mine]
    turned = sides[mine, 1] == label
    faces[turned] = faces[turned][:, ::-1]
    used, local = np.unique(faces, return_inverse=True)
    result = output_like(polydata)
    result.SetPoints(vtk_points(vtk_to_numpy(polydata.GetPoints().GetData())[used]))
    result.SetPolys(vtk_cells(np.arange(0, 3 * len(faces) + 1, 3), local.ravel()))
    result.GetCellData().ShallowCopy(rows_of(polydata.GetCellData(), mine.astype(np.int64)))
    return result
