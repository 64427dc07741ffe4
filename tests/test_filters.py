"""The filters as VTK citizens: pipelines, errors, abort, composite data, pass-through, precision."""

from __future__ import annotations

import contextlib
import threading
from typing import Any

import numpy as np
import pytest
import pyvista as pv
import reference
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import VTK_INT, vtkPoints, vtkStringArray
from vtkmodules.vtkCommonDataModel import (
    vtkCellArray,
    vtkMultiBlockDataSet,
    vtkPartitionedDataSetCollection,
    vtkPolyData,
)
from vtkmodules.vtkFiltersCore import (
    vtkConstrainedSmoothingFilter,
    vtkPolyDataNormals,
    vtkStripper,
    vtkTriangleFilter,
)
from vtkmodules.vtkFiltersSources import vtkCubeSource, vtkPlaneSource, vtkSphereSource

from vtksmooth import (
    AngleBasedSmoothing,
    BackToSurfaceSmoothing,
    Cancelled,
    EquilateralSmoothing,
    InvalidMeshError,
    LaplacianSmoothing,
    ParameterError,
    SurfaceComparison,
    SurfaceQuality,
    TrapeziumDrawing,
    VtksmoothError,
)
from vtksmooth.filters import FILTERS
from vtksmooth.filters.arrays import cells_of, surface_of, vtk_array
from vtksmooth.kernels.distance.closest_point import ClosestPoint

SMOOTHING = [
    TrapeziumDrawing,
    LaplacianSmoothing,
    AngleBasedSmoothing,
    BackToSurfaceSmoothing,
    EquilateralSmoothing,
]


def polydata(points: Any, faces: list[list[int]]) -> vtkPolyData:
    mesh, cells, vtk_points = vtkPolyData(), vtkCellArray(), vtkPoints()
    vtk_points.SetData(numpy_to_vtk(np.ascontiguousarray(points), deep=1))
    for face in faces:
        cells.InsertNextCell(len(face), face)
    mesh.SetPoints(vtk_points)
    mesh.SetPolys(cells)
    return mesh


def plane(n: int = 8, dtype: type = np.float64, seed: int = 1) -> vtkPolyData:
    """A square of n x n quads, every second one split, its inner points shaken."""
    x, y = np.meshgrid(np.arange(n + 1.0), np.arange(n + 1.0))
    points = np.column_stack((x.ravel(), y.ravel(), np.zeros(x.size)))
    inner = ((points[:, :2] > 0) & (points[:, :2] < n)).all(axis=1)
    points[inner, :2] += np.random.default_rng(seed).uniform(-0.3, 0.3, (inner.sum(), 2))
    faces = []
    for i in range(n):
        for j in range(n):
            a, b, c, d = (r * (n + 1) + s for r, s in ((i, j), (i, j + 1), (i + 1, j + 1), (i + 1, j)))
            faces += [[a, b, c, d]] if (i + j) % 2 else [[a, b, c], [a, c, d]]
    return polydata(points.astype(dtype), faces)


def bumpy(size: float = 1.0) -> vtkPolyData:
    """A closed ball, shaken."""
    source = vtkSphereSource()
    source.SetRadius(size)
    source.Update()
    mesh = source.GetOutput()
    points = points_of(mesh)
    points += np.random.default_rng(2).uniform(-0.02, 0.02, points.shape).astype(points.dtype)
    mesh.GetPoints().SetData(vtk_array(points, "Points"))
    return mesh


def points_of(mesh: Any) -> np.ndarray:
    return vtk_to_numpy(mesh.GetPoints().GetData()).copy()


# -- pipelines -----------------------------------------------------------------------------------


def test_chains_with_native_filters_on_both_sides_and_runs_once() -> None:
    source = vtkPlaneSource()
    source.SetResolution(6, 6)
    triangles, smoothing, normals = vtkTriangleFilter(), TrapeziumDrawing(), vtkPolyDataNormals()
    triangles.SetInputConnection(source.GetOutputPort())
    smoothing.SetInputConnection(triangles.GetOutputPort())
    normals.SetInputConnection(smoothing.GetOutputPort())
    runs: list[int] = []
    smoothing.AddObserver("StartEvent", lambda *_: runs.append(1))
    normals.Update()
    assert normals.GetOutput().GetNumberOfPoints() == 49
    normals.Update()
    assert len(runs) == 1
    smoothing.iterations = 7
    normals.Update()
    assert len(runs) == 2
    source.SetResolution(4, 4)
    normals.Update()
    assert len(runs) == 3
    assert normals.GetOutput().GetNumberOfPoints() == 25


