import json
import subprocess
from pathlib import Path

import numpy as np
import pytest
import pyvista as pv
from pyvista import examples

from vtksmooth import MeshFileError, SurfaceQuality, demo
from vtksmooth.pages import pictures


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("demo")
    demo.run(folder, quiet=True)
    return folder


def test_figures_are_those_of_the_filters(results):
    summary = json.loads((results / "summary.json").read_text(encoding="utf-8"))["meshes"]
    assert [mesh["name"] for mesh in summary] == ["airplane", "ant", "channels"]
    files = (examples.planefile, examples.antfile, results / "channels_before.vtp")
    for mesh, file in zip(summary, files, strict=True):
        quality = SurfaceQuality(usual_measures=False)
        quality(pv.read(file))
        assert mesh["before"] == quality.summary
        states = [mesh["before"], mesh["passes"]["1"], mesh["passes"]["5"]]
        smallest = [state["aspect_ratio"]["min"] for state in states]
        assert smallest == sorted(smallest)
        # The share of poor faces is what Trapezium Drawing lowers.
        poor = [sum(state["aspect_ratio"]["histogram"][:2]) for state in states]
        assert poor[0] > poor[1] > poor[2]


def test_result_meshes_hold_what_the_summary_says(results):
    for mesh in json.loads((results / "summary.json").read_text(encoding="utf-8"))["meshes"]:
        before, after = (pv.read(results / f"{mesh['name']}_{state}.vtp") for state in ("before", "after"))
        np.testing.assert_array_equal(before.faces, after.faces)
        assert after["AspectRatio"].min() == mesh["passes"]["5"]["aspect_ratio"]["min"]
        assert before["AspectRatio"].min() == mesh["before"]["aspect_ratio"]["min"]
        assert after["NormalDeviation"].max() == mesh["passes"]["5"]["normal_deviation"]["max"]


def test_the_marching_cubes_surface_gets_better_and_stays_where_it_is(results):
    before, after = (pv.read(results / f"channels_{state}.vtp") for state in ("before", "after"))
    assert before.is_all_triangles
    assert before.split_bodies().n_blocks == 1
    _, nearest = before.find_closest_cell(after.points, return_closest_point=True)
    distance = np.linalg.norm(nearest - after.points, axis=1)
    assert 0 < distance.max() < 0.005 * before.length
    assert (before["AspectRatio"] < 0.2).mean() > 0.05
    assert (after["AspectRatio"] < 0.2).mean() < 0.005


def test_document_has_the_tables_and_pictures_that_exist(results):
    document = (results / "summary.md").read_text(encoding="utf-8")
    assert document.count("| 0 <= k < 0.2, % of the faces ") == 3
    for name in ("airplane", "ant", "channels"):
        picture = results / f"{name}.png"
        if "No pictures" in document:
            assert not picture.exists()
        else:
            assert f"({name}.png)" in document
            image = pv.read(picture)
            width, height, _ = image.dimensions
            pixels = np.asarray(image.point_data.active_scalars).reshape(height, width, -1)
            # Before, after, histogram: none is blank.
            for part in np.array_split(pixels, 3, axis=1):
                assert part.std() > 10


def test_readme_quotes_the_figures(results):
    document = (results / "summary.md").read_text(encoding="utf-8")
    readme = " ".join((Path(__file__).parents[1] / "README.md").read_text(encoding="utf-8").split())
    for said, quoted in [
        ("fell from 9.0 to 0.3 %", "fall from 9.0 % to 0.3 %"),
        ("the mean k rose from 0.685 to 0.880", "the mean of k rises from 0.685 to 0.880"),
        ("original's at most 0.25 % from the", "more than 0.25 % of the diagonal away from the result"),
        ("fell from 13.4 to 1.3 %", "fall from 13.4 % to 1.3 %"),
        ("the mean k rose from 0.479 to 0.608", "the mean of k rises from 0.48 to 0.61"),
        ("fell from 7.3 to 4.2 %", "fall from 7.3 % to 4.2 %"),
        ("the mean k fell from 0.471 to 0.465", "the mean goes from 0.471 to 0.465"),
    ]:
        assert said in document
        assert quoted in readme


def test_says_what_was_done_and_what_to_type(capfd, tmp_path, monkeypatch):
    # VTK ends the process where it finds no OpenGL; the figures must be there all the same.
    def crash(command, **_):
        return subprocess.CompletedProcess(command, -11, b"", b"")

    monkeypatch.setattr(pictures.subprocess, "run", crash)
    demo.run(tmp_path, meshes=[examples.antfile, examples.antfile])
    out, err = capfd.readouterr()
    assert err == ""
    assert "No pictures: " in out
    assert "libegl1" in out
    assert "the share of poor faces (k < 0.2) fell from 13.4 to 1.3 %" in out
    assert "trapezium-drawing MESH RESULT.vtp" in out
    assert "![" not in (tmp_path / "summary.md").read_text(encoding="utf-8")
    made = {path.name for path in tmp_path.iterdir()}
    results = {f"{name}_{state}.vtp" for name in ("ant", "ant-2") for state in ("before", "after")}
    assert made == {"summary.md", "summary.json", *results}


def test_a_defect_in_drawing_is_named(capsys, tmp_path, monkeypatch):
    def fail(command, **_):
        return subprocess.CompletedProcess(command, 1, b"", b"Traceback\nValueError: no such colour\n")

    monkeypatch.setattr(pictures.subprocess, "run", fail)
    demo.run(tmp_path, meshes=[examples.antfile])
    assert "No pictures: ValueError: no such colour" in capsys.readouterr().out


def test_quiet_prints_nothing(capfd, tmp_path, monkeypatch):
    def drawn(command, **_):
        return subprocess.CompletedProcess(command, 1, b"", b"")

    monkeypatch.setattr(pictures.subprocess, "run", drawn)
    demo.run(tmp_path, quiet=True, meshes=[examples.antfile])
    assert capfd.readouterr() == ("", "")


def test_a_bad_file_is_found_before_anything_is_written(tmp_path):
    output = tmp_path / "output"
    with pytest.raises(MeshFileError, match=r"missing\.stl"):
        demo.run(output, meshes=[examples.antfile, tmp_path / "missing.stl"])
    assert not output.exists()


def test_output_that_is_a_file(tmp_path):
    output = tmp_path / "output"
    output.write_text("mine", encoding="utf-8")
    with pytest.raises(MeshFileError, match="--output"):
        demo.run(output, quiet=True, meshes=[examples.antfile])
    assert output.read_text(encoding="utf-8") == "mine"


@pytest.mark.parametrize(
    ("mean", "words"),
    [(0.6, "the mean k rose from 0.500 to 0.600"), (0.45, "the mean k fell from 0.500 to 0.450")],
)
def test_verdict_says_which_way_the_mean_went(mean, words):
    before = {"histogram": [1.0, 20.0, 0, 0, 0, 79.0], "mean": 0.5, "min": -0.1}
    after = {"histogram": [0.0, 10.0, 0, 0, 0, 90.0], "mean": mean, "min": -0.1}
    last = {"aspect_ratio": after, "deviation": {"max_relative": 0.001, "back": {"max_relative": 0.002}}}
    verdict = demo._verdict({"before": {"aspect_ratio": before}, "passes": {"5": last}})
    assert words in verdict
    assert "fell from 21.0 to 10.0 %" in verdict
    assert "at most 0.1 % of the diagonal from the original surface" in verdict
    assert "at most 0.2 % from the result" in verdict
    assert "the smallest k stayed at -0.100" in verdict
    assert ("hardly changes" in verdict) == (mean < 0.5)
