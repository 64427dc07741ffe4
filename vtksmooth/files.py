"""Reading and writing surface meshes as files, so that nothing is lost, silently changed or left half done.

VTK's readers and writers do the work where they are sound; OFF and PLY are read and written here. What
VTK has to say about a file becomes the message of the one exception,
:class:`~vtksmooth.errors.MeshFileError`.
"""

from __future__ import annotations

import contextlib
import importlib
import os
import re
import stat
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import IO, Any

import numpy as np
import numpy.typing as npt
import pyvista as pv
from vtkmodules.vtkCommonCore import vtkLogger, vtkOutputWindow, vtkStringOutputWindow
from vtkmodules.vtkCommonDataModel import (
    VTK_POLYGON,
    VTK_QUAD,
    VTK_TRIANGLE,
    vtkCellArray,
    vtkCompositeDataSet,
    vtkDataObjectTreeIterator,
    vtkDataSet,
    vtkGenericCell,
    vtkPointSet,
    vtkPolyData,
    vtkUnstructuredGrid,
)
from vtkmodules.vtkFiltersCore import vtkAppendFilter, vtkAppendPolyData
from vtkmodules.vtkFiltersGeometry import vtkGeometryFilter

from . import off, ply
from .errors import MeshFileError
from .filters.arrays import cells_of, point_array_names, points_of

_HEAD = 1 << 16

_XML = (".vtp", ".vtu", ".vts", ".vtr", ".vti", ".vtm", ".vtmb", ".pvtu")

#: The formats that can be read, by extension.
READABLE = (".obj", ".off", ".ply", ".stl", ".vtk", ".vtkhdf", *_XML, ".glb", ".gltf")

#: The writers of VTK that are used, by extension: module and class.
_WRITERS = {
    ".obj": ("vtkIOGeometry", "vtkOBJWriter"),
    ".stl": ("vtkIOGeometry", "vtkSTLWriter"),
    ".vtk": ("vtkIOLegacy", "vtkPolyDataWriter"),
    ".vtkhdf": ("vtkIOHDF", "vtkHDFWriter"),
    ".vtp": ("vtkIOXML", "vtkXMLPolyDataWriter"),
    ".vtu": ("vtkIOXML", "vtkXMLUnstructuredGridWriter"),
}

#: The formats that can be written, by extension.
WRITABLE = (*sorted([*_WRITERS, ".off", ".ply"]),)

#: Writers that report success on a full disk: what they wrote is read again.
_VERIFIED = (".obj", ".vtkhdf")

#: Keywords that lines of an OBJ file may begin with.
_OBJ_KEYWORDS = re.compile(
    rb"(v|vt|vn|vp|f|fo|l|p|g|s|o|mg|usemtl|usemap|mtllib|maplib|cstype|deg|curv|curv2|surf|bevel|c_interp"
    rb"|d_interp|lod|shadow_obj|trace_obj)(\s|$)"
)

_unfinished: set[Path] = set()


def remove_unfinished() -> None:
    """Remove the temporary files of writes that are under way; for a process about to be ended."""
    for path in list(_unfinished):
        path.unlink(missing_ok=True)


def _extension(path: Path) -> str:
    return path.suffix.lower()


# ---------------------------------------------------------------------------------------- reading


def read_surface(path: str | os.PathLike[str]) -> tuple[pv.PolyData, list[str]]:
    """Read a surface mesh.

    Parameters
    ----------
    path : path-like
        A file whose extension is one of :data:`READABLE`.

    Returns
    -------
    pyvista.PolyData
        The surface, with all of its data arrays and in the precision of the file.
    list of str
        What was done to the file's content, one sentence each: STL's points merged, points that an
        OBJ file's texture indices had split merged again, the outer surface of a grid taken, the
        blocks of a composite file combined.

    Raises
    ------
    MeshFileError
        There is no such file, it cannot be read, is not what its extension says, is damaged or
        truncated, or holds no faces.

    Examples
    --------
    >>> import pyvista as pv
    >>> mesh, notes = read_surface(pv.examples.planefile)
    >>> mesh.n_cells, notes
    (2452, [])
    """
    path = Path(path).expanduser()
    try:
        return _read(path)
    except MeshFileError:
        raise
    except OSError as error:
        raise MeshFileError(f"cannot read {path}: {error.strerror or error}; {_advice(error)}.") from error
    except MemoryError as error:
        raise MeshFileError(
            f"{path} does not fit into memory; use a smaller mesh or a larger machine."
        ) from error