@pytest.mark.parametrize("cls", SMOOTHING)
def test_progress_rises_from_0_to_1(cls: type) -> None:
    smoothing, seen = cls(iterations=3), []
    smoothing.AddObserver("ProgressEvent", lambda *_: seen.append(smoothing.GetProgress()))
    smoothing(plane())
    assert seen[0] == 0.0
    assert seen[-1] == 1.0
    assert seen == sorted(seen)


@pytest.mark.parametrize("cls", SMOOTHING)
def test_abort_from_an_observer_empties_the_output_and_the_next_run_works(cls: type) -> None:
    mesh, smoothing = plane(), cls(iterations=10_000, gate="none")
    tag = smoothing.AddObserver("ProgressEvent", lambda *_: smoothing.SetAbortExecute(1))
    before = points_of(mesh)
    with pytest.raises(Cancelled):
        smoothing(mesh)
    assert smoothing.GetOutput().GetNumberOfPoints() == 0
    np.testing.assert_array_equal(points_of(mesh), before)
    smoothing.RemoveObserver(tag)
    smoothing.iterations = 2
    assert smoothing(mesh).GetNumberOfPoints() == mesh.GetNumberOfPoints()


def test_abort_from_another_thread_ends_a_long_run() -> None:
    smoothing = LaplacianSmoothing(iterations=100_000_000)
    started = threading.Event()
    smoothing.AddObserver("ProgressEvent", lambda *_: started.set())

    def abort() -> None:
        started.wait(60)
        smoothing.SetAbortExecute(1)

    thread = threading.Thread(target=abort)
    thread.start()
    smoothing.SetInputData(plane())
    smoothing.Update()  # an abort is no error in VTK: nothing is raised here
    thread.join()
    assert isinstance(smoothing.last_error, Cancelled)
    assert smoothing.GetOutput().GetNumberOfPoints() == 0


# -- pass-through --------------------------------------------------------------------------------


def with_data(mesh: vtkPolyData) -> vtkPolyData:
    for data, size in (
        (mesh.GetPointData(), mesh.GetNumberOfPoints()),
        (mesh.GetCellData(), mesh.GetNumberOfCells()),
    ):
        array = numpy_to_vtk(np.arange(size, dtype=np.int32), deep=1)
        array.SetName("number")
        data.AddArray(array)
    text = vtkStringArray()
    text.SetName("note")
    text.InsertNextValue("hello")
    mesh.GetFieldData().AddArray(text)
    return mesh


@pytest.mark.parametrize("cls", SMOOTHING)
def test_data_and_topology_pass_and_the_input_stays(cls: type) -> None:
    mesh = with_data(plane())
    before = points_of(mesh)
    result = cls(iterations=4)(mesh)
    np.testing.assert_array_equal(points_of(mesh), before)
    assert mesh.GetFieldData().GetNumberOfArrays() == 1
    assert not np.array_equal(points_of(result), before)
    assert vtk_to_numpy(result.GetPointData().GetArray("number")).tolist() == list(range(len(before)))
    assert result.GetCellData().GetArray("number").GetNumberOfTuples() == mesh.GetNumberOfCells()
    assert result.GetFieldData().GetAbstractArray("note").GetValue(0) == "hello"
    for old, new in zip(cells_of(mesh.GetPolys()), cells_of(result.GetPolys()), strict=True):
        np.testing.assert_array_equal(old, new)


def test_what_was_done_is_in_field_data_and_report() -> None:
    smoothing = TrapeziumDrawing(iterations=3)
    field = smoothing(plane()).GetFieldData()
    assert field.GetArray("SmoothingIterations").GetValue(0) == smoothing.report.iterations == 3
    assert (
        field.GetAbstractArray("SmoothingStopReason").GetValue(0)
        == smoothing.report.stop_reason
        == "iterations"
    )
    assert field.GetArray("SmoothingVerticesMoved").GetValue(0) == smoothing.report.moved > 0
    assert field.GetArray("SmoothingSeconds").GetValue(0) == smoothing.report.seconds > 0


