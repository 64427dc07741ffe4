"""Boundary: fixed, or sliding along itself."""

from __future__ import annotations

import numpy as np

from .. import parallel
from ..adjacency import BORDER, IRREGULAR
from ..compiled import kernel
from ..state import State
from . import Constraint, Float64, Int64


@kernel
def slide(starts, ends, points, kind, ring, pinned, proposed):  # type: ignore[no-untyped-def]
    """Trapezium Drawing in one dimension, half way, for vertices of kind 1 between their two neighbours."""
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            if kind[v] != 1 or pinned[v]:
                continue
            a = ring[v, 0]
            b = ring[v, 1]
            chord = 0.0
            along = 0.0
            for axis in range(3):
                w = points[b, axis] - points[a, axis]
                chord += w * w
                along += (0.5 * (points[a, axis] + points[b, axis]) - points[v, axis]) * w
            for axis in range(3):
                proposed[v, axis] = points[v, axis]
                if chord > 0.0:
                    proposed[v, axis] += 0.5 * along / chord * (points[b, axis] - points[a, axis])


class Boundary(Constraint):
    """What the vertices on the boundary may do.

    Irregular vertices (non-manifold edges, orientations that disagree) are pinned either way: there a
    surface has no inside of the boundary to slide along.

    Parameters
    ----------
    sliding : bool
        If true, a boundary vertex moves parallel to the line through its two boundary neighbours, half
        way to where it is equally far from both (Trapezium Drawing in one dimension; the whole way would
        swing when all move at once). Straight boundaries stay straight. If false, it does not move.
    corner_angle : float
        When sliding, boundary vertices where the boundary turns by more than this stay, degrees.
    """

    def __init__(self, sliding: bool = False, corner_angle: float = 30.0) -> None:
        self.sliding = sliding
        self.corner_angle = corner_angle
        self.on_edges = not sliding
        self.name = "A sliding boundary (boundary)" if sliding else "A fixed boundary"

    def bind(self, state: State) -> None:
        border = state.near.border
        state.pinned[border == IRREGULAR] = 1
        on_border = np.flatnonzero(border == BORDER)
        if not self.sliding:
            state.pinned[on_border] = 1
            return
        ring = state.near.border_ring[on_border]
        before = state.points[on_border] - state.points[ring[:, 0]]
        after = state.points[ring[:, 1]] - state.points[on_border]
        turn = np.degrees(
            np.arctan2(np.linalg.norm(np.cross(before, after), axis=1), (before * after).sum(axis=1))
        )
        state.pinned[on_border[turn > self.corner_angle]] = 1

    def dispose(self, state: State, starts: Int64, ends: Int64, proposed: Float64) -> None:
        if self.sliding:
            near = state.near
            parallel.run(
                slide, starts, ends, state.points, near.border, near.border_ring, state.pinned, proposed
            )
