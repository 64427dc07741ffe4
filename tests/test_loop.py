import meshes
import numpy as np
import pytest
import reference
from schemes import SCHEMES
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkDoubleArray
from vtkmodules.vtkFiltersCore import vtkImplicitPolyDataDistance

from vtksmooth.errors import Cancelled, ParameterError
from vtksmooth.kernels.features import detection
from vtksmooth.kernels.measures import aspect_ratio, comparison
from vtksmooth.kernels.mesh import adjacency
from vtksmooth.kernels.mesh.mesh import Mesh
from vtksmooth.kernels.smoothing import loop
from vtksmooth.kernels.smoothing.constraints.back_to_surface import BackToSurface
from vtksmooth.kernels.smoothing.constraints.boundary import Boundary
from vtksmooth.kernels.smoothing.constraints.deviation_bound import DeviationBound
from vtksmooth.kernels.smoothing.constraints.gate import Gate
from vtksmooth.kernels.smoothing.schemes.taubin import Taubin
from vtksmooth.kernels.smoothing.schemes.trapezium import TrapeziumDrawing
from vtksmooth.kernels.smoothing.schemes.umbrella import Umbrella

GATES = {"none": [], "angle": [Gate("angle")], "aspect": [Gate("aspect")]}


@pytest.fixture
def small_blocks(monkeypatch):
    original = adjacency.colour_blocks
    monkeypatch.setattr(adjacency, "colour_blocks", lambda near, order: original(near, order, 64))


# -- one result, several roads ------------------------------------------------------------------------


@pytest.mark.parametrize(
    "name",
    [
        "sheet", "torus", "fan", "fixed", "hourglass", "tiny", "huge", "nearly_equal_angles",
        "misoriented", "degenerate_faces", "isolated_points", "non_manifold_edge", "moebius",
    ],
)  # fmt: skip
def test_the_fused_sweep_gives_the_bits_of_the_parts(name, small_blocks, monkeypatch):
    fixed = None
    if name == "sheet":
        mesh = meshes.sheet(24, 20, jitter=0.6, bump=3.0)
    elif name in ("torus", "fixed"):
        mesh = meshes.torus(40, 20, jitter=0.5)
        fixed = np.arange(mesh.n_points) % 7 < 2 if name == "fixed" else None
    elif name in ("tiny", "huge"):  # squares that are no float32
        mesh = meshes.torus(40, 20, jitter=0.5)
        mesh = mesh.with_points(mesh.points * {"tiny": 1e-25, "huge": 1e25}[name])
    elif name == "fan":
        mesh = meshes.joined(
            *(meshes.fan(valence, height=0.2) for valence in (3, 4, 5, 6, 7, 7, 17, 40, 200, 300))
        )
    elif name == "nearly_equal_angles":  # for float32 they are equal
        mesh = meshes.joined(*(meshes.fan(valence) for valence in (3, 5, 7, 9) * 50))
        random = np.random.default_rng(0)
        points = mesh.points - [0.3, 0.1, 0.0] * (mesh.points == [0.3, 0.1, 0.0]).all(axis=1)[:, None]
        points *= random.uniform(0.5, 1.5, (mesh.n_points, 1))
        mesh = mesh.with_points(points + random.normal(0, 1e-8, points.shape))
    else:
        mesh = meshes.HOSTILE[name]()
    road = {"iterations": 4, "fixed": fixed}
    fused, fused_report = loop.smooth(mesh, TrapeziumDrawing(), [Gate("aspect")], **road)
    monkeypatch.setattr(TrapeziumDrawing, "fuse", lambda *_: None)
    parts, report = loop.smooth(mesh, TrapeziumDrawing(), [Gate("aspect")], **road)
    assert fused.tobytes() == parts.tobytes()
    assert (fused_report.iterations, fused_report.stop_reason) == (report.iterations, report.stop_reason)
    assert report.moved == fused_report.moved > 0


