"""The volume that moving faces sweep, and how it answers to the vertices (Jiao, section 3)."""

from __future__ import annotations

from ...jit.compiled import device

#: The factors in N / 24 of :func:`triangle_shares`.
_HALF, _SIXTH = 0.5 / 24.0, 1.0 / 6.0 / 24.0


@device
def triangle_shares(ax, ay, az, bx, by, bz, px, py, pz, qx, qy, qz, dx, dy, dz, ex, ey, ez, fx, fy, fz):
    """Return what a moving triangle sweeps, shared among its corners; of numbers or of lanes.

    a and b are its sides from the first corner before, p and q after; d, e and f the steps of its corners.

    ``V = (d + e + f) . N / 6`` with twice the area vector in the mean over the way,
    ``N = (a x b + p x q) / 2 - u x v / 6``, u = e - d, v = f - d: exact with bilinear side patches.
    Neighbouring triangles agree on the patch between them, which the three tetrahedra of Jiao, section 3.2,
    do not: the sum over a closed mesh is the change of its volume. The share of a corner is the integral of
    the swept volume times its shape function, (9): ``(d + (d + e + f)) . N / 24`` for the corner that moves
    by d.
    """
    ux = ex - dx
    uy = ey - dy
    uz = ez - dz
    vx = fx - dx
    vy = fy - dy
    vz = fz - dz
    # N / 24
    nx = _HALF * ((ay * bz - az * by) + (py * qz - pz * qy)) - _SIXTH * (uy * vz - uz * vy)
    ny = _HALF * ((az * bx - ax * bz) + (pz * qx - px * qz)) - _SIXTH * (uz * vx - ux * vz)
    nz = _HALF * ((ax * by - ay * bx) + (px * qy - py * qx)) - _SIXTH * (ux * vy - uy * vx)
    of_d = dx * nx + dy * ny + dz * nz
    of_e = ex * nx + ey * ny + ez * nz
    of_f = fx * nx + fy * ny + fz * nz
    total = of_d + of_e + of_f
    return of_d + total, of_e + total, of_f + total


@device
def _sweep_triangle(before, after, p, q, r, swept, at):
    # Write the shares of the triangle p q r to ``swept[at : at + 3]``.
    swept[at], swept[at + 1], swept[at + 2] = triangle_shares(
        before[q, 0] - before[p, 0], before[q, 1] - before[p, 1], before[q, 2] - before[p, 2],
        before[r, 0] - before[p, 0], before[r, 1] - before[p, 1], before[r, 2] - before[p, 2],
        after[q, 0] - after[p, 0], after[q, 1] - after[p, 1], after[q, 2] - after[p, 2],
        after[r, 0] - after[p, 0], after[r, 1] - after[p, 1], after[r, 2] - after[p, 2],
        after[p, 0] - before[p, 0], after[p, 1] - before[p, 1], after[p, 2] - before[p, 2],
        after[q, 0] - before[q, 0], after[q, 1] - before[q, 1], after[q, 2] - before[q, 2],
        after[r, 0] - before[r, 0], after[r, 1] - before[r, 1], after[r, 2] - before[r, 2],
    )  # fmt: skip


@device
def sweep_face(before, after, offsets, connectivity, f, swept):
    """Write what face f sweeps between two states of the points to its corners in `swept`, (k,).

    A polygon with more than three corners is the fan round its corners' mean, whose share they have in equal
    parts: for a quadrilateral the volumes are those of its bilinear patch. Faces with fewer sweep nothing.
    """
    a = offsets[f]
    size = offsets[f + 1] - a
    if size == 3:
        _sweep_triangle(before, after, connectivity[a], connectivity[a + 1], connectivity[a + 2], swept, a)
        return
    for c in range(a, a + size):
        swept[c] = 0.0
    if size < 3:
        return
    mx = 0.0
    my = 0.0
    mz = 0.0
    dx = 0.0
    dy = 0.0
    dz = 0.0
    for c in range(a, a + size):
        p = connectivity[c]
        mx += before[p, 0] / size
        my += before[p, 1] / size
        mz += before[p, 2] / size
        dx += (after[p, 0] - before[p, 0]) / size
        dy += (after[p, 1] - before[p, 1]) / size
        dz += (after[p, 2] - before[p, 2]) / size
    middle = 0.0
    for c in range(a, a + size):
        following = c + 1 if c + 1 < a + size else a
        q = connectivity[c]
        r = connectivity[following]
        of_middle, of_q, of_r = triangle_shares(
            before[q, 0] - mx, before[q, 1] - my, before[q, 2] - mz,
            before[r, 0] - mx, before[r, 1] - my, before[r, 2] - mz,
            after[q, 0] - mx - dx, after[q, 1] - my - dy, after[q, 2] - mz - dz,
            after[r, 0] - mx - dx, after[r, 1] - my - dy, after[r, 2] - mz - dz,
            dx, dy, dz,
            after[q, 0] - before[q, 0], after[q, 1] - before[q, 1], after[q, 2] - before[q, 2],
            after[r, 0] - before[r, 0], after[r, 1] - before[r, 1], after[r, 2] - before[r, 2],
        )  # fmt: skip
        middle += of_middle
        swept[c] += of_q
        swept[following] += of_r
    for c in range(a, a + size):
        swept[c] += middle / size


@device
def volume_gradient(points, near, v):
    """Return the volume that the faces round v sweep per step of v alone: exact for steps of any size.

    One third of the sum of the area vectors where all faces are triangles.
    """
    gx = 0.0
    gy = 0.0
    gz = 0.0
    for row in range(near.corner_offsets[v], near.corner_offsets[v + 1]):
        c = near.corners[row]
        f = near.corner_face[c]
        a = near.offsets[f]
        size = near.offsets[f + 1] - a
        if size < 3:
            continue
        if size == 3:
            p = near.connectivity[a]
            q = near.connectivity[a + 1]
            r = near.connectivity[a + 2]
            ux = points[q, 0] - points[p, 0]
            uy = points[q, 1] - points[p, 1]
            uz = points[q, 2] - points[p, 2]
            vx = points[r, 0] - points[p, 0]
            vy = points[r, 1] - points[p, 1]
            vz = points[r, 2] - points[p, 2]
            gx += uy * vz - uz * vy
            gy += uz * vx - ux * vz
            gz += ux * vy - uy * vx
            continue
        # The middle moves by 1 / size of the step: all triangles of the fan; v itself: its two.
        mx = 0.0
        my = 0.0
        mz = 0.0
        for k in range(a, a + size):
            p = near.connectivity[k]
            mx += points[p, 0] / size
            my += points[p, 1] / size
            mz += points[p, 2] / size
        for k in range(size):
            q = near.connectivity[a + k]
            r = near.connectivity[a + (k + 1) % size]
            weight = 1.0 / size
            if a + k == c or a + (k + 1) % size == c:
                weight += 1.0
            ux = points[q, 0] - mx
            uy = points[q, 1] - my
            uz = points[q, 2] - mz
            vx = points[r, 0] - mx
            vy = points[r, 1] - my
            vz = points[r, 2] - mz
            gx += weight * (uy * vz - uz * vy)
            gy += weight * (uz * vx - ux * vz)
            gz += weight * (ux * vy - uy * vx)
    return gx / 6.0, gy / 6.0, gz / 6.0
