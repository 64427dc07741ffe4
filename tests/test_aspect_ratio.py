import meshes
import numpy as np
import pytest
import reference
from hypothesis import given, settings
from hypothesis import strategies as st
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkFiltersVerdict import vtkMeshQuality

from vtksmooth.kernels.measures import aspect_ratio
from vtksmooth.kernels.mesh.mesh import Mesh

UP = np.array([[0.0, 0.0, 1.0]])


def k_of(*corners):
    """k of one face in the plane, seen from above."""
    points = np.column_stack([np.array(corners, float), np.zeros(len(corners))])
    return aspect_ratio.aspect_ratios(Mesh.from_faces(points, [range(len(corners))]), UP)[0]


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
    k = aspect_ratio.aspect_ratios(mesh, aspect_ratio.reference_directions(mesh))
    np.testing.assert_allclose(k, [0, 0, 0, 1], atol=1e-15)


@given(seed=st.integers(0, 2**32), size=st.integers(3, 8))
@settings(max_examples=200)
def test_any_face_like_the_definition(seed, size):
    random = np.random.default_rng(seed)
    corners = random.normal(size=(size, 3))
    direction = random.normal(size=(1, 3))
    k = aspect_ratio.aspect_ratios(Mesh.from_faces(corners, [range(size)]), direction)[0]
    assert k == pytest.approx(reference.aspect_ratio(corners, direction[0]), abs=1e-13)
    assert -1 <= k <= 1 + 1e-15


def test_a_pulled_in_quadrilateral_that_is_inverted_has_minus_1():
    # Two equilateral triangles, of which one is pulled in to a line: the formula gives -1.55.
    corners = np.array([(0, 0), (0.5, 0), (1, 0), (0.5, np.sqrt(0.75))])
    assert k_of(*corners[::-1]) == -1
    assert k_of(*corners) == 0
    mesh = Mesh.from_faces(np.column_stack([corners[::-1], np.zeros(4)]), [range(4)])
    assert aspect_ratio.aspect_ratios(mesh, UP, bounded=False)[0] == pytest.approx(-1.549, abs=1e-3)


def rotation(random):
    return np.linalg.qr(random.normal(size=(3, 3)))[0]


def k_in_space(corners):
    mesh = Mesh.from_faces(corners, [range(len(corners))])
    return aspect_ratio.aspect_ratios(mesh, aspect_ratio.reference_directions(mesh))[0]


@given(seed=st.integers(0, 2**32), size=st.integers(4, 70), amount=st.floats(1e-3, 10))
@settings(max_examples=200)
def test_a_bent_face_is_worse_than_its_projection_and_neither_exceeds_1(seed, size, amount):
    random = np.random.default_rng(seed)
    turn = rotation(random)
    corners = reference.regular_polygon(size) @ np.diag([1, random.uniform(0.2, 1), 0])
    corners[:, 2] = amount * random.normal(size=size)
    corners[:, :2] += min(amount, 0.5) * random.normal(size=(size, 2)) * random.integers(0, 2) / size
    k = k_in_space(corners @ turn)
    assert k == pytest.approx(k_in_space(7e5 * corners), abs=1e-9), "pose and size do not matter"
    vector = np.cross(corners, np.roll(corners, -1, axis=0)).sum(axis=0)
    axis = vector / np.linalg.norm(vector)
    flat = k_in_space(corners - np.outer(corners @ axis, axis))
    assert max(k, flat) <= 1 + 1e-14
    assert abs(k) <= abs(flat) * (1 + 1e-9) + 1e-12


@pytest.mark.parametrize("size", [4, 6, 12, 64, 66])
def test_k_falls_with_the_warp_of_a_regular_polygon(size):
    corners = reference.regular_polygon(size)
    raised = [corners + z * np.outer(np.arange(size) % 2, [0, 0, 1]) for z in (0, 0.01, 0.1, 0.3, 1, 10)]
    k = [k_in_space(polygon) for polygon in raised]
    assert k[0] == pytest.approx(1, abs=1e-13)
    assert (np.diff(k) < 0).all()
    assert k[-1] > 0


@pytest.mark.parametrize(("size", "step"), [(5, 2), (7, 2), (7, 3), (12, 5), (64, 3), (67, 2)])
def test_star_polygons_are_not_regular(size, step):
    # Their corner triangles are as large as those of the regular polygon, or larger.
    star = reference.regular_polygon(size)[np.arange(size) * step % size]
    assert 0 < k_in_space(star) <= np.tan(np.pi / size) / np.tan(step * np.pi / size) + 1e-12 < 0.6


