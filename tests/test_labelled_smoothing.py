"""Every smoothing filter on surfaces between labels."""

import json

import meshes
import numpy as np
import pytest
import pyvista as pv
from vtkmodules.vtkFiltersCore import vtkAppendPolyData

from vtksmooth import (
    EquilateralSmoothing,
    InstallationSpaceSmoothing,
    InvalidMeshError,
    LaplacianSmoothing,
    NullSpaceSmoothing,
    ParameterError,
    SegmentationSurface,
    TrapeziumDrawing,
)
from vtksmooth.cli import main
from vtksmooth.filters import FILTERS, SmoothingFilter
from vtksmooth.kernels.mesh import adjacency
from vtksmooth.kernels.mesh.labels import labelled
from vtksmooth.kernels.mesh.mesh import Mesh

SMOOTHING = [cls for cls in FILTERS if issubclass(cls, SmoothingFilter) and len(cls.inputs) == 1]


def surface(voxels=None):
    voxels = meshes.grains(12, 4) if voxels is None else voxels
    image = pv.ImageData(dimensions=voxels.shape)
    image["labels"] = voxels.ravel(order="F").astype(np.uint8)
    return pv.wrap(SegmentationSurface(iterations=0)(image))


def volumes(mesh, points=None):
    p = np.asarray(mesh.points if points is None else points)[mesh.regular_faces]
    volume = np.einsum("ij,ij->i", p[:, 0], np.cross(p[:, 1], p[:, 2])) / 6
    sides = np.asarray(mesh.cell_data["BoundaryLabels"])
    count = sides.max() + 1
    return np.bincount(sides[:, 0], volume, count) - np.bincount(sides[:, 1], volume, count)


def kinds(mesh):
    arrays = Mesh.from_faces(mesh.points, mesh.regular_faces)
    return adjacency.build(labelled(arrays, np.asarray(mesh.cell_data["BoundaryLabels"]))[0]).kinds


@pytest.mark.parametrize("cls", SMOOTHING)
def test_preserve_volume_means_all_labels(cls):
    mesh = surface()
    smoothing = cls(iterations=5, preserve_volume=True)
    if cls.command == "back-to-surface":
        with pytest.raises(ParameterError, match="stays on the surface"):
            smoothing(mesh)
        return
    result = pv.wrap(smoothing(mesh))
    change = volumes(mesh, result.points) / volumes(mesh) - 1
    assert abs(change).max() < 1e-12
    assert [label for label, _, _ in smoothing.report.label_volumes] == [0, 1, 2, 3, 4]
    for label, before, after in smoothing.report.label_volumes:
        assert after == pytest.approx(volumes(mesh, result.points)[label], rel=1e-9)
        assert before == pytest.approx(volumes(mesh)[label], rel=1e-9)
    assert smoothing.report.moved > 0.1 * mesh.n_points
    assert smoothing.report.irregular == 0
    assert "volumes of 5 labels" in str(smoothing.report)


@pytest.mark.parametrize("scheme", ["umbrella", "scale-dependent", "thin-plate", "taubin", "pairwise"])
def test_lines_and_junctions_move_along(scheme):
    mesh = surface()
    smoothing = LaplacianSmoothing(scheme=scheme, iterations=10, preserve_volume=True)
    result = pv.wrap(smoothing(mesh))
    moved = (result.points != mesh.points).any(axis=1)
    assert moved[kinds(mesh) == adjacency.LINE].mean() > 0.9
    assert moved[kinds(mesh) == adjacency.JUNCTION].mean() > 0.5
    assert abs(volumes(mesh, result.points) / volumes(mesh) - 1).max() < 1e-12
    # Smoother: lines turn less.
    assert turning(mesh, result.points).mean() < 0.5 * turning(mesh, mesh.points).mean()


def turning(mesh, points):
    near = adjacency.build(
        labelled(Mesh.from_faces(points, mesh.regular_faces), np.asarray(mesh.cell_data["BoundaryLabels"]))[0]
    )
    at = np.flatnonzero(near.kinds == adjacency.LINE)
    first, second = (points[near.row[near.row_offsets[at] + i]] for i in (0, 1))
    a, b = points[at] - first, second - points[at]
    return np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), (a * b).sum(axis=1)))


