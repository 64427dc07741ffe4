"""Gate: a vertex moves only if the elements round it become better."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ....jit import parallel
from ....jit.compiled import device, kernel
from ...measures.aspect_ratio import aspect_ratios, polygon_square, triangle_square
from ..run_state import State
from . import Constraint, Float64, Int64, Phase

ANGLE, ASPECT, FLOOR = 1, 2, 3

#: A measure must grow by more than this part of itself (angles: by this much in the cosine): otherwise
#: rounding would decide about moves that change nothing, differently in each pose.
MARGIN = 1e-12

#: How often the gate with a floor halves a step that fails.
HALVINGS = 3

#: What vertices that move together must win: the worst element round any of them this part of its measure, or
#: each on average this much of the inverse measure. And the measure below which all are as bad.
_RISE, _GAIN, _LEAST = 1e-4, 1e-5, 1e-3


@device
def _largest_cosine(points, connectivity, first, last, v, x, y, z):
    # Largest cosine of the corner angles of one face, with vertex v at (x, y, z); 1 if a side vanishes.
    size = last - first
    largest = -1.0
    for i in range(size):
        p = connectivity[first + i]
        q = connectivity[first + (i + 1) % size]
        o = connectivity[first + (i + size - 1) % size]
        px = x if p == v else points[p, 0]
        py = y if p == v else points[p, 1]
        pz = z if p == v else points[p, 2]
        ax = (x if q == v else points[q, 0]) - px
        ay = (y if q == v else points[q, 1]) - py
        az = (z if q == v else points[q, 2]) - pz
        bx = (x if o == v else points[o, 0]) - px
        by = (y if o == v else points[o, 1]) - py
        bz = (z if o == v else points[o, 2]) - pz
        lengths = np.sqrt((ax * ax + ay * ay + az * az) * (bx * bx + by * by + bz * bz))
        if lengths == 0.0:
            return 1.0
        largest = max(largest, (ax * bx + ay * by + az * bz) / lengths)
    return largest


@device
def _judge(kind, points, near, reference, v, x, y, z):
    # Number of inverted elements round v, the smallest measure of them, and the sum of k (of kind 3 only),
    # with v at (x, y, z).
    inverted = 0
    smallest = np.inf
    total = 0.0
    for i in range(near.corner_offsets[v], near.corner_offsets[v + 1]):
        c = near.corners[i]
        f = near.corner_face[c]
        a = near.offsets[f]
        b = near.offsets[f + 1]
        if b - a < 3:
            continue
        if kind == 1:
            smallest = min(smallest, -_largest_cosine(points, near.connectivity, a, b, v, x, y, z))
            continue
        if b - a == 3:
            p = near.connectivity[a + (c - a + 1) % 3]
            r = near.connectivity[a + (c - a + 2) % 3]
            # A triangle that uses v twice has no area, wherever v goes.
            q = 0.0
            if p != v and r != v:
                q = triangle_square(
                    points[p, 0] - x, points[p, 1] - y, points[p, 2] - z,
                    points[r, 0] - x, points[r, 1] - y, points[r, 2] - z,
                    reference[f, 0], reference[f, 1], reference[f, 2],
                )  # fmt: skip
        else:
            q = polygon_square(
                points, near.connectivity, a, b, v, x, y, z,
                reference[f, 0], reference[f, 1], reference[f, 2],
            )  # fmt: skip
        inverted += q < 0.0
        smallest = min(smallest, q)
        if kind == 3:
            total += np.sqrt(q) if q >= 0.0 else -np.sqrt(-q)
    return inverted, smallest, total


@device
def _better(kind, old_inverted, old, old_total, new_inverted, new, new_total, margin, worst, floor):
    if new_inverted < old_inverted and new >= worst:
        return True
    if new_inverted != old_inverted:
        return False
    if kind == 3 and old >= floor:
        return new >= floor and new_total > old_total + margin * abs(old_total)
    # A cosine near 0, of a right angle, has its rounding errors relative to 1.
    if new > old + margin * (1.0 if kind == 1 else abs(old)):
        return True
    return kind == 3 and new >= old and new_total > old_total + margin * abs(old_total)


@kernel
def _gate(starts, ends, kind, points, near, reference, margin, worst, floor, proposed, refused):
    # refused: the targets that have not been accepted; where nothing has been proposed, NaN.
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            x = points[v, 0]
            y = points[v, 1]
            z = points[v, 2]
            if refused.size:
                refused[v, 0] = np.nan
            if proposed[v, 0] == x and proposed[v, 1] == y and proposed[v, 2] == z:
                continue
            old_inverted, old, old_total = _judge(kind, points, near, reference, v, x, y, z)
            inverted, new, total = _judge(
                kind, points, near, reference, v, proposed[v, 0], proposed[v, 1], proposed[v, 2]
            )
            if not _better(kind, old_inverted, old, old_total, inverted, new, total, margin, worst, floor):
                if refused.size:
                    refused[v, 0] = proposed[v, 0]
                    refused[v, 1] = proposed[v, 1]
                    refused[v, 2] = proposed[v, 2]
                proposed[v, 0] = x
                proposed[v, 1] = y
                proposed[v, 2] = z


@kernel
def _worst(starts, ends, kind, points, near, reference, smallest, inverted):
    # The smallest measure of the elements round each vertex, and how many of them are inverted.
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            inverted[v], smallest[v], _ = _judge(
                kind, points, near, reference, v, points[v, 0], points[v, 1], points[v, 2]
            )


@kernel
def _list_refused(starts, ends, refused, rows):
    count = 0
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            if not np.isnan(refused[v, 0]):
                rows[count] = v
                count += 1
    return count


@kernel
def _halve(starts, ends, points, refused, proposed):
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            for axis in range(3):
                proposed[v, axis] = points[v, axis] + 0.5 * (refused[v, axis] - points[v, axis])


class Gate(Constraint):
    """Accept a move only if it improves the elements round the vertex.

    ``"aspect"`` (Semenova et al., section 2.1): as many inverted elements as before and a greater smallest k,
    or fewer inverted elements and none worse than the worst of the whole mesh when the pass began. With it
    no pass lowers the smallest k of the mesh or makes more elements inverted.
    ``"floor"``: as before where the smallest k is below a floor; there, if the smallest k stays, and where
    it is above and remains so, a greater sum of k is enough. A step that fails is halved three times before
    it is refused. With it no pass lowers the smallest k of the mesh below the floor or, where it is below,
    at all; nor makes more elements inverted. The mean is free to grow where the worst is good enough.
    Where no vertex may move alone any more but many could together (a row of a graded grid), a pass is judged
    as a whole: by what the gate promises of a pass, and by the worst round those that move, or its harmonic
    mean, which must grow.
    ``"angle"`` (smart Laplacian): a greater smallest angle, which does not see inversion.

    Parameters
    ----------
    measure : {"aspect", "floor", "angle"}
    floor : float
        Of ``"floor"``: k that is good enough, 0 to 1.
    """

    name = "A gate (gate)"

    phase = Phase.JUDGE
    in_place = True

    def __init__(self, measure: str = "aspect", floor: float = 0.6) -> None:
        self.kind = {"angle": ANGLE, "aspect": ASPECT, "floor": FLOOR}[measure]
        self.floor = floor * floor
        #: How often a step that fails is halved.
        self.halvings = HALVINGS if self.kind == FLOOR else 0
        #: Signed square of the smallest k of the mesh; asked for only where elements are inverted.
        self.worst = 0.0
        self._refused = np.empty((0, 3))

    def bind(self, state: State) -> None:
        self.worst = state.smallest_k * abs(state.smallest_k)
        self._refused = np.empty((len(state.points) if self.kind == FLOOR else 0, 3))

    def prepare(self, state: State) -> None:
        # Where nothing is inverted nothing will be, and the worst is never asked for.
        if self.kind != ANGLE and self.worst < 0.0:
            k = float(aspect_ratios(state.mesh, state.reference, bounded=False).min())
            self.worst = k * abs(k)

    def dispose(self, state: State, starts: Int64, ends: Int64, proposed: Float64) -> None:
        parallel.run(
            _gate, starts, ends, self.kind, state.points, state.near, state.reference,
            MARGIN, self.worst, self.floor, proposed, self._refused,
            smallest_share=parallel.COSTLY,
        )  # fmt: skip

    def halve(self, state: State, starts: Int64, ends: Int64, proposed: Float64) -> Int64:
        """Put halves of the refused steps back into `proposed`; return whose."""
        rows = np.empty(int((ends - starts).sum()), np.int64)
        rows = rows[: _list_refused(starts, ends, self._refused, rows)].copy()
        parallel.run(_halve, rows, rows + 1, state.points, self._refused, proposed)
        return rows

    def _round(self, state: State, before: Float64, after: Float64) -> tuple[Float64, Int64]:
        """Return the smallest measure round each vertex and how many are inverted, (2, n) each."""
        n = len(before)
        smallest, inverted = np.empty((2, n)), np.empty((2, n), np.int64)
        for points, of_vertices, count in zip((before, after), smallest, inverted, strict=True):
            parallel.run(
                _worst, *parallel.ranges(n), self.kind, points, state.near, state.reference, of_vertices,
                count, smallest_share=parallel.COSTLY,
            )  # fmt: skip
        return smallest, inverted

    def unwelcome(self, state: State, before: Float64, after: Float64) -> npt.NDArray[np.bool_]:
        smallest, inverted = self._round(state, before, after)
        worse = self._worse(smallest, inverted)
        if worse.any():
            return worse
        moved = (before != after).any(axis=1)
        # Cosines begin at -1.
        worst = np.maximum(smallest + (self.kind == ANGLE), _LEAST)
        least = worst[:, worst[0] != worst[1]].min(axis=1, initial=np.inf)
        gain = 1.0 / worst[0] - 1.0 / worst[1]
        if least[1] > (1.0 + _RISE) * least[0] or gain.sum() > _GAIN * np.count_nonzero(moved):
            return np.zeros_like(moved)
        lost: npt.NDArray[np.bool_] = gain < 0.0
        return lost if lost.any() else moved

    def worsened(self, state: State, before: Float64, after: Float64) -> npt.NDArray[np.bool_]:
        return self._worse(*self._round(state, before, after))

    def _worse(self, smallest: Float64, inverted: Int64) -> npt.NDArray[np.bool_]:
        least = smallest[0].min()
        if self.kind == FLOOR:
            least = min(least, self.floor)
        worse: npt.NDArray[np.bool_] = smallest[1] < least
        if self.kind != ANGLE and inverted[1].sum() > inverted[0].sum():
            worse |= inverted[1] > inverted[0]
        return worse

    def check(self, state: State) -> str:
        worse = int(self.worsened(state, state.original.points, state.points).sum())
        return f"{worse} vertices have worse elements than the worst was" if worse else ""
