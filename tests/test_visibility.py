"""Points on the screen: projected by VTK's own camera, and counted one by one."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from vtkmodules.vtkCommonCore import vtkMath
from vtkmodules.vtkRenderingCore import vtkCamera

from vtksmooth.kernels.distance.visibility import add_stroke, inside_outline, project, seen


def camera(parallel):
    made = vtkCamera()
    made.SetPosition(3.0, -4.0, 2.0)
    made.SetFocalPoint(0.1, 0.2, -0.3)
    made.SetViewUp(0.0, 0.0, 1.0)
    made.SetClippingRange(1.0, 12.0)
    made.SetParallelProjection(parallel)
    return made


@pytest.mark.parametrize("parallel", [False, True])
def test_places_are_those_of_the_camera(parallel):
    view = camera(parallel)
    matrix = view.GetCompositeProjectionTransformMatrix(1.5, 0.0, 1.0)
    rows = [[matrix.GetElement(i, j) for j in range(4)] for i in range(4)]
    points = np.random.default_rng(0).normal(size=(50, 3))
    places = project(points, rows, (10, 20, 300, 200))
    for point, place in zip(points, places, strict=True):
        x, y, z, w = matrix.MultiplyPoint((*point, 1.0))
        expected = [10 + 150 * (x / w + 1), 20 + 100 * (y / w + 1), z / w]
        np.testing.assert_allclose(place[:3], expected, rtol=1e-5, atol=1e-3)
        # Three pixels nearer to the eye, at the distance of this point.
        away = np.array(view.GetDirectionOfProjection())
        pixel = (
            2.0
            / 200
            * (
                view.GetParallelScale()
                if parallel
                else np.tan(np.radians(view.GetViewAngle() / 2)) * (away @ (point - view.GetPosition()))
            )
        )
        _, _, z, w = matrix.MultiplyPoint((*(point - 3 * pixel * away), 1.0))
        np.testing.assert_allclose(place[3], z / w, rtol=1e-5)
    middle = project(np.array([view.GetFocalPoint()]), rows, (10, 20, 300, 200))[0]
    np.testing.assert_allclose(middle[:2], [160, 120], atol=1e-3)
    assert vtkMath.IsFinite(float(middle[2]))


def test_what_is_behind_the_eye_is_nowhere():
    matrix = camera(False).GetCompositeProjectionTransformMatrix(1.0, 0.0, 1.0)
    rows = [[matrix.GetElement(i, j) for j in range(4)] for i in range(4)]
    places = project(np.array([[6.0, -9.0, 4.5]]), rows, (0, 0, 100, 100))
    assert np.isnan(places).all()
    assert not seen(places, np.ones((100, 100), np.float32)).any()


def test_what_is_behind_a_wall_is_not_seen():
    depths = np.ones((10, 20), np.float32)
    depths[:, :10] = 0.5  # a wall on the left
    flat = np.array(
        [[4.5, 5.5, 0.5], [4.5, 5.5, 0.4], [4.5, 5.5, 0.6], [15.5, 5.5, 0.6], [-1, 5, 0.2], [5, 10, 0.2]],
        np.float32,
    )
    places = np.column_stack((flat, flat[:, 2]))
    assert seen(places, depths).tolist() == [True, True, False, True, False, False]


@given(st.integers(0, 10_000))
def test_a_stroke_marks_what_is_within_its_radius(seed):
    random = np.random.default_rng(seed)
    places = np.column_stack((random.uniform(0, 100, (200, 2)), np.zeros(200))).astype(np.float32)
    allowed = random.random(200) < 0.7
    (a, b), radius = random.uniform(0, 100, (2, 2)), float(random.uniform(1, 40))
    steps = a + np.linspace(0, 1, 4001)[:, None] * (b - a)
    away = np.linalg.norm(places[:, None, :2] - steps, axis=2).min(axis=1)
    found = random.random(200) < 0.1
    before = found.copy()
    new = add_stroke(places, allowed, tuple(a), tuple(b), radius, found)
    clear = np.abs(away - radius) > 0.05
    np.testing.assert_array_equal(found[clear], (before | (allowed & (away < radius)))[clear])
    assert new == found.sum() - before.sum()


def test_a_dot_is_a_disc():
    places = np.array([[5, 5, 0], [8, 5, 0], [9, 5, 0], [np.nan, np.nan, np.nan]], np.float32)
    found = np.zeros(4, bool)
    assert add_stroke(places, np.ones(4, bool), (5, 5), (5, 5), 3, found) == 2
    assert found.tolist() == [True, True, False, False]


def test_an_outline_is_even_odd():
    x, y = np.meshgrid(np.arange(0.5, 10), np.arange(0.5, 10))
    places = np.column_stack((x.ravel(), y.ravel(), np.zeros(100))).astype(np.float32)
    allowed = np.ones(100, bool)
    square = [[1, 1], [9, 1], [9, 9], [1, 9]]
    inside = (np.abs(places[:, :2] - 5) < 4).all(axis=1)
    np.testing.assert_array_equal(inside_outline(places, allowed, square), inside)
    np.testing.assert_array_equal(inside_outline(places, allowed, square[::-1]), inside)
    # Round a square twice, the second time smaller: what is between both is inside.
    ring = [[1, 1], [9, 1], [9, 9], [1, 9], [1, 1], [3, 3], [3, 7], [7, 7], [7, 3], [3, 3]]
    hole = (np.abs(places[:, :2] - 5) < 2).all(axis=1)
    np.testing.assert_array_equal(inside_outline(places, allowed, ring), inside & ~hole)
    assert not inside_outline(places, ~allowed, square).any()
    assert not inside_outline(places, allowed, square[:2]).any()
