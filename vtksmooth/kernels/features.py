"""Feature detection: vertices on ridges, at corners and cusps, and the ridge lines (Jiao, section 4)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..errors import ParameterError
from . import parallel
from .adjacency import Adjacency
from .compiled import device, kernel
from .mesh import Mesh
from .metric_tensor import WEIGHTS, corner_of_face, eigen
from .quality import area_vectors

Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
UInt8 = npt.NDArray[np.uint8]

#: Classes of vertices.
SMOOTH, RIDGE, CORNER, CUSP = 0, 1, 2, 3

#: Kinds of edges: two faces, one face, more.
REGULAR, BOUNDARY, NON_MANIFOLD = 0, 1, 2

#: Thresholds that the mesh chooses.
AUTO = "auto"

#: Smallest angles that :data:`AUTO` chooses, degrees: those of the paper.
RIDGE_ANGLE, CORNER_ANGLE = 20.0, 35.0

#: Angles are compared with this much to spare, radians: the corners of a square have exactly a quarter.
_SPARE = 1e-6


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
    """

    classes: UInt8
    ridge_ring: Int32
    ridge_edges: Int32


class Edges(NamedTuple):
    """What the edge to each neighbour is; in step with ``Adjacency.ring``.

    Attributes
    ----------
    kind : (k,) uint8
        REGULAR, BOUNDARY or NON_MANIFOLD.
    angle : (k,) float32
        Dihedral angle: between the two faces' normals, radians. 0 where there are not two.
    """

    kind: UInt8
    angle: npt.NDArray[np.float32]


@kernel
def _unit_normals(starts, ends, area):  # type: ignore[no-untyped-def]
    for part in range(starts.size):
        for f in range(starts[part], ends[part]):
            largest = max(abs(area[f, 0]), abs(area[f, 1]), abs(area[f, 2]))
            if largest > 0.0:
                for axis in range(3):
                    area[f, axis] /= largest
                length = np.sqrt(area[f, 0] ** 2 + area[f, 1] ** 2 + area[f, 2] ** 2)
                for axis in range(3):
                    area[f, axis] /= length


def unit_normals(mesh: Mesh) -> Float64:
    """Return each face's unit normal, (m, 3); 0 where it has no area."""
    normals = area_vectors(mesh)
    parallel.run(_unit_normals, *parallel.ranges(mesh.n_faces), normals)
    return normals


@kernel
def _edges_of_rings(starts, ends, near, normals, kind, angle):  # type: ignore[no-untyped-def]
    n = near.border.size
    place = np.empty(n, np.int32)  # of the neighbours in the ring at hand
    widest = 0
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            widest = max(widest, near.ring_offsets[v + 1] - near.ring_offsets[v])
    count = np.empty(widest, np.int32)
    first = np.empty(widest, np.int32)
    second = np.empty(widest, np.int32)
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            ring = near.ring_offsets[v]
            size = near.ring_offsets[v + 1] - ring
            for r in range(size):
                place[near.ring[ring + r]] = r
                count[r] = 0
            for row in range(near.corner_offsets[v], near.corner_offsets[v + 1]):
                c = near.corners[row]
                f = near.corner_face[c]
                a = near.offsets[f]
                b = near.offsets[f + 1]
                for side in range(2):
                    if side == 0:
                        w = near.connectivity[c + 1 if c + 1 < b else a]
                    else:
                        w = near.connectivity[c - 1 if c > a else b - 1]
                    if w == v:
                        continue
                    r = place[w]
                    # Faces that run from v to w are kept as they are, the others as -1 - f.
                    if count[r] == 0:
                        first[r] = f if side == 0 else -1 - f
                    elif count[r] == 1:
                        second[r] = f if side == 0 else -1 - f
                    count[r] += 1
            for r in range(size):
                angle[ring + r] = 0.0
                kind[ring + r] = 0 if count[r] == 2 else (1 if count[r] == 1 else 2)
                if count[r] != 2:
                    continue
                f = first[r] if first[r] >= 0 else -1 - first[r]
                g = second[r] if second[r] >= 0 else -1 - second[r]
                # Both ends must see the same angle to the last bit.
                f, g = min(f, g), max(f, g)
                # Where orientations disagree, one of the normals counts turned round.
                turn = 1.0 if (first[r] >= 0) != (second[r] >= 0) else -1.0
                dot = turn * (
                    normals[f, 0] * normals[g, 0]
                    + normals[f, 1] * normals[g, 1]
                    + normals[f, 2] * normals[g, 2]
                )
                x = normals[f, 1] * normals[g, 2] - normals[f, 2] * normals[g, 1]
                y = normals[f, 2] * normals[g, 0] - normals[f, 0] * normals[g, 2]
                z = normals[f, 0] * normals[g, 1] - normals[f, 1] * normals[g, 0]
                angle[ring + r] = np.arctan2(np.sqrt(x * x + y * y + z * z), dot)


