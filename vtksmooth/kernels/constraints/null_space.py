"""Null space: vertices move across the surface and along its ridges, not off them (Jiao, section 2)."""

from __future__ import annotations

import numpy as np

from .. import parallel
from ..adjacency import BORDER
from ..compiled import kernel
from ..dihedral import face_normals
from ..features import CORNER, CUSP
from ..metric_tensor import eigen, first_eigenvector, metric_tensor
from ..state import State
from . import Constraint, Float64, Int64

#: Of the primary space only eigenvectors count whose eigenvalue is at least this part of the largest (3.1).
_SMALLEST_RATIO = 0.003

#: A direction that leans away from the faces by more than this (mean cosine to their normals) says nothing
#: about the volume: at cusps corrections along it would be unstable (3.2).
_SMALLEST_COSINE = 0.05


@kernel
def frame(  # type: ignore[no-untyped-def]
    starts, ends, points, near, normals, pinned, classes, ridge_ring, limits, project, proposed, direction
):
    """Write the direction d of each vertex, zero where it has none, and `project` steps on the null space.

    `normals`: those of the faces, (m, 4); empty where vertices move one by one.
    Without `classes` (size 0) the eigenvalues' ratios decide, against `limits`: ridges, corners.
    """
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            direction[v, 0] = 0.0
            direction[v, 1] = 0.0
            direction[v, 2] = 0.0
            # What vertices on the boundary may do is the boundary's business.
            if pinned[v] or near.border[v] != 0:
                continue
            x = points[v, 0]
            y = points[v, 1]
            z = points[v, 2]
            a00, a01, a02, a11, a12, a22, b0, b1, b2 = metric_tensor(points, near, normals, v, 0)
            k = 0
            if classes.size > 0:
                k = 0 if classes[v] == CUSP else 1 + classes[v]
            if k == 1:
                l1, x1, y1, z1 = first_eigenvector(a00, a01, a02, a11, a12, a22)
                l2 = l3 = x2 = y2 = z2 = x3 = y3 = z3 = 0.0
            else:
                l1, l2, l3, x1, y1, z1, x2, y2, z2, x3, y3, z3 = eigen(a00, a01, a02, a11, a12, a22)
            if classes.size == 0:
                k = 3 if l3 >= limits[1] * l1 else 2 if l2 >= limits[0] * l1 else 1
            if l1 <= 0.0 or k == 0:
                if project:
                    proposed[v, 0] = x
                    proposed[v, 1] = y
                    proposed[v, 2] = z
                continue
            # (7): the primary space's part of the point that lies one unit before all faces.
            share = (x1 * b0 + y1 * b1 + z1 * b2) / l1
            dx = share * x1
            dy = share * y1
            dz = share * z1
            if k >= 2 and l2 > _SMALLEST_RATIO * l1:
                share = (x2 * b0 + y2 * b1 + z2 * b2) / l2
                dx += share * x2
                dy += share * y2
                dz += share * z2
            if k >= 3 and l3 > _SMALLEST_RATIO * l1:
                share = (x3 * b0 + y3 * b1 + z3 * b2) / l3
                dx += share * x3
                dy += share * y3
                dz += share * z3
            length = np.sqrt(dx * dx + dy * dy + dz * dz)
            # The trace is the sum of the weights, b.d that of the weighted cosines.
            if dx * b0 + dy * b1 + dz * b2 > _SMALLEST_COSINE * (a00 + a11 + a22) * length:
                direction[v, 0] = dx / length
                direction[v, 1] = dy / length
                direction[v, 2] = dz / length
            if not project:
                continue
            # (1): t = T T^T c
            cx = 0.0
            cy = 0.0
            cz = 0.0
            if k < 3:
                cx = proposed[v, 0] - x
                cy = proposed[v, 1] - y
                cz = proposed[v, 2] - z
            if k == 1:
                off = cx * x1 + cy * y1 + cz * z1
                cx -= off * x1
                cy -= off * y1
                cz -= off * z1
            elif k == 2:
                p = ridge_ring[v, 0]
                q = ridge_ring[v, 1]
                # Half the way to their middle: the whole way would swing when all move at once.
                if p >= 0 and q >= 0:
                    cx = 0.25 * ((points[p, 0] - x) + (points[q, 0] - x))
                    cy = 0.25 * ((points[p, 1] - y) + (points[q, 1] - y))
                    cz = 0.25 * ((points[p, 2] - z) + (points[q, 2] - z))
                along = cx * x3 + cy * y3 + cz * z3
                cx = along * x3
                cy = along * y3
                cz = along * z3
            proposed[v, 0] = x + cx
            proposed[v, 1] = y + cy
            proposed[v, 2] = z + cz


#: Stand-ins where the eigenvalues' ratios are to decide.
_NO_CLASSES, _NO_RINGS = np.empty(0, np.uint8), np.empty((0, 2), np.int32)

#: Ratios of eigenvalues from which on a vertex counts as ridge (20 degrees) and as corner (35); 2.6.
_LIMITS = (float(np.tan(np.radians(10.0)) ** 2), float(2.0 * np.tan(np.radians(17.5)) ** 2))


class NullSpace(Constraint):
    """Keep of every step what lies in the vertex' null space; Jiao, section 2.1.

    Smooth vertices move in their tangent plane. Ridge vertices move along the ridge, half way to the middle
    between their two neighbours on it: the mean of all neighbours would pull unevenly. Corners and cusps
    stay. Classes are those of the run's start; eigenvectors are those of the mesh as it is.

    What vertices on a boundary may do is left to
    :class:`~vtksmooth.kernels.constraints.boundary.Boundary`, except that corners on it stay.
    """

    def __init__(self) -> None:
        #: Direction d of each vertex (3.1), as the last pass found it; zero where there is none.
        self.direction: Float64 = np.empty((0, 3))

    def bind(self, state: State) -> None:
        self.direction = np.empty_like(state.points)
        self._normals = normals_for(state)
        state.pinned[(state.near.border == BORDER) & (state.features.classes >= CORNER)] = 1

    def dispose(self, state: State, starts: Int64, ends: Int64, proposed: Float64) -> None:
        if len(self._normals):
            face_normals(state.mesh, self._normals)
        parallel.run(
            frame, starts, ends, state.points, state.near, self._normals, state.pinned,
            state.features.classes, state.features.ridge_ring, _LIMITS, True, proposed, self.direction,
        )  # fmt: skip


def normals_for(state: State) -> Float64:
    """Return room for the faces' normals, (m, 4), where all vertices move at once; otherwise nothing."""
    return np.empty((0 if state.in_place else state.topology.n_faces, 4))


def directions(state: State, starts: Int64, ends: Int64, normals: Float64, direction: Float64) -> None:
    """Write the direction d of each vertex, its class by the ratios of the eigenvalues alone.

    `normals`: what :func:`normals_for` returned.
    """
    if len(normals):
        face_normals(state.mesh, normals)
    parallel.run(
        frame, starts, ends, state.points, state.near, normals, state.pinned,
        _NO_CLASSES, _NO_RINGS, _LIMITS, False, direction, direction,
    )  # fmt: skip
