"""Pairwise smoothing: like its definition, exact in volume, and the same for any number of threads."""

from fractions import Fraction
from functools import partial

import meshes
import numpy as np
import pytest
import pyvista as pv
import reference
from hypothesis import given, settings
from hypothesis import strategies as st

from vtksmooth import LaplacianSmoothing
from vtksmooth.errors import Cancelled, InvalidMeshError, ParameterError
from vtksmooth.filters.arrays import surface_of
from vtksmooth.jit import parallel
from vtksmooth.kernels.distance.signed_distance import SignedDistanceTree
from vtksmooth.kernels.measures import aspect_ratio, comparison
from vtksmooth.kernels.mesh import adjacency
from vtksmooth.kernels.smoothing import loop
from vtksmooth.kernels.smoothing.constraints import Constraint
from vtksmooth.kernels.smoothing.constraints.blend import Blend
from vtksmooth.kernels.smoothing.constraints.containment import Containment
from vtksmooth.kernels.smoothing.constraints.creases import Creases
from vtksmooth.kernels.smoothing.constraints.curvature_bound import CurvatureBound
from vtksmooth.kernels.smoothing.constraints.deviation_bound import DeviationBound
from vtksmooth.kernels.smoothing.constraints.displacement_bound import DisplacementBound
from vtksmooth.kernels.smoothing.constraints.gate import Gate
from vtksmooth.kernels.smoothing.constraints.local_volume import LocalVolume
from vtksmooth.kernels.smoothing.phases import Disposal
from vtksmooth.kernels.smoothing.schemes import pairwise
from vtksmooth.kernels.smoothing.schemes.pairwise import Pairwise
from vtksmooth.kernels.smoothing.weights import KINDS, Weights


def exact_volume(mesh, points):
    """Six times the signed volume, in rational numbers."""
    p = [[Fraction(x) for x in row] for row in points.tolist()]
    total = Fraction(0)
    for i, j, k in mesh.connectivity.reshape(-1, 3).tolist():
        a, b, c = p[i], p[j], p[k]
        total += (
            a[0] * (b[1] * c[2] - b[2] * c[1])
            + a[1] * (b[2] * c[0] - b[0] * c[2])
            + a[2] * (b[0] * c[1] - b[1] * c[0])
        )
    return total


def flow_round(mesh):
    """A flow round the z axis, of different sizes."""
    x, y, z = mesh.points.T
    return np.column_stack([-y, x, 0.3 * np.ones_like(z)]) * (1 + np.arange(len(x)) % 5)[:, None]


CLOSED = {
    "torus": lambda: meshes.torus(18, 10, jitter=0.3),
    "voxels": lambda: meshes.cube(4, triangles=True),
    "concave": lambda: meshes.l_shape(triangles=True),
    "sphere": lambda: meshes.icosphere(2),
}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", CLOSED)
def test_the_volume_of_closed_meshes_stays_to_rounding(name, kind):
    mesh = CLOSED[name]()
    weights = Weights(kind, flow_round(mesh), 3.0)
    blend = np.random.default_rng(0).choice([0.0, 0.3, 1.0], mesh.n_points)
    before = exact_volume(mesh, mesh.points)
    for iterations, bound in ((1, 1e-14), (30, 1e-13)):
        points, report = loop.smooth(mesh, Pairwise(0.8, weights), [Blend(blend)], iterations=iterations)
        after = exact_volume(mesh, points)
        assert report.moved > 0.3 * mesh.n_points
        assert abs(float((after - before) / before)) <= bound
        assert points[blend == 0].tobytes() == mesh.points[blend == 0].tobytes()


