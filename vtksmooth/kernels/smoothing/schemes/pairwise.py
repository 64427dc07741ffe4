"""Pairwise smoothing: both ends of an edge move at once, and the volume stays as it was, exactly."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ....errors import InvalidMeshError
from ....jit import parallel
from ....jit.compiled import device, kernel, routine
from ...containment.crossings import scratch
from ...containment.safe_moves import Guard, may_go, pending, settle, spread, stars_may_go
from ...mesh.adjacency import Adjacency
from ..constraints import Constraint
from ..constraints.local_volume import LocalVolume
from ..constraints.no_inversion import HALVINGS
from ..run_state import State
from ..weights import Weights
from . import Admitted, EdgeScheme, Float64, Operations

Bool = npt.NDArray[np.bool_]
Int32 = npt.NDArray[np.int32]
Int64 = npt.NDArray[np.int64]

#: Vertices of a block: its rows fit a core's second-level cache.
BLOCK_SIZE = 2048

#: Vertices whose edges are in batches together: enough to do for each call, and near each other in memory.
BATCHED = 8192

#: Part of the steps that is tried where the space does not allow all.
_RETRIED = 0.25

#: The two rows of an edge's system are the same up to rounding: the pair has no best place.
_SINGULAR = 1e-12

#: Part of the squared steps that is left when the volume takes all of them back, up to rounding. Of less than
#: 1e-15 rounding tells whether the energy falls, and steps of 1e-8 are taken in one pose and not in another.
_TAKEN_BACK = 1e-14


class Edges(NamedTuple):
    """The edges in the order of the sweep, and the rings of their ends.

    Attributes
    ----------
    ends : (e, 2) int32
        Block after block; inside a block in colours of edges that share no vertex, so that successive
        operations lie apart.
    blocks : list of (starts, ends)
        For each colour the ranges of edges of the blocks of this colour; no two of them touch the same
        vertices, nor these the same Laplacians.
    offsets, ring : int32
        The one-rings in cyclic order, seen from outside counter-clockwise.
    mirror : int32
        For each entry of `ring`, where its vertex' own row (in the order of the weights) names v.
    """

    ends: Int32
    blocks: list[tuple[Int64, Int64]]
    offsets: Int32
    ring: Int32
    mirror: Int32


@kernel
def _cyclic_rings(near, offsets, neighbours, after, held, ring, mirror):
    for v in range(offsets.size - 1):
        first = offsets[v]
        last = offsets[v + 1]
        for r in range(first, last):
            ring[r] = neighbours[r]
        if near.kinds[v] != 0:
            held[v] = 1
        else:
            for i in range(near.corner_offsets[v], near.corner_offsets[v + 1]):
                a = near.offsets[near.corner_face[near.corners[i]]]
                c = near.corners[i] - a
                after[near.connectivity[a + (c + 1) % 3]] = near.connectivity[a + (c + 2) % 3]
            for r in range(first + 1, last):
                ring[r] = after[ring[r - 1]]
                # Back at the beginning too soon: several fans that touch in v only.
                held[v] = held[v] or ring[r] == ring[first]
    for v in range(offsets.size - 1):
        for r in range(offsets[v], offsets[v + 1]):
            k = ring[r]
            for q in range(offsets[k], offsets[k + 1]):
                if neighbours[q] == v:
                    mirror[r] = q


@device
def _bit(colour):
    return np.uint64(1) << np.uint64(colour)


@device
def _lowest_free(used):
    colour = 0
    while colour < 63 and used & _bit(colour):
        colour += 1
    return colour


@kernel
def _schedule(ends, block_of, offsets, ring, colour, order, starts, block_colour, touched):
    # touched: which colours of edges, and then of blocks, have touched a vertex already, a bit for each.
    for e in range(block_of.size):
        starts[block_of[e] + 1] += 1
        i = ends[e, 0]
        j = ends[e, 1]
        free = _lowest_free(touched[i] | touched[j])
        colour[e] = free
        touched[i] |= _bit(free)
        touched[j] |= _bit(free)
    for v in range(touched.size):
        touched[v] = 0
    alone = 63  # blocks that find no bit free run by themselves
    for b in range(block_colour.size):
        starts[b + 1] += starts[b]
        # Stable counting sort of the block's edges by their colour.
        k = starts[b]
        used = np.uint64(0)
        for c in range(64):
            for e in range(starts[b], starts[b + 1]):
                if colour[e] == c:
                    order[k] = e
                    k += 1
            if k == starts[b + 1]:
                break
        for e in range(starts[b], starts[b + 1]):
            for end in range(2):
                v = ends[e, end]
                used |= touched[v]
                for r in range(offsets[v], offsets[v + 1]):
                    used |= touched[ring[r]]
        free = _lowest_free(used)
        if free == 63:
            block_colour[b] = alone
            alone += 1
            continue
        block_colour[b] = free
        for e in range(starts[b], starts[b + 1]):
            for end in range(2):
                v = ends[e, end]
                touched[v] |= _bit(free)
                for r in range(offsets[v], offsets[v + 1]):
                    touched[ring[r]] |= _bit(free)


def edges_of(
    near: Adjacency, rows: tuple[Int32, Int32], pinned: npt.NDArray[np.uint8], block_size: int = BLOCK_SIZE
) -> Edges:
    """Return the edges with an end that may move; vertices where the surface is no disc are pinned.

    Vertices should be in a coherent order: the blocks are made of successive ones.
    """
    offsets, neighbours = rows
    n = len(near.kinds)
    ring, mirror = np.empty_like(neighbours), np.zeros_like(neighbours)
    _cyclic_rings(near, offsets, neighbours, np.full(n, -1, np.int32), pinned, ring, mirror)
    vertex = np.repeat(np.arange(n, dtype=np.int32), np.diff(near.ring_offsets))
    once = near.ring > vertex
    once &= (pinned[vertex] == 0) | (pinned[near.ring] == 0)
    ends = np.column_stack((vertex[once], near.ring[once]))
    order, blocks = in_blocks(ends, offsets, ring, block_size)
    return Edges(np.ascontiguousarray(ends[order]), blocks, offsets, ring, mirror)


def in_blocks(
    ends: Int32, offsets: Int32, ring: Int32, block_size: int = BLOCK_SIZE
) -> tuple[Int64, list[tuple[Int64, Int64]]]:
    """Return the order in which to visit the edges with these ends, and the blocks of each colour.

    See :class:`Edges`; an operation changes the ends, and what belongs to the vertices of their rings.
    """
    n = len(offsets) - 1
    blocks = -(-n // block_size)
    order = np.empty(len(ends), np.int64)
    starts = np.zeros(blocks + 1, np.int64)
    block_colour = np.empty(blocks, np.int32)
    _schedule(
        ends, ends[:, 0] // block_size, offsets, ring, np.empty(len(ends), np.int8), order, starts,
        block_colour, np.zeros(n, np.uint64),
    )  # fmt: skip
    colours = [np.flatnonzero(block_colour == c) for c in np.unique(block_colour)]
    return order, [(starts[chosen], starts[chosen + 1]) for chosen in colours]


def batches_of(ends: Int32, offsets: Int32, ring: Int32, size: int = BATCHED) -> list[Int64]:
    """Return which edges can be judged at the same time: no two of a batch change the same Laplacians.

    Batches of the first `size` vertices come first, and so on.
    """
    count = len(ends)
    colour, left = np.full(count, -1), np.arange(count)
    while len(left):
        # Each edge is a block.
        found = np.empty(len(left), np.int32)
        _schedule(
            ends[left], np.arange(len(left)), offsets, ring, np.empty(len(left), np.int8),
            np.empty(len(left), np.int64), np.zeros(len(left) + 1, np.int64), found,
            np.zeros(len(offsets) - 1, np.uint64),
        )  # fmt: skip
        first = int(colour.max()) + 1
        colour[left] = np.where(found < 63, first + found, -1)
        left = left[found >= 63]
    region = ends[:, 0] // size
    order = np.lexsort((ends[:, 0], colour, region))
    changes = (np.diff(region[order]) != 0) | (np.diff(colour[order]) != 0)
    return np.split(order, np.flatnonzero(changes) + 1)


@kernel
def _reverse(starts, ends, offsets, ring, mirror, weights, kinds, reverse, rows):
    # reverse[r]: the weight of v in the Laplacian of its neighbour; rows[v, 7]: the sum of squares of all
    # coefficients of p_v. Laplacians where the surface has a boundary or is no surface do not count.
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            total = 1.0 if kinds[v] == 0 else 0.0
            for r in range(offsets[v], offsets[v + 1]):
                reverse[r] = weights[mirror[r]] if kinds[ring[r]] == 0 else 0.0
                total += reverse[r] * reverse[r]
            rows[v, 7] = total


@kernel
def _cross(starts, ends, edges, offsets, ring, reverse, cross):
    # Sum over all Laplacians of the product of the coefficients of p_i and p_j.
    for part in range(starts.size):
        for e in range(starts[part], ends[part]):
            i = edges[e, 0]
            j = edges[e, 1]
            total = 0.0
            for r in range(offsets[i], offsets[i + 1]):
                k = ring[r]
                if k == j:
                    total -= reverse[r]
                for q in range(offsets[j], offsets[j + 1]):
                    if ring[q] == k:
                        total += reverse[r] * reverse[q]
            for q in range(offsets[j], offsets[j + 1]):
                if ring[q] == i:
                    total -= reverse[q]
            cross[e] = total


@kernel
def _fill(starts, ends, points, laplacian, kinds, damping, factor, rows):
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            for axis in range(3):
                rows[v, axis] = points[v, axis]
                rows[v, 3 + axis] = laplacian[v, axis] if kinds[v] == 0 else 0.0
            rows[v, 6] = factor * damping[v]


# -- one operation: what the kernel of the sweep is made of. d[end], f[end] and g[end] are the step of an
# end of the edge, the force on it (the energy's gradient, negative) and the gradient of the volume.


@device
def _look_round(end, v, other, rows, first, last, ring, reverse, f, g):
    # f = -sum_k A_k L(k), g = 1/6 sum of a x b over the ring; returns (d - c) / 6 if that runs c, other, d.
    ux = 0.0
    uy = 0.0
    uz = 0.0
    x = rows[v, 0]
    y = rows[v, 1]
    z = rows[v, 2]
    rx = rows[v, 3]
    ry = rows[v, 4]
    rz = rows[v, 5]
    gx = 0.0
    gy = 0.0
    gz = 0.0
    k = ring[last - 1]
    bx = rows[k, 0] - x
    by = rows[k, 1] - y
    bz = rows[k, 2] - z
    for r in range(first, last):
        before = k
        k = ring[r]
        ax = bx
        ay = by
        az = bz
        bx = rows[k, 0] - x
        by = rows[k, 1] - y
        bz = rows[k, 2] - z
        gx += ay * bz - az * by
        gy += az * bx - ax * bz
        gz += ax * by - ay * bx
        rx -= reverse[r] * rows[k, 3]
        ry -= reverse[r] * rows[k, 4]
        rz -= reverse[r] * rows[k, 5]
        if before == other:
            ux += bx / 6.0
            uy += by / 6.0
            uz += bz / 6.0
        elif k == other:
            ux -= ax / 6.0
            uy -= ay / 6.0
            uz -= az / 6.0
    f[end, 0] = rx
    f[end, 1] = ry
    f[end, 2] = rz
    g[end, 0] = gx / 6.0
    g[end, 1] = gy / 6.0
    g[end, 2] = gz / 6.0
    return ux, uy, uz


@device
def _keep_volume(si, sj, ux, uy, uz, g, d):
    # i moves by d0, then j by d1: g_i . d0 + (g_j - d0 x u) . d1. If only one end moves, u has no effect.
    g[1, 0] -= d[0, 1] * uz - d[0, 2] * uy
    g[1, 1] -= d[0, 2] * ux - d[0, 0] * uz
    g[1, 2] -= d[0, 0] * uy - d[0, 1] * ux
    volume = 0.0
    for axis in range(3):
        volume += g[0, axis] * d[0, axis] + g[1, axis] * d[1, axis]
    g[0, 0] += d[1, 1] * uz - d[1, 2] * uy
    g[0, 1] += d[1, 2] * ux - d[1, 0] * uz
    g[0, 2] += d[1, 0] * uy - d[1, 1] * ux
    # Both by the same w, -volume g / |g|^2 with g = s_i g_i + s_j g_j, each damped as its step was.
    square = 0.0
    for axis in range(3):
        g[0, axis] = si * g[0, axis] + sj * g[1, axis]
        square += g[0, axis] * g[0, axis]
    if volume != 0.0:
        for axis in range(3):
            w = -volume / square * g[0, axis]
            d[0, axis] += si * w
            d[1, axis] += sj * w


@device
def _square(d):
    total = 0.0
    for axis in range(3):
        total += d[0, axis] * d[0, axis] + d[1, axis] * d[1, axis]
    return total


@device
def _energy_change(cii, cjj, cij, f, d):
    change = 0.0
    for axis in range(3):
        di = d[0, axis]
        dj = d[1, axis]
        change += 0.5 * (cii * di * di + cjj * dj * dj) + cij * di * dj
        change -= f[0, axis] * di + f[1, axis] * dj
    return change


@device
def _move(v, end, rows, d):
    if rows[v, 6] > 0.0:
        for axis in range(3):
            rows[v, axis] += d[end, axis]


@device
def _try_both(guard, i, j, rows, d, old, room, new):
    # Whether the triangles round both ends, too, may be where the steps take them; that is tried out.
    for axis in range(3):
        old[0, axis] = rows[i, axis]
        old[1, axis] = rows[j, axis]
    _move(i, 0, rows, d)
    _move(j, 1, rows, d)
    first = i if rows[i, 6] > 0.0 else -1
    second = j if rows[j, 6] > 0.0 else -1
    good, count = stars_may_go(guard, rows, first, second, room, new)
    if good:
        settle(guard.separation, rows, first, second, new, count)
        spread(guard.separation.triangles, guard.slack, rows, first, second, new, count)
    for axis in range(3):
        rows[i, axis] = old[0, axis]
        rows[j, axis] = old[1, axis]
    return good


@routine
def _may_both_go(guard, i, j, rows, d, step_i, step_j, old, room, new):
    # Whether both ends may take their steps, and how many distances that took.
    good = True
    asked = 0
    exact = guard.exact
    for end in range(2):
        v = i if end == 0 else j
        step = step_i if end == 0 else step_j
        if exact:
            step = np.inf  # triangles may not go as far as their corners
        if good and rows[v, 6] > 0.0:
            good, queries = may_go(
                guard, v, rows[v, 0] + d[end, 0], rows[v, 1] + d[end, 1], rows[v, 2] + d[end, 2], step,
                room[0],
            )  # fmt: skip
            asked += queries
    if good and exact:
        good = _try_both(guard, i, j, rows, d, old, room, new)
    return good, asked


@device
def _update_laplacians(v, end, rows, first, last, ring, reverse, d):
    if rows[v, 6] == 0.0:
        return
    dx = d[end, 0]
    dy = d[end, 1]
    dz = d[end, 2]
    rows[v, 3] -= dx
    rows[v, 4] -= dy
    rows[v, 5] -= dz
    for r in range(first, last):
        k = ring[r]
        rows[k, 3] += reverse[r] * dx
        rows[k, 4] += reverse[r] * dy
        rows[k, 5] += reverse[r] * dz


@device
def _steps(i, j, si, sj, cross, offsets, ring, reverse, rows, f, g, d):
    # The steps d of both ends, damped by si and sj, that keep the volume; returns whether they are any good.
    cii = rows[i, 7]
    cjj = rows[j, 7]
    # The place is sought of the ends that move.
    cij = cross if si > 0.0 and sj > 0.0 else 0.0
    det = cii * cjj - cij * cij
    if (si == 0.0 and sj == 0.0) or not det > _SINGULAR * (cii * cjj):
        return False
    ux = 0.0
    uy = 0.0
    uz = 0.0
    for end in range(2):
        v = i if end == 0 else j
        other = j if end == 0 else -1
        wx, wy, wz = _look_round(end, v, other, rows, offsets[v], offsets[v + 1], ring, reverse, f, g)
        ux += wx
        uy += wy
        uz += wz
    for axis in range(3):
        d[0, axis] = si * ((cjj * f[0, axis] - cij * f[1, axis]) / det)
        d[1, axis] = sj * ((cii * f[1, axis] - cij * f[0, axis]) / det)
    wanted = _square(d)
    _keep_volume(si, sj, ux, uy, uz, g, d)
    # What the volume takes back but for rounding is no step.
    if _square(d) <= _TAKEN_BACK * wanted:
        return False
    # The correction may take more than the steps have won; and where the ends' g cancel, at cusps,
    # there is none of reasonable size. Then the energy would grow.
    return _energy_change(cii, cjj, cij, f, d) < 0.0


@kernel
def _sweep(starts, ends, edges, cross, offsets, ring, reverse, rows, guard):
    # rows[v]: position, Laplacian, damping, sum of squared coefficients: a line of the cache.
    moved = 0
    checked = 0
    asked = 0
    room = scratch()
    new = pending(guard)
    old = np.empty((2, 3))
    d = np.empty((2, 3))
    g = np.empty((2, 3))
    f = np.empty((2, 3))
    slack_i = 0.0
    slack_j = 0.0
    active, slack = guard.active, guard.slack
    for part in range(starts.size):
        for e in range(starts[part], ends[part]):
            i = edges[e, 0]
            j = edges[e, 1]
            # What the space does not allow is tried once more with a part of the steps, which keeps the
            # volume, too: mostly the ends are at a wall already, and more trials would be in vain.
            share = 1.0
            for _ in range(2):
                si = share * rows[i, 6]
                sj = share * rows[j, 6]
                if not _steps(i, j, si, sj, cross[e], offsets, ring, reverse, rows, f, g, d):
                    break
                if active:
                    slack_i = slack[i]
                    slack_j = slack[j]
                    step_i = np.sqrt(d[0, 0] * d[0, 0] + d[0, 1] * d[0, 1] + d[0, 2] * d[0, 2])
                    step_j = np.sqrt(d[1, 0] * d[1, 0] + d[1, 1] * d[1, 1] + d[1, 2] * d[1, 2])
                    checked += (si > 0.0) + (sj > 0.0)
                    # Here and not in a helper: handing over the guard costs as much as a quarter of an
                    # operation.
                    if step_i <= slack_i and step_j <= slack_j:
                        slack[i] -= step_i
                        slack[j] -= step_j
                    else:
                        good, queries = _may_both_go(guard, i, j, rows, d, step_i, step_j, old, room, new)
                        asked += queries
                        if not good:
                            slack[i] = slack_i
                            slack[j] = slack_j
                            share = _RETRIED
                            continue
                for end in range(2):
                    v = i if end == 0 else j
                    _move(v, end, rows, d)
                    _update_laplacians(v, end, rows, offsets[v], offsets[v + 1], ring, reverse, d)
                moved += 1
                break
    return moved, checked, asked


@kernel
def _propose(starts, ends, chosen, edges, cross, offsets, ring, reverse, rows, part, steps, good, proposed):
    # The steps of the `chosen` edges, `part` of what they usually are each, and whether there are any.
    g = np.empty((2, 3))
    f = np.empty((2, 3))
    for share in range(starts.size):
        for k in range(starts[share], ends[share]):
            e = chosen[k]
            i = edges[e, 0]
            j = edges[e, 1]
            d = steps[k]
            si = part[k] * rows[i, 6]
            sj = part[k] * rows[j, 6]
            good[k] = _steps(i, j, si, sj, cross[e], offsets, ring, reverse, rows, f, g, d)
            for axis in range(3):
                proposed[i, axis] = rows[i, axis] + d[0, axis] if si > 0.0 else rows[i, axis]
                proposed[j, axis] = rows[j, axis] + d[1, axis] if sj > 0.0 else rows[j, axis]


@kernel
def _carry_out(starts, ends, chosen, edges, offsets, ring, reverse, steps, guard, good, rows, points):
    # The steps that are `good`; then that is what has been done.
    moved = 0
    checked = 0
    asked = 0
    room = scratch()
    new = pending(guard)
    old = np.empty((2, 3))
    for share in range(starts.size):
        for k in range(starts[share], ends[share]):
            if not good[k]:
                continue
            i = edges[chosen[k], 0]
            j = edges[chosen[k], 1]
            d = steps[k]
            if guard.active:
                slack_i = guard.slack[i]
                slack_j = guard.slack[j]
                step_i = np.sqrt(d[0, 0] * d[0, 0] + d[0, 1] * d[0, 1] + d[0, 2] * d[0, 2])
                step_j = np.sqrt(d[1, 0] * d[1, 0] + d[1, 1] * d[1, 1] + d[1, 2] * d[1, 2])
                checked += (rows[i, 6] > 0.0) + (rows[j, 6] > 0.0)
                good[k], queries = _may_both_go(guard, i, j, rows, d, step_i, step_j, old, room, new)
                asked += queries
                if not good[k]:
                    guard.slack[i] = slack_i
                    guard.slack[j] = slack_j
                    continue
            for end in range(2):
                v = i if end == 0 else j
                _move(v, end, rows, d)
                _update_laplacians(v, end, rows, offsets[v], offsets[v + 1], ring, reverse, d)
                for axis in range(3):
                    points[v, axis] = rows[v, axis]
            moved += 1
    return moved, checked, asked


@kernel
def _take(starts, ends, rows, points):
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            if rows[v, 6] != 0.0:
                for axis in range(3):
                    points[v, axis] = rows[v, axis]


class Pairwise(EdgeScheme):
    """Pairwise smoothing with exact volume (Liu, Bao, Shum and Peng 2002), for triangles.

    For each edge (i, j) the places of both ends are sought that minimise ``E = 1/2 sum |L(k)|^2`` over the
    rings of both, L the general Laplacian; the steps are damped; then both ends move along one vector so
    that the volume under the two stars is what it was. As i and j move along the *same* vector, the
    volume is linear in it, whatever the damping: the correction is exact, on open surfaces too (there
    the volume swept is nothing), and a vertex with damping 0 keeps its bits.

    An operation that would raise E is discarded, so E of the whole mesh never grows while the weights are
    what they are. The paper does not ask for that; without it sheets between fixed boundaries, where
    volume and smoothness pull against each other, leave all bounds within some dozens of sweeps.

    Laplacians on the boundary, where the surface is no disc, and at irregular vertices do not count; these
    vertices do not move.

    Parameters
    ----------
    relaxation : float
        Part of the steps that is taken, (0, 1].
    weights : Weights, optional
        Of the Laplacian (default: umbrella); refreshed before every sweep, constant within it.

    Notes
    -----
    Sections 5.2 and 5.4 of the installation-space paper. One operation costs O(valence): the Laplacians
    are kept up to date. Each edge is visited once in a sweep, in an order by topology; edges whose
    operations could meet are never worked on at the same time, so the number of threads does not matter.
    """

    keeps = frozenset({"volume"})

    def __init__(self, relaxation: float = 0.7, weights: Weights | None = None) -> None:
        self.relaxation, self.asked_weights = relaxation, weights or Weights()

    def closing(self) -> Constraint | None:
        return LocalVolume(0, True, whole=True)

    def bind(self, state: State) -> None:
        if not state.topology.only_triangles:
            raise InvalidMeshError(
                "Pairwise smoothing needs triangles; triangulate the polygons first (ValenceTriangulation)."
            )
        self.weights = self.asked_weights.in_run(state)
        near = state.near
        self.edges = edges_of(near, self.weights.rows(near), state.pinned)
        # A row is a line of the cache if the first one begins with one.
        room = np.zeros(8 * len(state.points) + 8)
        first = -(room.ctypes.data // 8) % 8
        self.rows = room[first : first + 8 * len(state.points)].reshape(-1, 8)
        self.values: Float64 | None = None
        self.cross = np.empty(len(self.edges.ends))
        self.reverse = np.empty(len(self.edges.ring))
        self.laplacian, self.proposed = np.empty_like(state.points), np.empty_like(state.points)
        self.batches: list[Int64] = []

    def prepare(self, state: State, turn: int) -> None:
        near, edges = state.near, self.edges
        everything = parallel.ranges(len(state.points))
        if self.values is None or not self.weights.constant:
            self.values = self.weights.compute(state.points, near, self.values)
            parallel.run(
                _reverse, *everything,
                edges.offsets, edges.ring, edges.mirror, self.values, near.kinds, self.reverse, self.rows,
            )  # fmt: skip
            parallel.run(
                _cross, *parallel.ranges(len(edges.ends)),
                edges.ends, edges.offsets, edges.ring, self.reverse, self.cross,
            )  # fmt: skip
        # The Laplacians anew: rounding errors do not pile up.
        self.weights.apply(state.points, near, self.values, self.laplacian)

    def sweep(
        self, state: State, damping: Float64, guard: Guard, admitted: Admitted | None = None
    ) -> Iterator[Operations]:
        edges = self.edges
        everything = parallel.ranges(len(state.points))
        parallel.run(
            _fill, *everything,
            state.points, self.laplacian, state.near.kinds, damping, self.relaxation, self.rows,
        )  # fmt: skip
        if admitted is not None:
            self.batches = self.batches or batches_of(edges.ends, edges.offsets, edges.ring)
            for number, batch in enumerate(self.batches):
                done = in_halves(
                    state, batch, edges.ends, admitted, self._propose, partial(self._do, state, guard)
                )
                yield Operations((number + 1) / len(self.batches), *done)
            return
        for number, (starts, ends) in enumerate(edges.blocks):
            results = parallel.run(
                _sweep, starts, ends,
                edges.ends, self.cross, edges.offsets, edges.ring, self.reverse, self.rows, guard,
                smallest_share=parallel.COSTLY,
            )  # fmt: skip
            # What observers see, and whoever cancels, is whole.
            parallel.run(_take, *everything, self.rows, state.points)
            moved, checked, asked = (sum(counts) for counts in zip(*results, strict=True))
            yield Operations((number + 1) / len(edges.blocks), moved, checked, asked)

    def _propose(self, batch: Int64, part: Float64) -> tuple[Float64, Float64, Bool]:
        edges, steps, good = self.edges, np.empty((len(batch), 2, 3)), np.empty(len(batch), np.bool_)
        parallel.run(
            _propose, *parallel.ranges(len(batch), size=64),
            batch, edges.ends, self.cross, edges.offsets, edges.ring, self.reverse, self.rows,
            part, steps, good, self.proposed, smallest_share=parallel.COSTLY,
        )  # fmt: skip
        return self.proposed, steps, good

    def _do(self, state: State, guard: Guard, batch: Int64, steps: Float64, good: Bool) -> Int64:
        edges = self.edges
        results = parallel.run(
            _carry_out, *parallel.ranges(len(batch), size=64),
            batch, edges.ends, edges.offsets, edges.ring, self.reverse, steps, guard, good, self.rows,
            state.points, smallest_share=parallel.COSTLY,
        )  # fmt: skip
        return np.asarray(np.sum(results, axis=0))


def in_halves(
    state: State,
    batch: Int64,
    ends: Int32,
    admitted: Admitted,
    propose: Callable[[Int64, Float64], tuple[Float64, Float64, Bool]],
    carry_out: Callable[[Int64, Float64, Bool], Int64],
) -> list[int]:
    """Do the operations on a batch of edges that are admitted, as they are or halved some times.

    A half of an operation is one that keeps the volume, too.

    Parameters
    ----------
    batch : (k,) int64
        Edges by their places in `ends`.
    propose : callable
        ``propose(batch, part)`` returns where the ends of the edges are moved to, (n, 3), by `part` of what
        they usually do each; the steps, (k, 2, 3); and which of them are any good, (k,) bool.
    carry_out : callable
        ``carry_out(batch, steps, good)`` does those that are `good`, and makes False of what it does not do.
        Returns how many were done, how many moves were judged, and how many distances asked for.

    Returns
    -------
    list of int
        The sums of what `carry_out` returned.
    """
    counts, part = np.zeros(3, np.int64), np.ones(len(batch))
    for _ in range(HALVINGS + 1):
        if not len(batch):
            break
        proposed, steps, good = propose(batch, part)
        batch, steps, part = batch[good], steps[good], part[good]
        left = admitted(state, ends[batch], proposed)
        good = left == 1.0
        counts += carry_out(batch, steps, good)
        again = ~good & (left >= 0.5**HALVINGS)
        batch, left = batch[again], np.minimum(left[again], 0.5)
        part = part[again] * 2.0 ** np.floor(np.log2(left))
    return list(counts.tolist())
