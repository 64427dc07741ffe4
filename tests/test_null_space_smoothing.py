"""The filter: what its parameters do, beyond what holds for every filter."""

import meshes
import numpy as np
import pytest
import pyvista as pv
import reference
from vtkmodules.util.numpy_support import vtk_to_numpy

from vtksmooth import LaplacianSmoothing, NullSpaceSmoothing, TrapeziumDrawing
from vtksmooth.errors import VtksmoothError
from vtksmooth.filters.arrays import surface_of
from vtksmooth.kernels.smoothing import loop
from vtksmooth.kernels.smoothing.constraints.boundary import Boundary
from vtksmooth.kernels.smoothing.constraints.local_volume import LocalVolume
from vtksmooth.kernels.smoothing.constraints.null_space import NullSpace
from vtksmooth.kernels.smoothing.schemes.umbrella import Umbrella


def points_of(polydata):
    return vtk_to_numpy(polydata.GetPoints().GetData())


def test_without_the_gate_it_is_the_paper_s_preset():
    mesh = meshes.torus(18, 8, jitter=0.2)
    smoothing = NullSpaceSmoothing(iterations=7, gate="none")
    found = points_of(smoothing(meshes.polydata(mesh)))
    constraints = [NullSpace(), Boundary(), LocalVolume(2)]
    expected, report = loop.smooth(mesh, Umbrella(0.5), constraints, iterations=7)
    np.testing.assert_array_equal(found, expected)
    assert smoothing.report.volume_residuals == report.volume_residuals
    assert len(report.volume_residuals) == 3


@pytest.mark.parametrize("scheme", NullSpaceSmoothing.scheme.choices)
@pytest.mark.parametrize("gate", NullSpaceSmoothing.gate.choices)
def test_every_scheme_and_gate_keeps_the_volume_and_the_features(scheme, gate):
    cube = meshes.polydata(meshes.cube(4, triangles=True))
    smoothing = NullSpaceSmoothing(scheme=scheme, gate=gate, iterations=20)
    points = points_of(smoothing(cube))
    assert smoothing.report.volume == pytest.approx((64.0, 64.0), rel=1e-13)
    np.testing.assert_allclose(np.abs(points - 2.0).max(axis=1), 2.0, atol=1e-13)
    assert smoothing.report.inverted == (0, 0)


@pytest.mark.parametrize(
    ("cls", "parameters"),
    [
        (LaplacianSmoothing, {}),
        (LaplacianSmoothing, {"scheme": "cotangent"}),
        (LaplacianSmoothing, {"tangent_plane": True}),
        (TrapeziumDrawing, {}),
        (TrapeziumDrawing, {"gate": "none", "null_space": True}),
    ],
)
def test_any_smoothing_filter_can_keep_the_volume(cls, parameters):
    sphere = pv.Sphere(theta_resolution=16, phi_resolution=16)
    sphere.points = sphere.points.astype(float)
    plain, keeping = cls(**parameters), cls(**parameters, corrections=1, preserve_volume=True)
    plain(sphere)
    keeping(sphere)
    before, after = keeping.report.volume
    assert after == pytest.approx(before, rel=1e-13)
    assert abs(plain.report.volume[1] - before) > 1e-6 * before
    assert keeping.report.inverted == (0, 0)


def test_null_space_alone_has_the_guard_too():
    mesh = meshes.torus(12, 8, jitter=0.8, seed=3)
    smoothing = NullSpaceSmoothing(corrections=0, preserve_volume=False, relaxation_factor=1.0, iterations=3)
    smoothing(meshes.polydata(mesh))
    assert smoothing.report.inverted[1] <= smoothing.report.inverted[0]
    assert smoothing.report.volume_residuals == ()


def test_fixed_points_keep_their_bits():
    mesh = meshes.torus(18, 8, jitter=0.2)
    polydata = pv.wrap(meshes.polydata(mesh))
    polydata["Fixed"] = np.random.default_rng(0).random(mesh.n_points) < 0.3
    smoothing = NullSpaceSmoothing(iterations=20)
    points = points_of(smoothing(polydata))
    fixed = polydata["Fixed"] != 0
    assert points[fixed].tobytes() == surface_of(polydata).mesh.points[fixed].tobytes()
    assert smoothing.report.volume[1] == pytest.approx(smoothing.report.volume[0], rel=1e-13)


