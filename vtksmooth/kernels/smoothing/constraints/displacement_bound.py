"""Displacement bound: no vertex farther from where it was than its own distance."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ....jit import parallel
from ....jit.compiled import kernel
from ..run_state import State
from . import Constraint, Float64, Int64

#: Squares of distances that agree to this part of them are equal.
_ROUNDING = 1e-14


@kernel
def _limit(starts, ends, points, first, distances, pinned, proposed):
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            if pinned[v]:
                continue
            # From p, which is inside, along s: |p + t s - first| = distance, a quadratic in t.
            a = 0.0
            b = 0.0
            c = 0.0
            beyond = 0.0
            for axis in range(3):
                off = points[v, axis] - first[v, axis]
                step = proposed[v, axis] - points[v, axis]
                a += step * step
                b += step * off
                c += off * off
                beyond += (off + step) ** 2
            square = distances[v] * distances[v]
            # What ends on the sphere but for rounding stays there: looked at again, it is the same step.
            if a == 0.0 or not beyond > square * (1.0 + _ROUNDING):
                continue
            c = min(c - square, 0.0)  # rounding may have put p outside
            part_of_step = (np.sqrt(b * b - a * c) - b) / a
            for axis in range(3):
                proposed[v, axis] = points[v, axis] + part_of_step * (proposed[v, axis] - points[v, axis])


class DisplacementBound(Constraint):
    """Steps that would leave the sphere round a vertex' first place end on it.

    Parameters
    ----------
    distances : (n,) array_like
        Radius of each vertex' sphere, model units, in the order of the points that smoothing is given;
        vertices with 0 stay, bit for bit.
    """

    name = "A bound on displacements (max_displacement)"

    def __init__(self, distances: npt.ArrayLike) -> None:
        self.distances = np.ascontiguousarray(distances, np.float64)

    def bind(self, state: State) -> None:
        state.one_each("max_displacement", self.distances)
        self._distances = np.ascontiguousarray(state.in_order(self.distances))
        state.pinned[self._distances == 0.0] = 1

    def dispose(self, state: State, starts: Int64, ends: Int64, proposed: Float64) -> None:
        parallel.run(
            _limit, starts, ends, state.points, state.original.points, self._distances, state.pinned,
            proposed,
        )  # fmt: skip

    def check(self, state: State) -> str:
        excess = np.linalg.norm(state.points - state.original.points, axis=1) - self._distances
        beyond = excess > 1e-9 * self._distances + 1e-15 * state.original.diagonal
        return f"{int(beyond.sum())} vertices went too far" if beyond.any() else ""