@pytest.mark.parametrize("cls", SMOOTHING)
@pytest.mark.parametrize(
    ("dtype", "precision", "expected"),
    [
        (np.float32, "default", np.float32),
        (np.float64, "default", np.float64),
        (np.float32, "double", np.float64),
        (np.float64, "single", np.float32),
    ],
)
def test_precision(cls: type, dtype: type, precision: str, expected: type) -> None:
    assert points_of(cls(output_points_precision=precision)(plane(dtype=dtype))).dtype == expected


@pytest.mark.parametrize("scale", [1e-60, 1e60])
def test_what_single_precision_cannot_hold_is_refused(scale: float) -> None:
    mesh = plane(dtype=np.float64)
    mesh.GetPoints().SetData(vtk_array(scale * points_of(mesh), "Points"))
    assert np.isfinite(points_of(TrapeziumDrawing()(mesh))).all()
    with pytest.raises(ParameterError, match="output_points_precision to double"):
        TrapeziumDrawing(output_points_precision="single")(mesh)


@pytest.mark.parametrize("cls", FILTERS)
def test_the_ends_of_all_ranges_work_or_are_refused(cls: type) -> None:
    mesh = bumpy()
    for name, parameter in cls.parameters().items():
        ends = {parameter.low, parameter.high} - {None}
        if parameter.low is not None and parameter.high is None and parameter.type is float:
            ends |= {np.nextafter(parameter.low, np.inf), 1e300}
        if parameter.low is not None and parameter.high is None and parameter.type is int:
            ends |= {2**31, 2**63} if name != "iterations" else set()
        for value in ends:
            algorithm = cls(**{"iterations": 2} if "iterations" in cls.parameters() else {})
            setattr(algorithm, name, value)
            # A refusal is ours; anything else is an error here.
            with contextlib.suppress(VtksmoothError):
                made = algorithm(mesh, *[bumpy(2.0)] * (len(cls.inputs) - 1))
                points = points_of(made[0] if isinstance(made, tuple) else made)
                assert np.isfinite(points).all(), (name, value)


def test_single_precision_is_computed_in_double() -> None:
    mesh = plane(dtype=np.float32)
    single = points_of(TrapeziumDrawing()(mesh))
    double = points_of(TrapeziumDrawing(output_points_precision="double")(mesh))
    np.testing.assert_array_equal(single, double.astype(np.float32))


def test_integer_points_give_real_ones() -> None:
    mesh, points = vtkPolyData(), vtkPoints()
    points.SetDataType(VTK_INT)
    for point in ((0, 0, 0), (4, 0, 0), (4, 4, 0), (0, 4, 0), (1, 1, 0)):
        points.InsertNextPoint(point)
    mesh.SetPoints(points)
    mesh.SetPolys(polydata(np.zeros((5, 3)), [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]).GetPolys())
    np.testing.assert_allclose(points_of(LaplacianSmoothing(iterations=60)(mesh))[4], [2, 2, 0], atol=1e-9)


def test_verts_lines_and_strips_beside_polygons() -> None:
    source = vtkPlaneSource()
    source.SetResolution(5, 5)
    triangles, stripper = vtkTriangleFilter(), vtkStripper()
    triangles.SetInputConnection(source.GetOutputPort())
    stripper.SetInputConnection(triangles.GetOutputPort())
    stripper.Update()
    triangles.Update()
    strips, flat = stripper.GetOutput(), triangles.GetOutput()
    assert strips.GetNumberOfStrips() > 0
    assert strips.GetNumberOfPolys() == 0
    points = points_of(flat).astype(np.float64)
    points[14, :2] += 0.05  # an inner point
    for mesh in (strips, flat):
        moved = vtkPoints()
        moved.SetData(numpy_to_vtk(points.copy(), deep=1))
        mesh.SetPoints(moved)
    extra = vtkCellArray()
    extra.InsertNextCell(1, [0])
    strips.SetVerts(extra)
    line = vtkCellArray()
    line.InsertNextCell(2, [0, 1])
    strips.SetLines(line)
    # The same triangles in another order: the same vertices move to the same places, up to rounding.
    a, b = (points_of(LaplacianSmoothing(iterations=3)(mesh)) for mesh in (strips, flat))
    np.testing.assert_allclose(a, b, atol=1e-12)
    quality = SurfaceQuality()
    result = quality(strips)
    k = vtk_to_numpy(result.GetCellData().GetArray("AspectRatio"))
    assert len(k) == strips.GetNumberOfCells()
    assert k[:2].tolist() == [1.0, 1.0]
    assert quality.summary["cells"]["triangle"] == 50
    other = SurfaceQuality()
    other(flat)
    assert quality.summary["aspect_ratio"]["min"] == pytest.approx(other.summary["aspect_ratio"]["min"])
    assert k[2:].min() == pytest.approx(other.summary["aspect_ratio"]["min"])


