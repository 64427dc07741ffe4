"""Which face a ray meets first."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ...jit import parallel
from ...jit.compiled import kernel
from ..mesh.mesh import Mesh


@kernel
def _first_hit(starts, ends, points, offsets, connectivity, origin, direction):
    # Polygons are taken as fans of triangles.
    best = np.inf
    face = -1
    dx, dy, dz = direction
    for part in range(starts.size):
        for f in range(starts[part], ends[part]):
            a = connectivity[offsets[f]]
            px = origin[0] - points[a, 0]
            py = origin[1] - points[a, 1]
            pz = origin[2] - points[a, 2]
            for j in range(offsets[f] + 1, offsets[f + 1] - 1):
                b = connectivity[j]
                c = connectivity[j + 1]
                ux = points[b, 0] - points[a, 0]
                uy = points[b, 1] - points[a, 1]
                uz = points[b, 2] - points[a, 2]
                vx = points[c, 0] - points[a, 0]
                vy = points[c, 1] - points[a, 1]
                vz = points[c, 2] - points[a, 2]
                # Moeller and Trumbore: origin + t direction = a + r u + s v, by Cramer's rule.
                hx = dy * vz - dz * vy
                hy = dz * vx - dx * vz
                hz = dx * vy - dy * vx
                determinant = ux * hx + uy * hy + uz * hz
                if determinant == 0.0:
                    continue
                r = (px * hx + py * hy + pz * hz) / determinant
                if not 0.0 <= r <= 1.0:
                    continue
                qx = py * uz - pz * uy
                qy = pz * ux - px * uz
                qz = px * uy - py * ux
                s = (dx * qx + dy * qy + dz * qz) / determinant
                if not (s >= 0.0 and r + s <= 1.0):
                    continue
                t = (vx * qx + vy * qy + vz * qz) / determinant
                if 0.0 <= t < best:
                    best = t
                    face = f
    return face, best


def first_hit(mesh: Mesh, origin: npt.ArrayLike, direction: npt.ArrayLike) -> tuple[int, float]:
    """Return the first face that a ray meets, and where; every face is looked at.

    Source: T. Moeller, B. Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", 1997.

    Parameters
    ----------
    mesh : Mesh
        Polygons are taken as fans of triangles.
    origin, direction : (3,) array_like
        The direction may have any length.

    Returns
    -------
    face : int
        -1 when the ray meets none. Of faces met at the same place, the first.
    t : float
        The ray meets it at ``origin + t * direction``; inf when it meets none.

    Examples
    --------
    >>> square = Mesh.from_faces([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]])
    >>> first_hit(square, [0.5, 0.25, 3.0], [0.0, 0.0, -2.0])
    (0, 1.5)
    """
    ray = [np.ascontiguousarray(vector, dtype=np.float64) for vector in (origin, direction)]
    parts = parallel.run(
        _first_hit, *parallel.ranges(mesh.n_faces), mesh.points, mesh.offsets, mesh.connectivity, *ray
    )
    face, t = min(parts, key=lambda part: (part[1], part[0]), default=(-1, np.inf))
    return int(face), float(t)
