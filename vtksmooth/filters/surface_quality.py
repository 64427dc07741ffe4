"""SurfaceQuality: the signed aspect ratio of every face, and the usual measures."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkPolyData

from ..kernels.measures import aspect_ratio, comparison
from ..kernels.measures.label_volumes import label_volumes
from ..kernels.mesh import adjacency
from ..kernels.mesh.mesh import Mesh
from .arrays import Surface, output_like, surface_of, vtk_array
from .base import Filter, add_field
from .labels import BOUNDARY_LABELS_PARAMETER, Labels, labels_name, with_labels
from .parameter import Parameter
from .self_intersection import self_intersections_of
from .usual_measures import USUAL_MEASURES, summary_of_measure, usual_measure

ASPECT_RATIO = "AspectRatio"


def summary_of(
    surface: Surface, near: adjacency.Adjacency, k: np.ndarray, names: Labels | None = None
) -> dict[str, Any]:
    """Return the figures of ``vtksmooth quality --json``; `names` are the values of the mesh's labels."""
    mesh = surface.mesh
    sizes = mesh.face_sizes
    closed = comparison.is_closed(near)
    figures = {
        "points": mesh.n_points,
        "cells": {
            "triangle": int((sizes == 3).sum()),
            "quad": int((sizes == 4).sum()),
            "polygon": int((sizes > 4).sum()),
        },
        "closed": closed,
        # Of a surface between labels each label has a volume.
        "volume": comparison.signed_volume(mesh) if closed and mesh.face_labels is None else None,
        "aspect_ratio": {
            "min": float(k.min()),
            "mean": float(k.mean()),
            "histogram": aspect_ratio.histogram(k),
        },
        "inverted": int((k < 0).sum()),
    }
    if mesh.face_labels is not None and names is not None:
        volumes = label_volumes(mesh).tolist() if closed else [None] * len(names)
        figures["labels"] = [
            {"label": label, "volume": volume} for label, volume in zip(names.tolist(), volumes, strict=True)
        ]
    return figures


def add_aspect_ratio(output: vtkPolyData, surface: Surface, k: np.ndarray) -> None:
    """Add k as a cell array; a strip has the smallest k of its triangles, other cells have 1."""
    values = np.ones(surface.n_cells)
    np.minimum.at(values, surface.cells, k)
    output.GetCellData().AddArray(vtk_array(values, ASPECT_RATIO))


def add_usual_measures(output: vtkPolyData, surface: Surface, progress: Callable[[float], None]) -> Any:
    """Add the usual measures as cell arrays, NaN where a cell has none, and return their summary.

    A strip has the worst value of its triangles.
    """
    summary = {}
    for number, (name, measure) in enumerate(USUAL_MEASURES.items()):
        progress(number / len(USUAL_MEASURES))
        values = usual_measure(surface.mesh, name)
        summary[measure.key] = summary_of_measure(values)
        of_cells = np.full(surface.n_cells, np.nan)
        (np.fmin if measure.low_is_bad else np.fmax).at(of_cells, surface.cells, values)
        output.GetCellData().AddArray(vtk_array(of_cells, name))
    return summary


def faces_with_area(mesh: Mesh, k: np.ndarray) -> np.ndarray:
    """Return k of the faces that have three corners or more: polygons of two corners are no faces."""
    proper = k[mesh.face_sizes >= 3]
    return proper if len(proper) else np.zeros(1)


class SurfaceQuality(Filter):
    """Add the cell array ``AspectRatio``: k of every face, signed (Semenova et al., sections 2.1, 3.1).

    1 for the equilateral triangle, the square and regular plane polygons, and less for all other faces: bent
    ones too. 0 for degenerate faces, negative for concave quadrilaterals and polygons, and for faces turned
    against the surface round them (the sum of their vertices' area-weighted normals); -1 at least.
    Cells that are no faces (verts, lines) have 1 and do not enter the summary.

    The usual measures, of triangles and quadrilaterals, are those of VTK's Verdict, cell arrays too:
    ``MinAngle`` and ``MaxAngle`` in degrees, ``EdgeRatio`` and ``RadiusRatio`` (1 is best, larger is worse),
    ``Skewness`` (of angles: 0 is best, 1 is worst) and ``ScaledJacobian`` (1 is best, 0 and less is
    degenerate or concave). Other cells have NaN.

    Attributes
    ----------
    summary : dict
        The figures of ``vtksmooth quality --json``; also in the output's field data. Of a surface between
        labels ``labels`` has the volume of each. With the parameter `self_intersections` that has the summary
        of :class:`SelfIntersection`.

    Examples
    --------
    >>> from vtkmodules.vtkFiltersSources import vtkPlaneSource
    >>> from vtksmooth import SurfaceQuality
    >>> plane = vtkPlaneSource()
    >>> _ = plane.Update()
    >>> quality = SurfaceQuality()
    >>> result = quality(plane.GetOutput())
    >>> quality.summary["cells"]["quad"], round(quality.summary["aspect_ratio"]["min"], 12)
    (1, 1.0)
    """

    command = "quality"
    measures = True

    boundary_labels = BOUNDARY_LABELS_PARAMETER.with_default(BOUNDARY_LABELS_PARAMETER.default)
    usual_measures = Parameter(
        True,
        "Add the smallest and largest angle, edge ratio, radius ratio, skewness and scaled Jacobian as well.",
    )
    self_intersections = Parameter(False, "Count the faces that cross or touch each other as well.")

    def joins_all(self, block: Any) -> bool:
        """Return whether the faces have labels: then walls between others may meet at a place."""
        return labels_name(block, self.boundary_labels) is not None

    def execute(self, *inputs: Any) -> vtkPolyData:
        """Measure one polydata."""
        (source,) = inputs
        self.progress(0.0, "measuring")
        surface = surface_of(source)
        mesh, names = with_labels(source, surface, labels_name(source, self.boundary_labels))
        near = adjacency.build(mesh)
        self.progress(0.2)
        k = aspect_ratio.aspect_ratios(mesh, aspect_ratio.reference_directions(mesh))
        self.progress(0.4)
        self.summary = summary_of(replace(surface, mesh=mesh), near, faces_with_area(mesh, k), names)
        self.summary["points"] = self.points_given(source)
        output = output_like(source)
        add_aspect_ratio(output, surface, k)
        if self.usual_measures:
            self.summary["usual_measures"] = add_usual_measures(
                output, surface, lambda done: self.progress(0.4 + 0.6 * done)
            )
        if self.self_intersections:
            self.summary["self_intersections"] = self_intersections_of(mesh)
        add_field(output, "AspectRatioMin", self.summary["aspect_ratio"]["min"])
        add_field(output, "AspectRatioMean", self.summary["aspect_ratio"]["mean"])
        add_field(output, "AspectRatioHistogram", self.summary["aspect_ratio"]["histogram"])
        add_field(output, "Inverted", self.summary["inverted"])
        self.progress(1.0)
        return output
