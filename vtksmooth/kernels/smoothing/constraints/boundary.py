"""Boundary: fixed, or sliding along itself."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ....jit import parallel
from ....jit.compiled import kernel
from ...mesh.adjacency import BOUNDARY, NON_MANIFOLD
from ..run_state import State
from . import Constraint, Float64, Int64, Phase, moved


@kernel
def slide(starts, ends, points, kind, ring, pinned, share, proposed):
    """Trapezium Drawing in one dimension, `share` of the way, for vertices of kind 1."""
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
                    proposed[v, axis] += share * along / chord * (points[b, axis] - points[a, axis])


class Boundary(Constraint):
    """What the vertices on the boundary may do.

    Irregular vertices (non-manifold edges, orientations that disagree) are pinned either way: there a
    surface has no inside of the boundary to slide along.

    Parameters
    ----------
    sliding : bool
        If true, a boundary vertex moves parallel to the line through its two boundary neighbours, half
        way to where it is equally far from both (Trapezium Drawing in one dimension; the whole way would
        swing when all move at once; less with a scheme that takes less of its steps). Straight boundaries
        stay straight. If false, it does not move.
    corner_angle : float
        When sliding, boundary vertices where the boundary turns by more than this stay, degrees.
    """

    topic = "boundary"

    def __init__(self, sliding: bool = False, corner_angle: float = 30.0) -> None:
        self.sliding = sliding
        self.corner_angle = corner_angle
        self.phase = Phase.DIRECT if sliding else Phase.PIN
        self.name = "A sliding boundary (boundary)" if sliding else "A fixed boundary"

    def bind(self, state: State) -> None:
        kinds = state.near.kinds
        state.pinned[kinds == NON_MANIFOLD] = 1
        on_boundary = np.flatnonzero(kinds == BOUNDARY)
        if not self.sliding:
            state.pinned[on_boundary] = 1
            return
        ring = state.near.boundary_ring[on_boundary]
        before = state.points[on_boundary] - state.points[ring[:, 0]]
        after = state.points[ring[:, 1]] - state.points[on_boundary]
        turn = np.degrees(
            np.arctan2(np.linalg.norm(np.cross(before, after), axis=1), (before * after).sum(axis=1))
        )
        state.pinned[on_boundary[turn > self.corner_angle]] = 1

    def dispose(self, state: State, starts: Int64, ends: Int64, proposed: Float64) -> None:
        near = state.near
        parallel.run(
            slide, starts, ends, state.points, near.kinds, near.boundary_ring, state.pinned, state.slide,
            proposed,
        )  # fmt: skip

    def check(self, state: State) -> str:
        kinds = state.near.kinds
        said = moved(state, (kinds == NON_MANIFOLD) | ((kinds == BOUNDARY) & (state.pinned != 0)))
        slides = np.flatnonzero((kinds == BOUNDARY) & (state.pinned == 0))
        return said or off_straight_lines(state, slides, state.near.boundary_ring[slides])


def off_straight_lines(state: State, vertices: Int64, ring: npt.NDArray[np.int32]) -> str:
    """Say by how much `vertices` have left the line through their two neighbours, where that was straight."""
    if state.elsewhere:
        return ""
    first, second = state.original.points[ring[:, 0]], state.original.points[ring[:, 1]]
    along = second - first
    length = np.linalg.norm(along, axis=1)

    def off(points: Float64) -> Float64:
        areas = np.linalg.norm(np.cross(points[vertices] - first, along), axis=1)
        distances: Float64 = np.divide(areas, length, out=np.zeros_like(length), where=length > 0.0)
        return distances

    # A line is straight as far as all that slide on it are in line with their neighbours.
    straight = state.pinned != 0
    straight[vertices] |= off(state.original.points) <= 1e-14 * state.original.diagonal
    count = -1
    while count != (count := int(np.count_nonzero(straight))):
        straight[vertices] &= straight[ring].all(axis=1)
    farthest = off(state.points)[straight[vertices]].max(initial=0.0)
    return f"a straight line is off by {farthest:.3g}" if farthest > 1e-9 * state.original.diagonal else ""
