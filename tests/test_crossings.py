"""Triangles that cross a surface: against VTK, against distances by formula, and where they only touch."""

import meshes
import numpy as np
import pytest
from vtkmodules.vtkCommonDataModel import vtkTriangle

from vtksmooth.kernels.containment.crossings import crossing_triangles
from vtksmooth.kernels.distance.closest_point import ClosestPoint
from vtksmooth.kernels.distance.signed_distance import SignedDistanceTree
from vtksmooth.kernels.mesh.mesh import Mesh

TOLERANCE = 1e-9


def crossing(points, triangles, space, distances=None, tolerance=TOLERANCE):
    points, triangles = np.asarray(points, float), np.asarray(triangles, np.int32)
    if distances is None:
        distances = np.full(len(points), np.inf)
    return crossing_triangles(points, triangles, ClosestPoint(space), distances, tolerance)


def test_pairs_of_triangles_like_vtk():
    random = np.random.default_rng(0)
    count = 1000
    corners = random.normal(size=(2, count, 3, 3))
    corners[1] *= random.choice([0.2, 1, 5], size=count)[:, None, None]
    expected = [vtkTriangle.TrianglesIntersect(*corners[0, i], *corners[1, i]) == 1 for i in range(count)]
    found = [
        crossing(corners[0, i], [[0, 1, 2]], Mesh.from_faces(corners[1, i], [[0, 1, 2]]))[0]
        for i in range(count)
    ]
    assert 0.1 * count < sum(expected) < 0.9 * count
    np.testing.assert_array_equal(found, expected)


def test_many_triangles_against_many_like_all_pairs():
    space = meshes.torus(14, 8, jitter=0.2)
    random = np.random.default_rng(1)
    points = random.uniform(-4, 4, (900, 3))
    points[1::3] = points[::3] + random.normal(size=(300, 3))
    points[2::3] = points[::3] + random.normal(size=(300, 3))
    triangles = np.arange(900).reshape(-1, 3)
    faces = space.points[space.connectivity.reshape(-1, 3)]
    expected = [any(vtkTriangle.TrianglesIntersect(*points[t], *face) for face in faces) for t in triangles]
    np.testing.assert_array_equal(crossing(points, triangles, space), expected)
    # With distances: those that are inside without a doubt are not tested, with the same result for those
    # that do not stick out altogether.
    distances = SignedDistanceTree(space)(points)
    np.testing.assert_array_equal(crossing(points, triangles, space, distances), expected)


def box_distance(points, low, high):
    beyond = np.maximum(low - points, points - high)
    return np.linalg.norm(np.maximum(beyond, 0), axis=-1) + np.minimum(beyond.max(axis=-1), 0)


def test_a_concave_corner_pokes_through_a_triangle_whose_corners_are_inside():
    # The paper's own example of what vertices alone do not see. The octant above (1, 1, 1) is outside.
    space = meshes.voxels([c for c in np.ndindex(2, 2, 2) if c != (1, 1, 1)])
    random = np.random.default_rng(2)
    points = random.uniform(0.05, 1.95, (15_000, 3))
    points = points[(points.min(axis=1) < 1)]  # inside
    triangles = np.arange(len(points) // 3 * 3).reshape(-1, 3)
    distances = SignedDistanceTree(space)(points)
    assert (distances < 0).all()
    found = crossing(points, triangles, space, distances)
    # How deep the triangle reaches into the octant, from many of its points.
    grid = np.array([(i, j, 60 - i - j) for i in range(61) for j in range(61 - i)]) / 60
    depth = (np.einsum("gc,tcx->tgx", grid, points[triangles]) - 1).min(axis=2).max(axis=1)
    assert (found & (depth > 0)).sum() > 50
    assert found[depth > 0].all()
    assert not found[depth < -0.1].any()


def test_touching_is_no_crossing():
    cube = meshes.cube(2, triangles=True)
    inside = [
        [[0, 0.5, 0.5], [1, 0.5, 0.5], [1, 1, 1]],  # a corner on a face
        [[0, 0.5, 0.5], [0, 1.5, 0.5], [1, 1, 1]],  # a side on a face
        [[0, 0, 0], [2, 2, 2], [2, 2, 1]],  # from corner to corner
        [[0, 0, 0], [2, 0, 0], [2, 2, 2]],  # a side along an edge
        [[0, 0, 0], [0, 2, 0], [0, 0, 2]],  # the half of a face
        [[0, 0.3, 0.2], [0, 1.7, 0.4], [0, 0.5, 1.9]],  # a part of a face
        [[0, 0, 1], [2, 0, 1], [2, 2, 1]],  # along grid lines of the surface
        [[1, 0, 0], [1, 2, 0], [1, 2, 2]],
    ]
    for turn in (np.eye(3), np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]):
        space = cube.with_points(cube.points @ turn + 5)
        for corners in inside:
            assert not crossing(np.array(corners) @ turn + 5, [[0, 1, 2]], space)[0], corners


