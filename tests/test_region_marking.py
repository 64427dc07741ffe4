"""Marks made by hand: what RegionMarking writes, and what every smoothing filter does with it."""

import base64
import itertools
import zlib

import meshes
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from vtkmodules.util.numpy_support import vtk_to_numpy

from vtksmooth.errors import Cancelled, InvalidMeshError, ParameterError
from vtksmooth.files import read_surface, write_surface
from vtksmooth.filters import (
    FILTERS,
    FeatureDetection,
    InstallationSpaceSmoothing,
    LaplacianSmoothing,
    NullSpaceSmoothing,
    RegionMarking,
    SmoothingFilter,
    TrapeziumDrawing,
)
from vtksmooth.filters.arrays import vtk_array
from vtksmooth.filters.point_lists import format_lines, format_points, parse_lines, parse_points
from vtksmooth.kernels.mesh.paths import edge_distances, shortest_path
from vtksmooth.kernels.mesh.regions import blend_weights, grown, rings_of

SMOOTHING = [cls for cls in FILTERS if issubclass(cls, SmoothingFilter) and len(cls.inputs) == 1]


def points_of(mesh):
    return vtk_to_numpy(mesh.GetPoints().GetData()).copy()


def point_data(mesh, name):
    array = mesh.GetPointData().GetArray(name)
    return None if array is None else vtk_to_numpy(array).copy()


def field(mesh, name):
    array = mesh.GetFieldData().GetArray(name)
    return None if array is None else vtk_to_numpy(array).tolist()


def mark(mesh, **values):
    return RegionMarking(**values)(mesh)


# -- texts ---------------------------------------------------------------------------------------------


@given(st.sets(st.integers(0, 3000)))
def test_points_are_a_round_trip(points):
    if points:
        assert parse_points("fix", format_points(list(points)), 3001).tolist() == sorted(points)


def test_very_many_scattered_points_are_written_as_bits():
    points = np.flatnonzero(np.random.default_rng(0).random(100_000) < 0.5)
    text = format_points(points)
    assert text.startswith("bits:")
    assert len(text) < 20_000
    np.testing.assert_array_equal(parse_points("fix", text, 100_000), points)
    with pytest.raises(ParameterError, match="numbered 0 to 49999"):
        parse_points("fix", text, 50_000)


@given(st.lists(st.lists(st.integers(0, 99), min_size=2, max_size=6), min_size=1, max_size=5))
def test_lines_are_a_round_trip(lines):
    pairs = [pair for line in lines for pair in itertools.pairwise(line)]
    assert parse_lines("add_lines", format_lines(lines), 100).tolist() == [list(pair) for pair in pairs]


@pytest.mark.parametrize(
    "text", ["a", "1,", "5-3", "1-2-3", "bits:???", "bits:AAAA", "bits:", "bits:eJw=", "9" * 40]
)
def test_other_texts_are_refused(text):
    with pytest.raises(ParameterError, match="fix"):
        parse_points("fix", text, 10)


def test_short_texts_of_very_many_points_take_no_memory():
    bomb = "bits:" + base64.urlsafe_b64encode(zlib.compress(b"\xff" * 50_000_000)).decode()
    for text in ("0-2147483647", "0-99999999999", f"7,0-{10**30}", bomb):
        with pytest.raises(ParameterError, match="numbered 0 to 9"):
            parse_points("fix", text, 10)
    assert parse_points("fix", ",".join(["0-99999"] * 10_000), 100_000).tolist() == list(range(100_000))


@pytest.mark.parametrize("text", ["a", "1", "1-2,", "1--2", "1-99"])
def test_other_lines_are_refused(text):
    with pytest.raises(ParameterError, match="add_lines"):
        parse_lines("add_lines", text, 10)


# -- regions -------------------------------------------------------------------------------------------


