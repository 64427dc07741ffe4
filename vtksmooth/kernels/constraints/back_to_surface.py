"""Back to the surface: every target is replaced by the closest point of the original mesh."""

from __future__ import annotations

from ..state import State
from . import Constraint, Float64, Int64


class BackToSurface(Constraint):
    """Keep the vertices on the original discrete surface (the "BDS" of Semenova et al., section 5.2)."""

    name = "The way back to the surface (back_to_surface)"

    convex = False

    def dispose(self, state: State, starts: Int64, ends: Int64, proposed: Float64) -> None:
        state.surface.project(starts, ends, state.points, state.pinned, proposed)