@pytest.mark.parametrize("fold", [30, 60, 120])
def test_a_side_in_a_sharp_edge_of_the_surface_is_no_crossing(fold):
    half = np.radians(fold / 2)
    far = [4 * np.cos(half), 4 * np.sin(half)]
    points = [[0, 0, -1], [0, 0, 1], [far[0], far[1], 0], [far[0], -far[1], 0]]
    wedge = Mesh.from_faces(points, [[0, 1, 2], [1, 0, 3]])
    for middle in ([2, 0, 0], [2, 0.5 * np.tan(half), 0]):
        assert not crossing([[0, 0, -0.7], [0, 0, 0.6], middle], [[0, 1, 2]], wedge)[0]


def test_a_triangle_that_touches_a_concave_edge():
    # Three cubes round a concave edge from (1, 1, 0) to (1, 1, 1): the quarter above it is outside.
    space = meshes.l_shape(triangles=True)
    touching = [[0.2, 1.8, 0.5], [1.8, 0.2, 0.5], [0.2, 0.2, 0.5]]  # its long side runs over the edge
    assert not crossing(touching, [[0, 1, 2]], space)[0]
    along = [[1, 1, 0.1], [1, 1, 0.9], [0.1, 0.1, 0.5]]  # its side lies in the edge
    assert not crossing(along, [[0, 1, 2]], space)[0]
    through = [[0.2, 1.9, 0.5], [1.9, 0.2, 0.5], [0.2, 0.2, 0.5]]
    assert crossing(through, [[0, 1, 2]], space)[0]


def test_a_surface_that_crosses_along_its_own_edges():
    # A square column pierces a triangle exactly where its faces are joined: no face crosses the plane.
    ring = [[0, 0], [1, 0], [1, 1], [0, 1]]
    points = np.array([[*r, z] for z in (-1, 0, 1) for r in ring], float)
    faces = [
        [4 * k + j, 4 * k + (j + 1) % 4, 4 * k + 4 + (j + 1) % 4, 4 * k + 4 + j]
        for k in range(2)
        for j in range(4)
    ]
    column = Mesh.from_faces(points, faces)
    plate = [[-5, -5, 0], [6, -5, 0], [0.5, 9, 0]]
    assert crossing(plate, [[0, 1, 2]], column)[0]
    # The upper half only stands on it.
    assert not crossing(plate, [[0, 1, 2]], Mesh.from_faces(points[4:], np.array(faces[4:]) - 4))[0]


def test_the_tolerance_is_a_depth():
    space = meshes.cube(2, triangles=True)
    for depth, expected in ((0.009, False), (0.011, True)):
        # A tip that comes out of the side x = 2 by this much, at right angles.
        poking = [[2 + depth, 1, 1], [1, 0.5, 1.01], [1, 1.5, 1.01]]
        wide = [[2 + depth, 0.4, 1], [2 + depth, 1.6, 1], [1, 1, 1.01]]
        assert not crossing(poking, [[0, 1, 2]], space, tolerance=0.01)[0] or expected
        assert crossing(wide, [[0, 1, 2]], space, tolerance=0.01)[0] == expected


@pytest.mark.parametrize("scale", [1e-9, 1e9])
def test_scale_does_not_matter(scale):
    space = meshes.torus(10, 6, jitter=0.2)
    points = np.random.default_rng(4).uniform(-4, 4, (600, 3))
    triangles = np.arange(600).reshape(-1, 3)
    expected = crossing(points, triangles, space)
    scaled = space.with_points(scale * space.points)
    found = crossing(scale * points, triangles, scaled, tolerance=scale * TOLERANCE)
    np.testing.assert_array_equal(found, expected)


def test_triangles_without_an_area_do_not_cross():
    space = meshes.cube(2, triangles=True)
    points = [[1, 1, 1], [5, 1, 1], [3, 1, 1]]
    assert not crossing(points, [[0, 1, 2], [0, 1, 1], [0, 0, 0]], space).any()
