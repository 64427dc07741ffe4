"""Feature detection as Jiao prints it, section 4: eigenvalues of the metric tensor and the filter."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ...jit import parallel
from ...jit.compiled import device, kernel
from ..measures.dihedral import face_normals, measure_edges
from ..mesh.adjacency import Adjacency
from ..mesh.mesh import Mesh
from .metric_tensor import WEIGHTS, corner_angle, eigen, metric_tensor

UInt8 = npt.NDArray[np.uint8]
Int32 = npt.NDArray[np.int32]
Float32 = npt.NDArray[np.float32]

#: Share of the first eigenvalue below which the second is far smaller than at a ridge: a cusp.
_CUSP = 0.003


@device
def _identified(near, kind, angle, classes, picked, v, r, ridge_angle):
    # Whether v takes its edge r for a ridge edge: by its third eigenvector, at corners and on boundaries by
    # the dihedral angle.
    if kind[r] != 0:
        return True
    if classes[v] >= 2 or (near.kinds[v] != 0 and angle[r] >= ridge_angle):
        return angle[r] >= ridge_angle
    return classes[v] == 1 and (picked[v, 0] == near.ring[r] or picked[v, 1] == near.ring[r])


@device
def _identified_there(near, kind, angle, classes, picked, v, r, ridge_angle):
    # Whether the other end of the edge r of v takes it for a ridge edge.
    w = near.ring[r]
    for back in range(near.ring_offsets[w], near.ring_offsets[w + 1]):
        if near.ring[back] == v:
            return _identified(near, kind, angle, classes, picked, w, back, ridge_angle)
    return False


@kernel
def _identify(
    starts, ends, points, near, normals, weight, ridge_angle, corner_turn, joined, kind, angle,
    before, chosen, classes, picked, acute,
):  # fmt: skip
    # Section 4.1. `joined`: step 6 of section 4.2, for the ridge vertices among `before` alone.
    chi_r = np.tan(0.5 * ridge_angle) ** 2
    chi_c = 2.0 * np.tan(0.5 * corner_turn) ** 2
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            ring = near.ring_offsets[v]
            size = near.ring_offsets[v + 1] - ring
            if joined and before[v] != 1:
                classes[v] = before[v]
                picked[v, 0] = chosen[v, 0]
                picked[v, 1] = chosen[v, 1]
                continue
            picked[v, 0] = -1
            picked[v, 1] = -1
            a00, a01, a02, a11, a12, a22, b0, b1, b2 = metric_tensor(points, near, normals, v, weight)
            for r in range(ring, ring + size if joined else ring):
                w = near.ring[r]
                along = _identified(near, kind, angle, before, chosen, v, r, ridge_angle)
                along = along or _identified_there(near, kind, angle, before, chosen, v, r, ridge_angle)
                if along and before[w] == 1:
                    c00, c01, c02, c11, c12, c22, c0, c1, c2 = metric_tensor(points, near, normals, w, weight)
                    a00 += c00
                    a01 += c01
                    a02 += c02
                    a11 += c11
                    a12 += c12
                    a22 += c22
                    b0 += c0
                    b1 += c1
                    b2 += c2
            l1, l2, l3, x1, y1, z1, _, _, _, x3, y3, z3 = eigen(a00, a01, a02, a11, a12, a22)
            total = 0.0
            against = False
            turn = 1.0 if x1 * b0 + y1 * b1 + z1 * b2 >= 0.0 else -1.0
            for row in range(near.corner_offsets[v], near.corner_offsets[v + 1]):
                f = near.corner_face[near.corners[row]]
                if normals[f, 3] > 0.0:
                    total += corner_angle(points, near, row, normals[f, 0], normals[f, 1], normals[f, 2])
                    along = turn * (x1 * normals[f, 0] + y1 * normals[f, 1] + z1 * normals[f, 2])
                    against = against or (along <= 0.0 and near.kinds[v] != 2)
            forced = 0
            for r in range(ring, ring + size):
                forced += kind[r] != 0
            if not joined:
                acute[v] = against
            defect = abs((np.pi if near.kinds[v] == 1 else 2.0 * np.pi) - total)
            if l1 == 0.0 and forced == 0:
                classes[v] = 0
                continue
            if l3 >= chi_c * l1 or (near.kinds[v] != 2 and defect >= 0.5 * np.pi - 1e-6):
                classes[v] = 2
                continue
            if forced > 0:
                # Boundaries and non-manifold lines are ridges; a corner is where they end or fork.
                classes[v] = 1 if forced == 2 else 2
                for r in range(ring, ring + size if forced == 2 else ring):
                    if kind[r] != 0:
                        picked[v, 0 if picked[v, 0] < 0 else 1] = near.ring[r]
                continue
            if l2 < chi_r * l1 and not acute[v]:
                classes[v] = 0
                continue
            if l2 < _CUSP * l1:
                classes[v] = 3
                continue
            classes[v] = 1
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
                if along < low:
                    low = along
                    picked[v, 0] = w
                if along > high:
                    high = along
                    picked[v, 1] = w


@kernel
def _filter(starts, ends, near, kind, angle, ridge_angle, acute, classes, picked, after, taken):
    # Section 4.2, steps 1 to 4.
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            count = 0
            first = -1
            second = -1
            for r in range(near.ring_offsets[v], near.ring_offsets[v + 1]):
                if _identified_there(near, kind, angle, classes, picked, v, r, ridge_angle):
                    count += 1
                    first, second = second, near.ring[r]
            after[v] = classes[v]
            taken[v, 0] = picked[v, 0]
            taken[v, 1] = picked[v, 1]
            if classes[v] >= 2:
                continue
            if count > 2:
                after[v] = 2
            elif classes[v] == 0 and count == 2:
                after[v] = 1
                taken[v, 0] = first
                taken[v, 1] = second
            elif classes[v] == 1 and count < 2 and not acute[v]:
                after[v] = 0


@kernel
def _collect(near, kind, angle, ridge_angle, classes, picked, found, found_kind):
    # Step 5: edges that an end identifies, between features.
    k = 0
    for v in range(near.kinds.size):
        for r in range(near.ring_offsets[v], near.ring_offsets[v + 1]):
            w = near.ring[r]
            if w < v or classes[v] == 0 or classes[w] == 0:
                continue
            ridge = _identified(near, kind, angle, classes, picked, v, r, ridge_angle)
            if ridge or _identified_there(near, kind, angle, classes, picked, v, r, ridge_angle):
                found[k, 0] = v
                found[k, 1] = w
                found_kind[k] = kind[r]
                k += 1
    return k


def detect_as_printed(
    mesh: Mesh, near: Adjacency, ridge_angle: float, corner_angle: float, weight: str = "area"
) -> tuple[UInt8, Int32, Int32, UInt8]:
    """Return classes, picked neighbours, ridge edges and their kinds, by Jiao's section 4 as printed.

    What the paper leaves open is decided so: at boundaries the angle defect is the difference from pi;
    boundary and non-manifold edges are ridge edges; a cusp has a second eigenvalue below 0.003 of the first;
    in step 1 of the filter edges at corners and on boundaries count too, by their dihedral angles, since
    otherwise every ridge would lose its ends; the neighbouring ridge vertices of step 6 are those along
    ridge edges.

    Parameters
    ----------
    mesh : Mesh
    near : Adjacency
    ridge_angle, corner_angle : float
        Radians.
    weight : {"area", "angle"}
        What weighs a face at a vertex.

    Returns
    -------
    classes : (n,) uint8
    picked : (n, 2) int32
        The two neighbours along the ridge; -1 where there is none.
    edges : (r, 2) int32
        The smaller point first.
    kinds : (r,) uint8
    """
    n, edges = mesh.n_points, len(near.ring)
    ranges = parallel.ranges(n)
    normals = face_normals(mesh)
    kind, angle = np.empty(edges, np.uint8), np.empty(edges, np.float32)
    classes, picked = np.empty(n, np.uint8), np.full((n, 2), -1, np.int32)
    parallel.run(measure_edges, *ranges, near, normals, 2.0, kind, angle, classes)
    other_classes, other_picked = np.zeros_like(classes), np.full_like(picked, -1)
    acute = np.zeros(n, np.bool_)
    for joined in (False, True):
        parallel.run(
            _identify, *ranges, mesh.points, near, normals, WEIGHTS.index(weight), ridge_angle, corner_angle,
            joined, kind, angle, other_classes, other_picked, classes, picked, acute,
        )  # fmt: skip
        parallel.run(
            _filter, *ranges, near, kind, angle, ridge_angle, acute, classes, picked,
            other_classes, other_picked,
        )  # fmt: skip
    classes, picked = other_classes, other_picked
    found, kinds = np.empty((edges // 2, 2), np.int32), np.empty(edges // 2, np.uint8)
    count = _collect(near, kind, angle, ridge_angle, classes, picked, found, kinds)
    return classes, picked, found[:count].copy(), kinds[:count].copy()
