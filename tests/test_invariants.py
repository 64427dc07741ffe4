"""What must hold for any mesh: properties that hypothesis tries to break."""

from functools import partial

import meshes
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from schemes import SCHEMES

from vtksmooth.jit import parallel
from vtksmooth.kernels.measures import aspect_ratio, comparison
from vtksmooth.kernels.mesh import adjacency
from vtksmooth.kernels.smoothing import loop
from vtksmooth.kernels.smoothing.constraints.back_to_surface import BackToSurface
from vtksmooth.kernels.smoothing.constraints.boundary import Boundary
from vtksmooth.kernels.smoothing.constraints.creases import Creases
from vtksmooth.kernels.smoothing.constraints.feature_lines import FeatureLines
from vtksmooth.kernels.smoothing.constraints.gate import Gate
from vtksmooth.kernels.smoothing.constraints.local_volume import LocalVolume
from vtksmooth.kernels.smoothing.constraints.no_inversion import NoInversion
from vtksmooth.kernels.smoothing.constraints.null_space import NullSpace
from vtksmooth.kernels.smoothing.constraints.tangent_plane import TangentPlane
from vtksmooth.kernels.smoothing.schemes.trapezium import TrapeziumDrawing

#: k is computed in another order by the gate than by the measure, with other rounding errors.
ROUNDING = 1e-13


