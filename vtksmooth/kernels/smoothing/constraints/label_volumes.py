"""Volumes of all labels: one equal step for each label closes them, all vertices at the same time."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ....errors import ParameterError
from ....jit import parallel
from ....jit.compiled import device, kernel
from ...measures.aspect_ratio import area_vectors
from ...measures.comparison import swept_at_corners
from ...measures.label_volumes import label_volumes
from ..run_state import State
from . import Beyond, Constraint, Float64, Int64, Phase
from .no_inversion import NoInversion

#: Most Newton steps, and what is left of a volume, as a part of it, that is rounding.
_NEWTON, _ROUNDING = 12, 1e-14

#: What is left of a volume, as a part of it, for which steps are taken back.
_TOO_MUCH = 1e-12

#: Most solutions tried without vertices that a limit stops, which stay where they were proposed to be, then
#: where they were before; and how often the steps are halved then.
_KEEPING, _HOLDING, _HALVINGS = 4, 8, 3

#: Volume of the ball with area 1: no surface of that area encloses more.
_BALL = 1.0 / (6.0 * np.sqrt(np.pi))


@device
def _gradients(v, near, area, labels, found, g):
    # Of the volume of each label at v by its place; returns how many labels there are, and the measure of v.
    count = 0
    for row in range(near.corner_offsets[v], near.corner_offsets[v + 1]):
        f = near.corner_face[near.corners[row]]
        share = 1.0 / np.float64(near.offsets[f + 1] - near.offsets[f])
        for side in range(2):
            place = 0
            while place < count and found[place] != labels[f, side]:
                place += 1
            if place == count:
                found[place] = labels[f, side]
                g[place, 0] = 0.0
                g[place, 1] = 0.0
                g[place, 2] = 0.0
                count += 1
            sign = share if side == 0 else -share
            g[place, 0] += sign * area[f, 0]
            g[place, 1] += sign * area[f, 1]
            g[place, 2] += sign * area[f, 2]
    total = 0.0
    for place in range(count):
        total += 0.5 * np.sqrt(g[place, 0] ** 2 + g[place, 1] ** 2 + g[place, 2] ** 2)
    return count, total


@kernel
def _add_up(near, area, labels, held, widest, matrix):
    found = np.empty(widest, np.int32)
    g = np.empty((widest, 3))
    for v in range(held.size):
        if held[v]:
            continue
        count, total = _gradients(v, near, area, labels, found, g)
        if total == 0.0:
            continue
        for k in range(count):
            for m in range(count):
                along = g[k, 0] * g[m, 0] + g[k, 1] * g[m, 1] + g[k, 2] * g[m, 2]
                matrix[found[k], found[m]] += along / total


@kernel
def _step(starts, ends, near, area, labels, held, widest, steps, points):
    found = np.empty(widest, np.int32)
    g = np.empty((widest, 3))
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            if held[v]:
                continue
            count, total = _gradients(v, near, area, labels, found, g)
            for k in range(count if total > 0.0 else 0):
                for axis in range(3):
                    points[v, axis] += steps[found[k]] / total * g[k, axis]


class LabelVolumes(Constraint):
    """Close the volumes of all labels of a surface between labels, after every pass.

    ``p_v += sum_l mu_l D_v^l``, D_v^l = g_v^l / a_v with the gradient g_v^l of the volume of label l at v and
    a_v half the sum of their lengths: on a face the unit normal. The steps mu, one for each label, solve
    ``sum_k mu_k sum_v g_v^l . D_v^k = -dV_l``, again and again until nothing but rounding is left. What is
    swept since the start of the run is closed, so nothing adds up.

    Vertices that a limit does not let go there take no part, at last none in the pass, and the rest is solved
    again; then all steps are halved, and taken back. No face that is not inverted is made so.

    A step of a label is the same everywhere on its walls: the constraint is not local.
    """

    name = "The volumes of all labels (preserve_volume)"
    phase = Phase.CONSERVE
    topic = "volume"
    conflicts = {"surface": "who stays on the surface cannot move off it for the volume"}  # noqa: RUF012
    companions = (NoInversion(),)
    closes = True

    #: Labels of both sides of each face; none before it is bound.
    _labels: npt.NDArray[np.int32] = np.empty((0, 2), np.int32)

    def tell(self, report: object) -> None:
        """Say in how many passes steps were shortened."""
        report.volume_shortened = self.shortened  # type: ignore[attr-defined]

    def bind(self, state: State) -> None:
        labels = state.topology.face_labels
        if labels is None:
            raise ParameterError("The volumes of labels can be kept only where faces have labels.")
        self._labels = labels
        self._count = int(labels.max()) + 1
        self.shortened = 0
        near = state.near
        self._widest = 2 * int(np.diff(near.corner_offsets).max())
        area = np.linalg.norm(area_vectors(state.topology.with_points(state.points)), axis=1)
        total = sum(np.bincount(labels[:, side], area, self._count) for side in range(2))
        ball = _BALL * np.asarray(total) ** 1.5
        volume = np.abs(label_volumes(state.topology.with_points(state.points)))
        # Open surfaces have no volume, and that of what is outside of all is the largest.
        self._scale = np.where(volume > 0.0, np.minimum(volume, ball), ball)

    def closing(self) -> Constraint | None:
        return LabelVolumes()

    def dispose(self, state: State, starts: Int64, ends: Int64, proposed: Float64) -> None:
        """Nothing for single vertices: a pass in place is closed as a whole."""

    def _left(self, state: State, points: Float64) -> Float64:
        """Return what each label has gained since the start of the run."""
        topology = state.topology
        swept = swept_at_corners(state.original, topology.with_points(points))
        of_faces = np.add.reduceat(swept, topology.offsets[:-1])
        first, second = (np.bincount(self._labels[:, side], of_faces, self._count) for side in range(2))
        return np.asarray(first - second)

    def _close(self, state: State, held: np.ndarray, points: Float64) -> bool:
        """Move `points` until the volumes are closed; whether they are."""
        for turn in range(_NEWTON + 1):
            left = self._left(state, points)
            if (np.abs(left) <= _ROUNDING * self._scale).all():
                return True
            if turn == _NEWTON or not np.isfinite(left).all():
                break
            area = area_vectors(state.topology.with_points(points))
            matrix = np.zeros((self._count, self._count))
            _add_up(state.near, area, self._labels, held, self._widest, matrix)
            steps = np.linalg.lstsq(matrix, -left, rcond=1e-12)[0]
            parallel.run(
                _step, *parallel.ranges(len(points)),
                state.near, area, self._labels, held, self._widest, steps, points,
            )  # fmt: skip
        return bool((np.abs(left) <= _TOO_MUCH * self._scale).all())

    def conserve(
        self, state: State, before: Float64, proposed: Float64, beyond: Beyond, back: Float64
    ) -> bool:
        wanted = proposed.copy()
        for halving in range(_HALVINGS + 1):
            held = (state.pinned != 0) | (state.confined is not None and state.confined != 0)
            proposed[:] = before + 0.5**halving * (wanted - before) if halving else wanted
            for turn in range(_KEEPING + _HOLDING):
                attempt = proposed.copy()
                if not self._close(state, held.astype(np.uint8), attempt):
                    break
                bad = beyond(state, attempt) & ~held
                if not bad.any():
                    proposed[:] = attempt
                    self.shortened += halving > 0
                    return True
                held |= bad
                if turn >= _KEEPING:
                    proposed[bad] = before[bad]
        self.shortened += 1
        proposed[:] = back
        return False

    def check(self, state: State) -> str:
        if not len(self._labels):  # the scheme has kept the volumes
            self.bind(state)
        left = np.abs(self._left(state, state.points)) / self._scale
        return f"the volume of a label changes by {left.max():.3g} of it" if left.max() > 1e-11 else ""
