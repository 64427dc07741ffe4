import meshes
import numpy as np
import pytest

from vtksmooth.errors import InvalidMeshError
from vtksmooth.kernels.mesh.mesh import Mesh

TRIANGLE = [[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]
OFFSETS, CONNECTIVITY = [0, 3], [0, 1, 2]


def changed(index, value):
    points = np.array(TRIANGLE)
    points[index] = value
    return points


@pytest.mark.parametrize(
    ("points", "offsets", "connectivity", "words"),
    [
        (np.empty((0, 3)), [0], [], "no points"),
        ([], [0], [], "shape"),
        (np.zeros((3, 2)), OFFSETS, CONNECTIVITY, "shape"),
        (TRIANGLE, [0], [], "no faces"),
        (TRIANGLE, [], [], "no faces"),
        (TRIANGLE, [1, 3], CONNECTIVITY, "offsets"),
        (TRIANGLE, [0, 2], CONNECTIVITY, "offsets"),
        (TRIANGLE, [0, 4], CONNECTIVITY, "offsets"),
        (TRIANGLE, [0, 3, 1, 3], CONNECTIVITY, "offsets"),
        (TRIANGLE, [0, 2**40, 3], CONNECTIVITY, "offsets"),
        (TRIANGLE, OFFSETS, [0, 1, 3], "point 3"),
        (TRIANGLE, OFFSETS, [0, -1, 2], "point -1"),
        (TRIANGLE, OFFSETS, [0, 1, 2**40], str(2**40)),
        (TRIANGLE, OFFSETS, [0, 1, -(2**40)], str(-(2**40))),
        (TRIANGLE, OFFSETS, [0.0, 1.5, 2.0], "integers"),
        (TRIANGLE, OFFSETS, [0.0, np.nan, 2.0], "integers"),
        (TRIANGLE, [0.0, 3.0], CONNECTIVITY, "integers"),
        (TRIANGLE, OFFSETS, [CONNECTIVITY], "one-dimensional"),
        (changed((1, 2), np.nan), OFFSETS, CONNECTIVITY, "point 1"),
        (changed((2, 0), np.inf), OFFSETS, CONNECTIVITY, "point 2"),
        (changed((2, 0), -np.inf), OFFSETS, CONNECTIVITY, "NaN or infinite"),
        (changed((0, 1), 1e200), OFFSETS, CONNECTIVITY, "scale"),
        (changed((0, 1), -1e200), OFFSETS, CONNECTIVITY, "scale"),
        (1e-80 * np.array(TRIANGLE), OFFSETS, CONNECTIVITY, "1e-80 only, .* scale the mesh up"),
    ],
)
def test_broken_arrays_are_refused_in_words(points, offsets, connectivity, words):
    with pytest.raises(InvalidMeshError, match=words):
        Mesh.from_arrays(points, offsets, connectivity)


def test_no_faces_at_all():
    with pytest.raises(InvalidMeshError, match="no faces"):
        Mesh.from_faces(TRIANGLE, [])


@pytest.mark.parametrize("dtype", [np.int32, np.int64, np.uint16, np.uint64])
def test_index_types(dtype):
    mesh = Mesh.from_arrays(np.float32(TRIANGLE), np.array(OFFSETS, dtype), np.array(CONNECTIVITY, dtype))
    assert mesh.points.dtype == np.float64
    assert mesh.offsets.dtype == mesh.connectivity.dtype == np.int32
    assert meshes.lists(mesh) == [[0, 1, 2]]


def test_arrays_of_the_right_type_are_not_copied():
    points, offsets = np.array(TRIANGLE), np.array(OFFSETS, np.int32)
    connectivity = np.array(CONNECTIVITY, np.int32)
    mesh = Mesh.from_arrays(points, offsets, connectivity)
    assert mesh.points is points
    assert mesh.offsets is offsets
    assert mesh.connectivity is connectivity


def test_points_that_no_face_uses_may_be_anything():
    mesh = meshes.isolated_points()
    assert np.isnan(mesh.points).any()
    assert mesh.n_points == 42


def test_counts():
    mesh = meshes.sheet(4, 4, "mixed")
    assert mesh.n_points == 25
    assert sorted(set(mesh.face_sizes.tolist())) == [3, 4, 5]
    assert len(mesh.connectivity) == mesh.face_sizes.sum()
    assert not mesh.only_triangles
    assert meshes.sheet(4, 4).only_triangles
    # As many corners as triangles would have, and yet none.
    assert not Mesh.from_faces([[i, i * i, 0] for i in range(4)], [[0, 1], [0, 1, 2, 3]]).only_triangles


def test_diagonal_is_that_of_the_faces():
    assert meshes.cube(2).diagonal == pytest.approx(2 * 3**0.5)
    assert meshes.isolated_points().diagonal == pytest.approx(50**0.5)
    few = Mesh.from_faces([*TRIANGLE, [50, 50, 50]], [CONNECTIVITY])
    assert few.diagonal == pytest.approx(2**0.5)
    twice = Mesh.from_faces([*TRIANGLE, [50, 50, 50]], [CONNECTIVITY, CONNECTIVITY])
    assert twice.diagonal == pytest.approx(2**0.5)


def test_other_points_same_faces():
    mesh = meshes.sheet(2, 2)
    moved = mesh.with_points(mesh.points + 1.0)
    assert moved.connectivity is mesh.connectivity
    np.testing.assert_array_equal(moved.points, mesh.points + 1.0)
