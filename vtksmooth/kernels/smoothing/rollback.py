"""Rolling back: what may not be at the end of some passes is taken back, and what is conserved closed again.

Schemes run some passes; then the surface is compared with what it was before them. Vertices of faces that may
not be where they are go back half of their way, or all of it, until nothing is left to object to; that comes
to an end, for without steps there is nothing. Clipping steps beforehand, so that nothing could happen, would
stop most of them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from ..mesh.adjacency import Adjacency
from .phases import Disposal
from .run_state import State

Bool = npt.NDArray[np.bool_]
Float64 = npt.NDArray[np.float64]

#: Iterations between two looks.
EVERY = 20

#: Least part of a step that is tried before it is taken back, and after how many rounds none is.
_LEAST, _ROUNDS = 0.25, 8

#: How many rings round vertices that went back move to conserve what they took along, one after another; and
#: the longest such step, in mean edges, for which no more are asked.
_RINGS, _LONGEST = (3, 8), 0.1


def roll_back(disposal: Disposal, state: State, good: Float64) -> int:
    """Take back what the passes since the points were `good`, (n, 3), must not have done.

    Returns
    -------
    int
        How many vertices have not taken all of their steps; 0 if nothing has been changed.
    """
    wanted = state.points.copy()
    bad = disposal.objections(state, good, wanted)
    if not bad.any():
        return 0
    state.points[:] = good
    place, part = _taken_back(disposal, state, wanted, bad)
    rolled = part < 1.0
    if disposal.closing is not None:
        place = _closed(disposal, state, place, rolled)
    state.points[:] = place
    disposal.forget(state)
    return int(np.count_nonzero((place != wanted).any(axis=1) & rolled)) or len(place)


def _taken_back(disposal: Disposal, state: State, wanted: Float64, bad: Bool) -> tuple[Float64, Float64]:
    """Return places between where the points are and where they are `wanted`, and the parts of the ways."""
    good, place, part = state.points, wanted.copy(), np.ones(len(wanted))
    rounds = 0
    while bad.any():
        # Who is back already is in the way of a neighbour.
        while not (lower := bad & (part > 0.0)).any():
            wider = _widened(state.near, bad)
            if (wider == bad).all():
                return good.copy(), np.zeros_like(part)
            bad = wider
        rounds += 1
        least = _LEAST if rounds <= _ROUNDS else 1.0
        part[lower] = np.where(part[lower] > least, 0.5 * part[lower], 0.0)
        rows = np.flatnonzero(lower)
        place[rows] = good[rows] + part[rows, None] * (wanted[rows] - good[rows])
        disposal.retract(state, rows[part[rows] > 0.0], place)
        bad = disposal.objections(state, good, place, lower)
        bad |= disposal.broken(state, good, place, np.flatnonzero(part < 1.0))
    return place, part


def _closed(disposal: Disposal, state: State, place: Float64, rolled: Bool) -> Float64:
    """Return the places with what is conserved closed, by vertices round those that went back."""
    assert disposal.closing is not None
    good, near = state.points, state.near
    longest = _LONGEST * np.linalg.norm(np.diff(good[_sides(near)], axis=1), axis=2).mean()
    region, reached = rolled, 0
    for rings in (*_RINGS, None):
        if rings is None:
            region = np.ones_like(rolled)
        else:
            for _ in range(rings - reached):
                region = _widened(near, region)
            reached = rings
        still = (state.pinned != 0) | rolled | ~region
        proposed = place.copy()
        kept = disposal.closing.conserve(
            replace(state, pinned=still.astype(np.uint8)),
            good,
            proposed,
            _beyond(disposal, state, place),
            good,
        )
        if not kept or (rings is not None and np.abs(proposed - place).max() > longest):
            continue
        changed = (proposed != place).any(axis=1)
        if not disposal.objections(state, good, proposed, changed).any():
            return proposed
    return good.copy()


def _beyond(
    disposal: Disposal, state: State, place: Float64
) -> Callable[[State, Float64], npt.NDArray[np.bool_]]:
    def beyond(_: State, proposed: Float64) -> Bool:
        changed = (proposed != place).any(axis=1)
        found = disposal.broken(state, state.points, proposed, np.flatnonzero(changed))
        return found | disposal.objections(state, state.points, proposed, changed)

    return beyond


def _widened(near: Adjacency, chosen: Bool) -> Bool:
    """Return the `chosen` vertices, (n,), and those of their faces."""
    faces = np.zeros(len(near.offsets) - 1, np.bool_)
    faces[near.corner_face[chosen[near.connectivity]]] = True
    wider = chosen.copy()
    wider[near.connectivity[faces[near.corner_face]]] = True
    return wider


def _sides(near: Adjacency) -> npt.NDArray[np.int32]:
    """Return the ends of a side of each face, (m, 2)."""
    first = near.offsets[:-1][np.diff(near.offsets) > 1]
    return np.column_stack((near.connectivity[first], near.connectivity[first + 1]))
