"""The application in a real window, used as a user does; results compared with scripts, bit for bit."""

import os
import threading

import numpy as np
import pytest
import pyvista as pv
from vtkmodules.util.numpy_support import vtk_to_numpy

from vtksmooth.files import read_surface
from vtksmooth.filters import (
    FILTERS,
    FeatureDetection,
    LaplacianSmoothing,
    SurfaceComparison,
    SurfaceQuality,
    TrapeziumDrawing,
    ValenceTriangulation,
)


def points(mesh):
    return vtk_to_numpy(mesh.GetPoints().GetData())


def same_points(a, b):
    return points(a).dtype == points(b).dtype and np.array_equal(points(a), points(b))


# -- opening and saving --------------------------------------------------------------------------------


def test_a_mesh_is_opened_by_dropping_it(user, ant):
    assert user.window.hint.isVisible()
    user.drop(ant)
    assert [layer.name for layer in user.document.layers] == ["ant"]
    assert same_points(user.mesh, read_surface(ant)[0])
    assert not user.window.hint.isVisible()
    assert "486 points" in user.window.figures.text()
    assert user.window.windowTitle() == "ant - vtksmooth"
    assert "ant" in user.application.settings.recent[0]


def test_a_wrong_file_gives_one_notification_and_loses_nothing(user, ant, tmp_path):
    user.drop(ant)
    before = user.mesh
    wrong = tmp_path / "wrong.ply"
    wrong.write_text("this is no mesh")
    user.drop(wrong, tmp_path / "missing.stl")
    assert "wrong.ply" in user.said
    assert "missing.stl" in user.said
    assert user.window.notification.level == "error"
    assert user.mesh is before
    assert len(user.document.layers) == 1


def test_what_is_saved_is_what_a_script_makes(user, ant, tmp_path):
    user.drop(ant)
    user.apply(TrapeziumDrawing, iterations=3)
    assert user.document.active.unsaved
    assert user.window.windowTitle().startswith("ant *")
    path = tmp_path / "better.vtp"
    user.application.files.write(user.document.active, path)
    user.wait()
    assert same_points(read_surface(path)[0], TrapeziumDrawing(iterations=3)(read_surface(ant)[0]))
    assert not user.document.active.unsaved
    assert user.window.windowTitle() == "ant - vtksmooth"


def test_a_save_that_fails_says_so_and_leaves_the_layer_unsaved(user, ant, tmp_path):
    user.drop(ant)
    user.apply(TrapeziumDrawing, iterations=1)
    user.application.files.write(user.document.active, tmp_path / "nowhere" / "better.ply")
    user.wait()
    assert user.window.notification.level == "error"
    assert user.document.active.unsaved


def test_unsaved_changes_are_asked_about(user, ant):
    user.drop(ant)
    user.apply(TrapeziumDrawing, iterations=1)
    asked = []
    user.application.sessions.ask_unsaved = lambda names, save: asked.append(names)
    user.window.close()
    assert asked == [["ant"]]
    assert user.window.isVisible()


# -- filters -------------------------------------------------------------------------------------------


def test_a_slider_and_apply_give_what_a_script_gives(user, ant):
    user.drop(ant)
    user.window.filters.choose(TrapeziumDrawing)
    row = user.window.filters.rows["iterations"]
    row.slider.setValue(7)
    assert row.value == 7
    user.do("apply")
    filter = TrapeziumDrawing(iterations=7)
    assert same_points(user.mesh, filter(read_surface(ant)[0]))
    assert "iterations 7" in user.document.history.steps[-1].title
    assert str(filter.report).split(" s;")[1] in user.said


@pytest.mark.parametrize("cls", [cls for cls in FILTERS if len(cls.inputs) == 1], ids=lambda cls: cls.command)
def test_every_filter_has_a_form_and_runs_as_in_a_script(user, ant, cls):
    user.drop(ant)
    user.choose(cls)
    assert set(user.window.filters.rows) == set(cls.parameters())
    user.do("apply")
    filter = cls()
    filter(read_surface(ant)[0])
    assert same_points(user.mesh, filter.GetOutput(0))
    assert len(user.document.layers) == len(cls.outputs)


def test_a_filter_with_two_inputs_takes_the_second_from_a_layer(user, ant, tmp_path):
    user.drop(ant)
    user.apply(TrapeziumDrawing, iterations=2)
    user.apply(SurfaceComparison)
    assert "ant as opened" in user.window.filters.inputs["original"].currentText()
    original = read_surface(ant)[0]
    expected = SurfaceComparison()(TrapeziumDrawing(iterations=2)(original), original)
    for name in ("NormalDeviation", "Deviation"):
        assert np.array_equal(
            vtk_to_numpy(user.mesh.GetPointData().GetArray(name)),
            vtk_to_numpy(expected.GetPointData().GetArray(name)),
        )


def test_cancel_stops_a_run_and_leaves_the_mesh(user, big):
    user.drop(big)
    before, state = points(user.mesh).copy(), user.document.active.state
    user.choose(LaplacianSmoothing, iterations=100_000)
    user.window.action("apply").trigger()
    user.qtbot.waitUntil(lambda: user.window.filters.progress.value() > 0, timeout=200_000)
    user.window.action("cancel").trigger()
    assert not user.jobs.busy("apply")
    user.wait()
    assert user.document.active.state is state
    assert np.array_equal(points(user.mesh), before)
    assert "Cancelled" in user.said
    user.do("undo")
    assert user.document.layers == []


