"""Four numbers at a time: a type for kernels whose loops the compiler does not vectorise by itself.

A value of this type holds one float64 of each of four independent pieces of work, four vertices say, in one
register of the processor (two where registers are narrower). Arithmetic is that of float64, lane by lane,
rounded as ever: a kernel written with lanes gives the bits of the same kernel written with numbers.

Only kernels can use it. Lanes are made by :func:`pack`, :func:`spread`, :func:`load` and :func:`gather`, and
leave by :func:`unpack` and :func:`store`; ``+ - * /`` and unary ``-`` work on lanes and numbers, comparisons
give masks, ``&`` and ``|`` join masks, :func:`select` chooses by them.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.datamodel import models
from numba.core.typing import signature
from numba.core.typing.templates import AbstractTemplate, infer_global
from numba.extending import intrinsic, lower_builtin, register_model

from .compiled import device

#: Numbers side by side: what a 256-bit register holds.
WIDTH = 4

_VECTOR = ir.VectorType(ir.DoubleType(), WIDTH)


class _Lanes(types.Type):
    """Four float64."""


class _Mask(types.Type):
    """Four truth values."""


_lanes, _mask = _Lanes("Lanes"), _Mask("LanesMask")


@register_model(_Lanes)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, dmm: Any, fe_type: Any) -> None:
        super().__init__(dmm, fe_type, _VECTOR)


@register_model(_Mask)
class _MaskModel(models.PrimitiveModel):
    def __init__(self, dmm: Any, fe_type: Any) -> None:
        super().__init__(dmm, fe_type, ir.VectorType(ir.IntType(1), WIDTH))


def _splat(builder: ir.IRBuilder, number: ir.Value) -> ir.Value:
    one = builder.insert_element(ir.Constant(_VECTOR, ir.Undefined), number, ir.Constant(ir.IntType(32), 0))
    everywhere = ir.Constant(ir.VectorType(ir.IntType(32), WIDTH), [0] * WIDTH)
    return builder.shuffle_vector(one, ir.Constant(_VECTOR, ir.Undefined), everywhere)


def _define(operation: Callable[..., Any], result: types.Type, build: Callable[..., ir.Value]) -> None:
    """Give the operator a meaning for lanes with lanes and lanes with numbers: ``build(builder, a, b)``."""

    class Template(AbstractTemplate):  # type: ignore[misc]
        def generic(self, args: tuple[Any, ...], kws: Any) -> Any:
            if len(args) == 2 and _lanes in args and all(a in (_lanes, types.float64) for a in args):
                return signature(result, *args)
            return None

    infer_global(operation)(Template)

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return build(builder, *(
            value if kind == _lanes else _splat(builder, value)
            for kind, value in zip(sig.args, args, strict=True)
        ))  # fmt: skip

    for kinds in ((_lanes, _lanes), (_lanes, types.float64), (types.float64, _lanes)):
        lower_builtin(operation, *kinds)(lower)


for _operations, _name in (
    ((operator.add, operator.iadd), "fadd"),
    ((operator.sub, operator.isub), "fsub"),
    ((operator.mul, operator.imul), "fmul"),
    ((operator.truediv, operator.itruediv), "fdiv"),
):
    for _operation in _operations:
        _define(_operation, _lanes, lambda builder, a, b, name=_name: getattr(builder, name)(a, b))
for _operation, _sign in (
    (operator.lt, "<"), (operator.le, "<="), (operator.gt, ">"), (operator.ge, ">="), (operator.eq, "=="),
):  # fmt: skip
    _define(_operation, _mask, lambda builder, a, b, sign=_sign: builder.fcmp_ordered(sign, a, b))


def _define_for_masks(operation: Callable[..., Any], name: str) -> None:
    class Template(AbstractTemplate):  # type: ignore[misc]
        def generic(self, args: tuple[Any, ...], kws: Any) -> Any:
            return signature(_mask, *args) if args == (_mask, _mask) else None

    infer_global(operation)(Template)

    @lower_builtin(operation, _mask, _mask)
    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return getattr(builder, name)(*args)


_define_for_masks(operator.and_, "and_")
_define_for_masks(operator.or_, "or_")


@infer_global(operator.neg)
class _Negation(AbstractTemplate):  # type: ignore[misc]
    def generic(self, args: tuple[Any, ...], kws: Any) -> Any:
        return signature(_lanes, _lanes) if args == (_lanes,) else None


@lower_builtin(operator.neg, _lanes)
def _negate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    return builder.fneg(args[0])


@intrinsic
def spread(typing_context, number):  # type: ignore[no-untyped-def]
    """Return the number in every lane."""

    def build(context, builder, sig, args):  # type: ignore[no-untyped-def]
        return _splat(builder, args[0])

    return signature(_lanes, types.float64), build


@intrinsic
def pack(typing_context, a, b, c, d):  # type: ignore[no-untyped-def]
    """Return four numbers, float64 or all float32, as lanes."""
    number = types.float32 if (a, b, c, d) == (types.float32,) * WIDTH else types.float64

    def build(context, builder, sig, args):  # type: ignore[no-untyped-def]
        vector = ir.VectorType(context.get_value_type(number), WIDTH)
        packed = ir.Constant(vector, ir.Undefined)
        for place, value in enumerate(args):
            packed = builder.insert_element(packed, value, ir.Constant(ir.IntType(32), place))
        return packed if vector == _VECTOR else builder.fpext(packed, _VECTOR)

    return signature(_lanes, *(number,) * WIDTH), build


@intrinsic
def unpack(typing_context, value):  # type: ignore[no-untyped-def]
    """Return the four numbers."""
    numbers = types.containers.UniTuple(types.float64, WIDTH)

    def build(context, builder, sig, args):  # type: ignore[no-untyped-def]
        places = [ir.Constant(ir.IntType(32), place) for place in range(WIDTH)]
        found = [builder.extract_element(args[0], place) for place in places]
        return context.make_tuple(builder, numbers, found)

    return signature(numbers, value), build


@device
def gather(rows, i, j, k, l):  # type: ignore[no-untyped-def]  # noqa: E741
    """Return the three columns of four rows of an (n, 3) array, float64 or float32."""
    return (
        pack(rows[i, 0], rows[j, 0], rows[k, 0], rows[l, 0]),
        pack(rows[i, 1], rows[j, 1], rows[k, 1], rows[l, 1]),
        pack(rows[i, 2], rows[j, 2], rows[k, 2], rows[l, 2]),
    )


def _row(context: Any, builder: Any, kind: Any, array: Any, row: Any) -> Any:
    data = context.make_array(kind)(context, builder, array).data
    place = builder.mul(row, ir.Constant(row.type, WIDTH))
    return builder.bitcast(builder.gep(data, [place]), ir.PointerType(_VECTOR))


@intrinsic
def load(typing_context, rows, row):  # type: ignore[no-untyped-def]
    """Return a row of a C-contiguous (n, 4) float64 array."""

    def build(context, builder, sig, args):  # type: ignore[no-untyped-def]
        value = builder.load(_row(context, builder, sig.args[0], *args))
        value.align = 8
        return value

    return signature(_lanes, rows, types.intp), build


@intrinsic
def store(typing_context, rows, row, value):  # type: ignore[no-untyped-def]
    """Write lanes to a row of a C-contiguous (n, 4) float64 array."""

    def build(context, builder, sig, args):  # type: ignore[no-untyped-def]
        instruction = builder.store(args[2], _row(context, builder, sig.args[0], *args[:2]))
        instruction.align = 8
        return context.get_dummy_value()

    return signature(types.void, rows, types.intp, _lanes), build


@intrinsic
def select(typing_context, mask, a, b):  # type: ignore[no-untyped-def]
    """Return a where the mask is true, b elsewhere; each of the two lanes or a number. Or all are numbers."""
    result = _lanes if mask == _mask else types.float64

    def build(context, builder, sig, args):  # type: ignore[no-untyped-def]
        return builder.select(args[0], *(
            value if kind == result else _splat(builder, value)
            for kind, value in zip(sig.args[1:], args[1:], strict=True)
        ))  # fmt: skip

    return signature(result, mask, *(k if k == _lanes else types.float64 for k in (a, b))), build


def _function(name: str) -> Any:
    @intrinsic
    def function(typing_context, value):  # type: ignore[no-untyped-def]
        suffix, kind = (f"v{WIDTH}f64", _VECTOR) if value == _lanes else ("f64", ir.DoubleType())

        def build(context, builder, sig, args):  # type: ignore[no-untyped-def]
            called = cgutils.get_or_insert_function(
                builder.module, ir.FunctionType(kind, [kind]), f"llvm.{name}.{suffix}"
            )
            return builder.call(called, args)

        return signature(value, value), build

    function.__doc__ = f"Return {name} of each lane, or of a number."
    return function


square_root = _function("sqrt")
absolute = _function("fabs")
