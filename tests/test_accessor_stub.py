"""accessor.pyi: what type checkers and editors know of ``mesh.vtksmooth`` is what there is."""

import ast
import inspect
import os
import subprocess
import sys
from pathlib import Path

import pytest

from vtksmooth import accessor_stub
from vtksmooth.accessor import VtksmoothAccessor, method_name
from vtksmooth.filters import FILTERS

#: A user's script. Every line that is wrong says which error it wants: mypy complains where there is none.
SCRIPT = """
from typing import assert_type

import pyvista as pv

from vtksmooth.accessor import VtksmoothAccessor

mesh = pv.Sphere()
smooth: VtksmoothAccessor = mesh.vtksmooth
assert_type(VtksmoothAccessor(mesh), VtksmoothAccessor)

better = smooth.trapezium_drawing(iterations=3, fixed=None, max_deviation_fraction=0.01, progress_bar=True)
assert_type(better, pv.PolyData)
assert_type(smooth.laplacian_smoothing(scheme="taubin", inplace=True), pv.PolyData)
assert_type(smooth.feature_detection(ridge_angle="auto", corner_angle=40), pv.PolyData)
assert_type(smooth.feature_detection(return_lines=False), pv.PolyData)
assert_type(smooth.feature_detection(return_lines=True), tuple[pv.PolyData, pv.PolyData])
assert_type(smooth.surface_comparison(mesh), pv.PolyData)
assert_type(smooth.installation_space_smoothing(installation=mesh, flow="Flow"), pv.PolyData)
smooth.trapezium_drawing(output_points_precision="double")
smooth.trapezium_drawing(output_points_precision=1)

smooth.trapezium_drawing(5)  # type: ignore[call-arg, arg-type]
smooth.trapezium_drawing(iterations="5")  # type: ignore[arg-type]
smooth.trapezium_drawing(iterations=None)  # type: ignore[arg-type]
smooth.trapezium_drawing(iteration=5)  # type: ignore[call-arg]
smooth.trapezium_drawing(gate="aspects")  # type: ignore[arg-type]
smooth.surface_comparison()  # type: ignore[call-arg]
smooth.surface_comparison("before.ply")  # type: ignore[arg-type]
smooth.feature_detection(ridge_angle="automatic")  # type: ignore[call-overload]
smooth.smooth()  # type: ignore[attr-defined]
"""

CONFIGURATION = """
[mypy]
strict = true
warn_unused_ignores = true
[mypy-vtkmodules.*,numba.*]
follow_imports = skip
"""


def mypy(*arguments, **more):
    # Where the installation is editable, mypy must be told where the package is.
    environment = {**os.environ, "PYTHONPATH": str(Path(accessor_stub.PATH).parents[1])}
    command = [sys.executable, "-m", *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, env=environment, **more)
    assert done.returncode == 0, done.stdout + done.stderr


def test_it_is_up_to_date():
    assert accessor_stub.PATH.read_text(encoding="utf-8") == accessor_stub.stub(), (
        "run: python -m vtksmooth.accessor_stub"
    )


@pytest.mark.parametrize("cls", FILTERS)
def test_editors_show_what_help_shows(cls):
    name = method_name(cls)
    definitions = [
        node for node in ast.walk(ast.parse(accessor_stub.stub()))
        if isinstance(node, ast.FunctionDef) and node.name == name
    ]  # fmt: skip
    assert len(definitions) == 2 ** (len(cls.outputs) - 1)
    for node in definitions:
        assert ast.get_docstring(node) == inspect.getdoc(getattr(VtksmoothAccessor, name))


def test_mypy_reads_a_users_script(tmp_path):
    (tmp_path / "script.py").write_text(SCRIPT, encoding="utf-8")
    (tmp_path / "mypy.ini").write_text(CONFIGURATION, encoding="utf-8")
    mypy("mypy", "script.py", cwd=tmp_path)


def test_the_stub_is_true_of_the_module():
    mypy("mypy.stubtest", "vtksmooth.accessor")


def test_the_module_itself_is_checked_too():
    # Where there is a stub, mypy does not look at the module unless it is named.
    mypy("mypy", "vtksmooth/accessor.py", cwd=Path(accessor_stub.PATH).parents[1])
