"""What smoothing changed: normals, dihedral angles, volume, deviation (Semenova et al., section 4)."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ...jit import parallel
from ...jit.compiled import device, kernel
from ..mesh.adjacency import BOUNDARY, NON_MANIFOLD, Adjacency
from ..mesh.mesh import Mesh
from .aspect_ratio import area_vector, area_vectors, ring_normals
from .swept_volume import sweep_face

Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]


@device
def angle_between(ax, ay, az, bx, by, bz):
    """Angle between two vectors, radians, good for small angles too; 0 if one of them vanishes."""
    # Made unit first: squares of cross products of areas would leave the range of float64.
    a = np.sqrt(ax * ax + ay * ay + az * az)
    b = np.sqrt(bx * bx + by * by + bz * bz)
    if a == 0.0 or b == 0.0:
        return 0.0
    ax /= a
    ay /= a
    az /= a
    bx /= b
    by /= b
    bz /= b
    nx = ay * bz - az * by
    ny = az * bx - ax * bz
    nz = ax * by - ay * bx
    return np.arctan2(np.sqrt(nx * nx + ny * ny + nz * nz), ax * bx + ay * by + az * bz)


@kernel
def _angles_between(starts, ends, a, b, degrees):
    for part in range(starts.size):
        for i in range(starts[part], ends[part]):
            degrees[i] = np.degrees(angle_between(a[i, 0], a[i, 1], a[i, 2], b[i, 0], b[i, 1], b[i, 2]))


@device
def dihedral_angle(ax, ay, az, bx, by, bz, ex, ey, ez):
    """Signed angle between the normals a and b of two faces, radians, convex > 0.

    Their edge runs along e in the first face.
    """
    angle = angle_between(ax, ay, az, bx, by, bz)
    # Convex if turning from a to b goes along the edge.
    along = (ay * bz - az * by) * ex + (az * bx - ax * bz) * ey + (ax * by - ay * bx) * ez
    return angle if along >= 0.0 else -angle


@kernel
def _dihedral_angles(starts, ends, points, edge_ends, edge_faces, area, degrees):
    for part in range(starts.size):
        for e in range(starts[part], ends[part]):
            f = edge_faces[e, 0]
            g = edge_faces[e, 1]
            degrees[e] = 0.0
            if f < 0 or g < 0:
                continue
            p = edge_ends[e, 0]
            q = edge_ends[e, 1]
            angle = dihedral_angle(
                area[f, 0], area[f, 1], area[f, 2], area[g, 0], area[g, 1], area[g, 2],
                points[q, 0] - points[p, 0], points[q, 1] - points[p, 1], points[q, 2] - points[p, 2],
            )  # fmt: skip
            degrees[e] = np.degrees(angle)


@kernel
def _volumes(starts, ends, points, offsets, connectivity, origin, volumes):
    # Pyramid over each face with its tip at `origin`. A face with more than three corners is the fan
    # round the mean of its corners; for a quadrilateral that is the volume under its bilinear patch. Whatever
    # the origin, areas come from differences of corners: products of places would cancel, digit by digit.
    for part in range(starts.size):
        for f in range(starts[part], ends[part]):
            a = offsets[f]
            size = offsets[f + 1] - a
            volumes[f] = 0.0
            if size < 3:
                continue
            mx = 0.0
            my = 0.0
            mz = 0.0
            for c in range(a, a + size):
                p = connectivity[c]
                mx += points[p, 0] - origin[0]
                my += points[p, 1] - origin[1]
                mz += points[p, 2] - origin[2]
            nx, ny, nz = area_vector(points, offsets, connectivity, f)
            volumes[f] = (mx * nx + my * ny + mz * nz) / (3.0 * size)


@kernel
def _swept_volumes(starts, ends, before, after, offsets, connectivity, swept):
    for part in range(starts.size):
        for f in range(starts[part], ends[part]):
            sweep_face(before, after, offsets, connectivity, f, swept)


def is_closed(near: Adjacency) -> bool:
    """Return whether the faces bound a volume: every edge runs as often back as forth.

    So do those of cells that touch along an edge, where the surface is no manifold.
    """
    if (near.kinds == BOUNDARY).any():
        return False
    # Elsewhere both faces of an edge agree.
    return not _irregular_edges(near)[1].any()


def has_walls(near: Adjacency) -> bool:
    """Return whether walls divide a closed surface into several bodies.

    There three faces or more meet at edges that do not run as often back as forth.
    """
    if (near.kinds == BOUNDARY).any():
        return False
    faces, balance = _irregular_edges(near)
    return bool(((faces > 2) & (balance != 0)).any())


def _irregular_edges(near: Adjacency) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
    """Return how many faces meet at each edge between non-manifold vertices, and how often they run forth."""
    corners = np.flatnonzero(near.kinds[near.connectivity] == NON_MANIFOLD)
    after = corners + 1
    last = after == near.offsets[near.corner_face[corners] + 1]
    after[last] = near.offsets[near.corner_face[corners[last]]]
    start, end = near.connectivity[corners].astype(np.int64), near.connectivity[after].astype(np.int64)
    n = len(near.kinds)
    _, edge = np.unique(np.minimum(start, end) * n + np.maximum(start, end), return_inverse=True)
    both = near.kinds[end] == NON_MANIFOLD
    return np.bincount(edge[both]), np.bincount(edge[both], weights=np.sign(end - start)[both])


def signed_volume(mesh: Mesh) -> float:
    """Return the volume enclosed by a closed mesh, positive if normals point outwards, model units cubed.

    Quadrilaterals count as bilinear patches. For an open mesh the figure depends on the origin and has
    no meaning: use :func:`swept_volume`.
    """
    return float(face_volumes(mesh).sum())


def face_volumes(mesh: Mesh) -> Float64:
    """Return the signed volume of the pyramid over each face, its tip on the mesh, (m,)."""
    volumes = np.empty(mesh.n_faces)
    # From the middle of the mesh: far from the origin nothing cancels.
    used = mesh.points[mesh.connectivity[0]] if len(mesh.connectivity) else np.zeros(3)
    parallel.run(
        _volumes, *parallel.ranges(mesh.n_faces),
        mesh.points, mesh.offsets, mesh.connectivity, used, volumes,
    )  # fmt: skip
    return volumes


def swept_volume(before: Mesh, after: Mesh) -> float:
    """Return the volume that the surface sweeps while its points go from one position to the other.

    For a closed mesh it is the change of the volume; polygons as fans round their corners' mean, see
    :func:`~vtksmooth.kernels.measures.swept_volume.sweep_face`.
    """
    return float(swept_at_corners(before, after).sum())


def swept_at_corners(before: Mesh, after: Mesh) -> Float64:
    """Return each corner's share of the volume that the surface sweeps, as connectivity lists them."""
    swept = np.empty(len(before.connectivity))
    parallel.run(
        _swept_volumes,
        *parallel.ranges(before.n_faces),
        before.points,
        after.points,
        before.offsets,
        before.connectivity,
        swept,
    )
    return swept


