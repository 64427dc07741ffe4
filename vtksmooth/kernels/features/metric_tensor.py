"""The metric tensor of a vertex and its eigen-analysis (Jiao, section 2.1)."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ...jit import parallel
from ...jit.compiled import device, kernel
from ...jit.simd import absolute, select, square_root
from ..measures.dihedral import face_normals, unit_normal
from ..mesh.adjacency import Adjacency
from ..mesh.mesh import Mesh

Float64 = npt.NDArray[np.float64]

#: The eigenvalue that lies apart, of a matrix of trace 0 and norm sqrt(6), where its determinant is 0.
_CHORD = float(np.sqrt(3.0))

#: What weighs a face in the tensor: its area, or its angle at the vertex.
WEIGHTS = ("area", "angle")


@device
def corner_angle(points, near, row, n0, n1, n2):
    """Return the angle of a face at one of its corners, radians; n is the face's normal.

    More than half a turn at reflex corners, where the sides turn against the normal. `row` is the position
    of the corner in ``near.corners``.
    """
    c = near.corners[row]
    f = near.corner_face[c]
    first = near.offsets[f]
    last = near.offsets[f + 1]
    v = near.connectivity[c]
    p = near.connectivity[c + 1 if c + 1 < last else first]
    q = near.connectivity[c - 1 if c > first else last - 1]
    ax = points[p, 0] - points[v, 0]
    ay = points[p, 1] - points[v, 1]
    az = points[p, 2] - points[v, 2]
    bx = points[q, 0] - points[v, 0]
    by = points[q, 1] - points[v, 1]
    bz = points[q, 2] - points[v, 2]
    sx = ay * bz - az * by
    sy = az * bx - ax * bz
    sz = ax * by - ay * bx
    largest = max(abs(sx), abs(sy), abs(sz))
    sine = 0.0
    if largest > 0.0:
        sine = largest * np.sqrt((sx / largest) ** 2 + (sy / largest) ** 2 + (sz / largest) ** 2)
    angle = np.arctan2(sine, ax * bx + ay * by + az * bz)
    return 2.0 * np.pi - angle if sx * n0 + sy * n1 + sz * n2 < 0.0 else angle


@device
def metric_tensor(points, near, normals, v, weight):
    """Return A = sum of w n n^T and b = sum of w n over the faces round v; 2.1.

    Parameters
    ----------
    points : (n, 3) float64
    near : Adjacency
    normals : (m, 4) float64
        Of the faces, as :func:`~vtksmooth.kernels.measures.dihedral.face_normals` gives them; they may be
        filtered. Where they are empty, the faces are read as they are now.
    v : int
    weight : int
        0: w is the area of the face, 1: its angle at v (better on badly graded meshes). A polygon counts
        by its area vector.

    Returns
    -------
    a00, a01, a02, a11, a12, a22, b0, b1, b2 : float64
        The upper half of A, and b. Zeros where no face round v has an area.
    """
    a00 = 0.0
    a01 = 0.0
    a02 = 0.0
    a11 = 0.0
    a12 = 0.0
    a22 = 0.0
    b0 = 0.0
    b1 = 0.0
    b2 = 0.0
    for row in range(near.corner_offsets[v], near.corner_offsets[v + 1]):
        f = np.intp(near.corner_face[near.corners[row]])
        if normals.size > 0:
            n0 = normals[f, 0]
            n1 = normals[f, 1]
            n2 = normals[f, 2]
            w = normals[f, 3]
        else:
            n0, n1, n2, w = unit_normal(points, near.offsets, near.connectivity, f)
        if weight == 1 and w > 0.0:
            w = corner_angle(points, near, row, n0, n1, n2)
        a00 += w * n0 * n0
        a01 += w * n0 * n1
        a02 += w * n0 * n2
        a11 += w * n1 * n1
        a12 += w * n1 * n2
        a22 += w * n2 * n2
        b0 += w * n0
        b1 += w * n1
        b2 += w * n2
    return a00, a01, a02, a11, a12, a22, b0, b1, b2


@device
def _isolated_vector(a00, a01, a02, a11, a12, a22):
    # The null vector of a symmetric matrix of rank 2: the longest cross product of two of its rows.
    x0 = a01 * a12 - a02 * a11
    y0 = a02 * a01 - a00 * a12
    z0 = a00 * a11 - a01 * a01
    x1 = a01 * a22 - a02 * a12
    y1 = a02 * a02 - a00 * a22
    z1 = a00 * a12 - a01 * a02
    x2 = a11 * a22 - a12 * a12
    y2 = a12 * a02 - a01 * a22
    z2 = a01 * a12 - a11 * a02
    s0 = x0 * x0 + y0 * y0 + z0 * z0
    s1 = x1 * x1 + y1 * y1 + z1 * z1
    s2 = x2 * x2 + y2 * y2 + z2 * z2
    first = s0 >= s1
    x = select(first, x0, x1)
    y = select(first, y0, y1)
    z = select(first, z0, z1)
    s = select(first, s0, s1)
    first = s >= s2
    x = select(first, x, x2)
    y = select(first, y, y2)
    z = select(first, z, z2)
    s = 1.0 / square_root(select(first, s, s2))
    return x * s, y * s, z * s


@device
def _apart(a00, a01, a02, a11, a12, a22):
    """Return whether the eigenvalue that lies apart from the other two is the largest, and its unit vector.

    Of a matrix whose largest entry is 1. From the cubic equation, where this root is exact to rounding. The
    vector is 0 where all three are equal. Of numbers or of lanes.
    """
    mean = (a00 + a11 + a22) / 3.0
    d0 = a00 - mean
    d1 = a11 - mean
    d2 = a22 - mean
    p = square_root((d0 * d0 + d1 * d1 + d2 * d2 + 2.0 * (a01 * a01 + a02 * a02 + a12 * a12)) / 6.0)
    apart = p > 1e-150
    # B = (A - mean) / p has the eigenvalues 2 cos(angle + 2 pi i / 3) with cos(3 angle) = det(B) / 2.
    s = 1.0 / p
    c0 = d0 * s
    c1 = d1 * s
    c2 = d2 * s
    c01 = a01 * s
    c02 = a02 * s
    c12 = a12 * s
    half = 0.5 * (c0 * (c1 * c2 - c12 * c12) - c01 * (c01 * c2 - c12 * c02) + c02 * (c01 * c12 - c1 * c02))
    highest = half >= 0.0
    # The largest root of x^3 - 3 x = 2 |half|, which lies between sqrt(3) and 2: three of Newton's steps
    # from the chord are exact to rounding, in half the time of the arc cosine.
    half = absolute(half)
    half = select(half < 1.0, half, 1.0)
    root = _CHORD + (2.0 - _CHORD) * half
    for _ in range(3):
        root -= (root * (root * root - 3.0) - 2.0 * half) / (3.0 * (root * root - 1.0))
    root = select(highest, root, -root)
    ux, uy, uz = _isolated_vector(c0 - root, c01, c02, c1 - root, c12, c2 - root)
    return highest, select(apart, ux, 0.0), select(apart, uy, 0.0), select(apart, uz, 0.0)


@device
def first_eigenvector(a00, a01, a02, a11, a12, a22):
    """Return the unit eigenvector of the largest eigenvalue of a metric tensor, where it is the one apart.

    Of numbers or of lanes, in a third of the time of :func:`eigen`. 0 where it is not, or where the tensor
    is 0; on smooth surfaces it is nearly always.

    Returns
    -------
    e10, e11, e12 : float64
    """
    s = 1.0 / (a00 + a11 + a22)
    highest, x, y, z = _apart(a00 * s, a01 * s, a02 * s, a11 * s, a12 * s, a22 * s)
    return select(highest, x, 0.0), select(highest, y, 0.0), select(highest, z, 0.0)


@device
def _form(a00, a01, a02, a11, a12, a22, x, y, z):
    # v^T A v
    tx = a00 * x + a01 * y + a02 * z
    ty = a01 * x + a11 * y + a12 * z
    tz = a02 * x + a12 * y + a22 * z
    return x * tx + y * ty + z * tz


@device
def eigen(a00, a01, a02, a11, a12, a22):
    """Return the eigenvalues, largest first, and unit eigenvectors of a symmetric 3x3 matrix.

    In closed form. The eigenvalue that lies apart from the other two is taken from the cubic
    equation, where it is exact to rounding; its vector from a cross product; the other
    two, which may be equal, from the 2x2 matrix that is left in the plane across. So repeated
    eigenvalues cost no digits, and the vectors are always orthonormal and right-handed.

    Returns
    -------
    l1, l2, l3 : float64
    e10, e11, e12, e20, e21, e22, e30, e31, e32 : float64
    """
    largest = max(abs(a00), abs(a01), abs(a02), abs(a11), abs(a12), abs(a22))
    if largest == 0.0:
        return 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0
    a00 /= largest
    a01 /= largest
    a02 /= largest
    a11 /= largest
    a12 /= largest
    a22 /= largest
    highest, ux, uy, uz = _apart(a00, a01, a02, a11, a12, a22)
    if ux == 0.0 and uy == 0.0 and uz == 0.0:
        l1 = (a00 + a11 + a22) / 3.0 * largest
        return l1, l1, l1, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0
    # A plane across it, spanned by v and w.
    if abs(ux) > abs(uy):
        s = 1.0 / np.sqrt(ux * ux + uz * uz)
        vx = -uz * s
        vy = 0.0
        vz = ux * s
    else:
        s = 1.0 / np.sqrt(uy * uy + uz * uz)
        vx = 0.0
        vy = uz * s
        vz = -uy * s
    wx = uy * vz - uz * vy
    wy = uz * vx - ux * vz
    wz = ux * vy - uy * vx
    tx = a00 * vx + a01 * vy + a02 * vz
    ty = a01 * vx + a11 * vy + a12 * vz
    tz = a02 * vx + a12 * vy + a22 * vz
    vv = vx * tx + vy * ty + vz * tz
    vw = wx * tx + wy * ty + wz * tz
    ww = _form(a00, a01, a02, a11, a12, a22, wx, wy, wz)
    alone = _form(a00, a01, a02, a11, a12, a22, ux, uy, uz)
    # One Jacobi rotation makes the 2x2 matrix diagonal.
    t = 0.0
    if vw != 0.0:
        ratio = (ww - vv) / (2.0 * vw)
        t = 1.0 / (abs(ratio) + np.sqrt(ratio * ratio + 1.0))
        if ratio < 0.0:
            t = -t
    cos = 1.0 / np.sqrt(t * t + 1.0)
    sin = t * cos
    px = cos * vx - sin * wx
    py = cos * vy - sin * wy
    pz = cos * vz - sin * wz
    high = vv - t * vw
    qx = sin * vx + cos * wx
    qy = sin * vy + cos * wy
    qz = sin * vz + cos * wz
    low = ww + t * vw
    if high < low:
        high, low = low, high
        # Turned by a quarter, so that they stay right-handed.
        px, py, pz, qx, qy, qz = qx, qy, qz, -px, -py, -pz
    high *= largest
    low *= largest
    alone *= largest
    if highest:
        return max(alone, high), high, low, ux, uy, uz, px, py, pz, qx, qy, qz
    return high, low, min(alone, low), px, py, pz, qx, qy, qz, ux, uy, uz


@kernel
def _eigen_systems(starts, ends, points, near, normals, weight, values, vectors, sums):
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            a00, a01, a02, a11, a12, a22, b0, b1, b2 = metric_tensor(points, near, normals, v, weight)
            l1, l2, l3, x1, y1, z1, x2, y2, z2, x3, y3, z3 = eigen(a00, a01, a02, a11, a12, a22)
            if x1 * b0 + y1 * b1 + z1 * b2 < 0.0:
                x1, y1, z1, x2, y2, z2 = -x1, -y1, -z1, -x2, -y2, -z2
            values[v, 0] = l1
            values[v, 1] = l2
            values[v, 2] = l3
            vectors[v, 0, 0] = x1
            vectors[v, 0, 1] = y1
            vectors[v, 0, 2] = z1
            vectors[v, 1, 0] = x2
            vectors[v, 1, 1] = y2
            vectors[v, 1, 2] = z2
            vectors[v, 2, 0] = x3
            vectors[v, 2, 1] = y3
            vectors[v, 2, 2] = z3
            sums[v, 0] = b0
            sums[v, 1] = b1
            sums[v, 2] = b2


def eigen_systems(mesh: Mesh, near: Adjacency, weight: str = "area") -> tuple[Float64, Float64, Float64]:
    """Return the eigenvalues and eigenvectors of every vertex' metric tensor.

    Parameters
    ----------
    mesh : Mesh
    near : Adjacency
    weight : {"area", "angle"}

    Returns
    -------
    values : (n, 3) float64
        Largest first; zeros where no face round the vertex has an area.
    vectors : (n, 3, 3) float64
        ``vectors[v, i]`` is the unit eigenvector of ``values[v, i]``; the three are right-handed and the
        first points to the side of b.
    sums : (n, 3) float64
        b, the weighted sum of the normals.

    Examples
    --------
    >>> from vtksmooth.kernels.mesh import adjacency
    >>> square = Mesh.from_faces([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    >>> values, vectors, _ = eigen_systems(square, adjacency.build(square))
    >>> values[0].tolist(), vectors[0, 0].tolist()
    ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0])
    """
    n = mesh.n_points
    values, vectors, sums = np.empty((n, 3)), np.empty((n, 3, 3)), np.empty((n, 3))
    parallel.run(
        _eigen_systems, *parallel.ranges(n),
        mesh.points, near, face_normals(mesh), WEIGHTS.index(weight), values, vectors, sums,
        smallest_share=parallel.COSTLY,
    )  # fmt: skip
    return values, vectors, sums
