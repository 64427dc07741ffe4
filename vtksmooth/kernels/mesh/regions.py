"""Regions of a mesh: marked vertices grown, shrunk and softened, connected parts, and blending."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ...jit import parallel
from ...jit.compiled import kernel
from .adjacency import Adjacency, edges, one_rings, vertex_corners
from .mesh import Mesh
from .union_find import find_root, join

Bool = npt.NDArray[np.bool_]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]


class Rings(NamedTuple):
    """One-rings as compressed rows: the neighbours of v are ``ring[ring_offsets[v]:ring_offsets[v + 1]]``."""

    ring_offsets: Int32
    ring: Int32


def rings_of(mesh: Mesh) -> Rings:
    """Return the one-rings of all vertices."""
    ring_offsets, ring, _, _ = one_rings(mesh, *vertex_corners(mesh))
    return Rings(ring_offsets, ring)


@kernel
def _reach(ring_offsets, ring, steps, marked, queue):
    # Each vertex is in the queue once, so any number of steps takes no longer than one look at all rings.
    end = 0
    for v in range(marked.size):
        if marked[v]:
            queue[end] = v
            end += 1
    begin = 0
    while steps > 0 and begin < end:
        steps -= 1
        last = end
        while begin < last:
            v = queue[begin]
            begin += 1
            for r in range(ring_offsets[v], ring_offsets[v + 1]):
                w = ring[r]
                if not marked[w]:
                    marked[w] = True
                    queue[end] = w
                    end += 1


def grown(rings: Rings, marked: npt.ArrayLike, steps: int) -> Bool:
    """Return the vertices that are at most `steps` edges from a marked one.

    Parameters
    ----------
    rings : Rings
    marked : (n,) array_like
        Nonzero at marked vertices.
    steps : int

    Returns
    -------
    (n,) bool

    Examples
    --------
    >>> from vtksmooth.kernels.mesh.mesh import Mesh
    >>> strip = Mesh.from_faces([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]])
    >>> grown(rings_of(strip), [1, 0, 0, 0], 1).tolist()
    [True, True, False, True]
    """
    reached: Bool = np.ascontiguousarray(marked) != 0
    _reach(*rings, min(steps, len(reached)), reached, np.empty(len(reached), np.int32))
    return reached


def shrunk(rings: Rings, marked: npt.ArrayLike, steps: int) -> Bool:
    """Return the marked vertices that are more than `steps` edges from every vertex that is not marked."""
    left = np.asarray(~grown(rings, np.asarray(marked) == 0, steps))
    return left


@kernel
def _carry_on(starts, ends, near, before, after):
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            after[v] = before[v]
            for r in range(near.ring_offsets[v], near.ring_offsets[v + 1]):
                after[v] = max(after[v], before[near.ring[r]])


def largest_around(near: Adjacency, values: Float64, rings: int) -> Float64:
    """Return for each vertex the largest of the values, (n,), within so many rings of it."""
    for _ in range(rings):
        before, values = values, np.empty_like(values)
        parallel.run(_carry_on, *parallel.ranges(len(values)), near, before, values)
    return values


@kernel
def _diffuse(starts, ends, ring_offsets, ring, fixed, before, after):
    changed = False
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            first = ring_offsets[v]
            last = ring_offsets[v + 1]
            after[v] = before[v]
            if not fixed[v] or first == last:
                continue
            total = 0.0
            for r in range(first, last):
                total += before[ring[r]]
            after[v] = total / (last - first)
            changed = changed or after[v] != before[v]
    return changed


def blend_weights(
    mesh: Mesh, fixed: npt.ArrayLike, steps: int, tell: Callable[[float], None] | None = None
) -> Float64:
    """Return how far each vertex may take part in smoothing: 1 where free, falling to 0 in fixed parts.

    Free vertices have the weight 1, fixed ones 0; then in each of `steps` steps every fixed vertex takes
    the mean of its neighbours' weights, all at the same time. Free vertices keep 1. Source: the
    installation-space paper, section 4.2.

    Parameters
    ----------
    mesh : Mesh
    fixed : (n,) array_like
        Nonzero at fixed vertices.
    steps : int
        Rings of fixed vertices that take part: weights farther from a free vertex than this stay 0. It ends
        earlier where weights no longer change.
    tell : callable, optional
        Called with the part of the steps that is done; it may raise to cancel.

    Returns
    -------
    (n,) float64, from 0 to 1

    Examples
    --------
    >>> from vtksmooth.kernels.mesh.mesh import Mesh
    >>> strip = Mesh.from_faces([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]])
    >>> blend_weights(strip, [0, 1, 1, 1], 1).tolist()
    [1.0, 0.5, 0.0, 0.5]
    """
    held = np.ascontiguousarray(fixed) != 0
    rings = rings_of(mesh)
    old, new = np.where(held, 0.0, 1.0), np.empty(mesh.n_points)
    for step in range(steps):
        if tell is not None:
            tell(step / steps)
        # Weights only rise, rounded as they are, so they come to rest.
        if not any(parallel.run(_diffuse, *parallel.ranges(mesh.n_points), *rings, held, old, new)):
            break
        old, new = new, old
    return old


@kernel
def _label_points(offsets, connectivity, parent):
    for f in range(offsets.size - 1):
        for c in range(offsets[f] + 1, offsets[f + 1]):
            join(parent, connectivity[c - 1], connectivity[c])
    for v in range(parent.size):
        parent[v] = find_root(parent, v)


def components(mesh: Mesh) -> Int32:
    """Return for each point the number of the first point of its connected component, (n,) int32.

    Two points are connected that are corners of one face. A point that no face uses is a component.

    Examples
    --------
    >>> from vtksmooth.kernels.mesh.mesh import Mesh
    >>> two = Mesh.from_faces([[x, y, 0] for x in range(3) for y in range(2)], [[0, 1, 2], [5, 4, 3]])
    >>> components(two).tolist()
    [0, 0, 0, 3, 3, 3]
    """
    parent = np.arange(mesh.n_points, dtype=np.int32)
    _label_points(mesh.offsets, mesh.connectivity, parent)
    return parent


@kernel
def _label_faces(faces, crossed, parent):
    for e in range(faces.shape[0]):
        if crossed[e] and faces[e, 0] >= 0 and faces[e, 1] >= 0:
            join(parent, faces[e, 0], faces[e, 1])
    for f in range(parent.size):
        parent[f] = find_root(parent, f)


def patches(near: Adjacency, lines: npt.NDArray[np.integer]) -> Int32:
    """Return for each face the number of the first face of its patch, (m,) int32.

    Patches are what lines cut a surface into: faces with a common edge belong to one patch, unless the
    edge is one of `lines`, has more than two faces, or faces that disagree on the orientation.

    Parameters
    ----------
    near : Adjacency
    lines : (r, 2) int array
        Edges, as pairs of points.
    """
    ends, faces = edges(near)
    on_lines = np.zeros(len(near.kinds), np.bool_)
    on_lines[lines] = True
    # Few edges have both ends on lines; only those are looked up.
    candidates = np.flatnonzero(on_lines[ends].all(axis=1))
    crossed = np.ones(len(ends), np.bool_)
    crossed[candidates] = ~np.isin(
        edge_numbers(ends[candidates], len(near.kinds)), edge_numbers(lines, len(near.kinds))
    )
    parent = np.arange(len(near.offsets) - 1, dtype=np.int32)
    _label_faces(faces, crossed, parent)
    return parent


def edge_numbers(pairs: npt.NDArray[np.integer], n: int) -> npt.NDArray[np.int64]:
    """Return one number for each edge between two of n points, whichever of its ends is named first."""
    wide = pairs.astype(np.int64)
    return np.asarray(wide.min(axis=1) * n + wide.max(axis=1))


@kernel
def _marked_faces(starts, ends, offsets, connectivity, marked, found):
    for part in range(starts.size):
        for f in range(starts[part], ends[part]):
            every = offsets[f + 1] > offsets[f]
            for c in range(offsets[f], offsets[f + 1]):
                every = every and marked[connectivity[c]] != 0
            found[f] = every


def marked_faces(mesh: Mesh, marked: npt.ArrayLike) -> npt.NDArray[np.int64]:
    """Return the faces whose corners are all marked, in rising order."""
    found = np.empty(mesh.n_faces, np.bool_)
    parallel.run(
        _marked_faces, *parallel.ranges(mesh.n_faces), mesh.offsets, mesh.connectivity,
        np.ascontiguousarray(marked) != 0, found,
    )  # fmt: skip
    return np.flatnonzero(found)
