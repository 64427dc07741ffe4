"""Self-intersection: no faces cross or touch that did not."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from ...containment.self_intersection import SelfIntersections
from ..run_state import State
from . import Constraint, Float64, Phase


class NoNewSelfIntersections(Constraint):
    """Pairs of faces that neither cross nor touch never do, and pairs that touch never cross.

    Looked at after some iterations and at the end of a run, not in each pass: see
    :mod:`~vtksmooth.kernels.smoothing.rollback`. Nor does a face lose its area. Pairs that cross at the start
    may go on, or come apart.

    States are compared, not the ways between them: an open sheet may pass through another one between two
    looks.

    Parameters
    ----------
    written : callable, optional
        Returns the points, (n, 3), as they will be written, where that rounds them: what is promised is
        promised of these.
    """

    name = "No new self-intersection (self_intersection)"
    phase = Phase.LOOK
    topic = "self-intersection"

    def __init__(self, written: Callable[[Float64], Float64] | None = None) -> None:
        self.written = written or (lambda points: points)

    def bind(self, state: State) -> None:
        self._pairs = SelfIntersections(state.topology, state.near)
        self._degenerate = np.zeros(state.topology.n_faces, np.bool_)
        self._degenerate[self._pairs.degenerate(self.written(state.points))] = True

    def found(
        self, state: State, before: Float64, after: Float64, changed: npt.NDArray[np.bool_] | None = None
    ) -> npt.NDArray[np.bool_]:
        topology, near = state.topology, state.near
        asked = None
        if changed is not None:
            asked = np.zeros(topology.n_faces, np.bool_)
            asked[near.corner_face[changed[near.connectivity]]] = True
        pairs, levels, degenerate = self._pairs.find(self.written(after), asked)
        faces = np.zeros(topology.n_faces, np.bool_)
        if len(pairs):
            worse = levels > self._pairs.levels(self.written(before), pairs)
            faces[pairs[worse]] = True
        faces[degenerate] |= ~self._degenerate[degenerate]
        return faces

    def check(self, state: State) -> str:
        found = int(self.found(state, state.original.points, state.points).sum())
        return f"{found} faces cross or touch others that did not" if found else ""
