"""How far one mesh is from another: point by point, or from its points to the other surface."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from vtksmooth.errors import InvalidMeshError
from vtksmooth.filters.arrays import points_of
from vtksmooth.filters.signed_distance import SignedDistance
from vtksmooth.kernels.distance.closest_point import ClosestPoint
from vtksmooth.kernels.mesh.mesh import Mesh

from .state import State

Values = npt.NDArray[np.float64]

#: The shares of the points whose largest distance is told, percent.
PERCENTILES = (50, 90, 95, 99)


def difference(state: State, other: State) -> tuple[Values, Values | None, dict[str, Any]]:
    """Return how far the points of a mesh are from another mesh.

    Parameters
    ----------
    state, other : State
        With faces.

    Returns
    -------
    distances : (n,) float64
        With the same faces, from each point to the one of the same number; else to the other surface.
        Points that no face uses are NaN.
    signed : (n,) float64 or None
        Signed distances to the other surface, positive outside; None if it encloses nothing.
    summary : dict
        ``point_by_point``, and the figures of the distances: ``mean``, ``rms``, ``max`` and ``percentiles``
        by percent; of points, not of areas. ``back``: the largest distance from the other's points to this
        surface, None point by point. All lengths are model units.
    """
    assert state.surface is not None
    assert other.surface is not None
    mine, its = state.surface.mesh, other.surface.mesh
    used, its_used = (mesh.used_points for mesh in (mine, its))
    distances = np.full(state.n_points, np.nan)
    same = state.has_same_faces(other)
    back = None
    if same:
        away = points_of(state.mesh)[used].astype(np.float64) - points_of(other.mesh)[used]
        distances[used] = np.linalg.norm(away, axis=1)
    else:
        distances[used] = ClosestPoint(its).query(mine.points[used])[1]
        back = float(ClosestPoint(mine).query(its.points[its_used])[1].max())
    found = distances[used]
    summary = {
        "point_by_point": same,
        "mean": float(found.mean()),
        "rms": float(np.sqrt((found**2).mean())),
        "max": float(found.max()),
        "percentiles": dict(zip(PERCENTILES, np.percentile(found, PERCENTILES).tolist(), strict=True)),
        "back": back,
    }
    return distances, _signed(mine, used, other), summary


def _signed(mesh: Mesh, used: npt.NDArray[Any], other: State) -> Values | None:
    try:
        space = SignedDistance(other.input(), "other mesh")
    except InvalidMeshError:
        return None
    if not space.closed:
        return None
    signed = np.full(mesh.n_points, np.nan)
    signed[used] = space.tree(mesh.points[used])
    return signed
