"""Feature edges given by hand: added to those that were detected, or taken from them."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ...errors import InvalidMeshError
from ..mesh.adjacency import Adjacency
from ..mesh.mesh import Mesh
from ..mesh.regions import Rings, edge_numbers
from .detection import CORNER, CORNER_ANGLE, CUSP, REGULAR, RIDGE, SMOOTH, Features

Int32 = npt.NDArray[np.int32]
Pairs = npt.NDArray[np.integer]


def edited(found: Features, mesh: Mesh, near: Adjacency, added: Pairs, removed: Pairs) -> Features:
    """Return features with edges added and removed by hand.

    Only at the ends of edges that come or go something changes. A vertex with no ridge edge left is
    smooth; with one it is a corner, where the line ends; with two it lies on a ridge, however sharply that
    turns, for a line drawn along edges goes zigzag; with more it is a corner. A corner that has two left
    stays one if the ridge turns by more than the corner angle there. Cusps stay.

    Parameters
    ----------
    found : Features
        Those detected. Without ``ridge_edges`` they are taken from ``ridge_ring``.
    mesh : Mesh
    near : Adjacency
    added, removed : (k, 2) int arrays
        Edges as pairs of points; an edge that is in both is added.

    Raises
    ------
    InvalidMeshError
        A pair is no edge of the mesh.
    """
    n = mesh.n_points
    for pairs in (added, removed):
        check_edges(pairs, Rings(near.ring_offsets, near.ring))
    before, kinds = _edges_of(found)
    numbers, plus = edge_numbers(before, n), np.unique(edge_numbers(added, n))
    minus = np.setdiff1d(edge_numbers(removed, n), plus)
    gone, new = np.isin(numbers, minus), np.setdiff1d(plus, numbers)
    new_edges = np.column_stack((new // n, new % n)).astype(np.int32)
    edges = np.concatenate((before[~gone], new_edges))
    kinds = np.concatenate((kinds[~gone], np.full(len(new), REGULAR, np.uint8)))
    order = np.lexsort((edges[:, 1], edges[:, 0]))
    edges, kinds = edges[order], kinds[order]
    touched = np.unique(np.concatenate((before[gone], new_edges)))
    classes, ring = found.classes.copy(), found.ridge_ring.copy()
    touched = touched[classes[touched] != CUSP]
    degree, first, second = _neighbours(edges, touched)
    turn = _turning(mesh.points, touched, first, second)
    limit = CORNER_ANGLE if np.isnan(found.corner_angle) else found.corner_angle
    on_ridge = (degree == 2) & ((classes[touched] != CORNER) | (turn <= np.radians(limit)))
    classes[touched] = np.where(degree == 0, SMOOTH, np.where(on_ridge, RIDGE, CORNER))
    ring[touched] = np.where(on_ridge[:, None], np.column_stack((first, second)), -1)
    ring[(ring >= 0) & (classes[ring] == SMOOTH)] = -1
    return Features(classes, ring, edges, kinds, found.ridge_angle, found.corner_angle)


def check_edges(pairs: Pairs, rings: Rings) -> None:
    """Raise InvalidMeshError where one of (k, 2) `pairs` of points is no edge."""
    n = len(rings.ring_offsets) - 1
    inside = ((pairs >= 0) & (pairs < n)).all(axis=1)
    usable = pairs[inside]
    starts = rings.ring_offsets[usable[:, 0]].astype(np.int64)
    sizes = rings.ring_offsets[usable[:, 0] + 1] - starts
    rows = np.repeat(np.arange(len(usable)), sizes)
    slots = np.arange(len(rows)) - np.repeat(np.cumsum(sizes) - sizes, sizes) + np.repeat(starts, sizes)
    known = np.zeros(len(pairs), np.bool_)
    known[np.flatnonzero(inside)[rows[rings.ring[slots] == usable[rows, 1]]]] = True
    if not known.all():
        a, b = pairs[np.flatnonzero(~known)[0]].tolist()
        raise InvalidMeshError(
            f"{(~known).sum()} of the feature edges are no edges of the mesh (the first: {a}-{b}); they "
            "belong to another mesh, remove them."
        )


def _edges_of(found: Features) -> tuple[Int32, npt.NDArray[np.uint8]]:
    if len(found.ridge_edges):
        kinds = found.edge_kinds
        return found.ridge_edges, kinds if len(kinds) else np.zeros(len(found.ridge_edges), np.uint8)
    v, side = np.nonzero(found.ridge_ring >= 0)
    pairs = np.column_stack((v, found.ridge_ring[v, side])).astype(np.int32)
    edges = np.unique(np.sort(pairs, axis=1), axis=0)
    return edges, np.zeros(len(edges), np.uint8)


def _neighbours(edges: Int32, points: Pairs) -> tuple[Pairs, Pairs, Pairs]:
    """Return how many edges meet at each of `points`, and the first two neighbours by them, or -1."""
    both = np.concatenate((edges, edges[:, ::-1]))
    both = both[np.lexsort((both[:, 1], both[:, 0]))]
    begin, end = (np.searchsorted(both[:, 0], points, side) for side in ("left", "right"))
    # Two rows more, so that there is always something to look at.
    ends = np.concatenate((both[:, 1], [-1, -1]))
    degree = end - begin
    return degree, np.where(degree > 0, ends[begin], -1), np.where(degree > 1, ends[begin + 1], -1)


def _turning(
    points: npt.NDArray[np.float64], at: Pairs, first: Pairs, second: Pairs
) -> npt.NDArray[np.float64]:
    """Return by how much the way from `first` over `at` to `second` turns, radians."""
    a, b = points[at] - points[first], points[second] - points[at]
    sine = np.linalg.norm(np.cross(a, b), axis=1)
    return np.asarray(np.arctan2(sine, (a * b).sum(axis=1)))
