"""Trapezium Drawing as a reader of the paper could also have meant it, to see what a reading changes.

An implementation of its own, one vertex after another, shared with nothing in the product: it serves as a
cross-check as well.
"""

from __future__ import annotations

import numba
import numpy as np
import numpy.typing as npt

from vtksmooth.kernels.measures import aspect_ratio
from vtksmooth.kernels.mesh import adjacency
from vtksmooth.kernels.mesh.mesh import Mesh

Float64 = npt.NDArray[np.float64]

NO_GATE, WORST, MEAN, NONE_WORSE = range(4)


@numba.njit
def _k(points, corners, v, place, direction, two_triangles):
    # k of one face with vertex v at `place`, by the formulas of sections 2.1 and 3.1.
    n = len(corners)
    at = np.empty((n, 3))
    for i in range(n):
        at[i] = place if corners[i] == v else points[corners[i]]
    squares = 0.0
    longest = 0.0
    smallest = np.inf
    for i in range(n):
        side = at[i] - at[i - 1]
        squares += (side * side).sum()
        for j in range(i):
            longest = max(longest, np.sqrt(((at[i] - at[j]) ** 2).sum()))
        # Corners 1 and 3 are the two triangles on either side of the diagonal 0-2.
        if n == 4 and two_triangles and i % 2 == 0:
            continue
        normal = np.cross(side, at[(i + 1) % n] - at[i])
        area = 0.5 * np.sqrt((normal * normal).sum())
        smallest = min(smallest, area if (normal * direction).sum() >= 0.0 else -area)
    if squares == 0.0:
        return 0.0
    if n == 3:
        return 4.0 * np.sqrt(3.0) * smallest / squares
    return 4.0 * np.sqrt(2.0) * smallest / (np.sqrt(squares) * longest)


@numba.njit
def _target(points, v, star):
    # Section 2: the mean of the p0_i.
    p = points[v]
    total = np.zeros(3)
    for i in range(len(star)):
        a = points[star[i]] - p
        partner = a
        smallest = 2.0
        for j in range(len(star)):
            b = points[star[j]] - p
            lengths = np.sqrt((a * a).sum() * (b * b).sum())
            if j != i and lengths > 0.0 and (a * b).sum() / lengths < smallest - 1e-12:
                smallest = (a * b).sum() / lengths
                partner = b
        w = a - partner
        if (w * w).sum() > 0.0:
            total += 0.5 * ((a * a).sum() - (partner * partner).sum()) / (w * w).sum() * w
    return p + total / len(star)


@numba.njit
def _smooth(
    points, offsets, connectivity, star_offsets, star, corner_offsets, faces_round, directions,
    held, order, gate, ring_normal, at_once, two_triangles, passes,
):  # fmt: skip
    for _ in range(passes):
        result = points.copy() if at_once else points
        for v in order:
            near = star[star_offsets[v] : star_offsets[v + 1]]
            if held[v] or len(near) < 2:
                continue
            target = _target(points, v, near)
            faces = faces_round[corner_offsets[v] : corner_offsets[v + 1]]
            normal = np.zeros(3)
            for f in faces:
                c = connectivity[offsets[f] : offsets[f + 1]]
                for i in range(1, len(c) - 1):
                    normal += np.cross(points[c[i]] - points[c[0]], points[c[i + 1]] - points[c[0]])
            worst_old, worst_new, gain, worse = np.inf, np.inf, 0.0, False
            for f in faces:
                c = connectivity[offsets[f] : offsets[f + 1]]
                direction = normal if ring_normal else directions[f]
                old = _k(points, c, v, points[v], direction, two_triangles)
                new = _k(points, c, v, target, direction, two_triangles)
                worst_old, worst_new = min(worst_old, old), min(worst_new, new)
                gain += new - old
                worse = worse or new < old
            if (
                gate == NO_GATE
                or (gate == WORST and worst_new > worst_old)
                or (gate == MEAN and gain > 0.0)
                or (gate == NONE_WORSE and not worse)
            ):
                result[v] = target
        points = result
    return points


def smooth(
    mesh: Mesh,
    passes: int,
    gate: int = WORST,
    order: str = "file",
    ring_normal: bool = False,
    at_once: bool = False,
    two_triangles: bool = False,
    sides_only: bool = False,
) -> Float64:
    """Return the points after `passes`; boundaries stay.

    Parameters
    ----------
    gate : {NO_GATE, WORST, MEAN, NONE_WORSE}
        What must improve: nothing; the smallest k of the ring (the paper); the mean k; no k may fall.
    order : {"file", "reversed", "random"}
    ring_normal : bool
        Sign areas against the current normal of the vertex instead of frozen directions of faces.
    at_once : bool
        All vertices move together, judged while their neighbours are where they were.
    two_triangles : bool
        k of quadrilaterals by the two triangles of one diagonal instead of all four.
    sides_only : bool
        Neighbours in quadrilaterals are those along sides only.
    """
    near = adjacency.build(mesh)
    numbers = np.arange(mesh.n_points)
    orders = {
        "file": numbers,
        "reversed": numbers[::-1].copy(),
        "random": np.random.default_rng(0).permutation(numbers),
    }
    directions = aspect_ratio.reference_directions(mesh).astype(float)
    offsets, star = (near.ring_offsets, near.ring) if sides_only else (near.star_offsets, near.star)
    return _smooth(
        mesh.points.copy(), mesh.offsets, mesh.connectivity, offsets, star,
        near.corner_offsets, near.corner_face[near.corners], directions,
        near.kinds != adjacency.INTERIOR, orders[order], gate, ring_normal, at_once, two_triangles, passes,
    )  # fmt: skip


def aspect_ratios(mesh: Mesh, directions: Float64, two_triangles: bool) -> Float64:
    """Return k of every face, (m,)."""
    return np.array([
        _k(mesh.points, mesh.connectivity[a:b], -1, np.zeros(3), direction, two_triangles)
        for a, b, direction in zip(mesh.offsets[:-1], mesh.offsets[1:], directions, strict=True)
    ])  # fmt: skip
