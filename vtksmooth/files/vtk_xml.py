"""What VTK's XML files cannot hold of a mesh."""

from __future__ import annotations

from typing import Any

from .damage import text


def for_xml(mesh: Any, name: str) -> tuple[Any, list[str]]:
    """Return a copy of a mesh that VTK's reader of XML files can read again.

    A null character ends a text there: an array of texts that hold some would be read beyond its end.

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
        What was left out, one sentence.
    """
    copy = mesh.NewInstance()
    copy.ShallowCopy(mesh)
    left_out = []
    for kind in ("PointData", "CellData", "FieldData"):
        data = getattr(copy, f"Get{kind}")()
        for i in reversed(range(data.GetNumberOfArrays())):
            array = data.GetAbstractArray(i)
            if array.IsA("vtkStringArray") and _holds_null(array):
                left_out.append(text(array.GetName()) or "(unnamed)")
                data.RemoveArray(i)
    if not left_out:
        return mesh, []
    return copy, [
        f"{name}: VTK's XML files keep no texts with null characters; left out {', '.join(left_out)}."
    ]


def _holds_null(texts: Any) -> bool:
    return any("\0" in text(texts.GetValue(i)) for i in range(texts.GetNumberOfValues()))
