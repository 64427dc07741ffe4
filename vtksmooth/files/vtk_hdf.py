"""What VTK's HDF files cannot hold of a mesh."""

from __future__ import annotations

import itertools
import re
from typing import Any

from vtkmodules.vtkCommonCore import vtkBitArray, vtkDataArray, vtkUnsignedCharArray

from .damage import text


def for_hdf(mesh: Any, name: str) -> tuple[Any, list[str]]:
    """Return a copy of a mesh that VTK's writer of HDF files writes without errors or silent losses.

    Texts at points or cells make the writer fail, it leaves out arrays of bits, and of two arrays whose names
    differ only in ``/`` and ``.``, which HDF's names cannot have, one takes the place of the other.

    Parameters
    ----------
    mesh : vtkPolyData
    name : str
        What notes call the file.

    Returns
    -------
    vtkPolyData
        Shares its arrays with `mesh`.
    list of str
        What was left out or renamed, one sentence each.
    """
    copy = mesh.NewInstance()
    copy.ShallowCopy(mesh)
    left_out, renamed = [], []
    for kind in ("PointData", "CellData", "FieldData"):
        data, put = getattr(mesh, f"Get{kind}")(), getattr(copy, f"Get{kind}")()
        put.Initialize()
        arrays = [data.GetAbstractArray(i) for i in range(data.GetNumberOfArrays())]
        taken = {text(array.GetName()) for array in arrays}
        for array in arrays:
            before = text(array.GetName())
            if not isinstance(array, vtkDataArray) and kind != "FieldData":
                left_out.append(before or "(unnamed)")
                continue
            after = _hdf_name(before, taken)
            if after != before:
                renamed.append(f"{before} to {after}")
            index = put.AddArray(_other(array, after) if after != before else _octets(array))
            for role in range(getattr(data, "NUM_ATTRIBUTES", 0)):
                if data.GetAbstractAttribute(role) is array:
                    put.SetActiveAttribute(index, role)
    notes = []
    if left_out:
        notes.append(f"{name}: VTKHDF does not keep the arrays {', '.join(left_out)}.")
    if renamed:
        notes.append(f"{name}: VTKHDF allows no / and . in names of arrays; renamed {', '.join(renamed)}.")
    return copy, notes


def _hdf_name(name: str, taken: set[str]) -> str:
    """Return a name as HDF allows it, and other than those that are `taken`, to which it is added."""
    plain = re.sub(r"[/.]", "_", name)
    if plain == name:
        return name
    candidates = itertools.chain((plain,), (f"{plain}_{i}" for i in itertools.count(2)))
    free = next(candidate for candidate in candidates if candidate not in taken)
    taken.add(free)
    return free


def _octets(array: Any) -> Any:
    """Return an array whose values have octets of their own."""
    if not isinstance(array, vtkBitArray):
        return array
    octets = vtkUnsignedCharArray()
    octets.DeepCopy(array)
    octets.SetName(array.GetName())
    return octets


def _other(array: Any, name: str) -> Any:
    """Return the same values as :func:`_octets` under another name."""
    values = _octets(array)
    renamed = values.NewInstance()
    renamed.ShallowCopy(values)
    renamed.SetName(name)
    return renamed
