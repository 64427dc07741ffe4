"""Cotangent weights: the mesh's curvature flow, nearly free of tangential drift."""

from __future__ import annotations

import numpy as np

from ....jit import parallel
from ....jit.compiled import device, kernel
from ..run_state import State
from . import Float64, Int64, Scheme


@device
def cotangent(ax, ay, az, bx, by, bz):
    """Cotangent of the angle between a and b; 0 where one of them or the angle vanishes."""
    nx = ay * bz - az * by
    ny = az * bx - ax * bz
    nz = ax * by - ay * bx
    area = np.sqrt(nx * nx + ny * ny + nz * nz)
    if area == 0.0:
        return 0.0
    return (ax * bx + ay * by + az * bz) / area


@device
def cotangent_weights(points, near, v, weights, first):
    """Write the sums of the two cotangents opposite each spoke of v to weights[first], .., as in its star.

    A weight belongs to an edge, and an edge has an angle in each of its two faces: gather them first,
    clamp the sums after.
    """
    x = points[v, 0]
    y = points[v, 1]
    z = points[v, 2]
    s0 = near.star_offsets[v]
    size = near.star_offsets[v + 1] - s0
    for r in range(size):
        weights[first + r] = 0.0
    for i in range(near.corner_offsets[v], near.corner_offsets[v + 1]):
        c = near.corners[i]
        f = near.corner_face[c]
        a = near.offsets[f]
        b = near.offsets[f + 1]
        # The face as a fan of triangles (v, p, q) from v.
        for step in range(1, b - a - 1):
            p = near.connectivity[a + (c - a + step) % (b - a)]
            q = near.connectivity[a + (c - a + step + 1) % (b - a)]
            px = points[p, 0]
            py = points[p, 1]
            pz = points[p, 2]
            qx = points[q, 0]
            qy = points[q, 1]
            qz = points[q, 2]
            at_p = cotangent(x - px, y - py, z - pz, qx - px, qy - py, qz - pz)
            at_q = cotangent(x - qx, y - qy, z - qz, px - qx, py - qy, pz - qz)
            for r in range(size):
                w = near.star[s0 + r]
                if w == p:
                    weights[first + r] += at_q
                elif w == q:
                    weights[first + r] += at_p


@kernel
def _propose(starts, ends, points, near, pinned, factor, proposed):
    widest = 0
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            widest = max(widest, near.star_offsets[v + 1] - near.star_offsets[v])
    weight = np.empty(widest)
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
            s0 = near.star_offsets[v]
            cotangent_weights(points, near, v, weight, 0)
            sx = 0.0
            sy = 0.0
            sz = 0.0
            total = 0.0
            for r in range(near.star_offsets[v + 1] - s0):
                if weight[r] > 0.0:
                    w = near.star[s0 + r]
                    total += weight[r]
                    sx += weight[r] * (points[w, 0] - x)
                    sy += weight[r] * (points[w, 1] - y)
                    sz += weight[r] * (points[w, 2] - z)
            if total > 0.0:
                proposed[v, 0] = x + factor * (sx / total)
                proposed[v, 1] = y + factor * (sy / total)
                proposed[v, 2] = z + factor * (sz / total)


class Cotangent(Scheme):
    """Cotangent operator (Desbrun et al. 1999), negative weights clamped to 0, normalised to sum 1.

    Faces with more than three corners are taken as a fan of triangles from the vertex in question.

    Parameters
    ----------
    relaxation : float
        Part of the way to the weighted mean, (0, 1].
    """

    def __init__(self, relaxation: float = 0.5) -> None:
        self.relaxation = relaxation

    def propose(self, state: State, turn: int, starts: Int64, ends: Int64, proposed: Float64) -> None:
        parallel.run(
            _propose, starts, ends, state.points, state.near, state.pinned, self.relaxation, proposed,
            smallest_share=parallel.COSTLY,
        )  # fmt: skip