@pytest.mark.parametrize("bits", [32, 64])
def test_cell_arrays_of_every_storage(bits: int) -> None:
    mesh = plane()
    expected = surface_of(mesh).mesh
    (mesh.GetPolys().ConvertTo32BitStorage if bits == 32 else mesh.GetPolys().ConvertTo64BitStorage)()
    found = surface_of(mesh).mesh
    np.testing.assert_array_equal(found.offsets, expected.offsets)
    np.testing.assert_array_equal(found.connectivity, expected.connectivity)


def test_fixed_size_storage_without_offsets() -> None:
    source = vtkSphereSource()
    source.Update()
    mesh = source.GetOutput()
    expected = surface_of(mesh).mesh
    polygons = mesh.GetPolys()
    if not getattr(polygons, "ConvertToFixedSize64BitStorage", bool)():  # VTK 9.6 and later
        pytest.skip("this VTK has no fixed-size storage")
    found = surface_of(mesh).mesh
    np.testing.assert_array_equal(found.offsets, expected.offsets)
    np.testing.assert_array_equal(found.connectivity, expected.connectivity)


def test_points_are_shared_with_vtk() -> None:
    mesh = plane()
    assert np.shares_memory(surface_of(mesh).mesh.points, vtk_to_numpy(mesh.GetPoints().GetData()))


# -- fixed points --------------------------------------------------------------------------------


def test_fixed_array_pins_bit_for_bit() -> None:
    mesh = plane()
    mask = np.zeros(mesh.GetNumberOfPoints(), np.uint8)
    mask[[20, 40, 41]] = 1
    for name in ("Fixed", "held"):
        array = numpy_to_vtk(mask, deep=1)
        array.SetName(name)
        mesh.GetPointData().AddArray(array)
        before = points_of(mesh)
        parameters = {} if name == "Fixed" else {"fixed": name}
        after = points_of(LaplacianSmoothing(**parameters)(mesh))
        np.testing.assert_array_equal(after[mask == 1], before[mask == 1])
        assert (after != before).any()
        mesh.GetPointData().RemoveArray(name)


def test_missing_or_wrong_fixed_array_is_said() -> None:
    mesh = with_data(plane())
    with pytest.raises(ParameterError, match=r"no point array 'helt'.*number"):
        LaplacianSmoothing(fixed="helt")(mesh)
    vectors = numpy_to_vtk(np.zeros((mesh.GetNumberOfPoints(), 3)), deep=1)
    vectors.SetName("Fixed")
    mesh.GetPointData().AddArray(vectors)
    with pytest.raises(InvalidMeshError, match="one value for each point"):
        LaplacianSmoothing()(mesh)
    assert LaplacianSmoothing(fixed=None)(mesh).GetNumberOfPoints() == mesh.GetNumberOfPoints()


def with_constraints(mesh: vtkPolyData, values: Any) -> vtkPolyData:
    array = numpy_to_vtk(np.asarray(values, float), deep=1)
    array.SetName("SmoothingConstraints")
    result = vtkPolyData()
    result.ShallowCopy(mesh)
    result.GetPointData().AddArray(array)
    return result


def test_smoothing_constraints_mean_what_they_mean_to_vtk() -> None:
    rng = np.random.default_rng(4)
    mesh = plane(seed=4)
    distances = rng.choice([0.0, 0.02, 1000.0], mesh.GetNumberOfPoints())
    mesh = with_constraints(mesh, distances)
    native = vtkConstrainedSmoothingFilter()
    native.SetInputData(mesh)
    native.SetRelaxationFactor(0.5)
    native.Update()
    for result in (native.GetOutput(), LaplacianSmoothing()(mesh)):
        displacement = np.linalg.norm(points_of(result) - points_of(mesh), axis=1)
        assert (displacement <= distances + 1e-7).all()
        assert displacement[distances == 0.02].max() == pytest.approx(0.02, abs=1e-6)
        assert displacement[distances == 1000.0].max() > 0.02
    free = points_of(LaplacianSmoothing(max_displacement=None)(mesh))
    assert np.linalg.norm(free - points_of(mesh), axis=1)[distances == 0.0].max() > 0.02


