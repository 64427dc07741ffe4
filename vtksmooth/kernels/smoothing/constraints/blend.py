"""Blend: each vertex takes a part of its steps, from nothing at clean vertices to all at noisy ones."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ....errors import ParameterError
from ..run_state import State
from . import moved
from .damping import Damping


class Blend(Damping):
    """Weights mu of section 4.2 of the installation-space paper, against a ridge where clean meets noisy.

    Parameters
    ----------
    weights : (n,) array_like
        From 0 (pinned: keeps its bits) to 1 (free), in the order of the points that smoothing is given.
    """

    name = "Blend weights (blend)"

    def __init__(self, weights: npt.ArrayLike) -> None:
        self.weights = np.asarray(weights, dtype=np.float64)

    def bind(self, state: State) -> None:
        state.one_each("Blend weights", self.weights)
        if not (self.weights.min() >= 0.0 and self.weights.max() <= 1.0):
            raise ParameterError("Blend weights must be from 0 (fixed) to 1 (free), and not NaN.")
        self.damping = np.ascontiguousarray(state.in_order(self.weights))
        state.pinned[self.damping == 0.0] = 1

    def check(self, state: State) -> str:
        return moved(state, np.equal(state.in_order(self.weights), 0.0))