def edges_of_rings(near: Adjacency, normals: Float64) -> Edges:
    """Return the kind and the dihedral angle of the edges to all neighbours."""
    edges = Edges(np.empty(len(near.ring), np.uint8), np.empty(len(near.ring), np.float32))
    parallel.run(_edges_of_rings, *parallel.ranges(len(near.border)), near, normals, *edges)
    return edges


@kernel
def _sum_tensors(starts, ends, points, near, weight, tensors, turned):  # type: ignore[no-untyped-def]
    # turned: the sum of the angles round v.
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            for i in range(9):
                tensors[v, i] = 0.0
            turned[v] = 0.0
            for row in range(near.corner_offsets[v], near.corner_offsets[v + 1]):
                n0, n1, n2, area, angle = corner_of_face(points, near, row, True)
                w = area if weight == 0 else angle
                turned[v] += angle
                tensors[v, 0] += w * n0 * n0
                tensors[v, 1] += w * n0 * n1
                tensors[v, 2] += w * n0 * n2
                tensors[v, 3] += w * n1 * n1
                tensors[v, 4] += w * n1 * n2
                tensors[v, 5] += w * n2 * n2
                tensors[v, 6] += w * n0
                tensors[v, 7] += w * n1
                tensors[v, 8] += w * n2


@device
def _is_sharp(kind, angle, r, ridge_angle):  # type: ignore[no-untyped-def]
    return kind[r] != 0 or angle[r] >= ridge_angle


@kernel
def _classify(  # type: ignore[no-untyped-def]
    starts, ends, points, near, normals, edge_kind, tensors, turned, ridge_angle, corner_angle,
    joined, before, classes, picked, acute,
):  # fmt: skip
    # Section 4.1. `joined`: the second round, in which ridge vertices take the tensors of their
    # neighbours along the ridge too, and only they are looked at.
    chi_r = np.tan(0.5 * ridge_angle) ** 2
    chi_c = 2.0 * np.tan(0.5 * corner_angle) ** 2
    a = np.empty(9)
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            if joined and before[v] != 1:
                continue
            for i in range(9):
                a[i] = tensors[v, i]
            if joined:
                for side in range(2):
                    w = picked[v, side]
                    if w >= 0 and before[w] == 1:
                        for i in range(9):
                            a[i] += tensors[w, i]
            else:
                picked[v, 0] = -1
                picked[v, 1] = -1
                acute[v] = 0
                classes[v] = 0
            if near.border[v] == 3:
                continue
            excess = -1.0
            if near.border[v] == 0:
                excess = abs(2.0 * np.pi - turned[v]) + 1e-6 - 0.5 * np.pi
            elif near.border[v] == 1:
                # On a boundary what the boundary turns by.
                excess = abs(np.pi - turned[v]) - corner_angle
            if excess >= 0.0:
                classes[v] = 2
                continue
            l1, l2, l3, x1, y1, z1, _, _, _, x3, y3, z3 = eigen(a[0], a[1], a[2], a[3], a[4], a[5])
            if l1 <= 0.0:
                continue
            if l3 >= chi_c * l1:
                classes[v] = 2
                continue
            if not joined:
                side_of_b = x1 * a[6] + y1 * a[7] + z1 * a[8]
                turn = 1.0 if side_of_b >= 0.0 else -1.0
                for row in range(near.corner_offsets[v], near.corner_offsets[v + 1]):
                    f = near.corner_face[near.corners[row]]
                    along = turn * (x1 * normals[f, 0] + y1 * normals[f, 1] + z1 * normals[f, 2])
                    has_area = normals[f, 0] != 0.0 or normals[f, 1] != 0.0 or normals[f, 2] != 0.0
                    if has_area and along <= 0.0:
                        acute[v] = 1
            if l2 < chi_r * l1 and not acute[v] and near.border[v] != 1:
                sharp = 0
                for r in range(near.ring_offsets[v], near.ring_offsets[v + 1]):
                    sharp += edge_kind[r] != 0
                if sharp == 0:
                    classes[v] = 0
                    continue
            # Below this share of the first eigenvalue a direction says nothing (section 3.1).
            if acute[v] and l2 < 0.003 * l1:
                classes[v] = 3
                continue
            classes[v] = 1
            if near.border[v] == 1:
                picked[v, 0] = near.border_ring[v, 0]
                picked[v, 1] = near.border_ring[v, 1]
                continue
            # The edges that go along the third eigenvector, one each way.
            low = 0.0
            high = 0.0
            picked[v, 0] = -1
            picked[v, 1] = -1
            for r in range(near.ring_offsets[v], near.ring_offsets[v + 1]):
                w = near.ring[r]
                dx = points[w, 0] - points[v, 0]
                dy = points[w, 1] - points[v, 1]
                dz = points[w, 2] - points[v, 2]
                length = np.sqrt(dx * dx + dy * dy + dz * dz)
                if length == 0.0:
                    continue
                along = (dx * x3 + dy * y3 + dz * z3) / length
                if along < low:
                    low = along
                    picked[v, 0] = w
                if along > high:
                    high = along
                    picked[v, 1] = w


