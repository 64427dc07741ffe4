"""Bilateral filtering of face normals: noise goes, creases stay.

Each normal becomes the mean of the normals round it, weighed by area and by how near they are to it in
direction: faces across a crease have no say. How near is near depends on the noise that the mesh has
now, so the filter closes in on the noise and does nothing to a mesh that has none.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ...jit import parallel
from ...jit.compiled import device, kernel
from ..measures.dihedral import measure_edges
from ..mesh.adjacency import Adjacency
from ..mesh.mesh import LARGEST_POLYGON
from ..mesh.regions import largest_around

Float64 = npt.NDArray[np.float64]
Int64 = npt.NDArray[np.int64]
Ranges = tuple[Int64, Int64]

#: Standard deviation of the weight's bell over the noise.
_REACH = 6.0

#: Weight of a face in its own mean, in the first pass; later it has none, for outliers would stay for ever.
_ITSELF = 0.6

#: Noise below this does not disturb feature detection, radians.
_NO_NOISE = np.radians(0.5)

#: Where even the flattest quarter of the edges turns by more, they are the shape of a coarse mesh, radians.
_NOT_NOISE = np.radians(30.0)

#: Vertices that the noise is measured at, at most, roughly.
_SAMPLE = 50_000

#: Bins of the histogram of dihedral angles.
_BINS = 8192

#: Edges, each from both ends, that the noise about one vertex is measured at, at least: some four rings.
_ABOUT = 192

#: Noise is uneven where more than this share of the vertices has this much more of it than the flattest
#: quarter: a factor, and an angle in radians.
_UNEVEN, _MORE, _MUCH = 0.1, 2.0, np.radians(1.0)

#: Noise turns edges both ways: to the rarer one this part at least of what goes to the other.
_OTHER_WAY = 0.25

#: Vertices about which uneven noise is looked for, at most, roughly.
_FEW = 500

#: Rings by which uneven noise is carried on: a measure that takes a quarter of the edges misses its rim.
_RIM = 3


@kernel
def _measure_unevenness(starts, ends, points, near, normals, angle, turns):
    # Angles between a face's normal and the mean of those across its edges; -1 where not each has one.
    # And how many of the edges are convex, and concave.
    for part in range(starts.size):
        for f in range(starts[part], ends[part]):
            angle[f] = -1.0
            turns[f, 0] = 0
            turns[f, 1] = 0
            begin = near.offsets[f]
            end = near.offsets[f + 1]
            if end - begin < 3 or end - begin > LARGEST_POLYGON:
                continue
            x = 0.0
            y = 0.0
            z = 0.0
            count = 0
            for c in range(begin, end):
                v = near.connectivity[c]
                w = near.connectivity[c + 1 if c + 1 < end else begin]
                for row in range(near.corner_offsets[v], near.corner_offsets[v + 1]):
                    d = near.corners[row]
                    g = near.corner_face[d]
                    a = near.offsets[g]
                    b = near.offsets[g + 1]
                    after = near.connectivity[d + 1 if d + 1 < b else a]
                    before = near.connectivity[d - 1 if d > a else b - 1]
                    if g != f and (after == w or before == w):
                        x += normals[g, 0]
                        y += normals[g, 1]
                        z += normals[g, 2]
                        count += 1
                        # Normals part where the edge is convex, on the way to the next corner beyond it.
                        u = before if after == w else after
                        turn = 0.0
                        for axis in range(3):
                            apart = normals[g, axis] - normals[f, axis]
                            turn += apart * (points[u, axis] - points[v, axis])
                        turns[f, 0] += turn > 0.0
                        turns[f, 1] += turn < 0.0
            if count != end - begin:
                continue
            cx = normals[f, 1] * z - normals[f, 2] * y
            cy = normals[f, 2] * x - normals[f, 0] * z
            cz = normals[f, 0] * y - normals[f, 1] * x
            dot = normals[f, 0] * x + normals[f, 1] * y + normals[f, 2] * z
            sine = np.sqrt(cx * cx + cy * cy + cz * cz)
            # Mean of opposite normals: it has no direction.
            if sine * sine + dot * dot >= 1e-6:
                angle[f] = np.arctan2(sine, dot)


def _sample(n: int) -> tuple[Int64, Int64]:
    # Every k-th of n as a range of its own.
    starts = np.arange(0, n, max(1, n // _SAMPLE))
    return starts, starts + 1


def _lower_quartile(angles: Float64) -> float:
    bins = np.minimum((angles * (_BINS / np.pi)).astype(np.int64), _BINS - 1)
    below = np.concatenate(([0], np.cumsum(np.bincount(bins, minlength=_BINS))))
    quarter = 0.25 * float(below[-1])
    if quarter == 0.0:
        return 0.0
    at = int(np.searchsorted(below, quarter)) - 1
    inside = (quarter - below[at]) / (below[at + 1] - below[at])
    return float(np.pi / _BINS * (at + inside))


@device
def _walk(near, v, seen, queue):
    # The vertices about v, ring by ring until there are enough edges, into the queue; returns how many.
    # `seen` holds the vertex whose neighbourhood was the last to have it.
    queue[0] = v
    seen[v] = v
    first = 0
    last = 1
    edges = 0
    while first < last and edges < _ABOUT:
        end = last
        for i in range(first, end):
            edges += near.ring_offsets[queue[i] + 1] - near.ring_offsets[queue[i]]
            for r in range(near.ring_offsets[queue[i]], near.ring_offsets[queue[i] + 1]):
                w = near.ring[r]
                if seen[w] != v:
                    seen[w] = v
                    queue[last] = w
                    last += 1
        first = end
    return first


@kernel
def _mark_about(centres, near, vertices, faces):
    seen = np.full(near.kinds.size, -1, np.int32)
    queue = np.empty(near.kinds.size, np.int32)
    for v in centres:
        for i in range(_walk(near, v, seen, queue)):
            vertices[queue[i]] = True
            for row in range(near.corner_offsets[queue[i]], near.corner_offsets[queue[i] + 1]):
                faces[near.corner_face[near.corners[row]]] = True


@kernel
def _measure_about(starts, ends, near, kind, angle, unevenness, turns, noise):
    # Lower quartiles of the dihedral angles and of the unevenness about each vertex; 0 where nearly all edges
    # turn the same way, as on coarse round parts.
    seen = np.full(near.kinds.size, -1, np.int32)
    seen_face = np.full(unevenness.size, -1, np.int32)
    queue = np.empty(near.kinds.size, np.int32)
    turning = np.empty(4 * _ABOUT)
    uneven = np.empty(4 * _ABOUT)
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            edges = 0
            faces = 0
            convex = 0
            concave = 0
            for i in range(_walk(near, v, seen, queue)):
                u = queue[i]
                for r in range(near.ring_offsets[u], near.ring_offsets[u + 1]):
                    if kind[r] == 0 and edges < turning.size:
                        turning[edges] = angle[r]
                        edges += 1
                for row in range(near.corner_offsets[u], near.corner_offsets[u + 1]):
                    f = near.corner_face[near.corners[row]]
                    if seen_face[f] != v and unevenness[f] >= 0.0 and faces < uneven.size:
                        uneven[faces] = unevenness[f]
                        faces += 1
                        convex += turns[f, 0]
                        concave += turns[f, 1]
                    seen_face[f] = v
            noise[v] = 0.0
            if faces > 0 and edges > 0 and min(convex, concave) > _OTHER_WAY * max(convex, concave):
                quartile = np.partition(turning[:edges], edges // 4)[edges // 4]
                if quartile <= _NOT_NOISE:
                    noise[v] = min(quartile, np.partition(uneven[:faces], faces // 4)[faces // 4])


class NoiseMeter:
    """Measures the noise of a mesh, again and again while its normals are filtered.

    Parameters
    ----------
    points : (n, 3) float64
    near : Adjacency
    """

    def __init__(self, points: Float64, near: Adjacency) -> None:
        self.points, self.near = points, near
        # Kept from one measuring to the next: new memory of this size costs more than what is measured.
        self._kind, self._angle = np.empty(len(near.ring), np.uint8), np.empty(len(near.ring), np.float32)
        self._bent = np.empty(len(near.kinds), np.uint8)
        self._unevenness = np.empty(len(near.offsets) - 1)
        self._turns = np.empty((len(near.offsets) - 1, 2), np.uint8)
        self._vertices, self._faces = _sample(len(self._bent)), _sample(len(self._unevenness))
        # Where in the one-rings the sample stands: only there is anything written.
        first, last = (near.ring_offsets[at] for at in self._vertices)
        sizes = last - first
        self._places = np.repeat(first - np.cumsum(sizes) + sizes, sizes) + np.arange(sizes.sum())

    def measure(self, normals: Float64) -> float:
        """Return the dihedral angle that noise alone makes in the flattest quarter of the mesh, radians.

        The lower quartile of the dihedral angles: clean models, of which half the edges may be creases, have
        none; Gaussian noise of a tenth of the edge length has some 6 degrees. But the facets of a coarse
        cylinder turn too, all alike: there normals lie in the middle of those round them. Noise prevents
        that, by as much as it makes edges turn, and the smaller of the two measures counts. On every k-th
        vertex or face of large meshes.
        """
        kind, angle = self._kind, self._angle
        parallel.run(measure_edges, *self._vertices, self.near, normals, 2.0, kind, angle, self._bent)
        turning = _lower_quartile(angle[self._places[kind[self._places] == 0]].astype(np.float64))
        if turning > _NOT_NOISE:
            return 0.0
        parallel.run(
            _measure_unevenness, *self._faces, self.points, self.near, normals, self._unevenness, self._turns
        )
        unevenness = self._unevenness[self._faces[0]]
        return min(turning, _lower_quartile(unevenness[unevenness >= 0.0]))

    def local(self, normals: Float64) -> Float64:
        """Return the noise about each vertex, (n,), radians: :meth:`measure`'s measures in some four rings.

        The rim of a noisy part counts to it.
        """
        every, faces = parallel.ranges(len(self._bent)), parallel.ranges(len(self._unevenness))
        return largest_around(self.near, self._about(normals, every, faces, every), _RIM)

    def is_uneven(self, normals: Float64, noise: float) -> bool:
        """Return whether a part of the mesh is much noisier than `noise`, what :meth:`measure` returned."""
        few = np.arange(0, len(self._bent), max(1, len(self._bent) // _FEW))
        vertices, faces = np.zeros(len(self._bent), np.bool_), np.zeros(len(self._unevenness), np.bool_)
        _mark_about(few, self.near, vertices, faces)
        near_them, of_them = np.flatnonzero(vertices), np.flatnonzero(faces)
        about = self._about(normals, (near_them, near_them + 1), (of_them, of_them + 1), (few, few + 1))
        return float(np.mean(about[few] > _MORE * noise + _MUCH)) > _UNEVEN

    def _about(self, normals: Float64, vertices: Ranges, faces: Ranges, centres: Ranges) -> Float64:
        # About the `centres`; edges at `vertices` and `faces` are looked at.
        kind, angle, unevenness = self._kind, self._angle, self._unevenness
        parallel.run(measure_edges, *vertices, self.near, normals, 2.0, kind, angle, self._bent)
        parallel.run(_measure_unevenness, *faces, self.points, self.near, normals, unevenness, self._turns)
        noise = np.zeros(len(self._bent))
        parallel.run(
            _measure_about, *centres, self.near, kind, angle, unevenness, self._turns, noise,
            smallest_share=parallel.COSTLY,
        )  # fmt: skip
        return noise


@kernel
def _filter_normals(starts, ends, near, noise, itself, normals, filtered):
    # (1 - x / 8)^8 for exp(-x) with x = |difference|^2 / (2 reach^2): no exponential, and an end.
    # `noise`: of all faces, or of each vertex.
    left = noise[0]
    for part in range(starts.size):
        for f in range(starts[part], ends[part]):
            if noise.size > 1:
                left = 0.0
                for c in range(near.offsets[f], near.offsets[f + 1]):
                    left = max(left, noise[near.connectivity[c]])
                if left < _NO_NOISE:
                    for axis in range(4):
                        filtered[f, axis] = normals[f, axis]
                    continue
            scale = 0.0625 / ((_REACH * left) * (_REACH * left))
            x = normals[f, 0]
            y = normals[f, 1]
            z = normals[f, 2]
            sx = 0.0
            sy = 0.0
            sz = 0.0
            for c in range(near.offsets[f], near.offsets[f + 1]):
                v = near.connectivity[c]
                first = near.corner_offsets[v]
                last = near.corner_offsets[v + 1]
                # Of a hub with very many faces some, evenly spread, stand for all.
                for row in range(first, last, 1 + (last - first) // 64):
                    g = near.corner_face[near.corners[row]]
                    dx = normals[g, 0] - x
                    dy = normals[g, 1] - y
                    dz = normals[g, 2] - z
                    w = max(0.0, 1.0 - scale * (dx * dx + dy * dy + dz * dz))
                    w *= w
                    w *= w
                    w *= w * normals[g, 3]
                    if g == f:
                        w *= itself
                    sx += w * normals[g, 0]
                    sy += w * normals[g, 1]
                    sz += w * normals[g, 2]
            filtered[f, 0] = x
            filtered[f, 1] = y
            filtered[f, 2] = z
            filtered[f, 3] = normals[f, 3]
            largest = max(abs(sx), abs(sy), abs(sz))
            if largest > 0.0:
                sx /= largest
                sy /= largest
                sz /= largest
                scale_back = 1.0 / np.sqrt(sx * sx + sy * sy + sz * sz)
                filtered[f, 0] = sx * scale_back
                filtered[f, 1] = sy * scale_back
                filtered[f, 2] = sz * scale_back


def filter_normals(meter: NoiseMeter, normals: Float64, noise: Float64, passes: int = 4) -> Float64:
    """Return filtered normals, in the form of :func:`~vtksmooth.kernels.measures.dihedral.face_normals`.

    `noise` is what they have: one number for all, (1,), or one for each vertex, (n,). Each pass reaches as
    far in direction as six times the noise that is left; none is done where there is hardly any.
    """
    result = normals
    spare = np.empty_like(normals)
    for turn in range(passes):
        if turn > 0:
            noise = np.array([meter.measure(result)]) if len(noise) == 1 else meter.local(result)
        if noise.max(initial=0.0) < _NO_NOISE:
            break
        itself = _ITSELF if turn == 0 else 0.0
        parallel.run(
            _filter_normals, *parallel.ranges(len(normals)), meter.near, noise, itself, result, spare,
            smallest_share=parallel.COSTLY,
        )  # fmt: skip
        result, spare = spare, result if result is not normals else np.empty_like(normals)
    return result
