"""Regions painted, picked and drawn with the mouse, and what filters do with them; compared with scripts."""

import itertools
import subprocess
import sys

import meshes
import numpy as np
import pytest
import pyvista as pv
from vtkmodules.util.numpy_support import vtk_to_numpy

from vtksmooth.files import read_surface
from vtksmooth.filters import FeatureDetection, LaplacianSmoothing, RegionMarking, TrapeziumDrawing
from vtksmooth.filters.point_lists import format_points
from vtksmooth.kernels.mesh.paths import shortest_path
from vtksmooth.kernels.mesh.regions import components, grown, rings_of, shrunk


def points(mesh):
    return vtk_to_numpy(mesh.GetPoints().GetData())


@pytest.fixture
def sphere(tmp_path):
    mesh = pv.Sphere(theta_resolution=40, phi_resolution=40)
    noise = np.random.default_rng(0).normal(scale=0.002, size=mesh.points.shape)
    mesh.points += noise.astype(np.float32)
    mesh.save(tmp_path / "sphere.vtp")
    return tmp_path / "sphere.vtp"


@pytest.fixture
def box(tmp_path):
    pv.wrap(meshes.polydata(meshes.cube(4, triangles=True))).save(tmp_path / "box.vtp")
    return tmp_path / "box.vtp"


class Hand:
    """A user with a mouse over the view."""

    def __init__(self, user):
        from PySide6.QtCore import QEvent, Qt

        self.user, self.Qt, self.QEvent = user, Qt, QEvent
        self.canvas = user.window.view.plotter.interactor

    def place(self, point):
        """Where a point of the mesh stands in the view."""
        from PySide6.QtCore import QPointF

        x, y = self.user.application.regions._looked().places[point, :2]
        ratio = self.user.window.view.devicePixelRatioF()
        return QPointF(x / ratio, self.canvas.height() - y / ratio)

    def middle(self):
        from PySide6.QtCore import QPointF

        return QPointF(self.canvas.width() / 2, self.canvas.height() / 2)

    def send(self, kind, at, button, buttons, modifier):
        from PySide6.QtGui import QMouseEvent
        from PySide6.QtWidgets import QApplication

        there = self.canvas.mapToGlobal(at)
        QApplication.sendEvent(self.canvas, QMouseEvent(kind, at, there, button, buttons, modifier))

    def drag(self, *places, modifier=None, button=None, wait=True):
        """Press the button, move through the places, let go."""
        modifier = modifier or self.Qt.KeyboardModifier.NoModifier
        button = button or self.Qt.MouseButton.LeftButton
        none = self.Qt.MouseButton.NoButton
        self.send(self.QEvent.Type.MouseMove, places[0], none, none, modifier)
        self.send(self.QEvent.Type.MouseButtonPress, places[0], button, button, modifier)
        for place in places[1:]:
            self.send(self.QEvent.Type.MouseMove, place, none, button, modifier)
        self.send(self.QEvent.Type.MouseButtonRelease, places[-1], button, none, modifier)
        if wait:
            self.user.wait(lambda: not self.user.application.regions._waiting)

    def click(self, at, modifier=None):
        self.drag(at, at, modifier=modifier)

    @property
    def ctrl(self):
        return self.Qt.KeyboardModifier.ControlModifier


@pytest.fixture
def hand(user):
    return Hand(user)


def fixed(user):
    array = user.mesh.GetPointData().GetArray("Fixed")
    return np.zeros(user.mesh.GetNumberOfPoints(), bool) if array is None else vtk_to_numpy(array) != 0


def edges(user, name):
    array = user.mesh.GetFieldData().GetArray(f"{name}FeatureEdges")
    return set() if array is None else {tuple(pair) for pair in vtk_to_numpy(array).tolist()}


