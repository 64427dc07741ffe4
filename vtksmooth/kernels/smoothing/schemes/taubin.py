"""Taubin's lambda|mu: a step of the umbrella operator inwards, then a larger one outwards."""

from __future__ import annotations

import math

from ....jit import parallel
from ..run_state import State
from ..weights import Weights
from . import Float64, Int64, Scheme
from .directional import Directional
from .umbrella import propose_umbrella

#: Most that a run amplifies any frequency below the pass band.
LARGEST_GAIN = 1.015


class Steps:
    """lambda and mu of one iteration after the other.

    An iteration has the gain ``(1 - lambda k)(1 - mu k) = 1 + s k (k_PB - k)``, s = -lambda mu, at the
    frequency k, 0 <= k <= 2. Below k_PB it exceeds 1, most at k_PB / 2, and iterations multiply it. The
    steps are those of `relaxation` until their product would exceed :data:`LARGEST_GAIN` there; one shorter
    iteration takes what is left. ``s <= 1 / (2 - k_PB)`` keeps the gain above k_PB within -1 and 1.

    Parameters
    ----------
    relaxation : float
        lambda, [0, 1].
    pass_band : float
        k_PB = 1/lambda + 1/mu.

    Examples
    --------
    >>> steps = Steps(0.5, 0.1)
    >>> [round(factor, 3) for factor in steps.next()]
    [0.5, -0.526]
    >>> sum(steps.next()[0] > 0 for _ in range(1000))
    22
    """

    def __init__(self, relaxation: float, pass_band: float) -> None:
        self.relaxation, self.pass_band = relaxation, pass_band
        #: Logarithm of the gain that is left.
        self.left = math.log(LARGEST_GAIN)

    def next(self) -> tuple[float, float]:
        """Return lambda and mu; 0 when nothing is left, or from the start with a relaxation of 0."""
        relaxation, band = self.relaxation, self.pass_band
        if relaxation == 0.0 or self.left == 0.0:
            return 0.0, 0.0
        asked = relaxation**2 / (1.0 - band * relaxation)
        product = min(asked, 1.0 / (2.0 - band))
        spent = math.log1p(product * band**2 / 4.0)
        if spent >= self.left:
            product, spent = 4.0 * math.expm1(self.left) / band**2, self.left
        self.left -= spent
        if product < asked:
            relaxation = 2.0 * product / (band * product + math.sqrt((band * product) ** 2 + 4.0 * product))
        return relaxation, 1.0 / (band - 1.0 / relaxation)


class Taubin(Scheme):
    """Low-pass filter without the shrinking of the plain Laplacian (Taubin 1995).

    Parameters
    ----------
    relaxation : float
        lambda, [0, 1]; above 0.7 as far as no frequency grows.
    pass_band : float
        k_PB = 1/lambda + 1/mu: frequencies below it are kept. Taubin uses 0.01 to 0.1.

    Guarantees
    ----------
    Where all vertices move at once: a run of any number of iterations amplifies no frequency above the pass
    band, and none below it by more than 1.5 % (:data:`LARGEST_GAIN`). The run stops when this is reached.
    """

    passes = 2

    moves_lines = True

    def __init__(self, relaxation: float = 0.5, pass_band: float = 0.1) -> None:
        self.relaxation, self.pass_band = relaxation, pass_band

    def bind(self, state: State) -> None:
        self.steps = Steps(self.relaxation, self.pass_band)

    def prepare(self, state: State, turn: int) -> None:
        if turn == 0:
            self.factors = self.steps.next()

    @property
    def finished(self) -> str:
        return "pass-band" if self.steps.left == 0.0 else ""

    def propose(self, state: State, turn: int, starts: Int64, ends: Int64, proposed: Float64) -> None:
        near = state.near
        parallel.run(
            propose_umbrella, starts, ends,
            state.points, near.row_offsets, near.row, state.pinned, self.factors[turn], proposed,
        )  # fmt: skip


class DirectionalTaubin(Directional):
    """:class:`Taubin` with any weights, directional ones above all.

    Parameters
    ----------
    weights : Weights
    relaxation, pass_band : float
    """

    def __init__(self, weights: Weights, relaxation: float, pass_band: float) -> None:
        super().__init__(weights, (relaxation, 0.0))
        self.relaxation, self.pass_band = relaxation, pass_band

    def bind(self, state: State) -> None:
        super().bind(state)
        self.steps = Steps(self.relaxation, self.pass_band)

    def prepare(self, state: State, turn: int) -> None:
        if turn == 0:
            self.factors = self.steps.next()
        super().prepare(state, turn)

    @property
    def finished(self) -> str:
        return "pass-band" if self.steps.left == 0.0 else ""