def test_marks_are_made_in_order_and_nothing_else_changes():
    shape = meshes.torus(12, 8)
    mesh = meshes.polydata(shape)
    mesh.GetPointData().AddArray(vtk_array(np.arange(96.0), "Height"))
    first = mark(mesh, fix="0-9,20")
    expected = np.isin(np.arange(96), [*range(10), 20])
    assert point_data(first, "Fixed").dtype == np.uint8
    np.testing.assert_array_equal(point_data(first, "Fixed"), expected)
    assert point_data(first, "BlendWeight") is None
    assert point_data(mesh, "Fixed") is None
    second = mark(first, free="5", fix="30", invert=True, grow=2, shrink=1)
    expected[5], expected[30] = False, True
    rings = rings_of(shape)
    expected = ~grown(rings, ~grown(rings, ~expected, 2), 1)
    np.testing.assert_array_equal(point_data(second, "Fixed"), expected)
    for result in (first, second):
        np.testing.assert_array_equal(points_of(result), points_of(mesh))
        assert result.GetPolys().GetConnectivityArray() is mesh.GetPolys().GetConnectivityArray()
        np.testing.assert_array_equal(point_data(result, "Height"), np.arange(96.0))
    assert point_data(mark(second, clear="region"), "Fixed") is None
    assert not point_data(mark(second, free="all"), "Fixed").any()


def test_soft_edges_by_rings_and_by_distance():
    shape = meshes.sheet(12, 6)
    mesh = meshes.polydata(shape)
    fixed = shape.points[:, 0] <= 2
    fix = format_points(np.flatnonzero(fixed))
    marking = RegionMarking(fix=fix, blend_rings=3)
    weights = point_data(marking(mesh), "BlendWeight")
    np.testing.assert_array_equal(weights, 1.0 - blend_weights(shape, ~fixed, 3))
    assert (weights[fixed] == 0).all()
    assert (weights[shape.points[:, 0] > 5] == 1).all()
    assert marking.summary["blended"] == ((weights > 0) & (weights < 1)).sum()
    weights = point_data(mark(mesh, fix=fix, blend_distance=4.0), "BlendWeight")
    away = edge_distances(shape.points, rings_of(shape), np.flatnonzero(fixed))
    np.testing.assert_allclose(weights, np.minimum(1.0, away / 4.0))
    with pytest.raises(ParameterError, match="rings or over a distance"):
        mark(mesh, fix=fix, blend_rings=1, blend_distance=1.0)


def test_weights_follow_points_that_are_fixed_and_freed_later():
    mesh = mark(meshes.polydata(meshes.sheet(12, 6)), fix="0-12", blend_rings=2)
    weights = point_data(mesh, "BlendWeight")
    later = point_data(mark(mesh, free="0", fix="40"), "BlendWeight")
    weights[[0, 40]] = 1.0, 0.0
    np.testing.assert_array_equal(later, weights)
    assert point_data(mark(mesh, blend_rings=0), "BlendWeight") is None


def test_points_that_are_not_there_are_refused():
    with pytest.raises(ParameterError, match=r"fix: there is no point 99; .* numbered 0 to 95"):
        mark(meshes.polydata(meshes.torus(12, 8)), fix="99")


# -- lines ---------------------------------------------------------------------------------------------


def test_lines_come_and_go():
    mesh = meshes.polydata(meshes.torus(12, 8))
    one = mark(mesh, add_lines="0-1-2,14-2")
    assert field(one, "AddedFeatureEdges") == [[0, 1], [1, 2], [2, 14]]
    two = mark(one, add_lines="2-3", remove_lines="2-1")
    assert field(two, "AddedFeatureEdges") == [[0, 1], [2, 3], [2, 14]]
    assert field(two, "RemovedFeatureEdges") == [[1, 2]]
    three = mark(two, add_lines="1-2", clear="nothing")
    assert field(three, "RemovedFeatureEdges") is None
    assert field(mark(three, clear="lines"), "AddedFeatureEdges") is None
    assert field(mesh, "AddedFeatureEdges") is None
    with pytest.raises(InvalidMeshError, match="no edges of the mesh"):
        mark(mesh, add_lines="0-50")


