"""What VTK's XML files cannot hold of a mesh, and names that its writer would not quote."""

from __future__ import annotations

import re
from typing import Any
from xml.sax.saxutils import escape

from .damage import text

#: Characters that XML cannot hold.
_FORBIDDEN = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\ufffe\uffff\ud800-\udfff]")

#: What is written in place of characters of names, besides &, < and >.
_ENTITIES = {'"': "&quot;", "\t": "&#9;", "\n": "&#10;", "\r": "&#13;"}


def for_xml(mesh: Any, name: str) -> tuple[Any, list[str]]:
    """Return a copy of a mesh that VTK's reader of XML files can read again.

    A null character ends a text there: an array of texts that hold some would be read beyond its end. Names
    are written as they are, and with a quote, ``<`` or ``&`` the file is no XML: they are quoted here.

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
        What was left out or replaced, a sentence each.
    """
    copy = mesh.NewInstance()
    copy.ShallowCopy(mesh)
    left_out, renamed = [], []
    for kind in ("PointData", "CellData", "FieldData"):
        data = getattr(copy, f"Get{kind}")()
        for i in reversed(range(data.GetNumberOfArrays())):
            array = data.GetAbstractArray(i)
            if array.IsA("vtkStringArray") and _holds_null(array):
                left_out.append(text(array.GetName()) or "(unnamed)")
                data.RemoveArray(i)
        names = [_names(data.GetAbstractArray(i)) for i in range(data.GetNumberOfArrays())]
        if all(quoted == given for given, quoted in names):
            continue
        renamed += [given[0] for given, _ in names if any(map(_FORBIDDEN.search, given))]
        _quote(data, [quoted for _, quoted in names])
    notes = []
    if left_out:
        notes.append(
            f"{name}: VTK's XML files keep no texts with null characters; left out {', '.join(left_out)}."
        )
    if renamed:
        told = ", ".join(_FORBIDDEN.sub("?", each) for each in renamed)
        notes.append(f"{name}: XML keeps no control characters in names; they became ? in {told}.")
    return copy, notes


def _names(array: Any) -> tuple[list[str], list[str]]:
    """Return the names of an array and its components, and the same quoted."""
    given = [text(array.GetName())]
    if array.HasAComponentName():
        given += [text(array.GetComponentName(i)) for i in range(array.GetNumberOfComponents())]
    return given, [escape(_FORBIDDEN.sub("?", each), _ENTITIES) for each in given]


def _quote(data: Any, names: list[list[str]]) -> None:
    """Give the arrays of `data` other names, which stay as they are in the mesh that they are shared with."""
    arrays = [data.GetAbstractArray(i) for i in range(len(names))]
    kinds = range(data.NUM_ATTRIBUTES) if hasattr(data, "NUM_ATTRIBUTES") else ()  # field data has none
    active = [[kind for kind in kinds if data.GetAbstractAttribute(kind) is array] for array in arrays]
    for _ in arrays:
        data.RemoveArray(0)
    for array, (name, *components), roles in zip(arrays, names, active, strict=True):
        other = array.NewInstance()
        other.DeepCopy(array)
        if name:
            other.SetName(name)
        for i, component in enumerate(components):
            other.SetComponentName(i, component)
        place = data.AddArray(other)
        for role in roles:
            data.SetActiveAttribute(place, role)


def _holds_null(texts: Any) -> bool:
    return any("\0" in text(texts.GetValue(i)) for i in range(texts.GetNumberOfValues()))
