"""Makes the tests' own modules (meshes, reference) importable, and runs reproducible."""

import sys
from pathlib import Path

import pytest
from hypothesis import settings

sys.path.insert(0, str(Path(__file__).parent))

# The first example of a test may wait for the compiler; what is found must be found again.
settings.register_profile("reproducible", deadline=None, derandomize=True, database=None)
settings.load_profile("reproducible")

#: Files whose tests share a fixture that takes seconds.
_TOGETHER = (
    "test_demo.py",
    "test_examples.py",
    "test_installation_space_smoothing.py",
    "test_pages.py",
    "test_paraview.py",
)

#: Run by ParaView's Python, not by pytest.
collect_ignore = ["paraview_session.py"]


@pytest.hookimpl(tryfirst=True)  # before xdist reads the marks
def pytest_collection_modifyitems(items):
    """Give tests that share something to one process: windows the keyboard, others a costly fixture."""
    for item in items:
        if item.path.parent.name == "gui":
            item.add_marker(pytest.mark.xdist_group("gui"))
        elif item.path.name in _TOGETHER:
            item.add_marker(pytest.mark.xdist_group(item.path.name))
