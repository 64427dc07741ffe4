"""LaplacianSmoothing: the family of Laplacian schemes, plain, smart and with constraints."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import ParameterError
from ..kernels.laplacian import KINDS, Weights
from ..kernels.schemes import Scheme
from ..kernels.schemes.angle_weighted import AngleWeighted
from ..kernels.schemes.area_weighted import AreaWeighted
from ..kernels.schemes.cotangent import Cotangent
from ..kernels.schemes.directional import Directional
from ..kernels.schemes.implicit import Implicit
from ..kernels.schemes.optimal_delaunay import OptimalDelaunay
from ..kernels.schemes.pairwise import Pairwise
from ..kernels.schemes.scale_dependent import ScaleDependent
from ..kernels.schemes.taubin import Taubin
from ..kernels.schemes.thin_plate import ThinPlate
from ..kernels.schemes.umbrella import Umbrella
from .arrays import vectors_at_points
from .parameter import CONSTRAINTS, Parameter
from .smoothing import SmoothingFilter

_FACE_CENTRES: dict[str, Callable[[float], Scheme]] = {
    "area-weighted": AreaWeighted,
    "angle-weighted": AngleWeighted,
    "odt": OptimalDelaunay,
}
Float64 = npt.NDArray[np.float64]


class LaplacianSmoothing(SmoothingFilter):
    """Move every vertex towards a weighted mean of its one-ring or of the faces round it.

    Umbrella: equal weights. Scale-dependent: ``1/|e|`` (Fujiwara). Cotangent: Desbrun et al., negative
    weights clamped. Thin plate: the umbrella operator twice (Kobbelt et al.). Taubin: ``lambda|mu``, which
    does not shrink. Area-weighted and angle-weighted: the centroids of the faces round the vertex; odt: their
    circumcentres, weighted by area (optimal Delaunay triangulation). Pairwise: both ends of an edge at once,
    so that the volume stays (Liu et al.), for triangles. ``gate="angle"`` makes it the smart Laplacian. With
    a flow, weights of neighbours are ``w_ij (1 + flow_weight cos^2 theta)``, theta between the flow and the
    edge in the tangent plane. With an implicit step each iteration solves one sparse system, which is as good
    as many small steps: for umbrella, scale-dependent, cotangent and thin-plate, with and without a flow, and
    with every constraint that these have.

    Guarantees
    ----------
    Fixed points and, unless it slides, the boundary keep their bits. The pairwise scheme keeps the volume (of
    open meshes: the volume swept is 0) to 1e-14 of it in each iteration; what judges or turns the step of
    one vertex is refused with it: gates, creases, bounds on deviation and displacement, tangent plane, back
    to surface, null space and corrections, boundaries and features that slide. The flow's size and sign do
    not matter. Implicit steps s are solved to 1e-14 (1 + 2 s) of the longest explicit step
    of that size; however large, they leave no point outside the box of the input's points (thin-plate may).
    With ``gate="aspect"`` what TrapeziumDrawing guarantees. Plain Laplacian schemes, explicit or implicit,
    shrink closed surfaces unless `preserve_volume` is set; none keeps elements from inverting without a gate.

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
        choices=(
            "umbrella", "scale-dependent", "cotangent", "thin-plate", "taubin", *_FACE_CENTRES, "pairwise",
        ),
    )  # fmt: skip
    weights = Parameter(
        "umbrella", "Weights of the schemes thin-plate, taubin and pairwise.", choices=tuple(KINDS)
    )
    flow = Parameter(
        None, "Array of vectors along which to smooth more than across.", optional=True, type=str,
    )  # fmt: skip
    flow_weight = Parameter(
        3.0, "How much more neighbours along the flow weigh; 0 is as much as all others.", low=0.0
    )
    relaxation_factor = Parameter(
        0.5, "Part of the proposed step that is taken (thin-plate diverges above 0.55).", low=0.0, high=1.0
    )
    implicit_step = Parameter(
        None,
        "Solve for the end of a step of this size, which is stable for any; off: explicit steps of "
        "relaxation_factor.",
        low=0.0, high=10_000.0, optional=True, type=float,
    )  # fmt: skip
    pass_band = Parameter(
        0.1, "Taubin's k_PB = 1/lambda + 1/mu: frequencies below it are kept, so lower smooths more.",
        low=0.001, high=0.9,
    )  # fmt: skip
    tangent_plane = Parameter(False, "Move vertices only across the surface, not off it.", group=CONSTRAINTS)
    back_to_surface = Parameter(False, "Put every vertex back on the original surface.", group=CONSTRAINTS)

    #: Vectors of the flow array, once read.
    _vectors: Float64 | None = None

    def read_arrays(self, source: Any) -> None:
        """Read the flow."""
        self._vectors = None if self.flow is None else vectors_at_points(source, self.flow)

    def make_scheme(self) -> Scheme:
        """Return the scheme chosen."""
        kind = self.scheme if self.scheme in KINDS else self.weights
        weights = Weights(kind, self._vectors, self.flow_weight)
        if self.implicit_step is not None:
            if self.scheme not in KINDS and self.scheme != "thin-plate":
                raise ParameterError(
                    f"The scheme {self.scheme} has no implicit steps; switch implicit_step off, or choose "
                    f"{', '.join(KINDS)} or thin-plate."
                )
            return Implicit(weights, self.implicit_step, thin_plate=self.scheme == "thin-plate")
        if self.scheme == "pairwise":
            return Pairwise(self.relaxation_factor, weights)
        if self.scheme in _FACE_CENTRES:
            if weights.directional:
                raise ParameterError(
                    f"The scheme {self.scheme} has no weights for a flow; choose umbrella, say, or pairwise."
                )
            return _FACE_CENTRES[self.scheme](self.relaxation_factor)
        if (self.scheme not in KINDS and kind != "umbrella") or weights.directional:
            taubin = Taubin(self.relaxation_factor, self.pass_band).factors
            factors = taubin if self.scheme == "taubin" else (self.relaxation_factor,)
            return Directional(weights, factors, thin_plate=self.scheme == "thin-plate")
        if self.scheme == "taubin":
            return Taubin(self.relaxation_factor, self.pass_band)
        schemes: dict[str, Callable[[float], Scheme]] = {
            "umbrella": Umbrella,
            "scale-dependent": ScaleDependent,
            "cotangent": Cotangent,
            "thin-plate": ThinPlate,
        }
        return schemes[self.scheme](self.relaxation_factor)
