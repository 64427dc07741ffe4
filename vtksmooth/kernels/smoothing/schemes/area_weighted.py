"""Area-weighted centroid: large faces pull harder, so that areas become even."""

from __future__ import annotations

import numpy as np

from ....jit import parallel
from ....jit.compiled import device, kernel
from ...measures.aspect_ratio import area_vector
from ..run_state import State
from . import Float64, Int64, Scheme


@device
def centre(points, offsets, connectivity, f):
    """Mean of the corners of face f."""
    x = 0.0
    y = 0.0
    z = 0.0
    for c in range(offsets[f], offsets[f + 1]):
        x += points[connectivity[c], 0]
        y += points[connectivity[c], 1]
        z += points[connectivity[c], 2]
    share = 1.0 / (offsets[f + 1] - offsets[f])
    return x * share, y * share, z * share


@kernel
def _propose(starts, ends, points, near, pinned, factor, proposed):
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            x = points[v, 0]
            y = points[v, 1]
            z = points[v, 2]
            proposed[v, 0] = x
            proposed[v, 1] = y
            proposed[v, 2] = z
            if pinned[v]:
                continue
            sx = 0.0
            sy = 0.0
            sz = 0.0
            total = 0.0
            for i in range(near.corner_offsets[v], near.corner_offsets[v + 1]):
                f = near.corner_face[near.corners[i]]
                nx, ny, nz = area_vector(points, near.offsets, near.connectivity, f)
                weight = np.sqrt(nx * nx + ny * ny + nz * nz)
                cx, cy, cz = centre(points, near.offsets, near.connectivity, f)
                total += weight
                sx += weight * (cx - x)
                sy += weight * (cy - y)
                sz += weight * (cz - z)
            if total > 0.0:
                proposed[v, 0] = x + factor * (sx / total)
                proposed[v, 1] = y + factor * (sy / total)
                proposed[v, 2] = z + factor * (sz / total)


class AreaWeighted(Scheme):
    """Mean of the centroids of the faces round a vertex, weighted by their areas.

    The centroid of a face is the mean of its corners. Faces without area have no say.

    Parameters
    ----------
    relaxation : float
        Part of the way to the mean, (0, 1].
    """

    def __init__(self, relaxation: float = 0.5) -> None:
        self.relaxation = relaxation

    def propose(self, state: State, turn: int, starts: Int64, ends: Int64, proposed: Float64) -> None:
        parallel.run(
            _propose, starts, ends, state.points, state.near, state.pinned, self.relaxation, proposed,
            smallest_share=parallel.COSTLY,
        )  # fmt: skip
