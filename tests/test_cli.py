import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
import pyvista as pv
from pyvista import examples

import vtksmooth
from vtksmooth.cli import COMMANDS, main
from vtksmooth.files import read_surface, write_surface
from vtksmooth.filters import FILTERS

SMOOTHING = ["trapezium-drawing", "laplacian", "angle-based", "back-to-surface", "equilateral"]
QUALITY_KEYS = {"points", "cells", "closed", "volume", "aspect_ratio", "inverted"}
COMPARE_KEYS = {"normal_deviation", "dihedral_change", "volume_change_percent", "deviation"}


def start(*arguments, **options):
    return subprocess.Popen(
        [sys.executable, "-m", "vtksmooth", *map(str, arguments)],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **options,
    )  # fmt: skip


def run(*arguments):
    process = start(*arguments)
    out, err = process.communicate(timeout=300)
    return process.returncode, out, err


@pytest.fixture
def sphere(tmp_path):
    path = tmp_path / "sphere.vtp"
    mesh = pv.Sphere(theta_resolution=12, phi_resolution=12)
    mesh.points += np.random.default_rng(0).normal(scale=0.02, size=mesh.points.shape).astype(np.float32)
    write_surface(mesh, path)
    return path


# ---------------------------------------------------------------------------------------- contract


def test_every_filter_has_its_command():
    assert {cls.command for cls in FILTERS} <= COMMANDS.keys()


def test_quality_json_in_a_process():
    code, out, err = run("quality", examples.planefile, "--json")
    assert code == 0
    summary = json.loads(out)
    assert summary.keys() >= QUALITY_KEYS
    assert summary["cells"] == {"triangle": 2452, "quad": 0, "polygon": 0}
    assert len(summary["aspect_ratio"]["histogram"]) == 6
    assert sum(summary["aspect_ratio"]["histogram"]) == pytest.approx(100)
    assert summary["volume"] is None
    assert "error" not in err


def test_compare_json_is_of_the_result_against_the_original(sphere, tmp_path, capsys):
    result = tmp_path / "result.vtp"
    assert main(["laplacian", str(sphere), str(result), "--iterations", "3", "--quiet"]) == 0
    assert main(["compare", str(sphere), str(result), "--json"]) == 0
    summary = json.loads(capsys.readouterr().out)
    assert summary.keys() >= QUALITY_KEYS | COMPARE_KEYS
    assert summary["normal_deviation"].keys() == {"max", "mean"}
    assert summary["dihedral_change"].keys() == {"max", "mean"}
    figures = {"max", "mean", "max_relative", "mean_relative"}
    assert summary["deviation"].keys() == figures | {"back"}
    assert summary["deviation"]["back"].keys() == figures
    assert summary["volume_change_percent"] < 0  # the plain Laplacian shrinks


