"""Umbrella operator: each vertex goes towards the mean of its one-ring."""

from __future__ import annotations

import numpy as np

from ....jit import parallel
from ....jit.compiled import kernel
from ..run_state import State
from . import Float64, Int64, Scheme


@kernel
def propose_umbrella(starts, ends, points, ring_offsets, ring, pinned, factor, proposed):
    """``p + factor (mean of the one-ring - p)``."""
    # Unsigned indices: signed ones are asked, at every access, whether they count from the end, and that
    # takes a third of the time here.
    one = np.uint64(1)
    for part in range(starts.size):
        for v in range(np.uint64(starts[part]), np.uint64(ends[part])):
            first = np.uint64(ring_offsets[v])
            last = np.uint64(ring_offsets[v + one])
            x = points[v, 0]
            y = points[v, 1]
            z = points[v, 2]
            if pinned[v] or first == last:
                proposed[v, 0] = x
                proposed[v, 1] = y
                proposed[v, 2] = z
                continue
            sx = 0.0
            sy = 0.0
            sz = 0.0
            for r in range(first, last):
                w = np.uint32(ring[r])
                sx += points[w, 0]
                sy += points[w, 1]
                sz += points[w, 2]
            share = 1.0 / np.int64(last - first)
            proposed[v, 0] = x + factor * (sx * share - x)
            proposed[v, 1] = y + factor * (sy * share - y)
            proposed[v, 2] = z + factor * (sz * share - z)


class Umbrella(Scheme):
    """Laplacian with equal weights.

    Parameters
    ----------
    relaxation : float
        Part of the way to the mean of the one-ring, (0, 1].
    """

    moves_lines = True

    def __init__(self, relaxation: float = 0.5) -> None:
        self.relaxation = relaxation

    def propose(self, state: State, turn: int, starts: Int64, ends: Int64, proposed: Float64) -> None:
        near = state.near
        parallel.run(
            propose_umbrella, starts, ends,
            state.points, near.row_offsets, near.row, state.pinned, self.relaxation, proposed,
        )  # fmt: skip
