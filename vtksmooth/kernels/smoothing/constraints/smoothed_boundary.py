"""Smoothed boundary: outlines are smoothed as curves, with the area that they enclose."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ....jit import parallel
from ....jit.compiled import kernel
from ...measures.aspect_ratio import ring_normals
from ...mesh.adjacency import BOUNDARY, NON_MANIFOLD
from ..run_state import State
from . import Constraint, Float64, Int64, Phase, moved

#: Over how many edges to either side a boundary must turn to have a corner: a zigzag does not.
_REACH = 4

#: Least length of the mean of an arc's unit normals by which they say what lies in the surface.
_AGREE = 0.5


@kernel
def _take(starts, ends, free, targets, proposed):
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            row = free[v]
            if row >= 0:
                for axis in range(3):
                    proposed[v, axis] = targets[row, axis]


class SmoothedBoundary(Constraint):
    """Boundary vertices move towards the middle of their two neighbours on the boundary; corners stay.

    All at once before each pass, whatever the scheme proposes: the Laplacian of the curve, at most half of
    it, as on a sliding boundary. Then each arc, a loop or what lies between two vertices that stay, takes an
    equal step across itself by which the area is again that of the start. The area is that in the plane of a
    loop's vector area, or in the mean tangent plane of the surface along an arc.

    Where other constraints hold vertices back, the area is closed in later passes.

    Parameters
    ----------
    corner_angle : float
        Vertices where the boundary turns by more than this, over one edge to either side as well as over up
        to four, stay; degrees.
    """

    topic = "boundary"
    phase = Phase.DIRECT
    name = "A smoothed boundary (boundary)"

    def __init__(self, corner_angle: float = 30.0) -> None:
        self.corner_angle = corner_angle

    def bind(self, state: State) -> None:
        kinds, ring = state.near.kinds, state.near.boundary_ring
        state.pinned[kinds == NON_MANIFOLD] = 1
        rim = np.flatnonzero(kinds == BOUNDARY)
        state.pinned[rim[_least_turns(state.points, rim, ring) > self.corner_angle]] = 1
        self._found = False

    def prepare(self, state: State) -> None:
        if not self._found:  # other constraints may have pinned vertices after this one
            self._find_arcs(state)
            self._found = True
        points, (vertices, before, after) = state.points, self._chains
        middle = 0.5 * (points[before] + points[after])
        self._targets = points[vertices] + state.slide * (middle - points[vertices])
        if state.slide:
            self._close(state)

    def _find_arcs(self, state: State) -> None:
        """List the vertices that move, arc by arc, and the edges at them; measure the areas."""
        ring = state.near.boundary_ring
        moves = (state.near.kinds == BOUNDARY) & (state.pinned == 0)
        free = np.flatnonzero(moves)
        waiting = moves.copy()
        chain: list[int] = []
        arc: list[int] = []
        count = 0
        # Arcs with ends first, so that what is left are loops.
        for first in [*free[~moves[ring[free, 0]]].tolist(), *free.tolist()]:
            v = first
            if not waiting[v]:
                continue
            while v >= 0 and waiting[v]:
                waiting[v] = False
                chain.append(v)
                arc.append(count)
                v = int(ring[v, 1])
            count += 1
        vertices, of_arc = np.array(chain, np.int64), np.array(arc, np.int64)
        before, after = ring[vertices, 0].astype(np.int64), ring[vertices, 1].astype(np.int64)
        self._chains = (vertices, before, after)
        self._row = np.full(len(state.points), -1, np.int64)
        self._row[vertices] = np.arange(len(vertices))
        # Edges that end at a vertex that moves, and those that lead on to one that does not.
        on = ~moves[after]
        self._tails = np.concatenate((before, vertices[on]))
        self._heads = np.concatenate((vertices, after[on]))
        self._arc, self._arc_of_edge = of_arc, np.concatenate((of_arc, of_arc[on]))
        self._count = count
        sizes = np.bincount(of_arc, minlength=count)[:, None]
        self._middle = self._sums(state.points[vertices], of_arc) / sizes
        area = self._vector_areas(state.points)
        loop = np.ones(count, bool)
        loop[of_arc[~moves[before]]] = False
        normals = self._sums(_unit(ring_normals(state.mesh)[vertices]), of_arc) / sizes
        agree = np.linalg.norm(normals, axis=1) > _AGREE
        self._normal = _unit(np.where((loop | ~agree)[:, None], area, normals))
        self._area = (area * self._normal).sum(axis=1)

    def _sums(self, values: Float64, arc: Int64) -> Float64:
        return np.column_stack([np.bincount(arc, column, self._count) for column in values.T])

    def _vector_areas(self, points: Float64) -> Float64:
        """Return the vector area of the cone from the middle of each arc over it."""
        middle = self._middle[self._arc_of_edge]
        cones = 0.5 * np.cross(points[self._tails] - middle, points[self._heads] - middle)
        return self._sums(cones, self._arc_of_edge)

    def _close(self, state: State) -> None:
        """Move each arc across itself so that its area is that of the start: a quadratic equation."""
        vertices, before, after = self._chains
        points = state.points.copy()
        points[vertices] = self._targets
        normal = self._normal[self._arc_of_edge]
        across = np.zeros_like(points)
        across[vertices] = _unit(np.cross(points[after] - points[before], self._normal[self._arc]))
        middle = self._middle[self._arc_of_edge]
        p, q = points[self._tails] - middle, points[self._heads] - middle
        d, e = across[self._tails], across[self._heads]

        def summed(vectors: Float64) -> Float64:
            of_edges = 0.5 * (vectors * normal).sum(axis=1)
            return np.bincount(self._arc_of_edge, of_edges, self._count).astype(np.float64)

        constant = summed(np.cross(p, q)) - self._area
        slope, bend = summed(np.cross(d, q) + np.cross(p, e)), summed(np.cross(d, e))
        root = slope * slope - 4.0 * bend * constant
        below = slope + np.sign(slope) * np.sqrt(np.maximum(root, 0.0))
        step = np.divide(
            -2.0 * constant, below, out=np.zeros_like(slope), where=(root > 0.0) & (below != 0.0)
        )
        self._targets += step[self._arc][:, None] * across[vertices]

    def dispose(self, state: State, starts: Int64, ends: Int64, proposed: Float64) -> None:
        parallel.run(_take, starts, ends, self._row, self._targets, proposed)

    def check(self, state: State) -> str:
        kinds = state.near.kinds
        return moved(state, (kinds == NON_MANIFOLD) | ((kinds == BOUNDARY) & (state.pinned != 0)))


def _unit(vectors: Float64) -> Float64:
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    unit: Float64 = np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0.0)
    return unit


def _least_turns(points: Float64, rim: Int64, ring: npt.NDArray[np.int32]) -> Float64:
    """Return the least angle by which the boundary turns at each vertex, over 1 to 4 edges, degrees."""
    least = np.full(len(rim), 180.0)
    first, last = rim.astype(np.int64), rim.astype(np.int64)
    for _ in range(_REACH):
        # Where the boundary ends at a vertex that has none, it is as far as one can look.
        first = np.where(ring[first, 0] >= 0, ring[first, 0], first)
        last = np.where(ring[last, 1] >= 0, ring[last, 1], last)
        came, goes = points[rim] - points[first], points[last] - points[rim]
        turn = np.degrees(np.arctan2(np.linalg.norm(np.cross(came, goes), axis=1), (came * goes).sum(axis=1)))
        least = np.where((first != rim) & (last != rim), np.minimum(least, turn), least)
    return least
