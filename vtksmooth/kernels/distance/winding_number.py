"""Winding numbers: how often a closed surface goes around a point, whatever its triangles look like."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ...jit import parallel
from ...jit.compiled import device, kernel, routine
from ..mesh.mesh import Mesh
from .closest_point import ClosestPoint

Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]

#: Rays run along x in a frame turned by this rotation (by the quaternion 1, 1/3, 1/5, 1/7), so that walls and
#: edges along the axes are not along them.
_A, _B, _C, _D = 1.0, 1.0 / 3.0, 1.0 / 5.0, 1.0 / 7.0
_ROTATION = np.array(
    [
        [_A * _A + _B * _B - _C * _C - _D * _D, 2 * (_B * _C - _A * _D), 2 * (_B * _D + _A * _C)],
        [2 * (_B * _C + _A * _D), _A * _A - _B * _B + _C * _C - _D * _D, 2 * (_C * _D - _A * _B)],
        [2 * (_B * _D - _A * _C), 2 * (_C * _D + _A * _B), _A * _A - _B * _B - _C * _C + _D * _D],
    ]
) / (_A * _A + _B * _B + _C * _C + _D * _D)

#: Part of the distance to the boundary by which the place to ask at is off.
_ASIDE = 0.3


@device
def _turned(x, y, z):
    return (
        _ROTATION[0, 0] * x + _ROTATION[0, 1] * y + _ROTATION[0, 2] * z,
        _ROTATION[1, 0] * x + _ROTATION[1, 1] * y + _ROTATION[1, 2] * z,
        _ROTATION[2, 0] * x + _ROTATION[2, 1] * y + _ROTATION[2, 2] * z,
    )


@routine
def winding_at(packed, x, y, z):
    """Return the winding number around (x, y, z) of the surface that a :class:`WindingNumber` has packed.

    The signed number of faces that a ray meets. Whether the ray passes a side on one side or the other is
    computed in one way for both of its faces, so between two faces nothing is missed and nothing is counted
    twice: the number is exact for points that are farther from the surface than rounding errors.
    """
    px, py, pz = _turned(x, y, z)
    nodes = int(packed[2, 2])
    total = 0
    i = 0
    while i < nodes:
        row = 3 * i
        if (
            packed[row + 1, 0] < px
            or packed[row, 1] > py or packed[row + 1, 1] < py
            or packed[row, 2] > pz or packed[row + 1, 2] < pz
        ):  # fmt: skip
            i = int(packed[row + 2, 2])
            continue
        count = int(packed[row + 2, 1])
        if count == 0:
            i += 1
            continue
        first = int(packed[row + 2, 0])
        for a in range(first, first + 3 * count, 3):
            # The winding number of the triangle's projection: sides that pass below the point.
            turns = 0
            for side in range(3):
                u = a + side
                v = a + (side + 1) % 3
                rising = packed[v, 1] > py
                if (packed[u, 1] > py) == rising:
                    continue
                low = u if rising else v
                high = v if rising else u
                over = (packed[high, 1] - packed[low, 1]) * (pz - packed[low, 2]) - (
                    packed[high, 2] - packed[low, 2]
                ) * (py - packed[low, 1])
                if over > 0.0:
                    turns += 1 if rising else -1
            if turns == 0:
                continue
            ax = packed[a + 1, 0] - packed[a, 0]
            ay = packed[a + 1, 1] - packed[a, 1]
            az = packed[a + 1, 2] - packed[a, 2]
            bx = packed[a + 2, 0] - packed[a, 0]
            by = packed[a + 2, 1] - packed[a, 1]
            bz = packed[a + 2, 2] - packed[a, 2]
            ahead = (
                (packed[a, 0] - px) * (ay * bz - az * by)
                + (packed[a, 1] - py) * (az * bx - ax * bz)
                + (packed[a, 2] - pz) * (ax * by - ay * bx)
            )
            if ahead * turns > 0.0:
                total += turns
        i = int(packed[row + 2, 2])
    return total


@device
def inside_at(packed, x, y, z, distance):
    """Return whether (x, y, z), so far from the boundary of where the number is 1 or more, is within it.

    What is asked is a place nearby: points are often on walls that bound nothing, as where solids touch, and
    there rounding tells.
    """
    step = _ASIDE * distance
    return winding_at(packed, x - 0.48 * step, y + 0.64 * step, z + 0.6 * step) > 0


@kernel
def _pack(points, faces, order, node_low, node_high, node, packed):
    # Nodes parent before children, each with the number of the node to go on with if it is missed: a way
    # through the tree that needs no stack. Children have larger numbers than their parent, side by side.
    nodes = node.shape[0]
    size = np.ones(nodes, np.int32)
    for i in range(nodes - 1, -1, -1):
        if node[i, 2] >= 0:
            size[i] += size[node[i, 2]] + size[node[i, 2] + 1]
    place = np.zeros(nodes, np.int32)
    for i in range(nodes):
        child = node[i, 2]
        if child >= 0:
            place[child] = place[i] + 1
            place[child + 1] = place[i] + 1 + size[child]
        row = 3 * place[i]
        for axis in range(3):
            packed[row, axis] = node_low[i, axis]
            packed[row + 1, axis] = node_high[i, axis]
        packed[row + 2, 0] = 3 * (nodes + node[i, 0])
        packed[row + 2, 1] = 0 if child >= 0 else node[i, 1] - node[i, 0]
        packed[row + 2, 2] = place[i] + size[i]
    for k in range(order.size):
        for corner in range(3):
            for axis in range(3):
                packed[3 * (nodes + k) + corner, axis] = points[faces[order[k], corner], axis]


@kernel
def _inside(starts, ends, packed, queries, distances, result):
    for part in range(starts.size):
        for i in range(starts[part], ends[part]):
            result[i] = inside_at(packed, queries[i, 0], queries[i, 1], queries[i, 2], distances[i])


@kernel
def _winding_numbers(starts, ends, packed, queries, result):
    for part in range(starts.size):
        for i in range(starts[part], ends[part]):
            result[i] = winding_at(packed, queries[i, 0], queries[i, 1], queries[i, 2])


class WindingNumber:
    """A closed surface that can be asked how often it goes around points.

    Inside one closed surface with normals outwards it is 1, outside 0; inside two that overlap it is 2, in a
    cavity, whose normals point into it, 0.

    Parameters
    ----------
    points : (n, 3) float64
    triangles : (t, 3) int32
        Closed: every side is used as often forth as back. Points in one place must be one point.

    Attributes
    ----------
    packed : (k, 3) float64
        What :func:`winding_at` takes: the tree's nodes, then the triangles' corners.

    Examples
    --------
    >>> import numpy as np
    >>> corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    >>> faces = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], np.int32)
    >>> WindingNumber(corners, faces)([[0.1, 0.2, 0.3], [1, 1, 1]]).tolist()
    [1, 0]
    """

    def __init__(self, points: Float64, triangles: Int32) -> None:
        turned = np.ascontiguousarray(points @ _ROTATION.T)
        turned, faces, order, node_low, node_high, node = ClosestPoint(
            Mesh.from_faces(turned, triangles)
        ).tree
        self.packed = np.empty((3 * (len(node) + len(faces)), 3))
        _pack(turned, faces, order, node_low, node_high, node, self.packed)

    def __call__(self, points: npt.ArrayLike) -> Int32:
        """Return the winding numbers (q,) of the surface around `points` (q, 3)."""
        points = np.ascontiguousarray(points, dtype=np.float64).reshape(-1, 3)
        result = np.empty(len(points), np.int32)
        parallel.run(
            _winding_numbers, *parallel.ranges(len(points)), self.packed, points, result,
            smallest_share=parallel.COSTLY,
        )  # fmt: skip
        return result

    def inside(self, points: npt.ArrayLike, distances: npt.ArrayLike) -> npt.NDArray[np.bool_]:
        """Return around which `points` (q, 3) the number is 1 or more, (q,).

        `distances` (q,), not negative, are those to the boundary of where it is.
        """
        points = np.ascontiguousarray(points, dtype=np.float64).reshape(-1, 3)
        away = np.ascontiguousarray(distances, dtype=np.float64)
        result = np.empty(len(points), np.bool_)
        parallel.run(
            _inside, *parallel.ranges(len(points)), self.packed, points, away, result,
            smallest_share=parallel.COSTLY,
        )  # fmt: skip
        return result
