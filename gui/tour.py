"""A tour through the application, which makes the pictures of the documentation.

    python -m vtksmooth_gui.tour [--output FOLDER]

It does what a user does, in a real window (or under xvfb-run), on meshes that everybody has.
"""

from __future__ import annotations

import argparse
import contextlib
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyvista as pv
from PySide6.QtCore import SLOT, QEvent, QEventLoop, QPointF, Qt, QTimer
from PySide6.QtGui import QMouseEvent
from PySide6.QtWidgets import QApplication, QMessageBox

from vtksmooth import samples
from vtksmooth.filters import FILTERS, Filter, LaplacianSmoothing, NullSpaceSmoothing, TrapeziumDrawing
from vtksmooth.pages.pdf import figures

from . import start  # first of all: it chooses how Qt draws
from .controllers.application import Application
from .controllers.recipes import report_maker
from .controllers.sessions import WHAT_SAVE_DOES
from .model.layer import Role
from .model.measure import Kind, Measurement
from .settings import Settings
from .views import questions
from .views.questions import Answer

_SIZE = (1600, 950)


def pause(seconds: float) -> None:
    """Let the application run for a while, as it does for a user.

    In the event loop proper, which lets go of Python's lock while it waits: QTest.qWait keeps it, and the
    worker would get a turn only between two waits.
    """
    loop = QEventLoop()
    # By name: of `loop.quit` PySide 6.11 would keep the name each time.
    QTimer.singleShot(round(1000 * seconds), loop, SLOT("quit()"))  # type: ignore[call-overload]
    loop.exec()


class Tour:
    """A user who takes pictures."""

    def __init__(self, application: Application, output: Path) -> None:
        self.application, self.output = application, output
        self.window, self.document = application.window, application.document
        self.written: list[Path] = []

    def wait(self, seconds: float = 0.25) -> None:
        """Wait until all is done and drawn."""
        pause(seconds)
        deadline = time.monotonic() + 300
        while not self.application.jobs.idle and time.monotonic() < deadline:
            pause(0.02)
        pause(seconds)

    def do(self, *commands: str) -> None:
        """Choose commands from the menus."""
        for command in commands:
            self.window.action(command).trigger()
            self.wait()

    def open(self, *paths: Path) -> None:
        """Open files."""
        self.application.files.open_paths(paths)
        self.wait()

    def apply(self, cls: Any, **values: Any) -> None:
        """Apply a filter."""
        self.window.filters.choose(cls)
        self.window.filters.set_values(values)
        self.do("apply")

    def turn(self, azimuth: float, elevation: float, zoom: float = 1.0) -> None:
        """Turn the camera and come nearer."""
        camera = self.window.view.camera
        camera.Azimuth(azimuth)
        camera.Elevation(elevation)
        camera.OrthogonalizeViewUp()
        camera.Dolly(zoom)
        self.window.view.render_soon()

    def drag(self, *places: tuple[float, float]) -> None:
        """Press the mouse in the view, move it and let go; at one place only, click."""
        canvas = self.window.view.plotter.interactor
        left, none = Qt.MouseButton.LeftButton, Qt.MouseButton.NoButton
        pressed, moved, released = (
            QEvent.Type.MouseButtonPress, QEvent.Type.MouseMove, QEvent.Type.MouseButtonRelease,
        )  # fmt: skip
        actions = [(pressed, places[0]), *((moved, place) for place in places[1:]), (released, places[-1])]
        for kind, place in actions:
            at = QPointF(*place)
            buttons = none if kind == released else left
            event = QMouseEvent(
                kind, at, QPointF(canvas.mapToGlobal(at)), none if kind == moved else left, buttons,
                Qt.KeyboardModifier.NoModifier,
            )  # fmt: skip
            QApplication.sendEvent(canvas, event)
        self.wait()

    def picture(self, name: str, widget: Any = None, at_once: bool = False) -> None:
        """Take a picture of the window."""
        if not at_once:
            self.wait()
        path = self.output / f"app_{name}.png"
        (widget or self.window).grab().save(str(path))
        self.written.append(path)

    def cancel_question(self, name: str) -> None:
        """Take a picture of the question that is asked, and cancel it."""
        box = QApplication.activeModalWidget()
        assert isinstance(box, QMessageBox)
        self.picture(name, box, at_once=True)
        box.reject()


