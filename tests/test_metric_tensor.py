"""The metric tensor and its eigen-analysis, against its definition and against LAPACK."""

from __future__ import annotations

import meshes
import numpy as np
import pytest
import reference
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from vtksmooth.jit.compiled import kernel
from vtksmooth.jit.simd import load, store
from vtksmooth.kernels.features import metric_tensor
from vtksmooth.kernels.mesh import adjacency
from vtksmooth.kernels.mesh.mesh import Mesh


@kernel
def _eigen(a):
    return metric_tensor.eigen(a[0, 0], a[0, 1], a[0, 2], a[1, 1], a[1, 2], a[2, 2])


def eigen(a):
    result = _eigen(np.asarray(a, float))
    return np.array(result[:3]), np.array(result[3:]).reshape(3, 3)


def check(a):
    """Everything that makes an eigen-analysis, and LAPACK's eigenvalues."""
    a = np.asarray(a, float)
    values, vectors = eigen(a)
    scale = np.abs(a).max()
    assert values[0] >= values[1] >= values[2]
    np.testing.assert_allclose(values, np.linalg.eigvalsh(a)[::-1], atol=1e-14 * scale, rtol=0)
    np.testing.assert_allclose(vectors @ vectors.T, np.eye(3), atol=1e-14)
    np.testing.assert_allclose(a @ vectors.T, vectors.T * values, atol=3e-14 * scale, rtol=0)
    assert np.linalg.det(vectors) > 0


matrices = arrays.arrays(float, (3, 3), elements=st.floats(-1, 1)).map(lambda a: a + a.T)
directions = arrays.arrays(float, (3, 3), elements=st.floats(-1, 1)).map(lambda a: np.linalg.qr(a)[0])


@given(matrices, st.sampled_from([1e-150, 1e-12, 1.0, 1e12, 1e150]))
@settings(max_examples=300, deadline=None)
def test_any_matrix_at_any_scale(a, scale):
    a = np.where(np.abs(a) < 1e-100, 0.0, a)
    check(a * scale)


@given(
    directions, st.lists(st.sampled_from([0.0, 1e-17, 1e-9, 0.5, 1.0, 1.0 + 1e-15]), min_size=3, max_size=3)
)
@settings(max_examples=300, deadline=None)
def test_equal_and_nearly_equal_eigenvalues(q, values):
    a = q @ np.diag(values) @ q.T
    check(0.5 * (a + a.T))


@pytest.mark.parametrize(
    "a", [np.zeros((3, 3)), np.eye(3), np.diag([1, 1, 0]), np.diag([1, 0, 0]), np.ones((3, 3))]
)
def test_matrices_of_low_rank(a):
    check(a)


@kernel
def _first(entries, of_lanes, of_numbers):
    x, y, z = metric_tensor.first_eigenvector(
        load(entries, 0), load(entries, 1), load(entries, 2),
        load(entries, 3), load(entries, 4), load(entries, 5),
    )  # fmt: skip
    store(of_lanes, 0, x)
    store(of_lanes, 1, y)
    store(of_lanes, 2, z)
    for i in range(4):
        of_numbers[0, i], of_numbers[1, i], of_numbers[2, i] = metric_tensor.first_eigenvector(
            entries[0, i], entries[1, i], entries[2, i], entries[3, i], entries[4, i], entries[5, i]
        )


@pytest.mark.parametrize("scale", [1e-150, 1.0, 1e150])
def test_first_eigenvector_where_it_stands_apart(scale):
    random = np.random.default_rng(1)
    for spread_of_others in ([0.0, 0.0], [1e-9, 0.0], [0.3, 0.3], [0.45, 0.1]):
        axes = [np.linalg.qr(random.normal(size=(3, 3)))[0] for _ in range(4)]
        tensors = [scale * q @ np.diag([1.0, *spread_of_others]) @ q.T for q in axes]
        entries = np.array([tensor[np.triu_indices(3)] for tensor in tensors]).T.copy()
        of_lanes, of_numbers = np.empty((3, 4)), np.empty((3, 4))
        _first(entries, of_lanes, of_numbers)
        np.testing.assert_array_equal(of_lanes, of_numbers)
        first = np.array([q[:, 0] for q in axes]).T
        first *= np.sign((first * of_lanes).sum(axis=0))
        np.testing.assert_allclose(of_lanes, first, atol=1e-14)


