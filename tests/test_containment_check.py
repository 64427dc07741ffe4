"""ContainmentCheck: what is outside is counted, and nothing else."""

from __future__ import annotations

import json

import meshes
import numpy as np
import pytest
import pyvista as pv
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkMultiBlockDataSet, vtkPolyData, vtkTable

from vtksmooth import ContainmentCheck, InstallationSpaceRegions, InstallationSpaceSmoothing, InvalidMeshError
from vtksmooth.cli import main
from vtksmooth.files import write_surface
from vtksmooth.filters.signed_distance import SignedDistance
from vtksmooth.kernels.mesh.mesh import Mesh

NOTHING = {"vertices_outside": 0, "max_outside": 0.0, "triangles_crossing": 0}


def check(mesh, space, **parameters):
    containment = ContainmentCheck(**parameters)
    result = containment(meshes.polydata(mesh), meshes.polydata(space))
    return containment.summary, vtk_to_numpy(result.GetPointData().GetArray("SignedDistance"))


def moved(mesh, *shift):
    return mesh.with_points(mesh.points + np.array(shift))


def test_inside_and_touching():
    cube, space = meshes.cube(2), meshes.cube(4)
    for shift in (0.0, 1.0, 0.5):
        summary, distances = check(moved(cube, shift, 1, 1), space)
        assert summary == NOTHING
        assert distances.max() == pytest.approx(-shift if shift < 1 else -1.0)
    assert check(space, space)[0] == NOTHING


def test_partly_outside():
    # A block that comes out of one side by a quarter: its outer corners, and the triangles between.
    cube, space = meshes.cube(2), meshes.cube(4)
    summary, distances = check(moved(cube, 2.25, 1, 1), space)
    assert summary["vertices_outside"] == (distances > 0).sum() == 9
    assert summary["max_outside"] == 0.25
    # The side faces of the outer layer, four sides of two squares each, cross.
    assert summary["triangles_crossing"] == 4 * 2 * 2


def test_what_vertices_do_not_see():
    # All vertices lie inside, but an inner corner of the space pierces the long triangle.
    points = [[0.2, 1.9, 0.5], [1.9, 0.2, 0.5], [0.2, 0.2, 0.5]]
    summary, _ = check(Mesh.from_faces(points, [[0, 1, 2]]), meshes.l_shape())
    assert summary == NOTHING | {"triangles_crossing": 1}


def test_a_mesh_outside_altogether_crosses_nothing():
    mesh = meshes.cube(1)
    summary, _ = check(moved(mesh, 1.2, 1.2, 0), meshes.l_shape())
    assert summary["vertices_outside"] == 8
    assert summary["triangles_crossing"] == 0


@pytest.mark.parametrize("scale", [1e-6, 1e6])
@pytest.mark.parametrize("shift", [0.0, 300.0])
def test_single_precision_is_not_outside(scale, shift):
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    space = meshes.torus(16, 9, "quads", jitter=0.1)
    space = space.with_points(scale * (space.points @ turn + shift))
    rounded = pv.PolyData(meshes.polydata(space))
    rounded.points = rounded.points.astype(np.float32)
    containment = ContainmentCheck()
    containment(rounded, meshes.polydata(space))
    assert containment.summary["vertices_outside"] == 0
    assert containment.summary["triangles_crossing"] == 0


def test_points_that_no_face_uses_do_not_count():
    mesh = meshes.isolated_points()
    space = meshes.cube(5)
    summary, distances = check(mesh, space.with_points(space.points - [0, 0, 2]))
    assert summary == NOTHING
    np.testing.assert_array_equal(np.isnan(distances), ~np.isfinite(mesh.points).all(axis=1))


