"""After any run the result is right, or an exception says why: errors, Ctrl-C, the end of the program."""

from __future__ import annotations

import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import pyvista as pv
from vtkmodules.vtkCommonDataModel import vtkPolyData
from vtkmodules.vtkFiltersCore import vtkPolyDataNormals
from vtkmodules.vtkFiltersSources import vtkPlaneSource, vtkSphereSource
from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter

from vtksmooth import (
    Cancelled,
    InstallationSpaceSmoothing,
    InvalidMeshError,
    LaplacianSmoothing,
    SurfaceComparison,
    SurfaceQuality,
)
from vtksmooth.accessor import method_name
from vtksmooth.filters import FILTERS, Filter, SmoothingFilter

IMAGE = pv.ImageData(dimensions=(3, 3, 3))
WRONG: dict[str, tuple[Any, str]] = {
    "image": (IMAGE, "not ImageData; extract its surface first"),
    "grid": (IMAGE.cast_to_unstructured_grid(), "not UnstructuredGrid; extract its surface first"),
    "table": (pv.Table({"a": np.arange(3)}), "not Table; give a surface mesh"),
    "none": (None, "is missing; give polydata"),
    "array": (np.zeros((3, 3)), "not ndarray; give a surface mesh"),
    "text": ("part.ply", "not str; read the file first"),
    "path": (Path("part.ply"), "read the file first"),
}
IN_VTK = ("image", "grid", "table", "none")


@pytest.fixture(autouse=True)
def quiet(monkeypatch: pytest.MonkeyPatch) -> None:
    from vtkmodules.vtkCommonCore import vtkLogger

    monkeypatch.setattr("vtksmooth.filters.base.Filter._say", lambda self, message: None)
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)


def no_figures(algorithm: Any) -> bool:
    """Whether a filter shows what a new one shows."""
    return bool(algorithm.figures == type(algorithm)().figures and algorithm.notes == [])


# -- wrong inputs --------------------------------------------------------------------------------


@pytest.mark.parametrize("cls", FILTERS)
@pytest.mark.parametrize("kind", WRONG)
def test_a_wrong_input_is_refused_on_every_port(cls: type[Filter], kind: str) -> None:
    thing, message = WRONG[kind]
    every = cls.every_input()
    for port, name in enumerate(every):
        if thing is None and name in cls.optional_inputs:
            continue
        inputs: list[Any] = [pv.Sphere()] * len(every)
        inputs[port] = thing
        algorithm = cls()
        for _ in range(2):
            with pytest.raises(InvalidMeshError, match=message):
                algorithm(*inputs)
        assert no_figures(algorithm)


@pytest.mark.parametrize("kind", IN_VTK)
@pytest.mark.parametrize("port", [0, 1])
def test_a_wrong_input_is_refused_in_a_pipeline(kind: str, port: int) -> None:
    thing, message = WRONG[kind]
    comparison = SurfaceComparison()
    comparison.SetInputData(1 - port, pv.Sphere())
    comparison.SetInputData(port, thing)
    for update in (comparison.Update, comparison.UpdateWholeExtent, lambda: comparison.UpdatePiece(0, 1, 0)):
        with pytest.raises(InvalidMeshError, match=message):
            update()
        assert isinstance(comparison.last_error, InvalidMeshError)
        assert comparison.GetOutput().GetNumberOfPoints() == 0
    comparison.SetInputData(port, pv.Sphere())
    comparison.Update()
    assert comparison.last_error is None


def test_a_wrong_connection_is_refused() -> None:
    source = vtkPlaneSource()
    quality = SurfaceQuality()
    quality.SetInputConnection(source.GetOutputPort())
    quality.AddInputConnection(source.GetOutputPort())
    for _ in range(2):
        with pytest.raises(InvalidMeshError, match="SurfaceQuality did not run"):
            quality.Update()


@pytest.mark.parametrize("cls", [cls for cls in FILTERS if len(cls.inputs) > 1])
@pytest.mark.parametrize("kind", WRONG)
def test_inplace_leaves_the_mesh_when_a_run_fails(cls: type, kind: str) -> None:
    thing, message = WRONG[kind]
    mesh = pv.Sphere()
    with pytest.raises(InvalidMeshError, match=message):
        getattr(mesh.vtksmooth, method_name(cls))(thing, inplace=True)
    assert mesh == pv.Sphere()


