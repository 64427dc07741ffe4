"""Feature edges given by hand: classes and rings of what comes and goes, everything else untouched."""

import meshes
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vtksmooth.errors import InvalidMeshError
from vtksmooth.kernels.features import detection
from vtksmooth.kernels.features.detection import CORNER, RIDGE, SMOOTH
from vtksmooth.kernels.features.edits import edited
from vtksmooth.kernels.mesh import adjacency
from vtksmooth.kernels.mesh.paths import shortest_path
from vtksmooth.kernels.mesh.regions import rings_of

NONE = np.empty((0, 2), np.int64)


def made(mesh, added=NONE, removed=NONE, found=None):
    near = adjacency.build(mesh)
    found = found or detection.detect(mesh, near)
    return found, edited(found, mesh, near, np.asarray(added), np.asarray(removed))


def chain(mesh, start, end):
    path = shortest_path(mesh.points, rings_of(mesh), start, end)
    return path, np.column_stack((path[:-1], path[1:]))


def edge_set(found):
    return {tuple(pair) for pair in found.ridge_edges.tolist()}


def test_a_line_on_a_sphere_is_a_ridge_with_two_ends():
    mesh = meshes.icosphere(3)
    path, pairs = chain(mesh, 0, int(np.argmin(mesh.points @ mesh.points[0])))
    _, found = made(mesh, pairs)
    assert (found.classes[path[1:-1]] == RIDGE).all()
    assert (found.classes[path[[0, -1]]] == CORNER).all()
    assert (found.classes != SMOOTH).sum() == len(path)
    for before, at, after in zip(path, path[1:], path[2:], strict=False):
        assert set(found.ridge_ring[at].tolist()) == {before, after}
    assert (found.ridge_ring[path[[0, -1]]] == -1).all()
    lines = detection.polylines(found)
    assert len(lines) == 1
    assert sorted(lines[0].tolist()) == sorted(path.tolist())
    # And it goes as it came.
    _, again = made(mesh, removed=pairs[:, ::-1], found=found)
    assert not again.classes.any()
    assert (again.ridge_ring == -1).all()
    assert not len(again.ridge_edges)


def test_a_closed_line_has_no_ends():
    mesh = meshes.torus(12, 8)
    loop = np.arange(12)
    smooth = detection.detect(mesh, adjacency.build(mesh), ridge_angle=170, corner_angle=170)
    assert not smooth.classes.any()
    _, found = made(mesh, np.column_stack((loop, np.roll(loop, -1))), found=smooth)
    assert (found.classes[loop] == RIDGE).all()
    assert (found.classes[12:] == SMOOTH).all()


def test_an_edge_of_a_cube_can_be_removed():
    mesh = meshes.cube(4, triangles=True)
    x, y, z = mesh.points.T
    line = np.flatnonzero((x == 0) & (y == 0))[np.argsort(z[(x == 0) & (y == 0)])]
    before, found = made(mesh, removed=np.column_stack((line[:-1], line[1:])))
    assert (found.classes[line[1:-1]] == SMOOTH).all()
    # Of the three edges at its ends two are left, at a right angle.
    assert (found.classes[line[[0, -1]]] == CORNER).all()
    others = np.setdiff1d(np.arange(mesh.n_points), line)
    np.testing.assert_array_equal(found.classes[others], before.classes[others])
    np.testing.assert_array_equal(found.ridge_ring[others], before.ridge_ring[others])
    assert len(detection.polylines(found)) == 11


def test_what_forks_is_a_corner_and_what_no_longer_forks_is_none():
    mesh = meshes.sheet(8, 8)
    at = lambda i, j: j * 9 + i  # noqa: E731
    across = [[at(i, 4), at(i + 1, 4)] for i in range(8)]
    branch = [[at(4, j), at(4, j + 1)] for j in range(4)]
    _, found = made(mesh, across + branch)
    assert found.classes[at(4, 4)] == CORNER
    assert found.classes[at(0, 4)] == CORNER  # on the boundary, where lines end
    _, found = made(mesh, removed=branch, found=found)
    assert found.classes[at(4, 4)] == RIDGE
    assert set(found.ridge_ring[at(4, 4)].tolist()) == {at(3, 4), at(5, 4)}


def test_half_a_line_removed_ends_in_a_corner():
    mesh = meshes.cube(4, triangles=True)
    x, y, z = mesh.points.T
    line = np.flatnonzero((x == 0) & (y == 0))[np.argsort(z[(x == 0) & (y == 0)])]
    _, found = made(mesh, removed=np.column_stack((line[:2], line[1:3])))
    assert found.classes[line].tolist() == [CORNER, SMOOTH, CORNER, RIDGE, CORNER]


@given(st.integers(0, 10_000))
def test_edits_do_what_sets_do_and_touch_only_their_ends(seed):
    random = np.random.default_rng(seed)
    mesh = meshes.cube(3, triangles=True)
    near = adjacency.build(mesh)
    ends, _ = adjacency.edges(near)
    added, removed = (ends[random.random(len(ends)) < 0.1] for _ in range(2))
    before, found = made(mesh, added[:, ::-1], removed)
    plus, minus = ({tuple(pair) for pair in pairs.tolist()} for pairs in (added, removed))
    assert edge_set(found) == (edge_set(before) - minus) | plus
    touched = {v for pair in edge_set(found) ^ edge_set(before) for v in pair}
    rest = [v for v in range(mesh.n_points) if v not in touched]
    np.testing.assert_array_equal(found.classes[rest], before.classes[rest])
    # Twice is once; and what is an end of no edge is smooth, of three a corner.
    again = made(mesh, added, removed, found)[1]
    np.testing.assert_array_equal(again.classes, found.classes)
    np.testing.assert_array_equal(again.ridge_ring, found.ridge_ring)
    degree = np.bincount(found.ridge_edges.ravel(), minlength=mesh.n_points)
    at = sorted(touched)
    assert (found.classes[at][degree[at] == 0] == SMOOTH).all()
    assert (found.classes[at][degree[at] > 2] == CORNER).all()
    # Nobody slides along what is no ridge.
    ring = found.ridge_ring
    assert (found.classes[ring[ring >= 0]] != SMOOTH).all()


def test_features_that_are_known_by_their_rings_only():
    mesh = meshes.cube(4, triangles=True)
    full, _ = made(mesh)
    rings_only = detection.Features(full.classes, full.ridge_ring, np.empty((0, 2), np.int32))
    x, y, z = mesh.points.T
    line = np.flatnonzero((x == 0) & (y == 0))[np.argsort(z[(x == 0) & (y == 0)])]
    removed = np.column_stack((line[:-1], line[1:]))
    _, a = made(mesh, removed=removed, found=full)
    _, b = made(mesh, removed=removed, found=rings_only)
    np.testing.assert_array_equal(a.classes, b.classes)
    np.testing.assert_array_equal(a.ridge_ring, b.ridge_ring)


@pytest.mark.parametrize("pair", [[0, 40], [0, 1_000_000], [-1, 0]])
def test_what_is_no_edge_is_refused(pair):
    mesh = meshes.icosphere(2)
    with pytest.raises(
        InvalidMeshError, match=r"1 of the feature edges are no edges of the mesh .*remove them"
    ):
        made(mesh, [chain(mesh, 0, 5)[1][0].tolist(), pair])
