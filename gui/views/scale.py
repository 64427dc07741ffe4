"""Colour scales: from values to colours, the same for the meshes, the colour bar and the histogram."""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import pyqtgraph

from ..model.field import Field
from ..model.overlays import Overlay

Colours = npt.NDArray[np.uint8]

#: As uniform and readable as the others, with a middle.
_DIVERGING = "CET-CBD1"

#: Okabe and Ito's colours: good, fair, poor, bad; and for classes.
BANDS = ((0, 114, 178), (86, 180, 233), (230, 159, 0), (213, 94, 0))
THRESHOLDS = (BANDS[0], BANDS[2], BANDS[3])
CLASSES = ((190, 196, 204), (213, 94, 0), (0, 114, 178), (204, 121, 167))
BEYOND = (213, 94, 0)
UNKNOWN = (160, 160, 160)
BEFORE, AFTER = (150, 155, 165), (0, 114, 178)

_STEPS = 256


@dataclass(frozen=True, eq=False)
class Scale:
    """A colour scale.

    Attributes
    ----------
    low, high : float
        Values of the first and the last colour.
    colours : (256, 3) uint8
    beyond : (3,) uint8 or None
        Colour of what is worse than the scale's end, where that means something of its own.
    beyond_is_low : bool
    classes : tuple of str
    """

    low: float
    high: float
    colours: Colours
    beyond: tuple[int, int, int] | None = None
    beyond_is_low: bool = True
    classes: tuple[str, ...] = ()


@functools.cache
def _table(name: str) -> Colours:
    found = pyqtgraph.colormap.get(name).getLookupTable(0.0, 1.0, _STEPS)
    return np.asarray(found[:, :3], dtype=np.uint8)


def make(
    overlay: Overlay, field: Field, thresholds: tuple[float, float, float], name: str, bands: bool
) -> Scale:
    """Return the scale for an overlay's values."""
    if overlay.kind == "classes":
        table = np.array(CLASSES[: len(overlay.classes)], dtype=np.uint8)
        index = np.arange(_STEPS) * len(table) // _STEPS
        return Scale(-0.5, len(table) - 0.5, table[index], classes=overlay.classes)
    good, _, bad = thresholds
    if overlay.span is not None:
        low, high = overlay.span
    elif overlay.kind == "diverging":
        reach = max(abs(good), abs(bad)) or 1.0
        low, high = -reach, reach
    else:
        # The bands reach beyond bad, so that its own can be seen.
        low, high = 0.0, 1.25 * bad if bands else bad
    if not high > low:
        low, high = field.span if field.span[1] > field.span[0] else (low, low + 1.0)
    values = np.linspace(low, high, _STEPS)
    if bands:
        order = sorted(thresholds)
        number = np.searchsorted(order, np.abs(values) if overlay.thresholds is None else values)
        colours = np.array(BANDS[::-1] if overlay.low_is_bad else BANDS, dtype=np.uint8)[number]
    else:
        colours = _table(_DIVERGING if overlay.kind == "diverging" else name)
    # Only k has an end that means something: below 0 faces are inverted.
    inverted = BEYOND if overlay.id == "aspect-ratio" else None
    return Scale(low, high, colours, inverted)