def test_the_fused_sweep_is_what_trapezium_drawing_uses():
    torus = meshes.torus(12, 8)
    for constraints, fused, mesh in (
        ([Gate("aspect")], True, torus),
        ([Gate("aspect")], True, meshes.fan(300)),
        ([Boundary(sliding=False), Gate("aspect")], True, torus),
        ([Boundary(sliding=True), Gate("aspect")], False, torus),
        ([Gate("angle")], False, torus),
        ([DeviationBound(1.0), Gate("aspect")], False, torus),
    ):
        run = loop._Run(
            mesh,
            TrapeziumDrawing(),
            constraints,
            None,
            None,
            detection.detect,
            loop.StopRules(),
            loop._ignore,
        )
        run.start()
        assert (run.fused is not None) == fused


@pytest.mark.parametrize("name", ["umbrella", "thin-plate", "trapezium-drawing"])
def test_putting_a_scattered_mesh_in_order_changes_nothing_but_rounding(name, monkeypatch):
    mesh = meshes.torus(20, 10, "mixed", jitter=0.2)
    expected, _ = loop.smooth(mesh, SCHEMES[name], iterations=3)
    shuffled, _ = adjacency.renumbered(mesh, np.random.default_rng(0).permutation(200).astype(np.int32))
    fixed = np.random.default_rng(1).random(200) < 0.1
    usual = loop.smooth(shuffled, SCHEMES[name], iterations=3, fixed=fixed)[0]
    monkeypatch.setattr(loop, "_SCATTERED", 40)
    assert loop._scattered(adjacency.build(shuffled))
    assert not loop._scattered(adjacency.build(mesh))
    ordered = loop.smooth(shuffled, SCHEMES[name], iterations=3, fixed=fixed)[0]
    np.testing.assert_allclose(ordered, usual, atol=1e-12)
    assert ordered[fixed].tobytes() == shuffled.points[fixed].tobytes()
    assert (ordered != usual).any() or (expected != usual).any()


def test_several_blocks_are_still_the_definition(small_blocks):
    mesh = meshes.torus(40, 20, jitter=0.4)
    k = aspect_ratio.reference_directions(mesh)
    before = aspect_ratio.aspect_ratios(mesh, k)
    points, report = loop.smooth(mesh, TrapeziumDrawing(), [Gate("aspect")], iterations=3)
    after = aspect_ratio.aspect_ratios(mesh.with_points(points), k)
    assert report.iterations == 3
    assert after.min() > before.min()
    assert (after < 0).sum() <= (before < 0).sum()


# -- stopping -----------------------------------------------------------------------------------------


def vtk_deviation(mesh, points):
    distance, result = vtkImplicitPolyDataDistance(), vtkDoubleArray()
    distance.SetInput(meshes.polydata(mesh.with_points(mesh.points)))
    distance.FunctionValue(numpy_to_vtk(points), result)
    return np.abs(vtk_to_numpy(result))


def angle_between(a, b):
    cosine = (a * b).sum(axis=1) / np.linalg.norm(a, axis=1) / np.linalg.norm(b, axis=1)
    return np.degrees(np.arccos(np.clip(cosine, -1, 1)))


def dihedral_changes(mesh, points):
    before, after = reference.dihedral_angles(mesh), reference.dihedral_angles(mesh.with_points(points))
    return np.array([abs(after[edge] - before[edge]) for edge in before])


BOUNDS = {
    "normal_deviation": (
        "normal-deviation",
        3.0,
        lambda mesh, points: angle_between(
            reference.vertex_normals(mesh), reference.vertex_normals(mesh.with_points(points))
        ),
    ),
    "dihedral_change": ("dihedral-change", 4.0, dihedral_changes),
    "deviation": ("deviation", 0.02, vtk_deviation),
    "volume_percent": (
        "volume",
        3.0,
        lambda mesh, points: np.array(
            [100 * abs(reference.volume(mesh.with_points(points)) / reference.volume(mesh) - 1)]
        ),
    ),
}


