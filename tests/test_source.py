"""Points kept on another surface: against its formula, its ridges and corners, VTK's filter."""

import numpy as np
import pytest
import pyvista as pv
from vtkmodules.vtkFiltersCore import vtkImplicitPolyDataDistance

from vtksmooth import (
    BackToSurfaceSmoothing,
    InvalidMeshError,
    LaplacianSmoothing,
    ParameterError,
    TrapeziumDrawing,
)
from vtksmooth.cli import main


def rough(mesh, size, seed=1):
    result = pv.PolyData(mesh.points.astype(float), mesh.faces)
    result.points += size * np.random.default_rng(seed).normal(size=result.points.shape)
    return result


def distances(mesh, source):
    distance = vtkImplicitPolyDataDistance()
    distance.SetInput(source)
    return np.abs([distance.EvaluateFunction(point) for point in mesh.points])


def double(mesh):
    return pv.PolyData(mesh.points.astype(float), mesh.faces)


@pytest.mark.parametrize("make", [TrapeziumDrawing, LaplacianSmoothing, BackToSurfaceSmoothing])
def test_points_are_put_and_kept_on_the_source(make):
    source = double(pv.Icosphere(nsub=4))
    mesh = rough(pv.Icosphere(nsub=3), 0.02)
    smoothing = make(iterations=15)
    smooth = pv.wrap(smoothing(mesh, None, source))
    before, after = smoothing.report.source_deviation
    assert before == pytest.approx(distances(mesh, source).max(), rel=1e-6)
    # A gate may refuse the way to the source; those that have moved are on it.
    moved = (smooth.points != mesh.points).any(axis=1)
    assert distances(smooth, source)[moved].max() < 1e-6  # VTK's own precision
    assert moved.sum() > 0.9 * mesh.n_points
    if make is LaplacianSmoothing:
        assert after < 1e-14
        # On a finer sphere the result is round: no farther off than its chords.
        radii = np.linalg.norm(smooth.points, axis=1)
        assert radii.max() <= 1.0 + 1e-12
        assert radii.min() > np.linalg.norm(source.cell_centers().points, axis=1).min() - 1e-12


def test_ridges_and_corners_of_the_source_stay():
    box = double(pv.Box(level=7).triangulate().clean())
    noise = rough(box, 0.01)
    smoothing = LaplacianSmoothing(iterations=30)
    smooth = pv.wrap(smoothing(noise, None, double(pv.Box().triangulate().clean())))
    at = np.isclose(np.abs(box.points), 1.0)
    # Points of edges and corners are on them, to the last digits, whatever the noise; others on the faces.
    assert smoothing.report.on_source == tuple(int((at.sum(axis=1) == k).sum()) for k in (1, 2, 3))
    np.testing.assert_allclose(smooth.points[at], box.points[at], atol=1e-14)
    assert smooth.volume == pytest.approx(8.0, rel=1e-12)
    plain = pv.wrap(LaplacianSmoothing(iterations=30)(noise))
    assert plain.volume < 7.5
    assert "distance from the source" in str(smoothing.report)


def test_a_soup_of_facets_far_off_is_a_source_too():
    far = np.array([1e5, -3e5, 2e5])
    soup = pv.Box().triangulate().separate_cells().extract_surface(algorithm="dataset_surface")
    source, mesh = double(soup), rough(pv.Box(level=7).triangulate().clean(), 0.02)
    source.points += far
    mesh.points += far
    smoothing = LaplacianSmoothing(iterations=10, output_points_precision="double")
    smooth = pv.wrap(smoothing(mesh, None, source))
    assert smoothing.report.on_source[2] == 8
    assert np.abs(np.abs(smooth.points - far).max(axis=1) - 1.0).max() < 1e-9


def test_no_farther_than_vtk_with_its_source():
    from vtkmodules.vtkFiltersCore import vtkSmoothPolyDataFilter

    source, mesh = double(pv.Icosphere(nsub=4)), rough(pv.Icosphere(nsub=3), 0.02)
    vtk = vtkSmoothPolyDataFilter()
    vtk.SetInputData(mesh)
    vtk.SetSourceData(source)
    vtk.SetNumberOfIterations(30)
    vtk.SetOutputPointsPrecision(1)
    vtk.Update()
    ours = pv.wrap(LaplacianSmoothing(iterations=30)(mesh, None, source))
    assert distances(ours, source).max() <= distances(pv.wrap(vtk.GetOutput()), source).max() + 1e-9


