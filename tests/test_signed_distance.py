"""Signed distance by VTK: against distances known by formula, and spaces as users have them."""

from __future__ import annotations

import meshes
import numpy as np
import pytest

from vtksmooth import InvalidMeshError
from vtksmooth.filters.signed_distance import SignedDistance, check_sizes
from vtksmooth.kernels.mesh.mesh import Mesh


def box_distance(points, low, high):
    """The signed distance of a box: inside the nearest side, outside the nearest point."""
    beyond = np.maximum(low - points, points - high)
    return np.linalg.norm(np.maximum(beyond, 0), axis=1) + np.minimum(beyond.max(axis=1), 0)


def queries(count=4000, low=-1.0, high=3.0, seed=0):
    return np.random.default_rng(seed).uniform(low, high, (count, 3))


def distances(mesh, points):
    return SignedDistance(meshes.polydata(mesh))(points)


@pytest.mark.parametrize("triangles", [False, True])
def test_a_cube(triangles):
    mesh = meshes.cube(2, triangles)
    near = np.round(queries(seed=1))  # corners, edges, faces, and their neighbours on the lattice
    for points in (queries(), near, near + 1e-9 * queries(seed=2)):
        np.testing.assert_allclose(distances(mesh, points), box_distance(points, 0, 2), atol=1e-12)


def test_a_concave_edge_and_corner():
    # The space without one octant, which touches a concave corner.
    mesh = meshes.voxels([c for c in np.ndindex(2, 2, 2) if c != (1, 1, 1)])
    points = queries()
    # Outside, within the octant: a point's nearest place is on one of the octant's three inner sides.
    octant = points[((points > 1) & (points < 1.5)).all(axis=1)]
    np.testing.assert_allclose(distances(mesh, octant), (octant - 1).min(axis=1), atol=1e-12)
    whole, found = box_distance(points, 0, 2), distances(mesh, points)
    free = box_distance(points, 1, 9)  # negative in the octant
    np.testing.assert_array_equal(found > 0, (whole > 0) | (free < 0))


def test_cells_that_touch_along_an_edge_or_at_a_corner():
    for second in ((1, 1, 0), (1, 1, 1)):
        mesh = meshes.voxels([(0, 0, 0), second])
        points = queries()
        first, other = box_distance(points, 0, 1), box_distance(points, np.array(second), np.add(second, 1))
        np.testing.assert_allclose(distances(mesh, points), np.minimum(first, other), atol=1e-12)


def test_solids_that_touch_are_one():
    # Two boxes side by side, each closed: between them there are two walls, which are none.
    box = meshes.cube(2)
    both = meshes.joined(box, box.with_points(box.points + np.array([2.0, 0, 0])))
    points = queries(low=-1, high=5)
    high = np.array([4.0, 2, 2])
    np.testing.assert_allclose(distances(both, points), box_distance(points, 0, high), atol=1e-12)


def test_strips():
    from vtkmodules.vtkFiltersCore import vtkStripper

    stripper = vtkStripper()
    stripper.SetInputData(meshes.polydata(meshes.cube(2, triangles=True)))
    stripper.Update()
    assert stripper.GetOutput().GetNumberOfStrips() > 0
    found = SignedDistance(stripper.GetOutput())(queries())
    np.testing.assert_allclose(found, box_distance(queries(), 0, 2), atol=1e-12)


def test_inside_out_is_turned_and_said():
    mesh = meshes.cube(2)
    turned = Mesh.from_faces(mesh.points, [face[::-1] for face in meshes.lists(mesh)])
    distance = SignedDistance(meshes.polydata(turned))
    assert distance.turned
    assert distance.closed
    assert "inside out" in distance.notes[0]
    np.testing.assert_allclose(distance(queries()), box_distance(queries(), 0, 2), atol=1e-12)
    assert not SignedDistance(meshes.polydata(mesh)).notes


def test_a_void_inside_is_outside():
    whole, hole = meshes.cube(5), meshes.cube(1)
    void = Mesh.from_faces(hole.points + 2.0, [face[::-1] for face in meshes.lists(hole)])
    distance = SignedDistance(meshes.polydata(meshes.joined(whole, void)))
    assert not distance.turned
    np.testing.assert_allclose(distance([[2.5, 2.5, 2.4], [2.5, 2.5, 1.5]]), [0.4, -0.5])


def test_lids_close_open_channels():
    distance = SignedDistance(meshes.polydata(meshes.tube()))
    assert not distance.closed
    assert "8 boundary edges" in distance.notes[0]
    assert "2 lids close it" in distance.notes[0]
    points = queries(low=-1, high=5)
    np.testing.assert_allclose(distance(points), box_distance(points, 0, np.array([4, 1, 1])), atol=1e-12)
    np.testing.assert_allclose(distance.tree(points), distance(points), atol=1e-12)
    # Open and inside out.
    inside_out = Mesh.from_faces(meshes.tube().points, [face[::-1] for face in meshes.lists(meshes.tube())])
    turned = SignedDistance(meshes.polydata(inside_out))
    assert turned.turned
    np.testing.assert_allclose(turned(points), distance(points), atol=1e-12)


