"""Polydata to arrays and back, without copies where VTK allows it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkIdTypeArray, vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkCellData, vtkFieldData, vtkPolyData

from ..errors import InvalidMeshError, ParameterError
from ..kernels.mesh.mesh import Mesh

Int = npt.NDArray[np.integer[Any]]


@dataclass(frozen=True)
class Surface:
    """The faces of a polydata, and which cell each belongs to.

    Attributes
    ----------
    mesh : Mesh
        Polygons first, then the triangles of the strips.
    cells : (m,) int64
        Number of each face's cell in the polydata.
    n_cells : int
        Cells of the polydata: verts, lines, polygons and strips.
    """

    mesh: Mesh
    cells: npt.NDArray[np.int64]
    n_cells: int


def points_of(polydata: Any) -> npt.NDArray[Any]:
    """Return the points, (n, 3); shared with VTK, so never write to them."""
    points = polydata.GetPoints()
    if points is None or points.GetNumberOfPoints() == 0:
        return np.empty((0, 3))
    data: npt.NDArray[Any] = vtk_to_numpy(points.GetData())
    return data


def cells_of(cells: Any) -> tuple[Int, Int]:
    """Return offsets and connectivity of a vtkCellArray; shared with VTK where its storage is plain."""
    size = cells.IsHomogeneous()
    connectivity = cells.GetConnectivityArray()
    try:
        corners = vtk_to_numpy(connectivity)
    except (AttributeError, TypeError, ValueError, AssertionError):
        # Implicit or generic storage: VTK has no buffer to share.
        plain = vtkIdTypeArray()
        plain.DeepCopy(connectivity)
        corners = vtk_to_numpy(plain)
    if size > 0:
        return np.arange(0, len(corners) + 1, size, dtype=np.int32), corners
    offsets = cells.GetOffsetsArray()
    if cells.GetNumberOfCells() == 0 or offsets is None:
        return np.zeros(1, np.int32), np.empty(0, np.int32)
    return vtk_to_numpy(offsets), corners


def surface_of(polydata: Any) -> Surface:
    """Return the surface of a vtkPolyData.

    Raises
    ------
    InvalidMeshError
        See :meth:`~vtksmooth.kernels.mesh.mesh.Mesh.from_arrays`.
    """
    offsets, corners = cells_of(polydata.GetPolys())
    before = polydata.GetNumberOfVerts() + polydata.GetNumberOfLines()
    cells = before + np.arange(len(offsets) - 1, dtype=np.int64)
    if polydata.GetNumberOfStrips():
        triangles, strips = strip_triangles(*cells_of(polydata.GetStrips()))
        start = int(offsets[-1])
        more = start + 3 * np.arange(1, len(triangles) + 1, dtype=np.int64)
        offsets = np.concatenate((offsets, more))
        cells = np.concatenate((cells, before + polydata.GetNumberOfPolys() + strips))
        corners = np.concatenate((corners, triangles.ravel()))
    return Surface(
        Mesh.from_arrays(points_of(polydata), offsets, corners), cells, polydata.GetNumberOfCells()
    )


def strip_triangles(offsets: Int, corners: Int) -> tuple[Int, npt.NDArray[np.int64]]:
    """Return the triangles of strips, (t, 3), and the number of each one's strip."""
    # A strip p0 p1 p2 p3 ... is (p0 p1 p2), (p2 p1 p3), (p2 p3 p4), ...: every second one turned.
    triangles = []
    strips = []
    for i in range(len(offsets) - 1):
        strip = corners[offsets[i] : offsets[i + 1]]
        if len(strip) < 3:
            continue
        rows = np.column_stack((strip[:-2], strip[1:-1], strip[2:]))
        rows[1::2] = rows[1::2][:, [1, 0, 2]]
        triangles.append(rows)
        strips.append(np.full(len(rows), i, np.int64))
    if not triangles:
        return np.empty((0, 3), np.int64), np.empty(0, np.int64)
    return np.concatenate(triangles), np.concatenate(strips)


def _owned_by_numpy(values: npt.NDArray[Any]) -> bool:
    """Return whether nothing but numpy, or Python itself, holds the memory of `values`."""
    owner: Any = values
    while type(owner) is np.ndarray and owner.base is not None:
        owner = owner.base
    return type(owner) in (np.ndarray, bytes)


def vtk_array(values: npt.NDArray[Any], name: str = "") -> Any:
    """Return a VTK array over the memory of `values`, which it keeps alive.

    A view of VTK's memory is copied. VTK up to 9.5 frees memory twice when an array dies that keeps alive a
    NumPy array which in turn keeps alive another VTK array. Nothing else in the package may call
    ``numpy_to_vtk``.
    """
    values = np.ascontiguousarray(values)
    array = numpy_to_vtk(values if _owned_by_numpy(values) else np.array(values))
    if name:
        array.SetName(name)
    return array


def vtk_points(points: npt.NDArray[Any]) -> Any:
    """Return vtkPoints over the memory of `points` (float32 or float64), as :func:`vtk_array` does."""
    result = vtkPoints()
    result.SetData(vtk_array(points))
    return result


def vtk_cells(offsets: Int, corners: Int) -> Any:
    """Return a vtkCellArray of cells whose corners are ``corners[offsets[i]:offsets[i + 1]]``."""
    cells = vtkCellArray()
    cells.SetData(_ids(offsets), _ids(corners))
    return cells


