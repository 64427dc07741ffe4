"""Signed distances in compiled code: a tree of boxes, and angle-weighted pseudonormals for the sign.

VTK answers through one function call a batch, on one thread, and holds the interpreter lock. Sweeps ask
this tree; it is tested against VTK's answers, signs included.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ...jit import parallel
from ...jit.compiled import device, kernel
from ..mesh.mesh import Mesh
from .closest_point import ClosestPoint, closest_of, query
from .winding_number import WindingNumber, inside_at

Float64 = npt.NDArray[np.float64]


@device
def signed_distance(tree, normals, winding, x, y, z, most, stack):
    """Signed distance to the surface of a :class:`SignedDistanceTree`, whose attributes are the first three.

    The surface is known to be no farther than `most`, which saves looking farther; infinity will do.

    The sign is that of the way from the closest point to (x, y, z) along the pseudonormal there: of the
    face, of the two faces at an edge, of all faces round a vertex, weighted by their angles. J. A.
    Baerentzen, H. Aanaes, "Signed Distance Computation Using the Angle Weighted Pseudonormal" (2005). Where
    there is a `winding`, it is that of the winding number.
    """
    reach = most * most * (1.0 + 1e-6)
    for _ in range(2):
        cx, cy, cz, square, f, s, t = query(tree, x, y, z, reach, -1.0, stack)
        if f >= 0:
            break
        reach = np.inf  # by rounding it was farther
    return _with_sign(tree, normals, winding, x, y, z, cx, cy, cz, square, f, s, t)


@device
def signed_distance_to(tree, normals, winding, near, first, last, x, y, z, most):
    """Signed distance to the faces ``near[first:last]``, or infinity if none is nearer than `most`."""
    points = tree[0]
    faces = tree[1]
    best = most * most
    cx = x
    cy = y
    cz = z
    s = 0.0
    t = 0.0
    closest = -1
    for k in range(first, last):
        f = near[k]
        o = faces[f, 0]
        h = (
            (x - points[o, 0]) * normals[f, 0]
            + (y - points[o, 1]) * normals[f, 1]
            + (z - points[o, 2]) * normals[f, 2]
        )
        if 0.999 * h * h > best:
            continue
        px, py, pz, ps, pt = closest_of(points, o, faces[f, 1], faces[f, 2], x, y, z)
        square = (px - x) ** 2 + (py - y) ** 2 + (pz - z) ** 2
        if square < best:
            best = square
            cx = px
            cy = py
            cz = pz
            s = ps
            t = pt
            closest = f
    if closest < 0:
        return np.inf
    return _with_sign(tree, normals, winding, x, y, z, cx, cy, cz, best, closest, s, t)


@device
def _with_sign(tree, normals, winding, x, y, z, cx, cy, cz, square, f, s, t):
    if winding.shape[0] > 0:
        distance = np.sqrt(square)
        return -distance if inside_at(winding, x, y, z, distance) else distance
    faces = tree[1]
    row = f
    if s == 0.0 and t == 0.0:
        row = 4 * faces.shape[0] + faces[f, 0]
    elif s == 1.0:
        row = 4 * faces.shape[0] + faces[f, 1]
    elif t == 1.0:
        row = 4 * faces.shape[0] + faces[f, 2]
    elif t == 0.0:
        row = faces.shape[0] + 3 * f
    elif s == 1.0 - t:
        row = faces.shape[0] + 3 * f + 1
    elif s == 0.0:
        row = faces.shape[0] + 3 * f + 2
    along = (x - cx) * normals[row, 0] + (y - cy) * normals[row, 1] + (z - cz) * normals[row, 2]
    return np.sqrt(square) if along > 0.0 else -np.sqrt(square)


@kernel
def _signed_distances(starts, ends, tree, normals, winding, points, most, distances):
    # Infinity where the surface is farther than `most`.
    stack = np.empty(128, np.int32)
    reach = np.nextafter(most * most, np.inf)
    for part in range(starts.size):
        for i in range(starts[part], ends[part]):
            x = points[i, 0]
            y = points[i, 1]
            z = points[i, 2]
            cx, cy, cz, square, f, s, t = query(tree, x, y, z, reach, -1.0, stack)
            distances[i] = (
                _with_sign(tree, normals, winding, x, y, z, cx, cy, cz, square, f, s, t) if f >= 0 else np.inf
            )


class SignedDistanceTree:
    """A surface that can be asked for signed distances, negative inside.

    Parameters
    ----------
    mesh : Mesh or ClosestPoint
        Normals outwards. Points in one place must be one point; an edge between more than two faces
        takes the sum of their normals. With a `winding`: what bounds its inside, in parts that need not fit
        together.
    winding : WindingNumber, optional
        A closed surface that tells who is inside: where its winding number is 1 or more. Without one, the
        nearest face does.

    Attributes
    ----------
    surface : ClosestPoint
    tree : tuple of arrays
    normals : (4 t + n, 3) float64
        What :func:`signed_distance` takes: pseudonormals of faces, of their three sides, of points.
    winding : (k, 3) float64
        What it takes as well; empty if the pseudonormals tell who is inside.

    Examples
    --------
    >>> from vtksmooth.kernels.mesh.mesh import Mesh
    >>> corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    >>> distance = SignedDistanceTree(
    ...     Mesh.from_faces(corners, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    ... )
    >>> distance([[0.1, 0.2, 0.3], [0, 0, 3], [-1, -1, 0.1]]).round(6).tolist()
    [-0.1, 2.0, 1.414214]
    """

    def __init__(self, mesh: Mesh | ClosestPoint, winding: WindingNumber | None = None) -> None:
        self.surface = ClosestPoint(mesh) if isinstance(mesh, Mesh) else mesh
        self.tree = self.surface.tree
        self.normals = _pseudonormals(self.tree[0], self.tree[1])
        self.winding = np.empty((0, 3)) if winding is None else winding.packed

    def __call__(self, points: npt.ArrayLike, most: float = np.inf) -> Float64:
        """Return the signed distances (q,) of `points` (q, 3), model units; infinity beyond `most`.

        Looking no farther than some distance is far cheaper: most points are nowhere near.
        """
        points = np.ascontiguousarray(points, dtype=np.float64).reshape(-1, 3)
        distances = np.empty(len(points))
        parallel.run(
            _signed_distances, *parallel.ranges(len(points)),
            self.tree, self.normals, self.winding, points, float(most), distances,
            smallest_share=parallel.COSTLY,
        )  # fmt: skip
        return distances


def _pseudonormals(points: Float64, faces: npt.NDArray[np.int32]) -> Float64:
    """Return the normals of faces, of their sides, face by face, of points, (4 t + n, 3); lengths vary."""
    n = len(points)
    corners = points[faces]
    sides = _unit(np.roll(corners, -1, axis=1) - corners)  # side i runs from corner i to the next
    of_faces = _unit(np.cross(sides[:, 0], sides[:, 1]))
    start, end = faces.astype(np.int64), np.roll(faces, -1, axis=1).astype(np.int64)
    keys = (np.minimum(start, end) * n + np.maximum(start, end)).ravel()
    _, edge = np.unique(keys, return_inverse=True)
    of_edges = np.column_stack([np.bincount(edge, weights=np.repeat(of_faces[:, i], 3)) for i in range(3)])
    # The angle at corner i lies between side i and the side before, turned round.
    into = np.roll(sides, 1, axis=1)
    angles = np.arctan2(np.linalg.norm(np.cross(into, sides), axis=2), -(into * sides).sum(axis=2))
    of_points: Float64 = np.column_stack(
        [
            np.bincount(faces.ravel(), weights=(angles * of_faces[:, i : i + 1]).ravel(), minlength=n)
            for i in range(3)
        ]
    )
    return np.concatenate((of_faces, of_edges[edge.ravel()], of_points))


def _unit(vectors: Float64) -> Float64:
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0.0)  # type: ignore[no-any-return]