def test_the_window_answers_while_a_filter_runs(user, big):
    user.drop(big)
    user.choose(LaplacianSmoothing, iterations=100_000)
    user.window.action("apply").trigger()
    user.qtbot.waitUntil(lambda: user.window.filters.progress.value() > 0, timeout=200_000)
    assert "iteration" in user.window.filters.doing.text()
    assert "k mean" in user.window.filters.doing.text()
    frames = user.window.view.frames
    user.window.action("view_pz").trigger()
    user.qtbot.waitUntil(lambda: user.window.view.frames > frames)
    assert user.jobs.busy("apply")
    assert not user.window.action("apply").isEnabled()
    user.do("cancel")


def test_an_error_of_a_filter_is_one_notification(user, ant):
    user.drop(ant)
    user.apply(TrapeziumDrawing, fixed="missing")
    assert "missing" in user.said
    assert user.window.notification.level == "error"
    assert len(user.document.history.steps) == 1


def test_without_a_mesh_nothing_can_be_applied(user):
    assert not user.window.action("apply").isEnabled()
    assert not user.window.action("save").isEnabled()
    user.application.filtering.apply()
    assert "Open a mesh" in user.said


def test_a_preview_shows_and_never_applies(user, ant):
    user.drop(ant)
    state = user.document.active.state
    user.choose(TrapeziumDrawing, iterations=2)
    user.do("preview")
    expected = TrapeziumDrawing(iterations=2)(read_surface(ant)[0])
    assert same_points(user.display.subject.state.mesh, expected)
    assert "PREVIEW" in user.window.figures.text()
    # The last of many requests wins.
    for iterations in (3, 4, 5, 6):
        user.window.filters.rows["iterations"].editor.setValue(iterations)
    user.wait(lambda: not user.application.filtering._timer.isActive())
    expected = TrapeziumDrawing(iterations=6)(read_surface(ant)[0])
    assert same_points(user.display.subject.state.mesh, expected)
    assert user.document.active.state is state
    assert len(user.document.history.steps) == 1
    user.do("cancel")
    assert user.display.subject.state is state
    assert not user.window.action("preview").isChecked()
    assert "PREVIEW" not in user.window.figures.text()


def test_apply_takes_what_the_preview_has_found(user, ant):
    user.drop(ant)
    user.choose(TrapeziumDrawing, iterations=2)
    user.do("preview")
    previewed = user.display.subject.state
    user.window.action("apply").trigger()
    assert user.document.active.state is previewed
    assert same_points(user.mesh, TrapeziumDrawing(iterations=2)(read_surface(ant)[0]))
    assert not user.window.action("preview").isChecked()
    user.wait()
    assert "PREVIEW" not in user.window.figures.text()
    assert len(user.document.history.steps) == 2
    # Of other parameters, or another mesh, it is not the result.
    user.do("preview")
    user.choose(TrapeziumDrawing, iterations=3)
    user.do("apply")
    assert user.document.active.state is not previewed
    expected = TrapeziumDrawing(iterations=3)(TrapeziumDrawing(iterations=2)(read_surface(ant)[0]))
    assert same_points(user.mesh, expected)


def test_apply_goes_on_with_a_preview_that_runs(user, ant, monkeypatch):
    user.drop(ant)
    user.choose(TrapeziumDrawing, iterations=4)
    ran, may_go_on = [], threading.Event()
    execute = TrapeziumDrawing.execute

    def wait_and_execute(*given):
        ran.append(given)
        assert may_go_on.wait(60)
        return execute(*given)

    monkeypatch.setattr(TrapeziumDrawing, "execute", wait_and_execute)
    user.window.action("preview").trigger()
    user.qtbot.waitUntil(lambda: len(ran) == 1)
    user.window.action("apply").trigger()
    assert user.jobs.busy("apply")
    may_go_on.set()
    user.wait()
    assert len(ran) == 1
    assert len(user.document.history.steps) == 2
    assert same_points(user.mesh, TrapeziumDrawing(iterations=4)(read_surface(ant)[0]))


def test_constraints_and_stop_rules_are_folded_and_say_what_is_changed(user):
    panel = user.window.filters
    user.choose(LaplacianSmoothing)
    assert list(panel.form.sections) == ["constraints", "stop rules", "output"]
    assert panel.rows["scheme"].isVisible()
    assert not panel.rows["corrections"].isVisible()
    panel.form.sections["constraints"].click()
    assert panel.rows["corrections"].isVisible()
    assert not panel.rows["stop_gain"].isVisible()
    panel.set_values({"corrections": 2, "boundary": "sliding"})
    assert panel.form.sections["constraints"].text() == "Constraints (2 changed)"
    user.choose(TrapeziumDrawing)
    assert panel.rows["corrections"].isVisible()
    assert panel.form.sections["constraints"].text() == "Constraints"


