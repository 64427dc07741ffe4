"""Face normals, the edges round a vertex, and the dihedral angles between their faces."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ...jit import parallel
from ...jit.compiled import device, kernel
from ...jit.simd import WIDTH, absolute, gather, select, square_root, unpack
from ..mesh.mesh import Mesh
from .aspect_ratio import area_vector

Float64 = npt.NDArray[np.float64]

#: Up to this valence neighbours are searched for one by one, which stays in registers.
_FEW = 32


@device
def _made_unit(x, y, z):
    # A vector's direction and its length, of numbers or of lanes; zeros where it is 0. By the largest
    # component first: squares of areas would leave the range of float64.
    largest = absolute(x)
    largest = select(largest > absolute(y), largest, absolute(y))
    largest = select(largest > absolute(z), largest, absolute(z))
    scale = select(largest > 0.0, largest, 1.0)
    x = x / scale
    y = y / scale
    z = z / scale
    length = square_root(x * x + y * y + z * z)
    scale = select(length > 0.0, length, 1.0)
    return x / scale, y / scale, z / scale, largest * length


@device
def unit_normal(points, offsets, connectivity, f):
    """Return the unit normal of face f and its area; zeros where it has none."""
    x, y, z = area_vector(points, offsets, connectivity, f)
    return _made_unit(x, y, z)


@device
def _corners(connectivity, c):
    # Corner c, and those at its place in the next three triangles.
    return (
        np.uintp(connectivity[c]),
        np.uintp(connectivity[c + 3]),
        np.uintp(connectivity[c + 6]),
        np.uintp(connectivity[c + 9]),
    )


@kernel
def _face_normals(starts, ends, points, offsets, connectivity, normals):
    for part in range(starts.size):
        f = starts[part]
        while f < ends[part]:
            triangles = f + WIDTH <= ends[part]
            for i in range(WIDTH if triangles else 0):
                triangles = triangles and offsets[f + i + 1] - offsets[f + i] == 3
            if not triangles:
                normals[f, 0], normals[f, 1], normals[f, 2], normals[f, 3] = unit_normal(
                    points, offsets, connectivity, f
                )
                f += 1
                continue
            # Four triangles at a time, with the same bits.
            c = offsets[f]
            ox, oy, oz = gather(points, *_corners(connectivity, c))
            px, py, pz = gather(points, *_corners(connectivity, c + 1))
            qx, qy, qz = gather(points, *_corners(connectivity, c + 2))
            ax = px - ox
            ay = py - oy
            az = pz - oz
            bx = qx - ox
            by = qy - oy
            bz = qz - oz
            x, y, z, area = _made_unit(
                0.5 * (ay * bz - az * by), 0.5 * (az * bx - ax * bz), 0.5 * (ax * by - ay * bx)
            )
            normals[f, 0], normals[f + 1, 0], normals[f + 2, 0], normals[f + 3, 0] = unpack(x)
            normals[f, 1], normals[f + 1, 1], normals[f + 2, 1], normals[f + 3, 1] = unpack(y)
            normals[f, 2], normals[f + 1, 2], normals[f + 2, 2], normals[f + 3, 2] = unpack(z)
            normals[f, 3], normals[f + 1, 3], normals[f + 2, 3], normals[f + 3, 3] = unpack(area)
            f += WIDTH


def face_normals(mesh: Mesh, normals: Float64 | None = None) -> Float64:
    """Return each face's unit normal and its area, (m, 4); a face without an area has the normal 0.

    They are written to `normals` where it is given.
    """
    if normals is None:
        normals = np.empty((mesh.n_faces, 4))
    parallel.run(
        _face_normals, *parallel.ranges(mesh.n_faces),
        mesh.points, mesh.offsets, mesh.connectivity, normals,
    )  # fmt: skip
    return normals


@device
def _faces_of_edges(near, v, place, faces, count):
    """Find the faces at each edge of v, in the order of its one-ring.

    Parameters
    ----------
    near : Adjacency
    v : int
    place : (n,) int32
        Scratch, whatever its content; needed for valences above `_FEW` only.
    faces : (valence, 2) int32
        Takes the two faces of every edge that has two, the smaller first; the second as -1 - f where the
        two disagree on the orientation.
    count : (valence,) int32
        Takes how many faces each edge has.
    """
    ring = near.ring_offsets[v]
    size = near.ring_offsets[v + 1] - ring
    for r in range(size):
        if size > _FEW:
            place[near.ring[ring + r]] = r
        count[r] = 0
    for row in range(near.corner_offsets[v], near.corner_offsets[v + 1]):
        c = near.corners[row]
        f = near.corner_face[c]
        first = near.offsets[f]
        last = near.offsets[f + 1]
        for side in range(2):
            if side == 0:
                w = near.connectivity[c + 1 if c + 1 < last else first]
            else:
                w = near.connectivity[c - 1 if c > first else last - 1]
            if w == v:
                continue
            r = 0
            if size > _FEW:
                r = place[w]
            else:
                while near.ring[ring + r] != w:
                    r += 1
            # Faces come in rising order. The side is kept as a sign until both are there.
            if count[r] == 0:
                faces[r, 0] = f if side == 0 else -1 - f
            elif count[r] == 1:
                one = faces[r, 0]
                faces[r, 0] = one if one >= 0 else -1 - one
                faces[r, 1] = f if (one >= 0) != (side == 0) else -1 - f
            count[r] += 1


@device
def _dihedral_angle(normals, f, g):
    """Return the angle between the normals of two faces, radians; g as `_faces_of_edges` gives it.

    0 where one of the faces has no area.
    """
    turn = 1.0
    if g < 0:
        g = -1 - g
        turn = -1.0
    dot = 0.0
    square = 0.0
    for axis in range(3):
        a = normals[f, axis]
        b = turn * normals[g, axis]
        dot += a * b
        square += (a - b) * (a - b)
    if dot > 0.5:  # good for small angles too
        return 2.0 * np.arcsin(0.5 * np.sqrt(square))
    # Without a normal the square is 1 or 0; otherwise it is 2 - 2 dot.
    return 0.0 if dot == 0.0 and square < 1.5 else np.arccos(max(-1.0, dot))


@device
def _is_flat(near, normals, v, cosine):
    # Whether the normals round v lie in a cone round their mean.
    x = 0.0
    y = 0.0
    z = 0.0
    first = near.corner_offsets[v]
    last = near.corner_offsets[v + 1]
    for row in range(first, last):
        f = near.corner_face[near.corners[row]]
        x += normals[f, 0]
        y += normals[f, 1]
        z += normals[f, 2]
    limit = cosine * np.sqrt(x * x + y * y + z * z)
    for row in range(first, last):
        f = near.corner_face[near.corners[row]]
        along = x * normals[f, 0] + y * normals[f, 1] + z * normals[f, 2]
        if along <= limit and normals[f, 3] > 0.0:
            return False
    return True


@kernel
def measure_edges(starts, ends, near, normals, cosine, kind, angle, bent):
    """Look at the edges round each vertex.

    Parameters
    ----------
    starts, ends : (r,) int64
        Ranges of vertices.
    near : Adjacency
    normals : (m, 4) float64
        From :func:`face_normals`.
    cosine : float
        Of the half angle of a cone: a vertex with faces on all sides whose normals lie in one is not looked
        at. Above 1: all are.
    kind : (h,) uint8
        Takes for each place in the one-rings how many faces the edge has: 0 two, 1 one, 2 more; 0 at vertices
        that are not looked at.
    angle : (h,) float32
        Takes the dihedral angle where there are two faces, 0 at vertices that are not looked at.
    bent : (n,) uint8
        Takes 1 for each vertex that was looked at, and 0.
    """
    place = np.empty(0, np.int32)
    faces = np.empty((_FEW, 2), np.int32)
    count = np.empty(_FEW, np.int32)
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            ring = near.ring_offsets[v]
            size = near.ring_offsets[v + 1] - ring
            for r in range(ring, ring + size):
                kind[r] = 0
                angle[r] = 0.0
            bent[v] = near.kinds[v] != 3 and not (near.kinds[v] == 0 and _is_flat(near, normals, v, cosine))
            if not bent[v]:
                continue
            if size > count.size:
                place = np.empty(near.kinds.size, np.int32)
                faces = np.empty((2 * size, 2), np.int32)
                count = np.empty(2 * size, np.int32)
            _faces_of_edges(near, v, place, faces, count)
            for r in range(size):
                kind[ring + r] = 0 if count[r] == 2 else (1 if count[r] == 1 else 2)
                if count[r] == 2:
                    angle[ring + r] = _dihedral_angle(normals, faces[r, 0], faces[r, 1])
