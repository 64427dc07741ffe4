"""Pruned distance queries give what asking for every distance gives."""

import numpy as np
import pytest

from vtksmooth.kernels.cached_distance import CachedDistance


def two_balls(points):
    """Two balls that overlap: a concave edge between them."""
    shift = np.array([0.7, 0, 0])
    return np.minimum(*(np.linalg.norm(points + side * shift, axis=1) - 1 for side in (-1, 1)))


@pytest.mark.parametrize("tolerance", [0.0, 0.01])
def test_like_asking_every_time(tolerance):
    random = np.random.default_rng(0)
    points = random.uniform(-1.6, 1.6, (400, 3))
    first = two_balls(points)
    cached = CachedDistance(two_balls, points, tolerance)
    assert cached.outside_at_start == (first > tolerance).sum() > 50
    limits = np.maximum(first, tolerance)
    batches = []
    cached.distance = lambda queries: (batches.append(len(queries)), two_balls(queries))[1]
    for _ in range(60):
        rows = random.permutation(400)[:300]
        proposed = points[rows] + 0.03 * random.normal(size=(300, 3))
        allowed = cached.allowed(rows, proposed)
        np.testing.assert_array_equal(allowed, two_balls(proposed) <= limits[rows])
        points[rows[allowed]] = proposed[allowed]
    assert cached.asked == sum(batches)
    assert cached.asked + cached.saved == 60 * 300
    assert cached.saved > cached.asked
    assert len(batches) <= 60
    # Nothing got worse than it was.
    assert (two_balls(points) <= limits).all()


def test_what_started_outside_may_come_back():
    cached = CachedDistance(two_balls, np.array([[0.0, 0, 2.0]]))
    row = np.array([0])
    assert not cached.allowed(row, np.array([[0.0, 0, 2.1]]))[0]
    assert cached.allowed(row, np.array([[0.0, 0, 1.9]]))[0]


def test_the_points_given_are_not_kept():
    points = np.zeros((1, 3))
    cached = CachedDistance(two_balls, points)
    cached.allowed(np.array([0]), np.array([[0.0, 0.0, 5.0]]))
    assert not points.any()
