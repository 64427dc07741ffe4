"""docs/switching.md: the names and defaults in its tables are real, and its example runs."""

import inspect
import re
from pathlib import Path

import numpy as np
import pytest
import pyvista as pv
from vtkmodules import vtkFiltersCore

import vtksmooth
from vtksmooth import LaplacianSmoothing, SurfaceQuality
from vtksmooth.cli import main
from vtksmooth.errors import ParameterError
from vtksmooth.other_names import OTHER_NAMES, advice, snake

PAGE = (Path(vtksmooth.__file__).parents[1] / "docs" / "switching.md").read_text(encoding="utf-8")
#: Rows of the tables: VTK's filter, its method in PyVista or "", and the cells.
ROWS = [
    (filter, method, [cell.strip() for cell in line.strip("|").split("|")])
    for filter, method, text in re.findall(
        r"^## (vtk\w+)(?:, `mesh\.(\w+)\(\)`)?\n(.*?)(?=^## )", PAGE, re.MULTILINE | re.DOTALL
    )
    for line in re.findall(r"^\|.*`.*$", text, re.MULTILINE)
]


def names_of(cell):
    """Names in code, with the value set and the default where they are said."""
    return re.findall(r"`(\w+)(?:=([^`]+))?`(?: \(`?([^`)]+)`?\))?", cell)


def test_the_tables_are_read():
    assert len({filter for filter, *_ in ROWS}) == 3
    assert len({method for _, method, _ in ROWS}) == 3
    assert len(ROWS) > 15


@pytest.mark.parametrize(("filter", "method", "cells"), ROWS)
def test_names_and_defaults(filter, method, cells):
    theirs = getattr(vtkFiltersCore, filter)()
    for name, _, default in names_of(cells[0]):
        if name == "SmoothingConstraints":
            assert LaplacianSmoothing().max_displacement == name
            continue
        assert hasattr(theirs, f"Set{name}") or hasattr(theirs, f"Set{name}Data")
        if re.fullmatch(r"[\d.]+", default):
            assert getattr(theirs, f"Get{name}")() == float(default)
    if method:
        keywords = inspect.signature(getattr(pv.PolyData, method)).parameters
        for name, *_ in names_of(cells[1]):
            assert name in keywords
    for name, value, default in names_of(cells[2 if method else 1]):
        parameter = LaplacianSmoothing.parameters()[name]
        if value:
            parameter.check(True if value == "True" else value.strip('"'))
        expected = {"off": (None, False)}.get(default, (default.strip('"'),))
        assert str(parameter.default) in map(str, expected)


@pytest.mark.parametrize(("filter", "method", "cells"), ROWS)
def test_errors_name_what_the_tables_name(filter, method, cells):
    known = LaplacianSmoothing.parameters()
    theirs = {name for cell in cells[: 2 if method else 1] for name, *_ in names_of(cell)}
    ours = {name for name, *_ in names_of(cells[2 if method else 1])}
    for name in theirs - {"SmoothingConstraints", "OutputPointsPrecision"}:
        if snake(name) in LaplacianSmoothing.optional_inputs:
            assert f"*{snake(name)}*" in cells[2]  # an input here as well
        elif snake(name) in known:
            assert snake(name) in ours
        else:
            assert OTHER_NAMES[snake(name)].name in (ours or {"", "max_displacement"})
            with pytest.raises(ParameterError, match=re.escape(f"{name!r}; {advice(name, known)}.")):
                LaplacianSmoothing(**{name: 1})


def test_every_other_name_is_in_the_tables():
    words = {snake(name) for _, _, cells in ROWS for cell in cells for name, *_ in names_of(cell)}
    assert words >= set(OTHER_NAMES)
    assert {ours.name for ours in OTHER_NAMES.values()} <= {"", *LaplacianSmoothing.parameters()}


def test_methods_and_attributes_by_other_names():
    smoothing = LaplacianSmoothing()
    with pytest.raises(AttributeError, match="SetNumberOfIterations'; use SetIterations"):
        smoothing.SetNumberOfIterations(20)
    with pytest.raises(AttributeError, match="GetFeatureAngle'; use GetRidgeAngle"):
        smoothing.GetFeatureAngle()
    with pytest.raises(AttributeError, match="BoundarySmoothingOn'; use SetBoundary: 'sliding'"):
        smoothing.BoundarySmoothingOn()
    with pytest.raises(AttributeError, match="no parameter 'n_iter'; use iterations"):
        smoothing.n_iter = 20
    assert not hasattr(smoothing, "SetSomethingElse")
    smoothing.label = "kept"  # as on every object of VTK
    assert smoothing.label == "kept"
    with pytest.raises(ParameterError, match="'n_iter'; it has: "):
        SurfaceQuality(n_iter=20)  # which has nothing of the kind


@pytest.mark.parametrize("option", ["--n-iter", "--NumberOfIterations=3", "--number-of-iterations"])
def test_options_by_other_names(option, capsys):
    assert main(["laplacian", "in.ply", "out.ply", option, "3"]) == 2
    assert f"there is no option {option.partition('=')[0]}; use --iterations;" in capsys.readouterr().err


def test_lower_pass_bands_smooth_more():
    sphere = pv.Icosphere(nsub=3)
    sphere.points *= 1 + 0.01 * np.random.default_rng(0).standard_normal((sphere.n_points, 1))
    for smooth in (
        lambda band: sphere.smooth_taubin(n_iter=50, pass_band=band),
        lambda band: sphere.vtksmooth.laplacian_smoothing(iterations=50, scheme="taubin", pass_band=band),
    ):
        rough = [np.linalg.norm(smooth(band).points, axis=1).std() for band in (0.1, 0.3, 0.5)]
        assert rough == sorted(rough)


def test_the_example_runs():
    (example,) = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    result = {}
    exec(example, result)
    assert result["better"].n_points == result["ours"].n_points == result["theirs"].n_points
