"""What schemes and constraints see of a run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from ...errors import ParameterError
from ..distance.closest_point import ClosestPoint
from ..features.detection import Features
from ..mesh.adjacency import Adjacency, Int32
from ..mesh.mesh import Mesh


@dataclass
class State:
    """A run in progress, in the numbering that the loop has chosen.

    Attributes
    ----------
    topology : Mesh
        The faces. Its points are wherever they happen to be: use `mesh` or `original`.
    near : Adjacency
    reference : (m, 3) float32
        Frozen direction of each face, see
        :func:`~vtksmooth.kernels.measures.aspect_ratio.reference_directions`.
    points : (n, 3) float64
        Where the vertices are now.
    pinned : (n,) uint8
        1 for vertices that must not move. Constraints add to it when they are bound.
    smallest_k : float
        Smallest aspect ratio at the start.
    in_place : bool
        Whether vertices move one colour class after another; otherwise all at the same time, and every
        constraint is given all ranges at once.
    first_points : callable
        Returns where the points were at the start, (n, 3).
    find_features : callable
        Returns the features of a mesh with its neighbourhoods, both in the run's numbering.
    order, face_order : (n,), (m,) int32, optional
        The run's point i is point ``order[i]`` of the input, its face f is ``face_order[f]``; None where the
        numbering is the input's.
    slide : float
        Part of the way to the middle of their two neighbours that vertices on lines go in a pass.
    direction : (n, 3) float64, optional
        Direction of the surface at each vertex, where a constraint computes it in each pass.
    factors : (n,) float64, optional
        Part of its step that each vertex takes in the pass, where a constraint shortens steps by factors.
    tensor_weight : int
        What weighs a face in the tensors that directions come from: 0 its area, 1 its angle at the vertex.
    elsewhere : bool
        Whether vertices are put on another surface than that of the start: no line need stay straight then.
    confined : (n,) uint8, optional
        1 for vertices off the boundary that slide on a line, which no correction may take them off.
    """

    topology: Mesh
    near: Adjacency
    reference: npt.NDArray[np.float32]
    points: npt.NDArray[np.float64]
    pinned: npt.NDArray[np.uint8]
    smallest_k: float
    in_place: bool
    first_points: Callable[[], npt.NDArray[np.float64]]
    find_features: Callable[[Mesh, Adjacency], Features]
    order: Int32 | None = None
    face_order: Int32 | None = None
    slide: float = 0.5
    direction: npt.NDArray[np.float64] | None = None
    factors: npt.NDArray[np.float64] | None = None
    tensor_weight: int = 0
    elsewhere: bool = False
    confined: npt.NDArray[np.uint8] | None = None

    def one_each(self, name: str, values: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """Return `values`, which must hold one for each point.

        Raises
        ------
        ParameterError
            They have another shape.
        """
        if values.shape != (len(self.points),):
            raise ParameterError(
                f"{name} must hold one value for each of the {len(self.points)} points, "
                f"not have the shape {values.shape}."
            )
        return values

    def in_order(self, values: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """Return `values` of the input's points, (n, ...), in the run's numbering."""
        return values if self.order is None else values[self.order]

    @cached_property
    def original(self) -> Mesh:
        """The mesh at the start of the run; kept only if somebody asks for it."""
        return self.topology.with_points(self.first_points())

    @cached_property
    def surface(self) -> ClosestPoint:
        """The original surface, ready for closest-point queries (built when first asked for)."""
        return ClosestPoint(self.original)

    @cached_property
    def features(self) -> Features:
        """Ridges and corners of the mesh at the start (found when first asked for)."""
        return self.find_features(self.original, self.near)

    @cached_property
    def widest_star(self) -> int:
        """Size of the largest star: kernels take their scratch space by it, many times in a pass."""
        return int(np.diff(self.near.star_offsets).max())

    @property
    def mesh(self) -> Mesh:
        """The mesh as it is now."""
        return self.topology.with_points(self.points)