def test_a_failure_before_a_filter_reaches_the_one_that_is_asked() -> None:
    first, between, last = LaplacianSmoothing(), vtkPolyDataNormals(), SurfaceQuality()
    first.SetInputData(pv.Sphere())
    between.SetInputConnection(first.GetOutputPort())
    last.SetInputConnection(between.GetOutputPort())
    last.Update()
    first.SetInputData(IMAGE)
    for _ in range(2):
        with pytest.raises(InvalidMeshError, match="not ImageData"):
            last.Update()
        assert no_figures(first)
        assert no_figures(last)
    first.SetInputData(pv.Sphere())
    last.Update()
    assert last.summary["points"] == 842
    assert last.last_error is None


# -- figures -------------------------------------------------------------------------------------


@pytest.mark.parametrize("cls", FILTERS)
def test_a_failed_run_shows_no_figures_of_the_run_before(cls: type) -> None:
    algorithm = cls()
    good = [pv.Cube().triangulate().clean()] * len(cls.inputs)
    algorithm(*good)
    figures = algorithm.figures
    if issubclass(cls, SmoothingFilter):
        assert algorithm.report.mean_aspect_ratio[0] > 0.0
    algorithm(*good)
    assert algorithm.figures == figures, "what is up to date is not done again, and keeps its figures"
    with pytest.raises(InvalidMeshError):
        algorithm(pv.PolyData(), *good[1:])
    assert no_figures(algorithm)
    with pytest.raises(InvalidMeshError):
        algorithm("part.ply", *good[1:])
    assert no_figures(algorithm)


def test_results_stay_when_the_filter_runs_again() -> None:
    quality = SurfaceQuality()
    first = quality(pv.Sphere())
    second = quality(pv.Plane())
    with pytest.raises(InvalidMeshError):
        quality(IMAGE)
    assert (first.GetNumberOfPoints(), second.GetNumberOfPoints()) == (842, 121)
    again = LaplacianSmoothing(iterations=1)
    mesh = again(again(again(pv.Sphere())))
    expected = LaplacianSmoothing(iterations=3)(pv.Sphere())
    np.testing.assert_allclose(pv.wrap(mesh).points, pv.wrap(expected).points, atol=1e-7)


# -- interruption --------------------------------------------------------------------------------


def interrupt_after_start(algorithm: Any, number: signal.Signals = signal.SIGINT) -> threading.Event:
    """Send a signal from another thread as soon as a filter says that it runs."""
    started = threading.Event()
    algorithm.AddObserver("ProgressEvent", lambda *_: started.set())

    def send() -> None:
        started.wait(60)
        time.sleep(0.01)
        signal.raise_signal(number)

    threading.Thread(target=send).start()
    return started


def updated(algorithm: Any, mesh: Any) -> Any:
    algorithm.SetInputData(mesh)
    algorithm.Update()


@pytest.mark.parametrize("run", [LaplacianSmoothing.__call__, updated])
def test_ctrl_c_reaches_the_caller_and_the_filter_can_be_used_again(run: Any) -> None:
    smoothing = LaplacianSmoothing(iterations=100_000_000)
    mesh = pv.Sphere()
    interrupt_after_start(smoothing)
    with pytest.raises(KeyboardInterrupt):
        run(smoothing, mesh)
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    assert no_figures(smoothing)
    smoothing.iterations = 1
    assert smoothing(mesh).GetNumberOfPoints() == 842
    assert smoothing.last_error is None


def test_ctrl_c_in_an_observer_ends_the_run_and_not_the_process() -> None:
    smoothing = LaplacianSmoothing(iterations=100_000_000)
    smoothing.AddObserver("ProgressEvent", lambda *_: signal.raise_signal(signal.SIGINT))
    with pytest.raises(KeyboardInterrupt):
        smoothing(pv.Sphere())


def test_ctrl_c_with_a_progress_bar_leaves_the_mesh() -> None:
    mesh = pv.Sphere()
    timer = threading.Timer(0.3, lambda: signal.raise_signal(signal.SIGINT))
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        mesh.vtksmooth.laplacian_smoothing(iterations=100_000_000, progress_bar=True, inplace=True)
    assert mesh == pv.Sphere()


def test_ctrl_c_in_a_filter_upstream_reaches_the_caller() -> None:
    first, last = LaplacianSmoothing(iterations=100_000_000), SurfaceQuality()
    first.SetInputData(pv.Sphere())
    last.SetInputConnection(first.GetOutputPort())
    interrupt_after_start(first)
    with pytest.raises(KeyboardInterrupt):
        last.Update()
    first.iterations = 1
    last.Update()
    assert last.summary["points"] == 842


