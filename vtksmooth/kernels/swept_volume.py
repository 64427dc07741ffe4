"""The volume that moving faces sweep, and how it answers to the vertices (Jiao, section 3)."""

from __future__ import annotations

from .compiled import device


@device
def mean_normal(ax, ay, az, bx, by, bz, dx, dy, dz, ex, ey, ez, fx, fy, fz):  # type: ignore[no-untyped-def]
    """Twice the area vector of a moving triangle, in the mean over its way.

    With the edges a and b from its first corner and the corners' steps d, e, f:
    ``a x b + (u x b + a x v) / 2 + u x v / 3``, u = e - d, v = f - d.
    """
    ux = ex - dx
    uy = ey - dy
    uz = ez - dz
    vx = fx - dx
    vy = fy - dy
    vz = fz - dz
    nx = ay * bz - az * by + 0.5 * (uy * bz - uz * by + ay * vz - az * vy) + (uy * vz - uz * vy) / 3.0
    ny = az * bx - ax * bz + 0.5 * (uz * bx - ux * bz + az * vx - ax * vz) + (uz * vx - ux * vz) / 3.0
    nz = ax * by - ay * bx + 0.5 * (ux * by - uy * bx + ax * vy - ay * vx) + (ux * vy - uy * vx) / 3.0
    return nx, ny, nz


@device
def sweep_triangle(before, after, p, q, r, swept, at):  # type: ignore[no-untyped-def]
    """Write what the triangle p q r sweeps to ``swept[at : at + 3]``, shared among its corners.

    ``V = (d + e + f) . N / 6`` with N of :func:`mean_normal`: exact with bilinear side patches. Neighbouring
    triangles agree on the patch between them, which the three tetrahedra of Jiao, section 3.2, do not: the
    sum over a closed mesh is the change of its volume. The share of a corner is the integral of the swept
    volume times its shape function, (9): ``(d + (d + e + f)) . N / 24`` for the corner that moves by d.
    """
    x = before[p, 0]
    y = before[p, 1]
    z = before[p, 2]
    dx = after[p, 0] - x
    dy = after[p, 1] - y
    dz = after[p, 2] - z
    ex = after[q, 0] - before[q, 0]
    ey = after[q, 1] - before[q, 1]
    ez = after[q, 2] - before[q, 2]
    fx = after[r, 0] - before[r, 0]
    fy = after[r, 1] - before[r, 1]
    fz = after[r, 2] - before[r, 2]
    nx, ny, nz = mean_normal(
        before[q, 0] - x, before[q, 1] - y, before[q, 2] - z,
        before[r, 0] - x, before[r, 1] - y, before[r, 2] - z,
        dx, dy, dz, ex, ey, ez, fx, fy, fz,
    )  # fmt: skip
    d = (dx * nx + dy * ny + dz * nz) / 24.0
    e = (ex * nx + ey * ny + ez * nz) / 24.0
    f = (fx * nx + fy * ny + fz * nz) / 24.0
    total = d + e + f
    swept[at] = d + total
    swept[at + 1] = e + total
    swept[at + 2] = f + total


@device
def sweep_face(before, after, offsets, connectivity, f, swept):  # type: ignore[no-untyped-def]
    """Write what face f sweeps between two states of the points to its corners in `swept`, (k,).

    A polygon with more than three corners is the fan round its corners' mean, whose share they have in equal
    parts: for a quadrilateral the volumes are those of its bilinear patch. Faces with fewer sweep nothing.
    """
    a = offsets[f]
    size = offsets[f + 1] - a
    if size == 3:
        sweep_triangle(before, after, connectivity[a], connectivity[a + 1], connectivity[a + 2], swept, a)
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
        ex = after[q, 0] - before[q, 0]
        ey = after[q, 1] - before[q, 1]
        ez = after[q, 2] - before[q, 2]
        fx = after[r, 0] - before[r, 0]
        fy = after[r, 1] - before[r, 1]
        fz = after[r, 2] - before[r, 2]
        nx, ny, nz = mean_normal(
            before[q, 0] - mx, before[q, 1] - my, before[q, 2] - mz,
            before[r, 0] - mx, before[r, 1] - my, before[r, 2] - mz,
            dx, dy, dz, ex, ey, ez, fx, fy, fz,
        )  # fmt: skip
        d = (dx * nx + dy * ny + dz * nz) / 24.0
        e = (ex * nx + ey * ny + ez * nz) / 24.0
        g = (fx * nx + fy * ny + fz * nz) / 24.0
        total = d + e + g
        middle += d + total
        swept[c] += e + total
        swept[following] += g + total
    for c in range(a, a + size):
        swept[c] += middle / size


@device
def volume_gradient(points, near, v):  # type: ignore[no-untyped-def]
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
