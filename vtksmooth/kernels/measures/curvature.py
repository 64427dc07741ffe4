"""Mean curvature of a mesh (Meyer et al. 2002), and what of it is noise."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ...jit import parallel
from ...jit.compiled import kernel
from ..mesh.adjacency import INTERIOR, Adjacency
from ..mesh.mesh import Mesh
from .aspect_ratio import ring_normals

Float64 = npt.NDArray[np.float64]


@kernel
def _mean_curvatures(starts, ends, points, near, curvature):
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            curvature[v] = 0.0
            if near.kinds[v] != 0:
                continue
            x = points[v, 0]
            y = points[v, 1]
            z = points[v, 2]
            area = 0.0
            sx = 0.0
            sy = 0.0
            sz = 0.0
            nx = 0.0
            ny = 0.0
            nz = 0.0
            for i in range(near.corner_offsets[v], near.corner_offsets[v + 1]):
                c = near.corners[i]
                last = near.offsets[near.corner_face[c] + 1]
                size = last - near.offsets[near.corner_face[c]]
                # The face as a fan of triangles (v, p, q) from v.
                for step in range(1, size - 1):
                    p = near.connectivity[c + step if c + step < last else c + step - size]
                    q = near.connectivity[c + step + 1 if c + step + 1 < last else c + step + 1 - size]
                    ax = points[p, 0] - x
                    ay = points[p, 1] - y
                    az = points[p, 2] - z
                    bx = points[q, 0] - x
                    by = points[q, 1] - y
                    bz = points[q, 2] - z
                    cx = points[q, 0] - points[p, 0]
                    cy = points[q, 1] - points[p, 1]
                    cz = points[q, 2] - points[p, 2]
                    tx = ay * bz - az * by
                    ty = az * bx - ax * bz
                    tz = ax * by - ay * bx
                    twice = np.sqrt(tx * tx + ty * ty + tz * tz)
                    if twice == 0.0:
                        continue
                    nx += tx
                    ny += ty
                    nz += tz
                    at_p = -(ax * cx + ay * cy + az * cz) / twice
                    at_q = (bx * cx + by * cy + bz * cz) / twice
                    sx += at_q * ax + at_p * bx
                    sy += at_q * ay + at_p * by
                    sz += at_q * az + at_p * bz
                    if ax * bx + ay * by + az * bz < 0.0:
                        area += 0.25 * twice
                    elif at_p < 0.0 or at_q < 0.0:
                        area += 0.125 * twice
                    else:
                        area += 0.125 * (
                            at_q * (ax * ax + ay * ay + az * az) + at_p * (bx * bx + by * by + bz * bz)
                        )
            if area > 0.0:
                # sum (cot + cot) (p_i - p_j) / (2 A) = 2 kappa n
                kappa = np.sqrt(sx * sx + sy * sy + sz * sz) / (4.0 * area)
                curvature[v] = kappa if sx * nx + sy * ny + sz * nz <= 0.0 else -kappa


def mean_curvatures(mesh: Mesh, near: Adjacency) -> Float64:
    """Return the mean curvature at every vertex, (n,), one over model units; positive where convex.

    M. Meyer et al., "Discrete Differential-Geometry Operators for Triangulated 2-Manifolds" (2002),
    equations (7) and (8), with mixed areas; faces with more corners as fans from the vertex in question.
    0 where there is none: at the boundary, at irregular vertices, and where all faces are degenerate.
    """
    curvature = np.empty(mesh.n_points)
    parallel.run(
        _mean_curvatures, *parallel.ranges(mesh.n_points), mesh.points, near, curvature,
        smallest_share=parallel.COSTLY,
    )  # fmt: skip
    return curvature


#: What a vertex may stand above its neighbours, as part of the noise's height, without being noise itself. A
#: vertex that stands still takes no volume from its neighbours, so a bound that holds more is felt by all.
_LEFT_OVER = 0.002


def radius_by_noise(mesh: Mesh, near: Adjacency, free: npt.NDArray[np.bool_]) -> float:
    """Return the radius of the sphere below whose curvature a vertex is as smooth as it needs to be.

    Noise is known by its height: sigma, the root mean square of how far the free vertices stand above
    the means of their one-rings (of a voxel surface: the stairs). On a sphere of radius r with edges of
    length h that height is h^2 / (2 r). The radius returned is the one where it is 0.2 % of the noise's,

        r = h^2 / (2 * 0.002 sigma),

    h the mean edge length: the noise is removed until 0.2 % of it are left, and what is flatter stands still.
    Infinite where there is no noise.

    Parameters
    ----------
    mesh : Mesh
    near : Adjacency
    free : (n,) bool
        The vertices whose noise counts; those at the boundary do not.
    """
    chosen = free & (near.kinds == INTERIOR)
    if not chosen.any():
        return np.inf
    row = np.repeat(chosen, np.diff(near.ring_offsets))
    spokes = mesh.points[near.ring[row]] - np.repeat(
        mesh.points[chosen], np.diff(near.ring_offsets)[chosen], axis=0
    )
    starts = np.concatenate(([0], np.cumsum(np.diff(near.ring_offsets)[chosen])[:-1]))
    means = np.add.reduceat(spokes, starts) / np.diff(near.ring_offsets)[chosen][:, None]
    normals = ring_normals(mesh)[chosen]
    length = np.linalg.norm(normals, axis=1)
    normals /= np.where(length > 0.0, length, 1.0)[:, None]
    height = float(np.sqrt(np.mean((means * normals).sum(axis=1) ** 2)))
    edge = float(np.linalg.norm(spokes, axis=1).mean())
    return edge * edge / (2.0 * _LEFT_OVER * height) if height > 0.0 else np.inf