def test_polygons_count_as_triangles():
    arrow = [[0.5, 0.5, 1], [3.5, 0.5, 1], [1, 1, 1], [0.5, 3.5, 1]]
    # The concave side of the arrow goes round the column that is not part of the space.
    space = meshes.voxels([c for c in np.ndindex(4, 4, 2) if c[:2] != (2, 2) and c[:2] != (1, 1)])
    space = space.with_points(space.points + np.array([0.3, 0.3, 0.0]))
    for first in range(4):
        polygon = Mesh.from_faces(np.array(arrow) - [0.1, 0.1, 0], [np.roll(range(4), first)])
        assert check(polygon, space)[0] == NOTHING
    assert check(Mesh.from_faces(polygon.points, [[0, 1, 3]]), space)[0]["triangles_crossing"] == 1


def test_blocks_have_one_space():
    blocks = vtkMultiBlockDataSet()
    blocks.SetBlock(0, meshes.polydata(meshes.cube(1)))
    cube = meshes.cube(1)
    blocks.SetBlock(1, meshes.polydata(moved(cube, 1.5, 0, 0)))
    result = ContainmentCheck()(blocks, meshes.polydata(meshes.cube(2)))
    counts = [result.GetBlock(i).GetFieldData().GetArray("VerticesOutside").GetValue(0) for i in (0, 1)]
    assert counts == [0, 4]


def test_command_prints_exactly_the_contract_and_succeeds(tmp_path, capsys):
    cube, space = meshes.cube(2), meshes.cube(4)
    write_surface(meshes.polydata(moved(cube, 2.25, 1, 1)), tmp_path / "sim.vtp")
    write_surface(meshes.polydata(space), tmp_path / "inst.vtp")
    paths = [str(tmp_path / "sim.vtp"), str(tmp_path / "inst.vtp")]
    assert main(["containment", *paths, "--json"]) == 0
    out, err = capsys.readouterr()
    assert json.loads(out) == {"vertices_outside": 9, "max_outside": 0.25, "triangles_crossing": 16}
    assert "note" not in err
    assert main(["containment", *paths]) == 0
    assert "9" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("mesh", "space", "message"),
    [
        (meshes.polydata(meshes.cube(1)), vtkPolyData(), "installation space is no usable surface"),
        (vtkPolyData(), meshes.polydata(meshes.cube(1)), "empty"),
        (meshes.polydata(meshes.folded_quads()), meshes.polydata(meshes.cube(9)), "cross themselves"),
        (
            meshes.polydata(meshes.cube(1).with_points(1e3 * meshes.cube(1).points)),
            meshes.polydata(meshes.cube(1)),
            "check their units",
        ),
    ],
)
def test_bad_input(mesh, space, message):
    with pytest.raises(InvalidMeshError, match=message):
        ContainmentCheck()(mesh, space)


def test_a_wrong_sign_is_found_and_mended(monkeypatch):
    # VTK's pseudonormals err at slivers of real parts, one vertex in 46,410 of a cooler.
    cube, space = meshes.cube(2), meshes.cube(4)
    honest = SignedDistance.__call__

    def wrong(self, points, *rest):
        distances = honest(self, points, *rest)
        distances[3::5] *= -1.0
        return distances

    for shift in (0.5, 2.25):
        mesh = moved(cube, shift, 1, 1)
        expected, distances = check(mesh, space)
        with monkeypatch.context() as patch:
            patch.setattr(SignedDistance, "__call__", wrong)
            summary, mended = check(mesh, space)
        assert summary == expected
        np.testing.assert_array_equal(mended, distances)


def on_a_lattice(mesh, shift=0.0):
    """Round to multiples of 2^-20, so that all can be moved far without rounding."""
    return mesh.with_points(np.round(2.0**20 * (mesh.points + shift)) / 2**20)


