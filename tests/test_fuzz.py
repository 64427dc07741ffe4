"""Odd meshes and damaged files, a small part: nothing dies, is lost or breaks a guarantee."""

import os
import sys
import time
from pathlib import Path

import meshes
import numpy as np
import pytest
from vtkmodules.vtkCommonDataModel import vtkPolyData

from vtksmooth.filters import FILTERS, LaplacianSmoothing, SurfaceQuality, TrapeziumDrawing

FOLDER = Path(__file__).parents[1] / "benchmarks"

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="process groups and limits of Linux")


def test_nothing_goes_wrong(program, tmp_path, capsys):
    fuzz = program("fuzz")
    counts = {"meshes": 12, "files": 25, "batch": 1, "sessions": 6}
    arguments = [word for kind, count in counts.items() for word in (f"--{kind}", str(count))]
    status = fuzz.main([*arguments, "--first", "1", "--jobs", "1", "--output", str(tmp_path / "fuzz.md")])
    said = capsys.readouterr().out
    assert status == 0, said
    page = (tmp_path / "fuzz.md").read_text(encoding="utf-8")
    for kind, count in counts.items():
        assert f"| {kind} | {count} |" in page
    assert "## Findings" not in page


class Losing(SurfaceQuality):
    """A filter that returns nothing."""

    def execute(self, source):
        super().execute(source)
        return vtkPolyData()


class Moving(TrapeziumDrawing):
    """A filter that moves what is fixed."""

    def execute(self, source):
        made = super().execute(source)
        made.GetPoints().GetData().SetComponent(0, 2, 7.0)
        return made


class Flattening(LaplacianSmoothing):
    """A filter that makes everything flat."""

    def execute(self, source):
        made = super().execute(source)
        made.GetPoints().GetData().FillComponent(2, 0.0)
        return made


class Failing(SurfaceQuality):
    """A filter with a fault in its program."""

    def execute(self, source):
        raise IndexError("no such thing")


@pytest.mark.parametrize(
    ("cls", "parameters", "kind"),
    [
        (Losing, {}, "silent empty"),
        (Moving, {"iterations": 1}, "boundary moved"),
        (Failing, {}, "unexpected exception"),
    ],
)
def test_what_goes_wrong_is_found(program, cls, parameters, kind):
    checks, odd_meshes = program("fuzz_checks"), program("odd_meshes")
    random = np.random.default_rng(0)
    mesh = odd_meshes.polydata(*odd_meshes.sheet(random))
    odd = odd_meshes.Odd("a sheet", mesh, {})
    assert checks.exercise(cls.__bases__[0], odd, parameters)[1] == []
    assert kind in [finding.kind for finding in checks.exercise(cls, odd, parameters)[1]]


def test_flattened_creases_are_found(program):
    checks, odd_meshes = program("fuzz_checks"), program("odd_meshes")
    cube = meshes.cube(3, triangles=True)
    odd = odd_meshes.Odd("a cube", meshes.polydata(cube), {})
    parameters = {"iterations": 2, "crease_angle": 40.0}
    assert checks.exercise(LaplacianSmoothing, odd, parameters)[1] == []
    found = [finding.kind for finding in checks.exercise(Flattening, odd, parameters)[1]]
    assert "creases flattened" in found


def test_a_process_that_hangs_is_ended_with_all_that_it_started(program):
    fuzz = program("fuzz")
    worker = fuzz.Worker(0, patience=0.001)
    try:
        hanging = worker.process.pid
        outcome = worker.do("meshes", 0)
        assert [finding["kind"] for finding in outcome.findings] == ["hang"]
        for _ in range(300):  # until the system has taken note of all
            try:
                os.killpg(hanging, 0)
            except ProcessLookupError:
                break
            time.sleep(0.1)
        else:
            pytest.fail("something that the process has started goes on")
        worker.patience = 300.0
        assert worker.do("meshes", 0).runs == len(FILTERS)
    finally:
        worker.end()
