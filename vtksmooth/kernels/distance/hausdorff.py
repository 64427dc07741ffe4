"""How far a surface is from another one at most: a bound that no point exceeds, not a sample."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ...jit import parallel
from ...jit.compiled import device, kernel
from ..mesh.mesh import Mesh
from .closest_point import ClosestPoint, closest_of, query, triangles

Float64 = npt.NDArray[np.float64]

#: How far apart the bounds may be, as a part of the lower one.
_TOLERANCE = 0.05

#: How often a triangle is cut into four at most.
_DEPTH = 12


class Farthest(NamedTuple):
    """The largest distance of the points of a surface from another one.

    Attributes
    ----------
    lower : float
        The largest distance of a point that was looked at.
    upper : float
        No point is farther away.
    """

    lower: float
    upper: float


@device
def _distance(others, a, b, c, points, row):
    x, y, z, _, _ = closest_of(others, a, b, c, points[row, 0], points[row, 1], points[row, 2])
    return np.sqrt((x - points[row, 0]) ** 2 + (y - points[row, 1]) ** 2 + (z - points[row, 2]) ** 2)


@device
def _covering_radius(corners, first):
    """Return what no point of a triangle is farther from the nearest corner: the longest side / sqrt(3)."""
    longest = 0.0
    for i in range(3):
        square = 0.0
        for axis in range(3):
            square += (corners[first + i, axis] - corners[first + (i + 1) % 3, axis]) ** 2
        longest = max(longest, square)
    return np.sqrt(longest / 3.0)


@kernel
def _sample(starts, ends, points, faces, tree, lower):
    # The distance of the corner of each triangle, and of its middle, that is farthest away.
    stack = np.empty(128, np.int32)
    for part in range(starts.size):
        for f in range(starts[part], ends[part]):
            x = 0.0
            y = 0.0
            z = 0.0
            square = 0.0
            for i in range(4):
                v = faces[f, min(i, 2)]
                px = x / 3.0 if i == 3 else points[v, 0]
                py = y / 3.0 if i == 3 else points[v, 1]
                pz = z / 3.0 if i == 3 else points[v, 2]
                x += px
                y += py
                z += pz
                square = max(square, query(tree, px, py, pz, np.inf, -1.0, stack)[3])
            lower[f] = np.sqrt(square)


@kernel
def _bound(starts, ends, points, faces, tree, least, tolerance, lower, upper):
    # The distance to a triangle is convex: over a part of the surface it is largest at the corners.
    others = tree[0]
    of_others = tree[1]
    stack = np.empty(128, np.int32)
    corners = np.empty((3 * (3 * _DEPTH + 4) + 1, 3))
    depths = np.empty(3 * _DEPTH + 4, np.int64)
    for part in range(starts.size):
        for f in range(starts[part], ends[part]):
            for i in range(3):
                for axis in range(3):
                    corners[1 + i, axis] = points[faces[f, i], axis]
            depths[0] = 0
            top = 1
            upper[f] = 0.0
            while top > 0:
                top -= 1
                first = 1 + 3 * top
                # The middle, in row 0, has a nearest triangle as well, which may serve for all.
                for axis in range(3):
                    corners[0, axis] = (
                        corners[first, axis] + corners[first + 1, axis] + corners[first + 2, axis]
                    ) / 3.0
                best = np.inf
                farthest = 0.0
                for i in range(4):
                    row = 0 if i == 3 else first + i
                    _, _, _, square, t, _, _ = query(
                        tree, corners[row, 0], corners[row, 1], corners[row, 2], np.inf, -1.0, stack
                    )
                    lower[f] = max(lower[f], np.sqrt(square))
                    if i < 3:
                        farthest = max(farthest, np.sqrt(square))
                    largest = 0.0
                    for k in range(3):
                        largest = max(
                            largest,
                            _distance(
                                others, of_others[t, 0], of_others[t, 1], of_others[t, 2], corners, first + k
                            ),
                        )
                    best = min(best, largest)
                best = min(best, farthest + _covering_radius(corners, first))
                allowed = max(least, (1.0 + tolerance) * lower[f])
                if best <= allowed or depths[top] == _DEPTH:
                    upper[f] = max(upper[f], best)
                    continue
                depth = depths[top] + 1
                _cut(corners, first)
                for i in range(4):
                    depths[top + i] = depth
                top += 4


@device
def _cut(corners, first):
    """Cut the triangle in three rows into four, which take its rows and the nine after them."""
    for axis in range(3):
        a = corners[first, axis]
        b = corners[first + 1, axis]
        c = corners[first + 2, axis]
        ab = 0.5 * (a + b)
        bc = 0.5 * (b + c)
        ca = 0.5 * (c + a)
        corners[first, axis] = a
        corners[first + 1, axis] = ab
        corners[first + 2, axis] = ca
        corners[first + 3, axis] = ab
        corners[first + 4, axis] = b
        corners[first + 5, axis] = bc
        corners[first + 6, axis] = ca
        corners[first + 7, axis] = bc
        corners[first + 8, axis] = c
        corners[first + 9, axis] = ab
        corners[first + 10, axis] = bc
        corners[first + 11, axis] = ca


def farthest(mesh: Mesh, surface: ClosestPoint) -> Farthest:
    """Bound the distance of all points of a mesh, on its faces too, from a surface.

    A triangle is cut into four until a bound on its points is near the largest distance that was found: the
    largest distance of its corners from one triangle of the surface, for that distance is convex; or from the
    surface, and how far its points are from them.

    Parameters
    ----------
    mesh : Mesh
        Polygons are taken as triangles, see :func:`~vtksmooth.kernels.distance.closest_point.triangles`.
    surface : ClosestPoint

    Returns
    -------
    Farthest
        The upper bound is at most 5 % above the lower one, or 1e-12 of the mesh's diagonal, unless triangles
        would have to be cut more than 12 times.

    Notes
    -----
    The one-sided Hausdorff distance. The number of threads does not matter.

    Examples
    --------
    >>> flat = Mesh.from_faces([[0, 0, 0], [4, 0, 0], [0, 4, 0]], [[0, 1, 2]])
    >>> roof = [[0, 0, 0], [4, 0, 0], [0, 4, 0], [1, 1, 0.5]]
    >>> surface = ClosestPoint(Mesh.from_faces(roof, [[0, 1, 3], [1, 2, 3], [2, 0, 3]]))
    >>> lower, upper = farthest(flat, surface)
    >>> lower <= upper <= 1.05 * lower, 0.3 < upper < 0.5
    (True, True)
    """
    faces = triangles(mesh)
    lower, upper = np.empty(len(faces)), np.empty(len(faces))
    parts = parallel.ranges(len(faces))
    parallel.run(_sample, *parts, mesh.points, faces, surface.tree, lower, smallest_share=parallel.COSTLY)
    least = max((1.0 + _TOLERANCE) * lower.max(initial=0.0), 1e-12 * mesh.diagonal)
    parallel.run(
        _bound, *parts, mesh.points, faces, surface.tree, least, _TOLERANCE, lower, upper,
        smallest_share=parallel.COSTLY,
    )  # fmt: skip
    largest = float(lower.max(initial=0.0))
    return Farthest(largest, max(largest, float(upper.max(initial=0.0))))
