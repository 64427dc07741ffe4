"""FeatureDetection: ridges, corners and cusps."""

from __future__ import annotations

from typing import Any

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkPolyData

from ..kernels.features import detection, metric_tensor
from ..kernels.features.edits import edited
from ..kernels.mesh import adjacency
from ..kernels.mesh.mesh import Mesh
from .arrays import cells_of, output_like, points_of, surface_of, vtk_array, vtk_cells, vtk_points
from .base import Filter, add_field
from .parameter import Parameter
from .places import HIDDEN, Joined, Merge
from .smoothing import FEATURE_CLASS, RIDGE_NEIGHBOURS, SmoothingFilter, edge_arrays_of, edits_of

#: What the lines of the second output are, by LineClass.
LINE_CLASSES = ("ridge", "boundary", "non_manifold")


class FeatureDetection(Filter):
    """Find the vertices on ridges, at corners and at cusps, and the ridge lines (Jiao, section 4).

    Adds to the mesh the point arrays ``FeatureClass`` (uint8: 0 smooth, 1 ridge, 2 corner, 3 cusp) and
    ``RidgeNeighbours`` (int32, two components: the neighbours along the ridge, -1 where there is none). The
    second output, ``lines``, holds the ridge lines as polylines from corner to corner or round closed
    loops, with the cell arrays ``LineClass`` (uint8: 0 ridge, 1 boundary, 2 non-manifold) and ``Length``,
    and the point arrays ``PointIds`` (the points' numbers in the mesh) and ``FeatureClass``. Boundary and
    non-manifold edges are ridges. Edges that the field arrays ``AddedFeatureEdges`` and
    ``RemovedFeatureEdges`` name, as pairs of points, are or are no ridges, whatever their angle: lines
    given by hand. Smoothing filters can hold these features or slide along them.

    Guarantees
    ----------
    The result does not depend on the number of threads; turning, moving and scaling the mesh change it
    only where an angle equals a threshold to rounding. On clean polyhedra with ridges above the ridge
    angle every vertex gets its class, every edge is found, and none is found that is not there.

    Not guaranteed: that noise is told from features as small as the noise.

    Attributes
    ----------
    summary : dict
        ``vertices`` of each class, ``lines`` and their ``length`` by what they are (model units), and the
        ``ridge_angle`` and ``corner_angle`` used (degrees); also in the output's field data.

    Examples
    --------
    >>> from vtkmodules.vtkFiltersSources import vtkCylinderSource
    >>> from vtkmodules.vtkFiltersCore import vtkCleanPolyData
    >>> from vtksmooth import FeatureDetection
    >>> cylinder, merged = vtkCylinderSource(resolution=36), vtkCleanPolyData()
    >>> merged.SetInputConnection(cylinder.GetOutputPort())
    >>> _ = merged.Update()
    >>> detection = FeatureDetection()
    >>> mesh, lines = detection(merged.GetOutput())
    >>> lines.GetNumberOfLines(), detection.summary["vertices"]["ridge"]
    (2, 72)
    """

    command = "features"
    outputs = ("mesh", "lines")
    clean = True
    #: Ghost cells are seen, so that classes on the boundary between pieces are the same in each.
    skipped = HIDDEN

    method = Parameter(
        "robust",
        "robust: filtered normals, thresholds that rise with noise; paper: Jiao's detection as printed.",
        choices=detection.METHODS,
    )
    ridge_angle = Parameter(
        detection.AUTO, "Dihedral angle above which an edge is a ridge; auto: 20, or more amid noise.",
        low=0.0, high=180.0, unit="deg", automatic=True, type=float,
    )  # fmt: skip
    corner_angle = Parameter(
        detection.AUTO,
        "Turning angle above which a tip is a corner, on boundaries their own; auto: 35, or more amid noise.",
        low=0.0, high=180.0, unit="deg", automatic=True, type=float,
    )  # fmt: skip
    added_edges = SmoothingFilter.added_edges.always()
    removed_edges = SmoothingFilter.removed_edges.always()
    weight = Parameter(
        "area",
        "What weighs a face at a vertex: its area, or its angle (better on badly graded meshes).",
        choices=metric_tensor.WEIGHTS,
    )
    denoise = Parameter(
        True, "Filter the faces' normals first, as far as the mesh's own noise asks.",
        only={"method": ("robust",)},
    )  # fmt: skip
    eigenvalue_ratios = Parameter(
        False,
        "Add EigenvalueRatios: second and third over first eigenvalue of each metric tensor, unfiltered.",
    )

    def merges(self) -> dict[str, Merge]:
        """Return that the neighbours on ridges are numbers of points."""
        return {RIDGE_NEIGHBOURS: Merge("neighbours", None, 2)}

    def edge_arrays(self) -> list[str]:
        """Return the arrays of edges added and removed by hand."""
        return edge_arrays_of(self)

    def spread(self, results: tuple[Any, ...], whole: Joined) -> list[tuple[Any, ...]]:
        """Return each block with the lines that have most of their points in it."""
        mesh, lines = results
        return list(zip(whole.spread(mesh, True), _lines_of_blocks(lines, whole), strict=True))

    def execute(self, *inputs: Any) -> tuple[vtkPolyData, vtkPolyData]:
        """Find the features of one polydata."""
        (source,) = inputs
        self.progress(0.0, "building neighbourhoods")
        mesh = surface_of(source).mesh
        near = adjacency.build(mesh)
        self.progress(0.2, "finding features")
        found = detection.detect(
            mesh, near,
            ridge_angle=self.ridge_angle, corner_angle=self.corner_angle,
            weight=self.weight, denoise=self.denoise, method=self.method,
        )  # fmt: skip
        edits = edits_of(self, source)
        if edits is not None:
            found = edited(found, mesh, near, *edits)
        self.progress(0.8, "joining lines")
        output = output_like(source)
        data = output.GetPointData()
        data.AddArray(vtk_array(found.classes, FEATURE_CLASS))
        data.AddArray(vtk_array(found.ridge_ring, RIDGE_NEIGHBOURS))
        if self.eigenvalue_ratios:
            values = metric_tensor.eigen_systems(mesh, near, self.weight)[0]
            first = np.where(values[:, :1] > 0.0, values[:, :1], 1.0)
            data.AddArray(vtk_array(values[:, 1:] / first, "EigenvalueRatios"))
        counted = np.ones(mesh.n_points, np.bool_)
        if self.whole is not None:
            # What only ghost cells have is the next piece's.
            counted = self.whole.counted_places
            mine = counted[found.ridge_edges].all(axis=1)
            found = found._replace(ridge_edges=found.ridge_edges[mine], edge_kinds=found.edge_kinds[mine])
        lines, kinds, lengths = _lines(mesh, found, points_of(source))
        counts = np.bincount(found.classes[counted], minlength=4).tolist()
        self.summary = {
            "vertices": dict(zip(("smooth", "ridge", "corner", "cusp"), counts, strict=True)),
            "lines": {name: int((kinds == i).sum()) for i, name in enumerate(LINE_CLASSES)},
            "length": {name: float(lengths[kinds == i].sum()) for i, name in enumerate(LINE_CLASSES)},
            "ridge_angle": found.ridge_angle,
            "corner_angle": found.corner_angle,
        }
        add_field(output, "FeatureVertices", counts)
        add_field(output, "FeatureLines", list(self.summary["lines"].values()))
        add_field(output, "FeatureLengths", list(self.summary["length"].values()))
        add_field(output, "RidgeAngle", found.ridge_angle)
        add_field(output, "CornerAngle", found.corner_angle)
        self.progress(1.0)
        return output, lines


