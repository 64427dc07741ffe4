"""ValenceTriangulation: polygons into triangles with valences near six."""

from __future__ import annotations

from typing import Any

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData

from ..kernels.mesh.triangulate import triangulate
from .arrays import output_like, rows_of, surface_of, vtk_array, vtk_triangles
from .base import Filter
from .places import ORIGINAL_CELL


class ValenceTriangulation(Filter):
    """Split polygons into triangles so that vertices have about six neighbours.

    Smoothing works evenly where valences are even. All points stay, with their data; the triangles take
    the data of their polygons' cells. Verts and lines pass; faces with fewer than three corners go.
    Adds the cell array ``OriginalCell`` (int64): the number of the cell that each cell was or is part of.
    Source: the installation-space paper, section 4.1.

    Guarantees
    ----------
    Triangles stay as they are. No triangle of a polygon with an area is degenerate or turned against the
    polygon, concave polygons included. The result does not depend on the pose, nor on anything but the
    order of the cells and their corners where choices are equal.

    Not guaranteed: a valence of six. Polygons that cross themselves are refused.

    Attributes
    ----------
    summary : dict
        How many ``polygons`` were split, and how many ``triangles`` there are now.

    Examples
    --------
    >>> from vtkmodules.vtkFiltersSources import vtkPlaneSource
    >>> from vtksmooth import ValenceTriangulation
    >>> plane = vtkPlaneSource(x_resolution=4, y_resolution=4)
    >>> _ = plane.Update()
    >>> ValenceTriangulation()(plane.GetOutput()).GetNumberOfPolys()
    32
    """

    command = "triangulate"
    skipped = 0

    def execute(self, *inputs: Any) -> vtkPolyData:
        """Triangulate one polydata."""
        (source,) = inputs
        self.progress(0.0, "triangulating")
        surface = surface_of(source)
        triangles, cell = triangulate(surface.mesh)
        self.progress(0.8)
        others = source.GetNumberOfVerts() + source.GetNumberOfLines()
        original = np.concatenate((np.arange(others, dtype=np.int64), surface.cells[cell]))
        output = output_like(source)
        output.SetStrips(vtkCellArray())
        output.SetPolys(vtk_triangles(triangles))
        output.GetCellData().ShallowCopy(rows_of(source.GetCellData(), original))
        output.GetCellData().AddArray(vtk_array(original, ORIGINAL_CELL))
        gone = surface.mesh.n_faces - int(np.count_nonzero(np.bincount(cell)))
        if gone:
            self.notes.append(
                f"{gone} of {surface.mesh.n_faces} faces have fewer than three corners in different places; "
                "they are left out."
            )
        self.summary = {
            "polygons": int((surface.mesh.face_sizes > 3).sum()),
            "triangles": len(triangles),
        }
        self.progress(1.0)
        return output
