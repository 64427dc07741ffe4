"""Reading and writing surface meshes as files, so that nothing is lost, silently changed or left half done.

VTK's readers and writers do the work where they are sound; OFF and PLY are read and written here. What
VTK has to say about a file becomes the message of the one exception,
:class:`~vtksmooth.errors.MeshFileError`.

``reading`` and ``writing`` are called from outside. The formats themselves are ``off``, ``ply`` (both made
of ``polygons``) and ``vtk_formats``. Before VTK reads, ``signatures`` refuses what is not the format it is
called; afterwards ``damage`` refuses what VTK let pass, and ``surfaces`` makes one surface of the rest.
``vtk_messages`` collects what VTK prints.
"""

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
    "WRITABLE",
    "atomic",
    "check_place",
    "check_writable",
    "make_folder",
    "read_surface",
    "remove_unfinished",
    "write_surface",
]
