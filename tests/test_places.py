"""Points in one place stay in one place: seams, soups, blocks and ghost cells; and normals are true."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import pyvista as pv

from vtksmooth import (
    AngleBasedSmoothing,
    BackToSurfaceSmoothing,
    ContainmentCheck,
    EquilateralSmoothing,
    LaplacianSmoothing,
    NullSpaceSmoothing,
    SurfaceComparison,
    SurfaceQuality,
    TrapeziumDrawing,
)
from vtksmooth.kernels.mesh.mesh import Mesh
from vtksmooth.kernels.mesh.places import distinct_places, join_points

SMOOTHING = [
    TrapeziumDrawing,
    LaplacianSmoothing,
    AngleBasedSmoothing,
    BackToSurfaceSmoothing,
    EquilateralSmoothing,
    NullSpaceSmoothing,
]


def bumpy(nsub: int = 2) -> pv.PolyData:
    """A closed surface without points in one place."""
    mesh = pv.Icosphere(nsub=nsub)
    mesh.points = mesh.points.astype(float)
    mesh.points += 0.01 * np.random.default_rng(3).normal(size=mesh.points.shape)
    mesh.clear_data()
    return mesh


def soup(mesh: pv.PolyData) -> pv.PolyData:
    """The same faces, each with points of its own."""
    corners = mesh.regular_faces.ravel()
    return pv.PolyData.from_regular_faces(mesh.points[corners], np.arange(len(corners)).reshape(-1, 3))


def halves(mesh: pv.PolyData) -> tuple[pv.MultiBlock, list[np.ndarray]]:
    """The faces of a mesh in two blocks, and the numbers of their points in the mesh."""
    faces = mesh.regular_faces
    left = mesh.points[faces].mean(axis=1)[:, 0] < 0.05
    blocks, numbers = pv.MultiBlock(), []
    for side in (left, ~left):
        used, corners = np.unique(faces[side], return_inverse=True)
        blocks.append(pv.PolyData.from_regular_faces(mesh.points[used], corners.reshape(-1, 3)))
        numbers.append(used)
    return blocks, numbers


def moved(mesh: Any, original: Any) -> bool:
    return not np.array_equal(pv.wrap(mesh).points, original.points)


# -- kernels -------------------------------------------------------------------------------------


def test_places_of_random_points_are_those_of_a_slow_search() -> None:
    random = np.random.default_rng(0)
    points = random.integers(-3, 4, (500, 3)).astype(float) * random.choice([-1.0, 1.0], (500, 3))
    points[7] = points[11] = np.nan
    place, first = distinct_places(points)
    seen: list[tuple[float, ...]] = []
    for v, point in enumerate(points.tolist()):
        if point[0] != point[0] or tuple(point) not in seen:
            assert first[place[v]] == v
            seen.append(tuple(point))
        else:
            assert place[v] == seen.index(tuple(point))
    assert len(first) == len(seen)


def test_bodies_that_touch_in_a_point_stay_apart_there() -> None:
    tetrahedron = pv.Tetrahedron().triangulate()
    corners = np.asarray(tetrahedron.points, float)
    other = 2.0 * corners[0] - corners
    points = np.concatenate((corners, other))
    faces = np.concatenate((tetrahedron.regular_faces, tetrahedron.regular_faces[:, ::-1] + 4))
    joint = join_points(Mesh.from_faces(points, faces.tolist()), *distinct_places(points))
    assert len(joint.first) == 8
    assert np.flatnonzero(joint.apart).tolist() == [0, 4]


# -- one mesh ------------------------------------------------------------------------------------


@pytest.mark.parametrize("cls", SMOOTHING)
def test_a_soup_is_smoothed_as_the_mesh_it_stands_for(cls: type) -> None:
    mesh = bumpy()
    apart, algorithm = soup(mesh), cls(iterations=3)
    expected = pv.wrap(cls(iterations=3)(mesh))
    result = pv.wrap(algorithm(apart))
    assert moved(result, apart)
    assert np.array_equal(result.regular_faces, apart.regular_faces)
    np.testing.assert_allclose(result.points, expected.points[mesh.regular_faces.ravel()], atol=1e-9)
    place, _ = distinct_places(np.asarray(apart.points))
    for corner in np.unique(place):
        assert len(np.unique(result.points[place == corner], axis=0)) == 1
    assert algorithm.report.merged_points == apart.n_points - mesh.n_points
    assert any("points in one place move as one" in note for note in algorithm.notes)


@pytest.mark.parametrize("cls", SMOOTHING)
def test_a_seam_stays_closed_with_sliding_boundaries(cls: type) -> None:
    plane = pv.Plane(i_resolution=8, j_resolution=8).triangulate()
    plane.points = np.asarray(plane.points, float)
    plane.points[:, 2] = 0.05 * np.sin(9.0 * plane.points[:, 0] + 4.0 * plane.points[:, 1])
    plane.clear_data()
    blocks, _ = halves(plane)
    seamed = pv.merge(list(blocks), merge_points=False)
    result = pv.wrap(cls(iterations=5, boundary="sliding")(seamed))
    before, after = distinct_places(seamed.points)[0], distinct_places(np.asarray(result.points))[0]
    assert moved(result, seamed)
    assert np.array_equal(before, after)


def test_any_fixed_copy_holds_its_place() -> None:
    mesh = soup(bumpy())
    mesh["Fixed"] = np.zeros(mesh.n_points, np.uint8)
    mesh["Fixed"][0] = 1
    result = pv.wrap(LaplacianSmoothing(iterations=2)(mesh))
    there = (mesh.points == mesh.points[0]).all(axis=1)
    assert there.sum() > 1
    assert np.array_equal(result.points[there], mesh.points[there])
    assert moved(result, mesh)


def test_a_mesh_without_points_in_one_place_has_no_note() -> None:
    algorithm = LaplacianSmoothing(iterations=1)
    algorithm(bumpy())
    assert algorithm.notes == []
    assert algorithm.report.merged_points == 0


# -- composite data ------------------------------------------------------------------------------


@pytest.mark.parametrize("cls", SMOOTHING)
def test_blocks_are_smoothed_as_one_surface(cls: type) -> None:
    blocks, numbers = halves(bumpy())
    # The mesh in the order of the blocks: what moves first is numbered first.
    order, first = np.unique(np.concatenate(numbers), return_index=True)
    new = np.argsort(np.argsort(first))
    points = np.concatenate([block.points for block in blocks])[np.sort(first)]
    faces = np.concatenate([own[block.regular_faces] for own, block in zip(numbers, blocks, strict=True)])
    mesh = pv.PolyData.from_regular_faces(points, new[faces])
    numbers = [new[own] for own in numbers]
    assert len(order) == mesh.n_points
    expected = pv.wrap(cls(iterations=3)(mesh))
    algorithm = cls(iterations=3)
    result = pv.wrap(algorithm(blocks))
    for block, source, own in zip(result, blocks, numbers, strict=True):
        assert np.array_equal(block.regular_faces, source.regular_faces)
        assert np.array_equal(block.points, expected.points[own])
    assert algorithm.report.volume is not None, "together they are closed"


def test_the_summary_is_of_all_blocks_in_any_order() -> None:
    fine, coarse = bumpy(3), bumpy(1)
    coarse.points += [3.0, 0.0, 0.0]
    summaries = []
    for blocks in ([fine, coarse], [coarse, fine]):
        quality, comparison = SurfaceQuality(), SurfaceComparison()
        quality(pv.MultiBlock(blocks))
        smooth = LaplacianSmoothing(iterations=2)(pv.MultiBlock(blocks))
        comparison(smooth, pv.MultiBlock(blocks))
        summaries.append((quality.summary, comparison.summary))
    for one, other in zip(*summaries, strict=True):
        assert one["points"] == fine.n_points + coarse.n_points
        assert one["cells"]["triangle"] == fine.n_cells + coarse.n_cells
        assert one["aspect_ratio"]["min"] == pytest.approx(other["aspect_ratio"]["min"])
        assert one["volume"] == pytest.approx(other["volume"])
    assert summaries[0][1]["deviation"]["max"] == pytest.approx(summaries[1][1]["deviation"]["max"])


@pytest.mark.parametrize("last", [True, False])
def test_containment_is_of_all_blocks(last: bool) -> None:
    space = pv.Cube().triangulate()
    out = pv.Cube(x_length=3.0).triangulate()
    inside = pv.Cube(x_length=0.5, y_length=0.5, z_length=0.5).triangulate()
    check = ContainmentCheck()
    check(pv.MultiBlock([inside, out] if last else [out, inside]), space)
    alone = ContainmentCheck()
    alone(out, space)
    assert check.summary == alone.summary
    assert check.summary["vertices_outside"] > 0


def test_figures_of_a_block_that_fails_are_not_shown() -> None:
    from vtksmooth import InvalidMeshError

    quality = SurfaceQuality()
    image = pv.ImageData(dimensions=(2, 2, 2))
    with pytest.raises(InvalidMeshError, match="Block 2 must be polydata, not vtkImageData"):
        quality(pv.MultiBlock([bumpy(), image]))
    assert quality.summary == {}


# -- ghosts --------------------------------------------------------------------------------------


@pytest.mark.parametrize("cls", SMOOTHING)
def test_points_of_ghost_cells_do_not_move(cls: type) -> None:
    mesh = bumpy()
    ghost = mesh.cell_centers().points[:, 0] > 0.3
    mesh.cell_data["vtkGhostType"] = ghost.astype(np.uint8)
    result = pv.wrap(cls(iterations=3)(mesh))
    held = np.unique(mesh.regular_faces[ghost])
    assert np.array_equal(result.points[held], mesh.points[held])
    assert moved(result, mesh)


def test_ghost_cells_are_not_measured() -> None:
    mesh = bumpy()
    mesh.cell_data["vtkGhostType"] = (np.arange(mesh.n_cells) < 10).astype(np.uint8)
    quality = SurfaceQuality()
    quality(mesh)
    assert quality.summary["cells"]["triangle"] == mesh.n_cells - 10


# -- normals -------------------------------------------------------------------------------------


@pytest.mark.parametrize("precision", [np.float32, np.float64])
def test_active_normals_are_those_of_the_result(precision: type) -> None:
    mesh = bumpy()
    mesh.compute_normals(inplace=True, split_vertices=False, consistent_normals=False)
    mesh.point_data["Pn"] = np.array(mesh.point_data["Normals"], precision)
    mesh.GetPointData().RemoveArray("Normals")
    mesh.point_data.active_normals_name = "Pn"
    mesh.point_data["OldNormals"] = np.ones((mesh.n_points, 3))
    algorithm = LaplacianSmoothing(iterations=5)
    result = pv.wrap(algorithm(mesh))
    bare = pv.PolyData(result.points, result.faces)
    true = bare.compute_normals(split_vertices=False, consistent_normals=False)
    assert result.point_data.active_normals_name == "Pn"
    assert result.point_data["Pn"].dtype == precision
    np.testing.assert_allclose(result.point_data["Pn"], true.point_data["Normals"], atol=1e-5)
    np.testing.assert_allclose(result.cell_data["Normals"], true.cell_data["Normals"], atol=1e-5)
    assert "OldNormals" not in result.point_data
    assert any("OldNormals" in note for note in algorithm.notes)
    assert "OldNormals" in mesh.point_data, "the input is never touched"


def test_edges_that_were_drawn_sharp_stay_sharp() -> None:
    cube = pv.Cube().triangulate().subdivide(2).clean()
    sharp = cube.compute_normals(split_vertices=True, feature_angle=30.0)
    result = pv.wrap(LaplacianSmoothing(iterations=1, features="hold")(sharp))
    assert result.n_points == sharp.n_points
    cosines = np.abs(np.asarray(result.point_data["Normals"])).max(axis=1)
    assert (cosines > 0.95).all(), "no normal is the mean of two sides"
