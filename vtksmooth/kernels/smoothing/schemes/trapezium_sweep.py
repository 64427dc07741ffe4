"""Trapezium Drawing with its own gate, as one sweep over a mesh of triangles, four vertices at a time."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ....jit import parallel
from ....jit.compiled import device, kernel, routine
from ....jit.simd import (
    WIDTH,
    absolute,
    everywhere,
    gather,
    load,
    narrow,
    pack,
    select,
    spread,
    square_root,
    store,
    unpack,
)
from ...measures.aspect_ratio import spokes_square
from ..run_state import State
from . import Float64, Int64

#: Two angles whose cosines differ by less are equal, and the neighbour that comes first in the star is
#: taken: on regular meshes rounding would otherwise choose, differently in each pose.
EQUAL_COSINES = 1e-12

#: Cosines computed in float32 are right to a few 1e-7. Where the lowest is lower than the others by more than
#: this, float64 would find the same.
_CLEAR = 1e-5

#: In float32 squares of lengths beyond these are not worth much.
_SHORTEST, _LONGEST = 1e-30, 1e30

#: Rows of a neighbour in what :func:`_read_rings` writes: its coordinates, and the square of its distance.
_ROWS = 4

#: Larger rings are left to the parts. Of those larger than the second number no cosines are kept: any mesh
#: may have a hub, and cosines take room by the square.
WIDEST_RING, _KEPT = 4095, 255

#: Kinds of vertices: the first of its colour; one whose faces do not follow each other in its ring; the first
#: of four in a row that are free, of one colour and with rings of one size.
_FIRST, _ALONE, _FOUR = 1, 2, 4

#: A vertex takes the sweep some 150 ns: half a millisecond is worth a thread.
_SMALLEST_SHARE = 4_000


@device
def _find_places(v, near, after, before):
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
def _mark_alone(starts, ends, near, kinds):
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
def _mark_fours(starts, ends, near, pinned, kinds):
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
def _read_rings(size, ring, first, points, x, y, z, place, unit):
    """Write neighbours and, in float32, their directions; return whether float32 can hold the lengths."""
    f, g, h, i = first
    shortest = narrow(spread(1.0))
    longest = shortest
    for r in range(size):
        at = np.uintp(r)
        px, py, pz = gather(points, ring[f + at], ring[g + at], ring[h + at], ring[i + at])
        store(place, _ROWS * r, px)
        store(place, _ROWS * r + 1, py)
        store(place, _ROWS * r + 2, pz)
        px -= x
        py -= y
        pz -= z
        square = px * px + py * py + pz * pz
        store(place, _ROWS * r + 3, square)
        store(unit, 3 * r, narrow(px))
        store(unit, 3 * r + 1, narrow(py))
        store(unit, 3 * r + 2, narrow(pz))
    # In a loop of its own: more of these roots and divisions are then under way at a time.
    for r in range(size):
        length = narrow(load(place, _ROWS * r + 3))
        shortest = select(length < shortest, length, shortest)
        longest = select(length < longest, longest, length)
        inverse = 1.0 / square_root(length)
        store(unit, 3 * r, load(unit, 3 * r) * inverse)
        store(unit, 3 * r + 1, load(unit, 3 * r + 1) * inverse)
        store(unit, 3 * r + 2, load(unit, 3 * r + 2) * inverse)
    return (shortest > _SHORTEST) & (longest < _LONGEST)


@device
def _take(cosine, at, lowest, second, found):
    """Return the lowest cosine, the second lowest, and where the lowest stands, after one more."""
    lower = cosine < lowest
    higher = select(lower, lowest, cosine)
    second = select(higher < second, higher, second)
    return select(lower, cosine, lowest), second, select(lower, at, found)


@device
def _find_partners(size, unit, cosines, partner):
    """Write where each neighbour's partner begins in `place`; return whether float64 would find the same."""
    none = narrow(spread(2.0))
    clear = none
    for i in range(size):
        ux = load(unit, 3 * i)
        uy = load(unit, 3 * i + 1)
        uz = load(unit, 3 * i + 2)
        lowest = none
        second = none
        found = narrow(spread(0.0))
        at = found
        for j in range(i):
            cosine = load(cosines, size * j + i)
            lowest, second, found = _take(cosine, at, lowest, second, found)
            at += float(_ROWS * WIDTH)
        for j in range(i + 1, size):
            at += float(_ROWS * WIDTH)
            cosine = ux * load(unit, 3 * j) + uy * load(unit, 3 * j + 1) + uz * load(unit, 3 * j + 2)
            store(cosines, size * i + j, cosine)
            lowest, second, found = _take(cosine, at, lowest, second, found)
        store(partner, i, found)
        lead = second - lowest
        clear = select(lead < clear, lead, clear)
    return clear > _CLEAR


