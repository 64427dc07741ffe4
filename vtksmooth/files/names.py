"""Names of arrays that are no text: old files have them in Latin-1, and VTK passes them on as bytes."""

from __future__ import annotations

from typing import Any

from ..filters.arrays import name_of


def _arrays(mesh: Any) -> list[Any]:
    homes = (mesh.GetPointData(), mesh.GetCellData(), mesh.GetFieldData())
    return [data.GetAbstractArray(i) for data in homes for i in range(data.GetNumberOfArrays())]


def decode(mesh: Any) -> None:
    """Give the arrays of a VTK data set names that are text."""
    for array in _arrays(mesh):
        if isinstance(array.GetName(), bytes):
            array.SetName(name_of(array))


def decoded(mesh: Any) -> Any:
    """Return a mesh whose arrays have names that are text: itself, or a copy."""
    if not any(isinstance(array.GetName(), bytes) for array in _arrays(mesh)):
        return mesh
    copy = mesh.NewInstance()
    copy.DeepCopy(mesh)
    decode(copy)
    return copy
