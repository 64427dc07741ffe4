"""The usual measures: closed forms, and PyVista's own call of Verdict."""

import json

import numpy as np
import pytest
import pyvista as pv

from vtksmooth import SurfaceQuality
from vtksmooth.cli import main
from vtksmooth.filters.usual_measures import USUAL_MEASURES


def measured(points, *faces):
    mesh = pv.PolyData(np.asarray(points, float), np.concatenate([[len(face), *face] for face in faces]))
    result = pv.wrap(SurfaceQuality()(mesh))
    return {name: result.cell_data[name] for name in USUAL_MEASURES}


def triangle(height):
    return [[-0.5, 0, 0], [0.5, 0, 0], [0, height, 0]]


@pytest.mark.parametrize("size", [1e-30, 1e-9, 1.0, 1e20])
def test_closed_forms_of_triangles(size):
    equilateral = measured(size * np.array(triangle(np.sqrt(0.75))), [0, 1, 2])
    for name, best in zip(USUAL_MEASURES, (60.0, 60.0, 1.0, 1.0, 0.0, 1.0), strict=True):
        assert equilateral[name] == pytest.approx(best, abs=1e-7)
    right = measured(size * np.array([[0, 0, 0], [3, 0, 0], [0, 4, 0]]), [0, 1, 2])
    least = np.degrees(np.arctan2(3, 4))
    # Of the triangle 3, 4, 5 the radii are 2.5 and 1; of an equilateral one, 2 and 1.
    expected = (least, 90.0, 5 / 3, 1.25, (60.0 - least) / 60.0, np.sin(np.radians(least)) / np.sqrt(0.75))
    for name, value in zip(USUAL_MEASURES, expected, strict=True):
        assert right[name] == pytest.approx(value, rel=1e-12)


def test_closed_forms_of_quadrilaterals():
    square = measured([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [0, 1, 2, 3])
    for name, best in zip(USUAL_MEASURES, (90.0, 90.0, 1.0, 1.0, 0.0, 1.0), strict=True):
        assert square[name] == pytest.approx(best, abs=1e-7)
    angle = np.radians(50.0)
    x, y = np.cos(angle), np.sin(angle)
    rhombus = measured([[0, 0, 0], [1, 0, 0], [1 + x, y, 0], [x, y, 0]], [0, 1, 2, 3])
    expected = {"MinAngle": 50.0, "MaxAngle": 130.0, "EdgeRatio": 1.0, "Skewness": 4 / 9, "ScaledJacobian": y}
    for name, value in expected.items():
        assert rhombus[name] == pytest.approx(value, rel=1e-12)
    concave = measured([[0, 0, 0], [1, 0, 0], [0.2, 0.2, 0], [0, 1, 0]], [0, 1, 2, 3])
    assert concave["ScaledJacobian"] < 0


def test_faces_that_verdict_does_not_know_and_degenerate_ones():
    points = [[0, 0, 0], [1, 0, 0], [2, 1, 0], [1, 2, 0], [0, 1, 0], [3, 0, 0]]
    found = measured(points, [0, 1, 2, 3, 4], [0, 1, 5])
    assert all(np.isnan(values[0]) for values in found.values())
    assert found["RadiusRatio"][1] == np.inf
    assert found["MinAngle"][1] == pytest.approx(0.0)


def test_all_agree_with_pyvista_on_strips_too():
    cells = pv.Sphere(theta_resolution=9, phi_resolution=7) + pv.Plane(i_resolution=3, j_resolution=2)
    cells.points = cells.points.astype(float) + 0.03 * np.random.default_rng(1).normal(
        size=cells.points.shape
    )
    result = pv.wrap(SurfaceQuality()(cells))
    keys = [USUAL_MEASURES[name].key for name in ("MinAngle", "MaxAngle", "RadiusRatio", "ScaledJacobian")]
    expected = cells.cell_quality(keys)
    for name in ("MinAngle", "MaxAngle", "RadiusRatio", "ScaledJacobian"):
        values = expected.cell_data[USUAL_MEASURES[name].key]
        np.testing.assert_allclose(result.cell_data[name], values, rtol=1e-9, atol=1e-9)
    best = np.where([cells.get_cell(i).n_points == 3 for i in range(cells.n_cells)], 60.0, 90.0)
    low, high = result.cell_data["MinAngle"], result.cell_data["MaxAngle"]
    skewness = np.maximum((best - low) / best, (high - best) / (180.0 - best))
    np.testing.assert_allclose(result.cell_data["Skewness"], skewness, atol=1e-9)
    for number in range(cells.n_cells):
        corners = cells.get_cell(number).points
        edges = np.linalg.norm(np.roll(corners, 1, axis=0) - corners, axis=1)
        assert result.cell_data["EdgeRatio"][number] == pytest.approx(edges.max() / edges.min(), rel=1e-9)
    strips = pv.Plane(i_resolution=5, j_resolution=4).triangulate()
    strips.points[:, 2] = np.random.default_rng(2).random(strips.n_points)
    faces = pv.wrap(SurfaceQuality()(strips))
    stripped = strips.strip(pass_cell_ids=True)
    of_strips = pv.wrap(SurfaceQuality()(stripped))
    for name, measure in USUAL_MEASURES.items():
        worst = min if measure.low_is_bad else max
        assert worst(of_strips.cell_data[name]) == worst(faces.cell_data[name])
        assert of_strips.n_cells < faces.n_cells


def test_the_command_tells_them(tmp_path, capsys):
    path = tmp_path / "mesh.ply"
    pv.Sphere().save(path)
    assert main(["quality", str(path), "--quiet"]) == 0
    assert "radius ratio" in capsys.readouterr().out
    assert main(["quality", str(path), "--quiet", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)["usual_measures"]
    of_cells = pv.wrap(SurfaceQuality()(pv.read(path))).cell_data["MinAngle"]
    assert told["min_angle"]["min"] == of_cells.min()
    assert list(told) == [measure.key for measure in USUAL_MEASURES.values()]
    assert main(["quality", str(path), "--quiet", "--no-usual-measures"]) == 0
    assert "radius ratio" not in capsys.readouterr().out
