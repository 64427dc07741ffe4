"""NullSpaceSmoothing: better elements on the same surface, with its features and its volume (Jiao)."""

from __future__ import annotations

from collections.abc import Callable

from ..kernels.smoothing.schemes import Scheme
from ..kernels.smoothing.schemes.angle_based import AngleBased
from ..kernels.smoothing.schemes.angle_weighted import AngleWeighted
from ..kernels.smoothing.schemes.area_weighted import AreaWeighted
from ..kernels.smoothing.schemes.cotangent import Cotangent
from ..kernels.smoothing.schemes.equilateral import Equilateral
from ..kernels.smoothing.schemes.optimal_delaunay import OptimalDelaunay
from ..kernels.smoothing.schemes.scale_dependent import ScaleDependent
from ..kernels.smoothing.schemes.taubin import Taubin
from ..kernels.smoothing.schemes.thin_plate import ThinPlate
from ..kernels.smoothing.schemes.trapezium import TrapeziumDrawing
from ..kernels.smoothing.schemes.umbrella import Umbrella
from .parameter import Parameter
from .smoothing import SmoothingFilter

_SCHEMES: dict[str, Callable[[float], Scheme]] = {
    "umbrella": Umbrella,
    "scale-dependent": ScaleDependent,
    "cotangent": Cotangent,
    "thin-plate": ThinPlate,
    "taubin": Taubin,
    "area-weighted": AreaWeighted,
    "angle-weighted": AngleWeighted,
    "odt": OptimalDelaunay,
    "equilateral": Equilateral,
    "trapezium-drawing": lambda relaxation: TrapeziumDrawing(),
    "angle-based": lambda relaxation: AngleBased(),
    "weighted-angle-based": lambda relaxation: AngleBased(weighted=True),
}

#: Schemes that always take their whole step.
_WHOLE_STEPS = ("trapezium-drawing", "angle-based", "weighted-angle-based")


class NullSpaceSmoothing(SmoothingFilter):
    """Redistribute the points of a surface that is to stay as it is: for simulations that smooth every step.

    A scheme proposes; of its step smooth points keep what lies in their tangent plane, ridge points move
    along the ridge, corners stay. The volume that this sweeps is given back round every point along the
    surface's direction there, in a few corrections, and the rest by an equal step of all points. Source:
    X. Jiao, "Volume and Feature Preservation in Surface Mesh Optimization", sections 2 to 4.

    Guarantees
    ----------
    With ``preserve_volume``: the volume of every closed body is that of the input to rounding, after any
    number of iterations; what open surfaces sweep is 0 to rounding. A pass that cannot close the volume
    of a body leaves it where it was. No iteration inverts a face that is not inverted already, against the
    input's directions. Fixed points keep their bits. On polyhedra flat faces stay flat, straight ridges
    straight, and corners where they were, to rounding. All before the output's points are rounded to single
    precision. Topology is the input's. The result does not depend on the number of threads.

    With the gate, the smallest k does not fall below `gate_floor` or, where it is below, at all. It moves
    points one after another, each with the volume kept up to rounding. With ``gate="none"`` points move at
    the same time, as in the paper: in half the time, but the worst elements may become worse.

    Examples
    --------
    >>> from vtkmodules.vtkFiltersSources import vtkSphereSource
    >>> from vtksmooth import NullSpaceSmoothing
    >>> sphere = vtkSphereSource(phi_resolution=20, theta_resolution=20)
    >>> _ = sphere.Update()
    >>> smoothing = NullSpaceSmoothing(iterations=50)
    >>> _ = smoothing(sphere.GetOutput())
    >>> before, after = smoothing.report.volume
    >>> abs(after / before - 1) < 1e-14
    True
    """

    command = "null-space"

    scheme = Parameter("umbrella", "Which steps are proposed.", choices=tuple(_SCHEMES))
    relaxation_factor = Parameter(
        0.5, "Part of the proposed step that is taken.", low=0.0, high=1.0,
        only={"scheme": tuple(name for name in _SCHEMES if name not in _WHOLE_STEPS)},
    )  # fmt: skip
    features = SmoothingFilter.features.with_default("slide")
    null_space = SmoothingFilter.null_space.with_default(True)
    corrections = SmoothingFilter.corrections.with_default(2)
    preserve_volume = SmoothingFilter.preserve_volume.with_default(True)
    gate = SmoothingFilter.gate.with_default("floor")

    def make_scheme(self) -> Scheme:
        """Return the scheme chosen."""
        return _SCHEMES[self.scheme](self.relaxation_factor)
