"""Each constraint's promise, alone and in every combination with every scheme."""

from itertools import product

import meshes
import numpy as np
import pytest
import reference
from schemes import SCHEMES
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkDoubleArray
from vtkmodules.vtkFiltersCore import vtkImplicitPolyDataDistance

from vtksmooth.errors import ParameterError
from vtksmooth.kernels.features import detection
from vtksmooth.kernels.measures import aspect_ratio
from vtksmooth.kernels.mesh import adjacency
from vtksmooth.kernels.mesh.mesh import Mesh
from vtksmooth.kernels.smoothing import loop
from vtksmooth.kernels.smoothing.constraints.back_to_surface import BackToSurface
from vtksmooth.kernels.smoothing.constraints.boundary import Boundary
from vtksmooth.kernels.smoothing.constraints.creases import Creases
from vtksmooth.kernels.smoothing.constraints.deviation_bound import DeviationBound
from vtksmooth.kernels.smoothing.constraints.feature_lines import FeatureLines
from vtksmooth.kernels.smoothing.constraints.fixed import Fixed
from vtksmooth.kernels.smoothing.constraints.gate import Gate
from vtksmooth.kernels.smoothing.constraints.local_volume import LocalVolume
from vtksmooth.kernels.smoothing.constraints.null_space import NullSpace
from vtksmooth.kernels.smoothing.constraints.tangent_plane import TangentPlane
from vtksmooth.kernels.smoothing.schemes.equilateral import Equilateral
from vtksmooth.kernels.smoothing.schemes.trapezium import TrapeziumDrawing
from vtksmooth.kernels.smoothing.schemes.umbrella import Umbrella


class Bumpy:
    """A wild sheet with straight sides over a hill, and what is measured on it once."""

    def __init__(self, kind):
        self.mesh = meshes.sheet(10, 8, kind, jitter=0.6, bump=2.0, seed=7, boundary_jitter=0.3)
        self.near = adjacency.build(self.mesh)
        self.directions = aspect_ratio.reference_directions(self.mesh)
        self.k = self.k_of(self.mesh.points)
        self.smallest_angle = reference.corner_angles(self.mesh).min()
        self.kinds = np.array(reference.boundaries(self.mesh)[0]) == 1
        x, y = self.mesh.points[:, 0], self.mesh.points[:, 1]
        self.sides = [x == 0, x == 10, y == 0, y == 8]
        self.corners = sum(self.sides) == 2
        self.fixed = (np.random.default_rng(0).random(self.mesh.n_points) < 0.15) & ~self.kinds
        self.distance = vtkImplicitPolyDataDistance()
        self.distance.SetInput(
            meshes.polydata(Mesh.from_faces(self.mesh.points, reference.triangles(self.mesh)))
        )

    def k_of(self, points):
        return reference.aspect_ratios(self.mesh.with_points(points), self.directions)

    def deviation(self, points):
        result = vtkDoubleArray()
        self.distance.FunctionValue(numpy_to_vtk(points), result)
        return np.abs(vtk_to_numpy(result))


@pytest.fixture(params=meshes.KINDS, scope="module")
def bumpy(request):
    return Bumpy(request.param)


BOUND = 0.05

GATES = ["none", "angle", "aspect", "floor"]


