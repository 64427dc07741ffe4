"""Schemes propose: each says where every vertex would like to go.

One scheme, one file. A scheme reads the state and writes a target for each vertex of some ranges; it
never decides whether the vertex may go there. Pinned vertices are proposed to stay.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ....report import RunReport
from ...containment.safe_moves import Guard
from ..constraints import Constraint
from ..run_state import State

Float64 = npt.NDArray[np.float64]
Int64 = npt.NDArray[np.int64]

#: A pass in place over the blocks of one colour, ``fused(first, starts, ends)``, `first` when the pass
#: begins. Returns how many vertices have moved.
Fused = Callable[[bool, Int64, Int64], int]


class Scheme(ABC):
    """A rule that proposes new positions."""

    #: Passes over the mesh that make one iteration.
    passes: int = 1

    #: Part of the proposed step that is taken: boundaries and ridges that slide go no more of their way.
    relaxation: float = 1.0

    #: Whether it moves vertices on lines between several labels along with these; otherwise they stay.
    moves_lines: bool = False

    #: Topics of constraints whose promise it keeps by itself.
    keeps: frozenset[str] = frozenset()

    def closing(self) -> Constraint | None:
        """Return what conserves the volume that it keeps by itself where steps were taken back."""
        return None

    def bind(self, state: State) -> None:  # noqa: B027
        """Look at the mesh once, before the first pass."""

    @property
    def finished(self) -> str:
        """Why there is no further iteration, a key of :data:`~vtksmooth.report.STOP_REASONS`, or ''."""
        return ""

    def prepare(self, state: State, turn: int) -> None:  # noqa: B027 (most need nothing)
        """Compute what the proposals of pass `turn` of the iteration need of the whole mesh."""

    def tell(self, report: RunReport) -> None:  # noqa: B027
        """Add to the report what the scheme knows of the run."""

    @abstractmethod
    def propose(self, state: State, turn: int, starts: Int64, ends: Int64, proposed: Float64) -> None:
        """Write targets for the vertices in ``starts[i]:ends[i]`` to the same rows of `proposed`."""

    def fuse(self, state: State, acting: Sequence[Constraint], k: Float64, colours: Int64) -> Fused | None:
        """Return a kernel that does a pass in place with exactly the constraints `acting`; None: in parts.

        Parameters
        ----------
        k : (m,) float64
            Aspect ratios of the faces as they are.
        colours : (c,) int64
            Starts of the ranges of vertices of one colour.
        """
        return None


class Operations(NamedTuple):
    """What a sweep has done since it last told.

    Attributes
    ----------
    part : float
        Of the whole sweep that is done, 0 to 1.
    moved, checked, asked : int
        Operations carried out, moves that were judged, and distances asked for.
    """

    part: float
    moved: int
    checked: int
    asked: int


#: ``admitted(state, edges, proposed)`` returns what part of their steps to where they are `proposed` the
#: `edges`, (k, 2), may take: 1 where both ends may go, otherwise at most 1/2. No face may have vertices of
#: two of them. What becomes of `proposed` does not matter.
Admitted = Callable[[State, npt.NDArray[np.int32], Float64], Float64]


class EdgeScheme(Scheme):
    """A scheme whose operations move both ends of an edge at once.

    What one operation does to the surface (to its volume, say) must be carried out as a whole or not at
    all, so constraints cannot change the step of one end. The loop hands over what they say beforehand,
    pinned vertices, damping, and the guard of the space to stay in; and what limits and gates say of both
    ends.
    """

    #: Whether it reads the guard; otherwise a space to stay in is judged as all limits are.
    guarded: bool = True

    @abstractmethod
    def sweep(
        self, state: State, damping: Float64, guard: Guard, admitted: Admitted | None = None
    ) -> Iterator[Operations]:
        """Do all operations once; tell now and then what has been done.

        Parameters
        ----------
        state : State
            Its points are up to date after the last step.
        damping : (n,) float64
            Part of each vertex' step that is taken; vertices with 0 keep their bits.
        guard : Guard
            Operations that it does not allow are not carried out, but perhaps shorter ones.
        admitted : callable, optional
            The same of operations that it does not admit.
        """

    def propose(self, state: State, turn: int, starts: Int64, ends: Int64, proposed: Float64) -> None:
        """Not for vertices alone."""
        raise TypeError(f"{type(self).__name__} works on edges; the loop calls its sweep.")
