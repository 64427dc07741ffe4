import meshes
import numpy as np
import pytest
import reference
from schemes import SCHEMES

from vtksmooth.kernels.mesh import adjacency
from vtksmooth.kernels.mesh.mesh import Mesh
from vtksmooth.kernels.smoothing import loop
from vtksmooth.kernels.smoothing.constraints.tangent_plane import TangentPlane
from vtksmooth.kernels.smoothing.schemes.angle_based import AngleBased
from vtksmooth.kernels.smoothing.schemes.angle_weighted import AngleWeighted
from vtksmooth.kernels.smoothing.schemes.area_weighted import AreaWeighted
from vtksmooth.kernels.smoothing.schemes.cotangent import Cotangent
from vtksmooth.kernels.smoothing.schemes.equilateral import Equilateral
from vtksmooth.kernels.smoothing.schemes.optimal_delaunay import OptimalDelaunay
from vtksmooth.kernels.smoothing.schemes.scale_dependent import ScaleDependent
from vtksmooth.kernels.smoothing.schemes.taubin import LARGEST_GAIN, DirectionalTaubin, Steps, Taubin
from vtksmooth.kernels.smoothing.schemes.thin_plate import ThinPlate
from vtksmooth.kernels.smoothing.schemes.trapezium import TrapeziumDrawing
from vtksmooth.kernels.smoothing.schemes.umbrella import Umbrella
from vtksmooth.kernels.smoothing.weights import Weights

SURFACES = [
    "sheet of triangles",
    "sheet of quads",
    "mixed sheet",
    "torus of triangles",
    "mixed torus",
    "sphere",
]
EVERY = {**meshes.USUAL, **meshes.HOSTILE}


def one_pass(mesh, scheme, iterations=1):
    return loop.smooth(mesh, scheme, iterations=iterations)[0]


def by_vertex(mesh, propose):
    """All interior vertices moved at once to where ``propose(v)`` says."""
    kinds, _ = reference.boundaries(mesh)
    return np.array([propose(v) if kinds[v] == 0 else mesh.points[v] for v in range(mesh.n_points)])


def rows(sets):
    return [sorted(row) for row in sets]


@pytest.fixture(params=[*SURFACES, "folded_quads", "isolated_points", "hourglass", "non_manifold_edge"])
def mesh(request):
    return EVERY[request.param]()


@pytest.mark.parametrize("relaxation", [0.3, 1.0])
def test_umbrella(mesh, relaxation):
    rings = rows(reference.one_rings(mesh))
    expected = by_vertex(mesh, lambda v: reference.umbrella(mesh.points, v, rings[v], relaxation))
    np.testing.assert_allclose(one_pass(mesh, Umbrella(relaxation)), expected, atol=1e-14)


def test_scale_dependent(mesh):
    rings = rows(reference.one_rings(mesh))
    expected = by_vertex(mesh, lambda v: reference.scale_dependent(mesh.points, v, rings[v], 0.4))
    np.testing.assert_allclose(one_pass(mesh, ScaleDependent(0.4)), expected, atol=1e-14)


def test_cotangent(mesh):
    expected = by_vertex(mesh, lambda v: reference.cotangent(mesh, v, 0.4))
    np.testing.assert_allclose(one_pass(mesh, Cotangent(0.4)), expected, atol=1e-12)


def test_thin_plate(mesh):
    rings, (kinds, _) = rows(reference.one_rings(mesh)), reference.boundaries(mesh)
    expected = by_vertex(mesh, lambda v: reference.thin_plate(mesh.points, rings, kinds, v, 0.4))
    np.testing.assert_allclose(one_pass(mesh, ThinPlate(0.4)), expected, atol=1e-14)


def test_taubin(mesh):
    rings = rows(reference.one_rings(mesh))
    outwards = 1 / (0.1 - 1 / 0.5)
    shrunk = by_vertex(mesh, lambda v: reference.umbrella(mesh.points, v, rings[v], 0.5))
    expected = by_vertex(mesh, lambda v: reference.umbrella(shrunk, v, rings[v], outwards))
    np.testing.assert_allclose(one_pass(mesh, Taubin(0.5, 0.1)), expected, atol=1e-14)