@pytest.mark.parametrize("statistic", ["max", "mean"])
@pytest.mark.parametrize("gate", ["none", "angle"])
@pytest.mark.parametrize("rule", BOUNDS)
def test_a_bound_stops_the_run_before_it_is_exceeded(rule, gate, statistic):
    reason, bound, measured = BOUNDS[rule]
    bound *= 0.25 if gate == "angle" else 1.0
    mesh, scheme = meshes.torus(24, 12, jitter=0.3, seed=2), Umbrella(0.1)
    stop = loop.StopRules(**{rule: bound}, statistic=statistic)
    points, report = loop.smooth(mesh, scheme, GATES[gate], iterations=200, stop=stop)
    assert report.stop_reason == reason
    assert report.iterations < 200
    value = getattr(np, statistic)
    assert value(measured(mesh, points)) <= bound * (1 + 1e-9)
    # It was the same run as without the rule, and the next iteration would have been too much.
    free, _ = loop.smooth(mesh, scheme, GATES[gate], iterations=report.iterations)
    np.testing.assert_array_equal(free, points)
    further, _ = loop.smooth(mesh, scheme, GATES[gate], iterations=report.iterations + 1)
    assert value(measured(mesh, further)) > bound * (1 - 1e-9)


def test_the_mean_dihedral_change_of_an_open_mesh_stops_the_run_by_its_inner_edges():
    mesh = meshes.sheet(10, 8, jitter=0.2, bump=2.0)
    stop = loop.StopRules(dihedral_change=2.0, statistic="mean")
    points, report = loop.smooth(mesh, Umbrella(0.1), iterations=200, stop=stop)
    assert report.stop_reason == "dihedral-change"
    assert dihedral_changes(mesh, points).mean() <= 2.0
    further, _ = loop.smooth(mesh, Umbrella(0.1), iterations=report.iterations + 1)
    assert dihedral_changes(mesh, further).mean() > 2.0


def test_volume_bound_of_an_open_mesh_is_swept_volume_over_the_bounding_box():
    mesh = meshes.sheet(10, 8, jitter=0.2, bump=2.0)
    box = np.ptp(mesh.points, axis=0).prod()
    stop = loop.StopRules(volume_percent=2.0)
    points, report = loop.smooth(mesh, Umbrella(), iterations=100, stop=stop)
    assert report.stop_reason == "volume"
    assert report.iterations > 0
    assert abs(comparison.swept_volume(mesh, mesh.with_points(points))) <= 0.02 * box
    further, _ = loop.smooth(mesh, Umbrella(), iterations=report.iterations + 1)
    assert abs(comparison.swept_volume(mesh, mesh.with_points(further))) > 0.02 * box


@pytest.mark.parametrize("gate", GATES)
def test_too_little_gain(gate):
    mesh = meshes.torus(24, 12, jitter=0.3, seed=2)
    stop = loop.StopRules(gain=0.002)
    points, report = loop.smooth(mesh, TrapeziumDrawing(), GATES[gate], iterations=100, stop=stop)
    assert report.stop_reason == "gain"
    assert 1 < report.iterations < 100
    directions = aspect_ratio.reference_directions(mesh)

    def mean_after(iterations):
        points, _ = loop.smooth(mesh, TrapeziumDrawing(), GATES[gate], iterations=iterations)
        return aspect_ratio.aspect_ratios(mesh.with_points(points), directions).mean(), points

    (last, same), (previous, _) = mean_after(report.iterations), mean_after(report.iterations - 1)
    np.testing.assert_array_equal(points, same)
    assert last - previous < 0.002
    assert previous - mean_after(report.iterations - 2)[0] >= 0.002


