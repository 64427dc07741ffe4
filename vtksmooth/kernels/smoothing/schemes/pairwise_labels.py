"""Pairwise smoothing of a surface between labels: pairs of vertices move, all labels keep their volume."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from ....errors import InvalidMeshError
from ....jit import parallel
from ....jit.compiled import allocating, device, kernel, routine
from ...containment.safe_moves import Guard
from ...measures.aspect_ratio import triangle_square
from ...mesh.adjacency import turn_into_cycles
from ..constraints import Constraint
from ..constraints.label_volumes import LabelVolumes
from ..run_state import State
from . import Admitted, EdgeScheme, Float64, Operations
from .pairwise import Bool, Int64, batches_of, in_blocks, in_halves

#: Square of the smallest k below which an operation must not lower it.
_LEAST = 0.04

#: Most labels round an edge: each but one is an equation, and two ends have six coordinates.
_MOST_LABELS = 6

#: Newton steps that are tried; what is left of a volume, as a part of what the steps move to and fro, that
#: is rounding; and what an operation is discarded for.
_NEWTON, _ROUNDING, _TOO_MUCH = 8, 2e-16, 1e-13

#: How much longer, squared, steps may become by the correction; and what is left of them, squared, where it
#: takes all of them back but for rounding.
_LONGER, _TAKEN_BACK = 4.0, 1e-16

#: Pivots, as a part of the largest one, that are rounding: equations that depend on others.
_DEPENDENT = 1e-10


@kernel
def _mark_fans(near, fan):
    # The usual vertex: one cycle of faces, all between the same two labels.
    for v in range(fan.size):
        first = near.corner_offsets[v]
        size = near.corner_offsets[v + 1] - first
        ring = near.ring_offsets[v]
        good = near.kinds[v] == 0 and near.ring_offsets[v + 1] - ring == size
        for i in range(size if good else 0):
            c = near.corners[first + i]
            a = c - c % 3
            after = near.connectivity[a + (c + 1) % 3]
            before = near.connectivity[a + (c + 2) % 3]
            good = good and after == near.ring[ring + i]
            good = good and before == near.ring[ring + (i + 1 if i + 1 < size else 0)]
        fan[v] = good


@kernel
def _fill(starts, ends, points, damping, factor, rows):
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            for axis in range(3):
                rows[v, axis] = points[v, axis]
            rows[v, 3] = factor * damping[v]


@kernel
def _take(starts, ends, rows, points):
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            if rows[v, 3] != 0.0:
                for axis in range(3):
                    points[v, axis] = rows[v, axis]


# -- both ends on faces: one equation ----------------------------------------------------------------


@device
def _look_round(end, v, other, part, rows, first, last, ring, spokes, g, d):
    # spokes[end]: the ring, seen from v; g = 1/6 sum of a x b; d: `part` of the usual step. Returns the place
    # of `other` in the ring.
    x = rows[v, 0]
    y = rows[v, 1]
    z = rows[v, 2]
    gx = 0.0
    gy = 0.0
    gz = 0.0
    sx = 0.0
    sy = 0.0
    sz = 0.0
    at = 0
    k = ring[last - 1]
    bx = rows[k, 0] - x
    by = rows[k, 1] - y
    bz = rows[k, 2] - z
    for r in range(first, last):
        k = ring[r]
        ax = bx
        ay = by
        az = bz
        bx = rows[k, 0] - x
        by = rows[k, 1] - y
        bz = rows[k, 2] - z
        spokes[end, r - first, 0] = bx
        spokes[end, r - first, 1] = by
        spokes[end, r - first, 2] = bz
        gx += ay * bz - az * by
        gy += az * bx - ax * bz
        gz += ax * by - ay * bx
        sx += bx
        sy += by
        sz += bz
        if k == other:
            at = r - first
    g[end, 0] = gx / 6.0
    g[end, 1] = gy / 6.0
    g[end, 2] = gz / 6.0
    share = part * rows[v, 3] / np.float64(last - first)
    d[end, 0] = share * sx
    d[end, 1] = share * sy
    d[end, 2] = share * sz
    return at


@device
def _keep_volume(si, sj, ux, uy, uz, g, d):
    # Newton's method on c(d_i, d_j) = g_i.d_i + g_j.d_j + (d_i x d_j).u; whether it ends at rounding.
    for _ in range(_NEWTON):
        c = 0.0
        scale = 0.0
        for axis in range(3):
            a = g[0, axis] * d[0, axis]
            b = g[1, axis] * d[1, axis]
            c += a + b
            scale += abs(a) + abs(b)
        # d_j x u and u x d_i.
        ix = d[1, 1] * uz - d[1, 2] * uy
        iy = d[1, 2] * ux - d[1, 0] * uz
        iz = d[1, 0] * uy - d[1, 1] * ux
        cross = d[0, 0] * ix + d[0, 1] * iy + d[0, 2] * iz
        c += cross
        scale += abs(cross)
        if abs(c) <= _ROUNDING * scale:
            return True
        ix += g[0, 0]
        iy += g[0, 1]
        iz += g[0, 2]
        jx = g[1, 0] - (d[0, 1] * uz - d[0, 2] * uy)
        jy = g[1, 1] - (d[0, 2] * ux - d[0, 0] * uz)
        jz = g[1, 2] - (d[0, 0] * uy - d[0, 1] * ux)
        square = si * (ix * ix + iy * iy + iz * iz) + sj * (jx * jx + jy * jy + jz * jz)
        if not square > 0.0:
            return False
        y = c / square
        d[0, 0] -= si * y * ix
        d[0, 1] -= si * y * iy
        d[0, 2] -= si * y * iz
        d[1, 0] -= sj * y * jx
        d[1, 1] -= sj * y * jy
        d[1, 2] -= sj * y * jz
    return abs(c) <= _TOO_MUCH * scale


@device
def _square(d):
    total = 0.0
    for axis in range(3):
        total += d[0, axis] * d[0, axis] + d[1, axis] * d[1, axis]
    return total


@device
def _smallest_of_fan(end, share, at, size, first, fan_face, reference, spokes, d):
    # Smallest signed square of k of the faces, after `share` (0 or 1) of the steps.
    other = 1 - end
    px = share * d[end, 0]
    py = share * d[end, 1]
    pz = share * d[end, 2]
    r = size - 1
    bx = spokes[end, r, 0] - px
    by = spokes[end, r, 1] - py
    bz = spokes[end, r, 2] - pz
    if r == at:
        bx += share * d[other, 0]
        by += share * d[other, 1]
        bz += share * d[other, 2]
    least = 2.0
    f = fan_face[first + r]
    for r in range(size):
        ax = bx
        ay = by
        az = bz
        bx = spokes[end, r, 0] - px
        by = spokes[end, r, 1] - py
        bz = spokes[end, r, 2] - pz
        if r == at:
            bx += share * d[other, 0]
            by += share * d[other, 1]
            bz += share * d[other, 2]
        q = triangle_square(ax, ay, az, bx, by, bz, reference[f, 0], reference[f, 1], reference[f, 2])
        f = fan_face[first + r]
        least = min(least, q)
    return least


@device
def _newly_turned_in_fan(end, at, size, first, fan_face, reference, spokes, d):
    other = 1 - end
    for r in range(size):
        s = r + 1 if r + 1 < size else 0
        f = fan_face[first + r]
        before = 0.0
        after = 0.0
        for axis in range(3):
            one = (axis + 1) % 3
            two = (axis + 2) % 3
            n = spokes[end, r, one] * spokes[end, s, two] - spokes[end, r, two] * spokes[end, s, one]
            before += n * reference[f, axis]
            a_one = spokes[end, r, one] - d[end, one] + (d[other, one] if r == at else 0.0)
            a_two = spokes[end, r, two] - d[end, two] + (d[other, two] if r == at else 0.0)
            b_one = spokes[end, s, one] - d[end, one] + (d[other, one] if s == at else 0.0)
            b_two = spokes[end, s, two] - d[end, two] + (d[other, two] if s == at else 0.0)
            after += (a_one * b_two - a_two * b_one) * reference[f, axis]
        if after < 0.0 and not before < 0.0:
            return True
    return False


@routine
def _fans_get_worse(i, j, si, sj, at_i, at_j, near, fan_face, reference, spokes, d, least):
    # Asked only where the smallest k is low: whether it falls, or a face turns over.
    before = 2.0
    for end in range(2):
        v = i if end == 0 else j
        if (si if end == 0 else sj) == 0.0:
            continue
        at = at_i if end == 0 else at_j
        first = near.corner_offsets[v]
        size = near.corner_offsets[v + 1] - first
        before = min(before, _smallest_of_fan(end, 0.0, at, size, first, fan_face, reference, spokes, d))
        if _newly_turned_in_fan(end, at, size, first, fan_face, reference, spokes, d):
            return True
    return least < before


@device
def _on_faces(i, j, part, si, sj, rows, near, fan_face, reference, spokes, g, d):
    # Finds the steps d; whether they may be taken.
    at_i = _look_round(
        0, i, j, part, rows, near.ring_offsets[i], near.ring_offsets[i + 1], near.ring, spokes, g, d
    )
    at_j = _look_round(
        1, j, i, part, rows, near.ring_offsets[j], near.ring_offsets[j + 1], near.ring, spokes, g, d
    )
    size_i = near.ring_offsets[i + 1] - near.ring_offsets[i]
    size_j = near.ring_offsets[j + 1] - near.ring_offsets[j]
    before = at_i - 1 if at_i > 0 else size_i - 1
    after = at_i + 1 if at_i + 1 < size_i else 0
    ux = (spokes[0, after, 0] - spokes[0, before, 0]) / 6.0
    uy = (spokes[0, after, 1] - spokes[0, before, 1]) / 6.0
    uz = (spokes[0, after, 2] - spokes[0, before, 2]) / 6.0
    wanted = _square(d)
    if not _keep_volume(si, sj, ux, uy, uz, g, d):
        return False
    got = _square(d)
    if got <= _TAKEN_BACK * wanted or not got <= _LONGER * wanted:
        return False
    least = 2.0
    if si > 0.0:
        least = _smallest_of_fan(0, 1.0, at_i, size_i, near.corner_offsets[i], fan_face, reference, spokes, d)
    if sj > 0.0:
        of_j = _smallest_of_fan(1, 1.0, at_j, size_j, near.corner_offsets[j], fan_face, reference, spokes, d)
        least = min(least, of_j)
    if least >= _LEAST:
        return True
    return not _fans_get_worse(i, j, si, sj, at_i, at_j, near, fan_face, reference, spokes, d, least)


# -- an end on a line: one equation for each label but one -------------------------------------------

# g[end, l], u[l]: of the l-th label round the edge. spokes[end, c, :3] and [3:] are the two other corners of
# the c-th face at an end, seen from there; role[end, c] is 1 where the first of them is the other end of the
# edge, 2 where the second is, otherwise 0.


@device
def _place_of(label, labels, count):
    for place in range(count):
        if labels[place] == label:
            return place
    if count < labels.size:
        labels[count] = label
    return count


@device
def _gather(end, v, other, rows, near, fan_face, face_labels, spokes, role, labels, count, g, u):
    x = rows[v, 0]
    y = rows[v, 1]
    z = rows[v, 2]
    first = near.corner_offsets[v]
    for row in range(first, near.corner_offsets[v + 1]):
        c = near.corners[row]
        f = fan_face[row]
        at = c - 3 * f
        k = near.connectivity[c + 1 if at < 2 else c - 2]
        w = near.connectivity[c + 2 if at == 0 else c - 1]
        ax = rows[k, 0] - x
        ay = rows[k, 1] - y
        az = rows[k, 2] - z
        bx = rows[w, 0] - x
        by = rows[w, 1] - y
        bz = rows[w, 2] - z
        spokes[end, row - first, 0] = ax
        spokes[end, row - first, 1] = ay
        spokes[end, row - first, 2] = az
        spokes[end, row - first, 3] = bx
        spokes[end, row - first, 4] = by
        spokes[end, row - first, 5] = bz
        role[end, row - first] = 1 if k == other else (2 if w == other else 0)
        nx = (ay * bz - az * by) / 6.0
        ny = (az * bx - ax * bz) / 6.0
        nz = (ax * by - ay * bx) / 6.0
        for side in range(2):
            place = _place_of(face_labels[f, side], labels, count)
            if place == count:
                if count == labels.size:
                    return count + 1
                count += 1
                for axis in range(3):
                    g[0, place, axis] = 0.0
                    g[1, place, axis] = 0.0
                    u[place, axis] = 0.0
            sign = 1.0 - 2.0 * side
            g[end, place, 0] += sign * nx
            g[end, place, 1] += sign * ny
            g[end, place, 2] += sign * nz
            if end == 0 and k == other:
                u[place, 0] += sign * bx / 6.0
                u[place, 1] += sign * by / 6.0
                u[place, 2] += sign * bz / 6.0
            elif end == 0 and w == other:
                u[place, 0] -= sign * ax / 6.0
                u[place, 1] -= sign * ay / 6.0
                u[place, 2] -= sign * az / 6.0
    return count


@device
def _step_along_row(end, v, part, rows, near, d):
    first = near.row_offsets[v]
    last = near.row_offsets[v + 1]
    share = part * rows[v, 3] / np.float64(last - first)
    for axis in range(3):
        total = 0.0
        for r in range(first, last):
            total += rows[near.row[r], axis] - rows[v, axis]
        d[end, axis] = share * total


@device
def _solve(matrix, right, n):
    # L D L^T in place; what depends on other equations gets 0.
    largest = 0.0
    for k in range(n):
        largest = max(largest, matrix[k, k])
    for k in range(n):
        pivot = matrix[k, k]
        if not pivot > _DEPENDENT * largest:
            matrix[k, k] = 0.0
            continue
        for r in range(k + 1, n):
            factor = matrix[r, k] / pivot
            for c in range(k + 1, r + 1):
                matrix[r, c] -= factor * matrix[c, k]
        for r in range(k + 1, n):
            matrix[r, k] /= pivot
    for k in range(n):
        if matrix[k, k] == 0.0:
            right[k] = 0.0
        for r in range(k + 1, n):
            if matrix[k, k] != 0.0:
                right[r] -= matrix[r, k] * right[k]
    for k in range(n):
        if matrix[k, k] != 0.0:
            right[k] /= matrix[k, k]
    for k in range(n - 1, -1, -1):
        if matrix[k, k] != 0.0:
            for r in range(k + 1, n):
                right[k] -= matrix[r, k] * right[r]


@device
def _keep_volumes(n, si, sj, g, u, d, rows_of, matrix, right):
    # As _keep_volume, for n labels at once.
    for turn in range(_NEWTON + 1):
        rounding = True
        small = True
        for k in range(n):
            ix = d[1, 1] * u[k, 2] - d[1, 2] * u[k, 1]
            iy = d[1, 2] * u[k, 0] - d[1, 0] * u[k, 2]
            iz = d[1, 0] * u[k, 1] - d[1, 1] * u[k, 0]
            c = d[0, 0] * ix + d[0, 1] * iy + d[0, 2] * iz
            scale = abs(c)
            for axis in range(3):
                a = g[0, k, axis] * d[0, axis]
                b = g[1, k, axis] * d[1, axis]
                c += a + b
                scale += abs(a) + abs(b)
            right[k] = c
            rounding = rounding and abs(c) <= _ROUNDING * scale
            small = small and abs(c) <= _TOO_MUCH * scale
            rows_of[k, 0] = g[0, k, 0] + ix
            rows_of[k, 1] = g[0, k, 1] + iy
            rows_of[k, 2] = g[0, k, 2] + iz
            rows_of[k, 3] = g[1, k, 0] - (d[0, 1] * u[k, 2] - d[0, 2] * u[k, 1])
            rows_of[k, 4] = g[1, k, 1] - (d[0, 2] * u[k, 0] - d[0, 0] * u[k, 2])
            rows_of[k, 5] = g[1, k, 2] - (d[0, 0] * u[k, 1] - d[0, 1] * u[k, 0])
        if rounding or turn == _NEWTON:
            return small
        for k in range(n):
            for m in range(k + 1):
                at_i = 0.0
                at_j = 0.0
                for axis in range(3):
                    at_i += rows_of[k, axis] * rows_of[m, axis]
                    at_j += rows_of[k, 3 + axis] * rows_of[m, 3 + axis]
                matrix[k, m] = si * at_i + sj * at_j
        _solve(matrix, right, n)
        for k in range(n):
            for axis in range(3):
                d[0, axis] -= si * right[k] * rows_of[k, axis]
                d[1, axis] -= sj * right[k] * rows_of[k, 3 + axis]
    return False


@device
def _may_turn(end, v, near, fan_face, reference, spokes, role, d, which):
    # Smallest signed square of k of the faces at an end before the steps (which = 0) or after them (1); of
    # `which` 2 it is -2 where a face turns over.
    other = 1 - end
    first = near.corner_offsets[v]
    least = 2.0
    for row in range(first, near.corner_offsets[v + 1]):
        i = row - first
        f = fan_face[row]
        rx = reference[f, 0]
        ry = reference[f, 1]
        rz = reference[f, 2]
        ax = spokes[end, i, 0]
        ay = spokes[end, i, 1]
        az = spokes[end, i, 2]
        bx = spokes[end, i, 3]
        by = spokes[end, i, 4]
        bz = spokes[end, i, 5]
        old = 0.0
        if which != 1:
            old = triangle_square(ax, ay, az, bx, by, bz, rx, ry, rz)
            least = min(least, old)
        if which == 0:
            continue
        ax -= d[end, 0]
        ay -= d[end, 1]
        az -= d[end, 2]
        bx -= d[end, 0]
        by -= d[end, 1]
        bz -= d[end, 2]
        if role[end, i] == 1:
            ax += d[other, 0]
            ay += d[other, 1]
            az += d[other, 2]
        elif role[end, i] == 2:
            bx += d[other, 0]
            by += d[other, 1]
            bz += d[other, 2]
        new = triangle_square(ax, ay, az, bx, by, bz, rx, ry, rz)
        if which == 1:
            least = min(least, new)
        elif new < 0.0 and not old < 0.0:
            return -2.0
    return least


@routine
def _on_lines(i, j, part, si, sj, rows, near, fan_face, face_labels, reference, room, d):
    # Finds the steps d; whether they may be taken.
    spokes, role, labels, g, u, rows_of, matrix, right = room
    count = _gather(0, i, j, rows, near, fan_face, face_labels, spokes, role, labels, 0, g, u)
    if count <= labels.size:
        count = _gather(1, j, i, rows, near, fan_face, face_labels, spokes, role, labels, count, g, u)
    free = 3 * (si > 0.0) + 3 * (sj > 0.0)
    # The equations of all labels sum to 0: the last one follows from the others.
    if count > labels.size or count - 1 >= free:
        return False
    for end in range(2):
        v = i if end == 0 else j
        _step_along_row(end, v, part, rows, near, d)
    wanted = _square(d)
    if not _keep_volumes(count - 1, si, sj, g, u, d, rows_of, matrix, right):
        return False
    got = _square(d)
    if got <= _TAKEN_BACK * wanted or not got <= _LONGER * wanted:
        return False
    least = 2.0
    for end in range(2):
        if (si if end == 0 else sj) > 0.0:
            v = i if end == 0 else j
            least = min(least, _may_turn(end, v, near, fan_face, reference, spokes, role, d, 1))
    if least >= _LEAST:
        return True
    before = 2.0
    for end in range(2):
        if (si if end == 0 else sj) > 0.0:
            v = i if end == 0 else j
            of_end = _may_turn(end, v, near, fan_face, reference, spokes, role, d, 2)
            if of_end == -2.0:
                return False
            before = min(before, of_end)
    return least >= before


@allocating
def _scratch(widest):
    return (
        np.empty((2, widest, 3)),
        np.empty((2, 3)),
        (
            np.empty((2, widest, 6)),
            np.empty((2, widest), np.uint8),
            np.empty(_MOST_LABELS, np.int32),
            np.empty((2, _MOST_LABELS, 3)),
            np.empty((_MOST_LABELS, 3)),
            np.empty((_MOST_LABELS, 6)),
            np.empty((_MOST_LABELS, _MOST_LABELS)),
            np.empty(_MOST_LABELS),
        ),
    )


@device
def _steps(i, j, part, fan, rows, near, fan_face, face_labels, reference, scratch, d):
    # Finds the steps d, `part` of what they usually are; whether they may be taken.
    spokes, g, room = scratch
    si = part * rows[i, 3]
    sj = part * rows[j, 3]
    if si == 0.0 and sj == 0.0:
        return False
    if fan[i] and fan[j]:
        return _on_faces(i, j, part, si, sj, rows, near, fan_face, reference, spokes, g, d)
    return _on_lines(i, j, part, si, sj, rows, near, fan_face, face_labels, reference, room, d)


@device
def _move(v, end, rows, d):
    if rows[v, 3] > 0.0:
        for axis in range(3):
            rows[v, axis] += d[end, axis]


@kernel
def _sweep(starts, ends, edges, fan, widest, rows, near, fan_face, face_labels, reference):
    # rows[v]: position, and the part of its step that is taken.
    moved = 0
    d = np.empty((2, 3))
    scratch = _scratch(widest)
    for part in range(starts.size):
        for e in range(starts[part], ends[part]):
            i = edges[e, 0]
            j = edges[e, 1]
            if _steps(i, j, 1.0, fan, rows, near, fan_face, face_labels, reference, scratch, d):
                _move(i, 0, rows, d)
                _move(j, 1, rows, d)
                moved += 1
    return moved


@kernel
def _propose(
    starts, ends, chosen, edges, fan, widest, rows, near, fan_face, face_labels, reference,
    part, steps, good, proposed,
):  # fmt: skip
    # The steps of the `chosen` edges, `part` of what they usually are each, and whether there are any.
    scratch = _scratch(widest)
    for share in range(starts.size):
        for k in range(starts[share], ends[share]):
            i = edges[chosen[k], 0]
            j = edges[chosen[k], 1]
            d = steps[k]
            good[k] = _steps(i, j, part[k], fan, rows, near, fan_face, face_labels, reference, scratch, d)
            for axis in range(3):
                proposed[i, axis] = rows[i, axis] + d[0, axis] if rows[i, 3] > 0.0 else rows[i, axis]
                proposed[j, axis] = rows[j, axis] + d[1, axis] if rows[j, 3] > 0.0 else rows[j, axis]


@kernel
def _carry_out(starts, ends, chosen, edges, steps, good, rows, points):
    # The steps that are `good`.
    moved = 0
    for share in range(starts.size):
        for k in range(starts[share], ends[share]):
            if not good[k]:
                continue
            for end in range(2):
                v = edges[chosen[k], end]
                _move(v, end, rows, steps[k])
                for axis in range(3):
                    points[v, axis] = rows[v, axis]
            moved += 1
    return moved


class PairwiseLabels(EdgeScheme):
    """Pairwise smoothing of a surface between labels, for triangles: every label keeps its volume.

    For each edge (i, j) both ends take a part of their umbrella steps, on lines towards the mean of the
    neighbours along it. Then both move by the least that gives all labels back their volume: an equation
    for each label round the edge but one, exact by Newton's method, as the equations are bilinear in the two
    steps. Generalises Liu, Bao, Shum and Peng (2002) from two labels to any number.

    A single vertex on a line could move along it only, and one where four labels meet not at all: pairs can.

    An operation is discarded where a face would turn over, or where the smallest k round the edge would fall
    while it is below 0.2.

    Parameters
    ----------
    relaxation : float
        Part of the umbrella step that each operation takes, (0, 1]. A vertex takes part in an operation for
        each of its edges.

    Notes
    -----
    An operation costs O(valence). The order of the operations, and how threads share them, is that of
    :class:`~vtksmooth.kernels.smoothing.schemes.pairwise.Pairwise`.
    """

    keeps = frozenset({"volume", "inversion"})
    moves_lines = True
    guarded = False

    def __init__(self, relaxation: float = 0.2) -> None:
        self.relaxation = relaxation

    def closing(self) -> Constraint | None:
        return LabelVolumes()

    def bind(self, state: State) -> None:
        labels = state.topology.face_labels
        if labels is None:
            raise InvalidMeshError("Smoothing all labels needs the labels of both sides of each face.")
        if not state.topology.only_triangles:
            raise InvalidMeshError(
                "Pairwise smoothing needs triangles; triangulate the polygons first (ValenceTriangulation)."
            )
        near = state.near
        self.face_labels = labels
        turn_into_cycles(near)
        n = len(near.kinds)
        self.fan = np.empty(n, np.uint8)
        _mark_fans(near, self.fan)
        self.fan_face = near.corner_face[near.corners]
        self.widest = int(np.diff(near.corner_offsets).max())
        vertex = np.repeat(np.arange(n, dtype=np.int32), np.diff(near.ring_offsets))
        once = near.ring > vertex
        once &= (state.pinned[vertex] == 0) | (state.pinned[near.ring] == 0)
        ends = np.column_stack((vertex[once], near.ring[once]))
        order, self.blocks = in_blocks(ends, near.ring_offsets, near.ring)
        self.ends = np.ascontiguousarray(ends[order])
        self.rows, self.proposed = np.empty((n, 4)), np.empty((n, 3))
        self.batches: list[Int64] = []

    def sweep(
        self, state: State, damping: Float64, guard: Guard, admitted: Admitted | None = None
    ) -> Iterator[Operations]:
        everything = parallel.ranges(len(state.points))
        parallel.run(_fill, *everything, state.points, damping, self.relaxation, self.rows)
        if admitted is not None:
            near = state.near
            self.batches = self.batches or batches_of(self.ends, near.ring_offsets, near.ring)
            for number, batch in enumerate(self.batches):
                done = in_halves(
                    state, batch, self.ends, admitted, partial(self._propose, state), partial(self._do, state)
                )
                yield Operations((number + 1) / len(self.batches), *done)
            return
        for number, (starts, ends) in enumerate(self.blocks):
            results = parallel.run(
                _sweep, starts, ends,
                self.ends, self.fan, self.widest, self.rows, state.near, self.fan_face, self.face_labels,
                state.reference, smallest_share=parallel.COSTLY,
            )  # fmt: skip
            parallel.run(_take, *everything, self.rows, state.points)
            yield Operations((number + 1) / len(self.blocks), sum(results), 0, 0)

    def _propose(self, state: State, batch: Int64, part: Float64) -> tuple[Float64, Float64, Bool]:
        steps, good = np.zeros((len(batch), 2, 3)), np.empty(len(batch), np.bool_)
        parallel.run(
            _propose, *parallel.ranges(len(batch), size=64),
            batch, self.ends, self.fan, self.widest, self.rows, state.near, self.fan_face, self.face_labels,
            state.reference, part, steps, good, self.proposed, smallest_share=parallel.COSTLY,
        )  # fmt: skip
        return self.proposed, steps, good

    def _do(self, state: State, batch: Int64, steps: Float64, good: Bool) -> Int64:
        results = parallel.run(
            _carry_out, *parallel.ranges(len(batch), size=64),
            batch, self.ends, steps, good, self.rows, state.points, smallest_share=parallel.COSTLY,
        )  # fmt: skip
        # Limits that learn from what they admit see who has not gone there.
        stay = self.ends[batch[~good]].ravel()
        self.proposed[stay] = state.points[stay]
        return np.array([sum(results), 0, 0])
