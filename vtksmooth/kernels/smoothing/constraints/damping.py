"""Damping: constraints that shorten steps by a factor for each vertex, and do nothing else."""

from __future__ import annotations

from collections.abc import Sequence

from ....jit.compiled import kernel
from . import Constraint, Float64, Phase


@kernel
def shorten(starts, ends, points, damping, proposed):
    """Multiply each step by the factor of its vertex."""
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            for axis in range(3):
                # The ends of the range keep their bits.
                if damping[v] == 0.0:
                    proposed[v, axis] = points[v, axis]
                elif damping[v] < 1.0:
                    step = proposed[v, axis] - points[v, axis]
                    proposed[v, axis] = points[v, axis] + damping[v] * step


class Damping(Constraint):
    """Base of the constraints that damp; they set `damping` when they are bound or prepared."""

    phase = Phase.SCALE


def factors(constraints: Sequence[Constraint]) -> Float64 | None:
    """Return the product of what all constraints leave of the steps; None where that is everything."""
    product = None
    for constraint in constraints:
        if constraint.damping is not None:
            product = constraint.damping if product is None else product * constraint.damping
    return product
