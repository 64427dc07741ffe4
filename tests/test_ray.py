"""Rays against analytic truths, and a linear system for each face."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vtksmooth.kernels.distance.ray import first_hit
from vtksmooth.kernels.mesh.mesh import Mesh


def cube():
    corners = [[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    return Mesh.from_faces(corners, faces)


@pytest.mark.parametrize(
    ("origin", "direction", "face", "t"),
    [
        ([-2, 0.3, 0.6], [1, 0, 0], 0, 2.0),
        ([3, 0.3, 0.6], [-4, 0, 0], 1, 0.5),
        ([0.2, 0.3, 0.6], [0, 0, 1], 5, 0.4),
        ([0.2, 0.3, 0.6], [0, 0, -1], 4, 0.6),
        ([-2, 0.3, 0.6], [-1, 0, 0], -1, np.inf),
        ([-2, 1.3, 0.6], [1, 0, 0], -1, np.inf),
    ],
)
def test_a_cube_is_met_from_all_sides(origin, direction, face, t):
    found = first_hit(cube(), origin, direction)
    assert found[0] == face
    assert found[1] == pytest.approx(t)


@given(st.integers(0, 10_000))
def test_as_a_linear_system_says(seed):
    generator = np.random.default_rng(seed)
    points = generator.normal(size=(30, 3))
    faces = np.array([generator.choice(30, 3, replace=False) for _ in range(20)])
    origin, direction = generator.normal(size=3), generator.normal(size=3)
    best, nearest = np.inf, -1
    for number, (a, b, c) in enumerate(points[faces]):
        r, s, t = np.linalg.solve(np.column_stack((b - a, c - a, -direction)), origin - a)
        if min(r, s) >= 0 and r + s <= 1 and 0 <= t < best:
            best, nearest = t, number
    face, t = first_hit(Mesh.from_faces(points, faces), origin, direction)
    assert face == nearest
    assert t == pytest.approx(best) or (t, best) == (np.inf, np.inf)


def test_faces_on_many_threads_are_looked_at_all():
    size = 300
    x, y = np.meshgrid(np.arange(size), np.arange(size))
    points = np.column_stack((x.ravel(), y.ravel(), np.zeros(size * size)))
    corner = (np.arange(size - 1)[:, None] * size + np.arange(size - 1)).ravel()
    mesh = Mesh.from_faces(points, np.column_stack((corner, corner + 1, corner + size + 1, corner + size)))
    for face in (0, 12_345, (size - 1) ** 2 - 1):
        place = points[corner[face]] + [0.4, 0.6, 5.0]
        assert first_hit(mesh, place, [0, 0, -1]) == (face, 5.0)