def test_wrong_smoothing_constraints_are_said() -> None:
    mesh = plane()
    for wrong in (-1.0, np.nan):
        constraints = np.full(mesh.GetNumberOfPoints(), 0.1)
        constraints[7] = wrong
        with pytest.raises(InvalidMeshError, match="'SmoothingConstraints' must hold distances, 0 or more"):
            LaplacianSmoothing()(with_constraints(mesh, constraints))
    with pytest.raises(ParameterError, match=r"max_displacement: there is no point array 'far'"):
        LaplacianSmoothing(max_displacement="far")(mesh)


# -- errors --------------------------------------------------------------------------------------

TRIANGLE = [[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]
BAD = {
    "empty": (vtkPolyData(), "no points"),
    "no faces": (polydata(TRIANGLE, []), "no faces"),
    "nan": (polydata([[0, 0, 0], [1, 0, 0], [np.nan, 1, 0]], [[0, 1, 2]]), "NaN"),
    "inf": (polydata([[0, 0, 0], [1, 0, 0], [np.inf, 1, 0]], [[0, 1, 2]]), "infinite"),
    "index": (polydata(TRIANGLE, [[0, 1, 7]]), "point 7"),
    "negative": (polydata(TRIANGLE, [[0, 1, -2]]), "point -2"),
}


@pytest.mark.parametrize("cls", [*SMOOTHING, SurfaceQuality])
@pytest.mark.parametrize("case", BAD)
def test_bad_input_raises_every_time_and_speaks_vtk(cls: type, case: str) -> None:
    mesh, message = BAD[case]
    algorithm, heard = cls(), []
    observer = algorithm.AddObserver("ErrorEvent", _hear(heard))
    for _ in range(2):
        with pytest.raises(InvalidMeshError, match=message):
            algorithm(mesh)
    assert message in heard[0]
    # From downstream: VTK's error, an empty output, no exception.
    normals = vtkPolyDataNormals()
    normals.SetInputConnection(algorithm.GetOutputPort())
    normals.AddObserver("ErrorEvent", lambda *_: None)
    algorithm.GetExecutive().AddObserver("ErrorEvent", lambda *_: None)
    normals.GetExecutive().AddObserver("ErrorEvent", lambda *_: None)
    algorithm.Modified()
    normals.Update()
    assert normals.GetOutput().GetNumberOfPoints() == 0
    # And it recovers.
    algorithm.RemoveObserver(observer)
    assert algorithm(plane()).GetNumberOfPoints() == 81
    assert algorithm.last_error is None


def _hear(heard: list[str]) -> Any:
    def observer(_caller: object, _event: str, message: str) -> None:
        heard.append(message)

    observer.CallDataType = "string0"  # type: ignore[attr-defined]
    return observer


def test_wrong_number_of_inputs() -> None:
    with pytest.raises(TypeError, match="result, original"):
        SurfaceComparison()(plane())


# -- composite data ------------------------------------------------------------------------------


def blocks(*leaves: Any) -> vtkMultiBlockDataSet:
    result = vtkMultiBlockDataSet()
    for i, leaf in enumerate(leaves):
        result.SetBlock(i, leaf)
    return result


def test_composite_is_smoothed_leaf_by_leaf() -> None:
    inner = blocks(plane(seed=2), vtkPolyData(), None)
    smoothing, seen = TrapeziumDrawing(), []
    smoothing.AddObserver("ProgressEvent", lambda *_: seen.append(smoothing.GetProgress()))
    result = smoothing(blocks(plane(seed=3), inner))
    assert seen == sorted(seen)
    for found, seed in ((result.GetBlock(0), 3), (result.GetBlock(1).GetBlock(0), 2)):
        np.testing.assert_array_equal(points_of(found), points_of(TrapeziumDrawing()(plane(seed=seed))))
    assert result.GetBlock(1).GetBlock(1).GetNumberOfPoints() == 0
    assert result.GetBlock(1).GetBlock(2) is None


def test_partitioned_collection_keeps_its_type() -> None:
    data = vtkPartitionedDataSetCollection()
    data.SetPartition(0, 0, plane())
    result = LaplacianSmoothing()(data)
    assert isinstance(result, vtkPartitionedDataSetCollection)
    assert result.GetPartition(0, 0).GetNumberOfPoints() == 81


def test_a_bad_leaf_is_named() -> None:
    with pytest.raises(InvalidMeshError, match=r"Block 2: .*NaN"):
        TrapeziumDrawing()(blocks(plane(), BAD["nan"][0]))


def test_comparison_of_composites() -> None:
    original = blocks(plane(seed=4), plane(seed=5))
    result = SurfaceComparison()(LaplacianSmoothing()(original), original)
    assert result.GetBlock(1).GetPointData().GetArray("Deviation").GetNumberOfTuples() == 81
    with pytest.raises(InvalidMeshError, match="Input 2 is composite"):
        SurfaceComparison()(plane(), original)


def test_a_second_input_that_is_no_composite_belongs_to_every_block() -> None:
    result = SurfaceComparison()(blocks(plane(seed=4), vtkPolyData(), plane(seed=5)), plane(seed=6))
    for block, seed in ((0, 4), (2, 5)):
        found = vtk_to_numpy(result.GetBlock(block).GetPointData().GetArray("Displacement"))
        np.testing.assert_array_equal(found, points_of(plane(seed=seed)) - points_of(plane(seed=6)))


# -- measures ------------------------------------------------------------------------------------


def cube() -> vtkPolyData:
    source = vtkCubeSource()
    source.Update()
    return polydata(
        [[x, y, z] for z in (0.0, 1.0) for y in (0.0, 1.0) for x in (0.0, 1.0)],
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]],
    )