def test_by_default_no_element_becomes_worse_than_good_enough():
    for kind in meshes.KINDS:
        mesh = meshes.torus(18, 8, kind, jitter=0.35, seed=1)
        smoothing = NullSpaceSmoothing(iterations=60, output_points_precision="double")
        smoothing(meshes.polydata(mesh))
        before, after = smoothing.report.min_aspect_ratio
        assert after >= min(before, 0.6)
        assert smoothing.report.mean_aspect_ratio[1] > smoothing.report.mean_aspect_ratio[0]
        assert smoothing.report.volume[1] == pytest.approx(smoothing.report.volume[0], rel=1e-13)


# -- a prescribed flux ----------------------------------------------------------------------------


def sourced(mesh, on="cells"):
    """A mesh with a source that varies along z."""
    source = pv.wrap(meshes.polydata(mesh))
    at = source.cell_centers().points if on == "cells" else source.points
    data = source.cell_data if on == "cells" else source.point_data
    data["Source"] = 0.002 * (2.0 + at[:, 2] / np.abs(at).max())
    return source


@pytest.mark.parametrize("on", ["cells", "points"])
@pytest.mark.parametrize("iterations", [1, 5])
@pytest.mark.parametrize("name", ["torus of triangles", "mixed torus", "sphere", "sheet of quads"])
def test_a_flux_is_what_the_volume_gains(name, iterations, on):
    mesh = meshes.USUAL[name]()
    source = sourced(mesh, on)
    smoothing = NullSpaceSmoothing(flux="Source", gate="none", iterations=iterations)
    result = pv.wrap(smoothing(source))
    areas = np.linalg.norm(reference.area_vectors(mesh), axis=1)
    if on == "cells":
        values = source["Source"]
    else:
        values = np.array([source["Source"][face].mean() for face in meshes.lists(mesh)])
    wanted = float((values * areas).sum())
    assert smoothing.report.flux == pytest.approx(wanted, rel=1e-13)
    size = reference.volume(mesh) if "sheet" not in name else mesh.diagonal**3
    assert abs(smoothing.report.swept_volume - wanted) < 1e-14 * size
    assert result.field_data["SmoothingFlux"][0] == smoothing.report.flux
    if "sheet" not in name:
        after = mesh.with_points(np.asarray(result.points, float))
        assert abs(reference.volume(after) - reference.volume(mesh) - wanted) < 1e-13 * size


def test_a_flux_moves_the_surface_where_it_is():
    source = sourced(meshes.icosphere(3))
    source["Source"] = np.where(source.cell_centers().points[:, 2] > 0.3, 0.02, 0.0)
    result = pv.wrap(NullSpaceSmoothing(flux="Source", gate="none", iterations=1, corrections=3)(source))
    radius = np.linalg.norm(result.points, axis=1)
    assert radius[source.points[:, 2] > 0.6] == pytest.approx(1.02, abs=2e-3)
    assert radius[source.points[:, 2] < 0.0] == pytest.approx(1.0, abs=2e-3)


@pytest.mark.parametrize(
    ("parameters", "said"),
    [
        ({"flux": "None"}, "no cell or point array 'None'"),
        ({"flux": "Source", "gate": "floor"}, "set the gate to none"),
        ({"flux": "Source", "crease_angle": 30.0}, "leave out the bound on creases"),
        ({"flux": "Source", "preserve_volume": False}, "preserve_volume"),
        ({"flux": "Broken"}, "not finite"),
    ],
)
def test_a_flux_that_cannot_be_kept_is_refused(parameters, said):
    source = sourced(meshes.icosphere(1))
    source["Broken"] = np.full(source.n_cells, np.nan)
    with pytest.raises(VtksmoothError, match=said):
        NullSpaceSmoothing(**{"gate": "none"} | parameters)(source)
