"""The volume of a mesh whose vertices shift along directions, all by the same distance: a cubic in it."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ...jit import parallel
from ...jit.compiled import device, kernel
from ...jit.simd import WIDTH, gather, pack, select, spread, unpack
from ..mesh.mesh import Mesh

Float64 = npt.NDArray[np.float64]

#: Part of the squares of its sides by which a triangle's area must be clear of 0 to be no doubtful one.
_CLEAR = 1e-12

#: Square of that of quadrilaterals.
_ROUNDING = 1e-24


@device
def _cubic(px, py, pz, ax, ay, az, ux, uy, uz, vx, vy, vz, dx, dy, dz, ex, ey, ez):
    """Return the coefficients of ``(p + s a) . ((u + s d) x (v + s e))``, and the vectors of the product.

    That is six times the volume of the cone from the origin over a triangle with the corner p and the sides u
    and v, which shift along a, a + d and a + e. Numbers, or lanes of four triangles.
    """
    nx = uy * vz - uz * vy
    ny = uz * vx - ux * vz
    nz = ux * vy - uy * vx
    mx = (dy * vz - dz * vy) + (uy * ez - uz * ey)
    my = (dz * vx - dx * vz) + (uz * ex - ux * ez)
    mz = (dx * vy - dy * vx) + (ux * ey - uy * ex)
    lx = dy * ez - dz * ey
    ly = dz * ex - dx * ez
    lz = dx * ey - dy * ex
    of_0 = px * nx + py * ny + pz * nz
    of_1 = (ax * nx + ay * ny + az * nz) + (px * mx + py * my + pz * mz)
    of_2 = (ax * mx + ay * my + az * mz) + (px * lx + py * ly + pz * lz)
    of_3 = ax * lx + ay * ly + az * lz
    return of_0, of_1, of_2, of_3, nx, ny, nz, mx, my, mz, lx, ly, lz


@device
def _to_rows(rows, f, g, h, i, x, y, z):
    if rows.size > 0:
        rows[f, 0], rows[g, 0], rows[h, 0], rows[i, 0] = unpack(x)
        rows[f, 1], rows[g, 1], rows[h, 1], rows[i, 1] = unpack(y)
        rows[f, 2], rows[g, 2], rows[h, 2], rows[i, 2] = unpack(z)


@device
def _to_sums(sums, row, sum_0, sum_1, sum_2, sum_3):
    for number, total in ((0, sum_0), (1, sum_1), (2, sum_2), (3, sum_3)):
        v0, v1, v2, v3 = unpack(total)
        sums[row, number] = (v0 + v1) + (v2 + v3)


@kernel
def _of_triangles(
    starts, ends, points, direction, connectivity, reference, origin, reach, portion, sums, area
):
    # Four at a time. Returns how many are doubtful.
    doubtful = spread(0.0)
    ox = spread(origin[0])
    oy = spread(origin[1])
    oz = spread(origin[2])
    for part in range(starts.size):
        sum_0 = spread(0.0)
        sum_1 = spread(0.0)
        sum_2 = spread(0.0)
        sum_3 = spread(0.0)
        last = ends[part] - 1
        for f in range(starts[part], ends[part], WIDTH):
            # Where fewer are left, the last face takes the places of those that are missing.
            g = min(f + 1, last)
            h = min(f + 2, last)
            i = min(f + 3, last)
            left = pack(0.0, 1.0, 2.0, 3.0) < np.float64(ends[part] - f)
            k0 = np.uintp(connectivity[3 * f])
            k1 = np.uintp(connectivity[3 * g])
            k2 = np.uintp(connectivity[3 * h])
            k3 = np.uintp(connectivity[3 * i])
            px, py, pz = gather(points, k0, k1, k2, k3)
            ax, ay, az = gather(direction, k0, k1, k2, k3)
            k0 = np.uintp(connectivity[3 * f + 1])
            k1 = np.uintp(connectivity[3 * g + 1])
            k2 = np.uintp(connectivity[3 * h + 1])
            k3 = np.uintp(connectivity[3 * i + 1])
            ux, uy, uz = gather(points, k0, k1, k2, k3)
            dx, dy, dz = gather(direction, k0, k1, k2, k3)
            k0 = np.uintp(connectivity[3 * f + 2])
            k1 = np.uintp(connectivity[3 * g + 2])
            k2 = np.uintp(connectivity[3 * h + 2])
            k3 = np.uintp(connectivity[3 * i + 2])
            vx, vy, vz = gather(points, k0, k1, k2, k3)
            ex, ey, ez = gather(direction, k0, k1, k2, k3)
            ux -= px
            uy -= py
            uz -= pz
            vx -= px
            vy -= py
            vz -= pz
            of_0, of_1, of_2, of_3, nx, ny, nz, mx, my, mz, lx, ly, lz = _cubic(
                px - ox, py - oy, pz - oz, ax, ay, az, ux, uy, uz, vx, vy, vz,
                dx - ax, dy - ay, dz - az, ex - ax, ey - ay, ez - az,
            )  # fmt: skip
            sum_0 += select(left, of_0, 0.0)
            sum_1 += select(left, of_1, 0.0)
            sum_2 += select(left, of_2, 0.0)
            sum_3 += select(left, of_3, 0.0)
            _to_rows(area, f, g, h, i, nx, ny, nz)
            rx, ry, rz = gather(reference, f, g, h, i)
            slope = mx * rx + my * ry + mz * rz
            bend = lx * rx + ly * ry + lz * rz
            taken = select(slope < 0.0, -slope, slope) + reach * select(bend < 0.0, -bend, bend)
            sides = (ux * ux + uy * uy + uz * uz) + (vx * vx + vy * vy + vz * vz)
            clear = reach * taken + _CLEAR * sides < nx * rx + ny * ry + nz * rz
            doubtful += select(left, select(clear, spread(0.0), 1.0), 0.0)
        _to_sums(sums, starts[part] // portion, sum_0, sum_1, sum_2, sum_3)
    v0, v1, v2, v3 = unpack(doubtful)
    return int(v0 + v1 + v2 + v3)


@device
def _squares(ax, ay, az, bx, by, bz):
    return (bx - ax) * (bx - ax) + (by - ay) * (by - ay) + (bz - az) * (bz - az)


@device
def _fourth(a):
    return (a * a) * (a * a)


@device
def _cross(ax, ay, az, bx, by, bz, nx, ny, nz):
    return nx * (ay * bz - az * by) + ny * (az * bx - ax * bz) + nz * (ax * by - ay * bx)


@device
def _convex(
    x0, y0, z0, x1, y1, z1, x2, y2, z2, x3, y3, z3, a0, b0, c0, a1, b1, c1, a2, b2, c2, a3, b3, c3,
    nx, ny, nz, up, reach,
):  # fmt: skip
    # Without doubt are those that are convex at all corners, seen along their area. With S and W the sums of
    # squares of the sides and of what a unit of the shift changes them by, and t^2 = reach^2 W / S < 0.01,
    # no product of two sides changes by more than (2 t + t^2) S, u x v by no more than (4 t + 2 t^2) S; they
    # are at most S and 2 S. So their product changes by less than 10 t S^2.
    turn = _squares(a0, b0, c0, a1, b1, c1) + _squares(a1, b1, c1, a2, b2, c2)
    turn += _squares(a2, b2, c2, a3, b3, c3) + _squares(a3, b3, c3, a0, b0, c0)
    sides = _squares(x0, y0, z0, x1, y1, z1) + _squares(x1, y1, z1, x2, y2, z2)
    sides += _squares(x2, y2, z2, x3, y3, z3) + _squares(x3, y3, z3, x0, y0, z0)
    # Sides, each in the place of the corner that it begins at.
    sx, sy, sz = x0, y0, z0
    x0, y0, z0 = x1 - x0, y1 - y0, z1 - z0
    x1, y1, z1 = x2 - x1, y2 - y1, z2 - z1
    x2, y2, z2 = x3 - x2, y3 - y2, z3 - z2
    x3, y3, z3 = sx - x3, sy - y3, sz - z3
    least = _cross(x3, y3, z3, x0, y0, z0, nx, ny, nz)
    corner = _cross(x0, y0, z0, x1, y1, z1, nx, ny, nz)
    least = select(corner < least, corner, least)
    corner = _cross(x1, y1, z1, x2, y2, z2, nx, ny, nz)
    least = select(corner < least, corner, least)
    corner = _cross(x2, y2, z2, x3, y3, z3, nx, ny, nz)
    least = select(corner < least, corner, least)
    # Squares of the bounds of changes, in units of S^4 and S^2, and rounding.
    change = reach * reach * turn
    clear = (up > 0.0) & (least > 0.0) & (change < 0.01 * sides)
    clear = clear & (100.0 * change * sides * sides * sides + _ROUNDING * _fourth(sides) < least * least)
    clear = clear & (25.0 * change * sides + _ROUNDING * sides * sides < up * up)
    return clear


@kernel
def _of_quadrilaterals(
    starts, ends, points, direction, connectivity, reference, origin, reach, portion, sums, area
):
    # As _of_triangles. The fan round the mean m of the corners is m . (u x v) with the diagonals u and v.
    doubtful = spread(0.0)
    ox = spread(origin[0])
    oy = spread(origin[1])
    oz = spread(origin[2])
    for part in range(starts.size):
        sum_0 = spread(0.0)
        sum_1 = spread(0.0)
        sum_2 = spread(0.0)
        sum_3 = spread(0.0)
        last = ends[part] - 1
        for f in range(starts[part], ends[part], WIDTH):
            g = min(f + 1, last)
            h = min(f + 2, last)
            i = min(f + 3, last)
            left = pack(0.0, 1.0, 2.0, 3.0) < np.float64(ends[part] - f)
            k0 = np.uintp(connectivity[4 * f])
            k1 = np.uintp(connectivity[4 * g])
            k2 = np.uintp(connectivity[4 * h])
            k3 = np.uintp(connectivity[4 * i])
            x0, y0, z0 = gather(points, k0, k1, k2, k3)
            a0, b0, c0 = gather(direction, k0, k1, k2, k3)
            k0 = np.uintp(connectivity[4 * f + 1])
            k1 = np.uintp(connectivity[4 * g + 1])
            k2 = np.uintp(connectivity[4 * h + 1])
            k3 = np.uintp(connectivity[4 * i + 1])
            x1, y1, z1 = gather(points, k0, k1, k2, k3)
            a1, b1, c1 = gather(direction, k0, k1, k2, k3)
            k0 = np.uintp(connectivity[4 * f + 2])
            k1 = np.uintp(connectivity[4 * g + 2])
            k2 = np.uintp(connectivity[4 * h + 2])
            k3 = np.uintp(connectivity[4 * i + 2])
            x2, y2, z2 = gather(points, k0, k1, k2, k3)
            a2, b2, c2 = gather(direction, k0, k1, k2, k3)
            k0 = np.uintp(connectivity[4 * f + 3])
            k1 = np.uintp(connectivity[4 * g + 3])
            k2 = np.uintp(connectivity[4 * h + 3])
            k3 = np.uintp(connectivity[4 * i + 3])
            x3, y3, z3 = gather(points, k0, k1, k2, k3)
            a3, b3, c3 = gather(direction, k0, k1, k2, k3)
            of_0, of_1, of_2, of_3, nx, ny, nz, _, _, _, _, _, _ = _cubic(
                0.25 * ((x0 + x1) + (x2 + x3)) - ox, 0.25 * ((y0 + y1) + (y2 + y3)) - oy,
                0.25 * ((z0 + z1) + (z2 + z3)) - oz, 0.25 * ((a0 + a1) + (a2 + a3)),
                0.25 * ((b0 + b1) + (b2 + b3)), 0.25 * ((c0 + c1) + (c2 + c3)),
                x2 - x0, y2 - y0, z2 - z0, x3 - x1, y3 - y1, z3 - z1,
                a2 - a0, b2 - b0, c2 - c0, a3 - a1, b3 - b1, c3 - c1,
            )  # fmt: skip
            sum_0 += select(left, of_0, 0.0)
            sum_1 += select(left, of_1, 0.0)
            sum_2 += select(left, of_2, 0.0)
            sum_3 += select(left, of_3, 0.0)
            _to_rows(area, f, g, h, i, nx, ny, nz)
            rx, ry, rz = gather(reference, f, g, h, i)
            clear = _convex(
                x0, y0, z0, x1, y1, z1, x2, y2, z2, x3, y3, z3, a0, b0, c0, a1, b1, c1, a2, b2, c2, a3, b3,
                c3, nx, ny, nz, nx * rx + ny * ry + nz * rz, reach,
            )  # fmt: skip
            doubtful += select(left, select(clear, spread(0.0), 1.0), 0.0)
        _to_sums(sums, starts[part] // portion, sum_0, sum_1, sum_2, sum_3)
    v0, v1, v2, v3 = unpack(doubtful)
    return int(v0 + v1 + v2 + v3)


@kernel
def _of_polygons(starts, ends, points, direction, offsets, connectivity, origin, portion, sums, area):
    # As _of_triangles, for faces of any size, none of which is clear of doubt.
    for part in range(starts.size):
        row = starts[part] // portion
        for number in range(4):
            sums[row, number] = 0.0
        for f in range(starts[part], ends[part]):
            first = offsets[f]
            size = max(offsets[f + 1] - first, 1)
            px = 0.0
            py = 0.0
            pz = 0.0
            ax = 0.0
            ay = 0.0
            az = 0.0
            for c in range(first, offsets[f + 1]):
                v = connectivity[c]
                px += points[v, 0] / size
                py += points[v, 1] / size
                pz += points[v, 2] / size
                ax += direction[v, 0] / size
                ay += direction[v, 1] / size
                az += direction[v, 2] / size
            tx = 0.0
            ty = 0.0
            tz = 0.0
            w = connectivity[first + size - 1]
            for c in range(first, first + size if size > 2 else first):
                v = w
                w = connectivity[c]
                of_0, of_1, of_2, of_3, nx, ny, nz, _, _, _, _, _, _ = _cubic(
                    px - origin[0], py - origin[1], pz - origin[2], ax, ay, az,
                    points[v, 0] - px, points[v, 1] - py, points[v, 2] - pz,
                    points[w, 0] - px, points[w, 1] - py, points[w, 2] - pz,
                    direction[v, 0] - ax, direction[v, 1] - ay, direction[v, 2] - az,
                    direction[w, 0] - ax, direction[w, 1] - ay, direction[w, 2] - az,
                )  # fmt: skip
                sums[row, 0] += of_0
                sums[row, 1] += of_1
                sums[row, 2] += of_2
                sums[row, 3] += of_3
                tx += nx
                ty += ny
                tz += nz
            if area.size > 0:
                area[f, 0] = tx
                area[f, 1] = ty
                area[f, 2] = tz
    return ends[ends.size - 1] - starts[0]


def shifted_volume(
    mesh: Mesh, points: Float64, direction: Float64, reference: npt.NDArray[np.float32], origin: Float64,
    reach: float, area: Float64,
) -> tuple[Float64, int]:  # fmt: skip
    """Return the volume of a mesh as a function of a shift of all its vertices, O(faces).

    The volume is that of the cones from `origin` over the faces, polygons being fans round their corners'
    mean: the enclosed volume of a closed mesh; of an open one its change is the swept volume, as long as the
    boundary does not move.

    Parameters
    ----------
    mesh : Mesh
        Its faces count.
    points : (n, 3) float64
        Its vertices.
    direction : (n, 3) float64
        Along which each vertex shifts, per unit of the shift.
    reference : (m, 3) float32
        Frozen direction of each face, see
        :func:`~vtksmooth.kernels.measures.aspect_ratio.reference_directions`.
    origin : (3,) float64
        Near the mesh, for the sake of rounding.
    reach : float
        Size of shifts up to which triangles are looked at for inversion.
    area : (m, 3) float64
        Becomes twice the area vectors of the faces, without a shift; may be empty.

    Returns
    -------
    coefficients : (4,) float64
        c of the volume ``c[0] + c[1] s + c[2] s^2 + c[3] s^3``.
    doubtful : int
        How many faces are inverted, or may be after a shift of at most `reach`: 0 says that none is. Polygons
        with more than three corners are always in doubt.
    """
    starts, ends = parallel.ranges(mesh.n_faces)
    if not len(starts):
        return np.zeros(4), 0
    sums = np.empty((len(starts), 4))
    portion = int(ends[0])
    of_one_size = _of_triangles if mesh.only_triangles else _of_quadrilaterals
    if mesh.only_triangles or mesh.only_quadrilaterals:
        doubtful = parallel.run(
            of_one_size, starts, ends, points, direction, mesh.connectivity, reference, origin,
            reach, portion, sums, area,
        )  # fmt: skip
    else:
        doubtful = parallel.run(
            _of_polygons, starts, ends, points, direction, mesh.offsets, mesh.connectivity, origin,
            portion, sums, area,
        )  # fmt: skip
    # Summed range by range: then the sum does not depend on the number of threads.
    return sums.sum(axis=0) / 6.0, sum(doubtful)