def test_points_in_one_place_are_one():
    mesh = meshes.cube(2, triangles=True)
    apart = Mesh.from_faces(mesh.points[mesh.connectivity], np.arange(len(mesh.connectivity)).reshape(-1, 3))
    distance = SignedDistance(meshes.polydata(apart))
    assert distance.closed
    np.testing.assert_allclose(distance(queries()), box_distance(queries(), 0, 2), atol=1e-12)


def test_degenerate_triangles_and_unused_points_do_not_matter():
    mesh = meshes.cube(2, triangles=True)
    points = np.vstack([mesh.points, [[np.nan] * 3, [50, 0, 0]]])
    more = Mesh.from_faces(points, [*meshes.lists(mesh), [0, 0, 1], [2, 2, 2]])
    np.testing.assert_allclose(distances(more, queries()), box_distance(queries(), 0, 2), atol=1e-12)


@pytest.mark.parametrize("scale", [1e-9, 1e9])
def test_scale_and_place_do_not_matter(scale):
    mesh = meshes.torus(16, 9, jitter=0.2)
    points, shift = queries(1000, -4, 4), np.array([100.0, 0, 0])
    expected = distances(mesh, points)
    moved = mesh.with_points(scale * (mesh.points + shift))
    found = distances(moved, scale * (points + shift)) / scale
    np.testing.assert_allclose(found, expected, atol=1e-9)


def test_many_points_can_be_interrupted():
    distance, seen = SignedDistance(meshes.polydata(meshes.cube(2))), []
    points = queries(40_000)
    np.testing.assert_allclose(distance(points, seen.append), box_distance(points, 0, 2), atol=1e-12)
    assert seen[0] == 0.0
    assert seen == sorted(seen)
    assert len(seen) > 1

    def stop(fraction):
        if fraction > 0:
            raise InterruptedError

    with pytest.raises(InterruptedError):
        distance(points, stop)


def test_distances_of_no_points():
    assert distances(meshes.cube(1), np.empty((0, 3))).shape == (0,)


def flat():
    return Mesh.from_faces([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 1]])


def with_a_wall():
    mesh = meshes.voxels([(0, 0, 0), (1, 0, 0)])
    wall = [mesh.points.tolist().index([1.0, y, z]) for y, z in ((0, 0), (1, 0), (1, 1), (0, 1))]
    return Mesh.from_faces(mesh.points, [*meshes.lists(mesh), wall])


def with_an_inverted_solid():
    box = meshes.cube(1, triangles=True)
    faces = [face[::-1] for face in meshes.lists(box)]
    return meshes.joined(box.with_points(3 * box.points), Mesh.from_faces(box.points + 2.5, faces))


@pytest.mark.parametrize(
    ("mesh", "message"),
    [
        (meshes.misoriented, "edges of the installation space join faces that are turned"),
        (flat, "is closed but encloses no volume"),
        (lambda: meshes.sheet(4, 4), "is open and encloses no volume; close its openings"),
        (with_an_inverted_solid, "Faces of the installation space point into it .* orient every solid"),
        (with_a_wall, "4 edges of the installation space"),
        (meshes.folded_quads, "no usable surface: .*cross themselves"),
    ],
)
def test_spaces_that_are_none(mesh, message):
    with pytest.raises(InvalidMeshError, match=message):
        SignedDistance(meshes.polydata(mesh()))


def test_empty_spaces():
    from vtkmodules.vtkCommonDataModel import vtkPolyData

    with pytest.raises(InvalidMeshError, match="installation space is no usable surface: The mesh is empty"):
        SignedDistance(vtkPolyData())


def test_units_that_do_not_match():
    sim, space = meshes.cube(1), meshes.cube(3)
    assert check_sizes(sim, space) == check_sizes(meshes.cube(4), space) == []
    (note,) = check_sizes(sim.with_points(1e-3 * sim.points + 1), space)
    assert "far smaller" in note
    far = sim.with_points(sim.points + 1000.0)
    with pytest.raises(InvalidMeshError, match=r"1 x 1 x 1, from \(1000, .*3 x 3 x 3, .* apart"):
        check_sizes(far, space)
    large = sim.with_points(1000.0 * (sim.points - 0.5))
    with pytest.raises(InvalidMeshError, match=r"1000 x 1000 x 1000\) is far larger .*3 x 3 x 3.* units"):
        check_sizes(large, space)
