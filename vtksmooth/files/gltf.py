"""glTF files in one piece (.glb): triangles in single precision, as programs that show meshes read them.

VTK's writer does it. Reference: Khronos Group, "glTF 2.0 Specification", ISO/IEC 12113:2022.
"""

from __future__ import annotations

from pathlib import Path
from typing import IO, Any

import numpy as np
import numpy.typing as npt
from vtkmodules.vtkCommonDataModel import vtkMultiBlockDataSet, vtkPolyData
from vtkmodules.vtkIOGeometry import vtkGLTFWriter

from ..filters.arrays import vtk_array, vtk_points, vtk_triangles
from . import vtk_messages, vtk_readers
from .polygons import Kept, Polygons


def write(file: IO[bytes], mesh: Polygons) -> Kept:
    """Write a file of a mesh of triangles, with the points' normals, colours and texture coordinates."""
    kept = Kept(set(), set(), set())
    surface = vtkPolyData()
    surface.SetPoints(vtk_points(mesh.points.astype(np.float32)))
    surface.SetPolys(vtk_triangles(mesh.connectivity.reshape(-1, 3)))
    data = surface.GetPointData()
    normals, textures = mesh.name_of("Normals", 3), mesh.name_of("TCoords", 2)
    colour = mesh.colours(mesh.point_data)
    if normals:
        data.SetNormals(vtk_array(_single(mesh, normals)[:, :3], "Normals"))
    if textures:
        data.SetTCoords(vtk_array(_single(mesh, textures)[:, :2], "TCoords"))
    if colour:
        values = mesh.point_data[colour]
        # Of bytes, the writer makes files that nothing can read.
        table = np.ones((len(values), 4), np.float32)
        table[:, : values.shape[1]] = values / 255.0 if values.dtype == np.uint8 else values
        data.SetScalars(vtk_array(table, "Colours"))
    kept.point_data.update(name for name in (normals, textures, colour) if name)
    building, scene = vtkMultiBlockDataSet(), vtkMultiBlockDataSet()
    building.SetBlock(0, surface)
    scene.SetBlock(0, building)
    writer: Any = vtkGLTFWriter()
    writer.SetFileName(vtk_readers.file_name(Path(file.name)))
    writer.SetInputDataObject(scene)
    writer.SetSaveNormal(normals is not None)
    writer.SetSaveTextures(textures is not None)
    writer.SetSaveActivePointColor(colour is not None)
    with vtk_messages.collected() as messages:
        vtk_messages.run(writer)
    if messages:
        raise OSError(messages[0])
    with Path(file.name).open("rb") as written:
        head = written.read(12)
        size = written.seek(0, 2)
    # The writer reports no failure of the disk; the file's head says how long it is to be.
    if int.from_bytes(head[8:12], "little") != size:
        raise OSError("the file is not complete")
    return kept


def _single(mesh: Polygons, name: str) -> npt.NDArray[np.float32]:
    with np.errstate(over="ignore"):
        return mesh.point_data[name].astype(np.float32)
