"""BackToSurfaceSmoothing: smart Laplacian in the tangent plane, then back to the original surface."""

from __future__ import annotations

from ..kernels.smoothing.schemes import Scheme
from ..kernels.smoothing.schemes.umbrella import Umbrella
from .parameter import Parameter
from .smoothing import SmoothingFilter


class BackToSurfaceSmoothing(SmoothingFilter):
    """Keep vertices on the original *discrete* surface while improving the smallest angles.

    The "BDS" that Semenova et al. compare with (section 5.2): the mean of the one-ring in the tangent
    plane, put back to the closest point of the original mesh, accepted if the smallest angle grows.

    Guarantees
    ----------
    Every vertex that moved lies on the original mesh (to rounding). Fixed points and, unless it slides,
    the boundary keep their bits.

    Examples
    --------
    >>> from vtkmodules.vtkFiltersSources import vtkSphereSource
    >>> from vtksmooth import BackToSurfaceSmoothing
    >>> sphere = vtkSphereSource()
    >>> _ = sphere.Update()
    >>> BackToSurfaceSmoothing(iterations=2)(sphere.GetOutput()).GetNumberOfPoints()
    50
    """

    command = "back-to-surface"

    relaxation_factor = Parameter(1.0, "Part of the proposed step that is taken.", low=0.0, high=1.0)
    gate = SmoothingFilter.gate.with_default("angle")
    tangent_plane = True
    back_to_surface = True

    def make_scheme(self) -> Scheme:
        """Return the umbrella scheme."""
        return Umbrella(self.relaxation_factor)
