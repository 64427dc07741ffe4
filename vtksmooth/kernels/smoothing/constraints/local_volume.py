"""Local volume: what steps sweep round each vertex is given back along its direction (Jiao, section 3)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from ....errors import ParameterError
from ....jit import parallel
from ....jit.compiled import device, kernel
from ....jit.simd import WIDTH, gather, pack, select, spread, unpack
from ....report import RunReport
from ...measures.aspect_ratio import area_vectors
from ...measures.comparison import has_walls, swept_at_corners
from ...measures.shifted_volume import ShiftedVolume
from ...measures.swept_volume import sweep_face, triangle_shares, volume_gradient
from ...mesh.adjacency import BOUNDARY
from ...mesh.regions import components
from ..run_state import State
from . import Beyond, Constraint, Float64, Int64, Phase
from .no_inversion import HALVINGS, NoInversion, any_inverted, newly_inverted, withdraw
from .null_space import directions, normals_for

#: Least cosine between a vertex' direction and the gradient of its volume; below, a correction would be
#: unstable (3.2).
_SMALLEST_COSINE = 0.05

#: Rounding of a number near 1.
_EPS = float(np.finfo(float).eps)

#: Most Newton steps to close the volume, and where boundaries have moved.
_CLOSINGS, _SECANTS = 4, 12

#: Normals for the equal step are renewed after so many passes, and each time so many times as many later: the
#: longer the surface has been smoothed, the less they turn.
_RENEWED = 8

#: Most solutions tried for a step: with vertices beyond a limit that keep what they were allowed before the
#: correction; with such that do not move at all; and after how many of these those round them do neither.
_KEEPING, _HOLDING, _WIDENING = 4, 16, 8


@kernel
def _sweep(starts, ends, before, after, offsets, connectivity, reference, flux, swept, portion, volumes):
    # What each face sweeps beyond its flux, by corners, and each `portion` of faces; returns how many
    # faces become inverted.
    inverted = 0
    for part in range(starts.size):
        volume = 0.0
        for f in range(starts[part], ends[part]):
            sweep_face(before, after, offsets, connectivity, f, swept)
            if flux.size > 0:
                size = offsets[f + 1] - offsets[f]
                for c in range(offsets[f], offsets[f + 1]):
                    swept[c] -= flux[f] / size
            for c in range(offsets[f], offsets[f + 1]):
                volume += swept[c]
            if newly_inverted(before, after, offsets, connectivity, reference, f):
                inverted += 1
        volumes[starts[part] // portion] = volume
    return inverted


@kernel
def _sweep_triangles(
    starts, ends, before, after, connectivity, reference, flux, swept, portion, volumes, area
):
    # As _sweep, where all faces are triangles, four at a time; and twice their area vectors afterwards.
    # The sign of a face is found step by step as quality.face_square finds it.
    inverted = spread(0.0)
    for part in range(starts.size):
        volume = spread(0.0)
        last = ends[part] - 1
        for f in range(starts[part], ends[part], WIDTH):
            # Where fewer are left, the last face takes the places of those that are missing.
            g = min(f + 1, last)
            h = min(f + 2, last)
            i = min(f + 3, last)
            left = pack(0.0, 1.0, 2.0, 3.0) < np.float64(ends[part] - f)
            k0 = np.uintp(connectivity[3 * f])
            k1 = np.uintp(connectivity[3 * g])
            k2 = np.uintp(connectivity[3 * h])
            k3 = np.uintp(connectivity[3 * i])
            ox, oy, oz = gather(before, k0, k1, k2, k3)
            px, py, pz = gather(after, k0, k1, k2, k3)
            k0 = np.uintp(connectivity[3 * f + 1])
            k1 = np.uintp(connectivity[3 * g + 1])
            k2 = np.uintp(connectivity[3 * h + 1])
            k3 = np.uintp(connectivity[3 * i + 1])
            qx, qy, qz = gather(before, k0, k1, k2, k3)
            sx, sy, sz = gather(after, k0, k1, k2, k3)
            k0 = np.uintp(connectivity[3 * f + 2])
            k1 = np.uintp(connectivity[3 * g + 2])
            k2 = np.uintp(connectivity[3 * h + 2])
            k3 = np.uintp(connectivity[3 * i + 2])
            rx, ry, rz = gather(before, k0, k1, k2, k3)
            tx, ty, tz = gather(after, k0, k1, k2, k3)
            ax = qx - ox
            ay = qy - oy
            az = qz - oz
            bx = rx - ox
            by = ry - oy
            bz = rz - oz
            ux = sx - px
            uy = sy - py
            uz = sz - pz
            vx = tx - px
            vy = ty - py
            vz = tz - pz
            of_p, of_q, of_r = triangle_shares(
                ax, ay, az, bx, by, bz, ux, uy, uz, vx, vy, vz,
                px - ox, py - oy, pz - oz, sx - qx, sy - qy, sz - qz, tx - rx, ty - ry, tz - rz,
            )  # fmt: skip
            if flux.size > 0:
                given = pack(flux[f], flux[g], flux[h], flux[i]) / 3.0
                of_p -= given
                of_q -= given
                of_r -= given
            volume += select(left, of_p + of_q + of_r, 0.0)
            swept[3 * f], swept[3 * g], swept[3 * h], swept[3 * i] = unpack(of_p)
            swept[3 * f + 1], swept[3 * g + 1], swept[3 * h + 1], swept[3 * i + 1] = unpack(of_q)
            swept[3 * f + 2], swept[3 * g + 2], swept[3 * h + 2], swept[3 * i + 2] = unpack(of_r)
            nx = uy * vz - uz * vy
            ny = uz * vx - ux * vz
            nz = ux * vy - uy * vx
            area[f, 0], area[g, 0], area[h, 0], area[i, 0] = unpack(nx)
            area[f, 1], area[g, 1], area[h, 1], area[i, 1] = unpack(ny)
            area[f, 2], area[g, 2], area[h, 2], area[i, 2] = unpack(nz)
            rx, ry, rz = gather(reference, f, g, h, i)
            after_all = nx * rx + ny * ry + nz * rz
            nx = ay * bz - az * by
            ny = az * bx - ax * bz
            nz = ax * by - ay * bx
            before_that = nx * rx + ny * ry + nz * rz
            inverted += select(
                left & (after_all < 0.0), select(before_that < 0.0, 0.0, spread(1.0)), spread(0.0)
            )
        v0, v1, v2, v3 = unpack(volume)
        volumes[starts[part] // portion] = v0 + v1 + v2 + v3
    v0, v1, v2, v3 = unpack(inverted)
    return int(v0 + v1 + v2 + v3)


@kernel
def _linearise(starts, ends, points, near, held, area, direction, swept, residual, answer):
    # The residual (9) of each v, and (10), the derivative of the volume by a step of v along d: 0 if v takes
    # no part; returns how many. `area`: twice the faces' area vectors, where all are triangles; otherwise
    # empty.
    idle = 0
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            total = 0.0
            gx = 0.0
            gy = 0.0
            gz = 0.0
            for row in range(near.corner_offsets[v], near.corner_offsets[v + 1]):
                c = np.uint32(near.corners[row])
                total += swept[c]
                if area.size > 0:
                    f = c // np.uint32(3)
                    gx += area[f, 0]
                    gy += area[f, 1]
                    gz += area[f, 2]
            residual[v] = total
            answer[v] = 0.0
            x = direction[v, 0]
            y = direction[v, 1]
            z = direction[v, 2]
            if not held[v] and (x != 0.0 or y != 0.0 or z != 0.0):
                if area.size > 0:
                    gx /= 6.0
                    gy /= 6.0
                    gz /= 6.0
                else:
                    gx, gy, gz = volume_gradient(points, near, v)
                along = gx * x + gy * y + gz * z
                if along > _SMALLEST_COSINE * np.sqrt(gx * gx + gy * gy + gz * gz):
                    answer[v] = along
            idle += answer[v] == 0.0
    return idle


@device
def _handed_over(v, ring_offsets, ring, residual, answer):
    # What v has to take over from neighbours that take no part: their residuals go in equal parts to those
    # of their neighbours that do, so that nothing of the whole is lost.
    total = 0.0
    for r in range(ring_offsets[v], ring_offsets[v + 1]):
        w = ring[r]
        if answer[w] == 0.0:
            takers = 0
            for s in range(ring_offsets[w], ring_offsets[w + 1]):
                takers += answer[ring[s]] != 0.0
            total += residual[w] / takers
    return total


@kernel
def _correct(starts, ends, near, residual, direction, answer, idle, share, after):
    # (11), with `share` 1; returns the largest residual met, per area. `idle`: whether some take no part.
    largest = 0.0
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            if answer[v] == 0.0:
                continue
            step = residual[v]
            if idle:
                step += _handed_over(v, near.ring_offsets, near.ring, residual, answer)
            step /= answer[v]
            largest = max(largest, abs(step))
            after[v, 0] -= share * step * direction[v, 0]
            after[v, 1] -= share * step * direction[v, 1]
            after[v, 2] -= share * step * direction[v, 2]
    return largest


@kernel
def _shift(starts, ends, body, step, direction, answer, after):
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            if answer[v] == 0.0:
                continue
            s = step[body[v] if body.size > 0 else 0]
            after[v, 0] += s * direction[v, 0]
            after[v, 1] += s * direction[v, 1]
            after[v, 2] += s * direction[v, 2]


@kernel
def _shift_all(starts, ends, step, direction, after):
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            x = direction[v, 0]
            y = direction[v, 1]
            z = direction[v, 2]
            if x != 0.0 or y != 0.0 or z != 0.0:
                after[v, 0] += step * x
                after[v, 1] += step * y
                after[v, 2] += step * z


def _root(cubic: Float64) -> float:
    """Return the root next to 0 of a cubic, by Newton's method; NaN where that does not lead there."""
    c, b, a, d = map(float, cubic)
    step = 0.0
    for _ in range(_SECANTS):
        slope = b + step * (2.0 * a + 3.0 * d * step)
        if not slope > 0.5 * b:
            break
        change = (c + step * (b + step * (a + d * step))) / slope
        step -= change
        if abs(change) <= _EPS * abs(step):
            return step
    return np.nan


