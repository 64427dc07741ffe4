"""Recipes in a real window: what was done is listed, edited, run again, kept, replayed, and reported."""

import subprocess
import sys

import numpy as np
import pytest
import pyvista as pv
from vtkmodules.util.numpy_support import vtk_to_numpy

from vtksmooth import Recipe, Step, samples
from vtksmooth.cli import main
from vtksmooth.files import read_surface, write_surface
from vtksmooth.filters import FILTERS, LaplacianSmoothing, SurfaceComparison, TrapeziumDrawing
from vtksmooth.pages import pictures

RECIPE = Recipe([Step("trapezium-drawing", {"iterations": 3}), Step("laplacian", {"iterations": 2})])


def points(mesh):
    return vtk_to_numpy(mesh.GetPoints().GetData())


def same_points(a, b):
    return points(a).dtype == points(b).dtype and np.array_equal(points(a), points(b))


def clipboard():
    from PySide6.QtGui import QGuiApplication

    return QGuiApplication.clipboard().text()


def undrawn(_):
    raise pictures.NoPicturesError("once is enough")


@pytest.fixture
def steps(user, ant):
    """A user who has applied two filters."""
    user.drop(ant)
    user.apply(TrapeziumDrawing, iterations=3)
    user.apply(LaplacianSmoothing, iterations=2)
    user.window.show_panel("Recipe")
    return user


def listed(user):
    rows = user.window.recipe.list
    return [rows.item(row).text().split("\n")[0] for row in range(rows.count())]


def select(user, row):
    from PySide6.QtCore import Qt

    rows = user.window.recipe.list
    user.qtbot.mouseClick(
        rows.viewport(), Qt.MouseButton.LeftButton, pos=rows.visualItemRect(rows.item(row)).center()
    )
    assert rows.currentRow() == row


def tick(user, row):
    from PySide6.QtCore import QPoint, Qt

    rows = user.window.recipe.list
    rect = rows.visualItemRect(rows.item(row))
    user.qtbot.mouseClick(
        rows.viewport(), Qt.MouseButton.LeftButton, pos=QPoint(rect.left() + 10, rect.center().y())
    )


# -- what was done -------------------------------------------------------------------------------------


def test_what_was_done_is_listed(steps):
    assert listed(steps) == ["1  Trapezium Drawing", "2  Laplacian Smoothing"]
    assert "iterations 3" in steps.window.recipe.list.item(0).text()
    assert steps.document.active.state.recipe == RECIPE
    assert not steps.window.action("run_recipe").isEnabled()
    steps.do("undo")
    assert listed(steps) == ["1  Trapezium Drawing"]
    steps.do("close_layer")
    assert listed(steps) == []


def test_scripts_run_as_they_are(steps, ant, tmp_path):
    result = tmp_path / "result.vtp"
    for command in ("copy_script", "copy_pyvista"):
        steps.do(command)
        if command == "copy_script":
            assert clipboard().rstrip() == steps.window.log.toPlainText()
        assert str(ant) in clipboard()
        (tmp_path / "script.py").write_text(clipboard())
        result.unlink(missing_ok=True)
        done = subprocess.run(
            [sys.executable, tmp_path / "script.py", ant, result], capture_output=True, text=True
        )
        assert done.returncode == 0, done.stderr
        assert same_points(read_surface(result)[0], steps.mesh)


def test_command_lines_give_the_same(steps, ant, tmp_path, capsys):
    steps.document.active.source = tmp_path / "ant.ply"
    (tmp_path / "ant.ply").write_bytes(ant.read_bytes())
    steps.do("copy_command")
    lines = clipboard().splitlines()
    assert [line.split()[1] for line in lines] == ["trapezium-drawing", "laplacian"]
    for line in lines:
        assert main([*line.split()[1:], "--quiet"]) == 0
    assert same_points(read_surface(tmp_path / "ant_result.vtp")[0], steps.mesh)


# -- editing -------------------------------------------------------------------------------------------


