"""Comparing two layers: distances against geometry, and in the window."""

import shutil

import numpy as np
import pytest
import pyvista as pv

model = pytest.importorskip("vtksmooth_gui.model")
from vtksmooth.filters import LaplacianSmoothing  # noqa: E402
from vtksmooth_gui.model.difference import PERCENTILES, difference  # noqa: E402
from vtksmooth_gui.model.state import State  # noqa: E402


def test_the_same_faces_are_compared_point_by_point():
    mesh = pv.Sphere()
    away = np.random.default_rng(0).normal(size=mesh.points.shape).astype(np.float32)
    moved = mesh.copy()
    moved.points = mesh.points + away
    distances, _, summary = difference(State(moved), State(mesh))
    expected = np.linalg.norm(moved.points.astype(float) - mesh.points.astype(float), axis=1)
    np.testing.assert_array_equal(distances, expected)
    assert summary["point_by_point"]
    assert summary["back"] is None
    assert summary["mean"] == pytest.approx(expected.mean())
    assert summary["rms"] == pytest.approx(np.sqrt((expected**2).mean()))
    assert summary["max"] == expected.max()
    order = np.sort(expected)
    for share in PERCENTILES:
        assert order[int(share / 100 * len(order)) - 2] <= summary["percentiles"][share]
        assert summary["percentiles"][share] <= order[min(int(share / 100 * len(order)) + 2, len(order) - 1)]


def test_other_faces_are_compared_by_the_distance_to_the_surface():
    low = pv.Plane(i_resolution=3, j_resolution=3)
    high = pv.Plane(center=(0, 0, 0.25), i_resolution=8, j_resolution=5).triangulate()
    distances, signed, summary = difference(State(low), State(high))
    np.testing.assert_allclose(distances, 0.25, rtol=1e-6)
    assert signed is None  # a plane encloses nothing
    assert not summary["point_by_point"]
    assert summary["back"] == pytest.approx(0.25)
    # Half as large: its points are near, those of the other are not.
    small = pv.Plane(i_size=0.5, j_size=0.5)
    _, _, summary = difference(State(small), State(low))
    assert summary["max"] == pytest.approx(0.0, abs=1e-7)
    assert summary["back"] == pytest.approx(np.sqrt(2) / 4)


def test_a_closed_mesh_tells_inside_from_outside():
    inner, outer = (
        State(pv.Sphere(radius=1.0)),
        State(pv.Cube(x_length=4, y_length=4, z_length=4).triangulate()),
    )
    distances, signed, _ = difference(inner, outer)
    expected = 2.0 - np.abs(inner.points.astype(float)).max(axis=1)
    np.testing.assert_allclose(distances, expected, atol=1e-6)
    np.testing.assert_allclose(signed, -expected, atol=1e-6)
    assert (difference(outer, inner)[1] > 0.7).all()


def test_points_that_no_face_uses_do_not_count():
    mesh = pv.Plane(i_resolution=2, j_resolution=2)
    lone = pv.PolyData(np.vstack((mesh.points, [[99, 99, 99]])), faces=mesh.faces)
    distances, _, summary = difference(State(lone), State(pv.Plane(i_resolution=3, j_resolution=1)))
    assert np.isnan(distances[-1])
    assert summary["max"] == pytest.approx(0.0, abs=1e-7)


# -- in the window -------------------------------------------------------------------------------------


def rows(user):
    return {row.name: (row.before, row.after) for row in user.window.numbers.rows}


def choose(user, first, second):
    """Choose two layers in the dialog and confirm."""
    user.do("compare_layers")
    dialog = user.application.comparing.dialog
    assert dialog.isVisible()
    dialog.first.setCurrentText(first)
    dialog.second.setCurrentText(second)
    text = dialog.how.text()
    ok = dialog.buttons.button(dialog.buttons.StandardButton.Ok)
    if ok.isEnabled():
        ok.click()
    else:
        dialog.reject()
    user.wait()
    return text


def test_two_layers_with_the_same_faces(user, ant, tmp_path):
    shutil.copy(ant, tmp_path / "second.ply")
    user.drop(ant, tmp_path / "second.ply")
    user.apply(LaplacianSmoothing, iterations=3)
    user.do("unit_mm")
    assert "point by point" in choose(user, "ant", "second")
    assert user.display.overlay.id == "difference"
    smoothed, other = (layer.state for layer in user.document.layers)
    expected = np.linalg.norm(smoothed.points.astype(float) - other.points.astype(float), axis=1)
    assert np.array_equal(user.display.fields[0].values, expected)
    found = rows(user)
    assert found["other layer"][1] == "point by point"
    assert found["other layer, mean [mm]"] == ("0", f"{expected.mean():.4g}")
    assert found["other layer, RMS [mm]"][1] == f"{np.sqrt((expected**2).mean()):.4g}"
    assert found["other layer, max [mm]"][1] == f"{expected.max():.4g}"
    assert found["other layer, 95 % [mm]"][1] == f"{np.percentile(expected, 95):.4g}"
    assert user.window.colour_bar.title == "Difference to a layer [mm]"
    # The other way round it is shown on the other one.
    choose(user, "second", "ant")
    assert user.document.active is user.document.layers[1]
    assert np.array_equal(user.display.fields[0].values, expected)
    assert "different" in choose(user, "ant", "ant")
    assert user.document.active is user.document.layers[1]


def test_two_layers_with_other_faces(user, tmp_path):
    pv.Sphere(radius=1.0).save(tmp_path / "ball.ply")
    pv.Cube(x_length=4, y_length=4, z_length=4).triangulate().clean().save(tmp_path / "box.ply")
    user.drop(tmp_path / "ball.ply")
    user.do("compare_layers")
    assert "takes two" in user.said
    user.do("overlay_difference")
    assert "Compare Layers" in user.said
    user.drop(tmp_path / "box.ply")
    assert "other surface" in choose(user, "ball", "box")
    points = user.document.layers[0].state.points.astype(float)
    expected = 2.0 - np.abs(points).max(axis=1)
    np.testing.assert_allclose(user.display.fields[0].values, expected, atol=1e-6)
    assert rows(user)["other layer"][1] == "to its surface"
    assert float(rows(user)["other layer, back, max"][1]) == pytest.approx(2 * np.sqrt(3) - 1, abs=0.01)
    user.do("overlay_signed_difference")
    np.testing.assert_allclose(user.display.fields[0].values, -expected, atol=1e-6)


def test_the_sign_needs_a_mesh_that_encloses_something(user, tmp_path):
    pv.Sphere().save(tmp_path / "ball.ply")
    pv.Plane().triangulate().save(tmp_path / "sheet.ply")
    user.drop(tmp_path / "ball.ply", tmp_path / "sheet.ply")
    user.do("overlay_signed_difference")
    assert "encloses a volume" in user.said
    assert user.display.fields == (None, None)