def test_quality_of_a_cube() -> None:
    quality = SurfaceQuality()
    k = vtk_to_numpy(quality(cube()).GetCellData().GetArray("AspectRatio"))
    np.testing.assert_allclose(k, 1.0, rtol=1e-14)
    assert quality.summary["cells"] == {"triangle": 0, "quad": 6, "polygon": 0}
    assert quality.summary["closed"] is True
    assert quality.summary["volume"] == pytest.approx(1.0, rel=1e-14)
    assert quality.summary["inverted"] == 0
    assert quality.summary["aspect_ratio"]["histogram"] == [0, 0, 0, 0, 0, 100]


def test_comparison_of_a_stretched_cube() -> None:
    original, result = cube(), cube()
    points = points_of(original) * [1.0, 1.0, 1.5]
    stretched = vtkPoints()
    stretched.SetData(numpy_to_vtk(points, deep=1))
    result.SetPoints(stretched)
    comparison = SurfaceComparison()
    output = comparison(result, original)
    summary = comparison.summary
    assert summary["volume_change_percent"] == pytest.approx(50.0)
    assert summary["swept_volume"] == pytest.approx(0.5)
    assert summary["deviation"]["max"] == pytest.approx(0.5)
    assert summary["deviation"]["max_relative"] == pytest.approx(0.5 / np.sqrt(3))
    assert summary["dihedral_change"]["max"] == pytest.approx(0.0, abs=1e-9)
    displacement = vtk_to_numpy(output.GetPointData().GetArray("Displacement"))
    np.testing.assert_array_equal(displacement, points - points_of(original))


def test_deviation_there_and_back() -> None:
    original = pv.Icosphere(nsub=3)
    original.points += np.random.default_rng(0).normal(scale=0.03, size=original.points.shape)
    result = pv.wrap(LaplacianSmoothing(iterations=5)(original))
    comparison = SurfaceComparison()
    deviation = vtk_to_numpy(comparison(result, original).GetPointData().GetArray("Deviation"))
    surfaces = [surface_of(mesh).mesh for mesh in (original, result)]
    expected = [ClosestPoint(a).query(b.points)[1] for a, b in (surfaces, surfaces[::-1])]
    np.testing.assert_array_equal(deviation, expected[0])
    found = comparison.summary["deviation"]
    for figures, distances in zip((found, found["back"]), expected, strict=True):
        assert figures["max"] == distances.max()
        assert figures["mean"] == pytest.approx(distances.mean())
        for part in ("max", "mean"):
            assert figures[f"{part}_relative"] == pytest.approx(figures[part] / surfaces[0].diagonal)
    # Peaks are smoothed away: the way back is longer.
    assert found["back"]["max"] > found["max"]