def normal_deviation(before: Mesh, after: Mesh) -> Float64:
    """Return the angle between the vertex normals (area-weighted) of two states, (n,), degrees.

    NaN where a normal does not exist in one of them: at points that no face uses, and where all faces
    have lost their areas. :func:`largest_and_mean` leaves those out.
    """
    normals = ring_normals(before), ring_normals(after)
    degrees = np.empty(before.n_points)
    parallel.run(_angles_between, *parallel.ranges(before.n_points), *normals, degrees)
    for state in normals:
        degrees[~state.any(axis=1)] = np.nan
    return degrees


def dihedral_angles(mesh: Mesh, edge_ends: Int32, edge_faces: Int32) -> Float64:
    """Return the signed angle between the two faces' normals at every edge, (e,), degrees.

    Positive at convex edges, negative at concave ones, 0 in the plane and where an edge does not have
    exactly two faces that agree on the orientation. Edges as :func:`~vtksmooth.kernels.mesh.adjacency.edges`
    returns them.
    """
    degrees = np.empty(len(edge_ends))
    parallel.run(
        _dihedral_angles, *parallel.ranges(len(edge_ends)),
        mesh.points, edge_ends, edge_faces, area_vectors(mesh), degrees,
    )  # fmt: skip
    return degrees


def dihedral_change(before: Mesh, after: Mesh, edge_ends: Int32, edge_faces: Int32) -> Float64:
    """Return the absolute change of the dihedral angle at every edge, (e,), degrees in [0, 360).

    NaN where there is no such angle: at edges of the boundary, non-manifold edges, edges whose two faces
    disagree on the orientation, and edges of a face that has no area before or after.
    :func:`largest_and_mean` leaves those out.
    """
    has_normal = np.ones(before.n_faces + 1, dtype=bool)
    has_normal[-1] = False  # the face -1, which is none
    for state in (before, after):
        has_normal[:-1] &= area_vectors(state).any(axis=1)
    change = np.abs(
        dihedral_angles(after, edge_ends, edge_faces) - dihedral_angles(before, edge_ends, edge_faces)
    )
    change[~has_normal[edge_faces].all(axis=1)] = np.nan
    return change


def largest_and_mean(values: Float64) -> tuple[float, float]:
    """Return the maximum and the mean of the values that are not NaN; zeros where there are none.

    Examples
    --------
    >>> largest_and_mean(np.array([1.0, np.nan, 3.0]))
    (3.0, 2.0)
    """
    known = values[~np.isnan(values)]
    return (float(known.max()), float(known.mean())) if len(known) else (0.0, 0.0)
