"""Vicinities: the faces of a surface near a vertex, and planes between it and them, kept while they serve."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ...jit import parallel
from ...jit.compiled import device, kernel
from ..distance.closest_point import closest_of
from ..distance.signed_distance import SignedDistanceTree, signed_distance_to
from ..mesh.adjacency import Adjacency
from .crossings import FACES, faces_near, longer, scratch

Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]

#: How far a vertex may go before the faces near are looked for again, in lengths of its edges.
REACH = 0.6

#: Most planes of a vertex.
PLANES = 4

#: Faces that differ from a plane by this part of the tolerance lie in it.
_FLAT = 1.0 / 64.0

#: A vicinity whose vertex sees no room as deep as this part of its radius has no planes.
_SHALLOW = 1.0 / 32.0


class Vicinities(NamedTuple):
    """What kernels read and keep of the vertices of a mesh and the faces of a surface that are near.

    Attributes
    ----------
    row : (n,) int32
        Where the vertex stands in what follows, or -1.
    anchor : (r, 3) float64
    reach : (r,) float64
        All faces that are no farther from the anchor than this are known; 0 if none are.
    first, last : (r,) int64
        Part of `faces`: these.
    faces : (m,) int32
        The one nearest to the anchor first.
    held : (r,) int32
        How many planes there are; 0 if none were found. Open surfaces have none: beyond their rims signs
        change where there is no face.
    planes : (r, PLANES, 4) float64
        Unit normal and offset: whoever is within reach, and nowhere over a plane (x - anchor) . n = offset,
        is inside, see :func:`_find_planes`.
    convex : (r,) bool
        Whether the faces are the boundary of the room behind the planes: whoever is over one is outside.
    wanted : (n,) uint8
        Vertices that have asked for more than is known.
    filled : int
        How many entries of `faces` are in use.
    """

    row: Int32
    anchor: Float64
    reach: Float64
    first: npt.NDArray[np.int64]
    last: npt.NDArray[np.int64]
    faces: Int32
    held: Int32
    planes: Float64
    convex: npt.NDArray[np.bool_]
    wanted: npt.NDArray[np.uint8]
    filled: int


def no_vicinities(n: int) -> Vicinities:
    """Return the beginning for n vertices: nothing is known."""
    return Vicinities(
        np.full(n, -1, np.int32), np.empty((0, 3)), np.empty(0), np.empty(0, np.int64), np.empty(0, np.int64),
        np.empty(0, np.int32), np.empty(0, np.int32), np.empty((0, PLANES, 4)), np.empty(0, np.bool_),
        np.zeros(n, np.uint8), 0,
    )  # fmt: skip


@device
def room_in_vicinity(kept, tree, normals, winding, v, x, y, z, limit):
    """Return how far vertex v may go from (x, y, z), and its signed distance there, if it had to be found.

    Less than nothing if its signed distance is greater than `limit`. NaN, and more is wanted, if what is
    kept does not tell. The distance is NaN unless it was asked of the faces.
    """
    anchor, planes = kept.anchor, kept.planes
    row = kept.row[v]
    if row >= 0:
        dx = x - anchor[row, 0]
        dy = y - anchor[row, 1]
        dz = z - anchor[row, 2]
        left = kept.reach[row] - np.sqrt(dx * dx + dy * dy + dz * dz)
        if left > 0.0:
            highest = -np.inf
            held = kept.held[row]
            for s in range(held):
                highest = max(
                    highest,
                    dx * planes[row, s, 0] + dy * planes[row, s, 1] + dz * planes[row, s, 2]
                    - planes[row, s, 3],
                )  # fmt: skip
            if held > 0:
                if highest <= 0.0:
                    return min(left, -highest), np.nan
                if kept.convex[row] and highest > limit:
                    return limit - highest, np.nan
            distance = signed_distance_to(
                tree, normals, winding, kept.faces, kept.first[row], kept.last[row], x, y, z, left
            )
            if distance < np.inf:
                return limit - distance, distance
    kept.wanted[v] = 1
    return np.nan, np.nan


@device
def _height(others, u, normal, x, y, z):
    return (others[u, 0] - x) * normal[0] + (others[u, 1] - y) * normal[1] + (others[u, 2] - z) * normal[2]


@device
def _find_planes(tree, normals, winding, near, size, x, y, z, nearest, reach, limit, tolerance, planes, row):
    """Write to planes[row] those behind which all within `reach` of (x, y, z) are inside.

    Returns how many, and `convex`.

    Each of the faces ``near[:size]``, all that are so near, the nearest at the distance `nearest`, is in
    front of one. So the room behind them is free of faces, and convex: it is all inside if one point in it
    is. Say that one, w, is a deep behind all planes. Somebody at the height h over one at most is then no
    farther from that room than ``h / a`` of the way to w, which is no longer than ``2 reach``: planes are
    raised until that is `limit`, for those who slide along a face.
    """
    others, faces = tree[0], tree[1]
    one = np.uint64(1)
    covered = np.uint64(0)
    count = 0
    ux = 0.0
    uy = 0.0
    uz = 0.0
    flat = _FLAT * tolerance
    convex = True
    for c in range(size):
        if covered & (one << np.uint64(c)):
            continue
        f = near[c]
        normal = (normals[f, 0], normals[f, 1], normals[f, 2])
        over = -_height(others, faces[f, 0], normal, x, y, z)
        if count == PLANES or not over <= tolerance or normal[0] == normal[1] == normal[2] == 0.0:
            return 0, False
        # The face's plane, moved half of the way to the vertex at most: then more faces are before it.
        lowest = 0.0
        for d in range(size):
            bottom = np.inf
            for corner in range(3):
                h = _height(others, faces[near[d], corner], normal, x, y, z) + over
                bottom = min(bottom, h)
                convex = convex and h <= flat
            if bottom >= min(0.5 * over, 0.0) - flat:
                covered |= one << np.uint64(d)
                lowest = min(lowest, bottom)
        convex = convex and lowest >= -flat
        for axis in range(3):
            planes[row, count, axis] = normal[axis]
        planes[row, count, 3] = lowest - over
        ux -= normal[0]
        uy -= normal[1]
        uz -= normal[2]
        count += 1
    length = np.sqrt(ux * ux + uy * uy + uz * uz)
    if length == 0.0:
        return 0, False
    # So near that the face nearest to w is among them.
    step = 0.4 * (reach - nearest) / length
    ux *= step
    uy *= step
    uz *= step
    deep = np.inf
    for s in range(count):
        deep = min(
            deep,
            planes[row, s, 3] - (ux * planes[row, s, 0] + uy * planes[row, s, 1] + uz * planes[row, s, 2]),
        )
    if not deep > _SHALLOW * reach:
        return 0, False
    distance = signed_distance_to(
        tree, normals, winding, near, 0, size, x + ux, y + uy, z + uz, reach - 0.4 * (reach - nearest)
    )
    if not distance < 0.0:
        return 0, False
    for s in range(count):
        planes[row, s, 3] += 0.5 * limit * deep / reach
    return count, convex


@kernel
def _gather(
    starts,
    ends,
    chosen,
    points,
    offsets,
    ring,
    known,
    tree,
    normals,
    winding,
    limit,
    tolerance,
    kept,
    size,
):
    # For each of the chosen vertices how many faces are within reach; and which, one after another, and how
    # many in all.
    stack, found, box = scratch()
    others, corners = tree[0], tree[1]
    rows, anchor, reaches, held, convex, planes = (
        kept.row, kept.anchor, kept.reach, kept.held, kept.convex, kept.planes
    )  # fmt: skip
    near = np.empty(FACES, np.int32)
    faces = np.empty(1024, np.int32)
    total = 0
    for part in range(starts.size):
        for i in range(starts[part], ends[part]):
            v = chosen[i]
            row = rows[v]
            x = points[v, 0]
            y = points[v, 1]
            z = points[v, 2]
            length = 0.0
            for r in range(offsets[v], offsets[v + 1]):
                k = ring[r]
                length += np.sqrt((points[k, 0] - x) ** 2 + (points[k, 1] - y) ** 2 + (points[k, 2] - z) ** 2)
            # From where its distance is known it has hardly come farther than REACH.
            reach = abs(known[v, 3]) + REACH * length / max(1, offsets[v + 1] - offsets[v])
            for axis in range(3):
                anchor[row, axis] = points[v, axis]
                box[0, axis] = points[v, axis] - reach
                box[1, axis] = points[v, axis] + reach
            stack[0] = 0
            count, more = faces_near(tree, box, 0.0, stack, 1, found)
            size[i] = 0
            held[row] = 0
            reaches[row] = 0.0
            if more > 0:
                continue
            nearest = np.inf
            for c in range(count):
                f = found[c]
                px, py, pz, _, _ = closest_of(others, corners[f, 0], corners[f, 1], corners[f, 2], x, y, z)
                square = (px - x) ** 2 + (py - y) ** 2 + (pz - z) ** 2
                if square > reach * reach:
                    continue
                place = size[i]
                if square < nearest:
                    nearest = square
                    near[place] = near[0]
                    place = 0
                near[place] = f
                size[i] += 1
            if size[i] == 0:
                continue
            reaches[row] = reach
            held[row], convex[row] = _find_planes(
                tree, normals, winding, near, size[i], x, y, z, np.sqrt(nearest), reach, limit, tolerance,
                planes, row,
            )  # fmt: skip
            if total + size[i] > faces.size:
                faces = longer(faces, total)
            for c in range(size[i]):
                faces[total + c] = near[c]
            total += size[i]
    return faces, total


def refreshed(
    vicinities: Vicinities,
    points: Float64,
    near: Adjacency,
    known: Float64,
    space: SignedDistanceTree,
    limit: float,
    tolerance: float,
) -> Vicinities:
    """Look for the faces near the vertices that have asked for them, and return what is known then."""
    kept = vicinities
    chosen = np.flatnonzero(kept.wanted)
    if not len(chosen):
        return kept
    kept.wanted[chosen] = 0
    new = chosen[kept.row[chosen] < 0]
    rows = int(kept.row.max()) + 1
    kept.row[new] = np.arange(rows, rows + len(new), dtype=np.int32)
    rows += len(new)
    kept = kept._replace(
        anchor=enlarged(kept.anchor, rows), reach=enlarged(kept.reach, rows),
        first=enlarged(kept.first, rows), last=enlarged(kept.last, rows), held=enlarged(kept.held, rows),
        planes=enlarged(kept.planes, rows), convex=enlarged(kept.convex, rows),
    )  # fmt: skip
    size = np.empty(len(chosen), np.int64)
    found: list[Any] = parallel.run(
        _gather, *parallel.ranges(len(chosen), 512), chosen, points, near.ring_offsets, near.ring, known,
        space.tree, space.normals, space.winding, limit, tolerance, kept, size,
        smallest_share=parallel.COSTLY,
    )  # fmt: skip
    # What vertices had before stays behind, unused.
    last = kept.filled + np.cumsum(size)
    kept.last[kept.row[chosen]] = last
    kept.first[kept.row[chosen]] = last - size
    filled = kept.filled + int(size.sum())
    kept, first = kept._replace(faces=enlarged(kept.faces, filled), filled=filled), kept.filled
    kept.faces[first:filled] = np.concatenate([faces[:total] for faces, total in found])
    return kept


def enlarged(values: npt.NDArray[Any], size: int) -> npt.NDArray[Any]:
    """Return an array that begins with `values` and has room for `size` of them."""
    if size <= len(values):
        return values
    larger = np.empty((size + size // 2, *values.shape[1:]), values.dtype)
    larger[: len(values)] = values
    return larger
