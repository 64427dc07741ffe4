"""Names of files that no system has, and names of arrays that are no text.

Old files have names of arrays in Latin-1, and VTK passes them on as bytes.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from ..errors import MeshFileError
from ..filters.arrays import name_of


def path_of(path: str | os.PathLike[str]) -> Path:
    """Return a path with the user's folder in place of a ~.

    Raises
    ------
    MeshFileError
        No file can have this name, or there is no such user.
    """
    try:
        place = Path(path).expanduser()
        if b"\0" in os.fsencode(place):
            raise ValueError("it holds a null character")
    except (RuntimeError, ValueError) as error:
        raise MeshFileError(f"{os.fspath(path)!r} can be no path ({error}); check it.") from error
    return place


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
