"""The usual measures of triangles and quadrilaterals, by VTK's Verdict."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkPolyData

from ..kernels.mesh.mesh import Mesh
from .arrays import vtk_cells, vtk_points

Float64 = npt.NDArray[np.float64]


class UsualMeasure(NamedTuple):
    """A measure: its name in VTK, the key of its summary, and which of its values are bad."""

    verdict: str
    key: str
    low_is_bad: bool


#: The measures by the names of their arrays.
USUAL_MEASURES = {
    "MinAngle": UsualMeasure("MinAngle", "min_angle", True),
    "MaxAngle": UsualMeasure("MaxAngle", "max_angle", False),
    "EdgeRatio": UsualMeasure("EdgeRatio", "edge_ratio", False),
    "RadiusRatio": UsualMeasure("RadiusRatio", "radius_ratio", False),
    "Skewness": UsualMeasure("EquiangleSkew", "skewness", False),
    "ScaledJacobian": UsualMeasure("ScaledJacobian", "scaled_jacobian", True),
}

#: Verdict's infinity.
_INFINITE = 1e30


def usual_measure(mesh: Mesh, name: str) -> Float64:
    """Return a measure of each face, (m,), by its name in ``USUAL_MEASURES``.

    NaN for faces with more than four corners, or less than three; infinite where Verdict says so, as of faces
    without an area.

    Examples
    --------
    >>> right = Mesh.from_faces([[0, 0, 0], [3, 0, 0], [0, 4, 0]], [[0, 1, 2]])
    >>> [round(float(usual_measure(right, name)[0]), 3) for name in ("MaxAngle", "RadiusRatio")]
    [90.0, 1.25]
    """
    # Late: the module takes time to load, and few runs need it.
    from vtkmodules.vtkFiltersVerdict import vtkMeshQuality

    known = (mesh.face_sizes == 3) | (mesh.face_sizes == 4)
    values = np.full(mesh.n_faces, np.nan)
    if not known.any():
        return values
    quality: Any = vtkMeshQuality()
    for kind in ("Triangle", "Quad"):
        getattr(quality, f"Set{kind}QualityMeasureTo{USUAL_MEASURES[name].verdict}")()
    polydata = vtkPolyData()
    # Verdict's thresholds are absolute. All measures are ratios, and powers of two change no bit.
    exponent = int(np.frexp(mesh.diagonal)[1]) if np.isfinite(mesh.diagonal) else 0
    polydata.SetPoints(vtk_points(np.ldexp(mesh.points, -exponent)))
    polydata.SetPolys(vtk_cells(mesh.offsets, mesh.connectivity))
    quality.SetInputData(polydata)
    quality.Update()
    measured = vtk_to_numpy(quality.GetOutput().GetCellData().GetArray("Quality"))
    values[known] = measured[known]
    values[values >= _INFINITE] = np.inf
    return values


def summary_of_measure(values: Float64) -> dict[str, float | None]:
    """Return the least, the mean and the greatest finite value of faces; None where there is none."""
    there = values[np.isfinite(values)]
    if not len(there):
        return dict.fromkeys(("min", "mean", "max"))
    return {"min": float(there.min()), "mean": float(there.mean()), "max": float(there.max())}
