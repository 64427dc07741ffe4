"""Containment with few distance queries: a vertex that has not gone far cannot have left."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

Bool = npt.NDArray[np.bool_]
Float64 = npt.NDArray[np.float64]
Int = npt.NDArray[np.signedinteger]


class CachedDistance:
    """Signed distances of vertices that move, asked for only where they may have become too large.

    A signed distance changes by no more than the way gone (it is 1-Lipschitz). So a vertex that was d
    inside at its last query, and is no farther from that place, is inside still; paper B, section 6,
    skips these queries, which are nearly all.

    Parameters
    ----------
    distance : callable
        Takes points (q, 3) and returns their signed distances (q,), negative inside.
    points : (n, 3) float64
        Where the vertices are at the start; all of them are asked for.
    tolerance : float
        Largest distance that counts as inside.

    Attributes
    ----------
    distances : (n,) float64
        Signed distance of each vertex at its last query.
    places : (n, 3) float64
        Where it was then.
    limits : (n,) float64
        The distance that each vertex may reach: the tolerance, or where it started outside (so that it
        may come back, and never gets worse).
    outside_at_start : int
        Vertices that started outside.
    asked, saved : int
        Queries made after the start, and queries that were not needed.

    Examples
    --------
    >>> ball = CachedDistance(lambda points: np.linalg.norm(points, axis=1) - 1.0, np.zeros((2, 3)))
    >>> ball.allowed(np.array([0, 1]), np.array([[0.5, 0, 0], [0, 2.0, 0]])).tolist()
    [True, False]
    >>> ball.asked, ball.saved
    (1, 1)
    """

    def __init__(
        self, distance: Callable[[Float64], Float64], points: Float64, tolerance: float = 0.0
    ) -> None:
        self.distance = distance
        self.places = np.array(points, dtype=np.float64)
        self.distances = distance(self.places)
        self.limits = np.maximum(self.distances, tolerance)
        self.outside_at_start = int((self.distances > tolerance).sum())
        self.asked = self.saved = 0

    def certain(self, rows: Int, points: Float64) -> Bool:
        """Return where the vertices `rows` (q,) may be at `points` (q, 3) without a query."""
        gone = np.sqrt(np.square(points - self.places[rows]).sum(axis=1))
        near: Bool = self.distances[rows] + gone <= self.limits[rows]
        return near

    def allowed(self, rows: Int, points: Float64) -> Bool:
        """Return where the vertices `rows` (q,) may be at `points` (q, 3); what must be asked is one batch.

        The answers are kept, whether the vertices go there or not. A vertex may stand in `rows` once.
        """
        result = self.certain(rows, points)
        unsure = np.flatnonzero(~result)
        self.saved += len(rows) - len(unsure)
        self.asked += len(unsure)
        if len(unsure):
            who = rows[unsure]
            found = self.distance(np.ascontiguousarray(points[unsure]))
            self.distances[who], self.places[who] = found, points[unsure]
            result[unsure] = found <= self.limits[who]
        return result
