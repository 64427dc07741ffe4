"""Judging moves: what may be said of the signed distance to a space with few queries, or none."""

from __future__ import annotations

import functools
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from .compiled import device
from .crossings import behind_planes, crosses, crosses_found, faces_near, no_box, turned_against, widen
from .mesh import Mesh
from .signed_distance import SignedDistanceTree, signed_distance

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
    """

    tree: Any
    normals: Any
    known: Float64
    limit: Float64
    slack: Float64
    tolerance: float
    active: bool
    exact: bool


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
def star_inside(guard, points, v, ring, first, last, stack):  # type: ignore[no-untyped-def]
    """Return whether v and ring[first:last] lie in a ball round v that is certainly inside.

    Nearly all stars do. Also returns whether a distance was asked for, where what is known is from too far.
    """
    x = points[v, 0]
    y = points[v, 1]
    z = points[v, 2]
    longest = 0.0
    for r in range(first, last):
        k = ring[r]
        dx = points[k, 0] - x
        dy = points[k, 1] - y
        dz = points[k, 2] - z
        longest = max(longest, dx * dx + dy * dy + dz * dz)
    most = guard.tolerance - np.sqrt(longest)
    if guard.limit[v] - guard.slack[v] <= most:
        return True, False
    # The slack has been worn off by ways there and back.
    bound = bound_at(guard, v, x, y, z)
    asked = bound > most and 2.0 * guard.known[v, 3] - bound <= most
    if asked:
        bound = distance_at(guard, v, x, y, z, bound, stack)
        learn(guard, v, x, y, z, bound)
    if bound <= most:
        guard.slack[v] = guard.limit[v] - bound
    return bound <= most, asked


@device
def may_cross(guard, points, i, j, ring, offsets, room):  # type: ignore[no-untyped-def]
    """Look for triangles round the vertices i and j that may cross the surface; -1 stands for no vertex.

    None does where the stars lie in balls that are inside, where no face comes near, and where all points of
    the stars are behind the planes of the faces that do. Returns 0 then, otherwise how many faces are near,
    in `room`, or -1 for too many; and how many distances were asked for.
    """
    stack, found, box = room
    asked = 0
    no_box(box)
    near_i = False
    near_j = False
    for end in range(2):
        v = i if end == 0 else j
        if v < 0:
            continue
        inside, query = star_inside(guard, points, v, ring, offsets[v], offsets[v + 1], stack)
        asked += query
        if inside:
            continue
        near_i = near_i or end == 0
        near_j = near_j or end == 1
        widen(box, points, v)
        for r in range(offsets[v], offsets[v + 1]):
            widen(box, points, ring[r])
    if not (near_i or near_j):
        return 0, asked
    stack[0] = 0
    count, more = faces_near(guard.tree, box, guard.tolerance, stack, 1, found)
    if more > 0:
        return -1, asked
    if turned_against(guard.normals, found, count):
        return count, asked
    for end in range(2):
        v = i if end == 0 else j
        if (near_i if end == 0 else near_j) and not behind_planes(
            guard.tree, guard.normals, found, count, guard.tolerance,
            points, v, ring, offsets[v], offsets[v + 1],
        ):  # fmt: skip
            return count, asked
    return 0, asked


@device
def triangle_crosses(guard, points, p, q, r, count, room):  # type: ignore[no-untyped-def]
    """Return whether the triangle (p, q, r) crosses one of `count` faces in `room`; of all, if that is -1.

    Triangles that are certainly inside are not tested.
    """
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
    if count < 0:
        return crosses(points, p, q, r, guard.tree, guard.tolerance, room)
    return crosses_found(points, p, q, r, guard.tree, guard.normals, guard.tolerance, room[1], count)


@device
def star_crosses(guard, points, v, ring, first, last, count, room):  # type: ignore[no-untyped-def]
    """Return whether a triangle of v and two successive ones of ring[first:last], cyclic, crosses.

    `count` and `room` as :func:`may_cross` has left them.
    """
    k = ring[last - 1]
    for r in range(first, last):
        before = k
        k = ring[r]
        if triangle_crosses(guard, points, v, before, k, count, room):
            return True
    return False


def guard_of(
    space: SignedDistanceTree,
    known: npt.ArrayLike = ((0.0, 0.0, 0.0, 0.0),),
    limit: npt.ArrayLike = (0.0,),
    tolerance: float = 0.0,
    *,
    active: bool = True,
    exact: bool = False,
) -> Guard:
    """Return the guard of a space."""
    places, limits = np.asarray(known, np.float64), np.asarray(limit, np.float64)
    return Guard(
        space.tree, space.normals, places, limits, np.maximum(0.0, limits - places[:, 3]),
        float(tolerance), active, exact,
    )  # fmt: skip


@functools.cache
def everywhere() -> Guard:
    """Return what stands for no space at all, a guard that is never asked."""
    return guard_of(SignedDistanceTree(Mesh.from_faces(np.eye(3), [[0, 1, 2]])), active=False)
