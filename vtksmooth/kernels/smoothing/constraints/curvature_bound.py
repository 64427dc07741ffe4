"""Curvature bound: what is flat enough does not move."""

from __future__ import annotations

import numpy as np

from ....report import RunReport
from ...measures.curvature import mean_curvatures, radius_by_noise
from ..run_state import State
from .damping import Damping


class CurvatureBound(Damping):
    """Vertices whose mean curvature is at most 1/r do not move (section 5.3 of the installation-space paper).

    Curvatures are taken at the beginning of each pass.

    Parameters
    ----------
    radius : float or None
        r, model units. None: by the noise of the vertices that are free at the start, see
        :func:`~vtksmooth.kernels.measures.curvature.radius_by_noise`.
    ramp : float
        From 1/r to (1 + ramp)/r steps grow linearly from nothing to their full length; 0: no ramp.

    Attributes
    ----------
    radius : float
        r of the run, once bound.
    """

    name = "A bound on the curvature (curvature_radius)"

    def __init__(self, radius: float | None = None, ramp: float = 0.0) -> None:
        self.asked, self.ramp = radius, ramp
        self.radius = np.inf

    def bind(self, state: State) -> None:
        self.radius = (
            radius_by_noise(state.mesh, state.near, state.pinned == 0) if self.asked is None else self.asked
        )

    def prepare(self, state: State) -> None:
        if not np.isfinite(self.radius):
            return  # no noise, no bound
        bend = np.abs(mean_curvatures(state.mesh, state.near)) * self.radius
        if self.ramp > 0.0:
            with np.errstate(over="ignore"):  # of a ramp that is next to none
                self.damping = np.clip((bend - 1.0) / self.ramp, 0.0, 1.0)
        else:
            self.damping = (bend > 1.0).astype(np.float64)

    def tell(self, report: RunReport) -> None:
        report.curvature_radius = self.radius