@kernel
def _filter(starts, ends, near, edge_kind, edge_angle, ridge_angle, classes, picked, acute, after, taken):  # type: ignore[no-untyped-def]
    # Section 4.2, steps 1 to 4.
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            count = 0
            one = -1
            two = -1
            for r in range(near.ring_offsets[v], near.ring_offsets[v + 1]):
                w = near.ring[r]
                if classes[w] == 0:
                    points_here = False
                elif classes[w] == 1 and near.border[w] == 0:
                    points_here = picked[w, 0] == v or picked[w, 1] == v
                else:
                    points_here = _is_sharp(edge_kind, edge_angle, r, ridge_angle)
                if points_here:
                    if count == 0:
                        one = w
                    elif count == 1:
                        two = w
                    count += 1
            after[v] = classes[v]
            taken[v, 0] = picked[v, 0]
            taken[v, 1] = picked[v, 1]
            if classes[v] >= 2:
                continue
            if count > 2:
                after[v] = 2
            elif count == 2 and classes[v] == 0:
                after[v] = 1
                taken[v, 0] = one
                taken[v, 1] = two
            elif count < 2 and classes[v] == 1 and not acute[v]:
                after[v] = 0


@kernel
def _collect_ridge_edges(near, edge_kind, edge_angle, ridge_angle, classes, picked, found):  # type: ignore[no-untyped-def]
    # Step 5: an edge that one of its ends has identified, and both ends are features.
    k = 0
    for v in range(near.border.size):
        if classes[v] == 0:
            continue
        for r in range(near.ring_offsets[v], near.ring_offsets[v + 1]):
            w = near.ring[r]
            if w < v or classes[w] == 0:
                continue
            ridge = edge_kind[r] != 0
            ridge = ridge or (classes[v] == 1 and (picked[v, 0] == w or picked[v, 1] == w))
            ridge = ridge or (classes[w] == 1 and (picked[w, 0] == v or picked[w, 1] == v))
            if classes[v] >= 2 and classes[w] >= 2:
                ridge = _is_sharp(edge_kind, edge_angle, r, ridge_angle)
            if ridge:
                found[k, 0] = v
                found[k, 1] = w
                k += 1
    return k


@kernel
def _complete_rings(classes, picked):  # type: ignore[no-untyped-def]
    for v in range(classes.size):
        for side in range(2):
            w = picked[v, side]
            if classes[v] != 1 or (w >= 0 and classes[w] == 0):
                picked[v, side] = -1


def thresholds(
    edges: Edges, ridge_angle: float | str = AUTO, corner_angle: float | str = AUTO
) -> tuple[float, float]:
    """Return the ridge angle and the corner angle in degrees, chosen by the mesh where they are "auto".

    Noise makes dihedral angles of its own, of which the median tells the size: ridges are what stands
    well above. The corner angle goes with the ridge angle.

    Raises
    ------
    ParameterError
        An angle does not lie between 0 and 180 degrees.
    """
    for name, angle in (("ridge_angle", ridge_angle), ("corner_angle", corner_angle)):
        if angle != AUTO and not (isinstance(angle, (int, float)) and 0.0 < angle < 180.0):
            raise ParameterError(f"{name} must lie between 0 and 180 degrees, or be auto, not {angle!r}.")
    if ridge_angle == AUTO:
        angles = edges.angle[edges.kind == REGULAR]
        median = float(np.degrees(np.median(angles))) if len(angles) else 0.0
        ridge_angle = min(max(RIDGE_ANGLE, 3.0 * median), 75.0)
    if corner_angle == AUTO:
        corner_angle = max(CORNER_ANGLE, 1.2 * float(ridge_angle))
    return float(ridge_angle), float(corner_angle)


