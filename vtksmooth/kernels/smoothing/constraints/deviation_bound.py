"""Deviation bound: no vertex farther from the original surface than a given distance."""

from __future__ import annotations

import numpy as np

from ..run_state import State
from . import Constraint, Float64, Int64


class DeviationBound(Constraint):
    """Steps that would end too far from the original surface are halved three times, then refused.

    Parameters
    ----------
    distance : float
        Largest allowed distance, model units.
    """

    name = "A bound on the deviation (max_deviation_fraction)"

    def __init__(self, distance: float) -> None:
        self.distance = distance

    def dispose(self, state: State, starts: Int64, ends: Int64, proposed: Float64) -> None:
        state.surface.limit(starts, ends, state.points, state.pinned, self.distance, proposed)

    def check(self, state: State) -> str:
        used = np.diff(state.near.corner_offsets) > 0
        farthest = state.surface.query(state.points[used])[1].max(initial=0.0)
        allowed = self.distance * (1.0 + 1e-9) + 1e-15 * state.original.diagonal
        return f"a vertex deviates by {farthest:.3g}" if farthest > allowed else ""
