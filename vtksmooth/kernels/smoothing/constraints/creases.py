"""Creases: edges that were sharp at the start of the run stay sharp."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ....jit import parallel
from ....jit.compiled import device, kernel
from ...measures.comparison import angle_between, dihedral_angle, dihedral_angles
from ...mesh import adjacency
from ..run_state import State
from . import Constraint, Float64, Int64


@device
def _where(points, w, v, x, y, z):
    if w == v:
        return x, y, z
    return points[w, 0], points[w, 1], points[w, 2]


@device
def _area_vector(points, near, f, v, x, y, z):
    # Twice the area vector of face f, with vertex v at (x, y, z).
    a = near.offsets[f]
    ox, oy, oz = _where(points, near.connectivity[a], v, x, y, z)
    nx = 0.0
    ny = 0.0
    nz = 0.0
    for c in range(a + 1, near.offsets[f + 1] - 1):
        px, py, pz = _where(points, near.connectivity[c], v, x, y, z)
        qx, qy, qz = _where(points, near.connectivity[c + 1], v, x, y, z)
        px -= ox
        py -= oy
        pz -= oz
        qx -= ox
        qy -= oy
        qz -= oz
        nx += py * qz - pz * qy
        ny += pz * qx - px * qz
        nz += px * qy - py * qx
    return nx, ny, nz


@device
def _stays(points, near, edge_ends, edge_faces, sign, limit, s, v, x, y, z):
    # Whether edge s is sharp enough with vertex v at (x, y, z), whatever goes on on its other side.
    p = edge_ends[s, 0]
    q = edge_ends[s, 1]
    px, py, pz = _where(points, p, v, x, y, z)
    qx, qy, qz = _where(points, q, v, x, y, z)
    ax, ay, az = _area_vector(points, near, edge_faces[s, 0], v, x, y, z)
    bx, by, bz = _area_vector(points, near, edge_faces[s, 1], v, x, y, z)
    new = sign[s] * dihedral_angle(ax, ay, az, bx, by, bz, qx - px, qy - py, qz - pz)
    if p == v or q == v:
        return new >= limit
    # A face without an area has no direction, and no angle that it turns by could be too large.
    if (ax == 0.0 and ay == 0.0 and az == 0.0) or (bx == 0.0 and by == 0.0 and bz == 0.0):
        return False
    nobody = np.int64(-1)
    cx, cy, cz = _area_vector(points, near, edge_faces[s, 0], nobody, x, y, z)
    dx, dy, dz = _area_vector(points, near, edge_faces[s, 1], nobody, x, y, z)
    old = sign[s] * dihedral_angle(cx, cy, cz, dx, dy, dz, qx - px, qy - py, qz - pz)
    # A vertex of the face on the other side may move at the same time; each may use half of what is left.
    # Triangles turn about the edge, and angles add; polygons may turn otherwise too.
    turn = max(angle_between(ax, ay, az, cx, cy, cz), angle_between(bx, by, bz, dx, dy, dz))
    f = edge_faces[s, 0]
    g = edge_faces[s, 1]
    sharper = (
        new >= old and near.offsets[f + 1] - near.offsets[f] == 3 == near.offsets[g + 1] - near.offsets[g]
    )
    return turn <= 0.5 * (np.pi - old) and (sharper or turn <= 0.5 * (old - limit))


@kernel
def _keep(starts, ends, points, near, row, sharp, edge_ends, edge_faces, sign, limit, proposed):
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            if row[v] == row[v + 1]:
                continue
            x = points[v, 0]
            y = points[v, 1]
            z = points[v, 2]
            dx = proposed[v, 0] - x
            dy = proposed[v, 1] - y
            dz = proposed[v, 2] - z
            if dx == 0.0 and dy == 0.0 and dz == 0.0:
                continue
            step = 1.0
            for attempt in range(5):
                if attempt == 4:
                    step = 0.0
                proposed[v, 0] = x + step * dx
                proposed[v, 1] = y + step * dy
                proposed[v, 2] = z + step * dz
                if attempt == 4:
                    break
                kept = True
                for i in range(row[v], row[v + 1]):
                    if not _stays(
                        points, near, edge_ends, edge_faces, sign, limit, sharp[i],
                        v, proposed[v, 0], proposed[v, 1], proposed[v, 2],
                    ):  # fmt: skip
                        kept = False
                        break
                if kept:
                    break
                step *= 0.5


class Creases(Constraint):
    """Edges whose dihedral angle is above a threshold at the start of the run stay above it.

    What features miss (single sharp edges, ridges amid noise) is kept as well, and vertices beside them
    remain free to move. Steps that would flatten such an edge too far, or fold it over, are halved three
    times, then refused. Convex edges stay convex and concave ones concave, except that beside polygons two
    vertices that move at the same time may turn one into the other. Boundary and non-manifold edges have no
    dihedral angle and are not looked at.

    Parameters
    ----------
    angle : float
        Degrees, 0 to 180.
    """

    name = "A bound on creases (crease_angle)"

    in_place = True

    def __init__(self, angle: float = 40.0) -> None:
        self.angle = angle
        self._edges: tuple[npt.NDArray[Any], ...] = ()

    def bind(self, state: State) -> None:
        near = state.near
        edge_ends, edge_faces = adjacency.edges(near)
        degrees = dihedral_angles(state.mesh, edge_ends, edge_faces)
        sharp = np.flatnonzero(np.abs(degrees) > self.angle)
        edge_ends, edge_faces, degrees = edge_ends[sharp], edge_faces[sharp], degrees[sharp]
        # Which sharp edges each vertex can change: those of its faces.
        pairs = []  # as one number each, and sorted: np.unique takes numpy fifty times as long
        for face in edge_faces.T:
            sizes = state.topology.face_sizes[face]
            owner = np.repeat(np.arange(len(sharp)), sizes)
            corner = np.arange(len(owner)) + np.repeat(near.offsets[face] - np.cumsum(sizes) + sizes, sizes)
            pairs.append(near.connectivity[corner].astype(np.int64) * len(sharp) + owner)
        rows = np.sort(np.concatenate(pairs))
        rows = rows[np.diff(rows, prepend=-1) > 0]
        vertex, edge = np.divmod(rows, max(len(sharp), 1))
        row = np.concatenate(([0], np.cumsum(np.bincount(vertex, minlength=len(near.kinds)))))
        self._edges = (row, np.ascontiguousarray(edge), edge_ends, edge_faces, np.sign(degrees))

    def dispose(self, state: State, starts: Int64, ends: Int64, proposed: Float64) -> None:
        parallel.run(
            _keep, starts, ends, state.points, state.near, *self._edges, np.radians(self.angle), proposed,
            smallest_share=parallel.COSTLY,
        )  # fmt: skip

    def exceeded(self, state: State, proposed: Float64, rows: Int64) -> npt.NDArray[np.bool_]:
        near, faces = state.near, np.zeros(state.topology.n_faces, np.bool_)
        faces[self._edges[3][self._flat(state, proposed, 1e-9)]] = True
        found = np.zeros(len(proposed), np.bool_)
        found[near.connectivity[faces[near.corner_face]]] = True
        return found

    def _flat(self, state: State, points: Float64, tolerance: float) -> npt.NDArray[np.bool_]:
        _, _, edge_ends, edge_faces, sign = self._edges
        degrees = sign * dihedral_angles(state.topology.with_points(points), edge_ends, edge_faces)
        if not state.topology.only_triangles:
            degrees = np.abs(degrees)
        flat: npt.NDArray[np.bool_] = degrees < self.angle - tolerance
        return flat

    def check(self, state: State) -> str:
        flat = int(self._flat(state, state.points, 1e-7).sum())
        return f"{flat} creases are flat" if flat else ""
