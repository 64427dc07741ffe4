import meshes
import numpy as np
import pytest
import reference
from hypothesis import given, settings
from hypothesis import strategies as st
from vtkmodules.vtkFiltersCore import vtkMassProperties, vtkTriangleFilter

from vtksmooth.kernels.measures import comparison
from vtksmooth.kernels.mesh import adjacency
from vtksmooth.kernels.mesh.mesh import Mesh

CLOSED = [
    "torus of triangles",
    "torus of quads",
    "mixed torus",
    "sphere",
    "cube of quads",
    "cube of triangles",
]


def thrown(mesh, amount, seed=0):
    return mesh.with_points(mesh.points + amount * np.random.default_rng(seed).normal(size=mesh.points.shape))


def rotation(seed):
    q, r = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    return q if np.linalg.det(q) > 0 else q[:, [1, 0, 2]]


def test_volumes_of_known_bodies():
    assert comparison.signed_volume(meshes.cube(3)) == pytest.approx(27, rel=1e-14)
    assert comparison.signed_volume(meshes.l_shape(triangles=True)) == pytest.approx(3, rel=1e-14)
    assert comparison.signed_volume(meshes.icosphere(4, radius=2)) == pytest.approx(32 / 3 * np.pi, rel=0.01)
    inside_out = meshes.cube(2)
    inside_out = Mesh.from_faces(inside_out.points, [face[::-1] for face in meshes.lists(inside_out)])
    assert comparison.signed_volume(inside_out) == pytest.approx(-8, rel=1e-14)


@pytest.mark.parametrize("name", CLOSED)
def test_volume_like_the_definition_also_far_away(name):
    mesh = thrown(meshes.USUAL[name](), 0.02)
    expected = reference.volume(mesh)
    assert comparison.signed_volume(mesh) == pytest.approx(expected, rel=1e-13)
    far = mesh.with_points(mesh.points + np.array([1e5, -2e5, 3e5]))
    assert comparison.signed_volume(far) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("name", ["torus of triangles", "sphere", "cube of quads", "cube of triangles"])
def test_volume_like_vtk(name):
    # VTK wants triangles; only of faces that are plane do they say the same as the bilinear patch.
    mesh = meshes.USUAL[name]()
    cut, properties = vtkTriangleFilter(), vtkMassProperties()
    cut.SetInputData(meshes.polydata(mesh))
    properties.SetInputConnection(cut.GetOutputPort())
    # vtkMassProperties weighs three estimates of the volume, equal only up to its rounding.
    assert comparison.signed_volume(mesh) == pytest.approx(properties.GetVolume(), rel=1e-4)


@pytest.mark.parametrize("name", CLOSED)
def test_swept_volume_of_a_closed_mesh_is_the_change_of_its_volume(name):
    before = thrown(meshes.USUAL[name](), 0.05, seed=1)
    middle, after = thrown(before, 0.2, seed=2), thrown(before, 0.5, seed=3)
    scale = abs(comparison.signed_volume(before))
    change = comparison.signed_volume(after) - comparison.signed_volume(before)
    assert abs(comparison.swept_volume(before, after) - change) < 1e-13 * scale
    legs = comparison.swept_volume(before, middle) + comparison.swept_volume(middle, after)
    assert abs(legs - change) < 1e-13 * scale, "it does not matter which way the points went"


def test_swept_volume_of_an_open_mesh():
    before = meshes.sheet(4, 2, "mixed")
    assert comparison.swept_volume(before, before) == 0.0
    lifted = before.with_points(before.points + np.array([0, 0, 2.0]))
    assert comparison.swept_volume(before, lifted) == pytest.approx(16, rel=1e-14)
    assert comparison.swept_volume(lifted, before) == pytest.approx(-16, rel=1e-14)
    away = [7e3, 8e3, 9e3]
    there, back = before.with_points(before.points + away), lifted.with_points(lifted.points + away)
    assert comparison.swept_volume(there, back) == pytest.approx(16, rel=1e-10), "no origin in it"


