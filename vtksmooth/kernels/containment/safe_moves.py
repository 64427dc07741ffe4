"""Judging moves: what may be said of the signed distance to a space with few queries, or none."""

from __future__ import annotations

import functools
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ...jit.compiled import allocating, device, routine
from ..distance.signed_distance import SignedDistanceTree, signed_distance
from ..mesh.mesh import Mesh
from .crossings import LIFT, covering_radius, crosses, crosses_found
from .nearby_faces import Vicinities, no_vicinities, room_in_vicinity
from .separating_planes import BEFORE, CROWDED, FREE, PLANES, Separation, above, no_triangles, separate

Float64 = npt.NDArray[np.float64]


class Guard(NamedTuple):
    """What kernels read and keep to judge moves.

    Attributes
    ----------
    tree, normals, winding : tuple
        Of :class:`~vtksmooth.kernels.distance.signed_distance.SignedDistanceTree`.
    known : (n, 4) float64
        For each vertex a place and the signed distance there: the last one that was asked for.
    limit : (n,) float64
        Largest signed distance that each vertex may have.
    slack : (n,) float64
        How far each vertex may go from where it is now, at least.
    vicinities : Vicinities
        The faces near the vertices that have come close to them.
    tolerance : float
    active : bool
        Whether there is a space at all.
    exact : bool
        Whether triangles are judged too.
    separation : Separation
        What is known of the triangles, if they are judged.
    """

    tree: Any
    normals: Any
    winding: Float64
    known: Float64
    limit: Float64
    slack: Float64
    vicinities: Vicinities
    tolerance: float
    active: bool
    exact: bool
    separation: Separation


@device
def bound_at(known, v, x, y, z):
    """Return what the signed distance of vertex v at (x, y, z) is at most, by what is known of it.

    A signed distance changes by no more than the way travelled.
    """
    dx = x - known[v, 0]
    dy = y - known[v, 1]
    dz = z - known[v, 2]
    return known[v, 3] + np.sqrt(dx * dx + dy * dy + dz * dz)


@device
def learn(known, v, x, y, z, distance):
    """Keep the signed distance of vertex v at (x, y, z)."""
    known[v, 0] = x
    known[v, 1] = y
    known[v, 2] = z
    known[v, 3] = distance


@routine
def room_at(guard, v, x, y, z, stack):
    """Return how far vertex v may go from (x, y, z), and how many queries that took.

    Less than nothing if it may not even be there.
    """
    known, tree, normals, winding = guard.known, guard.tree, guard.normals, guard.winding
    limit = guard.limit[v]
    bound = bound_at(known, v, x, y, z)
    if bound <= limit:
        return limit - bound, 0
    room, distance = room_in_vicinity(guard.vicinities, tree, normals, winding, v, x, y, z, limit)
    asked = 0
    if np.isnan(room):
        # |d| changes by no more than the way either: the surface is no farther than that.
        most = bound - known[v, 3] + abs(known[v, 3])
        distance = signed_distance(tree, normals, winding, x, y, z, most, stack)
        asked = 1
        room = limit - distance
    if distance <= limit:
        learn(known, v, x, y, z, distance)
    return room, asked


@device
def may_go(guard, v, x, y, z, step, stack):
    """Return whether vertex v may go to (x, y, z), and how many queries that took.

    The slack is then that of the new place: whoever leaves the vertex where it was puts the old one back.
    """
    slack = guard.slack
    if step <= slack[v]:
        slack[v] -= step
        return True, 0
    room, asked = room_at(guard, v, x, y, z, stack)
    if room >= 0.0:
        slack[v] = room
    return room >= 0.0, asked


@device
def _left(kept, points, v):
    """Return how far v may go until it is lost; less than nothing if it is."""
    square = 0.0
    for axis in range(3):
        square += (points[v, axis] - kept.anchor[v, axis]) ** 2
    return kept.reach[v] - np.sqrt(square)


@device
def _certainly_inside(known, points, p, q, r, tolerance):
    """Whether the triangle (p, q, r) is, by what is known of its corners."""
    highest = -np.inf
    for side in range(3):
        a = p if side == 0 else (q if side == 1 else r)
        highest = max(highest, bound_at(known, a, points[a, 0], points[a, 1], points[a, 2]))
    return highest + covering_radius(points, p, q, r) <= tolerance


@device
def _highest(planes, row, held, points, v, used):
    """Return the height of v over the highest of the planes; 0 if there are none, -inf if v is not `used`."""
    if not used:
        return -np.inf
    highest = -np.inf if held > 0 else 0.0
    for s in range(held):
        highest = max(highest, above(planes, row, s, points, v))
    return highest


@allocating
def pending(guard):
    """Return the room for triangles whose planes will be others: which, how many planes, and these."""
    most = 2 * guard.separation.widest
    return np.empty(most, np.int32), np.empty(most, np.int32), np.empty((most, PLANES, 6))


@device
def _test(points, p, q, r, far, known, tree, normals, faces, first, last, tolerance, room, planes, row):
    """Return whether the triangle (p, q, r) crosses, and how many planes keep it from ``faces[first:last]``.

    They go to ``planes[row]``. There are none if other faces may be near, for a corner is `far`.
    """
    if far:
        if _certainly_inside(known, points, p, q, r, tolerance):
            return False, 0
        return crosses(points, p, q, r, tree, tolerance, room), 0
    held = separate(points, p, q, r, tree, normals, faces, first, last, tolerance, planes, row)
    return held == 0 and crosses_found(points, p, q, r, tree, normals, tolerance, faces, first, last), held


