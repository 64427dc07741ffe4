"""Lines of a surface between labels: the edges where several labels meet, and the vertices on them.

An edge is regular if two faces between the same two labels meet there. Any other edge with which each label
closes (its faces at the edge, each turned outwards, come in pairs that cancel) is a *line edge*.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ...jit.compiled import device, kernel

Int32 = npt.NDArray[np.int32]

#: Kinds of edges. UNCLOSED: one face, or more than one with which a label does not close.
REGULAR, LINE_EDGE, OPEN, UNCLOSED, TURNED = 0, 1, 2, 3, 4


class EdgeCounts(NamedTuple):
    """Numbers of edges, each counted once: on lines, with one face, and where labels do not close.

    `turned` are those of the last where the labels are there in pairs, but faces disagree on the orientation.
    """

    lines: int
    open: int
    unclosed: int
    turned: int


@device
def _kind_of_edge(v, w, offsets, connectivity, rows, corners, corner_face, labels, found, turns):
    # The faces at the edge are collected in `found`, and +1 in `turns` where they run from v to w, else -1.
    count = 0
    for i in range(rows[v], rows[v + 1]):
        c = corners[i]
        f = corner_face[c]
        first = offsets[f]
        last = offsets[f + 1]
        after = connectivity[c + 1 if c + 1 < last else first]
        before = connectivity[c - 1 if c > first else last - 1]
        for side in range(2):
            if (after if side == 0 else before) == w and count < found.size:
                found[count] = f
                turns[count] = 1 - 2 * side
                count += 1
    if count == 1:
        return 2
    f = found[0]
    g = found[1]
    if count == 2 and turns[0] != turns[1] and labels[f, 0] == labels[g, 0] and labels[f, 1] == labels[g, 1]:
        return 0
    kind = 1
    for i in range(count):
        for side in range(2):
            label = labels[found[i], side]
            total = 0
            pairs = 0
            for k in range(count):
                for other in range(2):
                    if labels[found[k], other] == label:
                        total += turns[k] * (1 - 2 * other)
                        pairs += 1
            if pairs % 2:
                return 3
            if total != 0:
                kind = 4
    return kind


@kernel
def _find(offsets, connectivity, rows, corners, corner_face, labels, ring_offsets, ring, edge_kind, counts):
    found = np.empty(64, np.int32)
    turns = np.empty(64, np.int32)
    for v in range(rows.size - 1):
        for r in range(ring_offsets[v], ring_offsets[v + 1]):
            w = ring[r]
            edge_kind[r] = _kind_of_edge(
                v, w, offsets, connectivity, rows, corners, corner_face, labels, found, turns
            )
            if v < w:
                counts[edge_kind[r]] += 1


@kernel
def _sort_out(ring_offsets, ring, edge_kind, kinds, boundary_ring, row_offsets, row):
    k = 0
    row_offsets[0] = 0
    for v in range(kinds.size):
        first = ring_offsets[v]
        last = ring_offsets[v + 1]
        degree = 0
        closed = True
        for r in range(first, last):
            degree += edge_kind[r] == 1
            closed = closed and edge_kind[r] <= 1
        on_line = closed and degree > 0
        if on_line:
            kinds[v] = 4 if degree == 2 else 5
        elif degree > 0 or (not closed and kinds[v] != 1):
            kinds[v] = 2
        if kinds[v] != 1:
            boundary_ring[v, 0] = -1
            boundary_ring[v, 1] = -1
        # Where a single line ends, as that of two voxels that touch along an edge, the surface goes on.
        along = on_line and degree > 1
        for r in range(first, last):
            if not along or edge_kind[r] == 1:
                row[k] = ring[r]
                k += 1
        row_offsets[v + 1] = k
    return k


def find_lines(
    offsets: Int32,
    connectivity: Int32,
    corner_offsets: Int32,
    corners: Int32,
    corner_face: Int32,
    face_labels: Int32,
    ring_offsets: Int32,
    ring: Int32,
    kinds: npt.NDArray[np.uint8],
    boundary_ring: Int32,
) -> tuple[Int32, Int32]:
    """Set `kinds` and `boundary_ring` of the vertices on lines; return row_offsets, row.

    All as in :class:`~vtksmooth.kernels.mesh.adjacency.Adjacency`. A vertex all of whose edges are regular or
    on lines is LINE where two line edges meet and JUNCTION where there is another number of them. With an
    edge where labels do not close it is NON_MANIFOLD.
    """
    edge_kind, _ = edge_kinds(
        offsets, connectivity, corner_offsets, corners, corner_face, face_labels, ring_offsets, ring
    )
    row_offsets, row = np.empty_like(ring_offsets), np.empty_like(ring)
    size = _sort_out(ring_offsets, ring, edge_kind, kinds, boundary_ring, row_offsets, row)
    return row_offsets, row[:size]


def edge_kinds(
    offsets: Int32,
    connectivity: Int32,
    corner_offsets: Int32,
    corners: Int32,
    corner_face: Int32,
    face_labels: Int32,
    ring_offsets: Int32,
    ring: Int32,
) -> tuple[npt.NDArray[np.uint8], EdgeCounts]:
    """Return the kind of the edge to each vertex of `ring`, and how many edges there are of each."""
    edge_kind, counts = np.empty(len(ring), np.uint8), np.zeros(5, np.int64)
    _find(
        offsets, connectivity, corner_offsets, corners, corner_face, face_labels, ring_offsets, ring,
        edge_kind, counts,
    )  # fmt: skip
    _, lines, opened, unclosed, turned = counts.tolist()
    return edge_kind, EdgeCounts(lines, opened, unclosed + turned, turned)


@kernel
def _mark_sides(offsets, connectivity, ring_offsets, ring, edge_kind, marks):
    for f in range(offsets.size - 1):
        for c in range(offsets[f], offsets[f + 1]):
            v = connectivity[c]
            w = connectivity[c + 1 if c + 1 < offsets[f + 1] else offsets[f]]
            marks[c] = False
            for r in range(ring_offsets[v], ring_offsets[v + 1]):
                if ring[r] == w:
                    marks[c] = edge_kind[r] == 1


def sides_on_lines(
    offsets: Int32,
    connectivity: Int32,
    corner_offsets: Int32,
    corners: Int32,
    corner_face: Int32,
    face_labels: Int32,
    ring_offsets: Int32,
    ring: Int32,
) -> npt.NDArray[np.bool_]:
    """Return for each corner whether the side from there to its face's next corner is a line edge."""
    edge_kind, _ = edge_kinds(
        offsets, connectivity, corner_offsets, corners, corner_face, face_labels, ring_offsets, ring
    )
    marks = np.empty(len(connectivity), np.bool_)
    _mark_sides(offsets, connectivity, ring_offsets, ring, edge_kind, marks)
    return marks
