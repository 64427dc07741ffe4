"""Feature detection, on shapes whose features are known."""

from __future__ import annotations

from itertools import pairwise

import meshes
import numpy as np
import pytest

from vtksmooth.errors import ParameterError
from vtksmooth.jit import parallel
from vtksmooth.kernels.features import detection
from vtksmooth.kernels.features.detection import CORNER, RIDGE, SMOOTH
from vtksmooth.kernels.mesh import adjacency
from vtksmooth.kernels.mesh.mesh import Mesh


def detect(mesh, **settings):
    return detection.detect(mesh, adjacency.build(mesh), **settings)


def on_cube(mesh, side):
    """The classes of the points on a cube: by how many of its planes they lie on."""
    return ((mesh.points == 0) | (mesh.points == side)).sum(axis=1) - 1


def roof(angle, n=6):
    """Two square sheets of triangles that meet in a ridge where normals turn by `angle` degrees."""
    turn = np.radians(angle)
    sheet = meshes.sheet(2 * n, n)
    x, y, _ = sheet.points.T
    over = np.maximum(x - n, 0.0)
    points = np.column_stack([np.minimum(x, n) + over * np.cos(turn), y, -over * np.sin(turn)])
    return sheet.with_points(points), x == n


@pytest.mark.parametrize("weight", ["area", "angle"])
@pytest.mark.parametrize("triangles", [False, True])
@pytest.mark.parametrize("side", [1, 2, 5])
def test_cube(side, triangles, weight):
    mesh = meshes.cube(side, triangles)
    found = detect(mesh, weight=weight)
    np.testing.assert_array_equal(found.classes, on_cube(mesh, side))
    assert len(found.ridge_edges) == 12 * side
    assert (found.ridge_edges[:, 0] < found.ridge_edges[:, 1]).all()
    lines = detection.polylines(found)
    assert len(lines) == 12
    assert all(len(line) == side + 1 for line in lines)
    ends = np.array([line[[0, -1]] for line in lines])
    assert (found.classes[ends] == CORNER).all()


def test_sphere_is_smooth():
    found = detect(meshes.icosphere(3))
    assert not found.classes.any()
    assert not len(found.ridge_edges)
    assert (found.ridge_ring == -1).all()
    assert detection.polylines(found) == []


def test_sheet_has_its_boundary_and_its_corners():
    mesh = meshes.sheet(5, 4, bump=0.3)
    found = detect(mesh)
    x, y, _ = mesh.points.T
    boundary = (x == 0).astype(int) + (x == 5) + (y == 0) + (y == 4)
    np.testing.assert_array_equal(found.classes, boundary)
    assert len(detection.polylines(found)) == 4


@pytest.mark.parametrize("angle", [25, 60, 90, 150])
def test_roof(angle):
    mesh, on_ridge = roof(angle)
    found = detect(mesh)
    kinds = adjacency.build(mesh).kinds == adjacency.BOUNDARY
    np.testing.assert_array_equal(found.classes > 0, on_ridge | kinds)
    inner = on_ridge & ~kinds
    assert (found.classes[inner] == RIDGE).all()
    # Where the ridge meets the boundary three ridge edges meet.
    assert (found.classes[on_ridge & kinds] == CORNER).all()
    np.testing.assert_allclose(
        mesh.points[found.ridge_ring[inner]].mean(axis=1), mesh.points[inner], atol=1e-12
    )


@pytest.mark.parametrize(("threshold", "there"), [(44.0, True), (46.0, False)])
def test_ridge_angle_decides(threshold, there):
    mesh, on_ridge = roof(45)
    inner = on_ridge & (adjacency.build(mesh).kinds == adjacency.INTERIOR)
    assert (detect(mesh, ridge_angle=threshold).classes[inner] == (RIDGE if there else SMOOTH)).all()


@pytest.mark.parametrize("size", [1e-6, 1e6])
@pytest.mark.parametrize("name", meshes.USUAL)
def test_scale_and_pose_do_not_matter(name, size):
    mesh = meshes.USUAL[name]()
    turn, _ = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))
    other = mesh.with_points(size * (mesh.points @ (turn * np.linalg.det(turn)).T))
    found, again = detect(mesh), detect(other)
    np.testing.assert_array_equal(found.classes, again.classes)
    np.testing.assert_array_equal(found.ridge_edges, again.ridge_edges)


def test_closed_line():
    mesh = meshes.torus(24, 4, "quads")  # a square section: four sharp rings
    lines = detection.polylines(detect(mesh))
    assert len(lines) == 4
    assert all(line[0] == line[-1] and len(line) == 25 for line in lines)


def test_non_manifold_edges_are_ridges():
    mesh = meshes.non_manifold_edge()
    found = detect(mesh)
    shared = np.flatnonzero((mesh.points[:, 0] == 0) & (mesh.points[:, 2] == 0))
    assert (found.classes[shared] > 0).all()
    edges = {tuple(edge) for edge in found.ridge_edges.tolist()}
    inner = sorted(shared, key=lambda p: mesh.points[p, 1])
    assert all((min(p, q), max(p, q)) in edges for p, q in pairwise(inner))


