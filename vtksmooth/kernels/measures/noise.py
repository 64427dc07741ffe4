"""How far noise takes points off the surface: what a smooth patch through the points around leaves."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ...jit import parallel
from ...jit.compiled import device, kernel
from ..mesh.adjacency import Adjacency
from ..mesh.mesh import Mesh
from ..mesh.regions import largest_around
from .aspect_ratio import ring_normals

Float64 = npt.NDArray[np.float64]

#: Vertices about a vertex that its noise level is found from.
_ABOUT = 150

#: Part of these whose patches leave less: features do not count.
_QUANTILE = 0.4

#: Part of the level that half of the variance exceeds below which there is no noise.
_QUIET = 0.3

#: Rings by which the level is carried on: at the rim of a noisy part too few of the patches have noise.
_RIM = 2

#: Coefficients of a patch, and most vertices that one is fitted to.
_UNKNOWNS, _MOST = 6, 200


@device
def _two_ring(near, v, found):
    # v and its two-ring; returns how many.
    found[0] = v
    first = 0
    last = 1
    for _ in range(2):
        end = last
        for i in range(first, end):
            for r in range(near.ring_offsets[found[i]], near.ring_offsets[found[i] + 1]):
                w = near.ring[r]
                new = last < found.size
                for j in range(last):
                    new = new and found[j] != w
                if new:
                    found[last] = w
                    last += 1
        first = end
    return last


@kernel
def _fit(starts, ends, vertices, points, near, normals, variance):
    found = np.empty(_MOST, np.int32)
    terms = np.empty(_UNKNOWNS)
    matrix = np.empty((_UNKNOWNS, _UNKNOWNS + 1))
    axes = np.empty((3, 3))
    for part in range(starts.size):
        for at in range(starts[part], ends[part]):
            v = vertices[at]
            variance[at] = -1.0
            size = _two_ring(near, v, found)
            if size <= _UNKNOWNS:
                continue
            # The frame: mean normal, and two axes across it.
            axes[2] = 0.0
            spread = 0.0
            for i in range(size):
                for axis in range(3):
                    axes[2, axis] += normals[found[i], axis]
                    spread += (points[found[i], axis] - points[v, axis]) ** 2
            length = np.sqrt(axes[2, 0] ** 2 + axes[2, 1] ** 2 + axes[2, 2] ** 2)
            spread = np.sqrt(spread / size)
            if not length > 0.0 or not spread > 0.0:
                continue
            axes[2] /= length
            least = 0
            for axis in range(1, 3):
                if abs(axes[2, axis]) < abs(axes[2, least]):
                    least = axis
            axes[0] = -axes[2, least] * axes[2]
            axes[0, least] += 1.0
            axes[0] /= np.sqrt(axes[0, 0] ** 2 + axes[0, 1] ** 2 + axes[0, 2] ** 2)
            for axis in range(3):
                p = (axis + 1) % 3
                q = (axis + 2) % 3
                axes[1, axis] = axes[2, p] * axes[0, q] - axes[2, q] * axes[0, p]
            # Least squares: the heights are orthogonalised against the terms in the normal equations.
            matrix[:] = 0.0
            total = 0.0
            for i in range(size):
                x = 0.0
                y = 0.0
                z = 0.0
                for axis in range(3):
                    off = (points[found[i], axis] - points[v, axis]) / spread
                    x += off * axes[0, axis]
                    y += off * axes[1, axis]
                    z += off * axes[2, axis]
                terms[0] = 1.0
                terms[1] = x
                terms[2] = y
                terms[3] = x * x
                terms[4] = x * y
                terms[5] = y * y
                total += z * z
                for row in range(_UNKNOWNS):
                    for column in range(row, _UNKNOWNS):
                        matrix[row, column] += terms[row] * terms[column]
                    matrix[row, _UNKNOWNS] += terms[row] * z
            # Elimination without a choice of pivots: the matrix is positive definite, or the points do not
            # determine a patch.
            determined = True
            for k in range(_UNKNOWNS):
                pivot = matrix[k, k]
                if not pivot > 1e-9 * size:
                    determined = False
                    break
                total -= matrix[k, _UNKNOWNS] ** 2 / pivot
                for row in range(k + 1, _UNKNOWNS):
                    factor = matrix[k, row] / pivot
                    for column in range(row, _UNKNOWNS + 1):
                        matrix[row, column] -= factor * matrix[k, column]
            if determined:
                variance[at] = max(total, 0.0) / (size - _UNKNOWNS) * spread * spread


@kernel
def _find_levels(near, variance, level):
    # The quantile of the variances about a vertex, ring by ring until there are enough; of all that have none
    # yet, and for their one-rings: it hardly changes from one to the next.
    seen = np.full(near.kinds.size, -1, np.int32)
    queue = np.empty(near.kinds.size, np.int32)
    about = np.empty(_ABOUT)
    level[:] = -1.0
    for v in range(near.kinds.size):
        if level[v] >= 0.0:
            continue
        queue[0] = v
        seen[v] = v
        first = 0
        last = 1
        count = 0
        while first < last and count < _ABOUT:
            w = queue[first]
            first += 1
            if variance[w] >= 0.0:
                about[count] = variance[w]
                count += 1
            for r in range(near.ring_offsets[w], near.ring_offsets[w + 1]):
                if seen[near.ring[r]] != v:
                    seen[near.ring[r]] = v
                    queue[last] = near.ring[r]
                    last += 1
        found = 0.0
        if count > 0:
            at = int(_QUANTILE * (count - 1))
            found = np.sqrt(np.partition(about[:count], at)[at])
        level[v] = found
        for r in range(near.ring_offsets[v], near.ring_offsets[v + 1]):
            if level[near.ring[r]] < 0.0:
                level[near.ring[r]] = found


def noise_levels(mesh: Mesh, near: Adjacency) -> tuple[Float64, float]:
    """Return the standard deviation of the noise across the surface, model units.

    At each vertex off the boundary a quadratic patch is fitted to the two-ring, in the frame of its mean
    normal. What the patch leaves is noise, or shape that is no such patch: of the variances the 40 % quantile
    counts. For Gaussian noise along the normals this finds 0.9 to 1.0 of the truth.

    Returns
    -------
    levels : (n,) float64
        About each vertex. The level of a noisy part counts up to its rim.
    level : float
        Of all of the mesh that has noise.
    """
    vertices = np.flatnonzero(near.kinds == 0)
    variance, level = np.full(len(near.kinds), -1.0), np.zeros(len(near.kinds))
    measured = np.empty(len(vertices))
    parallel.run(
        _fit, *parallel.ranges(len(vertices)), vertices, mesh.points, near, ring_normals(mesh), measured,
        smallest_share=parallel.COSTLY,
    )  # fmt: skip
    variance[vertices] = measured
    _find_levels(near, variance, level)
    level = largest_around(near, level, _RIM)
    # Half of the variance is where there is more noise than this.
    ordered = np.sort(level)
    share = np.cumsum(ordered**2)
    middle = ordered[np.searchsorted(share, 0.5 * share[-1])] if len(ordered) else 0.0
    noisy = variance[(level > _QUIET * middle) & (variance >= 0.0)]
    return level, float(np.sqrt(np.quantile(noisy, _QUANTILE))) if len(noisy) else 0.0
