"""Qt is set up, the window is opened; imports everything, so it is imported late."""

from __future__ import annotations

import gc
import os
import signal
import sys
from pathlib import Path

# VTK's window needs X11, which Wayland desktops have too.
if sys.platform.startswith("linux") and os.environ.get("DISPLAY"):
    os.environ.setdefault("QT_QPA_PLATFORM", "xcb")
os.environ.setdefault("QT_API", "pyside6")
os.environ.setdefault("PYQTGRAPH_QT_LIB", "PySide6")

from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QApplication

from .later import import_later

# PyVista imports it for charts, which are not drawn here: half a second, before the window opens.
import_later("matplotlib.pyplot")

from .controllers.application import Application  # noqa: E402
from .settings import Settings  # noqa: E402


def set_up() -> QApplication:
    """Return Qt's application, with the same look everywhere."""
    application = QApplication.instance()
    if not isinstance(application, QApplication):
        application = QApplication(sys.argv[:1])
    application.setApplicationName("vtksmooth")
    application.setStyle("Fusion")
    # A worker that does things in Python gives the window its turn after half a millisecond, not after five.
    sys.setswitchinterval(0.0005)
    return application


def open_window(settings: Settings) -> Application:
    """Return the application, with its window open."""
    application = Application(settings)
    application.window.show()
    # Hundreds of thousands of objects: looking through them for garbage would be felt, and there is none.
    gc.freeze()
    return application


def run(meshes: list[Path]) -> int:
    """Open the window with these meshes, and return when it is closed."""
    qt = set_up()
    application = open_window(Settings())
    application.sessions.offer_recovery(meshes)
    # Python looks at signals between its own instructions: give it some.
    signal.signal(signal.SIGINT, lambda *_: application.window.close())
    beat = QTimer()
    beat.timeout.connect(lambda: None)
    beat.start(200)
    return qt.exec()
