"""Constraints: each restricts what becomes of the proposals, and says in which phase of a pass.

One constraint, one file. A constraint knows no other: :mod:`~vtksmooth.kernels.smoothing.phases` puts them in
order, shortens what several of them limit, and refuses those that cannot be kept together.
"""

from __future__ import annotations

from collections.abc import Callable
from enum import IntEnum
from typing import Any

import numpy as np
import numpy.typing as npt

from ....report import RunReport
from ..run_state import State

Float64 = npt.NDArray[np.float64]
Int64 = npt.NDArray[np.int64]

#: Says which vertices may not go where they are proposed to, all at the same time.
Beyond = Callable[[State, Float64], npt.NDArray[np.bool_]]


class Phase(IntEnum):
    """When a constraint acts on the proposals of a pass."""

    #: Pins vertices before the first pass, and does not act later.
    PIN = 0
    #: Changes the direction of steps.
    DIRECT = 1
    #: Multiplies each step by a factor.
    SCALE = 2
    #: Replaces targets by points of a surface.
    RETRACT = 3
    #: Shortens steps to what is admissible. A step of zero always is.
    LIMIT = 4
    #: Corrects steps so that a quantity stays, within what the limits leave.
    CONSERVE = 5
    #: Accepts the step of a vertex, or refuses it.
    JUDGE = 6
    #: Compares the surface with what it was some passes ago, and takes back what it does not allow.
    LOOK = 7


class Constraint:
    """Something that a run must respect."""

    #: What messages call it, and the parameters that ask for it.
    name: str = ""

    #: When it acts.
    phase: Phase = Phase.LIMIT

    #: What it is about, for :attr:`conflicts`, :attr:`covers` and what schemes keep by themselves.
    topic: str = ""

    #: The filter that always has this constraint; empty where a parameter turns it on and off.
    always_in: str = ""

    #: Topics of constraints that it cannot be kept together with, and why.
    conflicts: dict[str, str] = {}  # noqa: RUF012

    #: Constraints that its promise takes in addition.
    companions: tuple[Constraint, ...] = ()

    #: Topics of limits that it keeps by itself where all vertices move at the same time.
    covers: frozenset[str] = frozenset()

    #: Whether its promise holds only when neighbours do not move at the same time.
    in_place: bool = False

    #: After `prepare`, the part of each vertex' step that is taken, (n,) in [0, 1]; None: all of it.
    damping: Float64 | None = None

    #: How often a step is halved that is refused, in phase JUDGE.
    halvings: int = 0

    #: Whether, in phase CONSERVE, moves of single vertices leave something that a pass must close as a whole.
    closes: bool = False

    #: Whether vertices on lines between several labels must stay, as it knows surfaces only.
    holds_lines: bool = False

    #: Whether it can judge a vertex only if its neighbours stand still.
    needs_still: bool = False

    #: Whether schemes on edges judge their operations by its :attr:`guard`, not by :meth:`dispose`.
    guards: bool = False

    #: What these schemes read; None before it is bound.
    guard: Any = None

    def __str__(self) -> str:
        return self.name or type(self).__name__

    def bind(self, state: State) -> None:
        """Look at the mesh once, before the first pass; pin vertices that may never move."""

    def prepare(self, state: State) -> None:
        """Compute what the pass that begins needs of the whole mesh."""

    def dispose(self, state: State, starts: Int64, ends: Int64, proposed: Float64) -> None:
        """Change the targets in the rows ``starts[i]:ends[i]`` of `proposed` to what is allowed."""

    def count(self, checked: int, asked: int) -> None:
        """Add what kernels that were handed :attr:`guard` have checked and asked."""

    def conserve(
        self, state: State, before: Float64, proposed: Float64, beyond: Beyond, back: Float64
    ) -> bool:
        """Correct the steps from `before` to `proposed` of all vertices, in phase CONSERVE.

        Parameters
        ----------
        beyond : callable
            ``beyond(state, proposed)`` returns which vertices may not go there, (n,) bool.
        back : (n, 3) float64
            Where vertices go back to if nothing else keeps the quantity, all that hang together.

        Returns
        -------
        bool
            Whether the quantity is kept with steps that are not all zero.
        """
        raise NotImplementedError

    def exceeded(self, state: State, proposed: Float64, rows: Int64) -> npt.NDArray[np.bool_]:
        """Return the vertices that may not go to `proposed`, all at the same time, (n,), in phase LIMIT.

        Only the vertices `rows` need be looked at, and what changes with them.
        """
        allowed = proposed.copy()
        self.dispose(state, rows, rows + 1, allowed)
        found: npt.NDArray[np.bool_] = (allowed != proposed).any(axis=1)
        return found

    def closing(self) -> Constraint | None:
        """Return what conserves the quantity once more where steps were taken back, in phase CONSERVE.

        It counts from the start of the run. None: nothing need be conserved.
        """
        return None

    def forget(self, state: State) -> None:
        """Forget where the vertices were: they have been moved by something else than passes."""

    def found(
        self, state: State, before: Float64, after: Float64, changed: npt.NDArray[np.bool_] | None = None
    ) -> npt.NDArray[np.bool_]:
        """Return which faces must not be where they are at `after`, (m,), in phase LOOK.

        At `before` they were not so. Only faces with vertices that have `changed`, (n,), need be looked at,
        and what changes with them.
        """
        raise NotImplementedError

    def worsened(self, state: State, before: Float64, after: Float64) -> npt.NDArray[np.bool_]:
        """Return the vertices because of which a whole pass would be refused, in phase JUDGE."""
        raise NotImplementedError

    def unwelcome(self, state: State, before: Float64, after: Float64) -> npt.NDArray[np.bool_]:
        """Return the vertices that must stay for a pass to be accepted as a whole, in phase JUDGE.

        As :meth:`worsened`, and where a pass is not worth it.
        """
        raise NotImplementedError

    def halve(self, state: State, starts: Int64, ends: Int64, proposed: Float64) -> Int64:
        """Put halves of the steps that were refused into `proposed`; return whose, in phase JUDGE."""
        raise NotImplementedError

    def check(self, state: State) -> str:
        """Return what of its promise does not hold after the run, in a few words; '' if all does.

        Measured from scratch, on `state.points` against `state.original`, with a tolerance for rounding.
        """
        return ""

    def tell(self, report: RunReport) -> None:
        """Add to the report what this constraint knows of the run."""


def moved(state: State, held: npt.NDArray[np.bool_]) -> str:
    """Say how many of the vertices that are `held`, (n,), do not have the bits they had; '' if all do."""
    before, after = state.original.points[held], state.points[held]
    count = int((before.view(np.uint64) != after.view(np.uint64)).any(axis=1).sum())
    return f"{count} vertices moved that must stay" if count else ""
