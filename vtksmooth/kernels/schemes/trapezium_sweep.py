"""Trapezium Drawing with its own gate, as one sweep over a mesh of triangles, four vertices at a time."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from .. import parallel
from ..compiled import device, kernel
from ..lanes import WIDTH, absolute, gather, load, pack, select, spread, square_root, store
from ..state import State
from . import Float64, Int64

#: Two angles whose cosines differ by less are equal, and the neighbour that comes first in the star is
#: taken: on regular meshes rounding would otherwise choose, differently in each pose.
EQUAL_COSINES = 1e-12

#: Larger rings are left to the parts.
WIDEST_RING = 255

#: Kinds of vertices: the first of its colour; one whose faces do not follow each other in its ring; the first
#: of four in a row that are free, of one colour and with rings of one size.
_FIRST, _ALONE, _FOUR = 1, 2, 4

#: A vertex takes the sweep some 150 ns: half a millisecond is worth a thread.
_SMALLEST_SHARE = 4_000


@device
def _find_places(v, near, after, before):  # type: ignore[no-untyped-def]
    first = near.ring_offsets[v]
    for i in range(near.corner_offsets[v + 1] - near.corner_offsets[v]):
        c = near.corners[near.corner_offsets[v] + i]
        a = c - c % 3
        for r in range(near.ring_offsets[v + 1] - first):
            if near.ring[first + r] == near.connectivity[c + 1 if c < a + 2 else a]:
                after[i] = r
            if near.ring[first + r] == near.connectivity[c - 1 if c > a else a + 2]:
                before[i] = r


@kernel
def _mark_alone(starts, ends, near, kinds):  # type: ignore[no-untyped-def]
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            first = near.ring_offsets[v]
            row = near.corner_offsets[v]
            size = near.ring_offsets[v + 1] - first
            cyclic = near.corner_offsets[v + 1] - row == size
            for i in range(size if cyclic else 0):
                c = near.corners[row + i]
                a = c - c % 3
                after = near.connectivity[c + 1 if c < a + 2 else a]
                before = near.connectivity[c - 1 if c > a else a + 2]
                cyclic = cyclic and after == near.ring[first + i]
                cyclic = cyclic and before == near.ring[first + (i + 1 if i + 1 < size else 0)]
            if not cyclic:
                kinds[v] |= _ALONE


@kernel
def _mark_fours(starts, ends, near, pinned, kinds):  # type: ignore[no-untyped-def]
    n = kinds.size
    offsets = near.ring_offsets
    for part in range(starts.size):
        for v in range(starts[part], min(ends[part], n - WIDTH + 1)):
            size = offsets[v + 1] - offsets[v]
            four = not pinned[v] and not kinds[v] & _ALONE
            for w in range(v + 1, v + WIDTH):
                four = four and not pinned[w] and not kinds[w] & (_FIRST | _ALONE)
                four = four and offsets[w + 1] - offsets[w] == size
            if four:
                kinds[v] |= _FOUR


@device
def _displacement(size, x, y, z, place, unit, square, chord, cosines):  # type: ignore[no-untyped-def]
    # As trapezium.displacement: the mean of the p0_i - p0.
    for i in range(size):
        ux = load(unit, 3 * i)
        uy = load(unit, 3 * i + 1)
        uz = load(unit, 3 * i + 2)
        # Cosines below this are lower than the lowest so far, and not equal to it.
        bound = spread(2.0 - EQUAL_COSINES)
        px = x
        py = y
        pz = z
        for j in range(i):
            cosine = load(cosines, size * j + i)
            lower = cosine < bound
            bound = select(lower, cosine - EQUAL_COSINES, bound)
            px = select(lower, load(place, 3 * j), px)
            py = select(lower, load(place, 3 * j + 1), py)
            pz = select(lower, load(place, 3 * j + 2), pz)
        for j in range(i + 1, size):
            cosine = ux * load(unit, 3 * j) + uy * load(unit, 3 * j + 1) + uz * load(unit, 3 * j + 2)
            store(cosines, size * i + j, cosine)
            lower = cosine < bound
            bound = select(lower, cosine - EQUAL_COSINES, bound)
            px = select(lower, load(place, 3 * j), px)
            py = select(lower, load(place, 3 * j + 1), py)
            pz = select(lower, load(place, 3 * j + 2), pz)
        # The unit spoke has served: its place is taken by p_i - p_j.
        wx = load(place, 3 * i) - px
        wy = load(place, 3 * i + 1) - py
        wz = load(place, 3 * i + 2) - pz
        store(unit, 3 * i, wx)
        store(unit, 3 * i + 1, wy)
        store(unit, 3 * i + 2, wz)
        # A spoke of no length has no partner.
        store(chord, i, select(bound < 1.5, wx * wx + wy * wy + wz * wz, -1.0))
        px -= x
        py -= y
        pz -= z
        store(square, i, load(square, i) - (px * px + py * py + pz * pz))
    dx = spread(0.0)
    dy = spread(0.0)
    dz = spread(0.0)
    count = spread(0.0)
    for i in range(size):
        length = load(chord, i)
        part = select(length > 0.0, 0.5 * load(square, i) / length, 0.0)
        dx += part * load(unit, 3 * i)
        dy += part * load(unit, 3 * i + 1)
        dz += part * load(unit, 3 * i + 2)
        count += select(length >= 0.0, 1.0, 0.0)
    count = select(count > 1.0, count, 1.0)
    return dx / count, dy / count, dz / count


@device
def _spokes_square(ax, ay, az, aa, bx, by, bz, bb, rx, ry, rz):  # type: ignore[no-untyped-def]
    # As quality.spokes_square.
    nx = ay * bz - az * by
    ny = az * bx - ax * bz
    nz = ax * by - ay * bx
    length = aa + bb - (ax * bx + ay * by + az * bz)
    inverse = 1.0 / length
    q = 3.0 * ((nx * nx + ny * ny + nz * nz) * inverse * inverse)
    q = select(nx * rx + ny * ry + nz * rz < 0.0, -q, q)
    return select(length == 0.0, 0.0, q)


@kernel
def _sweep(starts, ends, points, near, kinds, squares, reference, pinned, widest, margin, worst):  # type: ignore[no-untyped-def]
    ring = near.ring
    offsets = near.ring_offsets
    rows = near.corner_offsets
    corners = near.corners
    group = np.zeros(WIDTH, np.int64)
    place = np.empty((3 * widest, WIDTH))
    unit = np.empty((3 * widest, WIDTH))
    square = np.empty((widest, WIDTH))
    chord = np.empty((widest, WIDTH))
    cosines = np.empty((widest * widest, WIDTH))
    proposed = np.empty((widest, WIDTH))
    target = np.empty((4, WIDTH))
    # Where in the ring the next and the previous corner of each face stand.
    after = np.empty(widest, np.int64)
    before = np.empty(widest, np.int64)
    filled = 0
    moved = 0
    for part in range(starts.size):
        v = starts[part]
        while v < ends[part]:
            # Up to four free vertices of one colour with rings of one size. (No function of its own: it would
            # count references to its arrays, at each call.)
            count = 0
            size = offsets[v + 1] - offsets[v]
            if kinds[v] & _FOUR:
                for lane in range(WIDTH):
                    group[lane] = v + lane
                count = WIDTH
                v += WIDTH
            while v < ends[part] and count < WIDTH and (count == 0 or not kinds[v] & (_FIRST | _ALONE)):
                if not pinned[v]:
                    if count == 0:
                        size = offsets[v + 1] - offsets[v]
                    elif offsets[v + 1] - offsets[v] != size:
                        break
                    group[count] = v
                    count += 1
                v += 1
                if count > 0 and kinds[v - 1] & _ALONE:
                    break
            if count == 0:
                continue
            for lane in range(count, WIDTH):
                group[lane] = group[0]
            g0 = np.uintp(group[0])
            g1 = np.uintp(group[1])
            g2 = np.uintp(group[2])
            g3 = np.uintp(group[3])
            first0 = np.uintp(offsets[g0])
            first1 = np.uintp(offsets[g1])
            first2 = np.uintp(offsets[g2])
            first3 = np.uintp(offsets[g3])
            x, y, z = gather(points, g0, g1, g2, g3)
            for i in range(size):
                w0 = np.uintp(ring[first0 + np.uintp(i)])
                w1 = np.uintp(ring[first1 + np.uintp(i)])
                w2 = np.uintp(ring[first2 + np.uintp(i)])
                w3 = np.uintp(ring[first3 + np.uintp(i)])
                px, py, pz = gather(points, w0, w1, w2, w3)
                store(place, 3 * i, px)
                store(place, 3 * i + 1, py)
                store(place, 3 * i + 2, pz)
                px -= x
                py -= y
                pz -= z
                length = px * px + py * py + pz * pz
                store(square, i, length)
                inverse = 1.0 / square_root(length)
                store(unit, 3 * i, px * inverse)
                store(unit, 3 * i + 1, py * inverse)
                store(unit, 3 * i + 2, pz * inverse)
            dx, dy, dz = _displacement(size, x, y, z, place, unit, square, chord, cosines)
            x += dx
            y += dy
            z += dz
            if kinds[g0] & _ALONE:
                _find_places(g0, near, after, before)
                filled = 0
            elif size != filled:
                for i in range(size):
                    after[i] = i
                    before[i] = i + 1
                before[size - 1] = 0
                filled = size
            row0 = np.uintp(rows[g0])
            row1 = np.uintp(rows[g1])
            row2 = np.uintp(rows[g2])
            row3 = np.uintp(rows[g3])
            old_inverted = spread(0.0)
            inverted = spread(0.0)
            old = spread(np.inf)
            new = spread(np.inf)
            at = -1
            bx = x
            by = y
            bz = z
            bb = x
            for i in range(rows[g0 + 1] - rows[g0]):
                f0 = np.uintp(corners[row0 + np.uintp(i)]) // np.uintp(3)
                f1 = np.uintp(corners[row1 + np.uintp(i)]) // np.uintp(3)
                f2 = np.uintp(corners[row2 + np.uintp(i)]) // np.uintp(3)
                f3 = np.uintp(corners[row3 + np.uintp(i)]) // np.uintp(3)
                q = pack(squares[f0], squares[f1], squares[f2], squares[f3])
                old_inverted += select(q < 0.0, 1.0, 0.0)
                old = select(q < old, q, old)
                if after[i] != at:  # seldom: the last corner of a face is the first of the next
                    at = after[i]
                    bx = load(place, 3 * at) - x
                    by = load(place, 3 * at + 1) - y
                    bz = load(place, 3 * at + 2) - z
                    bb = bx * bx + by * by + bz * bz
                ax = bx
                ay = by
                az = bz
                aa = bb
                at = before[i]
                bx = load(place, 3 * at) - x
                by = load(place, 3 * at + 1) - y
                bz = load(place, 3 * at + 2) - z
                bb = bx * bx + by * by + bz * bz
                rx, ry, rz = gather(reference, f0, f1, f2, f3)
                q = _spokes_square(ax, ay, az, aa, bx, by, bz, bb, rx, ry, rz)
                store(proposed, i, q)
                inverted += select(q < 0.0, 1.0, 0.0)
                new = select(q < new, q, new)
            better = (inverted == old_inverted) & (new > old + margin * absolute(old))
            better = better | ((inverted < old_inverted) & (new >= worst))
            store(target, 0, x)
            store(target, 1, y)
            store(target, 2, z)
            store(target, 3, select(better, 1.0, 0.0))
            for lane in range(count):
                if target[3, lane] > 0.0:
                    w = np.uintp(group[lane])
                    for axis in range(3):
                        points[w, axis] = target[axis, lane]
                    row = np.uintp(rows[w])
                    for i in range(rows[w + 1] - rows[w]):
                        squares[np.uintp(corners[row + np.uintp(i)]) // np.uintp(3)] = proposed[i, lane]
                    moved += 1
    return moved


class Sweep(NamedTuple):
    """What :func:`sweep` keeps between passes.

    Attributes
    ----------
    kinds : (n,) uint8
        What kind of vertex each is for the sweep.
    squares : (m,) float64
        Signed square of k of each face as it is now.
    """

    kinds: npt.NDArray[np.uint8]
    squares: Float64


def prepare(state: State, k: Float64, colours: Int64) -> Sweep | None:
    """Return what :func:`sweep` needs, or None where it does not apply (polygons, giant rings).

    Parameters
    ----------
    state : State
    k : (m,) float64
        Aspect ratios of the faces.
    colours : int64
        The first vertices of all ranges of vertices that are independent of each other.
    """
    near = state.near
    if not state.topology.only_triangles or state.widest_star > WIDEST_RING:
        return None
    n = len(near.border)
    kinds = np.zeros(n, np.uint8)
    kinds[colours[colours < n]] = _FIRST
    everything = parallel.ranges(n)
    parallel.run(_mark_alone, *everything, near, kinds)
    parallel.run(_mark_fours, *everything, near, state.pinned, kinds)
    return Sweep(kinds, k * np.abs(k))


def sweep(state: State, kept: Sweep, margin: float, worst: float, starts: Int64, ends: Int64) -> int:
    """Propose, judge by the aspect-ratio gate and move, vertex after vertex; return how many moved.

    The same result, bit for bit, as proposing, judging and moving one colour class after another, but
    quicker: four vertices stand side by side in the processor's registers, the ring is read once, and
    what faces are worth is remembered.
    """
    moved = parallel.run(
        _sweep, starts, ends,
        state.points, state.near, *kept, state.reference, state.pinned, state.widest_star, margin, worst,
        smallest_share=_SMALLEST_SHARE,
    )  # fmt: skip
    return sum(moved)
