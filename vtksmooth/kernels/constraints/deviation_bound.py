"""Deviation bound: no vertex farther from the original surface than a given distance."""

from __future__ import annotations

from ..state import State
from . import Constraint, Float64, Int64


class DeviationBound(Constraint):
    """Steps that would end too far from the original surface are halved three times, then refused.

    Parameters
    ----------
    distance : float
        Largest allowed distance, model units.
    """

    name = "A bound on the deviation (max_deviation_fraction)"

    convex = False

    def __init__(self, distance: float) -> None:
        self.distance = distance

    def dispose(self, state: State, starts: Int64, ends: Int64, proposed: Float64) -> None:
        state.surface.limit(starts, ends, state.points, state.pinned, self.distance, proposed)
