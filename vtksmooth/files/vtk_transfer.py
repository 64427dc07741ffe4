"""Polydata as plain arrays and a description of them, to be sent from one process to another."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt
from vtkmodules.util.numpy_support import get_numpy_array_type, vtk_to_numpy
from vtkmodules.vtkCommonCore import (
    VTK_BIT,
    VTK_DOUBLE,
    VTK_FLOAT,
    VTK_ID_TYPE,
    VTK_UNSIGNED_CHAR,
    vtkBitArray,
    vtkDataArray,
    vtkInformationIterator,
    vtkInformationKeyLookup,
    vtkPoints,
    vtkStringArray,
    vtkUnsignedCharArray,
)
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkDataSetAttributes, vtkPolyData

from .damage import plain, text

Values = npt.NDArray[Any]

CELLS = ("Verts", "Lines", "Polys", "Strips")
DATA = ("PointData", "CellData", "FieldData")

#: Kinds of what may be said of an array, its unit for example, that are kept.
_KEYS = ("vtkInformationDoubleKey", "vtkInformationIntegerKey", "vtkInformationStringKey")


def pack(mesh: vtkPolyData) -> tuple[dict[str, Any], list[Values]]:
    """Return what JSON can hold of a polydata, and its arrays.

    Points of other than float32 and float64 become float64.
    """
    arrays: list[Values] = []

    def put(values: Values) -> tuple[int, ...]:
        arrays.append(np.ascontiguousarray(values))
        return arrays[-1].shape

    points = vtk_to_numpy(mesh.GetPoints().GetData()) if mesh.GetNumberOfPoints() else np.empty((0, 3))
    if points.dtype != np.float32:
        points = points.astype(np.float64, copy=False)
    type_ = VTK_FLOAT if points.dtype == np.float32 else VTK_DOUBLE
    description: dict[str, Any] = {"type": type_, "points": put(points)}
    for kind in CELLS:
        cells = getattr(mesh, f"Get{kind}")()
        if cells is not None and cells.GetNumberOfCells():
            description[kind] = [put(values) for values in plain(cells)]
    for kind in DATA:
        data = getattr(mesh, f"Get{kind}")()
        description[kind] = [
            _description(data.GetAbstractArray(i), put) for i in range(data.GetNumberOfArrays())
        ]
        if kind != "FieldData":
            description[f"{kind}Attributes"] = [
                [i, attribute]
                for attribute in range(vtkDataSetAttributes.NUM_ATTRIBUTES)
                for i in range(data.GetNumberOfArrays())
                if data.GetAbstractArray(i) is data.GetAbstractAttribute(attribute)
            ]
    return description, arrays


def unpack(description: dict[str, Any], get: Callable[[Values], None]) -> vtkPolyData:
    """Return the polydata that :func:`pack` has described; `get` fills one array after the other.

    It is not checked.
    """

    def take(shape: list[int], type_: int) -> Any:
        # NumPy raises an exception where there is no memory, and VTK ends the process.
        np.empty(shape, get_numpy_array_type(type_))
        count, *width = shape
        array = vtkDataArray.CreateDataArray(type_)
        array.SetNumberOfComponents(*width or (1,))
        array.SetNumberOfTuples(count)
        if count:
            get(vtk_to_numpy(array))
        return array

    mesh = vtkPolyData()
    points = vtkPoints()
    points.SetData(take(description["points"], description["type"]))
    mesh.SetPoints(points)
    for kind in CELLS:
        if kind in description:
            offsets, corners = (take(shape, VTK_ID_TYPE) for shape in description[kind])
            cells = vtkCellArray()
            cells.SetData(offsets, corners)
            getattr(mesh, f"Set{kind}")(cells)
    for kind in DATA:
        data = getattr(mesh, f"Get{kind}")()
        for how in description[kind]:
            data.AddArray(_array(how, take))
        for i, attribute in description.get(f"{kind}Attributes", ()):
            data.SetActiveAttribute(i, attribute)
    return mesh


def _values(array: vtkDataArray) -> Values:
    if array.GetDataType() == VTK_BIT:
        octets = vtkUnsignedCharArray()
        octets.DeepCopy(array)
        array = octets
    values: Values = vtk_to_numpy(array)
    return values


def _description(array: Any, put: Callable[[Values], tuple[int, ...]]) -> dict[str, Any]:
    """Say what an array is, and put its values among those that are sent."""
    components = array.GetNumberOfComponents()
    names = [text(array.GetComponentName(i)) for i in range(components)] if array.HasAComponentName() else []
    described = {"name": text(array.GetName()), "components": names, "keys": _keys(array)}
    if isinstance(array, vtkDataArray):
        return described | {"type": array.GetDataType(), "values": put(_values(array))}
    count = array.GetNumberOfValues()
    words = (
        (array.GetValue(i) for i in range(count))
        if isinstance(array, vtkStringArray)
        else (array.GetVariantValue(i).ToString() for i in range(count))
    )
    return described | {"width": components, "texts": [text(word) for word in words]}


def _array(how: dict[str, Any], take: Callable[[list[int], int], Any]) -> Any:
    if "texts" in how:
        array: Any = vtkStringArray()
        array.SetNumberOfComponents(how["width"])
        array.SetNumberOfValues(len(how["texts"]))
        for i, word in enumerate(how["texts"]):
            array.SetValue(i, word)
    elif how["type"] == VTK_BIT:
        array = vtkBitArray()
        array.DeepCopy(take(how["values"], VTK_UNSIGNED_CHAR))
    else:
        array = take(how["values"], how["type"])
    if how["name"] is not None:
        array.SetName(how["name"])
    for i, name in enumerate(how["components"]):
        if name is not None:
            array.SetComponentName(i, name)
    for name, location, value in how["keys"]:
        key = vtkInformationKeyLookup.Find(name, location)
        if key is not None:
            array.GetInformation().Set(key, value)
    return array


def _keys(array: Any) -> list[tuple[str, str, Any]]:
    """Return what is said of an array beside its name: name and place of each key, and its value."""
    if not array.HasInformation():
        return []
    iterator = vtkInformationIterator()
    iterator.SetInformation(array.GetInformation())
    iterator.InitTraversal()
    found = []
    while not iterator.IsDoneWithTraversal():
        key = iterator.GetCurrentKey()
        if key.GetClassName() in _KEYS:
            value = array.GetInformation().Get(key)
            found.append(
                (key.GetName(), key.GetLocation(), text(value) if isinstance(value, bytes) else value)
            )
        iterator.GoToNextItem()
    return found