@pytest.fixture(autouse=True, scope="module")
def _small_pieces():
    """Small blocks and shares: otherwise small meshes would never see two threads."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(adjacency, "colour_blocks", partial(adjacency.colour_blocks, block_size=16))
        patch.setattr(parallel, "ranges", partial(parallel.ranges, size=16))
        patch.setattr(parallel, "SMALLEST_SHARE", 1)
        yield


@st.composite
def surfaces(draw, wild=True):
    """Sheets and tori of triangles, quads or mixed faces, from slightly jittered to thoroughly tangled."""
    kind = draw(st.sampled_from(meshes.KINDS))
    seed = draw(st.integers(0, 2**32 - 1))
    jitter = draw(st.sampled_from([0.05, 0.2, 0.4, 0.8] if wild else [0.05, 0.15, 0.3]))
    columns, rows = draw(st.sampled_from([4, 6, 10])), draw(st.sampled_from([4, 6, 8]))
    if draw(st.booleans()):
        return meshes.torus(max(columns, 6), max(rows, 6), kind, jitter, seed)
    bump = draw(st.sampled_from([0.0, 1.0, 3.0]))
    mesh = meshes.sheet(columns, rows, kind, jitter, bump, seed, boundary_jitter=min(jitter, 0.3))
    if wild and draw(st.booleans()):  # points in one place
        points = mesh.points.copy()
        random = np.random.default_rng(seed)
        points[random.integers(len(points), size=4)] = points[random.integers(len(points), size=4)]
        mesh = mesh.with_points(points)
    return mesh


def masks(mesh, seed):
    return np.random.default_rng(seed).random(mesh.n_points) < 0.2


def frozen_k(mesh):
    """A function from points to k, against the directions of `mesh`."""
    directions = aspect_ratio.reference_directions(mesh)
    return lambda points: aspect_ratio.aspect_ratios(mesh.with_points(points), directions)


def assert_never_worse(before, after):
    assert after.min() >= before.min() - ROUNDING
    assert (after < -ROUNDING).sum() <= (before < 0).sum()


constraint_lists = st.sampled_from(
    [
        [Gate("aspect")],
        [Boundary(sliding=True), Gate("aspect")],
        [TangentPlane(), Gate("aspect")],
        [Boundary(sliding=True), BackToSurface(), Gate("aspect")],
        [Boundary(sliding=True), TangentPlane(), FeatureLines(), Creases(30.0), Gate("aspect")],
        [NullSpace(), LocalVolume(1), Gate("aspect")],
    ]
)

#: Constraints for vertices that all move at once.
simultaneous_lists = st.sampled_from(
    [[], [BackToSurface()], [NoInversion()], [NullSpace()], [LocalVolume(1)], [NullSpace(), LocalVolume(2)]]
)


@given(mesh=surfaces(), constraints=constraint_lists, seed=st.integers(0, 99))
@settings(max_examples=150)
def test_no_pass_of_trapezium_drawing_makes_the_worst_face_worse_or_inverts_more(mesh, constraints, seed):
    k_of, fixed = frozen_k(mesh), masks(mesh, seed)
    k = k_of(mesh.points)
    for passes in range(1, 7):
        points, report = loop.smooth(mesh, TrapeziumDrawing(), constraints, iterations=passes, fixed=fixed)
        after = k_of(points)
        assert_never_worse(k, after)
        assert report.min_aspect_ratio[1] == pytest.approx(after.min(), abs=ROUNDING)
        k = after


@given(
    mesh=surfaces(),
    scheme=st.sampled_from(list(SCHEMES.values())),
    before=st.sampled_from(
        [[], [Boundary(sliding=True)], [TangentPlane(), FeatureLines()], [BackToSurface()], [Creases(40.0)]]
    ),
    floor=st.sampled_from([0.0, 0.3, 0.6, 1.0]),
    seed=st.integers(0, 99),
)
@settings(max_examples=80)
def test_no_pass_with_the_floor_gate_goes_below_the_floor_or_inverts_more(mesh, scheme, before, floor, seed):
    k_of, fixed = frozen_k(mesh), masks(mesh, seed)
    k = k_of(mesh.points)
    for passes in (1, 2, 4):
        constraints = [*before, Gate("floor", floor)]
        points, _ = loop.smooth(mesh, scheme, constraints, iterations=passes, fixed=fixed)
        after = k_of(points)
        assert after.min() >= min(k.min(), floor) - ROUNDING
        assert (after < -ROUNDING).sum() <= (k < 0).sum()
        k = after


@given(
    mesh=surfaces(),
    scheme=st.sampled_from(list(SCHEMES.values())),
    gate=st.sampled_from([[], [Gate("aspect")], [Gate("floor")]]),
    angle=st.sampled_from([5.0, 30.0, 60.0]),
)
@settings(max_examples=100)
def test_no_edge_above_the_crease_angle_falls_below_it(mesh, scheme, gate, angle):
    edges = adjacency.edges(adjacency.build(mesh))
    before = comparison.dihedral_angles(mesh, *edges)
    points, _ = loop.smooth(mesh, scheme, [Boundary(sliding=True), Creases(angle), *gate], iterations=4)
    after = comparison.dihedral_angles(mesh.with_points(points), *edges)
    sharp = np.abs(before) > angle
    assert (np.abs(after[sharp]) >= angle - 1e-6).all()
    if mesh.only_triangles:
        np.testing.assert_array_equal(np.sign(before[sharp]), np.sign(after[sharp]))


@given(
    mesh=surfaces(),
    scheme=st.sampled_from(list(SCHEMES.values())),
    gate=st.sampled_from([[], [Gate("angle")], [Gate("aspect")], [Gate("floor")]]),
    seed=st.integers(0, 99),
)
@settings(max_examples=150)
def test_fixed_points_keep_their_bits_and_the_input_is_not_touched(mesh, scheme, gate, seed):
    fixed = masks(mesh, seed)
    mesh.points[fixed] *= np.where(np.abs(mesh.points[fixed]) < 1e-12, -0.0, 1.0)
    copies = [array.copy() for array in (mesh.points, mesh.offsets, mesh.connectivity, fixed)]
    for constraints in (
        gate,
        [Boundary(sliding=True), TangentPlane(), BackToSurface(), *gate],
        [NullSpace(), LocalVolume(1), *gate],
    ):
        points, report = loop.smooth(mesh, scheme, constraints, iterations=3, fixed=fixed)
        for array, copy in zip((mesh.points, mesh.offsets, mesh.connectivity, fixed), copies, strict=True):
            np.testing.assert_array_equal(array.view(np.uint8), copy.view(np.uint8))
        assert np.isfinite(points).all()
        assert points[fixed].tobytes() == mesh.points[fixed].tobytes()
        assert not np.shares_memory(points, mesh.points)
        assert report.moved == (points != mesh.points).any(axis=1).sum()


@given(
    mesh=surfaces(),
    scheme=st.sampled_from(list(SCHEMES.values())),
    constraints=st.one_of(
        constraint_lists, simultaneous_lists, st.sampled_from([[TangentPlane(), Gate("angle")]])
    ),
)
@settings(max_examples=100)
def test_the_number_of_threads_does_not_matter(mesh, scheme, constraints):
    results = []
    try:
        for threads in (1, 2, 3):
            parallel.set_number_of_threads(threads)
            results.append(loop.smooth(mesh, scheme, constraints, iterations=3)[0].tobytes())
    finally:
        parallel.set_number_of_threads(0)
    assert results[0] == results[1] == results[2]


def rotation(seed):
    q, r = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    return q if np.linalg.det(q) > 0 else q[:, [1, 0, 2]]


def assert_same_in_another_pose(mesh, scheme, constraints, seed, scale, passes):
    turn = rotation(seed)
    shift = np.random.default_rng(seed).uniform(-5, 5, 3)
    moved = mesh.with_points((mesh.points @ turn + shift) * scale)
    expected = loop.smooth(mesh, scheme, constraints, iterations=passes)[0]
    found = loop.smooth(moved, scheme, constraints, iterations=passes)[0]
    np.testing.assert_allclose((found / scale - shift) @ turn.T, expected, atol=1e-9)


@given(
    mesh=surfaces(wild=False),
    scheme=st.sampled_from(list(SCHEMES.values())),
    constraints=st.one_of(constraint_lists, simultaneous_lists),
    seed=st.integers(0, 2**32 - 1),
    scale=st.sampled_from([1e-12, 1e-6, 1e-3, 1.0, 1e3, 1e6, 1e12]),
)
@settings(max_examples=100)
def test_pose_and_scale_do_not_matter(mesh, scheme, constraints, seed, scale):
    assert_same_in_another_pose(mesh, scheme, constraints, seed, scale, passes=2)


@pytest.mark.parametrize("name", SCHEMES)
@pytest.mark.parametrize("gate", ["none", "angle", "aspect", "floor"])
@pytest.mark.parametrize("kind", meshes.KINDS)
def test_pose_and_scale_do_not_matter_to_regular_meshes(name, gate, kind):
    # Everything is a tie here: equal angles, equal minima, steps of nothing but rounding.
    if (name, gate, kind) == ("low-pass", "floor", "mixed"):
        pytest.xfail("below its floor this gate lets rounding decide about minima that stay the same")
    constraints = [] if gate == "none" else [Gate(gate)]
    for mesh in (meshes.sheet(8, 6, kind), meshes.torus(12, 8, kind), meshes.cube(3, kind == "triangles")):
        for seed, scale in ((0, 1.0), (1, 1e-6), (2, 1e6)):
            assert_same_in_another_pose(mesh, SCHEMES[name], constraints, seed, scale, passes=3)