def detect(
    mesh: Mesh,
    near: Adjacency,
    *,
    ridge_angle: float | str = AUTO,
    corner_angle: float | str = AUTO,
    weight: str = "area",
) -> Features:
    """Find the ridge vertices, corners and cusps of a mesh, and the edges that are ridges.

    Parameters
    ----------
    mesh : Mesh
    near : Adjacency
    ridge_angle : float or "auto"
        Dihedral angle from which an edge is a ridge, degrees (the paper's phi_r).
    corner_angle : float or "auto"
        Turning angle from which a cone's tip is a corner, degrees (phi_c).
    weight : {"area", "angle"}
        What weighs a face at a vertex.

    Examples
    --------
    >>> from vtksmooth.kernels import adjacency
    >>> corners = [[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)]
    >>> sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    >>> cube = Mesh.from_faces(corners, sides)
    >>> found = detect(cube, adjacency.build(cube))
    >>> found.classes.tolist(), len(found.ridge_edges)
    ([2, 2, 2, 2, 2, 2, 2, 2], 12)
    """
    n = mesh.n_points
    normals = unit_normals(mesh)
    edges = edges_of_rings(near, normals)
    chosen = thresholds(edges, ridge_angle, corner_angle)
    phi_r, phi_c = np.radians(chosen) - _SPARE
    ranges = parallel.ranges(n)
    tensors, turned = np.empty((n, 9)), np.empty(n)
    parallel.run(_sum_tensors, *ranges, mesh.points, near, WEIGHTS.index(weight), tensors, turned)
    classes, picked = np.empty(n, np.uint8), np.empty((n, 2), np.int32)
    other_classes, other_picked = np.empty_like(classes), np.empty_like(picked)
    acute = np.empty(n, np.uint8)
    for joined in (False, True):
        before = classes.copy()
        parallel.run(
            _classify, *ranges, mesh.points, near, normals, edges.kind, tensors, turned, phi_r, phi_c,
            joined, before, classes, picked, acute,
        )  # fmt: skip
        parallel.run(
            _filter, *ranges, near, *edges, phi_r, classes, picked, acute, other_classes, other_picked
        )
        classes, other_classes = other_classes, classes
        picked, other_picked = other_picked, picked
    _complete_rings(classes, picked)
    found = np.empty((len(near.ring) // 2, 2), np.int32)
    count = _collect_ridge_edges(near, *edges, phi_r, classes, picked, found)
    return Features(classes, picked, found[:count].copy())


@kernel
def _trace(classes, offsets, neighbours, used, order, line_offsets):  # type: ignore[no-untyped-def]
    # Lines start where a ridge ends or forks; what is left after that are closed loops.
    lines = 0
    k = 0
    line_offsets[0] = 0
    for turn in range(2):
        for v in range(classes.size):
            degree = offsets[v + 1] - offsets[v]
            if degree == 0 or (turn == 0 and degree == 2 and classes[v] == 1):
                continue
            for start in range(offsets[v], offsets[v + 1]):
                if used[start]:
                    continue
                order[k] = v
                k += 1
                at = v
                slot = start
                while True:
                    used[slot] = 1
                    w = neighbours[slot]
                    for back in range(offsets[w], offsets[w + 1]):
                        if neighbours[back] == at:
                            used[back] = 1
                    order[k] = w
                    k += 1
                    if offsets[w + 1] - offsets[w] != 2 or classes[w] != 1 or w == v:
                        break
                    slot = offsets[w] if neighbours[offsets[w]] != at else offsets[w] + 1
                    at = w
                lines += 1
                line_offsets[lines] = k
    return lines


def polylines(features: Features) -> list[Int32]:
    """Join the ridge edges to lines of point indices, from end to end or round closed loops.

    Lines end at corners, cusps, and wherever not exactly two ridge edges meet. A loop names its first
    point twice.
    """
    n, edges = len(features.classes), features.ridge_edges
    if not len(edges):
        return []
    both = np.concatenate((edges, edges[:, ::-1]))
    both = both[np.lexsort((both[:, 1], both[:, 0]))]
    offsets = np.concatenate(([0], np.cumsum(np.bincount(both[:, 0], minlength=n)))).astype(np.int64)
    order = np.empty(2 * len(edges), np.int32)
    line_offsets = np.empty(len(edges) + 1, np.int64)
    lines = _trace(
        features.classes, offsets, np.ascontiguousarray(both[:, 1]),
        np.zeros(len(both), np.uint8), order, line_offsets,
    )  # fmt: skip
    return np.split(order[: line_offsets[lines]], line_offsets[1:lines])
