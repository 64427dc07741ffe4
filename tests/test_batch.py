"""A recipe on many files, from Python and as ``vtksmooth run``."""

import json
import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import pyvista as pv

from vtksmooth import MeshFileError, Recipe, Step, SurfaceComparison, SurfaceQuality, batch
from vtksmooth.cli import main
from vtksmooth.errors import RecipeError
from vtksmooth.files import read_surface, write_surface

RECIPE = Recipe([Step("trapezium-drawing", {"iterations": 2}), Step("compare")])


def sphere(seed=0, n=8):
    mesh = pv.Sphere(theta_resolution=n, phi_resolution=n)
    mesh.points += np.random.default_rng(seed).normal(scale=0.02, size=mesh.points.shape).astype(np.float32)
    return mesh


@pytest.fixture
def recipe(tmp_path):
    path = tmp_path / "recipe.json"
    RECIPE.save(path)
    return path


@pytest.fixture
def folder(tmp_path):
    folder = tmp_path / "meshes"
    folder.mkdir()
    write_surface(sphere(1), folder / "one.ply")
    write_surface(sphere(2), folder / "two.vtp")
    return folder


def contents(folder):
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir())}


# ------------------------------------------------------------------------------------------- plans


def test_a_folder_is_its_mesh_files(folder, tmp_path):
    (folder / "notes.txt").write_text("no mesh")
    (folder / ".hidden.ply").write_text("no mesh")
    (folder / "sub.ply").mkdir()
    jobs = batch.plan([folder], tmp_path / "out")
    assert [(job.source.name, job.target) for job in jobs] == [
        ("one.ply", tmp_path / "out" / "one.ply"),
        ("two.vtp", tmp_path / "out" / "two.vtp"),
    ]
    assert not (tmp_path / "out").exists()


def test_results_of_equal_names_do_not_overwrite_each_other(tmp_path):
    files = [
        Path("a/part.ply"),
        Path("b/PART.ply"),
        Path("b/part.stl"),
        Path("c/part.gltf"),
        Path("part-2.ply"),
    ]
    names = [job.target.name for job in batch.plan(files, tmp_path)]
    assert names == ["part.ply", "PART-2.ply", "part-3.stl", "part-4.vtp", "part-2-2.ply"]
    names = [job.target.name for job in batch.plan(files[:2], tmp_path, ".vtp")]
    assert names == ["part.vtp", "PART-2.vtp"]


def test_no_input_is_overwritten(folder, tmp_path):
    for sources, output, keep in (
        ([folder], folder, ()),
        ([folder / "one.ply"], tmp_path / "meshes" / ".." / "meshes", ()),
        ([tmp_path / "one.ply"], folder, [folder / "one.ply"]),
    ):
        with pytest.raises(MeshFileError, match="would be overwritten"):
            batch.plan(sources, output, keep=keep)
    if hasattr(os, "symlink"):
        (tmp_path / "out").mkdir()
        (tmp_path / "out" / "one.ply").symlink_to(folder / "one.ply")
        with pytest.raises(MeshFileError, match="would be overwritten"):
            batch.plan([folder / "one.ply"], tmp_path / "out")
    # Another format beside the input is no harm.
    assert [job.target for job in batch.plan([folder / "one.ply"], folder, ".vtp")] == [folder / "one.vtp"]


def test_plans_that_cannot_be(folder, tmp_path):
    (tmp_path / "empty").mkdir()
    for sources, output, extension, what in (
        ([tmp_path / "empty"], tmp_path, None, "no mesh files"),
        ([folder], folder / "one.ply", None, "not a folder"),
        ([folder], tmp_path, ".gltf", "no format that can be written"),
    ):
        with pytest.raises(MeshFileError, match=what):
            batch.plan(sources, output, extension)


# ------------------------------------------------------------------------------------- from Python


def test_an_outcome_is_what_the_filters_say(folder, tmp_path):
    (job, _) = batch.plan([folder], tmp_path)
    outcome = batch.run(RECIPE, job)
    mesh = read_surface(folder / "one.ply")[0]
    quality, comparison = SurfaceQuality(usual_measures=False), SurfaceComparison()
    quality(mesh)
    made = RECIPE.run(mesh)
    comparison(made, mesh)
    assert outcome.measured.summaries == (quality.summary, comparison.summary)
    np.testing.assert_array_equal(read_surface(job.target)[0].points, pv.wrap(made).points)
    assert [step["filter"] for step in outcome.steps] == ["trapezium-drawing", "compare"]
    outcome.release()
    assert outcome.measured.meshes == (None, None)
    assert outcome.figures["after"] == comparison.summary
    (text,) = (line for line in batch.table([outcome]) if "one.ply" in line)
    for figure in (
        f"{quality.summary['aspect_ratio']['min']:.3f} -> {comparison.summary['aspect_ratio']['min']:.3f}",
        f"{quality.summary['volume']:.6g} -> {comparison.summary['volume']:.6g}",
        f"{comparison.summary['volume_change_percent']:+.3f}",
        f"{100 * comparison.summary['deviation']['max_relative']:.3f}",
    ):
        assert figure in text


