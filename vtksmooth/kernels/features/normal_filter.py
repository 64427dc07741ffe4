"""Bilateral filtering of face normals: noise goes, creases stay.

Each normal becomes the mean of the normals round it, weighed by area and by how near they are to it in
direction: faces across a crease have no say. How near is near depends on the noise that the mesh has
now, so the filter closes in on the noise and does nothing to a mesh that has none.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ...jit import parallel
from ...jit.compiled import kernel
from ..measures.dihedral import measure_edges
from ..mesh.adjacency import Adjacency
from ..mesh.mesh import LARGEST_POLYGON

Float64 = npt.NDArray[np.float64]
Int64 = npt.NDArray[np.int64]

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


@kernel
def _measure_unevenness(starts, ends, near, normals, angle):
    # Angles between a face's normal and the mean of those across its edges; -1 where not each has one.
    for part in range(starts.size):
        for f in range(starts[part], ends[part]):
            angle[f] = -1.0
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


class NoiseMeter:
    """Measures the noise of a mesh, again and again while its normals are filtered.

    Parameters
    ----------
    near : Adjacency
    """

    def __init__(self, near: Adjacency) -> None:
        self.near = near
        # Kept from one measuring to the next: new memory of this size costs more than what is measured.
        self._kind, self._angle = np.empty(len(near.ring), np.uint8), np.empty(len(near.ring), np.float32)
        self._bent = np.empty(len(near.kinds), np.uint8)
        self._unevenness = np.empty(len(near.offsets) - 1)
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
        parallel.run(_measure_unevenness, *self._faces, self.near, normals, self._unevenness)
        unevenness = self._unevenness[self._faces[0]]
        return min(turning, _lower_quartile(unevenness[unevenness >= 0.0]))


@kernel
def _filter_normals(starts, ends, near, reach, itself, normals, filtered):
    # (1 - x / 8)^8 for exp(-x) with x = |difference|^2 / (2 reach^2): no exponential, and an end.
    scale = 0.0625 / (reach * reach)
    for part in range(starts.size):
        for f in range(starts[part], ends[part]):
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


def filter_normals(meter: NoiseMeter, normals: Float64, left: float, passes: int = 4) -> Float64:
    """Return filtered normals, in the form of :func:`~vtksmooth.kernels.measures.dihedral.face_normals`.

    `left` is the noise that they have. Each pass reaches as far in direction as six times the noise that is
    left; none is done once there is hardly any.
    """
    result = normals
    spare = np.empty_like(normals)
    for turn in range(passes):
        if turn > 0:
            left = meter.measure(result)
        if left < _NO_NOISE:
            break
        itself = _ITSELF if turn == 0 else 0.0
        parallel.run(
            _filter_normals, *parallel.ranges(len(normals)), meter.near, _REACH * left, itself, result,
            spare, smallest_share=parallel.COSTLY,
        )  # fmt: skip
        result, spare = spare, result if result is not normals else np.empty_like(normals)
    return result