@kernel
def _one_by_one(starts, ends, points, near, pinned, confined, flux, direction, proposed):
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            if pinned[v]:
                continue
            x = points[v, 0]
            y = points[v, 1]
            z = points[v, 2]
            gx, gy, gz = volume_gradient(points, near, v)
            swept = gx * (proposed[v, 0] - x) + gy * (proposed[v, 1] - y) + gz * (proposed[v, 2] - z)
            if flux.size > 0:
                for row in range(near.corner_offsets[v], near.corner_offsets[v + 1]):
                    f = near.corner_face[near.corners[row]]
                    swept -= flux[f] / (near.offsets[f + 1] - near.offsets[f])
            if swept != 0.0 and near.kinds[v] == 0 and not confined[v]:
                dx = direction[v, 0]
                dy = direction[v, 1]
                dz = direction[v, 2]
                along = gx * dx + gy * dy + gz * dz
                # alpha = -(b.t) / (b.d) of 3.2; exact, for what one vertex sweeps is linear in its step.
                if along > _SMALLEST_COSINE * np.sqrt(gx * gx + gy * gy + gz * gz):
                    proposed[v, 0] -= swept / along * dx
                    proposed[v, 1] -= swept / along * dy
                    proposed[v, 2] -= swept / along * dz
                else:
                    proposed[v, 0] = x
                    proposed[v, 1] = y
                    proposed[v, 2] = z


