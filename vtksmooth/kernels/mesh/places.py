"""Points in one place: which points coincide exactly, and the faces over distinct places."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ...jit.compiled import kernel
from . import adjacency
from .mesh import Mesh
from .regions import components
from .union_find import find_root, join

Bool = npt.NDArray[np.bool_]
Int64 = npt.NDArray[np.int64]


@kernel
def _number_places(coordinates, bits, table, shift, place, first):
    # A hash table with linear probing, which is at most half full. It holds points and half of their hashes,
    # so that coordinates are hardly ever compared in vain.
    mask = table.size - 1
    low = np.uint64(0xFFFFFFFF)
    columns = coordinates.shape[1]
    count = 0
    for v in range(coordinates.shape[0]):
        mixed = np.uint64(0)
        finite = True
        for axis in range(columns):
            word = bits[v, axis]
            if word == np.uint64(0x8000000000000000):  # -0.0 is 0.0
                word = np.uint64(0)
            mixed = (mixed ^ word) * np.uint64(0x9E3779B97F4A7C15)
            mixed ^= mixed >> np.uint64(32)
            finite = finite and coordinates[v, axis] == coordinates[v, axis]
        mixed *= np.uint64(0xBF58476D1CE4E5B9)
        entry = (mixed << np.uint64(32)) | np.uint64(v + 1)
        slot = np.int64(mixed >> shift)
        place[v] = count
        found = False
        while finite and table[slot] != 0 and not found:  # NaN is in no place
            if (table[slot] ^ entry) <= low:
                w = np.int64(table[slot] & low) - 1
                found = True
                for axis in range(columns):
                    found = found and coordinates[v, axis] == coordinates[w, axis]
                if found:
                    place[v] = place[w]
            slot = (slot + 1) & mask
        if not found:
            if finite:
                table[slot] = entry
            first[count] = v
            count += 1
    return count


def distinct_places(coordinates: npt.NDArray[np.float64]) -> tuple[Int64, Int64]:
    """Find the places where points are, numbered in the order of the points.

    Two points are in one place if their coordinates are equal; -0.0 equals 0.0, and NaN equals nothing.

    Parameters
    ----------
    coordinates : (n, c) float64
        One row for each point.

    Returns
    -------
    place : (n,) int64
        Place of each point.
    first : (p,) int64
        First point of each place, rising.

    Examples
    --------
    >>> place, first = distinct_places(np.array([[0.0, 1.0], [2.0, 3.0], [-0.0, 1.0]]))
    >>> place.tolist(), first.tolist()
    ([0, 1, 0], [0, 1])
    """
    n = len(coordinates)
    coordinates = np.ascontiguousarray(coordinates)
    exponent = max(4, int(2 * n - 1).bit_length())
    table = np.zeros(1 << exponent, np.uint64)
    place, first = np.empty(n, np.int64), np.empty(n, np.int64)
    bits = coordinates.view(np.uint64)
    count = _number_places(coordinates, bits, table, np.uint64(64 - exponent), place, first)
    return place, first[:count]


class Joint(NamedTuple):
    """A surface whose points in one place have become one vertex where that leaves it a surface.

    Attributes
    ----------
    vertex : (n,) int64
        Vertex of each point.
    first : (p,) int64
        First point of each vertex, rising.
    offsets, connectivity : int32
        The faces over the vertices, as in :class:`~vtksmooth.kernels.mesh.mesh.Mesh`.
    faces : (m,) int64
        The number of each face before.
    apart : (p,) bool
        Vertices whose place has other vertices too: where bodies touch, and at non-manifold edges. These
        must not move, so that all points in one place stay there.
    """

    vertex: Int64
    first: Int64
    offsets: npt.NDArray[np.int32]
    connectivity: npt.NDArray[np.int32]
    faces: Int64
    apart: Bool


def join_points(mesh: Mesh, place: Int64, first: Int64) -> Joint:
    """Make one vertex of points in one place.

    Corners in one place that follow each other count once, and faces with fewer than three corners go. Of
    faces that cover each other, as the two sides of a sheet do, one stays; where that would leave a wall
    between two bodies with one side, both stay. Points in one place become one vertex if the faces at them
    hang together by edges of exactly two faces that agree on the orientation, or by points that they share.

    Parameters
    ----------
    mesh : Mesh
    place, first
        Of its points, see :func:`distinct_places`.

    Examples
    --------
    >>> corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    >>> soup = Mesh.from_faces([corners[i] for i in (0, 1, 2, 0, 2, 3)], [[0, 1, 2], [3, 4, 5]])
    >>> joint = join_points(soup, *distinct_places(soup.points))
    >>> joint.vertex.tolist(), joint.connectivity.tolist()
    ([0, 1, 2, 0, 2, 3], [0, 1, 2, 0, 2, 3])
    """
    merged, points, faces = _without_repeats(mesh, place, first)
    near = adjacency.build(merged)
    parent = np.arange(mesh.n_points, dtype=np.int32)
    _join_points(*adjacency.edges(near), merged.offsets, merged.connectivity, points, parent)
    # Points that only faces without area have, or that only the other side of a sheet has.
    used = np.zeros(mesh.n_points, np.bool_)
    used[points] = True
    known = np.full(len(first), mesh.n_points)
    np.minimum.at(known, place[used], parent[used])
    rest = ~used
    rest[known[place] == mesh.n_points] = False
    parent[rest] = known[place[rest]]
    unknown = ~used & ~rest
    parent[unknown] = first[place[unknown]]
    roots, vertex = np.unique(parent, return_inverse=True)
    apart = np.bincount(place[roots], minlength=len(first))[place[roots]] > 1
    connectivity = vertex[points].astype(np.int32)
    return Joint(vertex.astype(np.int64), roots.astype(np.int64), merged.offsets, connectivity, faces, apart)


@kernel
def _join_points(ends, faces, offsets, connectivity, points, parent):
    # Both faces of a regular edge have a point at each end: these are one.
    for e in range(ends.shape[0]):
        if faces[e, 0] < 0 or faces[e, 1] < 0:
            continue
        for side in range(2):
            v = -1
            for f in faces[e]:
                for c in range(offsets[f], offsets[f + 1]):
                    if connectivity[c] == ends[e, side]:
                        if v < 0:
                            v = points[c]
                        elif points[c] != v:
                            join(parent, v, points[c])
    for v in range(parent.size):
        parent[v] = find_root(parent, v)


def _without_repeats(mesh: Mesh, place: Int64, first: Int64) -> tuple[Mesh, Int64, Int64]:
    """Return the proper faces over the places, the point at each of their corners, and their numbers."""
    corners = place[mesh.connectivity]
    before = np.arange(-1, len(corners) - 1)
    full = mesh.face_sizes > 0
    before[mesh.offsets[:-1][full]] = mesh.offsets[1:][full] - 1
    face = np.repeat(np.arange(mesh.n_faces), mesh.face_sizes)
    new = corners[before] != corners
    proper = np.bincount(face[new], minlength=mesh.n_faces) >= 3
    new &= proper[face]
    faces, points = np.flatnonzero(proper), mesh.connectivity[new].astype(np.int64)
    sizes = np.bincount(face[new], minlength=mesh.n_faces)[faces]
    clean = _mesh_of(mesh.points[first], sizes, corners[new])
    double = _covering(clean, np.bincount(place, minlength=len(first)) > 1)
    if double.any():
        kinds = adjacency.build(_selected(clean, ~double)).kinds
        doubled = _selected(clean, double)
        part = components(doubled)
        torn = np.zeros(clean.n_points, np.bool_)
        torn[part[doubled.connectivity[kinds[doubled.connectivity] == adjacency.NON_MANIFOLD]]] = True
        double[double] = ~torn[part[doubled.connectivity[doubled.offsets[:-1]]]]
        points = points[np.repeat(~double, sizes)]
        clean, faces = _selected(clean, ~double), faces[~double]
    return clean, points, faces


def _covering(mesh: Mesh, shared: Bool) -> Bool:
    """Return the faces that have the corners of one before them, in the same or the opposite direction."""
    double = np.zeros(mesh.n_faces, np.bool_)
    if not len(mesh.connectivity):
        return double
    candidates = np.logical_and.reduceat(shared[mesh.connectivity], mesh.offsets[:-1])
    for size in np.unique(mesh.face_sizes[candidates]):
        rows = np.flatnonzero(candidates & (mesh.face_sizes == size))
        corners = mesh.connectivity[mesh.offsets[rows][:, None] + np.arange(size)]
        # From the smallest corner on, in the direction of its smaller neighbour.
        smallest = corners.argmin(axis=1)[:, None]
        forth = np.take_along_axis(corners, (smallest + np.arange(size)) % size, axis=1)
        back = np.take_along_axis(corners, (smallest - np.arange(size)) % size, axis=1)
        forth = np.where((forth[:, 1] > forth[:, -1])[:, None], back, forth)
        _, first = distinct_places(forth.astype(np.float64))
        double[rows] = True
        double[rows[first]] = False
    return double


def _selected(mesh: Mesh, faces: Bool) -> Mesh:
    sizes = mesh.face_sizes
    return _mesh_of(mesh.points, sizes[faces], mesh.connectivity[np.repeat(faces, sizes)])


def _mesh_of(
    points: npt.NDArray[np.float64], sizes: npt.NDArray[np.integer], corners: npt.NDArray[np.integer]
) -> Mesh:
    return Mesh(points, np.concatenate(([0], np.cumsum(sizes))).astype(np.int32), corners.astype(np.int32))
