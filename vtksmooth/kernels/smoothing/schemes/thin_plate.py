"""Thin plate: the umbrella operator applied twice; bending is smoothed, not only position."""

from __future__ import annotations

import numpy as np

from ....jit import parallel
from ....jit.compiled import kernel
from ..run_state import State
from . import Float64, Int64, Scheme
from .umbrella import propose_umbrella


@kernel
def _propose(starts, ends, points, target, near, pinned, factor, proposed):
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            x = points[v, 0]
            y = points[v, 1]
            z = points[v, 2]
            proposed[v, 0] = x
            proposed[v, 1] = y
            proposed[v, 2] = z
            first = near.row_offsets[v]
            valence = near.row_offsets[v + 1] - first
            if pinned[v] or valence == 0:
                continue
            sx = 0.0
            sy = 0.0
            sz = 0.0
            inverse = 0.0
            for r in range(first, first + valence):
                w = near.row[r]
                inverse += 1.0 / max(1, near.row_offsets[w + 1] - near.row_offsets[w])
                # L at the boundary is taken as 0: there the plate is held, but not clamped.
                if near.kinds[w] == 0 or near.kinds[w] >= 4:
                    sx += target[w, 0] - points[w, 0]
                    sy += target[w, 1] - points[w, 1]
                    sz += target[w, 2] - points[w, 2]
            lx = 0.0
            ly = 0.0
            lz = 0.0
            if near.kinds[v] == 0 or near.kinds[v] >= 4:
                lx = target[v, 0] - x
                ly = target[v, 1] - y
                lz = target[v, 2] - z
            step = factor / (1.0 + inverse / valence)
            proposed[v, 0] = x - step * (sx / valence - lx)
            proposed[v, 1] = y - step * (sy / valence - ly)
            proposed[v, 2] = z - step * (sz / valence - lz)


class ThinPlate(Scheme):
    """Second-order operator ``p - (1 / nu) U(U(p))`` of Kobbelt et al. 1998, nu = 1 + mean of 1/valence.

    U(p) of all vertices is taken once, at the beginning of a pass.

    Parameters
    ----------
    relaxation : float
        Part of the full step, (0, 0.55]; larger steps are not stable.
    """

    moves_lines = True

    def __init__(self, relaxation: float = 0.5) -> None:
        self.relaxation = relaxation
        self._target: Float64 = np.empty((0, 3))

    def prepare(self, state: State, turn: int) -> None:
        near = state.near
        if self._target.shape != state.points.shape:
            self._target = np.empty_like(state.points)
        nothing_pinned = np.zeros_like(state.pinned)
        parallel.run(
            propose_umbrella, *parallel.ranges(len(state.points)),
            state.points, near.row_offsets, near.row, nothing_pinned, 1.0, self._target,
        )  # fmt: skip

    def propose(self, state: State, turn: int, starts: Int64, ends: Int64, proposed: Float64) -> None:
        parallel.run(
            _propose, starts, ends,
            state.points, self._target, state.near, state.pinned, self.relaxation, proposed,
        )  # fmt: skip
