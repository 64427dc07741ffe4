"""Tangent plane: vertices move across the surface, not off it."""

from __future__ import annotations

from ....jit import parallel
from ....jit.compiled import kernel
from ...measures.aspect_ratio import ring_normal
from ..run_state import State
from . import Constraint, Float64, Int64, Phase


@kernel
def _project(starts, ends, points, near, pinned, proposed):
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            # 0.0 taken from -0.0 would be other bits. What vertices on the boundary may do is its business.
            if pinned[v] or near.kinds[v] != 0:
                continue
            nx, ny, nz = ring_normal(points, near, v)
            x = points[v, 0]
            y = points[v, 1]
            z = points[v, 2]
            square = nx * nx + ny * ny + nz * nz
            if square > 0.0:
                off = (
                    (proposed[v, 0] - x) * nx + (proposed[v, 1] - y) * ny + (proposed[v, 2] - z) * nz
                ) / square
                proposed[v, 0] -= off * nx
                proposed[v, 1] -= off * ny
                proposed[v, 2] -= off * nz


class TangentPlane(Constraint):
    """Take from every step its part along the vertex' area-weighted ring normal.

    What vertices on a boundary may do is left to
    :class:`~vtksmooth.kernels.smoothing.constraints.boundary.Boundary`.
    """

    holds_lines = True
    name = "The tangent plane (tangent_plane)"
    phase = Phase.DIRECT
    topic = "turning"

    def dispose(self, state: State, starts: Int64, ends: Int64, proposed: Float64) -> None:
        parallel.run(_project, starts, ends, state.points, state.near, state.pinned, proposed)
