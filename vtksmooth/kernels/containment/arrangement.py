"""The boundary of a union of solids: faces cut where they cross, and those within other solids left out.

Inside is where a closed surface has a winding number of 1 or more. So a face, or a part of one, bounds the
inside if the number is 0 or less in front of it and 1 or more behind it (Q. Zhou, E. Grinspun, D. Zorin,
A. Jacobson, "Mesh Arrangements for Solid Geometry", 2016, DOI 10.1145/2897824.2925901). What they do in exact
arithmetic is done here within a small distance: parts need not fit together, for the winding number tells
what is inside.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ...errors import InvalidMeshError
from ...jit import parallel
from ...jit.compiled import allocating, device, kernel, routine
from ..distance.closest_point import ClosestPoint
from ..distance.winding_number import WindingNumber
from ..mesh.adjacency import build
from ..mesh.mesh import Mesh, widen
from ..mesh.regions import patches
from .crossings import face_normal, faces_near, longer, no_box, scratch

Bool = npt.NDArray[np.bool_]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]

#: Most corners of a part; one with more is cut in two.
_CORNERS = 24

#: How two faces meet: not at all, the first goes through the second's plane within it, both lie in one plane
#: and overlap, or the first has a side in the second.
_APART, _THROUGH, _OVERLAPPING, _ALONG = 0, 1, 2, 3

#: Faces meet along more than this many times the distance that counts as none: with a common corner, in which
#: they end at an angle, they seem to over some of it.
_LONG = 16.0

#: Most meetings for each face, on average, of surfaces that bound solids.
_MEETINGS = 50

#: In front of and behind a face is this many times the distance that counts as none. Parts that are thinner
#: than four times that tell nothing.
_STEP, _THIN = 2.0, 8.0


class Arrangement(NamedTuple):
    """What bounds the inside of a closed surface.

    Attributes
    ----------
    mesh : Mesh or None
        The faces that do, and the parts of those that do in part, which have points of their own. The surface
        itself if all faces do; None if none does.
    winding : WindingNumber or None
        If faces cross, overlap or meet, what tells the inside: the faces of `mesh` need not fit together.
        Otherwise `mesh` is closed.
    inverted : bool
        Whether solids are inside out: in front of their faces the winding number is negative.
    """

    mesh: Mesh | None
    winding: WindingNumber | None
    inverted: bool


@device
def _height(place, i, points, o, normal):
    return (
        (place[i, 0] - points[o, 0]) * normal[0]
        + (place[i, 1] - points[o, 1]) * normal[1]
        + (place[i, 2] - points[o, 2]) * normal[2]
    )


@device
def _beyond(ax, ay, az, bx, by, bz, nx, ny, nz, x, y, z):
    """Return how far (x, y, z) lies to the right of the line from a to b, seen against the normal.

    Where there is no line because a is b, nothing does.
    """
    ex = bx - ax
    ey = by - ay
    ez = bz - az
    rx = ey * nz - ez * ny
    ry = ez * nx - ex * nz
    rz = ex * ny - ey * nx
    length = np.sqrt(rx * rx + ry * ry + rz * rz)
    return ((x - ax) * rx + (y - ay) * ry + (z - az) * rz) / length if length > 0.0 else -np.inf


@routine
def _meeting(part, size, normal, points, u, v, w, other, near):
    """Return how a plane convex `part` of `size` corners meets the triangle (u, v, w), of the normal `other`.

    One of the four ways above.
    """
    # The triangle over the part's plane.
    low = np.inf
    high = -np.inf
    for side in range(3):
        k = u if side == 0 else (v if side == 1 else w)
        h = -_height(part, 0, points, k, normal)
        low = min(low, h)
        high = max(high, h)
    if low > near or high < -near:
        return _APART
    if low >= -near and high <= near:
        # In one plane: some side of one of them tells them apart, or they overlap.
        turn = 1.0 if normal[0] * other[0] + normal[1] * other[1] + normal[2] * other[2] > 0.0 else -1.0
        for side in range(3):
            p = u if side == 0 else (v if side == 1 else w)
            q = v if side == 0 else (w if side == 1 else u)
            least = np.inf
            for i in range(size):
                least = min(
                    least,
                    _beyond(
                        points[p, 0], points[p, 1], points[p, 2], points[q, 0], points[q, 1], points[q, 2],
                        turn * normal[0], turn * normal[1], turn * normal[2],
                        part[i, 0], part[i, 1], part[i, 2],
                    ),
                )  # fmt: skip
            if not least < -near:
                return _APART
        for i in range(size):
            j = (i + 1) % size
            least = np.inf
            for side in range(3):
                k = u if side == 0 else (v if side == 1 else w)
                least = min(
                    least,
                    _beyond(
                        part[i, 0], part[i, 1], part[i, 2], part[j, 0], part[j, 1], part[j, 2],
                        normal[0], normal[1], normal[2], points[k, 0], points[k, 1], points[k, 2],
                    ),
                )  # fmt: skip
            if not least < -near:
                return _APART
        return _OVERLAPPING
    # The part over the triangle's plane: it goes through it along a segment, or has a side in it.
    low = np.inf
    high = -np.inf
    for i in range(size):
        h = _height(part, i, points, u, other)
        low = min(low, h)
        high = max(high, h)
    through = low < -near and high > near
    ax = 0.0
    ay = 0.0
    az = 0.0
    bx = 0.0
    by = 0.0
    bz = 0.0
    found = 0
    for i in range(size):
        j = (i + 1) % size
        hi = _height(part, i, points, u, other)
        hj = _height(part, j, points, u, other)
        if through:
            if (hi > 0.0) == (hj > 0.0):
                continue
            s = hi / (hi - hj)
            x = part[i, 0] + s * (part[j, 0] - part[i, 0])
            y = part[i, 1] + s * (part[j, 1] - part[i, 1])
            z = part[i, 2] + s * (part[j, 2] - part[i, 2])
            if found == 0:
                ax = x
                ay = y
                az = z
            else:
                bx = x
                by = y
                bz = z
            found += 1
        elif abs(hi) <= near and abs(hj) <= near:
            ax = part[i, 0]
            ay = part[i, 1]
            az = part[i, 2]
            bx = part[j, 0]
            by = part[j, 1]
            bz = part[j, 2]
            found = 2
    if found < 2:
        return _APART
    # What of the segment is in the triangle.
    first = 0.0
    last = 1.0
    for side in range(3):
        p = u if side == 0 else (v if side == 1 else w)
        q = v if side == 0 else (w if side == 1 else u)
        da = near - _beyond(
            points[p, 0], points[p, 1], points[p, 2], points[q, 0], points[q, 1], points[q, 2],
            other[0], other[1], other[2], ax, ay, az,
        )  # fmt: skip
        db = near - _beyond(
            points[p, 0], points[p, 1], points[p, 2], points[q, 0], points[q, 1], points[q, 2],
            other[0], other[1], other[2], bx, by, bz,
        )  # fmt: skip
        if da < 0.0 and db < 0.0:
            return _APART
        if da < 0.0:
            first = max(first, da / (da - db))
        elif db < 0.0:
            last = min(last, da / (da - db))
    length = np.sqrt((bx - ax) ** 2 + (by - ay) ** 2 + (bz - az) ** 2)
    if not (last - first) * length > _LONG * near:
        return _APART
    return _THROUGH if through else _ALONG


@kernel
def _find_meetings(starts, ends, tree, normals, thin, near, size):
    # For each face how many others it meets; and which, one after another, and how many in all.
    points, faces = tree[0], tree[1]
    stack, found, box = scratch()
    part = np.empty((3, 3))
    met = np.empty(1024, np.int32)
    total = 0
    for share in range(starts.size):
        for f in range(starts[share], ends[share]):
            size[f] = 0
            if thin[f]:
                continue
            no_box(box)
            for corner in range(3):
                widen(box, points, faces[f, corner])
                for axis in range(3):
                    part[corner, axis] = points[faces[f, corner], axis]
            normal = (normals[f, 0], normals[f, 1], normals[f, 2])
            top = 1
            stack[0] = 0
            while top > 0:
                count, top = faces_near(tree, box, near, stack, top, found)
                if total + count > met.size:
                    met = longer(met, total)
                for c in range(count):
                    g = found[c]
                    if g == f or thin[g]:
                        continue
                    u = faces[g, 0]
                    v = faces[g, 1]
                    w = faces[g, 2]
                    common = 0
                    farthest = 0.0
                    for corner in range(3):
                        k = faces[f, corner]
                        common += k in (u, v, w)
                        k = faces[g, corner]
                        farthest = max(farthest, abs(_height(part, 0, points, k, normal)))
                    # Neighbours meet in their common side; that is no meeting unless one lies on the other.
                    if common == 2 and farthest > near:
                        continue
                    other = (normals[g, 0], normals[g, 1], normals[g, 2])
                    meeting = _meeting(part, 3, normal, points, u, v, w, other, near)
                    if meeting != _APART and (common < 2 or meeting == _OVERLAPPING):
                        met[total] = g
                        total += 1
                        size[f] += 1
    return met, total


@allocating
def _more_parts(parts, sizes, count):
    """Return arrays twice as long that begin with the first `count` parts."""
    more = np.empty((2 * parts.shape[0], parts.shape[1], 3))
    more_sizes = np.empty(2 * sizes.size, np.int32)
    for i in range(count):
        more_sizes[i] = sizes[i]
        for k in range(sizes[i]):
            for axis in range(3):
                more[i, k, axis] = parts[i, k, axis]
    return more, more_sizes


@routine
def _split(parts, sizes, i, new, x, y, z, normal, near, work):
    """Cut part i by a plane: what is in front goes to the part `new`. Return whether both sides have some."""
    size = sizes[i]
    low = 0.0
    high = 0.0
    for k in range(size):
        work[k, 3] = (
            (parts[i, k, 0] - x) * normal[0] + (parts[i, k, 1] - y) * normal[1]
            + (parts[i, k, 2] - z) * normal[2]
        )  # fmt: skip
        low = min(low, work[k, 3])
        high = max(high, work[k, 3])
        for axis in range(3):
            work[k, axis] = parts[i, k, axis]
    if low >= -near or high <= near:
        return False
    behind = 0
    before = 0
    for k in range(size):
        j = (k + 1) % size
        if work[k, 3] <= near:
            for axis in range(3):
                parts[i, behind, axis] = work[k, axis]
            behind += 1
        if work[k, 3] >= -near:
            for axis in range(3):
                parts[new, before, axis] = work[k, axis]
            before += 1
        if min(work[k, 3], work[j, 3]) < -near and max(work[k, 3], work[j, 3]) > near:
            s = work[k, 3] / (work[k, 3] - work[j, 3])
            for axis in range(3):
                place = work[k, axis] + s * (work[j, axis] - work[k, axis])
                parts[i, behind, axis] = place
                parts[new, before, axis] = place
            behind += 1
            before += 1
    sizes[i] = behind
    sizes[new] = before
    return True


@kernel
def _cut(starts, ends, chosen, first, met, tree, near, count):
    # The parts of each chosen face, one after another: how many a face has, their corners, how many in all.
    points, faces = tree[0], tree[1]
    parts = np.empty((64, _CORNERS, 3))
    sizes = np.empty(64, np.int32)
    work = np.empty((_CORNERS, 4))
    out = np.empty((256, _CORNERS, 3))
    out_sizes = np.empty(256, np.int32)
    total = 0
    for share in range(starts.size):
        for c in range(starts[share], ends[share]):
            f = chosen[c]
            normal = face_normal(points, faces[f, 0], faces[f, 1], faces[f, 2])
            sizes[0] = 3
            for corner in range(3):
                for axis in range(3):
                    parts[0, corner, axis] = points[faces[f, corner], axis]
            number = 1
            for m in range(first[f], first[f + 1]):
                g = met[m]
                other = face_normal(points, faces[g, 0], faces[g, 1], faces[g, 2])
                i = 0
                while i < number:
                    if number + 4 > sizes.size:
                        parts, sizes = _more_parts(parts, sizes, number)
                    if sizes[i] > _CORNERS - 4:
                        # Two halves, with a common side.
                        half = sizes[i] // 2
                        for k in range(half, sizes[i]):
                            for axis in range(3):
                                parts[number, k - half, axis] = parts[i, k, axis]
                        for axis in range(3):
                            parts[number, sizes[i] - half, axis] = parts[i, 0, axis]
                        sizes[number] = sizes[i] - half + 1
                        sizes[i] = half + 1
                        number += 1
                    meeting = _meeting(
                        parts[i], sizes[i], normal, points, faces[g, 0], faces[g, 1], faces[g, 2], other, near
                    )
                    if meeting == _THROUGH:
                        o = faces[g, 0]
                        number += _split(
                            parts,
                            sizes,
                            i,
                            number,
                            points[o, 0],
                            points[o, 1],
                            points[o, 2],
                            other,
                            near,
                            work,
                        )
                    elif meeting == _OVERLAPPING:
                        # What lies beyond a side of the other face does not overlap it.
                        turn = normal[0] * other[0] + normal[1] * other[1] + normal[2] * other[2]
                        turn = 1.0 if turn > 0.0 else -1.0
                        for side in range(3):
                            p = faces[g, side]
                            q = faces[g, (side + 1) % 3]
                            ex = points[q, 0] - points[p, 0]
                            ey = points[q, 1] - points[p, 1]
                            ez = points[q, 2] - points[p, 2]
                            rx = turn * (ey * normal[2] - ez * normal[1])
                            ry = turn * (ez * normal[0] - ex * normal[2])
                            rz = turn * (ex * normal[1] - ey * normal[0])
                            length = np.sqrt(rx * rx + ry * ry + rz * rz)
                            beyond = (rx / length, ry / length, rz / length)
                            number += _split(
                                parts, sizes, i, number, points[p, 0], points[p, 1], points[p, 2], beyond,
                                near, work,
                            )  # fmt: skip
                    i += 1
            count[c] = number
            for i in range(number):
                if total == out_sizes.size:
                    out, out_sizes = _more_parts(out, out_sizes, total)
                out_sizes[total] = sizes[i]
                for k in range(sizes[i]):
                    for axis in range(3):
                        out[total, k, axis] = parts[i, k, axis]
                total += 1
    return out, out_sizes, total


def _meetings(
    tree: ClosestPoint, normals: Float64, areas: Float64, near: float
) -> tuple[npt.NDArray[np.int64], Int32]:
    """Return where the faces that each face meets begin, (t + 1,), and which they are."""
    points, faces = tree.tree[:2]
    longest = np.max(
        [((points[faces[:, i]] - points[faces[:, i - 1]]) ** 2).sum(axis=1) for i in range(3)], axis=0
    )
    thin = ~(2.0 * areas > _THIN * near * np.sqrt(longest))
    size = np.empty(len(faces), np.int64)
    found = parallel.run(
        _find_meetings, *parallel.ranges(len(faces)), tree.tree, normals, thin, near, size,
        smallest_share=parallel.COSTLY,
    )  # fmt: skip
    return np.concatenate(([0], np.cumsum(size))), np.concatenate([met[:total] for met, total in found])


def _parts(
    tree: ClosestPoint,
    chosen: npt.NDArray[np.int64],
    first: npt.NDArray[np.int64],
    met: Int32,
    near: float,
) -> tuple[npt.NDArray[np.int64], Float64, Int32]:
    """Cut faces where they meet others, and return the parts of those of which there are several.

    Returns the face of each part, (p,), its corners, (p, _CORNERS, 3), and how many it has; the first one is
    repeated in the room that is left.
    """
    if not len(chosen):
        return np.empty(0, np.int64), np.empty((0, _CORNERS, 3)), np.empty(0, np.int32)
    count = np.empty(len(chosen), np.int64)
    found = parallel.run(
        _cut, *parallel.ranges(len(chosen), 64), chosen, first, met, tree.tree, near, count,
        smallest_share=parallel.COSTLY,
    )  # fmt: skip
    several = np.repeat(count, count) > 1
    corners = np.concatenate([out[:total] for out, _, total in found])[several]
    sizes = np.concatenate([size[:total] for _, size, total in found])[several]
    used = np.arange(_CORNERS) < sizes[:, None]
    corners = np.where(used[:, :, None], corners, corners[:, :1])
    return np.repeat(chosen, count)[several], corners, sizes


def _normals(points: Float64, triangles: Int32) -> tuple[Float64, Float64]:
    """Return the unit normals and the areas of triangles."""
    a, b, c = (points[triangles[:, corner]] for corner in range(3))
    normals = np.cross(b - a, c - a)
    twice = np.linalg.norm(normals, axis=1)
    return np.divide(normals, twice[:, None], out=normals, where=twice[:, None] > 0.0), 0.5 * twice


def _widths(corners: Float64) -> Float64:
    """Return how wide convex polygons are, about the diameter of a circle within; corners may repeat."""
    spokes = corners - corners[:, :1]
    twice = np.linalg.norm(np.cross(spokes[:, 1:-1], spokes[:, 2:]).sum(axis=1), axis=1)
    around = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2).sum(axis=1)
    return np.divide(2.0 * twice, around, out=np.zeros_like(twice), where=around > 0.0)  # type: ignore[no-any-return]


def _patches(mesh: Mesh, alone: Bool, areas: Float64) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Return the patch of each face, and the largest face of each patch.

    Patches end at sides with more than two faces; faces that are to be `alone` are a patch each.
    """
    corners = mesh.connectivity.reshape(-1, 3)[alone]
    lines = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]])
    numbers, patch = np.unique(patches(build(mesh), lines), return_inverse=True)
    by_size = np.argsort(areas, kind="stable")
    largest = np.empty(len(numbers), np.int64)
    largest[patch[by_size]] = by_size
    return patch, largest


