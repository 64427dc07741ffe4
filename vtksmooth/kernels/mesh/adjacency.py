"""Who is next to whom: corners of vertices, one-rings, stars, edges, boundary loops, and the schedule.

Every builder is linear in the size of the mesh. All indices are int32.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from llvmlite import ir
from numba.core import types
from numba.extending import intrinsic

from ...jit import parallel
from ...jit.compiled import device, kernel
from .lines import find_lines
from .mesh import LARGEST_POLYGON, Mesh

Int32 = npt.NDArray[np.int32]

#: Kinds of vertices in :attr:`Adjacency.kinds`.
INTERIOR, BOUNDARY, NON_MANIFOLD, UNUSED, LINE, JUNCTION = 0, 1, 2, 3, 4, 5

#: Vertices of a block: its ring data fits a core's second-level cache.
BLOCK_SIZE = 2048

#: Larger stars are not told apart where vertices are sorted by the size of their stars.
_LARGEST_SIZE = 15


class Adjacency(NamedTuple):
    """The neighbourhoods of a mesh, as compressed rows; row v of X is ``X[X_offsets[v]:X_offsets[v+1]]``.

    Attributes
    ----------
    offsets, connectivity : int32
        The faces, as in :class:`~vtksmooth.kernels.mesh.mesh.Mesh`.
    corner_offsets, corners : int32
        For each vertex the corners (positions in `connectivity`) where it stands, by rising face.
    corner_face : (k,) int32
        Face of each corner.
    ring_offsets, ring : int32
        One-rings: the vertices that share an edge with v.
    star_offsets, star : int32
        Stars: all other vertices of the faces round v. For triangles these *are* the one-rings.
    kinds : (n,) uint8
        INTERIOR: every edge at v has two faces that agree on the orientation. BOUNDARY: exactly two edges
        have one face, the others are regular. NON_MANIFOLD: any other (non-manifold edges, orientations
        that disagree, several boundaries meeting, faces that use v twice). UNUSED: no face uses v. Only on
        surfaces between labels: LINE, on a line where several labels meet, and JUNCTION, where such lines
        meet or end; see :mod:`~vtksmooth.kernels.mesh.lines`.
    boundary_ring : (n, 2) int32
        For BOUNDARY vertices the neighbours along the boundary, otherwise -1.
    row_offsets, row : int32
        The neighbours that Laplacians go by: the one-ring, but on lines only the neighbours along the line.
        Where there are no lines these *are* the one-rings.
    """

    offsets: Int32
    connectivity: Int32
    corner_offsets: Int32
    corners: Int32
    corner_face: Int32
    ring_offsets: Int32
    ring: Int32
    star_offsets: Int32
    star: Int32
    kinds: npt.NDArray[np.uint8]
    boundary_ring: Int32
    row_offsets: Int32
    row: Int32


# Large arrays are made by NumPy and filled by kernels: NumPy asks the system for huge pages, the
# allocator inside numba does not, and touching fresh small pages costs more than the work done in them.


# Corners are read four at a time: a load waits for the address of every store before it. Unsigned indices
# are not asked whether they count from the end.


@kernel
def _count_corners(starts, ends, offsets, connectivity, size, fill):
    for part in range(starts.size):
        count = fill[starts[part] // size]
        first = offsets[starts[part]]
        last = offsets[ends[part]]
        fours = last - (last - first) % 4
        for c in range(first, fours, 4):
            u, v = np.uint32(connectivity[c]), np.uint32(connectivity[c + 1])
            w, x = np.uint32(connectivity[c + 2]), np.uint32(connectivity[c + 3])
            count[u] += 1
            count[v] += 1
            count[w] += 1
            count[x] += 1
        for c in range(fours, last):
            count[connectivity[c]] += 1


@kernel
def _start_rows(fill, rows):
    # Counts become the places where each share of the faces starts to fill each row.
    shares, n = fill.shape
    total = 0
    for v in range(n):
        rows[v] = total
        for share in range(shares):
            count = fill[share, v]
            fill[share, v] = total
            total += count
    rows[n] = total


@device
def _place(fill, v, c, corners):
    i = fill[v]
    fill[v] = i + 1
    corners[np.uint32(i)] = c


@kernel
def _sort_corners(starts, ends, offsets, connectivity, size, fill, corners, corner_face):
    for part in range(starts.size):
        place = fill[starts[part] // size]
        first = offsets[starts[part]]
        last = offsets[ends[part]]
        fours = last - (last - first) % 4
        for c in range(first, fours, 4):
            u, v = np.uint32(connectivity[c]), np.uint32(connectivity[c + 1])
            w, x = np.uint32(connectivity[c + 2]), np.uint32(connectivity[c + 3])
            _place(place, u, c, corners)
            _place(place, v, c + 1, corners)
            _place(place, w, c + 2, corners)
            _place(place, x, c + 3, corners)
        for c in range(fours, last):
            _place(place, np.uint32(connectivity[c]), c, corners)
        for f in range(starts[part], ends[part]):
            for c in range(offsets[f], offsets[f + 1]):
                corner_face[c] = f


def vertex_corners(mesh: Mesh) -> tuple[Int32, Int32, Int32]:
    """Sort the corners by vertex (a counting sort); return corner_offsets, corners, corner_face."""
    rows = np.empty(mesh.n_points + 1, np.int32)
    corners, corner_face = (np.empty(len(mesh.connectivity), np.int32) for _ in range(2))
    # Each thread sorts a share of the faces; a share costs a count for every vertex.
    shares = min(parallel.number_of_threads(), 4)
    size = max(1, -(-mesh.n_faces // shares))
    faces = parallel.ranges(mesh.n_faces, size=size)
    fill = np.zeros((len(faces[0]), mesh.n_points), np.int32)
    parallel.run(_count_corners, *faces, mesh.offsets, mesh.connectivity, size, fill)
    _start_rows(fill, rows)
    parallel.run(_sort_corners, *faces, mesh.offsets, mesh.connectivity, size, fill, corners, corner_face)
    return rows, corners, corner_face


@intrinsic
def _equal(typing_context, values, start, value):
    """Return which of the eight ``values[start:start + 8]`` equal `value`, as bits.

    One comparison of vectors; of a loop that says the same the compiler makes eight.
    """

    def generate(context, builder, signature, arguments):
        array, first, wanted = arguments
        eight = ir.VectorType(ir.IntType(32), 8)
        place = builder.gep(context.make_array(signature.args[0])(context, builder, array).data, [first])
        read = builder.load(builder.bitcast(place, eight.as_pointer()), align=4)
        nothing = ir.Constant(eight, ir.Undefined)
        one = builder.insert_element(nothing, wanted, ir.Constant(ir.IntType(32), 0))
        all_lanes = builder.shuffle_vector(one, nothing, ir.Constant(eight, [0] * 8))
        same = builder.icmp_signed("==", read, all_lanes)
        return builder.zext(builder.bitcast(same, ir.IntType(8)), ir.IntType(64))

    return types.int64(values, types.int64, types.int32), generate


@kernel
def _find_regular(starts, ends, offsets, connectivity, rows, corners, corner_face, triangles, after, kinds):
    # The usual vertex: every neighbour follows v in one face and precedes it in another.
    others = 0
    before = np.empty(8, np.int32)
    for part in range(starts.size):
        base = rows[starts[part]]
        count = rows[ends[part]] - base
        if count + 8 > before.size:
            before = np.empty(count + 8, np.int32)
        if triangles:
            three = np.uint32(3)
            for i in range(count):
                c = np.uint32(corners[base + i])
                at = c % three
                after[base + i] = connectivity[c - np.uint32(2) if at == 2 else c + np.uint32(1)]
                before[i] = connectivity[c + np.uint32(2) if at == 0 else c - np.uint32(1)]
        else:
            for i in range(count):
                c = corners[base + i]
                a = offsets[corner_face[c]]
                b = offsets[corner_face[c] + 1]
                after[base + i] = connectivity[c + 1 if c + 1 < b else a]
                before[i] = connectivity[c - 1 if c > a else b - 1]
        for v in range(starts[part], ends[part]):
            first = rows[v]
            size = rows[v + 1] - first
            regular = 3 <= size < 56
            if regular:
                row = (1 << size) - 1
                found = 0
                for i in range(first, first + size):
                    same = 0
                    for eight in range(0, size, 8):
                        same |= _equal(before, first - base + eight, after[i]) << eight
                    same &= row
                    # Each neighbour precedes v once, and no two are the same one.
                    regular = regular and same != 0 and same & (same - 1) == 0 and same & found == 0
                    regular = regular and after[i] != v and before[i - base] != after[i]
                    found |= same
            kinds[v] = 0 if regular else 2
            others += not regular
    return others


@kernel
def _collect_rings(
    offsets, connectivity, rows, corners, corner_face, after, ring_offsets, ring, kinds, boundary_ring, place
):
    n = rows.size - 1
    ring_offsets[0] = 0
    seen = np.empty(64, np.int32)
    k = 0
    for v in range(n):
        first = rows[v]
        row = rows[v + 1] - first
        if kinds[v] == 0:
            for i in range(first, first + row):
                ring[k] = after[i]
                k += 1
            ring_offsets[v + 1] = k
            continue
        start = k
        kinds[v] = 3 if row == 0 else 0
        # Count how often a neighbour follows v (low half) and precedes it (high half).
        if 2 * row > seen.size:
            seen = np.empty(2 * row, np.int32)
        odd = False
        for i in range(first, first + row):
            c = corners[i]
            f = corner_face[c]
            before = connectivity[c - 1 if c > offsets[f] else offsets[f + 1] - 1]
            odd = odd or after[i] == v or before == v or after[i] == before
            odd = odd or (i > first and corner_face[corners[i - 1]] == f)
            for side in range(2):
                w = after[i] if side == 0 else before
                if w == v:
                    continue
                p = place[w]
                if p < start:  # marks of earlier rings lie below this ring's start
                    p = k
                    place[w] = k
                    ring[k] = w
                    seen[k - start] = 0
                    k += 1
                seen[p - start] += 1 if side == 0 else 65536
        ring_offsets[v + 1] = k
        ends = 0
        for p in range(k - start):
            if seen[p] == 1 or seen[p] == 65536:
                ends += 1
                # [0] is where the boundary comes from, [1] where it goes on, seen along the faces.
                boundary_ring[v, 0 if seen[p] == 65536 else 1] = ring[start + p]
            elif seen[p] != 65537:
                odd = True
        if row > 0 and (odd or ends > 0):
            kinds[v] = 1
            if odd or ends != 2 or boundary_ring[v, 0] < 0 or boundary_ring[v, 1] < 0:
                kinds[v] = 2
                boundary_ring[v, 0] = -1
                boundary_ring[v, 1] = -1
    return k


def one_rings(
    mesh: Mesh, rows: Int32, corners: Int32, corner_face: Int32
) -> tuple[Int32, Int32, npt.NDArray[np.uint8], Int32]:
    """Return ring_offsets, ring, boundary, boundary_ring of a mesh with its :func:`vertex_corners`."""
    n = mesh.n_points
    after = np.empty(len(corners), np.int32)
    kinds = np.empty(n, np.uint8)
    boundary_ring = np.full((n, 2), -1, np.int32)
    near = (mesh.offsets, mesh.connectivity, rows, corners, corner_face)
    if not sum(parallel.run(_find_regular, *parallel.ranges(n), *near, mesh.only_triangles, after, kinds)):
        return rows, after, kinds, boundary_ring  # what follows a vertex in its faces *is* its ring
    ring_offsets = np.empty(n + 1, np.int32)
    ring = np.empty(2 * len(after), np.int32)  # the most there can be; what is not written costs no memory
    size = _collect_rings(*near, after, ring_offsets, ring, kinds, boundary_ring, np.full(n, -1, np.int32))
    return ring_offsets, ring[:size], kinds, boundary_ring


@kernel
def stars(offsets, connectivity, rows, corners, corner_face):
    """Return star_offsets, star: all other vertices of the faces round each vertex, in face order.

    Of giant faces only the two neighbours: all pairs of their corners would not fit in memory.
    """
    n = rows.size - 1
    star_offsets = np.empty(n + 1, np.int64)
    star_offsets[0] = 0
    place = np.full(n, -1, np.int64)
    # Twice over the mesh: count, then fill. The second round's marks lie above the first's.
    total = 0
    star = np.empty(0, np.int32)
    for turn in range(2):
        k = turn * total
        for v in range(n):
            start = k
            place[v] = k  # v itself is no neighbour
            for i in range(rows[v], rows[v + 1]):
                f = corner_face[corners[i]]
                first = offsets[f]
                size = offsets[f + 1] - first
                at = corners[i] - first
                giant = size > LARGEST_POLYGON
                for step in range(1, 3 if giant else size + 1):
                    # In face order; of a giant the next corner and the one before.
                    c = (at + (1 if step == 1 else size - 1)) % size if giant else step - 1
                    w = connectivity[first + c]
                    if w != v and place[w] < start:
                        place[w] = k
                        if turn == 1:
                            star[k - total] = w
                        k += 1
            star_offsets[v + 1] = k - turn * total
            # A ring's marks must lie below the next ring's start even when it is empty.
            if k == start:
                place[v] = -1
        if turn == 0:
            total = k
            star = np.empty(total, np.int32)
            place[:] = -1
    return star_offsets.astype(np.int32), star


def build(mesh: Mesh) -> Adjacency:
    """Build all neighbourhoods of `mesh`, O(corners).

    Examples
    --------
    >>> from vtksmooth.kernels.mesh import adjacency, mesh
    >>> square = mesh.Mesh.from_faces([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    >>> near = adjacency.build(square)
    >>> near.ring[near.ring_offsets[0] : near.ring_offsets[1]].tolist()
    [1, 2, 3]
    """
    corner_offsets, corners, corner_face = vertex_corners(mesh)
    faces = (mesh.offsets, mesh.connectivity, corner_offsets, corners, corner_face)
    ring_offsets, ring, kinds, boundary_ring = one_rings(mesh, corner_offsets, corners, corner_face)
    star_offsets, star = (ring_offsets, ring) if mesh.only_triangles else stars(*faces)
    rows = ring_offsets, ring
    if mesh.face_labels is not None:
        rows = find_lines(*faces, mesh.face_labels, ring_offsets, ring, kinds, boundary_ring)
    return Adjacency(*faces, ring_offsets, ring, star_offsets, star, kinds, boundary_ring, *rows)


@kernel
def _turn_into_cycles(starts, ends, near, widest):
    after = np.empty(widest, np.int32)
    before = np.empty(widest, np.int32)
    corners = np.empty(widest, np.int32)
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            row = near.corner_offsets[v]
            size = near.corner_offsets[v + 1] - row
            if near.kinds[v] != 0 or size > widest:
                continue
            for i in range(size):
                c = near.corners[row + i]
                a = c - c % 3
                corners[i] = c
                after[i] = near.connectivity[c + 1 if c < a + 2 else a]
                before[i] = near.connectivity[c - 1 if c > a else a + 2]
            # Each round finds the face that begins where the last one ends, and puts it in the next place.
            found = 1
            for i in range(1, size):
                for j in range(i, size):
                    if after[j] == before[i - 1]:
                        after[i], after[j] = after[j], after[i]
                        before[i], before[j] = before[j], before[i]
                        corners[i], corners[j] = corners[j], corners[i]
                        found += 1
                        break
            if found == size:  # otherwise several fans meet at v
                first = near.ring_offsets[v]
                for i in range(size):
                    near.corners[row + i] = corners[i]
                    near.ring[first + i] = after[i]


def turn_into_cycles(near: Adjacency) -> None:
    """Sort the triangles round each interior vertex, and its ring: triangle i joins neighbours i and i + 1.

    Starts with the face of the lowest number. Changes `near`, of a mesh of triangles only; vertices where
    several fans meet, and those with more than 255 faces, stay as they are.
    """
    parallel.run(_turn_into_cycles, *parallel.ranges(len(near.kinds)), near, 255)


@kernel
def _breadth_first(ring_offsets, ring, order, seen):
    n = ring_offsets.size - 1
    filled = 0
    for first in range(n):
        if seen[first]:
            continue
        seen[first] = 1
        order[filled] = first
        head = filled
        filled += 1
        while head < filled:
            v = order[head]
            head += 1
            for r in range(ring_offsets[v], ring_offsets[v + 1]):
                w = ring[r]
                if not seen[w]:
                    seen[w] = 1
                    order[filled] = w
                    filled += 1


def breadth_first_order(near: Adjacency) -> Int32:
    """Return the vertices, component by component, in rising distance from each one's first vertex.

    An order by topology alone: the same for a mesh that is turned, moved or scaled.
    """
    n = len(near.kinds)
    order = np.empty(n, np.int32)
    _breadth_first(near.ring_offsets, near.ring, order, np.zeros(n, np.uint8))
    return order


@kernel
def _colour(star_offsets, star, order, block_size, rank, colour, block_colour, used, block_used):
    n = order.size
    colours = 0
    for b in range(block_colour.size):
        low = b * block_size
        high = min(n, low + block_size)
        for i in range(low, high):
            v = order[i]
            for r in range(star_offsets[v], star_offsets[v + 1]):
                j = rank[star[r]]
                if j < low or j >= high:
                    c = block_colour[j // block_size]
                    if c >= 0:
                        block_used[c] = b
                elif j < i:
                    used[colour[j]] = i
            free = 0
            while used[free] == i:
                free += 1
            colour[i] = free
            colours = max(colours, free + 1)
        free = 0
        while block_used[free] == b:
            free += 1
        block_colour[b] = free
    return colours


@kernel
def _sort_blocks(order, star_offsets, colour, block_size, starts, by_size, fill, result):
    n = order.size
    blocks, columns = starts.shape
    # Two stable counting sorts: by the size of the star, then by colour.
    count = np.empty(_LARGEST_SIZE + 2, np.int64)
    for b in range(blocks):
        low = b * block_size
        high = min(n, low + block_size)
        for size in range(count.size):
            count[size] = 0
        for i in range(low, high):
            v = order[i]
            count[min(star_offsets[v + 1] - star_offsets[v], _LARGEST_SIZE) + 1] += 1
            starts[b, colour[i] + 1] += 1
        for size in range(_LARGEST_SIZE + 1):
            count[size + 1] += count[size]
        for i in range(low, high):
            v = order[i]
            size = min(star_offsets[v + 1] - star_offsets[v], _LARGEST_SIZE)
            by_size[count[size]] = i
            count[size] += 1
        starts[b, 0] = low
        fill[0] = low
        for c in range(1, columns):
            starts[b, c] += starts[b, c - 1]
            fill[c] = starts[b, c]
        for k in range(high - low):
            i = by_size[k]
            result[fill[colour[i]]] = order[i]
            fill[colour[i]] += 1


def colour_blocks(near: Adjacency, order: Int32, block_size: int = BLOCK_SIZE) -> tuple[Int32, Int32, Int32]:
    """Cut `order` into blocks; colour the blocks, and the vertices inside each block.

    Two vertices that stand in each other's star differ in their vertex colour (same block) or in their
    blocks' colour (neighbouring blocks), so the vertices of one vertex colour in all blocks of one block
    colour can move at the same time.

    Returns
    -------
    order : (n,) int32
        `order`, sorted inside each block by vertex colour, and vertices of one colour by the size of their
        stars (stable).
    starts : (blocks, colours + 1) int32
        Where each vertex colour starts in `order`, block by block.
    block_colour : (blocks,) int32
    """
    n = len(order)
    blocks = -(-n // block_size)
    colour, block_colour = np.empty(n, np.int32), np.full(blocks, -1, np.int32)
    rank, result = np.empty(n, np.int32), np.empty(n, np.int32)
    rank[order] = np.arange(n, dtype=np.int32)
    # Who has used a colour last: a vertex of the block, a block.
    used = np.full(np.diff(near.star_offsets).max(initial=0) + 2, -1, np.int32)
    block_used = np.full(blocks + 1, -1, np.int32)
    colours = _colour(
        near.star_offsets, near.star, order, block_size, rank, colour, block_colour, used, block_used
    )
    starts, fill = np.zeros((blocks, colours + 1), np.int32), np.empty(colours + 1, np.int32)
    by_size = np.empty(min(n, block_size), np.int64)
    _sort_blocks(order, near.star_offsets, colour, block_size, starts, by_size, fill, result)
    return result, starts, block_colour


@kernel
def _sort_faces(offsets, connectivity, rank, smallest, count, faces):
    m = offsets.size - 1
    for f in range(m):
        low = rank.size
        for c in range(offsets[f], offsets[f + 1]):
            low = min(low, rank[connectivity[c]])
        smallest[f] = low
        count[low + 1] += 1
    for v in range(rank.size + 1):
        count[v + 1] += count[v]
    for f in range(m):
        faces[count[smallest[f]]] = f
        count[smallest[f]] += 1


@kernel
def _renumber(offsets, connectivity, rank, faces, new_offsets, new_connectivity):
    k = 0
    new_offsets[0] = 0
    for i in range(faces.size):
        f = faces[i]
        for c in range(offsets[f], offsets[f + 1]):
            new_connectivity[k] = rank[connectivity[c]]
            k += 1
        new_offsets[i + 1] = k


def renumbered(mesh: Mesh, order: Int32) -> tuple[Mesh, Int32]:
    """Return `mesh` with its points in the given order, and for each of its faces the old number.

    Faces are sorted by their smallest new point number (stable), so that a sweep meets them in order.
    """
    n = mesh.n_points
    rank = np.empty(n, np.int32)
    rank[order] = np.arange(n, dtype=np.int32)
    faces, smallest = np.empty(mesh.n_faces, np.int32), np.empty(mesh.n_faces, np.int32)
    _sort_faces(mesh.offsets, mesh.connectivity, rank, smallest, np.zeros(n + 2, np.int32), faces)
    del smallest
    offsets, connectivity = np.empty_like(mesh.offsets), np.empty_like(mesh.connectivity)
    _renumber(mesh.offsets, mesh.connectivity, rank, faces, offsets, connectivity)
    labels = None if mesh.face_labels is None else mesh.face_labels[faces]
    return Mesh(mesh.points[order], offsets, connectivity, labels), faces


@kernel
def _edges(
    ring_offsets, ring, corner_offsets, corners, corner_face, offsets, connectivity, place, ends, faces
):
    n = ring_offsets.size - 1
    k = 0
    for v in range(n):
        start = k
        for r in range(ring_offsets[v], ring_offsets[v + 1]):
            w = ring[r]
            if w > v:
                ends[k, 0] = v
                ends[k, 1] = w
                place[w] = k
                k += 1
        for i in range(corner_offsets[v], corner_offsets[v + 1]):
            c = corners[i]
            f = corner_face[c]
            a = offsets[f]
            size = offsets[f + 1] - a
            for side in range(2):
                w = connectivity[a + (c - a + (1 if side == 0 else size - 1)) % size]
                e = place[w]
                if w > v and e >= start:
                    faces[e, side] = f if faces[e, side] == -1 else -2
        for e in range(start, k):
            if faces[e, 0] == -2 or faces[e, 1] == -2:
                faces[e, 0] = -1
                faces[e, 1] = -1


def edges(near: Adjacency) -> tuple[Int32, Int32]:
    """Return the edges once each, and the two faces of the regular ones.

    Returns
    -------
    ends : (e, 2) int32
        Point indices, the smaller first.
    faces : (e, 2) int32
        The face where the edge runs from ``ends[0]`` to ``ends[1]`` and the one where it runs back;
        -1 for what is missing, both -1 where more faces meet or orientations disagree.
    """
    n = len(near.kinds)
    count = len(near.ring) // 2  # every edge stands in two rings
    ends, faces = np.empty((count, 2), np.int32), np.full((count, 2), -1, np.int32)
    near_faces = (near.corner_offsets, near.corners, near.corner_face, near.offsets, near.connectivity)
    _edges(near.ring_offsets, near.ring, *near_faces, np.full(n, -1, np.int32), ends, faces)
    return ends, faces


def boundary_loops(near: Adjacency) -> list[Int32]:
    """Return the boundaries as lists of point indices, each along the direction of its faces.

    A boundary that runs through an irregular vertex is cut there and comes as an open chain, its
    regular vertices only.
    """
    at_boundary = np.flatnonzero(near.kinds == BOUNDARY)
    loops: list[Int32] = []
    seen: set[int] = set()
    before, after = near.boundary_ring[:, 0], near.boundary_ring[:, 1]
    for first in at_boundary.tolist():
        if first in seen:
            continue
        start = first
        # Back to the beginning of an open chain, or once round a closed one.
        while near.kinds[before[start]] == BOUNDARY and before[start] != first:
            start = int(before[start])
        loop = [start]
        while near.kinds[after[loop[-1]]] == BOUNDARY and after[loop[-1]] != start:
            loop.append(int(after[loop[-1]]))
        seen.update(loop)
        loops.append(np.asarray(loop, dtype=np.int32))
    return loops
