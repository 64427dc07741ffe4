"""Fields: one value for each face or point, ready to be drawn, counted and searched."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from vtksmooth.filters.arrays import Surface

Values = npt.NDArray[Any]

#: How many of the worst faces are listed.
WORST = 200


@dataclass(frozen=True, eq=False)
class Field:
    """Values on the points or the faces of a mesh.

    Attributes
    ----------
    values : (n,) or (m,) float array
        One for each point, or for each face of `surface`.
    on_points : bool
    surface : Surface
        The faces.
    low_is_bad : bool
        Which end of the values is the bad one.
    lines : vtkPolyData or None
        Lines that belong to the values (ridges).
    """

    values: Values
    on_points: bool
    surface: Surface
    low_is_bad: bool = False
    lines: Any = None

    @cached_property
    def ordered(self) -> Values:
        """The values that are numbers, in ascending order: every histogram is at hand."""
        return np.sort(self.values[np.isfinite(self.values)])

    @cached_property
    def span(self) -> tuple[float, float]:
        """Smallest and largest value."""
        return (float(self.ordered[0]), float(self.ordered[-1])) if len(self.ordered) else (0.0, 1.0)

    @cached_property
    def quantiles(self) -> tuple[float, float, float]:
        """What half, nine tenths and 99 of a hundred of the values are below, signs aside."""
        if not len(self.ordered):
            return (0.0, 0.5, 1.0)
        half, most, nearly_all = np.quantile(np.abs(self.ordered), (0.5, 0.9, 0.99))
        return (float(half), float(most), float(nearly_all))

    @cached_property
    def of_faces(self) -> Values:
        """One value for each face; of point values the worst at its corners."""
        if not self.on_points:
            return self.values
        mesh = self.surface.mesh
        corners = self.values[mesh.connectivity]
        if mesh.only_triangles:
            table = corners.reshape(-1, 3)
            extreme: Values = table.min(axis=1) if self.low_is_bad else table.max(axis=1)
            return extreme
        reduce = np.minimum if self.low_is_bad else np.maximum
        result: Values = reduce.reduceat(corners, mesh.offsets[:-1])
        return result

    @cached_property
    def worst(self) -> npt.NDArray[np.int64]:
        """The faces with the worst values, the worst first; ties in the order of the faces."""
        values = self.of_faces if self.low_is_bad else -self.of_faces
        values = np.where(np.isnan(values), np.inf, values)
        count = min(WORST, len(values))
        if count == 0:
            return np.empty(0, np.int64)
        bound = np.partition(values, count - 1)[count - 1]
        faces = np.flatnonzero(values <= bound)
        return faces[np.argsort(values[faces], kind="stable")][:count]

    @cached_property
    def of_cells(self) -> Values:
        """One value for each cell of the polydata: faces of one strip share theirs, other cells have none."""
        cells, count = self.surface.cells, self.surface.n_cells
        if len(cells) == count and cells[0] == 0 and cells[-1] == count - 1:
            return self.values
        values = np.full(count, np.nan)
        values[cells] = self.values
        return values

    def histogram(self, edges: Values) -> Values:
        """Return how many percent of the values lie between `edges`; those beyond count at the ends."""
        below = np.searchsorted(self.ordered, edges[1:-1])
        shares: Values = 100.0 * np.diff([0, *below, len(self.ordered)]) / max(1, len(self.ordered))
        return shares

    def faces_between(self, low: float, high: float) -> npt.NDArray[np.int64]:
        """Return the faces with a value from `low` to `high`, at a corner if the values are on points."""
        inside = (self.values >= low) & (self.values <= high)
        if self.on_points:
            corners = inside[self.surface.mesh.connectivity]
            inside = np.logical_or.reduceat(corners, self.surface.mesh.offsets[:-1])
        return np.flatnonzero(inside)

    def faces_beyond(self, bad: float) -> npt.NDArray[np.int64]:
        """Return the faces whose value is worse than `bad`."""
        return np.flatnonzero(self.of_faces < bad if self.low_is_bad else self.of_faces > bad)

    def prepare(self) -> Field:
        """Compute what the windows will ask for; to be called by the worker."""
        _ = self.span, self.worst
        if not self.on_points:
            _ = self.of_cells
        return self
