"""LaplacianSmoothing: the family of Laplacian schemes, plain, smart and with constraints."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..errors import ParameterError
from ..kernels.smoothing.schemes import Scheme
from ..kernels.smoothing.schemes.angle_weighted import AngleWeighted
from ..kernels.smoothing.schemes.area_weighted import AreaWeighted
from ..kernels.smoothing.schemes.cotangent import Cotangent
from ..kernels.smoothing.schemes.directional import Directional
from ..kernels.smoothing.schemes.implicit import Implicit
from ..kernels.smoothing.schemes.low_pass import LowPass
from ..kernels.smoothing.schemes.optimal_delaunay import OptimalDelaunay
from ..kernels.smoothing.schemes.pairwise import Pairwise
from ..kernels.smoothing.schemes.pairwise_labels import PairwiseLabels
from ..kernels.smoothing.schemes.scale_dependent import ScaleDependent
from ..kernels.smoothing.schemes.taubin import DirectionalTaubin, Taubin
from ..kernels.smoothing.schemes.thin_plate import ThinPlate
from ..kernels.smoothing.schemes.umbrella import Umbrella
from ..kernels.smoothing.weights import KINDS, Weights
from .arrays import vectors_at_points
from .parameter import AUTO, CONSTRAINTS, SET, Parameter
from .places import Merge
from .smoothing import SmoothingFilter

Float64 = npt.NDArray[np.float64]


class _Row(NamedTuple):
    """What a scheme is made by, and what of the filter it can make use of."""

    #: ``make(filter, weights)``.
    make: Callable[[LaplacianSmoothing, Weights], Scheme]
    #: Whether its weights can be chosen, may go by a flow, and make a system for implicit steps.
    weights: bool
    flow: bool
    implicit: bool


def _of_neighbours(quick: Callable[[float], Scheme], thin_plate: bool = False) -> Any:
    """Return what makes a scheme of weights of the one-ring: by `quick`, which knows its own."""

    def make(smoothing: LaplacianSmoothing, weights: Weights) -> Scheme:
        own = weights.kind == ("umbrella" if thin_plate else smoothing.scheme)
        if own and not weights.directional:
            return quick(smoothing.relaxation_factor)
        return Directional(weights, (smoothing.relaxation_factor,), thin_plate)

    return make


def _of_faces(scheme: Callable[[float], Scheme]) -> Any:
    return lambda smoothing, weights: scheme(smoothing.relaxation_factor)


def _taubin(smoothing: LaplacianSmoothing, weights: Weights) -> Scheme:
    given = smoothing.relaxation_factor, smoothing.pass_band
    return Taubin(*given) if weights.constant else DirectionalTaubin(weights, *given)


def _low_pass(smoothing: LaplacianSmoothing, weights: Weights) -> Scheme:
    return LowPass(None if smoothing.wavelength == AUTO else smoothing.wavelength)


def _pairwise(smoothing: LaplacianSmoothing, weights: Weights) -> Scheme:
    if smoothing.labelled:
        if not weights.constant:
            raise ParameterError(
                "On a surface between labels the pairwise scheme has umbrella weights only: leave out "
                "weights and flow."
            )
        return PairwiseLabels(smoothing.relaxation_factor)
    return Pairwise(smoothing.relaxation_factor, weights)


#: All schemes of the filter.
SCHEMES: dict[str, _Row] = {
    "umbrella": _Row(_of_neighbours(Umbrella), weights=False, flow=True, implicit=True),
    "scale-dependent": _Row(_of_neighbours(ScaleDependent), weights=False, flow=True, implicit=True),
    "cotangent": _Row(_of_neighbours(Cotangent), weights=False, flow=True, implicit=True),
    "thin-plate": _Row(_of_neighbours(ThinPlate, thin_plate=True), weights=True, flow=True, implicit=True),
    "taubin": _Row(_taubin, weights=True, flow=True, implicit=False),
    "area-weighted": _Row(_of_faces(AreaWeighted), weights=False, flow=False, implicit=False),
    "angle-weighted": _Row(_of_faces(AngleWeighted), weights=False, flow=False, implicit=False),
    "odt": _Row(_of_faces(OptimalDelaunay), weights=False, flow=False, implicit=False),
    "low-pass": _Row(_low_pass, weights=False, flow=False, implicit=False),
    "pairwise": _Row(_pairwise, weights=True, flow=True, implicit=False),
}


def _schemes(ability: str) -> dict[str, Any]:
    return {"scheme": tuple(name for name, row in SCHEMES.items() if getattr(row, ability))}


class LaplacianSmoothing(SmoothingFilter):
    """Move every vertex towards a weighted mean of its one-ring or of the faces round it.

    Umbrella: equal weights. Scale-dependent: ``1/|e|`` (Fujiwara). Cotangent: Desbrun et al., negative
    weights clamped. Thin plate: the umbrella operator twice (Kobbelt et al.). Taubin: ``lambda|mu``, which
    hardly shrinks or grows. Area-weighted and angle-weighted: the centroids of the faces round the vertex;
    odt: their circumcentres, weighted by area (optimal Delaunay triangulation). Low-pass: where a filter of
    the whole surface puts each vertex, which removes waves shorter than `wavelength` as far as they are
    noise; it is there after two or three iterations. Pairwise: both ends of an edge at once, so that the
    volume stays (Liu et al.), for triangles. ``gate="angle"`` makes it the smart Laplacian. With a flow,
    weights of neighbours are ``w_ij (1 + flow_weight cos^2 theta)``, theta between the flow and the edge in
    the tangent plane. With an implicit step each iteration solves one sparse system, which is as good as
    many small steps: for umbrella, scale-dependent, cotangent and thin-plate, with and without a flow, and
    with every constraint that these have.

    Guarantees
    ----------
    Fixed points and, unless it slides, the boundary keep their bits. The pairwise scheme keeps the volume (of
    open meshes: the volume swept is 0) to 1e-14 of it in each iteration, with all gates and bounds: it moves
    the ends of an edge only where these accept both. With `preserve_volume` or `corrections` it inverts no
    face. Constraints that turn the step of one vertex, or put it on a surface, are refused with it: tangent
    plane, back to surface, null space, boundaries that are not fixed, features that slide. The flow's size
    and sign do not matter. Implicit steps s are solved to 1e-14 (1 + 2 s) of the longest explicit step of
    that size; however large, they leave no point outside the box of the input's points (thin-plate may).
    Taubin's filter, as long as all vertices move at once, amplifies no frequency above `pass_band`, and none
    below it by more than 1.5 %: before it would, the run stops (``stop_reason`` "pass-band"). With
    ``self_intersection="none-new"`` no faces cross or touch that did not, of the points as they are written,
    and every other promise is kept. With ``gate="aspect"`` what TrapeziumDrawing guarantees. Plain Laplacian
    schemes, explicit or implicit, shrink closed surfaces unless `preserve_volume` is set; none keeps elements
    from inverting without a gate.

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

    scheme = Parameter("umbrella", "Which weights.", choices=tuple(SCHEMES))
    weights = Parameter(
        "umbrella",
        "Weights of the schemes thin-plate, taubin and pairwise.",
        choices=tuple(KINDS),
        only=_schemes("weights"),
    )
    flow = Parameter(
        None, "Array of vectors along which to smooth more than across.",
        optional=True, type=str, only=_schemes("flow"),
    )  # fmt: skip
    flow_weight = Parameter(
        3.0, "How much more neighbours along the flow weigh; 0 is as much as all others.",
        low=0.0, only={"flow": SET},
    )  # fmt: skip
    relaxation_factor = Parameter(
        0.5, "Part of the proposed step that is taken (thin-plate diverges above 0.55).",
        low=0.0, high=1.0, every=True,
        only={"implicit_step": (None,), "scheme": tuple(name for name in SCHEMES if name != "low-pass")},
    )  # fmt: skip
    implicit_step = Parameter(
        None,
        "Solve for the end of a step of this size, which is stable for any; off: explicit steps of "
        "relaxation_factor.",
        low=0.0, high=10_000.0, optional=True, type=float, only=_schemes("implicit"),
    )  # fmt: skip
    pass_band = Parameter(
        0.1, "Taubin's k_PB = 1/lambda + 1/mu: frequencies below it are kept, so lower smooths more.",
        low=0.001, high=0.9, only={"scheme": ("taubin",)},
    )  # fmt: skip
    wavelength = Parameter(
        AUTO,
        "Waves of this length lose half of their height, shorter ones more; auto: 15 voxels, or 13 edges.",
        low=0.0, unit="model units", automatic=True, type=float, only={"scheme": ("low-pass",)},
    )  # fmt: skip
    tangent_plane = Parameter(False, "Move vertices only across the surface, not off it.", group=CONSTRAINTS)
    back_to_surface = Parameter(False, "Put every vertex back on the original surface.", group=CONSTRAINTS)

    #: Vectors of the flow array, once read.
    _vectors: Float64 | None = None

    def read_arrays(self, source: Any) -> None:
        """Read the flow."""
        self._vectors = None if self.flow is None else vectors_at_points(source, self.flow)

    def merges(self) -> dict[str, Merge]:
        """Return what becomes of the arrays that the parameters name; flows meet in their mean."""
        return super().merges() | ({} if self.flow is None else {self.flow: Merge("mean", components=3)})

    def make_scheme(self) -> Scheme:
        """Return the scheme chosen."""
        kind = self.scheme if self.scheme in KINDS else self.weights
        weights = Weights(kind, self._vectors, self.flow_weight)
        if self.implicit_step is not None:
            return Implicit(weights, self.implicit_step, thin_plate=self.scheme == "thin-plate")
        return SCHEMES[self.scheme].make(self, weights)
