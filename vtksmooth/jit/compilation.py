"""How numba compiles kernels: in less time than it takes otherwise, and into quicker ones.

- For each operator in a kernel numba tries, one after the other, all that this operator can mean (of texts,
  sets, dates ...) until one fits the types. A kernel asks this thousands of times, of a few dozens of
  combinations of operators and types: to remember the answers saves a fifth of all compiling.
- Half of numba's passes look for what kernels do not have: closures, generators, array expressions.
- A helper is compiled anew for every literal number that is handed to it, though it becomes a part of its
  caller, where the compiler sees the number anyway.
- Of a helper numba makes machine code, which nobody calls: it becomes a part of its callers. And where
  helpers call helpers, it optimises the inner ones again in each, although the kernel that they end up in
  is optimised as a whole.
- There are millions of objects, and no garbage among them.
- Coordinates lie side by side, and arithmetic on them can be done in pairs. By default numba does not look
  for this. It takes 3 % more time to compile, and kernels take up to a seventh less; same bits.
"""

from __future__ import annotations

import gc
from typing import Any

import llvmlite.binding as llvm
from numba import _dynfunc
from numba.core import config, typed_passes, types, untyped_passes
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase
from numba.core.compiler_machinery import PassManager, register_pass


class _KernelCode(JITCodeLibrary):  # type: ignore[misc]
    """The code of a kernel and of all that it calls, in LLVM's language and then the machine's."""

    def _optimize_functions(self, module: Any) -> None:
        # No more than makes functions small: they are optimised when they are together.
        module.data_layout = self._codegen._data_layout
        builder = self._codegen._pass_builder()
        passes = llvm.create_new_function_pass_manager()
        passes.add_sroa_pass()
        passes.add_instruction_combine_pass()
        passes.add_simplify_cfg_pass()
        for function in module.functions:
            if not function.is_declaration:
                passes.run(function, builder)


class _HelperCode(_KernelCode):
    """The code of a helper, which stays in LLVM's language."""

    def finalize(self) -> None:
        """Take in the helpers that the helper calls."""
        for library in dict.fromkeys(self._linking_libraries):
            self._reload_init.update(library._reload_init)
            self._final_module.link_in(library._get_module_for_linking(), preserve=True)
        self._finalized = True


@register_pass(mutates_CFG=True, analysis_only=False)
class _Lowering(typed_passes.NativeLowering):  # type: ignore[misc]
    """Translation to LLVM's language; of kernels on to that of the machine."""

    def run_pass(self, state: Any) -> bool:
        helper = state.flags.no_cpython_wrapper
        kind = _HelperCode if helper else _KernelCode
        state.library = kind(state.targetctx.codegen(), state.func_id.func_qualname)
        state.library.enable_object_caching()
        state.flags.no_compile = helper
        super().run_pass(state)
        if helper:
            # What stands for it in Python: it cannot be called, but is looked up by.
            made, description = state.cr, state.cr.fndesc
            name = _dynfunc.make_function(
                description.lookup_module(), description.qualname, "", 0, made.env, (state.library,)
            )
            state.targetctx.insert_user_function(name, description, [state.library])
            state.reload_init.extend(state.library._reload_init)
            state["cr"] = made._replace(cfunc=name)
        return True


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
    _Lowering,
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
