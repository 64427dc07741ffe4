"""What all smoothing filters share: each is a preset of the one loop."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, replace
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt
from vtkmodules.vtkCommonDataModel import vtkPolyData

from ..errors import InvalidMeshError, ParameterError, VtksmoothError
from ..kernels.features.detection import Features, detect
from ..kernels.features.edits import edited
from ..kernels.features.metric_tensor import WEIGHTS
from ..kernels.measures import comparison
from ..kernels.mesh import adjacency
from ..kernels.mesh.adjacency import Adjacency
from ..kernels.mesh.mesh import Mesh
from ..kernels.smoothing import loop
from ..kernels.smoothing.constraints import Constraint
from ..kernels.smoothing.constraints.back_to_surface import BackToSurface
from ..kernels.smoothing.constraints.blend import Blend
from ..kernels.smoothing.constraints.boundary import Boundary
from ..kernels.smoothing.constraints.containment import Containment
from ..kernels.smoothing.constraints.creases import Creases
from ..kernels.smoothing.constraints.curvature_bound import CurvatureBound
from ..kernels.smoothing.constraints.deviation_bound import DeviationBound
from ..kernels.smoothing.constraints.directions import Directions
from ..kernels.smoothing.constraints.feature_lines import FeatureLines
from ..kernels.smoothing.constraints.gate import Gate
from ..kernels.smoothing.constraints.label_volumes import LabelVolumes
from ..kernels.smoothing.constraints.local_volume import LocalVolume
from ..kernels.smoothing.constraints.no_inversion import NoInversion
from ..kernels.smoothing.constraints.null_space import NullSpace
from ..kernels.smoothing.constraints.on_source import OnSource
from ..kernels.smoothing.constraints.self_intersection import NoNewSelfIntersections
from ..kernels.smoothing.constraints.smoothed_boundary import SmoothedBoundary
from ..kernels.smoothing.constraints.tangent_plane import TangentPlane
from ..kernels.smoothing.schemes import Scheme
from ..report import RunReport
from .arrays import edge_array, output_like, point_array, point_array_names, points_of, surface_of, vtk_points
from .base import Filter, add_field
from .labels import BOUNDARY_LABELS, labels_name, with_labels
from .parameter import AUTO, CONSTRAINTS, OUTPUT, SET, STOP_RULES, Parameter
from .places import DUPLICATES, HIDDEN, Block, Joined, Merge, joined
from .planes import parse_coordinates, parse_planes
from .point_lists import SELECTION, parse_selection
from .signed_distance import Inside, opened

#: Array that pins points when it is there and no other is named.
FIXED = "Fixed"

#: Array that says how much of its steps a point takes, when it is there and no other is named.
BLEND_WEIGHT = "BlendWeight"

#: Array that bounds displacements when it is there and no other is named: that of VTK's
#: vtkConstrainedSmoothingFilter.
MAX_DISPLACEMENT = "SmoothingConstraints"

#: What numbers in single precision can be.
_SINGLE = np.finfo(np.float32)

#: Arrays that say what the features are, when both are there.
FEATURE_CLASS, RIDGE_NEIGHBOURS = "FeatureClass", "RidgeNeighbours"

#: Field arrays of edges that are features, or none, whatever the detection says.
ADDED_EDGES, REMOVED_EDGES = "AddedFeatureEdges", "RemovedFeatureEdges"


#: Where coordinates are coarser than this part of the diagonal, what is promised is lost in rounding.
_COARSEST = 1e-3

#: Where it matters what the features are.
_FEATURES: dict[str, Any] = {"features": ("hold", "slide"), "null_space": (True,)}


def edits_of(algorithm: Any, source: Any) -> tuple[npt.NDArray[Any], npt.NDArray[Any]] | None:
    """Return the edges added and removed by hand, (k, 2) each; None where there are none.

    Parameters
    ----------
    algorithm : Filter
        Has the parameters `added_edges` and `removed_edges`.
    source : vtkPolyData
    """
    edits = []
    for parameter in ("added_edges", "removed_edges"):
        name = getattr(algorithm, parameter)
        pairs = None if name is None else edge_array(source, name)
        if pairs is None and name not in (None, ADDED_EDGES, REMOVED_EDGES):
            raise ParameterError(f"{parameter}: there is no field array {name!r}.")
        edits.append(np.empty((0, 2), np.int64) if pairs is None else pairs)
    return (edits[0], edits[1]) if any(len(pairs) for pairs in edits) else None


def edge_arrays_of(algorithm: Any) -> list[str]:
    """Return the names of the field arrays that the parameters `added_edges` and `removed_edges` name."""
    return [name for name in (algorithm.added_edges, algorithm.removed_edges) if name is not None]


def _refuse_coarse(mesh: Mesh) -> None:
    spacing = float(np.spacing(np.abs(mesh.points[mesh.used_points]).max(initial=0.0)))
    if spacing > _COARSEST * mesh.diagonal > 0.0:
        raise InvalidMeshError(
            f"The mesh lies so far from the origin that its coordinates are exact to {spacing:.2g} only, "
            "more than a thousandth of its size; move it to the origin first."
        )


class SmoothingFilter(Filter):
    """Base of the smoothing filters. Subclasses choose a scheme and default constraints.

    Attributes
    ----------
    report : RunReport
        What the last execution did; composite input is one surface.
    """

    clean = True
    optional_inputs: ClassVar[tuple[str, ...]] = ("installation", "source")
    says_of_places = "points in one place move as one."

    iterations = Parameter(10, "Most iterations to do.", low=0)
    fixed = Parameter(
        FIXED,
        "Point array; points with a nonzero value stay fixed. If it is missing, no point is. In Python also "
        "a mask or numbers of points; as text points:0-14,20.",
        optional=True, type=str, points=True, group=CONSTRAINTS,
    )  # fmt: skip
    blend = Parameter(
        BLEND_WEIGHT, "Point array of the part of each step that a point takes, 0 to 1; absent, all of it.",
        optional=True, type=str, group=CONSTRAINTS,
    )  # fmt: skip
    max_displacement = Parameter(
        MAX_DISPLACEMENT,
        "Point array of how far each point may go from its place, in model units; absent, any distance.",
        optional=True, type=str, group=CONSTRAINTS,
    )  # fmt: skip
    boundary_labels = Parameter(
        BOUNDARY_LABELS,
        "Cell array of the labels on the two sides of each face, normals from the first to the second (or of "
        "one label, the other is 0); absent, the surface is one between two sides.",
        optional=True, type=str, group=CONSTRAINTS,
    )  # fmt: skip
    boundary = Parameter(
        "fixed",
        "Whether boundary points stay, slide along it, or smooth it as a curve that keeps its area.",
        choices=("fixed", "sliding", "smoothed"),
        group=CONSTRAINTS,
    )
    boundary_corner_angle = Parameter(
        30.0, "Boundary points that may move stay where the boundary turns by more than this.",
        low=0.0, high=180.0, unit="deg", group=CONSTRAINTS, only={"boundary": ("sliding", "smoothed")},
    )  # fmt: skip
    features = Parameter(
        "ignore",
        "Whether points on ridges move like all others, are held, or slide along the ridge; corners stay.",
        choices=("ignore", "hold", "slide"),
        group=CONSTRAINTS,
    )
    ridge_angle = Parameter(
        AUTO, "Dihedral angle from which an edge is a ridge, where no arrays say what the features are.",
        low=0.0, high=180.0, unit="deg", automatic=True, type=float, group=CONSTRAINTS, only=_FEATURES,
    )  # fmt: skip
    corner_angle = Parameter(
        AUTO, "Turning angle from which a ridge or a cone has a corner, where no arrays say it.",
        low=0.0, high=180.0, unit="deg", automatic=True, type=float, group=CONSTRAINTS, only=_FEATURES,
    )  # fmt: skip
    added_edges = Parameter(
        ADDED_EDGES, "Field array of pairs of points: edges that are ridges, whatever their angle.",
        optional=True, type=str, group=CONSTRAINTS, only=_FEATURES,
    )  # fmt: skip
    removed_edges = Parameter(
        REMOVED_EDGES, "Field array of pairs of points: edges that are no ridges, whatever their angle.",
        optional=True, type=str, group=CONSTRAINTS, only=_FEATURES,
    )  # fmt: skip
    crease_angle = Parameter(
        None, "Edges with a dihedral angle above this stay above it.",
        low=0.0, high=180.0, unit="deg", optional=True, type=float, group=CONSTRAINTS,
    )  # fmt: skip
    gate = Parameter(
        "none",
        "What must improve round a vertex for it to move: nothing, the smallest angle, the smallest aspect "
        "ratio, or (floor) that below gate_floor and the mean above it.",
        choices=("none", "angle", "aspect", "floor"),
        group=CONSTRAINTS,
    )
    gate_floor = Parameter(
        0.6,
        "Of the gate with a floor: aspect ratio that is good enough.",
        low=0.0,
        high=1.0,
        group=CONSTRAINTS,
        only={"gate": ("floor",)},
    )
    max_deviation_fraction = Parameter(
        None, "Keep every point within this distance of the original surface.",
        low=0.0, unit="diagonals", optional=True, type=float, group=CONSTRAINTS,
    )  # fmt: skip
    null_space = Parameter(
        False,
        "Keep of each step what goes across the surface or along its ridges; corners do not slide.",
        group=CONSTRAINTS,
    )
    tensor_weight = Parameter(
        "area",
        "What weighs a face in a vertex' tensor: its area, or its angle (better on badly graded meshes).",
        choices=WEIGHTS,
        group=CONSTRAINTS,
        only={"null_space": (True,)},
    )
    corrections = Parameter(
        0,
        "Corrections in each pass of the volume that is swept round every point; 0 is none.",
        low=0,
        high=100,
        group=CONSTRAINTS,
    )
    preserve_volume = Parameter(
        False,
        "End each pass with an equal step of all points that closes the volume of every body, or of every "
        "label, exactly.",
        group=CONSTRAINTS,
    )
    containment = Parameter(
        "exact",
        "What must stay inside the installation space: nothing, vertices, or (exact) triangles too.",
        choices=("none", "vertices", "exact"),
        group=CONSTRAINTS,
        only={"installation": SET},
    )
    tolerance_fraction = Parameter(
        1e-6, "How far outside counts as inside; never less than what the points' precision makes of it.",
        low=0.0, unit="diagonals", group=CONSTRAINTS, only={"installation": SET},
    )  # fmt: skip
    directions = Parameter(
        "all",
        "Coordinates that may change (xy: in plan, where no face turns over), or an axis to turn about.",
        choices=("all", "x", "y", "z", "xy", "xz", "yz", "about-x", "about-y", "about-z"),
        group=CONSTRAINTS,
    )
    rotation_center = Parameter(
        "0,0,0", "A point on the axis about which points turn, in model units: its three coordinates.",
        type=str, text="coordinates", group=CONSTRAINTS,
        only={"directions": ("about-x", "about-y", "about-z")},
    )  # fmt: skip
    symmetry_planes = Parameter(
        None, "Planes on which points stay that are on them at the start, such as x=0,z=2.5; model units.",
        optional=True, type=str, text="planes", group=CONSTRAINTS,
    )  # fmt: skip
    curvature_radius = Parameter(
        None, "Leave points where the surface is as flat as a sphere of this radius; auto: by the noise.",
        low=0.0, unit="model units", optional=True, automatic=True, type=float, group=CONSTRAINTS,
    )  # fmt: skip
    curvature_ramp = Parameter(
        0.0, "Steps grow from nothing to full length between 1 and 1 + this times the bound.",
        low=0.0, group=CONSTRAINTS, only={"curvature_radius": SET},
    )  # fmt: skip
    self_intersection = Parameter(
        "ignore", "Whether faces may come to cross or touch others that they did not at the start.",
        choices=("ignore", "none-new"), group=CONSTRAINTS,
    )  # fmt: skip
    stop_normal_deviation = Parameter(
        None, "Stop before vertex normals turn by more than this.",
        low=0.0, high=180.0, unit="deg", optional=True, type=float, group=STOP_RULES,
    )  # fmt: skip
    stop_dihedral_change = Parameter(
        None, "Stop before dihedral angles change by more than this.",
        low=0.0, high=360.0, unit="deg", optional=True, type=float, group=STOP_RULES,
    )  # fmt: skip
    stop_deviation_fraction = Parameter(
        None, "Stop before points are farther from the original surface than this.",
        low=0.0, unit="diagonals", optional=True, type=float, group=STOP_RULES,
    )  # fmt: skip
    stop_volume_percent = Parameter(
        None, "Stop before the enclosed volume changes by more than this.",
        low=0.0, unit="percent", optional=True, type=float, group=STOP_RULES,
    )  # fmt: skip
    stop_gain = Parameter(
        None, "Stop when an iteration raises the mean aspect ratio by less than this.",
        optional=True, type=float, group=STOP_RULES,
    )  # fmt: skip
    stop_statistic = Parameter(
        "max",
        "What of normals, dihedral angles and distances the stop rules look at.",
        choices=("max", "mean"),
        group=STOP_RULES,
        only=dict.fromkeys(("stop_normal_deviation", "stop_dihedral_change", "stop_deviation_fraction"), SET),
    )
    output_points_precision = Parameter(
        "default", "Precision of the output's points; default keeps the input's.",
        choices=("default", "single", "double"), codes={0: "single", 1: "double", 2: "default"}, group=OUTPUT,
    )  # fmt: skip

    report: RunReport

    def forget(self) -> None:
        """Drop what the last execution reported."""
        super().forget()
        self.report = RunReport()

    @property
    def figures(self) -> dict[str, Any]:
        """The report as a dictionary."""
        return asdict(self.report)

    def read_arrays(self, source: Any) -> None:
        """Read what the scheme and the constraints need of the input's arrays."""

    def make_scheme(self) -> Scheme:
        """Return the scheme that proposes."""
        raise NotImplementedError

    #: What of the declared constraints a subclass does not let people choose.
    tangent_plane: Any = False
    back_to_surface: Any = False

    #: Volume that each face is to sweep in each iteration, where a subclass reads it.
    _flux: npt.NDArray[np.float64] | None = None

    #: Whether the surface lies between labels.
    labelled: bool = False

    def make_constraints(
        self, diagonal: float, weights: npt.NDArray[Any] | None, inside: Inside | None
    ) -> list[Constraint]:
        """Return the constraints that dispose, in any order; see ``smoothed``."""
        constraints: list[Constraint] = []
        # What steps off the surface are to remove, local corrections would give back: noise with it.
        tangential = (
            self.corrections and not self.labelled and not self.null_space and not self.make_scheme().keeps
        )
        if self.tangent_plane or tangential:
            constraints.append(TangentPlane())
            if not self.tangent_plane:
                constraints[-1].name = "The tangent plane that corrections need (corrections)"
            elif "tangent_plane" not in self.parameters():
                constraints[-1].name, constraints[-1].always_in = "The tangent plane", type(self).__name__
        if self.null_space:
            constraints.append(NullSpace(self.tensor_weight))
        if self.boundary == "smoothed":
            constraints.append(SmoothedBoundary(self.boundary_corner_angle))
        else:
            constraints.append(Boundary(self.boundary == "sliding", self.boundary_corner_angle))
        # In the null space ridges slide as it is.
        if self.features == "hold" or (self.features == "slide" and not self.null_space):
            constraints.append(FeatureLines(sliding=self.features == "slide"))
        if self.directions != "all" or self.symmetry_planes is not None:
            constraints.append(self._make_directions(inside))
        if weights is not None:
            constraints.append(Blend(weights))
        if self.curvature_radius is not None:
            radius = None if self.curvature_radius == AUTO else self.curvature_radius
            constraints.append(CurvatureBound(radius, self.curvature_ramp))
        if self.back_to_surface:
            constraints.append(BackToSurface())
            if "back_to_surface" not in self.parameters():
                constraints[-1].name = "The way back to the surface"
                constraints[-1].always_in = type(self).__name__
        if self.max_deviation_fraction is not None:
            constraints.append(DeviationBound(self.max_deviation_fraction * diagonal))
        if self.crease_angle is not None:
            constraints.append(Creases(self.crease_angle))
        if inside is not None and self.containment != "none":
            exact = self.containment == "exact"
            constraints.append(Containment(inside.space.tree, inside.tolerance, exact, inside.measured))
        if self.labelled:
            constraints += self._constraints_on_labels()
        elif self.corrections or self.preserve_volume:
            constraints.append(LocalVolume(self.corrections, self.preserve_volume, self._flux))
        elif self.null_space:
            constraints.append(NoInversion())
        if self.gate != "none":
            constraints.append(Gate(self.gate, self.gate_floor))
        return constraints

    def _on_source(self, onto: vtkPolyData, origin: npt.NDArray[np.float64] | None) -> OnSource:
        try:
            whole = joined([Block(None, onto)], None, True, DUPLICATES | HIDDEN)
            mesh = surface_of(onto if whole is None else whole.polydata).mesh
        except InvalidMeshError as error:
            raise InvalidMeshError(f"The source surface is no usable surface: {error}") from error
        mesh = mesh if origin is None else mesh.with_points(mesh.points - origin)
        features = detect(mesh, adjacency.build(mesh), ridge_angle=AUTO, corner_angle=AUTO)
        return OnSource(mesh, features)

    def _make_directions(self, inside: Inside | None) -> Directions:
        origin = np.zeros(3) if inside is None or inside.space.origin is None else inside.space.origin
        planes = parse_planes("symmetry_planes", self.symmetry_planes)
        planes = [(axis, value - origin[axis]) for axis, value in planes]
        center = parse_coordinates("rotation_center", self.rotation_center) - origin
        if self.directions.startswith("about-"):
            return Directions(about="xyz".index(self.directions[-1]), center=center, planes=planes)
        return Directions("xyz" if self.directions == "all" else self.directions, planes=planes)

    def _constraints_on_labels(self) -> list[Constraint]:
        if self.corrections != self.parameters()["corrections"].default:
            raise ParameterError(
                "corrections have no effect on a surface between labels: leave them out; preserve_volume "
                "keeps the volume of every label."
            )
        if self._flux is not None:
            raise ParameterError("flux has no effect on a surface between labels: leave it out.")
        if self.preserve_volume:
            return [LabelVolumes()]
        return [NoInversion()] if self.null_space else []

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

    def check(self, *inputs: Any) -> None:
        """Refuse distances below 0."""
        distances = None if self.max_displacement is None else point_array(inputs[0], self.max_displacement)
        if distances is not None and not (distances >= 0).all():
            raise InvalidMeshError(
                f"The point array {self.max_displacement!r} must hold distances, 0 or more at every point."
            )

    def merges(self) -> dict[str, Merge]:
        """Return what becomes of the arrays that the parameters name: what holds back most goes."""
        named = {
            None if self._selects() else self.fixed: Merge("any"),
            self.blend: Merge("least", 1.0),
            self.max_displacement: Merge("least", np.inf),
            FEATURE_CLASS: Merge("greatest", None),
            RIDGE_NEIGHBOURS: Merge("neighbours", None, 2),
        }
        return {name: merge for name, merge in named.items() if name is not None}

    def joins_all(self, block: Any) -> bool:
        """Return whether the faces have labels: then walls between others may meet at a place."""
        return labels_name(block, self.boundary_labels) is not None

    def edge_arrays(self) -> list[str]:
        """Return the arrays of edges added and removed by hand."""
        return edge_arrays_of(self)

    def spread(self, results: tuple[Any, ...], whole: Joined) -> list[tuple[Any, ...]]:
        """Return the blocks with their new points."""
        keep = self.output_points_precision == "default"
        return [(output,) for output in whole.spread(results[0], keep_precision=keep)]

    def execute(self, *inputs: Any) -> vtkPolyData:
        """Smooth one polydata, inside another one if there is one."""
        source, installation, onto = (*inputs, None, None)[:3]
        held = self.held_points(source)
        weights = self.weights_of_steps(source, held)
        inside = None
        if installation is not None:
            self.progress(0.0, "measuring distances")
            inside = opened(source, installation, self.tolerance_fraction)
            self.notes += inside.space.notes
        return self.smoothed(source, held, weights, inside, onto)

    def smoothed(
        self,
        source: vtkPolyData,
        held: npt.NDArray[Any] | None,
        weights: npt.NDArray[Any] | None,
        inside: Inside | None,
        onto: vtkPolyData | None = None,
    ) -> vtkPolyData:
        """Return `source` smoothed, and keep the report.

        Parameters
        ----------
        source : vtkPolyData
        held : (n,) array, optional
            Nonzero at points that must not move.
        weights : (n,) array, optional
            The part of each step that a point takes.
        inside : Inside, optional
            The same mesh with the space that it is in.
        onto : vtkPolyData, optional
            The surface that its points are put on.
        """
        given, names = with_labels(source, surface_of(source), labels_name(source, self.boundary_labels))
        self.labelled = given.face_labels is not None
        _refuse_coarse(given)
        mesh = given if inside is None else given.with_points(inside.mesh.points)
        origin = None if inside is None else inside.space.origin
        diagonal = mesh.diagonal
        self.read_arrays(source)
        constraints = self.make_constraints(diagonal, weights, inside)
        kept_on = None
        if onto is not None:
            kept_on = self._on_source(onto, origin)
            constraints = [each for each in constraints if not isinstance(each, BackToSurface)] + [kept_on]
        if self.self_intersection == "none-new":
            constraints.append(NoNewSelfIntersections(self._written(source, origin)))
        points, report = loop.smooth(
            mesh,
            self.make_scheme(),
            constraints,
            iterations=self.iterations,
            fixed=held,
            max_displacement=self._point_array(source, "max_displacement"),
            find_features=self._features(source, mesh),
            stop=self.make_stop_rules(diagonal),
            progress=self.progress,
            watched=bool(self.HasObserver("ProgressEvent")),
        )
        if kept_on is not None:
            before, after = (
                float(kept_on.surface.query(each[mesh.used_points])[1].max(initial=0.0))
                for each in (mesh.points, points)
            )
            report.source_deviation = before, after
        if not np.isfinite(points).all() and np.isfinite(mesh.points).all():
            raise VtksmoothError(
                "The scheme diverged: points left the finite numbers; lower the relaxation factor."
            )
        if origin is not None and origin.any():
            points = np.where(points == mesh.points, given.points, points + origin)
            # Where the origin is far away, steps may be less than what the coordinates can tell.
            moved = (points != given.points) & ~np.isnan(points)
            report.moved = int(np.count_nonzero(moved.any(axis=1)))
        rounded = self._in_output_precision(points, points_of(source).dtype)
        if len(names):
            report.label_volumes = tuple(
                (int(names[number]), before, after) for number, before, after in report.label_volumes
            )
        if report.volume is not None:
            written = mesh.with_points(rounded.astype(np.float64) - (0.0 if origin is None else origin))
            report = replace(report, volume_rounded=comparison.signed_volume(written))
        if self.whole is not None:
            report = replace(report, merged_points=self.whole.merged_points)
        self.report = report
        return self._with_points(source, rounded)

    def _with_points(self, source: vtkPolyData, points: npt.NDArray[Any]) -> vtkPolyData:
        """Return `source` with its new points, and with what the report says as field data."""
        output, report = output_like(source), self.report
        output.SetPoints(vtk_points(points))
        add_field(output, "SmoothingIterations", report.iterations)
        add_field(output, "SmoothingStopReason", report.stop_reason)
        add_field(output, "SmoothingVerticesMoved", report.moved)
        add_field(output, "SmoothingMergedPoints", report.merged_points)
        add_field(output, "SmoothingSeconds", report.seconds)
        return output

    def _written(
        self, source: vtkPolyData, origin: npt.NDArray[np.float64] | None
    ) -> Callable[[npt.NDArray[np.float64]], npt.NDArray[np.float64]] | None:
        """Return what gives points as the output has them; None where that does not round them."""
        precision = self.output_points_precision
        single = precision == "single" or (precision == "default" and points_of(source).dtype == np.float32)
        if not single:
            return None
        shift = 0.0 if origin is None else origin

        def written(points: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
            with np.errstate(over="ignore"):
                return (points + shift).astype(np.float32).astype(np.float64)

        return written

    def held_points(self, source: Any) -> npt.NDArray[Any] | None:
        """Return what is nonzero at points that must not move, or None.

        Those of ghost cells are among them: what is on the boundary between pieces is the same in each.
        """
        held = self._selected(source) if self._selects() else self._point_array(source, "fixed")
        if self.whole is None or not self.whole.pinned.any():
            return held
        return self.whole.pinned if held is None else self.whole.pinned | (held != 0)

    def _selects(self) -> bool:
        return self.fixed is not None and self.fixed.startswith(SELECTION)

    def _selected(self, source: Any) -> npt.NDArray[Any]:
        """Return the points that `fixed` chooses by a mask or by numbers, as a mask."""
        selected = np.zeros(source.GetNumberOfPoints(), np.bool_)
        if self.whole is None:
            selected[parse_selection("fixed", self.fixed, len(selected))] = True
            return selected
        if len(self.whole.blocks) > 1:
            raise ParameterError(
                "fixed: a mask or numbers of points are of one mesh; for meshes in blocks give the name of a "
                "point array of theirs."
            )
        points = parse_selection("fixed", self.fixed, self.whole.starts[-1])
        selected[self.whole.places_of(0, points)] = True
        return selected

    def weights_of_steps(self, source: Any, held: npt.NDArray[Any] | None) -> npt.NDArray[Any] | None:
        """Return the part of each step that a point takes; None where those that may move take all of it."""
        weights = self._point_array(source, "blend")
        if weights is None or ((weights if held is None else weights[held == 0]) == 1.0).all():
            return None
        return weights

    def _point_array(self, source: Any, parameter: str) -> npt.NDArray[Any] | None:
        """Return the array that a parameter names; an array with the default's name need not be there."""
        name = getattr(self, parameter)
        array = None if name is None else point_array(source, name)
        if array is None and name is not None and name != self.parameters()[parameter].default:
            names = ", ".join(point_array_names(source)) or "no arrays"
            raise ParameterError(f"{parameter}: there is no point array {name!r}; the mesh has: {names}.")
        return array

    def _features(self, source: Any, mesh: Mesh) -> loop.FindFeatures:
        """Return the features, where the input says something of them, or what finds them."""
        given = self._given_features(source, mesh)
        if self.features == "ignore" and not self.null_space:
            return given or self._find_features
        edits = edits_of(self, source)
        if edits is None:
            return given or self._find_features
        near = adjacency.build(mesh)
        return edited(given or self._find_features(mesh, near), mesh, near, *edits)

    def _given_features(self, source: Any, mesh: Mesh) -> Features | None:
        classes = point_array(source, FEATURE_CLASS)
        ring = point_array(source, RIDGE_NEIGHBOURS, components=2)
        if classes is None or ring is None:
            return None
        on_faces = np.zeros(mesh.n_points + 1, np.bool_)  # and at the end, where there is no neighbour
        on_faces[mesh.connectivity] = on_faces[-1] = True
        there = (ring >= -1) & (ring < len(ring))
        if not (np.isin(classes, range(4)).all() and there.all() and on_faces[ring].all()):
            raise InvalidMeshError(
                f"{FEATURE_CLASS} and {RIDGE_NEIGHBOURS} do not belong to this mesh; detect its features "
                "anew, or remove the arrays."
            )
        no_edges = np.empty((0, 2), np.int32)
        return Features(classes.astype(np.uint8), ring.astype(np.int32), no_edges)

    def _find_features(self, mesh: Mesh, near: Adjacency) -> Features:
        weight = self.tensor_weight if self.null_space else WEIGHTS[0]
        return detect(mesh, near, ridge_angle=self.ridge_angle, corner_angle=self.corner_angle, weight=weight)

    def _in_output_precision(self, points: npt.NDArray[np.float64], given: np.dtype[Any]) -> npt.NDArray[Any]:
        default = self.output_points_precision == "default"
        if self.output_points_precision == "double" or (default and given != np.float32):
            return points
        with np.errstate(over="ignore"):
            rounded = points.astype(np.float32)
        largest = np.abs(points).max(where=np.isfinite(points), initial=0.0)
        if largest > _SINGLE.max or 0.0 < largest < _SINGLE.tiny:
            raise ParameterError(
                f"Coordinates of {largest:.3g} are out of the range of single precision; set "
                "output_points_precision to double."
            )
        return rounded