@pytest.mark.parametrize("by", [(725_000_001.0, -3.0e6, 858_000_003.5), (0.25, 0.0, 1e6)])
def test_where_the_meshes_are_does_not_matter(by):
    # The faces of the spaces cross. By coordinates relative to 0, far off some winding numbers are wrong.
    random = np.random.default_rng(3)
    box, part = meshes.cube(2, triangles=True), on_a_lattice(meshes.cube(3), 0.2)
    part = part.with_points(0.5 * part.points)
    for _ in range(10):
        space = on_a_lattice(box, 0.3 * random.normal(size=box.points.shape))
        here, there = check(part, space), check(moved(part, *by), moved(space, *by))
        assert here[0] == there[0]
        np.testing.assert_array_equal(here[1], there[1])


@pytest.mark.parametrize("scale", [2.0**230, 2.0**-230])
def test_sizes_do_not_matter(scale):
    # Fifth powers of such lengths are out of the range of float64.
    space, part = meshes.torus(16, 9, "quads", jitter=0.1), meshes.torus(12, 7, jitter=0.2, seed=1)
    for around in (space, meshes.joined(space, moved(space, 0.5, 0.1, 0.2))):
        usual, distances = check(part, around)
        summary, large = check(*(mesh.with_points(scale * mesh.points) for mesh in (part, around)))
        np.testing.assert_array_equal(large, scale * distances)
        assert summary == usual | {"max_outside": scale * usual["max_outside"]}


def test_the_summary_counts_as_the_array_does():
    # As they come from vtkCubeSource: three points at each corner.
    part, space = pv.Cube(x_length=0.5, y_length=0.5, z_length=1.5, clean=False), pv.Cube()
    assert part.n_points == 24
    blocks = vtkMultiBlockDataSet()
    for number, block in enumerate((part, part.translate((0.1, 0, 0.5), inplace=False))):
        blocks.SetBlock(number, block)
    for mesh in (part, blocks):
        containment = ContainmentCheck()
        result = pv.wrap(containment(mesh, space))
        smoothing = InstallationSpaceSmoothing(iterations=1, containment="none", fixed=None)
        smoothing(mesh, space)
        pieces = [result] if mesh is part else list(result)
        outside = [int((piece["SignedDistance"] > 1e-5).sum()) for piece in pieces]
        assert outside == ([24] if mesh is part else [24, 12])
        assert containment.summary["vertices_outside"] == smoothing.report.outside[0] == sum(outside)
        assert [int(piece.field_data["VerticesOutside"][0]) for piece in pieces] == outside
        regions = InstallationSpaceRegions()
        pieces = [regions(mesh, space)] if mesh is part else list(pv.wrap(regions(mesh, space)))
        marked = sum(int(pv.wrap(piece)["Fixed"].sum()) for piece in pieces)
        assert regions.summary["fixed"] == smoothing.report.fixed == marked
        assert regions.summary["fixed"] + regions.summary["free"] == 24 * len(pieces)


def test_points_of_no_face_do_not_count():
    # One that is far off made all distances as good as none.
    stray = [[1e300, 0, 0], [0, -1e20, 0]]
    part, space = (
        mesh.with_points(np.vstack((mesh.points, stray)))
        for mesh in (moved(meshes.cube(2), 2.25, 1, 1), meshes.cube(4))
    )
    summary, distances = check(part, space)
    assert (summary["vertices_outside"], summary["max_outside"]) == (9, 0.25)
    assert np.isnan(distances[-2])
    assert distances[-1] > 0.9e20


@pytest.mark.filterwarnings("error")
def test_spaces_without_a_surface_are_refused_by_name():
    part, nothing = meshes.polydata(meshes.cube()), vtkPolyData()
    nothing.SetPoints(part.GetPoints())
    faces = vtkCellArray()
    faces.InsertNextCell(0)
    nothing.SetPolys(faces)
    blocks = vtkMultiBlockDataSet()
    blocks.SetBlock(0, vtkPolyData())
    table = vtkMultiBlockDataSet()
    table.SetBlock(0, vtkTable())
    for space in (nothing, blocks, table):
        with pytest.raises(InvalidMeshError, match="installation space"):
            ContainmentCheck()(part, space)
