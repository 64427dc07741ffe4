"""Tangent plane: vertices move across the surface, not off it."""

from __future__ import annotations

from .. import parallel
from ..compiled import kernel
from ..state import State
from . import Constraint, Float64, Int64


@kernel
def _project(starts, ends, points, near, pinned, proposed):  # type: ignore[no-untyped-def]
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            if pinned[v]:
                continue  # 0.0 taken from -0.0 would be other bits
            nx = 0.0
            ny = 0.0
            nz = 0.0
            x = points[v, 0]
            y = points[v, 1]
            z = points[v, 2]
            for i in range(near.corner_offsets[v], near.corner_offsets[v + 1]):
                c = near.corners[i]
                f = near.corner_face[c]
                a = near.offsets[f]
                size = near.offsets[f + 1] - a
                for step in range(1, size - 1):
                    p = near.connectivity[a + (c - a + step) % size]
                    q = near.connectivity[a + (c - a + step + 1) % size]
                    ax = points[p, 0] - x
                    ay = points[p, 1] - y
                    az = points[p, 2] - z
                    bx = points[q, 0] - x
                    by = points[q, 1] - y
                    bz = points[q, 2] - z
                    nx += ay * bz - az * by
                    ny += az * bx - ax * bz
                    nz += ax * by - ay * bx
            square = nx * nx + ny * ny + nz * nz
            if square > 0.0:
                off = (
                    (proposed[v, 0] - x) * nx + (proposed[v, 1] - y) * ny + (proposed[v, 2] - z) * nz
                ) / square
                proposed[v, 0] -= off * nx
                proposed[v, 1] -= off * ny
                proposed[v, 2] -= off * nz


class TangentPlane(Constraint):
    """Take from every step its part along the vertex' area-weighted ring normal."""

    def dispose(self, state: State, starts: Int64, ends: Int64, proposed: Float64) -> None:
        parallel.run(_project, starts, ends, state.points, state.near, state.pinned, proposed)
