"""Closest points on a surface, by a tree of bounding boxes.

VTK's locators answer one query per Python call (3 to 11 microseconds); inside a sweep that would cost
more than everything else together. This tree answers them in compiled code and is tested against
VTK's answers.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ...jit import parallel
from ...jit.compiled import device, kernel
from ..mesh.mesh import Mesh

Float64 = npt.NDArray[np.float64]
Int64 = npt.NDArray[np.int64]
UInt8 = npt.NDArray[np.uint8]

#: Triangles in a leaf.
LEAF = 4

#: Square of the sine below which the corners of a triangle count as lying in line.
FLAT = 1e-20

#: Diagonals that differ by less than this part are equal: rounding must not choose, differently in each pose.
EQUAL_LENGTHS = 1e-12


def triangles(mesh: Mesh) -> npt.NDArray[np.int32]:
    """Return the faces as triangles, (t, 3): polygons as fans, quadrilaterals along the shorter diagonal."""
    if mesh.only_triangles:
        return mesh.connectivity.reshape(-1, 3)
    sizes = mesh.face_sizes
    parts = []
    for size in np.unique(sizes[sizes >= 3]):
        corners = mesh.connectivity[mesh.offsets[:-1][sizes == size][:, None] + np.arange(size)]
        if size == 4:
            p = mesh.points[corners]
            usual, other = (np.linalg.norm(p[:, i] - p[:, i + 2], axis=1) for i in (0, 1))
            turned = other < usual * (1.0 - EQUAL_LENGTHS)
            corners[turned] = np.roll(corners[turned], -1, axis=1)
        parts += [corners[:, [0, i, i + 1]] for i in range(1, size - 1)]
    return np.ascontiguousarray(np.concatenate(parts)) if parts else np.empty((0, 3), np.int32)


@kernel
def _find_centres(starts, ends, points, faces, centre):
    for part in range(starts.size):
        for t in range(starts[part], ends[part]):
            for axis in range(3):
                a = points[faces[t, 0], axis]
                b = points[faces[t, 1], axis]
                c = points[faces[t, 2], axis]
                centre[t, axis] = 0.5 * (min(a, min(b, c)) + max(a, max(b, c)))


@device
def _widest(centre, order, first, last):
    """Return the axis along which the centres of some triangles spread most."""
    low = (np.inf, np.inf, np.inf)
    high = (-np.inf, -np.inf, -np.inf)
    for k in range(first, last):
        x = centre[order[k], 0]
        y = centre[order[k], 1]
        z = centre[order[k], 2]
        low = (min(low[0], x), min(low[1], y), min(low[2], z))
        high = (max(high[0], x), max(high[1], y), max(high[2], z))
    axis = 0
    widest = high[0] - low[0]
    if high[1] - low[1] > widest:
        axis = 1
        widest = high[1] - low[1]
    return 2 if high[2] - low[2] > widest else axis


@kernel
def _build(centre, order, node):
    # node[i] = (first triangle, last triangle, left child or -1); the right child follows the left.
    for t in range(order.size):
        order[t] = t
    node[0, 0] = 0
    node[0, 1] = order.size
    nodes = 1
    i = 0
    while i < nodes:
        first = node[i, 0]
        last = node[i, 1]
        node[i, 2] = -1
        if last - first > LEAF:
            split = _widest(centre, order, first, last)
            # Put the median in its place along the widest axis (Hoare's selection).
            middle = (first + last) // 2
            a = first
            b = last - 1
            while a < b:
                pivot = centre[order[(a + b) // 2], split]
                p = a
                q = b
                while p <= q:
                    while centre[order[p], split] < pivot:
                        p += 1
                    while centre[order[q], split] > pivot:
                        q -= 1
                    if p <= q:
                        swap = order[p]
                        order[p] = order[q]
                        order[q] = swap
                        p += 1
                        q -= 1
                if middle <= q:
                    b = q
                elif middle >= p:
                    a = p
                else:
                    break
            node[i, 2] = nodes
            node[nodes, 0] = first
            node[nodes, 1] = middle
            node[nodes + 1, 0] = middle
            node[nodes + 1, 1] = last
            nodes += 2
        i += 1
    return nodes


@kernel
def _refit_leaves(starts, ends, points, faces, order, asked, node, node_low, node_high):
    for part in range(starts.size):
        for i in range(starts[part], ends[part]):
            if node[i, 2] >= 0:
                continue
            if asked.size == 0:
                for axis in range(3):
                    node_low[i, axis] = np.inf
                    node_high[i, axis] = -np.inf
            for k in range(node[i, 0], node[i, 1]):
                t = order[k]
                if asked.size > 0 and not asked[t]:
                    continue
                for corner in range(3):
                    for axis in range(3):
                        node_low[i, axis] = min(node_low[i, axis], points[faces[t, corner], axis])
                        node_high[i, axis] = max(node_high[i, axis], points[faces[t, corner], axis])


@kernel
def _refit_parents(node, node_low, node_high):
    for back in range(node.shape[0]):
        i = node.shape[0] - 1 - back  # children come after their parents
        child = node[i, 2]
        if child >= 0:
            for axis in range(3):
                node_low[i, axis] = min(node_low[child, axis], node_low[child + 1, axis])
                node_high[i, axis] = max(node_high[child, axis], node_high[child + 1, axis])


def refitted(
    tree: tuple[npt.NDArray[Any], ...], points: Float64, moved: npt.NDArray[np.bool_]
) -> tuple[npt.NDArray[Any], ...]:
    """Return the `tree` of a :class:`ClosestPoint` with its points elsewhere; the old one is of no use then.

    Parameters
    ----------
    moved : (t,) bool
        Triangles that have moved: boxes grow by where these are. Empty: all have, and boxes fit them.
    """
    _, faces, order, low, high, node = tree
    parallel.run(_refit_leaves, *parallel.ranges(len(node)), points, faces, order, moved, node, low, high)
    _refit_parents(node, low, high)
    return points, faces, order, low, high, node


@device
def closest_of(points, p0, p1, p2, x, y, z):
    """Closest point of a triangle, by the regions of its plane, and its coordinates s and t.

    It is p0 + s (p1 - p0) + t (p2 - p0); at corners and on sides s or t are 0 or 1, or s is 1 - t, exactly.
    C. Ericson, Real-Time Collision Detection (2005), section 5.1.5.
    """
    ox = points[p0, 0]
    oy = points[p0, 1]
    oz = points[p0, 2]
    ax = points[p1, 0] - ox
    ay = points[p1, 1] - oy
    az = points[p1, 2] - oz
    bx = points[p2, 0] - ox
    by = points[p2, 1] - oy
    bz = points[p2, 2] - oz
    qx = x - ox
    qy = y - oy
    qz = z - oz
    cx = bx - ax
    cy = by - ay
    cz = bz - az
    aa = ax * ax + ay * ay + az * az
    bb = bx * bx + by * by + bz * bz
    cc = cx * cx + cy * cy + cz * cz
    aq = ax * qx + ay * qy + az * qz
    bq = bx * qx + by * qy + bz * qz
    ab = ax * bx + ay * by + az * bz
    s = 0.0
    t = 0.0
    if aq <= 0.0 and bq <= 0.0:
        pass  # the corner p0
    elif aq >= aa and bq - ab <= aq - aa:
        s = 1.0  # the corner p1
    elif bq >= bb and aq - ab <= bq - bb:
        t = 1.0  # the corner p2
    else:
        # Barycentric coordinates by cross products: with dot products alone needles lose twice the digits.
        nx = ay * bz - az * by
        ny = az * bx - ax * bz
        nz = ax * by - ay * bx
        square = nx * nx + ny * ny + nz * nz
        vs = nx * (qy * bz - qz * by) + ny * (qz * bx - qx * bz) + nz * (qx * by - qy * bx)
        vt = nx * (ay * qz - az * qy) + ny * (az * qx - ax * qz) + nz * (ax * qy - ay * qx)
        along_a = min(1.0, max(0.0, aq / aa)) if aa > 0.0 else 0.0
        along_b = min(1.0, max(0.0, bq / bb)) if bb > 0.0 else 0.0
        cq = (qx - ax) * cx + (qy - ay) * cy + (qz - az) * cz
        along_c = min(1.0, max(0.0, cq / cc)) if cc > 0.0 else 0.0
        if square <= FLAT * aa * bb:
            # Corners in line have no plane: the nearest of the three sides.
            best = np.inf
            for side in range(3):
                u = along_a if side == 0 else (1.0 - along_c if side == 2 else 0.0)
                v = along_b if side == 1 else (along_c if side == 2 else 0.0)
                dx = qx - u * ax - v * bx
                dy = qy - u * ay - v * by
                dz = qz - u * az - v * bz
                distance = dx * dx + dy * dy + dz * dz
                if distance < best:
                    best = distance
                    s = u
                    t = v
        elif vt <= 0.0 and 0.0 <= aq <= aa:
            s = along_a  # the side p0 p1
        elif vs <= 0.0 and 0.0 <= bq <= bb:
            t = along_b  # the side p0 p2
        elif square - vs - vt <= 0.0:
            t = along_c  # the side p1 p2
            s = 1.0 - t
        else:
            s = vs / square
            t = vt / square
    return ox + s * ax + t * bx, oy + s * ay + t * by, oz + s * az + t * bz, s, t


@device
def _box_square(node_low, node_high, i, x, y, z):
    dx = max(0.0, max(node_low[i, 0] - x, x - node_high[i, 0]))
    dy = max(0.0, max(node_low[i, 1] - y, y - node_high[i, 1]))
    dz = max(0.0, max(node_low[i, 2] - z, z - node_high[i, 2]))
    return dx * dx + dy * dy + dz * dz


@device
def query(tree, x, y, z, reach, bound, stack):
    """Closest point of the surface, its squared distance, its triangle, and s and t in that.

    Looks no farther than the root of `reach` (then the triangle may be -1), and stops as soon as a squared
    distance below `bound` is found.
    """
    points, faces, order, node_low, node_high, node = tree
    best = reach
    cx = x
    cy = y
    cz = z
    closest = -1
    cs = 0.0
    ct = 0.0
    top = 1
    stack[0] = 0
    while top > 0:
        top -= 1
        i = stack[top]
        if _box_square(node_low, node_high, i, x, y, z) >= best:
            continue
        child = node[i, 2]
        if child < 0:
            for k in range(node[i, 0], node[i, 1]):
                t = order[k]
                px, py, pz, ps, pt = closest_of(points, faces[t, 0], faces[t, 1], faces[t, 2], x, y, z)
                square = (px - x) ** 2 + (py - y) ** 2 + (pz - z) ** 2
                if square < best:
                    best = square
                    cx = px
                    cy = py
                    cz = pz
                    closest = t
                    cs = ps
                    ct = pt
                    if best <= bound:
                        return cx, cy, cz, best, closest, cs, ct
            continue
        left = _box_square(node_low, node_high, child, x, y, z)
        right = _box_square(node_low, node_high, child + 1, x, y, z)
        near = child if left <= right else child + 1
        if max(left, right) < best:
            stack[top] = child + 1 if near == child else child
            top += 1
        stack[top] = near
        top += 1
    return cx, cy, cz, best, closest, cs, ct


@kernel
def _closest_points(starts, ends, tree, queries, closest, distance):
    stack = np.empty(128, np.int32)
    for part in range(starts.size):
        for i in range(starts[part], ends[part]):
            x, y, z, square, _, _, _ = query(
                tree, queries[i, 0], queries[i, 1], queries[i, 2], np.inf, -1.0, stack
            )
            closest[i, 0] = x
            closest[i, 1] = y
            closest[i, 2] = z
            distance[i] = np.sqrt(square)


@kernel
def _limit(starts, ends, tree, points, pinned, limit, proposed):
    # Mode one (limit < 0): put the target on the surface. Mode two: keep it within `limit` of it.
    stack = np.empty(128, np.int32)
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            x = points[v, 0]
            y = points[v, 1]
            z = points[v, 2]
            if pinned[v] or (proposed[v, 0] == x and proposed[v, 1] == y and proposed[v, 2] == z):
                continue
            if limit < 0.0:
                cx, cy, cz, square, _, _, _ = query(
                    tree, proposed[v, 0], proposed[v, 1], proposed[v, 2], np.inf, -1.0, stack
                )
                proposed[v, 0] = cx
                proposed[v, 1] = cy
                proposed[v, 2] = cz
                continue
            step = 1.0
            dx = proposed[v, 0] - x
            dy = proposed[v, 1] - y
            dz = proposed[v, 2] - z
            for attempt in range(5):
                if attempt == 4:
                    step = 0.0
                proposed[v, 0] = x + step * dx
                proposed[v, 1] = y + step * dy
                proposed[v, 2] = z + step * dz
                if attempt == 4:
                    break
                cx, cy, cz, square, _, _, _ = query(
                    tree, proposed[v, 0], proposed[v, 1], proposed[v, 2], np.inf, limit * limit, stack
                )
                if square <= limit * limit:
                    break
                step *= 0.5


def tree_of(points: Float64, faces: npt.NDArray[np.int32]) -> tuple[npt.NDArray[Any], ...]:
    """Return a tree of triangles, (t, 3), as :func:`query` takes it."""
    centre, order = np.empty((len(faces), 3)), np.empty(len(faces), np.int32)
    parallel.run(_find_centres, *parallel.ranges(len(faces)), points, faces, centre)
    node = np.empty((max(1, 2 * len(faces)), 3), np.int32)
    node = node[: _build(centre, order, node)]
    boxes = np.empty((2, len(node), 3))
    return refitted((points, faces, order, *boxes, node), points, np.empty(0, np.bool_))


class ClosestPoint:
    """A surface that can be asked for its closest points.

    Parameters
    ----------
    mesh : Mesh
        Polygons are taken as triangles, see :func:`triangles`.

    Attributes
    ----------
    tree : tuple of arrays
        What :func:`query` takes: points, triangles, their order, and the nodes' boxes and contents.

    Examples
    --------
    >>> from vtksmooth.kernels.mesh.mesh import Mesh
    >>> surface = ClosestPoint(Mesh.from_faces([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]))
    >>> closest, distance = surface.query([[0.25, 0.25, 2.0]])
    >>> closest.tolist(), distance.tolist()
    ([[0.25, 0.25, 0.0]], [2.0])
    """

    def __init__(self, mesh: Mesh) -> None:
        self.tree = tree_of(mesh.points, triangles(mesh))

    @classmethod
    def of_lines(cls, points: Float64, edges: npt.NDArray[np.int32]) -> ClosestPoint:
        """Return what finds the closest points on `edges`, (k, 2): triangles without area to the tree."""
        lines = cls.__new__(cls)
        lines.tree = tree_of(points, np.ascontiguousarray(edges[:, [0, 1, 1]], dtype=np.int32))
        return lines

    def query(self, queries: npt.ArrayLike) -> tuple[Float64, Float64]:
        """Return the closest points (q, 3) and their distances (q,) of (q, 3) `queries`."""
        queries = np.ascontiguousarray(queries, dtype=np.float64)
        closest, distance = np.empty_like(queries), np.empty(len(queries))
        parallel.run(
            _closest_points, *parallel.ranges(len(queries)), self.tree, queries, closest, distance,
            smallest_share=parallel.COSTLY,
        )  # fmt: skip
        return closest, distance

    def project(self, starts: Int64, ends: Int64, points: Float64, pinned: UInt8, proposed: Float64) -> None:
        """Replace the targets that differ from `points` by the closest points of the surface."""
        self.limit(starts, ends, points, pinned, -1.0, proposed)

    def limit(
        self, starts: Int64, ends: Int64, points: Float64, pinned: UInt8, distance: float, proposed: Float64
    ) -> None:
        """Shorten the steps that would end farther than `distance` from the surface.

        What is tried: the whole step, a half, a quarter, an eighth, none.
        """
        parallel.run(
            _limit, starts, ends, self.tree, points, pinned, distance, proposed,
            smallest_share=parallel.COSTLY,
        )  # fmt: skip