@pytest.mark.parametrize("width", [700, 1600])
def test_rows_of_forms_are_never_cut(user, width):
    user.window.resize(width, 700)
    form = user.window.filters.form
    for cls in FILTERS:
        user.choose(cls)
        for section in form.sections.values():
            section.setChecked(True)
        user.wait()
        assert form.widget().minimumSizeHint().width() <= form.viewport().width(), cls.__name__


def test_reset_goes_back_to_the_default(user):
    user.choose(LaplacianSmoothing, iterations=33, scheme="taubin", max_deviation_fraction=0.01)
    panel = user.window.filters
    assert panel.values() == {"iterations": 33, "scheme": "taubin", "max_deviation_fraction": 0.01}
    for row in panel.rows.values():
        if row.reset.isEnabled():
            row.reset.click()
    assert panel.values() == {}
    assert "Which weights" in panel.rows["scheme"].toolTip()


# -- history -------------------------------------------------------------------------------------------


def test_undo_and_redo_go_through_all_states(user, ant):
    user.drop(ant)
    states = [user.document.active.state]
    for iterations in (1, 2):
        user.apply(TrapeziumDrawing, iterations=iterations)
        states.append(user.document.active.state)
    user.do("undo")
    assert user.document.active.state is states[1]
    user.do("undo")
    assert user.document.active.state is states[0]
    assert not user.document.active.unsaved
    user.do("redo")
    user.do("redo")
    assert user.document.active.state is states[2]
    rows = user.window.history.list
    user.qtbot.mouseClick(
        rows.viewport(), __import__("PySide6.QtCore").QtCore.Qt.MouseButton.LeftButton,
        pos=rows.visualItemRect(rows.item(2)).center(),
    )  # fmt: skip
    user.wait()
    assert user.document.active.state is states[1]
    user.apply(TrapeziumDrawing, iterations=4)
    assert not user.window.action("redo").isEnabled()


def test_closing_a_layer_can_be_undone(user, ant):
    user.drop(ant)
    user.do("close_layer")
    assert user.document.layers == []
    assert user.window.hint.isVisible()
    user.do("undo")
    assert [layer.name for layer in user.document.layers] == ["ant"]


# -- overlays ------------------------------------------------------------------------------------------


def test_overlays_show_the_arrays_of_the_filters(user, ant):
    user.drop(ant)
    user.apply(TrapeziumDrawing, iterations=3)
    original = read_surface(ant)[0]
    result = TrapeziumDrawing(iterations=3)(original)
    comparison = SurfaceComparison()(result, original)
    assert np.array_equal(
        user.display.fields[0].values, vtk_to_numpy(comparison.GetCellData().GetArray("AspectRatio"))
    )
    assert np.array_equal(
        user.display.fields[1].values,
        vtk_to_numpy(SurfaceQuality()(original).GetCellData().GetArray("AspectRatio")),
    )
    for command, name in (
        ("normal_deviation", "NormalDeviation"),
        ("dihedral_change", "DihedralChange"),
        ("deviation", "Deviation"),
    ):
        user.do(f"overlay_{command}")
        expected = vtk_to_numpy(comparison.GetPointData().GetArray(name))
        assert np.array_equal(user.display.fields[0].values, expected)
        shown = user.window.view._surfaces["after"].data.GetPointData().GetScalars()
        assert np.array_equal(vtk_to_numpy(shown), expected)
    user.do("overlay_displacement")
    moved = np.linalg.norm(points(result).astype(float) - points(original).astype(float), axis=1)
    assert np.allclose(user.display.fields[0].values, moved)
    user.do("overlay_none")
    assert user.window.view._surfaces["after"].mapper.GetScalarVisibility() == 0
    assert not user.window.colour_bar.isVisible()


def test_feature_classes_come_with_their_lines(user, tmp_path):
    from vtksmooth_gui.views.scale import CLASSES

    pv.Cube().triangulate().subdivide(3).clean().save(tmp_path / "cube.ply")
    user.drop(tmp_path / "cube.ply")
    user.do("overlay_feature_class")
    surface = user.window.view._surfaces["after"]
    values, mapper = surface.data.GetPointData().GetScalars(), surface.mapper
    colours = vtk_to_numpy(mapper.GetLookupTable().MapScalars(values, mapper.GetColorMode(), -1))
    assert {tuple(colour) for colour in colours[:, :3].tolist()} == {CLASSES[0], CLASSES[1], CLASSES[2]}
    assert user.display.fields[0].of_faces[user.display.fields[0].worst[0]] == 2
    assert user.window.worst.item(0, 1).text() == "corner"
    assert len(user.window.histogram.edges()) == 5
    mesh, lines = FeatureDetection()(read_surface(tmp_path / "cube.ply")[0])
    expected = vtk_to_numpy(mesh.GetPointData().GetArray("FeatureClass"))
    assert np.array_equal(user.display.fields[0].values, expected)
    assert (np.bincount(expected)[2], lines.GetNumberOfLines()) == (8, 12)
    mark = user.window.view._marks["lines"]
    assert mark.actor.GetVisibility()
    assert mark.data.GetNumberOfLines() == 12
    user.do("overlay_aspect_ratio")
    assert not mark.actor.GetVisibility()


