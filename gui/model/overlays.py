"""Overlays: what can be shown on a mesh, and how it is computed, by the filters."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkFiltersGeneral import vtkCurvatures

from vtksmooth.filters import FILTERS, Filter, SelfIntersection, SurfaceComparison, SurfaceQuality
from vtksmooth.filters.smoothing import ADDED_EDGES, REMOVED_EDGES
from vtksmooth.filters.surface_quality import faces_with_area, summary_of
from vtksmooth.filters.usual_measures import USUAL_MEASURES
from vtksmooth.kernels.measures import aspect_ratio
from vtksmooth.kernels.mesh import adjacency

from .difference import difference
from .field import Field, Values
from .state import State
from .units import powered


@dataclass(frozen=True)
class Subject:
    """What an overlay is computed from.

    Attributes
    ----------
    state : State
        The mesh that is shown.
    before : State or None
        What it is compared with.
    space : State or None
        The installation space.
    other : State or None
        The other mesh that it is compared with, whatever its faces.
    """

    state: State
    before: State | None = None
    space: State | None = None
    other: State | None = None

    @property
    def reference(self) -> State | None:
        """What k's signs are taken from: the mesh before, where it has the same points."""
        before = self.before
        if before is None or before.shares_geometry(self.state) or before.surface is None:
            return None
        return before if before.n_points == self.state.n_points else None


#: Runs a filter on meshes, so that it can be watched and cancelled, and returns it.
Run = Callable[..., Any]


@dataclass(frozen=True)
class Overlay:
    """Something to show on the faces.

    Attributes
    ----------
    id, title, unit, help : str
    array : str
        The array's name, as the filters have it.
    source : str
        Key of :data:`SOURCES`.
    needs : str
        "" or what must be there beside the mesh: "before", "space" or "other".
    thresholds : tuple of float or None
        Good, warning, bad. None: by the values themselves.
    relative : bool
        The thresholds are fractions of the bounding box's diagonal.
    span : tuple of float or None
        Ends of the colours; None: by the thresholds and values.
    kind : str
        "sequential", "diverging", "amount" (no value is good or bad) or "classes".
    classes : tuple of str
        Names of the values 0, 1, 2 ...
    power : int
        Of the unit of length in the values: 1 for lengths, -1 for curvatures.
    """

    id: str
    title: str
    array: str
    source: str
    help: str
    unit: str = ""
    needs: str = ""
    thresholds: tuple[float, float, float] | None = None
    relative: bool = False
    span: tuple[float, float] | None = None
    kind: str = "sequential"
    classes: tuple[str, ...] = ()
    power: int = 0

    @property
    def judged(self) -> bool:
        """Whether values are good or bad: there are thresholds, bands and outlines."""
        return self.kind not in ("amount", "classes")

    @property
    def low_is_bad(self) -> bool:
        """Whether small values are the bad ones."""
        return self.thresholds is not None and self.thresholds[0] > self.thresholds[2]

    def unit_of(self, length: str) -> str:
        """Return the unit of the values where lengths have the unit `length`."""
        power = 1 if self.relative else self.power
        return powered(length, power) if power else "°" if self.unit == "deg" else self.unit

    def default_thresholds(self, subject: Subject, values: Field | None) -> tuple[float, float, float]:
        """Return good, warning and bad for this mesh."""
        if self.thresholds is not None:
            scale = (subject.before or subject.state).diagonal if self.relative else 1.0
            good, warning, bad = self.thresholds
            return (good * scale, warning * scale, bad * scale)
        return (0.0, 0.5, 1.0) if values is None else values.quantiles


