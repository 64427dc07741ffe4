import meshes
import numpy as np
import pytest
import reference
from hypothesis import given, settings
from hypothesis import strategies as st
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkFiltersVerdict import vtkMeshQuality

from vtksmooth.kernels import quality
from vtksmooth.kernels.mesh import Mesh

UP = np.array([[0.0, 0.0, 1.0]])


def k_of(*corners):
    """k of one face in the plane, seen from above."""
    points = np.column_stack([np.array(corners, float), np.zeros(len(corners))])
    return quality.aspect_ratios(Mesh.from_faces(points, [range(len(corners))]), UP)[0]


def test_triangles_of_known_shape():
    assert k_of((0, 0), (1, 0), (0.5, 0.75**0.5)) == pytest.approx(1, abs=1e-15)
    assert k_of((0, 0), (0.5, 0.75**0.5), (1, 0)) == pytest.approx(-1, abs=1e-15)
    assert k_of((0, 0), (1, 0), (0, 1)) == pytest.approx(3**0.5 / 2)
    assert k_of((0, 0), (1, 0), (3, 0)) == 0
    assert k_of((0, 0), (0, 0), (3, 0)) == 0
    assert k_of((1, 1), (1, 1), (1, 1)) == 0


def test_quadrilaterals_of_known_shape():
    assert k_of((0, 0), (1, 0), (1, 1), (0, 1)) == pytest.approx(1, abs=1e-15)
    assert k_of((0, 0), (0, 1), (1, 1), (1, 0)) == pytest.approx(-1, abs=1e-15)
    # A rectangle 2 x 1: area 1 at every corner, sum of squares 10, diagonal of square 5.
    assert k_of((0, 0), (2, 0), (2, 1), (0, 1)) == pytest.approx(4 * 2**0.5 / 50**0.5)
    assert k_of((0, 0), (2, 0), (0.5, 0.5), (0, 2)) < 0, "concave"
    assert k_of((0, 0), (2, 0), (0, 2), (0.5, 0.5)) < 0, "concave at another corner"
    assert k_of((0, 0), (1, 1), (1, 0), (0, 1)) < 0, "crossing itself"
    assert k_of((0, 0), (2, 0), (1, 1), (0, 2)) == pytest.approx(0, abs=1e-12), "a corner of 180 degrees"
    assert k_of((0, 0), (1, 0), (1, 0), (0, 1)) == 0, "two corners in one place"
    assert k_of((2, 3), (2, 3), (2, 3), (2, 3)) == 0


@pytest.mark.parametrize("n", range(3, 13))
def test_regular_polygons(n):
    corners = 7.0 * reference.regular_polygon(n)[:, :2] + 3.0
    assert k_of(*corners) == pytest.approx(1, abs=1e-13)
    assert k_of(*corners[::-1]) == pytest.approx(-1, abs=1e-13)


def test_faces_without_an_area():
    mesh = Mesh.from_faces(np.eye(3), [[0, 1], [2], [], [0, 1, 2]])
    k = quality.aspect_ratios(mesh, quality.reference_directions(mesh))
    np.testing.assert_allclose(k, [0, 0, 0, 1], atol=1e-15)


@given(seed=st.integers(0, 2**32), size=st.integers(3, 8))
@settings(max_examples=200)
def test_any_face_like_the_definition(seed, size):
    random = np.random.default_rng(seed)
    corners = random.normal(size=(size, 3))
    direction = random.normal(size=(1, 3))
    k = quality.aspect_ratios(Mesh.from_faces(corners, [range(size)]), direction)[0]
    assert k == pytest.approx(reference.aspect_ratio(corners, direction[0]), abs=1e-13)
    flat = np.column_stack([corners[:, :2], np.zeros(size)])
    if size <= 4:
        assert quality.aspect_ratios(Mesh.from_faces(flat, [range(size)]), UP)[0] <= 1 + 1e-15


@pytest.mark.parametrize(
    "name", [*meshes.USUAL, "folded_quads", "misoriented", "moebius", "degenerate_faces"]
)
def test_meshes_like_the_definition(name):
    mesh = {**meshes.USUAL, **meshes.HOSTILE}[name]()
    np.testing.assert_allclose(quality.area_vectors(mesh), reference.area_vectors(mesh), atol=1e-13)
    np.testing.assert_allclose(quality.ring_normals(mesh), reference.vertex_normals(mesh), atol=1e-13)
    directions = quality.reference_directions(mesh)
    expected_directions = reference.reference_directions(mesh)
    lengths = np.linalg.norm(expected_directions, axis=1, keepdims=True)
    np.testing.assert_allclose(directions, expected_directions / np.where(lengths > 0, lengths, 1), atol=1e-6)
    expected = reference.aspect_ratios(mesh, directions)
    np.testing.assert_allclose(quality.aspect_ratios(mesh, directions), expected, atol=1e-13)


@pytest.mark.parametrize("name", ["sheet of triangles", "torus of triangles", "sphere", "high_valence"])
def test_triangles_like_vtk(name):
    # VTK's "aspect Frobenius" of a triangle is the sum of squared sides over 4 sqrt(3) area: 1 / k.
    mesh = {**meshes.USUAL, **meshes.HOSTILE}[name]()
    filter = vtkMeshQuality()
    filter.SetInputData(meshes.polydata(mesh))
    filter.SetTriangleQualityMeasureToAspectFrobenius()
    filter.Update()
    theirs = vtk_to_numpy(filter.GetOutput().GetCellData().GetArray("Quality"))
    k = quality.aspect_ratios(mesh, quality.reference_directions(mesh))
    np.testing.assert_allclose(np.abs(k), 1 / theirs, rtol=1e-9)


def test_a_folded_face_is_negative_in_its_surroundings_and_positive_once_mended():
    mesh = meshes.sheet(4, 4)
    folded = mesh.points.copy()
    folded[12] += [1.7, 0.2, 0]
    folded = mesh.with_points(folded)
    directions = quality.reference_directions(folded)
    assert (quality.aspect_ratios(folded, directions) < 0).any()
    assert (quality.aspect_ratios(mesh, directions) > 0).all()


@pytest.mark.parametrize("scale", [1e-60, 1e-12, 1.0, 1e12, 1e60])
@pytest.mark.parametrize("kind", meshes.KINDS)
def test_scale_does_not_matter(kind, scale):
    mesh = meshes.torus(12, 8, kind, jitter=0.2)
    expected = quality.aspect_ratios(mesh, quality.reference_directions(mesh))
    scaled = mesh.with_points(mesh.points * scale)
    k = quality.aspect_ratios(scaled, quality.reference_directions(scaled))
    np.testing.assert_allclose(k, expected, rtol=1e-12)


def test_histogram_in_the_papers_bins():
    assert quality.histogram(np.array([-1, -1e-9, 0, 0.19, 0.2, 0.4, 0.6, 0.8, 0.99, 1])) == [
        20.0, 20.0, 10.0, 10.0, 10.0, 30.0,
    ]  # fmt: skip
    assert quality.histogram(np.empty(0)) == [0.0] * 6
