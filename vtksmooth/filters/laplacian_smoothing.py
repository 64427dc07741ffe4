"""LaplacianSmoothing: the family of Laplacian schemes, plain, smart and with constraints."""

from __future__ import annotations

from collections.abc import Callable

from ..kernels.schemes import Scheme
from ..kernels.schemes.angle_weighted import AngleWeighted
from ..kernels.schemes.area_weighted import AreaWeighted
from ..kernels.schemes.cotangent import Cotangent
from ..kernels.schemes.optimal_delaunay import OptimalDelaunay
from ..kernels.schemes.scale_dependent import ScaleDependent
from ..kernels.schemes.taubin import Taubin
from ..kernels.schemes.thin_plate import ThinPlate
from ..kernels.schemes.umbrella import Umbrella
from .parameter import Parameter
from .smoothing import SmoothingFilter

_FACE_CENTRES: dict[str, Callable[[float], Scheme]] = {
    "area-weighted": AreaWeighted,
    "angle-weighted": AngleWeighted,
    "odt": OptimalDelaunay,
}


class LaplacianSmoothing(SmoothingFilter):
    """Move every vertex towards a weighted mean of its one-ring or of the faces round it.

    Umbrella: equal weights. Scale-dependent: 1/|e| (Fujiwara). Cotangent: Desbrun et al., negative
    weights clamped. Thin plate: the umbrella operator twice (Kobbelt et al.). Taubin: lambda|mu, which
    does not shrink. Area-weighted and angle-weighted: the centroids of the faces round the vertex; odt: their
    circumcentres, weighted by area (optimal Delaunay triangulation). ``gate="angle"`` makes it the smart
    Laplacian.

    Guarantees
    ----------
    Fixed points and, unless it slides, the boundary keep their bits. With ``gate="aspect"`` what
    TrapeziumDrawing guarantees. Plain Laplacian schemes shrink closed surfaces; none of them keeps
    elements from inverting without a gate.

    Examples
    --------
    >>> from vtkmodules.vtkFiltersSources import vtkSphereSource
    >>> from vtksmooth import LaplacianSmoothing
    >>> sphere = vtkSphereSource()
    >>> _ = sphere.Update()
    >>> smoothing = LaplacianSmoothing(scheme="taubin", iterations=20)
    >>> smoothing(sphere.GetOutput()).GetNumberOfPoints()
    50
    """

    command = "laplacian"

    scheme = Parameter(
        "umbrella",
        "Which weights.",
        choices=("umbrella", "scale-dependent", "cotangent", "thin-plate", "taubin", *_FACE_CENTRES),
    )
    relaxation = Parameter(
        0.5, "Part of the proposed step that is taken (thin-plate diverges above 0.55).", low=0.0, high=1.0
    )
    pass_band = Parameter(0.1, "Taubin's k_PB = 1/lambda + 1/mu; lower keeps more.", low=0.001, high=0.9)
    tangent_plane = Parameter(False, "Move vertices only across the surface, not off it.")
    back_to_surface = Parameter(False, "Put every vertex back on the original surface.")

    def make_scheme(self) -> Scheme:
        """Return the scheme chosen."""
        if self.scheme == "taubin":
            return Taubin(self.relaxation, self.pass_band)
        schemes: dict[str, Callable[[float], Scheme]] = {
            "umbrella": Umbrella,
            "scale-dependent": ScaleDependent,
            "cotangent": Cotangent,
            "thin-plate": ThinPlate,
            **_FACE_CENTRES,
        }
        return schemes[self.scheme](self.relaxation)
