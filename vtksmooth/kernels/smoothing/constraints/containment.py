"""Containment: no vertex leaves the installation space, and no triangle crosses its surface."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ....errors import InvalidMeshError
from ....jit import parallel
from ....jit.compiled import kernel
from ....report import RunReport
from ...containment import nearby_faces, separating_planes
from ...containment.crossings import LIFT, crossing_triangles, scratch
from ...containment.safe_moves import guard_of, pending, room_at, settle, stars_may_go
from ...distance.signed_distance import SignedDistanceTree
from ..run_state import State
from . import Constraint, Float64, Int64

#: Shortest part of a step that is tried where the whole is not allowed, and most trials: they find the
#: largest part to less than the shortest.
_SHORTEST, _TRIALS = 1.0 / 16.0, 6


@kernel
def _stay_inside(starts, ends, points, pinned, guard, proposed, tried, places):
    room = scratch()
    new = pending(guard)
    checked = 0
    asked = 0
    old = np.empty(3)
    wish = np.empty(3)
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            still = True
            for axis in range(3):
                old[axis] = points[v, axis]
                wish[axis] = proposed[v, axis]
                still = still and wish[axis] == old[axis]
            if pinned[v] or still:
                continue
            checked += 1
            allowed = 0.0
            beyond = 1.0
            share = 1.0
            for _ in range(_TRIALS):
                for axis in range(3):
                    proposed[v, axis] = wish[axis]
                    if share < 1.0:
                        proposed[v, axis] = old[axis] + share * (wish[axis] - old[axis])
                # Not by the slack: that is of the place tried last, and others may have shortened that step.
                within, queries = room_at(guard, v, proposed[v, 0], proposed[v, 1], proposed[v, 2], room[0])
                asked += queries
                good = within >= 0.0
                if good and guard.exact:
                    # Neighbours stand still: the vertex may be tried out where it wants to go.
                    for axis in range(3):
                        points[v, axis] = proposed[v, axis]
                    good, count = stars_may_go(guard, points, v, -1, room, new)
                    if good:
                        settle(guard.separation, points, v, -1, new, count)
                        tried[v] = True
                        for axis in range(3):
                            places[v, axis] = points[v, axis]
                    for axis in range(3):
                        points[v, axis] = old[axis]
                if good:
                    allowed = share
                elif share < 1.0 and allowed == 0.0:
                    break
                else:
                    beyond = share
                if allowed == 1.0:
                    break
                share = 0.5 * (allowed + beyond) if allowed > 0.0 else _SHORTEST
            if allowed < 1.0:
                for axis in range(3):
                    proposed[v, axis] = old[axis]
                    if allowed > 0.0:
                        proposed[v, axis] += allowed * (wish[axis] - old[axis])
    return checked, asked


class Containment(Constraint):
    """Moves that would carry a vertex out of a space end before (installation-space paper, section 6).

    Of such a move the largest part is taken that is allowed, to a sixteenth of it; operations on edges, which
    must be done as a whole, are tried once more with a quarter of the steps.
    Vertices that are outside at the start stay no farther outside than they were.

    Parameters
    ----------
    space : SignedDistanceTree
        The space's surface, normals outwards.
    tolerance : float
        How far outside still counts as inside, model units.
    exact : bool
        Nor may a move make a triangle cross the surface that did not at the start: at a concave edge of the
        space a triangle may, although its corners are inside. For triangles only.
    measured : (n,) float64 and (m,) bool, optional
        Signed distances of the points that faces use at the start, others 0, and which faces cross the
        surface there, in the numbering of the run's input; measured here if absent.

    Attributes
    ----------
    outside : int
        Vertices outside by more than the tolerance at the start.
    checked, asked : int
        Moves looked at, and those for which a distance had to be computed.
    """

    name = "The installation space (containment)"
    guards = True

    def __init__(
        self,
        space: SignedDistanceTree,
        tolerance: float,
        exact: bool = False,
        measured: tuple[Float64, npt.NDArray[np.bool_]] | None = None,
    ) -> None:
        self.space, self.tolerance, self.exact, self.measured = space, tolerance, exact, measured
        # A triangle is as it is judged only if the other corners stand still.
        self.in_place = self.needs_still = exact
        self.outside = self.checked = self.asked = 0

    def bind(self, state: State) -> None:
        if self.exact and not state.topology.only_triangles:
            raise InvalidMeshError(
                "Exact containment needs triangles; triangulate the polygons first (ValenceTriangulation), "
                "or contain vertices only (containment='vertices')."
            )
        if self.measured is None:
            distance = self._distances(state, state.points)
        else:
            distance = state.in_order(self.measured[0])
        near, triangles, self.limit = state.near, None, self.tolerance
        if self.exact:
            # As far as separating planes allow: between that and the tolerance every triangle needs a test.
            self.limit *= separating_planes.BEFORE * LIFT
            triangles = separating_planes.nothing_known(
                self._triangles(state), near.corner_offsets, near.corners,
                self._crossing_at_start(state, distance),
            )  # fmt: skip
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
        # Vertices with steps that were admitted, and where these take them: what is known of triangles is
        # true only if they go there, and others may refuse.
        self._tried = np.zeros(len(distance), np.bool_)
        # Vertices of the current colour: a gate may still refuse their steps, even where limits are done.
        self._moving = np.zeros(len(distance), np.bool_)
        self._places = np.empty((len(distance) if self.exact else 0, 3))
        self.outside = int(np.count_nonzero(distance > self.tolerance))
        self.checked = self.asked = 0

    def prepare(self, state: State) -> None:
        guard = self.guard
        if self.exact:
            self._give_up(state.points)
            self._tried[:] = self._moving[:] = False
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

    def _give_up(self, proposed: Float64) -> None:
        """Give up what was learned of triangles with corners that do not go where they were allowed to."""
        tried = np.flatnonzero(self._tried)
        gone = tried[(self._places[tried] != proposed[tried]).any(axis=1)]
        separating_planes.give_up(self.guard.separation, gone)
        self._tried[gone] = False

    def dispose(self, state: State, starts: Int64, ends: Int64, proposed: Float64) -> None:
        if self.exact:
            self._give_up(proposed)
            rows = [np.arange(a, b) for a, b in zip(starts, ends, strict=True)]
            moving = np.concatenate([np.empty(0, np.int64), *rows])
            if not self._moving[moving].all():  # others have had their turn
                self._tried[:] = self._moving[:] = False
                self._moving[moving] = True
        results = parallel.run(
            _stay_inside, starts, ends,
            state.points, state.pinned, self.guard, proposed, self._tried, self._places,
            smallest_share=parallel.COSTLY,
        )  # fmt: skip
        for checked, asked in results:
            self.count(checked, asked)

    def exceeded(self, state: State, proposed: Float64, rows: Int64) -> npt.NDArray[np.bool_]:
        allowed, guard = proposed.copy(), self.guard._replace(exact=False)
        parallel.run(
            _stay_inside, rows, rows + 1, state.points, state.pinned, guard, allowed, self._tried,
            self._places, smallest_share=parallel.COSTLY,
        )  # fmt: skip
        found: npt.NDArray[np.bool_] = (allowed != proposed).any(axis=1)
        if self.exact:
            away = np.linalg.norm(proposed - guard.known[:, :3], axis=1)
            crossing = self._crossing(state, proposed, guard.known[:, 3] + away) & ~guard.separation.crossing
            found[self._triangles(state)[crossing]] = True
        return found

    def forget(self, state: State) -> None:
        self.guard.slack[:] = 0.0
        self._tried[:] = self._moving[:] = False
        if self.exact:
            crossing = self.guard.separation.crossing
            near = state.near
            self.guard = self.guard._replace(
                separation=separating_planes.nothing_known(
                    self._triangles(state), near.corner_offsets, near.corners, crossing
                )
            )

    def tell(self, report: RunReport) -> None:
        report.moves_checked, report.distances_asked = self.checked, self.asked

    def check(self, state: State) -> str:
        original = state.original.points
        before, after = self._distances(state, original), self._distances(state, state.points)
        left = after > np.maximum(before, self.tolerance) * (1.0 + 1e-9)
        if left.any():
            return f"{int(left.sum())} vertices left the space"
        if not self.exact:
            return ""
        crossing = self._crossing(state, state.points, after) & ~self._crossing(state, original, before)
        return f"{int(crossing.sum())} triangles cross that did not" if crossing.any() else ""

    def _distances(self, state: State, points: Float64) -> Float64:
        """Return the signed distances (n,) of `points`, 0 for those that no face uses."""
        used = np.diff(state.near.corner_offsets) > 0
        distances = np.zeros(len(points))
        distances[used] = self.space(points[used])
        return distances

    @staticmethod
    def _triangles(state: State) -> npt.NDArray[np.int32]:
        return state.topology.connectivity.reshape(-1, 3)

    def _crossing_at_start(self, state: State, distance: Float64) -> npt.NDArray[np.bool_]:
        if self.measured is None:
            return self._crossing(state, state.points, distance)
        crossing = self.measured[1]
        return crossing if state.face_order is None else crossing[state.face_order]

    def _crossing(self, state: State, points: Float64, distances: Float64) -> npt.NDArray[np.bool_]:
        return crossing_triangles(
            points, self._triangles(state), self.space.surface, distances, self.tolerance
        )
