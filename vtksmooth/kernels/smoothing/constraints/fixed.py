"""Fixed points: chosen vertices stay where they are, bit for bit."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ..run_state import State
from . import Constraint, Phase, moved


class Fixed(Constraint):
    """Pin vertices.

    Parameters
    ----------
    mask : (n,) array_like
        Nonzero where a vertex must not move, in the order of the points that smoothing is given.
    """

    name = "Fixed points (fixed)"
    phase = Phase.PIN

    def __init__(self, mask: npt.ArrayLike) -> None:
        self.mask = np.asarray(mask) != 0

    def bind(self, state: State) -> None:
        state.pinned[state.in_order(state.one_each("fixed", self.mask))] = 1

    def check(self, state: State) -> str:
        return moved(state, state.in_order(self.mask))