def logged(user, folder):
    """What the log makes, run as the script that it is."""
    (folder / "log.py").write_text(user.window.log.toPlainText())
    result = folder / "logged.vtp"
    words = [sys.executable, folder / "log.py", user.document.active.source, result]
    done = subprocess.run(words, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return read_surface(result)[0]


# -- painting ------------------------------------------------------------------------------------------


def test_painted_points_stay_and_a_script_gives_the_same(user, hand, sphere, tmp_path):
    user.drop(sphere)
    user.do("region_brush")
    at = hand.middle()
    hand.drag(at, at + (at - hand.place(0)) * 0.05, at + (at - hand.place(0)) * 0.2)
    painted = np.flatnonzero(fixed(user))
    places = user.application.regions._looked().places
    ratio, radius = user.window.view.devicePixelRatioF(), user.application.regions.pen.radius
    near = np.hypot(places[:, 0] - at.x() * ratio, places[:, 1] - (hand.canvas.height() - at.y()) * ratio)
    front = user.application.regions._looked().seen
    assert set(np.flatnonzero(front & (near < 0.95 * radius * ratio))) <= set(painted)
    assert front[painted].all()
    assert not fixed(user)[near < radius * ratio].all()  # the other side is not reached
    assert f"fix {len(painted)} points" in user.document.history.steps[-1].title
    assert f"{len(painted)} fixed" in user.window.regions.counts.text()
    assert user.window.view._marks["region"].actor.GetVisibility()
    assert not user.window.view._marks["stroke"].actor.GetVisibility()
    user.apply(LaplacianSmoothing, iterations=5)
    assert np.array_equal(points(user.mesh)[painted], points(read_surface(sphere)[0])[painted])
    marked = RegionMarking(fix=format_points(painted))(read_surface(sphere)[0])
    assert np.array_equal(points(user.mesh), points(LaplacianSmoothing(iterations=5)(marked)))
    free = LaplacianSmoothing(iterations=5)(read_surface(sphere)[0])
    assert not np.array_equal(points(user.mesh)[painted], points(free)[painted])
    # The log does the same, and so does the recipe.
    assert np.array_equal(points(logged(user, tmp_path)), points(user.mesh))
    recipe = user.document.active.state.recipe
    assert [step.command for step in recipe.steps] == ["mark", "laplacian"]
    assert np.array_equal(points(recipe.run(read_surface(sphere)[0])), points(user.mesh))


def test_ctrl_frees_and_undo_brings_back(user, hand, sphere):
    user.drop(sphere)
    user.do("region_brush")
    hand.click(hand.middle())
    first = fixed(user)
    assert first.any()
    user.window.regions.radius.setValue(12)
    hand.click(hand.middle(), hand.ctrl)
    second = fixed(user)
    assert second.any()
    assert (second < first).any()
    assert (second <= first).all()
    user.do("undo")
    assert np.array_equal(fixed(user), first)
    user.do("undo")
    assert not fixed(user).any()
    assert not user.window.view._marks["region"].actor.GetVisibility()
    user.do("redo")
    assert np.array_equal(fixed(user), first)
    user.do("region_free")
    hand.click(hand.middle())
    assert np.array_equal(fixed(user), second)
    # There is nothing more to free there, and that is no step.
    steps = len(user.document.history.steps)
    hand.click(hand.middle())
    assert len(user.document.history.steps) == steps
    assert "no point there is fixed" in user.said


def test_a_stroke_neither_draws_the_mesh_anew_nor_measures_it_again(user, hand, sphere):
    user.drop(sphere)
    user.do("region_brush")
    before = user.document.active.state
    drawn, field = user.window.view._surfaces["after"].data, user.display.fields[0]
    hand.click(hand.middle())
    after = user.document.active.state
    assert after is not before
    assert after.surface.mesh.connectivity is before.surface.mesh.connectivity
    assert user.window.view._surfaces["after"].data is drawn
    assert user.display.fields[0] is field
    user.do("undo")
    assert user.document.active.state is before
    assert user.window.view._surfaces["after"].data is drawn


def test_beside_the_mesh_and_with_the_right_button_the_view_turns(user, hand, sphere):
    from PySide6.QtCore import QPointF

    user.drop(sphere)
    user.do("region_brush")
    camera = user.window.view.camera
    for at, button in ((QPointF(8, 8), None), (hand.middle(), hand.Qt.MouseButton.RightButton)):
        before = camera.GetPosition()
        hand.drag(at, at + QPointF(30, 5), at + QPointF(60, 20), button=button)
        assert not np.allclose(camera.GetPosition(), before)
        assert not fixed(user).any()
    before = camera.GetPosition()
    hand.drag(hand.middle(), hand.middle() + QPointF(30, 0))
    assert camera.GetPosition() == before
    assert fixed(user).any()


def test_keys_choose_the_brush_change_it_and_leave_it(user, hand, sphere):
    from PySide6.QtCore import Qt

    user.drop(sphere)
    pen = user.application.regions.pen
    user.press(Qt.Key.Key_B, Qt.KeyboardModifier.ShiftModifier)
    assert user.application.regions.tool == "brush"
    assert pen.isVisible()
    radius = pen.radius
    user.press(Qt.Key.Key_BracketRight)
    assert pen.radius > radius
    user.press(Qt.Key.Key_BracketLeft)
    user.press(Qt.Key.Key_BracketLeft)
    assert pen.radius < radius
    user.press(Qt.Key.Key_Escape)
    assert user.application.regions.tool == "camera"
    assert user.window.action("region_camera").isChecked()
    assert not pen.isVisible()
    hand.click(hand.middle())
    assert not fixed(user).any()


# -- lasso and threshold -------------------------------------------------------------------------------


@pytest.mark.parametrize("through", [False, True])
def test_a_lasso_takes_what_is_inside_and_seen_or_all(user, hand, sphere, through):
    from PySide6.QtCore import QPointF

    user.drop(sphere)
    user.do("view_pz")
    if through:
        user.do("region_through")
    user.do("region_lasso")
    at = hand.middle()
    corners = [at + QPointF(x, y) for x, y in ((-60, -60), (60, -60), (60, 60), (-60, 60))]
    hand.drag(*corners)
    look, ratio = user.application.regions._looked(), user.window.view.devicePixelRatioF()
    middle = np.array([at.x(), hand.canvas.height() - at.y()]) * ratio
    inside = (np.abs(look.places[:, :2] - middle) < 60 * ratio).all(axis=1)
    front = points(user.mesh)[:, 2] > 0
    assert np.array_equal(fixed(user), inside if through else inside & front)


def test_by_threshold_of_the_overlay_that_is_shown(user, ant):
    user.drop(ant)
    k = user.display.fields[0].values
    assert user.window.regions.what.text() == "Aspect ratio k"
    user.do("region_threshold")  # what is bad
    faces = pv.wrap(user.mesh).regular_faces
    assert np.array_equal(np.flatnonzero(fixed(user)), np.unique(faces[k <= 0.2]))
    user.do("undo")
    user.window.histogram.set_brush((0.5, 0.75))
    user.do("region_threshold")
    assert np.array_equal(np.flatnonzero(fixed(user)), np.unique(faces[(k >= 0.5) & (k <= 0.75)]))
    user.do("overlay_none")
    user.do("region_threshold")
    assert "Show an overlay" in user.said


# -- the region as a whole -----------------------------------------------------------------------------


def test_grow_shrink_invert_and_clear(user, hand, sphere):
    user.drop(sphere)
    rings = rings_of(user.document.active.state.surface.mesh)
    user.do("region_brush")
    hand.click(hand.middle())
    expected = fixed(user)
    for command, change in (
        ("region_grow", lambda marked: grown(rings, marked, 1)),
        ("region_grow", lambda marked: grown(rings, marked, 1)),
        ("region_shrink", lambda marked: shrunk(rings, marked, 1)),
        ("region_invert", np.logical_not),
        ("region_clear", np.zeros_like),
    ):
        user.do(command)
        expected = change(expected)
        assert np.array_equal(fixed(user), expected), command
    assert user.mesh.GetPointData().GetArray("Fixed") is None


def test_a_soft_edge_is_shown_saved_and_used(user, hand, sphere, tmp_path, open_window):
    user.drop(sphere)
    user.do("region_brush")
    hand.click(hand.middle())
    user.do("region_soften")
    weights = vtk_to_numpy(user.mesh.GetPointData().GetArray("BlendWeight"))
    marked = RegionMarking(fix=format_points(np.flatnonzero(fixed(user))), blend_rings=3)(
        read_surface(sphere)[0]
    )
    assert np.array_equal(weights, vtk_to_numpy(marked.GetPointData().GetArray("BlendWeight")))
    user.do("bad_faces")
    user.do("overlay_blend_weight")
    assert np.array_equal(user.display.fields[0].values, weights)
    assert user.window.colour_bar.thresholds is None  # no weight is good or bad
    assert not user.window.view._marks["bad"].actor.GetVisibility()
    assert (user.window.regions.low.value(), user.window.regions.high.value()) == (0.0, 1.0)
    user.do("overlay_none")
    assert (user.window.regions.low.text(), user.window.regions.high.text()) == ("", "")
    user.do("overlay_fixed")
    assert np.array_equal(user.display.fields[0].values != 0, fixed(user))
    user.application.files.write(user.document.active, tmp_path / "marked.vtp")
    user.apply(TrapeziumDrawing, iterations=2)
    assert np.array_equal(points(user.mesh), points(TrapeziumDrawing(iterations=2)(marked)))
    again = open_window(tmp_path / "marked.vtp")
    assert np.array_equal(fixed(again), fixed(user))
    again.apply(TrapeziumDrawing, iterations=2)
    assert np.array_equal(points(again.mesh), points(user.mesh))


# -- picking -------------------------------------------------------------------------------------------


def top(user):
    return points(user.mesh)[:, 2] == 4


def test_picking_a_side_of_a_box_and_one_of_its_edges(user, hand, box):
    user.drop(box)
    user.do("region_patch")
    hand.click(hand.place(int(np.flatnonzero((points(user.mesh) == [2, 2, 4]).all(axis=1))[0])))
    assert np.array_equal(fixed(user), top(user))
    user.do("region_line")
    edge = top(user) & (points(user.mesh)[:, 1] == 0)
    on_edge = int(np.flatnonzero((points(user.mesh) == [2, 0, 4]).all(axis=1))[0])
    hand.click(hand.place(on_edge), hand.ctrl)
    assert np.array_equal(fixed(user), top(user) & ~edge)
    assert user.window.view._marks["features"].data.GetNumberOfLines() == 12
    hand.drag(hand.middle(), hand.middle() * 1.2)  # a drag turns the view and picks nothing
    assert np.array_equal(fixed(user), top(user) & ~edge)


def test_picking_a_component_and_nothing(user, hand, tmp_path):
    from PySide6.QtCore import QPointF

    (pv.Sphere() + pv.Sphere(center=(2, 0, 0))).save(tmp_path / "two.vtp")
    user.drop(tmp_path / "two.vtp")
    user.do("region_component")
    labels = components(user.document.active.state.surface.mesh)
    seen = user.application.regions._looked().seen
    chosen = int(np.flatnonzero(seen & (labels == labels[-1]))[50])
    hand.click(hand.place(chosen))
    assert np.array_equal(fixed(user), labels == labels[-1])
    hand.click(QPointF(5, 5))
    assert "no face" in user.said


# -- feature lines -------------------------------------------------------------------------------------


def test_lines_are_drawn_removed_and_used(user, hand, sphere, tmp_path):
    user.drop(sphere)
    user.do("region_edges")
    look = user.application.regions._looked()
    mesh = user.document.active.state.surface.mesh
    ratio = user.window.view.devicePixelRatioF()
    centre = np.array([hand.canvas.width() / 2, hand.canvas.height() / 2]) * ratio
    near = np.flatnonzero(look.seen)[np.argsort(np.abs(look.places[look.seen][:, :2] - centre).sum(axis=1))]
    a, b, c = (int(v) for v in near[[0, 60, 200]])
    for v in (a, b, c):
        hand.click(hand.place(v))
    rings = rings_of(mesh)
    chains = [shortest_path(mesh.points, rings, *ends).tolist() for ends in ((a, b), (b, c))]
    pairs = {tuple(sorted(pair)) for chain in chains for pair in itertools.pairwise(chain)}
    assert edges(user, "Added") == pairs
    assert user.window.view._marks["drawn"].data.GetNumberOfLines() == len(pairs)
    assert user.window.view._marks["drawn"].data.GetNumberOfVerts() == 1
    hand.click(hand.place(c))  # ends the line
    assert user.window.view._marks["drawn"].data.GetNumberOfVerts() == 0
    assert len(user.document.history.steps) == 3
    # They are features for the overlay and for filters, in a script as here.
    classes = FeatureDetection()(user.mesh)[0].GetPointData().GetArray("FeatureClass")
    user.do("overlay_feature_class")
    assert np.array_equal(user.display.fields[0].values, vtk_to_numpy(classes))
    assert (vtk_to_numpy(classes)[[v for chain in chains for v in chain]] > 0).all()
    held = sorted({v for chain in chains for v in chain})
    original = points(user.mesh)[held].copy()
    user.apply(LaplacianSmoothing, iterations=3, features="hold")
    assert np.array_equal(points(user.mesh)[held], original)
    assert np.array_equal(points(logged(user, tmp_path)), points(user.mesh))
    # With Ctrl a click on a line takes all of it.
    user.do("undo")
    hand.click(hand.place(chains[0][len(chains[0]) // 2]), hand.ctrl)
    assert len(edges(user, "Added")) < len(pairs)
    assert edges(user, "Added").isdisjoint(edges(user, "Removed"))
    user.do("region_clear_lines")
    assert edges(user, "Added") == edges(user, "Removed") == set()


def test_a_detected_edge_is_removed_and_then_moves(user, hand, box):
    user.drop(box)
    user.do("region_edges")
    on_edge = int(np.flatnonzero((points(user.mesh) == [2, 0, 4]).all(axis=1))[0])
    hand.click(hand.place(on_edge), hand.ctrl)
    assert len(edges(user, "Removed")) == 4
    assert user.window.view._marks["features"].data.GetNumberOfLines() == 11
    before = points(user.mesh).copy()
    user.apply(LaplacianSmoothing, iterations=1, features="hold")
    assert (points(user.mesh)[on_edge] != before[on_edge]).any()


def test_esc_ends_a_line_and_then_the_tool(user, hand, sphere):
    from PySide6.QtCore import Qt

    user.drop(sphere)
    user.do("region_edges")
    hand.click(hand.middle())
    regions = user.application.regions
    assert regions._anchor is not None
    user.press(Qt.Key.Key_Escape)
    assert regions._anchor is None
    assert regions.tool == "edges"
    user.press(Qt.Key.Key_Escape)
    assert regions.tool == "camera"


# -- what does not go together -------------------------------------------------------------------------


def test_nothing_is_marked_while_a_filter_runs(user, hand, big):
    user.drop(big)
    user.do("region_brush")
    user.choose(LaplacianSmoothing, iterations=100_000)
    user.window.action("apply").trigger()
    user.qtbot.waitUntil(lambda: user.window.filters.progress.value() > 0, timeout=200_000)
    hand.drag(hand.middle(), hand.middle() * 1.05, wait=False)
    assert "A filter is running" in user.said
    user.do("cancel")
    assert not fixed(user).any()
    hand.click(hand.middle())
    assert fixed(user).any()


def test_in_split_view_only_the_result_is_painted(user, hand, sphere):
    user.drop(sphere)
    user.apply(LaplacianSmoothing, iterations=2)
    user.do("split")
    user.do("region_brush")
    width, height = hand.canvas.width(), hand.canvas.height()
    from PySide6.QtCore import QPointF

    hand.click(QPointF(0.25 * width, 0.5 * height))
    assert not fixed(user).any()
    hand.click(QPointF(0.75 * width, 0.5 * height))
    assert fixed(user).any()
    steps = len(user.document.history.steps)
    user.do("split")
    user.do("toggle_before")
    hand.click(hand.middle())
    assert len(user.document.history.steps) == steps


def test_a_tool_for_regions_and_one_that_measures_take_turns(user, ant):
    user.drop(ant)
    user.do("measure_distance")
    user.do("region_component")
    assert not user.window.action("measure_distance").isChecked()
    assert user.application.measuring.kind is None
    user.do("measure_angle")
    assert user.application.regions.tool == "camera"
    assert not user.application.regions.pen.isVisible()


def test_without_a_mesh_the_tools_rest(user, ant):
    assert not user.window.action("region_brush").isEnabled()
    user.drop(ant)
    assert user.window.action("region_brush").isEnabled()
    user.do("region_brush")
    user.do("close_layer")
    assert user.application.regions.tool == "camera"
    assert not user.window.action("region_brush").isEnabled()
