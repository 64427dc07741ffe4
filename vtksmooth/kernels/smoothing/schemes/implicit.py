"""Implicit steps of the Laplacian: a sparse system in place of many small steps, stable for any size."""

from __future__ import annotations

import math

import numpy as np

from ....errors import ParameterError
from ....jit import parallel
from ....jit.compiled import kernel
from ...mesh.adjacency import INTERIOR
from ..run_state import State
from ..weights import Weights
from . import Float64
from .directional import Directional

#: The system is solved when no residual is greater than this times the condition number, 1 + 2 step, as a
#: part of the greatest right-hand side: some twenty times what rounding leaves.
TOLERANCE = 1e-14

#: Ellipses in the complex plane in which the eigenvalues are sought, one after another: their heights as
#: parts of their width. With 0 it is the real interval; with 1 a circle, and the iteration Jacobi's.
_HEIGHTS = (0.0, 0.1, 0.3, 1.0)

#: Residuals grow by this much only if there are eigenvalues outside the ellipse.
_DIVERGED = 1e6


@kernel
def _iterate(
    starts, ends, solution, field, right, offsets, neighbours, weights, held,
    factor, momentum, share, before,
):  # fmt: skip
    # u_(k+1) = u_k + momentum (u_k - u_(k-1)) + share r_k, put where u_(k-1) was; the residual is
    # r = right - u + factor L(field). Returns the greatest |r_k|, of any axis.
    greatest = 0.0
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            if held[v]:
                continue  # 0 stays 0
            sx = 0.0
            sy = 0.0
            sz = 0.0
            for r in range(offsets[v], offsets[v + 1]):
                w = neighbours[r]
                sx += weights[r] * (field[w, 0] - field[v, 0])
                sy += weights[r] * (field[w, 1] - field[v, 1])
                sz += weights[r] * (field[w, 2] - field[v, 2])
            for axis in range(3):
                laplacian = sx if axis == 0 else (sy if axis == 1 else sz)
                u = solution[v, axis]
                residual = right[v, axis] - u + factor * laplacian
                greatest = max(greatest, abs(residual))
                before[v, axis] = u + momentum * (u - before[v, axis]) + share * residual
    return greatest


class Implicit(Directional):
    """Backward Euler: the new points p' solve ``p' = p + step L(p')``, or ``p' = p - step L(L(p'))``.

    The weights are those of where the points are at the beginning of each pass (M. Desbrun et al.,
    "Implicit Fairing of Irregular Meshes using Diffusion and Curvature Flow", 1999, section 2.3); pinned
    vertices and the boundary are boundary values. What the constraints do to steps they do to the solution:
    they dispose after the solve.

    Parameters
    ----------
    weights : Weights
    step : float
        Any size, 0 or more. A step of 10 smooths like 10 explicit ones of full length, and more evenly.
    thin_plate : bool
        Whether the operator is applied twice; L on the boundary is then 0.

    Notes
    -----
    Without the thin plate the matrix I - step L is an M-matrix whose rows sum to 1: every p' is a weighted
    mean of all p, with weights of 0 or more, so nothing overshoots however great the step; and a residual
    bounds the error, so that no point is farther from the solution than :data:`TOLERANCE` (1 + 2 step) of
    the longest explicit step of that size.

    Solved for the steps p' - p (so the distance to the origin costs no digits) by Chebyshev's iteration
    (Y. Saad, "Iterative Methods for Sparse Linear Systems", 2003, algorithm 12.1). The eigenvalues of
    I - step L are real and within [1, 1 + 2 step] if the weights are symmetric before they are normalised,
    as umbrella, 1/|e| and cotangents in triangles are; so the number of iterations grows with the root of the
    step: some 70 for 10, 200 for 100. No sums over all points are needed, as conjugate gradients need them:
    every iteration is a pass over the rows, and the result has the same bits for any number of threads.
    Weights along a flow are not symmetric; where their eigenvalues are too far from real, the iteration
    for wider and wider ellipses follows, in the end Jacobi's, which converges for every M-matrix. Only a thin
    plate along a flow might not be solved by any, which is a :class:`~vtksmooth.errors.ParameterError`.
    """

    def __init__(self, weights: Weights, step: float = 10.0, thin_plate: bool = False) -> None:
        super().__init__(weights, (1.0,), thin_plate)
        # The operator of the thin plate is -L(L(p)) / 2; both have eigenvalues from -2 to 0.
        self.step = 2.0 * step if thin_plate else step

    def bind(self, state: State) -> None:
        super().bind(state)
        self.solution, self.before = np.empty_like(state.points), np.empty_like(state.points)
        # The boundary slides, if it does, by a rule of its own.
        self.held = ((state.pinned != 0) | (state.near.kinds != INTERIOR)).astype(np.uint8)

    def prepare(self, state: State, turn: int) -> None:
        super().prepare(state, turn)
        assert self.values is not None
        self.laplacian *= self.step
        self.laplacian[self.held != 0] = 0.0
        greatest = float(np.abs(self.laplacian).max(initial=0.0))
        if greatest == 0.0:
            return
        for height in _HEIGHTS:
            if self._solved(state, self.values, greatest, height):
                break
        else:
            raise ParameterError(
                "The system of this implicit step is not solved; choose a smaller step, or another scheme "
                "than the thin plate along this flow."
            )
        self.laplacian, self.solution = self.solution, self.laplacian

    def scale(self, state: State, values: Float64) -> None:
        """Halve it: the system is that of -L(L(p)) itself."""
        self.laplacian *= -0.5

    def _solved(self, state: State, values: Float64, greatest: float, height: float) -> bool:
        offsets, neighbours = self.weights.rows(state.near)
        everything = parallel.ranges(len(state.points))
        factor = -0.5 * self.step if self.thin_plate else self.step
        middle = 1.0 + self.step
        focus = self.step * math.sqrt(1.0 - height * height)
        rate = self.step * (1.0 + height) / (middle + math.sqrt(middle * middle - focus * focus))
        # The rate of a step that is next to none is 0 when it is rounded.
        most = 10 + int(2.0 * math.log(TOLERANCE) / math.log(max(rate, TOLERANCE)))
        small = TOLERANCE * (1.0 + 2.0 * self.step) * greatest
        momentum, share, ratio = 0.0, 1.0 / middle, focus / middle
        self.solution[:] = self.before[:] = 0.0
        for _ in range(most):
            field = self.innermost(state, values, self.solution)
            residual = max(
                parallel.run(
                    _iterate, *everything,
                    self.solution, field, self.laplacian, offsets, neighbours, values, self.held,
                    factor, momentum, share, self.before,
                )
            )  # fmt: skip
            self.solution, self.before = self.before, self.solution
            if residual <= small:
                return True
            if not residual <= _DIVERGED * greatest:
                return False
            share = 2.0 / (2.0 * middle - focus * ratio)
            momentum = 0.5 * focus * share * ratio
            ratio = 0.5 * focus * share
        return False
