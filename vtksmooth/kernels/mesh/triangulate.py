"""Polygons into triangles so that vertex valences come near six (the installation-space paper, section 4.1).

The greedy algorithm of the paper's Figure 2, then flips of the edges that it inserted. Time is linear in
the number of polygons: valences only grow while edges are inserted, so in place of a heap the candidates
are gone through once for each valence that occurs.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ...errors import InvalidMeshError
from ...jit.compiled import device, kernel, routine
from .adjacency import BOUNDARY, one_rings, vertex_corners
from .lines import sides_on_lines
from .mesh import Mesh

Int32 = npt.NDArray[np.int32]

#: Polygons with more corners are cut down to this many by clipping ears: looking at all triangles of a
#: polygon takes cubic time.
MOST_CORNERS = 16

#: Valences from here on count as equal, which bounds the number of passes over the candidates.
HIGHEST_VALENCE = 32

#: Twice the area of a triangle, as a part of its longest side's square, that it must exceed: slivers only
#: where there is nothing better (or for a corner that lies on a side), and never what rounding alone makes.
SLIVER, FLAT = 1e-3, 1e-12

#: What has become of a diagonal.
_DEAD, _FREE, _INSERTED = 0, 1, 2

# The diagonals of a polygon stand in the order (0, 2), (0, 3), .. (1, 3), (1, 4), .. of its corners.


# -- the triangles of one polygon --------------------------------------------------------------------


@device
def _unit_normal(points, corners, first, size):
    # Of the polygon's area vector, by edge differences; 0 for polygons without an area.
    nx = 0.0
    ny = 0.0
    nz = 0.0
    longest = 0.0
    o = corners[first]
    for c in range(1, size - 1):
        p = corners[first + c]
        q = corners[first + c + 1]
        ax = points[p, 0] - points[o, 0]
        ay = points[p, 1] - points[o, 1]
        az = points[p, 2] - points[o, 2]
        bx = points[q, 0] - points[o, 0]
        by = points[q, 1] - points[o, 1]
        bz = points[q, 2] - points[o, 2]
        nx += ay * bz - az * by
        ny += az * bx - ax * bz
        nz += ax * by - ay * bx
        longest = max(longest, max(ax * ax + ay * ay + az * az, bx * bx + by * by + bz * bz))
    length = np.sqrt(nx * nx + ny * ny + nz * nz)
    if length <= FLAT * longest:
        return 0.0, 0.0, 0.0
    return nx / length, ny / length, nz / length


@routine
def _good(points, p, q, r, nx, ny, nz, least):
    # Whether the triangle is turned like its polygon, whose unit normal is n, and no sliver.
    ax = points[q, 0] - points[p, 0]
    ay = points[q, 1] - points[p, 1]
    az = points[q, 2] - points[p, 2]
    bx = points[r, 0] - points[p, 0]
    by = points[r, 1] - points[p, 1]
    bz = points[r, 2] - points[p, 2]
    cx = bx - ax
    cy = by - ay
    cz = bz - az
    area = nx * (ay * bz - az * by) + ny * (az * bx - ax * bz) + nz * (ax * by - ay * bx)
    square = max(ax * ax + ay * ay + az * az, bx * bx + by * by + bz * bz)
    return area > least * max(square, cx * cx + cy * cy + cz * cz)


@device
def _turns_once(points, corners, first, size, nx, ny, nz):
    # Whether the sides, seen along the normal, turn by 360 degrees in all. A polygon that goes round twice
    # falls into triangles of the right turning, but they overlap.
    total = 0.0
    px = 0.0
    py = 0.0
    pz = 0.0
    for c in range(2 * size):
        p = corners[first + c % size]
        q = corners[first + (c + 1) % size]
        qx = points[q, 0] - points[p, 0]
        qy = points[q, 1] - points[p, 1]
        qz = points[q, 2] - points[p, 2]
        along = qx * nx + qy * ny + qz * nz
        qx -= along * nx
        qy -= along * ny
        qz -= along * nz
        if qx == 0.0 and qy == 0.0 and qz == 0.0:
            continue
        if c >= size:  # the first round only finds the last side that has a length
            across = nx * (py * qz - pz * qy) + ny * (pz * qx - px * qz) + nz * (px * qy - py * qx)
            total += np.arctan2(across, px * qx + py * qy + pz * qz)
        px = qx
        py = qy
        pz = qz
    return total < 3.0 * np.pi


@device
def _judge(points, corners, first, size, least, good):
    # good[a, b, c] for all corners in their cyclic order.
    nx, ny, nz = _unit_normal(points, corners, first, size)
    for a in range(size):
        for b in range(a + 1, size):
            for c in range(b + 1, size):
                p = corners[first + a]
                q = corners[first + b]
                r = corners[first + c]
                fine = p != q and q != r and r != p
                fine = fine and (least < 0.0 or _good(points, p, q, r, nx, ny, nz, least))
                good[a, b, c] = fine
                good[b, c, a] = fine
                good[c, a, b] = fine


@device
def _explore(good, usable, size, can):
    # can[a, l]: whether the part with the corners a, a + 1, .. a + l, cut off by the chord from the first
    # to the last, falls into good triangles by usable diagonals. The whole polygon: can[0, size - 1].
    for a in range(size):
        can[a, 1] = True
    for length in range(2, size):
        for a in range(size):
            b = (a + length) % size
            can[a, length] = False
            for step in range(1, length):
                c = (a + step) % size
                if (
                    can[a, step]
                    and can[c, length - step]
                    and good[a, c, b]
                    and (step == 1 or usable[a, c])
                    and (length - step == 1 or usable[c, b])
                ):
                    can[a, length] = True
                    break


@device
def _read_fates(fate, first, size, usable):
    k = first
    for a in range(size - 2):
        for b in range(a + 2, size - (a == 0)):
            usable[a, b] = fate[k] != _DEAD
            usable[b, a] = usable[a, b]
            k += 1


@device
def _kill(fate, first, size, can):
    # Free diagonals become dead where the polygon cannot be triangulated with them.
    k = first
    for a in range(size - 2):
        for b in range(a + 2, size - (a == 0)):
            if fate[k] == _FREE and not (can[a, b - a] and can[b, size - b + a]):
                fate[k] = _DEAD
            k += 1


@routine
def _narrow(points, offsets, corners, f, first, least, fate, good, usable, can):
    # Kill the free diagonals that no longer serve; whether the polygon can be triangulated at all.
    size = offsets[f + 1] - offsets[f]
    _read_fates(fate, first, size, usable)
    _judge(points, corners, offsets[f], size, least[f], good)
    _explore(good, usable, size, can)
    if can[0, size - 1]:
        _kill(fate, first, size, can)
    return can[0, size - 1]


@kernel
def _find_candidates(points, offsets, corners, first_candidate, face, ends, fate, least, lines, room):
    """List every polygon's diagonals, and set free those with which it can be triangulated.

    A quadrilateral with a corner between two `lines` (sides after corners, or empty) is split from there.

    Returns how many polygons have no triangulation, and the first of them.
    """
    good, usable, can = room
    impossible = 0
    culprit = -1
    for f in range(offsets.size - 1):
        first = offsets[f]
        size = offsets[f + 1] - first
        if size < 4:
            continue
        k = first_candidate[f]
        for a in range(size - 2):
            for b in range(a + 2, size - (a == 0)):
                face[k] = f
                ends[k, 0] = a
                ends[k, 1] = b
                fate[k] = _FREE
                k += 1
        nx, ny, nz = _unit_normal(points, corners, first, size)
        # Without an area there is nothing to keep: valences decide.
        flat = nx == 0.0 and ny == 0.0 and nz == 0.0
        possible = False
        once = flat or size == 4 or _turns_once(points, corners, first, size, nx, ny, nz)
        for attempt in range(2 if once else 0):
            least[f] = -1.0 if flat else (SLIVER if attempt == 0 else FLAT)
            if size == 4:
                p, q, r, s = corners[first], corners[first + 1], corners[first + 2], corners[first + 3]
                first_fine = p != r
                second_fine = q != s
                if not flat:
                    first_fine = (
                        first_fine
                        and _good(points, p, q, r, nx, ny, nz, least[f])
                        and _good(points, p, r, s, nx, ny, nz, least[f])
                    )
                    second_fine = (
                        second_fine
                        and _good(points, p, q, s, nx, ny, nz, least[f])
                        and _good(points, q, r, s, nx, ny, nz, least[f])
                    )
                fate[first_candidate[f]] = first_fine
                fate[first_candidate[f] + 1] = second_fine
                possible = first_fine or second_fine
                if first_fine and second_fine and lines.size > 0:
                    # A triangle with two sides on a line would lose its area where the line is straight.
                    a = lines[first]
                    b = lines[first + 1]
                    c = lines[first + 2]
                    d = lines[first + 3]
                    from_first = (d and a) or (b and c)
                    from_second = (a and b) or (c and d)
                    if from_first != from_second:
                        fate[first_candidate[f] + (1 if from_first else 0)] = _DEAD
                        least[f] = -1.0  # and is not flipped
            else:
                possible = _narrow(
                    points, offsets, corners, f, first_candidate[f], least, fate, good, usable, can
                )
            if possible or flat:
                break
        if not possible:
            impossible += 1
            if culprit < 0:
                culprit = f
    return impossible, culprit


# -- edges that are there ----------------------------------------------------------------------------

# Inserted edges are kept in a linked list for each vertex: head[v], after[entry], other_end[entry]. The
# entries of diagonal k are 2 k at its first corner and 2 k + 1 at its second.


@device
def _joined(p, q, valence, ring_offsets, ring, inserted):
    head, after, other_end = inserted
    if valence[p] > valence[q]:
        p, q = q, p
    for r in range(ring_offsets[p], ring_offsets[p + 1]):
        if ring[r] == q:
            return True
    entry = head[p]
    while entry >= 0:
        if other_end[entry] == q:
            return True
        entry = after[entry]
    return False


@device
def _insert(k, p, q, valence, inserted):
    head, after, other_end = inserted
    for side in range(2):
        v = p if side == 0 else q
        entry = 2 * k + side
        other_end[entry] = q if side == 0 else p
        after[entry] = head[v]
        head[v] = entry
        valence[v] += 1


@device
def _remove(k, p, q, valence, inserted):
    head, after, _ = inserted
    for side in range(2):
        v = p if side == 0 else q
        entry = head[v]
        if entry == 2 * k + side:
            head[v] = after[entry]
        else:
            while after[entry] != 2 * k + side:
                entry = after[entry]
            after[entry] = after[2 * k + side]
        valence[v] -= 1


# -- the whole mesh ----------------------------------------------------------------------------------


@kernel
def _greedy(
    points,
    offsets,
    corners,
    first_candidate,
    face,
    ends,
    fate,
    least,
    room,
    ring_offsets,
    ring,
    valence,
    inserted,
    waiting,
):
    """Insert the free diagonal whose greater valence is lowest, again and again (Figure 2)."""
    good, usable, can = room
    count = waiting.size
    level = 0
    while count > 0:
        # In order; those of a higher valence wait. Valences only grow, so none of those passed over can
        # fall back to this level.
        left = 0
        lowest = HIGHEST_VALENCE
        for i in range(count):
            k = waiting[i]
            if fate[k] != _FREE:
                continue
            f = np.int64(face[k])
            size = offsets[f + 1] - offsets[f]
            a = np.int64(ends[k, 0])
            b = np.int64(ends[k, 1])
            p = corners[offsets[f] + a]
            q = corners[offsets[f] + b]
            greater = min(HIGHEST_VALENCE, max(valence[p], valence[q]))
            if greater > level:
                lowest = min(lowest, greater)
                waiting[left] = k
                left += 1
                continue
            first = first_candidate[f]
            if _joined(p, q, valence, ring_offsets, ring, inserted):
                # More than two faces would meet in this edge: only where there is no other way.
                fate[k] = _DEAD
                if size == 4:
                    if fate[first] == _FREE or fate[first + 1] == _FREE:
                        continue
                elif _narrow(points, offsets, corners, f, first, least, fate, good, usable, can):
                    continue
            fate[k] = _INSERTED
            _insert(k, p, q, valence, inserted)
            if size == 4:
                fate[first if k > first else first + 1] = _DEAD
                continue
            x = first
            for c in range(size - 2):
                for d in range(c + 2, size - (c == 0)):
                    if fate[x] == _FREE and (a < c < b < d or c < a < d < b):
                        fate[x] = _DEAD
                    x += 1
            _narrow(points, offsets, corners, f, first, least, fate, good, usable, can)
        count = left
        level = max(level + 1, lowest)


@device
def _excess(v, change, valence, kinds):
    # What a change of the valence of v adds to the sum of |6 - valence| (boundary: 4), equation (1); where
    # that is nothing, to the sum of the squares, which spreads what is left: an 8 and a 6 become two 7.
    old = valence[v] - (4 if kinds[v] == BOUNDARY else 6)
    new = old + change
    return 1024 * (abs(new) - abs(old)) + max(-255, min(255, new * new - old * old))


@device
def _number(a, b, size):
    # Place of the diagonal (a, b), a < b, among those of its polygon.
    if a == 0:
        return b - 2
    return size - 3 + (a - 1) * (size - 2) - a * (a - 1) // 2 + b - a - 2


@device
def _linked(a, b, size, first, fate):
    # Whether two corners of a polygon are joined by a side or an inserted diagonal of it.
    if a > b:
        a, b = b, a
    if b - a == 1 or b - a == size - 1:
        return True
    return fate[first + _number(a, b, size)] == _INSERTED


@routine
def _opposite(a, b, size, first, fate):
    # The corner of the triangle on the side of a .. b of the chord from a on to b.
    c = (a + 1) % size
    while not (_linked(a, c, size, first, fate) and _linked(c, b, size, first, fate)):
        c = (c + 1) % size
    return c


@kernel
def _flip(
    points,
    offsets,
    corners,
    first_candidate,
    ends,
    fate,
    least,
    ring_offsets,
    ring,
    kinds,
    valence,
    inserted,
):
    """Flip every inserted edge where that lowers the sum of equation (1); return how many were."""
    flips = 0
    for f in range(offsets.size - 1):
        corner = offsets[f]
        size = offsets[f + 1] - corner
        first = first_candidate[f]
        for k in range(first, first_candidate[f + 1]):
            if fate[k] != _INSERTED or least[f] < 0.0:
                continue
            a = np.int64(ends[k, 0])
            b = np.int64(ends[k, 1])
            c = _opposite(a, b, size, first, fate)
            d = _opposite(b, a, size, first, fate)
            p = corners[corner + a]
            q = corners[corner + b]
            r = corners[corner + c]
            s = corners[corner + d]
            gain = _excess(p, -1, valence, kinds) + _excess(q, -1, valence, kinds)
            gain += _excess(r, 1, valence, kinds) + _excess(s, 1, valence, kinds)
            if gain >= 0 or _joined(r, s, valence, ring_offsets, ring, inserted):
                continue
            nx, ny, nz = _unit_normal(points, corners, corner, size)
            if not (
                _good(points, p, r, s, nx, ny, nz, least[f]) and _good(points, r, q, s, nx, ny, nz, least[f])
            ):
                continue
            _remove(k, p, q, valence, inserted)
            fate[k] = _DEAD
            if c > d:
                c, d, r, s = d, c, s, r
            k = first + _number(c, d, size)
            _insert(k, r, s, valence, inserted)
            fate[k] = _INSERTED
            flips += 1
    return flips


@kernel
def _write(offsets, corners, first_candidate, fate, triangles, cell):
    stack = np.empty((MOST_CORNERS, 2), np.int64)
    t = 0
    for f in range(offsets.size - 1):
        corner = offsets[f]
        size = offsets[f + 1] - corner
        if size < 3:
            continue
        stack[0, 0] = 0
        stack[0, 1] = size - 1
        top = 1
        while top > 0:
            top -= 1
            a = stack[top, 0]
            b = stack[top, 1]
            c = _opposite(a, b, size, first_candidate[f], fate)
            triangles[t, 0] = corners[corner + a]
            triangles[t, 1] = corners[corner + c]
            triangles[t, 2] = corners[corner + b]
            cell[t] = f
            t += 1
            if b - c > 1:
                stack[top, 0] = c
                stack[top, 1] = b
                top += 1
            if c - a > 1:
                stack[top, 0] = a
                stack[top, 1] = c
                top += 1
    return t


# -- polygons that are not as they should be ---------------------------------------------------------


@kernel
def _clip_ears(points, polygon, size, wanted, ears):
    """Cut ears off the polygon in `polygon[:size]`, in place, until `wanted` corners are left.

    A round takes an ear and leaves the next corner, so that the cuts spread. Returns how many corners are
    left; more than `wanted` where the polygon crosses itself.
    """
    nx, ny, nz = _unit_normal(points, polygon, 0, size)
    flat = nx == 0.0 and ny == 0.0 and nz == 0.0
    if not flat and not _turns_once(points, polygon, 0, size, nx, ny, nz):
        return size
    reflex = np.empty(size, np.int64)
    n_ears = 0
    least = SLIVER
    while size > wanted:
        # Only corners that are not convex can lie in an ear.
        n_reflex = 0
        for c in range(0 if flat else size):
            q = polygon[c]
            if not _good(
                points, polygon[(c + size - 1) % size], q, polygon[(c + 1) % size], nx, ny, nz, FLAT
            ):
                reflex[n_reflex] = q
                n_reflex += 1
        left = 0
        remaining = size
        before = polygon[size - 1]
        first = polygon[0]
        skip = False
        for c in range(size):
            q = polygon[c]
            after = polygon[c + 1] if c + 1 < size else first
            ear = not skip and remaining > wanted and before != after
            ear = ear and (flat or _good(points, before, q, after, nx, ny, nz, least))
            for i in range(n_reflex if ear else 0):
                v = reflex[i]
                if v in (before, q, after):
                    continue
                outside = False
                for side in range(3):
                    a = before if side == 0 else (q if side == 1 else after)
                    b = q if side == 0 else (after if side == 1 else before)
                    outside = outside or _good(points, a, v, b, nx, ny, nz, 0.0)
                if not outside:
                    ear = False
                    break
            skip = ear
            if ear:
                ears[n_ears, 0] = before
                ears[n_ears, 1] = q
                ears[n_ears, 2] = after
                n_ears += 1
                remaining -= 1
                if c == 0:
                    first = after
            else:
                polygon[left] = q
                left += 1
                before = q
        if left == size:
            if least == FLAT:
                break
            least = FLAT
        size = left
    return size


@kernel
def _is_odd(offsets, corners):
    for f in range(offsets.size - 1):
        a = offsets[f]
        b = offsets[f + 1]
        if b - a < 3 or b - a > MOST_CORNERS:
            return True
        for c in range(a, b):
            if b - a > 3 and corners[c] == corners[c + 1 if c + 1 < b else a]:
                return True
    return False


@kernel
def _prepare(points, offsets, corners, widest, new_offsets, new_corners, face):
    """Leave out what is no polygon and corners named twice in a row; cut large polygons down.

    Returns the number of faces, how many polygons cannot be cut down, and the first of them.
    """
    polygon = np.empty(widest, np.int32)
    ears = np.empty((widest, 3), np.int32)
    m = 0
    k = 0
    new_offsets[0] = 0
    impossible = 0
    culprit = -1
    for f in range(offsets.size - 1):
        size = 0
        triangle = offsets[f + 1] - offsets[f] == 3
        for c in range(offsets[f], offsets[f + 1]):
            if triangle or size == 0 or corners[c] != polygon[size - 1]:
                polygon[size] = corners[c]
                size += 1
        while size > 1 and polygon[size - 1] == polygon[0] and not triangle:
            size -= 1
        if size < 3:
            continue
        whole = size
        if size > MOST_CORNERS:
            size = _clip_ears(points, polygon, size, MOST_CORNERS, ears)
            if size > MOST_CORNERS:
                impossible += 1
                if culprit < 0:
                    culprit = f
                continue
        for e in range(whole - size):
            for c in range(3):
                new_corners[k] = ears[e, c]
                k += 1
            face[m] = f
            m += 1
            new_offsets[m] = k
        for c in range(size):
            new_corners[k] = polygon[c]
            k += 1
        face[m] = f
        m += 1
        new_offsets[m] = k
    return m, impossible, culprit


@kernel
def _cut_each(points, offsets, corners, widest, triangles, face):
    polygon = np.empty(widest, np.int32)
    m = 0
    for f in range(offsets.size - 1):
        first = offsets[f]
        size = offsets[f + 1] - first
        for c in range(size):
            polygon[c] = corners[first + c]
        ears = triangles[m:]
        count = size - 2
        if size == 4:
            p, q, r, s = polygon[0], polygon[1], polygon[2], polygon[3]
            nx, ny, nz = _unit_normal(points, polygon, 0, 4)
            one = _good(points, p, q, r, nx, ny, nz, FLAT) and _good(points, p, r, s, nx, ny, nz, FLAT)
            two = _good(points, p, q, s, nx, ny, nz, FLAT) and _good(points, q, r, s, nx, ny, nz, FLAT)
            if two and (not one or _square(points, q, s) < _square(points, p, r)):
                polygon[0], polygon[1], polygon[2], polygon[3] = q, r, s, p
            size = 3
            ears[0, 0], ears[0, 1], ears[0, 2] = polygon[0], polygon[2], polygon[3]
        elif size > 4:
            size = _clip_ears(points, polygon, size, 3, ears)
        if size > 3:  # it crosses itself
            for c in range(count):
                ears[c, 0], ears[c, 1], ears[c, 2] = (
                    corners[first],
                    corners[first + c + 1],
                    corners[first + c + 2],
                )
        elif count > 0:
            ears[count - 1, 0], ears[count - 1, 1], ears[count - 1, 2] = polygon[0], polygon[1], polygon[2]
        for c in range(count):
            face[m + c] = f
        m += max(0, count)
    return m


@device
def _square(points, p, q):
    total = 0.0
    for axis in range(3):
        total += (points[p, axis] - points[q, axis]) ** 2
    return total


def cut(mesh: Mesh) -> tuple[Int32, Int32]:
    """Split each polygon by itself, by where its corners are alone.

    Quadrilaterals along the shorter of the diagonals that lie inside, others by clipping ears; those that
    cross themselves as fans round their first corner.

    Parameters
    ----------
    mesh : Mesh

    Returns
    -------
    triangles : (t, 3) int32
        Polygon by polygon; faces with fewer than three corners are left out.
    face : (t,) int32
        The face that each triangle is part of.

    Examples
    --------
    >>> from vtksmooth.kernels.mesh.mesh import Mesh
    >>> concave = Mesh.from_faces([[0, 0, 0], [4, 0, 0], [1, 1, 0], [0, 4, 0]], [[0, 1, 2, 3]])
    >>> cut(concave)[0].tolist()
    [[0, 2, 3], [0, 1, 2]]
    """
    if mesh.only_triangles:
        return mesh.connectivity.reshape(-1, 3), np.arange(mesh.n_faces, dtype=np.int32)
    sizes = mesh.face_sizes
    count = int(np.maximum(sizes - 2, 0).sum(dtype=np.int64))
    triangles, face = np.empty((count, 3), np.int32), np.empty(count, np.int32)
    _cut_each(mesh.points, mesh.offsets, mesh.connectivity, int(sizes.max(initial=3)), triangles, face)
    return triangles, face


def triangulate(mesh: Mesh) -> tuple[Int32, Int32]:
    """Split polygons along diagonals so that vertex valences come near six.

    Greedy: of all diagonals that are no edges yet, the one whose greater valence is lowest, ties by the
    order of the faces and their corners. Then inserted edges are flipped while that lowers the sum of
    |6 - valence|, on the boundary |4 - valence|; or leaves it and lowers the sum of the squares. Source:
    Installation-space paper, section 4.1, Figure 2 and equation (1).

    Of a surface between labels, quadrilaterals with a corner between two sides on lines are split from that
    corner before all others: a triangle with both of them would lose its area as the line is smoothed.

    Parameters
    ----------
    mesh : Mesh

    Returns
    -------
    triangles : (t, 3) int32
        Point indices in their polygon's direction of turning, polygon by polygon. Triangles stay as they
        are; faces with fewer than three corners are left out.
    cell : (t,) int32
        The face that each triangle is part of.

    Raises
    ------
    InvalidMeshError
        A polygon cannot be triangulated without turning a triangle over: it crosses itself.

    Notes
    -----
    No triangle of a polygon with an area is degenerate or turned against the polygon's area vector; of
    such, those thinner than 1e-3 appear only where the polygon has no other triangulation. An edge is
    inserted beside one that joins the same points only where there is no other way. Linear time.

    Examples
    --------
    >>> from vtksmooth.kernels.mesh.mesh import Mesh
    >>> concave = Mesh.from_faces([[0, 0, 0], [4, 0, 0], [1, 1, 0], [0, 4, 0]], [[0, 1, 2, 3]])
    >>> triangles, cell = triangulate(concave)
    >>> triangles.tolist(), cell.tolist()
    ([[0, 2, 3], [0, 1, 2]], [0, 0])
    """
    if mesh.only_triangles:
        return mesh.connectivity.reshape(-1, 3), np.arange(mesh.n_faces, dtype=np.int32)
    offsets, corners, faces = mesh.offsets, mesh.connectivity, None
    if _is_odd(offsets, corners):
        sizes = np.maximum(mesh.face_sizes, 3)
        most = int((sizes - 2).sum(dtype=np.int64))
        offsets, corners, faces = (np.empty(size, np.int32) for size in (most + 1, 3 * most, most))
        count, impossible, culprit = _prepare(
            mesh.points, mesh.offsets, mesh.connectivity, int(sizes.max()), offsets, corners, faces
        )
        _refuse(mesh, impossible, culprit)
        offsets, faces = offsets[: count + 1], faces[:count]
        corners = corners[: offsets[-1]]
    labels = mesh.face_labels
    polygons = Mesh(
        mesh.points, offsets, corners, labels if labels is None or faces is None else labels[faces]
    )
    if not polygons.n_faces:
        raise InvalidMeshError("The mesh has no faces with three corners or more; there is nothing to split.")
    fate, first_candidate = _chosen(polygons, faces, mesh)
    most = int((polygons.face_sizes - 2).sum(dtype=np.int64))
    triangles, cell = np.empty((most, 3), np.int32), np.empty(most, np.int32)
    _write(offsets, corners, first_candidate, fate, triangles, cell)
    return triangles, cell if faces is None else faces[cell]


def _chosen(polygons: Mesh, faces: Int32 | None, given: Mesh) -> tuple[npt.NDArray[np.uint8], Int32]:
    """Return the fate of every diagonal, and each polygon's first one; these are parts of `given` faces."""
    offsets, corners = polygons.offsets, polygons.connectivity
    sizes = polygons.face_sizes.astype(np.int64)
    first_candidate = np.concatenate(([0], np.cumsum(sizes * (sizes - 3) // 2))).astype(np.int32)
    candidates = int(first_candidate[-1])
    face, ends = np.empty(candidates, np.int32), np.empty((candidates, 2), np.uint8)
    fate, least = np.empty(candidates, np.uint8), np.empty(polygons.n_faces)
    # What is known of one polygon: which triangles are good, diagonals usable, parts to be triangulated.
    room = np.empty((MOST_CORNERS,) * 3, np.bool_), *np.empty((2, MOST_CORNERS, MOST_CORNERS), np.bool_)
    rows = vertex_corners(polygons)
    ring_offsets, ring, kinds, _ = one_rings(polygons, *rows)
    lines = np.empty(0, np.bool_)
    if polygons.face_labels is not None:
        lines = sides_on_lines(offsets, corners, *rows, polygons.face_labels, ring_offsets, ring)
    impossible, culprit = _find_candidates(
        polygons.points, offsets, corners, first_candidate, face, ends, fate, least, lines, room
    )
    _refuse(given, impossible, culprit if faces is None else int(faces[culprit]))
    valence = np.diff(ring_offsets)
    inserted = (
        np.full(polygons.n_points, -1, np.int32),
        np.empty(2 * candidates, np.int32),
        np.empty(2 * candidates, np.int32),
    )
    _greedy(
        polygons.points, offsets, corners, first_candidate, face, ends, fate, least, room,
        ring_offsets, ring, valence, inserted, np.arange(candidates, dtype=np.int32),
    )  # fmt: skip
    while _flip(
        polygons.points, offsets, corners, first_candidate, ends, fate, least,
        ring_offsets, ring, kinds, valence, inserted,
    ):  # fmt: skip
        pass
    return fate, first_candidate


def _refuse(mesh: Mesh, impossible: int, culprit: int) -> None:
    if impossible:
        corners = mesh.connectivity[mesh.offsets[culprit] : mesh.offsets[culprit + 1]]
        place = ", ".join(f"{x:.6g}" for x in mesh.points[corners].mean(axis=0))
        raise InvalidMeshError(
            f"{impossible} of the polygons cross themselves, the first is face {culprit} at ({place}); "
            "put their corners in order, or remove them."
        )