def test_no_first_eigenvector_where_another_stands_apart():
    entries = np.array([[0.0, 1.0, 1.0, 1.0], [0.0] * 4, [0.0] * 4, [0.0, 1.0, 0.9, 1.0], [0.0] * 4,
                        [0.0, 1.0, 0.1, 0.0]])  # fmt: skip
    of_lanes, of_numbers = np.empty((3, 4)), np.empty((3, 4))
    _first(entries, of_lanes, of_numbers)
    assert (of_lanes == 0).all()
    assert (of_numbers == 0).all()


@pytest.mark.parametrize("weight", metric_tensor.WEIGHTS)
@pytest.mark.parametrize("name", meshes.USUAL)
def test_tensor_is_the_sum_over_the_faces(name, weight):
    mesh = meshes.USUAL[name]()
    values, vectors, sums = metric_tensor.eigen_systems(mesh, adjacency.build(mesh), weight)
    tensors, expected = reference.metric_tensors(mesh, weight)
    rebuilt = np.einsum("vi,vij,vik->vjk", values, vectors, vectors)
    np.testing.assert_allclose(rebuilt, tensors, atol=1e-13 * np.abs(tensors).max())
    np.testing.assert_allclose(sums, expected, atol=1e-13 * np.abs(expected).max())
    assert (np.einsum("vj,vj->v", vectors[:, 0], sums) >= 0).all()


def test_plane_edge_and_corner_of_a_cube():
    mesh = meshes.cube(4)
    values, vectors, _ = metric_tensor.eigen_systems(mesh, adjacency.build(mesh))
    ratios = values[:, 1:] / values[:, :1]
    on_planes = ((mesh.points == 0) | (mesh.points == 4)).sum(axis=1)
    expected = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]])
    np.testing.assert_allclose(ratios, expected[on_planes - 1], atol=1e-14)
    along = (mesh.points[on_planes == 2] != 0) & (mesh.points[on_planes == 2] != 4)
    np.testing.assert_allclose(np.abs(vectors[on_planes == 2, 2]), along, atol=1e-14)


@pytest.mark.parametrize("angle", [10, 45, 90, 120])
def test_ratio_of_a_ridge_is_the_tangent_of_half_the_angle_squared(angle):
    turn = np.radians(angle)
    points = [[0, -1, 0], [0, 1, 0], [-1, 0, 0], [np.cos(turn), 0, -np.sin(turn)]]
    mesh = Mesh.from_faces(points, [[0, 1, 2], [1, 0, 3]])
    values, vectors, _ = metric_tensor.eigen_systems(mesh, adjacency.build(mesh))
    ratio = np.tan(turn / 2) ** 2
    assert values[0, 1] / values[0, 0] == pytest.approx(min(ratio, 1 / ratio), rel=1e-12)
    np.testing.assert_allclose(np.abs(vectors[0, 2]), [0, 1, 0], atol=1e-14)


@pytest.mark.parametrize("size", [1e-60, 1e-6, 1e6, 1e60])
def test_vectors_do_not_depend_on_the_scale(size):
    mesh = meshes.USUAL["mixed torus"]()
    near = adjacency.build(mesh)
    values, vectors, _ = metric_tensor.eigen_systems(mesh, near)
    other_values, other_vectors, _ = metric_tensor.eigen_systems(mesh.with_points(mesh.points * size), near)
    np.testing.assert_allclose(other_values / size**2, values, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(other_vectors[:, 0], vectors[:, 0], atol=1e-9)


@pytest.mark.parametrize("name", meshes.HOSTILE)
def test_hostile_meshes_have_orthonormal_vectors(name):
    mesh = meshes.HOSTILE[name]()
    values, vectors, _ = metric_tensor.eigen_systems(mesh, adjacency.build(mesh), "angle")
    assert np.isfinite(values).all()
    assert (values >= -1e-12).all()
    np.testing.assert_allclose(
        vectors @ vectors.transpose(0, 2, 1), np.broadcast_to(np.eye(3), vectors.shape), atol=1e-13
    )
