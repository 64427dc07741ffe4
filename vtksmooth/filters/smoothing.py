"""What all smoothing filters share: each is a preset of the one loop."""

from __future__ import annotations

from dataclasses import asdict, replace
from typing import Any

import numpy as np
import numpy.typing as npt
from vtkmodules.vtkCommonDataModel import vtkPolyData

from ..errors import ParameterError, VtksmoothError
from ..kernels import loop, measure
from ..kernels.constraints import Constraint
from ..kernels.constraints.back_to_surface import BackToSurface
from ..kernels.constraints.boundary import Boundary
from ..kernels.constraints.deviation_bound import DeviationBound
from ..kernels.constraints.gate import Gate
from ..kernels.constraints.tangent_plane import TangentPlane
from ..kernels.schemes import Scheme
from ..report import RunReport
from .arrays import point_array, point_array_names, points_of, surface_of, vtk_points
from .base import Filter, add_field, output_like
from .parameter import Parameter

#: Array that pins points when it is there and no other is named.
FIXED = "Fixed"


class SmoothingFilter(Filter):
    """Base of the smoothing filters. Subclasses choose a scheme and default constraints.

    Attributes
    ----------
    report : RunReport
        What the last execution did. With composite input, the last block's.
    """

    iterations = Parameter(10, "Most iterations to do.", low=0)
    fixed = Parameter(
        FIXED, "Point array that is nonzero at points that must not move; absent, none is held.",
        optional=True, type=str,
    )  # fmt: skip
    boundary = Parameter(
        "fixed",
        "Whether boundary points stay or slide along the boundary.",
        choices=("fixed", "sliding"),
    )
    boundary_corner_angle = Parameter(
        30.0, "Sliding boundary points stay where the boundary turns by more than this.",
        low=0.0, high=180.0, unit="deg",
    )  # fmt: skip
    max_deviation_fraction = Parameter(
        None, "Keep every point within this distance of the original surface.",
        low=0.0, unit="diagonals", optional=True, type=float,
    )  # fmt: skip
    stop_normal_deviation = Parameter(
        None, "Stop before vertex normals turn by more than this.",
        low=0.0, high=180.0, unit="deg", optional=True, type=float,
    )  # fmt: skip
    stop_dihedral_change = Parameter(
        None, "Stop before dihedral angles change by more than this.",
        low=0.0, high=360.0, unit="deg", optional=True, type=float,
    )  # fmt: skip
    stop_deviation_fraction = Parameter(
        None, "Stop before points are farther from the original surface than this.",
        low=0.0, unit="diagonals", optional=True, type=float,
    )  # fmt: skip
    stop_volume_percent = Parameter(
        None, "Stop before the enclosed volume changes by more than this.",
        low=0.0, unit="percent", optional=True, type=float,
    )  # fmt: skip
    stop_gain = Parameter(
        None, "Stop when an iteration raises the mean aspect ratio by less than this.",
        optional=True, type=float,
    )  # fmt: skip
    stop_statistic = Parameter(
        "max",
        "What of normals, dihedral angles and distances the stop rules look at.",
        choices=("max", "mean"),
    )
    output_points_precision = Parameter(
        "default", "Precision of the output's points; default keeps the input's.",
        choices=("default", "single", "double"), codes={0: "single", 1: "double", 2: "default"},
    )  # fmt: skip

    def __init__(self, **parameters: Any) -> None:
        super().__init__(**parameters)
        self.report = RunReport()

    @property
    def figures(self) -> dict[str, Any]:
        """The report as a dictionary."""
        return asdict(self.report)

    def make_scheme(self) -> Scheme:
        """Return the scheme that proposes."""
        raise NotImplementedError

    #: What of the declared constraints a subclass does not let people choose.
    gate: Any = "none"
    tangent_plane: Any = False
    back_to_surface: Any = False

    def make_constraints(self, diagonal: float) -> list[Constraint]:
        """Return the constraints that dispose, the gate last: it judges what the others have left."""
        constraints: list[Constraint] = []
        if self.tangent_plane:
            constraints.append(TangentPlane())
        constraints.append(Boundary(self.boundary == "sliding", self.boundary_corner_angle))
        if self.back_to_surface:
            constraints.append(BackToSurface())
        if self.max_deviation_fraction is not None:
            constraints.append(DeviationBound(self.max_deviation_fraction * diagonal))
        if self.gate != "none":
            constraints.append(Gate(self.gate))
        return constraints

    def make_stop_rules(self, diagonal: float) -> loop.StopRules:
        """Return the stop rules in model units."""
        fraction = self.stop_deviation_fraction
        return loop.StopRules(
            normal_deviation=self.stop_normal_deviation,
            dihedral_change=self.stop_dihedral_change,
            deviation=None if fraction is None else fraction * diagonal,
            volume_percent=self.stop_volume_percent,
            gain=self.stop_gain,
            statistic=self.stop_statistic,
        )

    def execute(self, *inputs: Any) -> vtkPolyData:
        """Smooth one polydata."""
        (source,) = inputs
        surface = surface_of(source)
        diagonal = surface.mesh.diagonal
        points, report = loop.smooth(
            surface.mesh,
            self.make_scheme(),
            self.make_constraints(diagonal),
            iterations=self.iterations,
            fixed=self._fixed_mask(source),
            stop=self.make_stop_rules(diagonal),
            progress=self.progress,
        )
        if not np.isfinite(points).all() and np.isfinite(surface.mesh.points).all():
            raise VtksmoothError("The scheme diverged: points left the finite numbers; lower the relaxation.")
        rounded = self._in_output_precision(points, points_of(source).dtype)
        if report.volume is not None:
            report = replace(
                report,
                volume_rounded=measure.signed_volume(surface.mesh.with_points(rounded.astype(np.float64))),
            )
        output = output_like(source)
        output.SetPoints(vtk_points(rounded))
        add_field(output, "SmoothingIterations", report.iterations)
        add_field(output, "SmoothingStopReason", report.stop_reason)
        add_field(output, "SmoothingVerticesMoved", report.moved)
        add_field(output, "SmoothingSeconds", report.seconds)
        self.report = report
        return output

    def _fixed_mask(self, source: Any) -> npt.NDArray[Any] | None:
        if self.fixed is None:
            return None
        mask = point_array(source, self.fixed)
        if mask is None and self.fixed != FIXED:
            names = ", ".join(point_array_names(source)) or "no arrays"
            raise ParameterError(
                f"There is no point array {self.fixed!r} to fix points by; the mesh has: {names}."
            )
        return mask

    def _in_output_precision(self, points: npt.NDArray[np.float64], given: np.dtype[Any]) -> npt.NDArray[Any]:
        if self.output_points_precision == "single":
            return points.astype(np.float32)
        if self.output_points_precision == "default" and given == np.float32:
            return points.astype(np.float32)
        return points