def _advice(error: OSError) -> str:
    if isinstance(error, FileNotFoundError):
        return "check the path"
    if isinstance(error, PermissionError):
        return "change its permissions"
    return "check the file and its disk"


def _read(path: Path) -> tuple[pv.PolyData, list[str]]:
    extension = _extension(path)
    status = path.stat()
    if stat.S_ISDIR(status.st_mode):
        raise MeshFileError(f"{path} is a folder; name a mesh file in it.")
    # A pipe would wait for a writer, a device might never end.
    if not stat.S_ISREG(status.st_mode):
        raise MeshFileError(f"{path} is not a regular file; copy its content into one.")
    if extension not in READABLE:
        raise MeshFileError(
            f"{path} has the extension {extension or '(none)'!r}, which is not known; "
            f"known are {' '.join(READABLE)}."
        )
    with path.open("rb") as file:
        head = file.read(_HEAD)
    if not head:
        raise MeshFileError(f"{path} is empty; export it again.")

    notes: list[str] = []
    if extension in (".off", ".ply"):
        polygons, notes = (off.read(path), notes) if extension == ".off" else ply.read(path)
        mesh = _polydata(path, polygons, notes)
    else:
        wrong = _wrong_signature(extension, head, status.st_size)
        if wrong:
            raise MeshFileError(f"{path} {wrong}.")
        mesh = _surface(path, _read_with_vtk(path, extension), notes)
    if extension == ".obj":
        mesh = _merge_split_points(path, mesh, notes)
    elif extension == ".stl":
        _note_merged(path, mesh, head, status.st_size, notes)
    if mesh.GetNumberOfPolys() + mesh.GetNumberOfStrips() == 0:
        raise MeshFileError(f"{path} holds {mesh.n_points} points but no faces; export it as a surface mesh.")
    return mesh, notes


def _wrong_signature(extension: str, head: bytes, size: int) -> str | None:
    """Return what shows that a file is not what its extension says, or None.

    Readers of VTK search garbage for a mesh at length, or end the process when a count is absurd.
    """
    start = head.lstrip(b"\xef\xbb\xbf \t\r\n")
    if extension in _XML:
        if not start.startswith(b"<") or b"<VTKFile" not in head:
            return "is not an XML file of VTK, as its extension says; check its name"
        # Compression makes no more than some 1000 out of one.
        counts = [int(count) for count in re.findall(rb"NumberOf\w+=\"(\d{1,30})\"", head)]
        if max(counts, default=0) > 1100 * size:
            return f"announces {max(counts)} elements in {size} bytes; it is damaged, export it again"
    elif extension == ".vtk":
        # The version decides how the rest is read; an unknown one has ended the process.
        if not re.match(rb"# vtk DataFile Version [1-5]\.\d+\s", head):
            return "is not a legacy file of VTK, as its extension says; check its name"
    elif extension == ".vtkhdf":
        if not head.startswith(b"\x89HDF\r\n\x1a\n"):
            return "is not an HDF file, as its extension says; check its name"
    elif extension == ".glb":
        if not head.startswith(b"glTF"):
            return "is not a binary glTF file, as its extension says; check its name"
    elif extension == ".gltf":
        if not start.startswith(b"{"):
            return "is not a glTF file, as its extension says; check its name"
    elif extension == ".obj":
        lines = (line.strip() for line in head.split(b"\n"))
        first = next((line for line in lines if line and not line.startswith(b"#")), b"v")
        if b"\0" in head or not _OBJ_KEYWORDS.match(first):
            return "is not an OBJ file, as its extension says; check its name"
    elif extension == ".stl":
        return _wrong_stl(head, size)
    return None


def _stl_triangles(head: bytes, size: int) -> int | None:
    """Return the number of triangles of a binary STL file, None of a text file.

    Some binary files begin with "solid", too; their size gives them away.
    """
    count = int.from_bytes(head[80:84], "little")
    if head.lstrip()[:5].lower() == b"solid" and size != 84 + 50 * count:
        return None
    return count


