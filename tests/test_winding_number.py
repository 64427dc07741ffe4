"""Winding numbers, against shapes whose inside is known, and the sum of solid angles."""

import meshes
import numpy as np
import pytest

from vtksmooth.kernels.distance.winding_number import WindingNumber


def triangles(mesh):
    return mesh.connectivity.reshape(-1, 3)


def solid_angles(points, faces, query):
    """The winding number by A. van Oosterom, J. Strackee (1983), equation 8."""
    a, b, c = (points[faces[:, corner]] - query for corner in range(3))
    la, lb, lc = (np.linalg.norm(spoke, axis=1) for spoke in (a, b, c))
    box = (a * np.cross(b, c)).sum(axis=1)
    rest = la * lb * lc + (a * b).sum(axis=1) * lc + (b * c).sum(axis=1) * la + (c * a).sum(axis=1) * lb
    return np.arctan2(box, rest).sum() / (2 * np.pi)


def test_a_torus_and_its_hole():
    torus = meshes.torus(40, 24)
    random = np.random.default_rng(0)
    low, high = torus.points.min(axis=0), torus.points.max(axis=0)
    radius = 0.5 * (high[2] - low[2])
    ring = 0.5 * (high[0] - low[0]) - radius
    points = random.uniform(low, high, (20_000, 3))
    middle = np.hypot(np.hypot(points[:, 0], points[:, 1]) - ring, points[:, 2])
    clear = abs(middle - radius) > 0.1 * radius  # not between the torus and its facets
    found = WindingNumber(torus.points, triangles(torus))(points)
    np.testing.assert_array_equal(found[clear], middle[clear] < radius)


@pytest.mark.parametrize("seed", range(5))
def test_crumpled_surfaces(seed):
    random = np.random.default_rng(seed)
    mesh = meshes.icosphere(1)
    points = np.round(mesh.points + random.normal(size=mesh.points.shape), 1)  # many in one plane
    faces = triangles(mesh)
    queries = np.vstack([random.normal(size=(300, 3)), np.round(random.normal(size=(300, 3)), 1) + 0.05])
    found = WindingNumber(points, faces)(queries)
    expected = [solid_angles(points, faces, query) for query in queries]
    np.testing.assert_allclose(found, expected, atol=1e-6)
    assert len(np.unique(found)) > 3


def test_rays_through_edges_and_corners_count_once():
    # A fine lattice of cells: all about are edges and corners in line.
    cells = np.argwhere(np.random.default_rng(0).random((6, 6, 6)) < 0.5)
    mesh = meshes.voxels(cells, triangles=True)
    found = WindingNumber(mesh.points, triangles(mesh))(np.array(list(np.ndindex(6, 6, 6))) + 0.5)
    assert found.sum() == len(cells)
    assert set(found) == {0, 1}


def test_a_cavity_is_outside():
    cube = meshes.cube(2, triangles=True)
    hollow = np.vstack([3.0 * cube.points, cube.points + cube.points.mean(axis=0) * 2.0])
    both = np.vstack([triangles(cube), triangles(cube)[:, ::-1] + len(cube.points)])
    winding = WindingNumber(hollow, both)
    assert winding([3.0 * cube.points.mean(axis=0), [0.1, 0.1, 0.1], [-0.1, 0.1, 0.1]]).tolist() == [0, 1, 0]
