"""Taubin's lambda|mu: a step of the umbrella operator inwards, then a larger one outwards."""

from __future__ import annotations

from .. import parallel
from ..state import State
from . import Float64, Int64, Scheme
from .umbrella import propose_umbrella


class Taubin(Scheme):
    """Low-pass filter without the shrinking of the plain Laplacian (Taubin 1995).

    Parameters
    ----------
    relaxation : float
        lambda, (0, 1).
    pass_band : float
        k_PB = 1/lambda + 1/mu: frequencies below it are kept. Taubin uses 0.01 to 0.1.
    """

    passes = 2

    def __init__(self, relaxation: float = 0.5, pass_band: float = 0.1) -> None:
        self.relaxation = relaxation
        self.factors = (relaxation, 1.0 / (pass_band - 1.0 / relaxation))

    def propose(self, state: State, turn: int, starts: Int64, ends: Int64, proposed: Float64) -> None:
        near = state.near
        parallel.run(
            propose_umbrella, starts, ends,
            state.points, near.ring_offsets, near.ring, state.pinned, self.factors[turn], proposed,
        )  # fmt: skip
