"""FeaturePreservingDenoising: noise goes, edges and the volume stay."""

from __future__ import annotations

from typing import Any

import numpy.typing as npt
from vtkmodules.vtkCommonDataModel import vtkPolyData

from ..kernels.smoothing.constraints import Constraint
from ..kernels.smoothing.constraints.no_inversion import NoInversion
from ..kernels.smoothing.schemes import Scheme
from ..kernels.smoothing.schemes.feature_preserving import WHITENESS, FeaturePreserving
from .base import add_field
from .parameter import Parameter
from .signed_distance import Inside
from .smoothing import SmoothingFilter


class FeaturePreservingDenoising(SmoothingFilter):
    """Remove the noise of a scan or of a measured surface, and keep its edges, its shape and its volume.

    The filter measures the noise level, filters the face normals under a guide that tells creases from
    noise, and lets the points follow. It watches what it removes: where neighbouring points have moved the
    same way, that is shape, and comes back; when what was removed is white noise, the run ends by itself.
    Sources: W. Zhang et al., "Guided Mesh Normal Filtering" (2015), doi:10.1111/cgf.12742; X. Sun et al.,
    "Fast and Effective Feature-Preserving Mesh Denoising" (2007), doi:10.1109/TVCG.2007.1065.

    Guarantees
    ----------
    No face that is not inverted becomes inverted, against the input's directions. With `preserve_volume`:
    the volume of every closed body is that of the input to rounding, and what open surfaces sweep is 0 to
    rounding. Fixed points and, unless it moves, the boundary keep their bits. All before the output's points
    are rounded to single precision. Topology is the input's. The result does not depend on the number of
    threads. ``report.noise_level`` is the noise level that was found.

    Not guaranteed: that inverted faces are mended (most are), and the quality of elements.

    Examples
    --------
    >>> import numpy as np
    >>> from vtkmodules.util.numpy_support import vtk_to_numpy
    >>> from vtkmodules.vtkFiltersSources import vtkSphereSource
    >>> from vtksmooth import FeaturePreservingDenoising
    >>> source = vtkSphereSource(theta_resolution=60, phi_resolution=60)
    >>> _ = source.Update()
    >>> sphere = source.GetOutput()
    >>> points = vtk_to_numpy(sphere.GetPoints().GetData())
    >>> points += np.random.default_rng(1).normal(0.0, 0.004, points.shape)
    >>> denoising = FeaturePreservingDenoising()
    >>> _ = denoising(sphere)
    >>> 0.003 < denoising.report.noise_level < 0.005
    True
    """

    command = "denoise"

    strength = Parameter(
        "normal", "How much of what is removed may be shape: the weaker, the more noise stays.",
        choices=tuple(WHITENESS),
    )  # fmt: skip
    iterations = Parameter(20, "Most iterations to do; 3 to 8 are needed.", low=0)
    preserve_volume = SmoothingFilter.preserve_volume.with_default(True)

    def make_scheme(self) -> Scheme:
        """Return the scheme, as strong as wanted."""
        return FeaturePreserving(WHITENESS[self.strength])

    def make_constraints(
        self, diagonal: float, weights: npt.NDArray[Any] | None, inside: Inside | None
    ) -> list[Constraint]:
        """Return the constraints of all filters; none lets a face invert."""
        constraints = super().make_constraints(diagonal, weights, inside)
        if not (self.corrections or self.preserve_volume or self.null_space):
            constraints.append(NoInversion())
        return constraints

    def execute(self, *inputs: Any) -> vtkPolyData:
        """Remove the noise of one polydata."""
        output = super().execute(*inputs)
        add_field(output, "SmoothingNoiseLevel", self.report.noise_level or 0.0)
        return output