def test_an_overlay_is_chosen_by_its_key_and_by_the_list(user, ant):
    from PySide6.QtCore import Qt

    user.drop(ant)
    user.press(Qt.Key.Key_2)
    user.wait()
    assert user.display.overlay.id == "normal-deviation"
    assert user.window.overlays.currentText() == "Normal deviation"
    user.window.overlays.setCurrentIndex(1)
    user.window.overlays.activated.emit(1)
    user.wait()
    assert user.display.overlay.id == "aspect-ratio"
    assert user.window.action("overlay_aspect_ratio").isChecked()


def test_an_overlay_that_cannot_be_shown_says_what_to_do(user, ant):
    user.drop(ant)
    user.do("overlay_signed_distance")
    assert "installation space" in user.said
    assert user.display.fields == (None, None)


def test_thresholds_are_dragged_remembered_and_reset(user, ant, open_window):
    user.drop(ant)
    bar = user.window.colour_bar
    assert bar.thresholds == (0.6, 0.4, 0.2)
    place = lambda value: __import__("PySide6.QtCore").QtCore.QPoint(20, round(bar.place(value)))  # noqa: E731
    left = __import__("PySide6.QtCore").QtCore.Qt.MouseButton.LeftButton
    user.qtbot.mousePress(bar, left, pos=place(0.2))
    user.qtbot.mouseMove(bar, place(0.3))
    user.qtbot.mouseRelease(bar, left, pos=place(0.3))
    assert bar.thresholds[:2] == (0.6, 0.4)
    assert abs(bar.thresholds[2] - 0.3) < 0.01
    user.do("bad_faces")
    drawn = user.window.view._marks["bad"].data.GetNumberOfPolys()
    assert drawn == (user.display.fields[0].values < bar.thresholds[2]).sum()
    # No threshold passes its neighbour.
    bar.set_threshold(2, 0.9)
    assert bar.thresholds[0] >= bar.thresholds[1] >= bar.thresholds[2]
    bar.set_threshold(2, 0.1)
    again = open_window(ant)
    assert again.window.colour_bar.thresholds == (0.6, 0.4, 0.1)
    again.do("reset_thresholds")
    assert again.window.colour_bar.thresholds == (0.6, 0.4, 0.2)


def test_brushing_the_histogram_selects_faces(user, ant):
    user.drop(ant)
    k = user.display.fields[0].values
    user.window.histogram.set_brush((0.2, 0.4))
    user.wait(lambda: user.display.selected is not None)
    assert np.array_equal(user.display.selected, np.flatnonzero((k >= 0.2) & (k <= 0.4)))
    assert user.window.view._marks["brush"].data.GetNumberOfPolys() == len(user.display.selected)
    user.do("lock_brush")
    selected = user.display.selected
    user.do("overlay_mean_curvature")
    assert np.array_equal(user.display.selected, selected)
    assert not user.window.histogram.brush.isVisible()  # these are other values
    user.do("overlay_aspect_ratio")
    assert user.window.histogram.brush.isVisible()
    assert np.array_equal(user.display.selected, selected)
    user.do("overlay_mean_curvature")
    user.do("lock_brush")
    assert user.display.selected is None
    user.window.histogram.set_brush((0.0, 1.0))
    user.wait(lambda: user.display.selected is not None)
    assert user.window.histogram.brush.isVisible()
    user.do("overlay_aspect_ratio")
    assert user.display.selected is None
    assert not user.window.view._marks["brush"].actor.GetVisibility()


def test_dragging_in_the_plot_spans_the_brush(user, ant):
    from PySide6.QtCore import QPointF, Qt

    user.drop(ant)
    plot = user.window.histogram.plot
    place = lambda x: plot.mapFromScene(plot.getViewBox().mapViewToScene(QPointF(x, 1.0)))  # noqa: E731
    viewport = plot.viewport()
    user.qtbot.mousePress(viewport, Qt.MouseButton.LeftButton, pos=place(0.5))
    for x in (0.55, 0.65, 0.8):
        user.qtbot.mouseMove(viewport, place(x))
        user.qtbot.wait(10)
    user.qtbot.mouseRelease(viewport, Qt.MouseButton.LeftButton, pos=place(0.8))
    user.wait(lambda: user.display.selected is not None)
    low, high = user.display._brush
    assert abs(low - 0.5) < 0.02
    assert abs(high - 0.8) < 0.02


def test_the_bins_of_the_papers(user, ant):
    user.drop(ant)
    user.do("papers_bins")
    histogram = user.window.histogram
    shares = histogram.plot.listDataItems()[0].getData()[1]
    filter = SurfaceQuality()
    filter(read_surface(ant)[0])
    assert np.allclose(shares, filter.summary["aspect_ratio"]["histogram"])
    histogram.set_brush((1.0, 2.0))  # the second bin: k from 0 to 0.2
    user.wait(lambda: user.display.selected is not None)
    k = user.display.fields[0].values
    assert len(user.display.selected) == ((k >= 0) & (k <= 0.2)).sum()