# Steps of Taubin's end before; a low-pass filter of what it has made is another filter.
@pytest.mark.parametrize("name", sorted(SCHEMES.keys() - {"taubin", "low-pass"}))
def test_gated_runs_converge(name):
    mesh = meshes.sheet(5, 5, jitter=0.3, seed=1)
    points, report = loop.smooth(mesh, SCHEMES[name], [Gate("aspect")], iterations=20_000)
    assert report.stop_reason == "converged"
    again, after = loop.smooth(mesh.with_points(points), SCHEMES[name], [Gate("aspect")], iterations=10)
    assert (after.iterations, after.moved) == (0, 0)
    np.testing.assert_array_equal(again, points)


@pytest.mark.parametrize("gate", ["angle", "aspect"])
def test_points_that_no_face_uses_do_not_keep_a_run_from_converging(gate):
    mesh = meshes.isolated_points()
    points, report = loop.smooth(mesh, Umbrella(), GATES[gate], iterations=5000)
    assert report.stop_reason == "converged"
    assert report.moved <= 16
    isolated = np.setdiff1d(np.arange(mesh.n_points), mesh.connectivity)
    assert points[isolated].tobytes() == mesh.points[isolated].tobytes()


def test_no_iterations():
    mesh = meshes.torus(12, 8)
    points, report = loop.smooth(mesh, Umbrella(), iterations=0)
    np.testing.assert_array_equal(points, mesh.points)
    assert (report.iterations, report.stop_reason, report.moved) == (0, "iterations", 0)


def test_all_iterations():
    mesh = meshes.torus(12, 8, jitter=0.3)
    for gate in GATES.values():
        _, report = loop.smooth(mesh, Taubin(), gate, iterations=3)
        assert (report.iterations, report.stop_reason) == (3, "iterations")
        before, after = report.volume
        assert "3 iterations" in str(report)
        assert f"volume {before:.6g} -> {after:.6g}" in str(report)


@pytest.mark.parametrize("name", ["sphere", "torus of quads", "mixed torus"])
def test_the_reported_volumes(name):
    mesh = meshes.USUAL[name]()
    points, report = loop.smooth(mesh, Umbrella(), iterations=3)
    expected = reference.volume(mesh), reference.volume(mesh.with_points(points))
    assert report.volume == pytest.approx(expected, rel=1e-12)
    assert report.swept_volume == pytest.approx(expected[1] - expected[0], rel=1e-9)


# -- progress and cancelling --------------------------------------------------------------------------


@pytest.mark.parametrize("gate", GATES)
def test_progress_rises_from_0_to_1(gate, small_blocks):
    said = []
    mesh = meshes.torus(40, 20, jitter=0.3)
    loop.smooth(mesh, Umbrella(), GATES[gate], iterations=4, progress=lambda *what: said.append(what))
    fractions = [fraction for fraction, _ in said]
    assert fractions == sorted(fractions)
    assert (fractions[0], fractions[-1]) == (0.0, 1.0)
    assert sorted({what for _, what in said if what.startswith("iteration ")}) == [
        f"iteration {i} of 4" for i in (1, 2, 3, 4)
    ]
    assert all(isinstance(what, str) and what for _, what in said)
    if gate != "none":
        assert len(set(fractions)) > 10, "also within an iteration"


@pytest.mark.parametrize("gate", GATES)
def test_who_watches_is_told_the_measures_and_gets_the_same_result(gate):
    said = []
    mesh = meshes.torus(40, 20, jitter=0.3)
    tell = lambda *what: said.append(what[1])  # noqa: E731
    watched, report = loop.smooth(mesh, Umbrella(), GATES[gate], iterations=4, progress=tell, watched=True)
    assert np.array_equal(watched, loop.smooth(mesh, Umbrella(), GATES[gate], iterations=4)[0])
    first = next(what for what in said if what.startswith("iteration 1"))
    assert f"k mean {report.mean_aspect_ratio[0]:.3f}, min {report.min_aspect_ratio[0]:.3f}" in first


