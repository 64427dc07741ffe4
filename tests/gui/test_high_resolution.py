"""Screens of high resolution: points of the window are several pixels, a whole number of them or not."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

#: What has to do with places and sizes in the view.
TESTS = "probe or swipe_line or screenshot or dragging_in_the_plot or thresholds_are_dragged"


@pytest.mark.parametrize("factor", ["1.5", "2"])
def test_places_and_sizes_are_right_on_screens_of_high_resolution(display, factor):
    file = Path(__file__).with_name("test_window.py")
    # Qt reads the factor when its application is made: it takes a process of its own.
    done = subprocess.run(
        [sys.executable, "-m", "pytest", str(file), "-k", TESTS, "-p", "no:cacheprovider"],
        capture_output=True, text=True, env={**os.environ, "QT_SCALE_FACTOR": factor},
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    assert "skipped" not in done.stdout
