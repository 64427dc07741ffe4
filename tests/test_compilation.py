"""How kernels are compiled: what is remembered is what numba says, and nobody else's compiling is touched."""

import gc
import itertools
import operator

import numba
import pytest
from numba import types
from numba.core.errors import TypingError
from numba.core.registry import cpu_target

from vtksmooth.jit import compilation, compiled
from vtksmooth.jit.compilation import compiling_kernels

_OPERATORS = (operator.add, operator.mul, operator.truediv, operator.sub, operator.lt, operator.getitem)
_TYPES = (
    types.float64, types.int32, types.uint8, types.boolean, types.IntegerLiteral(2), types.float64[::1],
    types.float64[:, ::1], types.UniTuple(types.int64, 2), types.Tuple((types.int64, types.slice2_type)),
)  # fmt: skip


def signature(function, arguments):
    context = cpu_target.typing_context
    context.refresh()
    try:
        return context.resolve_value_type(function).get_call_type(context, arguments, {})
    except TypingError:
        return None


@pytest.mark.parametrize("function", _OPERATORS)
def test_what_is_remembered_is_what_numba_says(function):
    pairs = list(itertools.product(_TYPES, _TYPES))
    expected = [signature(function, pair) for pair in pairs]
    assert sum(answer is not None for answer in expected) > 5
    for _ in range(2):  # asked, and remembered
        with compiling_kernels():
            assert [signature(function, pair) for pair in pairs] == expected


def state():
    ours = types.BaseFunction.get_call_type is compilation._remembered
    assert bool(numba.config.SLP_VECTORIZE) == ours
    return gc.isenabled(), ours


@pytest.mark.parametrize("collects", [True, False])
def test_it_ends_with_our_kernel(collects, monkeypatch):
    usual, within = state(), []

    def fails(x):
        return x + "a text"

    def works(x):
        return x + 1.0

    for function in (fails, works):
        function.__module__ = "vtksmooth.kernels.made_up"
    listener = compiled.on_compile(lambda kernel: within.append(state()))
    if not collects:
        gc.disable()
    try:
        with listener:
            with pytest.raises(TypingError):
                numba.njit(fails)(1.0)
            assert state() == (collects, False)
            assert numba.njit(works)(1.0) == 2.0
            assert state() == (collects, False)
    finally:
        gc.enable()
    assert within == [(False, True)] * 2
    assert state() == usual == (True, False)


def test_others_are_compiled_as_ever():
    within = []

    class Listener(numba.core.event.Listener):
        def on_start(self, event):
            within.append(state())

        def on_end(self, event):
            within.append(state())

    with numba.core.event.install_listener("numba:compile", Listener()):
        assert numba.njit(lambda x: x + 1.0)(1.0) == 2.0
    assert within == [(True, False)] * 2
