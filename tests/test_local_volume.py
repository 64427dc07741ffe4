"""Local volume against its definition, and what it promises for any mesh."""

import meshes
import numpy as np
import pytest
import reference
from hypothesis import given, settings
from hypothesis import strategies as st
from schemes import SCHEMES
from test_invariants import surfaces
from test_no_inversion import OneByOne, To
from test_swept_volume import shares
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkDoubleArray
from vtkmodules.vtkFiltersCore import vtkImplicitPolyDataDistance

from vtksmooth import ParameterError
from vtksmooth.kernels.features import detection
from vtksmooth.kernels.measures import aspect_ratio, comparison
from vtksmooth.kernels.mesh import adjacency
from vtksmooth.kernels.mesh.mesh import Mesh
from vtksmooth.kernels.smoothing import loop
from vtksmooth.kernels.smoothing.constraints import local_volume
from vtksmooth.kernels.smoothing.constraints.boundary import Boundary
from vtksmooth.kernels.smoothing.constraints.deviation_bound import DeviationBound
from vtksmooth.kernels.smoothing.constraints.gate import Gate
from vtksmooth.kernels.smoothing.constraints.local_volume import LocalVolume
from vtksmooth.kernels.smoothing.constraints.null_space import NullSpace
from vtksmooth.kernels.smoothing.schemes.umbrella import Umbrella

CLOSED = {
    "torus of triangles": lambda: meshes.torus(18, 8, "triangles", jitter=0.2),
    "torus of quads": lambda: meshes.torus(18, 8, "quads", jitter=0.2),
    "mixed torus": lambda: meshes.torus(18, 8, "mixed", jitter=0.1),
    "cube and sphere": lambda: meshes.joined(meshes.cube(3), meshes.icosphere(2).with_points(
        meshes.icosphere(2).points + np.random.default_rng(0).normal(0, 0.05, (162, 3)) + 10.0)),
}  # fmt: skip


def vertex_axes(mesh, v):
    """Eigenvalues, eigenvectors and weighted sum of the normals at v, the largest first; 2.1."""
    pairs = zip(meshes.lists(mesh), reference.area_vectors(mesh), strict=True)
    areas = [area for face, area in pairs if v in face]
    values, vectors = np.linalg.eigh(sum(np.outer(a, a) / np.linalg.norm(a) for a in areas))
    return values[::-1], vectors[:, ::-1], sum(areas)


def direction(mesh, v, kind):
    """(7), word by word; in a mesh without sharp edges."""
    values, vectors, b = vertex_axes(mesh, v)
    x = sum(
        (vectors[:, i] @ b / values[i] * vectors[:, i] for i in range(kind + 1)
         if values[i] > 0.003 * values[0]),
        np.zeros(3),
    )  # fmt: skip
    return x / np.linalg.norm(x)


def residuals(before, after, mesh):
    """(9): what is swept, times the hat function of each vertex."""
    return np.bincount(mesh.connectivity, shares(before, after, meshes.lists(mesh)), minlength=mesh.n_points)


@pytest.mark.parametrize("corrections", [1, 3])
# (Of the mixed torus some pentagons are concave: there steps are shortened first.)
@pytest.mark.parametrize("kind", ["triangles", "quads"])
def test_corrections_by_their_definition(kind, corrections):
    mesh = meshes.joined(meshes.torus(12, 8, kind, jitter=0.1), meshes.cube(2, kind == "triangles"))
    # The cube is pushed out of shape, so that its ridges and corners have something to correct.
    mesh.points[96:] += np.random.default_rng(5).normal(0, 0.02, (mesh.n_points - 96, 3))
    classes = detection.detect(mesh, adjacency.build(mesh)).classes
    assert {1, 2} <= set(classes.tolist())
    expected, _ = loop.smooth(mesh, Umbrella(0.05), [NullSpace()], iterations=1)
    d = np.array([direction(mesh, v, kind) for v, kind in enumerate(classes)])
    free = classes < 2
    d[~free] = 0.0
    rings = [np.array(sorted(ring)) for ring in reference.one_rings(mesh)]
    stars = [[face for face in meshes.lists(mesh) if v in face] for v in range(mesh.n_points)]
    for _ in range(corrections):
        residual = residuals(mesh.points, expected, mesh)
        answer = np.full(mesh.n_points, np.inf)
        for v in np.flatnonzero(~free):  # corners stay: their neighbours take over
            residual[rings[v][free[rings[v]]]] += residual[v] / np.count_nonzero(free[rings[v]])
        for v in np.flatnonzero(free):  # (10): what a step of one along d sweeps, exactly
            moved = expected.copy()
            moved[v] += d[v]
            answer[v] = shares(expected, moved, stars[v]).sum()
        expected = expected - (residual / answer)[:, None] * d
    volume = LocalVolume(corrections, uniform=False)
    points, report = loop.smooth(mesh, Umbrella(0.05), [NullSpace(), volume], iterations=1)
    np.testing.assert_allclose(points, expected, atol=1e-12)
    assert len(report.volume_residuals) == corrections + 1