def test_ctrl_c_reaches_the_caller_of_vtks_own_filters(tmp_path: Path) -> None:
    smoothing, writer = LaplacianSmoothing(iterations=100_000_000), vtkXMLPolyDataWriter()
    smoothing.SetInputData(pv.Sphere())
    writer.SetInputConnection(smoothing.GetOutputPort())
    writer.SetFileName(str(tmp_path / "out.vtp"))
    interrupt_after_start(smoothing)

    def write() -> None:
        writer.Write()
        time.sleep(60)  # the interruption comes as soon as VTK has returned

    with pytest.raises(KeyboardInterrupt):
        write()
    assert not (tmp_path / "out.vtp").exists()


def test_other_handlers_may_end_the_run_too() -> None:
    def leave(*_: Any) -> None:
        raise SystemExit(3)

    before = signal.signal(signal.SIGTERM, leave)
    try:
        smoothing = LaplacianSmoothing(iterations=100_000_000)
        tag = smoothing.AddObserver("EndEvent", lambda *_: None)
        threading.Timer(0.3, lambda: signal.raise_signal(signal.SIGTERM)).start()
        with pytest.raises(SystemExit) as caught:
            smoothing(pv.Sphere(theta_resolution=100, phi_resolution=100))
        assert caught.value.code == 3
        smoothing.RemoveObserver(tag)
    finally:
        signal.signal(signal.SIGTERM, before)


def test_an_aborted_run_is_done_again_when_asked() -> None:
    smoothing, mesh = LaplacianSmoothing(iterations=3), vtkSphereSource()
    mesh.Update()
    tag = smoothing.AddObserver("ProgressEvent", lambda *_: smoothing.SetAbortExecute(1))
    with pytest.raises(Cancelled):
        smoothing(mesh.GetOutput())
    smoothing.RemoveObserver(tag)
    assert smoothing(mesh.GetOutput()).GetNumberOfPoints() == 50


AT_THE_END = """
import threading, time, sys
import pyvista as pv
from vtkmodules.vtkFiltersCore import vtkPolyDataNormals
from vtksmooth import Cancelled, LaplacianSmoothing

smoothing, normals, started = LaplacianSmoothing(iterations=10**8), vtkPolyDataNormals(), threading.Event()
smoothing.AddObserver("ProgressEvent", lambda *_: started.set())
smoothing.SetInputData(pv.Sphere())
normals.SetInputConnection(smoothing.GetOutputPort())

def run():
    while True:
        try:
            {call}
        except Cancelled as error:
            print(error, flush=True)

threading.Thread(target=run, daemon=True).start()
started.wait()
"""


@pytest.mark.parametrize("call", ["smoothing(pv.Sphere())", "smoothing.Update()", "normals.Update()"])
def test_a_filter_in_a_daemon_thread_is_stopped_when_the_program_ends(call: str) -> None:
    code = AT_THE_END.format(call=call)
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""


def test_a_filter_in_a_thread_that_python_waits_for_ends_by_itself() -> None:
    code = (
        "import threading, pyvista as pv; from vtksmooth import LaplacianSmoothing\n"
        "def run(): print(LaplacianSmoothing(iterations=200)(pv.Sphere()).GetNumberOfPoints())\n"
        "threading.Thread(target=run).start()"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stdout) == (0, "842\n")


def test_empty_polydata_is_what_a_failed_filter_holds() -> None:
    algorithm = LaplacianSmoothing()
    with pytest.raises(InvalidMeshError):
        algorithm(IMAGE)
    assert type(algorithm.GetOutput()) is vtkPolyData


@pytest.mark.parametrize(("away", "refused"), [(1e9, False), (1e11, False), (1e15, True)])
@pytest.mark.parametrize("in_space", [False, True])
def test_a_mesh_whose_coordinates_are_coarse_is_refused(away, refused, in_space):
    mesh = pv.Icosphere(nsub=2)
    mesh.points = np.asarray(mesh.points, float) + away
    space = pv.Cube(x_length=3.0, y_length=3.0, z_length=3.0).triangulate()
    space.points = np.asarray(space.points, float) + away
    smoothing = InstallationSpaceSmoothing(iterations=1) if in_space else LaplacianSmoothing(iterations=1)
    inputs = (mesh, space) if in_space else (mesh,)
    if refused:
        with pytest.raises(InvalidMeshError, match="so far from the origin that its coordinates"):
            smoothing(*inputs)
    else:
        smoothing(*inputs)
        assert smoothing.report.moved
