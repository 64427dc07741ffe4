"""The low-pass scheme, against matrices, waves of known length, and surfaces that are known."""

import meshes
import numpy as np
import pytest
import pyvista as pv

from vtksmooth import (
    ContainmentCheck,
    InstallationSpaceSmoothing,
    LaplacianSmoothing,
    ParameterError,
    ValenceTriangulation,
    samples,
)
from vtksmooth.kernels.mesh import adjacency
from vtksmooth.kernels.smoothing.schemes import low_pass
from vtksmooth.kernels.smoothing.weights import Weights


def graph_and_matrix(mesh):
    near, weights = adjacency.build(mesh), Weights()
    offsets, neighbours = weights.rows(near)
    size = np.diff(offsets).astype(float)
    graph = low_pass.Graph(offsets, neighbours, weights.compute(mesh.points, near), size)
    matrix = np.eye(len(size))
    for v in range(len(size)):
        np.add.at(matrix[v], neighbours[offsets[v] : offsets[v + 1]], -1.0 / size[v])
    return graph, matrix


@pytest.mark.parametrize("strength", low_pass.STRENGTHS)
@pytest.mark.parametrize("name", ["mixed torus", "cube of triangles"])
def test_filters_are_the_functions_of_the_laplacian(name, strength):
    mesh = meshes.USUAL[name]()
    graph, matrix = graph_and_matrix(mesh)
    moves = np.random.default_rng(0).uniform(0.0, 1.0, len(matrix))
    moves[::7] = 0.0
    response = low_pass.half_height(low_pass.USUAL_FREQUENCY, strength)
    values, vectors = np.linalg.eig(moves[:, None] * matrix)
    expected = (vectors * response(values.real)) @ np.linalg.solve(vectors, mesh.points.astype(complex))
    found = graph.filtered(mesh.points, moves, low_pass.coefficients(response, 30)[None])[0]
    np.testing.assert_allclose(found, expected.real, atol=0.02 * np.ptp(mesh.points))
    np.testing.assert_allclose(found[::7], mesh.points[::7], atol=1e-13 * np.ptp(mesh.points))


@pytest.mark.parametrize("time", [2.0, 12.0, 24.0])
def test_what_is_spread_out_stays_in_sum(time):
    mesh = meshes.USUAL["mixed torus"]()
    graph, matrix = graph_and_matrix(mesh)
    amounts = np.random.default_rng(0).normal(size=(len(matrix), 2))
    spread = graph.spread(amounts, time)
    np.testing.assert_allclose(spread.sum(axis=0), amounts.sum(axis=0), atol=1e-12)
    values, vectors = np.linalg.eig(matrix)
    size = graph.sums[:, None]
    expected = (vectors * np.exp(-time * values.real)) @ np.linalg.solve(
        vectors, (amounts / size).astype(complex)
    )
    np.testing.assert_allclose(spread, size * expected.real, atol=1e-3)


@pytest.mark.parametrize("kind", ["triangles", "quads"])
@pytest.mark.parametrize(
    ("times", "left"), [(0.25, 1 / 257), (0.5, 1 / 17), (1.0, 0.5), (2.0, 16 / 17), (4.0, 256 / 257)]
)
def test_a_wave_of_the_wavelength_loses_half(kind, times, left):
    n, length = 96, 16.0
    sheet = pv.Plane(i_size=n, j_size=n, i_resolution=n, j_resolution=n)
    mesh = (sheet.triangulate() if kind == "triangles" else sheet).copy()
    mesh.points = np.asarray(mesh.points, float)
    x, y = mesh.points[:, 0], mesh.points[:, 1]
    mesh.points[:, 2] = 0.02 * np.cos(2 * np.pi * x / (times * length))
    smoothing = LaplacianSmoothing(scheme="low-pass", wavelength=length)
    result = pv.wrap(smoothing(mesh))
    inner = np.hypot(x, y) < 16.0
    wave = mesh.points[inner, 2]
    assert smoothing.report.wavelength == pytest.approx(length)
    # What is given back locally adds to what the filter leaves; short waves have a frequency of their own.
    assert (result.points[inner, 2] @ wave) / (wave @ wave) == pytest.approx(left, abs=0.06)


def rms(points):
    return float(np.sqrt((samples.torus_distance(points) ** 2).mean()))