def test_the_bound_on_the_deviation_shows_in_the_comparison() -> None:
    original = pv.Icosphere(nsub=3)
    original.points += np.random.default_rng(0).normal(scale=0.03, size=original.points.shape)
    result = LaplacianSmoothing(iterations=20, max_deviation_fraction=0.005)(original)
    comparison = SurfaceComparison()
    comparison(result, original)
    found = comparison.summary["deviation"]
    assert 0.0045 < found["max_relative"] <= 0.005 * (1 + 1e-5)  # points are rounded to single precision
    assert found["back"]["max_relative"] > 0.006


def test_comparison_with_itself_is_zero() -> None:
    comparison = SurfaceComparison()
    comparison(cube(), cube())
    for key in ("normal_deviation", "dihedral_change", "deviation"):
        assert comparison.summary[key]["max"] == 0.0
        assert comparison.summary[key]["mean"] == 0.0


@pytest.mark.parametrize("faces", [[[0]], [[0, 1]], [[0, 1], [2]]])
def test_comparison_of_faces_that_are_no_surface(faces: list[list[int]]) -> None:
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    comparison = SurfaceComparison()
    output = comparison(polydata(points + 1.0, faces), polydata(points, faces))
    nothing = {"max": 0.0, "mean": 0.0, "max_relative": 0.0, "mean_relative": 0.0}
    assert comparison.summary["deviation"] == nothing | {"back": nothing}
    assert not vtk_to_numpy(output.GetPointData().GetArray("Deviation")).any()


def test_errors_are_one_line_whatever_names_they_quote() -> None:
    mesh = plane()
    mesh.GetPointData().AddArray(vtk_array(np.zeros(mesh.GetNumberOfPoints()), "two\nlines"))
    with pytest.raises(ParameterError, match=r"the mesh has: two lines\.$"):
        TrapeziumDrawing(fixed="none such")(mesh)


def test_the_mean_dihedral_change_of_an_open_mesh_is_over_its_inner_edges() -> None:
    flat, bent = plane(), plane()
    points = points_of(flat).copy()
    random = np.random.default_rng(0).normal(scale=0.01, size=len(points))
    points[:, 2] += random
    raised = vtkPoints()
    raised.SetData(numpy_to_vtk(points, deep=1))
    bent.SetPoints(raised)
    comparison = SurfaceComparison()
    output = comparison(bent, flat)
    before, after = surface_of(flat).mesh, surface_of(bent).mesh
    old, new = reference.dihedral_angles(before), reference.dihedral_angles(after)
    expected = np.mean([abs(new[edge] - old[edge]) for edge in old])
    assert comparison.summary["dihedral_change"]["mean"] == pytest.approx(expected, rel=1e-6)
    for name in ("DihedralChange", "NormalDeviation"):
        assert np.isfinite(vtk_to_numpy(output.GetPointData().GetArray(name))).all()


def test_open_meshes_have_no_volume() -> None:
    comparison = SurfaceComparison()
    comparison(plane(seed=1), plane(seed=2))
    assert comparison.summary["volume"] is None
    assert comparison.summary["volume_change_percent"] is None


def test_comparison_needs_the_same_faces() -> None:
    other = plane()
    other.SetPolys(cube().GetPolys())
    with pytest.raises(InvalidMeshError, match="same points and faces"):
        SurfaceComparison()(plane(), other)
    turned = polydata(TRIANGLE, [[0, 2, 1]])
    with pytest.raises(InvalidMeshError, match="join other points"):
        SurfaceComparison()(polydata(TRIANGLE, [[0, 1, 2]]), turned)


def test_volume_is_reported_before_and_after_rounding() -> None:
    source = vtkSphereSource()
    source.Update()
    smoothing = LaplacianSmoothing(iterations=3)
    smoothing(source.GetOutput())
    before, after = smoothing.report.volume
    assert after < before
    assert smoothing.report.volume_rounded != after
    assert smoothing.report.volume_rounded == pytest.approx(after, rel=1e-5)
