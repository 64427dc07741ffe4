"""Equilateral: each face asks for the apex that would make its corner a regular polygon's."""

from __future__ import annotations

import numpy as np

from ....jit import parallel
from ....jit.compiled import kernel
from ..run_state import State
from . import Float64, Int64, Scheme

#: Square of height over opposite side below which a corner counts as flat: which side the vertex stands on
#: would be anybody's guess.
FLAT = 1e-20


@kernel
def _propose(starts, ends, points, near, reference, pinned, factor, proposed):
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
            count = 0
            for i in range(near.corner_offsets[v], near.corner_offsets[v + 1]):
                c = near.corners[i]
                f = near.corner_face[c]
                first = near.offsets[f]
                size = near.offsets[f + 1] - first
                if size < 3:
                    continue
                p = near.connectivity[first + (c - first + 1) % size]
                q = near.connectivity[first + (c - first + size - 1) % size]
                ex = points[q, 0] - points[p, 0]
                ey = points[q, 1] - points[p, 1]
                ez = points[q, 2] - points[p, 2]
                square = ex * ex + ey * ey + ez * ez
                if square == 0.0:
                    continue
                # The middle m of e, seen from v, and the part h of v - m that is perpendicular to e.
                mx = 0.5 * (points[p, 0] + points[q, 0]) - x
                my = 0.5 * (points[p, 1] + points[q, 1]) - y
                mz = 0.5 * (points[p, 2] + points[q, 2]) - z
                along = (mx * ex + my * ey + mz * ez) / square
                hx = along * ex - mx
                hy = along * ey - my
                hz = along * ez - mz
                # Inwards, seen along the face's reference direction.
                rx = reference[f, 1] * ez - reference[f, 2] * ey
                ry = reference[f, 2] * ex - reference[f, 0] * ez
                rz = reference[f, 0] * ey - reference[f, 1] * ex
                height = hx * hx + hy * hy + hz * hz
                if height <= FLAT * square:
                    hx = rx
                    hy = ry
                    hz = rz
                    height = hx * hx + hy * hy + hz * hz
                elif hx * rx + hy * ry + hz * rz < 0.0:
                    hx = -hx
                    hy = -hy
                    hz = -hz
                if height == 0.0:
                    continue
                part_of = 0.5 * np.tan(np.pi / size) * np.sqrt(square / height)
                sx += mx + part_of * hx
                sy += my + part_of * hy
                sz += mz + part_of * hz
                count += 1
            if count > 0:
                proposed[v, 0] = x + factor * (sx / count)
                proposed[v, 1] = y + factor * (sy / count)
                proposed[v, 2] = z + factor * (sz / count)


class Equilateral(Scheme):
    """Mean over the faces of ``m + (h / |h|) tan(pi / n) |e| / 2``, n the corners of the face.

    e joins the vertex' two neighbours in the face, m is its middle, h the part of ``v - m`` perpendicular
    to e. In a triangle e is the opposite side and the height is sqrt(3)/2 of it; in a quadrilateral e is
    the diagonal and the corner becomes a square's. In an inverted face, or where v lies on e, "the
    vertex' side" is the one that the face's reference direction says. Like most centroids it has a part
    off the surface; :class:`~vtksmooth.kernels.smoothing.constraints.tangent_plane.TangentPlane`
    takes that away.

    Parameters
    ----------
    relaxation : float
        Part of the way to the mean, (0, 1].
    """

    def __init__(self, relaxation: float = 0.5) -> None:
        self.relaxation = relaxation

    def propose(self, state: State, turn: int, starts: Int64, ends: Int64, proposed: Float64) -> None:
        parallel.run(
            _propose, starts, ends,
            state.points, state.near, state.reference, state.pinned, self.relaxation, proposed,
            smallest_share=parallel.COSTLY,
        )  # fmt: skip
