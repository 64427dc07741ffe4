"""Implicit steps: the solution of their system, however large the step, the flow and the distance."""

import json

import meshes
import numpy as np
import pytest
import pyvista as pv
import reference

from vtksmooth import InstallationSpaceSmoothing, LaplacianSmoothing, ParameterError, samples
from vtksmooth.cli import main
from vtksmooth.kernels.smoothing import loop
from vtksmooth.kernels.smoothing.constraints.blend import Blend
from vtksmooth.kernels.smoothing.constraints.local_volume import LocalVolume
from vtksmooth.kernels.smoothing.schemes import implicit
from vtksmooth.kernels.smoothing.schemes.implicit import TOLERANCE, Implicit
from vtksmooth.kernels.smoothing.schemes.umbrella import Umbrella
from vtksmooth.kernels.smoothing.weights import KINDS, Weights

SURFACES = {
    "sheet": lambda: meshes.sheet(8, 6, jitter=0.2, bump=2.0),
    "mixed sheet": lambda: meshes.sheet(8, 6, "mixed", jitter=0.2, bump=2.0),
    "torus": lambda: meshes.torus(12, 8, jitter=0.2),
    "isolated points": meshes.isolated_points,
}


def laplacian(mesh, kind, flow=None, flow_weight=0.0):
    """The matrix of L from the definitions."""
    points, matrix = mesh.points, np.zeros((mesh.n_points, mesh.n_points))
    normals = reference.vertex_normals(mesh)
    for v, ring in enumerate(reference.one_rings(mesh)):
        if kind == "cotangent":
            weights = reference.cotangent_weights(mesh, v)
        elif kind == "scale-dependent":
            weights = {w: 1.0 / np.linalg.norm(points[w] - points[v]) for w in ring}
        else:
            weights = dict.fromkeys(ring, 1.0)
        across = np.eye(3) - np.outer(normals[v], normals[v]) / max(normals[v] @ normals[v], 1e-300)
        for w, weight in weights.items():
            if flow is not None:
                along, edge = across @ flow[v], across @ (points[w] - points[v])
                weight *= 1.0 + flow_weight * (along @ edge) ** 2 / (along @ along) / (edge @ edge)
            matrix[v, w] = weight
        total = matrix[v].sum()
        if total > 0.0:
            matrix[v] /= total
            matrix[v, v] = -1.0
    return matrix


def solution(mesh, matrix, step, thin_plate=False):
    """The dense solution, and the longest explicit step."""
    inner = (np.array(reference.boundaries(mesh)[0]) == 0).astype(float)[:, None]
    points = np.nan_to_num(mesh.points)
    operator = inner * (-matrix @ (inner * matrix) if thin_plate else matrix)
    found = np.linalg.solve(np.eye(len(points)) - step * operator, points)
    return found, np.abs(step * operator @ points).max()


@pytest.mark.parametrize("step", [0.0, 0.5, 10.0, 10_000.0])
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", SURFACES)
def test_the_solution_is_that_of_the_dense_system(name, kind, step):
    mesh = SURFACES[name]()
    expected, longest = solution(mesh, laplacian(mesh, kind), step)
    points, _ = loop.smooth(mesh, Implicit(Weights(kind), step), iterations=1)
    error = np.abs(np.nan_to_num(points) - expected).max()
    assert error <= TOLERANCE * (1 + 2 * step) * longest + 1e-12 * np.nanmax(np.abs(mesh.points))


@pytest.mark.parametrize("step", [0.5, 10.0, 1000.0])
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", ["sheet", "torus"])
def test_the_thin_plate(name, kind, step):
    mesh = SURFACES[name]()
    expected, _ = solution(mesh, laplacian(mesh, kind), step, thin_plate=True)
    points, _ = loop.smooth(mesh, Implicit(Weights(kind), step, thin_plate=True), iterations=1)
    np.testing.assert_allclose(points, expected, atol=1e-8)


@pytest.mark.parametrize(("flow_weight", "step"), [(3.0, 10.0), (3.0, 1000.0), (1e6, 1000.0)])
def test_along_any_flow(flow_weight, step):
    # Every vertex has a flow of its own: the weights are as little symmetric as they can be.
    mesh = SURFACES["torus"]()
    flow = np.random.default_rng(1).normal(size=mesh.points.shape)
    matrix = laplacian(mesh, "umbrella", flow, flow_weight)
    if flow_weight > 3.0:
        assert np.abs(np.linalg.eigvals(matrix).imag).max() > 0.2
    expected, longest = solution(mesh, matrix, step)
    weights = Weights("umbrella", flow, flow_weight)
    points, _ = loop.smooth(mesh, Implicit(weights, step), iterations=1)
    assert np.abs(points - expected).max() <= TOLERANCE * (1 + 2 * step) * longest + 1e-12


def test_jacobi_s_iteration_comes_last(monkeypatch):
    monkeypatch.setattr(implicit, "_HEIGHTS", (1.0,))
    mesh = SURFACES["torus"]()
    flow = np.random.default_rng(1).normal(size=mesh.points.shape)
    expected, _ = solution(mesh, laplacian(mesh, "umbrella", flow, 1e6), 30.0)
    points, _ = loop.smooth(mesh, Implicit(Weights("umbrella", flow, 1e6), 30.0), iterations=1)
    np.testing.assert_allclose(points, expected, atol=1e-10)


def test_a_system_that_is_not_solved_is_an_error(monkeypatch):
    monkeypatch.setattr(implicit, "_HEIGHTS", (0.0,))
    mesh = SURFACES["torus"]()
    flow = np.random.default_rng(1).normal(size=mesh.points.shape)
    with pytest.raises(ParameterError, match="smaller step"):
        loop.smooth(mesh, Implicit(Weights("umbrella", flow, 1e6), 1000.0), iterations=1)


