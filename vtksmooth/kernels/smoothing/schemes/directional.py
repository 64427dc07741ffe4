"""Explicit steps of the Laplacian with the weights as such: for directional smoothing."""

from __future__ import annotations

import numpy as np

from ....jit import parallel
from ....jit.compiled import kernel
from ...mesh.adjacency import INTERIOR, LINE
from ..run_state import State
from ..weights import Weights
from . import Float64, Int64, Scheme


@kernel
def _step(starts, ends, points, laplacian, pinned, factor, proposed):
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            for axis in range(3):
                proposed[v, axis] = points[v, axis]
                if not pinned[v]:
                    proposed[v, axis] += factor * laplacian[v, axis]


@kernel
def _bend(starts, ends, offsets, neighbours, weights, laplacian):
    # -L(L(p)) over nu = 1 + sum_j w_ij w_ji, by which a step of v alone changes its own L(L(p)).
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            nu = 1.0
            for r in range(offsets[v], offsets[v + 1]):
                w = neighbours[r]
                for back in range(offsets[w], offsets[w + 1]):
                    if neighbours[back] == v:
                        nu += weights[r] * weights[back]
            for axis in range(3):
                laplacian[v, axis] /= -nu


class Directional(Scheme):
    """``p + factor L(p)`` with any weights, directional above all; or the thin plate's ``-L(L(p)) / nu``.

    L is taken once, at the beginning of each pass.

    Parameters
    ----------
    weights : Weights
    factors : sequence of float
        One for each pass of an iteration.
    thin_plate : bool
        Whether the operator is applied twice, L on the boundary taken as 0: the operator of
        :class:`~vtksmooth.kernels.smoothing.schemes.thin_plate.ThinPlate`, which is quicker, with other
        weights.
    """

    def __init__(
        self, weights: Weights, factors: tuple[float, ...] = (0.5,), thin_plate: bool = False
    ) -> None:
        self.asked_weights, self.factors, self.thin_plate = weights, factors, thin_plate
        self.passes, self.relaxation = len(factors), factors[0]
        self.moves_lines = weights.kind != "cotangent"

    def bind(self, state: State) -> None:
        self.weights = self.asked_weights.in_run(state)
        self.values: Float64 | None = None
        self.laplacian, self.first = np.empty_like(state.points), np.empty_like(state.points)

    def prepare(self, state: State, turn: int) -> None:
        if self.values is None or not self.weights.constant:
            self.values = self.weights.compute(state.points, state.near, self.values)
        field = self.innermost(state, self.values, state.points)
        self.weights.apply(field, state.near, self.values, self.laplacian)
        if self.thin_plate:
            self.scale(state, self.values)

    def scale(self, state: State, values: Float64) -> None:
        """Make the step of the thin plate of L(L(p)) in `laplacian`."""
        everything = parallel.ranges(len(state.points))
        parallel.run(_bend, *everything, *self.weights.rows(state.near), values, self.laplacian)

    def innermost(self, state: State, values: Float64, field: Float64) -> Float64:
        """Return what L is applied to last: the field itself, or its own L, which is 0 on the boundary."""
        if not self.thin_plate:
            return field
        self.weights.apply(field, state.near, values, self.first)
        self.first[(state.near.kinds != INTERIOR) & (state.near.kinds < LINE)] = 0.0
        return self.first

    def propose(self, state: State, turn: int, starts: Int64, ends: Int64, proposed: Float64) -> None:
        parallel.run(
            _step, starts, ends,
            state.points, self.laplacian, state.pinned, self.factors[turn], proposed,
        )  # fmt: skip
