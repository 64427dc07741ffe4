"""Schemes propose: each says where every vertex would like to go.

One scheme, one file. A scheme reads the state and writes a target for each vertex of some ranges; it
never decides whether the vertex may go there. Pinned vertices are proposed to stay.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from ..state import State

Float64 = npt.NDArray[np.float64]
Int64 = npt.NDArray[np.int64]


class Scheme(ABC):
    """A rule that proposes new positions."""

    #: Passes over the mesh that make one iteration.
    passes: int = 1

    def bind(self, state: State) -> None:  # noqa: B027
        """Look at the mesh once, before the first pass."""

    def prepare(self, state: State, turn: int) -> None:  # noqa: B027 (most need nothing)
        """Compute what the proposals of pass `turn` of the iteration need of the whole mesh."""

    @abstractmethod
    def propose(self, state: State, turn: int, starts: Int64, ends: Int64, proposed: Float64) -> None:
        """Write targets for the vertices in ``starts[i]:ends[i]`` to the same rows of `proposed`."""


class EdgeScheme(Scheme):
    """A scheme whose operations move both ends of an edge at once.

    What one operation does to the surface (to its volume, say) must be carried out as a whole or not at
    all, so proposals do not pass through the constraints one vertex at a time. The loop hands over what
    the constraints say beforehand: pinned vertices, damping, and the space to stay in.
    """

    @abstractmethod
    def sweep(self, state: State, damping: Float64, space: Any) -> Iterator[tuple[float, int]]:
        """Do all operations once; yield the part done, 0 to 1, and how many were carried out since.

        Parameters
        ----------
        state : State
            Its points are up to date after the last step.
        damping : (n,) float64
            Part of each vertex' step that is taken; vertices with 0 keep their bits.
        space : Containment or None
            Operations that it does not allow are discarded.
        """

    def propose(self, state: State, turn: int, starts: Int64, ends: Int64, proposed: Float64) -> None:
        """Not for vertices alone."""
        raise TypeError(f"{type(self).__name__} works on edges; the loop calls its sweep.")