@pytest.mark.parametrize("null_space", [False, True])
@pytest.mark.parametrize("name", CLOSED)
def test_the_largest_residual_falls_with_every_correction(name, null_space):
    mesh = CLOSED[name]()
    for kind, scheme in SCHEMES.items():
        if kind == "feature-preserving":  # there is no noise, so nothing moves
            continue
        for iterations in (1, 3):
            constraints = [NullSpace()] * null_space + [LocalVolume(5, uniform=False)]
            _, report = loop.smooth(mesh, scheme, constraints, iterations=iterations)
            found = np.array(report.volume_residuals)
            assert (found[1:] < found[:-1]).all()
            assert found[-1] < 0.5 * found[0]


@pytest.mark.parametrize("constraints", ["alone", "null space", "gate", "null space, gate"])
@pytest.mark.parametrize("name", CLOSED)
def test_closed_bodies_keep_their_volume_for_hundreds_of_iterations(name, constraints):
    mesh = CLOSED[name]()
    chosen = [NullSpace()] * ("null space" in constraints) + [LocalVolume(1)]
    chosen += [Gate("angle")] * ("gate" in constraints)
    iterations = 200 if "gate" in constraints else 1000
    _, report = loop.smooth(mesh, SCHEMES["umbrella"], chosen, iterations=iterations)
    before, after = report.volume
    assert abs(after - before) <= 1e-12 * before
    assert abs(report.swept_volume) <= 1e-12 * before
    assert report.inverted[1] <= report.inverted[0]
    assert report.moved > 0


def parts(mesh):
    """The two bodies of the mesh of cube and sphere."""
    first = mesh.points[:, 0] < 5
    faces = [face for face in meshes.lists(mesh) if first[face[0]]]
    others = [face for face in meshes.lists(mesh) if not first[face[0]]]
    return [lambda points, f=f: reference.volume(Mesh.from_faces(points, f)) for f in (faces, others)]


def test_every_body_keeps_its_own():
    mesh = CLOSED["cube and sphere"]()
    points, _ = loop.smooth(mesh, SCHEMES["umbrella"], [LocalVolume(0)], iterations=20)
    plain, _ = loop.smooth(mesh, SCHEMES["umbrella"], iterations=20)
    for volume in parts(mesh):
        assert volume(points) == pytest.approx(volume(mesh.points), rel=1e-13)
        assert volume(plain) < 0.98 * volume(mesh.points)


def test_without_the_last_step_what_is_left_depends_on_the_corrections():
    mesh = meshes.icosphere(3)
    mesh.points[:] += np.random.default_rng(1).normal(0, 0.01, mesh.points.shape)
    changes = [
        abs(loop.smooth(
            mesh, Umbrella(), [NullSpace(), LocalVolume(m, uniform=False)], iterations=20
        )[1].swept_volume)
        for m in (0, 1, 2)
    ]  # fmt: skip
    assert changes[0] > 100 * changes[1] > 100 * changes[2] > 0


