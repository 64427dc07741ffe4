"""Damping: constraints that shorten steps by a factor for each vertex, and do nothing else."""

from __future__ import annotations

from .. import parallel
from ..compiled import kernel
from ..state import State
from . import Constraint, Float64, Int64


@kernel
def _shorten(starts, ends, points, damping, proposed):  # type: ignore[no-untyped-def]
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            for axis in range(3):
                # The ends of the range keep their bits.
                if damping[v] == 0.0:
                    proposed[v, axis] = points[v, axis]
                elif damping[v] < 1.0:
                    step = proposed[v, axis] - points[v, axis]
                    proposed[v, axis] = points[v, axis] + damping[v] * step


class Damping(Constraint):
    """Base of the constraints that damp; they set `damping` when they are bound or prepared."""

    on_edges = True

    def dispose(self, state: State, starts: Int64, ends: Int64, proposed: Float64) -> None:
        if self.damping is not None:
            parallel.run(_shorten, starts, ends, state.points, self.damping, proposed)
