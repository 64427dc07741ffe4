"""Schemes propose: each says where every vertex would like to go.

One scheme, one file. A scheme reads the state and writes a target for each vertex of some ranges; it
never decides whether the vertex may go there. Pinned vertices are proposed to stay.
"""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
import numpy.typing as npt

from ..state import State

Float64 = npt.NDArray[np.float64]
Int64 = npt.NDArray[np.int64]


class Scheme(ABC):
    """A rule that proposes new positions."""

    #: Passes over the mesh that make one iteration.
    passes: int = 1

    def prepare(self, state: State, turn: int) -> None:  # noqa: B027 (most need nothing)
        """Compute what the proposals of pass `turn` of the iteration need of the whole mesh."""

    @abstractmethod
    def propose(self, state: State, turn: int, starts: Int64, ends: Int64, proposed: Float64) -> None:
        """Write targets for the vertices in ``starts[i]:ends[i]`` to the same rows of `proposed`."""