def _wrong_stl(head: bytes, size: int) -> str | None:
    count = _stl_triangles(head, size)
    if count is None:
        if b"\0" in head or not re.search(rb"(?i)\bfacet\b|\bendsolid\b", head):
            return "is not an STL file, as its extension says; check its name"
    elif size < 84 + 50 * count or len(head) < 84:
        return (
            f"is not an STL file, or truncated (it announces {count} triangles in {size} bytes); "
            "check its name, or export it again"
        )
    elif size != 84 + 50 * count:
        return (
            f"is not an STL file (it announces {count} triangles and goes on for "
            f"{size - 84 - 50 * count} bytes after them); check its name, or export it again"
        )
    return None


@contextlib.contextmanager
def _vtk_messages() -> Iterator[list[str]]:
    """Collect VTK's error messages in the list, which is complete when the context ends.

    Objects inside a reader do not pass their errors on as events, so the output window is what sees
    all of them; the log to stderr is silenced meanwhile.
    """
    messages: list[str] = []
    before = vtkOutputWindow.GetInstance()
    window = vtkStringOutputWindow()
    vtkOutputWindow.SetInstance(window)
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)
    try:
        yield messages
    finally:
        vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_INFO)
        vtkOutputWindow.SetInstance(before)
        messages += _errors(window.GetOutput())


def _errors(text: str | bytes) -> list[str]:
    if isinstance(text, bytes):  # a message that quotes a damaged file
        text = text.decode("utf-8", "replace")
    found = re.findall(r"ERROR: In (\S+), line \d+\n(?:\S+ \(\w+\)|\(nullptr\)): ([^\n]*)", text)
    return [_printable(message) for source, message in found if not source.startswith(_PIPELINE)] or [
        "VTK gave up on it" for _ in found[:1]
    ]


def _printable(message: str) -> str:
    return "".join(c if c.isprintable() else "?" for c in message.strip().rstrip("."))[:200]


#: The pipeline's own messages repeat that an algorithm failed; why is said elsewhere.
_PIPELINE = ("vtkExecutive", "vtkStreamingDemandDriven", "vtkDemandDriven", "vtkCompositeDataPipeline")


def _run(algorithm: Any) -> None:
    """Update a VTK algorithm and collect what it reports as an error in the output window."""

    def show(caller: Any, event: str, message: str) -> None:
        # An observed error event is kept from the window, where the others are collected.
        vtkOutputWindow.GetInstance().DisplayErrorText(message)

    show.CallDataType = "string0"  # type: ignore[attr-defined]
    algorithm.AddObserver("ErrorEvent", show)
    algorithm.Update()


@contextlib.contextmanager
def _hdf_silence(extension: str) -> Iterator[None]:
    """Keep the HDF5 library, which knows nothing of VTK's messages, from writing to stderr."""
    if extension != ".vtkhdf":
        yield
        return
    stderr = os.dup(2)
    try:
        with open(os.devnull, "wb") as nothing:
            os.dup2(nothing.fileno(), 2)
        yield
    finally:
        os.dup2(stderr, 2)
        os.close(stderr)


def _read_with_vtk(path: Path, extension: str) -> Any:
    data = None
    with _vtk_messages() as messages, _hdf_silence(extension):
        try:
            reader = pv.get_reader(str(path), force_ext=extension).reader
            _run(reader)
            data = reader.GetOutputDataObject(0)
        # Whatever a reader trips over, an attribute of the file is the cause.
        except (AttributeError, KeyError, RuntimeError, TypeError, ValueError) as error:
            messages.append(_printable(str(error).split("\n")[0]) or type(error).__name__)
    if not messages and data is None:
        messages.append("nothing could be read")
    if messages:
        raise MeshFileError(f"{path} is damaged or truncated ({messages[0]}); export it again.")
    return data


