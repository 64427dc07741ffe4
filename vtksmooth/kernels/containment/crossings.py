"""Triangles that cross another surface: the exact test behind containment."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ...jit import parallel
from ...jit.compiled import allocating, device, kernel
from ..distance.closest_point import FLAT, LEAF, ClosestPoint
from ..mesh.mesh import widen

Bool = npt.NDArray[np.bool_]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]

#: Part of the tolerance by which a triangle is moved along its normal. A surface that is folded along one
#: of its sides comes into the moved triangle, by half the tolerance where the fold is of 30 degrees.
LIFT = 0.125

#: Most faces of the surface that are looked at together, and most nodes of its tree that wait.
FACES, STACK = 64, 128


@allocating
def scratch():
    """Return the room that a kernel needs to look for crossings."""
    return np.empty(STACK, np.int32), np.empty(FACES, np.int32), np.empty((2, 3))


@allocating
def longer(values, count):
    """Return an array twice as long that begins with the first `count` of the `values`."""
    twice = np.empty(2 * values.size, np.int32)
    for i in range(count):  # a slice would be compiled for some seconds
        twice[i] = values[i]
    return twice


@device
def no_box(box):
    """Make the box (2, 3), low and high corner, that of nothing."""
    for axis in range(3):
        box[0, axis] = np.inf
        box[1, axis] = -np.inf


@device
def _meets(others, u, v, w, low, high):
    """Whether the triangle (u, v, w) of `others` meets the box from `low` to `high`.

    They are apart if some axis tells them apart: one of the box, the triangle's normal, or one at right
    angles to an edge of each (T. Akenine-Moeller, "Fast 3D Triangle-Box Overlap Testing", 2001).
    """
    for axis in range(3):
        if (
            min(others[u, axis], min(others[v, axis], others[w, axis])) > high[axis]
            or max(others[u, axis], max(others[v, axis], others[w, axis])) < low[axis]
        ):
            return False
    cx = 0.5 * (low[0] + high[0])
    cy = 0.5 * (low[1] + high[1])
    cz = 0.5 * (low[2] + high[2])
    hx = 0.5 * (high[0] - low[0])
    hy = 0.5 * (high[1] - low[1])
    hz = 0.5 * (high[2] - low[2])
    for side in range(3):
        p = u if side == 0 else (v if side == 1 else w)
        q = v if side == 0 else (w if side == 1 else u)
        r = w if side == 0 else (u if side == 1 else v)
        px = others[p, 0] - cx
        py = others[p, 1] - cy
        pz = others[p, 2] - cz
        rx = others[r, 0] - cx
        ry = others[r, 1] - cy
        rz = others[r, 2] - cz
        ex = others[q, 0] - cx - px
        ey = others[q, 1] - cy - py
        ez = others[q, 2] - cz - pz
        # The axes x, y and z across the edge; both its ends are in one place on them.
        s = ey * pz - ez * py
        t = ey * rz - ez * ry
        reach = hy * abs(ez) + hz * abs(ey)
        if min(s, t) > reach or max(s, t) < -reach:
            return False
        s = ez * px - ex * pz
        t = ez * rx - ex * rz
        reach = hx * abs(ez) + hz * abs(ex)
        if min(s, t) > reach or max(s, t) < -reach:
            return False
        s = ex * py - ey * px
        t = ex * ry - ey * rx
        reach = hx * abs(ey) + hy * abs(ex)
        if min(s, t) > reach or max(s, t) < -reach:
            return False
        if side == 0:
            nx = ey * (rz - pz) - ez * (ry - py)
            ny = ez * (rx - px) - ex * (rz - pz)
            nz = ex * (ry - py) - ey * (rx - px)
            reach = hx * abs(nx) + hy * abs(ny) + hz * abs(nz)
            if abs(nx * px + ny * py + nz * pz) > reach:
                return False
    return True


@device
def faces_near(tree, box, margin, stack, top, found):
    """Find the faces of a surface that meet the `box` made larger by `margin`, as many as `found` holds.

    Begins with ``stack[0] = 0`` and ``top = 1``, the root; there are more as long as the `top` returned
    is not 0, with which it goes on. Returns how many were found, and that.
    """
    others, faces, order, node_low, node_high, node = tree
    low = (box[0, 0] - margin, box[0, 1] - margin, box[0, 2] - margin)
    high = (box[1, 0] + margin, box[1, 1] + margin, box[1, 2] + margin)
    count = 0
    while top > 0 and count + LEAF <= found.size:
        top -= 1
        i = stack[top]
        if (
            node_low[i, 0] > high[0] or node_high[i, 0] < low[0]
            or node_low[i, 1] > high[1] or node_high[i, 1] < low[1]
            or node_low[i, 2] > high[2] or node_high[i, 2] < low[2]
        ):  # fmt: skip
            continue
        if node[i, 2] >= 0:
            stack[top] = node[i, 2]
            stack[top + 1] = node[i, 2] + 1
            top += 2
            continue
        for k in range(node[i, 0], node[i, 1]):
            f = order[k]
            if not _meets(others, faces[f, 0], faces[f, 1], faces[f, 2], low, high):
                continue
            found[count] = f
            count += 1
    return count, top


@device
def covering_radius(points, p, q, r):
    """Return what no point of the triangle (p, q, r) is farther away from the nearest corner."""
    # Its longest side / sqrt(3): where it is acute that is the greatest circumradius for this side; elsewhere
    # its height cuts it into two right triangles, whose points are within half a side of a corner.
    longest = 0.0
    for side in range(3):
        a = p if side == 0 else (q if side == 1 else r)
        b = q if side == 0 else (r if side == 1 else p)
        square = 0.0
        for axis in range(3):
            square += (points[a, axis] - points[b, axis]) ** 2
        longest = max(longest, square)
    return np.sqrt(longest / 3.0)


@device
def _pierces(points, p, q, r, normal, lift, others, u, v, w, margin):
    """Whether the triangle (u, v, w) of `others` crosses (p, q, r) moved by `lift` along its unit normal.

    Its segment in the plane must have a part that lies deeper inside than `margin` from all three sides.
    """
    # Heights of the corners above the moved plane.
    heights = (
        height(others, u, points, p, normal) - lift,
        height(others, v, points, p, normal) - lift,
        height(others, w, points, p, normal) - lift,
    )
    if (heights[0] > 0.0) == (heights[1] > 0.0) and (heights[1] > 0.0) == (heights[2] > 0.0):
        return False
    # Where two sides pass through the plane: the ends of the segment.
    ax = 0.0
    ay = 0.0
    az = 0.0
    bx = 0.0
    by = 0.0
    bz = 0.0
    found = 0
    for side in range(3):
        i = u if side == 0 else (v if side == 1 else w)
        j = v if side == 0 else (w if side == 1 else u)
        hi = heights[0] if side == 0 else (heights[1] if side == 1 else heights[2])
        hj = heights[1] if side == 0 else (heights[2] if side == 1 else heights[0])
        if (hi > 0.0) == (hj > 0.0):
            continue
        s = hi / (hi - hj)
        x = others[i, 0] + s * (others[j, 0] - others[i, 0])
        y = others[i, 1] + s * (others[j, 1] - others[i, 1])
        z = others[i, 2] + s * (others[j, 2] - others[i, 2])
        if found == 0:
            ax = x
            ay = y
            az = z
        else:
            bx = x
            by = y
            bz = z
        found += 1
    # Cut the segment by the three sides, each moved inwards by the margin.
    low = 0.0
    high = 1.0
    for side in range(3):
        i = p if side == 0 else (q if side == 1 else r)
        j = q if side == 0 else (r if side == 1 else p)
        ex = points[j, 0] - points[i, 0]
        ey = points[j, 1] - points[i, 1]
        ez = points[j, 2] - points[i, 2]
        # Inwards: normal x side, of unit length.
        ix = normal[1] * ez - normal[2] * ey
        iy = normal[2] * ex - normal[0] * ez
        iz = normal[0] * ey - normal[1] * ex
        length = np.sqrt(ix * ix + iy * iy + iz * iz)
        da = ((ax - points[i, 0]) * ix + (ay - points[i, 1]) * iy + (az - points[i, 2]) * iz) / length
        db = ((bx - points[i, 0]) * ix + (by - points[i, 1]) * iy + (bz - points[i, 2]) * iz) / length
        da -= margin
        db -= margin
        if da <= 0.0 and db <= 0.0:
            return False
        if da < 0.0:
            low = max(low, da / (da - db))
        elif db < 0.0:
            high = min(high, da / (da - db))
    return low < high


@device
def height(others, v, points, p, normal):
    """Return the height of v of `others` over the plane through p with the unit normal."""
    return (
        (others[v, 0] - points[p, 0]) * normal[0]
        + (others[v, 1] - points[p, 1]) * normal[1]
        + (others[v, 2] - points[p, 2]) * normal[2]
    )


@device
def face_normal(points, p, q, r):
    """Return the unit normal of the triangle (p, q, r); zeros where it is a line."""
    ax = points[q, 0] - points[p, 0]
    ay = points[q, 1] - points[p, 1]
    az = points[q, 2] - points[p, 2]
    bx = points[r, 0] - points[p, 0]
    by = points[r, 1] - points[p, 1]
    bz = points[r, 2] - points[p, 2]
    nx = ay * bz - az * by
    ny = az * bx - ax * bz
    nz = ax * by - ay * bx
    square = nx * nx + ny * ny + nz * nz
    if square <= FLAT * (ax * ax + ay * ay + az * az) * (bx * bx + by * by + bz * bz):
        return 0.0, 0.0, 0.0
    length = np.sqrt(square)
    return nx / length, ny / length, nz / length


@device
def _pierced(points, p, q, r, normal, tree, f, tolerance, above, below):
    """Whether face f comes into the triangle (p, q, r) moved to either side; True remains True."""
    others = tree[0]
    faces = tree[1]
    for side in range(2):
        if above if side == 0 else below:
            continue
        lift = LIFT * tolerance if side == 0 else -LIFT * tolerance
        if _pierces(points, p, q, r, normal, lift, others, faces[f, 0], faces[f, 1], faces[f, 2], tolerance):
            above = above or side == 0
            below = below or side == 1
    return above, below


@device
def crosses(points, p, q, r, tree, tolerance, room):
    """Whether the triangle (p, q, r) crosses the surface of `tree`, by more than touching.

    The surface must cross the triangle both when it is moved a little along its normal and when it is
    moved the other way: a surface that touches it, or runs along it, crosses in one case at most. `room` is
    :func:`scratch`.
    """
    stack, found, box = room
    normal = face_normal(points, p, q, r)
    if normal[0] == 0.0 and normal[1] == 0.0 and normal[2] == 0.0:
        return False  # a line: what crosses it crosses the triangles beside it
    no_box(box)
    widen(box, points, p)
    widen(box, points, q)
    widen(box, points, r)
    above = False
    below = False
    top = 1
    stack[0] = 0
    while top > 0:
        count, top = faces_near(tree, box, tolerance, stack, top, found)
        for c in range(count):
            above, below = _pierced(points, p, q, r, normal, tree, found[c], tolerance, above, below)
            if above and below:
                return True
    return False


@device
def crosses_found(points, p, q, r, tree, normals, tolerance, found, first, last):
    """Do what :func:`crosses` does for the faces ``found[first:last]``, with their `normals`."""
    normal = face_normal(points, p, q, r)
    if normal[0] == 0.0 and normal[1] == 0.0 and normal[2] == 0.0:
        return False
    above = False
    below = False
    most = LIFT * tolerance
    for c in range(first, last):
        f = found[c]
        o = tree[1][f, 0]
        face = (normals[f, 0], normals[f, 1], normals[f, 2])
        # Of a triangle that is all on one side of its plane the face touches a corner at most.
        hp = height(points, p, tree[0], o, face)
        hq = height(points, q, tree[0], o, face)
        hr = height(points, r, tree[0], o, face)
        if max(hp, max(hq, hr)) < -most or min(hp, min(hq, hr)) > most:
            continue
        above, below = _pierced(points, p, q, r, normal, tree, f, tolerance, above, below)
        if above and below:
            return True
    return False


@kernel
def _find(starts, ends, points, triangles, distances, tree, tolerance, result):
    room = scratch()
    for part in range(starts.size):
        for f in range(starts[part], ends[part]):
            p = triangles[f, 0]
            q = triangles[f, 1]
            r = triangles[f, 2]
            deepest = max(distances[p], max(distances[q], distances[r]))
            result[f] = False
            # A signed distance grows by no more than the way gone (1-Lipschitz).
            if deepest + covering_radius(points, p, q, r) > tolerance:
                result[f] = crosses(points, p, q, r, tree, tolerance, room)


def crossing_triangles(
    points: Float64, triangles: Int32, space: ClosestPoint, distances: Float64, tolerance: float
) -> Bool:
    """Return which triangles the surface `space` crosses, (t,) bool.

    Triangles that are certainly inside by the signed distances of their corners are not tested; the
    others are, against the triangles of `space` whose boxes they meet. Touching is no crossing: the
    surface must come in by more than the tolerance from all sides, and go through by an eighth of it.

    Parameters
    ----------
    points : (n, 3) float64
    triangles : (t, 3) int32
    space : ClosestPoint
        The surface that must not be crossed.
    distances : (n,) float64
        Signed distances of the points to it, negative inside; numbers that are too large cost time only.
    tolerance : float
        Model units, greater than the rounding errors of coordinates.

    Examples
    --------
    >>> from vtksmooth.kernels.mesh.mesh import Mesh
    >>> wall = Mesh.from_faces([[0, -1, -1], [0, 1, -1], [0, 0, 1]], [[0, 1, 2]])
    >>> points = np.array([[-1, -0.2, 0], [1, 0, 0], [-1, 0.2, 0], [0, -0.2, 0.0]])
    >>> pairs = np.array([[0, 1, 2], [0, 3, 2]], np.int32)
    >>> crossing_triangles(points, pairs, ClosestPoint(wall), np.zeros(4), 1e-9).tolist()
    [True, False]
    """
    result = np.empty(len(triangles), np.bool_)
    parallel.run(
        _find, *parallel.ranges(len(triangles)),
        points, triangles, distances, space.tree, tolerance, result, smallest_share=parallel.COSTLY,
    )  # fmt: skip
    return result
