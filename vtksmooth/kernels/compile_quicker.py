"""Compiling in less time: while numba compiles a kernel it is asked nothing twice, and collects no garbage.

For each operator in a kernel numba tries, one after the other, all that this operator can mean (of texts,
sets, dates ...) until one fits the types. A kernel asks this thousands of times, of a few dozens of
combinations of operators and types. To remember the answers saves a fifth of all compiling; not to look for
garbage among the millions of objects saves a twentieth.
"""

from __future__ import annotations

import gc
from typing import Any

from numba.core import types

_original: Any = types.BaseFunction.get_call_type


def _remembered(self: Any, context: Any, args: Any, kws: Any) -> Any:
    if kws:
        return _original(self, context, args, kws)
    # With the function's type itself: it keeps what belongs to each signature that it has returned.
    known = vars(self).setdefault("_vtksmooth_signatures", {})
    key = (context, tuple(args))
    if key not in known:
        known[key] = _original(self, context, args, kws)
    return known[key]


class compiling_quicker:  # noqa: N801 (used like a function)
    """While this context is open, numba compiles quicker. Others' code is compiled as ever.

    Numba compiles on one thread at a time.
    """

    _collects = False

    def __enter__(self) -> None:
        self._collects = gc.isenabled()
        gc.disable()
        types.BaseFunction.get_call_type = _remembered  # type: ignore[method-assign]

    def __exit__(self, *exc: object) -> None:
        types.BaseFunction.get_call_type = _original  # type: ignore[method-assign]
        if self._collects:
            gc.enable()