def test_the_volume_swept_by_open_meshes_is_nothing():
    mesh = meshes.sheet(14, 11, jitter=0.3, bump=3.0)
    box = np.prod(np.ptp(mesh.points, axis=0))
    points, report = loop.smooth(mesh, Pairwise(), iterations=20)
    assert report.moved == (np.array(reference.boundaries(mesh)[0]) == 0).sum()
    # The boundary stays, so what is swept is the difference of the volumes, wherever the origin is.
    swept = exact_volume(mesh, points) - exact_volume(mesh, mesh.points)
    assert abs(float(swept)) / 6 <= 1e-14 * box
    assert abs(report.swept_volume) <= 1e-13 * box
    assert points[reference_border(mesh)].tobytes() == mesh.points[reference_border(mesh)].tobytes()


def reference_border(mesh):
    return np.array(reference.boundaries(mesh)[0]) != 0


def laplacians(mesh, points, kind):
    """The matrix of L, row by row from the definitions; rows of the boundary are 0."""
    matrix = np.zeros((mesh.n_points, mesh.n_points))
    kinds = reference.boundaries(mesh)[0]
    for v, ring in enumerate(reference.one_rings(mesh)):
        if kinds[v] != 0:
            continue
        for w in ring:
            if kind == "umbrella":
                matrix[v, w] = 1.0
            elif kind == "scale-dependent":
                matrix[v, w] = 1.0 / np.linalg.norm(points[w] - points[v])
        matrix[v] /= matrix[v].sum()
        matrix[v, v] = -1.0
    return matrix


def star_volume(mesh, points):
    p = points[mesh.connectivity.reshape(-1, 3)]
    return np.einsum("ij,ij->", p[:, 0], np.cross(p[:, 1], p[:, 2])) / 6


def slow_sweep(mesh, edges, kind, damping):
    """The definition: least squares over everything, a Newton step on the volume, and E must fall."""
    points = mesh.points.copy()
    matrix = laplacians(mesh, points, kind)
    refused = 0
    for i, j in edges:
        ends = [v for v in (i, j) if damping[v] > 0]
        step = -np.linalg.lstsq(matrix[:, ends], matrix @ points, rcond=None)[0]
        moved = points.copy()
        moved[ends] += damping[ends, None] * step

        def volume(w, moved=moved, ends=ends):
            there = moved.copy()
            there[ends] += damping[ends, None] * w
            return star_volume(mesh, there)

        # Linear in w, so differences over any length are its gradient.
        zero = volume(np.zeros(3))
        gradient = np.array([volume(axis) - zero for axis in np.eye(3)])
        w = -(zero - star_volume(mesh, points)) * gradient / (gradient @ gradient)
        moved[ends] += damping[ends, None] * w
        if np.linalg.norm(matrix @ moved) < np.linalg.norm(matrix @ points):
            points = moved
        else:
            refused += 1
    assert refused < 0.2 * len(edges)
    return points


@pytest.mark.parametrize("kind", ["umbrella", "scale-dependent"])
@pytest.mark.parametrize("closed", [True, False])
def test_one_sweep_like_the_definition(kind, closed):
    mesh = meshes.torus(9, 6, jitter=0.2) if closed else meshes.sheet(6, 6, jitter=0.2, bump=1.5)
    order = adjacency.breadth_first_order(adjacency.build(mesh))
    near = adjacency.build(adjacency.renumbered(mesh, order)[0])
    damping = np.random.default_rng(1).choice([0.0, 0.4, 1.0], mesh.n_points)
    held = ((near.kinds != 0) | (damping[order] == 0)).astype(np.uint8)
    rows = (near.ring_offsets, near.ring)
    edges = pairwise.edges_of(near, rows, held).ends
    assert len(edges) == (held[adjacency.edges(near)[0]] == 0).any(axis=1).sum()
    assert len({tuple(sorted(edge)) for edge in edges.tolist()}) == len(edges)
    damping[order[held == 1]] = 0.0
    expected = slow_sweep(mesh, order[edges], kind, 0.7 * damping)
    scheme = Pairwise(0.7, Weights(kind))
    points, _ = loop.smooth(mesh, scheme, [Blend(damping)], iterations=1)
    np.testing.assert_allclose(points, expected, atol=1e-10)


