"""Rolling back: no new self-intersection, whatever is proposed, with every other promise kept."""

import meshes
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from schemes import SCHEMES
from test_promises import ALTERNATIVES, CONSTRAINTS, MESHES

from vtksmooth import EquilateralSmoothing, LaplacianSmoothing, SelfIntersection
from vtksmooth.errors import ParameterError
from vtksmooth.kernels.containment.self_intersection import SelfIntersections
from vtksmooth.kernels.mesh.labels import labelled
from vtksmooth.kernels.mesh.mesh import Mesh
from vtksmooth.kernels.mesh.triangulate import triangulate
from vtksmooth.kernels.smoothing import loop
from vtksmooth.kernels.smoothing.constraints.label_volumes import LabelVolumes
from vtksmooth.kernels.smoothing.constraints.self_intersection import NoNewSelfIntersections
from vtksmooth.kernels.smoothing.schemes.pairwise import Pairwise
from vtksmooth.kernels.smoothing.schemes.pairwise_labels import PairwiseLabels

LOOK = "no self-intersection"


class Wild(type(SCHEMES["umbrella"])):
    """Proposes places at random, some edges away."""

    def __init__(self, size):
        super().__init__()
        self.size, self.random = size, np.random.default_rng(1)

    def propose(self, state, turn, starts, ends, proposed):
        for first, last in zip(starts, ends, strict=True):
            step = self.size * self.random.normal(size=(last - first, 3))
            step[state.pinned[first:last] != 0] = 0.0
            proposed[first:last] = state.points[first:last] + step


def levels(mesh, points):
    pairs, levels, degenerate = SelfIntersections(mesh).find(points)
    return dict(zip(map(tuple, pairs.tolist()), levels.tolist(), strict=True)), len(degenerate)


def assert_none_new(mesh, points):
    before, after = levels(mesh, mesh.points), levels(mesh, points)
    assert after[1] <= before[1]
    assert {pair: what for pair, what in after[0].items() if what > before[0].get(pair, 0)} == {}


@pytest.mark.parametrize("name", [name for name in CONSTRAINTS if name != LOOK])
def test_wild_steps_are_rolled_back_and_the_other_promise_is_kept(name):
    for mesh in MESHES:
        if name == "exact space" and not mesh.only_triangles:
            continue
        constraints = [CONSTRAINTS[name](mesh), CONSTRAINTS[LOOK](mesh)]
        points, report = loop.smooth(mesh, Wild(0.3), constraints, iterations=2, checked=True)
        assert report.broken == []
        assert_none_new(mesh, points)


def test_wild_steps_cross_otherwise():
    crossing = 0
    for mesh in MESHES:
        points, _ = loop.smooth(mesh, Wild(0.4), [], iterations=2)
        crossing += len(levels(mesh, points)[0])
        looked, report = loop.smooth(mesh, Wild(0.4), [NoNewSelfIntersections()], iterations=2)
        assert report.taken_back > 0
        # Only what must be is taken back.
        moved = (looked != mesh.points).any(axis=1)
        assert moved.sum() > 0.3 * (points != mesh.points).any(axis=1).sum()
    assert crossing > 100


@given(
    mesh=st.sampled_from(MESHES),
    names=st.lists(st.sampled_from(sorted(set(CONSTRAINTS) - {LOOK})), min_size=1, max_size=4, unique=True),
    iterations=st.integers(1, 4),
    size=st.sampled_from([0.05, 0.15, 0.4]),
)
@settings(max_examples=60, deadline=None)
def test_random_sets_of_promises_are_kept_as_steps_are_rolled_back(mesh, names, iterations, size):
    for alternatives in ALTERNATIVES:
        if alternatives <= set(names):
            names.remove(min(alternatives))
    if "exact space" in names and not mesh.only_triangles:
        names.remove("exact space")
    constraints = [CONSTRAINTS[name](mesh) for name in [*names, LOOK]]
    try:
        points, report = loop.smooth(mesh, Wild(size), constraints, iterations=iterations, checked=True)
    except ParameterError as error:
        assert "cannot go together" in str(error)  # noqa: PT017
        return
    assert report.broken == []
    assert_none_new(mesh, points)


