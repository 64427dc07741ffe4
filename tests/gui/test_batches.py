"""Batches in a real window; results compared with those of the command line, byte for byte."""

import numpy as np
import pytest
import pyvista as pv

from vtksmooth import Recipe, Step
from vtksmooth.cli import main
from vtksmooth.files import write_surface

RECIPE = Recipe([Step("trapezium-drawing", {"iterations": 2}), Step("compare")])


def sphere(seed, n=8):
    mesh = pv.Sphere(theta_resolution=n, phi_resolution=n)
    mesh.points += np.random.default_rng(seed).normal(scale=0.02, size=mesh.points.shape).astype(np.float32)
    return mesh


@pytest.fixture
def recipe(tmp_path):
    RECIPE.save(tmp_path / "recipe.json")
    return tmp_path / "recipe.json"


@pytest.fixture
def folder(tmp_path):
    folder = tmp_path / "meshes"
    folder.mkdir()
    for number in range(20):
        if number == 7:
            (folder / "07.ply").write_text("this is no mesh")
        else:
            write_surface(sphere(number), folder / f"{number:02}.ply")
    return folder


def fill(user, recipe, folder, output):
    user.do("batch")
    dialog = user.application.batches.dialog
    assert dialog.isVisible()
    assert not dialog.start.isEnabled()
    dialog.offer_recipe(recipe.name, recipe)
    dialog.add_sources([folder])
    dialog.output.setText(str(output))
    assert dialog.start.isEnabled()
    return dialog


def column(dialog, number):
    return [
        dialog.table.item(row, number).text() if dialog.table.item(row, number) else ""
        for row in range(dialog.table.rowCount())
    ]


def click(user, button):
    from PySide6.QtCore import Qt

    user.qtbot.mouseClick(button, Qt.MouseButton.LeftButton)


def test_twenty_meshes_one_of_them_broken(user, recipe, folder, tmp_path, capsys):
    from PySide6.QtGui import QGuiApplication

    dialog = fill(user, recipe, folder, tmp_path / "window")
    seen = set()
    user.application.batches.ended.connect(lambda: seen.add("ended"))
    click(user, dialog.start)
    assert dialog.cancel.isEnabled()
    assert not dialog.start.isEnabled()
    user.qtbot.waitUntil(lambda: seen.update(column(dialog, 1)) or "ended" in seen, timeout=200_000)
    assert {"waiting", "done", "failed"} <= seen
    assert any(state.startswith("running") for state in seen)
    states = column(dialog, 1)
    assert states == ["failed" if row == 7 else "done" for row in range(20)]
    assert column(dialog, 0) == [f"{number:02}.ply" for number in range(20)]
    assert "07.ply" in column(dialog, 2)[7]
    assert dialog.said.text() == "19 done, 1 failed."
    assert main(["run", str(recipe), str(folder), "--output", str(tmp_path / "line")]) == 1
    table = capsys.readouterr().out
    results = [
        {path.name: path.read_bytes() for path in (tmp_path / name).iterdir()} for name in ("line", "window")
    ]
    assert len(results[0]) == 19
    assert results[0] == results[1]
    dialog.table.cellDoubleClicked.emit(7, 0)
    dialog.table.cellDoubleClicked.emit(3, 0)
    user.wait()
    assert [layer.name for layer in user.document.layers] == ["03"]
    assert user.document.active.source == tmp_path / "window" / "03.ply"
    click(user, dialog.copy)
    # The same table, but for the seconds.
    copied = QGuiApplication.clipboard().text().splitlines()
    assert [line.rsplit("|", 2)[0].strip() for line in copied] == [
        line.rsplit("|", 2)[0].strip() for line in table.splitlines()
    ]


def test_the_recipe_of_the_active_layer_and_reports(user, ant, folder, tmp_path, monkeypatch):
    from vtksmooth.filters import LaplacianSmoothing
    from vtksmooth.pages import pictures

    def undrawn(_):
        raise pictures.NoPicturesError("drawing takes its time")

    monkeypatch.setattr(pictures, "draw", undrawn)
    user.drop(ant)
    user.apply(LaplacianSmoothing, iterations=2)
    for path in sorted(folder.iterdir())[2:]:
        path.unlink()
    user.do("batch")
    dialog = user.application.batches.dialog
    assert "active layer, 1 step" in dialog.recipes.currentText()
    dialog.add_sources([folder])
    dialog.output.setText(str(tmp_path / "out"))
    dialog.format.setCurrentIndex(dialog.format.findText(".vtp"))
    dialog.report.setCurrentIndex(1)
    click(user, dialog.start)
    user.wait()
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == [
        "00.html", "00.vtp", "01.html", "01.vtp",
    ]  # fmt: skip


def test_a_batch_can_be_cancelled_and_the_window_answers(user, big, tmp_path):
    Recipe([Step("laplacian", {"iterations": 100_000})]).save(tmp_path / "long.json")
    user.drop(big)
    dialog = fill(user, tmp_path / "long.json", big, tmp_path / "out")
    click(user, dialog.start)
    user.qtbot.waitUntil(lambda: "iteration" in dialog.said.text(), timeout=200_000)
    assert column(dialog, 1)[0].startswith("running")
    frames = user.window.view.frames
    user.window.action("view_pz").trigger()
    user.qtbot.waitUntil(lambda: user.window.view.frames > frames)
    click(user, dialog.cancel)
    user.wait()
    assert column(dialog, 1) == ["not done"]
    assert dialog.said.text() == "Cancelled. 0 done, 0 failed."
    assert [*(tmp_path / "out").iterdir()] == []
    assert dialog.start.isEnabled()


def test_what_cannot_be_is_said_before_anything_is_done(user, recipe, folder, tmp_path):
    dialog = fill(user, recipe, folder, folder)
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    click(user, dialog.start)
    user.wait()
    assert "is an input and would be overwritten" in dialog.said.text()
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before
    recipe.write_text("{}")
    click(user, dialog.start)
    assert "It is no recipe" in dialog.said.text()
    assert dialog.start.isEnabled()
