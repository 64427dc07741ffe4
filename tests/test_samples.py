"""The samples are what they say: by formulas, and by a slow voxel skin."""

import subprocess
import sys

import meshes
import numpy as np
import pytest
import pyvista as pv
import reference

from vtksmooth import ContainmentCheck, InstallationSpaceRegions, samples
from vtksmooth.filters.arrays import surface_of


@pytest.fixture(scope="module")
def case():
    return samples.channel()


def corners(mesh):
    return np.diff(mesh.GetPolys().GetOffsetsArray())


def sides(mesh):
    """How many edges have one face, and how many more than two."""
    edges = mesh.extract_feature_edges(
        boundary_edges=False, non_manifold_edges=True, feature_edges=False, manifold_edges=False
    )
    return mesh.n_open_edges, edges.n_cells


@pytest.mark.parametrize("refinement", [1, 2])
def test_the_installation_space(refinement):
    _, inst = samples.channel(refinement)
    assert sides(inst) == (0, 0)
    # The boxes, less the bevel, the outer corner of the bend, the ceiling, and the two slanted walls of the
    # outlet duct, which have a part in common.
    boxes = 14 * 12 * 10 + 16 * 22 * 16 + 10 * 12 * 10 + 6 * 8 * 6
    cuts = 9 * 6**2 / 6 + 16 * 8 * 4 / 2 + 22 * 8 * 6 / 2 + 12 * (12 + 10) - 6 * 4**2 / 3
    assert inst.triangulate().volume == pytest.approx(boxes - cuts, rel=1e-12)


def test_the_flow_volume(case):
    sim, _ = case
    count = np.bincount(corners(sim), minlength=7)
    assert len(count) == 7
    assert (count[:3] == 0).all()
    assert (count[3:] > 0).all()
    assert sides(sim)[1] == 0
    mesh = surface_of(sim).mesh
    kinds = np.array(reference.boundaries(mesh)[0])
    ends = np.isin(sim.points[:, 0], (0, 46)) & (kinds == 1)
    assert set(kinds) == {0, 1}
    np.testing.assert_array_equal(kinds == 1, ends)
    assert sim.extract_feature_edges(
        boundary_edges=True, non_manifold_edges=False, feature_edges=False, manifold_edges=False
    ).connectivity()["RegionId"].max() == 1  # fmt: skip
    # Every face is plane.
    areas = reference.area_vectors(mesh)
    for face, area in zip(meshes.lists(mesh), areas, strict=True):
        heights = (mesh.points[face] - mesh.points[face[0]]) @ (area / np.linalg.norm(area))
        assert np.abs(heights).max() < 1e-12


def test_the_flow_volume_lies_in_the_space_and_partly_on_it(case):
    sim, inst = case
    check = ContainmentCheck()
    check(sim, inst)
    assert check.summary == {"vertices_outside": 0, "max_outside": 0.0, "triangles_crossing": 0}
    regions = InstallationSpaceRegions()
    result = pv.wrap(regions(sim, inst))
    assert min(regions.summary["fixed"], regions.summary["free"]) > 500
    # What does not lie on a wall is stairs about the flow's true surface: its cells are in by their centres.
    free = samples.flow_distance(result.points[result["Fixed"] == 0])
    assert np.abs(free).max() < 1.0
    assert 0.3 < np.sqrt((free**2).mean()) < 0.6


def test_the_space_has_a_corner_that_pokes_into_the_flow(case):
    sim, inst = case
    corner = np.array([[30.0, 10.0, 6.0]])
    assert samples.flow_distance(corner)[0] < 2.0
    assert (np.abs(inst.points - corner).max(axis=1) == 0).any()
    assert np.linalg.norm(sim.points - corner, axis=1).min() < 2.0


def test_the_flow_runs_from_inlet_to_outlet(case):
    sim, _ = case
    flow = sim["Flow"]
    assert flow.shape == (sim.n_points, 3)
    speed = np.linalg.norm(flow, axis=1)
    assert speed.min() > 0
    assert (flow[:, 0] > 0).all()
    inlet = sim.points[:, 0] == 0
    np.testing.assert_allclose(flow[inlet, 0], speed[inlet], rtol=1e-2)


def test_flow_distance_is_a_distance():
    points = np.random.default_rng(0).uniform([0, 0, 0], [46, 22, 16], (500, 3))
    step = np.random.default_rng(1).normal(size=(500, 3))
    change = samples.flow_distance(points + 1e-3 * step) - samples.flow_distance(points)
    # The tube narrows, and its middle is sampled: not quite 1-Lipschitz.
    assert (np.abs(change) <= 1.3e-3 * np.linalg.norm(step, axis=1) + 1e-2).all()
    assert samples.flow_distance([[0, 6, 5]])[0] == pytest.approx(-6.3)


def test_voxel_skin_like_the_slow_one():
    cells = np.random.default_rng(2).random((6, 5, 4)) < 0.5
    skin, slow = samples.voxel_skin(cells), meshes.voxels(np.argwhere(cells))
    places = {tuple(p): i for i, p in enumerate(slow.points.tolist())}
    number = [places[tuple(p)] for p in skin.points.tolist()]
    found = [[number[i] for i in face] for face in skin.regular_faces.tolist()]

    def turned(face):
        first = face.index(min(face))
        return tuple(face[first:] + face[:first])

    assert sorted(map(turned, found)) == sorted(map(turned, meshes.lists(slow)))
    scaled = samples.voxel_skin(cells, origin=(1, 2, 3), spacing=(0.5, 1, 2))
    np.testing.assert_array_equal(scaled.points, skin.points * [0.5, 1, 2] + [1, 2, 3])


@pytest.mark.parametrize("quarter", [False, True])
def test_voxel_torus(quarter):
    skin = samples.voxel_torus(6.0, 20.0, quarter)
    assert sides(skin)[1] == 0
    distance = samples.torus_distance(skin.points, 6.0, 20.0)
    assert np.abs(distance).max() < np.sqrt(3) / 2
    assert 0.35 < np.sqrt((distance**2).mean()) < 0.5
    if quarter:
        assert skin.points[:, :2].min() == 0
        assert sides(skin)[0] > 0
        assert len(np.unique(skin.regular_faces)) == skin.n_points
    else:
        assert sides(skin)[0] == 0
        assert skin.volume == pytest.approx(2 * np.pi**2 * 20 * 36, rel=0.01)


def test_torus_distance():
    points = [[26, 0, 0], [0, 20, 6], [-20, 0, 0], [0, 0, 0]]
    np.testing.assert_allclose(samples.torus_distance(points, 6.0, 20.0), [0, 0, -6, 14])


def test_files(tmp_path, case):
    done = subprocess.run(
        [sys.executable, "-m", "vtksmooth.samples", tmp_path / "new"],
        capture_output=True,
        text=True,
        check=True,
    )
    paths = done.stdout.split()
    assert [pv.read(path).n_cells for path in paths[:2]] == [mesh.n_cells for mesh in case]
    assert len(paths) == 3