@pytest.mark.parametrize(
    "smoothing",
    [
        TrapeziumDrawing(iterations=5),
        EquilateralSmoothing(iterations=5),
        NullSpaceSmoothing(iterations=5),
        LaplacianSmoothing(scheme="cotangent"),
        LaplacianSmoothing(scheme="odt"),
        LaplacianSmoothing(implicit_step=2.0),
        LaplacianSmoothing(tangent_plane=True),
    ],
)
def test_other_schemes_hold_lines(smoothing):
    mesh = surface()
    result = pv.wrap(smoothing(mesh))
    lines = kinds(mesh) >= adjacency.LINE
    corrected = smoothing.preserve_volume
    if not corrected:
        assert result.points[lines].tobytes() == mesh.points[lines].tobytes()
    assert (result.points[~lines] != mesh.points[~lines]).any(axis=1).mean() > 0.1


def test_limits_hold_together_with_the_volumes():
    mesh = surface()
    fixed = np.zeros(mesh.n_points, np.uint8)
    fixed[::7] = 1
    mesh.point_data["Fixed"] = fixed
    smoothing = LaplacianSmoothing(
        iterations=10, preserve_volume=True, max_deviation_fraction=0.01, gate="none"
    )
    result = pv.wrap(smoothing(mesh))
    assert abs(volumes(mesh, result.points) / volumes(mesh) - 1).max() < 1e-12
    assert result.points[fixed == 1].tobytes() == mesh.points[fixed == 1].tobytes()
    distance = np.abs(result.compute_implicit_distance(mesh)["implicit_distance"])
    assert distance.max() <= 0.01 * mesh.length * (1 + 1e-6)
    assert smoothing.report.moved > 0.3 * mesh.n_points


def test_gates_go_with_the_volumes():
    mesh = surface()
    smoothing = LaplacianSmoothing(iterations=5, preserve_volume=True, gate="floor")
    result = pv.wrap(smoothing(mesh))
    assert abs(volumes(mesh, result.points) / volumes(mesh) - 1).max() < 1e-12
    assert smoothing.report.min_aspect_ratio[1] >= 0.6 - 1e-9
    assert smoothing.report.moved > 0.3 * mesh.n_points


def test_the_array_of_pyvista_is_found_and_another_can_be_named():
    mesh = surface()
    expected = pv.wrap(LaplacianSmoothing(scheme="pairwise")(mesh)).points
    for name in ("boundary_labels", "Materials"):
        other = mesh.copy()
        other.cell_data[name] = other.cell_data.pop("BoundaryLabels")
        smoothing = LaplacianSmoothing(scheme="pairwise")
        if name == "Materials":
            smoothing.boundary_labels = name
        np.testing.assert_array_equal(pv.wrap(smoothing(other)).points, expected)


def test_without_the_labels_lines_stay():
    mesh = surface()
    result = pv.wrap(LaplacianSmoothing(scheme="pairwise", boundary_labels=None)(mesh))
    lines = kinds(mesh) >= adjacency.LINE
    assert result.points[lines].tobytes() == mesh.points[lines].tobytes()


def test_points_in_one_place_are_one():
    mesh = surface()
    parts = vtkAppendPolyData()
    halves = np.arange(mesh.n_cells) % 2
    for half in (0, 1):
        parts.AddInputData(
            mesh.extract_cells(halves == half).extract_surface(
                algorithm=None, pass_pointid=False, pass_cellid=False
            )
        )
    parts.Update()
    torn = pv.wrap(parts.GetOutput())
    assert torn.n_points > mesh.n_points
    smoothing = LaplacianSmoothing(scheme="pairwise")
    result = pv.wrap(smoothing(torn))
    assert smoothing.report.merged_points == torn.n_points - mesh.n_points
    assert smoothing.report.irregular == 0
    assert abs(volumes(torn, result.points) / volumes(mesh) - 1).max() < 1e-12
    places = {
        before.tobytes(): after.tobytes() for before, after in zip(torn.points, result.points, strict=True)
    }
    assert all(places[a.tobytes()] == b.tobytes() for a, b in zip(torn.points, result.points, strict=True))


