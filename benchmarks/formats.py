"""What each file format keeps of a mesh, by writing it and reading it again.

    python benchmarks/formats.py [--output docs/formats.md]

Writes docs/formats.md. Ends with an error where something is lost without a note.
"""

from __future__ import annotations

import argparse
import importlib.util
import re
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pyvista as pv
import tables

from vtksmooth.errors import MeshFileError
from vtksmooth.files import READABLE, WRITABLE, read_surface, reading, vtk_formats, write_surface, writing

_TEXT = """# File formats

Which formats are read and written, what each keeps of a mesh, and what it leaves out. Nothing is left out
without a note: `read_surface` and `write_surface` return the notes, the command line prints them, the app
shows them. A format that holds none of a mesh's cells refuses it. Files appear completely or not at all: an
interrupted or failed write leaves the file that was there.

## Who reads and writes

{who}

- **vtksmooth** reads and writes the text and binary formats of polygons by itself: it understands what
  other programs write, checks every index, and gives each point of the file once, in the file's order (STL
  has none: equal corners become one point).
- **VTK** reads in a process of its own. A damaged file that ends VTK's reader ends that process only, and
  becomes one sentence.
- **trimesh** writes 3MF: `pip install trimesh lxml networkx`, or the extra `3mf`. It keeps double
  precision. The 3MF Consortium's own lib3mf ends the process when the disk is full and rounds coordinates
  to single precision.
- Of volume grids the outer surface is taken, of composite files all blocks as one mesh; both are said.
- `.3mf` is not read, as VTK does not read it. `.gltf` is not written: `.glb` is the same scene in one file.

## What comes back

Each cell is the result of a file written and read again: **yes** is kept exactly (normals, colours and
texture coordinates: in the format's precision), **note** is lost or changed and said so, **refused** is an
error that says which format to use. Of `.3mf`, which is not read, only the notes count.

{kept}

- **patches** are the cell array `SolidIds` (`GroupIds`, `MaterialIds`, `ObjectIds`) with the field array
  `SolidNames` (…): solids of STL, groups, materials and objects of OBJ.
- **seams** are texture coordinates that differ at a point between the faces there. The field array
  `CornerTCoords` keeps them as long as the faces stay the same.
- Colours are the arrays `RGB` or `RGBA`; normals and texture coordinates are the active ones.
- `.glb` has texture coordinates from the top down; they are turned when it is read and written.

What to read next: [Command line](start/command_line.md), and [the functions](reference/files.rst).
"""


class Feature(NamedTuple):
    """Something that a mesh may have.

    Attributes
    ----------
    title : str
    add : callable
        Gives a mesh the feature.
    kept : callable
        Says of the mesh that was read and the one that was written whether it is there.
    """

    title: str
    add: Callable[[pv.PolyData], pv.PolyData]
    kept: Callable[[pv.PolyData, pv.PolyData], bool]


def plain() -> pv.PolyData:
    """Return triangles in single precision, without arrays."""
    mesh = pv.Plane(i_resolution=3, j_resolution=2).triangulate()
    points = mesh.points.astype(np.float32)
    points[:, 2] = points[:, 0] * points[:, 1]
    return pv.PolyData(points, mesh.faces)


def _with_cells(**cells: Any) -> Callable[[pv.PolyData], pv.PolyData]:
    def add(mesh: pv.PolyData) -> pv.PolyData:
        faces = {} if "strips" in cells else {"faces": mesh.faces}
        return pv.PolyData(mesh.points, **faces, **cells)

    return add


def _with_array(home: str, name: str, values: Any, role: str = "") -> Callable[[pv.PolyData], pv.PolyData]:
    def add(mesh: pv.PolyData) -> pv.PolyData:
        count = {"point_data": mesh.n_points, "cell_data": mesh.n_cells}.get(home, 4)
        getattr(mesh, home)[name] = values(count)
        if role:
            getattr(mesh.GetPointData(), f"SetActive{role}")(name)
        return mesh

    return add


def _same(home: str, name: str, role: str = "") -> Callable[[pv.PolyData, pv.PolyData], bool]:
    def kept(back: pv.PolyData, mesh: pv.PolyData) -> bool:
        there, before = getattr(back, home), getattr(mesh, home)
        if role:
            active = getattr(back.GetPointData(), f"Get{role}")()
            return active is not None and np.allclose(there[active.GetName()], before[name], atol=1e-6)
        return name in there and np.array_equal(
            there[name], before[name], equal_nan=before[name].dtype.kind == "f"
        )

    return kept


def _double(mesh: pv.PolyData) -> pv.PolyData:
    mesh.points = mesh.points.astype(np.float64) / 3
    return mesh


def _polygons(mesh: pv.PolyData) -> pv.PolyData:
    return pv.PolyData(mesh.points, [4, 0, 1, 5, 4, 5, 1, 2, 6, 9, 5])


def _loose(mesh: pv.PolyData) -> pv.PolyData:
    return pv.PolyData(np.vstack((mesh.points, [[9, 9, 9]])).astype(np.float32), mesh.faces)


def _patches(mesh: pv.PolyData) -> pv.PolyData:
    mesh.cell_data["SolidIds"] = np.arange(mesh.n_cells) // 6
    mesh.field_data["SolidNames"] = ["inlet", "wall"]
    return mesh


def _patches_kept(back: pv.PolyData, mesh: pv.PolyData) -> bool:
    for kind in ("Solid", "Group"):
        if f"{kind}Ids" in back.cell_data and f"{kind}Names" in back.field_data:
            found = np.asarray(back.field_data[f"{kind}Names"])[np.asarray(back.cell_data[f"{kind}Ids"])]
            return [str(name) for name in found] == ["inlet"] * 6 + ["wall"] * 6
    return False


