"""FeatureDetection: arrays, lines and figures of the filter, in VTK, PyVista and on the command line."""

from __future__ import annotations

import json
import math

import meshes
import numpy as np
import pytest
import pyvista as pv
from vtkmodules.vtkCommonDataModel import vtkMultiBlockDataSet

from vtksmooth import FeatureDetection, ParameterError
from vtksmooth.cli import main
from vtksmooth.files import read_surface, write_surface
from vtksmooth.kernels.features.detection import detect as find_features
from vtksmooth.kernels.mesh import adjacency


def detect(mesh, **parameters):
    detection = FeatureDetection(**parameters)
    result, lines = detection(meshes.polydata(mesh))
    return detection, pv.wrap(result), pv.wrap(lines)


def test_cube():
    mesh = meshes.cube(3)
    detection, result, lines = detect(mesh)
    found = find_features(mesh, adjacency.build(mesh))
    np.testing.assert_array_equal(result["FeatureClass"], found.classes)
    np.testing.assert_array_equal(result["RidgeNeighbours"], found.ridge_ring)
    assert result["FeatureClass"].dtype == np.uint8
    assert result["RidgeNeighbours"].dtype == np.int32
    assert lines.n_cells == lines.n_lines == 12
    np.testing.assert_allclose(lines["Length"], 3.0)
    assert (lines["LineClass"] == 0).all()
    np.testing.assert_array_equal(mesh.points[lines["PointIds"]], lines.points)
    np.testing.assert_array_equal(found.classes[lines["PointIds"]], lines["FeatureClass"])
    assert detection.summary == {
        "vertices": {"smooth": 24, "ridge": 24, "corner": 8, "cusp": 0},
        "lines": {"ridge": 12, "boundary": 0, "non_manifold": 0},
        "length": {"ridge": pytest.approx(36.0), "boundary": 0.0, "non_manifold": 0.0},
        "ridge_angle": 20.0,
        "corner_angle": 35.0,
    }
    assert list(result.field_data["FeatureVertices"]) == [24, 24, 8, 0]


def test_lines_are_told_apart():
    detection, _, lines = detect(meshes.non_manifold_edge())
    kinds = lines["LineClass"]
    assert set(kinds) == {1, 2}
    assert (kinds == 2).sum() == 1
    assert lines["Length"][kinds == 2] == pytest.approx(4.0)
    assert detection.summary["length"]["non_manifold"] == pytest.approx(4.0)


def test_a_round_line_has_the_length_of_its_polygon():
    _, _, lines = detect(meshes.torus(24, 4, "quads"))
    radii = np.linalg.norm(lines.points[:, :2], axis=1)
    for i, length in enumerate(lines["Length"]):
        points = lines.get_cell(i).point_ids
        assert points[0] == points[-1]
        assert length == pytest.approx(48 * radii[points[0]] * math.sin(math.pi / 24))


def test_nothing_there():
    detection, result, lines = detect(meshes.icosphere(3))
    assert lines.n_points == lines.n_cells == 0
    assert not result["FeatureClass"].any()
    assert detection.summary["length"]["ridge"] == 0.0


def test_eigenvalue_ratios():
    _, result, _ = detect(meshes.cube(4), eigenvalue_ratios=True)
    on_planes = ((result.points == 0) | (result.points == 4)).sum(axis=1)
    expected = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]])[on_planes - 1]
    np.testing.assert_allclose(result["EigenvalueRatios"], expected, atol=1e-14)


@pytest.mark.parametrize("name", meshes.HOSTILE)
def test_hostile_meshes_and_the_input_stays(name):
    source = meshes.polydata(meshes.HOSTILE[name]())
    kept = pv.wrap(source).copy()
    result, _ = FeatureDetection(weight="angle", eigenvalue_ratios=True)(source)
    assert np.isfinite(pv.wrap(result)["EigenvalueRatios"]).all()
    assert pv.wrap(source).array_names == []
    np.testing.assert_array_equal(pv.wrap(source).points, kept.points)


def test_composite_data():
    blocks = vtkMultiBlockDataSet()
    blocks.SetBlock(0, meshes.polydata(meshes.cube(2)))
    blocks.SetBlock(1, meshes.polydata(meshes.icosphere(2)))
    result, lines = FeatureDetection(ridge_angle=30)(blocks)
    assert pv.wrap(result.GetBlock(0))["FeatureClass"].max() == 2
    assert lines.GetBlock(0).GetNumberOfLines() == 12
    assert lines.GetBlock(1).GetNumberOfLines() == 0


def test_accessor():
    cube = pv.wrap(meshes.polydata(meshes.cube(2)))
    alone = cube.vtksmooth.feature_detection()
    assert isinstance(alone, pv.PolyData)
    mesh, lines = cube.vtksmooth.feature_detection(return_lines=True)
    np.testing.assert_array_equal(mesh["FeatureClass"], alone["FeatureClass"])
    assert lines.n_lines == 12


@pytest.fixture
def cube(tmp_path):
    write_surface(meshes.polydata(meshes.cube(2)), tmp_path / "cube.vtp")
    return tmp_path / "cube.vtp"


def test_command(cube, tmp_path, capsys):
    out, lines = tmp_path / "out.vtp", tmp_path / "lines.vtp"
    assert (
        main(["features", str(cube), str(out), "--lines", str(lines), "--ridge-angle", "auto", "--json"]) == 0
    )
    summary = json.loads(capsys.readouterr().out)
    assert summary["vertices"] == {"smooth": 6, "ridge": 12, "corner": 8, "cusp": 0}
    assert summary["lines"]["ridge"] == 12
    assert (np.bincount(read_surface(out)[0]["FeatureClass"]) == [6, 12, 8]).all()
    assert pv.read(lines).n_lines == 12
    assert main(["features", str(cube), str(out)]) == 0
    assert "corner: 8" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("lines", "said"),
    [("lines.off", "with lines"), ("out.vtp", "a file for each"), ("no/lines.vtp", "no folder")],
)
def test_lines_that_cannot_be_written_are_refused_before_the_work(lines, said, cube, tmp_path, capsys):
    out = tmp_path / "out.vtp"
    assert main(["features", str(cube), str(out), "--lines", str(tmp_path / lines)]) == 1
    assert said in capsys.readouterr().err
    assert not out.exists()


@pytest.mark.parametrize("angle", ["-1", "181", "nan", "sharp"])
def test_angles_out_of_range(angle, cube, tmp_path, capsys):
    assert main(["features", str(cube), str(tmp_path / "out.vtp"), "--ridge-angle", angle]) == 2
    assert "from 0 to 180 deg, or auto" in capsys.readouterr().err


def test_auto_is_a_value():
    detection = FeatureDetection(ridge_angle=40)
    detection.SetRidgeAngle("auto")
    assert detection.ridge_angle == "auto"
    with pytest.raises(ParameterError, match="auto"):
        detection.corner_angle = "much"


@pytest.mark.parametrize("sides", [24, 36, 60, 100])
@pytest.mark.parametrize("triangulated", [False, True])
def test_the_facets_of_a_coarse_cylinder_are_no_noise(sides, triangulated):
    cylinder = pv.Cylinder(resolution=sides).clean()
    if triangulated:
        cylinder = cylinder.triangulate()
    detection = FeatureDetection()
    _, lines = detection(cylinder)
    assert detection.summary["vertices"]["ridge"] == 2 * sides
    assert lines.GetNumberOfLines() == 2