@pytest.mark.parametrize("closed", [True, False])
def test_the_energy_never_grows(closed):
    # Without the guard the sheet leaves all bounds: 100 sweeps end at heights of 1e28.
    mesh = meshes.torus(16, 8, jitter=0.3) if closed else meshes.sheet(14, 11, jitter=0.3, bump=3.0)
    matrix = laplacians(mesh, mesh.points, "umbrella")
    energies = [np.linalg.norm(matrix @ mesh.points)]
    for iterations in (1, 2, 3, 5, 10, 20, 50, 100, 200):
        points, report = loop.smooth(mesh, Pairwise(1.0), iterations=iterations)
        energies.append(np.linalg.norm(matrix @ points))
    assert energies == sorted(energies, reverse=True)
    assert report.inverted == (0, 0)
    assert np.ptp(points, axis=0) == pytest.approx(np.ptp(mesh.points, axis=0), rel=0.5)


@pytest.fixture
def _small_blocks(monkeypatch):
    monkeypatch.setattr(pairwise, "edges_of", partial(pairwise.edges_of, block_size=16))
    monkeypatch.setattr(parallel, "ranges", partial(parallel.ranges, size=16))
    monkeypatch.setattr(parallel, "SMALLEST_SHARE", 1)


@pytest.mark.usefixtures("_small_blocks")
@pytest.mark.parametrize("constraints", [[], [Gate("floor"), Creases(60.0), DeviationBound(0.3)]])
def test_the_number_of_threads_does_not_matter(constraints):
    mesh = meshes.torus(40, 20, jitter=0.3)
    results = []
    try:
        for threads in (1, 2, 3):
            parallel.set_number_of_threads(threads)
            results.append(loop.smooth(mesh, Pairwise(), constraints, iterations=4)[0].tobytes())
    finally:
        parallel.set_number_of_threads(0)
    assert results[0] == results[1] == results[2]


SHAPES = [meshes.torus(40, 20, jitter=0.2), meshes.fan(300, 0.5), meshes.sheet(20, 20)]


@pytest.mark.parametrize("mesh", SHAPES)
def test_blocks_of_one_colour_do_not_touch(mesh):
    near = adjacency.build(mesh)
    pinned = (near.kinds != 0).astype(np.uint8)
    edges = pairwise.edges_of(near, (near.ring_offsets, near.ring), pinned, block_size=16)
    rings = reference.one_rings(mesh)
    assert sum(int((ends - starts).sum()) for starts, ends in edges.blocks) == len(edges.ends)
    for starts, ends in edges.blocks:
        seen = set()
        for a, b in zip(starts, ends, strict=True):
            touched = set()
            for v in np.unique(edges.ends[a:b]).tolist():
                touched |= {v} | rings[v]
            assert not touched & seen
            seen |= touched


