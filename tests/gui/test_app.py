"""Starting the application where it cannot start."""

import os
import subprocess
import sys

import pytest


def run(command, **environment):
    return subprocess.run(
        [sys.executable, "-c", command], capture_output=True, text=True, env={**os.environ, **environment}
    )


@pytest.mark.parametrize(
    "command",
    [
        "from vtksmooth.cli import main; sys.exit(main(['gui']))",
        "from vtksmooth_gui.app import main; sys.exit(main([]))",
    ],
)
def test_without_qt_one_sentence_says_how_to_install_it(command):
    done = run(f"import sys; sys.modules['PySide6'] = None; {command}")
    assert done.returncode == 1
    assert done.stderr.count("\n") == 1
    assert 'pip install "vtksmooth[gui]"' in done.stderr


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="elsewhere there always is a display")
def test_without_a_display_one_sentence_says_so():
    pytest.importorskip("PySide6")
    command = "import sys; from vtksmooth.cli import main; sys.exit(main(['gui', 'a.ply']))"
    done = run(command, DISPLAY="", WAYLAND_DISPLAY="")
    assert done.returncode == 1
    assert "there is no display" in done.stderr
    assert done.stderr.count("\n") == 1


def test_what_draws_charts_is_imported_by_whoever_draws_one():
    for package in ("PySide6", "pyvistaqt", "pyqtgraph"):
        pytest.importorskip(package)
    done = run(
        "import sys; from vtksmooth_gui import start; assert 'matplotlib.axes' not in sys.modules;"
        "import matplotlib.pyplot as plt; from pyvista import ChartMPL;"
        "plt.switch_backend('agg'); chart = ChartMPL(plt.figure());"
        "from matplotlib import pyplot; assert pyplot.figure is plt.figure"
    )
    assert done.returncode == 0, done.stderr
