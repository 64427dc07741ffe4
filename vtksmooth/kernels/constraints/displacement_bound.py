"""Displacement bound: no vertex farther from where it was than its own distance."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from .. import parallel
from ..compiled import kernel
from ..state import State
from . import Constraint, Float64, Int64
from .back_to_surface import BackToSurface


@kernel
def _limit(starts, ends, points, first, distances, shorten, pinned, proposed):  # type: ignore[no-untyped-def]
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
            if not beyond > square:
                continue
            c = min(c - square, 0.0)  # rounding may have put p outside
            part_of_step = (np.sqrt(b * b - a * c) - b) / a if shorten else 0.0
            for axis in range(3):
                proposed[v, axis] = points[v, axis] + part_of_step * (proposed[v, axis] - points[v, axis])


class DisplacementBound(Constraint):
    """Steps that would leave the sphere round a vertex' first place end on it.

    Behind :class:`~vtksmooth.kernels.constraints.back_to_surface.BackToSurface` they are refused: a part
    of a step along the surface would end off it.

    Parameters
    ----------
    distances : (n,) array_like
        Radius of each vertex' sphere, model units, in the numbering of `State.points`; vertices with 0
        stay, bit for bit.
    """

    name = "A bound on displacements (max_displacement)"

    def __init__(self, distances: npt.ArrayLike) -> None:
        self.distances = np.ascontiguousarray(distances, np.float64)

    def follow(self, before: Sequence[Constraint]) -> None:
        self.convex = not any(isinstance(constraint, BackToSurface) for constraint in before)

    def bind(self, state: State) -> None:
        state.pinned[self.distances == 0.0] = 1

    def dispose(self, state: State, starts: Int64, ends: Int64, proposed: Float64) -> None:
        parallel.run(
            _limit, starts, ends, state.points, state.original.points, self.distances, self.convex,
            state.pinned, proposed,
        )  # fmt: skip