def test_detection_has_the_lines():
    mesh = meshes.polydata(meshes.icosphere(3))
    path = shortest_path(meshes.icosphere(3).points, rings_of(meshes.icosphere(3)), 0, 30)
    marked, lines = FeatureDetection()(mark(mesh, add_lines=format_lines([path])))
    assert (point_data(marked, "FeatureClass") > 0).sum() == len(path)
    assert lines.GetNumberOfLines() == 1
    assert sorted(point_data(lines, "PointIds")) == sorted(path)
    ignored, lines = FeatureDetection(added_edges=None)(mark(mesh, add_lines=format_lines([path])))
    assert not point_data(ignored, "FeatureClass").any()
    with pytest.raises(ParameterError, match="no field array 'Mine'"):
        FeatureDetection(added_edges="Mine")(mesh)


# -- what smoothing does with them ---------------------------------------------------------------------


@pytest.mark.parametrize("cls", SMOOTHING, ids=lambda cls: cls.command)
def test_marked_points_stay_and_weighted_points_move_less(cls):
    shape = meshes.torus(24, 16, jitter=0.3)
    mesh = meshes.polydata(shape)
    fixed = shape.points[:, 0] > 1.0
    marked = mark(mesh, fix=format_points(np.flatnonzero(fixed)), blend_rings=3)
    weights = point_data(marked, "BlendWeight")
    free = points_of(cls(iterations=1, gate="none")(mesh))
    softly = points_of(cls(iterations=1, gate="none")(marked))
    np.testing.assert_array_equal(softly[fixed], shape.points[fixed])
    assert not np.array_equal(softly[weights == 1.0], shape.points[weights == 1.0])
    hard = points_of(cls(iterations=1, gate="none", blend=None)(marked))
    between = (weights > 0) & (weights < 1)
    assert not np.array_equal(softly[between], hard[between])
    assert not np.array_equal(free[fixed], shape.points[fixed])


def test_one_step_is_taken_in_proportion():
    shape = meshes.torus(24, 16, jitter=0.3)
    fixed = format_points(np.flatnonzero(shape.points[:, 0] > 1.0))
    marked = mark(meshes.polydata(shape), fix=fixed, blend_rings=3)
    weights = point_data(marked, "BlendWeight")
    steps = {
        blend: points_of(LaplacianSmoothing(iterations=1, blend=blend)(marked)) - shape.points
        for blend in (None, "BlendWeight")
    }
    np.testing.assert_allclose(steps["BlendWeight"], weights[:, None] * steps[None], atol=1e-12)


def test_weights_that_are_all_one_cost_nothing_and_wrong_ones_are_refused():
    mesh = meshes.polydata(meshes.torus(24, 16, jitter=0.3))
    plain = points_of(TrapeziumDrawing()(mesh))
    mesh.GetPointData().AddArray(vtk_array(np.ones(384), "BlendWeight"))
    np.testing.assert_array_equal(points_of(TrapeziumDrawing()(mesh)), plain)
    mesh.GetPointData().AddArray(vtk_array(np.full(384, 2.0), "BlendWeight"))
    with pytest.raises(ParameterError, match=r"from 0 .* to 1"):
        TrapeziumDrawing()(mesh)


@pytest.mark.parametrize("cls", [LaplacianSmoothing, NullSpaceSmoothing])
def test_points_on_a_line_by_hand_are_held_or_slide(cls):
    shape = meshes.torus(24, 16, jitter=0.2)
    line = np.arange(24)
    marked = mark(meshes.polydata(shape), add_lines=format_lines([[*line, 0]]))
    if cls is LaplacianSmoothing:
        held = points_of(cls(iterations=3, features="hold")(marked))
        np.testing.assert_array_equal(held[line], shape.points[line])
    slid = points_of(cls(iterations=3, features="slide")(marked))
    without = points_of(cls(iterations=3, features="slide", added_edges=None)(marked))
    assert not np.array_equal(slid[line], without[line])
    assert not np.array_equal(slid[line], shape.points[line])


