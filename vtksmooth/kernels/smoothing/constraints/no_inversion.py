"""No inversion: a step that would invert a face is halved a few times, then refused."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ....jit import parallel
from ....jit.compiled import device, kernel
from ...measures.aspect_ratio import area_vectors, face_square, polygon_square
from ..run_state import State
from . import Constraint, Float64, Int64

UInt8 = npt.NDArray[np.uint8]

#: How often a step is halved before it is refused.
HALVINGS = 3


# Signs are found step by step as quality.face_square finds that of k, so that both agree to the last bit.


@device
def _against(ox, oy, oz, px, py, pz, qx, qy, qz, reference, f):
    ax = px - ox
    ay = py - oy
    az = pz - oz
    bx = qx - ox
    by = qy - oy
    bz = qz - oz
    nx = ay * bz - az * by
    ny = az * bx - ax * bz
    nz = ax * by - ay * bx
    return nx * reference[f, 0] + ny * reference[f, 1] + nz * reference[f, 2] < 0.0


@device
def _convex(points, connectivity, a, reference, f):
    # Whether all corners of a quadrilateral are clearly convex, seen along its area on the reference's side:
    # then its k is positive, and no root need be drawn to know.
    o = connectivity[a]
    p = connectivity[a + 1]
    q = connectivity[a + 2]
    r = connectivity[a + 3]
    ax = points[p, 0] - points[o, 0]
    ay = points[p, 1] - points[o, 1]
    az = points[p, 2] - points[o, 2]
    bx = points[q, 0] - points[p, 0]
    by = points[q, 1] - points[p, 1]
    bz = points[q, 2] - points[p, 2]
    cx = points[r, 0] - points[q, 0]
    cy = points[r, 1] - points[q, 1]
    cz = points[r, 2] - points[q, 2]
    dx = points[o, 0] - points[r, 0]
    dy = points[o, 1] - points[r, 1]
    dz = points[o, 2] - points[r, 2]
    # The diagonals' product: twice the area.
    ux = ax + bx
    uy = ay + by
    uz = az + bz
    vx = bx + cx
    vy = by + cy
    vz = bz + cz
    nx = uy * vz - uz * vy
    ny = uz * vx - ux * vz
    nz = ux * vy - uy * vx
    area = nx * nx + ny * ny + nz * nz
    clear = 1e-9 * area
    sides = (ax * ax + ay * ay + az * az) + (bx * bx + by * by + bz * bz)
    sides += (cx * cx + cy * cy + cz * cz) + (dx * dx + dy * dy + dz * dz)
    return (
        area > 1e-18 * sides * sides
        and nx * reference[f, 0] + ny * reference[f, 1] + nz * reference[f, 2] > 0.0
        and nx * (ay * bz - az * by) + ny * (az * bx - ax * bz) + nz * (ax * by - ay * bx) > clear
        and nx * (by * cz - bz * cy) + ny * (bz * cx - bx * cz) + nz * (bx * cy - by * cx) > clear
        and nx * (cy * dz - cz * dy) + ny * (cz * dx - cx * dz) + nz * (cx * dy - cy * dx) > clear
        and nx * (dy * az - dz * ay) + ny * (dz * ax - dx * az) + nz * (dx * ay - dy * ax) > clear
    )


@device
def _inverted(points, offsets, connectivity, reference, f):
    a = offsets[f]
    if offsets[f + 1] - a == 4 and _convex(points, connectivity, a, reference, f):
        return False
    if offsets[f + 1] - a != 3:
        return face_square(points, offsets, connectivity, f, reference) < 0.0
    o = connectivity[a]
    p = connectivity[a + 1]
    q = connectivity[a + 2]
    return _against(
        points[o, 0], points[o, 1], points[o, 2], points[p, 0], points[p, 1], points[p, 2],
        points[q, 0], points[q, 1], points[q, 2], reference, f,
    )  # fmt: skip


@device
def newly_inverted(before, after, offsets, connectivity, reference, f):
    """Whether the area of face f is negative against its reference direction after a step, not before."""
    if _inverted(after, offsets, connectivity, reference, f):
        return not _inverted(before, offsets, connectivity, reference, f)
    return False


@device
def _inverted_with(points, near, reference, f, v, x, y, z):
    # The same with vertex v at (x, y, z).
    a = near.offsets[f]
    b = near.offsets[f + 1]
    if b - a < 3:
        return False
    if b - a > 3:
        rx = reference[f, 0]
        ry = reference[f, 1]
        rz = reference[f, 2]
        return polygon_square(points, near.connectivity, a, b, v, x, y, z, rx, ry, rz) < 0.0
    o = near.connectivity[a]
    p = near.connectivity[a + 1]
    q = near.connectivity[a + 2]
    return _against(
        x if o == v else points[o, 0], y if o == v else points[o, 1], z if o == v else points[o, 2],
        x if p == v else points[p, 0], y if p == v else points[p, 1], z if p == v else points[p, 2],
        x if q == v else points[q, 0], y if q == v else points[q, 1], z if q == v else points[q, 2],
        reference, f,
    )  # fmt: skip


@kernel
def _find(starts, ends, before, after, near, reference, found):
    for part in range(starts.size):
        for f in range(starts[part], ends[part]):
            found[f] = newly_inverted(before, after, near.offsets, near.connectivity, reference, f)


@kernel
def _withdraw(before, after, near, reference, halvings, found, refused):
    # Only what lies round the faces `found` is looked at, again and again; hence no threads.
    m = near.offsets.size - 1
    seen = np.zeros(m, np.uint8)
    halved = np.zeros(before.shape[0], np.uint8)
    waiting, shortened = np.empty(m, np.int32), np.empty(before.shape[0], np.int32)
    faces = found.size
    waiting[:faces] = found
    while faces > 0:
        vertices = 0
        for i in range(faces):
            f = waiting[i]
            for c in range(near.offsets[f], near.offsets[f + 1]):
                v = near.connectivity[c]
                if halved[v] >= 128:
                    continue  # in this round already
                still = True
                for axis in range(3):
                    still = still and after[v, axis] == before[v, axis]
                if still:
                    continue
                shortened[vertices] = v
                vertices += 1
                halved[v] += 1
                give_up = halved[v] > halvings
                halved[v] += 128
                for axis in range(3):
                    if give_up:
                        after[v, axis] = before[v, axis]
                    else:
                        after[v, axis] = before[v, axis] + 0.5 * (after[v, axis] - before[v, axis])
                if give_up:
                    refused[v] = 1
        faces = 0
        for i in range(vertices):
            v = shortened[i]
            halved[v] -= 128
            for row in range(near.corner_offsets[v], near.corner_offsets[v + 1]):
                f = near.corner_face[near.corners[row]]
                if not seen[f] and newly_inverted(
                    before, after, near.offsets, near.connectivity, reference, f
                ):
                    seen[f] = 1
                    waiting[faces] = f
                    faces += 1
        for i in range(faces):
            seen[waiting[i]] = 0


@device
def shorten(points, near, reference, halvings, v, proposed):
    """Halve the step of v alone while it inverts a face, at most `halvings` times; then refuse it."""
    for turn in range(halvings + 1):
        bad = False
        for row in range(near.corner_offsets[v], near.corner_offsets[v + 1]):
            f = near.corner_face[near.corners[row]]
            x = proposed[v, 0]
            y = proposed[v, 1]
            z = proposed[v, 2]
            if _inverted_with(points, near, reference, f, v, x, y, z):
                bad = bad or not _inverted(points, near.offsets, near.connectivity, reference, f)
        if not bad:
            return
        for axis in range(3):
            step = 0.5 * (proposed[v, axis] - points[v, axis]) if turn < halvings else 0.0
            proposed[v, axis] = points[v, axis] + step if step != 0.0 else points[v, axis]


@kernel
def _shorten_each(starts, ends, points, near, reference, pinned, halvings, proposed):
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            if not pinned[v]:
                shorten(points, near, reference, halvings, v, proposed)


@kernel
def _count(starts, ends, before, after, offsets, connectivity, reference):
    count = 0
    for part in range(starts.size):
        for f in range(starts[part], ends[part]):
            count += newly_inverted(before, after, offsets, connectivity, reference, f)
    return count


def any_inverted(state: State, before: Float64, after: Float64) -> bool:
    """Return whether steps invert a face that was not inverted."""
    topology = state.topology
    counts = parallel.run(
        _count, *parallel.ranges(topology.n_faces), before, after, topology.offsets, topology.connectivity,
        state.reference,
    )  # fmt: skip
    return any(counts)


def withdraw(
    state: State,
    before: Float64,
    after: Float64,
    halvings: int,
    refused: UInt8,
    reference: npt.NDArray[np.float32] | None = None,
) -> None:
    """Shorten steps until no face is newly inverted, all vertices of a face at the same time.

    A vertex' step is halved at most `halvings` times, then refused: it is back where it was, and noted in
    `refused`. Every round shortens a step, and without steps nothing is newly inverted: so it ends.
    """
    near, reference = state.near, state.reference if reference is None else reference
    found = np.empty(len(near.offsets) - 1, np.bool_)
    parallel.run(_find, *parallel.ranges(len(found)), before, after, near, reference, found)
    faces = np.flatnonzero(found)
    if len(faces):
        _withdraw(before, after, near, reference, halvings, faces, refused)


class NoInversion(Constraint):
    """No face that is not inverted becomes inverted, whether vertices move one by one or all at once.

    Steps that would invert a face are halved up to three times, then refused. Against the directions of
    the run's start, exactly as k is signed. The paper has no such guard.

    Parameters
    ----------
    plan : int, optional
        Number of an axis, 0 to 2, along which faces are seen: none turns over in this plan, whatever the
        directions of the run's start.
    """

    def __init__(self, plan: int | None = None) -> None:
        self.plan = plan
        self.topic = "inversion" if plan is None else "inversion in plan"
        self.name = f"The promise that nothing inverts{'' if plan is None else ' in plan'}"

    def bind(self, state: State) -> None:
        if self.plan is not None:
            self._in_plan = np.zeros_like(state.reference)
            self._in_plan[:, self.plan] = np.sign(area_vectors(state.mesh)[:, self.plan])

    def _reference(self, state: State) -> npt.NDArray[np.float32]:
        return state.reference if self.plan is None else self._in_plan

    def dispose(self, state: State, starts: Int64, ends: Int64, proposed: Float64) -> None:
        points, near, reference = state.points, state.near, self._reference(state)
        if state.in_place:
            parallel.run(
                _shorten_each, starts, ends, points, near, reference, state.pinned, HALVINGS, proposed,
                smallest_share=parallel.COSTLY,
            )  # fmt: skip
            return
        withdraw(state, points, proposed, HALVINGS, np.zeros_like(state.pinned), reference)

    def exceeded(self, state: State, proposed: Float64, rows: Int64) -> npt.NDArray[np.bool_]:
        near, found = state.near, np.zeros(len(proposed), np.bool_)
        found[near.connectivity[self._found(state, state.points, proposed)[near.corner_face]]] = True
        return found

    def _found(self, state: State, before: Float64, after: Float64) -> npt.NDArray[np.bool_]:
        found = np.empty(state.topology.n_faces, np.bool_)
        parallel.run(
            _find, *parallel.ranges(len(found)), before, after, state.near, self._reference(state), found
        )
        return found

    def check(self, state: State) -> str:
        found = self._found(state, state.original.points, state.points)
        return f"{int(found.sum())} faces are inverted that were not" if found.any() else ""