def _surface(path: Path, data: Any, notes: list[str]) -> pv.PolyData:
    """Make one surface of whatever a reader gave."""
    if isinstance(data, vtkPolyData):
        _check(path, data)
        return pv.wrap(data)
    if isinstance(data, vtkCompositeDataSet):
        return _combined(path, data, notes)
    if not isinstance(data, vtkDataSet):
        raise MeshFileError(f"{path} holds no mesh ({data.GetClassName()[3:]}); export it as a surface mesh.")
    _check(path, data)
    if isinstance(data, vtkUnstructuredGrid) and _only_faces(data):
        notes.append(f"{path.name} holds an unstructured grid of faces; they were taken as they are.")
        return _faces_of(data)
    # Not vtkDataSetSurfaceFilter: of structured grids that gives six sides that share no points.
    surface = vtkGeometryFilter()
    surface.SetInputDataObject(data)
    with _vtk_messages() as messages:
        _run(surface)
    if messages:
        raise MeshFileError(f"{path} has no outer surface ({messages[0]}); export the surface itself.")
    kind = re.sub(r"(?<!^)([A-Z])", r" \1", data.GetClassName()[3:]).lower()
    mesh = pv.wrap(surface.GetOutput())
    notes.append(
        f"{path.name} holds {_article(kind)} of {data.GetNumberOfCells()} cells; "
        f"its outer surface was taken ({mesh.n_cells} faces)."
    )
    return mesh


def _only_faces(grid: vtkUnstructuredGrid) -> bool:
    types = {grid.GetCellType(i) for i in range(grid.GetNumberOfCells())}
    return bool(types) and types <= {VTK_TRIANGLE, VTK_QUAD, VTK_POLYGON}


def _faces_of(grid: vtkUnstructuredGrid) -> pv.PolyData:
    """Make polydata of a grid of faces: the surface filter would drop and renumber points."""
    mesh = pv.PolyData()
    mesh.SetPoints(grid.GetPoints())
    mesh.SetPolys(grid.GetCells())
    mesh.GetPointData().ShallowCopy(grid.GetPointData())
    mesh.GetCellData().ShallowCopy(grid.GetCellData())
    mesh.GetFieldData().ShallowCopy(grid.GetFieldData())
    return mesh


def _article(noun: str) -> str:
    return f"{'an' if noun[0] in 'aeiou' else 'a'} {noun}"


def _combined(path: Path, data: Any, notes: list[str]) -> pv.PolyData:
    iterator = data.NewIterator()
    if isinstance(iterator, vtkDataObjectTreeIterator):
        iterator.SkipEmptyNodesOn()
    append = vtkAppendPolyData()
    blocks = 0
    iterator.InitTraversal()
    inner: list[str] = []
    while not iterator.IsDoneWithTraversal():
        block = iterator.GetCurrentDataObject()
        if isinstance(block, vtkDataSet) and block.GetNumberOfCells():
            append.AddInputDataObject(_surface(path, block, inner))
            blocks += 1
        iterator.GoToNextItem()
    if not blocks:
        raise MeshFileError(f"{path} holds no block with faces; export it as a surface mesh.")
    append.Update()
    if blocks > 1:
        notes.append(
            f"{path.name} holds {blocks} blocks; they were combined into one mesh, "
            "with the arrays that all of them have, and share no points."
        )
    notes += inner[:1] if blocks == 1 else [f"{path.name}: outer surfaces of grids were taken."] * bool(inner)
    return pv.wrap(append.GetOutput())


def _check(path: Path, data: Any) -> None:
    """Refuse cells that point outside the points, and short arrays: VTK would read foreign memory."""
    for attributes, expected in (
        (data.GetPointData(), data.GetNumberOfPoints()),
        (data.GetCellData(), data.GetNumberOfCells()),
    ):
        for i in range(attributes.GetNumberOfArrays()):
            array = attributes.GetAbstractArray(i)
            if array.GetNumberOfTuples() != expected:
                raise MeshFileError(
                    f"{path} is damaged: the array {array.GetName() or '(unnamed)'} has "
                    f"{array.GetNumberOfTuples()} values for {expected} points or cells; export it again."
                )
    arrays: list[vtkCellArray] = []
    if isinstance(data, vtkPolyData):
        arrays = [data.GetVerts(), data.GetLines(), data.GetPolys(), data.GetStrips()]
    elif isinstance(data, vtkUnstructuredGrid):
        arrays = [data.GetCells()]
    n_points = data.GetNumberOfPoints() if isinstance(data, vtkPointSet) else 0
    for cells in arrays:
        if cells is None:  # of an empty grid
            continue
        if not cells.IsValid():
            raise MeshFileError(f"{path} is damaged (broken cell offsets); export it again.")
        _check_indices(path, cells_of(cells)[1], n_points)
    if isinstance(data, vtkUnstructuredGrid) and data.GetNumberOfCells():
        _check_cell_types(path, data)


