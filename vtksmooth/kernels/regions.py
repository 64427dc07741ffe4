"""Clean and noisy parts of a mesh, and the transition between them (paper B, section 4.2)."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from . import parallel
from .adjacency import one_rings, vertex_corners
from .compiled import kernel
from .mesh import Mesh

Float64 = npt.NDArray[np.float64]


@kernel
def _diffuse(starts, ends, ring_offsets, ring, fixed, before, after):  # type: ignore[no-untyped-def]
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


def blend_weights(mesh: Mesh, fixed: npt.ArrayLike, steps: int) -> Float64:
    """Return how far each vertex may take part in smoothing: 1 where free, falling to 0 in fixed parts.

    Free vertices have the weight 1, fixed ones 0; then in each of `steps` steps every fixed vertex takes
    the mean of its neighbours' weights, all at the same time. Free vertices keep 1. Source: paper B,
    section 4.2.

    Parameters
    ----------
    mesh : Mesh
    fixed : (n,) array_like
        Nonzero at fixed vertices.
    steps : int
        Rings of fixed vertices that take part: weights farther from a free vertex than this stay 0.

    Returns
    -------
    (n,) float64, from 0 to 1

    Examples
    --------
    >>> from vtksmooth.kernels.mesh import Mesh
    >>> strip = Mesh.from_faces([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]])
    >>> blend_weights(strip, [0, 1, 1, 1], 1).tolist()
    [1.0, 0.5, 0.0, 0.5]
    """
    held = np.ascontiguousarray(fixed) != 0
    rows, _, _, after, before = vertex_corners(mesh)
    ring_offsets, ring, _, _ = one_rings(rows, after, before)
    old, new = np.where(held, 0.0, 1.0), np.empty(mesh.n_points)
    for _ in range(steps):
        parallel.run(_diffuse, *parallel.ranges(mesh.n_points), ring_offsets, ring, held, old, new)
        old, new = new, old
    return old
