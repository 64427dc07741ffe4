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
from .signed_distance import SignedDistanceTree, signed_distance, signed_distance_to

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
    tolerance : float
    active : bool
        Whether there is a space at all.
    exact : bool
        Whether triangles are judged too.
    closed : bool
        Whether the surface is closed: who does not cross it does not leave.
    separation : Separation
        What is known of the triangles, if they are judged.
    """

    tree: Any
    normals: Any
    known: Float64
    limit: Float64
    slack: Float64
    tolerance: float
    active: bool
    exact: bool
    closed: bool
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
def distance_at(guard, v, x, y, z, bound, stack):  # type: ignore[no-untyped-def]
    """Return the signed distance of vertex v at (x, y, z), where it is `bound` at most, by a query."""
    # |d| changes by no more than the way either: the surface is no farther than that.
    most = bound - guard.known[v, 3] + abs(guard.known[v, 3])
    return signed_distance(guard.tree, guard.normals, x, y, z, most, stack)


@device
def learn(guard, v, x, y, z, distance):  # type: ignore[no-untyped-def]
    """Keep the signed distance of vertex v at (x, y, z)."""
    guard.known[v, 0] = x
    guard.known[v, 1] = y
    guard.known[v, 2] = z
    guard.known[v, 3] = distance


@device
def may_go(guard, v, x, y, z, step, stack):  # type: ignore[no-untyped-def]
    """Return whether vertex v may go to (x, y, z): 2 by what is known already, 1 by a query, 0 not.

    The slack is then that of the new place: whoever leaves the vertex where it was puts the old one back.
    """
    if step <= guard.slack[v]:
        guard.slack[v] -= step
        return 2
    answer = 2
    bound = bound_at(guard, v, x, y, z)
    if bound > guard.limit[v]:
        answer = 1
        bound = distance_at(guard, v, x, y, z, bound, stack)
        if not bound <= guard.limit[v]:
            return 0
        learn(guard, v, x, y, z, bound)
    guard.slack[v] = guard.limit[v] - bound
    return answer


@device
def _left(guard, points, v):  # type: ignore[no-untyped-def]
    """Return how far v may go until it is lost; less than nothing if it is."""
    square = 0.0
    for axis in range(3):
        square += (points[v, axis] - guard.separation.anchor[v, axis]) ** 2
    return guard.separation.reach[v] - np.sqrt(square)


@device
def _near_distance(guard, points, v):  # type: ignore[no-untyped-def]
    """Return the signed distance of v, where it is now, by the faces near; infinity if that is in doubt."""
    kept = guard.separation
    left = _left(guard, points, v)
    fewest = -1
    for c in range(kept.corner_offsets[v], kept.corner_offsets[v + 1]):
        row = kept.row[kept.corners[c] // 3]
        if row >= 0 and (
            fewest < 0 or kept.last[row] - kept.first[row] < kept.last[fewest] - kept.first[fewest]
        ):
            fewest = row
    if fewest < 0 or not left > 0.0:
        return np.inf
    # All that is so near is near to each of them.
    return signed_distance_to(
        guard.tree, guard.normals, kept.faces, kept.first[fewest], kept.last[fewest],
        points[v, 0], points[v, 1], points[v, 2], left,
    )  # fmt: skip


@device
def _stay(guard, points, i, j, stack):  # type: ignore[no-untyped-def]
    """Return whether i and j, where they are now, are as far inside as they must be; and the queries."""
    asked = 0
    for end in range(2):
        v = i if end == 0 else j
        if v < 0:
            continue
        x = points[v, 0]
        y = points[v, 1]
        z = points[v, 2]
        bound = bound_at(guard, v, x, y, z)
        if bound > guard.limit[v]:
            distance = _near_distance(guard, points, v)
            if distance == np.inf:
                asked += 1
                distance = distance_at(guard, v, x, y, z, bound, stack)
            if not distance <= guard.limit[v]:
                return False, asked
            learn(guard, v, x, y, z, distance)
    return True, asked


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
    for; :func:`settle` makes that known, if the vertices go.
    """
    kept = guard.separation
    asked = 0
    count = 0
    looked = False
    lost_i = i >= 0 and _left(guard, points, i) < 0.0
    lost_j = j >= 0 and _left(guard, points, j) < 0.0
    for end in range(2):
        v = i if end == 0 else j
        if v < 0:
            continue
        for c in range(kept.corner_offsets[v], kept.corner_offsets[v + 1]):
            t = kept.corners[c] // 3
            p = kept.triangles[t, 0]
            q = kept.triangles[t, 1]
            r = kept.triangles[t, 2]
            if end == 1 and (p == i or q == i or r == i):
                continue
            row = kept.row[t]
            lost = row == CROWDED
            for corner in range(3):
                k = kept.triangles[t, corner]
                lost = lost or (lost_i if k == i else (lost_j if k == j else kept.lost[k] != 0))
            if not lost:
                if row == FREE:
                    continue
                highest = np.inf if kept.held[row] == 0 else -np.inf
                for s in range(kept.held[row]):
                    for corner in range(3):
                        k = kept.triangles[t, corner]
                        if k == i or k == j:  # noqa: SIM109 (they may differ in type)
                            highest = max(highest, above(kept.planes[row, s], points, k))
                if highest <= BEFORE * LIFT * guard.tolerance:
                    continue
            planes = 0
            if not lost:
                first = kept.first[row]
                last = kept.last[row]
                planes = separate(
                    points, p, q, r, guard.tree, guard.normals, kept.faces, first, last, guard.tolerance,
                    new[2][count],
                )  # fmt: skip
            if planes == 0:
                if not looked:
                    # What is refused most often.
                    looked = True
                    good, asked = _stay(guard, points, i, j, room[0])
                    if not good:
                        return False, count, asked
                if lost:
                    good = not triangle_crosses(guard, points, p, q, r, room)
                else:
                    good = not crosses_found(
                        points, p, q, r, guard.tree, guard.normals, guard.tolerance,
                        kept.faces[first:last], last - first,
                    )  # fmt: skip
                if not good:
                    return False, count, asked
            new[0][count] = t
            new[1][count] = planes
            count += 1
    if not looked and not (
        guard.closed
        and (i < 0 or guard.limit[i] <= guard.tolerance)
        and (j < 0 or guard.limit[j] <= guard.tolerance)
    ):
        good, asked = _stay(guard, points, i, j, room[0])
        return good, count, asked
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
    """Find how far i, j and the other corners of the triangles in `new` may go, after :func:`settle`."""
    kept = guard.separation
    for c in range(count):
        t = new[0][c]
        for corner in range(3):
            k = kept.triangles[t, corner]
            if k == i or k == j:  # noqa: SIM109 (they may differ in type)
                continue
            highest = 0.0 if new[1][c] == 0 else -np.inf
            for s in range(new[1][c]):
                highest = max(highest, above(new[2][c, s], points, k))
            guard.slack[k] = min(guard.slack[k], max(0.0, -highest))
    for end in range(2):
        v = i if end == 0 else j
        if v < 0:
            continue
        free = _left(guard, points, v)
        if not (guard.closed and guard.limit[v] <= guard.tolerance):
            free = min(free, guard.limit[v] - bound_at(guard, v, points[v, 0], points[v, 1], points[v, 2]))
        for c in range(kept.corner_offsets[v], kept.corner_offsets[v + 1]):
            t = kept.corners[c] // 3
            row = kept.row[t]
            if row == FREE:
                for corner in range(3):
                    if kept.lost[kept.triangles[t, corner]]:
                        free = 0.0
                continue
            if row == CROWDED or kept.held[row] == 0:
                free = 0.0
                continue
            for s in range(kept.held[row]):
                free = min(free, -above(kept.planes[row, s], points, v))
        guard.slack[v] = max(0.0, free)


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
        float(tolerance), active, exact, exact and space.closed, separation or no_triangles(),
    )  # fmt: skip


@functools.cache
def everywhere() -> Guard:
    """Return what stands for no space at all, a guard that is never asked."""
    return guard_of(SignedDistanceTree(Mesh.from_faces(np.eye(3), [[0, 1, 2]])), active=False)
