"""Directions: points that move along some axes only, in symmetry planes, or about an axis."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from ....jit import parallel
from ....jit.compiled import kernel
from ...mesh.adjacency import BOUNDARY
from ..run_state import State
from . import Constraint, Float64, Int64, Phase
from .no_inversion import NoInversion

#: How far from a symmetry plane a point is on it, in diagonals: coordinates in single precision are.
ON_PLANE = 1e-6

#: How far a line may leave that through its neighbours to be straight, and a step that line; in lengths.
_STRAIGHT = 1e-9


@kernel
def _keep(starts, ends, points, first, kept, axis, center, along, pinned, proposed):
    u = (axis + 1) % 3
    w = (axis + 2) % 3
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            if pinned[v]:
                continue
            # What slides on a straight line must not leave it: where the directions lead off it, it stays.
            length = 0.0
            on_line = 0.0
            for i in range(3):
                step = proposed[v, i] - points[v, i]
                length += step * step
                on_line += step * along[v, i]
            slides = length > 0.0 and on_line * on_line >= (1.0 - 1e-15) * length
            if axis >= 0 and (proposed[v, u] != points[v, u] or proposed[v, w] != points[v, w]):
                x = proposed[v, u] - center[u]
                y = proposed[v, w] - center[w]
                a = first[v, u] - center[u]
                b = first[v, w] - center[w]
                reached = np.sqrt(x * x + y * y)
                if reached > 0.0:
                    part_of = np.sqrt(a * a + b * b) / reached
                    proposed[v, u] = center[u] + part_of * x
                    proposed[v, w] = center[w] + part_of * y
                else:
                    proposed[v, u] = points[v, u]
                    proposed[v, w] = points[v, w]
            for i in range(3):
                if kept[v] & (1 << i):
                    proposed[v, i] = first[v, i]
            if slides:
                on_line = 0.0
                length = 0.0
                for i in range(3):
                    step = proposed[v, i] - points[v, i]
                    length += step * step
                    on_line += step * along[v, i]
                if on_line * on_line < (1.0 - 1e-15) * length:
                    for i in range(3):
                        proposed[v, i] = points[v, i]


class Directions(Constraint):
    """Points move along some axes only, in symmetry planes that they are in, or about an axis.

    Coordinates that are kept have the bits they had. In plan, where two coordinates change, no face turns
    over in the plan. Points that slide along a straight line stay where directions lead off it.

    Parameters
    ----------
    axes : str
        Which coordinates may change, of "xyz"; with `about` all are those that rotation changes.
    about : int, optional
        Number of the axis about which points turn, 0 to 2.
    center : (3,) array_like
        A point on the axis.
    planes : sequence of (int, float)
        Symmetry planes: a coordinate and its value. Points on a plane at the start stay on it.
    """

    phase = Phase.RETRACT
    topic = "directions"
    name = "Directions (directions, symmetry_planes)"
    conflicts = {  # noqa: RUF012
        "volume": "volumes are kept by steps across the surface",
        "surface": "the surface leads off the directions",
        "turning": "both turn the same steps",
    }

    def __init__(
        self,
        axes: str = "xyz",
        about: int | None = None,
        center: npt.ArrayLike = (0.0, 0.0, 0.0),
        planes: Sequence[tuple[int, float]] = (),
    ) -> None:
        self.kept = sum(1 << i for i, axis in enumerate("xyz") if axis not in axes and about is None)
        self.about = -1 if about is None else about
        self.kept |= 0 if about is None else 1 << about
        self.center, self.planes = np.array(center, np.float64), tuple(planes)
        plan = [i for i in range(3) if self.kept == 1 << i]
        self.companions = (NoInversion(plan[0]),) if plan and about is None else ()

    def bind(self, state: State) -> None:
        self._first = state.points.copy()
        self._kept = np.full(len(self._first), self.kept, np.uint8)
        tolerance = ON_PLANE * state.original.diagonal
        for axis, value in self.planes:
            self._kept[np.abs(self._first[:, axis] - value) <= tolerance] |= 1 << axis
        turns = self._kept & ~np.uint8(1 << self.about if self.about >= 0 else 7)
        state.pinned[(self._kept == 7) | (turns != 0)] = 1
        self._along = np.zeros_like(self._first)
        self._add_lines(state, np.flatnonzero(state.near.kinds == BOUNDARY), state.near.boundary_ring)
        if state.confined is not None:
            self._add_lines(state, np.flatnonzero(state.confined), state.features.ridge_ring)

    def _add_lines(self, state: State, vertices: Int64, ring: npt.NDArray[np.int32]) -> None:
        """Note the directions of straight lines at those of the `vertices` that are on one."""
        vertices = vertices[(ring[vertices] >= 0).all(axis=1)]
        first, second = state.points[ring[vertices, 0]], state.points[ring[vertices, 1]]
        line = second - first
        length = np.linalg.norm(line, axis=1)
        off = np.linalg.norm(np.cross(state.points[vertices] - first, line), axis=1)
        straight = (length > 0.0) & (off <= _STRAIGHT * length * length)
        self._along[vertices[straight]] = line[straight] / length[straight, None]

    def dispose(self, state: State, starts: Int64, ends: Int64, proposed: Float64) -> None:
        parallel.run(
            _keep, starts, ends, state.points, self._first, self._kept, self.about, self.center, self._along,
            state.pinned, proposed,
        )  # fmt: skip

    def check(self, state: State) -> str:
        before, after = state.original.points, state.points
        used = np.diff(state.near.corner_offsets) > 0
        for axis in range(3):
            held = used & (self._kept & (1 << axis) != 0)
            changed = before[held, axis].view(np.uint64) != after[held, axis].view(np.uint64)
            if changed.any():
                return f"{int(changed.sum())} points moved in {'xyz'[axis]}"
        if self.about < 0:
            return ""
        others = [(self.about + 1) % 3, (self.about + 2) % 3]
        radii = [np.linalg.norm((each - self.center)[used][:, others], axis=1) for each in (before, after)]
        off = np.abs(radii[1] - radii[0]).max(initial=0.0)
        allowed = 1e-13 * (state.original.diagonal + np.abs(self.center).max() + np.abs(before[used]).max())
        return f"a point is off its circle by {off:.3g}" if off > allowed else ""