def _check_cell_types(path: Path, grid: vtkUnstructuredGrid) -> None:
    """Refuse cells of unknown types, and cells with another number of points than their type has."""
    sizes = np.diff(cells_of(grid.GetCells())[0])
    types = np.array([grid.GetCellType(i) for i in range(grid.GetNumberOfCells())])
    for kind in np.unique(types).tolist():
        cell = vtkGenericCell.InstantiateCell(kind)
        # 0: any number, as of polygons and of the higher-order cells from 60 on.
        size = cell.GetNumberOfPoints() if cell is not None and kind < 60 else 0
        if cell is None or (size and (sizes[types == kind] != size).any()):
            raise MeshFileError(f"{path} is damaged (broken cells of type {kind}); export it again.")


def _check_indices(path: Path, connectivity: npt.NDArray[Any], n_points: int) -> None:
    if len(connectivity) and (connectivity.min() < 0 or connectivity.max() >= n_points):
        worst = connectivity.max() if connectivity.min() >= 0 else connectivity.min()
        raise MeshFileError(
            f"{path} is damaged: a face refers to point {worst}, but the points are numbered "
            f"0 to {n_points - 1}; export it again."
        )


def _polydata(path: Path, polygons: off.Polygons, notes: list[str]) -> pv.PolyData:
    _check_indices(path, polygons.connectivity, len(polygons.points))
    sizes, connectivity, cell_data = polygons.sizes, polygons.connectivity, polygons.cell_data
    small = sizes < 3
    if small.any():
        connectivity = connectivity[np.repeat(~small, sizes)]
        sizes, cell_data = sizes[~small], {name: array[~small] for name, array in cell_data.items()}
        notes.append(f"{path.name}: {int(small.sum())} faces with less than three corners were left out.")
    # VTK's layout: the size of each face before its corners.
    starts = np.cumsum(sizes) - sizes
    mesh = (
        pv.PolyData(polygons.points, np.insert(connectivity, starts, sizes)) if len(sizes) else pv.PolyData()
    )
    if not len(sizes):
        mesh.points = polygons.points
    mesh.point_data.update(polygons.point_data)
    mesh.cell_data.update(cell_data)
    return mesh


def _note_merged(path: Path, mesh: pv.PolyData, head: bytes, size: int, notes: list[str]) -> None:
    triangles = _stl_triangles(head, size)
    if triangles is None:
        last = b""
        triangles = 0
        with path.open("rb") as file:
            for line in file:
                word = line.lstrip()[:8].lower()
                triangles += word.startswith(b"facet")
                last = word or last
        if not last.startswith(b"endsolid"):
            raise MeshFileError(f"{path} does not end with endsolid; it is truncated, export it again.")
    dropped = triangles - mesh.n_cells
    notes.append(
        f"{path.name}: STL has no shared points; equal ones were merged ({3 * triangles} to {mesh.n_points})"
        + (f", and {dropped} triangles with two equal corners left out." if dropped > 0 else ".")
    )


def _merge_split_points(path: Path, mesh: pv.PolyData, notes: list[str]) -> pv.PolyData:
    """Undo what VTK's OBJ reader does to points with several texture or normal indices.

    It repeats such a point for each of them, which tears the surface open there.
    """
    with path.open("rb") as file:
        listed = sum(line.lstrip()[:2] in (b"v ", b"v\t") for line in file)
    if mesh.n_points <= listed:
        return mesh
    points = mesh.points
    order = np.lexsort(points.T)
    ahead = points[order]
    new = np.concatenate(([True], (ahead[1:] != ahead[:-1]).any(axis=1)))
    # lexsort is stable: the first of each group is the first in the file, and names the group.
    first = order[new]
    group = np.empty(len(points), dtype=np.int64)
    group[order] = np.cumsum(new) - 1
    by_file = np.argsort(first)
    number = np.empty(len(first), dtype=np.int64)
    number[by_file] = np.arange(len(first))
    target = number[group]
    merged = pv.PolyData()
    merged.points = points[first[by_file]]
    for get, put in (("GetVerts", "SetVerts"), ("GetLines", "SetLines"), ("GetPolys", "SetPolys")):
        cells = getattr(mesh, get)()
        if cells.GetNumberOfCells():
            offsets, corners = cells_of(cells)
            getattr(merged, put)(pv.CellArray.from_arrays(offsets, target[corners]))
    merged.GetCellData().ShallowCopy(mesh.GetCellData())
    merged.GetFieldData().ShallowCopy(mesh.GetFieldData())
    lost = [name or "texture coordinates" for name in point_array_names(mesh)]
    notes.append(
        f"{path.name}: points that the reader had split at texture or normal seams were merged again "
        f"({mesh.n_points} to {merged.n_points})"
        + (f"; {', '.join(lost)} left out, as they differ across seams." if lost else ".")
    )
    return merged