def _lines(mesh: Mesh, found: detection.Features, points: np.ndarray) -> tuple[vtkPolyData, Any, Any]:
    """Return the ridge lines as polydata, their kinds and their lengths."""
    offsets, along, kinds = detection.lines(found)
    ids, places = np.unique(along, return_inverse=True)
    steps = np.linalg.norm(np.diff(mesh.points[along], axis=0), axis=1)
    steps[offsets[1:-1] - 1] = 0.0  # from one line to the next
    lengths = np.add.reduceat(steps, offsets[:-1]) if len(kinds) else np.empty(0)
    lines = vtkPolyData()
    lines.SetPoints(vtk_points(points[ids]))
    lines.SetLines(vtk_cells(offsets, places))
    lines.GetPointData().AddArray(vtk_array(ids.astype(np.int64), "PointIds"))
    lines.GetPointData().AddArray(vtk_array(found.classes[ids], FEATURE_CLASS))
    lines.GetCellData().AddArray(vtk_array(kinds, "LineClass"))
    lines.GetCellData().AddArray(vtk_array(lengths, "Length"))
    return lines, kinds, lengths


def _lines_of_blocks(lines: vtkPolyData, whole: Joined) -> list[vtkPolyData]:
    """Return for each block the lines that have more of their points in it than in those before it."""
    offsets, corners = cells_of(lines.GetLines())
    places = vtk_to_numpy(lines.GetPointData().GetArray("PointIds"))
    ids = [whole.points_in(number, places) for number in range(len(whole.blocks))]
    inside = np.array([np.add.reduceat((known >= 0)[corners], offsets[:-1]) for known in ids])
    home = inside.argmax(axis=0) if len(offsets) > 1 else np.empty(0, np.int64)
    outputs = []
    for number, known in enumerate(ids):
        mine = np.flatnonzero(home == number)
        sizes = np.diff(offsets)[mine]
        rows = np.repeat(offsets[mine] - np.cumsum(sizes) + sizes, sizes) + np.arange(sizes.sum())
        used, along = np.unique(corners[rows], return_inverse=True)
        output = vtkPolyData()
        output.SetPoints(vtk_points(points_of(lines)[used]))
        output.SetLines(vtk_cells(np.concatenate(([0], np.cumsum(sizes))), along))
        output.GetPointData().AddArray(vtk_array(known[used], "PointIds"))
        for data, new, chosen in (
            (lines.GetPointData(), output.GetPointData(), used),
            (lines.GetCellData(), output.GetCellData(), mine),
        ):
            for i in range(data.GetNumberOfArrays()):
                if (name := data.GetArrayName(i)) != "PointIds":
                    new.AddArray(vtk_array(vtk_to_numpy(data.GetArray(i))[chosen], name))
        outputs.append(output)
    return outputs
