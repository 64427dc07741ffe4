"""Lids over holes."""

import meshes
import numpy as np
import pytest

from vtksmooth.kernels.mesh.hole_filling import lid, rims


def circle(n, height=0.0):
    angle = 2 * np.pi * np.arange(n) / n
    return np.column_stack([np.cos(angle), np.sin(angle), height * np.cos(2 * angle)])


def areas(points, triangles):
    a, b, c = (points[triangles[:, corner]] for corner in range(3))
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)


def directed(triangles):
    return [(triangle[i], triangle[(i + 1) % 3]) for triangle in triangles.tolist() for i in range(3)]


@pytest.mark.parametrize("n", [3, 4, 7, 60, 400, 401, 3000])
def test_lids_fit_their_rim_and_lie_flat(n):
    points = circle(n)
    triangles = lid(points, np.arange(n, dtype=np.int32))
    assert len(triangles) == n - 2
    sides = directed(triangles)
    assert len(set(sides)) == len(sides)
    free = {(a, b) for a, b in sides if (b, a) not in set(sides)}
    assert free == {(i, (i + 1) % n) for i in range(n)}
    assert areas(points, triangles).sum() == pytest.approx(0.5 * n * np.sin(2 * np.pi / n), rel=1e-12)


def test_no_lid_has_less_area():
    points = np.random.default_rng(0).normal(size=(7, 3))

    def least(rim):
        if len(rim) < 3:
            return 0.0
        first, last = rim[0], rim[-1]
        return min(
            areas(points, np.array([[first, rim[m], last]]))[0] + least(rim[: m + 1]) + least(rim[m:])
            for m in range(1, len(rim) - 1)
        )

    found = areas(points, lid(points, np.arange(7, dtype=np.int32))).sum()
    assert found == pytest.approx(least(list(range(7))), rel=1e-6)


def test_a_concave_rim_is_not_overshot():
    points = np.array(
        [[0.0, 0, 0], [3, 0, 0], [3, 3, 0], [2, 3, 0], [2, 1, 0], [1, 1, 0], [1, 3, 0], [0, 3, 0]]
    )
    triangles = lid(points, np.arange(8, dtype=np.int32))
    a, b, c = (points[triangles[:, corner], :2] for corner in range(3))
    assert (np.linalg.det(np.stack([b - a, c - a], axis=1)) > 0).all()
    assert areas(points, triangles).sum() == pytest.approx(7)


def test_rims_pass_each_point_once():
    # An eight, and a triangle.
    boundaries = np.array([[0, 1], [1, 2], [2, 0], [0, 3], [3, 4], [4, 0], [7, 8], [8, 9], [9, 7]])
    found = rims(boundaries[np.random.default_rng(0).permutation(len(boundaries))])
    assert sorted(sorted(rim.tolist()) for rim in found) == [[0, 1, 2], [0, 3, 4], [7, 8, 9]]
    sides = {(rim[i - 1], rim[i]) for rim in found for i in range(len(rim))}
    assert sides == set(map(tuple, boundaries.tolist()))


def test_rims_of_a_tube():
    from vtksmooth.filters.signed_distance import SignedDistance

    assert SignedDistance(meshes.polydata(meshes.tube())).mesh.n_faces == 4 * 4 * 2 + 4
