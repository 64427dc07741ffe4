"""EquilateralSmoothing: the best elements that points can make on the same surface with the same features."""

from __future__ import annotations

from ..kernels.smoothing.schemes import Scheme
from ..kernels.smoothing.schemes.equilateral import Equilateral
from .parameter import CONSTRAINTS, Parameter
from .smoothing import SmoothingFilter


class EquilateralSmoothing(SmoothingFilter):
    """Make elements as regular as their connectivity allows, on the surface as it is.

    Each face of a vertex asks for the apex that would make it equilateral (a polygon: its corner regular);
    the vertex takes the tangential part of the mean. Points on ridges and boundaries slide along them,
    corners stay, creases stay creases. A point moves only where no element becomes worse that is not good
    enough anyway, and then if the worst or the mean gains: see ``gate="floor"``.

    Guarantees
    ----------
    With the default gate, before the output's points are rounded to single precision: no iteration makes more
    faces inverted, nor lowers the smallest k of the mesh below ``gate_floor`` or, where it is below that, at
    all; both against the input's directions. Edges with a dihedral angle above ``crease_angle`` stay above
    it. No faces cross or touch that did not. Straight ridges and boundaries stay straight, flat faces of
    polyhedra flat, and corners keep their bits. Fixed points keep their bits. Topology is the input's. The
    result does not depend on the number of threads.

    Not guaranteed: a bound of the deviation (set ``max_deviation_fraction``); curved ridges and boundaries
    change by what sliding parallel to the chord of the neighbours makes.

    Examples
    --------
    >>> from vtkmodules.vtkFiltersSources import vtkSphereSource
    >>> from vtksmooth import EquilateralSmoothing
    >>> sphere = vtkSphereSource(phi_resolution=20, theta_resolution=20)
    >>> smoothing = EquilateralSmoothing()
    >>> smoothing.SetInputConnection(sphere.GetOutputPort())
    >>> _ = smoothing.Update()
    >>> before, after = smoothing.report.mean_aspect_ratio
    >>> after > before
    True
    """

    command = "equilateral"

    iterations = Parameter(50, "Most iterations to do.", low=0)
    relaxation_factor = Parameter(1.0, "Part of the proposed step that is taken.", low=0.0, high=1.0)
    gate = SmoothingFilter.gate.with_default("floor")
    boundary = SmoothingFilter.boundary.with_default("sliding")
    features = SmoothingFilter.features.with_default("slide")
    ridge_angle = SmoothingFilter.ridge_angle.with_default(40.0)
    crease_angle = SmoothingFilter.crease_angle.with_default(40.0)
    self_intersection = SmoothingFilter.self_intersection.with_default("none-new")
    tangent_plane = Parameter(True, "Move vertices only across the surface, not off it.", group=CONSTRAINTS)

    def make_scheme(self) -> Scheme:
        """Return the equilateral scheme."""
        return Equilateral(self.relaxation_factor)
