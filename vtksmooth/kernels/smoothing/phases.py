"""Disposal: the constraints of a run, phase by phase, so that the promises of all of them are kept.

Directions first, then factors, then points of a surface; steps are shortened until every limit admits them,
what must be conserved is corrected within the limits, and gates judge what is left. A step of zero keeps
every promise: that is how each of the rounds below ends.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from ...errors import ParameterError
from ...jit import parallel
from ...jit.compiled import kernel
from .constraints import Constraint, Phase
from .constraints.damping import factors, shorten
from .run_state import State

Float64 = npt.NDArray[np.float64]
Int64 = npt.NDArray[np.int64]

#: How often a step that several limits shorten is shortened before it is refused, and after how many rounds
#: all steps are that are left.
_SHORTENED, _ROUNDS = 3, 16


@kernel
def _copy(starts, ends, source, target):
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            for axis in range(3):
                target[v, axis] = source[v, axis]


@kernel
def _list_changed(starts, ends, first, second, rows):
    count = 0
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            same = True
            for axis in range(3):
                # NaN differs from itself, and has not been changed.
                old = first[v, axis]
                same = same and (old == second[v, axis] or np.isnan(old))
            if not same:
                rows[count] = v
                count += 1
    return count


def _advice(one: Constraint, other: Constraint) -> str:
    """Return what to do about two constraints that conflict: leave out what the caller can leave out."""
    for always, asked in ((one, other), (other, one)):
        if always.always_in:
            left_out = str(asked)[0].lower() + str(asked)[1:]
            return f"Leave out {left_out}, or choose another filter than {always.always_in}."
    return "Leave one of them out."


class Disposal:
    """What becomes of the proposals of a run.

    Parameters
    ----------
    constraints : sequence of Constraint
        In any order.
    kept : frozenset of str
        Topics that the scheme keeps by itself: constraints about these are not needed.
    on_edges : bool
        Whether the scheme moves both ends of an edge at once.
    closing : Constraint, optional
        Conserves what the scheme keeps by itself where steps are taken back.
    guarded : bool
        Whether a scheme on edges judges its operations by the guards of constraints that have one.

    Attributes
    ----------
    constraints : list of Constraint
        In the order in which they act, with those that the promises of others take in addition.
    in_place : bool
        Whether neighbours must not move at the same time.

    Raises
    ------
    ParameterError
        Two constraints cannot be kept together, or one has no say in operations on edges: it changes steps
        otherwise than by taking a part of them.
    """

    def __init__(
        self,
        constraints: Sequence[Constraint],
        kept: frozenset[str],
        on_edges: bool,
        closing: Constraint | None = None,
        guarded: bool = True,
    ) -> None:
        needed = [each for each in constraints if each.topic not in kept]
        #: Constraints whose promise the scheme keeps.
        self.kept = [each for each in constraints if each.topic in kept]
        companions = [companion for each in constraints for companion in each.companions]
        needed += [companion for companion in companions if companion.topic not in kept]
        self.constraints = sorted(needed, key=lambda each: each.phase)
        self.on_edges = on_edges
        self.in_place = any(each.in_place for each in needed)
        for one in needed:
            for other in needed:
                if other.topic in one.conflicts:
                    raise ParameterError(
                        f"{one} cannot go together with {str(other)[0].lower()}{str(other)[1:]}: "
                        f"{one.conflicts[other.topic]}. {_advice(one, other)}"
                    )
            if on_edges and one.phase in (Phase.DIRECT, Phase.RETRACT, Phase.CONSERVE):
                raise ParameterError(
                    f"{one} cannot dispose of operations on edges: leave it out, or choose a scheme that "
                    "moves one vertex at a time."
                )
        by_phase = {phase: [each for each in self.constraints if each.phase == phase] for phase in Phase}
        self._directing, self._retracting = by_phase[Phase.DIRECT], by_phase[Phase.RETRACT]
        self._limiting, self._conserving = by_phase[Phase.LIMIT], by_phase[Phase.CONSERVE]
        self._judging, self._looking = by_phase[Phase.JUDGE], by_phase[Phase.LOOK]
        #: What conserves where steps are taken back, and limits that it takes in addition.
        self.closing: Constraint | None = None
        self._bounding = [each for each in needed if each.phase == Phase.LIMIT]
        if self._looking:
            for each in self._conserving:
                closing = closing or each.closing()
            self.closing = closing
            if closing is not None:
                topics = {each.topic for each in self._bounding}
                self._bounding += [each for each in closing.companions if each.topic not in topics]
        self._of_ends = [
            each for each in self._limiting + self._judging if on_edges and not (guarded and each.guards)
        ]
        self.in_place = self.in_place or bool(self._of_ends)
        if not self.in_place:
            covered = frozenset().union(*(each.covers for each in self._conserving))
            self._limiting = [each for each in self._limiting if each.topic not in covered]
        #: Whether gates judge each vertex as it moves; otherwise :meth:`unwelcome` says of a pass.
        self.judged_alone = True
        self._spare = np.empty((0, 3))

    @property
    def acting(self) -> list[Constraint]:
        """The constraints that act on the proposals of a pass."""
        return [each for each in self.constraints if each.phase not in (Phase.PIN, Phase.LOOK)]

    def bind(self, state: State) -> None:
        """Bind all constraints."""
        for constraint in self.constraints:
            constraint.bind(state)
        if self.closing is not None:
            self.closing.bind(state)

    def prepare(self, state: State) -> None:
        """Prepare the pass that begins."""
        for constraint in self.constraints:
            constraint.prepare(state)
        state.factors = factors(self.constraints)

    def dispose(self, state: State, starts: Int64, ends: Int64, proposed: Float64) -> None:
        """Change the targets in the rows ``starts[i]:ends[i]`` of `proposed` to what all allow."""
        for constraint in self._directing:
            constraint.dispose(state, starts, ends, proposed)
        if state.factors is not None:
            parallel.run(shorten, starts, ends, state.points, state.factors, proposed)
        if self.in_place:
            for constraint in self._conserving:
                constraint.dispose(state, starts, ends, proposed)
        for constraint in self._retracting:
            constraint.dispose(state, starts, ends, proposed)
        self._limit(state, starts, ends, proposed)
        if not self.in_place:
            for constraint in self._conserving:
                constraint.conserve(state, state.points, proposed, self.beyond, state.points)
        for judge in self._judging if self.judged_alone else ():
            judge.dispose(state, starts, ends, proposed)
            rows, last = starts, ends
            for _ in range(judge.halvings):
                rows = judge.halve(state, rows, last, proposed)
                last = rows + 1
                if not len(rows):
                    break
                for constraint in self._retracting:
                    constraint.dispose(state, rows, last, proposed)
                self._limit(state, rows, last, proposed)
                judge.dispose(state, rows, last, proposed)

    @property
    def judges_ends(self) -> bool:
        """Whether operations on edges are judged by :meth:`admitted`."""
        return any(self.judged_alone or each.phase != Phase.JUDGE for each in self._of_ends)

    def admitted(self, state: State, edges: npt.NDArray[np.int32], proposed: Float64) -> Float64:
        """Return what part of their steps to where they are `proposed` the edges, (k, 2), may take, (k,).

        Where it is 1, both ends may go. Otherwise it is what was left of the step of the end that may not; 0
        if that has to stay. No face may have vertices of two edges. First one end goes, then the other: each
        by itself keeps every promise, so that both do. The points are then as before; `proposed` is not.
        """
        part = self._part(state, edges[:, 0], proposed)
        good = part == 1.0
        first = edges[good, 0]
        before = state.points[first]
        state.points[first] = proposed[first]
        part[good] = self._part(state, edges[good, 1], proposed)
        state.points[first] = before
        return part

    def _part(self, state: State, vertices: npt.NDArray[np.int32], proposed: Float64) -> Float64:
        wanted, before = proposed[vertices], state.points[vertices]
        rows = np.sort(vertices).astype(np.int64)
        for constraint in self._of_ends:
            if self.judged_alone or constraint.phase != Phase.JUDGE:
                constraint.dispose(state, rows, rows + 1, proposed)
        left = proposed[vertices]
        part = np.linalg.norm(left - before, axis=1)
        whole = np.linalg.norm(wanted - before, axis=1)
        part = np.divide(part, whole, out=np.zeros_like(part), where=whole > 0.0)
        return np.where((left == wanted).all(axis=1), 1.0, np.minimum(part, 0.5))

    def _limit(self, state: State, starts: Int64, ends: Int64, proposed: Float64) -> None:
        """Shorten steps until every limit admits them."""
        if not self._limiting or len(self._limiting) + len(self._retracting) < 2:
            for constraint in self._limiting:
                constraint.dispose(state, starts, ends, proposed)
            return
        before = self._room(proposed)
        for turn in range(_ROUNDS + 1):
            parallel.run(_copy, starts, ends, proposed, before)
            for constraint in self._limiting:
                constraint.dispose(state, starts, ends, proposed)
            rows = np.empty(int((ends - starts).sum()), np.int64)
            rows = rows[: _list_changed(starts, ends, before, proposed, rows)].copy()
            if not len(rows):
                return
            if turn == _ROUNDS:
                rows = np.flatnonzero((proposed != state.points).any(axis=1))
            if turn >= _SHORTENED:
                _copy(rows, rows + 1, state.points, proposed)
            else:
                for constraint in self._retracting:
                    constraint.dispose(state, rows, rows + 1, proposed)
            if self.in_place:  # what becomes of one says nothing of the others
                starts, ends = rows, rows + 1

    def beyond(self, state: State, proposed: Float64) -> npt.NDArray[np.bool_]:
        """Return which vertices a limit would not let go to `proposed`, all at the same time, (n,)."""
        found = np.zeros(len(proposed), bool)
        if not self._limiting:
            return found
        starts, ends = parallel.ranges(len(proposed))
        for constraint in self._limiting:
            allowed = proposed.copy()
            constraint.dispose(state, starts, ends, allowed)
            found |= (allowed != proposed).any(axis=1)
        found &= state.pinned == 0
        return found

    # -- after some passes -------------------------------------------------------------------------

    @property
    def looks(self) -> bool:
        """Whether a constraint compares the surface with what it was some passes ago."""
        return bool(self._looking)

    def objections(
        self, state: State, before: Float64, after: Float64, changed: npt.NDArray[np.bool_] | None = None
    ) -> npt.NDArray[np.bool_]:
        """Return the vertices that must not all have gone from `before` to `after`, (n,), by looking."""
        near, found = state.near, np.zeros(len(after), bool)
        for each in self._looking:
            faces = each.found(state, before, after, changed)
            found[near.connectivity[faces[near.corner_face]]] = True
        found &= (before != after).any(axis=1)
        return found

    def broken(self, state: State, before: Float64, proposed: Float64, rows: Int64) -> npt.NDArray[np.bool_]:
        """Return the vertices that limits or gates do not let go to `proposed`, where only `rows` are new.

        Gates compare with the points `before`.
        """
        found = np.zeros(len(proposed), bool)
        for limit in self._bounding:
            found |= limit.exceeded(state, proposed, rows)
        for judge in self._judging:
            found |= judge.worsened(state, before, proposed)
        found &= state.pinned == 0
        return found

    def retract(self, state: State, rows: Int64, proposed: Float64) -> None:
        """Put the targets in some rows on the surfaces that they must be on."""
        for constraint in self._retracting:
            constraint.dispose(state, rows, rows + 1, proposed)

    def forget(self, state: State) -> None:
        """Let all constraints forget where the vertices were."""
        for constraint in self.constraints:
            constraint.forget(state)

    @property
    def judges_passes(self) -> bool:
        """Whether there are gates, and all the rest keeps its promise with each vertex that moves."""
        return bool(self._judging) and not any(
            each.needs_still or (self.on_edges and each not in self._of_ends) for each in self._limiting
        )

    def unwelcome(self, state: State, before: Float64) -> npt.NDArray[np.bool_]:
        """Return the vertices that must stay for the pass that began at `before` to be accepted, (n,)."""
        found = np.zeros(len(before), bool)
        for judge in self._judging:
            found |= judge.unwelcome(state, before, state.points)
        return found

    @property
    def closes(self) -> bool:
        """Whether a pass in place must be closed as a whole, see :meth:`close`."""
        return self.in_place and any(each.closes for each in self._conserving)

    def close(self, state: State, before: Float64) -> bool:
        """Close what a pass in place that began at `before` has left open.

        Returns False where that cannot be done; then all vertices are back at `before`.
        """
        kept = True
        for constraint in self._conserving:

            def beyond(state: State, proposed: Float64) -> npt.NDArray[np.bool_]:
                changed = np.flatnonzero((proposed != state.points).any(axis=1))
                return self.broken(state, before, proposed, changed)

            proposed = state.points.copy()
            kept = kept and constraint.conserve(state, state.points, proposed, beyond, before)
            state.points[:] = proposed if kept else before
        self.forget(state)
        return kept

    def check(self, state: State) -> list[str]:
        """Return the promises that do not hold after the run, a sentence each."""
        found = [(each, each.check(state)) for each in (*self.constraints, *self.kept)]
        return [f"{each}: {broken}." for each, broken in found if broken]

    def _room(self, like: Float64) -> Float64:
        if self._spare.shape != like.shape:
            self._spare = np.empty_like(like)
        return self._spare
