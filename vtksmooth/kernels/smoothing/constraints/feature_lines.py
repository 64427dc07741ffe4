"""Features: ridges and corners that stay, or ridges whose vertices slide along them."""

from __future__ import annotations

import numpy as np

from ....jit import parallel
from ....report import RunReport
from ...features.detection import CORNER, RIDGE
from ...mesh.adjacency import BOUNDARY
from ..run_state import State
from . import Constraint, Float64, Int64, Phase, moved
from .boundary import off_straight_lines, slide


class FeatureLines(Constraint):
    """What the vertices on ridges may do. Corners and cusps stay.

    Features are those of the mesh at the start of the run. What vertices on a boundary may do is left to
    :class:`~vtksmooth.kernels.smoothing.constraints.boundary.Boundary`, except that corners on it stay.

    Parameters
    ----------
    sliding : bool
        If true, a ridge vertex moves parallel to the line through its two ridge neighbours, half way to
        where it is equally far from both, as on a sliding boundary: straight ridges stay straight. Ridge
        vertices without two such neighbours stay. If false, no ridge vertex moves.
    """

    def __init__(self, sliding: bool = True) -> None:
        self.sliding = sliding
        self.phase = Phase.DIRECT if sliding else Phase.PIN
        self.name = f"Features that {'slide' if sliding else 'are held'} (features)"
        self._slides = np.empty(0, np.uint8)

    def bind(self, state: State) -> None:
        classes, ring = state.features.classes, state.features.ridge_ring
        ridge = (classes == RIDGE) & (state.near.kinds != BOUNDARY)
        state.pinned[classes >= CORNER] = 1
        slides = ridge & (ring >= 0).all(axis=1) & self.sliding
        state.pinned[ridge & ~slides] = 1
        self._slides = slides.astype(np.uint8)
        self._counts = state.features.counts()
        if slides.any():
            state.confined = self._slides

    def dispose(self, state: State, starts: Int64, ends: Int64, proposed: Float64) -> None:
        ring = state.features.ridge_ring
        parallel.run(
            slide, starts, ends, state.points, self._slides, ring, state.pinned, state.slide, proposed
        )

    def tell(self, report: RunReport) -> None:
        report.vertex_classes = self._counts

    def check(self, state: State) -> str:
        classes = state.features.classes
        held = (classes >= CORNER) | (
            (classes == RIDGE) & (state.near.kinds != BOUNDARY) & (self._slides == 0)
        )
        slides = np.flatnonzero((self._slides != 0) & (state.pinned == 0))
        ring = state.features.ridge_ring[slides]
        return moved(state, held) or off_straight_lines(state, slides, ring)
