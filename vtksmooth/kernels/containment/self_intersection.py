"""Pairs of faces of one surface that cross or touch: exact, by orientation predicates.

Two triangles cross if their interiors share a point. They touch if they share points beyond their common
vertices and edges, but none of the interiors. Both follow from signs of determinants alone (P. Guigue,
O. Devillers, "Fast and Robust Triangle-Triangle Overlap Test Using Orientation Predicates", 2003, DOI
10.1080/10867651.2003.10487580). Signs that rounding leaves open are computed again in exact arithmetic
(J. R. Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates", 1997,
DOI 10.1007/PL00009321).
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ...jit import parallel
from ...jit.compiled import allocating, device, kernel, routine
from ..distance.closest_point import LEAF, refitted, tree_of
from ..mesh.adjacency import Adjacency
from ..mesh.mesh import Mesh
from ..mesh.triangulate import cut
from .crossings import STACK, face_normal, longer

Bool = npt.NDArray[np.bool_]
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

#: Least cosine between the normals round a vertex and their mean for the triangles to be seen as a fan.
_FACING = 1e-3


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
def _axis(points, t, terms):
    """Return an axis along which a triangle has an area; 3 if it has none."""
    longest = -1.0
    axis = 0
    for k in range(3):
        i = (k + 1) % 3
        j = (k + 2) % 3
        area = abs(
            (points[t[1], i] - points[t[0], i]) * (points[t[2], j] - points[t[0], j])
            - (points[t[1], j] - points[t[0], j]) * (points[t[2], i] - points[t[0], i])
        )
        if area > longest:
            longest = area
            axis = k
    for k in range(3):
        if turn(points, t[0], t[1], t[2], (axis + k) % 3, terms) != 0:
            return (axis + k) % 3
    return 3


@device
def _in_one_plane(points, f, g, common, terms):
    """Do what :func:`level` does for triangles in one plane."""
    axis = _axis(points, f, terms)
    if axis == 3 or _axis(points, g, terms) == 3:
        return APART
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
def level(points, f, g, terms):
    """Return whether two triangles are apart, touch or cross; one without an area is apart from all."""
    common = 0
    for i in range(3):
        k = _corner(f, i)
        common += k == g[0] or k == g[1] or k == g[2]
    if common == 3:
        return APART if _axis(points, f, terms) == 3 else CROSSING
    of_f = (
        orientation(points, g[0], g[1], g[2], f[0], terms),
        orientation(points, g[0], g[1], g[2], f[1], terms),
        orientation(points, g[0], g[1], g[2], f[2], terms),
    )
    if of_f[0] == 0 and of_f[1] == 0 and of_f[2] == 0:
        return _in_one_plane(points, f, g, common, terms)
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


@device
def _corners(triangles, f):
    return triangles[f, 0], triangles[f, 1], triangles[f, 2]


@kernel
def _find_degenerate(starts, ends, points, triangles, degenerate):
    terms = _room()
    for part in range(starts.size):
        for f in range(starts[part], ends[part]):
            degenerate[f] = _axis(points, _corners(triangles, f), terms) == 3


@kernel
def _find_fans(starts, ends, points, near, discs):
    # Whether the triangles round each vertex are one fan that covers no direction twice, seen along the mean
    # of their normals: then no two of them have more in common than their common corners.
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            discs[v] = 0
            if near.kinds[v] != 0:
                continue
            dx = 0.0
            dy = 0.0
            dz = 0.0
            for row in range(near.corner_offsets[v], near.corner_offsets[v + 1]):
                x, y, z = _unit_normal(points, near, v, near.corners[row])
                dx += x
                dy += y
                dz += z
            length = np.sqrt(dx * dx + dy * dy + dz * dz)
            first = _beside(near, near.corners[near.corner_offsets[v]], 1)
            good = length > 0.0
            for row in range(near.corner_offsets[v], near.corner_offsets[v + 1]):
                c = near.corners[row]
                x, y, z = _unit_normal(points, near, v, c)
                if not x * dx + y * dy + z * dz > _FACING * length:
                    good = False
                    break
                p = _beside(near, c, 1)
                q = _beside(near, c, 2)
                if p != first and q != first:
                    good = not (
                        _turn_round(points, v, p, first, dx, dy, dz) >= 0.0
                        and _turn_round(points, v, first, q, dx, dy, dz) >= 0.0
                    )
                    if not good:
                        break
            discs[v] = good


@device
def _beside(near, c, step):
    """Return the vertex `step` corners after corner c of a triangle."""
    first = c - c % 3
    return near.connectivity[first + (c - first + step) % 3]


@device
def _unit_normal(points, near, v, c):
    return face_normal(points, v, _beside(near, c, 1), _beside(near, c, 2))


@device
def _turn_round(points, v, p, q, dx, dy, dz):
    """Return (p - v) x (q - v) . d."""
    ax = points[p, 0] - points[v, 0]
    ay = points[p, 1] - points[v, 1]
    az = points[p, 2] - points[v, 2]
    bx = points[q, 0] - points[v, 0]
    by = points[q, 1] - points[v, 1]
    bz = points[q, 2] - points[v, 2]
    return (ay * bz - az * by) * dx + (az * bx - ax * bz) * dy + (ax * by - ay * bx) * dz


@device
def _box(points, t, box):
    for axis in range(3):
        p = points[t[0], axis]
        q = points[t[1], axis]
        r = points[t[2], axis]
        box[axis] = min(p, min(q, r))
        box[3 + axis] = max(p, max(q, r))


@device
def _apart(box, low_x, low_y, low_z, high_x, high_y, high_z):
    return (
        box[0] > high_x or box[3] < low_x or box[1] > high_y or box[4] < low_y
        or box[2] > high_z or box[5] < low_z
    )  # fmt: skip


@device
def _in_one_disc(discs, s, t):
    """Whether two triangles share a vertex whose triangles are certainly apart."""
    if discs.size > 0:
        for i in range(3):
            v = _corner(s, i)
            if discs[v] and (v == t[0] or v == t[1] or v == t[2]):
                return True
    return False


@device
def _any_asked(tree, i, asked):
    order, node = tree[2], tree[5]
    any_asked = False
    for k in range(node[i, 0], node[i, 1]):
        any_asked |= asked[order[k]]
    return any_asked


@kernel
def _find_pairs(starts, ends, leaves, tree, face, discs, asked):
    # Leaf against leaf. Three numbers for each pair, one after another: the triangles and their level; and
    # how many in all. `asked`: one of each pair must be; empty: all are.
    points, triangles, order, low, high, node = tree
    stack = np.empty(STACK, np.int32)
    terms = _room()
    boxes = np.empty((LEAF, 6))
    box = np.empty(6)
    pairs = np.empty(1024, np.int32)
    total = 0
    for part in range(starts.size):
        for leaf in range(starts[part], ends[part]):
            i = leaves[leaf]
            if asked.size > 0 and not _any_asked(tree, i, asked):
                continue
            first = node[i, 0]
            last = node[i, 1]
            for k in range(first, last):
                _box(points, _corners(triangles, order[k]), boxes[k - first])
            top = 1
            stack[0] = 0
            while top > 0:
                top -= 1
                j = stack[top]
                if (
                    low[j, 0] > high[i, 0] or high[j, 0] < low[i, 0] or low[j, 1] > high[i, 1]
                    or high[j, 1] < low[i, 1] or low[j, 2] > high[i, 2] or high[j, 2] < low[i, 2]
                ):  # fmt: skip
                    continue
                if node[j, 2] >= 0:
                    stack[top] = node[j, 2]
                    stack[top + 1] = node[j, 2] + 1
                    top += 2
                    continue
                # Each pair of leaves once: by the first of them that is asked.
                if j < i and (asked.size == 0 or _any_asked(tree, j, asked)):
                    continue
                for m in range(node[j, 0], node[j, 1]):
                    g = order[m]
                    t = _corners(triangles, g)
                    _box(points, t, box)
                    if _apart(box, low[i, 0], low[i, 1], low[i, 2], high[i, 0], high[i, 1], high[i, 2]):
                        continue
                    for k in range(first, m if i == j else last):
                        f = order[k]
                        b = boxes[k - first]
                        if (
                            face[f] == face[g] or (asked.size > 0 and not asked[f] and not asked[g])
                            or _apart(box, b[0], b[1], b[2], b[3], b[4], b[5])
                        ):  # fmt: skip
                            continue
                        s = _corners(triangles, f)
                        if _in_one_disc(discs, s, t):
                            continue
                        what = level(points, s, t, terms)
                        if what != APART:
                            if total + 3 > pairs.size:
                                pairs = longer(pairs, total)
                            pairs[total] = f
                            pairs[total + 1] = g
                            pairs[total + 2] = what
                            total += 3
    return pairs, total


@kernel
def _find_levels(starts, ends, points, triangles, first, pairs, levels):
    terms = _room()
    for part in range(starts.size):
        for row in range(starts[part], ends[part]):
            levels[row] = APART
            for f in range(first[pairs[row, 0]], first[pairs[row, 0] + 1]):
                s = _corners(triangles, f)
                for g in range(first[pairs[row, 1]], first[pairs[row, 1] + 1]):
                    t = _corners(triangles, g)
                    levels[row] = max(levels[row], level(points, s, t, terms))


class SelfIntersections:
    """Looks for the pairs of faces of a surface that cross or touch, again and again as its points move.

    Two triangles cross if their interiors share a point, in one plane too. They touch if they share points
    beyond their common vertices and edges, but none of the interiors.

    Parameters
    ----------
    mesh : Mesh
        Polygons are taken as triangles, as :func:`~vtksmooth.kernels.mesh.triangulate.cut` cuts them where
        the points are when they are looked at.
    near : Adjacency, optional
        Of the mesh: with it triangles round one vertex need hardly any tests.

    Notes
    -----
    Exact for the given doubles, as long as nonzero coordinates are greater than 1e-90 times the largest. The
    result does not depend on the number of threads.

    Examples
    --------
    >>> points = np.array([[0, 0, 0], [4, 0, 0], [0, 4, 0], [1, 1, -1], [1, 1, 1], [9, 9, 0.0]])
    >>> mesh = Mesh.from_faces(points, [[0, 1, 2], [3, 4, 5]])
    >>> pairs, levels, _ = SelfIntersections(mesh).find(points)
    >>> pairs.tolist(), levels.tolist()
    ([[0, 1]], [2])
    """

    def __init__(self, mesh: Mesh, near: Adjacency | None = None) -> None:
        self._mesh, self._near = mesh, near if mesh.only_triangles else None
        self._tree: tuple[npt.NDArray[Any], ...] = ()
        # By a power of two, which is exact: products neither overflow nor underflow.
        self._exponent = -int(np.frexp(np.fmax.reduce(np.abs(mesh.points), axis=None, initial=0.0))[1])

    def find(self, points: Float64, asked: Bool | None = None) -> tuple[Int32, UInt8, Int32]:
        """Find the pairs of faces that cross or touch where the points are now.

        Parameters
        ----------
        points : (n, 3) float64
        asked : (m,) bool, optional
            Only pairs with a face for which this is true; the points of all others must be where they were in
            an earlier look.

        Returns
        -------
        pairs : (p, 2) int32
            Faces, the smaller number first, in rising order, each pair once.
        levels : (p,) uint8
            TOUCHING or CROSSING, the highest of the pair's triangles.
        degenerate : (d,) int32
            The face of each triangle without area; these are in no pair.
        """
        scaled, triangles, face = self._cut(points)
        of_triangles = np.empty(0, np.bool_) if asked is None else asked[face]
        discs = np.empty(0, np.uint8)
        if self._near is not None and asked is None:
            discs = np.empty(len(points), np.uint8)
            parallel.run(_find_fans, *parallel.ranges(len(points)), scaled, self._near, discs)
        tree = self._boxes(scaled, triangles, of_triangles)
        leaves = np.flatnonzero(tree[5][:, 2] < 0).astype(np.int32)
        found = parallel.run(
            _find_pairs, *parallel.ranges(len(leaves)), leaves, tree, face, discs, of_triangles,
            smallest_share=parallel.COSTLY,
        )  # fmt: skip
        rows = np.concatenate([pairs[:total] for pairs, total in found]).reshape(-1, 3)
        # Polygons may meet in several of their triangles: the highest level first.
        pairs = np.sort(face[rows[:, :2]], axis=1)
        order = np.lexsort((-rows[:, 2], pairs[:, 1], pairs[:, 0]))
        pairs, levels = pairs[order], rows[order, 2].astype(np.uint8)
        first = np.ones(len(pairs), np.bool_)
        first[1:] = (pairs[1:] != pairs[:-1]).any(axis=1)
        looked = np.arange(len(face)) if asked is None else np.flatnonzero(of_triangles)
        return pairs[first], levels[first], face[looked[_degenerate(scaled, triangles[looked])]]

    def degenerate(self, points: Float64) -> Int32:
        """Return the face of each triangle without area, where the points are `points`."""
        scaled, triangles, face = self._cut(points)
        return face[_degenerate(scaled, triangles)]

    def levels(self, points: Float64, pairs: Int32) -> UInt8:
        """Return what the pairs of faces, (p, 2), do where the points are `points`, (p,)."""
        scaled, triangles, face = self._cut(points)
        first = np.searchsorted(face, np.arange(self._mesh.n_faces + 1)).astype(np.int32)
        levels = np.empty(len(pairs), np.uint8)
        parallel.run(
            _find_levels, *parallel.ranges(len(pairs)), scaled, triangles, first, pairs, levels,
            smallest_share=parallel.COSTLY,
        )  # fmt: skip
        return levels

    def _cut(self, points: Float64) -> tuple[Float64, Int32, Int32]:
        """Return the points, scaled, the triangles, and the face of each."""
        return np.ldexp(points, self._exponent), *cut(self._mesh.with_points(points))

    def _boxes(self, points: Float64, triangles: Int32, asked: Bool) -> tuple[npt.NDArray[Any], ...]:
        """Return a tree of the triangles; one made before serves as long as these are the same."""
        if not self._tree or not self._mesh.only_triangles:
            self._tree = tree_of(points, triangles)
        else:
            self._tree = refitted(self._tree, points, asked)
        return self._tree


def _degenerate(points: Float64, triangles: Int32) -> Bool:
    degenerate = np.empty(len(triangles), np.bool_)
    parallel.run(
        _find_degenerate,
        *parallel.ranges(len(triangles)),
        points,
        np.ascontiguousarray(triangles),
        degenerate,
    )
    return degenerate
