"""Reading and writing surface meshes as files, so that nothing is lost, silently changed or left half done.

VTK's readers and writers do the work where they are sound; OBJ, OFF, PLY and STL are read and written here.
What VTK has to say about a file becomes the message of the one exception,
:class:`~vtksmooth.errors.MeshFileError`.

``reading`` and ``writing`` are called from outside; they are imported when first asked for, as the process in
which VTK reads does without them. The formats themselves are ``obj``, ``off``, ``ply`` and ``stl`` (made of
``polygons`` and of lines of ``text``) and ``vtk_formats``. VTK reads in a process of its own: ``vtk_process``
starts it, ``vtk_child`` is what runs there, ``vtk_readers`` reads, ``surfaces`` makes one surface of what was
read, and ``vtk_transfer`` brings it over. Before, ``signatures`` refuses what is not the format it is called;
afterwards ``damage`` refuses what VTK let pass. ``names`` turns the names of arrays into text, ``vtk_hdf``
takes from a mesh what HDF files cannot hold, and ``vtk_messages`` collects what VTK prints.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .images import READABLE_IMAGES, read_image
    from .reading import READABLE, read_surface
    from .writing import (
        WRITABLE,
        atomic,
        check_place,
        check_writable,
        make_folder,
        remove_unfinished,
        write_surface,
    )

__all__ = [
    "READABLE",
    "READABLE_IMAGES",
    "WRITABLE",
    "atomic",
    "check_place",
    "check_writable",
    "make_folder",
    "read_image",
    "read_surface",
    "remove_unfinished",
    "write_surface",
]


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    homes = {
        "READABLE": "reading",
        "read_surface": "reading",
        "READABLE_IMAGES": "images",
        "read_image": "images",
    }
    home = homes.get(name, "writing")
    return getattr(importlib.import_module(f".{home}", __name__), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
