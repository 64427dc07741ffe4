"""Measurements: distances, angles and radii at vertices that were picked."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
import numpy.typing as npt

from vtksmooth.errors import InvalidMeshError
from vtksmooth.kernels.measures.fitting import fit_cylinder, fit_sphere
from vtksmooth.report import figure

from .layer import Layer
from .state import State
from .units import quantity

Vertices = npt.NDArray[np.int64]


class Kind(StrEnum):
    """What is measured."""

    DISTANCE = "distance"
    ANGLE = "angle"
    RADIUS = "radius"


#: How many vertices are picked one by one; a radius takes a region.
PICKS = {Kind.DISTANCE: 2, Kind.ANGLE: 3}


@dataclass(frozen=True)
class Figure:
    """One figure of a measurement.

    Attributes
    ----------
    name : str
    value : float
        Model units, or degrees.
    rms : float or None
        How far the points are from the surface that was fitted, root mean square.
    """

    name: str
    value: float
    rms: float | None = None

    def text(self, unit: str) -> str:
        """Return it as people read it, lengths with their unit."""
        if self.name == Kind.ANGLE:
            return quantity(figure(self.value, 5), "°")
        spread = "" if self.rms is None else f" (± {figure(self.rms, 2)})"
        return quantity(f"{figure(self.value, 5)}{spread}", unit)


@dataclass(frozen=True, eq=False)
class Measurement:
    """Something measured on a layer, at vertices that keep their numbers while the mesh is smoothed.

    Attributes
    ----------
    kind : Kind
    layer : Layer
    vertices : (k,) int64
        Of a distance its two ends; of an angle its three points, the apex second; of a radius the region.
    n_points : int
        Of the mesh that they were picked on. In a mesh with another number of points they mean nothing.
    """

    kind: Kind
    layer: Layer
    vertices: Vertices
    n_points: int
    _found: WeakKeyDictionary[State, list[Figure]] = field(default_factory=WeakKeyDictionary, repr=False)

    @property
    def names(self) -> list[str]:
        """What its figures are called."""
        if self.kind is Kind.RADIUS:
            return ["radius of sphere", "radius of cylinder"]
        return [self.kind.value]

    def places(self, state: State) -> npt.NDArray[np.float64] | None:
        """Return where its vertices are, (k, 3), or None in a mesh with other points."""
        if state.n_points != self.n_points:
            return None
        return state.points[self.vertices].astype(np.float64)

    def known(self, state: State | None) -> list[Figure] | None:
        """Return the figures for a mesh if they have been computed."""
        return None if state is None else self._found.get(state)

    def compute(self, state: State) -> list[Figure]:
        """Return the figures for a mesh: those that can be had. Fits take a while: call it from a worker."""
        found = self._found.get(state)
        if found is None:
            places = self.places(state)
            found = [] if places is None else _MEASURES[self.kind](places)
            self._found[state] = found
        return found


def _distance(places: npt.NDArray[np.float64]) -> list[Figure]:
    return [Figure(Kind.DISTANCE, float(np.linalg.norm(places[1] - places[0])))]


def _angle(places: npt.NDArray[np.float64]) -> list[Figure]:
    a, b = places[0] - places[1], places[2] - places[1]
    across = float(np.linalg.norm(np.cross(a, b)))
    return [Figure(Kind.ANGLE, float(np.degrees(np.arctan2(across, a @ b))))]


def _radius(places: npt.NDArray[np.float64]) -> list[Figure]:
    found = []
    for name, fit in (("radius of sphere", fit_sphere), ("radius of cylinder", fit_cylinder)):
        try:
            result: Any = fit(places)
        except InvalidMeshError:
            continue  # too few points for a cylinder, or a plane: there is no such figure
        found.append(Figure(name, result.radius, result.rms))
    return found


_MEASURES = {Kind.DISTANCE: _distance, Kind.ANGLE: _angle, Kind.RADIUS: _radius}


def row_texts(one: Measurement, unit: str) -> list[tuple[str, str, str]]:
    """Return name, before and after of each figure, as far as they are known."""
    texts = []
    for name in one.names:
        sides = []
        for state in (one.layer.opened, one.layer.state):
            figures = {figure.name: figure for figure in one.known(state) or []}
            sides.append(figures[name].text(unit) if name in figures else "")
        texts.append((name, sides[0], sides[1]))
    return texts
