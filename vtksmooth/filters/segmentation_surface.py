"""SegmentationSurface: a label image in, smooth surfaces out that fit together."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import (
    vtkCompositeDataSet,
    vtkDataObject,
    vtkImageData,
    vtkMultiBlockDataSet,
    vtkPolyData,
)

from ..errors import InvalidMeshError, ParameterError
from ..kernels.mesh.labels import labelled
from ..kernels.mesh.mesh import Mesh
from ..kernels.mesh.places import distinct_places
from ..kernels.mesh.triangulate import triangulate
from ..kernels.smoothing import loop
from ..kernels.smoothing.constraints.self_intersection import NoNewSelfIntersections
from ..kernels.smoothing.schemes.pairwise_labels import PairwiseLabels
from ..report import LabelVolume, SegmentationReport
from .arrays import name_of, vtk_array, vtk_points, vtk_triangles
from .base import Filter, add_field
from .labels import BOUNDARY_LABELS, Labels, closed_surface, parse_labels
from .parameter import Parameter
from .smoothing import SmoothingFilter

#: Labels whose values span no more than this are numbered by a table; otherwise they are sorted.
_SPAN = 1 << 20


class SegmentationSurface(Filter):
    """Turn a label image into smooth surfaces that fit together; every label keeps its volume.

    VTK's SurfaceNets, without its smoothing, takes one surface between all labels from the voxels; points
    that coincide are merged; its quadrilaterals are split into triangles; and pairs of points move such that
    the volumes of all labels stay (see the scheme ``pairwise``). Lines where several labels meet, and the
    junctions of these lines, move like all other points.

    The output has the cell array ``BoundaryLabels`` with the labels on both sides of each triangle; normals
    run from the first to the second, which is the background wherever that is one of them. With `separate`
    the output is a multi-block dataset with one closed surface for each label, named by the label: on common
    walls the surfaces have the same points, bit for bit.

    Guarantees
    ----------
    The volume of every label is that of its voxels to 1e-12 of it, in double precision (that of the
    output). No triangle turns over, and no two triangles cross or touch that did not before they were
    smoothed (unless ``self_intersection="ignore"``). Where no steps were taken back for that
    (``report.taken_back``), no quality k falls below 0.2 that has not been there. No label is lost.

    Attributes
    ----------
    report : SegmentationReport
        The volume of every label before and after, and what was found on the way.

    Examples
    --------
    >>> import numpy as np
    >>> from vtkmodules.vtkCommonDataModel import vtkImageData
    >>> from vtksmooth import SegmentationSurface
    >>> from vtksmooth.filters.arrays import vtk_array
    >>> image = vtkImageData(dimensions=(6, 6, 6))
    >>> labels = np.zeros((6, 6, 6), np.uint8)
    >>> labels[1:5, 1:5, 1:3], labels[1:5, 1:5, 3:5] = 1, 2
    >>> image.GetPointData().SetScalars(vtk_array(labels.ravel(order="F"), "labels"))
    0
    >>> segmentation = SegmentationSurface()
    >>> surface = segmentation(image)
    >>> [(each.label, each.voxels, round(each.volume, 12)) for each in segmentation.report.labels]
    [(1, 32, 32.0), (2, 32, 32.0)]
    """

    command = "segmentation"
    inputs = ("image",)
    accepts = (vtkImageData,)

    scalars = Parameter(
        None, "Array of the labels; off, the active scalars or the only array.", optional=True, type=str
    )
    labels = Parameter("all", "Labels to take, such as 1,3,5-9; all others are background.", text="labels")
    background = Parameter(0, "Label of what is around the others, and outside of the image.")
    border = Parameter(
        "closed", "Whether surfaces are closed along the border of the image, or left open there.",
        choices=("closed", "open"),
    )  # fmt: skip
    iterations = Parameter(20, "Sweeps of smoothing; 0 leaves the stairs of the voxels.", low=0)
    relaxation_factor = Parameter(
        0.2, "Part of the umbrella step that each operation on a pair takes.", low=0.0, high=1.0
    )
    self_intersection = SmoothingFilter.self_intersection.with_default("none-new")
    separate = Parameter(
        False, "Return one closed surface for each label instead of one surface between all."
    )

    report: SegmentationReport

    def forget(self) -> None:
        """Drop what the last execution reported."""
        super().forget()
        self.report = SegmentationReport()

    @property
    def figures(self) -> dict[str, Any]:
        """The report as a dictionary."""
        return self.report.figures()

    def RequestDataObject(self, request: Any, inInfo: Any, outInfo: Any) -> int:
        """Make the output: polydata, or one block for each label."""
        kind = vtkMultiBlockDataSet if self.separate else vtkPolyData
        output = vtkDataObject.GetData(outInfo, 0)
        if output is None or not output.IsA(kind.__name__):
            outInfo.GetInformationObject(0).Set(vtkDataObject.DATA_OBJECT(), kind())
        return 1

    def _execute_all(self, sources: list[Any], outputs: list[Any]) -> None:
        self._share = (0.0, 1.0)
        surface, names = self.execute(sources[0])
        outputs[0].ShallowCopy(self._blocks_of(surface, names) if self.separate else surface)

    def execute(self, *inputs: Any) -> Any:
        """Return the surface of one image, and its labels without the background."""
        (image,) = inputs
        self.progress(0.0, "reading labels")
        voxels, grid = label_voxels(image, self.scalars)
        numbers, names = self._numbered(voxels)
        counts = np.bincount(numbers.ravel(), minlength=len(names))
        self.progress(0.02, "finding surfaces")
        mesh, merged = self._walls(numbers, names)
        self.progress(0.05, "triangulating")
        corners, cell = triangulate(mesh)
        points = grid.place(mesh.points)
        assert mesh.face_labels is not None
        if grid.mirrored:
            corners = corners[:, ::-1]
        offsets = np.arange(0, 3 * len(corners) + 1, 3, dtype=np.int32)
        triangles = Mesh.from_arrays(points, offsets, np.ascontiguousarray(corners).ravel())
        triangles, _ = labelled(triangles, mesh.face_labels[cell])
        self.progress(0.08)
        self._share = (0.1, 1.0)
        points, run = loop.smooth(
            triangles,
            PairwiseLabels(self.relaxation_factor),
            [NoNewSelfIntersections()] if self.self_intersection == "none-new" else [],
            iterations=self.iterations,
            progress=self.progress,
        )
        report = SegmentationReport(**vars(run))
        report.labels = [
            LabelVolume(int(name), int(count), before, after)
            for (name, count, (_, before, after)) in zip(
                names.tolist(), counts.tolist(), run.label_volumes, strict=True
            )
        ][1:]
        report.label_volumes = tuple(
            (int(names[number]), before, after) for number, before, after in run.label_volumes
        )
        report.voxel_volume, report.merged_points = grid.volume, merged
        self.report = report
        if merged:
            self.notes.append(
                f"{merged} points lie where another one is, where a label touches itself: they were merged."
            )
        return self._surface(triangles, points, names), names[1:]

    def _numbered(self, voxels: Labels) -> tuple[npt.NDArray[np.int32], Labels]:
        """Return the labels as numbers from 1, 0 for the background; and the value of each number."""
        low, high = int(voxels.min()), int(voxels.max())
        table = high - low < _SPAN
        if table:
            # Differences of signed labels may leave their own type.
            places = (voxels.astype(np.int64) - low).ravel()
            there = low + np.flatnonzero(np.bincount(places, minlength=high - low + 1))
        else:
            there, places = np.unique(voxels, return_inverse=True)
        own = there[there != self.background]
        if not len(own):
            raise InvalidMeshError(
                f"The image holds nothing but the background, label {self.background}; name another one."
            )
        chosen = parse_labels("labels", self.labels, own)
        number = np.zeros(len(there), np.int32)
        number[np.searchsorted(there, chosen)] = np.arange(1, len(chosen) + 1)
        if table:
            wide = np.zeros(high - low + 1, np.int32)
            wide[there - low] = number
            number = wide
        names = np.concatenate(([self.background], chosen)).astype(np.int64)
        return number[places].reshape(voxels.shape), names

    def _walls(self, numbers: npt.NDArray[np.int32], names: Labels) -> tuple[Mesh, int]:
        """Return the quadrilaterals between labels, in voxels; and how many points were merged."""
        closed = self.border == "closed"
        around = np.pad(numbers, 1) if closed else numbers
        most = np.iinfo(np.uint16).max
        image = vtkImageData(dimensions=around.shape)
        values = around.astype(
            np.uint8 if len(names) < 255 else np.uint16 if len(names) < most else np.float64
        )
        image.GetPointData().SetScalars(vtk_array(values.ravel(order="F"), "Labels"))
        from vtkmodules.vtkFiltersCore import vtkSurfaceNets3D  # older than VTK 9.3 has none

        nets = vtkSurfaceNets3D()
        nets.SetInputData(image)
        nets.SmoothingOff()
        nets.SetOutputMeshTypeToQuads()
        nets.SetBackgroundLabel(0)
        for number in range(1, len(names)):
            nets.SetValue(number - 1, number)
        nets.Update()
        walls = nets.GetOutput()
        if not walls.GetNumberOfPolys():
            raise InvalidMeshError(
                "No surface lies between the labels of the image: one label fills it; close the border, or "
                "choose other labels."
            )
        points = vtk_to_numpy(walls.GetPoints().GetData()).astype(np.float64) - (1.0 if closed else 0.0)
        quads = vtk_to_numpy(walls.GetPolys().GetConnectivityArray()).reshape(-1, 4)
        sides = vtk_to_numpy(walls.GetCellData().GetArray(BOUNDARY_LABELS)).astype(np.int32)
        place, first = distinct_places(points)
        mesh, _ = labelled(Mesh.from_faces(points[first], place[quads]), sides)
        return mesh, len(place) - len(first)

    def _surface(self, mesh: Mesh, points: npt.NDArray[np.float64], names: Labels) -> vtkPolyData:
        """Return the output: where the background is on one side, the normal runs towards it."""
        assert mesh.face_labels is not None
        corners, sides = mesh.connectivity.reshape(-1, 3), names[mesh.face_labels]
        outside = mesh.face_labels[:, 0] == 0
        corners = np.where(outside[:, None], corners[:, ::-1], corners)
        sides = np.where(outside[:, None], sides[:, ::-1], sides)
        result = vtkPolyData()
        result.SetPoints(vtk_points(points))
        result.SetPolys(vtk_triangles(corners))
        result.GetCellData().AddArray(vtk_array(sides, BOUNDARY_LABELS))
        add_field(result, "LabelVolumes", np.array([each.volume for each in self.report.labels]))
        add_field(result, "Labels", np.array([each.label for each in self.report.labels]))
        return result

    def _blocks_of(self, surface: vtkPolyData, names: Labels) -> vtkMultiBlockDataSet:
        corners = vtk_to_numpy(surface.GetPolys().GetConnectivityArray()).reshape(-1, 3)
        sides = vtk_to_numpy(surface.GetCellData().GetArray(BOUNDARY_LABELS))
        blocks = vtkMultiBlockDataSet()
        for number, name in enumerate(names.tolist()):
            blocks.SetBlock(number, closed_surface(surface, corners, sides, name))
            blocks.GetMetaData(number).Set(vtkCompositeDataSet.NAME(), str(name))
        return blocks


class Grid:
    """Where the voxels of an image are.

    Parameters
    ----------
    image : vtkImageData
    half : float
        Where the middle of the first voxel is, in voxels from the image's first point.
    """

    def __init__(self, image: Any, half: float) -> None:
        matrix = image.GetDirectionMatrix()
        direction = np.array([[matrix.GetElement(i, j) for j in range(3)] for i in range(3)])
        self._axes = direction * np.array(image.GetSpacing())
        first = np.array(image.GetExtent()[::2]) + half
        self._origin = np.array(image.GetOrigin()) + self._axes @ first
        determinant = float(np.linalg.det(self._axes))
        self.volume, self.mirrored = abs(determinant), determinant < 0.0

    def place(self, points: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        """Return the coordinates of places that are given in voxels."""
        return np.ascontiguousarray(self._origin + points @ self._axes.T)


def label_voxels(image: Any, name: str | None) -> tuple[Labels, Grid]:
    """Return the labels of an image, (x, y, z), and where the voxels are.

    Raises
    ------
    InvalidMeshError
        The image is flat, or its values are no labels.
    ParameterError
        There is no such array, or several and none is active.
    """
    homes = (image.GetPointData(), image.GetCellData())
    if name is not None:
        found = [(data, data.GetArray(name)) for data in homes if data.GetArray(name) is not None]
    else:
        found = [(data, data.GetScalars()) for data in homes if data.GetScalars() is not None]
        found = found or [
            (data, data.GetArray(i))
            for data in homes
            for i in range(data.GetNumberOfArrays())
            if data.GetArray(i)
        ]
    if not found or (name is None and homes[0].GetScalars() is None and len(found) > 1):
        known = [name_of(data.GetAbstractArray(i)) for data in homes for i in range(data.GetNumberOfArrays())]
        what = f"there is no array {name!r}" if name is not None else "no array is the active one"
        raise ParameterError(f"scalars: {what}; the image has: {', '.join(known) or 'no arrays'}.")
    data, array = found[0]
    of_cells = data is homes[1]
    size = tuple(max(1, n - 1) if of_cells else n for n in image.GetDimensions())
    flat = min(image.GetDimensions()) < 2
    values = vtk_to_numpy(array)
    if values.ndim > 1:
        raise InvalidMeshError(
            f"The array {name_of(array)!r} has {values.shape[1]} components; labels are single numbers."
        )
    if flat:
        raise InvalidMeshError(
            f"The image is flat ({' x '.join(map(str, size))}); surfaces need three dimensions."
        )
    if len(values) != np.prod(size):
        raise InvalidMeshError(
            f"The array {name_of(array)!r} has {len(values)} values for {' x '.join(map(str, size))} voxels."
        )
    if values.dtype.kind == "f":
        whole = np.isfinite(values).all() and bool((values == np.rint(values)).all())
        if not whole or np.abs(values).max() >= 2.0**53:
            raise InvalidMeshError(
                f"The array {name_of(array)!r} holds other numbers than whole ones; labels are integers: "
                "segment the image first."
            )
        values = values.astype(np.int64)
    if not (np.array(image.GetSpacing()) > 0).all():
        raise InvalidMeshError(f"The image's spacing {image.GetSpacing()} must be greater than 0.")
    return values.reshape(size, order="F"), Grid(image, 0.5 if of_cells else 0.0)