@routine
def _find_partners_surely(size, place, x, y, z, unit, partner):
    """Write where each neighbour's partner begins in `place`; return how many have one."""
    for i in range(size):
        inverse = 1.0 / square_root(load(place, _ROWS * i + 3))
        store(unit, 3 * i, (load(place, _ROWS * i) - x) * inverse)
        store(unit, 3 * i + 1, (load(place, _ROWS * i + 1) - y) * inverse)
        store(unit, 3 * i + 2, (load(place, _ROWS * i + 2) - z) * inverse)
    count = spread(0.0)
    for i in range(size):
        ux = load(unit, 3 * i)
        uy = load(unit, 3 * i + 1)
        uz = load(unit, 3 * i + 2)
        # Cosines below this are lower than the lowest so far, and not equal to it.
        bound = spread(2.0 - EQUAL_COSINES)
        # A spoke of no length has no partner. It stands as its own, and asks for nothing.
        found = spread(float(_ROWS * WIDTH * i))
        for j in range(size):
            if j != i:
                cosine = ux * load(unit, 3 * j) + uy * load(unit, 3 * j + 1) + uz * load(unit, 3 * j + 2)
                lower = cosine < bound
                bound = select(lower, cosine - EQUAL_COSINES, bound)
                found = select(lower, float(_ROWS * WIDTH * j), found)
        count += select(bound < 1.5, 1.0, 0.0)
        store(partner, i, found)
    return select(count > 1.0, count, 1.0)


@device
def _displacement(size, place, partner, count):
    # As trapezium.displacement: the mean of the p0_i - p0.
    dx = spread(0.0)
    dy = spread(0.0)
    dz = spread(0.0)
    for i in range(size):
        # Lane after lane, so that the next row is four numbers on.
        a = np.uintp(partner[i, 0])
        b = np.uintp(partner[i, 1]) + np.uintp(1)
        c = np.uintp(partner[i, 2]) + np.uintp(2)
        d = np.uintp(partner[i, 3]) + np.uintp(3)
        y = np.uintp(WIDTH)
        z = np.uintp(2 * WIDTH)
        s = np.uintp(3 * WIDTH)
        wx = load(place, _ROWS * i) - pack(place[a], place[b], place[c], place[d])
        wy = load(place, _ROWS * i + 1) - pack(place[a + y], place[b + y], place[c + y], place[d + y])
        wz = load(place, _ROWS * i + 2) - pack(place[a + z], place[b + z], place[c + z], place[d + z])
        difference = load(place, _ROWS * i + 3) - pack(place[a + s], place[b + s], place[c + s], place[d + s])
        chord = wx * wx + wy * wy + wz * wz
        part = select(chord > 0.0, 0.5 * difference / chord, 0.0)
        dx += part * wx
        dy += part * wy
        dz += part * wz
    return dx / count, dy / count, dz / count


@device
def _faces(corners, first, r):
    f, g, h, i = first
    at = np.uintp(r)
    three = np.uintp(3)
    return (
        np.uintp(corners[f + at]) // three,
        np.uintp(corners[g + at]) // three,
        np.uintp(corners[h + at]) // three,
        np.uintp(corners[i + at]) // three,
    )


