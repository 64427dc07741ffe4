"""Windows for tests: real ones, on a display; without Qt or a display the tests on them are skipped."""

import gc
import os
import sys
import weakref
from pathlib import Path

import pytest

#: Where set, a missing window is a failure: continuous integration must not skip these tests.
NEEDED = bool(os.environ.get("VTKSMOOTH_NEED_WINDOWS"))


def missing():
    """Return why no window can be opened here, or ''."""
    for package in ("PySide6", "pyvistaqt", "pyqtgraph", "pytestqt"):
        try:
            __import__(package)
        except ImportError:
            return f"{package} is not installed; install vtksmooth[dev]"
    if sys.platform.startswith("linux") and not os.environ.get("DISPLAY"):
        return "there is no display; run the tests with xvfb-run"
    return ""


class User:
    """What a user does with the application, and what is seen."""

    def __init__(self, application, qtbot):
        self.application, self.qtbot = application, qtbot
        self.window, self.document = application.window, application.document
        self.display, self.jobs = application.display, application.jobs

    def wait(self, condition=lambda: True, timeout=200_000):
        """Wait until everything asked for has been done and shown; the first time kernels are compiled."""
        self.qtbot.waitUntil(lambda: self.jobs.idle and condition(), timeout=timeout)
        self.qtbot.wait(1)

    def drop(self, *paths):
        """Drop files on the middle of the window: on what takes them there."""
        from PySide6.QtCore import QMimeData, QPoint, QPointF, Qt, QUrl
        from PySide6.QtGui import QDragEnterEvent, QDropEvent
        from PySide6.QtWidgets import QApplication

        target = self.window.childAt(self.window.rect().center())
        while not target.acceptDrops():
            target = target.parentWidget()
        data = QMimeData()
        data.setUrls([QUrl.fromLocalFile(str(path)) for path in paths])
        enter = QDragEnterEvent(
            QPoint(20, 20), Qt.DropAction.CopyAction, data, Qt.MouseButton.LeftButton,
            Qt.KeyboardModifier.NoModifier,
        )  # fmt: skip
        QApplication.sendEvent(target, enter)
        assert enter.isAccepted()
        drop = QDropEvent(
            QPointF(20, 20), Qt.DropAction.CopyAction, data, Qt.MouseButton.LeftButton,
            Qt.KeyboardModifier.NoModifier,
        )  # fmt: skip
        QApplication.sendEvent(target, drop)
        self.wait()

    def press(self, key, modifier=None):
        """Press a key in the window."""
        from PySide6.QtCore import Qt

        with self.qtbot.waitActive(self.window):
            self.window.activateWindow()
        self.qtbot.keyClick(self.window, key, modifier or Qt.KeyboardModifier.NoModifier)

    def do(self, command):
        """Choose a command from the menu, and wait until it is done."""
        action = self.window.action(command)
        assert action.isEnabled(), command
        action.trigger()
        self.wait()

    def choose(self, cls, **values):
        """Choose a filter and its parameters."""
        self.window.filters.choose(cls)
        self.window.filters.set_values(values)

    def apply(self, cls, **values):
        """Apply a filter."""
        self.choose(cls, **values)
        self.do("apply")

    @property
    def said(self):
        """The notification that is shown."""
        return self.window.notification.text

    @property
    def mesh(self):
        """The active mesh."""
        return self.document.active.state.mesh


@pytest.fixture
def settings_file(tmp_path):
    return tmp_path / "settings.ini"


@pytest.fixture
def display():
    """Where no window can be opened: skips the test, or fails it."""
    reason = missing()
    if reason and NEEDED:
        pytest.fail(f"Windows are needed here, and {reason}.")
    if reason:
        pytest.skip(reason)


@pytest.fixture
def open_window(request, display, settings_file):
    """A function that opens the application; at the end nothing is left of its windows."""
    qtbot = request.getfixturevalue("qtbot")
    from PySide6.QtCore import QCoreApplication, QEvent

    from vtksmooth_gui import start
    from vtksmooth_gui.controllers.application import Application
    from vtksmooth_gui.settings import Settings
    from vtksmooth_gui.views.questions import Answer

    start.set_up()
    if not gc.get_freeze_count():
        gc.freeze()  # what has been imported is no garbage: collecting takes milliseconds
    opened = []

    def open_application(*paths):
        application = Application(Settings(settings_file))
        application.window.resize(1200, 800)
        application.sessions.ask_unsaved = lambda names, save: Answer.DISCARD
        user = User(application, qtbot)
        opened.append(user)
        with qtbot.waitExposed(application.window):
            application.window.show()
        if paths:
            application.files.open_paths(paths)
        user.wait()
        return user

    yield open_application
    left = [weakref.ref(part) for user in opened for part in (user.application, user.window, user.document)]
    for user in opened:
        user.window.close()
        user.jobs.close()
        user.window.deleteLater()
        vars(user).clear()  # pytest keeps it
    QCoreApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete.value)

    def gone():
        gc.collect()
        return not any(part() is not None for part in left)

    if not request.session.testsfailed:  # reports of failures keep what they show
        qtbot.waitUntil(gone)
    gc.enable()  # the windows collected in Python's place


@pytest.fixture
def user(open_window):
    return open_window()


@pytest.fixture
def ant():
    import pyvista as pv

    return Path(pv.examples.antfile)


@pytest.fixture
def big(tmp_path):
    """A noisy sphere of 20,000 faces: 100,000 iterations on it run long enough to be cancelled."""
    import numpy as np
    import pyvista as pv

    from vtksmooth.files import write_surface

    sphere = pv.Sphere(theta_resolution=100, phi_resolution=102)
    noise = np.random.default_rng(0).normal(scale=0.002, size=sphere.points.shape)
    sphere.points += noise.astype(np.float32)
    write_surface(sphere, tmp_path / "big.ply")
    return tmp_path / "big.ply"
