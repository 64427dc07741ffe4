"""Separating planes: why a triangle does not cross a surface, kept as long as it is true.

Of each triangle the faces near are known, and a few planes: the triangle is behind all of them, and each of
the faces is in front of one. As long as its corners stay behind, it needs no test; and how far a vertex may
go until one of its triangles does is one number.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ...jit import parallel
from ...jit.compiled import device, kernel
from ..distance.signed_distance import SignedDistanceTree
from ..mesh.adjacency import Adjacency
from .crossings import FACES, LIFT, face_normal, faces_near, height, longer, no_box, scratch
from .nearby_faces import REACH, enlarged

Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]

#: Most planes of a triangle.
PLANES = 4

#: Rows of triangles with no face near, and with more than can be kept.
FREE, CROWDED = -1, -2

#: A corner may be in front of a plane by this part of the lift, and a face behind it by that.
BEFORE, _BEHIND = 0.5, 0.125

#: Cosine of the angle from which on two planes are turned against each other.
_AGAINST = -0.9


class Separation(NamedTuple):
    """What kernels read and keep of the triangles of a mesh and the faces of a surface that are near.

    Attributes
    ----------
    triangles : (t, 3) int32
    corner_offsets, corners : int32
        Of :class:`~vtksmooth.kernels.mesh.adjacency.Adjacency`.
    crossing : (t,) bool
        Triangles that may cross, for they did at the start.
    anchor : (n, 3) float64
    reach : (n,) float64
        The faces near are known as long as each vertex is no farther from its anchor.
    lost : (n,) uint8
        Vertices that are.
    row : (t,) int32
        Where the triangle stands in what follows, or FREE or CROWDED.
    first, last : (r,) int64
        Part of `faces`: the faces near.
    faces : (m,) int32
    held : (r,) int32
        How many planes hold; 0 if it is not known why the triangle does not cross, or if it does.
    planes : (r, PLANES, 6) float64
        A point of each plane and its unit normal.
    rows, filled : int
        How many rows, and entries of `faces`, are in use.
    widest : int
        Most triangles round a vertex.
    """

    triangles: Int32
    corner_offsets: Int32
    corners: Int32
    crossing: npt.NDArray[np.bool_]
    anchor: Float64
    reach: Float64
    lost: npt.NDArray[np.uint8]
    row: Int32
    first: npt.NDArray[np.int64]
    last: npt.NDArray[np.int64]
    faces: Int32
    held: Int32
    planes: Float64
    rows: int
    filled: int
    widest: int


@device
def above(planes, row, s, points, v):
    """Return the height of v over plane s of a row."""
    return (
        (points[v, 0] - planes[row, s, 0]) * planes[row, s, 3]
        + (points[v, 1] - planes[row, s, 1]) * planes[row, s, 4]
        + (points[v, 2] - planes[row, s, 2]) * planes[row, s, 5]
    )


@device
def _own_plane(points, p, q, r, others, faces, near, first, size, covered, behind, planes, row, s):
    # Whether the triangle's own plane has all faces that are not covered on one side; then it is plane s.
    normal = face_normal(points, p, q, r)
    if normal[0] == 0.0 and normal[1] == 0.0 and normal[2] == 0.0:
        return False
    lowest = np.inf
    highest = -np.inf
    for c in range(size):
        if not covered & (np.uint64(1) << np.uint64(c)):
            f = near[first + c]
            for corner in range(3):
                h = height(others, faces[f, corner], points, p, normal)
                lowest = min(lowest, h)
                highest = max(highest, h)
    if lowest < -behind and highest > behind:
        return False
    side = 1.0 if lowest >= -behind else -1.0
    for axis in range(3):
        planes[row, s, axis] = points[p, axis]
        planes[row, s, 3 + axis] = side * normal[axis]
    return True


@device
def separate(points, p, q, r, tree, normals, near, first, last, tolerance, planes, row):
    """Find planes that separate the triangle (p, q, r) from the faces ``near[first:last]``; return how many.

    They go to ``planes[row]``. 0 if none are found. Then it may cross or not. Otherwise it does not, as
    :func:`~vtksmooth.kernels.containment.crossings.crosses` has it: that moves a triangle by the lift both
    ways. Say a face in front of the plane m comes into the triangle moved by s = 1 or -1 lifts along its
    normal n, deeper than the tolerance from its sides. Corners are less than 5/8 of the lift higher over m
    than any point of the face, so with c = n.m: s c > 8 sqrt(1 - c^2) - 5/8, which leaves s c > 0.978, 12
    degrees. So the two faces it takes have planes that are turned against each other, to 24 degrees.
    """
    others = tree[0]
    faces = tree[1]
    size = last - first
    if size > FACES:
        return 0
    before = BEFORE * LIFT * tolerance
    behind = _BEHIND * LIFT * tolerance
    one = np.uint64(1)
    covered = np.uint64(0)
    count = 0
    left = 0
    for c in range(size):
        if covered & (one << np.uint64(c)):
            continue
        f = near[first + c]
        normal = (normals[f, 0], normals[f, 1], normals[f, 2])
        o = faces[f, 0]
        top = max(
            height(points, p, others, o, normal),
            max(height(points, q, others, o, normal), height(points, r, others, o, normal)),
        )
        if top > before or (normal[0] == 0.0 and normal[1] == 0.0 and normal[2] == 0.0):
            left += 1
            continue
        if count == PLANES:
            return 0
        # The face's plane, moved half of the way to the triangle at most: then more faces are before it.
        least = min(0.5 * top, 0.0) - behind
        lowest = 0.0
        for d in range(size):
            bit = one << np.uint64(d)
            if covered & bit:
                continue
            g = near[first + d]
            bottom = min(
                height(others, faces[g, 0], others, o, normal),
                min(
                    height(others, faces[g, 1], others, o, normal),
                    height(others, faces[g, 2], others, o, normal),
                ),
            )
            if bottom >= least:
                covered |= bit
                left -= d < c
                lowest = min(lowest, bottom)
        for axis in range(3):
            planes[row, count, axis] = others[o, axis] + lowest * normal[axis]
            planes[row, count, 3 + axis] = normal[axis]
        count += 1
    if left > 0:
        if count == PLANES or not _own_plane(
            points, p, q, r, others, faces, near, first, size, covered, behind, planes, row, count
        ):
            return 0
        count += 1
    for a in range(1, count):
        for b in range(a):
            along = 0.0
            for axis in range(3, 6):
                along += planes[row, a, axis] * planes[row, b, axis]
            if along < _AGAINST:
                return 0
    return count


@kernel
def _anchor(starts, ends, points, pinned, offsets, ring, anchor, reach, lost, stale):
    # Anew for vertices that have gone four fifths of their way. A vertex that stays reaches nowhere.
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            square = 0.0
            for axis in range(3):
                square += (points[v, axis] - anchor[v, axis]) ** 2
            stale[v] = not square <= 0.64 * reach[v] * reach[v]
            if not stale[v]:
                continue
            lost[v] = 0
            total = 0.0
            for r in range(offsets[v], offsets[v + 1]):
                k = ring[r]
                square = 0.0
                for axis in range(3):
                    square += (points[v, axis] - points[k, axis]) ** 2
                total += np.sqrt(square)
            size = offsets[v + 1] - offsets[v]
            reach[v] = REACH * total / size if size > 0 and not pinned[v] else 0.0
            for axis in range(3):
                anchor[v, axis] = points[v, axis]


@kernel
def _gather(starts, ends, chosen, triangles, pinned, anchor, reach, known, tree, tolerance, size):
    # For each of the chosen triangles how many faces are near, or CROWDED; and which, one after another, and
    # how many in all.
    stack, found, box = scratch()
    faces = np.empty(1024, np.int32)
    total = 0
    for part in range(starts.size):
        for i in range(starts[part], ends[part]):
            t = chosen[i]
            size[i] = 0
            if pinned[triangles[t, 0]] and pinned[triangles[t, 1]] and pinned[triangles[t, 2]]:
                continue
            no_box(box)
            inside = False
            for a in range(3):
                v = triangles[t, a]
                far = reach[v]
                bound = 0.0
                for axis in range(3):
                    box[0, axis] = min(box[0, axis], anchor[v, axis] - reach[v])
                    box[1, axis] = max(box[1, axis], anchor[v, axis] + reach[v])
                    bound += (anchor[v, axis] - known[v, axis]) ** 2
                for b in range(1, 3):
                    k = triangles[t, (a + b) % 3]
                    square = 0.0
                    for axis in range(3):
                        square += (anchor[v, axis] - anchor[k, axis]) ** 2
                    far = max(far, np.sqrt(square) + reach[k])
                # The balls that the corners may be in lie in one round v, which is inside.
                inside = inside or known[v, 3] + np.sqrt(bound) + far < 0.0
            if inside:
                continue
            stack[0] = 0
            count, more = faces_near(tree, box, tolerance, stack, 1, found)
            if more > 0:
                size[i] = CROWDED
                continue
            size[i] = count
            if total + count > faces.size:
                faces = longer(faces, total)
            for c in range(count):
                faces[total + c] = found[c]
            total += count
    return faces, total


@kernel
def _round(vertices, corner_offsets, corners, slack, triangles, chosen):
    for v in vertices:
        for c in range(corner_offsets[v], corner_offsets[v + 1]):
            t = corners[c] // 3
            chosen[t] = True
            for corner in range(3):
                slack[triangles[t, corner]] = 0.0


@kernel
def _give_up(vertices, corner_offsets, corners, row, held):
    for v in vertices:
        for c in range(corner_offsets[v], corner_offsets[v + 1]):
            at = row[corners[c] // 3]
            if at >= 0:
                held[at] = 0


def give_up(separation: Separation, vertices: npt.NDArray[np.int64]) -> None:
    """Give up the planes of the triangles round some vertices."""
    _give_up(vertices, separation.corner_offsets, separation.corners, separation.row, separation.held)


def nothing_known(
    triangles: Int32, corner_offsets: Int32, corners: Int32, crossing: npt.NDArray[np.bool_]
) -> Separation:
    """Return the beginning: all vertices are to be looked at."""
    n = len(corner_offsets) - 1
    return Separation(
        triangles, corner_offsets, corners, crossing, np.zeros((n, 3)), np.full(n, np.nan),
        np.zeros(n, np.uint8), np.full(len(triangles), FREE, np.int32), np.empty(0, np.int64),
        np.empty(0, np.int64), np.empty(0, np.int32), np.empty(0, np.int32), np.empty((0, PLANES, 6)), 0, 0,
        int(np.diff(corner_offsets).max(initial=0)),
    )  # fmt: skip


def no_triangles() -> Separation:
    """Return what stands for no triangles at all."""
    return nothing_known(
        np.empty((0, 3), np.int32), np.zeros(1, np.int32), np.empty(0, np.int32), np.empty(0, bool)
    )


def refreshed(
    separation: Separation,
    points: Float64,
    near: Adjacency,
    pinned: npt.NDArray[np.uint8],
    known: Float64,
    slack: Float64,
    space: SignedDistanceTree,
    tolerance: float,
) -> Separation:
    """Look for the faces near where vertices have gone most of their way, and return what is known then."""
    old = separation
    stale = np.empty(len(points), np.bool_)
    parallel.run(
        _anchor, *parallel.ranges(len(points)), points, pinned, near.ring_offsets, near.ring,
        old.anchor, old.reach, old.lost, stale,
    )  # fmt: skip
    marked = np.zeros(len(old.triangles), np.bool_)
    _round(np.flatnonzero(stale), old.corner_offsets, old.corners, slack, old.triangles, marked)
    chosen = np.flatnonzero(marked)
    if not len(chosen):
        return old
    size = np.empty(len(chosen), np.int64)
    found = parallel.run(
        _gather, *parallel.ranges(len(chosen)), chosen, old.triangles, pinned, old.anchor, old.reach, known,
        space.tree, tolerance, size, smallest_share=parallel.COSTLY,
    )  # fmt: skip
    old.row[chosen] = np.minimum(size, FREE)
    full = size > 0
    chosen, last = chosen[full], old.filled + np.cumsum(size[full])
    rows, filled = old.rows + len(chosen), old.filled + int(size[full].sum())
    old.row[chosen] = np.arange(old.rows, rows)
    # What triangles had before stays behind, unused.
    new = old._replace(
        first=enlarged(old.first, rows), last=enlarged(old.last, rows), held=enlarged(old.held, rows),
        planes=enlarged(old.planes, rows), faces=enlarged(old.faces, filled), rows=rows, filled=filled,
    )  # fmt: skip
    new.first[old.rows : rows] = last - size[full]
    new.last[old.rows : rows] = last
    new.held[old.rows : rows] = 0
    new.faces[old.filled : filled] = np.concatenate([faces[:total] for faces, total in found])
    return new