def test_fixed_points_and_boundaries_stay():
    sheet = pv.Plane(i_resolution=9, j_resolution=9).triangulate()
    source = double(pv.Plane(i_resolution=40, j_resolution=40).triangulate())
    source.points[:, 2] = 0.1 * np.cos(4 * source.points[:, 0])
    mesh = rough(sheet, 0.0)
    smooth = pv.wrap(LaplacianSmoothing(iterations=5, fixed=[50])(mesh, None, source))
    rim = np.isclose(np.abs(mesh.points[:, :2]).max(axis=1), 0.5)
    rim[50] = True
    np.testing.assert_array_equal(smooth.points[rim], mesh.points[rim])
    assert distances(smooth, source)[~rim].max() < 1e-6


@pytest.mark.parametrize("features", ["ignore", "slide"])
@pytest.mark.parametrize("boundary", ["sliding", "smoothed"])
def test_lines_that_slide_are_put_on_the_source(boundary, features):
    sheet = pv.Plane(i_resolution=9, j_resolution=9).triangulate()
    sheet.points[:, 2] = 0.3 * np.maximum(sheet.points[:, 0], 0.0)  # a ridge along the middle
    source = double(pv.Plane(i_size=2, j_size=2, i_resolution=80, j_resolution=80).triangulate())
    source.points[:, 2] = 0.1 * np.cos(4 * source.points[:, 0]) - 0.05 * source.points[:, 1]
    mesh = rough(sheet, 0.0)
    angles = {"ridge_angle": 10.0, "corner_angle": 170.0} if features == "slide" else {}
    smoothing = LaplacianSmoothing(iterations=5, boundary=boundary, features=features, **angles)
    smooth = pv.wrap(smoothing(mesh, None, source))
    moved = (smooth.points != mesh.points).any(axis=1)
    rim = np.isclose(np.abs(mesh.points[:, :2]).max(axis=1), 0.5)
    assert moved[rim].sum() > 25
    assert distances(smooth, source)[moved].max() < 1e-9


def test_what_cannot_be_is_refused():
    with pytest.raises(ParameterError, match="cannot go together"):
        LaplacianSmoothing(preserve_volume=True)(pv.Sphere(), None, pv.Sphere())
    with pytest.raises(ParameterError, match="cannot dispose of operations on edges"):
        LaplacianSmoothing(scheme="pairwise")(pv.Sphere(), None, pv.Sphere())
    with pytest.raises(InvalidMeshError, match="source surface"):
        LaplacianSmoothing()(pv.Sphere(), None, pv.PolyData([[0.0, 0, 0]]))


def test_the_accessor_and_the_command_take_it(tmp_path):
    source, mesh = double(pv.Icosphere(nsub=4)), rough(pv.Icosphere(nsub=3), 0.02)
    of_accessor = mesh.vtksmooth.laplacian_smoothing(source=source, iterations=4)
    source.save(tmp_path / "source.vtp")
    mesh.save(tmp_path / "mesh.vtp")
    arguments = ["laplacian", str(tmp_path / "mesh.vtp"), str(tmp_path / "out.vtp"), "--quiet"]
    assert main([*arguments, "--source", str(tmp_path / "source.vtp"), "--iterations", "4"]) == 0
    np.testing.assert_array_equal(pv.read(tmp_path / "out.vtp").points, of_accessor.points)


def test_steps_that_are_taken_back_are_put_on_the_source_again():
    # Two sheets close together, on a source between them: what would cross is taken back, all of it or half.
    lower, upper = (
        pv.Plane(center=(0, 0, z), i_resolution=8, j_resolution=8).triangulate() for z in (-0.05, 0.05)
    )
    mesh = rough(lower + upper, 0.01)
    smoothing = LaplacianSmoothing(iterations=3, self_intersection="none-new")
    smooth = pv.wrap(smoothing(mesh, None, double(pv.Plane().triangulate())))
    assert smoothing.report.taken_back > 0
    moved = (smooth.points != mesh.points).any(axis=1)
    assert np.abs(smooth.points[moved, 2]).max(initial=0.0) < 1e-12
    assert smooth.vtksmooth.self_intersection().field_data["CrossingPairs"][0] == 0