# ---------------------------------------------------------------------------------------- writing


def check_writable(path: str | os.PathLike[str]) -> None:
    """Refuse a path that :func:`write_surface` could not write, before the work is done.

    Raises
    ------
    MeshFileError
        The extension is not one of :data:`WRITABLE`; the folder is missing or not writable; the path
        is a folder, or a file that may not be changed.
    """
    path = Path(path).expanduser()
    if _extension(path) not in WRITABLE:
        raise MeshFileError(
            f"cannot write {path}: the extension {path.suffix or '(none)'!r} is no format that can be "
            f"written; use one of {' '.join(WRITABLE)}."
        )
    try:
        target = path.resolve(strict=False)
        if not target.parent.is_dir():
            raise MeshFileError(f"cannot write {path}: there is no folder {target.parent}; create it first.")
        if target.is_dir():
            raise MeshFileError(f"cannot write {path}: it is a folder; name a file.")
        if target.exists() and not target.is_file():
            raise MeshFileError(f"cannot write {path}: it is not a regular file; name another one.")
        if target.exists() and not os.access(target, os.W_OK):
            raise MeshFileError(
                f"cannot write {path}: the file is write-protected; unprotect it or name another one."
            )
        if not os.access(target.parent, os.W_OK | os.X_OK):
            raise MeshFileError(
                f"cannot write {path}: the folder {target.parent} is not writable; choose another one."
            )
    except MeshFileError:
        raise
    except (OSError, RuntimeError) as error:  # a name too long, a loop of links
        raise MeshFileError(f"cannot write {path}: {error}; choose another path.") from error


def write_surface(mesh: vtkPolyData, path: str | os.PathLike[str]) -> list[str]:
    """Write a surface mesh so that the file is there completely, or as it was before.

    The mesh is written to a temporary file in the same folder, which then takes the place of `path`.

    Parameters
    ----------
    mesh : vtkPolyData
        The surface; it is not changed.
    path : path-like
        Where to; the extension, one of :data:`WRITABLE`, chooses the format.

    Returns
    -------
    list of str
        What the format cannot hold: arrays, double precision, faces with more than three corners.

    Raises
    ------
    MeshFileError
        See :func:`check_writable`; or the disk is full or failed.
    """
    path = Path(path).expanduser()
    check_writable(path)
    surface = mesh if isinstance(mesh, pv.PolyData) else pv.wrap(mesh)
    target = path.resolve()
    with _atomic(path, target) as temporary:
        notes = _write(surface, temporary, path.name)
    return notes


@contextlib.contextmanager
def _atomic(path: Path, target: Path) -> Iterator[Path]:
    temporary: Path | None = None
    try:
        handle, name = tempfile.mkstemp(target.suffix, f".{target.stem[:100]}.", target.parent)
        temporary = Path(name)
        _unfinished.add(temporary)
        os.close(handle)
        yield temporary
        with temporary.open("rb+") as file:
            os.fsync(file.fileno())
        temporary.chmod(_mode(target))
        temporary.replace(target)
    except OSError as error:
        if isinstance(error, MeshFileError):
            raise
        raise MeshFileError(
            f"cannot write {path}: {error.strerror or error}; make room or choose another folder."
        ) from error
    finally:
        if temporary is not None:
            temporary.unlink(missing_ok=True)
            _unfinished.discard(temporary)


def _mode(target: Path) -> int:
    """Return the permissions of the file that is replaced, or those of any new file."""
    if target.exists():
        return stat.S_IMODE(target.stat().st_mode)
    umask = os.umask(0)
    os.umask(umask)
    return 0o666 & ~umask


