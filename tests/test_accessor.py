"""``mesh.vtksmooth``: the same results as the filters, found without an import."""

import inspect
import subprocess
import sys

import numpy as np
import pytest
import pyvista as pv

from vtksmooth.accessor import method_name
from vtksmooth.errors import InvalidMeshError, ParameterError
from vtksmooth.filters import FILTERS, SmoothingFilter, TrapeziumDrawing


@pytest.fixture
def ant() -> pv.PolyData:
    return pv.read(pv.examples.antfile)


def test_found_without_an_import() -> None:
    code = "import pyvista as pv; print(pv.Sphere().vtksmooth.laplacian_smoothing(iterations=1).n_points)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == str(pv.Sphere().n_points)


@pytest.mark.parametrize("cls", FILTERS)
def test_every_filter_has_a_method_with_its_parameters(cls: type, ant: pv.PolyData) -> None:
    signature = inspect.signature(getattr(ant.vtksmooth, method_name(cls)))
    further = [f"return_{output}" for output in cls.outputs[1:]]
    names = [*cls.every_input()[1:], *cls.parameters(), *further, "inplace", "progress_bar"]
    assert list(signature.parameters) == names


@pytest.mark.parametrize(
    "cls", [cls for cls in FILTERS if issubclass(cls, SmoothingFilter) and len(cls.inputs) == 1]
)
def test_matches_the_filter_and_leaves_the_source(cls: type, ant: pv.PolyData) -> None:
    before = ant.points.copy()
    result = getattr(ant.vtksmooth, method_name(cls))(iterations=3)
    assert isinstance(result, pv.PolyData)
    np.testing.assert_array_equal(result.points, pv.wrap(cls(iterations=3)(ant)).points)
    np.testing.assert_array_equal(ant.points, before)
    assert not np.array_equal(result.points, before)


def test_inplace_changes_and_returns_the_mesh(ant: pv.PolyData) -> None:
    expected = ant.vtksmooth.trapezium_drawing(iterations=2).points
    result = ant.vtksmooth.trapezium_drawing(iterations=2, inplace=True)
    assert result is ant
    np.testing.assert_array_equal(ant.points, expected)


def test_comparison_takes_the_original(ant: pv.PolyData) -> None:
    result = ant.vtksmooth.trapezium_drawing()
    for compared in (
        result.vtksmooth.surface_comparison(ant),
        result.vtksmooth.surface_comparison(original=ant),
    ):
        assert {"NormalDeviation", "DihedralChange", "Displacement", "Deviation"} <= set(compared.point_data)
    with pytest.raises(TypeError, match="original"):
        result.vtksmooth.surface_comparison()


def test_quality(ant: pv.PolyData) -> None:
    k = ant.vtksmooth.surface_quality()["AspectRatio"]
    assert len(k) == ant.n_cells
    assert k.min() > 0


def test_errors_are_exceptions(ant: pv.PolyData) -> None:
    with pytest.raises(ParameterError, match="iterations must be 0 or more, not -1"):
        ant.vtksmooth.trapezium_drawing(iterations=-1)
    with pytest.raises(InvalidMeshError, match="no points"):
        pv.PolyData().vtksmooth.trapezium_drawing()


def test_progress_bar(ant: pv.PolyData, capsys: pytest.CaptureFixture[str]) -> None:
    ant.vtksmooth.trapezium_drawing(progress_bar=True)
    assert TrapeziumDrawing.__name__ in capsys.readouterr().err


def test_fixed_takes_a_mask_or_numbers(ant: pv.PolyData) -> None:
    mask = ant.points[:, 2] > np.median(ant.points[:, 2])
    named = ant.copy()
    named["mine"] = mask
    expected = named.vtksmooth.laplacian_smoothing(fixed="mine").points
    assert not np.array_equal(expected, ant.vtksmooth.laplacian_smoothing().points)
    for fixed in (mask, mask.tolist(), np.flatnonzero(mask), np.flatnonzero(mask).tolist()):
        np.testing.assert_array_equal(ant.vtksmooth.laplacian_smoothing(fixed=fixed).points, expected)
    free = ant.vtksmooth.laplacian_smoothing(fixed=[]).points
    np.testing.assert_array_equal(free, ant.vtksmooth.laplacian_smoothing().points)


def test_fixed_numbers_points_that_coincide_with_others() -> None:
    soup = pv.Icosphere(nsub=2).extract_surface(algorithm="geometry").separate_cells()
    soup = soup.extract_surface(algorithm="dataset_surface")
    fixed = [0, 7]
    moved = (soup.vtksmooth.laplacian_smoothing(fixed=fixed).points != soup.points).any(axis=1)
    same = (soup.points[:, None] == soup.points[fixed]).all(axis=2).any(axis=1)
    np.testing.assert_array_equal(moved, ~same)


@pytest.mark.parametrize(
    ("fixed", "message"),
    [
        ([True, False], "the mask has 2 values; the mesh has 486 points"),
        ([10**6], "there is no point 1000000"),
        ([-1], "numbers of points from 0 on"),
        ([0, 1, 1, 0], r"astype\(bool\)"),
        ([0.5], "fixed must be the name"),
    ],
)
def test_wrong_selections_are_refused(fixed: list[object], message: str, ant: pv.PolyData) -> None:
    with pytest.raises(ParameterError, match=message):
        ant.vtksmooth.laplacian_smoothing(fixed=fixed)


def test_grids_give_their_surface() -> None:
    grid = pv.ImageData(dimensions=(4, 4, 4)).cast_to_unstructured_grid()
    mask = grid.points[:, 2] < 1.5
    with pytest.warns(UserWarning, match="The surface of the UnstructuredGrid is taken: 56 of 64 points"):
        smooth = grid.vtksmooth.laplacian_smoothing(fixed=mask)
    moved = (smooth.points != grid.points[smooth["vtkOriginalPointIds"]]).any(axis=1)
    assert moved.any()
    np.testing.assert_array_equal(moved & (smooth.points[:, 2] < 1.5), False)
    with pytest.raises(TypeError, match="cannot change a UnstructuredGrid in place"):
        grid.vtksmooth.laplacian_smoothing(inplace=True)


def test_blocks_give_blocks(ant: pv.PolyData) -> None:
    blocks = pv.MultiBlock({"ant": ant, "none": None})
    smooth = blocks.vtksmooth.laplacian_smoothing(iterations=3)
    assert isinstance(smooth, pv.MultiBlock)
    assert smooth.keys() == ["ant", "none"]
    assert isinstance(smooth["ant"], pv.PolyData)
    np.testing.assert_array_equal(
        smooth["ant"].points, ant.vtksmooth.laplacian_smoothing(iterations=3).points
    )
    with pytest.raises(ParameterError, match="no parameter 'n_iter'; use iterations"):
        blocks.vtksmooth.laplacian_smoothing(n_iter=3)