def test_w_goes_to_the_next_worst_face_and_frames_it(user, ant):
    from PySide6.QtCore import Qt

    user.drop(ant)
    k = user.display.fields[0].values
    order = np.argsort(k, kind="stable")
    mesh = pv.wrap(user.mesh)
    for face in order[:2]:
        user.press(Qt.Key.Key_W)
        assert int(user.window.worst.item(user.window.worst.currentRow(), 0).text()) == face
        focus = np.array(user.window.view.camera.GetFocalPoint())
        assert np.allclose(focus, mesh.get_cell(face).points.mean(axis=0), atol=1e-4 * mesh.length)
        assert user.window.view._marks["worst"].data.GetNumberOfPolys() == 1


def test_nobody_goes_by_the_values_of_another_mesh(user, ant, tmp_path):
    from vtksmooth_gui.model.overlays import OVERLAYS

    pv.Plane(i_resolution=3, j_resolution=3).triangulate().save(tmp_path / "plane.vtp")
    user.drop(tmp_path / "plane.vtp")
    small = user.document.active
    user.drop(ant)
    user.display.show_overlay(next(one for one in OVERLAYS if one.id == "mean-curvature"))
    user.wait()
    assert user.window.worst.rowCount() > small.state.n_faces
    user.document.activate(small)
    assert user.jobs.busy("overlay")
    for _ in range(2):
        user.window.action("previous_worst").trigger()  # the last in the list of the other mesh
    for command in ("bad_faces", "bands", "bad_faces"):
        user.window.action(command).trigger()
    assert not user.window.view._marks["worst"].actor.GetVisibility()
    user.window.histogram.set_brush((-1e9, 1e9))
    user.wait()
    assert user.window.worst.rowCount() == small.state.n_faces
    assert len(user.display.selected) == small.state.n_faces
    user.do("next_worst")
    assert user.window.view._marks["worst"].data.GetNumberOfPolys() == 1


def test_the_numbers_are_those_of_the_filters(user, ant):
    from PySide6.QtGui import QGuiApplication

    user.drop(ant)
    user.apply(TrapeziumDrawing, iterations=3)
    user.do("copy_numbers")
    text = QGuiApplication.clipboard().text()
    original = read_surface(ant)[0]
    comparison = SurfaceComparison()
    comparison(TrapeziumDrawing(iterations=3)(original), original)
    summary = comparison.summary
    assert f"| mean k | 0.4793 | {summary['aspect_ratio']['mean']:.4g} |" in text
    assert f"| volume change |  | {summary['volume_change_percent']:+.4g} % |" in text
    assert f"| normals, max |  | {summary['normal_deviation']['max']:.4g}° |" in text
    assert "| inverted | 0 | 0 |" in text
    assert user.window.numbers.table.rowCount() == text.count("\n") - 2
    assert f"worst k {summary['aspect_ratio']['min']:.3f}" in user.window.figures.text()


def test_polygons_are_compared_with_their_triangles(user, tmp_path):
    plane = pv.Plane(i_resolution=6, j_resolution=6)
    plane.points[:, 2] = 0.1 * np.sin(9 * plane.points[:, 0])
    plane.save(tmp_path / "quads.vtp")
    user.drop(tmp_path / "quads.vtp")
    user.apply(ValenceTriangulation)
    user.apply(TrapeziumDrawing, iterations=2)
    user.do("overlay_deviation")
    assert user.display.fields[0] is not None
    assert len(user.display.fields[0].values) == user.mesh.GetNumberOfPoints()


# -- before and after ----------------------------------------------------------------------------------


def grabbed(user):
    user.window.view.render_now()
    image = user.window.view.picture(300, 200, False)
    return np.frombuffer(image.constBits(), np.uint8).reshape(200, -1, 4)[:, :300].copy()


def test_before_after_split_and_swipe(user, ant):
    from PySide6.QtCore import Qt

    user.drop(ant)
    user.apply(LaplacianSmoothing, iterations=15)
    view = user.window.view
    after = grabbed(user)
    user.press(Qt.Key.Key_Space)
    before = grabbed(user)
    assert (before != after).any()
    user.press(Qt.Key.Key_Space)
    assert np.array_equal(grabbed(user), after)
    user.press(Qt.Key.Key_X)
    assert view.mode == "swipe"
    view.set_swipe(0.0)
    assert np.abs(grabbed(user)[:140, 4:].astype(int) - after[:140, 4:]).max() <= 8
    view.set_swipe(1.0)
    left = np.abs(grabbed(user)[:140, :-4].astype(int) - before[:140, :-4]).max(axis=2)
    assert (left > 8).mean() < 0.002
    user.press(Qt.Key.Key_S)
    assert view.mode == "split"
    assert not user.window.action("swipe").isChecked()
    first, second = view._renderers
    assert first.GetActiveCamera() is second.GetActiveCamera()
    split = grabbed(user)
    assert (split[:140, :150] != split[:140, 150:]).any()
    user.press(Qt.Key.Key_S)
    assert np.abs(grabbed(user).astype(int) - after).max() <= 8