def scan(folder: Path) -> Path:
    """Write a marching-cubes surface of PyVista's voxel image of channels, and return its file."""
    image = pv.read(pv.examples.channelsfile).extract_subset([0, 60, 170, 230, 53, 72]).cells_to_points()
    image["facies"] = (image["facies"] > 0).astype(np.float32)
    image = image.gaussian_smooth(std_dev=2.0)
    image = image.extract_subset(image.extent, rate=(2, 2, 2))
    surface = image.contour([0.5], method="flying_edges").connectivity("largest")
    surface.clear_data()
    surface.save(folder / "channels.ply")
    return folder / "channels.ply"


def improve(tour: Tour, folder: Path) -> None:
    """Improve a marching-cubes surface."""
    tour.open(scan(folder))
    tour.turn(25, 0, 1.1)
    tour.window.filters.choose(TrapeziumDrawing)
    tour.window.filters.set_values({"max_deviation_fraction": 0.002})
    tour.do("preview")
    tour.do("apply", "split", "frame")
    tour.picture("split")
    tour.do("split", "swipe", "overlay_normal_deviation", "bands")
    tour.turn(0, 0, 1.6)
    tour.picture("swipe")
    tour.do("bands", "swipe", "overlay_aspect_ratio", "bad_faces", "dark", "next_worst")
    tour.picture("worst")
    tour.do("dark", "bad_faces", "frame", "cheat_sheet")
    tour.picture("keys", tour.application._dialogs["cheat_sheet"])
    tour.do("cheat_sheet", "papers_bins", "overlay_deviation", "frame")
    tour.apply(LaplacianSmoothing, scheme="taubin", iterations=20)
    tour.do("undo", "redo", "papers_bins", "close_layer")


def repeat(tour: Tour, folder: Path) -> None:
    """Edit the recipe, run it again, run it on many files, and report."""
    tour.open(scan(folder))
    tour.turn(25, 0, 1.1)
    tour.apply(NullSpaceSmoothing, iterations=10)
    tour.apply(TrapeziumDrawing)
    tour.apply(LaplacianSmoothing, gate="aspect")
    tour.window.show_panel("Recipe")
    steps = tour.window.recipe
    steps.list.item(2).setCheckState(Qt.CheckState.Unchecked)
    steps.list.setCurrentRow(1)
    steps.form.rows["iterations"].set_value(12)
    tour.picture("recipe")
    tour.do("run_recipe")
    layer = tour.document.active
    assert layer is not None
    page = report_maker(layer)(Filter.__call__)
    tour.written.append(tour.output / "app_report.png")
    figures(page)[0].savefig(tour.written[-1], dpi=110)
    many = folder / "parts"
    many.mkdir()
    for number in range(12):
        part = samples.channel()[0].rotate_z(30.0 * number)
        part.save(many / f"part_{number + 1:02}.stl")
    (many / "part_05.stl").write_text("no mesh")
    with contextlib.chdir(folder):  # for short names in the picture
        tour.do("batch")
        dialog = tour.application.batches.dialog
        dialog.add_sources([many.name])
        dialog.output.setText("results")
        dialog.start.click()
        while len(tour.application.batches.outcomes) < 8:
            pause(0.01)
        tour.picture("batch", dialog, at_once=True)
        tour.wait()
    dialog.close()
    tour.window.show_panel("Numbers")
    tour.do("close_layer")


def mark(tour: Tour, folder: Path) -> None:
    """Say what smoothing may do where."""
    pv.read(pv.examples.nutfile).clean().subdivide(2).save(folder / "nut.ply")
    tour.open(folder / "nut.ply")
    tour.do("overlay_none", "frame")
    tour.turn(20, 20, 1.1)
    canvas = tour.window.view.plotter.interactor
    width, height = canvas.width(), canvas.height()
    tour.do("region_patch")
    tour.drag((0.62 * width, 0.62 * height))
    tour.do("region_brush", "region_larger")
    tour.drag(*((x * width, (0.3 - 0.6 * (x - 0.5) ** 2) * height) for x in np.linspace(0.4, 0.6, 20)))
    tour.do("region_edges")
    for x, y in ((0.56, 0.86), (0.66, 0.72), (0.735, 0.66)):
        tour.drag((x * width, y * height))
    tour.picture("regions")
    tour.do("region_soften", "region_camera")
    tour.apply(LaplacianSmoothing, iterations=5, features="hold")
    tour.window.show_panel("Layers and filter")
    tour.do("close_layer")


