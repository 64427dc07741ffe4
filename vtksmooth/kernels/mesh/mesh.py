"""The mesh as arrays: points, and faces as offsets into a connectivity list."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ...errors import InvalidMeshError
from ...jit.compiled import device, kernel

#: Topology is kept in 32 bits: half the memory traffic of 64, and no mesh of 700 million triangles
#: fits the rest of the machine.
_INDEX_LIMIT = 2**31 - 1

#: Faces with more corners ("giants": the caps of cylinders) are measured roughly, and their vertices do
#: not move: looking at all of such a face for each of its vertices takes cubic time.
LARGEST_POLYGON = 64

#: Squares of areas of faces this large or this small leave the range of float64.
LARGEST_COORDINATE, _SMALLEST_MESH = 1e70, 1e-70


@dataclass(frozen=True)
class Mesh:
    """A polygonal surface mesh. Make one with :meth:`from_arrays`, which checks it.

    Parameters
    ----------
    points : (n, 3) float64
        Coordinates, model units.
    offsets : (m + 1,) int32
        Face f has the corners ``connectivity[offsets[f]:offsets[f + 1]]``.
    connectivity : (k,) int32
        Point indices, face by face, in the face's direction of turning.
    face_labels : (m, 2) int32, optional
        Of a surface between labels: the labels on the two sides of each face, numbered from 0; normals run
        from the first to the second. See :func:`~vtksmooth.kernels.mesh.labels.labelled`.
    """

    points: npt.NDArray[np.float64]
    offsets: npt.NDArray[np.int32]
    connectivity: npt.NDArray[np.int32]
    face_labels: npt.NDArray[np.int32] | None = None

    @classmethod
    def from_arrays(cls, points: npt.ArrayLike, offsets: npt.ArrayLike, connectivity: npt.ArrayLike) -> Mesh:
        """Check three arrays and make a mesh of them, without a copy where the types already fit.

        Raises
        ------
        InvalidMeshError
            There are no points or no faces; offsets or indices are no integers, or out of range; a point
            that a face uses is not finite, or so large that areas overflow; all are so small that areas
            vanish.
        """
        points = np.ascontiguousarray(points, dtype=np.float64)
        raw_offsets, raw_connectivity = np.asarray(offsets), np.asarray(connectivity)
        if points.ndim != 2 or points.shape[1] != 3:
            raise InvalidMeshError(f"points must have the shape (n, 3), not {points.shape}.")
        if len(points) == 0:
            raise InvalidMeshError("The mesh is empty: it has no points.")
        if raw_offsets.ndim != 1 or raw_connectivity.ndim != 1:
            raise InvalidMeshError("Offsets and connectivity must be one-dimensional arrays.")
        if len(raw_offsets) < 2:
            raise InvalidMeshError("The mesh has no faces; smoothing needs a surface of polygons.")
        if any(len(raw) and raw.dtype.kind not in "iu" for raw in (raw_offsets, raw_connectivity)):
            raise InvalidMeshError("Offsets and connectivity must be integers.")
        if max(len(raw_connectivity), len(points)) > _INDEX_LIMIT:
            raise InvalidMeshError("The mesh has more than 2^31 points or corners; split it into parts.")
        if (
            raw_offsets[0] != 0
            or raw_offsets[-1] != len(raw_connectivity)
            or (raw_offsets[1:] < raw_offsets[:-1]).any()
        ):
            raise InvalidMeshError(
                "The face offsets are broken: they must rise from 0 to the number of corners."
            )
        if len(raw_connectivity):
            low, high = int(raw_connectivity.min()), int(raw_connectivity.max())
            if low < 0 or high >= len(points):
                wrong = high if low >= 0 else low
                raise InvalidMeshError(
                    f"A face refers to point {wrong}, but the points are numbered 0 to {len(points) - 1}."
                )
        mesh = cls(
            points,
            np.ascontiguousarray(raw_offsets, dtype=np.int32),
            np.ascontiguousarray(raw_connectivity, dtype=np.int32),
        )
        mesh._check_coordinates()
        return mesh

    @classmethod
    def from_faces(cls, points: npt.ArrayLike, faces: Any) -> Mesh:
        """Make a mesh from points and a list of faces (an (m, c) array, or a sequence of sequences)."""
        if isinstance(faces, np.ndarray) and faces.ndim == 2:
            count, size = faces.shape
            return cls.from_arrays(points, size * np.arange(count + 1), faces.ravel())
        sizes = [len(face) for face in faces]
        flat = [np.asarray(face, dtype=np.int64) for face in faces]
        connectivity = np.concatenate(flat) if flat else np.empty(0, dtype=np.int64)
        return cls.from_arrays(points, np.concatenate(([0], np.cumsum(sizes))), connectivity)

    def _check_coordinates(self) -> None:
        # One pass over all points decides nearly always; which of the bad ones matter is asked after.
        largest = np.abs(self.points).max()
        if 0.0 < largest < _SMALLEST_MESH:
            raise InvalidMeshError(
                f"Coordinates go up to {largest:.3g} only, where areas vanish; scale the mesh up."
            )
        if largest <= LARGEST_COORDINATE:
            return
        used = self.used_points
        coordinates = self.points[used]
        bad = used[~np.isfinite(coordinates).all(axis=1)]
        if len(bad):
            raise InvalidMeshError(
                f"{len(bad)} of the points used by faces have NaN or infinite coordinates "
                f"(the first is point {bad[0]}); repair or remove them."
            )
        if len(used) and np.abs(coordinates).max() > LARGEST_COORDINATE:
            raise InvalidMeshError(
                f"Coordinates go up to {np.abs(coordinates).max():.3g}, where areas overflow; "
                "scale the mesh down."
            )

    def with_points(self, points: npt.NDArray[np.float64]) -> Mesh:
        """Return the same faces over other points."""
        return Mesh(points, self.offsets, self.connectivity, self.face_labels)

    @property
    def n_points(self) -> int:
        """Number of points, those that no face uses included."""
        return len(self.points)

    @property
    def n_faces(self) -> int:
        """Number of faces."""
        return len(self.offsets) - 1

    @property
    def face_sizes(self) -> npt.NDArray[np.int32]:
        """Corners of each face, (m,) int32."""
        return np.diff(self.offsets)

    @functools.cached_property
    def only_triangles(self) -> bool:
        """Whether every face has three corners."""
        return len(self.connectivity) == 3 * self.n_faces and bool((self.face_sizes == 3).all())

    @functools.cached_property
    def only_quadrilaterals(self) -> bool:
        """Whether every face has four corners."""
        return len(self.connectivity) == 4 * self.n_faces and bool((self.face_sizes == 4).all())

    @property
    def used_points(self) -> npt.NDArray[np.int64]:
        """Numbers of the points that faces use, rising, int64."""
        return np.flatnonzero(np.bincount(self.connectivity))  # np.unique takes thirty times as long

    @property
    def diagonal(self) -> float:
        """Length of the bounding box's diagonal, over the points that faces use."""
        if not len(self.connectivity):
            return 0.0
        box = np.array([[np.inf] * 3, [-np.inf] * 3])
        _widen(self.points, self.connectivity, box)
        return float(np.linalg.norm(box[1] - box[0]))

    @property
    def span(self) -> float:
        """Twice the distance of the farthest point that faces use from the mean of them all.

        Of a box it is the diagonal; unlike :attr:`diagonal` it is the same in every pose.
        """
        if not len(self.connectivity):
            return 0.0
        points = self.points[self.used_points]
        return 2.0 * float(np.linalg.norm(points - points.mean(axis=0), axis=1).max())


@device
def widen(box, points, v):
    """Make the box (2, 3), low and high corner, hold v."""
    for axis in range(3):
        box[0, axis] = min(box[0, axis], points[v, axis])
        box[1, axis] = max(box[1, axis], points[v, axis])


@kernel
def _widen(points, connectivity, box):
    for c in range(connectivity.size):
        widen(box, points, connectivity[c])