def _inside_out(mesh: Mesh, component: Int32) -> Bool:
    """Return the faces whose component encloses a negative volume, (t,)."""
    _, part = np.unique(component, return_inverse=True)
    a, b, c = (mesh.points[mesh.connectivity[corner::3]] for corner in range(3))
    middle = np.column_stack([np.bincount(part, weights=x) for x in ((a + b + c) / 3.0).T])
    place = (middle / np.bincount(part)[:, None])[part]
    a, b, c = (corner - place for corner in (a, b, c))
    volume = np.bincount(part, weights=np.einsum("ij,ij->i", a, np.cross(b, c)))
    return (volume < 0.0)[part]  # type: ignore[no-any-return]


def arrange(mesh: Mesh, tree: ClosestPoint, near: float) -> Arrangement:
    """Find what bounds the inside of a closed surface.

    Parameters
    ----------
    mesh : Mesh
        Triangles; every side is used as often forth as back. Points in one place must be one point.
    tree : ClosestPoint
        Of the same triangles.
    near : float
        Distance that counts as none, model units. The result is as exact as that.

    Raises
    ------
    InvalidMeshError
        Faces meet so many others that they are a tangle and no walls of solids.

    Examples
    --------
    >>> corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    >>> faces = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], np.int32)
    >>> both = Mesh.from_faces(np.vstack([4 * corners - 1, corners]), np.vstack([faces, faces + 4]))
    >>> arrange(both, ClosestPoint(both), 1e-9).mesh.points.max()
    np.float64(3.0)
    """
    points, triangles = mesh.points, mesh.connectivity.reshape(-1, 3)
    normals, areas = _normals(points, triangles)
    first, met = _meetings(tree, normals, areas, near)
    if len(met) > _MEETINGS * len(triangles):
        raise InvalidMeshError(
            f"The {len(triangles)} faces of the installation space meet others in {len(met)} places: a "
            "tangle which bounds nothing; clean it until it is one surface or a few solids that overlap."
        )
    component = patches(build(mesh), np.empty((0, 2), np.int32))
    if not len(met) and not component.any():
        return Arrangement(mesh, None, False)  # one solid
    winding = WindingNumber(points, triangles)
    involved = np.diff(first) > 0
    involved[met] = True
    # Faces that meet no other are in front of or behind the same as their neighbours.
    patch, largest = _patches(mesh, involved, areas)
    face, corners, sizes = _parts(tree, np.flatnonzero(involved), first, met, near)
    # The patches first, then the parts.
    middles = np.concatenate(
        (
            points[triangles[largest]].mean(axis=1),
            (corners.sum(axis=1) - (_CORNERS - sizes[:, None]) * corners[:, 0]) / sizes[:, None],
        )
    )
    along = _STEP * near * normals[np.concatenate((largest, face))]
    before, behind = winding(middles + along), winding(middles - along)
    telling = np.concatenate((_widths(points[triangles[largest]]), _widths(corners))) > _THIN * near
    # Where a surface folds over there are pockets of negative numbers as well; they are outside.
    turned = telling & (before < 0) & _inside_out(mesh, component)[np.concatenate((largest, face))]
    inverted = bool(turned.any())
    # Where faces meet, those beside the nearest one are not all known to it.
    decides = winding if len(met) else None
    if (~telling | ((before == 0) & (behind == 1))).all():
        return Arrangement(mesh, decides, inverted)
    kept = (before <= 0) & (behind >= 1)
    kept_parts = kept[len(largest) :]
    whole = kept[: len(largest)][patch]
    whole[face] = True
    whole[face[~kept_parts]] = False
    # Of faces that are kept in part: fans of triangles. If all parts are kept the face is, as it was.
    part = np.flatnonzero(kept_parts & ~whole[face])
    fans = [corners[part[sizes[part] > k + 1]][:, [0, k, k + 1]] for k in range(1, _CORNERS - 1)]
    new = np.concatenate(fans).reshape(-1, 3)
    parts = len(points) + np.arange(len(new), dtype=np.int32).reshape(-1, 3)
    used, numbers = np.unique(np.concatenate((triangles[whole], parts)), return_inverse=True)
    if not len(used):
        return Arrangement(None, None, inverted)
    bounding = Mesh.from_faces(np.concatenate((points, new))[used], numbers.reshape(-1, 3).astype(np.int32))
    return Arrangement(bounding, decides, inverted)