@pytest.mark.parametrize("mesh", SHAPES)
def test_edges_of_a_batch_change_different_laplacians(mesh):
    near = adjacency.build(mesh)
    pinned = (near.kinds != 0).astype(np.uint8)
    edges = pairwise.edges_of(near, (near.ring_offsets, near.ring), pinned)
    batches = pairwise.batches_of(edges.ends, edges.offsets, edges.ring, 300)
    assert sorted(np.concatenate(batches).tolist()) == list(range(len(edges.ends)))
    rings = reference.one_rings(mesh)
    for batch in batches:
        assert len(np.unique(edges.ends[batch, 0] // 300)) == 1
        touched = [k for i, j in edges.ends[batch].tolist() for k in {i, j} | rings[i] | rings[j]]
        assert len(touched) == len(set(touched))


class Everything(Constraint):
    """A limit that admits all steps: operations are judged, and none is refused."""


def test_operations_that_are_judged_are_those_of_the_sweep(monkeypatch):
    mesh = meshes.torus(40, 20, jitter=0.3)
    blend = np.random.default_rng(0).choice([0.0, 0.3, 1.0], mesh.n_points)
    judged = loop.smooth(mesh, Pairwise(), [Blend(blend), Everything()], iterations=3)[0]

    def in_this_order(*args, edges_of=pairwise.edges_of):
        edges = edges_of(*args)
        ends = edges.ends[np.concatenate(pairwise.batches_of(edges.ends, edges.offsets, edges.ring))]
        return edges._replace(ends=ends, blocks=[(np.array([0]), np.array([len(ends)]))])

    monkeypatch.setattr(pairwise, "edges_of", in_this_order)
    # A gate numbers the vertices as it does for limits; it is not asked.
    monkeypatch.setattr(Disposal, "judges_ends", False)
    swept = loop.smooth(mesh, Pairwise(), [Blend(blend), Everything()], iterations=3)[0]
    assert judged.tobytes() == swept.tobytes()
    assert (judged != mesh.points).any(axis=1).sum() > 300


def test_steps_that_are_refused_are_halved():
    # A single vertex can move, in the plane of what the volume allows, and not as far as it would.
    mesh = meshes.torus(16, 8, jitter=0.3)
    free = loop.smooth(mesh, Pairwise(), iterations=1)[0]
    far = np.linalg.norm(free - mesh.points, axis=1)
    bound = np.where(far > 0, 0.3 * far, 0.0)
    points, report = loop.smooth(mesh, Pairwise(), [DisplacementBound(bound)], iterations=1, checked=True)
    assert report.broken == []
    assert (np.linalg.norm(points - mesh.points, axis=1) <= bound * (1 + 1e-9)).all()
    assert report.moved > 0.5 * mesh.n_points
    before = exact_volume(mesh, mesh.points)
    assert abs(float((exact_volume(mesh, points) - before) / before)) < 1e-14


@pytest.mark.parametrize(("kind", "measure"), [("aspect", "k"), ("floor", "k"), ("angle", "angle")])
def test_gates_judge_both_ends(kind, measure):
    mesh = voxel_torus(6, 3)
    directions = aspect_ratio.reference_directions(mesh)

    def smallest(points):
        if measure == "k":
            return aspect_ratio.aspect_ratios(mesh.with_points(points), directions).min()
        corners = points[mesh.connectivity.reshape(-1, 3)]
        sides = np.roll(corners, -1, axis=1) - corners
        sides /= np.linalg.norm(sides, axis=2, keepdims=True)
        return np.pi - np.arccos((sides * np.roll(sides, 1, axis=1)).sum(axis=2)).max()

    assert smallest(loop.smooth(mesh, Pairwise(), iterations=2)[0]) < 0.9 * smallest(mesh.points)
    points = mesh.points
    for _ in range(5):
        before = smallest(points)
        points, report = loop.smooth(
            mesh.with_points(points), Pairwise(), [Gate(kind, 0.95)], iterations=1, checked=True
        )
        assert report.moved > 0
        assert report.broken == []
        assert smallest(points) >= before


def rotation(seed):
    q, r = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    return q if np.linalg.det(q) > 0 else q[:, [1, 0, 2]]


@given(
    seed=st.integers(0, 2**32 - 1),
    scale=st.sampled_from([1e-12, 1e-3, 1.0, 1e6]),
    kind=st.sampled_from(list(KINDS)),
    closed=st.booleans(),
    bound=st.booleans(),
)
@settings(max_examples=40)
def test_pose_and_scale_do_not_matter(seed, scale, kind, closed, bound):
    mesh = meshes.torus(14, 8, jitter=0.2, seed=seed) if closed else meshes.sheet(9, 8, jitter=0.2, bump=2.0)
    turn, shift = rotation(seed), np.random.default_rng(seed).uniform(-5, 5, 3)
    moved = mesh.with_points((mesh.points @ turn + shift) * scale)
    results = []
    for where, flow in ((mesh, flow_round(mesh)), (moved, -1e-9 * flow_round(mesh) @ turn)):
        constraints = [CurvatureBound()] if bound else []
        results.append(
            loop.smooth(where, Pairwise(weights=Weights(kind, flow, 2.0)), constraints, iterations=2)[0]
        )
    np.testing.assert_allclose((results[1] / scale - shift) @ turn.T, results[0], atol=1e-8)


def test_a_flow_that_vanishes_in_the_plane_or_altogether_is_isotropic():
    mesh = meshes.torus(14, 8, jitter=0.2)
    expected = loop.smooth(mesh, Pairwise(), iterations=1)[0]
    for flow in (np.zeros((mesh.n_points, 3)), reference.vertex_normals(mesh)):
        points = loop.smooth(mesh, Pairwise(weights=Weights("umbrella", flow, 5.0)), iterations=1)[0]
        np.testing.assert_allclose(points, expected, atol=1e-12)
    along = loop.smooth(mesh, Pairwise(weights=Weights("umbrella", flow_round(mesh), 5.0)), iterations=1)[0]
    assert np.abs(along - expected).max() > 1e-3


def test_directional_weights_by_hand():
    # A flat hexagon, flow along x: theta is 0, 60, 120, 180 ... degrees.
    mesh = meshes.fan(6)
    mesh.points[0] = 0.0
    near = adjacency.build(mesh)
    flow = np.tile([0.0, 0.0, 7.0], (7, 1)) + np.array([-3.0, 0.0, 0.0])
    weights = Weights("umbrella", flow, 4.0).compute(mesh.points, near)
    first = near.ring_offsets[0]
    angle = np.arctan2(*mesh.points[near.ring[first : first + 6], :2].T[::-1])
    expected = 1 + 4 * np.cos(angle) ** 2
    np.testing.assert_allclose(weights[first : first + 6], expected / expected.sum(), rtol=1e-13)


@pytest.mark.parametrize("angle", [0.0, 0.2, np.pi / 6])
def test_along_the_flow_long_waves_go_three_times_as_fast_as_across(angle):
    # A flat hexagon; heights x^2 and y^2, x along the flow, are what long waves look like from near by.
    mesh = meshes.fan(6)
    mesh.points[0] = 0.0
    near = adjacency.build(mesh)
    along, across = (
        np.array([np.cos(angle), np.sin(angle), 0.0]),
        np.array([-np.sin(angle), np.cos(angle), 0.0]),
    )
    for flow_weight, expected in ((0.0, 1.0), (3.0, 13 / 7), (1e9, 3.0)):
        weights = Weights("umbrella", np.tile(along, (7, 1)), flow_weight)
        values = weights.compute(mesh.points, near)
        heights = np.column_stack([(mesh.points @ along) ** 2, (mesh.points @ across) ** 2, np.zeros(7)])
        laplacian = np.empty_like(heights)
        weights.apply(heights, near, values, laplacian)
        assert laplacian[0, 0] / laplacian[0, 1] == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("turned", [False, True])
def test_waves_along_the_flow_go_and_those_across_stay(turned):
    mesh = meshes.sheet(36, 36)
    x, y, _ = mesh.points.T
    waves = np.column_stack([np.cos(2 * np.pi * x / 6), np.cos(2 * np.pi * y / 6)])
    mesh.points[:, 2] = 0.3 * waves.sum(axis=1)
    middle = (np.abs(x - 18) < 10) & (np.abs(y - 18) < 10)
    flow = np.tile([0.0, 1.0, 0.0] if turned else [1.0, 0.0, 0.0], (mesh.n_points, 1))
    rates = {}
    for flow_weight in (0.0, 3.0, 100.0):
        scheme = Pairwise(1.0, Weights("umbrella", flow, flow_weight))
        points, _ = loop.smooth(mesh, scheme, iterations=10)
        heights = np.linalg.lstsq(waves[middle], points[middle, 2], rcond=None)[0]
        rates[flow_weight] = np.log(0.3 / (heights[::-1] if turned else heights))
    assert rates[0.0][0] == pytest.approx(rates[0.0][1], rel=0.2)
    assert rates[3.0][0] > 2.0 * rates[3.0][1]
    assert rates[100.0][0] > 4.0 * rates[100.0][1]
    assert rates[100.0][0] > rates[3.0][0] > rates[0.0][0]
    assert rates[100.0][1] < rates[3.0][1] < rates[0.0][1]


def test_stop_rules_progress_and_cancelling():
    mesh = voxel_torus(6, 3)
    seen = []
    _, report = loop.smooth(
        mesh, Pairwise(), iterations=50, stop=loop.StopRules(normal_deviation=20.0),
        progress=lambda fraction, what: seen.append(fraction),
    )  # fmt: skip
    assert report.stop_reason == "normal-deviation"
    assert 0 <= report.iterations < 50
    assert seen == sorted(seen)
    _, report = loop.smooth(mesh, Pairwise(), iterations=50, fixed=np.ones(mesh.n_points))
    assert report.stop_reason == "nothing-to-do"

    def cancel(fraction, what):
        if fraction > 0.3:
            raise Cancelled("enough")

    with pytest.raises(Cancelled):
        loop.smooth(mesh, Pairwise(), iterations=10, progress=cancel)


@pytest.mark.parametrize(
    ("parameter", "value"),
    [
        ("tangent_plane", True), ("back_to_surface", True), ("boundary", "sliding"), ("features", "slide"),
        ("null_space", True),
    ],
)  # fmt: skip
def test_what_does_not_combine_is_refused(parameter, value):
    mesh = pv.wrap(meshes.polydata(meshes.torus(9, 6)))
    smoothing = LaplacianSmoothing(scheme="pairwise", **{parameter: value})
    with pytest.raises(ParameterError, match=rf"\(.*{parameter}.*\) cannot .* operations on edges"):
        smoothing(mesh)


@pytest.mark.parametrize(
    ("parameter", "value"),
    [
        ("fixed", "Some"),
        ("blend", "Some"),
        ("features", "hold"),
        ("gate", "floor"),
        ("crease_angle", 40.0),
        ("max_deviation_fraction", 0.01),
        ("max_displacement", "Some"),
        ("stop_normal_deviation", 90.0),
        ("corrections", 2),
        ("preserve_volume", True),
    ],
)
def test_what_combines(parameter, value):
    mesh = pv.wrap(meshes.polydata(meshes.torus(9, 6, jitter=0.3)))
    mesh["Some"] = np.arange(mesh.n_points) % 2.0
    smoothing = LaplacianSmoothing(scheme="pairwise", iterations=3, **{parameter: value})
    result = pv.wrap(smoothing(mesh))
    assert smoothing.report.moved > 0
    before, after = smoothing.report.volume
    assert after == pytest.approx(before, rel=1e-13)
    if value == "Some":
        held = mesh["Some"] == (parameter == "fixed")
        assert (result.points[held] == mesh.points[held]).all()


def test_polygons_are_refused():
    with pytest.raises(InvalidMeshError, match="triangulate"):
        loop.smooth(meshes.cube(2), Pairwise(), iterations=1)


@pytest.mark.parametrize("name", meshes.HOSTILE)
def test_hostile_meshes_end_in_a_right_result(name):
    mesh = meshes.HOSTILE[name]()
    if not mesh.only_triangles:
        return
    points, _ = loop.smooth(mesh, Pairwise(), iterations=3)
    held = reference_border(mesh)
    assert points[held].tobytes() == mesh.points[held].tobytes()
    used = np.unique(mesh.connectivity)
    assert np.isfinite(points[used]).all()
    size = np.ptp(mesh.points[used], axis=0).max()
    assert np.abs(points[used] - mesh.points[used]).max() <= 3 * size
    assert (
        abs(
            comparison.swept_volume(
                mesh.with_points(np.nan_to_num(mesh.points)), mesh.with_points(np.nan_to_num(points))
            )
        )
        <= 1e-13 * max(size, 1e-30) ** 3
    )


def test_voxels_that_touch_along_edges_and_in_corners_stay_there():
    # Two cubes share an edge, two others a corner only.
    cells = [*np.ndindex(3, 3, 3)]
    cells += [(3 + i, 3 + j, k) for i, j, k in cells] + [(-3 + i, -3 + j, -3 + k) for i, j, k in cells]
    mesh = meshes.voxels(cells, triangles=True)
    kinds = np.array(reference.boundaries(mesh)[0])
    points, report = loop.smooth(mesh, Pairwise(), iterations=10)
    assert report.irregular == (kinds == 2).sum() == 4
    np.testing.assert_array_equal(points[kinds == 2], mesh.points[kinds == 2])
    corner = (mesh.points == 0).all(axis=1)
    np.testing.assert_array_equal(points[corner], mesh.points[corner])
    assert report.moved == mesh.n_points - 5
    before = exact_volume(mesh, mesh.points)
    assert abs(float((exact_volume(mesh, points) - before) / before)) < 1e-13


def voxel_torus(major, minor):
    half = int(major + minor + 2)
    centres = np.stack(np.meshgrid(*[np.arange(-half, half)] * 3, indexing="ij"), -1).reshape(-1, 3) + 0.5
    ring = np.hypot(centres[:, 0], centres[:, 1]) - major
    inside = ring**2 + centres[:, 2] ** 2 <= minor**2
    return meshes.voxels((centres[inside] - 0.5).astype(int), triangles=True)


def deviation_from_torus(points, major, minor):
    ring = np.hypot(points[:, 0], points[:, 1]) - major
    return np.sqrt(np.mean((np.hypot(ring, points[:, 2]) - minor) ** 2))


@pytest.mark.parametrize("bound", [[], [CurvatureBound()]])
def test_the_noise_of_a_voxel_torus_goes(bound):
    mesh = voxel_torus(12, 5)
    assert deviation_from_torus(mesh.points, 12, 5) > 0.4
    points, report = loop.smooth(mesh, Pairwise(), bound, iterations=20)
    assert deviation_from_torus(points, 12, 5) <= 0.10
    assert report.inverted == (0, 0)


def test_a_flux_is_refused():
    mesh = meshes.icosphere(1)
    with pytest.raises(
        ParameterError, match=r"A flux of volume \(flux\) cannot dispose of operations on edges"
    ):
        loop.smooth(mesh, Pairwise(), [LocalVolume(flux=np.ones(mesh.n_faces))], iterations=1)


@pytest.mark.parametrize("exact", [False, True])
def test_an_operation_that_would_leave_the_space_is_shortened(exact):
    mesh = meshes.icosphere(2)
    points = mesh.points.copy()
    i = int(np.argmax(points[:, 2]))
    near = adjacency.build(mesh)
    j = int(near.ring[near.ring_offsets[i]])
    points[i] *= 0.9
    points[j] *= 1.1
    mesh = mesh.with_points(points)
    fixed = np.ones(mesh.n_points)
    fixed[[i, j]] = 0
    free, _ = loop.smooth(mesh, Pairwise(), iterations=1, fixed=fixed)
    whole = free[i] - points[i]
    top = points[i, 2] + 0.6 * whole[2]
    walls = surface_of(pv.Box((-2, 2, -2, 2, -2, top)).triangulate()).mesh
    space = Containment(SignedDistanceTree(walls), 1e-9, exact)
    moved, report = loop.smooth(mesh, Pairwise(), [space], iterations=1, fixed=fixed, checked=True)
    assert moved[i, 2] > points[i, 2] + 0.15 * whole[2]
    assert moved[i, 2] <= top
    assert report.broken == []
    assert abs(report.swept_volume) < 1e-15