def test_a_parameter_is_changed_and_the_rest_is_run_again(steps):
    before = steps.document.active.state
    select(steps, 1)
    row = steps.window.recipe.form.rows["iterations"]
    assert row.value == 2
    row.slider.setValue(6)
    assert "iterations 6" in steps.window.recipe.list.item(1).text()
    assert steps.document.active.state is before
    assert "not run" in steps.window.recipe.about.text()
    steps.do("run_recipe")
    wanted = RECIPE.changed(1, iterations=6)
    assert same_points(steps.mesh, wanted.run(before_opened(steps)))
    assert steps.document.active.state.recipe == wanted
    assert "1 step from step 2 on" in steps.said
    assert not steps.window.action("run_recipe").isEnabled()
    steps.do("undo")
    assert steps.document.active.state is before
    assert steps.window.recipe.form.rows["iterations"].value == 2
    steps.do("redo")
    assert steps.document.active.state.recipe == wanted


def before_opened(user):
    return user.document.active.opened.mesh


def test_a_step_is_switched_off_and_on(steps):
    tick(steps, 0)
    assert steps.window.recipe.list.item(0).font().strikeOut()
    steps.do("run_recipe")
    assert same_points(steps.mesh, LaplacianSmoothing(iterations=2)(before_opened(steps)))
    assert listed(steps) == ["1  Trapezium Drawing", "2  Laplacian Smoothing"]
    tick(steps, 0)
    steps.do("run_recipe")
    # Both steps have been run before: nothing has to be made again.
    assert "no step had to be run" in steps.said
    assert same_points(steps.mesh, RECIPE.run(before_opened(steps)))


def test_steps_change_places(steps):
    from PySide6.QtCore import QModelIndex, Qt

    panel = steps.window.recipe
    select(steps, 1)
    steps.qtbot.mouseClick(panel.up, Qt.MouseButton.LeftButton)
    assert listed(steps) == ["1  Laplacian Smoothing", "2  Trapezium Drawing"]
    assert panel.list.currentRow() == 0
    assert not panel.up.isEnabled()
    steps.do("run_recipe")
    swapped = RECIPE.moved(1, 0)
    assert same_points(steps.mesh, swapped.run(before_opened(steps)))
    # What dragging a step below the other one does to the list.
    select(steps, 0)
    panel.list.model().moveRow(QModelIndex(), 0, QModelIndex(), 2)
    steps.wait(lambda: steps.application.recipes.draft.recipe == RECIPE)
    assert listed(steps) == ["1  Trapezium Drawing", "2  Laplacian Smoothing"]
    steps.do("revert_recipe")
    assert listed(steps) == ["1  Laplacian Smoothing", "2  Trapezium Drawing"]


def test_a_step_is_taken_out(steps):
    from PySide6.QtCore import Qt

    select(steps, 1)
    steps.qtbot.mouseClick(steps.window.recipe.remove, Qt.MouseButton.LeftButton)
    assert listed(steps) == ["1  Trapezium Drawing"]
    steps.do("revert_recipe")
    select(steps, 0)
    with steps.qtbot.waitActive(steps.window):
        steps.window.activateWindow()
    steps.window.recipe.list.setFocus()
    steps.qtbot.keyClick(steps.window.recipe.list, Qt.Key.Key_Delete)
    assert listed(steps) == ["1  Laplacian Smoothing"]
    steps.do("run_recipe")
    assert same_points(steps.mesh, LaplacianSmoothing(iterations=2)(before_opened(steps)))
    assert len(steps.document.active.state.recipe) == 1


def test_steps_run_anew_are_known_when_the_recipe_is_edited_again(steps):
    steps.apply(LaplacianSmoothing, iterations=4)
    draft = steps.application.recipes.draft
    draft.set(draft.recipe.changed(0, iterations=5))
    steps.do("run_recipe")
    assert "3 steps from step 1 on" in steps.said
    draft.set(draft.recipe.changed(2, iterations=1))
    steps.do("run_recipe")
    assert "1 step from step 3 on" in steps.said
    assert same_points(steps.mesh, draft.recipe.run(before_opened(steps)))


def test_a_step_that_fails_is_named_and_nothing_is_lost(steps):
    state = steps.document.active.state
    select(steps, 1)
    steps.window.recipe.form.rows["fixed"].set_value("missing")
    steps.do("run_recipe")
    assert "Step 2, Laplacian Smoothing" in steps.said
    assert "missing" in steps.said
    assert steps.document.active.state is state
    assert steps.window.action("run_recipe").isEnabled()