@pytest.mark.parametrize("relaxation", [1e-320, 1e-9, 0.1, 0.5, 0.7, 0.9, 1.0])
@pytest.mark.parametrize("band", [0.001, 0.1, 0.5, 0.9])
@pytest.mark.parametrize("iterations", [1, 20, 3000])
def test_no_run_of_taubin_amplifies(relaxation, band, iterations):
    steps = Steps(relaxation, band)
    frequencies = np.linspace(0, 2, 1001)
    gain = np.ones_like(frequencies)
    for _ in range(iterations):
        inwards, outwards = steps.next()
        assert inwards <= relaxation
        gain *= (1 - inwards * frequencies) * (1 - outwards * frequencies)
    kept = frequencies <= band
    assert gain[kept].min() >= 1 - 1e-12
    assert gain[kept].max() <= LARGEST_GAIN + 1e-12
    assert np.abs(gain[~kept]).max() <= 1 + 1e-9
    if steps.left == 0 and band > 0.01:
        assert gain[kept].max() > 0.999 * LARGEST_GAIN, "all is spent"


@pytest.mark.parametrize("weights", ["umbrella", "cotangent"])
@pytest.mark.parametrize("iterations", [100, 10_000])
def test_taubin_stops_before_the_body_grows(weights, iterations):
    ball = meshes.icosphere(3)
    scheme = Taubin() if weights == "umbrella" else DirectionalTaubin(Weights(weights), 0.5, 0.1)
    for _ in range(2):  # a scheme may serve several runs
        _, report = loop.smooth(ball, scheme, iterations=iterations)
        assert (report.stop_reason, report.iterations) == ("pass-band", 23)
        assert 1 <= report.volume[1] / report.volume[0] < LARGEST_GAIN**3
    report = loop.smooth(ball, scheme, iterations=23)[1]
    assert report.stop_reason == "iterations"


@pytest.mark.parametrize("scheme", [Taubin(0.0, 0.1), DirectionalTaubin(Weights("cotangent"), 0.0, 0.9)])
def test_taubin_without_relaxation_moves_nothing(scheme):
    ball = meshes.icosphere(1)
    points, _ = loop.smooth(ball, scheme, iterations=2)
    np.testing.assert_array_equal(points, ball.points)


def test_trapezium_drawing(mesh):
    # In the order of the star: of equal angles the first is taken.
    near = adjacency.build(mesh)
    star = [near.star[a:b] for a, b in zip(near.star_offsets[:-1], near.star_offsets[1:], strict=True)]
    expected = by_vertex(mesh, lambda v: reference.trapezium(mesh.points, v, star[v]))
    np.testing.assert_allclose(one_pass(mesh, TrapeziumDrawing()), expected, atol=1e-12)


def test_equilateral(mesh):
    directions = reference.reference_directions(mesh)
    expected = by_vertex(mesh, lambda v: reference.equilateral(mesh, v, directions, 0.7))
    np.testing.assert_allclose(one_pass(mesh, Equilateral(0.7)), expected, atol=1e-12)


def test_area_weighted(mesh):
    expected = by_vertex(mesh, lambda v: reference.area_weighted(mesh, v, 0.7))
    np.testing.assert_allclose(one_pass(mesh, AreaWeighted(0.7)), expected, atol=1e-13)


def test_angle_weighted(mesh):
    expected = by_vertex(mesh, lambda v: reference.angle_weighted(mesh, v, 0.7))
    np.testing.assert_allclose(one_pass(mesh, AngleWeighted(0.7)), expected, atol=1e-13)


def test_optimal_delaunay(mesh):
    expected = by_vertex(mesh, lambda v: reference.optimal_delaunay(mesh, v, 0.7))
    np.testing.assert_allclose(one_pass(mesh, OptimalDelaunay(0.7)), expected, atol=1e-12)


def test_the_equilateral_scheme_mends_flat_and_folded_corners():
    # A corner on the opposite side, or beyond it: the apex is where the reference direction says.
    for y in (0.0, -0.4):
        points = [[0.3, y, 0], [1, 0, 0], [0.5, 2.0, 0], [0, 0, 0], [0.5, -1.0, 0]]
        mesh = Mesh.from_faces(points, [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]])
        moved = one_pass(mesh, Equilateral(1.0))[0]
        assert moved[2] == 0
        assert -0.6 < moved[1] < 1.2
        alone = reference.aspect_ratios(mesh, [[0, 0, 1]] * 4).min()
        after = reference.aspect_ratios(
            mesh.with_points(np.vstack([moved, mesh.points[1:]])), [[0, 0, 1]] * 4
        )
        assert after.min() > alone


