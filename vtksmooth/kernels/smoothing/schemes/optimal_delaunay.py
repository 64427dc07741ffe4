"""Optimal Delaunay triangulation (ODT): area-weighted mean of the circumcentres."""

from __future__ import annotations

import numpy as np

from ....jit import parallel
from ....jit.compiled import device, kernel
from ..run_state import State
from . import Float64, Int64, Scheme


@device
def _circumcentre(ax, ay, az, bx, by, bz):
    """Circumcentre of the triangle (0, a, b), and its area.

    By barycentric weights |opposite side|^2 times the dot product of the other two at the corner. In an
    obtuse triangle one of them is negative, and the centre outside; with 0 in its stead the point is on the
    longest side, and passes through its middle where the angle is right.
    """
    aa = ax * ax + ay * ay + az * az
    bb = bx * bx + by * by + bz * bz
    ab = ax * bx + ay * by + az * bz
    at_0 = (aa + bb - 2.0 * ab) * max(0.0, ab)
    at_a = bb * max(0.0, aa - ab)
    at_b = aa * max(0.0, bb - ab)
    total = at_0 + at_a + at_b
    if total == 0.0:
        return 0.0, 0.0, 0.0, 0.0
    at_a /= total
    at_b /= total
    nx = ay * bz - az * by
    ny = az * bx - ax * bz
    nz = ax * by - ay * bx
    area = 0.5 * np.sqrt(nx * nx + ny * ny + nz * nz)
    return at_a * ax + at_b * bx, at_a * ay + at_b * by, at_a * az + at_b * bz, area


@kernel
def _propose(starts, ends, points, near, pinned, factor, proposed):
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            x = points[v, 0]
            y = points[v, 1]
            z = points[v, 2]
            proposed[v, 0] = x
            proposed[v, 1] = y
            proposed[v, 2] = z
            if pinned[v]:
                continue
            sx = 0.0
            sy = 0.0
            sz = 0.0
            total = 0.0
            for i in range(near.corner_offsets[v], near.corner_offsets[v + 1]):
                c = near.corners[i]
                f = near.corner_face[c]
                first = near.offsets[f]
                size = near.offsets[f + 1] - first
                for step in range(1, size - 1):
                    p = near.connectivity[first + (c - first + step) % size]
                    q = near.connectivity[first + (c - first + step + 1) % size]
                    cx, cy, cz, area = _circumcentre(
                        points[p, 0] - x, points[p, 1] - y, points[p, 2] - z,
                        points[q, 0] - x, points[q, 1] - y, points[q, 2] - z,
                    )  # fmt: skip
                    total += area
                    sx += area * cx
                    sy += area * cy
                    sz += area * cz
            if total > 0.0:
                proposed[v, 0] = x + factor * (sx / total)
                proposed[v, 1] = y + factor * (sy / total)
                proposed[v, 2] = z + factor * (sz / total)


class OptimalDelaunay(Scheme):
    """Mean of the circumcentres of the faces round a vertex, weighted by their areas.

    L. Chen, J. Xu, "Optimal Delaunay Triangulations" (2004); P. Alliez et al., "Variational Tetrahedral
    Meshing" (2005), section 3. The circumcentre of an obtuse triangle is moved to its longest side, so that
    every target lies in the convex hull of the star. Polygons count as fans of triangles from the vertex.

    Parameters
    ----------
    relaxation : float
        Part of the way to the mean, (0, 1].
    """

    def __init__(self, relaxation: float = 0.5) -> None:
        self.relaxation = relaxation

    def propose(self, state: State, turn: int, starts: Int64, ends: Int64, proposed: Float64) -> None:
        parallel.run(
            _propose, starts, ends, state.points, state.near, state.pinned, self.relaxation, proposed,
            smallest_share=parallel.COSTLY,
        )  # fmt: skip