OVERLAYS: tuple[Overlay, ...] = (
    Overlay(
        "aspect-ratio", "Aspect ratio k", "AspectRatio", "quality",
        "1 for equilateral triangles and squares, 0 for degenerate faces, negative for inverted ones.",
        thresholds=(0.6, 0.4, 0.2), span=(0.0, 1.0),
    ),
    Overlay(
        "normal-deviation", "Normal deviation", "NormalDeviation", "comparison",
        "Angle between the vertex normals before and after.",
        "deg", "before", (5.0, 10.0, 20.0),
    ),
    Overlay(
        "dihedral-change", "Dihedral change", "DihedralChange", "comparison",
        "Largest change of the dihedral angles of the edges at a point.",
        "deg", "before", (5.0, 15.0, 30.0),
    ),
    Overlay(
        "displacement", "Displacement", "Displacement", "comparison",
        "How far each point has moved.",
        "", "before", (0.001, 0.005, 0.01), True,
    ),
    Overlay(
        "deviation", "Deviation", "Deviation", "comparison",
        "Distance of each point to the surface before.",
        "", "before", (0.0005, 0.002, 0.005), True,
    ),
    Overlay(
        "feature-class", "Feature classes", "FeatureClass", "features",
        "Smooth, ridge, corner or cusp; with the ridge lines.",
        kind="classes", classes=("smooth", "ridge", "corner", "cusp"),
    ),
    Overlay(
        "fixed", "Fixed points", "Fixed", "array",
        "Points that smoothing does not move.",
        kind="classes", classes=("free", "fixed"),
    ),
    Overlay(
        "blend-weight", "Blend weights", "BlendWeight", "regions",
        "How much of a step a point takes: 0 fixed, 1 free.",
        span=(0.0, 1.0), kind="amount",
    ),
    Overlay(
        "signed-distance", "Distance to the space", "SignedDistance", "containment",
        "Signed distance to the installation space, negative inside.",
        "", "space", (-0.01, -0.002, 1e-5), True, kind="diverging",
    ),
    Overlay(
        "self-intersection", "Self-intersection", "SelfIntersection", "self-intersection",
        "Faces that cross another face, or touch one beyond common vertices and edges.",
        kind="classes", classes=("apart", "touching", "crossing"),
    ),
    Overlay(
        "mean-curvature", "Mean curvature", "Mean_Curvature", "curvature",
        "Mean curvature at the points, 1 / length.",
        kind="diverging", power=-1,
    ),
    Overlay(
        "difference", "Difference to a layer", "", "difference",
        "Distance to another layer: to the same points, or to its surface where the faces differ.",
        "", "other", (0.0005, 0.002, 0.005), True,
    ),
    Overlay(
        "signed-difference", "Signed difference", "", "difference",
        "Signed distance to another layer, which encloses a volume: negative inside.",
        "", "other", (-0.002, 0.0, 0.002), True, kind="diverging",
    ),
    Overlay(
        "min-angle", "Smallest angle", "MinAngle", "usual-measures",
        "Smallest angle of a triangle or quadrilateral: 60° or 90° is best.",
        "deg", thresholds=(30.0, 20.0, 10.0), span=(0.0, 90.0),
    ),
    Overlay(
        "max-angle", "Largest angle", "MaxAngle", "usual-measures",
        "Largest angle of a triangle or quadrilateral: 60° or 90° is best.",
        "deg", thresholds=(110.0, 130.0, 150.0), span=(60.0, 180.0),
    ),
    Overlay(
        "edge-ratio", "Edge ratio", "EdgeRatio", "usual-measures",
        "Longest edge of a face over its shortest: 1 is best.",
        thresholds=(2.0, 4.0, 8.0),
    ),
    Overlay(
        "radius-ratio", "Radius ratio", "RadiusRatio", "usual-measures",
        "Circumscribed over inscribed circle, as VTK's Verdict has it: 1 is best.",
        thresholds=(1.5, 3.0, 6.0),
    ),
    Overlay(
        "skewness", "Skewness", "Skewness", "usual-measures",
        "How far the angles are from those of a regular face: 0 is best, 1 is worst.",
        thresholds=(0.5, 0.75, 0.9), span=(0.0, 1.0),
    ),
    Overlay(
        "scaled-jacobian", "Scaled Jacobian", "ScaledJacobian", "usual-measures",
        "1 for squares and equilateral triangles, 0 and less for degenerate and concave faces.",
        thresholds=(0.6, 0.4, 0.2), span=(0.0, 1.0),
    ),
)  # fmt: skip


class Unavailable(Exception):
    """An overlay cannot be shown for this mesh; the message says why and what to do."""


def overlay(id: str) -> Overlay:
    """Return the overlay `id`."""
    return next(one for one in OVERLAYS if one.id == id)


def _filter(name: str) -> type[Filter] | None:
    return next((cls for cls in FILTERS if cls.__name__ == name), None)


