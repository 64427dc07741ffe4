"""Scale-dependent umbrella: weights 1/|e|, so that unequal edges pull equally hard."""

from __future__ import annotations

import numpy as np

from ....jit import parallel
from ....jit.compiled import kernel
from ..run_state import State
from . import Float64, Int64, Scheme


@kernel
def _propose(starts, ends, points, ring_offsets, ring, pinned, factor, proposed):
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            x = points[v, 0]
            y = points[v, 1]
            z = points[v, 2]
            proposed[v, 0] = x
            proposed[v, 1] = y
            proposed[v, 2] = z
            if pinned[v]:
                continue
            sx = 0.0
            sy = 0.0
            sz = 0.0
            total = 0.0
            for r in range(ring_offsets[v], ring_offsets[v + 1]):
                w = ring[r]
                ex = points[w, 0] - x
                ey = points[w, 1] - y
                ez = points[w, 2] - z
                length = np.sqrt(ex * ex + ey * ey + ez * ez)
                if length > 0.0:
                    weight = 1.0 / length
                    total += weight
                    sx += weight * ex
                    sy += weight * ey
                    sz += weight * ez
            if total > 0.0:
                proposed[v, 0] = x + factor * (sx / total)
                proposed[v, 1] = y + factor * (sy / total)
                proposed[v, 2] = z + factor * (sz / total)


class ScaleDependent(Scheme):
    """Fujiwara's operator, weights normalised to sum 1. Edges of no length have no say.

    Parameters
    ----------
    relaxation : float
        Part of the way to the weighted mean, (0, 1].
    """

    moves_lines = True

    def __init__(self, relaxation: float = 0.5) -> None:
        self.relaxation = relaxation

    def propose(self, state: State, turn: int, starts: Int64, ends: Int64, proposed: Float64) -> None:
        near = state.near
        parallel.run(
            _propose, starts, ends,
            state.points, near.row_offsets, near.row, state.pinned, self.relaxation, proposed,
        )  # fmt: skip
