"""Constraints dispose: each restricts what becomes of the proposals.

One constraint, one file. The loop binds every constraint once, then has them act, in the order given,
on the proposals for some ranges of vertices; what is left of the proposals is carried out.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from ...report import RunReport
from ..state import State

Float64 = npt.NDArray[np.float64]
Int64 = npt.NDArray[np.int64]


class Constraint:
    """Something that a run must respect."""

    #: What messages call it, and the parameters that ask for it.
    name: str = ""

    #: Whether the constraint's promise holds only when neighbours do not move at the same time.
    in_place: bool = False

    #: Whether what is left of a step is allowed in any part: half of it needs no second look.
    convex: bool = True

    #: Whether it can restrict operations on edges, which move both ends at once: by pinning, by
    #: :attr:`damping`, or because the scheme knows it.
    on_edges: bool = False

    #: After `prepare`, the part of each vertex' step that is taken, (n,) in [0, 1]; None: all of it.
    damping: Float64 | None = None

    def __str__(self) -> str:
        return self.name or type(self).__name__

    def bind(self, state: State) -> None:
        """Look at the mesh once, before the first pass; pin vertices that may never move."""

    def follow(self, before: Sequence[Constraint]) -> None:
        """Hear, before the run, of the constraints that act before this one."""

    def prepare(self, state: State) -> None:
        """Compute what the pass that begins needs of the whole mesh."""

    def dispose(self, state: State, starts: Int64, ends: Int64, proposed: Float64) -> None:
        """Change the targets in the rows ``starts[i]:ends[i]`` of `proposed` to what is allowed."""

    def tell(self, report: RunReport) -> None:
        """Add to the report what this constraint knows of the run."""
