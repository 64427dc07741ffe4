"""Winding numbers, against shapes whose inside is known."""

import meshes
import numpy as np
import pytest

from vtksmooth.kernels.winding_number import winding_number


def triangles(mesh):
    return mesh.connectivity.reshape(-1, 3)


def test_a_torus_and_its_hole():
    torus = meshes.torus(40, 24)
    random = np.random.default_rng(0)
    low, high = torus.points.min(axis=0), torus.points.max(axis=0)
    radius = 0.5 * (high[2] - low[2])
    ring = 0.5 * (high[0] - low[0]) - radius
    for query in random.uniform(low, high, (200, 3)):
        middle = np.hypot(np.hypot(query[0], query[1]) - ring, query[2])
        if abs(middle - radius) > 0.1 * radius:  # not between the torus and its facets
            expected = float(middle < radius)
            assert winding_number(torus.points, triangles(torus), query) == pytest.approx(expected, abs=1e-9)


def test_a_void_is_outside():
    cube = meshes.cube(2)
    quads = cube.connectivity.reshape(-1, 4)
    faces = np.vstack([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    hollow = np.vstack([3.0 * cube.points, cube.points + cube.points.mean(axis=0) * 2.0])
    both = np.vstack([faces, faces[:, ::-1] + len(cube.points)])
    middle = 3.0 * cube.points.mean(axis=0)
    assert winding_number(hollow, both, middle) == pytest.approx(0.0, abs=1e-12)
    assert winding_number(hollow, both, [0.1, 0.1, 0.1]) == pytest.approx(1.0)
    assert winding_number(hollow, both, [-0.1, 0.1, 0.1]) == pytest.approx(0.0, abs=1e-12)