@device
def stars_may_go(guard, points, i, j, room, new):
    """Return whether no triangle round i and j crosses as they are in `points`; -1 stands for no vertex.

    Those that crossed at the start may go on crossing. The vertices must have been allowed to be there by
    :func:`may_go`. `room` is :func:`~vtksmooth.kernels.containment.crossings.scratch`. Returns too how many
    triangles were put into `new` (:func:`pending`), those whose planes are others now or that have none;
    :func:`settle` makes that known, if the vertices go. The slack is then that of the new places: whoever
    leaves the vertices where they were puts the old one back.
    """
    # Each use of a tuple of arrays takes the compiler as long as one of each of its arrays.
    kept = guard.separation
    known, slack, tolerance = guard.known, guard.slack, guard.tolerance
    tree, normals, faces, first, last = guard.tree, guard.normals, kept.faces, kept.first, kept.last
    offsets, corners, triangles, row = kept.corner_offsets, kept.corners, kept.triangles, kept.row
    lost, held, planes, may_cross = kept.lost, kept.held, kept.planes, kept.crossing
    other, other_held, other_planes = new
    left_i = _left(kept, points, i) if i >= 0 else np.inf
    left_j = _left(kept, points, j) if j >= 0 else np.inf
    free_i = left_i
    free_j = left_j
    count = 0
    for end in range(2):
        v = i if end == 0 else j
        if v < 0:
            continue
        for c in range(offsets[v], offsets[v + 1]):
            t = corners[c] // 3
            p = triangles[t, 0]
            q = triangles[t, 1]
            r = triangles[t, 2]
            has_i = p == i or q == i or r == i
            has_j = p == j or q == j or r == j
            if end == 1 and has_i:
                continue
            at = int(row[t])
            far = at == CROWDED
            for corner in range(3):
                k = triangles[t, corner]
                far = far or (left_i < 0.0 if k == i else (left_j < 0.0 if k == j else lost[k] != 0))
            if at == FREE and not far:
                continue
            # It is behind the planes it has, or it is tested and may get others.
            those = planes
            size = 0 if far else held[at]
            tested = size == 0
            while True:
                if tested:
                    begin = 0 if far else first[at]
                    end_ = 0 if far else last[at]
                    crossing, size = _test(
                        points, p, q, r, far, known, tree, normals, faces, begin, end_, tolerance, room,
                        other_planes, count,
                    )  # fmt: skip
                    if crossing and not may_cross[t]:
                        return False, count
                    those = other_planes
                    at = count
                    other[count] = t
                    other_held[count] = size
                    count += 1
                top_i = _highest(those, at, size, points, i, has_i)
                top_j = _highest(those, at, size, points, j, has_j)
                if tested or max(top_i, top_j) <= BEFORE * LIFT * tolerance:
                    break
                tested = True
            free_i = min(free_i, -top_i)
            free_j = min(free_j, -top_j)
    if i >= 0:
        slack[i] = max(0.0, min(slack[i], free_i))
    if j >= 0:
        slack[j] = max(0.0, min(slack[j], free_j))
    return True, count


@device
def settle(kept, points, i, j, new, count):
    """Keep what :func:`stars_may_go` has found, now that i and j go; but not how far vertices may go.

    What it writes belongs to triangles round i and j: others may do the same for theirs at the same time.
    `kept` is the guard's separation.
    """
    for end in range(2):
        v = i if end == 0 else j
        if v >= 0:
            kept.lost[v] = _left(kept, points, v) < 0.0
    for c in range(count):
        row = kept.row[new[0][c]]
        if row >= 0:
            kept.held[row] = new[1][c]
            for s in range(new[1][c]):
                for entry in range(6):
                    kept.planes[row, s, entry] = new[2][c, s, entry]


@device
def spread(triangles, slack, points, i, j, new, count):
    """Find how far the other corners of the triangles in `new` may go, after :func:`settle`."""
    for c in range(count):
        for corner in range(3):
            k = triangles[new[0][c], corner]
            other = k != i and k != j
            highest = _highest(new[2], c, new[1][c], points, k, other)
            slack[k] = min(slack[k], max(0.0, -highest))


def guard_of(
    space: SignedDistanceTree,
    known: npt.ArrayLike = ((0.0, 0.0, 0.0, 0.0),),
    limit: npt.ArrayLike = (0.0,),
    tolerance: float = 0.0,
    *,
    active: bool = True,
    separation: Separation | None = None,
) -> Guard:
    """Return the guard of a space; of triangles too, if there is a `separation` to begin with."""
    places, limits = np.asarray(known, np.float64), np.asarray(limit, np.float64)
    exact = separation is not None
    return Guard(
        space.tree, space.normals, space.winding, places, limits, np.maximum(0.0, limits - places[:, 3]),
        no_vicinities(len(places)), float(tolerance), active, exact, separation or no_triangles(),
    )  # fmt: skip


@functools.cache
def everywhere() -> Guard:
    """Return what stands for no space at all, a guard that is never asked."""
    return guard_of(SignedDistanceTree(Mesh.from_faces(np.eye(3), [[0, 1, 2]])), active=False)