def test_far_from_the_origin():
    mesh, shift = SURFACES["torus"](), 2.0**20 * np.array([1.0, 0.0, -1.0])
    far = mesh.with_points(mesh.points + shift)
    near = mesh.with_points(far.points - shift)
    expected, points = (loop.smooth(m, Implicit(Weights(), 100.0), iterations=1)[0] for m in (near, far))
    np.testing.assert_allclose(points - shift, expected, atol=2.0**-31)


@pytest.mark.parametrize("step", [0.0, 5e-324, 1e-20])
def test_steps_that_are_next_to_none_move_next_to_nothing(step):
    before = pv.wrap(meshes.polydata(SURFACES["sheet"]()))
    after = pv.wrap(LaplacianSmoothing(iterations=2, implicit_step=step)(before))
    np.testing.assert_allclose(after.points, before.points, rtol=0, atol=1e-15)


def test_small_steps_are_those_of_the_explicit_scheme():
    mesh = SURFACES["sheet"]()
    solved, stepped = (
        loop.smooth(mesh, scheme, iterations=1)[0] - mesh.points
        for scheme in (Implicit(Weights(), 1e-6), Umbrella(1e-6))
    )
    np.testing.assert_allclose(solved, stepped, atol=1e-11)


@pytest.mark.parametrize("kind", KINDS)
def test_nothing_overshoots_however_large_the_step(kind):
    mesh = meshes.sheet(12, 10, jitter=0.3, bump=3.0)
    held = np.random.default_rng(0).random(mesh.n_points) < 0.1
    mesh.points[held] *= 1.5
    low, high = mesh.points.min(axis=0), mesh.points.max(axis=0)
    for step in (1.0, 100.0, 10_000.0):
        points, _ = loop.smooth(mesh, Implicit(Weights(kind), step), iterations=5, fixed=held)
        assert points[held].tobytes() == mesh.points[held].tobytes()
        assert (points >= low - 1e-9).all()
        assert (points <= high + 1e-9).all()
    if kind == "umbrella":  # the weights stay what they are: in the limit L vanishes where points are free
        free = (np.array(reference.boundaries(mesh)[0]) == 0) & ~held
        assert np.abs(laplacian(mesh, kind) @ points)[free].max() < 1e-9


def test_weights_that_dampen_and_the_volume_are_obeyed_after_the_solve():
    mesh = SURFACES["torus"]()
    scheme = Implicit(Weights("cotangent"), 5.0)
    step = loop.smooth(mesh, scheme, iterations=1)[0] - mesh.points
    blend = np.random.default_rng(0).choice([0.25, 1.0], mesh.n_points)
    part = loop.smooth(mesh, scheme, [Blend(blend)], iterations=1)[0] - mesh.points
    np.testing.assert_allclose(part, blend[:, None] * step, atol=1e-13)
    _, report = loop.smooth(mesh, scheme, [LocalVolume(0)], iterations=5)
    assert report.volume[1] == pytest.approx(report.volume[0], rel=1e-13)
    _, free = loop.smooth(mesh, scheme, iterations=5)
    assert free.volume[1] < 0.8 * free.volume[0]


# -- filters and the command line --------------------------------------------------------------------


@pytest.mark.parametrize("scheme", ["umbrella", "scale-dependent", "cotangent", "thin-plate"])
def test_the_filter(scheme, tmp_path, capsys):
    sphere = pv.Sphere(theta_resolution=12, phi_resolution=12)
    weights = {"weights": "cotangent"} if scheme == "thin-plate" else {}
    filter = LaplacianSmoothing(scheme=scheme, implicit_step=25.0, iterations=2, **weights)
    result = pv.wrap(filter(sphere))
    kind, plate = ("cotangent", True) if scheme == "thin-plate" else (scheme, False)
    mesh = meshes.Mesh.from_faces(sphere.points, sphere.regular_faces.tolist())
    expected, _ = loop.smooth(mesh, Implicit(Weights(kind), 25.0, plate), iterations=2)
    np.testing.assert_array_equal(result.points, expected.astype(np.float32))
    sphere.save(tmp_path / "in.vtp")
    command = ["laplacian", str(tmp_path / "in.vtp"), str(tmp_path / "out.vtp"), "--json"]
    options = ["--scheme", scheme, "--implicit-step", "25", "--iterations", "2"]
    options += ["--weights", "cotangent"] if weights else []
    assert main(command + options) == 0
    assert json.loads(capsys.readouterr().out)["iterations"] == 2
    np.testing.assert_array_equal(pv.read(tmp_path / "out.vtp").points, result.points)


@pytest.mark.parametrize("scheme", ["taubin", "pairwise", "odt"])
def test_schemes_without_implicit_steps_say_so(scheme):
    with pytest.raises(ParameterError, match=f"implicit_step=5.0 has no effect with scheme='{scheme}'"):
        LaplacianSmoothing(scheme=scheme, implicit_step=5.0)(pv.Sphere())


def test_in_an_installation_space():
    sim, inst = samples.channel()
    smoothing = InstallationSpaceSmoothing(
        scheme="thin-plate", implicit_step=10.0, iterations=5, flow="Flow", flow_weight=1.0
    )
    result = pv.wrap(smoothing(sim, inst))
    assert smoothing.report.outside == smoothing.report.crossing == (0, 0)
    still = result["BlendWeight"] == 0
    assert result.points[still].tobytes() == sim.points[still].tobytes()
    inner = (result["Fixed"] == 0) & (sim.points[:, 0] > 1) & (sim.points[:, 0] < 45)
    before, after = (np.sqrt(np.mean(samples.flow_distance(m.points)[inner] ** 2)) for m in (sim, result))
    assert after < 0.5 * before