def _ids(values: Int) -> Any:
    """Return a copy of `values` in VTK's own type for indices: others it keeps as slow "generic" storage.

    In memory of its own, as VTK 9.2 takes the memory out of the arrays of cells; numpy fills it, which lets
    other threads run meanwhile.
    """
    array = vtkIdTypeArray()
    array.SetNumberOfValues(len(values))
    vtk_to_numpy(array)[:] = values
    return array


def vtk_triangles(triangles: Int) -> Any:
    """Return a vtkCellArray of (t, 3) `triangles`."""
    return vtk_cells(np.arange(0, 3 * len(triangles) + 1, 3), np.ascontiguousarray(triangles).ravel())


def point_array(polydata: Any, name: str, components: int = 1) -> npt.NDArray[Any] | None:
    """Return the point array `name`, or None where there is none of that name.

    Raises
    ------
    InvalidMeshError
        The array has another number of components, or another length than the points.
    """
    array = polydata.GetPointData().GetArray(name)
    if array is None:
        return None
    values: npt.NDArray[Any] = vtk_to_numpy(array)
    shape = (polydata.GetNumberOfPoints(), components)[:components]
    if values.shape != shape:
        what = "one value" if components == 1 else f"{components} values"
        raise InvalidMeshError(
            f"The point array {name!r} has the shape {values.shape}; it must hold {what} for each point."
        )
    return values


def vectors_at_points(polydata: Any, name: str) -> npt.NDArray[np.float64]:
    """Return the array `name` as a vector at each point, (n, 3); that of cells is averaged at their corners.

    Raises
    ------
    ParameterError
        There is no point or cell array of that name.
    InvalidMeshError
        The array does not hold three finite components for each point or cell.
    """
    homes = {"point": polydata.GetPointData(), "cell": polydata.GetCellData()}
    kind = next((kind for kind, data in homes.items() if data.GetArray(name) is not None), None)
    if kind is None:
        names = {
            name_of(data.GetAbstractArray(i)) or "(unnamed)"
            for data in homes.values()
            for i in range(data.GetNumberOfArrays())
        }
        raise ParameterError(
            f"There is no array {name!r} on the points or cells; the mesh has: "
            f"{', '.join(sorted(names)) or 'no arrays'}."
        )
    values = vtk_to_numpy(homes[kind].GetArray(name))
    count = polydata.GetNumberOfPoints() if kind == "point" else polydata.GetNumberOfCells()
    if values.shape != (count, 3):
        raise InvalidMeshError(
            f"The array {name!r} has the shape {values.shape}; it must hold a vector for each of the "
            f"{count} {kind}s."
        )
    if not np.isfinite(values).all():
        raise InvalidMeshError(f"The array {name!r} holds NaN or infinite numbers; replace them, by 0 say.")
    if kind == "point":
        return np.ascontiguousarray(values, dtype=np.float64)
    surface = surface_of(polydata)
    at_corners = np.repeat(values[surface.cells].astype(np.float64), surface.mesh.face_sizes, axis=0)
    corners, n = surface.mesh.connectivity, surface.mesh.n_points
    total = [np.bincount(corners, weights=at_corners[:, axis], minlength=n) for axis in range(3)]
    used = np.maximum(1, np.bincount(corners, minlength=n))
    return np.ascontiguousarray(np.column_stack(total) / used[:, None])


def edge_array(polydata: Any, name: str) -> npt.NDArray[Any] | None:
    """Return the field array `name` as pairs of points, (k, 2), or None where there is none of that name.

    Raises
    ------
    InvalidMeshError
        The array does not hold pairs of integers.
    """
    array = polydata.GetFieldData().GetArray(name)
    if array is None:
        return None
    pairs: npt.NDArray[Any] = vtk_to_numpy(array)
    if pairs.dtype.kind not in "iu" or pairs.ndim != 2 or pairs.shape[1] != 2:
        raise InvalidMeshError(
            f"The field array {name!r} is {pairs.dtype} of the shape {pairs.shape}; it must hold a pair of "
            "point numbers for each edge."
        )
    return pairs


def name_of(array: Any) -> str:
    """Return the name of a VTK array; old files have names in Latin-1, which VTK gives as bytes."""
    name = array.GetName()
    return name.decode("latin-1") if isinstance(name, bytes) else name or ""


def point_array_names(polydata: Any) -> list[str]:
    """Return the names of the point arrays; empty where one has none."""
    data = polydata.GetPointData()
    return [name_of(data.GetAbstractArray(i)) for i in range(data.GetNumberOfArrays())]


def output_like(source: Any) -> vtkPolyData:
    """Return a new polydata that shares everything with `source`; its field data may be added to."""
    output = vtkPolyData()
    output.ShallowCopy(source)
    # VTK shares the *container* of field data between shallow copies.
    fields = vtkFieldData()
    fields.ShallowCopy(source.GetFieldData())
    output.SetFieldData(fields)
    return output


def rows_of(data: Any, rows: npt.NDArray[np.int64]) -> vtkCellData:
    """Return new cell data with the given rows of `data`."""
    result = vtkCellData()
    result.CopyAllOn()
    result.CopyAllocate(data, len(rows))
    for i in range(data.GetNumberOfArrays()):
        old = data.GetAbstractArray(i)
        new = result.GetAbstractArray(old.GetName()) if old.GetName() else result.GetAbstractArray(i)
        new.SetNumberOfTuples(len(rows))
        if old.IsNumeric() and not old.IsA("vtkBitArray"):
            vtk_to_numpy(new)[:] = vtk_to_numpy(old)[rows]
        else:
            for to, row in enumerate(rows.tolist()):
                new.SetTuple(to, row, old)
    return result
