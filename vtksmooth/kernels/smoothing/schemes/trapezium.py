"""Trapezium Drawing (Semenova, Savchenko, Hagiwara)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ....jit import parallel
from ....jit.compiled import device, kernel
from ..constraints import Constraint
from ..constraints.gate import ASPECT, MARGIN, Gate
from ..run_state import State
from . import Float64, Fused, Int64, Scheme, trapezium_sweep
from .trapezium_sweep import EQUAL_COSINES


@device
def displacement(points, star, first, size, x, y, z, unit, square, best, partner):
    """Mean of the p0_i - p0 (section 2), with p0 = (x, y, z).

    p_j, the partner of p_i, makes the largest angle p_i p0 p_j. With w = p_i - p_j and m the middle of
    the two, seen from p0, p0_i - p0 = (m.w) w / (w.w), and m.w = (|p_i|^2 - |p_j|^2) / 2.
    """
    for i in range(size):
        w = np.uintp(star[first + i])  # unsigned: no check for indices from the end
        sx = points[w, 0] - x
        sy = points[w, 1] - y
        sz = points[w, 2] - z
        length = sx * sx + sy * sy + sz * sz
        square[i] = length
        # A spoke of no length becomes NaN here, and NaN is never the smaller cosine: it has no partner.
        inverse = 1.0 / np.sqrt(length)
        unit[i, 0] = sx * inverse
        unit[i, 1] = sy * inverse
        unit[i, 2] = sz * inverse
        best[i] = 2.0
        partner[i] = -1
    for i in range(size):
        lowest = best[i]
        found = partner[i]
        ux = unit[i, 0]
        uy = unit[i, 1]
        uz = unit[i, 2]
        for j in range(i + 1, size):
            cosine = ux * unit[j, 0] + uy * unit[j, 1] + uz * unit[j, 2]
            # Written as selections, not as branches: which angle is larger is anybody's guess.
            lower = cosine < lowest - EQUAL_COSINES
            lowest = cosine if lower else lowest
            found = j if lower else found
            other = best[j]
            lower = cosine < other - EQUAL_COSINES
            best[j] = cosine if lower else other
            partner[j] = i if lower else partner[j]
        partner[i] = found
    dx = 0.0
    dy = 0.0
    dz = 0.0
    count = 0
    for i in range(size):
        j = partner[i]
        if j >= 0:
            count += 1
            p = np.uintp(star[first + i])
            q = np.uintp(star[first + j])
            wx = points[p, 0] - points[q, 0]
            wy = points[p, 1] - points[q, 1]
            wz = points[p, 2] - points[q, 2]
            chord = wx * wx + wy * wy + wz * wz
            if chord > 0.0:
                part = 0.5 * (square[i] - square[j]) / chord
                dx += part * wx
                dy += part * wy
                dz += part * wz
    if count > 0:
        dx /= count
        dy /= count
        dz /= count
    return dx, dy, dz


@kernel
def _propose(starts, ends, points, star_offsets, star, pinned, widest, proposed):
    unit = np.empty((widest, 3))
    square = np.empty(widest)
    best = np.empty(widest)
    partner = np.empty(widest, np.int32)
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            x = points[v, 0]
            y = points[v, 1]
            z = points[v, 2]
            first = star_offsets[v]
            size = star_offsets[v + 1] - first
            if not pinned[v] and size > 1:
                dx, dy, dz = displacement(points, star, first, size, x, y, z, unit, square, best, partner)
                x += dx
                y += dy
                z += dz
            proposed[v, 0] = x
            proposed[v, 1] = y
            proposed[v, 2] = z


class TrapeziumDrawing(Scheme):
    """Every neighbour p_i asks for the point that makes an isosceles triangle with it and its partner.

    The neighbours are the star: for triangles the one-ring, for quadrilaterals also the nodes across.
    The proposal is the mean of what they ask for (Semenova et al., section 2). Each p0_i lies on a parallel
    to p_i p_j through p0: that is what keeps the vertex close to the surface that the mesh approximates.
    """

    def propose(self, state: State, turn: int, starts: Int64, ends: Int64, proposed: Float64) -> None:
        near = state.near
        parallel.run(
            _propose, starts, ends,
            state.points, near.star_offsets, near.star, state.pinned, state.widest_star, proposed,
            smallest_share=parallel.COSTLY,
        )  # fmt: skip

    def fuse(self, state: State, acting: Sequence[Constraint], k: Float64, colours: Int64) -> Fused | None:
        """Return the quick sweep, with nothing but the aspect-ratio gate."""
        gates = [each for each in acting if isinstance(each, Gate) and each.kind == ASPECT]
        kept = trapezium_sweep.prepare(state, k, colours) if gates == list(acting) != [] else None
        if kept is None:
            return None
        worst = float(k.min())

        def fused(first: bool, starts: Int64, ends: Int64) -> int:
            nonlocal worst
            # Where nothing is inverted nothing will be, and the worst is never asked for.
            if first and worst < 0.0:
                worst = float(kept.squares.min())
            return trapezium_sweep.sweep(state, kept, MARGIN, worst, starts, ends)

        return fused