def test_a_run_can_be_cancelled(user, big):
    user.drop(big)
    user.apply(LaplacianSmoothing, iterations=1)
    state = user.document.active.state
    draft = user.application.recipes.draft
    draft.set(draft.recipe.changed(0, iterations=100_000))
    user.window.action("run_recipe").trigger()
    user.qtbot.waitUntil(lambda: user.window.recipe.progress.value() > 0, timeout=200_000)
    assert "step 1 of 1" in user.window.filters.doing.text()
    user.window.action("cancel").trigger()
    user.wait()
    assert user.document.active.state is state
    assert draft.edited
    assert "Cancelled" in user.said


def test_a_further_input_is_chosen_among_the_layers(steps, ant, tmp_path):
    other = pv.read(ant)
    other.points += np.float32(0.5)
    other.save(tmp_path / "other.ply")
    steps.apply(SurfaceComparison)
    steps.drop(tmp_path / "other.ply")
    steps.document.activate(steps.document.layers[0])
    select(steps, 2)
    box = steps.window.recipe.form.inputs["original"]
    assert box.currentText() == "ant as opened"
    box.setCurrentIndex(box.findText("other"))
    box.activated.emit(box.currentIndex())
    steps.do("run_recipe")
    assert steps.document.active.state.recipe.steps[2].inputs["original"] == tmp_path / "other.ply"
    expected = SurfaceComparison()(RECIPE.run(before_opened(steps)), read_surface(tmp_path / "other.ply")[0])
    found = steps.mesh.GetPointData().GetArray("Deviation")
    assert np.array_equal(vtk_to_numpy(found), vtk_to_numpy(expected.GetPointData().GetArray("Deviation")))


def test_an_optional_input_is_chosen_among_the_layers_or_none(user, tmp_path):
    skin, space = samples.channel()
    skin.triangulate().save(tmp_path / "skin.vtp")
    space.save(tmp_path / "space.vtp")
    user.drop(tmp_path / "skin.vtp")
    user.drop(tmp_path / "space.vtp")
    user.document.activate(user.document.layers[0])
    user.choose(TrapeziumDrawing, iterations=2)
    form = user.window.filters.form
    box, row = form.inputs["installation"], form.rows["containment"]
    assert (box.currentText(), row.isEnabled()) == ("none", False)
    user.do("apply")
    assert dict(user.document.active.state.recipe.steps[0].inputs) == {}
    free = user.mesh
    given = [read_surface(tmp_path / name)[0] for name in ("skin.vtp", "space.vtp")]
    smoothing = TrapeziumDrawing(iterations=2)
    assert same_points(free, smoothing(given[0]))
    # In the form of the filter, and in that of its step.
    user.do("undo")
    box.setCurrentIndex(box.findText("space"))
    assert row.isEnabled()
    user.do("apply")
    inside = smoothing(*given)
    assert same_points(user.mesh, inside)
    assert not same_points(free, inside)
    step = user.document.active.state.recipe.steps[0]
    assert dict(step.inputs) == {"installation": tmp_path / "space.vtp"}
    user.window.show_panel("Recipe")
    select(user, 0)
    box = user.window.recipe.form.inputs["installation"]
    assert box.currentText() == "space"
    box.setCurrentIndex(0)
    box.activated.emit(0)
    user.do("run_recipe")
    assert dict(user.document.active.state.recipe.steps[0].inputs) == {}
    assert same_points(user.mesh, free)


# -- files ---------------------------------------------------------------------------------------------


def answer(monkeypatch, method, path, kind=""):
    """Let the next file dialogs be answered with `path`."""
    from PySide6.QtWidgets import QFileDialog

    monkeypatch.setattr(QFileDialog, method, lambda *_: (str(path) if path else "", kind))


def test_the_kind_of_a_file_is_what_its_name_says(steps, tmp_path, monkeypatch):
    from vtksmooth_gui.controllers.recipes import JSON, PYVISTA, VTK

    for name, kind, written, begins in (
        ("a", JSON, "a.json", "{"),
        ("b", VTK, "b.py", '"""VTK pipeline'),
        ("c.py", PYVISTA, "c.py", '"""PyVista script'),
        ("d.py", JSON, "d.py", '"""VTK pipeline'),
        ("e.json", VTK, "e.json", "{"),
    ):
        answer(monkeypatch, "getSaveFileName", tmp_path / name, kind)
        steps.do("save_recipe")
        assert written in steps.said
        assert (tmp_path / written).read_text().startswith(begins)
    answer(monkeypatch, "getSaveFileName", "")
    steps.do("save_recipe")
    steps.do("report")
    assert len([*tmp_path.glob("?.*")]) == 5


