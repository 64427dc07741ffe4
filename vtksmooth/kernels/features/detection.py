"""Feature detection: vertices on ridges, at corners and cusps, and the ridge lines (Jiao, section 4)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ...errors import ParameterError
from ...jit import parallel
from ...jit.compiled import device, kernel
from ..measures.dihedral import face_normals, measure_edges
from ..mesh.adjacency import Adjacency
from ..mesh.mesh import Mesh
from ..mesh.union_find import find_root, join
from .metric_tensor import WEIGHTS, corner_angle, eigen, metric_tensor
from .normal_filter import NoiseMeter, filter_normals
from .paper import detect_as_printed

Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
UInt8 = npt.NDArray[np.uint8]

#: Classes of vertices.
SMOOTH, RIDGE, CORNER, CUSP = 0, 1, 2, 3

#: Kinds of edges: two faces, one face, more.
REGULAR, BOUNDARY, NON_MANIFOLD = 0, 1, 2

#: Ours, which holds up amid noise, and the paper's as printed.
METHODS = ("robust", "paper")

#: Thresholds that the mesh chooses.
AUTO = "auto"

#: Smallest angles that :data:`AUTO` chooses, degrees: those of the paper.
RIDGE_ANGLE, CORNER_ANGLE = 20.0, 35.0

#: Largest ridge angle that :data:`AUTO` chooses, degrees.
LARGEST_RIDGE_ANGLE = 60.0

#: Angles must exceed their thresholds by this much, radians: cylinders of 24 sides turn by just 15 degrees.
_SPARE = 1e-3

#: At a cusp the surface folds back on itself: squared sine of what its normals may differ by, up to their
#: signs. The share of the first eigenvalue below which a direction says nothing (Jiao, section 3.1).
_CUSP = 0.003

#: An edge is strong from this many ridge angles; weak edges need a strong one, or to be this many together.
_STRONG, _LONG = 1.25, 10

#: Ridge edges closer in direction than this (cosine) count as one, so that slivers make no corners.
_SAME_WAY = 0.75


class Features(NamedTuple):
    """The features of a mesh.

    Attributes
    ----------
    classes : (n,) uint8
        SMOOTH, RIDGE, CORNER or CUSP.
    ridge_ring : (n, 2) int32
        For ridge vertices the two neighbours along the ridge; -1 where there is none.
    ridge_edges : (r, 2) int32
        Edges that are ridges, once each, the smaller point first.
    edge_kinds : (r,) uint8
        REGULAR, BOUNDARY or NON_MANIFOLD.
    ridge_angle, corner_angle : float
        The thresholds that were used, degrees; where noise is uneven those of the quietest part.
    """

    classes: UInt8
    ridge_ring: Int32
    ridge_edges: Int32
    edge_kinds: UInt8 = np.empty(0, np.uint8)
    ridge_angle: float = np.nan
    corner_angle: float = np.nan

    def counts(self) -> tuple[int, ...]:
        """Return how many vertices are smooth, on ridges, corners and cusps."""
        return tuple(np.bincount(self.classes, minlength=4).tolist())


@device
def _is_sharp(kind, angle, r, ridge_angle):
    return kind[r] != 0 or angle[r] >= ridge_angle


@device
def _turns(points, near, normals, v, limit):
    # The angle defect: a quarter of a turn makes a corner, on a boundary the corner angle.
    total = 0.0
    for row in range(near.corner_offsets[v], near.corner_offsets[v + 1]):
        f = near.corner_face[near.corners[row]]
        if normals[f, 3] > 0.0:
            total += corner_angle(points, near, row, normals[f, 0], normals[f, 1], normals[f, 2])
    if near.kinds[v] == 0:
        return abs(2.0 * np.pi - total) >= 0.5 * np.pi - 1e-6
    return near.kinds[v] == 1 and abs(np.pi - total) >= limit


@device
def _cosine(points, v, a, b):
    # Of the angle at v between the edges to a and b; 1 where one has no length.
    dot = 0.0
    aa = 0.0
    bb = 0.0
    for axis in range(3):
        x = points[a, axis] - points[v, axis]
        y = points[b, axis] - points[v, axis]
        dot += x * y
        aa += x * x
        bb += y * y
    return dot / (np.sqrt(aa) * np.sqrt(bb)) if aa > 0.0 and bb > 0.0 else 1.0


@kernel
def _classify(
    starts, ends, points, near, normals, weight, ridge_angle, ridge_angles, turn_angles, joined, before,
    kind, angle, classes, picked, acute,
):  # fmt: skip
    # Section 4.1, for the vertices whose class was 1 before. `joined`: the second round, in which ridge
    # vertices take the tensors of their neighbours along the ridge too. Angles of edges are to be compared
    # with `ridge_angle`, what is of vertices with theirs: one for all, or one for each.
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            if before[v] != 1:
                continue
            chi_r = np.tan(0.5 * ridge_angles[min(v, ridge_angles.size - 1)]) ** 2
            turn_angle = turn_angles[min(v, turn_angles.size - 1)]
            chi_c = 2.0 * np.tan(0.5 * turn_angle) ** 2
            ring = near.ring_offsets[v]
            size = near.ring_offsets[v + 1] - ring
            a00 = 0.0
            a01 = 0.0
            a02 = 0.0
            a11 = 0.0
            a12 = 0.0
            a22 = 0.0
            b0 = 0.0
            b1 = 0.0
            b2 = 0.0
            for side in range(3 if joined else 1):
                w = v if side == 0 else np.int64(picked[v, side - 1])
                if side == 0 or (w >= 0 and before[w] == 1):
                    c00, c01, c02, c11, c12, c22, b0, b1, b2 = metric_tensor(points, near, normals, w, weight)
                    a00 += c00
                    a01 += c01
                    a02 += c02
                    a11 += c11
                    a12 += c12
                    a22 += c22
            l1, l2, l3, x1, y1, z1, _, _, _, x3, y3, z3 = eigen(a00, a01, a02, a11, a12, a22)
            if not joined and near.kinds[v] != 2:  # where orientations disagree signs mean nothing
                turn = 1.0 if x1 * b0 + y1 * b1 + z1 * b2 >= 0.0 else -1.0
                parallel_to_first = True
                for row in range(near.corner_offsets[v], near.corner_offsets[v + 1]):
                    f = near.corner_face[near.corners[row]]
                    along = turn * (x1 * normals[f, 0] + y1 * normals[f, 1] + z1 * normals[f, 2])
                    if normals[f, 3] > 0.0:
                        parallel_to_first = parallel_to_first and along * along >= 1.0 - _CUSP
                        if along < -1e-6:
                            acute[v] = 1
                if acute[v] and parallel_to_first:
                    classes[v] = 3
                    continue
            sharp = 0
            forced = 0
            for r in range(ring, ring + size):
                sharp += _is_sharp(kind, angle, r, ridge_angle)
                forced += kind[r] != 0
            folded = l1 > 0.0 and (l2 >= chi_r * l1 or l3 >= chi_c * l1)
            if not (folded or sharp >= 2 or forced > 0 or acute[v]):
                classes[v] = 0
                continue
            classes[v] = 2
            if l3 >= chi_c * l1 or _turns(points, near, normals, v, turn_angle):
                continue
            classes[v] = 1
            if near.kinds[v] == 1:
                picked[v, 0] = near.boundary_ring[v, 0]
                picked[v, 1] = near.boundary_ring[v, 1]
                continue
            picked[v, 0] = -1
            picked[v, 1] = -1
            if sharp >= 2:
                # The sharpest edge, and of the others the one that leads away from it, sharp ones first.
                best = -1.0
                for r in range(ring, ring + size):
                    rank = angle[r] if kind[r] == 0 else 4.0
                    if rank > best:
                        best = rank
                        picked[v, 0] = near.ring[r]
                best = -1.0
                for r in range(ring, ring + size):
                    if near.ring[r] != picked[v, 0] and _is_sharp(kind, angle, r, ridge_angle):
                        away = 1.0 - _cosine(points, v, picked[v, 0], near.ring[r])
                        away *= angle[r] if kind[r] == 0 else 4.0
                        if away > best:
                            best = away
                            picked[v, 1] = near.ring[r]
                continue
            # The edges that go along the third eigenvector, one each way.
            low = 0.0
            high = 0.0
            for r in range(ring, ring + size):
                w = near.ring[r]
                dx = points[w, 0] - points[v, 0]
                dy = points[w, 1] - points[v, 1]
                dz = points[w, 2] - points[v, 2]
                length = np.sqrt(dx * dx + dy * dy + dz * dz)
                if length == 0.0:
                    continue
                along = (dx * x3 + dy * y3 + dz * z3) / length
                if _is_sharp(kind, angle, r, ridge_angle):
                    along *= 2.0
                if along < low:
                    low = along
                    picked[v, 0] = w
                if along > high:
                    high = along
                    picked[v, 1] = w


@device
def _ways(points, near, kind, v, rows, count):
    # How many of the edges in rows[:count] go different ways, three at most, and the two that differ most.
    # Of all sets of edges the largest counts: what is met first depends on the numbering.
    first = second = -1
    best = 2.0
    ways = min(1, count)
    for i in range(count):
        for j in range(i):
            a = near.ring[rows[i]]
            b = near.ring[rows[j]]
            cosine = _cosine(points, v, a, b)
            apart = kind[rows[i]] != 0 or kind[rows[j]] != 0 or cosine < _SAME_WAY
            if not apart:
                continue
            ways = max(ways, 2)
            if cosine < best:
                best = cosine
                first = b
                second = a
            for k in range(j):
                if ways == 3:
                    break
                c = near.ring[rows[k]]
                of_c = kind[rows[k]] != 0
                from_a = of_c or kind[rows[i]] != 0 or _cosine(points, v, a, c) < _SAME_WAY
                from_b = of_c or kind[rows[j]] != 0 or _cosine(points, v, b, c) < _SAME_WAY
                if from_a and from_b:
                    ways = 3
        if ways == 3:
            break
    return ways, first, second


@kernel
def _filter(
    starts, ends, points, near, kind, angle, ridge_angle, only_corners, classes, picked, acute, after, taken
):
    # Section 4.2, steps 1 to 4; `only_corners`: step 4 alone. Steps 3 and 4 count ways rather than edges.
    widest = 0
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            widest = max(widest, near.ring_offsets[v + 1] - near.ring_offsets[v])
    way = np.empty(widest, np.int32)
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            count = 0
            strong = 0
            for r in range(near.ring_offsets[v], near.ring_offsets[v + 1]):
                w = near.ring[r]
                if classes[w] == 0:
                    identified = False
                elif classes[w] == 1 and near.kinds[w] == 0:
                    identified = picked[w, 0] == v or picked[w, 1] == v
                else:
                    identified = _is_sharp(kind, angle, r, ridge_angle)
                strong += _is_sharp(kind, angle, r, 2.0 * ridge_angle)
                if identified:
                    way[count] = r
                    count += 1
            ways, first, second = _ways(points, near, kind, v, way, count)
            after[v] = classes[v]
            taken[v, 0] = picked[v, 0]
            taken[v, 1] = picked[v, 1]
            if classes[v] >= 2:
                continue
            if ways > 2:
                after[v] = 2
            elif only_corners:
                continue
            elif ways == 2 and classes[v] == 0:
                after[v] = 1
                taken[v, 0] = first
                taken[v, 1] = second
            elif count < 2 and strong < 2 and classes[v] == 1 and not acute[v]:
                after[v] = 0


@kernel
def _collect_ridge_edges(near, kind, angle, ridge_angle, classes, picked, found, found_kind, found_strong):
    # Step 5: an edge that one of its ends has identified, and both ends are features.
    k = 0
    for v in range(near.kinds.size):
        if classes[v] == 0:
            continue
        for r in range(near.ring_offsets[v], near.ring_offsets[v + 1]):
            w = near.ring[r]
            if w < v or classes[w] == 0:
                continue
            ridge = kind[r] != 0
            ridge = ridge or (classes[v] == 1 and (picked[v, 0] == w or picked[v, 1] == w))
            ridge = ridge or (classes[w] == 1 and (picked[w, 0] == v or picked[w, 1] == v))
            if classes[v] >= 2 and classes[w] >= 2:
                ridge = _is_sharp(kind, angle, r, ridge_angle)
            if ridge:
                found[k, 0] = v
                found[k, 1] = w
                found_kind[k] = kind[r]
                found_strong[k] = _is_sharp(kind, angle, r, _STRONG * ridge_angle)
                k += 1
    return k


@kernel
def _complete_rings(classes, picked):
    for v in range(classes.size):
        for side in range(2):
            w = picked[v, side]
            if classes[v] != 1 or (w >= 0 and classes[w] == 0):
                picked[v, side] = -1


@kernel
def _relate_to_noise(starts, ends, near, ridge_angles, smallest, angle):
    # What an edge turns by, were the noise that of the quietest part.
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            for r in range(near.ring_offsets[v], near.ring_offsets[v + 1]):
                angle[r] *= smallest / max(ridge_angles[v], ridge_angles[near.ring[r]])


def _thresholds(
    ridge_angle: float | str, corner_angle: float | str, noise: Float64
) -> tuple[Float64, Float64]:
    # In degrees, one for all or one for each vertex, as the noise is.
    if ridge_angle == AUTO:
        ridge = np.clip(1.5 * np.degrees(noise), RIDGE_ANGLE, LARGEST_RIDGE_ANGLE)
    else:
        ridge = np.array([float(ridge_angle)])
    corner = (
        np.maximum(CORNER_ANGLE, 1.2 * ridge) if corner_angle == AUTO else np.array([float(corner_angle)])
    )
    return ridge, corner


def _check_angle(name: str, angle: float | str) -> None:
    if angle != AUTO and not (isinstance(angle, (int, float)) and 0.0 <= angle <= 180.0):
        raise ParameterError(f"{name} must be from 0 to 180 degrees, or auto, not {angle!r}.")


def detect(
    mesh: Mesh,
    near: Adjacency,
    *,
    ridge_angle: float | str = AUTO,
    corner_angle: float | str = AUTO,
    weight: str = "area",
    denoise: bool = True,
    method: str = "robust",
) -> Features:
    """Find the ridge vertices, corners and cusps of a mesh, and the edges that are ridges.

    Jiao's detection, in four ways more robust: normals are filtered first, as far as the mesh's own noise
    asks; two edges with a dihedral angle of at least `ridge_angle` make a ridge vertex too, whatever the
    sizes of its faces; a large angle defect makes a corner only where the normals vary as well; and
    corners count before ridge vertices do, so that a ridge does not lose its end.

    Parameters
    ----------
    mesh : Mesh
    near : Adjacency
    ridge_angle : float or "auto"
        Dihedral angle from which an edge is a ridge, degrees (the paper's phi_r). "auto": 20, or 1.5 times
        the noise if that is more; where a part of the mesh is much noisier than the rest, the noise about
        each vertex.
    corner_angle : float or "auto"
        Turning angle from which a cone's tip is a corner, degrees (phi_c); on boundaries, by how much the
        boundary must turn. "auto": 35, or 1.2 times the ridge angle if that is more.
    weight : {"area", "angle"}
        What weighs a face at a vertex.
    denoise : bool
        Whether to filter the normals, see :mod:`~vtksmooth.kernels.features.normal_filter`.
    method : {"robust", "paper"}
        "paper": the detection as printed, without those four; "auto" is then 20 and 35 degrees, `denoise`
        is ignored. See :func:`~vtksmooth.kernels.features.paper.detect_as_printed`.

    Returns
    -------
    Features
        It does not depend on the pose and the scale of the mesh.

    Raises
    ------
    ParameterError
        An angle is not from 0 to 180 degrees.

    Examples
    --------
    >>> from vtksmooth.kernels.mesh import adjacency
    >>> corners = [[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)]
    >>> sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    >>> cube = Mesh.from_faces(corners, sides)
    >>> found = detect(cube, adjacency.build(cube))
    >>> found.classes.tolist(), len(found.ridge_edges)
    ([2, 2, 2, 2, 2, 2, 2, 2], 12)
    """
    _check_angle("ridge_angle", ridge_angle)
    _check_angle("corner_angle", corner_angle)
    if method == "paper":
        phi_r = RIDGE_ANGLE if ridge_angle == AUTO else float(ridge_angle)
        phi_c = CORNER_ANGLE if corner_angle == AUTO else float(corner_angle)
        spared = np.radians(phi_r) + _SPARE, np.radians(phi_c) + _SPARE
        classes, picked, found, kinds = detect_as_printed(mesh, near, *spared, weight)
        _complete_rings(classes, picked)
        return Features(classes, picked, found, kinds, phi_r, phi_c)
    n, edges = mesh.n_points, len(near.ring)
    ranges = parallel.ranges(n)
    normals = face_normals(mesh)
    meter = NoiseMeter(mesh.points, near)
    noise = np.array([meter.measure(normals) if denoise or ridge_angle == AUTO else 0.0])
    if (denoise or ridge_angle == AUTO) and meter.is_uneven(normals, noise[0]):
        noise = np.maximum(meter.local(normals), noise[0])
    ridge_angles, corner_angles = _thresholds(ridge_angle, corner_angle, noise)
    ridge_angle, corner_angle = float(ridge_angles.min()), float(corner_angles.min())
    ridge_angles, corner_angles = np.radians(ridge_angles) + _SPARE, np.radians(corner_angles) + _SPARE
    phi_r, phi_c = float(ridge_angles.min()), float(corner_angles.min())
    if denoise:
        normals = filter_normals(meter, normals, noise)
    kind, angle = np.empty(edges, np.uint8), np.empty(edges, np.float32)
    # With all normals in a cone of half angle a, l2 / l1 <= tan(a)^2 and l3 / l1 <= tan(a)^2 / 2, no
    # dihedral angle exceeds 2 a, and up to 30 degrees the first eigenvector lies in the cone.
    cosine = float(np.cos(min(0.5 * phi_r, 0.5 * phi_c, np.pi / 6.0)))
    classes, picked = np.empty(n, np.uint8), np.full((n, 2), -1, np.int32)
    parallel.run(measure_edges, *ranges, near, normals, cosine, kind, angle, classes)
    if len(ridge_angles) > 1:
        parallel.run(_relate_to_noise, *ranges, near, ridge_angles, phi_r, angle)
    other_classes, other_picked = np.empty_like(classes), np.empty_like(picked)
    acute = np.zeros(n, np.uint8)
    for joined in (False, True):
        parallel.run(
            _classify, *ranges, mesh.points, near, normals, WEIGHTS.index(weight), phi_r, ridge_angles,
            corner_angles, joined, classes.copy(), kind, angle, classes, picked, acute,
        )  # fmt: skip
        for only_corners in (True, False):
            parallel.run(
                _filter, *ranges, mesh.points, near, kind, angle, phi_r, only_corners, classes, picked, acute,
                other_classes, other_picked,
            )  # fmt: skip
            classes, other_classes = other_classes, classes
            picked, other_picked = other_picked, picked
    _complete_rings(classes, picked)
    found, kinds = np.empty((edges // 2, 2), np.int32), np.empty(edges // 2, np.uint8)
    strong = np.empty(edges // 2, np.bool_)
    count = _collect_ridge_edges(near, kind, angle, phi_r, classes, picked, found, kinds, strong)
    found, kinds, kept = found[:count], kinds[:count], np.empty(count, np.bool_)
    parent = np.arange(n, dtype=np.int32)
    _strong_or_long(found, strong, parent, np.zeros(n, np.int32), np.zeros(n, np.int32), kept)
    found, kinds = found[kept], kinds[kept]
    alone = np.bincount(found.ravel(), minlength=n) == 0
    classes[alone & (classes == RIDGE) & (acute == 0)] = SMOOTH
    _complete_rings(classes, picked)
    return Features(classes, picked, found, kinds, ridge_angle, corner_angle)


@kernel
def _strong_or_long(found, strong, parent, size, seeds, kept):
    # Which edges hang together with a strong one, or with many: where a fillet's angles are about the
    # threshold, dashes remain otherwise.
    for e in range(found.shape[0]):
        join(parent, found[e, 0], found[e, 1])
    for e in range(found.shape[0]):
        part = find_root(parent, found[e, 0])
        size[part] += 1
        seeds[part] += strong[e]
    for e in range(found.shape[0]):
        part = find_root(parent, found[e, 0])
        kept[e] = size[part] >= _LONG or seeds[part] > 0


@kernel
def _trace(ends_here, offsets, neighbours, kinds, used, points, line_offsets, line_kinds):
    # Lines start where a ridge ends or forks; what is left after that are closed loops.
    lines = 0
    k = 0
    line_offsets[0] = 0
    for turn in range(2):
        for v in range(ends_here.size):
            if turn == 0 and not ends_here[v]:
                continue
            for start in range(offsets[v], offsets[v + 1]):
                if used[start]:
                    continue
                line_kinds[lines] = kinds[start]
                points[k] = v
                k += 1
                at = v
                slot = start
                while True:
                    used[slot] = 1
                    w = neighbours[slot]
                    for back in range(offsets[w], offsets[w + 1]):
                        if neighbours[back] == at:
                            used[back] = 1
                    points[k] = w
                    k += 1
                    if ends_here[w] or w == v:
                        break
                    slot = offsets[w] if neighbours[offsets[w]] != at else offsets[w] + 1
                    at = w
                lines += 1
                line_offsets[lines] = k
    return lines


def lines(features: Features) -> tuple[npt.NDArray[np.int64], Int32, UInt8]:
    """Join the ridge edges to lines, from end to end or round closed loops.

    Lines end at corners, at cusps, where ridge edges fork, and where their kind changes. A loop names its
    first point twice.

    Returns
    -------
    offsets : (l + 1,) int64
    points : (k,) int32
        Line i has the points ``points[offsets[i]:offsets[i + 1]]``.
    kinds : (l,) uint8
        REGULAR, BOUNDARY or NON_MANIFOLD.
    """
    n, edges = len(features.classes), features.ridge_edges
    kinds = features.edge_kinds if len(features.edge_kinds) else np.zeros(len(edges), np.uint8)
    both = np.concatenate((edges, edges[:, ::-1]))
    order = np.lexsort((both[:, 1], both[:, 0]))
    both, both_kinds = both[order], np.concatenate((kinds, kinds))[order]
    degree = np.bincount(both[:, 0], minlength=n)
    offsets = np.concatenate(([0], np.cumsum(degree))).astype(np.int64)
    ends_here = (features.classes != RIDGE) | (degree != 2)
    inner = np.flatnonzero(~ends_here)
    ends_here[inner] = both_kinds[offsets[inner]] != both_kinds[offsets[inner] + 1]
    points, line_offsets = np.empty(2 * len(edges), np.int32), np.empty(len(edges) + 1, np.int64)
    line_kinds = np.empty(len(edges), np.uint8)
    count = _trace(
        ends_here, offsets, np.ascontiguousarray(both[:, 1]), both_kinds, np.zeros(len(both), np.uint8),
        points, line_offsets, line_kinds,
    )  # fmt: skip
    line_offsets = line_offsets[: count + 1].copy()
    return line_offsets, points[: line_offsets[-1]].copy(), line_kinds[:count].copy()


def polylines(features: Features) -> list[Int32]:
    """Return the ridge lines of :func:`lines` as a list of arrays of point indices."""
    offsets, points, _ = lines(features)
    return np.split(points, offsets[1:-1]) if len(points) else []