def test_a_change_is_drawn_once_and_what_is_said_not_at_all(user, ant):
    user.drop(ant)
    view = user.window.view
    user.qtbot.wait(100)
    frames, size = view.frames, view.plotter.interactor.size()
    user.do("edges")
    user.qtbot.wait(100)
    assert view.frames == frames + 1
    notification = user.window.notification
    notification.say("Something long to read. " * 40)
    user.qtbot.wait(100)
    folded = notification.height()
    assert notification.more.isVisible()
    notification.more.click()
    user.qtbot.wait(100)
    assert notification.height() > 2 * folded
    notification.say("Something short.")
    assert notification.height() <= folded
    assert not notification.more.isVisible()
    notification.hide()
    user.qtbot.wait(100)
    assert view.frames == frames + 1
    user.do("overlay_none")
    user.qtbot.wait(100)
    assert view.frames == frames + 2
    assert view.plotter.interactor.size() == size


def test_the_swipe_line_is_dragged(user, ant):
    from PySide6.QtCore import QPoint, Qt

    user.drop(ant)
    user.do("swipe")
    view = user.window.view
    widget = view.plotter.interactor
    place = lambda x: QPoint(round(x * widget.width()), widget.height() // 2)  # noqa: E731
    camera = view.camera.GetPosition()
    user.qtbot.mousePress(widget, Qt.MouseButton.LeftButton, pos=place(0.5))
    user.qtbot.mouseMove(widget, place(0.7))
    user.qtbot.mouseRelease(widget, Qt.MouseButton.LeftButton, pos=place(0.7))
    assert abs(view.swipe_at - 0.7) < 0.01
    assert view.camera.GetPosition() == camera


def test_the_probe_names_what_is_under_the_pointer(user, tmp_path):
    from PySide6.QtCore import QPoint

    plane = pv.Plane(i_resolution=4, j_resolution=4)
    plane.save(tmp_path / "plane.vtp")
    user.drop(tmp_path / "plane.vtp")
    user.do("view_pz")
    user.window.view.render_now()
    mesh = pv.wrap(user.mesh)
    renderer = user.window.view._renderers[0]
    ratio = user.window.view.devicePixelRatioF()
    widget = user.window.view.plotter.interactor
    for face in (0, 5, 15):
        centre = mesh.get_cell(face).center
        renderer.SetWorldPoint(*centre, 1.0)
        renderer.WorldToDisplay()
        x, y, _ = renderer.GetDisplayPoint()
        place = QPoint(round(x / ratio), round(widget.height() - 1 - y / ratio))
        user.window.probe.setText(" ")
        for attempt in range(20):  # a move to where the pointer is already is none
            user.qtbot.mouseMove(widget, place + QPoint(attempt % 2, 0))
            user.qtbot.wait(300)
            if user.window.probe.text() != " ":
                break
        assert f"face {face}," in user.window.probe.text()
        assert "Aspect ratio k 1 " in user.window.probe.text()


def test_keys_do_what_the_table_says_and_vtk_gets_none(user, ant):
    from PySide6.QtCore import Qt
    from PySide6.QtGui import QKeySequence

    from vtksmooth_gui.commands import COMMANDS

    user.drop(ant)
    edges = user.window.view._surfaces["after"].actor.GetProperty()
    assert edges.GetEdgeVisibility()
    user.press(Qt.Key.Key_E)
    assert not edges.GetEdgeVisibility()
    user.press(Qt.Key.Key_H)
    sheet = user.application._dialogs["cheat_sheet"]
    assert sheet.isVisible()
    user.qtbot.keyClick(sheet, Qt.Key.Key_H)
    assert not sheet.isVisible()
    asked = []
    for command in (command for command in COMMANDS if command.key):
        action = user.window.action(command.id)
        action.triggered.disconnect()
        action.triggered.connect(lambda *_, id=command.id: asked.append(id))
        action.setEnabled(True)
        user.qtbot.keySequence(user.window, QKeySequence(command.key))
        assert asked.pop() == command.id, command.key
    # In VTK's own style 'w' is wireframe and 'q' ends the window.
    for key in (Qt.Key.Key_Q, Qt.Key.Key_R, Qt.Key.Key_3):
        user.qtbot.keyClick(user.window.view.plotter.interactor, key)
    assert user.window.isVisible()
    assert edges.GetRepresentation() == 2


# -- the rest ------------------------------------------------------------------------------------------


def test_what_is_opened_is_worked_on(user, ant, big):
    user.drop(ant)
    user.drop(big)
    assert user.document.active.name == "big"
    assert user.display.subject.state is user.document.layers[1].state
    user.drop(ant, big)
    assert user.document.active is user.document.layers[2]


def test_what_is_opened_is_brought_into_view(user, ant, tmp_path):
    mesh = pv.read(ant)
    for name, scale, shift in (
        ("small", 1e-3, 0.0),
        ("large", 1e3, 0.0),
        ("far", 1.0, 1e3),
        ("near", 1.1, 0.5),
    ):
        moved = mesh.copy()
        moved.points = scale * moved.points + shift
        moved.save(tmp_path / f"{name}.ply")
    view = user.window.view
    for name in ("small", "large", "far"):
        user.drop(ant)
        user.do("frame")
        user.drop(tmp_path / f"{name}.ply")
        assert view.sees(user.display.subject.state.bounds), name
        framed = view.camera.GetPosition()
        user.do("frame")
        assert np.allclose(view.camera.GetPosition(), framed), name
    user.drop(ant)
    user.do("frame")
    place = view.camera.GetPosition()
    user.drop(tmp_path / "near.ply")
    assert view.camera.GetPosition() == place
    user.window.view.camera.Zoom(50.0)
    user.drop(tmp_path / "missing.ply")
    assert view.camera.GetPosition() == place


def test_other_layers_do_not_hide_the_one_that_is_worked_on(user, ant, big):
    user.drop(ant, big)
    ant, big = user.document.layers
    assert user.window.view._context[big].actor.GetProperty().GetOpacity() < 1
    user.document.activate(big)
    user.wait()
    assert user.window.view._context[ant].actor.GetProperty().GetOpacity() < 1
    assert big not in user.window.view._context


@pytest.mark.parametrize("mode", ["single", "split"])
def test_no_layer_is_cut_off_however_far_apart_they_are(user, ant, tmp_path, mode):
    far = pv.read(ant).scale(0.1)
    far.translate((0.0, 500.0, 0.0)).save(tmp_path / "far.vtp")
    user.drop(ant, tmp_path / "far.vtp")
    view = user.window.view
    view.set_mode(mode)
    for bounds in (None, user.document.layers[0].state.bounds):
        view.frame(bounds)
        frames = view.frames
        user.qtbot.waitUntil(lambda frames=frames: view.frames > frames)
        near, end = view.camera.GetClippingRange()
        ahead = np.array(view.camera.GetDirectionOfProjection())
        for layer in user.document.layers:
            depths = (points(layer.state.mesh) - view.camera.GetPosition()) @ ahead
            assert near < depths.min()
            assert depths.max() < end


def test_layers_have_roles_and_can_be_hidden(user, ant, tmp_path):
    box = pv.read(ant)
    box.points = box.points * 1.5
    box.save(tmp_path / "space.ply")
    user.drop(ant, tmp_path / "space.ply")
    assert user.document.active.name == "ant"
    space = user.document.layers[1]
    tree = user.window.layers
    combo = tree.itemWidget(tree.topLevelItem(1), 1)
    combo.setCurrentText("installation space")
    combo.activated.emit(combo.currentIndex())
    user.wait()
    assert user.document.space is space
    look = user.window.view._context[space].actor.GetProperty()
    assert 0 < look.GetOpacity() < 1
    from PySide6.QtCore import Qt

    tree.topLevelItem(1).setCheckState(0, Qt.CheckState.Unchecked)
    user.wait()
    assert not space.visible
    assert space not in user.window.view._context


def test_a_screenshot_of_any_size(user, ant, tmp_path):
    from PySide6.QtGui import QImage

    user.drop(ant)
    user.application.write_picture(tmp_path / "a.png", 1500, 700, True, False)
    image = QImage(str(tmp_path / "a.png"))
    assert (image.width(), image.height()) == (1500, 700)
    image = image.convertToFormat(QImage.Format.Format_RGBA8888)  # its pixels live as long as it does
    pixels = np.frombuffer(image.constBits(), np.uint8)
    alpha = pixels.reshape(700, 1500, 4)[..., 3]
    assert alpha[0, 0] == 0
    assert 0.003 < (alpha == 255).mean() < 0.9
    user.application.write_picture(tmp_path / "no" / "a.png", 100, 100, False, True)
    assert user.window.notification.level == "error"


def test_what_is_set_is_remembered(user, ant, open_window):
    user.drop(ant)
    user.choose(TrapeziumDrawing, iterations=8)
    user.do("dark")
    user.do("edges")
    user.window.docks["Log"].close()
    user.window.close()
    again = open_window()
    assert again.window.docks["Log"].isHidden()
    assert not again.window.docks["History"].isHidden()
    assert again.window.filters.filter is TrapeziumDrawing
    assert again.window.filters.values() == {"iterations": 8}
    assert again.window.action("dark").isChecked()
    assert not again.window.action("edges").isChecked()
    assert again.window.palette().window().color().lightness() < 100
    again.window.menus["File"].aboutToShow.emit()
    assert again.window.recent.actions()[0].text().endswith("ant.ply")


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_what_is_switched_on_is_seen(user, ant, theme):
    from PySide6.QtWidgets import QToolButton

    user.drop(ant)

    def shade(command):
        buttons = user.window.findChildren(QToolButton)
        button = next(one for one in buttons if one.defaultAction() is user.window.action(command))
        return button.palette().button().color().lightness()

    if theme == "dark":
        user.do("dark")
    off = shade("region_brush")
    user.do("region_brush")
    assert abs(shade("region_brush") - off) > 40
    user.do("region_camera")
    assert shade("region_brush") == off


def test_closing_while_a_filter_runs_is_safe(user, big):
    user.drop(big)
    user.choose(LaplacianSmoothing, iterations=100_000)
    user.window.action("apply").trigger()
    user.qtbot.waitUntil(lambda: user.window.filters.progress.value() > 0, timeout=200_000)
    user.window.close()
    assert not user.window.isVisible()
    assert user.jobs._pool.activeThreadCount() == 0


def test_about_names_versions(user):
    user.do("about")
    text = user.application._dialogs["about"].text
    for word in ("vtksmooth", "PySide6", "numba", "OpenGL", "Python"):
        assert word in text
    user.do("about")


@pytest.mark.skipif("VTKSMOOTH_DATA" not in os.environ, reason="VTKSMOOTH_DATA is not set")
def test_a_skin_in_its_installation_space(user):
    filters = {cls.__name__: cls for cls in FILTERS}
    if "InstallationSpaceSmoothing" not in filters:
        pytest.skip("there is no such filter yet")
    from pathlib import Path

    from vtksmooth_gui.model.layer import Role

    data = Path(os.environ["VTKSMOOTH_DATA"])
    skin, space = data / "channel_sim.vtp", data / "channel_inst.vtp"
    user.drop(skin, space)
    user.document.set_role(user.document.layers[1], Role.SPACE)
    user.wait()
    cls = filters["InstallationSpaceSmoothing"]
    user.apply(cls, iterations=3)
    assert len(user.document.history.steps) == 4, user.said
    expected = cls(iterations=3)(read_surface(skin)[0], read_surface(space)[0])
    assert same_points(user.mesh, expected)
    user.do("overlay_signed_distance")
    assert user.display.fields[0] is not None, user.said
    rows = {row.name: (row.before, row.after) for row in user.window.numbers.rows}
    assert rows["vertices outside the space"] == ("0", "0")
    assert rows["triangles crossing it"] == ("0", "0")


def test_jobs_let_go_of_what_they_worked_on(user, ant):
    """Otherwise every state would live as long as the window, whatever the history gives up."""
    import gc
    import weakref

    user.application.files.open_paths([ant])
    user.wait()
    user.apply(LaplacianSmoothing, iterations=1)
    gone = weakref.ref(user.document.active.state)
    user.do("undo")
    user.apply(LaplacianSmoothing, iterations=2)
    user.do("overlay_displacement")
    user.do("overlay_aspect_ratio")
    gc.collect()
    assert gone() is None


def test_using_the_window_leaves_nothing_behind(user, ant):
    """Otherwise memory would grow with every use, and the time that each change takes."""
    import gc

    from PySide6.QtCore import SIGNAL
    from PySide6.QtWidgets import QWidget

    window = user.window
    user.drop(ant)

    def use():
        for filter in (LaplacianSmoothing, TrapeziumDrawing):
            user.apply(filter, iterations=1)
        for command in ("undo", "redo", "undo", "undo", "preview", "preview", "next_worst"):
            user.do(command)
        for switch in ("split", "swipe", "edges", "bad_faces", "dark", "section"):
            user.do(switch)
            user.do(switch)
        for overlay in ("feature_class", "none", "aspect_ratio"):
            user.do(f"overlay_{overlay}")
        window.histogram.set_brush((0.0, 0.5))
        user.wait()
        window.histogram.set_brush(None)
        user.drop(ant)
        user.do("close_layer")
        user.document.restore([], None, [], 0)
        user.drop(ant)
        user.wait()
        gc.collect()

    def left():
        props = [
            one.GetViewProps().GetNumberOfItems() for one in window.view.plotter.render_window.GetRenderers()
        ]
        changed = {id: one.receivers(SIGNAL("changed()")) for id, one in window.actions_by_id.items()}
        return {
            "listeners to actions": changed,
            "widgets": len(window.findChildren(QWidget)),
            "actors": props,
            "items of plots": [len(one.plot.items()) for one in (window.histogram, window.section)],
            "jobs": len(user.jobs._kept) + len(user.jobs._lanes),
        }

    use()
    before = left()
    use()
    use()
    assert left() == before


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_the_widgets_of_all_forms_share_one_palette(user, theme):
    """Qt draws them anew for each palette and keeps the names: choosing filters would take memory."""
    from PySide6.QtWidgets import QCheckBox, QWidget

    if theme == "dark":
        user.do("dark")
    boxes = {box.palette().window().color().name() for box in user.window.filters.findChildren(QCheckBox)}
    palettes = set()
    for cls in (TrapeziumDrawing, LaplacianSmoothing):
        user.choose(cls)
        page = user.window.filters.form.widget()
        drawn = [one for one in page.findChildren(QWidget) if not isinstance(one, QCheckBox)]
        assert len(drawn) > 30
        palettes |= {one.palette().cacheKey() for one in drawn}
    assert len(palettes) == 1
    assert {box.palette().window().color().name() for box in page.findChildren(QCheckBox)} == boxes


def test_parameters_without_effect_are_grey_and_not_passed(user, ant):
    user.drop(ant)
    user.choose(LaplacianSmoothing, scheme="taubin", pass_band=0.05)
    filters = user.window.filters
    band, weights = filters.form.rows["pass_band"], filters.form.rows["weights"]
    assert band.isEnabled()
    assert weights.isEnabled()
    assert filters.form.values() == {"scheme": "taubin", "pass_band": 0.05}
    filters.form.rows["scheme"].set_value("umbrella")
    filters.form.rows["scheme"].changed.emit(False)
    assert not band.isEnabled()
    assert not weights.isEnabled()
    assert filters.form.values() == {}
    before = user.mesh
    user.do("apply")
    assert user.mesh is not before