def test_a_recipe_is_saved_and_replayed_on_another_mesh(steps, tmp_path, monkeypatch):
    path = tmp_path / "recipe.json"
    answer(monkeypatch, "getSaveFileName", path, "Recipe (*.json)")
    steps.do("save_recipe")
    assert Recipe.load(path) == RECIPE
    sphere = pv.Sphere(theta_resolution=12, phi_resolution=12)
    sphere.save(tmp_path / "sphere.ply")
    steps.drop(tmp_path / "sphere.ply")
    steps.document.activate(steps.document.layers[1])
    assert listed(steps) == []
    answer(monkeypatch, "getOpenFileName", path)
    steps.do("open_recipe")
    assert listed(steps) == ["1  Trapezium Drawing", "2  Laplacian Smoothing"]
    steps.do("run_recipe")
    assert same_points(steps.mesh, RECIPE.run(read_surface(tmp_path / "sphere.ply")[0]))
    assert "2 steps from step 1 on" in steps.said
    assert steps.document.layers[0].state.recipe == RECIPE


BROKEN = {
    "no json": "It is no JSON",
    '{"steps": []}': "It is no recipe",
    '{"format": "vtksmooth recipe", "version": 99}': "version 99",
    '{"format": "vtksmooth recipe", "version": 1, "steps": [{"filter": "magic"}]}': (
        "Step 1: There is no filter 'magic'"
    ),
}


def test_what_is_no_recipe_is_one_notification(steps, tmp_path):
    path = tmp_path / "broken.json"
    for text, what in BROKEN.items():
        path.write_text(text)
        steps.drop(path)
        assert steps.window.notification.level == "error"
        assert "broken.json" in steps.said
        assert what in steps.said
    steps.drop(tmp_path / "missing.json")
    assert "missing.json" in steps.said
    assert steps.application.recipes.draft.recipe == RECIPE


def test_a_role_without_a_mesh_is_asked_for(steps, tmp_path):
    Recipe([Step("containment")]).save(tmp_path / "recipe.json")
    steps.application.recipes.load(tmp_path / "recipe.json")
    state = steps.document.active.state
    steps.do("run_recipe")
    assert "'installation'" in steps.said
    assert "open it as a layer" in steps.said
    assert steps.document.active.state is state


def test_a_file_of_a_recipe_is_read_when_it_runs(user, ant, tmp_path):
    write_surface(pv.Sphere(radius=2.0), tmp_path / "space.vtp")
    recipe = Recipe([Step("containment", {}, {"installation": tmp_path / "space.vtp"})])
    recipe.save(tmp_path / "recipe.json")
    user.drop(ant)
    user.application.recipes.load(tmp_path / "recipe.json")
    user.do("run_recipe")
    assert user.mesh.GetPointData().HasArray("SignedDistance")
    (tmp_path / "space.vtp").unlink()
    # It has been read once.
    draft = user.application.recipes.draft
    draft.set(draft.recipe.added(Step("laplacian"), 0))
    user.do("run_recipe")
    assert "2 steps" in user.said


def test_every_filter_has_a_form_in_the_recipe(user, ant):
    user.drop(ant)
    for cls in FILTERS:
        user.application.recipes.draft.set(Recipe([Step(cls.command)]))
        assert set(user.window.recipe.form.rows) == set(cls.parameters())
        assert set(user.window.recipe.form.inputs) == set(cls.every_input()[1:])


# -- reports -------------------------------------------------------------------------------------------


def test_reports(steps, tmp_path, monkeypatch):
    for extension in (".html", ".pdf"):
        answer(monkeypatch, "getSaveFileName", tmp_path / "report", f"A page (*{extension})")
        steps.do("report")
        assert f"report{extension}" in steps.said
        monkeypatch.setattr(pictures, "draw", undrawn)
    text = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "trapezium-drawing iterations=3" in text
    assert "2 iterations, " in text
    assert "ant (not saved)" in text
    assert ("data:image/png" in text) != ("There are no pictures" in text)
    assert (tmp_path / "report.pdf").read_bytes().startswith(b"%PDF")


def test_a_report_that_cannot_be_written_says_so(steps, tmp_path):
    for name in ("nowhere/report.html", "report.docx"):
        steps.application.recipes.write_report(tmp_path / name)
        steps.wait()
        assert steps.window.notification.level == "error"
        assert name.split("/")[0] in steps.said