def thin():
    """Return the skin of a random body of flat voxels, whose walls lie near each other."""
    values = np.random.default_rng(0).normal(size=(14, 14, 14))
    for _ in range(2):
        for axis in range(3):
            values = (np.roll(values, 1, axis) + 2.0 * values + np.roll(values, -1, axis)) / 4.0
    mesh = meshes.voxels(np.argwhere(values > np.quantile(values, 0.7)).tolist(), triangles=True)
    return mesh.with_points(mesh.points * [1.0, 1.0, 0.4])


@pytest.mark.parametrize("every", [1, 3, 20])
def test_pairwise_on_thin_walls(every, monkeypatch):
    monkeypatch.setattr(loop, "EVERY", every)
    mesh = thin()
    points, report = loop.smooth(mesh, Pairwise(), iterations=20)
    assert len(levels(mesh, points)[0]) > len(levels(mesh, mesh.points)[0])
    points, report = loop.smooth(mesh, Pairwise(), [NoNewSelfIntersections()], iterations=20, checked=True)
    assert report.broken == []
    assert report.taken_back > 0
    assert_none_new(mesh, points)
    assert abs(report.swept_volume) <= 1e-13 * mesh.diagonal**3


@pytest.mark.parametrize("scheme", [PairwiseLabels, lambda: Wild(0.2)])
def test_labels_keep_their_volumes_as_steps_are_rolled_back(scheme):
    quads, _ = labelled(*meshes.label_walls(meshes.grains(9, 5)))
    corners, cell = triangulate(quads)
    mesh, _ = labelled(Mesh.from_faces(quads.points, corners), quads.face_labels[cell])
    made = scheme()
    constraints = [NoNewSelfIntersections(), *([] if made.keeps else [LabelVolumes()])]
    points, report = loop.smooth(mesh, made, constraints, iterations=5, checked=True)
    assert report.broken == []
    assert_none_new(mesh, points)
    assert report.worst_label[0] <= 1e-12
    assert report.taken_back > 0 or made.keeps


def test_where_nothing_crosses_bits_stay():
    for mesh in MESHES:
        plain, _ = loop.smooth(mesh, SCHEMES["umbrella"], iterations=5)
        looked, report = loop.smooth(mesh, SCHEMES["umbrella"], [NoNewSelfIntersections()], iterations=5)
        assert report.taken_back == 0
        np.testing.assert_array_equal(looked, plain)


def test_pairs_that_cross_at_the_start_do_not_become_more():
    one, other = meshes.icosphere(2), meshes.icosphere(2)
    both = meshes.joined(one, other.with_points(other.points * 0.9 + [0.8, 0.1, 0.05]))
    points, report = loop.smooth(both, Wild(0.1), [NoNewSelfIntersections()], iterations=3, checked=True)
    assert report.broken == []
    assert len(levels(both, both.points)[0]) > 50
    assert_none_new(both, points)


def test_the_promise_holds_of_what_is_written_in_single_precision():
    # Two sheets so near that rounding decides whether they cross.
    sheet = meshes.sheet(20, 20, jitter=0.3, bump=1.0, seed=2)
    both = meshes.joined(sheet, sheet.with_points(sheet.points + np.array([0.0, 0.0, 3e-6])))
    source = meshes.polydata(both.with_points((both.points + 10.0).astype(np.float32).astype(float)))
    check = SelfIntersection()
    check(source)
    before = check.summary
    for precision in ("single", "double"):
        smoothing = LaplacianSmoothing(
            iterations=7, self_intersection="none-new", output_points_precision=precision
        )
        check(smoothing(source))
        assert check.summary["crossing_pairs"] <= before["crossing_pairs"]


def test_the_report_says_what_was_taken_back():
    mesh = meshes.polydata(thin())
    smoothing = LaplacianSmoothing(scheme="pairwise", iterations=20, self_intersection="none-new")
    smoothing(mesh)
    assert smoothing.report.taken_back > 0
    assert "steps taken back where faces would have crossed" in str(smoothing.report)
    assert EquilateralSmoothing().self_intersection == "none-new"


def test_bad_meshes_do_not_stop_it():
    for mesh in (
        meshes.degenerate_faces(),
        meshes.all_points_the_same(),
        meshes.non_manifold_edge(),
        meshes.folded_quads(),
    ):
        _, report = loop.smooth(mesh, Wild(0.2), [NoNewSelfIntersections()], iterations=2, checked=True)
        assert report.broken == []
    assert isinstance(mesh, Mesh)
