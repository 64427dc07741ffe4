import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vtksmooth.errors import InvalidMeshError
from vtksmooth.kernels.measures.fitting import fit_cylinder, fit_sphere


def turned(seed):
    """A rotation."""
    q, r = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    q *= np.sign(np.diag(r))
    return q if np.linalg.det(q) > 0 else -q


def on_sphere(random, count, cap):
    """Points of the unit sphere around +z, as far from there as `cap` (in z)."""
    z, turn = random.uniform(cap, 1.0, count), random.uniform(0, 2 * np.pi, count)
    ring = np.sqrt(1.0 - z * z)
    return np.column_stack((ring * np.cos(turn), ring * np.sin(turn), z))


def on_cylinder(random, count, arc, height):
    """Points of the cylinder of radius 1 about z."""
    turn, z = random.uniform(0, arc, count), random.uniform(0, height, count)
    return np.column_stack((np.cos(turn), np.sin(turn), z))


poses = st.tuples(st.integers(0, 10**6), st.floats(-6, 6), st.integers(-1000, 1000))


@given(poses, st.sampled_from([-1.0, 0.0, 0.8, 0.95]))
@settings(max_examples=30)
def test_points_of_a_sphere_give_that_sphere(pose, cap):
    seed, exponent, shift = pose
    random = np.random.default_rng(seed)
    scale = 10.0**exponent
    points = scale * (on_sphere(random, 200, cap) @ turned(seed) + shift)
    sphere = fit_sphere(points)
    assert sphere.radius == pytest.approx(scale, rel=1e-7)
    np.testing.assert_allclose(sphere.centre, np.full(3, scale * shift), atol=1e-7 * scale)
    assert sphere.largest < 1e-9 * scale


@given(poses, st.sampled_from([(2 * np.pi, 5.0), (2 * np.pi, 0.05), (1.0, 3.0), (0.6, 0.5)]))
@settings(max_examples=30)
def test_points_of_a_cylinder_give_that_cylinder(pose, part):
    seed, exponent, shift = pose
    random = np.random.default_rng(seed)
    scale, turn = 10.0**exponent, turned(seed)
    points = scale * (on_cylinder(random, 200, *part) @ turn + shift)
    cylinder = fit_cylinder(points)
    assert cylinder.radius == pytest.approx(scale, rel=1e-6)
    assert abs(cylinder.axis @ turn[2]) == pytest.approx(1.0, abs=1e-12)
    assert np.linalg.norm(cylinder.axis) == pytest.approx(1.0, abs=1e-14)
    assert cylinder.axis[np.argmax(np.abs(cylinder.axis))] > 0
    away = cylinder.centre - np.full(3, scale * shift)
    assert np.linalg.norm(away - (away @ turn[2]) * turn[2]) < 1e-6 * scale
    assert cylinder.largest < 1e-9 * scale


@pytest.mark.parametrize("fit", [fit_sphere, fit_cylinder])
def test_of_noisy_points_no_surface_nearby_is_closer(fit):
    random = np.random.default_rng(3)
    points = on_cylinder(random, 300, 2.0, 2.0) if fit is fit_cylinder else on_sphere(random, 300, 0.5)
    points += random.normal(scale=0.02, size=points.shape)
    found = fit(points)

    def rms(centre, axis, radius):
        away = points - centre
        away = away - np.outer(away @ axis, axis)
        return np.sqrt(((np.linalg.norm(away, axis=1) - radius) ** 2).mean())

    axis = found.axis if fit is fit_cylinder else np.zeros(3)
    least = rms(found.centre, axis, found.radius)
    assert least == pytest.approx(found.rms, rel=1e-9)
    for _ in range(200):
        other = axis + 1e-3 * random.normal(size=3) if fit is fit_cylinder else axis
        length = np.linalg.norm(other) or 1.0
        moved = found.centre + 1e-3 * random.normal(size=3)
        assert rms(moved, other / length, found.radius + 1e-3 * random.normal()) >= least


def test_all_points_count_not_only_those_that_choose_the_axis():
    random = np.random.default_rng(0)
    points = on_cylinder(random, 5001, 6.0, 1.0)
    points[1::3] *= (1.2, 1.2, 1.0)
    assert fit_cylinder(points).radius == pytest.approx(1.0 + 0.2 / 3, rel=1e-2)


@pytest.mark.parametrize("fit", [fit_sphere, fit_cylinder])
@pytest.mark.parametrize(
    ("points", "message"),
    [
        (np.eye(3), "at least"),
        (np.repeat(np.eye(3), 5, axis=0), "at least"),
        (np.random.default_rng(0).normal(size=(20, 3)) * (1, 1, 0) + 3, "in a plane"),
        (np.random.default_rng(0).normal(size=(20, 3)) * (1, 0, 0), "in a plane"),
        (np.full((9, 3), np.nan), "not finite"),
    ],
)
def test_what_nothing_can_be_fitted_to_says_so(fit, points, message):
    with pytest.raises(InvalidMeshError, match=message):
        fit(points)
