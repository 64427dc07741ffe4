"""Null space: vertices move across the surface and along its ridges, not off them (Jiao, section 2)."""

from __future__ import annotations

import numpy as np

from ....jit import parallel
from ....jit.compiled import device, kernel
from ....jit.simd import WIDTH, load, store
from ....report import RunReport
from ...features.detection import CORNER, CUSP
from ...features.metric_tensor import WEIGHTS, eigen, first_eigenvector, metric_tensor
from ...measures.dihedral import face_normals
from ..run_state import State
from . import Constraint, Float64, Int64, Phase, moved

#: Of the primary space only eigenvectors count whose eigenvalue is at least this part of the largest (3.1).
_SMALLEST_RATIO = 0.003

#: A direction that leans away from the faces by more than this (mean cosine to their normals) says nothing
#: about the volume: at cusps corrections along it would be unstable (3.2).
_SMALLEST_COSINE = 0.05


#: Vertices whose metric tensors are gathered before they are analysed, four at a time.
_TILE = 64


@device
def _first_eigenvectors(tensors, size, axes):
    # Of the first `size` tensors of a tile, four at a time; the last row may hold others' remains.
    stride = _TILE // WIDTH
    for row in range((size + WIDTH - 1) // WIDTH):
        x, y, z = first_eigenvector(
            load(tensors, row), load(tensors, stride + row), load(tensors, 2 * stride + row),
            load(tensors, 3 * stride + row), load(tensors, 4 * stride + row), load(tensors, 5 * stride + row),
        )  # fmt: skip
        store(axes, row, x)
        store(axes, stride + row, y)
        store(axes, 2 * stride + row, z)


@device
def _direction(k, l1, l2, l3, x1, y1, z1, x2, y2, z2, x3, y3, z3, b0, b1, b2):
    # (7): the primary space's part of the point that lies one unit before all faces, made unit.
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
    return dx / length, dy / length, dz / length


@device
def _project(v, k, points, ridge_ring, slide, x1, y1, z1, x3, y3, z3, proposed):
    # (1): t = T T^T c
    x = points[v, 0]
    y = points[v, 1]
    z = points[v, 2]
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
        # Half the way to their middle at most: the whole way would swing when all move at once.
        if p >= 0 and q >= 0:
            cx = 0.5 * slide * ((points[p, 0] - x) + (points[q, 0] - x))
            cy = 0.5 * slide * ((points[p, 1] - y) + (points[q, 1] - y))
            cz = 0.5 * slide * ((points[p, 2] - z) + (points[q, 2] - z))
        along = cx * x3 + cy * y3 + cz * z3
        cx = along * x3
        cy = along * y3
        cz = along * z3
    proposed[v, 0] = x + cx
    proposed[v, 1] = y + cy
    proposed[v, 2] = z + cz


@kernel
def frame(
    starts, ends, points, near, normals, weight, pinned, classes, ridge_ring, limits, project, slide,
    proposed, direction,
):  # fmt: skip
    """Write the direction d of each vertex, zero where it has none, and `project` steps on the null space.

    `normals`: those of the faces, (m, 4); empty where vertices move one by one. `weight`: 0 area, 1 angle.
    Without `classes` (size 0) the eigenvalues' ratios decide, against `limits`: ridges, corners.
    """
    tensors = np.zeros((9, _TILE))
    axes = np.zeros((3, _TILE))
    rows_of_tensors = tensors.reshape(-1, WIDTH)
    rows_of_axes = axes.reshape(-1, WIDTH)
    for part in range(starts.size):
        for first in range(starts[part], ends[part], _TILE):
            size = min(_TILE, ends[part] - first)
            for i in range(size):
                v = first + i
                # What vertices on the boundary may do is the boundary's business.
                if not pinned[v] and near.kinds[v] == 0:
                    tensor = metric_tensor(points, near, normals, v, weight)
                    for entry in range(9):
                        tensors[entry, i] = tensor[entry]
            if classes.size > 0:
                _first_eigenvectors(rows_of_tensors, size, rows_of_axes)
            for i in range(size):
                v = first + i
                direction[v, 0] = 0.0
                direction[v, 1] = 0.0
                direction[v, 2] = 0.0
                if pinned[v] or near.kinds[v] != 0:
                    continue
                b0 = tensors[6, i]
                b1 = tensors[7, i]
                b2 = tensors[8, i]
                trace = tensors[0, i] + tensors[3, i] + tensors[5, i]
                k = 0
                if classes.size > 0:
                    k = 0 if classes[v] == CUSP else 1 + classes[v]
                x1 = axes[0, i]
                y1 = axes[1, i]
                z1 = axes[2, i]
                along = x1 * b0 + y1 * b1 + z1 * b2
                if k == 1 and abs(along) > 0.0:
                    # Of smooth vertices the sum (7) has one term.
                    side = 1.0 if along > 0.0 else -1.0
                    dx = side * x1
                    dy = side * y1
                    dz = side * z1
                    x3 = y3 = z3 = 0.0
                else:
                    l1, l2, l3, x1, y1, z1, x2, y2, z2, x3, y3, z3 = eigen(
                        tensors[0, i], tensors[1, i], tensors[2, i],
                        tensors[3, i], tensors[4, i], tensors[5, i],
                    )  # fmt: skip
                    if classes.size == 0:
                        k = 3 if l3 >= limits[1] * l1 else 2 if l2 >= limits[0] * l1 else 1
                    if l1 <= 0.0 or k == 0:
                        if project:
                            for axis in range(3):
                                proposed[v, axis] = points[v, axis]
                        continue
                    dx, dy, dz = _direction(k, l1, l2, l3, x1, y1, z1, x2, y2, z2, x3, y3, z3, b0, b1, b2)
                # The trace is the sum of the weights, b.d that of the weighted cosines.
                if dx * b0 + dy * b1 + dz * b2 > _SMALLEST_COSINE * trace:
                    direction[v, 0] = dx
                    direction[v, 1] = dy
                    direction[v, 2] = dz
                if not project:
                    continue
                _project(v, k, points, ridge_ring, slide, x1, y1, z1, x3, y3, z3, proposed)


#: Stand-ins where the eigenvalues' ratios are to decide.
_NO_CLASSES, _NO_RINGS = np.empty(0, np.uint8), np.empty((0, 2), np.int32)

#: Ratios of eigenvalues from which on a vertex counts as ridge (20 degrees) and as corner (35); 2.6.
_LIMITS = (float(np.tan(np.radians(10.0)) ** 2), float(2.0 * np.tan(np.radians(17.5)) ** 2))


class NullSpace(Constraint):
    """Keep of every step what lies in the vertex' null space; Jiao, section 2.1.

    Smooth vertices move in their tangent plane. Ridge vertices move along the ridge, half way to the middle
    between their two neighbours on it: the mean of all neighbours would pull unevenly. Corners and cusps
    stay, for the volume too: their neighbours give back what they would have to. Classes are those of the
    run's start; eigenvectors are those of the mesh as it is.

    What vertices on a boundary may do is left to
    :class:`~vtksmooth.kernels.smoothing.constraints.boundary.Boundary`.

    Parameters
    ----------
    weight : {"area", "angle"}
        What weighs a face at a vertex. Angles where sizes of faces vary much round vertices.
    """

    holds_lines = True
    name = "The null space (null_space)"
    phase = Phase.DIRECT
    topic = "turning"

    def __init__(self, weight: str = "area") -> None:
        self._weight = WEIGHTS.index(weight)
        #: Direction d of each vertex (3.1), as the last pass found it; zero where there is none.
        self.direction: Float64 = np.empty((0, 3))

    def bind(self, state: State) -> None:
        self.direction = state.direction = np.empty_like(state.points)
        state.tensor_weight = self._weight
        self._normals = normals_for(state)
        self._counts = state.features.counts()
        state.pinned[state.features.classes >= CORNER] = 1

    def dispose(self, state: State, starts: Int64, ends: Int64, proposed: Float64) -> None:
        if len(self._normals):
            face_normals(state.mesh, self._normals)
        parallel.run(
            frame, starts, ends, state.points, state.near, self._normals, state.tensor_weight, state.pinned,
            state.features.classes, state.features.ridge_ring, _LIMITS, True, state.slide, proposed,
            self.direction,
            smallest_share=parallel.COSTLY,
        )  # fmt: skip

    def tell(self, report: RunReport) -> None:
        report.vertex_classes = self._counts

    def check(self, state: State) -> str:
        return moved(state, state.features.classes >= CORNER)


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
        frame, starts, ends, state.points, state.near, normals, state.tensor_weight, state.pinned,
        _NO_CLASSES, _NO_RINGS, _LIMITS, False, 0.0, direction, direction,
        smallest_share=parallel.COSTLY,
    )  # fmt: skip
