"""Measures of a mesh before and after."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import InvalidMeshError
from ..filters import Filter, SurfaceComparison, SurfaceQuality
from ..filters.arrays import Surface, surface_of
from ..filters.surface_comparison import deviation_figures
from ..filters.surface_quality import ASPECT_RATIO
from ..kernels.distance.closest_point import ClosestPoint


@dataclass(frozen=True)
class BeforeAfter:
    """Two meshes and their measures.

    Attributes
    ----------
    meshes : tuple of vtkPolyData
        Before and after, with the cell array ``AspectRatio`` and, with the same faces, the point arrays
        of :class:`~vtksmooth.SurfaceComparison`.
    summaries : tuple of dict
        The figures of ``vtksmooth quality`` before and of ``vtksmooth compare`` after.
    same_faces : bool
        Whether the meshes have the same points and faces. If not, normals and dihedral angles cannot be
        compared and their figures are None; deviations are those of the surfaces all the same.
    """

    meshes: tuple[Any, Any]
    summaries: tuple[dict[str, Any], dict[str, Any]]
    same_faces: bool

    @property
    def aspect_ratios(self) -> tuple[np.ndarray, np.ndarray]:
        """K of the faces before and after."""
        before, after = (_face_values(mesh) for mesh in self.meshes)
        return before, after


def _face_values(mesh: Any) -> np.ndarray:
    surface = surface_of(mesh)
    values = np.asarray(mesh.GetCellData().GetArray(ASPECT_RATIO))
    return values[surface.cells][surface.mesh.face_sizes >= 3]


def measure(original: Any, result: Any, apply: Callable[..., Any] = Filter.__call__) -> BeforeAfter:
    """Measure `result` against `original`.

    Parameters
    ----------
    original, result : vtkPolyData
    apply : callable
        Called with each filter and its inputs, to run it.

    Examples
    --------
    >>> import pyvista as pv
    >>> sphere = pv.Sphere()
    >>> measure(sphere, sphere.vtksmooth.laplacian_smoothing()).summaries[1]["volume_change_percent"] < 0
    True
    >>> measure(sphere, sphere.decimate(0.5)).same_faces
    False
    """
    before = SurfaceQuality(usual_measures=False)
    apply(before, original)
    try:
        after: Any = SurfaceComparison()
        apply(after, result, original)
        same_faces, figures = True, after.summary
    except InvalidMeshError:
        after = SurfaceQuality(usual_measures=False)
        apply(after, result)
        same_faces, figures = (
            False,
            after.summary | _distances(before.summary, after.summary, original, result),
        )
    return BeforeAfter((before.GetOutput(), after.GetOutput()), (before.summary, figures), same_faces)


def _distances(before: dict[str, Any], after: dict[str, Any], original: Any, result: Any) -> dict[str, Any]:
    """Return what :class:`SurfaceComparison` says of meshes with other faces too."""
    a, b = surface_of(original), surface_of(result)
    closed = before["closed"] and after["closed"] and before["volume"]
    change = 100.0 * (after["volume"] - before["volume"]) / abs(before["volume"]) if closed else None
    return {
        "normal_deviation": {"max": None, "mean": None},
        "dihedral_change": {"max": None, "mean": None},
        "volume_change_percent": change,
        "deviation": deviation_figures(_distance(b, a), _distance(a, b), a.mesh.diagonal),
    }


def _distance(of: Surface, to: Surface) -> np.ndarray:
    """Return how far the points that faces of one surface use are from the other."""
    points = of.mesh.points[of.mesh.used_points]
    distance: np.ndarray = ClosestPoint(to.mesh).query(points)[1]
    return distance
