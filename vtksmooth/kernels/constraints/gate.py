"""Gate: a vertex moves only if the elements round it become better."""

from __future__ import annotations

import numpy as np

from .. import parallel
from ..compiled import device, kernel
from ..quality import aspect_ratios, polygon_square, triangle_square
from ..state import State
from . import Constraint, Float64, Int64

ANGLE, ASPECT = 1, 2

#: A measure must grow by more than this part of itself (angles: by this much in the cosine): otherwise
#: rounding would decide about moves that change nothing, differently in each pose.
MARGIN = 1e-12


@device
def _largest_cosine(points, connectivity, first, last, v, x, y, z):  # type: ignore[no-untyped-def]
    # Largest cosine of the corner angles of one face, with vertex v at (x, y, z); 1 if a side vanishes.
    size = last - first
    largest = -1.0
    for i in range(size):
        p = connectivity[first + i]
        q = connectivity[first + (i + 1) % size]
        o = connectivity[first + (i + size - 1) % size]
        px = x if p == v else points[p, 0]
        py = y if p == v else points[p, 1]
        pz = z if p == v else points[p, 2]
        ax = (x if q == v else points[q, 0]) - px
        ay = (y if q == v else points[q, 1]) - py
        az = (z if q == v else points[q, 2]) - pz
        bx = (x if o == v else points[o, 0]) - px
        by = (y if o == v else points[o, 1]) - py
        bz = (z if o == v else points[o, 2]) - pz
        lengths = np.sqrt((ax * ax + ay * ay + az * az) * (bx * bx + by * by + bz * bz))
        if lengths == 0.0:
            return 1.0
        largest = max(largest, (ax * bx + ay * by + az * bz) / lengths)
    return largest


@device
def _judge(kind, points, near, reference, v, x, y, z):  # type: ignore[no-untyped-def]
    # Number of inverted elements round v, and the smallest measure of them, with v at (x, y, z).
    inverted = 0
    smallest = np.inf
    for i in range(near.corner_offsets[v], near.corner_offsets[v + 1]):
        c = near.corners[i]
        f = near.corner_face[c]
        a = near.offsets[f]
        b = near.offsets[f + 1]
        if b - a < 3:
            continue
        if kind == 1:
            smallest = min(smallest, -_largest_cosine(points, near.connectivity, a, b, v, x, y, z))
            continue
        if b - a == 3:
            p = near.connectivity[a + (c - a + 1) % 3]
            r = near.connectivity[a + (c - a + 2) % 3]
            # A triangle that uses v twice has no area, wherever v goes.
            q = 0.0
            if p != v and r != v:
                q = triangle_square(
                    points[p, 0] - x, points[p, 1] - y, points[p, 2] - z,
                    points[r, 0] - x, points[r, 1] - y, points[r, 2] - z,
                    reference[f, 0], reference[f, 1], reference[f, 2],
                )  # fmt: skip
        else:
            q = polygon_square(
                points, near.connectivity, a, b, v, x, y, z,
                reference[f, 0], reference[f, 1], reference[f, 2],
            )  # fmt: skip
        inverted += q < 0.0
        smallest = min(smallest, q)
    return inverted, smallest


@kernel
def _gate(starts, ends, kind, points, near, reference, margin, floor, proposed):  # type: ignore[no-untyped-def]
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            x = points[v, 0]
            y = points[v, 1]
            z = points[v, 2]
            if proposed[v, 0] == x and proposed[v, 1] == y and proposed[v, 2] == z:
                continue
            old_inverted, old = _judge(kind, points, near, reference, v, x, y, z)
            new_inverted, new = _judge(
                kind, points, near, reference, v, proposed[v, 0], proposed[v, 1], proposed[v, 2]
            )
            # A cosine near 0, of a right angle, has its rounding errors relative to 1.
            needed = old + margin * (1.0 if kind == 1 else abs(old))
            better = new_inverted == old_inverted and new > needed
            if not (better or (new_inverted < old_inverted and new >= floor)):
                proposed[v, 0] = x
                proposed[v, 1] = y
                proposed[v, 2] = z


class Gate(Constraint):
    """Accept a move only if it improves the worst element round the vertex.

    ``"aspect"`` (paper C, section 2.1): as many inverted elements as before and a greater smallest k, or
    fewer inverted elements and none worse than the worst of the whole mesh when the pass began. With it
    no pass lowers the smallest k of the mesh or makes more elements inverted.
    ``"angle"`` (smart Laplacian): a greater smallest angle, which does not see inversion.

    Parameters
    ----------
    measure : {"aspect", "angle"}
    """

    in_place = True

    def __init__(self, measure: str = "aspect") -> None:
        self.kind = {"angle": ANGLE, "aspect": ASPECT}[measure]
        self.floor = 0.0

    def bind(self, state: State) -> None:
        self.floor = state.smallest_k * abs(state.smallest_k)

    def prepare(self, state: State) -> None:
        # Where nothing is inverted nothing will be, and the floor is never asked for.
        if self.kind == ASPECT and self.floor < 0.0:
            k = float(aspect_ratios(state.mesh, state.reference).min())
            self.floor = k * abs(k)

    def dispose(self, state: State, starts: Int64, ends: Int64, proposed: Float64) -> None:
        parallel.run(
            _gate, starts, ends,
            self.kind, state.points, state.near, state.reference, MARGIN, self.floor, proposed,
        )  # fmt: skip
