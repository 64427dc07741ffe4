"""Containment: no vertex leaves the installation space, and no triangle crosses its surface."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ...errors import InvalidMeshError
from .. import parallel
from ..compiled import device, kernel
from ..crossings import behind_planes, crosses, faces_near, no_box, scratch, turned_against, widen
from ..signed_distance import SignedDistanceTree, signed_distance
from ..state import State
from . import Constraint, Float64, Int64


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
    """Return whether a triangle round vertex i or j may cross the surface; -1 stands for no vertex.

    None does where the stars lie in balls that are inside, where no face comes near, and where all points of
    the stars are behind the planes of the faces that do. Also returns how many distances were asked for.
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
        return False, asked
    stack[0] = 0
    count, more = faces_near(guard.tree, box, guard.tolerance, stack, 1, found)
    if more > 0 or turned_against(guard.normals, found, count):
        return True, asked
    for end in range(2):
        v = i if end == 0 else j
        if (near_i if end == 0 else near_j) and not behind_planes(
            guard.tree, guard.normals, found, count, guard.tolerance,
            points, v, ring, offsets[v], offsets[v + 1],
        ):  # fmt: skip
            return True, asked
    return False, asked


@device
def triangle_crosses(guard, points, p, q, r, room):  # type: ignore[no-untyped-def]
    """Return whether the triangle (p, q, r) crosses the surface; those certainly inside are not tested."""
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
def star_crosses(guard, points, v, ring, first, last, room):  # type: ignore[no-untyped-def]
    """Return whether a triangle of v and two successive ones of ring[first:last], cyclic, crosses."""
    k = ring[last - 1]
    for r in range(first, last):
        before = k
        k = ring[r]
        if triangle_crosses(guard, points, v, before, k, room):
            return True
    return False


@kernel
def _stay_inside(starts, ends, points, near, pinned, guard, proposed):  # type: ignore[no-untyped-def]
    room = scratch()
    stack = room[0]
    checked = 0
    asked = 0
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            x = points[v, 0]
            y = points[v, 1]
            z = points[v, 2]
            if pinned[v] or (proposed[v, 0] == x and proposed[v, 1] == y and proposed[v, 2] == z):
                continue
            checked += 1
            slack = guard.slack[v]
            step = np.sqrt((proposed[v, 0] - x) ** 2 + (proposed[v, 1] - y) ** 2 + (proposed[v, 2] - z) ** 2)
            answer = may_go(guard, v, proposed[v, 0], proposed[v, 1], proposed[v, 2], step, stack)
            asked += answer < 2
            good = answer > 0
            if good and guard.exact:
                # Neighbours stand still: the vertex may be tried out where it wants to go.
                points[v] = proposed[v]
                possible, queries = may_cross(guard, points, v, -1, near.ring, near.ring_offsets, room)
                asked += queries
                for i in range(near.corner_offsets[v], near.corner_offsets[v + 1] if possible else 0):
                    a = 3 * near.corner_face[near.corners[i]]
                    p, q, r = near.connectivity[a], near.connectivity[a + 1], near.connectivity[a + 2]
                    good = good and not triangle_crosses(guard, points, p, q, r, room)
                points[v, 0] = x
                points[v, 1] = y
                points[v, 2] = z
            if not good:
                guard.slack[v] = slack
                proposed[v, 0] = x
                proposed[v, 1] = y
                proposed[v, 2] = z
    return checked, asked


class Containment(Constraint):
    """Moves that would carry a vertex out of a space are discarded (installation-space paper, section 6).

    Vertices that are outside at the start stay no farther outside than they were.

    Parameters
    ----------
    space : SignedDistanceTree
        The space's surface, normals outwards.
    tolerance : float
        How far outside still counts as inside, model units.
    exact : bool
        Also discard moves that would make a triangle cross the surface: at a concave edge of the space a
        triangle may, although its corners are inside. For triangles only.

    Attributes
    ----------
    outside : int
        Vertices outside by more than the tolerance at the start.
    checked, asked : int
        Moves looked at, and those for which a distance had to be computed.
    """

    on_edges = True
    convex = False

    def __init__(self, space: SignedDistanceTree, tolerance: float, exact: bool = False) -> None:
        self.space, self.tolerance, self.exact = space, tolerance, exact
        # A triangle is as it is judged only if the other corners stand still.
        self.in_place = exact
        self.outside = self.checked = self.asked = 0

    def bind(self, state: State) -> None:
        if self.exact and not state.topology.only_triangles:
            raise InvalidMeshError(
                "Exact containment needs triangles; triangulate the polygons first (ValenceTriangulation)."
            )
        used = np.diff(state.near.corner_offsets) > 0
        distance = np.zeros(len(state.points))
        distance[used] = self.space(state.points[used])
        self.guard = guard(
            self.space, np.column_stack((state.points, distance)), np.maximum(self.tolerance, distance),
            self.tolerance, exact=self.exact,
        )  # fmt: skip
        self.outside = int(np.count_nonzero(distance > self.tolerance))
        self.checked = self.asked = 0

    def count(self, results: list[tuple[int, int]]) -> None:
        """Add up what kernels have checked and asked."""
        self.checked += sum(result[0] for result in results)
        self.asked += sum(result[1] for result in results)

    def dispose(self, state: State, starts: Int64, ends: Int64, proposed: Float64) -> None:
        self.count(
            parallel.run(
                _stay_inside, starts, ends,
                state.points, state.near, state.pinned, self.guard, proposed, smallest_share=2000,
            )
        )  # fmt: skip


def guard(
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
