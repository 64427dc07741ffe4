"""Compiling every kernel beforehand, so that no later run waits for the compiler."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import suppress

import numpy as np
from vtkmodules.vtkCommonCore import vtkIdList, vtkPoints
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkPolyData
from vtkmodules.vtkFiltersCore import vtkAppendPolyData
from vtkmodules.vtkFiltersSources import vtkCubeSource

from .errors import InvalidMeshError, ParameterError
from .files import corners, numerals, shortest
from .filters import (
    FILTERS,
    ContainmentCheck,
    FeatureDetection,
    Filter,
    LaplacianSmoothing,
    SegmentationSurface,
)
from .filters.arrays import points_of, surface_of, vtk_array, vtk_points
from .filters.smoothing import FIXED
from .jit.compile_ahead import compiling_ahead
from .jit.compiled import on_compile
from .kernels.distance import visibility
from .kernels.distance.ray import first_hit
from .kernels.mesh import adjacency, paths, regions
from .kernels.mesh.mesh import Mesh


def bump(size: int, kind: str) -> vtkPolyData:
    """Return a bumpy grid of triangles, quads, or both in turn; one point of it is fixed.

    The last kind is closed by one large polygon: more corners than triangulation takes at once.
    """
    mesh = vtkPolyData()
    points = vtkPoints()
    for j in range(size):
        for i in range(size):
            points.InsertNextPoint(i + 0.3 * ((i * j) % 2), j, 0.2 * ((i + j) % 3))
    mesh.SetPoints(points)
    mesh.AllocateEstimate(2 * size * size, 4)
    for j in range(size - 1):
        for i in range(size - 1):
            a = j * size + i
            b, c, d = a + 1, a + size + 1, a + size
            split = kind == "triangles" or (kind == "mixed" and (i + j) % 2)
            for face in ((a, b, c), (a, c, d)) if split else ((a, b, c, d),):
                corners = vtkIdList()
                for corner in face:
                    corners.InsertNextId(corner)
                mesh.InsertNextCell(7, corners)
    if kind == "mixed":
        grid, corners = np.arange(size * size).reshape(size, size), vtkIdList()
        for corner in np.concatenate((grid[:-1, 0], grid[-1, :-1], grid[:0:-1, -1], grid[0, :0:-1])):
            corners.InsertNextId(int(corner))
        mesh.InsertNextCell(7, corners)
    fixed = np.zeros(size * size, dtype=np.uint8)
    fixed[size + 1] = 1
    mesh.GetPointData().AddArray(vtk_array(fixed, FIXED))
    mesh.GetPointData().AddArray(vtk_array(np.tile([1.0, 0.0, 0.0], (size * size, 1)), "Flow"))
    mesh.GetPointData().AddArray(vtk_array(np.full(size * size, 0.1), "Displacement"))
    return mesh


def space_over(size: int) -> vtkPolyData:
    """Return a box round the bumps, near to their top."""
    box = vtkCubeSource(bounds=(-1.0, size + 1.0, -1.0, size, -1.0, 0.41))
    box.Update()
    space: vtkPolyData = box.GetOutput()
    return space


def _solids(size: int) -> tuple[vtkPolyData, vtkPolyData]:
    """Return two boxes that overlap, and one that is open."""
    both, opened = vtkAppendPolyData(), vtkPolyData()
    both.AddInputData(space_over(size))
    both.AddInputData(space_over(size + 1))
    both.Update()
    opened.DeepCopy(space_over(size))
    opened.BuildLinks()
    opened.DeleteCell(0)
    opened.RemoveDeletedCells()
    return both.GetOutput(), opened


#: Values that make a filter use all that it can; stop rules so wide that nothing stops.
_EVERYTHING = {
    "iterations": 2,
    "boundary": "sliding",
    "features": "slide",
    "crease_angle": 40.0,
    "max_deviation_fraction": 0.5,
    "stop_normal_deviation": 180.0,
    "stop_dihedral_change": 360.0,
    "stop_deviation_fraction": 10.0,
    "stop_volume_percent": 1e6,
    "stop_gain": -1.0,
    "tangent_plane": True,
    "back_to_surface": True,
    "null_space": True,
    "corrections": 0,
    "preserve_volume": False,
    "weighted": True,
    "eigenvalue_ratios": True,
    "hausdorff": True,
    "flow": "Flow",
    "fix": "0-3",
    "grow": 1,
    "blend_rings": 1,
    "add_lines": "0-1",
}

#: What the above excludes.
_BESIDES: tuple[dict[str, object], ...] = (
    {"implicit_step": 2.0},
    {"directions": "xy"},
    {"max_displacement": "Displacement"},
    {"null_space": True, "corrections": 0, "preserve_volume": False},
    {"null_space": True, "corrections": 0, "preserve_volume": False, "gate": "aspect"},
    {"preserve_volume": True, "corrections": 0, "boundary": "smoothed"},
    {"preserve_volume": True, "corrections": 0},
    {"corrections": 1, "preserve_volume": True},
    {"corrections": 1, "preserve_volume": True, "gate": "aspect", "boundary": "sliding"},
)


def _settings(cls: type[Filter]) -> Iterator[dict[str, object]]:
    """Yield parameter values that together reach every scheme, gate and constraint of a filter."""
    declared = cls.parameters()
    everything = {name: value for name, value in _EVERYTHING.items() if name in declared}
    settings = [
        {},
        everything,
        *({n: v for n, v in besides.items() if n in declared} for besides in _BESIDES),
    ]
    for name in ("scheme", "gate", "weight", "weights", "containment", "method"):
        for choice in (declared[name].choices or ()) if name in declared else ():
            settings += [{name: choice}, {**everything, name: choice}]
    for setting in settings:
        # What has no say would be refused.
        values = {name: parameter.default for name, parameter in declared.items()} | setting
        yield {name: value for name, value in setting.items() if declared[name].has_say(values.get)}


def _flat_in_part(size: int) -> vtkPolyData:
    """Return a bumpy grid of which half is flat: noise that is uneven."""
    mesh = bump(size, "triangles")
    points = points_of(mesh).copy()
    points[points[:, 1] < size / 2, 2] = 0.0
    mesh.SetPoints(vtk_points(points))
    return mesh


def label_image(size: int) -> vtkImageData:
    """Return an image of two labels that touch each other, and the background."""
    labels = np.zeros((size, size, size), np.uint8)
    labels[1:-1, 1:-1, 1:-1] = 1
    labels[2:, 2:, size // 2 :] = 2
    image = vtkImageData(dimensions=(size, size, size))
    image.GetPointData().SetScalars(vtk_array(labels.ravel(order="F"), "Labels"))
    return image


def _smooth_labels(size: int) -> None:
    surface = SegmentationSurface(iterations=2)(label_image(size))
    LaplacianSmoothing(iterations=2, preserve_volume=True)(surface)
    LaplacianSmoothing(iterations=1, scheme="pairwise", gate="floor")(surface)


def _pick(mesh: Mesh) -> None:
    """Do what the tools of the desktop app do with the mouse."""
    first_hit(mesh, (0.0, 0.0, 9.0), (0.0, 0.0, -1.0))
    places = visibility.project(mesh.points, np.eye(4), (0.0, 0.0, 9.0, 9.0))
    seen = visibility.seen(places, np.ones((9, 9), np.float32))
    visibility.add_stroke(places, seen, (0.0, 0.0), (9.0, 9.0), 2.0, np.zeros_like(seen))
    visibility.inside_outline(places, seen, [[0.0, 0.0], [9.0, 0.0], [0.0, 9.0]])
    regions.components(mesh)
    regions.patches(adjacency.build(mesh), np.empty((0, 2), np.int32))
    regions.marked_faces(mesh, seen)
    paths.shortest_path(mesh.points, regions.rings_of(mesh), 0, 1)


def run(progress: Callable[[float, str], None] | None = None) -> int:
    """Run all schemes, constraints, measures and views on small meshes, so that all kernels are compiled.

    Parameters
    ----------
    progress : callable, optional
        Called with the part done, 0 to 1, and the name of the filter; what it raises ends the run.

    Returns
    -------
    int
        How many kernels were compiled; 0 when all of them had been before.
    """
    size = 6
    meshes, space = [bump(size, kind) for kind in ("triangles", "quads", "mixed")], space_over(size)
    jobs = [(cls, setting) for cls in FILTERS for setting in _settings(cls)]
    compiled: list[str] = []
    with on_compile(compiled.append), compiling_ahead(""):
        for number, (cls, setting) in enumerate(jobs):
            if progress:
                progress(number / len(jobs), cls.command)
            for mesh in meshes:
                # Some schemes, constraints and faces do not combine, and say so.
                with suppress(InvalidMeshError, ParameterError):
                    cls(**setting)(*(space if name == "installation" else mesh for name in cls.inputs))
        for solid in _solids(size):
            ContainmentCheck()(space, solid)
        FeatureDetection()(_flat_in_part(16))
        LaplacianSmoothing()(space)  # points of boxes are there once for each face: several in one place
        _smooth_labels(size)
        _pick(surface_of(meshes[0]).mesh)
        # Of large text files.
        numerals.parsed(b"0")
        shortest.table_lines(b"v", np.zeros((1, 3)))
        corners.write(b"f", np.array([3]), np.arange(1, 10).reshape(3, 3))
        corners.read(b"1 2 3\n")
    if progress:
        progress(1.0, "done")
    return len(compiled)
