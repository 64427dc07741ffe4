"""InstallationSpaceRegions: what lies on the space is fixed, and the transition."""

from __future__ import annotations

import json

import meshes
import numpy as np
import pytest
import pyvista as pv
import reference
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkMultiBlockDataSet, vtkPolyData

from vtksmooth import InstallationSpaceRegions, InvalidMeshError
from vtksmooth.cli import main
from vtksmooth.files import write_surface
from vtksmooth.kernels.mesh.mesh import Mesh


def arrays(result):
    data = result.GetPointData()
    return vtk_to_numpy(data.GetArray("Fixed")), vtk_to_numpy(data.GetArray("BlendWeight"))


def test_cells_in_the_corner_of_a_box():
    # Three sides of the block lie on the box, with other faces than the box's; three stand in the open.
    sim, space = meshes.cube(4), meshes.cube(1)
    regions = InstallationSpaceRegions(blend_rings=2)
    fixed, weights = arrays(
        regions(meshes.polydata(sim), meshes.polydata(space.with_points(6 * space.points)))
    )
    assert fixed.dtype == np.uint8
    assert weights.dtype == np.float64
    on_the_box = (sim.points == 0).any(axis=1)
    np.testing.assert_array_equal(fixed, on_the_box)
    assert (weights[~on_the_box] == 1).all()
    # Edges to the nearest free vertex, by growing.
    rings, reached = reference.one_rings(sim), {*np.flatnonzero(~on_the_box).tolist()}
    for _ in range(2):
        reached |= {q for p in reached for q in rings[p]}
    np.testing.assert_array_equal(weights > 0, np.isin(np.arange(sim.n_points), list(reached)))
    assert regions.summary == {
        "fixed": on_the_box.sum(),
        "blended": (weights[on_the_box] > 0).sum(),
        "free": (~on_the_box).sum(),
    }
    assert regions.notes == []


@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_points_in_single_precision_are_on_it_still(scale):
    sim, space = meshes.cube(4), meshes.cube(1)
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    near = pv.PolyData(meshes.polydata(sim.with_points(scale * (sim.points @ turn + 3))))
    near.points = near.points.astype(np.float32)
    fixed, _ = arrays(
        InstallationSpaceRegions()(
            near, meshes.polydata(space.with_points(scale * (6 * space.points @ turn + 3)))
        )
    )
    np.testing.assert_array_equal(fixed, (sim.points == 0).any(axis=1))


def test_points_that_no_face_uses():
    sim = meshes.isolated_points()
    fixed, weights = arrays(InstallationSpaceRegions()(meshes.polydata(sim), meshes.polydata(meshes.cube(5))))
    unused = np.setdiff1d(np.arange(sim.n_points), sim.connectivity)
    assert not fixed[unused].any()
    assert (weights[unused] == 1).all()
    assert fixed.sum() == sim.n_points - len(unused)


def test_every_block_has_the_same_space():
    sim, space = meshes.cube(2), meshes.polydata(meshes.cube(3))
    blocks = vtkMultiBlockDataSet()
    blocks.SetBlock(0, meshes.polydata(sim))
    blocks.SetBlock(1, meshes.polydata(sim.with_points(sim.points + 1)))
    result = InstallationSpaceRegions()(blocks, space)
    for block, side in ((0, 0.0), (1, 3.0)):
        points = sim.points + block
        np.testing.assert_array_equal(arrays(result.GetBlock(block))[0], (points == side).any(axis=1))


def test_command(tmp_path, capsys):
    sim = meshes.polydata(meshes.cube(2))
    space = meshes.cube(3)
    turned = Mesh.from_faces(space.points, [face[::-1] for face in meshes.lists(space)])
    write_surface(sim, tmp_path / "sim.vtp")
    write_surface(meshes.polydata(turned), tmp_path / "space.vtp")
    paths = [str(tmp_path / name) for name in ("sim.vtp", "space.vtp", "out.vtp")]
    assert main(["regions", *paths, "--json", "--blend-rings", "1"]) == 0
    out, err = capsys.readouterr()
    assert "inside out" in err
    result = pv.read(paths[2])
    assert json.loads(out)["fixed"] == result["Fixed"].sum() == 19
    assert 0 < result["BlendWeight"].min() + 1 < 2


def test_accessor():
    sim, space = pv.PolyData(meshes.polydata(meshes.cube(2))), pv.PolyData(meshes.polydata(meshes.cube(3)))
    result = sim.vtksmooth.installation_space_regions(space, blend_rings=0)
    assert (result["BlendWeight"] == 1 - result["Fixed"]).all()
    assert "Fixed" not in sim.point_data


@pytest.mark.parametrize(
    ("sim", "space", "message"),
    [
        (vtkPolyData(), meshes.polydata(meshes.cube(1)), "empty"),
        (meshes.polydata(meshes.cube(1)), vtkPolyData(), "installation space is no usable surface"),
        (
            meshes.polydata(meshes.cube(1)),
            meshes.polydata(meshes.cube(1).with_points(meshes.cube(1).points + 9)),
            "are apart; check units",
        ),
    ],
)
def test_bad_input(sim, space, message):
    with pytest.raises(InvalidMeshError, match=message):
        InstallationSpaceRegions()(sim, space)