@pytest.mark.parametrize("name", CLOSED)
def test_closed(name):
    assert comparison.is_closed(adjacency.build(meshes.USUAL[name]()))


def test_closed_where_it_is_no_manifold():
    # Cells that touch along an edge, in a corner, and one of them turned inside out or open.
    for second in ((1, 1, 0), (1, 1, 1)):
        mesh = meshes.voxels([(0, 0, 0), second])
        assert comparison.is_closed(adjacency.build(mesh))
        assert comparison.signed_volume(mesh) == pytest.approx(2, rel=1e-14)
        faces = meshes.lists(mesh)
        for wrong in (faces[:-1], [*faces[:-1], faces[-1][::-1]], [*faces, faces[0]]):
            assert not comparison.is_closed(adjacency.build(Mesh.from_faces(mesh.points, wrong)))
    assert comparison.is_closed(adjacency.build(meshes.hourglass()))


@pytest.mark.parametrize("name", ["moebius", "two_components", "misoriented", "non_manifold_edge", "bow_tie"])
def test_not_closed(name):
    assert not comparison.is_closed(adjacency.build(meshes.HOSTILE[name]()))


def test_dihedral_angles_of_a_cube_and_of_an_l():
    for triangles in (False, True):
        for mesh, concave in ((meshes.cube(2, triangles), 0), (meshes.l_shape(triangles), 1)):
            degrees = comparison.dihedral_angles(mesh, *adjacency.edges(adjacency.build(mesh)))
            assert np.unique(np.round(degrees, 9)).tolist() == [-90.0] * concave + [0.0, 90.0]
            assert np.count_nonzero(degrees < -1) == concave
    assert np.count_nonzero(degrees > 1) == 21  # 22 edges of the L less the concave one, three of them halved


@pytest.mark.parametrize("name", ["sheet of triangles", "torus of quads", "mixed torus", "sphere", "moebius"])
def test_dihedral_angles_like_the_definition(name):
    mesh = thrown({**meshes.USUAL, **meshes.HOSTILE}[name](), 0.02)
    ends, faces = adjacency.edges(adjacency.build(mesh))
    found = comparison.dihedral_angles(mesh, ends, faces)
    expected = reference.dihedral_angles(mesh)
    assert len(expected) > 50
    for edge, degrees in zip(map(tuple, ends.tolist()), found, strict=True):
        assert degrees == pytest.approx(expected.get(edge, 0.0), abs=1e-5)


def test_dihedral_change():
    flat = meshes.sheet(2, 1)
    edges = adjacency.edges(adjacency.build(flat))
    x, z = flat.points[:, 0], np.zeros(6)
    bent = flat.with_points(np.column_stack([np.minimum(x, 1), flat.points[:, 1], np.maximum(x - 1, z)]))
    change = comparison.dihedral_change(flat, bent, *edges)
    middle = (flat.points[edges[0]][:, :, 0] == 1).all(axis=1)
    inner = (edges[1] >= 0).all(axis=1)
    np.testing.assert_array_equal(np.isnan(change), ~inner)
    np.testing.assert_allclose(change[inner], np.where(middle, 90, 0)[inner], atol=1e-12)
    np.testing.assert_allclose(comparison.dihedral_change(bent, flat, *edges), change)
    np.testing.assert_array_equal(comparison.dihedral_change(bent, bent, *edges)[inner], 0)


@pytest.mark.parametrize("name", ["sheet of triangles", "mixed torus", "moebius", "non_manifold_edge"])
def test_the_mean_dihedral_change_is_over_the_edges_that_have_an_angle(name):
    mesh = {**meshes.USUAL, **meshes.HOSTILE}[name]()
    after = thrown(mesh, 0.02)
    change = comparison.dihedral_change(mesh, after, *adjacency.edges(adjacency.build(mesh)))
    a, b = reference.dihedral_angles(mesh), reference.dihedral_angles(after)
    expected = np.array([abs(b[edge] - a[edge]) for edge in a])
    assert 0 < len(expected) <= len(change)
    assert np.count_nonzero(~np.isnan(change)) == len(expected)
    found = comparison.largest_and_mean(change)
    assert found == pytest.approx((expected.max(), expected.mean()), abs=1e-5)


