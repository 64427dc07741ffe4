"""SurfaceComparison: what smoothing changed."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkPolyData

from ..errors import InvalidMeshError
from ..kernels.distance.closest_point import ClosestPoint
from ..kernels.distance.hausdorff import farthest
from ..kernels.measures import aspect_ratio, comparison
from ..kernels.measures.label_volumes import label_volumes
from ..kernels.mesh import adjacency
from ..kernels.mesh.mesh import Mesh
from .arrays import output_like, surface_of, vtk_array
from .base import Filter, add_field
from .labels import BOUNDARY_LABELS_PARAMETER, labels_name, with_labels
from .parameter import Parameter
from .surface_quality import add_aspect_ratio, faces_with_area, summary_of


class SurfaceComparison(Filter):
    """Measure a result against its original (Semenova et al., section 4).

    Adds to the result the point arrays ``NormalDeviation`` (angle between vertex normals, degrees),
    ``DihedralChange`` (largest change of the signed dihedral angle of the edges at the point, degrees),
    ``Displacement`` (vector) and ``Deviation`` (distance of the point to the original surface, which
    ``max_deviation_fraction`` bounds), and the cell array ``AspectRatio``, signed against the original's
    directions. Both meshes must have the same points and faces.

    Maximum and mean of the dihedral change are those of the edges that have a dihedral angle: edges of
    exactly two faces that agree on the orientation and have an area in both meshes. Edges of the boundary and
    non-manifold edges do not count. In the same way those of the normal deviation are over the points that
    have a normal in both. Points without such an edge, or without a normal, have 0 in the arrays.

    Attributes
    ----------
    summary : dict
        The figures of ``vtksmooth compare --json``; also in the output's field data. For open meshes
        ``volume_change_percent`` is None; ``swept_volume`` is the volume between the two surfaces. Of a
        surface between labels ``labels`` has the volumes of each, and ``swept_volume`` is the largest change.
        ``deviation`` has the largest and the mean distance of the result's points to the original surface
        and, under ``back``, of the original's points to the result, which is larger where a corner is cut
        off. ``max_relative`` and ``mean_relative`` are fractions of the original's diagonal. With the
        parameter `hausdorff`, ``hausdorff`` has bounds on the Hausdorff distance, in model units: no point of
        either surface, on its faces too, is farther than ``upper`` from the other one, and one is as far as
        ``lower``, which is at most 5 % less; ``there`` and ``back`` have those of the result to the original
        and of the original to the result. None otherwise.

    Examples
    --------
    >>> from vtkmodules.vtkFiltersSources import vtkSphereSource
    >>> from vtksmooth import LaplacianSmoothing, SurfaceComparison
    >>> sphere = vtkSphereSource()
    >>> _ = sphere.Update()
    >>> original = sphere.GetOutput()
    >>> comparison = SurfaceComparison()
    >>> result = comparison(LaplacianSmoothing()(original), original)
    >>> comparison.summary["volume_change_percent"] < 0
    True
    """

    command = "compare"
    boundary_labels = BOUNDARY_LABELS_PARAMETER.with_default(BOUNDARY_LABELS_PARAMETER.default)
    hausdorff = Parameter(
        False, "Bound the distance of the surfaces both ways, at all their points (the Hausdorff distance)."
    )
    inputs = ("result", "original")
    arguments = ("original", "result")
    measures = True

    def joins_all(self, block: Any) -> bool:
        """Return whether the faces have labels: then walls between others may meet at a place."""
        return labels_name(block, self.boundary_labels) is not None

    def check(self, *inputs: Any) -> None:
        """Refuse meshes with other points or faces than each other's."""
        after, before = (surface_of(data).mesh for data in inputs)
        _check_same_topology(after, before)

    def execute(self, *inputs: Any) -> vtkPolyData:
        """Compare two polydata."""
        result, original = inputs
        self.progress(0.0, "comparing")
        after, before = surface_of(result), surface_of(original)
        mesh, names = with_labels(result, after, labels_name(result, self.boundary_labels))
        if mesh.face_labels is not None:
            # Which faces labels turn over is the same in both.
            after, before = (
                replace(each, mesh=mesh.with_points(each.mesh.points)) for each in (after, before)
            )
        near = adjacency.build(before.mesh)
        edge_ends, edge_faces = adjacency.edges(near)
        self.progress(0.2)
        normals = comparison.normal_deviation(before.mesh, after.mesh)
        dihedral = comparison.dihedral_change(before.mesh, after.mesh, edge_ends, edge_faces)
        at_points = np.zeros(before.mesh.n_points)
        for end in range(2):
            np.fmax.at(at_points, edge_ends[:, end], dihedral)
        self.progress(0.4)
        # Faces of fewer than three corners are no surface, and nothing is at a distance from them.
        sizes = before.mesh.face_sizes
        used = np.zeros(before.mesh.n_points, np.bool_)
        used[before.mesh.connectivity[np.repeat(sizes >= 3, sizes)]] = True
        deviation = np.zeros(before.mesh.n_points)
        deviation[used] = ClosestPoint(before.mesh).query(after.mesh.points[used])[1]
        self.progress(0.7)
        back = ClosestPoint(after.mesh).query(before.mesh.points[used])[1]
        bounds = self._hausdorff(before.mesh, after.mesh) if self.hausdorff else None
        self.progress(0.9)
        k = aspect_ratio.aspect_ratios(after.mesh, aspect_ratio.reference_directions(before.mesh))
        labelled = mesh.face_labels is not None
        swept = (
            float(np.abs(label_volumes(after.mesh) - label_volumes(before.mesh)).max())
            if labelled
            else comparison.swept_volume(before.mesh, after.mesh)
        )
        summary = summary_of(after, near, faces_with_area(after.mesh, k), names)
        summary["points"] = self.points_given(result)
        volume = comparison.signed_volume(before.mesh) if summary["closed"] and not labelled else 0.0
        if labelled and summary["closed"]:
            for each, old in zip(summary["labels"], label_volumes(before.mesh).tolist(), strict=True):
                change = 100.0 * (each["volume"] / old - 1.0) if old else None
                each |= {"volume_before": old, "change_percent": change}
        summary |= {
            "normal_deviation": _statistics(normals),
            "dihedral_change": _statistics(dihedral),
            "volume_change_percent": 100.0 * swept / abs(volume) if volume else None,
            "swept_volume": swept,
            "deviation": deviation_figures(deviation[used], back, before.mesh.diagonal),
            "hausdorff": bounds,
        }
        self.summary = summary
        output = output_like(result)
        data = output.GetPointData()
        data.AddArray(vtk_array(np.nan_to_num(normals), "NormalDeviation"))
        data.AddArray(vtk_array(at_points, "DihedralChange"))
        data.AddArray(vtk_array(np.nan_to_num(after.mesh.points - before.mesh.points), "Displacement"))
        data.AddArray(vtk_array(deviation, "Deviation"))
        add_aspect_ratio(output, after, k)
        for name, key in (
            ("NormalDeviation", "normal_deviation"),
            ("DihedralChange", "dihedral_change"),
            ("Deviation", "deviation"),
        ):
            add_field(output, f"{name}Max", summary[key]["max"])
            add_field(output, f"{name}Mean", summary[key]["mean"])
        add_field(output, "DeviationBackMax", summary["deviation"]["back"]["max"])
        add_field(output, "DeviationBackMean", summary["deviation"]["back"]["mean"])
        add_field(output, "SweptVolume", swept)
        if bounds is not None:
            add_field(output, "HausdorffLower", bounds["lower"])
            add_field(output, "HausdorffUpper", bounds["upper"])
        self.progress(1.0)
        return output

    def _hausdorff(self, before: Mesh, after: Mesh) -> dict[str, Any]:
        self.progress(0.7, "bounding the distance")
        there = farthest(after, ClosestPoint(before))
        self.progress(0.8, "bounding the distance back")
        back = farthest(before, ClosestPoint(after))
        return {
            "lower": max(there.lower, back.lower),
            "upper": max(there.upper, back.upper),
            "there": there._asdict(),
            "back": back._asdict(),
        }


