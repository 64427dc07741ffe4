"""On a source: vertices are put and kept on another surface, those near its ridges on these."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ....report import RunReport
from ...distance.closest_point import ClosestPoint
from ...features.detection import CORNER, Features
from ...mesh.adjacency import UNUSED
from ...mesh.mesh import Mesh
from ..run_state import State
from . import Constraint, Float64, Int64, Phase

#: How far from a ridge or a corner of the source a vertex belongs to it, in mean edges at the vertex.
_NEAR = 0.25

#: What each vertex is kept on.
_NOTHING, _SURFACE, _RIDGE, _CORNER = -1, 0, 1, 2


class OnSource(Constraint):
    """Put vertices on another surface, and keep them there.

    Vertices that are nearer to a ridge of that surface than a quarter of their mean edge slide along its
    ridges; the nearest vertex to each corner, within the same distance, goes there. A vertex that another
    constraint lets go nowhere stays where it is. Vertices on lines that slide (boundaries, features) are put
    there after they have slid.

    Parameters
    ----------
    mesh : Mesh
        The source.
    features : Features
        Its ridges and corners; its boundary is among the ridges.
    """

    phase = Phase.RETRACT
    topic = "surface"
    name = "The source (source)"

    def __init__(self, mesh: Mesh, features: Features) -> None:
        self.surface = ClosestPoint(mesh)
        self.corners = mesh.points[features.classes >= CORNER]
        edges = features.ridge_edges
        self.ridges = ClosestPoint.of_lines(mesh.points, edges) if len(edges) else None
        self._diagonal = mesh.diagonal

    def bind(self, state: State) -> None:
        kinds, points = state.near.kinds, state.points
        self._on = np.full(len(points), _SURFACE, np.int8)
        self._on[(kinds == UNUSED) | (state.pinned != 0)] = _NOTHING
        state.elsewhere = True
        self._corner = np.zeros(len(points), np.int64)
        reach = _NEAR * _mean_edges(state)
        free = np.flatnonzero(self._on == _SURFACE)
        if self.ridges is not None and len(free):
            distance = self.ridges.query(points[free])[1]
            self._on[free[distance <= reach[free]]] = _RIDGE
        for number, corner in enumerate(self.corners):
            if not len(free):
                break
            distance = np.linalg.norm(points[free] - corner, axis=1)
            nearest = int(distance.argmin())
            if distance[nearest] <= reach[free[nearest]]:
                self._on[free[nearest]], self._corner[free[nearest]] = _CORNER, number

    def _targets(self, rows: Int64, wanted: Float64) -> Float64:
        targets = wanted.copy()
        for kind, lines in ((_SURFACE, self.surface), (_RIDGE, self.ridges)):
            there = self._on[rows] == kind
            if lines is not None and there.any():
                targets[there] = lines.query(wanted[there])[0]
        there = self._on[rows] == _CORNER
        targets[there] = self.corners[self._corner[rows[there]]]
        return targets

    def dispose(self, state: State, starts: Int64, ends: Int64, proposed: Float64) -> None:
        ranges = [np.arange(a, b) for a, b in zip(starts, ends, strict=True)]
        rows = np.concatenate([np.empty(0, np.int64), *ranges])  # there may be no ranges
        rows = rows[(self._on[rows] >= 0) & (state.pinned[rows] == 0)]
        if not len(rows):
            return
        wanted = proposed[rows]
        targets = self._targets(rows, wanted)
        # Who stays where it is, on the surface, keeps its bits.
        still = (wanted == state.points[rows]).all(axis=1)
        still &= np.linalg.norm(targets - wanted, axis=1) <= 1e-14 * self._diagonal
        proposed[rows[~still]] = targets[~still]

    def check(self, state: State) -> str:
        moved = (state.points != state.original.points).any(axis=1) & (state.pinned == 0)
        rows = np.flatnonzero(moved & (self._on >= 0))
        off = np.linalg.norm(self._targets(rows, state.points[rows]) - state.points[rows], axis=1)
        allowed = 1e-12 * max(self._diagonal, state.original.diagonal)
        farthest = off.max(initial=0.0)
        return f"a vertex is off by {farthest:.3g}" if farthest > allowed else ""

    def tell(self, report: RunReport) -> None:
        report.on_source = tuple(int((self._on == kind).sum()) for kind in (_SURFACE, _RIDGE, _CORNER))


def _mean_edges(state: State) -> npt.NDArray[np.float64]:
    """Return the mean length of the edges at each vertex, (n,); 0 without edges."""
    near, count = state.near, len(state.points)
    owner = np.repeat(np.arange(count), np.diff(near.ring_offsets))
    length = np.linalg.norm(state.points[near.ring] - state.points[owner], axis=1)
    mean: npt.NDArray[np.float64] = np.bincount(owner, length, count) / np.maximum(
        np.bincount(owner, minlength=count), 1
    )
    return mean