def test_one_label_for_each_face_has_zero_on_the_other_side():
    mesh = surface(np.pad(np.ones((3, 3, 3), int), 1))
    expected = pv.wrap(LaplacianSmoothing(scheme="pairwise")(mesh)).points
    mesh.cell_data["BoundaryLabels"] = np.ones(mesh.n_cells, int)
    np.testing.assert_array_equal(pv.wrap(LaplacianSmoothing(scheme="pairwise")(mesh)).points, expected)


def test_walls_without_labels_are_refused_where_volumes_are_asked_for():
    mesh = surface()
    mesh.cell_data.clear()
    for smoothing in (LaplacianSmoothing(preserve_volume=True), NullSpaceSmoothing()):
        with pytest.raises(ParameterError, match="boundary_labels"):
            smoothing(mesh)
    # Voxels that touch along an edge have four faces there, and close.
    touching = surface(np.pad(np.eye(2, dtype=int)[:, :, None] * np.ones((1, 1, 3), int), 1))
    touching.cell_data.clear()
    LaplacianSmoothing(preserve_volume=True)(touching)


def _give(values):
    return lambda mesh: mesh.cell_data.update({"BoundaryLabels": values(mesh.n_cells)})


@pytest.mark.parametrize(
    ("spoil", "smoothing", "error", "message"),
    [
        (lambda m: None, LaplacianSmoothing(boundary_labels="no"), ParameterError, "no cell array 'no'"),
        (_give(lambda n: np.ones((n, 3), int)), LaplacianSmoothing(), InvalidMeshError, "both sides"),
        (_give(lambda n: np.ones((n, 2), int)), LaplacianSmoothing(), InvalidMeshError, "same label"),
        (lambda m: m.flip_faces(inplace=True), LaplacianSmoothing(), None, ""),
        (lambda m: None, LaplacianSmoothing(corrections=1), ParameterError, "corrections have no effect"),
        (
            lambda m: None,
            LaplacianSmoothing(scheme="pairwise", weights="cotangent"),
            ParameterError,
            "umbrella weights",
        ),
    ],
)
def test_bad_labels(spoil, smoothing, error, message):
    mesh = surface()
    spoil(mesh)
    if error is None:  # all of them turned over: volumes are negative, and stay
        result = pv.wrap(LaplacianSmoothing(preserve_volume=True)(mesh))
        assert abs(volumes(mesh, result.points) / volumes(mesh) - 1).max() < 1e-12
        return
    with pytest.raises(error, match=message):
        smoothing(mesh)


def test_installation_spaces_take_no_labels():
    mesh = surface()
    with pytest.raises(ParameterError, match="installation space"):
        InstallationSpaceSmoothing(boundary_labels="BoundaryLabels")(
            mesh, pv.Cube(bounds=(-1, 20) * 3).triangulate()
        )


def test_quality_and_comparison_tell_the_volumes_of_labels(tmp_path, capsys):
    voxels = meshes.grains(12, 4)
    mesh = surface(voxels)
    smooth = pv.wrap(LaplacianSmoothing(iterations=3)(mesh))
    mesh.save(tmp_path / "before.vtp")
    smooth.save(tmp_path / "after.vtp")
    before, after = str(tmp_path / "before.vtp"), str(tmp_path / "after.vtp")
    assert main(["quality", before, "--json"]) == 0
    figures = json.loads(capsys.readouterr().out)
    assert figures["volume"] is None
    assert figures["closed"]
    found = {each["label"]: each["volume"] for each in figures["labels"] if each["label"]}
    assert found == pytest.approx({label: (voxels == label).sum() for label in range(1, 5)})
    assert main(["compare", before, after, "--json"]) == 0
    figures = json.loads(capsys.readouterr().out)
    old, new = volumes(mesh), volumes(mesh, smooth.points)
    for each in figures["labels"]:
        assert each["volume"] == pytest.approx(new[each["label"]], rel=1e-6)
        assert each["change_percent"] == pytest.approx(100 * (new / old - 1)[each["label"]], rel=1e-6)
    assert figures["swept_volume"] == pytest.approx(abs(new - old).max(), rel=1e-6)
    assert main(["compare", before, after]) == 0
    assert "volume change of label 3, %" in capsys.readouterr().out
