"""Angle-weighted centroid: how finely the ring is cut does not matter to where it pulls."""

from __future__ import annotations

import numpy as np

from ....jit import parallel
from ....jit.compiled import kernel
from ..run_state import State
from . import Float64, Int64, Scheme
from .area_weighted import centre


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
                p = near.connectivity[first + (c - first + 1) % size]
                q = near.connectivity[first + (c - first + size - 1) % size]
                ax = points[p, 0] - x
                ay = points[p, 1] - y
                az = points[p, 2] - z
                bx = points[q, 0] - x
                by = points[q, 1] - y
                bz = points[q, 2] - z
                nx = ay * bz - az * by
                ny = az * bx - ax * bz
                nz = ax * by - ay * bx
                # Sides of no length give an angle of 0.
                weight = np.arctan2(np.sqrt(nx * nx + ny * ny + nz * nz), ax * bx + ay * by + az * bz)
                cx, cy, cz = centre(points, near.offsets, near.connectivity, f)
                total += weight
                sx += weight * (cx - x)
                sy += weight * (cy - y)
                sz += weight * (cz - z)
            if total > 0.0:
                proposed[v, 0] = x + factor * (sx / total)
                proposed[v, 1] = y + factor * (sy / total)
                proposed[v, 2] = z + factor * (sz / total)


class AngleWeighted(Scheme):
    """Mean of the centroids of the faces round a vertex, weighted by their angles at the vertex.

    The centroid of a face is the mean of its corners. Many narrow faces on one side of a vertex weigh as
    much as one wide face on the other.

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