def _values(mesh: Any, array: str) -> tuple[Values, bool] | None:
    """Return the array of that name as float values, one for each point or cell; lengths of vectors."""
    for data, on_points in ((mesh.GetPointData(), True), (mesh.GetCellData(), False)):
        found = data.GetArray(array)
        if found is not None:
            values = vtk_to_numpy(found)
            if values.ndim == 2:
                values = np.linalg.norm(values.astype(np.float64), axis=1)
            if values.dtype.kind != "f":
                values = values.astype(np.float32)  # VTK takes bytes for colours
            return values, on_points
    return None


def _fields(state: State, mesh: Any, names: list[str], lines: Any = None) -> dict[str, Field]:
    """Return fields of `mesh`, a filter's output on `state`, for the overlays that show `names`."""
    fields = {}
    for one in OVERLAYS:
        found = _values(mesh, one.array) if one.array in names else None
        if found is None or state.surface is None:
            continue
        values, on_points = found
        if not on_points:
            values = values[state.surface.cells]
        field = Field(values, on_points, state.surface, one.low_is_bad, lines).prepare()
        if one.thresholds is None:
            _ = field.quantiles  # of which its thresholds are made
        fields[one.id] = field
    return fields


def _quality(subject: Subject, run: Run) -> dict[str, Field]:
    """Measure k against the directions of the mesh before, as comparisons do; or against its own."""
    state, before = subject.state, subject.reference
    if before is None:
        filter = run(SurfaceQuality(usual_measures=False), state.input())
        state.summaries["quality", None] = filter.summary
        return _fields(state, filter.GetOutput(), ["AspectRatio"])
    assert state.surface is not None
    assert before.surface is not None
    mesh = state.surface.mesh
    k = aspect_ratio.aspect_ratios(
        mesh, aspect_ratio.reference_directions(mesh.with_points(before.surface.mesh.points))
    )
    state.summaries["quality", before] = summary_of(
        state.surface, adjacency.build(mesh), faces_with_area(mesh, k)
    )
    return {"aspect-ratio": Field(k, False, state.surface, True).prepare()}


def _usual_measures(subject: Subject, run: Run) -> dict[str, Field]:
    filter = run(SurfaceQuality(), subject.state.input())
    return _fields(subject.state, filter.GetOutput(), list(USUAL_MEASURES))


def _comparison(subject: Subject, run: Run) -> dict[str, Field]:
    assert subject.before is not None
    state = subject.state
    before = state.comparable(subject.before)
    if before is None:
        raise Unavailable("The mesh before has other points; only meshes with the same points are compared.")
    comparison = run(SurfaceComparison(), state.input(), before)
    state.summaries["comparison", subject.before] = comparison.summary
    arrays = ["NormalDeviation", "DihedralChange", "Displacement", "Deviation"]
    return _fields(state, comparison.GetOutput(), arrays)


def _features(subject: Subject, run: Run) -> dict[str, Field]:
    cls = _filter("FeatureDetection")
    if cls is None:
        raise Unavailable("This version of vtksmooth has no feature detection.")
    detection = run(cls(), subject.state.input())
    lines = detection.GetOutput(1) if len(cls.outputs) > 1 else None
    return _fields(subject.state, detection.GetOutput(), ["FeatureClass"], lines)


def _array(subject: Subject, run: Run) -> dict[str, Field]:
    fields = _fields(subject.state, subject.state.mesh, ["Fixed", "BlendWeight"])
    if "fixed" not in fields:
        raise Unavailable("No points are fixed; paint some (menu Regions).")
    return fields


def _regions(subject: Subject, run: Run) -> dict[str, Field]:
    fields = _fields(subject.state, subject.state.mesh, ["BlendWeight"])
    if not fields:
        raise Unavailable("The region has no soft edge; give it one (menu Regions).")
    return fields


def _containment(subject: Subject, run: Run) -> dict[str, Field]:
    cls = _filter("ContainmentCheck")
    if cls is None:
        raise Unavailable("This version of vtksmooth has no containment check.")
    assert subject.space is not None
    check: Any = run(cls(), subject.state.input(), subject.space.input())
    subject.state.summaries["containment", subject.space] = check.summary
    return _fields(subject.state, check.GetOutput(), ["SignedDistance"])


def _self_intersection(subject: Subject, run: Run) -> dict[str, Field]:
    filter = run(SelfIntersection(), subject.state.input())
    return _fields(subject.state, filter.GetOutput(), ["SelfIntersection"])


