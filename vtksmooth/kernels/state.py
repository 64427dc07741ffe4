"""What schemes and constraints see of a run."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import numpy.typing as npt

from .adjacency import Adjacency
from .closest_point import ClosestPoint
from .mesh import Mesh


@dataclass
class State:
    """A run in progress, in the numbering that the loop has chosen.

    Attributes
    ----------
    original : Mesh
        The mesh at the start of the run. Never changes.
    near : Adjacency
    reference : (m, 3) float64
        Frozen direction of each face, see :func:`~vtksmooth.kernels.quality.reference_directions`.
    points : (n, 3) float64
        Where the vertices are now.
    pinned : (n,) uint8
        1 for vertices that must not move. Constraints add to it when they are bound.
    """

    original: Mesh
    near: Adjacency
    reference: npt.NDArray[np.float64]
    points: npt.NDArray[np.float64]
    pinned: npt.NDArray[np.uint8] = field(repr=False)

    @cached_property
    def surface(self) -> ClosestPoint:
        """The original surface, ready for closest-point queries (built when first asked for)."""
        return ClosestPoint(self.original)

    @property
    def mesh(self) -> Mesh:
        """The mesh as it is now."""
        return self.original.with_points(self.points)
