"""ValenceTriangulation: polygons into triangles with valences near six."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkCellData, vtkPolyData

from ..kernels.triangulate import triangulate
from .arrays import surface_of, vtk_array, vtk_triangles
from .base import Filter, output_like

ORIGINAL_CELL = "OriginalCell"


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
        output.GetCellData().ShallowCopy(_rows_of(source.GetCellData(), original))
        output.GetCellData().AddArray(vtk_array(original, ORIGINAL_CELL))
        self.summary = {
            "polygons": int((surface.mesh.face_sizes > 3).sum()),
            "triangles": len(triangles),
        }
        self.progress(1.0)
        return output


def _rows_of(data: Any, rows: npt.NDArray[np.int64]) -> vtkCellData:
    """Return new cell data with the given rows of `data`."""
    result = vtkCellData()
    result.CopyAllOn()
    result.CopyAllocate(data, len(rows))
    for i in range(data.GetNumberOfArrays()):
        old = data.GetAbstractArray(i)
        new = result.GetAbstractArray(old.GetName()) if old.GetName() else result.GetAbstractArray(i)
        new.SetNumberOfTuples(len(rows))
        if old.IsNumeric() and not old.IsA("vtkBitArray"):
            vtk_to_numpy(new)[:] = vtk_to_numpy(old)[rows]
        else:
            for to, row in enumerate(rows.tolist()):
                new.SetTuple(to, row, old)
    return result