def _write(mesh: pv.PolyData, temporary: Path, name: str) -> list[str]:
    extension = temporary.suffix.lower()
    notes = _losses(mesh, extension, name)
    if extension in (".off", ".ply"):
        polygons = _polygons(mesh)
        with temporary.open("wb") as file:
            _WRITE_POLYGONS[extension](file, polygons)
        return notes
    module, cls = _WRITERS[extension]
    writer = getattr(importlib.import_module(f"vtkmodules.{module}"), cls)()
    data: Any = mesh
    if extension == ".vtu":
        append = vtkAppendFilter()
        append.AddInputDataObject(mesh)
        append.Update()
        data = append.GetOutput()
    writer.SetFileName(str(temporary))
    writer.SetInputDataObject(data)
    if hasattr(writer, "SetFileTypeToBinary"):
        writer.SetFileTypeToBinary()
    # Update() and not Write(): it lets other Python threads run.
    with _vtk_messages() as messages, _hdf_silence(extension):
        _run(writer)
    code = writer.GetErrorCode()
    if messages or code:
        raise MeshFileError(
            f"cannot write {name}: {messages[0] if messages else f'error {code} of VTK'}; "
            "make room or choose another folder."
        )
    if extension in _VERIFIED:
        incomplete = MeshFileError(f"cannot write {name}: it came out incomplete; make room on the disk.")
        try:
            written = _read_with_vtk(temporary, extension)
        except MeshFileError:
            raise incomplete from None
        if written.GetNumberOfCells() != data.GetNumberOfCells():
            raise incomplete
    return notes


def _polygons(mesh: pv.PolyData) -> off.Polygons:
    offsets, corners = cells_of(mesh.GetPolys())
    before = mesh.n_verts + mesh.n_lines
    inside = slice(before, before + len(offsets) - 1)
    return off.Polygons(
        points_of(mesh),
        np.diff(offsets).astype(np.int64),
        corners.astype(np.int64, copy=False),
        _numeric(mesh.point_data),
        {name: array[inside] for name, array in _numeric(mesh.cell_data).items()},
    )


def _numeric(data: pv.DataSetAttributes) -> dict[str, npt.NDArray[Any]]:
    return {name: np.asarray(array) for name, array in data.items() if name and array.dtype.kind in "biuf"}


def _write_off(file: IO[bytes], polygons: off.Polygons) -> None:
    off.write(file, polygons.points, polygons.sizes, polygons.connectivity)


_WRITE_POLYGONS: dict[str, Callable[[IO[bytes], off.Polygons], None]] = {
    ".off": _write_off,
    ".ply": ply.write,
}


def _losses(mesh: pv.PolyData, extension: str, name: str) -> list[str]:
    """Say what the format does not keep."""
    notes = []
    point, cell, fields = (
        [name or "(unnamed)" for name in data.keys()]  # noqa: SIM118 (iterating skips no unnamed ones)
        for data in (mesh.point_data, mesh.cell_data, mesh.field_data)
    )
    # What a run reports about itself is told to the user anyway.
    fields = [name for name in fields if not name.startswith("Smoothing")]
    lost = {
        ".obj": [n for n in point if n not in ("Normals", "TCoords")] + cell + fields,
        ".off": point + cell + fields,
        ".ply": [
            *(
                n
                for n, a in [*mesh.point_data.items(), *mesh.cell_data.items()]
                if a.dtype.kind not in "biuf"
            ),
            *fields,
        ],
        ".stl": point + cell + fields,
    }.get(extension, [])
    format_name = extension[1:].upper()
    if lost:
        notes.append(f"{name}: {format_name} does not keep the arrays {', '.join(lost)}.")
    if extension == ".ply":
        split = [
            n
            for n, a in [*mesh.point_data.items(), *mesh.cell_data.items()]
            if a.ndim > 1 and a.shape[1] > 1 and n not in ("Normals", "RGB", "RGBA")
        ]
        if split:
            notes.append(f"{name}: PLY keeps arrays with several components as one each: {', '.join(split)}.")
    if extension == ".stl":
        if mesh.points.dtype != np.float32:
            notes.append(f"{name}: STL keeps single precision only; the points were rounded.")
        if not mesh.is_all_triangles:
            notes.append(f"{name}: STL holds triangles only; larger faces were split.")
    if extension in (".off", ".ply", ".stl", ".obj") and mesh.n_verts + mesh.n_lines + mesh.n_strips:
        notes.append(f"{name}: only the polygons were written, not verts, lines and strips.")
    if extension == ".vtu":
        notes.append(f"{name}: VTU holds no polygonal data; the faces were written as an unstructured grid.")
    return notes