@pytest.mark.parametrize("name", meshes.HOSTILE)
def test_hostile_meshes(name):
    mesh = meshes.HOSTILE[name]()
    found = detect(mesh)
    near = adjacency.build(mesh)
    assert (found.classes[near.kinds == adjacency.UNUSED] == SMOOTH).all()
    assert (found.ridge_ring[found.classes != RIDGE] == -1).all()
    assert (found.classes[found.ridge_edges] > 0).all()
    joined = detection.polylines(found)
    assert sum(len(line) - 1 for line in joined) == len(found.ridge_edges)


@pytest.mark.parametrize(
    "settings",
    [{"ridge_angle": -1.0}, {"corner_angle": 180.1}, {"ridge_angle": "much"}, {"ridge_angle": np.nan}],
)
def test_thresholds_out_of_range(settings):
    with pytest.raises(ParameterError, match="from 0 to 180"):
        detect(meshes.cube(), **settings)


def test_single_triangle():
    found = detect(Mesh.from_faces([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]))
    assert (found.classes == CORNER).all()
    assert len(detection.polylines(found)) == 3


def needle(height):
    """A pyramid over a small square: its tip is as acute as `height` is large."""
    points = [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0], [0, 0, height]]
    return Mesh.from_faces(points, [[3, 2, 1, 0], [0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]])


@pytest.mark.parametrize("height", [2.0, 20.0, 2000.0])
def test_needle_has_five_corners(height):
    found = detect(needle(height))
    assert (found.classes == CORNER).all()
    assert len(found.ridge_edges) == 8


def test_flat_two_sided_disc_has_cusps_on_its_rim():
    disc = meshes.fan(12)
    lower = [face[::-1] for face in meshes.lists(disc)]
    lower = [[13 if p == 0 else p for p in face] for face in lower]
    points = np.vstack([disc.points, disc.points[:1]])
    found = detect(Mesh.from_faces(points, [*meshes.lists(disc), *lower]))
    assert (found.classes[1:13] == detection.CUSP).all()
    assert (found.classes[[0, 13]] == SMOOTH).all()


def test_sizes_of_faces_do_not_matter_to_a_ridge():
    mesh, on_ridge = roof(60)
    inner = on_ridge & (adjacency.build(mesh).kinds == adjacency.INTERIOR)
    stretched = mesh.points.copy()
    stretched[stretched[:, 0] < 6, 0] = 6 + 1000 * (stretched[stretched[:, 0] < 6, 0] - 6)
    assert (detect(mesh.with_points(stretched)).classes[inner] == RIDGE).all()


@pytest.mark.parametrize("threads", [1, 3])
def test_threads_and_numbering_do_not_matter(threads, request):
    mesh = meshes.torus(60, 24, jitter=0.3)
    expected = detect(mesh)
    request.addfinalizer(lambda: parallel.set_number_of_threads(0))
    parallel.set_number_of_threads(threads)
    again = detect(mesh)
    np.testing.assert_array_equal(again.classes, expected.classes)
    np.testing.assert_array_equal(again.ridge_edges, expected.ridge_edges)
    order = np.random.default_rng(0).permutation(mesh.n_points).astype(np.int32)
    other, _ = adjacency.renumbered(mesh, order)
    assert (detect(other).classes == expected.classes[order]).mean() > 0.99


@pytest.mark.parametrize(("level", "bound"), [(0.05, 0.97), (0.1, 0.93), (0.2, 0.9)])
def test_noise_on_a_cube(level, bound):
    clean = meshes.cube(12, triangles=True)
    push = np.random.default_rng(0).normal(0.0, level, clean.points.shape)
    found = detect(clean.with_points(clean.points + push)).classes > 0
    there = on_cube(clean, 12) > 0
    assert 2 * (found & there).sum() / (found.sum() + there.sum()) >= bound


@pytest.mark.parametrize(("level", "bound"), [(0.05, 0.99), (0.1, 0.95), (0.2, 0.85)])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_noise_on_half_a_cube(level, bound, axis):
    clean = meshes.cube(16, triangles=True)
    push = np.random.default_rng(0).normal(0.0, level, clean.points.shape)
    push[clean.points[:, axis] < 8.0] = 0.0
    found = detect(clean.with_points(clean.points + push)).classes > 0
    there = on_cube(clean, 16) > 0
    assert 2 * (found & there).sum() / (found.sum() + there.sum()) >= bound


@pytest.mark.parametrize("ridge_angle", [30.0, "auto"])
def test_classes_do_not_depend_on_the_numbering(ridge_angle):
    ball = meshes.icosphere(2)
    for seed in range(20):
        random = np.random.default_rng(seed)
        mesh = ball.with_points(ball.points + 0.15 * random.normal(size=ball.points.shape))
        order = random.permutation(mesh.n_points).astype(np.int32)
        place = np.argsort(order)
        faces = place[np.array(meshes.lists(mesh))][random.permutation(mesh.n_faces)]
        other = Mesh.from_faces(mesh.points[order], faces.tolist())
        found, renumbered = detect(mesh, ridge_angle=ridge_angle), detect(other, ridge_angle=ridge_angle)
        np.testing.assert_array_equal(renumbered.classes, found.classes[order])
        edges = np.sort(order[renumbered.ridge_edges], axis=1)
        assert {tuple(edge) for edge in edges.tolist()} == {
            tuple(edge) for edge in found.ridge_edges.tolist()
        }
