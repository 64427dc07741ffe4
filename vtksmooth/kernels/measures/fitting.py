"""Spheres and cylinders through points, in the sense of least squares of the distances.

The distances are those from the points to the surface, not algebraic ones, which make small radii too
small. G. Lukacs, R. Martin, D. Marshall, "Faithful Least-Squares Fitting of Spheres, Cylinders, Cones and
Tori for Reliable Segmentation" (1998), sections 2 and 3.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ...errors import InvalidMeshError

Float64 = npt.NDArray[np.float64]

#: Points whose smallest extent is below this part of their largest lie in a plane: in single precision
#: nothing more can be told.
FLAT = 1e-6

#: Directions that are tried as a cylinder's axis, and how many of the best are followed up.
_DIRECTIONS, _FOLLOWED = 96, 4
#: Points that those directions are judged by, at most.
_SAMPLE = 2000
#: Steps, halvings of one, and the part of the variance that a step must take off to be followed by another.
_STEPS, _HALVINGS, _GAIN = 50, 12, 1e-9


@dataclass(frozen=True, eq=False)
class Sphere:
    """A sphere that was fitted to points.

    Attributes
    ----------
    centre : (3,) float64
    radius : float
    rms, largest : float
        Root mean square and maximum of the points' distances from it. All lengths are model units.
    """

    centre: Float64
    radius: float
    rms: float
    largest: float


@dataclass(frozen=True, eq=False)
class Cylinder:
    """A cylinder that was fitted to points.

    Attributes
    ----------
    centre : (3,) float64
        The point of the axis in the middle of the points.
    axis : (3,) float64
        Unit vector along the axis; its largest component is positive.
    radius : float
    rms, largest : float
        Root mean square and maximum of the points' distances from it. All lengths are model units.
    """

    centre: Float64
    axis: Float64
    radius: float
    rms: float
    largest: float


def fit_sphere(points: npt.ArrayLike) -> Sphere:
    """Return the sphere with the least sum of squared distances to points.

    The start is the linear fit of I. D. Coope, "Circle fitting by linear and nonlinear least squares"
    (1993); Gauss-Newton steps follow, which are halved where they do not help.

    Parameters
    ----------
    points : (n, 3) array_like
        At least four, not in a plane.

    Raises
    ------
    InvalidMeshError
        The points are too few, not finite, or in a plane.

    Examples
    --------
    >>> sphere = fit_sphere([[3, 0, 0], [-1, 0, 0], [1, 2, 0], [1, 0, 2], [1, 0, -2]])
    >>> (sphere.centre.round(12) + 0.0).tolist(), round(sphere.radius, 12)
    ([1.0, 0.0, 0.0], 2.0)
    """
    places, middle, size, _ = _normalised(points, 4, "sphere")
    centre = _linear(places)

    def residuals(c: Float64) -> tuple[Float64, Float64]:
        away = places - c
        distance = np.linalg.norm(away, axis=1)
        return distance, -_unit(away, distance)

    centre, distance = _gauss_newton(centre, residuals, lambda c, step: c + step)
    radius, rms, largest = _radius(distance, size)
    return Sphere(middle + size * centre, radius, rms, largest)


def fit_cylinder(points: npt.ArrayLike) -> Cylinder:
    """Return the cylinder with the least sum of squared distances to points.

    Axes all round are tried with the linear fit of a circle to the points seen along them; the best of them
    are refined by Gauss-Newton steps. Source of the search: D. Eberly, "Fitting 3D Data with a Cylinder"
    (2003).

    Parameters
    ----------
    points : (n, 3) array_like
        At least six, not in a plane.

    Raises
    ------
    InvalidMeshError
        The points are too few, not finite, or in a plane.

    Examples
    --------
    >>> turn = np.arange(12.0)
    >>> cylinder = fit_cylinder(np.column_stack((2.0 * np.cos(turn), 2.0 * np.sin(turn), turn)))
    >>> (cylinder.axis.round(9) + 0.0).tolist(), round(cylinder.radius, 9)
    ([0.0, 0.0, 1.0], 2.0)
    """
    places, middle, size, frame = _normalised(points, 6, "cylinder")
    sample = _sampled(places)
    starts = []
    for axis in _hemisphere() @ frame:
        across = _across(axis)
        flat = sample @ across.T
        centre = _linear(flat)
        distance = np.linalg.norm(flat - centre, axis=1)
        starts.append((float(distance.std()), axis, centre @ across))
    # Equal starts, as those of a cube's corners, keep the order of the directions.
    starts.sort(key=lambda start: start[0])
    lines = [
        _gauss_newton(np.array((centre, axis)), _from_axis(sample), _moved_axis)
        for _, axis, centre in starts[:_FOLLOWED]
    ]
    line, distance = min(lines, key=lambda found: float(found[1].var()))
    if len(sample) < len(places):
        line, distance = _gauss_newton(line, _from_axis(places), _moved_axis)
    centre, axis = line
    centre = centre + axis * ((places - centre) @ axis).mean()
    axis = axis if axis[np.argmax(np.abs(axis))] > 0 else -axis
    radius, rms, largest = _radius(distance, size)
    return Cylinder(middle + size * centre, axis, radius, rms, largest)


def _normalised(points: npt.ArrayLike, least: int, what: str) -> tuple[Float64, Float64, float, Float64]:
    """Return the points about their mean in units of their size, that mean and size, and principal axes."""
    points = np.ascontiguousarray(points, dtype=np.float64).reshape(-1, 3)
    if not np.isfinite(points).all():
        raise InvalidMeshError("Some of the points are not finite; leave them out.")
    if len(np.unique(_sampled(points), axis=0)) < least:
        raise InvalidMeshError(f"A {what} needs at least {least} points in different places; pick more.")
    middle = points.mean(axis=0)
    away = points - middle
    size = float(np.abs(away).max())
    away /= size
    spread, axes = np.linalg.eigh(away.T @ away)
    if spread[0] <= FLAT**2 * spread[2]:
        raise InvalidMeshError(f"The points lie in a plane, which no {what} fits; pick a curved region.")
    return away, middle, size, axes.T


def _sampled(points: Float64) -> Float64:
    return points[:: max(1, -(-len(points) // _SAMPLE))]


def _hemisphere() -> Float64:
    """Return directions spread evenly over half a sphere, and the three axes, (d, 3)."""
    i = np.arange(_DIRECTIONS) + 0.5
    z = i / _DIRECTIONS
    turn = i * np.pi * (3.0 - np.sqrt(5.0))
    ring = np.sqrt(1.0 - z * z)
    return np.vstack((np.eye(3), np.column_stack((ring * np.cos(turn), ring * np.sin(turn), z))))


def _across(axis: Float64) -> Float64:
    """Return two unit vectors at right angles to an axis and to each other, (2, 3)."""
    first = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    first /= np.linalg.norm(first)
    return np.array((first, np.cross(axis, first)))


def _linear(places: Float64) -> Float64:
    """Return the centre of the circle or sphere that solves |p|^2 = 2 c p + (r^2 - |c|^2) best."""
    rows = np.column_stack((2.0 * places, np.ones(len(places))))
    solution: Float64 = np.linalg.lstsq(rows, (places**2).sum(axis=1), rcond=None)[0]
    return solution[:-1]


def _unit(vectors: Float64, lengths: Float64) -> Float64:
    return vectors / np.where(lengths > 0.0, lengths, 1.0)[:, None]


def _from_axis(places: Float64) -> Callable[[Float64], tuple[Float64, Float64]]:
    def residuals(line: Float64) -> tuple[Float64, Float64]:
        centre, axis = line
        away = places - centre
        along = away @ axis
        out = away - along[:, None] * axis
        distance = np.linalg.norm(out, axis=1)
        sideways = -_unit(out, distance) @ _across(axis).T
        return distance, np.hstack((sideways, along[:, None] * sideways))

    return residuals


def _moved_axis(line: Float64, step: Float64) -> Float64:
    centre, axis = line
    across = _across(axis)
    turned = axis + step[2:] @ across
    return np.array((centre + step[:2] @ across, turned / np.linalg.norm(turned)))


def _gauss_newton(
    start: Float64,
    residuals: Callable[[Float64], tuple[Float64, Float64]],
    moved: Callable[[Float64, Float64], Float64],
) -> tuple[Float64, Float64]:
    """Return where the variance of the distances is least, and the distances there.

    The radius is their mean, so that the residuals and their derivatives are taken about their means.
    """
    now = start
    distance, slopes = residuals(now)
    for _ in range(_STEPS):
        rows, variance = slopes - slopes.mean(axis=0), distance.var()
        step = -np.linalg.lstsq(rows.T @ rows, rows.T @ (distance - distance.mean()), rcond=None)[0]
        for _ in range(_HALVINGS):
            there = moved(now, step)
            distance_there, slopes_there = residuals(there)
            if distance_there.var() < variance:
                break
            step /= 2.0
        else:
            break
        now, distance, slopes = there, distance_there, slopes_there
        if distance.var() > (1.0 - _GAIN) * variance:
            break
    return now, distance


def _radius(distance: Float64, size: float) -> tuple[float, float, float]:
    """Return the radius, and root mean square and maximum of the distances from it."""
    radius = float(distance.mean())
    gaps = distance - radius
    return size * radius, size * float(np.sqrt((gaps**2).mean())), size * float(np.abs(gaps).max())