@pytest.mark.parametrize("gate", GATES)
@pytest.mark.parametrize("after", [0.0, 0.3, 0.999])
def test_progress_may_cancel(gate, after, small_blocks):
    def progress(fraction, what):
        if fraction >= after:
            raise Cancelled

    mesh = meshes.torus(40, 20, jitter=0.3)
    copy = mesh.points.copy()
    with pytest.raises(Cancelled):
        loop.smooth(mesh, TrapeziumDrawing(), GATES[gate], iterations=5, progress=progress)
    np.testing.assert_array_equal(mesh.points, copy)


def test_any_other_exception_of_progress_comes_through():
    def progress(fraction, what):
        raise ZeroDivisionError(what)

    with pytest.raises(ZeroDivisionError, match="neighbourhoods"):
        loop.smooth(meshes.cube(1), Umbrella(), iterations=5, progress=progress)


# -- hostile input ------------------------------------------------------------------------------------


@pytest.mark.parametrize("gate", GATES)
@pytest.mark.parametrize("name", SCHEMES)
@pytest.mark.parametrize("hostile", sorted(meshes.HOSTILE.keys() - {"high_valence"}))
def test_hostile_meshes_end_in_a_right_result(hostile, name, gate):
    mesh = meshes.HOSTILE[hostile]()
    near = adjacency.build(mesh)
    directions = aspect_ratio.reference_directions(mesh)
    before = aspect_ratio.aspect_ratios(mesh, directions)
    for extra in ([], [Boundary(sliding=True), BackToSurface(), DeviationBound(0.1)]):
        points, _ = loop.smooth(mesh, SCHEMES[name], [*extra, *GATES[gate]], iterations=3)
        used = near.kinds != adjacency.UNUSED
        assert np.isfinite(points[used]).all()
        assert points[~used].tobytes() == mesh.points[~used].tobytes()
        held = near.kinds == adjacency.NON_MANIFOLD
        assert points[held].tobytes() == mesh.points[held].tobytes()
        low, high = mesh.points[used].min(axis=0), mesh.points[used].max(axis=0)
        size = np.linalg.norm(high - low) + 1e-15
        assert (points[used] >= low - size).all()
        assert (points[used] <= high + size).all()
        if gate == "aspect":
            after = aspect_ratio.aspect_ratios(mesh.with_points(points), directions)
            assert after.min() >= before.min() - 1e-13
            assert (after < -1e-13).sum() <= (before < 0).sum()


@pytest.mark.parametrize("hostile", meshes.HOSTILE)
def test_hostile_meshes_with_every_stop_rule(hostile):
    mesh = meshes.HOSTILE[hostile]()
    stop = loop.StopRules(180.0, 360.0, 1e9, 1e9, -1e9)
    _, report = loop.smooth(mesh, Umbrella(0.1), iterations=2, stop=stop)
    assert report.stop_reason in ("iterations", "nothing-to-do")
    _, report = loop.smooth(mesh, Umbrella(0.1), iterations=2, stop=loop.StopRules(0.0, 0.0, 0.0, 0.0))
    assert np.isfinite([report.swept_volume, *report.min_aspect_ratio, *report.mean_aspect_ratio]).all()


@pytest.mark.parametrize("scale", [1e-60, 1e-12, 1e12, 1e60])
@pytest.mark.parametrize("gate", GATES)
@pytest.mark.parametrize("name", SCHEMES)
def test_huge_and_tiny_coordinates(name, gate, scale):
    mesh = meshes.torus(12, 8, jitter=0.3)
    expected, _ = loop.smooth(mesh, SCHEMES[name], GATES[gate], iterations=2)
    stop = loop.StopRules(180.0, 360.0, 1e70, 1e9, -1e9)
    scaled = mesh.with_points(mesh.points * scale)
    points, _ = loop.smooth(scaled, SCHEMES[name], GATES[gate], iterations=2, stop=stop)
    np.testing.assert_allclose(points / scale, expected, atol=1e-10)


