"""Spaces of several solids, and open ones: one inside, for distances, the check and the smoothing."""

import meshes
import numpy as np
import pytest
from vtkmodules.util.numpy_support import vtk_to_numpy

from vtksmooth import ContainmentCheck, InstallationSpaceSmoothing
from vtksmooth.filters.signed_distance import SignedDistance
from vtksmooth.kernels.mesh.mesh import Mesh


def planes(solid):
    """Return the normals of the faces of a convex solid of triangles, and their distances from the origin."""
    a, b, c = (solid.points[solid.connectivity[corner::3]] for corner in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    return normals, (normals * a).sum(axis=1)


def beyond(solids, points):
    """Return how far points are beyond the farthest plane of the solid they are deepest in."""
    heights = [(points @ normals.T - offsets).max(axis=1) for normals, offsets in map(planes, solids)]
    return np.min(heights, axis=0)


def random_solid(random, on_lattice):
    if on_lattice:
        low = random.integers(0, 4, 3)
        return box(low, low + random.integers(1, 4, 3))
    solid = meshes.cube(1, triangles=True) if random.random() < 0.6 else meshes.icosphere(1)
    turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    points = (solid.points - solid.points.mean(axis=0)) * random.uniform(0.7, 2.5, 3)
    return solid.with_points(points @ turn.T + random.uniform(-1, 1, 3))


def box(low, high):
    solid = meshes.cube(1, triangles=True)
    return solid.with_points(low + solid.points * (np.asarray(high) - low))


def shrunk(solid, share):
    middle = solid.points.mean(axis=0)
    return solid.with_points(middle + share * (solid.points - middle))


def random_solids(seed):
    random = np.random.default_rng(seed)
    solids = [random_solid(random, seed % 2 == 0) for _ in range(random.integers(2, 6))]
    if seed % 3 == 0:
        solids += [shrunk(solids[0], 0.5), solids[1]]  # one within another, and one twice
    return random, solids


@pytest.mark.parametrize("seed", range(24))
def test_a_space_of_solids_that_overlap_anyhow_is_their_union(seed):
    random, solids = random_solids(seed)
    space = SignedDistance(meshes.polydata(meshes.joined(*solids)))
    low, high = space.mesh.points.min(axis=0) - 0.5, space.mesh.points.max(axis=0) + 0.5
    points = random.uniform(low, high, (4000, 3))
    points = np.vstack([points, np.round(2 * points) / 2])  # many on walls that bound nothing
    expected, found = beyond(solids, points), space(points)
    clear = np.abs(expected) > 1e-6
    np.testing.assert_array_equal(found[clear] < 0, expected[clear] < 0)
    np.testing.assert_allclose(space.tree(points), found, atol=1e-9)
    # Faces inside the union are no walls: a point deep in one solid is far from every wall.
    assert (found[expected < 0] <= expected[expected < 0] + 1e-6).all()
    step = random.normal(size=points.shape) * 0.1
    change = np.abs(space(points + step) - found)
    assert (change <= np.linalg.norm(step, axis=1) + 1e-6).all()


def test_two_boxes_that_overlap():
    corner = meshes.joined(box([0, 0, 0], [10, 2, 2]), box([0, 0, 0], [2, 10, 2]))
    found = SignedDistance(meshes.polydata(corner))([[2, 1, 1], [5, 1, 1], [3, 3, 1], [1.5, 1.5, 1]])
    np.testing.assert_allclose(found, [-1, -1, 1, -np.sqrt(0.5)], atol=1e-12)


def test_boxes_whose_walls_between_do_not_match_are_one():
    both = meshes.joined(box([0, 0, 0], [2, 2, 2]), box([2, 0.5, 0.5], [4, 1.5, 1.5]))
    points = np.array([[2, 1, 1], [2, 0.7, 1], [2, 0.25, 1], [3, 1, 1], [2.5, 0.2, 1]])
    found = SignedDistance(meshes.polydata(both))(points)
    np.testing.assert_allclose(found, [-0.5, -0.2, 0, -0.5, 0.3], atol=1e-9)


def test_where_solids_touch_along_a_line_the_winding_number_decides():
    # No face of the one is a neighbour of the other's: pseudonormals at the line are those of one solid.
    both = meshes.joined(box([0, 0, 0], [2, 2, 2]), box([2, 0.5, 2], [4, 1.5, 4]))
    space = SignedDistance(meshes.polydata(both))
    assert space.mesh.n_faces == 24
    assert len(space.tree.winding) > 0
    np.testing.assert_allclose(
        space([[1.9, 1, 2.3], [2.3, 1, 1.9], [1.5, 1, 1.5]]), [0.1, 0.1, -0.5], atol=1e-12
    )


def test_a_cavity_in_a_space_of_two_solids_is_outside():
    solids = [box([0, 0, 0], [4, 4, 4]), box([3, 1, 1], [6, 3, 3])]
    cavity = box([1, 1, 1], [2, 2, 2])
    inverted = Mesh.from_faces(cavity.points, [face[::-1] for face in meshes.lists(cavity)])
    space = SignedDistance(meshes.polydata(meshes.joined(*solids, inverted)))
    np.testing.assert_allclose(
        space([[1.5, 1.5, 1.5], [3, 2, 2], [0.5, 1.5, 1.5]]), [0.5, -1, -0.5], atol=1e-9
    )


@pytest.mark.parametrize("size", [1e-6, 1e6])
def test_size_and_place_do_not_matter(size):
    solids = [random_solid(np.random.default_rng(seed), False) for seed in range(4)]
    space = meshes.joined(*solids)
    points = np.random.default_rng(0).uniform(-2, 2, (2000, 3))
    expected = SignedDistance(meshes.polydata(space))(points)
    moved = space.with_points(size * (space.points + 10))
    found = SignedDistance(meshes.polydata(moved))(size * (points + 10))
    np.testing.assert_allclose(found, size * expected, atol=1e-7 * size)


def test_a_single_solid_is_as_it_was():
    sphere = meshes.icosphere(2)
    space = SignedDistance(meshes.polydata(sphere))
    for corners in (1, 3):
        places = [m.points[m.connectivity].reshape(-1, 3 * corners) for m in (space.mesh, sphere)]
        np.testing.assert_array_equal(*[np.unique(place, axis=0) for place in places])
    assert len(space.tree.winding) == 0


def smoothed(part, space):
    """Smooth, and return how far points are outside before and after, by the check."""
    source, installation = meshes.polydata(part), meshes.polydata(space)
    smoothing = InstallationSpaceSmoothing(
        relaxation_factor=1.0, iterations=8, output_points_precision="double"
    )
    found = []
    checks = ContainmentCheck(), ContainmentCheck()
    for check, mesh in zip(checks, (source, smoothing(source, installation)), strict=True):
        result = check(mesh, installation)
        found.append(vtk_to_numpy(result.GetPointData().GetArray("SignedDistance")))
    outside = tuple(check.summary["vertices_outside"] for check in checks)
    assert smoothing.report.outside == outside, "one answer everywhere"
    assert smoothing.report.moved > 0
    before, after = (check.summary["triangles_crossing"] for check in checks)
    assert after <= before
    return found


@pytest.mark.parametrize("seed", range(6))
def test_nothing_leaves_a_space_of_several_solids(seed):
    random, solids = random_solids(seed)
    points = random.uniform(-2, 4, (3000, 3))
    depth = beyond(solids, points)
    ball = meshes.icosphere(2)
    rough = 1 + 0.1 * random.normal(size=(ball.n_points, 1))
    radius = -1.05 * depth.min()
    part = ball.with_points(points[depth.argmin()] + radius * rough * ball.points)
    before, after = smoothed(part, meshes.joined(*solids))
    np.testing.assert_array_equal(before > 1e-5, beyond(solids, part.points) > 1e-5)
    assert not ((before <= 1e-5) & (after > 1e-5)).any()


def opened(space, kept):
    """Return the space without the faces for which `kept` is not true of their corners, (t, 3, 3)."""
    faces = space.connectivity.reshape(-1, 3)
    return Mesh.from_faces(space.points, faces[kept(space.points[faces])])


def open_space(seed):
    """Return a space that is open, and cells of a part in it."""
    random = np.random.default_rng(seed)
    cells = np.argwhere(random.random((5, 5, 5)) < 0.75)
    kind = seed % 4
    if kind == 0:  # a box without a lid
        whole = meshes.cube(7, triangles=True)
        shift = np.array([1, 1, random.integers(0, 3)])
        return opened(whole, lambda p: ~(p[:, :, 2] == 7).all(axis=1)), cells + shift
    if kind == 1:  # a tube, open at both ends
        whole = meshes.cube(7, triangles=True)
        shift = np.array([random.integers(0, 3), 1, 1])
        return opened(whole, lambda p: ~np.isin(p[:, :, 0], [0, 7]).all(axis=1)), cells + shift
    if kind == 2:  # a piece of a ball
        whole, along, at = meshes.icosphere(3, 5.0), random.normal(size=3), random.uniform(-2, 4)
        along /= np.linalg.norm(along)
        return opened(whole, lambda p: (p @ along).min(axis=1) < at), cells - 2.5
    # A body of cells, cut off anywhere.
    cells = np.argwhere(np.pad(random.random((7, 7, 7)) < 0.8, 1))
    axis, at = random.integers(3), random.uniform(4, 7)
    whole = meshes.voxels(cells, triangles=True)
    return opened(whole, lambda p: p[:, :, axis].min(axis=1) < at), cells[random.random(len(cells)) < 0.7]


@pytest.mark.parametrize("seed", range(16))
def test_nothing_leaves_an_open_space(seed):
    space, cells = open_space(seed)
    before, after = smoothed(meshes.voxels(cells, triangles=True), space)
    assert not ((before <= 1e-5) & (after > 1e-5)).any()
