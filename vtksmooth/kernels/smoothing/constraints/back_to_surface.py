"""Back to the surface: every target is replaced by the closest point of the original mesh."""

from __future__ import annotations

from ..run_state import State
from . import Constraint, Float64, Int64, Phase


class BackToSurface(Constraint):
    """Keep the vertices on the original discrete surface (the "BDS" of Semenova et al., section 5.2)."""

    name = "The way back to the surface (back_to_surface)"

    phase = Phase.RETRACT
    topic = "surface"

    def dispose(self, state: State, starts: Int64, ends: Int64, proposed: Float64) -> None:
        state.surface.project(starts, ends, state.points, state.pinned, proposed)

    def check(self, state: State) -> str:
        moved = (state.points != state.original.points).any(axis=1) & (state.pinned == 0)
        farthest = state.surface.query(state.points[moved])[1].max(initial=0.0)
        return f"a vertex is off by {farthest:.3g}" if farthest > 1e-12 * state.original.diagonal else ""