@pytest.mark.parametrize("weighted", [False, True])
@pytest.mark.parametrize("kind", meshes.KINDS)
def test_angle_based_in_the_plane(kind, weighted):
    mesh = meshes.sheet(8, 6, kind, jitter=0.2, seed=4)
    expected = by_vertex(mesh, lambda v: reference.angle_based(mesh, v, weighted))
    np.testing.assert_allclose(one_pass(mesh, AngleBased(weighted)), expected, atol=1e-13)


@pytest.mark.parametrize("name", SCHEMES)
@pytest.mark.parametrize("kind", ["triangles", "quads"])
def test_a_regular_plane_mesh_is_a_fixed_point(name, kind):
    mesh = meshes.sheet(6, 6, "quads")
    if kind == "triangles":
        equilateral = mesh.points @ [[1, 0, 0], [0.5, 0.75**0.5, 0], [0, 0, 1]]
        mesh = Mesh.from_faces(
            equilateral, [t for a, b, c, d in meshes.lists(mesh) for t in ([a, b, d], [b, c, d])]
        )
    np.testing.assert_allclose(one_pass(mesh, SCHEMES[name]), mesh.points, atol=1e-14)


@pytest.mark.parametrize("name", SCHEMES)
@pytest.mark.parametrize("kind", meshes.KINDS)
def test_a_plane_stays_a_plane(name, kind):
    mesh = meshes.sheet(8, 6, kind, jitter=0.2)
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    points = one_pass(mesh.with_points(mesh.points @ turn), SCHEMES[name], iterations=3) @ turn.T
    np.testing.assert_allclose(points[:, 2], 0, atol=1e-13)


# A flow of curvature has no work here, nor has what removes noise across the surface.
@pytest.mark.parametrize("name", sorted(SCHEMES.keys() - {"cotangent", "feature-preserving"}))
def test_a_wild_plane_gets_better(name):
    mesh = meshes.sheet(12, 12, jitter=0.3, seed=2)
    report = loop.smooth(mesh, SCHEMES[name], iterations=10)[1]
    assert report.mean_aspect_ratio[1] > report.mean_aspect_ratio[0] + 0.03


@pytest.mark.parametrize("name", ["umbrella", "scale-dependent", "cotangent"])
def test_plain_laplacians_shrink_a_sphere_and_taubin_does_not(name):
    sphere = meshes.icosphere(2)
    volume = loop.smooth(sphere, SCHEMES[name], iterations=10)[1].volume
    kept = loop.smooth(sphere, SCHEMES["taubin"], iterations=10)[1].volume
    assert volume[1] < 0.95 * volume[0]
    assert kept[1] == pytest.approx(kept[0], rel=0.03)


def test_cotangent_flow_hardly_moves_points_across_the_surface():
    mesh = meshes.icosphere(2)
    random = np.random.default_rng(0).normal(size=mesh.points.shape)
    points = mesh.points + 0.05 * (random - (random * mesh.points).sum(axis=1)[:, None] * mesh.points)
    mesh = mesh.with_points(points / np.linalg.norm(points, axis=1)[:, None])

    def across(scheme):
        step = one_pass(mesh, scheme) - mesh.points
        inwards = (step * mesh.points).sum(axis=1)
        return np.linalg.norm(step - inwards[:, None] * mesh.points, axis=1).mean()

    assert across(Cotangent(1.0)) < 0.3 * across(Umbrella(1.0))


# Two passes of Taubin's have two tangent planes; there is no noise.
@pytest.mark.parametrize("name", sorted(SCHEMES.keys() - {"taubin", "feature-preserving"}))
def test_tangent_plane(name):
    mesh = meshes.torus(18, 8, "mixed", jitter=0.1)
    points, _ = loop.smooth(mesh, SCHEMES[name], [TangentPlane()], iterations=1)
    normals = reference.vertex_normals(mesh)
    assert np.abs(points - mesh.points).max() > 1e-3
    np.testing.assert_allclose(((points - mesh.points) * normals).sum(axis=1), 0, atol=1e-14)


@pytest.mark.parametrize("name", SCHEMES)
def test_high_valence(name):
    mesh = meshes.fan(3000, height=0.2)
    points, _ = loop.smooth(mesh, SCHEMES[name], iterations=2)
    assert np.isfinite(points).all()
    np.testing.assert_array_equal(points[1:], mesh.points[1:])
    if name == "umbrella":
        np.testing.assert_allclose(points[0], 0.25 * mesh.points[0], atol=1e-12)