@pytest.mark.parametrize("one_by_one", [False, True])
@pytest.mark.parametrize("kind", meshes.KINDS)
def test_a_prescribed_flux_is_what_the_faces_sweep(kind, one_by_one):
    mesh = meshes.torus(24, 16, kind)
    areas = np.linalg.norm(reference.area_vectors(mesh), axis=1)
    flux = areas * 0.01 * (1.0 + 0.5 * np.sin(np.arange(mesh.n_faces) // 64))
    stay = To(mesh.points)
    volume = LocalVolume(8, flux=flux)
    points, report = loop.smooth(mesh, stay, [volume, *[OneByOne()] * one_by_one], iterations=1)
    assert report.swept_volume == pytest.approx(flux.sum(), rel=1e-12)
    # And where: faces sweep more where more is asked of them.
    found = shares(mesh.points, points, meshes.lists(mesh))
    by_face = np.add.reduceat(found, mesh.offsets[:-1])
    assert np.corrcoef(by_face, flux)[0, 1] > 0.9
    if not one_by_one:
        wanted = np.bincount(mesh.connectivity, np.repeat(flux / mesh.face_sizes, mesh.face_sizes))
        np.testing.assert_allclose(residuals(mesh.points, points, mesh), wanted, rtol=0.02)


def test_a_flux_of_the_wrong_length_is_refused():
    mesh = meshes.icosphere(1)
    with pytest.raises(ParameterError, match="flux must hold one value for each of the 80 faces"):
        loop.smooth(mesh, Umbrella(), [LocalVolume(flux=np.zeros(79))], iterations=1)


def test_a_body_that_cannot_be_closed_stays():
    # One row of faces: all points are on the boundary, whose sliding nobody can make up for.
    u, v = np.meshgrid(np.linspace(0, 2, 12) ** 2 / 2, [0.0, 1.0])
    points = np.column_stack([u.ravel(), v.ravel(), np.sin(u.ravel())])
    strip = Mesh.from_faces(points, [[i, i + 1, i + 13, i + 12] for i in range(11)])
    slide = Boundary(sliding=True, corner_angle=80)
    free, _ = loop.smooth(strip, Umbrella(), [slide, LocalVolume(1, uniform=False)], iterations=2)
    held, report = loop.smooth(strip, Umbrella(), [slide, LocalVolume(1)], iterations=2)
    assert (free != points).any()
    assert abs(comparison.swept_volume(strip, strip.with_points(free))) > 1e-5
    np.testing.assert_array_equal(held, points)
    assert report.moved == 0


@pytest.mark.parametrize("kind", meshes.KINDS)
def test_a_bound_on_the_deviation_holds_all_the_same(kind):
    mesh = meshes.torus(18, 8, kind, jitter=0.2)
    distance = vtkImplicitPolyDataDistance()
    distance.SetInput(meshes.polydata(Mesh.from_faces(mesh.points, reference.triangles(mesh))))
    for gate in ([], [Gate("angle")]):
        constraints = [DeviationBound(0.01), LocalVolume(2), *gate]
        points, report = loop.smooth(mesh, Umbrella(), constraints, iterations=10)
        found = vtkDoubleArray()
        distance.FunctionValue(numpy_to_vtk(points), found)
        assert np.abs(vtk_to_numpy(found)).max() <= 0.01 * (1 + 1e-9)
        assert report.volume[1] == pytest.approx(report.volume[0], rel=1e-13)
        assert report.moved > 0
    loose, _ = loop.smooth(mesh, Umbrella(), [LocalVolume(2)], iterations=10)
    assert np.linalg.norm(loose - mesh.points, axis=1).max() > 0.05


@given(
    mesh=surfaces(),
    scheme=st.sampled_from(list(SCHEMES.values())),
    null_space=st.booleans(),
    sliding=st.booleans(),
    corrections=st.integers(0, 3),
    gate=st.sampled_from([[], [OneByOne()], [Gate("angle")]]),
)
@settings(max_examples=150)
def test_nothing_is_inverted_and_the_volume_stays(mesh, scheme, null_space, sliding, corrections, gate):
    directions = aspect_ratio.reference_directions(mesh)
    before = aspect_ratio.aspect_ratios(mesh, directions)
    constraints = [NullSpace()] * null_space + [Boundary(sliding), LocalVolume(corrections), *gate]
    for passes in range(1, 4):
        points, report = loop.smooth(mesh, scheme, constraints, iterations=passes)
        after = aspect_ratio.aspect_ratios(mesh.with_points(points), directions)
        assert not ((after < 0) & (before >= 0)).any()
        before = after
        if report.volume is not None:
            assert report.volume[1] == pytest.approx(report.volume[0], rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("name", [*meshes.HOSTILE, "cusp", "needle", "folded ring"])
def test_hostile_meshes(name):
    mesh = {**meshes.HOSTILE, "cusp": cusp, "needle": needle, "folded ring": folded_ring}[name]()
    for scheme in (SCHEMES["umbrella"], SCHEMES["trapezium-drawing"]):
        for constraints in ([LocalVolume(2)], [NullSpace(), LocalVolume(2)], [LocalVolume(2), OneByOne()]):
            points, report = loop.smooth(mesh, scheme, constraints, iterations=5)
            assert np.isfinite(points[np.unique(mesh.connectivity)]).all()
            assert report.inverted[1] <= report.inverted[0]
            if report.volume is not None:
                assert report.volume[1] == pytest.approx(report.volume[0], rel=1e-12, abs=1e-15)


def cusp():
    """Two sheets that meet in an edge at 2 degrees."""
    sheet = meshes.sheet(6, 4, jitter=0.2)
    tilted = sheet.points + sheet.points[:, :1] * [0.0, 0.0, np.tan(np.radians(2))]
    points = np.vstack([sheet.points, tilted])
    number = np.arange(len(points))
    number[len(sheet.points) :][sheet.points[:, 0] == 0] = np.flatnonzero(sheet.points[:, 0] == 0)
    upper = [[number[p + len(sheet.points)] for p in face] for face in meshes.lists(sheet)]
    return Mesh.from_faces(points, [face[::-1] for face in meshes.lists(sheet)] + upper)


def needle():
    """A sphere drawn out to a thousand times its width."""
    sphere = meshes.icosphere(2)
    return sphere.with_points(sphere.points * [1000.0, 1.0, 1.0])


def folded_ring():
    """A sphere one of whose points lies across the ring of its neighbour."""
    sphere = meshes.icosphere(2)
    points = sphere.points.copy()
    points[20] = points[20] + 2.5 * (points[30] - points[20]) / np.linalg.norm(points[30] - points[20])
    return sphere.with_points(points)


@pytest.mark.parametrize("left_out", range(4))
def test_triangles_have_a_kernel_that_agrees_with_the_general_one(left_out):
    mesh = meshes.sheet(12, 10, "triangles", jitter=0.4, bump=2.0, seed=3)
    mesh = Mesh.from_faces(mesh.points, meshes.lists(mesh)[left_out:])
    random = np.random.default_rng(5)
    after = mesh.points + 0.3 * random.normal(size=mesh.points.shape)
    reference = aspect_ratio.reference_directions(mesh)
    faces = np.array([0]), np.array([mesh.n_faces])
    for flux in (np.empty(0), random.normal(size=mesh.n_faces)):
        expected, swept = np.empty(len(mesh.connectivity)), np.empty(len(mesh.connectivity))
        area, volume, expected_volume = np.empty((mesh.n_faces, 3)), np.empty(1), np.empty(1)
        common = (mesh.connectivity, reference, flux)
        before_and_after = (*faces, mesh.points, after)
        inverted = local_volume._sweep(
            *before_and_after, mesh.offsets, *common, expected, mesh.n_faces, expected_volume
        )
        assert inverted > 0
        found = local_volume._sweep_triangles(*before_and_after, *common, swept, mesh.n_faces, volume, area)
        assert found == inverted
        np.testing.assert_allclose([volume[0], expected_volume[0]], expected.sum(), atol=1e-13)
        np.testing.assert_allclose(swept, expected, atol=1e-14)
        np.testing.assert_allclose(area, 2.0 * aspect_ratio.area_vectors(mesh.with_points(after)), atol=1e-13)
