"""AngleBasedSmoothing: spokes turned onto bisectors."""

from __future__ import annotations

from ..kernels.smoothing.schemes import Scheme
from ..kernels.smoothing.schemes.angle_based import AngleBased
from .parameter import Parameter
from .smoothing import SmoothingFilter


class AngleBasedSmoothing(SmoothingFilter):
    """Turn each spoke onto the bisector of the angle at its outer end, in the tangent plane.

    Plain: T. Zhou, K. Shimada, "An Angle-Based Approach to Two-Dimensional Mesh Smoothing" (2000).
    Weighted with 1/angle^2: V. Surazhsky, C. Gotsman, "High Quality Compatible Triangulations" (2002).

    Guarantees
    ----------
    Fixed points and, unless it slides, the boundary keep their bits. With ``gate="aspect"`` what
    TrapeziumDrawing guarantees; without a gate elements may invert.

    Examples
    --------
    >>> from vtkmodules.vtkFiltersSources import vtkDiskSource
    >>> from vtksmooth import AngleBasedSmoothing
    >>> disk = vtkDiskSource()
    >>> _ = disk.Update()
    >>> AngleBasedSmoothing(weighted=True)(disk.GetOutput()).GetNumberOfPoints()
    12
    """

    command = "angle-based"

    weighted = Parameter(False, "Weigh each neighbour with 1/angle^2, so that small angles count more.")

    def make_scheme(self) -> Scheme:
        """Return the angle-based scheme."""
        return AngleBased(self.weighted)
