"""Cross-sections: the outline of a mesh in a plane."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from vtkmodules.vtkCommonDataModel import vtkPlane, vtkPolyData
from vtkmodules.vtkFiltersCore import vtkCutter

from vtksmooth.filters.arrays import cells_of, points_of

from .state import State

Vector = npt.NDArray[np.float64]
_AXES = "xyz"


@dataclass(frozen=True)
class Plane:
    """A plane to cut with.

    Attributes
    ----------
    origin : tuple of float
        A point of the plane.
    normal : tuple of float
        Of any length but 0.
    """

    origin: tuple[float, float, float]
    normal: tuple[float, float, float]

    @classmethod
    def of(cls, origin: npt.ArrayLike, normal: npt.ArrayLike) -> Plane:
        """Return the plane through `origin`, (3,), at right angles to `normal`, (3,)."""
        x, y, z = (float(value) for value in np.asarray(origin))
        u, v, w = (float(value) for value in np.asarray(normal))
        return cls((x, y, z), (u, v, w))

    @property
    def frame(self) -> Vector:
        """Unit vectors to the right, upwards (z where it can be, else y), and towards the eye, (3, 3)."""
        normal = np.array(self.normal, dtype=float)
        normal /= np.linalg.norm(normal)
        up = np.eye(3)[1 if abs(normal[2]) > 0.9 else 2]
        right = np.cross(up, normal)
        right /= np.linalg.norm(right)
        return np.array((right, np.cross(normal, right), normal))

    @property
    def names(self) -> tuple[str, str]:
        """What the coordinates in the plane are called: of planes across an axis those of the others."""
        found = []
        for name, vector in zip(("right", "up"), self.frame, strict=False):
            axis = int(np.argmax(np.abs(vector)))
            if abs(abs(vector[axis]) - 1.0) < 1e-12:
                found.append(("-" if vector[axis] < 0 else "") + _AXES[axis])
            else:
                found.append(name)
        return found[0], found[1]


@dataclass(frozen=True, eq=False)
class Outline:
    """Where a plane cuts a mesh.

    Attributes
    ----------
    segments : (s, 2, 2) float64
        Their ends, as coordinates in the plane to the right and upwards.
    """

    segments: Vector

    @property
    def length(self) -> float:
        """Length of all segments together."""
        return float(np.linalg.norm(self.segments[:, 1] - self.segments[:, 0], axis=1).sum())


def outline(state: State, plane: Plane) -> Outline:
    """Return the outline of a mesh's faces in a plane, by VTK."""
    faces, cut, cutter = vtkPolyData(), vtkPlane(), vtkCutter()
    source = state.input()
    faces.SetPoints(source.GetPoints())
    faces.SetPolys(source.GetPolys())
    faces.SetStrips(source.GetStrips())
    cut.SetOrigin(*plane.origin)
    cut.SetNormal(*plane.frame[2])
    cutter.SetInputData(faces)
    cutter.SetCutFunction(cut)
    cutter.Update()
    lines = cutter.GetOutput()
    offsets, corners = cells_of(lines.GetLines())
    points = points_of(lines).astype(np.float64) @ plane.frame[:2].T
    # A polyline of n points is n - 1 segments.
    inside = np.ones(max(0, len(corners) - 1), np.bool_)
    inside[offsets[1:-1] - 1] = False
    ends = np.column_stack((corners[:-1], corners[1:]))[inside]
    return Outline(points[ends] if len(ends) else np.empty((0, 2, 2)))
