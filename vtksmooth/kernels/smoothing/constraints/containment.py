"""Containment: no vertex leaves the installation space, and no triangle crosses its surface."""

from __future__ import annotations

import numpy as np

from ....errors import InvalidMeshError
from ....jit import parallel
from ....jit.compiled import kernel
from ...containment import nearby_faces, separating_planes
from ...containment.crossings import LIFT, scratch
from ...containment.safe_moves import guard_of, pending, room_at, settle, stars_may_go
from ...distance.signed_distance import SignedDistanceTree
from ..run_state import State
from . import Constraint, Float64, Int64


@kernel
def _stay_inside(starts, ends, points, pinned, guard, proposed):
    room = scratch()
    new = pending(guard)
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
            # Not by the slack: that is of the place tried last, and others may have shortened that step.
            within, queries = room_at(guard, v, proposed[v, 0], proposed[v, 1], proposed[v, 2], room[0])
            good = within >= 0.0
            if good and guard.exact:
                # Neighbours stand still: the vertex may be tried out where it wants to go.
                for axis in range(3):
                    points[v, axis] = proposed[v, axis]
                good, count = stars_may_go(guard, points, v, -1, room, new)
                if good:
                    settle(guard.separation, points, v, -1, new, count)
                points[v, 0] = x
                points[v, 1] = y
                points[v, 2] = z
            asked += queries
            if not good:
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

    name = "The installation space (containment)"
    guards = True

    def __init__(self, space: SignedDistanceTree, tolerance: float, exact: bool = False) -> None:
        self.space, self.tolerance, self.exact = space, tolerance, exact
        # A triangle is as it is judged only if the other corners stand still.
        self.in_place = self.needs_still = exact
        self.outside = self.checked = self.asked = 0

    def bind(self, state: State) -> None:
        if self.exact and not state.topology.only_triangles:
            raise InvalidMeshError(
                "Exact containment needs triangles; triangulate the polygons first (ValenceTriangulation)."
            )
        used = np.diff(state.near.corner_offsets) > 0
        distance = np.zeros(len(state.points))
        distance[used] = self.space(state.points[used])
        near, triangles, self.limit = state.near, None, self.tolerance
        if self.exact:
            # As far as separating planes allow: between that and the tolerance every triangle needs a test.
            self.limit *= separating_planes.BEFORE * LIFT
            triangles = separating_planes.nothing_known(
                state.topology.connectivity.reshape(-1, 3), near.corner_offsets, near.corners
            )
        self.guard = guard_of(
            self.space, np.column_stack((state.points, distance)), np.maximum(self.limit, distance),
            self.tolerance, separation=triangles,
        )  # fmt: skip
        # Who is near a wall will ask for it.
        first = state.topology.offsets[:-1][state.topology.face_sizes > 1]
        sides = state.points[state.topology.connectivity[first + 1]]
        sides -= state.points[state.topology.connectivity[first]]
        length = np.linalg.norm(sides, axis=1).sum() / max(1, len(sides))
        self.guard.vicinities.wanted[:] = (state.pinned == 0) & (distance > -nearby_faces.REACH * length)
        self.outside = int(np.count_nonzero(distance > self.tolerance))
        self.checked = self.asked = 0

    def prepare(self, state: State) -> None:
        guard = self.guard
        if self.exact:
            triangles = separating_planes.refreshed(
                guard.separation, state.points, state.near, state.pinned, guard.known, guard.slack,
                self.space, self.tolerance,
            )  # fmt: skip
            guard = guard._replace(separation=triangles)
        vicinities = nearby_faces.refreshed(
            guard.vicinities, state.points, state.near, guard.known, self.space, self.limit, self.tolerance
        )
        self.guard = guard._replace(vicinities=vicinities)

    def count(self, checked: int, asked: int) -> None:
        """Add what kernels have checked and asked."""
        self.checked += checked
        self.asked += asked

    def dispose(self, state: State, starts: Int64, ends: Int64, proposed: Float64) -> None:
        results = parallel.run(
            _stay_inside, starts, ends,
            state.points, state.pinned, self.guard, proposed, smallest_share=parallel.COSTLY,
        )  # fmt: skip
        for checked, asked in results:
            self.count(checked, asked)

    def check(self, state: State) -> str:
        used = np.diff(state.near.corner_offsets) > 0
        before = self.space(state.original.points[used])
        after = self.space(state.points[used])
        left = after > np.maximum(before, self.tolerance) * (1.0 + 1e-9)
        return f"{int(left.sum())} vertices left the space" if left.any() else ""
