"""Winding numbers: how often a closed surface goes round a point, whatever its triangles look like."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Float64 = npt.NDArray[np.float64]


def winding_number(points: Float64, triangles: npt.NDArray[np.integer], query: npt.ArrayLike) -> float:
    """Return 1 for a point inside a closed surface with normals outwards, 0 for one outside.

    The sum of the solid angles of all triangles over 4 pi (A. van Oosterom, J. Strackee, "The Solid Angle of
    a Plane Triangle", 1983, equation 8). Looks at every triangle: for few points, where all else is in doubt.

    Parameters
    ----------
    points : (n, 3) float64
    triangles : (t, 3) integers
    query : (3,) float64

    Examples
    --------
    >>> import numpy as np
    >>> corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    >>> faces = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    >>> [round(winding_number(corners, faces, query), 9) + 0.0 for query in ([0.1, 0.2, 0.3], [1, 1, 1])]
    [1.0, 0.0]
    """
    a, b, c = (points[triangles[:, corner]] - np.asarray(query, dtype=np.float64) for corner in range(3))
    la, lb, lc = (np.linalg.norm(spoke, axis=1) for spoke in (a, b, c))
    box = np.einsum("ij,ij->i", a, np.cross(b, c))
    rest = la * lb * lc
    for (p, q), length in (((a, b), lc), ((b, c), la), ((c, a), lb)):
        rest += np.einsum("ij,ij->i", p, q) * length
    return float(np.arctan2(box, rest).sum() / (2.0 * np.pi))
