"""What the OFF and PLY formats have in common: polygon meshes as arrays, numbers as text."""

from __future__ import annotations

import warnings
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt


class Polygons(NamedTuple):
    """A polygon mesh as a file holds it.

    Attributes
    ----------
    points : (n, 3) float32 or float64
    sizes : (m,) int64
        Corners of each face.
    connectivity : (sum(sizes),) int64
        Point indices, face after face.
    point_data, cell_data : dict of str to array
        Arrays with one row for each point or face.
    """

    points: npt.NDArray[Any]
    sizes: npt.NDArray[np.int64]
    connectivity: npt.NDArray[np.int64]
    point_data: dict[str, npt.NDArray[Any]]
    cell_data: dict[str, npt.NDArray[Any]]


def numbers(text: bytes) -> npt.NDArray[np.float64] | None:
    """Parse numbers between white space, (k,) float64; None when something else is among them."""
    with warnings.catch_warnings():
        # NumPy announces text that is no number as a deprecation, and returns what came before it.
        warnings.simplefilter("error", DeprecationWarning)
        try:
            return np.fromstring(text, dtype=np.float64, sep=" ")  # type: ignore[call-overload,no-any-return]
        except (DeprecationWarning, ValueError):
            return None