def _seams(mesh: pv.PolyData) -> pv.PolyData:
    corners = mesh.regular_faces.ravel()
    mesh.field_data["CornerTCoords"] = np.column_stack(
        (corners, np.arange(2 * len(corners)).reshape(-1, 2) / 64)
    )
    return mesh


def _random(*shape: int, dtype: Any = np.float64) -> Callable[[int], Any]:
    return lambda count: np.random.default_rng(0).random((count, *shape)).astype(dtype)


def _bytes(count: int) -> Any:
    return np.random.default_rng(0).integers(0, 256, (count, 3)).astype(np.uint8)


FEATURES = [
    Feature("double precision", _double, lambda back, mesh: np.array_equal(back.points, mesh.points)),
    Feature("polygons", _polygons, lambda back, mesh: np.array_equal(back.faces, mesh.faces)),
    Feature("lines", _with_cells(lines=[3, 0, 1, 5]), lambda back, mesh: back.n_lines == 1),
    Feature("vertex cells", _with_cells(verts=[1, 0, 1, 5]), lambda back, mesh: back.n_verts == 2),
    Feature("strips", _with_cells(strips=[6, 0, 4, 1, 5, 2, 6]), lambda back, mesh: back.n_strips == 1),
    Feature("points without faces", _loose, lambda back, mesh: back.n_points == mesh.n_points),
    Feature(
        "normals",
        _with_array("point_data", "Normals", lambda n: np.tile(np.float32([0.6, 0, 0.8]), (n, 1)), "Normals"),
        _same("point_data", "Normals", "Normals"),
    ),
    Feature("colours of points", _with_array("point_data", "RGB", _bytes), _same("point_data", "RGB")),
    Feature("colours of faces", _with_array("cell_data", "RGB", _bytes), _same("cell_data", "RGB")),
    Feature(
        "texture coordinates",
        _with_array("point_data", "TCoords", _random(2, dtype=np.float32), "TCoords"),
        _same("point_data", "TCoords", "TCoords"),
    ),
    Feature("seams", _seams, _same("field_data", "CornerTCoords")),
    Feature("patches", _patches, _patches_kept),
    Feature("point numbers", _with_array("point_data", "heat", _random()), _same("point_data", "heat")),
    Feature("point vectors", _with_array("point_data", "flow", _random(3)), _same("point_data", "flow")),
    Feature("face numbers", _with_array("cell_data", "part", np.arange), _same("cell_data", "part")),
    Feature("mesh numbers", _with_array("field_data", "time", _random()), _same("field_data", "time")),
    Feature(
        "mesh texts",
        _with_array("field_data", "remark", lambda count: ["made", "by hand"]),
        lambda back, mesh: [*back.field_data.get("remark", ())] == ["made", "by hand"],
    ),
]  # fmt: skip


def outcome(extension: str, feature: Feature, folder: Path, usual: set[str]) -> str:
    """Write a mesh with a feature and read it again: "yes", "note" or "refused".

    Parameters
    ----------
    usual : set of str
        The notes on a mesh without any feature, without numbers.

    Raises
    ------
    RuntimeError
        The feature was lost without a note.
    """
    path = folder / f"mesh{extension}"
    mesh = feature.add(plain())
    try:
        notes = write_surface(mesh, path)
        back = None
        if extension in READABLE:
            back, more = read_surface(path)
            notes += more
    except MeshFileError:
        return "refused"
    said = bool(_kinds(notes) - usual)
    if back is None:
        return "note" if said else "yes"
    if feature.kept(back, mesh):
        return "yes"
    if not said:
        raise RuntimeError(f"{extension} loses {feature.title} without a note")
    return "note"


def _kinds(notes: Sequence[str]) -> set[str]:
    return {re.sub(r"\d+", "#", note) for note in notes}


def _who() -> list[str]:
    rows = []
    for extension in sorted({*READABLE, *WRITABLE}):
        reader = "" if extension not in READABLE else "VTK"
        writer = "VTK" if extension in (*vtk_formats.WRITERS, ".glb") else ""
        if extension in reading._POLYGONS:
            reader = writer = "vtksmooth"
        if extension == ".3mf":
            writer = "trimesh"
        what = []
        if extension in writing._TRIANGLES_ONLY:
            what.append("triangles only")
        elif extension in writing._FACES_ONLY:
            what.append("faces only")
        if extension in writing._SINGLE_PRECISION:
            what.append("single precision")
        rows.append([f"`{extension}`", reader or "not read", writer or "not written", ", ".join(what)])
    return tables.table(["format", "read by", "written by", "holds"], rows)


def make(output: Path) -> None:
    """Write the page."""
    formats = [e for e in WRITABLE if e != ".3mf" or importlib.util.find_spec("trimesh")]
    columns = []
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        for extension in formats:
            notes = write_surface(plain(), folder / f"mesh{extension}")
            if extension in READABLE:
                notes += read_surface(folder / f"mesh{extension}")[1]
            columns.append([outcome(extension, feature, folder, _kinds(notes)) for feature in FEATURES])
    rows = [[feature.title, *cells] for feature, *cells in zip(FEATURES, *columns, strict=True)]
    kept = tables.table(["", *(f"`{extension}`" for extension in formats)], rows)
    output.write_text(_TEXT.format(who="\n".join(_who()), kept="\n".join(kept)), encoding="utf-8")


def main(arguments: Sequence[str] | None = None) -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description="Write the page on file formats.")
    parser.add_argument("--output", type=Path, default=Path("docs/formats.md"))
    make(parser.parse_args(arguments).output)


if __name__ == "__main__":
    main()