def test_a_ridge_that_is_removed_does_not_hold():
    shape = meshes.cube(4, triangles=True)
    x, y, z = shape.points.T
    line = np.flatnonzero((x == 0) & (y == 0))[np.argsort(z[(x == 0) & (y == 0)])]
    mesh = meshes.polydata(shape)
    removed = mark(mesh, remove_lines=format_lines([line]))
    for source, moves in ((mesh, False), (removed, True)):
        after = points_of(LaplacianSmoothing(iterations=1, features="hold")(source))
        assert (after[line[1:-1]] != shape.points[line[1:-1]]).any() == moves


@pytest.mark.parametrize("detected", [False, True])
def test_a_file_gives_the_same_bits(tmp_path, detected):
    shape = meshes.torus(24, 16, jitter=0.3)
    marked = mark(
        meshes.polydata(shape), fix="100-140", blend_distance=1.5, add_lines="0-1-2-3-4-5", remove_lines="7-8"
    )
    if detected:
        marked = FeatureDetection()(marked)[0]
    write_surface(marked, tmp_path / "marked.vtp")
    again = read_surface(tmp_path / "marked.vtp")[0]
    smoothing = NullSpaceSmoothing(iterations=3)
    np.testing.assert_array_equal(points_of(smoothing(again)), points_of(smoothing(marked)))
    plain = points_of(smoothing(meshes.polydata(shape)))
    assert not np.array_equal(points_of(smoothing(marked)), plain)


def test_what_runs_in_place_has_the_features_in_its_own_numbering():
    shape = meshes.torus(24, 16, jitter=0.2)
    line = np.arange(24)
    marked = mark(meshes.polydata(shape), add_lines=format_lines([[*line, 0]]))
    after = points_of(TrapeziumDrawing(features="hold")(marked))
    np.testing.assert_array_equal(after[line], shape.points[line])
    assert not np.array_equal(after[24:], shape.points[24:])


def test_a_skin_in_its_space_keeps_what_is_fixed_by_hand():
    from vtksmooth import samples

    skin, space = samples.channel()
    smoothing = InstallationSpaceSmoothing(iterations=2)
    free = smoothing(skin, space)
    moved = np.flatnonzero((points_of(free) != points_of(skin)).any(axis=1))
    held = moved[::3]
    marked = mark(skin, fix=format_points(held), blend_rings=1)
    smoothing = InstallationSpaceSmoothing(iterations=2, fixed="Fixed", blend="BlendWeight")
    result = smoothing(marked, space)
    np.testing.assert_array_equal(points_of(result)[held], points_of(skin)[held])
    assert (points_of(result) != points_of(skin)).any()
    fixed = point_data(result, "Fixed").astype(bool)
    np.testing.assert_array_equal(
        fixed, point_data(free, "Fixed").astype(bool) | np.isin(np.arange(len(fixed)), held)
    )
    assert (point_data(result, "BlendWeight") <= point_data(free, "BlendWeight")).all()


@pytest.mark.parametrize("name", ["grow", "shrink", "blend_rings"])
def test_any_number_of_rings_ends_when_nothing_changes(name):
    shape = meshes.sheet(12, 6)
    mesh = mark(meshes.polydata(shape), fix="0-20")
    ends = mark(mesh, **{name: 10**4})
    for number in (10**9, 10**30):
        again = mark(mesh, **{name: number})
        for array in ("Fixed", "BlendWeight"):
            np.testing.assert_array_equal(point_data(again, array), point_data(ends, array))
    assert point_data(ends, "Fixed").all() == (name == "grow")
    assert point_data(ends, "Fixed").any() == (name != "shrink")


def test_weights_that_take_long_to_come_to_rest_can_be_cancelled():
    # Over hundreds of rings weights change in their last bits for hundred thousands of steps.
    marking = RegionMarking(fix="0", blend_rings=10**9)
    marking.AddObserver("ProgressEvent", lambda *_: marking.SetAbortExecute(1))
    with pytest.raises(Cancelled):
        marking(meshes.polydata(meshes.sheet(2000, 1)))
