"""The volume of a mesh whose vertices shift along directions, all by the same distance: a cubic in it.

Six times the volume is ``T(P, P, P)``, T linear and symmetric in its three places. What a shift s along D
makes of it, ``T(P, P, P) + 3 s T(P, P, D) + 3 s^2 T(P, D, D) + s^3 T(D, D, D)``, is needed for many P and few
D: so what D alone says is computed once. ``3 T(P, P, D)`` is a sum over faces of products of their area
vectors with sums of D over their corners, ``3 T(P, D, D)`` the product of P with a gradient. Both are so only
where the faces round each vertex that shifts close up; elsewhere the cones over the faces are expanded one by
one.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ...jit import parallel
from ...jit.compiled import device, kernel
from ...jit.simd import WIDTH, gather, load, pack, select, spread, unpack
from ..mesh.adjacency import Adjacency
from ..mesh.mesh import Mesh

Float64 = npt.NDArray[np.float64]
UInt8 = npt.NDArray[np.uint8]

#: Part of the squares of its sides by which a triangle's area must be clear of 0 to be no doubtful one.
_CLEAR = 1e-12

#: Square of that of quadrilaterals.
_ROUNDING = 1e-24

#: What is kept of the directions for each triangle and quadrilateral, see the kernels that write it.
_KEPT = {3: 4, 4: 10}


@device
def _to_rows(rows, f, g, h, i, x, y, z):
    if rows.size > 0:
        rows[f, 0], rows[g, 0], rows[h, 0], rows[i, 0] = unpack(x)
        rows[f, 1], rows[g, 1], rows[h, 1], rows[i, 1] = unpack(y)
        rows[f, 2], rows[g, 2], rows[h, 2], rows[i, 2] = unpack(z)


@device
def _to_sums(sums, row, sum_0, sum_1):
    for number, total in ((0, sum_0), (1, sum_1)):
        v0, v1, v2, v3 = unpack(total)
        sums[row, number] = (v0 + v1) + (v2 + v3)


@device
def _across(vectors, i, j, k, m):
    # (v_j - v_i) x (v_m - v_k)
    ux = vectors[j, 0] - vectors[i, 0]
    uy = vectors[j, 1] - vectors[i, 1]
    uz = vectors[j, 2] - vectors[i, 2]
    wx = vectors[m, 0] - vectors[k, 0]
    wy = vectors[m, 1] - vectors[k, 1]
    wz = vectors[m, 2] - vectors[k, 2]
    return uy * wz - uz * wy, uz * wx - ux * wz, ux * wy - uy * wx


@device
def _turn(direction, i, j):
    x = direction[j, 0] - direction[i, 0]
    y = direction[j, 1] - direction[i, 1]
    z = direction[j, 2] - direction[i, 2]
    return x * x + y * y + z * z


@kernel
def _keep_of_triangles(starts, ends, direction, connectivity, kept, share):
    # kept: the sum of the corners' directions, and the larger square of what two sides change by; four faces
    # side by side. share: the share of each face in the gradients at its corners.
    for part in range(starts.size):
        for f in range(starts[part], ends[part]):
            i = connectivity[3 * f]
            j = connectivity[3 * f + 1]
            k = connectivity[3 * f + 2]
            row = f // WIDTH * 4
            lane = f % WIDTH
            for axis in range(3):
                kept[row + axis, lane] = direction[i, axis] + direction[j, axis] + direction[k, axis]
            kept[row + 3, lane] = max(_turn(direction, i, j), _turn(direction, i, k))
            share[f, 0], share[f, 1], share[f, 2] = _across(direction, i, j, i, k)


@kernel
def _keep_of_quadrilaterals(starts, ends, direction, connectivity, kept, share):
    # As _keep_of_triangles; a shift changes the volume by half the product of the corners' directions with
    # the area vector n and that of the corner, c. At opposite corners these add up to n: what is kept belongs
    # to n, to the first and to the second corner, and is the sum of the squares of what four sides change by.
    for part in range(starts.size):
        for f in range(starts[part], ends[part]):
            row = f // WIDTH * 10
            lane = f % WIDTH
            i = connectivity[4 * f]
            j = connectivity[4 * f + 1]
            k = connectivity[4 * f + 2]
            m = connectivity[4 * f + 3]
            for axis in range(3):
                a = 0.5 * direction[i, axis]
                b = 0.5 * direction[j, axis]
                c = 0.5 * direction[k, axis]
                d = 0.5 * direction[m, axis]
                kept[row + axis, lane] = (a + b) + 2.0 * (c + d)
                kept[row + 3 + axis, lane] = a - c
                kept[row + 6 + axis, lane] = b - d
            kept[row + 9, lane] = (_turn(direction, i, j) + _turn(direction, j, k)) + (
                _turn(direction, k, m) + _turn(direction, m, i)
            )
            nx, ny, nz = _across(direction, i, k, j, m)
            for corner in range(4):
                x, y, z = _across(direction, i, j, i, m)
                share[4 * f + corner, 0] = 0.5 * (nx + x)
                share[4 * f + corner, 1] = 0.5 * (ny + y)
                share[4 * f + corner, 2] = 0.5 * (nz + z)
                i, j, k, m = j, k, m, i


@kernel
def _sum_round(starts, ends, near, corners, vectors, unit, pinned, sums):
    # Sums of one vector for each `corners` corners, those of one face, or 1; 0 corners: of faces of any size.
    # As unit vectors if asked for; 0 at `pinned` vertices.
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            x = 0.0
            y = 0.0
            z = 0.0
            for row in range(near.corner_offsets[v], 0 if pinned[v] else near.corner_offsets[v + 1]):
                c = np.uint32(near.corners[row])
                f = c
                if corners == 3:
                    f = c // np.uint32(3)
                elif corners == 0:
                    f = np.uint32(near.corner_face[c])
                x += vectors[f, 0]
                y += vectors[f, 1]
                z += vectors[f, 2]
            scale = 1.0
            if unit:
                length = np.sqrt(x * x + y * y + z * z)
                scale = 1.0 / length if length > 0.0 else 0.0
            sums[v, 0] = scale * x
            sums[v, 1] = scale * y
            sums[v, 2] = scale * z


@kernel
def _products(starts, ends, points, origin, gradient, portion, sums):
    for part in range(starts.size):
        along_x = 0.0
        along_y = 0.0
        along_z = 0.0
        for v in range(starts[part], ends[part]):
            x = gradient[v, 0]
            y = gradient[v, 1]
            z = gradient[v, 2]
            if x != 0.0 or y != 0.0 or z != 0.0:  # points that no face uses may be NaN
                along_x += (points[v, 0] - origin[0]) * x
                along_y += (points[v, 1] - origin[1]) * y
                along_z += (points[v, 2] - origin[2]) * z
        sums[starts[part] // portion] = along_x + along_y + along_z


@kernel
def _of_triangles(starts, ends, points, connectivity, kept, reference, origin, reach, portion, sums, area):
    # Four at a time: ranges begin at multiples of four. Returns how many are doubtful.
    doubtful = spread(0.0)
    ox = spread(origin[0])
    oy = spread(origin[1])
    oz = spread(origin[2])
    for part in range(starts.size):
        sum_0 = spread(0.0)
        sum_1 = spread(0.0)
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
            k0 = np.uintp(connectivity[3 * f + 1])
            k1 = np.uintp(connectivity[3 * g + 1])
            k2 = np.uintp(connectivity[3 * h + 1])
            k3 = np.uintp(connectivity[3 * i + 1])
            ux, uy, uz = gather(points, k0, k1, k2, k3)
            k0 = np.uintp(connectivity[3 * f + 2])
            k1 = np.uintp(connectivity[3 * g + 2])
            k2 = np.uintp(connectivity[3 * h + 2])
            k3 = np.uintp(connectivity[3 * i + 2])
            vx, vy, vz = gather(points, k0, k1, k2, k3)
            ux -= px
            uy -= py
            uz -= pz
            vx -= px
            vy -= py
            vz -= pz
            nx = uy * vz - uz * vy
            ny = uz * vx - ux * vz
            nz = ux * vy - uy * vx
            sum_0 += select(left, (px - ox) * nx + (py - oy) * ny + (pz - oz) * nz, 0.0)
            row = f // WIDTH * 4
            slope = nx * load(kept, row) + ny * load(kept, row + 1) + nz * load(kept, row + 2)
            sum_1 += select(left, slope, 0.0)
            _to_rows(area, f, g, h, i, nx, ny, nz)
            rx, ry, rz = gather(reference, f, g, h, i)
            # With t^2 the larger square of what u and v change by, u x v changes by no more than
            # t (|u| + |v|) + t^2, and (|u| + |v|)^2 <= 2 (|u|^2 + |v|^2).
            change = reach * reach * load(kept, row + 3)
            sides = (ux * ux + uy * uy + uz * uz) + (vx * vx + vy * vy + vz * vz)
            spare = nx * rx + ny * ry + nz * rz - change - _CLEAR * sides
            clear = (spare > 0.0) & (spare * spare > 2.0 * change * sides)
            doubtful += select(left, select(clear, spread(0.0), 1.0), 0.0)
        _to_sums(sums, starts[part] // portion, sum_0, sum_1)
    v0, v1, v2, v3 = unpack(doubtful)
    return int(v0 + v1 + v2 + v3)


@kernel
def _of_quadrilaterals(
    starts, ends, points, connectivity, kept, reference, origin, reach, portion, sums, area
):
    # As _of_triangles. The fan round the mean m of the corners is m . (u x v) with the diagonals u and v.
    doubtful = spread(0.0)
    ox = spread(origin[0])
    oy = spread(origin[1])
    oz = spread(origin[2])
    for part in range(starts.size):
        sum_0 = spread(0.0)
        sum_1 = spread(0.0)
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
            k0 = np.uintp(connectivity[4 * f + 1])
            k1 = np.uintp(connectivity[4 * g + 1])
            k2 = np.uintp(connectivity[4 * h + 1])
            k3 = np.uintp(connectivity[4 * i + 1])
            x1, y1, z1 = gather(points, k0, k1, k2, k3)
            k0 = np.uintp(connectivity[4 * f + 2])
            k1 = np.uintp(connectivity[4 * g + 2])
            k2 = np.uintp(connectivity[4 * h + 2])
            k3 = np.uintp(connectivity[4 * i + 2])
            x2, y2, z2 = gather(points, k0, k1, k2, k3)
            k0 = np.uintp(connectivity[4 * f + 3])
            k1 = np.uintp(connectivity[4 * g + 3])
            k2 = np.uintp(connectivity[4 * h + 3])
            k3 = np.uintp(connectivity[4 * i + 3])
            x3, y3, z3 = gather(points, k0, k1, k2, k3)
            mx = 0.25 * ((x0 + x1) + (x2 + x3)) - ox
            my = 0.25 * ((y0 + y1) + (y2 + y3)) - oy
            mz = 0.25 * ((z0 + z1) + (z2 + z3)) - oz
            # Sides, each in the place of the corner that it begins at.
            fx, fy, fz = x0, y0, z0
            x0, y0, z0 = x1 - x0, y1 - y0, z1 - z0
            x1, y1, z1 = x2 - x1, y2 - y1, z2 - z1
            x2, y2, z2 = x3 - x2, y3 - y2, z3 - z2
            x3, y3, z3 = fx - x3, fy - y3, fz - z3
            # Of the first and the second corner, and of the diagonals.
            ax = y3 * z0 - z3 * y0
            ay = z3 * x0 - x3 * z0
            az = x3 * y0 - y3 * x0
            bx = y0 * z1 - z0 * y1
            by = z0 * x1 - x0 * z1
            bz = x0 * y1 - y0 * x1
            nx = (y0 + y1) * (z1 + z2) - (z0 + z1) * (y1 + y2)
            ny = (z0 + z1) * (x1 + x2) - (x0 + x1) * (z1 + z2)
            nz = (x0 + x1) * (y1 + y2) - (y0 + y1) * (x1 + x2)
            sum_0 += select(left, mx * nx + my * ny + mz * nz, 0.0)
            row = f // WIDTH * 10
            slope = nx * load(kept, row) + ny * load(kept, row + 1) + nz * load(kept, row + 2)
            slope += ax * load(kept, row + 3) + ay * load(kept, row + 4) + az * load(kept, row + 5)
            slope += bx * load(kept, row + 6) + by * load(kept, row + 7) + bz * load(kept, row + 8)
            sum_1 += select(left, slope, 0.0)
            _to_rows(area, f, g, h, i, nx, ny, nz)
            rx, ry, rz = gather(reference, f, g, h, i)
            up = nx * rx + ny * ry + nz * rz
            # Without doubt are those that are convex at all corners, seen along their area. With S and W the
            # sums of squares of the sides and of what the shift changes them by, and t^2 = W / S < 0.01, the
            # product of two sides or of the diagonals (whose squares sum to no more than S) is at most S / 2
            # and changes by no more than (t + t^2 / 2) S < 1.05 t S, and u x v times that of a corner by less
            # than (1.05 t + 1.1 t^2) S^2 < 1.2 t S^2.
            change = reach * reach * load(kept, row + 9)
            sides = ((x0 * x0 + y0 * y0 + z0 * z0) + (x1 * x1 + y1 * y1 + z1 * z1)) + (
                (x2 * x2 + y2 * y2 + z2 * z2) + (x3 * x3 + y3 * y3 + z3 * z3)
            )
            # A corner and the one across share n . n.
            whole = nx * nx + ny * ny + nz * nz
            least = nx * ax + ny * ay + nz * az
            least = select(whole - least < least, whole - least, least)
            corner = nx * bx + ny * by + nz * bz
            least = select(corner < least, corner, least)
            least = select(whole - corner < least, whole - corner, least)
            # Squares of the bounds of changes, in units of S^4 and S^2, and rounding.
            square = sides * sides
            clear = (up > 0.0) & (least > 0.0) & (change < 0.01 * sides)
            clear = clear & (1.44 * change * sides * square + _ROUNDING * square * square < least * least)
            clear = clear & (1.44 * change * sides + _ROUNDING * square < up * up)
            doubtful += select(left, select(clear, spread(0.0), 1.0), 0.0)
        _to_sums(sums, starts[part] // portion, sum_0, sum_1)
    v0, v1, v2, v3 = unpack(doubtful)
    return int(v0 + v1 + v2 + v3)


@device
def _cubic(px, py, pz, ax, ay, az, ux, uy, uz, vx, vy, vz, dx, dy, dz, ex, ey, ez):
    """Return the coefficients of ``(p + s a) . ((u + s d) x (v + s e))``, and u x v.

    That is six times the volume of the cone from the origin over a triangle with the corner p and the sides u
    and v, which shift along a, a + d and a + e.
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
    return of_0, of_1, of_2, of_3, nx, ny, nz


