"""Ways along edges: against Bellman and Ford's relaxation, and by what a shortest way is."""

import itertools

import meshes
import numpy as np
import pytest
import reference
from hypothesis import given
from hypothesis import strategies as st

from vtksmooth.kernels.mesh.paths import edge_distances, shortest_path
from vtksmooth.kernels.mesh.regions import rings_of

EVERY = {**meshes.USUAL, **meshes.HOSTILE}


def relaxed(mesh, sources):
    """Lengths of shortest ways, by relaxing all edges until nothing changes."""
    a, b = np.array([(v, w) for v, ring in enumerate(reference.one_rings(mesh)) for w in ring]).T
    length = np.linalg.norm(mesh.points[b] - mesh.points[a], axis=1)
    away = np.full(mesh.n_points, np.inf)
    away[sources] = 0.0
    before = None
    while before is None or (away != before).any():
        before = away.copy()
        np.minimum.at(away, b, before[a] + length)
    return away


@pytest.mark.parametrize("name", EVERY)
def test_distances_as_by_relaxation(name):
    mesh = EVERY[name]()
    sources = [0, mesh.n_points // 2]
    found, expected = edge_distances(mesh.points, rings_of(mesh), sources), relaxed(mesh, sources)
    np.testing.assert_allclose(found, expected, rtol=1e-12)
    limit = float(np.median(expected[np.isfinite(expected)]))
    near = edge_distances(mesh.points, rings_of(mesh), sources, limit)
    np.testing.assert_array_equal(near, np.where(found <= limit, found, np.inf))


@given(st.integers(0, 10_000))
def test_a_path_goes_along_edges_and_is_as_long_as_the_distance(seed):
    mesh = meshes.torus(12, 8, "triangles", jitter=0.2, seed=seed)
    start, end = np.random.default_rng(seed).choice(mesh.n_points, 2, replace=False).tolist()
    rings = reference.one_rings(mesh)
    path = shortest_path(mesh.points, rings_of(mesh), start, end).tolist()
    assert (path[0], path[-1]) == (start, end)
    assert all(b in rings[a] for a, b in itertools.pairwise(path))
    length = np.linalg.norm(np.diff(mesh.points[path], axis=0), axis=1).sum()
    assert length == pytest.approx(edge_distances(mesh.points, rings_of(mesh), [start])[end], rel=1e-12)


def test_no_way_and_the_shortest_of_all():
    mesh = meshes.two_components()
    labels = relaxed(mesh, [0])
    other = int(np.flatnonzero(np.isinf(labels))[0])
    assert len(shortest_path(mesh.points, rings_of(mesh), 0, other)) == 0
    assert shortest_path(mesh.points, rings_of(mesh), 0, 0).tolist() == [0]


def test_the_numbers_of_the_points_decide_between_equal_ways():
    mesh = meshes.sheet(1, 1, "quads")
    assert shortest_path(mesh.points, rings_of(mesh), 0, 3).tolist() == [0, 1, 3]
    assert shortest_path(mesh.points, rings_of(mesh), 3, 0).tolist() == [3, 1, 0]