@pytest.mark.parametrize("command", SMOOTHING)
def test_smoothing_equals_the_filter(command, sphere, tmp_path, capsys):
    result = tmp_path / "result.vtp"
    assert main([command, str(sphere), str(result), "--iterations", "4", "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    cls = next(cls for cls in FILTERS if cls.command == command)
    algorithm = cls(iterations=4)
    expected = pv.wrap(algorithm(read_surface(sphere)[0]))
    np.testing.assert_array_equal(read_surface(result)[0].points, expected.points)
    assert report["iterations"] == algorithm.report.iterations
    assert report["stop_reason"] == algorithm.report.stop_reason
    assert report["moved"] == algorithm.report.moved


@pytest.mark.parametrize("cls", [cls for cls in FILTERS if cls.command in SMOOTHING], ids=lambda c: c.command)
def test_every_parameter_is_an_option(cls, capsys):
    assert main([cls.command, "--help"]) == 0
    text = " ".join(capsys.readouterr().out.split())
    for parameter in cls.parameters().values():
        assert f"--{parameter.name.replace('_', '-')}" in text
        assert " ".join(parameter.help.split()) in text


def test_options_reach_the_filter(sphere, tmp_path, capsys):
    arguments = [
        "--iterations",
        "50",
        "--stop-normal-deviation",
        "2",
        "--boundary",
        "sliding",
        "--tangent-plane",
    ]
    assert main(["laplacian", str(sphere), str(tmp_path / "o.vtp"), *arguments, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["stop_reason"] == "normal-deviation"
    arguments = ["--stop-normal-deviation", "off", "--fixed", "off", "--no-tangent-plane"]
    assert main(["laplacian", str(sphere), str(tmp_path / "o.vtp"), *arguments, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["stop_reason"] == "iterations"


def test_help_and_version_are_quick_because_they_import_little():
    for arguments, modules in (
        (["--version"], ("numpy", "numba", "vtkmodules", "pyvista")),
        (["--help"], ("numba", "vtkmodules", "pyvista")),
        (["laplacian", "--help"], ("pyvista",)),
    ):
        script = f"import sys; from vtksmooth.cli import main; code = main({arguments}); "
        script += f"print(sorted(set(sys.modules) & set({modules}))); sys.exit(code)"
        done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
        assert done.stdout.splitlines()[-1] == "[]"


def test_version(capsys):
    assert main(["--version"]) == 0
    assert capsys.readouterr().out == f"vtksmooth {vtksmooth.__version__}\n"


# ----------------------------------------------------------------------------------- people's view


def test_tables_have_the_papers_bins(sphere, capsys):
    assert main(["compare", str(sphere), str(sphere)]) == 0
    out = capsys.readouterr().out
    assert "closed, volume" in out
    for head in ("k<0", "0-.2", ".2-.4", ".4-.6", ".6-.8", ".8-1", "inverted", "normal deviation"):
        assert head in out


def test_notes_go_to_stderr_unless_quiet(sphere, tmp_path, capsys):
    stl = tmp_path / "s.stl"
    write_surface(read_surface(sphere)[0], stl)
    assert main(["quality", str(stl), "--json"]) == 0
    captured = capsys.readouterr()
    json.loads(captured.out)
    assert "merged" in captured.err
    assert main(["laplacian", str(stl), str(tmp_path / "o.stl"), "--quiet"]) == 0
    assert capsys.readouterr() == ("", "")


def test_kernels_being_compiled_are_announced(sphere, capsys, monkeypatch):
    from vtksmooth.jit import compiled

    real = vtksmooth.SurfaceQuality.execute

    def execute(self, *inputs):
        for listener, _ in list(compiled._announcer.listeners):
            listener("_some_kernel")
            listener("_another")
        return real(self, *inputs)

    monkeypatch.setattr(vtksmooth.SurfaceQuality, "execute", execute)
    assert main(["quality", str(sphere)]) == 0
    err = capsys.readouterr().err
    assert "compiling kernel 1 (_some_kernel)" in err
    assert "compiling kernel 2 (_another)" in err
    assert main(["quality", str(sphere), "--quiet"]) == 0
    assert capsys.readouterr().err == ""


# ------------------------------------------------------------------------------------------ errors


@pytest.mark.parametrize(
    "arguments",
    [
        [],
        ["nonsense"],
        ["laplacian"],
        ["laplacian", "a.vtp"],
        ["laplacian", "a.vtp", "b.vtp", "--iterations", "-1"],
        ["laplacian", "a.vtp", "b.vtp", "--iterations", "2.5"],
        ["laplacian", "a.vtp", "b.vtp", "--iterations", "off"],
        ["laplacian", "a.vtp", "b.vtp", "--relaxation-factor", "nan"],
        ["laplacian", "a.vtp", "b.vtp", "--scheme", "magic"],
        ["laplacian", "a.vtp", "b.vtp", "--iter", "3"],
        ["laplacian", "a.vtp", "b.vtp", "--stop-normal-deviation", "200"],
        ["quality", "a.vtp", "--threads", "-1"],
    ],
)
def test_wrong_usage_is_one_line_and_2(arguments, capsys):
    assert main(arguments) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert len(captured.err.splitlines()) == 1
    assert captured.err.startswith("vtksmooth: error: ")


def test_out_of_range_names_parameter_and_range(capsys):
    assert main(["laplacian", "a.vtp", "b.vtp", "--relaxation-factor", "3"]) == 2
    assert "relaxation_factor must be from 0 to 1" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("output", "options", "what"),
    [
        ("o.xyz", [], "no format"),
        ("none/o.vtp", [], "no folder"),
        ("o.vtp", ["--fixed", "Pinned"], "Pinned"),
    ],
)
def test_a_failed_run_is_one_line_and_1(sphere, tmp_path, capsys, output, options, what):
    assert main(["laplacian", str(sphere), str(tmp_path / output), *options]) == 1
    err = capsys.readouterr().err
    assert err.startswith("vtksmooth: error: ")
    assert len(err.splitlines()) == 1
    assert what in err
    assert [p.name for p in tmp_path.iterdir()] == ["sphere.vtp"]


def test_the_output_is_checked_before_the_input_is_read(tmp_path, capsys):
    assert main(["laplacian", str(tmp_path / "none.vtp"), str(tmp_path / "o.xyz")]) == 1
    assert "o.xyz" in capsys.readouterr().err


def test_no_traceback_but_with_debug(tmp_path):
    code, out, err = run("quality", tmp_path / "none.ply")
    assert (code, out) == (1, "")
    assert err.startswith("vtksmooth: error: ")
    assert "Traceback" not in err
    code, _, err = run("quality", tmp_path / "none.ply", "--debug")
    assert code == 1
    assert "Traceback" in err


def test_an_unexpected_exception_is_one_line_too(sphere, capsys, monkeypatch):
    def execute(self, *inputs):
        raise ZeroDivisionError("two\nlines")

    monkeypatch.setattr(vtksmooth.SurfaceQuality, "execute", execute)
    assert main(["quality", str(sphere)]) == 1
    err = capsys.readouterr().err
    assert len(err.splitlines()) == 1
    assert "ZeroDivisionError" in err
    assert "--debug" in err


def test_meshes_that_cannot_be_compared(sphere, tmp_path, capsys):
    write_surface(pv.Cube(), tmp_path / "cube.vtp")
    assert main(["compare", str(sphere), str(tmp_path / "cube.vtp")]) == 1
    assert "same points and faces" in capsys.readouterr().err


def test_a_closed_pipe_is_no_traceback(sphere):
    read, write = os.pipe()
    os.close(read)
    process = subprocess.Popen(
        [sys.executable, "-m", "vtksmooth", "quality", str(sphere)],
        stdout=write,
        stderr=subprocess.PIPE,
        text=True,
    )
    os.close(write)
    _, err = process.communicate(timeout=300)
    assert process.returncode == 1
    assert "Traceback" not in err
    assert "BrokenPipe" not in err


# ------------------------------------------------------------------------------------ interruption


@pytest.mark.skipif(sys.platform == "win32", reason="POSIX signals")
@pytest.mark.parametrize(("number", "expected"), [(signal.SIGINT, 130), (signal.SIGTERM, 1)])
def test_a_signal_stops_the_filter_and_nothing_is_written(tmp_path, number, expected):
    mesh = pv.Plane(i_resolution=150, j_resolution=150).triangulate()
    write_surface(mesh, tmp_path / "m.vtp")
    (tmp_path / "out.vtp").write_text("old")
    process = start("laplacian", tmp_path / "m.vtp", tmp_path / "out.vtp", "--iterations", "100000000")
    time.sleep(4)  # wherever it is by then, it is not done
    process.send_signal(number)
    out, err = process.communicate(timeout=60)
    assert process.returncode == expected
    assert out == ""
    assert err.splitlines()[-1] == "vtksmooth: cancelled, nothing written"
    assert "Traceback" not in err
    assert (tmp_path / "out.vtp").read_text() == "old"
    assert sorted(p.name for p in tmp_path.iterdir()) == ["m.vtp", "out.vtp"]


@pytest.mark.skipif(sys.platform == "win32", reason="POSIX signals")
def test_a_signal_during_the_writing_leaves_the_old_file(tmp_path, sphere):
    (tmp_path / "out.ply").write_text("old")
    script = """
import sys, time
from vtksmooth.cli import main
from vtksmooth.files import writing
def slow(file, mesh):
    file.write(b"ply")
    file.flush()
    print("writing", flush=True)
    time.sleep(100)
writing._WRITE_POLYGONS[".ply"] = slow
sys.exit(main(["trapezium-drawing", *sys.argv[1:]]))
"""
    process = subprocess.Popen(
        [sys.executable, "-c", script, str(sphere), str(tmp_path / "out.ply")],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    assert process.stdout.readline() == "writing\n"
    assert len(list(tmp_path.glob(".out*.ply"))) == 1
    process.send_signal(signal.SIGTERM)
    _, err = process.communicate(timeout=60)
    assert process.returncode == 1
    assert err.splitlines()[-1] == "vtksmooth: cancelled, nothing written"
    assert (tmp_path / "out.ply").read_text() == "old"
    assert list(tmp_path.glob(".out*")) == []


def test_signal_handlers_are_given_back(sphere):
    before = signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)
    assert main(["quality", str(sphere), "--quiet", "--json"]) == 0
    assert (signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)) == before


# --------------------------------------------------------------------------------- warm-up, threads


def test_after_a_warm_up_nothing_is_left_to_compile(tmp_path):
    assert run("warm-up", "--quiet")[0] == 0
    code, out, err = run("warm-up", "--json")
    assert code == 0
    assert json.loads(out)["compiled"] == 0
    assert err == ""
    # Nor for meshes of another size, precision, index type and fixed array than its own.
    mesh = pv.Plane(i_resolution=220, j_resolution=220)
    mesh.points = mesh.points.astype(np.float64)
    mesh.point_data["Fixed"] = np.zeros(mesh.n_points, dtype=np.float32)
    write_surface(mesh, tmp_path / "m.vtp")
    for command in SMOOTHING:
        code, _, err = run(command, tmp_path / "m.vtp", tmp_path / "o.vtp", "--iterations", 2, "--threads", 2)
        assert (code, err) == (0, "")
    code, _, err = run("compare", tmp_path / "m.vtp", tmp_path / "o.vtp")
    assert (code, err) == (0, "")


def test_threads_do_not_change_the_result(tmp_path):
    mesh = pv.Plane(i_resolution=220, j_resolution=220).triangulate()
    mesh.points[:, 2] = np.random.default_rng(0).normal(scale=1e-3, size=mesh.n_points)
    write_surface(mesh, tmp_path / "m.vtp")
    for threads in ("1", "2"):
        arguments = [
            str(tmp_path / "m.vtp"),
            str(tmp_path / f"o{threads}.vtp"),
            "--threads",
            threads,
            "--quiet",
        ]
        assert main(["trapezium-drawing", *arguments]) == 0
    vtksmooth.set_number_of_threads(0)
    one, two = (read_surface(tmp_path / f"o{threads}.vtp")[0] for threads in "12")
    np.testing.assert_array_equal(one.points, two.points)