@kernel
def _of_polygons(starts, ends, points, direction, offsets, connectivity, origin, portion, sums, area):
    # Of faces of any size, wherever they are: none of them is clear of doubt.
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
                of_0, of_1, of_2, of_3, nx, ny, nz = _cubic(
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


class ShiftedVolume:
    """The volume of a mesh as a function of a shift of all its vertices.

    The volume is that of the cones from `origin` over the faces, polygons being fans round their corners'
    mean: the enclosed volume of a closed mesh; of an open one its change is the swept volume, as long as the
    boundary does not move.

    Parameters
    ----------
    mesh : Mesh
        Its faces count.
    near : Adjacency
    pinned : (n,) uint8
        Vertices that do not shift.
    reference : (m, 3) float32
        Frozen direction of each face, see
        :func:`~vtksmooth.kernels.measures.aspect_ratio.reference_directions`.
    origin : (3,) float64
        Near the mesh, for the sake of rounding.

    Attributes
    ----------
    direction : (n, 3) float64
        Along which the vertices shift, per unit of the shift.
    """

    def __init__(
        self,
        mesh: Mesh,
        near: Adjacency,
        pinned: UInt8,
        reference: npt.NDArray[np.float32],
        origin: Float64,
    ) -> None:
        self.mesh, self.near, self.pinned, self.reference, self.origin = mesh, near, pinned, reference, origin
        self._faces, self._vertices = parallel.ranges(mesh.n_faces), parallel.ranges(mesh.n_points)
        self.direction = np.empty((mesh.n_points, 3))
        #: Corners of each face where the faces close up, otherwise 0.
        self._size = 3 if mesh.only_triangles else (4 if mesh.only_quadrilaterals else 0)
        if near.kinds[pinned == 0].any():
            self._size = 0
        if self._size:
            # Summed range by range: then the sum does not depend on the number of threads.
            self._products = np.empty(len(self._vertices[0]))
            self._kept = np.zeros((-(-mesh.n_faces // WIDTH) * _KEPT[self._size], WIDTH))
            self._share = np.empty((mesh.n_faces if self._size == 3 else len(mesh.connectivity), 3))
            self._gradient = np.empty_like(self.direction)
            self._nobody = np.zeros_like(pinned)

    def along_normals(self, area: Float64) -> None:
        """Shift along the normals of the mesh whose faces have these area vectors, (m, 3), on any scale."""
        self._sum_round(3 if self.mesh.only_triangles else 0, area, True, self.pinned, self.direction)
        self._keep()

    def along(self, direction: Float64) -> None:
        """Shift along `direction`, (n, 3), which is 0 at pinned vertices."""
        self.direction[:] = direction
        self._keep()

    def _keep(self) -> None:
        if not self._size:
            return
        keep = _keep_of_triangles if self._size == 3 else _keep_of_quadrilaterals
        parallel.run(keep, *self._faces, self.direction, self.mesh.connectivity, self._kept, self._share)
        self._sum_round(3 if self._size == 3 else 1, self._share, False, self._nobody, self._gradient)
        self._cube = self._product(self.direction, np.zeros(3)) / 3.0

    def _sum_round(self, corners: int, vectors: Float64, unit: bool, pinned: UInt8, sums: Float64) -> None:
        parallel.run(_sum_round, *self._vertices, self.near, corners, vectors, unit, pinned, sums)

    def _product(self, points: Float64, origin: Float64) -> float:
        portion = int(self._vertices[1][0])
        parallel.run(_products, *self._vertices, points, origin, self._gradient, portion, self._products)
        return float(self._products.sum())

    def __call__(self, points: Float64, reach: float, area: Float64) -> tuple[Float64, int]:
        """Return the volume as a cubic in the shift, O(faces).

        Parameters
        ----------
        points : (n, 3) float64
            The vertices.
        reach : float
            Size of shifts up to which faces are looked at for inversion.
        area : (m, 3) float64
            Becomes twice the area vectors of the faces, without a shift; may be empty.

        Returns
        -------
        coefficients : (4,) float64
            c of the volume ``c[0] + c[1] s + c[2] s^2 + c[3] s^3``.
        doubtful : int
            How many faces are inverted, or may be after a shift of at most `reach`: 0 says that none is.
            Faces that are neither all triangles nor all quadrilaterals are always in doubt, and so are all
            where vertices shift round which the faces do not close up.
        """
        mesh, faces = self.mesh, self._faces
        if not len(faces[0]):
            return np.zeros(4), 0
        portion = int(faces[1][0])
        if self._size:
            sums = np.empty((len(faces[0]), 2))
            of_one_size = _of_triangles if self._size == 3 else _of_quadrilaterals
            doubtful = parallel.run(
                of_one_size, *faces, points, mesh.connectivity, self._kept, self.reference, self.origin,
                reach, portion, sums, area,
            )  # fmt: skip
            cubic = np.array([*sums.sum(axis=0), self._product(points, self.origin), self._cube])
        else:
            sums = np.empty((len(faces[0]), 4))
            doubtful = parallel.run(
                _of_polygons, *faces, points, self.direction, mesh.offsets, mesh.connectivity, self.origin,
                portion, sums, area,
            )  # fmt: skip
            cubic = sums.sum(axis=0)
        return cubic / 6.0, sum(doubtful)