class LocalVolume(Constraint):
    """Give back, round every vertex, the volume that the steps sweep; Jiao, section 3.

    All at once: the quasi-Newton method of (11), one step along d for each vertex in each correction. The
    residual of a vertex is the weak form (9) itself, the swept volume times the vertex' shape function, which
    is exact for straight paths; with whole faces' volumes in its place, as (13) has it, the equations hardly
    see what alternates from vertex to vertex, and more corrections roughen the surface. Then, if wanted, a
    last step that is equal for all vertices of a body (what hangs together by faces) and closes its volume
    exactly. One by one: with corrections the Gauss-Seidel variant of section 3.2, exact in one step; without,
    the last step alone.

    No face that is not inverted is made so. Before the volume is corrected, steps that would invert one
    are shortened, as by :class:`~vtksmooth.kernels.smoothing.constraints.no_inversion.NoInversion`. Where the
    correction would carry a vertex beyond a limit, it does without, and the rest is solved again: the others
    give what it cannot. Where that does not close, the vertex stays where it was, then its neighbours too;
    at last the steps of all vertices are halved.

    Vertices without a direction (cusps), pinned ones and those on a boundary or on another line that they
    slide on are not moved for it: their neighbours take over what they would have to give back.

    Parameters
    ----------
    corrections : int
        Corrector steps of each pass; 1 to 3 suffice. They belong to steps across the surface: what steps off
        it are to remove they would give back.
    uniform : bool
        Whether the last step follows. It takes with it what rounding and earlier passes have left, so
        nothing adds up. A body that it cannot close stays where it was in this pass.
    flux : (m,) array_like, optional
        Volume that each face shall sweep in each pass, positive along its normal, in the numbering of the
        run's input: (8) to (11) of the paper. 0 if absent.
    whole : bool
        Whether what is closed is counted from the start of the run, not from pass to pass.

    Attributes
    ----------
    closes : bool
        Whether vertices slide on boundaries or lines of features. What a surface sweeps from the start to
        where it is then depends on more than on the sum of its steps, and is what is closed.
    """

    name = "A local volume (corrections, preserve_volume)"
    phase = Phase.CONSERVE
    topic = "volume"
    conflicts = {"surface": "who stays on the surface cannot move off it for the volume"}  # noqa: RUF012
    companions = (NoInversion(),)
    covers = frozenset({"inversion"})

    def __init__(
        self,
        corrections: int = 2,
        uniform: bool = True,
        flux: npt.ArrayLike | None = None,
        whole: bool = False,
    ) -> None:
        self.corrections, self.uniform, self.whole = corrections, uniform, whole
        self.flux = np.empty(0) if flux is None else np.ascontiguousarray(flux, dtype=np.float64)
        if self.flux.size:
            # More than a volume that stays, which some schemes keep by themselves.
            self.name, self.topic = "A flux of volume (flux)", "flux"
        #: Largest residual in the last pass, before each correction: volume swept round a vertex over the
        #: area that it stands for, model units.
        self.residuals: list[float] = []

    def tell(self, report: RunReport) -> None:
        report.volume_residuals = (*self.residuals, *self._last_residual())
        report.volume_shortened = self.shortened

    def bind(self, state: State) -> None:
        n, m = len(state.points), state.topology.n_faces
        if self.flux.shape not in ((0,), (m,)):
            raise ParameterError(
                f"flux must hold one value for each of the {m} faces, not have the shape {self.flux.shape}."
            )
        if self.uniform and has_walls(state.near):
            raise ParameterError(
                "The surface has walls between several bodies (edges of three faces or more), whose volumes "
                "a step of one body does not keep: name the labels on both sides of each face "
                "(boundary_labels), or leave out preserve_volume; with the scheme "
                "pairwise, self_intersection."
            )
        self._flux = self.flux
        if len(self.flux) and state.face_order is not None:
            self._flux = self.flux[state.face_order]
        self._own = state.direction is None
        self._direction = np.empty((n, 3)) if state.direction is None else state.direction
        self._normals = normals_for(state)
        self.residuals = []
        self.shortened = 0
        self._last_residual: Callable[[], list[float]] = list
        self._confined = np.zeros(n, np.uint8) if state.confined is None else state.confined
        slide = (self._confined != 0) | (state.near.kinds == BOUNDARY)
        # With corrections, vertices that move one by one give back what they sweep each for itself: all of
        # their way off the surface. Without, the pass is closed as a whole.
        self._alone = self.corrections > 0 or not state.in_place
        slides = bool((slide & (state.pinned == 0)).any())
        self.closes = self.uniform and (self.whole or not self._alone or slides)
        if len(self.flux) and self.closes:
            raise ParameterError("A flux takes boundaries that stay: set the boundary to fixed.")
        if self.closes or not state.in_place:
            self._swept = np.empty(len(state.topology.connectivity))
            self._residual, self._answer = np.empty(n), np.empty(n)
            # Summed range by range: then the sum does not depend on the number of threads.
            self._faces = parallel.ranges(m)
            self._volumes = np.empty(len(self._faces[0]))
            self._held = np.zeros(n, np.uint8)
            self._area = np.empty((m if state.topology.only_triangles else 0, 3))
            self._find_bodies(state)
        self._quick = not (
            self.corrections or not self.uniform or len(self._flux) or not self._own or self.closes
            or state.in_place or self._bodies > 1
        )  # fmt: skip
        if self._quick:
            self._passes, self._renewal, self._reach = 0, _RENEWED, 0.0
            used = state.points[state.topology.connectivity]
            origin = 0.5 * (used.min(axis=0) + used.max(axis=0))
            self._shifted = ShiftedVolume(state.topology, state.near, state.pinned, state.reference, origin)
            self._vectors = area_vectors(state.mesh)
            self._shifted.along_normals(self._vectors)
            self._enclosed = self._shifted(state.points, 0.0, self._vectors[:0])[0][0]

    def closing(self) -> Constraint | None:
        if len(self.flux):
            raise ParameterError("A flux takes all its steps: set self_intersection to ignore.")
        return LocalVolume(0, True, whole=True) if self.uniform else None

    def forget(self, state: State) -> None:
        if self.uniform and not (state.in_place or self.closes):
            self._left = np.zeros(self._bodies)

    def _find_bodies(self, state: State) -> None:
        topology, n = state.topology, len(state.points)
        root = components(topology)
        roots = np.flatnonzero(np.bincount(root[topology.connectivity]))
        self._bodies = max(1, len(roots))
        self._body = np.empty(0, np.int32)
        if len(roots) > 1:
            number = np.zeros(n, np.int32)
            number[roots] = np.arange(len(roots))
            self._body = number[root]
            self._corner_body = self._body[topology.connectivity]
        # What earlier passes left over, and how near to nothing rounding of the coordinates lets it come.
        self._left = np.zeros(self._bodies)
        areas = np.linalg.norm(area_vectors(state.mesh), axis=1) / np.maximum(topology.face_sizes, 1)
        largest = np.abs(state.points[topology.connectivity]).max(initial=0.0)
        of_corners = np.repeat(areas, topology.face_sizes)
        area = np.array([of_corners.sum()]) if self._bodies == 1 else self._of_bodies(of_corners)
        self._tolerance = 4.0 * _EPS * largest * area

    def _of_bodies(self, of_corners: Float64) -> Float64:
        return np.bincount(self._corner_body, of_corners, self._bodies).astype(np.float64)

    def _left_over(self, state: State, after: Float64) -> Float64:
        """Return the volume that each body has swept, in this pass and in earlier ones."""
        if self.closes:
            self._sweep(state, state.original.points, after)
        swept = np.array([self._volumes.sum()]) if self._bodies == 1 else self._of_bodies(self._swept)
        return swept + self._left

    # -- one by one --------------------------------------------------------------------------------

    def dispose(self, state: State, starts: Int64, ends: Int64, proposed: Float64) -> None:
        if not self._alone:
            return
        if self._own:
            directions(state, starts, ends, self._normals, self._direction)
        parallel.run(
            _one_by_one, starts, ends, state.points, state.near, state.pinned, self._confined, self._flux,
            self._direction, proposed, smallest_share=parallel.COSTLY,
        )  # fmt: skip

    # -- all at once, an equal step of all alone -----------------------------------------------------

    def _close_at_once(self, state: State, before: Float64, proposed: Float64, beyond: Beyond) -> bool:
        """Close the volume by one step that is known beforehand; return whether nothing is against that.

        Along the normals of the mesh that an earlier pass proposed. They hardly turn once the first passes
        are done, and are renewed now and then.
        """
        if self._passes == self._renewal:
            self._shifted.along_normals(self._vectors)
            self._renewal *= _RENEWED
        self._passes += 1
        # Areas are written down where the next pass will ask for them.
        area = self._vectors if self._passes == self._renewal else self._vectors[:0]
        cubic, doubtful = self._shifted(proposed, self._reach, area)
        cubic[0] -= self._enclosed
        step = _root(cubic)
        if not np.isfinite(step):
            return False
        vertices = parallel.ranges(len(proposed))
        parallel.run(_shift_all, *vertices, step, self._shifted.direction, proposed)
        doubtful += abs(step) > self._reach
        self._reach = 4.0 * abs(step)
        if (doubtful and any_inverted(state, before, proposed)) or beyond(state, proposed).any():
            parallel.run(_shift_all, *vertices, -step, self._shifted.direction, proposed)
            return False
        self._left = np.zeros(1)
        return True

    # -- all at once -------------------------------------------------------------------------------

    def conserve(
        self, state: State, before: Float64, proposed: Float64, beyond: Beyond, back: Float64
    ) -> bool:
        if self._quick and self._close_at_once(state, before, proposed, beyond):
            return True
        vertices = parallel.ranges(len(proposed))
        if self._own or state.in_place:
            directions(state, *vertices, self._normals, self._direction)
        if state.confined is not None:
            self._direction[self._confined != 0] = 0.0
        self._admit(state, before, proposed, beyond)
        wanted = proposed.copy()
        # In place the steps have been taken: there is nothing to halve.
        for halving in range(1 if state.in_place else HALVINGS + 1):
            if self._solved(state, before, proposed, wanted, beyond):
                self.shortened += halving > 0
                self._left = self._close(state, before, proposed, back)
                return True
            wanted = before + 0.5 * (wanted - before)
            proposed[:] = wanted
            self._admit(state, before, proposed, beyond)
            wanted[:] = proposed
        self.shortened += 1
        proposed[:] = before
        self._sweep(state, before, proposed)
        self._left = np.zeros(self._bodies) if self.closes else self._left_over(state, proposed)
        return False

    def _admit(self, state: State, before: Float64, proposed: Float64, beyond: Beyond) -> None:
        """Shorten steps before anything is corrected, so that no face is inverted and no limit exceeded."""
        while self._sweep(state, before, proposed):
            withdraw(state, before, proposed, HALVINGS, self._held)
            outside = beyond(state, proposed)
            if not outside.any():
                self._sweep(state, before, proposed)
                return
            proposed[outside] = before[outside]

    def _solved(
        self, state: State, before: Float64, proposed: Float64, wanted: Float64, beyond: Beyond
    ) -> bool:
        """Correct `proposed`, which is as `wanted`, within the limits; return whether that can be done."""
        near, held = state.near, self._held
        for attempts, fallback in ((_KEEPING, wanted), (_HOLDING, before)):
            held[:] = 0
            if fallback is before:
                proposed[:] = wanted
                self._sweep(state, before, proposed)
            for attempt in range(attempts):
                inverted = self._solve(state, before, proposed)
                outside = beyond(state, proposed)
                if not inverted and not outside.any():
                    return True
                held[outside] = 1
                proposed[outside] = fallback[outside]
                withdraw(state, before, proposed, 0, held)
                if attempt >= _WIDENING:  # ring after ring, so that it comes to an end
                    reached = np.zeros(state.topology.n_faces, dtype=bool)
                    reached[near.corner_face[held[near.connectivity] != 0]] = True
                    held[near.connectivity[reached[near.corner_face]]] = 1
                    proposed[held != 0] = before[held != 0]
                self._sweep(state, before, proposed)
        return False

    def _sweep(self, state: State, before: Float64, after: Float64) -> int:
        topology = state.topology
        portion = int(self._faces[1][0])
        if len(self._area):
            inverted = parallel.run(
                _sweep_triangles, *self._faces, before, after,
                topology.connectivity, state.reference, self._flux,
                self._swept, portion, self._volumes, self._area,
            )  # fmt: skip
        else:
            inverted = parallel.run(
                _sweep, *self._faces, before, after,
                topology.offsets, topology.connectivity, state.reference, self._flux,
                self._swept, portion, self._volumes,
            )  # fmt: skip
        return sum(inverted)

    def _solve(self, state: State, before: Float64, proposed: Float64) -> int:
        """Correct `proposed`, of which `_swept` holds; return how many faces this inverts."""
        vertices, direction = parallel.ranges(len(proposed)), self._direction
        near, residual, answer = state.near, self._residual, self._answer

        def linearise() -> bool:
            return any(
                parallel.run(
                    _linearise, *vertices, proposed, near, self._held, self._area, direction,
                    self._swept, residual, answer,
                )
            )  # fmt: skip

        def correct(share: float) -> float:
            # Linearised anew for each: what is left of the whole volume is then of second order in this step
            # alone.
            idle = linearise()
            return max(
                parallel.run(_correct, *vertices, near, residual, direction, answer, idle, share, proposed),
                default=0.0,
            )

        inverted = 0
        self.residuals = []
        for _ in range(0 if state.in_place else self.corrections):
            self.residuals.append(correct(1.0))
            inverted = self._sweep(state, before, proposed)
        if self.corrections and not state.in_place:
            self._last_residual = lambda: [correct(0.0)]
        step, earlier = np.zeros(self._bodies), np.zeros(self._bodies)
        for turn in range((_SECANTS if self.closes else _CLOSINGS) if self.uniform else 0):
            left = self._left_over(state, proposed)
            if (np.abs(left) <= self._tolerance).all():
                break
            # What is left after corrections is so little that their last slope closes it, as a rule.
            if turn > 0 or not self.corrections or self.closes:
                linearise()
            slope = answer.sum(keepdims=True)
            if self._bodies > 1:
                slope = np.bincount(self._body, answer, self._bodies)
            if self.closes and turn > 0:
                found = np.divide(left - earlier, step, out=slope.copy(), where=step != 0.0)
                slope = np.where((found > 0.5 * slope) & (found < 2.0 * slope), found, slope)
            earlier = left
            step = np.divide(-left, slope, out=np.zeros_like(left), where=slope > 0.0)
            parallel.run(_shift, *vertices, self._body, step, direction, answer, proposed)
            inverted = self._sweep(state, before, proposed)
        return inverted

    def _close(self, state: State, before: Float64, proposed: Float64, back: Float64) -> Float64:
        """Take back the steps of bodies that could not be closed; return what is left over."""
        if not self.uniform:
            return self._left
        left = self._left_over(state, proposed)
        unclosed = ~(np.abs(left) <= self._tolerance)
        if unclosed.any():
            whole = np.broadcast_to(True, len(proposed)) if self._bodies == 1 else unclosed[self._body]
            proposed[whole] = back[whole]
            self._sweep(state, before, proposed)
            left = self._left_over(state, proposed)
        return np.zeros(self._bodies) if self.closes else left

    def check(self, state: State) -> str:
        if not self.uniform or self.flux.size:
            return ""
        before, after = state.original, state.mesh
        swept = swept_at_corners(before, after)
        body = components(state.topology)[state.topology.connectivity]
        total = np.abs(np.bincount(body, swept))
        allowed = 1e-12 * before.diagonal**3
        return f"a body sweeps {total.max():.3g}" if total.max(initial=0.0) > allowed else ""
