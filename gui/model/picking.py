"""What is under the pointer."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vtksmooth.kernels.distance.ray import first_hit
from vtksmooth.report import figure

from .field import Field
from .state import State
from .units import quantity

Vector = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Probe:
    """A place on a mesh.

    Attributes
    ----------
    face : int
    point : int
        The corner of the face that is nearest.
    position : (3,) float64
    """

    face: int
    point: int
    position: Vector

    def describe(self, title: str, unit: str, values: Field | None, length: str = "") -> str:
        """Return what is there, in one line; `unit` is that of the values, `length` that of the place."""
        x, y, z = self.position
        place = quantity(f"({figure(x, 5)}, {figure(y, 5)}, {figure(z, 5)})", length)
        text = f"face {self.face:,}, point {self.point:,} at {place}"
        if values is None:
            return text
        value = values.values[self.point if values.on_points else self.face]
        return f"{title} {quantity(figure(value), unit)}   {text}"


def probe(state: State, origin: Vector, direction: Vector) -> Probe | None:
    """Return what a ray meets first, or None."""
    if state.surface is None:
        return None
    mesh = state.surface.mesh
    face, t = first_hit(mesh, origin, direction)
    if face < 0:
        return None
    position = origin + t * direction
    corners = mesh.connectivity[mesh.offsets[face] : mesh.offsets[face + 1]]
    nearest = int(corners[np.argmin(((mesh.points[corners] - position) ** 2).sum(axis=1))])
    return Probe(face, nearest, position)
