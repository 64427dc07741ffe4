"""Which faces are near a face: across its edges, at its vertices, and within a distance."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ...jit import parallel
from ...jit.compiled import kernel
from .adjacency import Adjacency

Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
Int64 = npt.NDArray[np.int64]

#: Most faces of a ring and of a neighbourhood: around the poles of a sphere there are more, and all pairs of
#: them would take too long.
MOST_IN_RING, MOST_NEARBY = 64, 400


@kernel
def _find_across(starts, ends, near, across):
    for part in range(starts.size):
        for f in range(starts[part], ends[part]):
            begin = near.offsets[f]
            end = near.offsets[f + 1]
            for c in range(begin, end):
                across[c] = -1
                v = near.connectivity[c]
                w = near.connectivity[c + 1 if c + 1 < end else begin]
                for row in range(near.corner_offsets[v], near.corner_offsets[v + 1]):
                    d = near.corners[row]
                    g = near.corner_face[d]
                    before = near.connectivity[d - 1 if d > near.offsets[g] else near.offsets[g + 1] - 1]
                    if g != f and before == w:
                        across[c] = g
                        break


def across(near: Adjacency) -> Int32:
    """Return for each corner the face beyond the edge that begins there, (k,); -1 where there is none.

    Faces that disagree with it on the orientation do not count.
    """
    found = np.empty(len(near.connectivity), np.int32)
    parallel.run(_find_across, *parallel.ranges(len(near.offsets) - 1), near, found)
    return found


@kernel
def _find_rings(starts, ends, near, most, sizes):
    total = 0
    for part in range(starts.size):
        total += ends[part] - starts[part]
    rows = np.empty(16 * total + most, np.int32)
    last = 0
    for part in range(starts.size):
        for f in range(starts[part], ends[part]):
            if last + most > rows.size:
                larger = np.empty(2 * rows.size, np.int32)
                larger[:last] = rows[:last]
                rows = larger
            first = last
            rows[last] = f
            last += 1
            for c in range(near.offsets[f], near.offsets[f + 1]):
                v = near.connectivity[c]
                for row in range(near.corner_offsets[v], near.corner_offsets[v + 1]):
                    g = near.corner_face[near.corners[row]]
                    new = last - first < most
                    for i in range(first, last):
                        new = new and rows[i] != g
                    if new:
                        rows[last] = g
                        last += 1
            sizes[f] = last - first
    return rows[:last].copy()


@kernel
def _find_nearby(starts, ends, offsets, across, centre, reach, most, sizes):
    seen = np.full(sizes.size, -1, np.int32)
    total = 0
    for part in range(starts.size):
        total += ends[part] - starts[part]
    rows = np.empty(32 * total + most, np.int32)
    last = 0
    for part in range(starts.size):
        for f in range(starts[part], ends[part]):
            if last + most > rows.size:
                larger = np.empty(2 * rows.size, np.int32)
                larger[:last] = rows[:last]
                rows = larger
            # On regular meshes many are just as far: all of them are near, whatever rounding says.
            square = (1.0 + 1e-9) * reach[f] * reach[f]
            first = last
            rows[last] = f
            last += 1
            seen[f] = f
            i = first
            while i < last:
                for c in range(offsets[rows[i]], offsets[rows[i] + 1]):
                    g = across[c]
                    if g >= 0 and seen[g] != f:
                        seen[g] = f
                        x = centre[g, 0] - centre[f, 0]
                        y = centre[g, 1] - centre[f, 1]
                        z = centre[g, 2] - centre[f, 2]
                        if x * x + y * y + z * z <= square and last - first < most:
                            rows[last] = g
                            last += 1
                i += 1
            sizes[f] = last - first
    return rows[:last].copy()


def _as_rows(sizes: Int64, parts: list[Int32]) -> tuple[Int64, Int32]:
    return np.concatenate(([0], np.cumsum(sizes))), np.concatenate(parts)


def rings(near: Adjacency) -> tuple[Int64, Int32]:
    """Return offsets, rings: each face, and the faces that share a vertex with it, 64 at most."""
    sizes = np.empty(len(near.offsets) - 1, np.int64)
    parts = parallel.run(_find_rings, *parallel.ranges(len(sizes)), near, MOST_IN_RING, sizes)
    return _as_rows(sizes, parts)


def nearby(near: Adjacency, across: Int32, centre: Float64, reach: Float64) -> tuple[Int64, Int32]:
    """Return offsets, faces: each face, and those that hang together with it by edges within a distance.

    The nearest across edges first, 400 at most.

    Parameters
    ----------
    near : Adjacency
    across : (k,) int32
        From :func:`across`.
    centre : (m, 3) float64
    reach : (m,) float64
        How far from its centre those of the others may be.
    """
    sizes = np.empty(len(centre), np.int64)
    parts = parallel.run(
        _find_nearby, *parallel.ranges(len(sizes)), near.offsets, across, centre, reach, MOST_NEARBY, sizes,
        smallest_share=parallel.COSTLY,
    )  # fmt: skip
    return _as_rows(sizes, parts)