@device
def _judge(faces, corners, first, squares, reference, place, after, before, x, y, z, old, new, margin, worst):
    """Write what faces are worth and would be worth; return where the gate lets vertices go to (x, y, z)."""
    lowest_old = spread(np.inf)
    lowest = spread(np.inf)
    at = -1
    bx = x
    by = y
    bz = z
    bb = x
    for r in range(faces):
        f, g, h, i = _faces(corners, first, r)
        q = pack(squares[f], squares[g], squares[h], squares[i])
        store(old, r, q)
        lowest_old = select(q < lowest_old, q, lowest_old)
        if after[r] != at:  # seldom: the last corner of a face is the first of the next
            at = after[r]
            bx = load(place, _ROWS * at) - x
            by = load(place, _ROWS * at + 1) - y
            bz = load(place, _ROWS * at + 2) - z
            bb = bx * bx + by * by + bz * bz
        ax = bx
        ay = by
        az = bz
        aa = bb
        at = before[r]
        bx = load(place, _ROWS * at) - x
        by = load(place, _ROWS * at + 1) - y
        bz = load(place, _ROWS * at + 2) - z
        bb = bx * bx + by * by + bz * bz
        rx, ry, rz = gather(reference, f, g, h, i)
        q = spokes_square(ax, ay, az, aa, bx, by, bz, bb, rx, ry, rz)
        store(new, r, q)
        lowest = select(q < lowest, q, lowest)
    better = lowest > lowest_old + margin * absolute(lowest_old)
    if not everywhere(lowest_old >= 0.0):  # seldom: something is inverted
        inverted_old = spread(0.0)
        inverted = spread(0.0)
        for r in range(faces):
            inverted_old += select(load(old, r) < 0.0, 1.0, 0.0)
            inverted += select(load(new, r) < 0.0, 1.0, 0.0)
        better = (inverted == inverted_old) & better
        better = better | ((inverted < inverted_old) & (lowest >= worst))
    return better


@device
def _fill_places(size, after, before):
    # Of a cycle.
    for r in range(size):
        after[r] = r
        before[r] = r + 1
    before[size - 1] = 0


@device
def _write_squares(faces, corners, first, better, old, new, squares):
    for r in range(faces):
        f, g, h, i = _faces(corners, first, r)
        q = select(better, load(new, r), load(old, r))
        squares[f], squares[g], squares[h], squares[i] = unpack(q)


@kernel
def _sweep(starts, ends, points, near, kinds, squares, reference, pinned, widest, margin, worst):
    ring = near.ring
    offsets = near.ring_offsets
    rows = near.corner_offsets
    corners = near.corners
    group = np.zeros(WIDTH, np.int64)
    place = np.empty(_ROWS * widest * WIDTH)
    unit = np.empty((3 * widest, WIDTH))
    thin_unit = np.empty((3 * widest, WIDTH), np.float32)
    kept = min(widest, _KEPT)
    cosines = np.empty((kept * kept, WIDTH), np.float32)
    partner = np.empty((widest, WIDTH), np.int32)
    old = np.empty((widest, WIDTH))
    new = np.empty((widest, WIDTH))
    # Where in the ring the next and the previous corner of each face stand.
    after = np.empty(widest, np.int64)
    before = np.empty(widest, np.int64)
    filled = 0
    moved = 0
    for part in range(starts.size):
        v = starts[part]
        while v < ends[part]:
            # Up to four free vertices of one colour with rings of one size.
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
            a, b, c, d = np.uintp(group[0]), np.uintp(group[1]), np.uintp(group[2]), np.uintp(group[3])
            ox, oy, oz = gather(points, a, b, c, d)
            first = (np.uintp(offsets[a]), np.uintp(offsets[b]), np.uintp(offsets[c]), np.uintp(offsets[d]))
            sure = _read_rings(size, ring, first, points, ox, oy, oz, place, thin_unit)
            if size <= kept:
                sure = sure & _find_partners(size, thin_unit, cosines, partner)
            partners = spread(float(max(size, 1)))
            if size > kept or not everywhere(sure):
                partners = _find_partners_surely(size, place, ox, oy, oz, unit, partner)
            x, y, z = _displacement(size, place, partner, partners)
            x += ox
            y += oy
            z += oz
            if kinds[a] & _ALONE:
                _find_places(a, near, after, before)
                filled = 0
            elif size != filled:
                _fill_places(size, after, before)
                filled = size
            faces = rows[a + 1] - rows[a]
            first = (np.uintp(rows[a]), np.uintp(rows[b]), np.uintp(rows[c]), np.uintp(rows[d]))
            better = _judge(
                faces, corners, first, squares, reference, place, after, before, x, y, z, old, new, margin,
                worst,
            )  # fmt: skip
            # Written whether they move or not: nobody can guess which, and a wrong guess costs more.
            points[a, 0], points[b, 0], points[c, 0], points[d, 0] = unpack(select(better, x, ox))
            points[a, 1], points[b, 1], points[c, 1], points[d, 1] = unpack(select(better, y, oy))
            points[a, 2], points[b, 2], points[c, 2], points[d, 2] = unpack(select(better, z, oz))
            _write_squares(faces, corners, first, better, old, new, squares)
            store(old, 0, select(better, 1.0, 0.0))
            for lane in range(count):
                moved += int(old[0, lane])
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
    n = len(near.kinds)
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