def contain(tour: Tour, folder: Path) -> None:
    """Smooth a skin of cells inside its installation space."""
    cls = next((cls for cls in FILTERS if cls.__name__ == "InstallationSpaceSmoothing"), None)
    skin, space = samples.channel()
    skin.save(folder / "skin.vtp")
    space.save(folder / "space.vtp")
    tour.open(folder / "skin.vtp", folder / "space.vtp")
    tour.application.document.set_role(tour.document.layers[-1], Role.SPACE)
    tour.do("overlay_none", "frame")
    if cls is not None:
        tour.apply(cls)
        tour.do("overlay_signed_distance", "frame")
        tour.turn(0, 0, 1.3)
        tour.picture("contained")
    tour.do("close_layer", "close_layer")


def measure(tour: Tour, folder: Path) -> None:
    """Measure a nut, cut it, compare it with a coarser one, and save everything."""
    nut = pv.read(pv.examples.nutfile).clean()
    nut.points -= nut.points.mean(axis=0)
    nut.save(folder / "nut.ply")
    tour.open(folder / "nut.ply")
    tour.do("unit_mm", "overlay_none")
    tour.apply(LaplacianSmoothing, iterations=4)
    layer, measuring = tour.document.active, tour.application.measuring
    assert layer is not None
    assert layer.state is not None
    places = layer.state.points
    across = np.argmax(places[:, 0]), np.argmin(places[:, 0])
    tour.document.measure(Measurement(Kind.DISTANCE, layer, np.array(across), layer.state.n_points))
    reach = np.linalg.norm(layer.opened.points[:, ::2], axis=1)
    hole = np.flatnonzero(reach < 1.05 * reach.min())
    tour.document.measure(Measurement(Kind.RADIUS, layer, hole, layer.state.n_points))
    tour.window.view.look_from((0.6, -1.0, 0.5), (0, 0, 1))
    measuring.cut_across((0.0, 1.0, 0.0))
    tour.window.show_panel("Measurements")
    docks = [tour.window.docks["Cross-section"]]
    tour.window.resizeDocks(docks, [380], Qt.Orientation.Vertical)
    tour.wait()
    tour.window.section.frame()
    tour.picture("measuring")
    tour.window.resizeDocks(docks, [190], Qt.Orientation.Vertical)
    tour.do("section")
    nut.decimate(0.7).save(folder / "coarse.ply")
    tour.open(folder / "coarse.ply")
    tour.document.activate(layer)
    tour.document.set_visible(tour.document.layers[-1], False)
    tour.do("compare_layers")
    dialog = tour.application.comparing.dialog
    assert dialog is not None
    dialog.accept()
    tour.window.show_panel("Histogram")
    tour.picture("comparing")
    tour.application.sessions.write(folder / "nut.vtksmooth")
    tour.wait()
    QTimer.singleShot(500, lambda: tour.cancel_question("unsaved"))
    questions.ask_unsaved(tour.window, ["nut"], WHAT_SAVE_DOES)


STOPS: tuple[Callable[[Tour, Path], None], ...] = (improve, mark, repeat, contain, measure)


def run(output: Path) -> list[Path]:
    """Make all pictures and return their files."""
    start.set_up()
    output.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        application = Application(Settings(Path(folder) / "settings.ini"))
        application.sessions.ask_unsaved = lambda names, save: Answer.DISCARD  # type: ignore[method-assign]
        application.window.resize(*_SIZE)
        application.window.show()
        tour = Tour(application, output)
        tour.wait(1.0)
        for stop in STOPS:
            stop(tour, Path(folder))
        application.window.close()
    return tour.written


def main() -> None:
    """Run the tour."""
    parser = argparse.ArgumentParser(
        prog="vtksmooth_gui.tour", description="Make the documentation's pictures."
    )
    parser.add_argument("--output", type=Path, default=Path("docs/pictures"), help="folder for the pictures")
    for path in run(parser.parse_args().output.resolve()):
        print(path)


if __name__ == "__main__":
    main()