def test_a_mesh_without_free_points():
    for faces in ([[0, 1, 2]], [[0, 1]], [[0], [1]], [[]], [[0, 0, 0]], [[0, 1, 0, 1]]):
        mesh = loop.Mesh.from_faces(np.eye(3), faces)
        for gate in GATES.values():
            points, report = loop.smooth(mesh, TrapeziumDrawing(), gate, iterations=5)
            np.testing.assert_array_equal(points, mesh.points)
            assert report.stop_reason == "nothing-to-do"


def test_a_mask_of_another_length_is_refused():
    mesh = meshes.sheet(4, 4)
    for length in (mesh.n_points - 1, mesh.n_points + 1):
        with pytest.raises(ParameterError, match=f"{mesh.n_points} points"):
            loop.smooth(mesh, Umbrella(), iterations=1, fixed=np.zeros(length))


def test_giant_faces_take_linear_time_and_hold_their_points():
    n = 20_000  # a cap with all pairs of its corners would take 3 GB and minutes
    angle = 2 * np.pi * np.arange(n) / n
    rim = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    ring = np.arange(n)
    sides = np.column_stack([ring, np.roll(ring, -1), n + np.roll(ring, -1), n + ring])
    cap = Mesh.from_arrays(
        np.vstack([rim, rim + np.array([0, 0, 1])]),
        np.concatenate([[0], 4 * np.arange(1, n + 1), [5 * n, 6 * n]]),
        np.concatenate([sides.ravel(), ring[::-1], n + ring]),
    )
    points, report = loop.smooth(cap, TrapeziumDrawing(), [Gate("aspect")], iterations=2)
    np.testing.assert_array_equal(points, cap.points)
    assert report.stop_reason == "nothing-to-do"
    assert report.volume[0] == pytest.approx(np.pi, rel=1e-6)


def test_a_large_mesh_with_nothing_but_degenerate_faces_stays():
    points = np.random.default_rng(0).random((40_000, 3))
    mesh = Mesh.from_arrays(points, [0, 3, 5], [5, 5, 5, 7, 7])
    for scheme, constraints in ((Umbrella(), []), (TrapeziumDrawing(), [Gate("aspect")])):
        result, report = loop.smooth(mesh, scheme, constraints, iterations=2)
        np.testing.assert_array_equal(result, points)
        assert report.stop_reason == "nothing-to-do"


@pytest.mark.parametrize("gate", ["aspect", "floor"])
@pytest.mark.parametrize(("kind", "best"), [("quads", 1.0), ("triangles", np.sqrt(3) / 2)])
def test_gates_do_not_stall_where_rows_move_together(kind, best, gate):
    # A graded grid whose boundary slides: no vertex gains alone, all of them together become even.
    mesh = meshes.sheet(10, 10, kind)
    mesh = mesh.with_points(10.0 * (mesh.points / 10.0) ** 1.5)
    k = []
    for iterations in (0, 10, 20, 100, 400):
        _, report = loop.smooth(mesh, Umbrella(), [Boundary(sliding=True), Gate(gate)], iterations=iterations)
        k.append(report.min_aspect_ratio[1])
        assert report.inverted[1] == 0
    assert k == sorted(k)
    assert k[0] < 0.45
    assert k[-1] > best - 0.03


def test_a_gate_that_accepts_nothing_is_the_reason_to_stop():
    # All angles of rectangles are right: a gate that looks at angles finds none better.
    even = meshes.sheet(10, 10, "quads")
    graded = even.with_points(10.0 * (even.points / 10.0) ** 1.5)
    for mesh, reason in ((graded, "gate"), (even, "converged")):
        points, report = loop.smooth(mesh, Umbrella(), [Boundary(sliding=True), Gate("angle")], iterations=5)
        assert (report.stop_reason, report.iterations) == (reason, 0)
        np.testing.assert_array_equal(points, mesh.points)
