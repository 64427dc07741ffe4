"""Angle-based smoothing, plain (Zhou & Shimada 2000) and weighted (Surazhsky & Gotsman 2002)."""

from __future__ import annotations

import numpy as np

from ....jit import parallel
from ....jit.compiled import device, kernel
from ...measures.aspect_ratio import ring_normal
from ..run_state import State
from . import Float64, Int64, Scheme


@device
def _measure_angles(points, near, v, nx, ny, nz, left, right):
    # The signed angles at the neighbours of v, on the side of the face where each follows v and where it
    # precedes v; in the tangent plane with the normal n.
    first = near.ring_offsets[v]
    for i in range(near.corner_offsets[v], near.corner_offsets[v + 1]):
        c = near.corners[i]
        f = near.corner_face[c]
        a = near.offsets[f]
        size = near.offsets[f + 1] - a
        for side in range(2):
            # Left: p follows v, and the face goes on to q. Right: p precedes v, and q precedes p.
            p = near.connectivity[a + (c - a + (1 if side == 0 else size - 1)) % size]
            q = near.connectivity[a + (c - a + (2 if side == 0 else size - 2)) % size]
            sx = points[v, 0] - points[p, 0]
            sy = points[v, 1] - points[p, 1]
            sz = points[v, 2] - points[p, 2]
            tx = points[q, 0] - points[p, 0]
            ty = points[q, 1] - points[p, 1]
            tz = points[q, 2] - points[p, 2]
            sn = sx * nx + sy * ny + sz * nz
            tn = tx * nx + ty * ny + tz * nz
            # Both projected to the tangent plane; the angle turns about the normal.
            dot = sx * tx + sy * ty + sz * tz - sn * tn
            turn = nx * (sy * tz - sz * ty) + ny * (sz * tx - sx * tz) + nz * (sx * ty - sy * tx)
            for r in range(near.ring_offsets[v + 1] - first):
                if near.ring[first + r] == p:
                    if side == 0:
                        left[r] = np.arctan2(-turn, dot)
                    else:
                        right[r] = np.arctan2(turn, dot)


@kernel
def _propose(starts, ends, points, near, pinned, weighted, proposed):
    widest = 0
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            widest = max(widest, near.ring_offsets[v + 1] - near.ring_offsets[v])
    # Signed angle at a neighbour, on the side of the face where it follows v and where it precedes v.
    left = np.empty(widest)
    right = np.empty(widest)
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
            nx, ny, nz = ring_normal(points, near, v)
            length = np.sqrt(nx * nx + ny * ny + nz * nz)
            if length == 0.0:
                continue
            nx /= length
            ny /= length
            nz /= length
            first = near.ring_offsets[v]
            valence = near.ring_offsets[v + 1] - first
            left[:valence] = np.nan
            right[:valence] = np.nan
            _measure_angles(points, near, v, nx, ny, nz, left, right)
            px = 0.0
            py = 0.0
            pz = 0.0
            total = 0.0
            for r in range(valence):
                if np.isnan(left[r]) or np.isnan(right[r]):
                    continue  # an edge with one face has no bisector
                w = near.ring[first + r]
                sx = x - points[w, 0]
                sy = y - points[w, 1]
                sz = z - points[w, 2]
                sn = sx * nx + sy * ny + sz * nz
                sx -= sn * nx
                sy -= sn * ny
                sz -= sn * nz
                # Rotate the spoke, about the normal, onto the bisector of the angle at the neighbour.
                turn = 0.5 * (right[r] - left[r])
                cosine = np.cos(turn)
                sine = np.sin(turn)
                weight = 1.0
                if weighted:
                    angle = left[r] + right[r]
                    weight = 1.0 / max(angle * angle, 1e-12)
                total += weight
                px += weight * ((cosine - 1.0) * sx + sine * (ny * sz - nz * sy))
                py += weight * ((cosine - 1.0) * sy + sine * (nz * sx - nx * sz))
                pz += weight * ((cosine - 1.0) * sz + sine * (nx * sy - ny * sx))
            if total > 0.0:
                proposed[v, 0] = x + px / total
                proposed[v, 1] = y + py / total
                proposed[v, 2] = z + pz / total


class AngleBased(Scheme):
    """Each spoke is rotated about its outer end onto the bisector of the angle there; the mean of that.

    On a surface all this happens in the tangent plane (normal to the area-weighted ring normal).

    Parameters
    ----------
    weighted : bool
        Weigh each neighbour with 1/angle^2, so that small angles count more.
    """

    def __init__(self, weighted: bool = False) -> None:
        self.weighted = weighted

    def propose(self, state: State, turn: int, starts: Int64, ends: Int64, proposed: Float64) -> None:
        parallel.run(
            _propose, starts, ends, state.points, state.near, state.pinned, self.weighted, proposed,
            smallest_share=parallel.COSTLY,
        )  # fmt: skip
