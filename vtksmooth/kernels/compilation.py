"""How numba compiles kernels: in less time than it takes otherwise, and into quicker ones.

- For each operator in a kernel numba tries, one after the other, all that this operator can mean (of texts,
  sets, dates ...) until one fits the types. A kernel asks this thousands of times, of a few dozens of
  combinations of operators and types: to remember the answers saves a fifth of all compiling.
- Half of numba's passes look for what kernels do not have: closures, generators, array expressions.
- A helper is compiled anew for every literal number that is handed to it, though it becomes a part of its
  caller, where the compiler sees the number anyway.
- There are millions of objects, and no garbage among them.
- Coordinates lie side by side, and arithmetic on them can be done in pairs. By default numba does not look
  for this. It takes 3 % more time to compile, and kernels take up to a seventh less; same bits.
"""

from __future__ import annotations

import gc
from typing import Any

from numba.core import config, typed_passes, types, untyped_passes
from numba.core.compiler import CompilerBase
from numba.core.compiler_machinery import PassManager

_PASSES = (
    untyped_passes.TranslateByteCode,
    untyped_passes.FixupArgs,
    untyped_passes.IRProcessing,
    untyped_passes.GenericRewrites,
    untyped_passes.ReconstructSSA,
    typed_passes.NopythonTypeInference,
    typed_passes.PreLowerStripPhis,
    typed_passes.NoPythonSupportedFeatureValidation,
    typed_passes.IRLegalization,
    typed_passes.AnnotateTypes,
    typed_passes.NativeLowering,
    typed_passes.NoPythonBackend,
)


class Passes(CompilerBase):  # type: ignore[misc]
    """The passes of numba that kernels need, in its order.

    Kernels must do without what the others are for: comprehensions and functions within functions.
    """

    def define_pipelines(self) -> list[Any]:
        """Return the only way to compile."""
        manager = PassManager("vtksmooth")
        for each in _PASSES:
            manager.add_pass(each, each.__name__)
        manager.finalize()
        return [manager]


def for_any_number(helper: Any) -> Any:
    """Make numba compile `helper` once for a type of numbers, and not for each literal of it; return it."""
    original = helper.get_call_template
    plain: Any = types.unliteral  # type: ignore[attr-defined]

    def general(args: tuple[types.Type, ...], kws: dict[str, types.Type]) -> Any:
        named = {name: plain(kind) for name, kind in kws.items()}
        return original(tuple(plain(kind) for kind in args), named)

    helper.get_call_template = general
    return helper


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


class compiling_kernels:  # noqa: N801 (used like a function)
    """While this context is open, numba compiles for us. Others' code is compiled as ever.

    Numba compiles on one thread at a time.
    """

    _collects = False
    _pairs = 0

    def __enter__(self) -> None:
        self._collects, self._pairs = gc.isenabled(), config.SLP_VECTORIZE
        gc.disable()
        config.SLP_VECTORIZE = 1
        types.BaseFunction.get_call_type = _remembered  # type: ignore[method-assign]

    def __exit__(self, *exc: object) -> None:
        types.BaseFunction.get_call_type = _original  # type: ignore[method-assign]
        config.SLP_VECTORIZE = self._pairs
        if self._collects:
            gc.enable()
