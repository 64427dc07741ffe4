"""Judging moves: what may be said of the signed distance to a space with few queries, or none."""

from __future__ import annotations

import functools
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from .compiled import allocating, device
from .crossings import LIFT, crosses, crosses_found
from .mesh import Mesh
from .separation import BEFORE, CROWDED, FREE, PLANES, Separation, above, no_triangles, separate
from .signed_distance import SignedDistanceTree, signed_distance
from .vicinity import Vicinities, no_vicinities, room_in_vicinity

Float64 = npt.NDArray[np.float64]


class Guard(NamedTuple):
    """What kernels read and keep to judge moves.

    Attributes
    ----------
    tree, normals : tuple
        Of :class:`~vtksmooth.kernels.signed_distance.SignedDistanceTree`.
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
    known: Float64
    limit: Float64
    slack: Float64
    vicinities: Vicinities
    tolerance: float
    active: bool
    exact: bool
    separation: Separation


@device
def bound_at(guard, v, x, y, z):  # type: ignore[no-untyped-def]
    """Return what the signed distance of vertex v at (x, y, z) is at most, by what is known of it.

    A signed distance changes by no more than the way travelled.
    """
    dx = x - guard.known[v, 0]
    dy = y - guard.known[v, 1]
    dz = z - guard.known[v, 2]
    return guard.known[v, 3] + np.sqrt(dx * dx + dy * dy + dz * dz)


@device
def learn(guard, v, x, y, z, distance):  # type: ignore[no-untyped-def]
    """Keep the signed distance of vertex v at (x, y, z)."""
    guard.known[v, 0] = x
    guard.known[v, 1] = y
    guard.known[v, 2] = z
    guard.known[v, 3] = distance


@device
def room_at(guard, v, x, y, z, stack):  # type: ignore[no-untyped-def]
    """Return how far vertex v may go from (x, y, z), and how many queries that took.

    Less than nothing if it may not even be there.
    """
    limit = guard.limit[v]
    bound = bound_at(guard, v, x, y, z)
    if bound <= limit:
        return limit - bound, 0
    room, distance = room_in_vicinity(guard.vicinities, guard.tree, guard.normals, v, x, y, z, limit)
    asked = 0
    if np.isnan(room):
        # |d| changes by no more than the way either: the surface is no farther than that.
        most = bound - guard.known[v, 3] + abs(guard.known[v, 3])
        distance = signed_distance(guard.tree, guard.normals, x, y, z, most, stack)
        asked = 1
        room = limit - distance
    if distance <= limit:
        learn(guard, v, x, y, z, distance)
    return room, asked


@device
def may_go(guard, v, x, y, z, step, stack):  # type: ignore[no-untyped-def]
    """Return whether vertex v may go to (x, y, z), and how many queries that took.

    The slack is then that of the new place: whoever leaves the vertex where it was puts the old one back.
    """
    if step <= guard.slack[v]:
        guard.slack[v] -= step
        return True, 0
    room, asked = room_at(guard, v, x, y, z, stack)
    if room >= 0.0:
        guard.slack[v] = room
    return room >= 0.0, asked


@device
def _left(guard, points, v):  # type: ignore[no-untyped-def]
    """Return how far v may go until it is lost; less than nothing if it is."""
    square = 0.0
    for axis in range(3):
        square += (points[v, axis] - guard.separation.anchor[v, axis]) ** 2
    return guard.separation.reach[v] - np.sqrt(square)


@device
def triangle_crosses(guard, points, p, q, r, room):  # type: ignore[no-untyped-def]
    """Return whether the triangle (p, q, r) crosses, by the tree; not for those that are certainly inside."""
    highest = -np.inf
    longest = 0.0
    for side in range(3):
        a = p if side == 0 else (q if side == 1 else r)
        b = q if side == 0 else (r if side == 1 else p)
        highest = max(highest, bound_at(guard, a, points[a, 0], points[a, 1], points[a, 2]))
        dx = points[a, 0] - points[b, 0]
        dy = points[a, 1] - points[b, 1]
        dz = points[a, 2] - points[b, 2]
        longest = max(longest, dx * dx + dy * dy + dz * dz)
    # No point of a triangle is farther from the nearest corner than its longest side / sqrt(3).
    if highest + np.sqrt(longest / 3.0) <= guard.tolerance:
        return False
    return crosses(points, p, q, r, guard.tree, guard.tolerance, room)


@device
def _highest(planes, row, held, points, v, used):  # type: ignore[no-untyped-def]
    """Return the height of v over the highest of the planes; 0 if there are none, -inf if v is not `used`."""
    if not used:
        return -np.inf
    if held == 0:
        return 0.0
    highest = -np.inf
    for s in range(held):
        highest = max(highest, above(planes[row, s], points, v))
    return highest


@allocating
def pending(guard):  # type: ignore[no-untyped-def]
    """Return the room for triangles whose planes will be others: which, how many planes, and these."""
    most = 2 * guard.separation.widest
    return np.empty(most, np.int32), np.empty(most, np.int32), np.empty((most, PLANES, 6))


@device
def stars_may_go(guard, points, i, j, room, new):  # type: ignore[no-untyped-def]
    """Return whether vertices i and j may be where they are now in `points`; -1 stands for no vertex.

    They may if they are inside and no triangle round them crosses. `room` is
    :func:`~vtksmooth.kernels.crossings.scratch`. Returns too how many triangles were put into `new`
    (:func:`pending`), those whose planes are others now or that have none, and how many distances were asked
    for; :func:`settle` makes that known, if the vertices go. The slack is then that of the new places:
    whoever leaves the vertices where they were puts the old one back.
    """
    kept = guard.separation
    asked = 0
    count = 0
    for end in range(2):
        v = i if end == 0 else j
        if v >= 0:
            free, queries = room_at(guard, v, points[v, 0], points[v, 1], points[v, 2], room[0])
            asked += queries
            if not free >= 0.0:
                return False, count, asked
            guard.slack[v] = free
    left_i = _left(guard, points, i) if i >= 0 else np.inf
    left_j = _left(guard, points, j) if j >= 0 else np.inf
    free_i = left_i
    free_j = left_j
    for end in range(2):
        v = i if end == 0 else j
        if v < 0:
            continue
        for c in range(kept.corner_offsets[v], kept.corner_offsets[v + 1]):
            t = kept.corners[c] // 3
            p = kept.triangles[t, 0]
            q = kept.triangles[t, 1]
            r = kept.triangles[t, 2]
            has_i = p == i or q == i or r == i
            has_j = p == j or q == j or r == j
            if end == 1 and has_i:
                continue
            row = kept.row[t]
            lost = row == CROWDED
            for corner in range(3):
                k = kept.triangles[t, corner]
                lost = lost or (left_i < 0.0 if k == i else (left_j < 0.0 if k == j else kept.lost[k] != 0))
            if row == FREE and not lost:
                continue
            top_i = 0.0
            top_j = 0.0
            known = False
            if not lost and kept.held[row] > 0:
                top_i = _highest(kept.planes, row, kept.held[row], points, i, has_i)
                top_j = _highest(kept.planes, row, kept.held[row], points, j, has_j)
                known = max(top_i, top_j) <= BEFORE * LIFT * guard.tolerance
            if not known:
                planes = 0
                if lost:
                    crossing = triangle_crosses(guard, points, p, q, r, room)
                else:
                    first = kept.first[row]
                    last = kept.last[row]
                    planes = separate(
                        points, p, q, r, guard.tree, guard.normals, kept.faces, first, last, guard.tolerance,
                        new[2][count],
                    )  # fmt: skip
                    crossing = planes == 0 and crosses_found(
                        points, p, q, r, guard.tree, guard.normals, guard.tolerance,
                        kept.faces[first:last], last - first,
                    )  # fmt: skip
                if crossing:
                    return False, count, asked
                top_i = _highest(new[2], count, planes, points, i, has_i)
                top_j = _highest(new[2], count, planes, points, j, has_j)
                new[0][count] = t
                new[1][count] = planes
                count += 1
            free_i = min(free_i, -top_i)
            free_j = min(free_j, -top_j)
    if i >= 0:
        guard.slack[i] = max(0.0, min(guard.slack[i], free_i))
    if j >= 0:
        guard.slack[j] = max(0.0, min(guard.slack[j], free_j))
    return True, count, asked


@device
def settle(guard, points, i, j, new, count):  # type: ignore[no-untyped-def]
    """Keep what :func:`stars_may_go` has found, now that i and j go; but not how far vertices may go.

    What it writes belongs to triangles round i and j: others may do the same for theirs at the same time.
    """
    kept = guard.separation
    for end in range(2):
        v = i if end == 0 else j
        if v >= 0:
            kept.lost[v] = _left(guard, points, v) < 0.0
    for c in range(count):
        row = kept.row[new[0][c]]
        if row >= 0:
            kept.held[row] = new[1][c]
            for s in range(new[1][c]):
                for entry in range(6):
                    kept.planes[row, s, entry] = new[2][c, s, entry]


@device
def spread(guard, points, i, j, new, count):  # type: ignore[no-untyped-def]
    """Find how far the other corners of the triangles in `new` may go, after :func:`settle`."""
    for c in range(count):
        for corner in range(3):
            k = guard.separation.triangles[new[0][c], corner]
            other = k != i and k != j
            highest = _highest(new[2], c, new[1][c], points, k, other)
            guard.slack[k] = min(guard.slack[k], max(0.0, -highest))


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
        space.tree, space.normals, places, limits, np.maximum(0.0, limits - places[:, 3]),
        no_vicinities(len(places)), float(tolerance), active, exact, separation or no_triangles(),
    )  # fmt: skip


@functools.cache
def everywhere() -> Guard:
    """Return what stands for no space at all, a guard that is never asked."""
    return guard_of(SignedDistanceTree(Mesh.from_faces(np.eye(3), [[0, 1, 2]])), active=False)
