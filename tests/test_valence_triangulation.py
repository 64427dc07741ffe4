"""ValenceTriangulation: data rides along, cells other than polygons pass."""

from __future__ import annotations

import meshes
import numpy as np
import pytest
import pyvista as pv
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkBitArray, vtkStringArray
from vtkmodules.vtkCommonDataModel import vtkCellArray
from vtkmodules.vtkFiltersCore import vtkStripper, vtkTriangleFilter

from vtksmooth import InvalidMeshError, ValenceTriangulation
from vtksmooth.filters.arrays import cells_of, points_of, surface_of
from vtksmooth.kernels.mesh.triangulate import triangulate


def with_data(source):
    for data, size in (
        (source.GetPointData(), source.GetNumberOfPoints()),
        (source.GetCellData(), source.GetNumberOfCells()),
    ):
        for dtype in (np.float32, np.int64):
            array = numpy_to_vtk(np.arange(3 * size, dtype=dtype).reshape(-1, 3), deep=1)
            array.SetName(dtype.__name__)
            data.AddArray(array)
        data.SetActiveVectors("float32")
        text, bits = vtkStringArray(), vtkBitArray()
        text.SetName("text")
        bits.SetName("bits")
        for i in range(size):
            text.InsertNextValue(f"number {i}")
            bits.InsertNextValue(i % 3 == 0)
        data.AddArray(text)
        data.AddArray(bits)
    return source


def test_like_the_kernel_and_data_rides_along():
    mesh = meshes.sheet(8, 6, "mixed", bump=1.0)
    source = with_data(meshes.polydata(mesh))
    triangulation = ValenceTriangulation()
    result = triangulation(source)
    triangles, cell = triangulate(mesh)
    offsets, corners = cells_of(result.GetPolys())
    np.testing.assert_array_equal(corners.reshape(-1, 3), triangles)
    np.testing.assert_array_equal(np.diff(offsets), 3)
    assert np.shares_memory(points_of(result), points_of(source))
    assert result.GetPointData().GetNumberOfArrays() == source.GetPointData().GetNumberOfArrays()
    old, new = source.GetCellData(), result.GetCellData()
    original = vtk_to_numpy(new.GetArray("OriginalCell"))
    assert original.dtype == np.int64
    np.testing.assert_array_equal(original, cell)
    for name in ("float32", "int64"):
        np.testing.assert_array_equal(
            vtk_to_numpy(new.GetArray(name)), vtk_to_numpy(old.GetArray(name))[cell]
        )
    assert new.GetVectors().GetName() == "float32"
    for i, f in enumerate(cell.tolist()):
        assert new.GetAbstractArray("text").GetValue(i) == f"number {f}"
        assert new.GetArray("bits").GetValue(i) == (f % 3 == 0)
    assert triangulation.summary == {
        "polygons": int((mesh.face_sizes > 3).sum()),
        "triangles": len(triangles),
    }
    # The source is as it was.
    assert old.GetArray("OriginalCell") is None
    assert source.GetNumberOfCells() == mesh.n_faces


def test_verts_lines_and_strips():
    source = meshes.polydata(meshes.cube(2))
    triangles, stripper = vtkTriangleFilter(), vtkStripper()
    triangles.SetInputData(source)
    stripper.SetInputConnection(triangles.GetOutputPort())
    stripper.Update()
    mixed = stripper.GetOutput()
    assert mixed.GetNumberOfStrips() > 0
    verts, lines, quad = vtkCellArray(), vtkCellArray(), vtkCellArray()
    verts.InsertNextCell(1, [0])
    lines.InsertNextCell(2, [0, 1])
    quad.InsertNextCell(4, cells_of(source.GetPolys())[1][:4].tolist())
    mixed.SetVerts(verts)
    mixed.SetLines(lines)
    mixed.SetPolys(quad)
    mixed = with_data(mixed)
    result = ValenceTriangulation()(mixed)
    assert result.GetNumberOfVerts() == result.GetNumberOfLines() == 1
    assert result.GetNumberOfStrips() == 0
    assert result.GetNumberOfPolys() == surface_of(mixed).mesh.n_faces + 1
    original = vtk_to_numpy(result.GetCellData().GetArray("OriginalCell"))
    assert original[:4].tolist() == [0, 1, 2, 2]
    values = vtk_to_numpy(result.GetCellData().GetArray("int64"))[:, 0]
    np.testing.assert_array_equal(values, 3 * original)
    # Twice is once.
    again = ValenceTriangulation()(result)
    np.testing.assert_array_equal(cells_of(again.GetPolys())[1], cells_of(result.GetPolys())[1])


def test_single_precision_and_read_only_arrays_stay():
    mesh = meshes.torus(12, 8, "quads", jitter=0.1)
    source = meshes.polydata(mesh.with_points(mesh.points))
    source.GetPoints().SetData(numpy_to_vtk(mesh.points.astype(np.float32), deep=1))
    assert points_of(ValenceTriangulation()(source)).dtype == np.float32


@pytest.mark.parametrize("name", ["folded_quads"])
def test_what_cannot_be_triangulated_is_said(name):
    with pytest.raises(InvalidMeshError, match="cross themselves"):
        ValenceTriangulation()(meshes.polydata(meshes.HOSTILE[name]()))


def test_faces_that_are_left_out_are_said():
    flat, one_place = pv.Cube().triangulate(), pv.Plane(i_resolution=2, j_resolution=2)
    one_place.points[:] = 1.0
    triangulation = ValenceTriangulation()
    result = triangulation(pv.MultiBlock([flat, one_place]))
    assert [block.n_cells for block in pv.wrap(result)] == [12, 0]
    assert "4 of 16 faces have fewer than three corners in different places; they are left out." in (
        triangulation.notes
    )
