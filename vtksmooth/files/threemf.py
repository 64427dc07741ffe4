"""3MF files, which 3D printers take: triangles, in millimetres.

The package trimesh writes them; the extra ``3mf`` installs it with what it needs for that. The consortium's
own lib3mf ends the process when the disk is full, rounds, and is not faster. Reference: 3MF Consortium, "3MF
Core Specification", ISO/IEC 25422:2025.
"""

from __future__ import annotations

import importlib.util
from typing import IO

import numpy as np

from ..errors import MeshFileError
from .polygons import Kept, Polygons

_NEEDED = ("trimesh", "lxml", "networkx")


def check_installed(path: object) -> None:
    """Refuse to write a file when a package that is needed is not installed."""
    missing = [name for name in _NEEDED if importlib.util.find_spec(name) is None]
    if missing:
        raise MeshFileError(
            f"cannot write {path}: 3MF files need {' and '.join(missing)}; install "
            f'with "pip install {" ".join(missing)}", or write .stl, which printers take, too.'
        )


def proper(mesh: Polygons) -> tuple[Polygons, int]:
    """Return a mesh of triangles without those that have two equal corners, and how many these are."""
    corners = mesh.connectivity.reshape(-1, 3)
    kept = (corners != np.roll(corners, 1, axis=1)).all(axis=1)
    if kept.all():
        return mesh, 0
    cells = {name: array[kept] for name, array in mesh.cell_data.items()}
    left = mesh._replace(sizes=mesh.sizes[kept], connectivity=corners[kept].ravel(), cell_data=cells)
    return left, int((~kept).sum())


def write(file: IO[bytes], mesh: Polygons) -> Kept:
    """Write a file of a mesh of triangles that have three different corners each."""
    import trimesh

    # Not processed: points stay as many as they are, in their order.
    solid = trimesh.Trimesh(mesh.points, mesh.connectivity.reshape(-1, 3), process=False)
    file.write(solid.export(file_type="3mf"))
    return Kept(set(), set(), set())