def test_what_has_no_angle_does_not_count():
    # A face that collapses has no normal: neither have its edges an angle, nor the point of it alone.
    before = meshes.sheet(2, 1)
    collapsed = before.points.copy()
    corner = np.flatnonzero(np.bincount(before.connectivity) == 1)[0]
    face = next(f for f in meshes.lists(before) if corner in f)
    collapsed[corner] = collapsed[next(p for p in face if p != corner)]
    after = before.with_points(collapsed)
    assert np.isnan(comparison.normal_deviation(before, after)[corner])
    edges = adjacency.edges(adjacency.build(before))
    assert (
        np.isnan(comparison.dihedral_change(before, after, *edges)).sum() > (edges[1] < 0).any(axis=1).sum()
    )
    assert comparison.largest_and_mean(np.array([np.nan, np.nan])) == (0.0, 0.0)


@given(seed=st.integers(0, 2**32), degrees=st.floats(0, 180))
@settings(max_examples=40)
def test_normal_deviation_of_a_turned_plane_is_the_angle(seed, degrees):
    mesh = meshes.sheet(4, 2, "mixed", jitter=0.1, seed=seed)
    angle, turn = np.radians(degrees), rotation(seed)
    tilt = np.array([[1, 0, 0], [0, np.cos(angle), np.sin(angle)], [0, -np.sin(angle), np.cos(angle)]])
    before, after = mesh.with_points(mesh.points @ turn), mesh.with_points(mesh.points @ tilt @ turn)
    deviation = comparison.normal_deviation(before, after)
    np.testing.assert_allclose(deviation, degrees, atol=1e-9)


def test_normal_deviation_like_the_definition():
    before = meshes.torus(12, 8, "mixed", jitter=0.2)
    after = thrown(before, 0.1)
    a, b = reference.vertex_normals(before), reference.vertex_normals(after)
    cosine = (a * b).sum(axis=1) / np.linalg.norm(a, axis=1) / np.linalg.norm(b, axis=1)
    found = comparison.normal_deviation(before, after)
    np.testing.assert_allclose(found, np.degrees(np.arccos(cosine)), atol=1e-5)
    np.testing.assert_array_equal(comparison.normal_deviation(before, before), 0)


@pytest.mark.parametrize("scale", [1e-60, 1e-12, 1e12, 1e60])
def test_angles_do_not_depend_on_the_scale(scale):
    before = meshes.torus(12, 8, jitter=0.2)
    after = thrown(before, 0.1)
    small, large = before.with_points(before.points * scale), after.with_points(after.points * scale)
    near = adjacency.build(before)
    edges = adjacency.edges(near)
    expected = comparison.normal_deviation(before, after)
    np.testing.assert_allclose(comparison.normal_deviation(small, large), expected, rtol=1e-9)
    expected = comparison.dihedral_change(before, after, *edges)
    np.testing.assert_allclose(comparison.dihedral_change(small, large, *edges), expected, atol=1e-9)


@pytest.mark.parametrize("name", meshes.HOSTILE)
def test_hostile_meshes_are_measured(name):
    mesh = meshes.HOSTILE[name]()
    near = adjacency.build(mesh)
    after = thrown(mesh, 0.01)
    has_normal = [comparison.ring_normals(state).any(axis=1) for state in (mesh, after)]
    np.testing.assert_array_equal(
        np.isfinite(comparison.normal_deviation(mesh, after)), np.logical_and(*has_normal)
    )
    change = comparison.dihedral_change(mesh, after, *adjacency.edges(near))
    assert np.isfinite(comparison.largest_and_mean(change)).all()
    assert np.isfinite(comparison.swept_volume(mesh, after))
    assert np.isfinite(comparison.signed_volume(mesh))