@pytest.mark.parametrize("gate", GATES)
@pytest.mark.parametrize("name", SCHEMES)
def test_every_scheme_with_every_constraint(bumpy, name, gate):
    mesh = bumpy.mesh
    assert (bumpy.k < 0).any(), "the test wants something to gate"
    first = (list(SCHEMES).index(name) + GATES.index(gate)) % 2
    for sliding, to_surface, bounded, some_fixed, conserving in product((False, True), repeat=5):
        # Half of all combinations; any four of these settings still meet.
        if (sliding + to_surface + bounded + some_fixed + conserving) % 2 != first:
            continue
        constraints = [NullSpace()] * conserving + [Boundary(sliding)]
        constraints += [BackToSurface()] * to_surface
        constraints += [DeviationBound(BOUND)] * bounded
        constraints += [LocalVolume(1)] * conserving
        constraints += [] if gate == "none" else [Gate(gate)]
        fixed = bumpy.fixed if some_fixed else None
        if to_surface and conserving:
            with pytest.raises(ParameterError, match=r"volume.* cannot go together with the way back"):
                loop.smooth(mesh, SCHEMES[name], constraints, iterations=3, fixed=fixed)
            continue
        points, report = loop.smooth(mesh, SCHEMES[name], constraints, iterations=3, fixed=fixed)

        assert np.isfinite(points).all()
        assert report.moved == (points != mesh.points).any(axis=1).sum()
        assert report.moved > 0 or conserving
        if some_fixed:
            assert points[bumpy.fixed].tobytes() == mesh.points[bumpy.fixed].tobytes()
        if sliding:
            for axis, side in enumerate(bumpy.sides):
                np.testing.assert_allclose(points[side, axis // 2], mesh.points[side, axis // 2], atol=1e-13)
            np.testing.assert_allclose(points[bumpy.kinds, 2], 0, atol=1e-13)
            np.testing.assert_array_equal(points[bumpy.corners], mesh.points[bumpy.corners])
            if gate == "none" and not conserving:
                assert (points != mesh.points).any(axis=1)[bumpy.kinds].any()
        else:
            assert points[bumpy.kinds].tobytes() == mesh.points[bumpy.kinds].tobytes()
        if conserving:
            assert abs(report.swept_volume) < 1e-11
        if to_surface:
            assert bumpy.deviation(points).max() < 1e-12
        if bounded:
            assert bumpy.deviation(points).max() <= BOUND * (1 + 1e-12)
        k = bumpy.k_of(points)
        if conserving:
            assert not ((k < 0) & (bumpy.k >= 0)).any()
        if gate == "aspect":
            assert k.min() >= bumpy.k.min() - 1e-13
            assert (k < 0).sum() <= (bumpy.k < 0).sum()
        if gate == "floor":
            assert k.min() >= min(bumpy.k.min(), 0.6) - 1e-13
            assert (k < 0).sum() <= (bumpy.k < 0).sum()
        if gate == "angle":
            # All faces round an accepted vertex have greater angles than the smallest was, others the same.
            assert reference.corner_angles(mesh.with_points(points)).min() >= bumpy.smallest_angle - 1e-9
        # What the run says of itself.
        assert report.min_aspect_ratio == pytest.approx((bumpy.k.min(), k.min()), abs=1e-12)
        assert report.mean_aspect_ratio == pytest.approx((bumpy.k.mean(), k.mean()), abs=1e-12)
        # By rounding, a corner on a straight side can count on either side.
        assert report.inverted[0] == (bumpy.k < 0).sum()
        assert (k < -1e-14).sum() <= report.inverted[1] <= (k < 1e-14).sum()
        assert report.volume is None


def test_without_the_bound_the_product_test_would_fail(bumpy):
    for name in ("umbrella", "scale-dependent", "cotangent"):
        points, _ = loop.smooth(bumpy.mesh, SCHEMES[name], iterations=3)
        assert bumpy.deviation(points).max() > BOUND
        assert bumpy.k_of(loop.smooth(bumpy.mesh, SCHEMES["taubin"], iterations=3)[0]).min() != bumpy.k.min()


def test_fixed_as_a_constraint():
    mesh = meshes.sheet(6, 6, jitter=0.3)
    mask = np.arange(mesh.n_points) % 3
    points, _ = loop.smooth(mesh, Umbrella(), [Fixed(mask)], iterations=2)
    np.testing.assert_array_equal(points[mask != 0], mesh.points[mask != 0])
    assert (points != mesh.points).any()


def test_all_fixed_is_nothing_to_do():
    mesh = meshes.sheet(6, 6, jitter=0.3)
    points, report = loop.smooth(mesh, Umbrella(), iterations=5, fixed=np.ones(mesh.n_points))
    assert (report.stop_reason, report.iterations, report.moved) == ("nothing-to-do", 0, 0)
    np.testing.assert_array_equal(points, mesh.points)


def test_a_sliding_boundary_becomes_even():
    mesh = meshes.sheet(10, 4, jitter=0.1, seed=3, boundary_jitter=0.3)
    points, _ = loop.smooth(mesh, Umbrella(), [Boundary(sliding=True)], iterations=300)
    side = mesh.points[:, 1] == 0
    np.testing.assert_allclose(points[side, 0], np.arange(11), atol=1e-2)


def test_corners_of_a_sliding_boundary_stay_by_their_angle():
    angle = np.radians(np.arange(0, 360, 15))  # a boundary that turns by 15 degrees at every point
    rim = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    rim[5] = [np.cos(np.radians(70)), np.sin(np.radians(70)), 0]
    faces = [[0, 1 + i, 1 + (i + 1) % 24] for i in range(24)]
    mesh = Mesh.from_faces(np.vstack([[0, 0, 0], rim]), faces)
    tight, _ = loop.smooth(mesh, Umbrella(), [Boundary(sliding=True, corner_angle=5)], iterations=1)
    loose, _ = loop.smooth(mesh, Umbrella(), [Boundary(sliding=True, corner_angle=30)], iterations=1)
    np.testing.assert_array_equal(tight[1:], mesh.points[1:])
    assert (loose[6] != mesh.points[6]).any()
    chord = mesh.points[7] - mesh.points[5]
    step = loose[6] - mesh.points[6]
    assert np.linalg.norm(np.cross(chord, step)) < 1e-15, "parallel to the line through its neighbours"
    target = mesh.points[6] + 2 * step
    assert np.linalg.norm(target - mesh.points[5]) == pytest.approx(
        np.linalg.norm(target - mesh.points[7])
    ), "half way to where it is equally far from both"


def test_irregular_points_stay_whatever_the_boundary_may_do():
    for name in ("moebius", "non_manifold_edge", "misoriented", "bow_tie"):
        mesh = meshes.HOSTILE[name]()
        irregular = np.array(reference.boundaries(mesh)[0]) == 2
        for sliding in (False, True):
            points, report = loop.smooth(mesh, Umbrella(), [Boundary(sliding)], iterations=3)
            np.testing.assert_array_equal(points[irregular], mesh.points[irregular])
            assert report.irregular == irregular.sum() > 0


def test_deviation_bound_shortens_steps_before_it_refuses_them():
    # A cone over a fan: the umbrella wants the tip down by its height, in one step.
    mesh = meshes.fan(12)
    mesh.points[0] = [0.0, 0.0, 1.0]
    for bound, left in ((2.0, 0.0), (0.5, 0.5), (0.2, 0.75), (0.1, 0.875), (0.05, 1.0)):
        points, _ = loop.smooth(mesh, Umbrella(1.0), [DeviationBound(bound)], iterations=1)
        height = points[0, 2]
        # Straight below the tip the surface is as far as the side of the cone: (1 - height) / sqrt 2, nearly.
        slope = np.cos(np.pi / 12)
        assert (1 - height) * slope / np.hypot(1, slope) <= bound
        assert height == pytest.approx(left, abs=0.26)
        refused = (1 - height) * 2 * slope / np.hypot(1, slope)
        assert height == pytest.approx(0, abs=1e-15) or height == 1.0 or refused > bound


@pytest.mark.parametrize("name", SCHEMES)
def test_displacement_bound(bumpy, name):
    mesh = bumpy.mesh
    distances = np.random.default_rng(2).choice([0.0, 0.01, 0.1, np.inf], mesh.n_points)
    for sliding, to_surface, gated in product((False, True), repeat=3):
        constraints = [Boundary(sliding)] + [BackToSurface()] * to_surface + [Gate("aspect")] * gated
        points, _ = loop.smooth(
            mesh, SCHEMES[name], constraints, iterations=4, max_displacement=distances
        )  # fmt: skip
        displacement = np.linalg.norm(points - mesh.points, axis=1)
        assert (displacement <= distances * (1 + 1e-12)).all()
        for distance in (0.01, 0.1, np.inf):
            moved = displacement[distances == distance].max() > 0
            assert moved or (to_surface or gated)
        held = distances == 0.0
        assert points[held].tobytes() == mesh.points[held].tobytes()
        if to_surface:
            assert bumpy.deviation(points).max() < 1e-12
        if sliding:
            for axis, side in enumerate(bumpy.sides):
                np.testing.assert_allclose(points[side, axis // 2], mesh.points[side, axis // 2], atol=1e-13)


def test_displacement_bound_ends_steps_on_the_sphere():
    mesh = meshes.fan(12)
    mesh.points[0] = [0.0, 0.0, 1.0]
    for bound in (0.3, 0.7, 1.0, 5.0):
        distances = np.full(mesh.n_points, bound)
        points, _ = loop.smooth(mesh, Umbrella(0.5), iterations=20, max_displacement=distances)
        assert points[0, 2] == pytest.approx(max(0.0, 1.0 - bound), abs=1e-5)


@pytest.mark.parametrize("scattered", [False, True])
def test_displacements_belong_to_the_callers_numbering(scattered, monkeypatch):
    monkeypatch.setattr(loop, "_scattered", lambda near: scattered)
    mesh = meshes.sheet(9, 9, jitter=0.4, bump=2.0, seed=3)
    shuffle = np.random.default_rng(5).permutation(mesh.n_points)
    rank = np.argsort(shuffle)
    shuffled = Mesh.from_faces(mesh.points[shuffle], [rank[face] for face in meshes.lists(mesh)])
    distances = np.linspace(0.0, 0.2, mesh.n_points)
    for gate in ([], [Gate("aspect")]):
        points, _ = loop.smooth(
            shuffled, Umbrella(), gate, iterations=5, max_displacement=distances[shuffle]
        )  # fmt: skip
        displacement = np.linalg.norm(points[rank] - mesh.points, axis=1)
        assert (displacement <= distances * (1 + 1e-12)).all()
        assert (displacement > 0.9 * distances).sum() > (0 if gate else 10)


def oracle_gated_pass(mesh, k_directions, kinds):
    """Trapezium Drawing with its gate, one vertex after another in the loop's own order."""
    near = adjacency.build(mesh)
    order, _, block_colour = adjacency.colour_blocks(near, adjacency.breadth_first_order(near))
    assert len(block_colour) == 1
    faces = meshes.lists(mesh)
    points = mesh.points.copy()
    for v in order:
        if kinds[v] != 0:
            continue
        star = near.star[near.star_offsets[v] : near.star_offsets[v + 1]]
        around = [f for f, face in enumerate(faces) if v in face]

        def judge(around=around):
            k = [reference.aspect_ratio(points[faces[f]], k_directions[f]) for f in around]
            return sum(q < 0 for q in k), -min(k)

        old, before = points[v].copy(), judge()
        points[v] = reference.trapezium(points, v, star)
        if judge() >= before:
            points[v] = old
    return points


@pytest.mark.parametrize("kind", meshes.KINDS)
def test_gated_trapezium_drawing_like_the_definition(kind):
    # No face is inverted: the gate is the paper's.
    mesh = meshes.sheet(8, 6, kind, jitter=0.2, bump=1.5, seed=11)
    near = adjacency.build(mesh)
    directions = aspect_ratio.reference_directions(mesh)
    assert (aspect_ratio.aspect_ratios(mesh, directions) > 0).all()
    expected = oracle_gated_pass(mesh, directions, reference.boundaries(mesh)[0])
    points, report = loop.smooth(mesh, TrapeziumDrawing(), [Gate("aspect")], iterations=1)
    np.testing.assert_allclose(points, expected, atol=1e-12)
    assert 0 < report.moved < (near.kinds == 0).sum()


# -- features and creases --------------------------------------------------------------------------


class Block:
    """A cuboid with straight ridges whose points are thrown about on its faces and along its ridges."""

    def __init__(self, kind):
        n = 6
        mesh = meshes.cube(n, kind == "triangles")
        random = np.random.default_rng(5)
        points, at = mesh.points, (mesh.points == 0) | (mesh.points == n)
        self.mesh = mesh.with_points(points + random.uniform(-0.3, 0.3, points.shape) * ~at)
        self.planes, self.sides = at, at.sum(axis=1)
        self.near = adjacency.build(self.mesh)
        self.edges = adjacency.edges(self.near)


@pytest.fixture(params=["triangles", "quads"], scope="module")
def block(request):
    return Block(request.param)


# Denoising finds no noise on the block, and moves nothing.
@pytest.mark.parametrize("sliding", [False, True])
@pytest.mark.parametrize("name", sorted(SCHEMES.keys() - {"feature-preserving"}))
def test_every_scheme_with_features(block, name, sliding):
    mesh, start = block.mesh, block.mesh.points
    for gate, fixed in product(([], [Gate("floor")]), (None, block.sides == 1)):
        constraints = [TangentPlane(), FeatureLines(sliding), *gate]
        points, report = loop.smooth(mesh, SCHEMES[name], constraints, iterations=4, fixed=fixed)
        # Flat faces stay flat, straight ridges straight.
        np.testing.assert_allclose(points[block.planes], start[block.planes], atol=1e-12)
        corners, ridges = block.sides == 3, block.sides == 2
        assert points[corners].tobytes() == start[corners].tobytes()
        moved = (points != start).any(axis=1)
        if sliding:
            assert moved[ridges].any() or gate
        else:
            assert not moved[ridges].any()
        assert moved[block.sides == 1].any() == (fixed is None)
        assert report.inverted[1] == 0


def test_sliding_makes_ridges_even_and_needs_two_neighbours(block):
    points, _ = loop.smooth(block.mesh, Umbrella(), [TangentPlane(), FeatureLines(True)], iterations=100)
    ridges = block.sides == 2
    np.testing.assert_allclose(points[ridges], np.round(points[ridges]), atol=1e-2)
    found = detection.detect(block.mesh, block.near)
    ring = found.ridge_ring.copy()
    ring[:, 1] = -1
    held, _ = loop.smooth(
        block.mesh,
        Umbrella(),
        [FeatureLines(True)],
        iterations=3,
        find_features=found._replace(ridge_ring=ring),
    )
    np.testing.assert_array_equal(held[ridges], block.mesh.points[ridges])


def test_features_that_are_given_are_renumbered_as_the_run_is(block):
    # In place the run has a numbering of its own; the features are those of a mesh numbered otherwise.
    found = detection.detect(block.mesh, block.near)
    for gate in ([], [Gate("floor")]):
        constraints = [TangentPlane(), FeatureLines(True), *gate]
        given, _ = loop.smooth(block.mesh, Umbrella(), constraints, iterations=3, find_features=found)
        expected, _ = loop.smooth(block.mesh, Umbrella(), constraints, iterations=3)
        np.testing.assert_array_equal(given, expected)
    with pytest.raises(ParameterError, match="features are those of 3 points"):
        loop.smooth(
            block.mesh, Umbrella(), [FeatureLines()], iterations=1,
            find_features=detection.Features(found.classes[:3], found.ridge_ring[:3], found.ridge_edges),
        )  # fmt: skip


def sharp_edges(mesh, angle):
    return {edge: value for edge, value in reference.dihedral_angles(mesh).items() if abs(value) > angle}


@pytest.mark.parametrize("kind", meshes.KINDS)
@pytest.mark.parametrize("name", SCHEMES)
def test_creases_stay_sharp_whatever_is_proposed(kind, name):
    mesh = meshes.torus(18, 10, kind, jitter=0.25, seed=3)
    before = sharp_edges(mesh, 30.0)
    assert before
    for constraints in ([Creases(30.0)], [BackToSurface(), Creases(30.0), Gate("floor")]):
        points, report = loop.smooth(mesh, SCHEMES[name], constraints, iterations=4)
        after = reference.dihedral_angles(mesh.with_points(points))
        assert all(abs(after[edge]) >= 30.0 - 1e-9 for edge in before)
        # What removes noise need not be what these allow.
        assert report.moved > 0 or name == "feature-preserving"


def test_without_the_constraint_creases_would_flatten():
    mesh = meshes.torus(18, 10, jitter=0.25, seed=3)
    points, _ = loop.smooth(mesh, Umbrella(), iterations=4)
    after = reference.dihedral_angles(mesh.with_points(points))
    assert any(abs(after[edge]) < 25 for edge in sharp_edges(mesh, 25.0))


def test_steps_that_the_floor_gate_shortens_are_still_allowed():
    # Halved steps would leave the surface, or its neighbourhood, if what came before did not act again.
    bumpy = Bumpy("triangles")
    for before, bound in (([BackToSurface()], 1e-12), ([DeviationBound(BOUND)], BOUND * (1 + 1e-12))):
        points, _ = loop.smooth(bumpy.mesh, Equilateral(1.0), [*before, Gate("floor")], iterations=5)
        assert bumpy.deviation(points).max() <= bound
        assert (points != bumpy.mesh.points).any()


def test_the_floor_gate_lets_the_mean_grow_where_the_aspect_gate_does_not():
    mesh = meshes.torus(18, 8, jitter=0.2)
    mean = {}
    for measure in ("aspect", "floor"):
        _, report = loop.smooth(mesh, Equilateral(1.0), [TangentPlane(), Gate(measure)], iterations=20)
        mean[measure] = report.mean_aspect_ratio[1]
    assert mean["floor"] > mean["aspect"] + 0.01


def test_no_step_takes_the_area_from_a_face_beside_a_crease():
    # The middle of each wall goes to a corner of it: onto an end of creases.
    mesh = meshes.cube(2, triangles=True)
    middle = np.flatnonzero((mesh.points == 1.0).sum(axis=1) == 2)
    corner = mesh.points.copy()
    corner[middle] = np.where(mesh.points[middle] == 1.0, 2.0, mesh.points[middle])

    class ToTheCorner(Umbrella):
        def propose(self, state, turn, starts, ends, proposed):
            for first, last in zip(starts, ends, strict=True):
                places = state.in_order(corner)[first:last]
                free = state.pinned[first:last, None] == 0
                proposed[first:last] = np.where(free, places, state.points[first:last])

    _, report = loop.smooth(mesh, ToTheCorner(), [Creases(40.0)], iterations=1, checked=True)
    assert report.broken == []