def _curvature(subject: Subject, run: Run) -> dict[str, Field]:
    curvatures = vtkCurvatures()
    curvatures.SetCurvatureTypeToMean()
    curvatures.SetInputData(subject.state.input())
    curvatures.Update()
    return _fields(subject.state, curvatures.GetOutput(), ["Mean_Curvature"])


def _difference(subject: Subject, run: Run) -> dict[str, Field]:
    state, other = subject.state, subject.other
    assert other is not None
    assert state.surface is not None
    if other.surface is None:
        raise Unavailable("The other layer has no faces to compare with.")
    distances, signed, summary = difference(state, other)
    state.summaries["difference", other] = summary
    fields = {"difference": Field(distances, True, state.surface).prepare()}
    if signed is not None:
        fields["signed-difference"] = Field(signed, True, state.surface).prepare()
    return fields


#: How the values come to be; one source may serve several overlays.
SOURCES: dict[str, Callable[[Subject, Run], dict[str, Field]]] = {
    "quality": _quality,
    "usual-measures": _usual_measures,
    "comparison": _comparison,
    "features": _features,
    "array": _array,
    "regions": _regions,
    "containment": _containment,
    "self-intersection": _self_intersection,
    "curvature": _curvature,
    "difference": _difference,
}


def key(one: Overlay, subject: Subject) -> Any:
    """Return where the field of an overlay is kept in its state."""
    if one.source == "quality":
        return (one.id, subject.reference)
    return (one.id, getattr(subject, one.needs) if one.needs else None)


def share(known: State, other: State) -> None:
    """Let a state have what was computed on another one that differs from it in data only."""
    if known is other or not other.shares_geometry(known):
        return
    if "surface" in vars(known):
        vars(other).setdefault("surface", known.surface)
    lines = [
        state.mesh.GetFieldData().GetArray(name)
        for name in (ADDED_EDGES, REMOVED_EDGES)
        for state in (known, other)
    ]
    same_lines = lines[0] is lines[1] and lines[2] is lines[3]
    # Copies: a worker may be adding to these.
    for (id, what), values in known.fields.copy().items():
        source = overlay(id).source
        if source not in ("array", "regions") and (source != "features" or same_lines):
            other.fields.setdefault((id, what), values)
    for what, summary in known.summaries.copy().items():
        other.summaries.setdefault(what, summary)


def check_available(one: Overlay, subject: Subject) -> None:
    """Raise Unavailable where what the overlay needs is not open."""
    if subject.state.surface is None:
        raise Unavailable(subject.state.fault)
    if one.needs == "space" and subject.space is None:
        raise Unavailable("Open the installation space, and give its layer that role in the list of layers.")
    if one.needs == "before" and subject.before is None:
        raise Unavailable("There is nothing to compare with.")
    if one.needs == "other" and subject.other is None:
        raise Unavailable("Choose the layer to compare with: Measure > Compare Layers.")


def cached(one: Overlay, subject: Subject) -> Field | None:
    """Return the field of an overlay if it has been computed."""
    return subject.state.fields.get(key(one, subject))


def compute(one: Overlay, subject: Subject, run: Run) -> Field:
    """Compute the field of an overlay, and all others that come with it.

    Raises
    ------
    Unavailable
        It cannot be shown for this mesh.
    VtksmoothError
        What the filter says.
    """
    check_available(one, subject)
    found = cached(one, subject)
    if found is None:
        computed = SOURCES[one.source](subject, run)
        for id, values in computed.items():
            subject.state.fields[key(overlay(id), subject)] = values
        found = computed.get(one.id)
    if found is None:
        raise Unavailable(f"{one.title} could not be computed on this mesh. {one.help}")
    return found


def summarise(subject: Subject, run: Run) -> None:
    """Compute the figures of the numbers panel: quality of both meshes, comparison where possible."""
    for one in (Subject(subject.before) if subject.before else None, subject):
        if one is not None and one.state.surface is not None:
            compute(OVERLAYS[0], one, run)
    before = subject.before
    if (
        before is not None
        and not before.shares_geometry(subject.state)
        and subject.state.surface is not None
        and ("comparison", before) not in subject.state.summaries
        and subject.state.comparable(before) is not None
    ):
        compute(overlay("deviation"), subject, run)
