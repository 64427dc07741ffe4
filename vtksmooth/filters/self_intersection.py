"""SelfIntersection: faces of a mesh that cross or touch others."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from vtkmodules.vtkCommonDataModel import vtkPolyData

from ..kernels.containment.self_intersection import CROSSING, TOUCHING, SelfIntersections
from ..kernels.mesh.mesh import Mesh
from .arrays import output_like, surface_of, vtk_array
from .base import Filter, add_field
from .places import Joined

SELF_INTERSECTION = "SelfIntersection"

#: The field arrays of pairs of cells.
_PAIRS = {CROSSING: "CrossingCells", TOUCHING: "TouchingCells"}


class SelfIntersection(Filter):
    """Find the faces of a mesh that cross or touch each other.

    Adds the cell array ``SelfIntersection`` (uint8): 2 for faces that cross another one, 1 for those that
    only touch one, 0 for all others. Adds the field arrays ``CrossingCells`` and ``TouchingCells`` (int64,
    two components): the numbers of the cells of each pair. Two faces cross if their interiors share a point,
    in one plane too: faces that cover each other cross. They touch if they share points beyond their common
    vertices and edges, but none of the interiors. Quadrilaterals count as two triangles, cut along
    the shorter diagonal inside, larger polygons as triangles by clipping ears; triangles of one polygon are
    not compared.

    Guarantees
    ----------
    The result is exact for the coordinates as they are (other than 0 and above 1e-90 of the largest): signs
    that rounding leaves open are computed in exact arithmetic. There is no tolerance. The number of threads
    does not matter.

    Not guaranteed: anything about faces without area. They are counted, and belong to no pair.

    Attributes
    ----------
    summary : dict
        ``crossing_pairs``, ``touching_pairs``, ``crossing_faces``, ``touching_faces`` (those that cross no
        face) and ``degenerate_triangles`` (without area, not tested), the metrics of
        ``vtksmooth self-intersection --json``; also in field data. In data of several blocks the pairs in
        field data are those within the block; the metrics are those of the whole.

    Examples
    --------
    >>> from vtkmodules.vtkFiltersCore import vtkAppendPolyData
    >>> from vtkmodules.vtkFiltersSources import vtkCubeSource
    >>> from vtksmooth import SelfIntersection
    >>> cube, bar = vtkCubeSource(), vtkCubeSource(x_length=0.5, y_length=0.5, z_length=1.5)
    >>> both = vtkAppendPolyData()
    >>> both.AddInputConnection(cube.GetOutputPort())
    >>> both.AddInputConnection(bar.GetOutputPort())
    >>> _ = both.Update()
    >>> check = SelfIntersection()
    >>> result = check(both.GetOutput())
    >>> check.summary["crossing_pairs"], check.summary["crossing_faces"]
    (8, 6)
    """

    command = "self-intersection"
    measures = True

    def spread(self, results: tuple[Any, ...], whole: Joined) -> list[tuple[Any, ...]]:
        """Return the blocks, each with the pairs of its own cells."""
        outputs = super().spread(results, whole)
        pairs, levels = self._found
        block, cells = whole.block_of_faces, whole.cell_of_faces
        for number, (output,) in enumerate(outputs):
            mine = (block[pairs] == number).all(axis=1)
            _add_pairs(output, cells[pairs[mine]], levels[mine])
        return outputs

    def execute(self, *inputs: Any) -> vtkPolyData:
        """Measure one polydata."""
        (source,) = inputs
        self.progress(0.0, "looking for self-intersections")
        surface = surface_of(source)
        pairs, levels, degenerate = SelfIntersections(surface.mesh).find(surface.mesh.points)
        self.progress(0.9)
        self._found = pairs, levels
        of_faces = _levels_of_faces(surface.mesh, pairs, levels)
        self.summary = _counts(of_faces, levels, degenerate)
        output = output_like(source)
        of_cells = np.zeros(surface.n_cells, np.uint8)
        np.maximum.at(of_cells, surface.cells, of_faces)  # a strip is several faces
        output.GetCellData().AddArray(vtk_array(of_cells, SELF_INTERSECTION))
        _add_pairs(output, surface.cells[pairs], levels)
        for key, value in self.summary.items():
            add_field(output, key.title().replace("_", ""), value)
        self.progress(1.0)
        return output


def self_intersections_of(mesh: Mesh) -> dict[str, int]:
    """Return how many faces of a mesh cross or touch others, as the summary of SelfIntersection has it."""
    pairs, levels, degenerate = SelfIntersections(mesh).find(mesh.points)
    return _counts(_levels_of_faces(mesh, pairs, levels), levels, degenerate)


def _levels_of_faces(
    mesh: Mesh, pairs: npt.NDArray[np.int32], levels: npt.NDArray[np.uint8]
) -> npt.NDArray[np.uint8]:
    of_faces = np.zeros(mesh.n_faces, np.uint8)
    np.maximum.at(of_faces, pairs, levels[:, None])
    return of_faces


def _counts(
    of_faces: npt.NDArray[np.uint8], levels: npt.NDArray[np.uint8], degenerate: npt.NDArray[np.int32]
) -> dict[str, int]:
    return {
        "crossing_pairs": int((levels == CROSSING).sum()),
        "touching_pairs": int((levels == TOUCHING).sum()),
        "crossing_faces": int((of_faces == CROSSING).sum()),
        "touching_faces": int((of_faces == TOUCHING).sum()),
        "degenerate_triangles": len(degenerate),
    }


def _add_pairs(output: vtkPolyData, pairs: npt.NDArray[np.int64], levels: npt.NDArray[np.uint8]) -> None:
    # A strip is several faces: pairs of these are one pair of cells.
    pairs = np.sort(pairs.reshape(-1, 2), axis=1)
    both, place = np.unique(pairs, axis=0, return_inverse=True)
    of_both = np.zeros(len(both), np.uint8)
    np.maximum.at(of_both, place.ravel(), levels)
    for level, name in _PAIRS.items():
        output.GetFieldData().AddArray(vtk_array(both[of_both == level], name))
