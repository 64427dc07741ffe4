"""NullSpaceSmoothing: better elements on the same surface, with its features and its volume (Jiao)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkPolyData

from ..errors import InvalidMeshError, ParameterError
from ..kernels.measures.aspect_ratio import area_vectors
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
from .arrays import Surface, point_array, surface_of
from .base import add_field
from .parameter import CONSTRAINTS, Parameter
from .places import Merge
from .smoothing import SmoothingFilter

Float64 = npt.NDArray[np.float64]

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


def flux_at_faces(source: Any, name: str, surface: Surface) -> Float64:
    """Return the values of a cell or point array at the faces, (m,); of points the mean of the corners.

    Raises
    ------
    ParameterError
        There is no such array.
    InvalidMeshError
        It has several components, values that are not finite, or not one for each cell or point.
    """
    mesh = surface.mesh
    array = source.GetCellData().GetArray(name)
    at_points = point_array(source, name)
    of_faces: Float64
    if array is not None:
        values = vtk_to_numpy(array)
        if values.shape != (source.GetNumberOfCells(),):
            raise InvalidMeshError(f"The cell array {name!r} must hold one value for each cell.")
        of_faces = values[surface.cells].astype(np.float64)
    elif at_points is not None:
        faces = np.repeat(np.arange(mesh.n_faces), mesh.face_sizes)
        sums = np.bincount(faces, at_points[mesh.connectivity].astype(np.float64), mesh.n_faces)
        of_faces = sums / np.maximum(mesh.face_sizes, 1)
    else:
        raise ParameterError(f"flux: there is no cell or point array {name!r}.")
    if not np.isfinite(of_faces).all():
        raise InvalidMeshError(f"The array {name!r} has values that are not finite numbers.")
    return of_faces


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

    With a `flux` the volume of every closed body grows by the integral of the array over its area at the
    start, to rounding, in equal parts in each iteration; ``report.flux`` is that of the whole surface, and
    ``report.swept_volume`` what was gained: a simulation that calls once per time step adds what is left of
    the one to the next. Round each point what it sweeps answers to the flux there as far as `corrections` go.

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
    flux = Parameter(
        None,
        "Cell or point array of volume per area that the surface is to gain along its normals in the run.",
        unit="model units", optional=True, type=str, group=CONSTRAINTS,
        only={"preserve_volume": (True,)},
    )  # fmt: skip

    def read_arrays(self, source: Any) -> None:
        """Read the flux: what each face sweeps in each iteration."""
        self._flux = None
        if self.flux is None:
            return
        exact = self._given("installation") is not None and self.containment == "exact"
        if self.gate != "none" or self.crease_angle is not None or exact:
            raise ParameterError(
                "A flux takes steps of all points at the same time: set the gate to none, and leave out the "
                "bound on creases and exact containment."
            )
        surface = surface_of(source)
        volumes = flux_at_faces(source, self.flux, surface) * np.linalg.norm(
            area_vectors(surface.mesh), axis=1
        )
        self._wanted = float(volumes.sum())
        self._flux = volumes / max(1, self.iterations)

    def merges(self) -> dict[str, Merge]:
        """Return what becomes of the arrays that the parameters name; a flux of points is the mean."""
        return super().merges() | ({} if self.flux is None else {self.flux: Merge("mean")})

    def execute(self, *inputs: Any) -> vtkPolyData:
        """Smooth one polydata."""
        output = super().execute(*inputs)
        if self._flux is not None:
            self.report = replace(self.report, flux=self._wanted)
            add_field(output, "SmoothingFlux", self._wanted)
        return output

    def make_scheme(self) -> Scheme:
        """Return the scheme chosen."""
        return _SCHEMES[self.scheme](self.relaxation_factor)
