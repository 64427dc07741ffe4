import meshes
import numpy as np
import pytest
import reference
from hypothesis import given, settings
from hypothesis import strategies as st
from vtkmodules.vtkCommonCore import mutable
from vtkmodules.vtkCommonDataModel import vtkStaticCellLocator

from vtksmooth.kernels.distance.closest_point import ClosestPoint, triangles
from vtksmooth.kernels.mesh.mesh import Mesh


def as_triangles(mesh):
    return Mesh.from_faces(mesh.points, reference.triangles(mesh))


def vtk_distances(mesh, queries):
    locator = vtkStaticCellLocator()
    locator.SetDataSet(meshes.polydata(as_triangles(mesh)))
    locator.BuildLocator()
    place, cell, part, square = [0.0] * 3, mutable(0), mutable(0), mutable(0.0)
    result = []
    for query in queries:
        locator.FindClosestPoint(query, place, cell, part, square)
        result.append(float(square) ** 0.5)
    return np.array(result)


@pytest.mark.parametrize(
    "name", ["sheet of triangles", "mixed sheet", "torus of quads", "sphere", "cube of quads"]
)
def test_like_vtk(name):
    mesh = meshes.USUAL[name]()
    random = np.random.default_rng(5)
    low, high = mesh.points.min(axis=0) - 0.5, mesh.points.max(axis=0) + 0.5
    near = mesh.points[random.integers(mesh.n_points, size=1000)] + 0.05 * random.normal(size=(1000, 3))
    queries = np.vstack([random.uniform(low, high, (2000, 3)), near])
    closest, distance = ClosestPoint(mesh).query(queries)
    np.testing.assert_allclose(distance, vtk_distances(mesh, queries), atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(closest - queries, axis=1), distance, atol=1e-15)
    np.testing.assert_allclose(ClosestPoint(mesh).query(closest)[1], 0, atol=1e-14)


def test_points_of_the_mesh_are_on_it():
    for name in ("mixed sheet", "torus of quads", "folded_quads"):
        mesh = {**meshes.USUAL, **meshes.HOSTILE}[name]()
        np.testing.assert_allclose(ClosestPoint(mesh).query(mesh.points)[1], 0.0, atol=1e-15)


# Corners on a coarse lattice make needles, triangles in line and corners in one place the rule.
lattice = st.tuples(*[st.integers(-2, 2)] * 3)


@given(
    corners=st.tuples(*[lattice] * 3),
    thin=st.sampled_from([0.0, 1e-15, 1e-9, 1e-4, 1.0]),
    seed=st.integers(0, 99),
)
@settings(max_examples=300)
def test_one_triangle_however_thin(corners, thin, seed):
    random = np.random.default_rng(seed)
    corners = np.array(corners, float)
    corners[2] = corners[0] + thin * (corners[2] - corners[0]) + (1 - thin) * 0.4 * (corners[1] - corners[0])
    turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
    corners = corners @ turn
    queries = random.uniform(-3, 3, (20, 3))
    closest, distance = ClosestPoint(Mesh.from_faces(corners, [[0, 1, 2]])).query(queries)
    for query, place, found in zip(queries, closest, distance, strict=True):
        expected = reference.distance_to_triangle(*corners, query)
        assert found == pytest.approx(expected, abs=1e-12)
        assert reference.distance_to_triangle(*corners, place) < 1e-12


def test_a_triangle_with_a_side_of_no_length_is_a_line():
    for corners in ([0, 0, 1], [0, 1, 0], [1, 0, 0], [0, 1, 1], [1, 0, 1], [1, 1, 0]):
        mesh = Mesh.from_faces([[float(x), 0, 0] for x in corners], [[0, 1, 2]])
        closest, distance = ClosestPoint(mesh).query([[0.25, 3.0, 4.0], [-3, 4, 0], [4, 4, 0]])
        np.testing.assert_allclose(closest, [[0.25, 0, 0], [0, 0, 0], [1, 0, 0]])
        np.testing.assert_allclose(distance, [5, 5, 5])


@pytest.mark.parametrize("scale", [1e-12, 1e-6, 1e6, 1e12, 1e60])
def test_scale_does_not_matter(scale):
    mesh = meshes.torus(12, 8, jitter=0.2)
    queries = np.random.default_rng(0).normal(size=(200, 3)) * 3
    closest, distance = ClosestPoint(mesh).query(queries)
    scaled, far = ClosestPoint(mesh.with_points(mesh.points * scale)).query(queries * scale)
    np.testing.assert_allclose(scaled / scale, closest, atol=1e-12)
    np.testing.assert_allclose(far / scale, distance, atol=1e-12)


def test_triangles_of_polygons_cover_them():
    mesh = meshes.sheet(8, 6, "mixed", jitter=0.15)
    corners = mesh.points[triangles(mesh)]
    area = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2] / 2
    assert (area > 0).all()
    assert area.sum() == pytest.approx(48, rel=1e-13)
    assert len(area) == (mesh.face_sizes - 2).sum()


def test_triangles_do_not_depend_on_the_pose():
    # A square that is bent has diagonals of one length: which is taken must not be left to rounding.
    bent = Mesh.from_faces([[1, 0, 0.1], [0, 1, -0.1], [-1, 0, 0.1], [0, -1, -0.1]], [[0, 1, 2, 3]])
    expected = triangles(bent).tolist()
    for seed in range(50):
        turn = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
        assert triangles(bent.with_points(bent.points @ turn)).tolist() == expected


def test_no_triangles():
    closest, distance = ClosestPoint(Mesh.from_faces(np.eye(3), [[0, 1]])).query([[1.0, 2.0, 3.0]])
    assert closest.tolist() == [[1.0, 2.0, 3.0]]
    assert distance.tolist() == [np.inf]
