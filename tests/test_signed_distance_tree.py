"""The compiled tree: VTK's signed distances, signs included, at faces, edges and vertices."""

import meshes
import numpy as np
import pytest

from vtksmooth.filters.signed_distance import SignedDistance
from vtksmooth.kernels.distance.signed_distance import SignedDistanceTree


def spiky(points=60, seed=0):
    """A closed star with deep, sharp folds: every kind of edge and vertex, saddles too."""
    mesh = meshes.icosphere(2)
    radius = np.random.default_rng(seed).uniform(0.4, 1.6, mesh.n_points)
    return mesh.with_points(mesh.points * radius[:, None])


SPACES = {
    "cube": lambda: meshes.cube(2),
    "concave": lambda: meshes.voxels([c for c in np.ndindex(2, 2, 2) if c != (1, 1, 1)]),
    "two cells at an edge": lambda: meshes.voxels([(0, 0, 0), (1, 1, 0)]),
    "two cells at a corner": lambda: meshes.voxels([(0, 0, 0), (1, 1, 1)]),
    "torus": lambda: meshes.torus(16, 9, "quads", jitter=0.2),
    "sphere": lambda: meshes.icosphere(2),
    "spikes": spiky,
    "thin": lambda: spiky().with_points(spiky().points * [1, 1, 1e-3]),
    "open": lambda: meshes.tube(),
    "far away": lambda: meshes.cube(2).with_points(meshes.cube(2).points + 1e4),
}


@pytest.mark.parametrize("name", SPACES)
def test_like_vtk(name):
    vtk = SignedDistance(meshes.polydata(SPACES[name]()))
    tree = SignedDistanceTree(vtk.mesh)
    random = np.random.default_rng(1)
    low, high = vtk.mesh.points.min(axis=0), vtk.mesh.points.max(axis=0)
    size = (high - low).max()
    corners = vtk.mesh.points[vtk.mesh.connectivity].reshape(-1, 3, 3)
    weights = random.dirichlet([1, 1, 1], len(corners))
    on_faces = np.einsum("tc,tcx->tx", weights, corners)
    on_edges = 0.3 * corners[:, 0] + 0.7 * corners[:, 1]
    directions = random.normal(size=(20, *on_faces.shape))
    directions /= np.linalg.norm(directions, axis=-1, keepdims=True)
    points = np.vstack(
        [random.uniform(low - 0.5 * size, high + 0.5 * size, (3000, 3))]
        + [
            (place + size * step * directions[:, : len(place)]).reshape(-1, 3)
            for place in (on_faces, on_edges, corners[:, 0])
            for step in (1e-6, 1e-2)
        ]
    )
    expected, found = vtk(points), tree(points)
    np.testing.assert_allclose(np.abs(found), np.abs(expected), atol=1e-12 * max(size, np.abs(high).max()))
    far = np.abs(expected) > 1e-10 * size
    np.testing.assert_array_equal(np.sign(found[far]), np.sign(expected[far]))


@pytest.mark.parametrize("seed", range(3))
def test_cells_that_touch_anyhow(seed):
    # Half of the cells of a block: edges of four faces and corners of many kinds everywhere.
    cells = np.random.default_rng(seed).random((5, 5, 5)) < 0.5
    space = SignedDistance(meshes.polydata(meshes.voxels(np.argwhere(cells))))
    assert space.closed
    points = np.random.default_rng(9).uniform(-1, 6, (10_000, 3))

    def nearest(lows):
        beyond = np.maximum(lows - points[:, None], points[:, None] - lows - 1)
        return np.linalg.norm(np.maximum(beyond, 0), axis=2).min(axis=1)

    outside = nearest(np.argwhere(cells))
    expected = np.where(outside > 0, outside, -nearest(np.argwhere(~np.pad(cells, 2)) - 2))
    np.testing.assert_allclose(space(points), expected, atol=1e-12)
    np.testing.assert_allclose(SignedDistanceTree(space.mesh)(points), expected, atol=1e-12)


def test_points_on_the_surface_have_no_distance():
    mesh = meshes.torus(12, 8)
    np.testing.assert_allclose(SignedDistanceTree(mesh)(mesh.points), 0, atol=1e-15)


def test_threads_do_not_matter():
    from vtksmooth.jit.parallel import set_number_of_threads

    tree = SignedDistanceTree(meshes.torus(12, 8))
    points = np.random.default_rng(0).normal(size=(20_000, 3)) * 3
    results = []
    for threads in (1, 3):
        set_number_of_threads(threads)
        results.append(tree(points))
    set_number_of_threads(0)
    np.testing.assert_array_equal(*results)
    assert tree(np.empty((0, 3))).shape == (0,)
