"""Coordinates and planes as texts."""

from __future__ import annotations

import math
import re

import numpy as np
import numpy.typing as npt

from ..errors import ParameterError

_PLANE = re.compile(r"\s*([xyz])\s*=\s*(\S+)\s*")


def parse_coordinates(name: str, text: str) -> npt.NDArray[np.float64]:
    """Return the point that a text gives by three numbers.

    Raises
    ------
    ParameterError
        The text is written otherwise; `name` is the parameter.

    Examples
    --------
    >>> parse_coordinates("rotation_center", "0, 1.5, -2").tolist()
    [0.0, 1.5, -2.0]
    """
    values = [_number(part) for part in text.split(",")]
    if len(values) != 3 or None in values:
        raise ParameterError(f"{name} must be three coordinates such as 0,1.5,-2, not {text!r}.")
    return np.array(values, np.float64)


def parse_planes(name: str, text: str | None) -> list[tuple[int, float]]:
    """Return planes across the axes as pairs of the axis' number and the coordinate.

    Raises
    ------
    ParameterError
        The text is written otherwise; `name` is the parameter.

    Examples
    --------
    >>> parse_planes("symmetry_planes", "x=0, z=2.5")
    [(0, 0.0), (2, 2.5)]
    """
    planes = []
    for part in [] if text is None else text.split(","):
        match = _PLANE.fullmatch(part)
        value = None if match is None else _number(match[2])
        if match is None or value is None:
            raise ParameterError(f"{name} must be planes such as x=0,z=2.5, not {text!r}.")
        planes.append(("xyz".index(match[1]), value))
    return planes


def _number(text: str) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) else None