@pytest.mark.parametrize("size", [4, 5, 6, 9])
def test_no_search_finds_a_polygon_better_than_the_regular_one(size):
    random = np.random.default_rng(size)
    for start in (reference.regular_polygon(size), random.normal(size=(size, 3))):
        best, k, step = start, k_in_space(start + 0.1 * random.normal(size=start.shape)), 0.1
        for _ in range(1500):
            tried = best + step * random.normal(size=(size, 3)) * (random.random((size, 1)) < 0.5)
            value = k_in_space(tried)
            step = min(0.3, 1.5 * step) if value > k else max(1e-4, 0.97 * step)
            if value > k:
                best, k = tried, value
        assert k < 1


@given(seed=st.integers(0, 2**32), size=st.integers(4, 12), amount=st.floats(1e-4, 0.5))
@settings(max_examples=200)
def test_every_other_polygon_is_worse_than_the_regular_one(seed, size, amount):
    change = np.random.default_rng(seed).normal(size=(size, 3))
    assert k_in_space(reference.regular_polygon(size) + amount * change) < 1 - 1e-9


@given(seed=st.integers(0, 2**32), size=st.integers(5, 12))
@settings(max_examples=100)
def test_of_plane_convex_polygons_the_corner_triangles_decide(seed, size):
    random = np.random.default_rng(seed)
    angle = 2 * np.pi * (np.arange(size) + random.uniform(-0.4, 0.4, size)) / size
    corners = np.column_stack([np.cos(angle), random.uniform(0.1, 1) * np.sin(angle)])
    in_space = np.column_stack([corners, np.zeros(size)])
    assert k_of(*corners) < reference.isoperimetric(in_space)


@pytest.mark.parametrize(
    "name", [*meshes.USUAL, "folded_quads", "misoriented", "moebius", "degenerate_faces"]
)
def test_meshes_like_the_definition(name):
    mesh = {**meshes.USUAL, **meshes.HOSTILE}[name]()
    np.testing.assert_allclose(aspect_ratio.area_vectors(mesh), reference.area_vectors(mesh), atol=1e-13)
    np.testing.assert_allclose(aspect_ratio.ring_normals(mesh), reference.vertex_normals(mesh), atol=1e-13)
    directions = aspect_ratio.reference_directions(mesh)
    expected_directions = reference.reference_directions(mesh)
    lengths = np.linalg.norm(expected_directions, axis=1, keepdims=True)
    np.testing.assert_allclose(directions, expected_directions / np.where(lengths > 0, lengths, 1), atol=1e-6)
    expected = reference.aspect_ratios(mesh, directions)
    np.testing.assert_allclose(aspect_ratio.aspect_ratios(mesh, directions), expected, atol=1e-13)


@pytest.mark.parametrize("name", ["sheet of triangles", "torus of triangles", "sphere", "high_valence"])
def test_triangles_like_vtk(name):
    # VTK's "aspect Frobenius" of a triangle is the sum of squared sides over 4 sqrt(3) area: 1 / k.
    mesh = {**meshes.USUAL, **meshes.HOSTILE}[name]()
    filter = vtkMeshQuality()
    filter.SetInputData(meshes.polydata(mesh))
    filter.SetTriangleQualityMeasureToAspectFrobenius()
    filter.Update()
    theirs = vtk_to_numpy(filter.GetOutput().GetCellData().GetArray("Quality"))
    k = aspect_ratio.aspect_ratios(mesh, aspect_ratio.reference_directions(mesh))
    np.testing.assert_allclose(np.abs(k), 1 / theirs, rtol=1e-9)


def test_a_folded_face_is_negative_in_its_surroundings_and_positive_once_mended():
    mesh = meshes.sheet(4, 4)
    folded = mesh.points.copy()
    folded[12] += [1.7, 0.2, 0]
    folded = mesh.with_points(folded)
    directions = aspect_ratio.reference_directions(folded)
    assert (aspect_ratio.aspect_ratios(folded, directions) < 0).any()
    assert (aspect_ratio.aspect_ratios(mesh, directions) > 0).all()


@pytest.mark.parametrize("scale", [1e-60, 1e-12, 1.0, 1e12, 1e60])
@pytest.mark.parametrize("kind", meshes.KINDS)
def test_scale_does_not_matter(kind, scale):
    mesh = meshes.torus(12, 8, kind, jitter=0.2)
    expected = aspect_ratio.aspect_ratios(mesh, aspect_ratio.reference_directions(mesh))
    scaled = mesh.with_points(mesh.points * scale)
    k = aspect_ratio.aspect_ratios(scaled, aspect_ratio.reference_directions(scaled))
    np.testing.assert_allclose(k, expected, rtol=1e-12)


def test_histogram_in_the_papers_bins():
    assert aspect_ratio.histogram(np.array([-1, -1e-9, 0, 0.19, 0.2, 0.4, 0.6, 0.8, 0.99, 1])) == [
        20.0, 20.0, 10.0, 10.0, 10.0, 30.0,
    ]  # fmt: skip
    assert aspect_ratio.histogram(np.empty(0)) == [0.0] * 6
