"""Trapezium Drawing (Semenova, Savchenko, Hagiwara)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from .. import parallel
from ..compiled import device, kernel
from ..quality import spokes_square
from ..state import State
from . import Float64, Int64, Scheme

#: Two angles whose cosines differ by less are equal, and the neighbour that comes first in the star is
#: taken: on regular meshes rounding would otherwise choose, differently in each pose.
EQUAL_COSINES = 1e-12

#: A vertex takes the fused sweep some 300 ns: a millisecond is worth a thread.
_SMALLEST_SHARE = 4_000


@device
def displacement(points, star, first, size, x, y, z, spoke, unit, square, best, partner):  # type: ignore[no-untyped-def]
    """Mean of the p0_i - p0 (section 2), with p0 = (x, y, z); leaves the spokes p_i - p0 in `spoke`.

    p_j, the partner of p_i, makes the largest angle p_i p0 p_j. With w = p_i - p_j and m the middle of
    the two, seen from p0, p0_i - p0 = (m.w) w / (w.w), and m.w = (|p_i|^2 - |p_j|^2) / 2.
    """
    for i in range(size):
        w = np.uintp(star[first + i])  # unsigned: no check for indices from the end
        sx = points[w, 0] - x
        sy = points[w, 1] - y
        sz = points[w, 2] - z
        spoke[i, 0] = sx
        spoke[i, 1] = sy
        spoke[i, 2] = sz
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
            wx = spoke[i, 0] - spoke[j, 0]
            wy = spoke[i, 1] - spoke[j, 1]
            wz = spoke[i, 2] - spoke[j, 2]
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
def _propose(starts, ends, points, star_offsets, star, pinned, widest, proposed):  # type: ignore[no-untyped-def]
    spoke = np.empty((widest, 3))
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
                dx, dy, dz = displacement(
                    points, star, first, size, x, y, z, spoke, unit, square, best, partner
                )
                x += dx
                y += dy
                z += dz
            proposed[v, 0] = x
            proposed[v, 1] = y
            proposed[v, 2] = z


@kernel
def _ring_places(starts, ends, near, places):  # type: ignore[no-untyped-def]
    # For each corner of a vertex, where in its ring the next and the previous corner of the face stand.
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            first = near.ring_offsets[v]
            for i in range(near.corner_offsets[v], near.corner_offsets[v + 1]):
                c = near.corners[i]
                a = c - c % 3
                after = near.connectivity[c + 1 if c < a + 2 else a]
                before = near.connectivity[c - 1 if c > a else a + 2]
                for r in range(first, near.ring_offsets[v + 1]):
                    if near.ring[r] == after:
                        places[i, 0] = r - first
                    if near.ring[r] == before:
                        places[i, 1] = r - first


@kernel
def _sweep(starts, ends, points, near, places, squares, reference, pinned, widest, margin, worst):  # type: ignore[no-untyped-def]
    spoke = np.empty((widest, 3))
    unit = np.empty((widest, 3))
    square = np.empty(widest)
    best = np.empty(widest)
    partner = np.empty(widest, np.int32)
    proposed = np.empty(widest)
    moved = 0
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            first = near.ring_offsets[v]
            size = near.ring_offsets[v + 1] - first
            if pinned[v] or size < 2:
                continue
            x = points[v, 0]
            y = points[v, 1]
            z = points[v, 2]
            dx, dy, dz = displacement(
                points, near.ring, first, size, x, y, z, spoke, unit, square, best, partner
            )
            x += dx
            y += dy
            z += dz
            row = near.corner_offsets[v]
            faces = near.corner_offsets[v + 1] - row
            old_inverted = 0
            old = np.inf
            for i in range(faces):
                q = squares[near.corners[row + i] // 3]
                old_inverted += q < 0.0
                old = min(old, q)
            # The spokes from the proposed position take the place of the old ones.
            for i in range(size):
                w = np.uintp(near.ring[first + i])
                sx = points[w, 0] - x
                sy = points[w, 1] - y
                sz = points[w, 2] - z
                spoke[i, 0] = sx
                spoke[i, 1] = sy
                spoke[i, 2] = sz
                square[i] = sx * sx + sy * sy + sz * sz
            new_inverted = 0
            new = np.inf
            needed = old + margin * abs(old)
            for i in range(faces):
                f = np.uintp(near.corners[row + i] // 3)
                a = places[row + i, 0]
                b = places[row + i, 1]
                q = spokes_square(
                    spoke[a, 0], spoke[a, 1], spoke[a, 2], square[a],
                    spoke[b, 0], spoke[b, 1], spoke[b, 2], square[b],
                    reference[f, 0], reference[f, 1], reference[f, 2],
                )  # fmt: skip
                proposed[i] = q
                new_inverted += q < 0.0
                new = min(new, q)
                # Refused already: too many are inverted, or the minimum is not above and the number of
                # inverted elements, 0 before, cannot fall.
                if new_inverted > old_inverted or (old_inverted == 0 and q <= needed):
                    new = -np.inf
                    new_inverted = old_inverted
                    break
            better = new_inverted == old_inverted and new > needed
            if better or (new_inverted < old_inverted and new >= worst):
                points[v, 0] = x
                points[v, 1] = y
                points[v, 2] = z
                for i in range(faces):
                    squares[near.corners[row + i] // 3] = proposed[i]
                moved += 1
    return moved


class Sweep(NamedTuple):
    """What :meth:`TrapeziumDrawing.sweep` keeps between passes.

    Attributes
    ----------
    places : (k, 2) uint8
        For each corner of a vertex, where in its ring the next and the previous corner of the face stand.
    squares : (m,) float64
        Signed square of k of each face as it is now.
    """

    places: npt.NDArray[np.uint8]
    squares: Float64


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
        )  # fmt: skip

    def prepare_sweep(self, state: State, k: Float64) -> Sweep | None:
        """Return what :meth:`sweep` needs, or None where it does not apply (polygons, giant rings).

        `k` are the aspect ratios of the faces.
        """
        near = state.near
        if not state.topology.only_triangles or state.widest_star > 255:
            return None
        places = np.empty((len(near.corners), 2), np.uint8)
        parallel.run(_ring_places, *parallel.ranges(len(near.border)), near, places)
        return Sweep(places, k * np.abs(k))

    def sweep(
        self, state: State, kept: Sweep, margin: float, worst: float, starts: Int64, ends: Int64
    ) -> int:
        """Propose, judge by the aspect-ratio gate and move, vertex after vertex; return how many moved.

        The same result, bit for bit, as proposing, judging and moving one colour class after another,
        but quicker: the ring is read once, and what faces are worth is remembered.
        """
        near = state.near
        moved = parallel.run(
            _sweep, starts, ends,
            state.points, near, *kept, state.reference, state.pinned, state.widest_star, margin, worst,
            smallest_share=_SMALLEST_SHARE,
        )  # fmt: skip
        return sum(moved)
