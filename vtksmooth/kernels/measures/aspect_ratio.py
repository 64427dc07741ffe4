"""Signed aspect ratio k of triangles, quadrilaterals and polygons.

Semenova et al., sections 2.1 and 3.1: 1 for the equilateral triangle and the square, 0 for a degenerate
element, negative for an inverted one. Bent faces are worse than plane ones.

Kernels compare *signed squares* ``q = k |k|``: the order is that of k, and no root is drawn.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ...jit import parallel
from ...jit.compiled import device, kernel, routine
from ...jit.simd import select
from ..mesh.labels import sheets
from ..mesh.mesh import LARGEST_POLYGON, Mesh

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]

#: The papers' bins of k.
BINS = (0.0, 0.2, 0.4, 0.6, 0.8)

#: Twice the vector area of a polygon over the sum of its squared sides, below which it is rounding.
_CANCELLED = 1e-13

#: How much the thickness of polygons with five corners or more counts. With 1 instead of 4 Trapezium Drawing
#: made noisy dual meshes less flat.
_THICKNESS = 4.0


@device
def spokes_square(ax, ay, az, aa, bx, by, bz, bb, rx, ry, rz):
    """Signed square of ``k = 4 sqrt(3) A / (l1^2 + l2^2 + l3^2)`` of the triangle (0, a, b).

    aa and bb are the squares of a and b. With N = a x b (twice the area) and l1^2 + l2^2 + l3^2 =
    2 (aa + bb - a.b), k^2 is 3 N^2 / (aa + bb - a.b)^2. The sign is that of N against the reference
    direction r. Numbers, or lanes of four triangles.
    """
    nx = ay * bz - az * by
    ny = az * bx - ax * bz
    nz = ax * by - ay * bx
    length = aa + bb - (ax * bx + ay * by + az * bz)
    # One division, and before the square: lengths of 1e-60 do not underflow.
    inverse = 1.0 / length
    q = 3.0 * ((nx * nx + ny * ny + nz * nz) * inverse * inverse)
    q = select(nx * rx + ny * ry + nz * rz < 0.0, -q, q)
    return select(length == 0.0, 0.0, q)


@device
def triangle_square(ax, ay, az, bx, by, bz, rx, ry, rz):
    """Do as :func:`spokes_square` does where the squares are not at hand."""
    aa = ax * ax + ay * ay + az * az
    bb = bx * bx + by * by + bz * bz
    return spokes_square(ax, ay, az, aa, bx, by, bz, bb, rx, ry, rz)


@device
def polygon_scale(size):
    """Square of the factor that makes k = 1 for the regular polygon; 32 for the quadrilateral.

    The regular polygon with circumradius 1 has sides s = 2 sin(pi/n), corner triangles of area
    s^2 sin(2 pi/n) / 2, and a longest diagonal of 2 (n even) or 2 cos(pi/2n) (n odd).
    """
    if size == 4:
        return 32.0
    side = 2.0 * np.sin(np.pi / size)
    area = 0.5 * side * side * np.sin(2.0 * np.pi / size)
    longest = 2.0 if size % 2 == 0 else 2.0 * np.cos(0.5 * np.pi / size)
    return size * side * side * longest * longest / (area * area)


@routine
def polygon_square(points, connectivity, first, last, v, x, y, z, rx, ry, rz):
    """Signed square of k of a polygon with four corners or more, with vertex v at (x, y, z).

    ``k1 = c min A_i / (sqrt(sum l_i^2) h)`` is k of a quadrilateral. With more corners, k is k1 where that is
    negative, and otherwise ``min(k1, 4 tan(pi/n) |A| / sum l_i^2) / (1 + 4 t)^2``. A is the vector area. A_i
    are the signed areas of *all* corner triangles as seen along A (turned to the side of the reference
    direction r): of a concave or self-crossing quadrilateral one is negative, whichever way it would be
    split. h is the longest side or diagonal, and c makes k = 1 for the regular polygon (4 sqrt(2) for the
    square). t is how thick the polygon is: the root mean square of the distances of its corners from the
    plane across A through their mean, over that of their distances from the mean.

    k is at most 1, and 1 for the regular plane polygon only; a polygon that is not plane has a smaller k than
    its projection along A, if that is positive. For the projection has the same A and A_i, and shorter sides.
    In the plane, with corners ``z_j = sum_m c_m exp(2 pi i j m / n)`` as complex numbers,

    ``sum l_j^2 - 4 tan(pi/n) A = 4 n sum_m |c_m|^2 sin^2(pi m/n) (1 - tan(pi/n) cot(pi m/n))``

    with m = 1 ... n - 1. No term is negative, and only that of m = 1, the regular polygon, is 0. Of a
    quadrilateral A = A_1 + A_3 = A_2 + A_4, so min A_i <= A / 2; with A <= sum l_i^2 / 4 and A <= h^2 / 2
    (half the diagonals' cross product) k1 is at most 1, and 1 for the square only. Of plane convex polygons
    k is k1, as far as is known: the isoperimetric bound is there for crumpled ones and for stars, whose
    corner triangles are large. The thickness counts linearly: a gate would otherwise buy rounder polygons
    with warped ones.
    """
    size = last - first
    o = connectivity[first]
    ox = x if o == v else points[o, 0]
    oy = y if o == v else points[o, 1]
    oz = z if o == v else points[o, 2]
    # Twice the vector area, seen from the first corner.
    ux = 0.0
    uy = 0.0
    uz = 0.0
    mx = 0.0
    my = 0.0
    mz = 0.0
    bx = 0.0
    by = 0.0
    bz = 0.0
    for i in range(1, size):
        p = connectivity[first + i]
        ax = bx
        ay = by
        az = bz
        bx = (x if p == v else points[p, 0]) - ox
        by = (y if p == v else points[p, 1]) - oy
        bz = (z if p == v else points[p, 2]) - oz
        mx += bx / size
        my += by / size
        mz += bz / size
        ux += ay * bz - az * by
        uy += az * bx - ax * bz
        uz += ax * by - ay * bx
    area = np.sqrt(ux * ux + uy * uy + uz * uz)
    perimeter = 0.0
    longest = 0.0
    for i in range(size):
        p = connectivity[first + i]
        q = connectivity[first + (i + 1) % size]
        px = x if p == v else points[p, 0]
        py = y if p == v else points[p, 1]
        pz = z if p == v else points[p, 2]
        ax = (x if q == v else points[q, 0]) - px
        ay = (y if q == v else points[q, 1]) - py
        az = (z if q == v else points[q, 2]) - pz
        side = ax * ax + ay * ay + az * az
        perimeter += side
        longest = max(longest, side)
        # In giants twice the largest distance from the middle stands for the longest diagonal.
        if size > LARGEST_POLYGON:
            ax = px - ox - mx
            ay = py - oy - my
            az = pz - oz - mz
            longest = max(longest, 4.0 * (ax * ax + ay * ay + az * az))
            continue
        for j in range(i + 2, size - (1 if i == 0 else 0)):
            d = connectivity[first + j]
            dx = (x if d == v else points[d, 0]) - px
            dy = (y if d == v else points[d, 1]) - py
            dz = (z if d == v else points[d, 2]) - pz
            longest = max(longest, dx * dx + dy * dy + dz * dz)
    if perimeter == 0.0 or longest == 0.0:
        return 0.0
    # Of an area that cancels, but for rounding, the direction has no meaning.
    if area > _CANCELLED * perimeter:
        turn = -1.0 / area if ux * rx + uy * ry + uz * rz < 0.0 else 1.0 / area
        ux *= turn
        uy *= turn
        uz *= turn
    else:
        ux = rx
        uy = ry
        uz = rz
    smallest = np.inf
    from_plane = 0.0
    from_mean = 0.0
    for i in range(size):
        p = connectivity[first + i]
        q = connectivity[first + (i + 1) % size]
        d = connectivity[first + (i + size - 1) % size]
        px = x if p == v else points[p, 0]
        py = y if p == v else points[p, 1]
        pz = z if p == v else points[p, 2]
        ax = (x if q == v else points[q, 0]) - px
        ay = (y if q == v else points[q, 1]) - py
        az = (z if q == v else points[q, 2]) - pz
        bx = (x if d == v else points[d, 0]) - px
        by = (y if d == v else points[d, 1]) - py
        bz = (z if d == v else points[d, 2]) - pz
        nx = ay * bz - az * by
        ny = az * bx - ax * bz
        nz = ax * by - ay * bx
        smallest = min(smallest, nx * ux + ny * uy + nz * uz)
        ax = px - ox - mx
        ay = py - oy - my
        az = pz - oz - mz
        from_mean += ax * ax + ay * ay + az * az
        from_plane += (ax * ux + ay * uy + az * uz) ** 2
    square = polygon_scale(size) * (0.25 * smallest * abs(smallest) / perimeter / longest)
    if size == 4 or square <= 0.0:
        return square
    roundness = 2.0 * np.tan(np.pi / size) * (area / perimeter)
    flat = 1.0 / (1.0 + _THICKNESS * np.sqrt(from_plane / from_mean))
    return min(square, roundness * roundness) * (flat * flat) * (flat * flat)


@device
def _corners_square(points, connectivity, a, rx, ry, rz):
    # Of the triangle whose first corner stands at a.
    p = connectivity[a]
    q = connectivity[a + 1]
    r = connectivity[a + 2]
    x = points[p, 0]
    y = points[p, 1]
    z = points[p, 2]
    return triangle_square(
        points[q, 0] - x, points[q, 1] - y, points[q, 2] - z,
        points[r, 0] - x, points[r, 1] - y, points[r, 2] - z,
        rx, ry, rz,
    )  # fmt: skip


@device
def face_square(points, offsets, connectivity, f, reference):
    """Signed square of k of face f; 0 for faces of fewer than three corners."""
    a = offsets[f]
    b = offsets[f + 1]
    rx = reference[f, 0]
    ry = reference[f, 1]
    rz = reference[f, 2]
    if b - a == 3:
        return _corners_square(points, connectivity, a, rx, ry, rz)
    if b - a < 3:
        return 0.0
    return polygon_square(points, connectivity, a, b, np.int64(-1), 0.0, 0.0, 0.0, rx, ry, rz)


@device
def _signed_root(q):
    return np.sqrt(q) if q >= 0.0 else -np.sqrt(-q)


@kernel
def _aspect_ratios_of_triangles(starts, ends, points, connectivity, reference, k):
    for part in range(starts.size):
        for f in range(starts[part], ends[part]):
            rx = reference[f, 0]
            ry = reference[f, 1]
            rz = reference[f, 2]
            k[f] = _signed_root(_corners_square(points, connectivity, 3 * f, rx, ry, rz))


@kernel
def _aspect_ratios(starts, ends, points, offsets, connectivity, reference, k):
    for part in range(starts.size):
        for f in range(starts[part], ends[part]):
            k[f] = _signed_root(face_square(points, offsets, connectivity, f, reference))


@device
def ring_normal(points, near, v):
    """Sum of the area vectors of the faces round v, times two; each taken as a fan from v."""
    x = points[v, 0]
    y = points[v, 1]
    z = points[v, 2]
    nx = 0.0
    ny = 0.0
    nz = 0.0
    for row in range(near.corner_offsets[v], near.corner_offsets[v + 1]):
        c = near.corners[row]
        f = near.corner_face[c]
        last = near.offsets[f + 1]
        size = last - near.offsets[f]
        for step in range(1, size - 1):
            p = near.connectivity[c + step if c + step < last else c + step - size]
            q = near.connectivity[c + step + 1 if c + step + 1 < last else c + step + 1 - size]
            ax = points[p, 0] - x
            ay = points[p, 1] - y
            az = points[p, 2] - z
            bx = points[q, 0] - x
            by = points[q, 1] - y
            bz = points[q, 2] - z
            nx += ay * bz - az * by
            ny += az * bx - ax * bz
            nz += ax * by - ay * bx
    return nx, ny, nz


@device
def area_vector(points, offsets, connectivity, f):
    """Half the sum of the cross products of successive corners of face f, seen from its first.

    For a polygon that is not plane: the vector area of any surface that it bounds.
    """
    nx = 0.0
    ny = 0.0
    nz = 0.0
    a = offsets[f]
    o = connectivity[a] if offsets[f + 1] > a else 0
    for c in range(a + 1, offsets[f + 1] - 1):
        p = connectivity[c]
        q = connectivity[c + 1]
        ax = points[p, 0] - points[o, 0]
        ay = points[p, 1] - points[o, 1]
        az = points[p, 2] - points[o, 2]
        bx = points[q, 0] - points[o, 0]
        by = points[q, 1] - points[o, 1]
        bz = points[q, 2] - points[o, 2]
        nx += ay * bz - az * by
        ny += az * bx - ax * bz
        nz += ax * by - ay * bx
    return 0.5 * nx, 0.5 * ny, 0.5 * nz


@kernel
def _area_vectors(starts, ends, points, offsets, connectivity, area):
    for part in range(starts.size):
        for f in range(starts[part], ends[part]):
            area[f, 0], area[f, 1], area[f, 2] = area_vector(points, offsets, connectivity, f)


@kernel
def _add_to_corners(points, offsets, connectivity, normals):
    for f in range(offsets.size - 1):
        nx, ny, nz = area_vector(points, offsets, connectivity, f)
        for c in range(offsets[f], offsets[f + 1]):
            v = connectivity[c]
            normals[v, 0] += nx
            normals[v, 1] += ny
            normals[v, 2] += nz


@kernel
def _sum_at_faces(starts, ends, offsets, connectivity, normals, reference):
    total = np.empty(3)
    for part in range(starts.size):
        for f in range(starts[part], ends[part]):
            largest = 0.0
            for axis in range(3):
                total[axis] = 0.0
                for c in range(offsets[f], offsets[f + 1]):
                    total[axis] += normals[connectivity[c], axis]
                largest = max(largest, abs(total[axis]))
            # By the largest component first: squares of areas of tiny or giant meshes leave float64.
            length = 0.0
            if largest > 0.0:
                for axis in range(3):
                    length += (total[axis] / largest) ** 2
            scale = 1.0 / np.sqrt(length) if length > 0.0 else 0.0
            for axis in range(3):
                reference[f, axis] = total[axis] / largest * scale if largest > 0.0 else 0.0


def area_vectors(mesh: Mesh) -> Float64:
    """Return each face's area times its unit normal, (m, 3)."""
    area = np.empty((mesh.n_faces, 3))
    parallel.run(
        _area_vectors, *parallel.ranges(mesh.n_faces), mesh.points, mesh.offsets, mesh.connectivity, area
    )
    return area


def ring_normals(mesh: Mesh) -> Float64:
    """Return each vertex' area-weighted normal, not unit: the sum of its faces' area vectors, (n, 3)."""
    normals = np.zeros((mesh.n_points, 3))
    _add_to_corners(mesh.points, mesh.offsets, mesh.connectivity, normals)
    return normals


def reference_directions(mesh: Mesh) -> Float32:
    """Return for each face the direction of the sum of its vertices' ring normals, unit, (m, 3) float32.

    An area on a surface is positive or negative *against a direction*. The face's own normal will not
    do (a face folded in the input would count as inverted once it is mended), nor will the ring normal
    of whichever vertex is being moved (one face would have several signs). One direction per face,
    taken once from the reference mesh and frozen, does; single precision says as well which side is
    which, at half the memory. Where the normals cancel the direction is 0, and no area is negative.
    Of a surface between labels each sheet counts by itself.
    """
    if mesh.face_labels is not None:
        mesh, _ = sheets(mesh)
    reference = np.empty((mesh.n_faces, 3), np.float32)
    parallel.run(
        _sum_at_faces, *parallel.ranges(mesh.n_faces),
        mesh.offsets, mesh.connectivity, ring_normals(mesh), reference,
    )  # fmt: skip
    return reference


def aspect_ratios(mesh: Mesh, reference: Float32, *, bounded: bool = True) -> Float64:
    """Return the signed aspect ratio k of every face, (m,).

    Between -1 and 1, and 1 for regular plane faces only.

    Parameters
    ----------
    mesh : Mesh
    reference : (m, 3) float32
        Direction against which each face's area is signed, from :func:`reference_directions`.
    bounded : bool
        Of concave, crossed and inverted faces with four corners or more the formula can fall below -1.
        Such faces have -1; otherwise what gates compare, for which less bad is better there, too.

    Notes
    -----
    Triangles: section 2.1 of Semenova et al. Quadrilaterals: section 3.1, with the corner triangles of
    both diagonals as seen along the face's vector area: for plane ones the paper's. Polygons with more
    corners: the quadrilateral's formula, scaled so that the regular polygon has k = 1, at most the
    isoperimetric quotient of sides and area, and less the thicker the polygon is; :func:`polygon_square`
    proves that no face exceeds 1. Faces with fewer than three corners have k = 0.
    """
    k = np.empty(mesh.n_faces)
    everything = parallel.ranges(mesh.n_faces)
    if mesh.only_triangles:
        parallel.run(_aspect_ratios_of_triangles, *everything, mesh.points, mesh.connectivity, reference, k)
    else:
        parallel.run(_aspect_ratios, *everything, mesh.points, mesh.offsets, mesh.connectivity, reference, k)
        if bounded:
            np.maximum(k, -1.0, out=k)
    return k


def histogram(k: Float64) -> list[float]:
    """Return the percentages of faces in the papers' bins k<0, 0-.2, .2-.4, .4-.6, .6-.8, .8-1."""
    counts = np.bincount(np.searchsorted(BINS, k, side="right"), minlength=6)
    return [100.0 * float(count) / max(len(k), 1) for count in counts]
