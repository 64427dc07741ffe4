"""What is handed to VTK: memory of numpy's, or VTK's own arrays, and never a view of VTK's memory."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import pyvista as pv
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkDoubleArray
from vtkmodules.vtkCommonDataModel import vtkPolyData

from vtksmooth.files import read_surface, write_surface
from vtksmooth.filters import FILTERS, arrays
from vtksmooth.filters.arrays import vtk_array, vtk_points
from vtksmooth.samples import channel
from vtksmooth.warm_up import bump, space_over


def in_double_precision(mesh: vtkPolyData) -> vtkPolyData:
    """The mesh with coordinates that kernels take without a copy, in memory of VTK's own."""
    points = vtkDoubleArray()
    points.DeepCopy(mesh.GetPoints().GetData())
    mesh.GetPoints().SetData(points)
    return mesh


def kept_alive(array: Any) -> Iterator[np.ndarray]:
    """The numpy arrays that a VTK array keeps alive: in its dictionary, since VTK 9.6 in its buffer's."""
    holders = [array, *([array.GetBuffer()] if hasattr(array, "GetBuffer") else [])]
    for holder in holders:
        for value in vars(holder).values():
            if isinstance(value, np.ndarray):
                yield value


def chain(values: Any) -> Iterator[Any]:
    """What holds the memory of a numpy array, from the array on."""
    while values is not None:
        yield values
        values = values.obj if isinstance(values, memoryview) else getattr(values, "base", None)


def of_vtk(values: np.ndarray) -> bool:
    return any(type(owner).__module__.startswith("vtkmodules") for owner in chain(values))


def arrays_of(data: Any) -> Iterator[Any]:
    if data.GetPoints() is not None:
        yield data.GetPoints().GetData()
    for cells in (data.GetVerts(), data.GetLines(), data.GetPolys(), data.GetStrips()):
        yield from filter(None, (cells.GetOffsetsArray(), cells.GetConnectivityArray()))
    for fields in (data.GetPointData(), data.GetCellData(), data.GetFieldData()):
        yield from (fields.GetAbstractArray(i) for i in range(fields.GetNumberOfArrays()))


def chains_in(data: Any) -> list[str]:
    """The names of the arrays of a polydata that keep other VTK arrays alive."""
    return [a.GetName() or "?" for a in arrays_of(data) if any(map(of_vtk, kept_alive(a)))]


@pytest.mark.parametrize(
    "view",
    [
        lambda a: a,
        lambda a: a[1:4],
        lambda a: a.reshape(-1),
        lambda a: memoryview(np.ascontiguousarray(a)),
        lambda a: pv.pyvista_ndarray(a),
        lambda a: np.asarray(pv.pyvista_ndarray(a)[2:]),
        lambda a: np.frombuffer(a, np.uint8),
    ],
)
def test_views_of_vtk_memory_are_copied(view: Any) -> None:
    values = np.asarray(view(vtk_to_numpy(in_double_precision(bump(6, "mixed")).GetPoints().GetData())))
    assert of_vtk(values)
    array = vtk_array(values, "x")
    assert not any(map(of_vtk, kept_alive(array)))
    assert not np.shares_memory(vtk_to_numpy(array), values)
    np.testing.assert_array_equal(vtk_to_numpy(array), values)


@pytest.mark.parametrize(
    "values",
    [
        np.arange(12.0).reshape(4, 3),
        np.arange(24.0).reshape(8, 3)[2:5],
        np.frombuffer(bytes(96), np.float64).reshape(4, 3),
    ],
)
def test_memory_of_numpy_is_shared(values: np.ndarray) -> None:
    for array in (vtk_array(values), vtk_points(values).GetData()):
        assert np.shares_memory(vtk_to_numpy(array), values)


def test_memory_of_a_subclass_of_arrays_is_copied() -> None:
    # pyvista's arrays may keep the VTK array alive in an attribute.
    copied = vtk_array(pv.Sphere().points[[1, 2, 3]])
    assert all(type(owner) is np.ndarray for kept in kept_alive(copied) for owner in chain(kept))


@pytest.mark.parametrize("cls", FILTERS, ids=lambda cls: cls.__name__)
def test_filters_hand_on_no_views_of_vtk_memory(cls: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    handed: list[np.ndarray] = []

    def hand_over(values: np.ndarray, *arguments: Any) -> Any:
        handed.append(values)
        return numpy_to_vtk(values, *arguments)

    monkeypatch.setattr(arrays, "numpy_to_vtk", hand_over)
    mesh, space = (in_double_precision(polydata) for polydata in (bump(6, "triangles"), space_over(6)))
    seen = 0
    for setting in ({}, {"flow": "Flow", "features": "hold", "ridge_angle": 40.0}):
        algorithm = cls(**{name: value for name, value in setting.items() if name in cls.parameters()})
        results = algorithm(*(space if name == "installation" else mesh for name in cls.inputs))
        for result in results if isinstance(results, tuple) else (results,):
            seen += sum(len(list(kept_alive(array))) for array in arrays_of(result))
            assert chains_in(result) == []
    assert not any(map(of_vtk, handed))
    assert seen  # otherwise this test looks in the wrong place


@pytest.mark.parametrize("extension", [".vtp", ".vtk", ".ply", ".obj", ".off", ".stl"])
def test_files_make_meshes_that_keep_no_other_vtk_array_alive(extension: str, tmp_path: Path) -> None:
    path = tmp_path / f"mesh{extension}"
    write_surface(pv.Sphere(theta_resolution=8, phi_resolution=8), path)
    assert chains_in(read_surface(path)[0]) == []


def test_samples_keep_no_other_vtk_array_alive() -> None:
    assert [chains_in(mesh) for mesh in channel()] == [[], []]