def deviation_figures(there: np.ndarray, back: np.ndarray, diagonal: float) -> dict[str, Any]:
    """Return the largest and the mean of distances, and of those back; `diagonal` is the original's."""

    def figures(distances: np.ndarray) -> dict[str, Any]:
        largest = float(distances.max(initial=0.0))
        mean = float(distances.mean()) if len(distances) else 0.0
        per = 1.0 / diagonal if diagonal > 0 else 0.0
        return {"max": largest, "mean": mean, "max_relative": per * largest, "mean_relative": per * mean}

    return figures(there) | {"back": figures(back)}


def _statistics(values: np.ndarray) -> dict[str, float]:
    largest, mean = comparison.largest_and_mean(values)
    return {"max": largest, "mean": mean}


def _check_same_topology(after: Mesh, before: Mesh) -> None:
    if after.n_points != before.n_points or after.n_faces != before.n_faces:
        raise InvalidMeshError(
            f"The meshes must have the same points and faces; the result has {after.n_points} points and "
            f"{after.n_faces} faces, the original {before.n_points} and {before.n_faces}."
        )
    if not (
        np.array_equal(after.offsets, before.offsets)
        and np.array_equal(after.connectivity, before.connectivity)
    ):
        raise InvalidMeshError(
            "The meshes have equally many points and faces, but the faces join other points."
        )
