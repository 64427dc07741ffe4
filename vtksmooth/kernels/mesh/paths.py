"""Distances and shortest paths along the edges of a mesh (Dijkstra)."""

from __future__ import annotations

import heapq

import numpy as np
import numpy.typing as npt

from ...jit.compiled import kernel
from .regions import Rings

Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]


@kernel
def _travel(points, ring_offsets, ring, sources, target, limit, distance, previous):
    heap = [(0.0, sources[0])]
    for v in sources:
        distance[v] = 0.0
    for v in sources[1:]:
        heapq.heappush(heap, (0.0, v))
    while len(heap) > 0:
        so_far, v = heapq.heappop(heap)
        if so_far > distance[v]:
            continue  # there was a shorter way
        if v == target:
            break
        for r in range(ring_offsets[v], ring_offsets[v + 1]):
            w = ring[r]
            x = points[w, 0] - points[v, 0]
            y = points[w, 1] - points[v, 1]
            z = points[w, 2] - points[v, 2]
            way = so_far + np.sqrt(x * x + y * y + z * z)
            # Of ways of the same length the one by the smaller number, whichever was found first.
            if way < distance[w] and way <= limit:
                distance[w] = way
                previous[w] = v
                heapq.heappush(heap, (way, np.int64(w)))
            elif way == distance[w] and v < previous[w] and way > so_far:
                previous[w] = v


def _run(
    points: Float64, rings: Rings, sources: npt.ArrayLike, target: int, limit: float
) -> tuple[Float64, Int32]:
    distance, previous = np.full(len(points), np.inf), np.full(len(points), -1, np.int32)
    starts = np.ascontiguousarray(sources, dtype=np.int64)
    if len(starts):
        _travel(points, *rings, starts, target, limit, distance, previous)
    return distance, previous


def edge_distances(points: Float64, rings: Rings, sources: npt.ArrayLike, limit: float = np.inf) -> Float64:
    """Return the length of the shortest way along edges to the nearest source, (n,) float64.

    Parameters
    ----------
    points : (n, 3) float64
    rings : Rings
    sources : (k,) array_like of int
    limit : float
        Points farther away than this have inf, as those have that no way leads to.

    Examples
    --------
    >>> from vtksmooth.kernels.mesh.mesh import Mesh
    >>> from vtksmooth.kernels.mesh.regions import rings_of
    >>> square = Mesh.from_faces([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]])
    >>> edge_distances(square.points, rings_of(square), [0]).tolist()
    [0.0, 1.0, 2.0, 1.0]
    """
    return _run(points, rings, sources, -1, limit)[0]


def shortest_path(points: Float64, rings: Rings, start: int, end: int) -> Int32:
    """Return the points of a shortest way along edges from `start` to `end`, both included.

    Source: E. W. Dijkstra, "A Note on Two Problems in Connexion with Graphs", 1959. Of ways of the same
    length it is the one by the smaller point numbers, seen from the end.

    Returns
    -------
    (k,) int32
        Empty where no way leads from one to the other.
    """
    _, previous = _run(points, rings, [start], end, np.inf)
    path = [end]
    while path[-1] != start:
        if previous[path[-1]] < 0:
            return np.empty(0, np.int32)
        path.append(int(previous[path[-1]]))
    return np.array(path[::-1], np.int32)