# ------------------------------------------------------------------------------------ command line


def run(*arguments):
    return main(["run", *map(str, arguments)])


def test_twenty_meshes_one_of_them_broken(tmp_path, recipe, capsys):
    folder, output = tmp_path / "meshes", tmp_path / "results" / "deep"
    folder.mkdir()
    for i in range(20):
        write_surface(sphere(i), folder / f"part{i:02}.ply")
    whole = (folder / "part07.ply").read_bytes()
    (folder / "part07.ply").write_bytes(whole[: len(whole) // 2])
    before = contents(folder)
    assert run(recipe, folder, "--output", output) == 1
    out, err = capsys.readouterr()
    assert contents(folder) == before
    assert sorted(contents(output)) == [f"part{i:02}.ply" for i in range(20) if i != 7]
    rows = [line for line in out.splitlines() if line.startswith("| part")]
    assert len(rows) == 20
    assert "failed" in rows[7]
    assert out.splitlines()[-1].startswith("part07.ply ends in the middle")
    progress = [line for line in err.splitlines() if " of 20, " in line]
    assert len(progress) == 20
    assert "part07.ply ends in the middle" in progress[7]
    for i in (0, 19):
        expected = RECIPE.run(read_surface(folder / f"part{i:02}.ply")[0])
        np.testing.assert_array_equal(
            read_surface(output / f"part{i:02}.ply")[0].points, pv.wrap(expected).points
        )


def test_json(folder, recipe, tmp_path, capsys):
    (folder / "broken.off").write_text("OFF\n1 1 0\n")
    assert run(recipe, folder, "--output", tmp_path / "out", "--json", "--format", "vtp") == 1
    document = json.loads(capsys.readouterr().out)
    assert (document["done"], document["failed"]) == (2, 1)
    broken, one, two = document["files"]
    assert broken["output"] is None
    assert "broken.off" in broken["error"]
    assert one["error"] is None
    assert Path(one["output"]) == tmp_path / "out" / "one.vtp"
    assert Path(two["output"]).exists()
    assert one["after"]["deviation"]["max_relative"] > 0
    assert one["steps"][0]["iterations"] == 2


def test_quiet_says_nothing(folder, recipe, tmp_path, capsys):
    assert run(recipe, folder, "--output", tmp_path / "out", "--quiet") == 0
    assert capsys.readouterr() == ("", "")


def test_a_filter_that_fails_leaves_no_file_and_the_rest_done(folder, tmp_path, capsys):
    mesh = sphere()
    mesh.point_data["Pinned"] = np.zeros(mesh.n_points)
    write_surface(mesh, folder / "zero.vtp")
    Recipe([Step("laplacian", {"fixed": "Pinned"})]).save(tmp_path / "r.json")
    assert run(tmp_path / "r.json", folder, folder / "none.ply", "--output", tmp_path / "out") == 1
    out = capsys.readouterr().out
    (said,) = [line for line in out.splitlines() if line.startswith("one.ply: ")]
    assert "'Pinned'" in said
    assert "none.ply" in out
    assert list(contents(tmp_path / "out")) == ["zero.vtp"]


def test_an_unexpected_exception_is_one_files_failure_too(folder, recipe, tmp_path, capsys, monkeypatch):
    real = SurfaceQuality.execute

    def execute(self, *inputs):
        if inputs[0].GetNumberOfPoints() == 50:
            raise ZeroDivisionError("two\nlines")
        return real(self, *inputs)

    monkeypatch.setattr(SurfaceQuality, "execute", execute)
    write_surface(sphere(n=9), folder / "three.ply")
    assert read_surface(folder / "one.ply")[0].n_points == 50
    assert run(recipe, folder, "--output", tmp_path / "out") == 1
    assert "unexpected ZeroDivisionError" in capsys.readouterr().out
    assert list(contents(tmp_path / "out")) == ["three.ply"]
    with pytest.raises(ZeroDivisionError):
        run(recipe, folder, "--output", tmp_path / "out", "--debug")


def test_a_quiet_run_still_says_which_file_failed_and_why(folder, recipe, tmp_path, capsys):
    (folder / "broken.ply").write_text("junk")
    assert run(recipe, folder, "--output", tmp_path / "out", "--quiet") == 1
    out, err = capsys.readouterr()
    assert out == ""
    (line,) = err.splitlines()
    assert "broken.ply does not begin with ply" in line


def test_meshes_by_role(folder, tmp_path, capsys):
    Recipe([Step("compare", inputs={"original": "reference"})]).save(tmp_path / "r.json")
    arguments = [tmp_path / "r.json", folder / "one.ply", "--output", tmp_path / "out"]
    assert run(*arguments) == 1
    assert "role 'reference'" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
    assert run(*arguments, "--input", f"reference={folder / 'two.vtp'}", "--json") == 0
    (file,) = json.loads(capsys.readouterr().out)["files"]
    assert file["steps"][0]["deviation"]["max"] > 0
    assert file["after"]["deviation"]["max"] == 0
    assert run(*arguments, "--input", "reference") == 2
    assert run(*arguments, "--input", f"refrence={folder / 'two.vtp'}") == 1
    assert "'refrence'" in capsys.readouterr().err


@pytest.mark.parametrize("broken", ["{", '{"format": "vtksmooth recipe", "version": 99}'])
def test_what_is_no_recipe_stops_everything(folder, tmp_path, capsys, broken):
    (tmp_path / "r.json").write_text(broken)
    assert run(tmp_path / "r.json", folder, "--output", tmp_path / "out") == 1
    err = capsys.readouterr().err
    assert err.startswith("vtksmooth: error: ")
    assert len(err.splitlines()) == 1
    assert not (tmp_path / "out").exists()
    with pytest.raises(RecipeError):
        Recipe.load(tmp_path / "r.json")


@pytest.mark.skipif(sys.platform == "win32", reason="POSIX signals")
@pytest.mark.parametrize(("number", "expected"), [(signal.SIGINT, 130), (signal.SIGTERM, 1)])
def test_a_signal_keeps_what_is_done(tmp_path, number, expected):
    folder, output = tmp_path / "meshes", tmp_path / "out"
    folder.mkdir()
    output.mkdir()
    # Where no vertex may move, a run of any number of iterations is done at once.
    for name in "abc":
        write_surface(pv.Triangle(), folder / f"{name}.vtp")
    write_surface(pv.Plane(i_resolution=150, j_resolution=150).triangulate(), folder / "d.vtp")
    write_surface(pv.Triangle(), folder / "e.vtp")
    (output / "d.vtp").write_text("old")
    Recipe([Step("laplacian", {"iterations": 100_000_000})]).save(tmp_path / "r.json")
    process = subprocess.Popen(
        [sys.executable, "-m", "vtksmooth", "run", tmp_path / "r.json", folder, "--output", output, "--json"],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    for line in process.stderr:
        if line.startswith("3 of 5"):
            break
    process.send_signal(number)
    out, err = process.communicate(timeout=60)
    assert process.returncode == expected
    assert err.splitlines()[-1] == "vtksmooth: cancelled, 3 of 5 files done"
    assert "Traceback" not in err
    assert sorted(contents(output)) == ["a.vtp", "b.vtp", "c.vtp", "d.vtp"]
    assert (output / "d.vtp").read_text() == "old"
    if out:  # else the run was where it could not be asked to stop
        assert json.loads(out)["done"] == 3


def test_reports_are_beside_the_results(folder, recipe, tmp_path, capsys, monkeypatch):
    from vtksmooth.pages import pictures

    def no_pictures(command, **_):
        return subprocess.CompletedProcess(command, -11, b"", b"")

    monkeypatch.setattr(pictures.subprocess, "run", no_pictures)
    shutil.copy(folder / "one.ply", folder / "one.PLY.ply")
    assert run(recipe, folder, "--output", tmp_path / "out", "--report", "--json") == 0
    files = json.loads(capsys.readouterr().out)["files"]
    assert [Path(file["report"]).name for file in files] == ["one.PLY.html", "one.html", "two.html"]
    text = (tmp_path / "out" / "two.html").read_text(encoding="utf-8")
    assert "two.vtp" in text
    assert "trapezium-drawing iterations=2" in text
    assert "2 iterations, " in text
    assert "There are no pictures" in text
    assert run(recipe, folder / "two.vtp", "--output", tmp_path / "out", "--report", "pdf") == 0
    assert (tmp_path / "out" / "two.pdf").read_bytes().startswith(b"%PDF")
