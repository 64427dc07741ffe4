"""Pairs of faces of one surface that cross or touch: exact, by orientation predicates.

Two triangles cross if their interiors share a point. They touch if they share points beyond their common
vertices and edges, but none of the interiors. Both follow from signs of determinants alone (P. Guigue,
O. Devillers, "Fast and Robust Triangle-Triangle Overlap Test Using Orientation Predicates", 2003, DOI
10.1080/10867651.2003.10487580). Signs that rounding leaves open are computed again in exact arithmetic
(J. R. Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates", 1997,
DOI 10.1007/PL00009321).
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ...jit import parallel
from ...jit.compiled import allocating, device, kernel, routine
from ..distance.closest_point import ClosestPoint
from ..mesh.mesh import Mesh, widen
from .crossings import faces_near, longer, no_box, scratch

Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
UInt8 = npt.NDArray[np.uint8]

#: What two faces do.
APART, TOUCHING, CROSSING = 0, 1, 2

#: Rounding errors of the two determinants, in parts of the sum of their terms' sizes (Shewchuk, section 4).
_EPSILON = 2.0**-53
_ERROR_2D = (3.0 + 16.0 * _EPSILON) * _EPSILON
_ERROR_3D = (7.0 + 56.0 * _EPSILON) * _EPSILON

#: Dekker's constant, which cuts a double into two halves.
_SPLITTER = 2.0**27 + 1.0

#: Most numbers whose sum is an exact determinant: 24 products of three coordinates, each of which is the sum
#: of four doubles.
_TERMS = 128

#: How much larger boxes are made in which faces are looked for: more than the rounding errors of that test
#: for coordinates up to 1.
_MARGIN = 1e-13


# -- exact signs -------------------------------------------------------------------------------------


@device
def _product(a, b):
    """Return a b as the sum of two doubles: the rounded product and its error."""
    p = a * b
    c = _SPLITTER * a
    ah = c - (c - a)
    al = a - ah
    c = _SPLITTER * b
    bh = c - (c - b)
    bl = b - bh
    return p, al * bl - (((p - ah * bh) - al * bh) - ah * bl)


@routine
def _add(terms, count, value):
    """Add a double to an exact sum of `count` terms in rising order (Shewchuk's GROW-EXPANSION)."""
    left = 0
    for i in range(count):
        s = value + terms[i]
        virtual = s - value
        error = (value - (s - virtual)) + (terms[i] - virtual)
        value = s
        if error != 0.0:
            terms[left] = error
            left += 1
    if value != 0.0:
        terms[left] = value
        left += 1
    return left


@routine
def _add_product(terms, count, sign, a, b, c):
    """Add sign a b c, exactly."""
    p, e = _product(a, b)
    for part in range(2):
        s, t = _product(p if part == 0 else e, sign * c)
        count = _add(terms, count, t)
        count = _add(terms, count, s)
    return count


@device
def _sign_of(terms, count):
    # The last term is greater than all before it together.
    if count == 0:
        return 0
    return 1 if terms[count - 1] > 0.0 else -1


@routine
def _exact_orientation(points, a, b, c, d, terms):
    # The determinant with rows (x, y, z, 1), by the column of ones: minors of three rows each.
    count = 0
    for left_out in range(4):
        p = b if left_out == 0 else a
        q = c if left_out < 2 else b
        r = d if left_out < 3 else c
        sign = -1.0 if left_out % 2 else 1.0
        for axis in range(3):
            i = (axis + 1) % 3
            j = (axis + 2) % 3
            count = _add_product(terms, count, sign, points[p, axis], points[q, i], points[r, j])
            count = _add_product(terms, count, -sign, points[p, axis], points[q, j], points[r, i])
    return _sign_of(terms, count)


@routine
def _exact_turn(points, a, b, c, i, j, terms):
    count = 0
    for side in range(3):
        p = a if side == 0 else (b if side == 1 else c)
        q = b if side == 0 else (c if side == 1 else a)
        count = _add_product(terms, count, 1.0, points[p, i], points[q, j], 1.0)
        count = _add_product(terms, count, -1.0, points[p, j], points[q, i], 1.0)
    return _sign_of(terms, count)


@device
def orientation(points, a, b, c, d, terms):
    """Return the sign of (b - a) x (c - a) . (d - a): whether d is in front of the triangle (a, b, c)."""
    if a == d or b == d or c == d or a == b or b == c or a == c:  # noqa: SIM109 (numba)
        return 0
    bx = points[b, 0] - points[a, 0]
    by = points[b, 1] - points[a, 1]
    bz = points[b, 2] - points[a, 2]
    cx = points[c, 0] - points[a, 0]
    cy = points[c, 1] - points[a, 1]
    cz = points[c, 2] - points[a, 2]
    dx = points[d, 0] - points[a, 0]
    dy = points[d, 1] - points[a, 1]
    dz = points[d, 2] - points[a, 2]
    yz = by * cz
    zy = bz * cy
    zx = bz * cx
    xz = bx * cz
    xy = bx * cy
    yx = by * cx
    value = dx * (yz - zy) + dy * (zx - xz) + dz * (xy - yx)
    bound = _ERROR_3D * (
        abs(dx) * (abs(yz) + abs(zy)) + abs(dy) * (abs(zx) + abs(xz)) + abs(dz) * (abs(xy) + abs(yx))
    )
    if value > bound:
        return 1
    if value < -bound:
        return -1
    if bound == 0.0 and _is_flat(bx, cx, dx, by, cy, dy, bz, cz, dz):
        return 0
    return _exact_orientation(points, a, b, c, d, terms)


@device
def _is_flat(bx, cx, dx, by, cy, dy, bz, cz, dz):
    """Whether all differences along an axis are 0; then nothing has underflown."""
    return bx == cx == dx == 0.0 or by == cy == dy == 0.0 or bz == cz == dz == 0.0


@device
def turn(points, a, b, c, axis, terms):
    """Return the sign of the area of (a, b, c), seen along an axis."""
    if a == b or b == c or a == c:  # noqa: SIM109 (numba)
        return 0
    i = (axis + 1) % 3
    j = (axis + 2) % 3
    bi = points[b, i] - points[a, i]
    bj = points[b, j] - points[a, j]
    ci = points[c, i] - points[a, i]
    cj = points[c, j] - points[a, j]
    left = bi * cj
    right = bj * ci
    value = left - right
    bound = _ERROR_2D * (abs(left) + abs(right))
    if value > bound:
        return 1
    if value < -bound:
        return -1
    if (bi == 0.0 or cj == 0.0) and (bj == 0.0 or ci == 0.0):
        return 0
    return _exact_turn(points, a, b, c, i, j, terms)


# -- two triangles -----------------------------------------------------------------------------------


@device
def _corner(t, i):
    i = i % 3
    return t[0] if i == 0 else (t[1] if i == 1 else t[2])


@device
def _alone(s):
    """Return the corner that the other two are not on the side of, and its side (signs `s`, not all 0)."""
    for i in range(3):
        if _corner(s, i) > 0 and _corner(s, i + 1) <= 0 and _corner(s, i + 2) <= 0:
            return i, 1
    for i in range(3):
        if _corner(s, i) < 0 and _corner(s, i + 1) >= 0 and _corner(s, i + 2) >= 0:
            return i, -1
    # One corner in the plane, the others on one side of it.
    i = 0 if s[0] == 0 else (1 if s[1] == 0 else 2)
    return i, -_corner(s, i + 1)


@device
def _straddles(s):
    return min(s[0], min(s[1], s[2])) < 0 < max(s[0], max(s[1], s[2]))


@device
def _zeros(s):
    return (s[0] == 0) + (s[1] == 0) + (s[2] == 0)


@device
def _in_one_plane(points, f, g, common, axis, terms):
    """Do what :func:`level` does for triangles in one plane, seen along an axis."""
    crossing = True
    for part in range(2):
        t = f if part == 0 else g
        o = g if part == 0 else f
        way = turn(points, t[0], t[1], t[2], axis, terms)
        for side in range(3):
            p = _corner(t, side)
            q = _corner(t, side + 1)
            most = -1
            for i in range(3):
                most = max(most, way * turn(points, p, q, _corner(o, i), axis, terms))
            if most < 0:
                return APART
            if most == 0:
                crossing = False
    if crossing:
        return CROSSING
    if common == 0:
        return TOUCHING
    # One common vertex, at which they touch if a side of one is in the other's angle; or a common side.
    for part in range(2 if common == 1 else 0):
        t = f if part == 0 else g
        o = g if part == 0 else f
        way = turn(points, t[0], t[1], t[2], axis, terms)
        for i in range(3):
            v = _corner(t, i)
            if v != o[0] and v != o[1] and v != o[2]:
                continue
            for k in range(3):
                w = _corner(o, k)
                if w == v:
                    continue
                if (
                    way * turn(points, v, _corner(t, i + 1), w, axis, terms) >= 0
                    and way * turn(points, v, w, _corner(t, i + 2), axis, terms) >= 0
                ):
                    return TOUCHING
    return APART


@routine
def level(points, f, g, axis, terms):
    """Return whether two triangles with areas are apart, touch or cross; f has an area along `axis`."""
    common = 0
    for i in range(3):
        k = _corner(f, i)
        common += k == g[0] or k == g[1] or k == g[2]
    if common == 3:
        return CROSSING
    of_f = (
        orientation(points, g[0], g[1], g[2], f[0], terms),
        orientation(points, g[0], g[1], g[2], f[1], terms),
        orientation(points, g[0], g[1], g[2], f[2], terms),
    )
    if of_f[0] == 0 and of_f[1] == 0 and of_f[2] == 0:
        return _in_one_plane(points, f, g, common, axis, terms)
    if common == 2 or (of_f[0] == of_f[1] and of_f[1] == of_f[2]):
        return APART
    if common == 1 and not _straddles(of_f) and _zeros(of_f) == 1:
        return APART  # meets the other plane in the common vertex only
    of_g = (
        orientation(points, f[0], f[1], f[2], g[0], terms),
        orientation(points, f[0], f[1], f[2], g[1], terms),
        orientation(points, f[0], f[1], f[2], g[2], terms),
    )
    if of_g[0] == of_g[1] and of_g[1] == of_g[2]:
        return APART
    if common == 1 and not _straddles(of_g) and _zeros(of_g) == 1:
        return APART
    # Each has an interval on the line in which the planes meet: do they overlap? (Guigue and Devillers)
    i, side_f = _alone(of_f)
    j, side_g = _alone(of_g)
    a = _corner(f, i)
    b = _corner(f, i + (1 if side_g > 0 else 2))
    c = _corner(f, i + (2 if side_g > 0 else 1))
    p = _corner(g, j)
    q = _corner(g, j + (1 if side_f > 0 else 2))
    r = _corner(g, j + (2 if side_f > 0 else 1))
    one = orientation(points, a, b, p, q, terms)
    two = orientation(points, a, c, r, p, terms)
    if one > 0 or two > 0:
        return APART
    if one < 0 and two < 0:
        # Of positive length, unless an interval is a point.
        return CROSSING if _straddles(of_f) and _straddles(of_g) else TOUCHING
    return TOUCHING if common == 0 else APART


# -- all pairs ---------------------------------------------------------------------------------------


@allocating
def _room():
    return np.empty(_TERMS)


@kernel
def _find_axes(starts, ends, points, triangles, axes):
    # An axis along which each triangle has an area; 3 where it has none.
    terms = _room()
    for part in range(starts.size):
        for f in range(starts[part], ends[part]):
            a = triangles[f, 0]
            b = triangles[f, 1]
            c = triangles[f, 2]
            longest = -1.0
            axis = 0
            for k in range(3):
                i = (k + 1) % 3
                j = (k + 2) % 3
                area = abs(
                    (points[b, i] - points[a, i]) * (points[c, j] - points[a, j])
                    - (points[b, j] - points[a, j]) * (points[c, i] - points[a, i])
                )
                if area > longest:
                    longest = area
                    axis = k
            axes[f] = 3
            for k in range(3):
                if turn(points, a, b, c, (axis + k) % 3, terms) != 0:
                    axes[f] = (axis + k) % 3
                    break


@kernel
def _find_pairs(starts, ends, tree, axes, face):
    # Three numbers for each pair, one after another: the triangles and their level; and how many in all.
    points, triangles = tree[0], tree[1]
    stack, found, box = scratch()
    terms = _room()
    pairs = np.empty(1024, np.int32)
    total = 0
    for part in range(starts.size):
        for f in range(starts[part], ends[part]):
            if axes[f] == 3:
                continue
            t = (triangles[f, 0], triangles[f, 1], triangles[f, 2])
            no_box(box)
            for corner in range(3):
                widen(box, points, triangles[f, corner])
            top = 1
            stack[0] = 0
            while top > 0:
                count, top = faces_near(tree, box, _MARGIN, stack, top, found)
                for c in range(count):
                    g = found[c]
                    if g <= f or axes[g] == 3 or face[g] == face[f]:
                        continue
                    o = (triangles[g, 0], triangles[g, 1], triangles[g, 2])
                    what = level(points, t, o, axes[f], terms)
                    if what != APART:
                        if total + 3 > pairs.size:
                            pairs = longer(pairs, total)
                        pairs[total] = f
                        pairs[total + 1] = g
                        pairs[total + 2] = what
                        total += 3
    return pairs, total


def self_intersections(points: Float64, triangles: Int32, face: Int32) -> tuple[Int32, UInt8, Int32]:
    """Find the pairs of faces of a surface that cross or touch.

    Two triangles cross if their interiors share a point, in one plane too. They touch if they share points
    beyond their common vertices and edges, but none of the interiors.

    Parameters
    ----------
    points : (n, 3) float64
    triangles : (t, 3) int32
    face : (t,) int32
        The face that each triangle is part of; triangles of one face are not compared.

    Returns
    -------
    pairs : (p, 2) int32
        Faces, the smaller number first, in rising order, each pair once.
    levels : (p,) uint8
        TOUCHING or CROSSING, the highest of the pair's triangles.
    degenerate : (d,) int32
        Triangles without area; they are in no pair.

    Notes
    -----
    Exact for the given doubles, as long as nonzero coordinates are greater than 1e-90 times the largest. The
    result does not depend on the number of threads.

    Examples
    --------
    >>> points = np.array([[0, 0, 0], [4, 0, 0], [0, 4, 0], [1, 1, -1], [1, 1, 1], [9, 9, 0.0]])
    >>> triangles = np.array([[0, 1, 2], [3, 4, 5]], np.int32)
    >>> pairs, levels, _ = self_intersections(points, triangles, np.arange(2, dtype=np.int32))
    >>> pairs.tolist(), levels.tolist()
    ([[0, 1]], [2])
    """
    # By a power of two, which is exact: products neither overflow nor underflow.
    largest = np.abs(points[triangles]).max(initial=0.0)
    scaled = np.ldexp(points, -int(np.frexp(largest)[1]))
    axes = np.empty(len(triangles), np.uint8)
    parts = parallel.ranges(len(triangles))
    parallel.run(_find_axes, *parts, scaled, triangles, axes)
    tree = ClosestPoint(Mesh.from_faces(scaled, triangles)).tree
    found = parallel.run(_find_pairs, *parts, tree, axes, face, smallest_share=parallel.COSTLY)
    rows = np.concatenate([pairs[:total] for pairs, total in found]).reshape(-1, 3)
    # Polygons may meet in several of their triangles: the highest level first.
    pairs = np.sort(face[rows[:, :2]], axis=1)
    order = np.lexsort((-rows[:, 2], pairs[:, 1], pairs[:, 0]))
    pairs, levels = pairs[order], rows[order, 2].astype(np.uint8)
    first = np.ones(len(pairs), np.bool_)
    first[1:] = (pairs[1:] != pairs[:-1]).any(axis=1)
    return pairs[first], levels[first], np.flatnonzero(axes == 3).astype(np.int32)