def test_a_torus_of_voxels():
    skin = pv.wrap(ValenceTriangulation()(samples.voxel_torus()))
    skin.points = np.asarray(skin.points, float)
    smoothing = LaplacianSmoothing(scheme="low-pass", preserve_volume=True)
    result = pv.wrap(smoothing(skin))
    before, after = smoothing.report.volume
    assert abs(after / before - 1.0) < 1e-14
    assert rms(result.points) < 0.044 < 0.3 < rms(skin.points)
    assert smoothing.report.inverted[1] == 0
    assert smoothing.report.stop_reason == "target"
    assert smoothing.report.wavelength == pytest.approx(15.0, rel=0.02)


@pytest.mark.parametrize(("refinement", "bound", "away"), [(1, 0.08, 0.06), (2, 0.06, 0.047)])
def test_a_channel_in_its_space(refinement, bound, away):
    channel, space = samples.channel(refinement)
    smoothing = InstallationSpaceSmoothing(scheme="low-pass", preserve_volume=True, curvature_radius=None)
    result = pv.wrap(smoothing(channel, space))
    x = channel.points[:, 0]
    free = (result["Fixed"] == 0) & (x > 1) & (x < 45)
    near = result["Fixed"] != 0
    for _ in range(4):
        near[result.regular_faces[near[result.regular_faces].any(axis=1)]] = True
    # The true surface is that of the flow, or the space's walls where the flow is beyond them.
    walls = result.compute_implicit_distance(space.triangulate())["implicit_distance"]
    off = refinement * np.maximum(samples.flow_distance(result.points), walls)
    check = ContainmentCheck()
    check(result, space)
    assert check.summary["vertices_outside"] == check.summary["triangles_crossing"] == 0
    assert abs(smoothing.report.swept_volume) < 1e-12 * space.volume
    assert np.sqrt((off[free] ** 2).mean()) < bound
    assert np.sqrt((off[free & ~near] ** 2).mean()) < away
    same = (result["BlendWeight"] == 0) & (result["Fixed"] != 0)
    np.testing.assert_array_equal(result.points[same], channel.points[same])


def test_a_surface_that_is_smooth_stays_one():
    ball = pv.Icosphere(nsub=4)
    ball.points = np.asarray(ball.points, float)
    result = pv.wrap(LaplacianSmoothing(scheme="low-pass", preserve_volume=True)(ball))
    edge = np.sqrt(4.0 / np.sqrt(3.0) * ball.area / ball.n_cells)
    # What counts as noise is 0.15 edges; vertices with five neighbours need some of it.
    off = np.linalg.norm(result.points, axis=1) - 1.0
    assert np.abs(off).max() < 0.15 * edge
    assert np.sqrt((off**2).mean()) < 0.035 * edge


def test_the_longer_the_wavelength_the_smoother():
    skin = pv.wrap(ValenceTriangulation()(samples.voxel_torus()))
    found = []
    for wavelength in (0.0, 4.0, 8.0, 15.0):
        smoothing = LaplacianSmoothing(scheme="low-pass", wavelength=wavelength, preserve_volume=True)
        found.append(rms(np.asarray(pv.wrap(smoothing(skin)).points, float)))
    assert found[0] == pytest.approx(rms(skin.points), abs=1e-6)
    assert found == sorted(found, reverse=True)


def test_far_from_the_origin_and_in_other_units_it_is_the_same():
    skin = pv.wrap(ValenceTriangulation()(samples.voxel_torus(5.0, 12.0)))
    skin.points = np.asarray(skin.points, float)
    here = pv.wrap(LaplacianSmoothing(scheme="low-pass")(skin)).points
    moved = skin.copy()
    moved.points = 1e-3 * skin.points + 100.0
    there = pv.wrap(LaplacianSmoothing(scheme="low-pass")(moved)).points
    np.testing.assert_allclose(1e3 * (there - 100.0), here, atol=1e-9)


def test_a_wavelength_without_the_scheme_is_refused():
    with pytest.raises(ParameterError, match="wavelength"):
        LaplacianSmoothing(wavelength=3.0)(pv.Sphere())
    with pytest.raises(ParameterError, match="relaxation_factor"):
        LaplacianSmoothing(scheme="low-pass", relaxation_factor=0.3)(pv.Sphere())
