"""Four numbers at a time: a type for kernels whose loops the compiler does not vectorise by itself.

A value of this type holds one float64 of each of four independent pieces of work, four vertices say, in one
register of the processor (two where registers are narrower). Arithmetic is that of float64, lane by lane,
rounded as ever: a kernel written with lanes gives the bits of the same kernel written with numbers.

Only kernels can use it. Lanes are made by :func:`pack`, :func:`spread`, :func:`load` and :func:`gather`, and
leave by :func:`unpack` and :func:`store`; ``+ - * /`` and unary ``-`` work on lanes and numbers, comparisons
give masks, ``&`` and ``|`` join masks, :func:`select` chooses by them and :func:`everywhere` asks them.

:func:`narrow` makes four float32 of them, for what may be roughly known first. They are half as wide and take
the same operations, among each other and with numbers.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Sequence
from typing import Any

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.datamodel import models
from numba.core.typing import signature
from numba.core.typing.templates import AbstractTemplate, infer_global
from numba.extending import intrinsic, lower_builtin, register_model

#: Numbers side by side: what a 256-bit register holds.
WIDTH = 4


class _Lanes(types.Type):
    """Four float64 or float32."""

    def __init__(self, number: types.Float, element: ir.Type) -> None:
        super().__init__(f"Lanes({number})")
        self.number = number
        self.vector = ir.VectorType(element, WIDTH)


class _Mask(types.Type):
    """Four truth values."""


_lanes = _Lanes(types.float64, ir.DoubleType())
_narrow = _Lanes(types.float32, ir.FloatType())
_mask = _Mask("LanesMask")


@register_model(_Lanes)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, dmm: Any, fe_type: Any) -> None:
        super().__init__(dmm, fe_type, fe_type.vector)


@register_model(_Mask)
class _MaskModel(models.PrimitiveModel):
    def __init__(self, dmm: Any, fe_type: Any) -> None:
        super().__init__(dmm, fe_type, ir.VectorType(ir.IntType(1), WIDTH))


def _shuffle(builder: ir.IRBuilder, a: ir.Value, b: ir.Value, *chosen: int) -> ir.Value:
    places = ir.Constant(ir.VectorType(ir.IntType(32), len(chosen)), chosen)
    return builder.shuffle_vector(a, b, places)


def _pack(builder: ir.IRBuilder, numbers: Sequence[ir.Value]) -> ir.Value:
    packed = ir.Constant(ir.VectorType(numbers[0].type, WIDTH), ir.Undefined)
    for place, number in enumerate(numbers):
        packed = builder.insert_element(packed, number, ir.Constant(ir.IntType(32), place))
    return packed


def _as_lanes(builder: ir.IRBuilder, lanes: _Lanes, value: ir.Value) -> ir.Value:
    """Return the value, which may be one float64, as such lanes."""
    if isinstance(value.type, ir.VectorType):
        return value
    if lanes == _narrow:
        value = builder.fptrunc(value, _narrow.vector.element)
    nothing = ir.Constant(lanes.vector, ir.Undefined)
    one = builder.insert_element(nothing, value, ir.Constant(ir.IntType(32), 0))
    return _shuffle(builder, one, nothing, *[0] * WIDTH)


def _define(operation: Callable[..., Any], result: types.Type | None, build: Callable[..., ir.Value]) -> None:
    """Give the operator a meaning for lanes with lanes and lanes with numbers: ``build(builder, a, b)``."""

    class Template(AbstractTemplate):  # type: ignore[misc]
        def generic(self, args: tuple[Any, ...], kws: Any) -> Any:
            for lanes in (_lanes, _narrow):
                if len(args) == 2 and lanes in args and all(a in (lanes, types.float64) for a in args):
                    return signature(result or lanes, *args)
            return None

    infer_global(operation)(Template)

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        lanes = next(kind for kind in sig.args if isinstance(kind, _Lanes))
        return build(builder, *(_as_lanes(builder, lanes, value) for value in args))

    for lanes in (_lanes, _narrow):
        for kinds in ((lanes, lanes), (lanes, types.float64), (types.float64, lanes)):
            lower_builtin(operation, *kinds)(lower)


for _operations, _name in (
    ((operator.add, operator.iadd), "fadd"),
    ((operator.sub, operator.isub), "fsub"),
    ((operator.mul, operator.imul), "fmul"),
    ((operator.truediv, operator.itruediv), "fdiv"),
):
    for _operation in _operations:
        _define(_operation, None, lambda builder, a, b, name=_name: getattr(builder, name)(a, b))
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
        return signature(args[0], *args) if args in ((_lanes,), (_narrow,)) else None


@lower_builtin(operator.neg, _Lanes)
def _negate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    return builder.fneg(args[0])


@intrinsic
def spread(typing_context, number):
    """Return the number in every lane."""

    def build(context, builder, sig, args):
        return _as_lanes(builder, _lanes, args[0])

    return signature(_lanes, types.float64), build


@intrinsic
def narrow(typing_context, value):
    """Return the lanes rounded to float32."""

    def build(context, builder, sig, args):
        return builder.fptrunc(args[0], _narrow.vector)

    return signature(_narrow, _lanes), build


@intrinsic
def pack(typing_context, a, b, c, d):
    """Return four numbers, float64 or all float32, as lanes."""
    number = types.float32 if (a, b, c, d) == (types.float32,) * WIDTH else types.float64

    def build(context, builder, sig, args):
        packed = _pack(builder, args)
        return packed if number == types.float64 else builder.fpext(packed, _lanes.vector)

    return signature(_lanes, *(number,) * WIDTH), build


@intrinsic
def unpack(typing_context, value):
    """Return the four numbers."""
    numbers = types.containers.UniTuple(types.float64, WIDTH)

    def build(context, builder, sig, args):
        places = [ir.Constant(ir.IntType(32), place) for place in range(WIDTH)]
        found = [builder.extract_element(args[0], place) for place in places]
        return context.make_tuple(builder, numbers, found)

    return signature(numbers, _lanes), build


def _row(context: Any, builder: Any, rows: Any, array: Any, row: Any, width: int) -> Any:
    """Return where the row of an (n, width) array begins."""
    data = context.make_array(rows)(context, builder, array).data
    return builder.gep(data, [builder.mul(row, ir.Constant(row.type, width))])


def _read(builder: Any, rows: Any, place: Any, kind: ir.Type) -> Any:
    value = builder.load(builder.bitcast(place, kind.as_pointer()))
    value.align = rows.dtype.bitwidth // 8
    return value


@intrinsic
def gather(typing_context, rows, i, j, k, l):  # noqa: E741
    """Return the three columns of four rows of a C-contiguous (n, 3) array, float64 or float32."""
    columns = types.containers.UniTuple(_lanes, 3)

    def build(context, builder, sig, args):
        number = context.get_value_type(rows.dtype)
        places = [_row(context, builder, rows, args[0], row, 3) for row in args[1:]]
        # The first two numbers of a row come by one reading.
        a, b, c, d = (_read(builder, rows, place, ir.VectorType(number, 2)) for place in places)
        ac = _shuffle(builder, a, c, 0, 1, 2, 3)
        bd = _shuffle(builder, b, d, 0, 1, 2, 3)
        third = [builder.gep(place, [ir.Constant(ir.IntType(64), 2)]) for place in places]
        found = [
            _shuffle(builder, ac, bd, 0, 4, 2, 6),
            _shuffle(builder, ac, bd, 1, 5, 3, 7),
            _pack(builder, [_read(builder, rows, place, number) for place in third]),
        ]
        if rows.dtype == types.float32:
            found = [builder.fpext(value, _lanes.vector) for value in found]
        return context.make_tuple(builder, columns, found)

    return signature(columns, rows, *(types.uintp,) * WIDTH), build


@intrinsic
def load(typing_context, rows, row):
    """Return a row of a C-contiguous array, float64 or float32, in rows of four, as lanes as wide."""
    lanes = _lanes if rows.dtype == types.float64 else _narrow

    def build(context, builder, sig, args):
        return _read(builder, rows, _row(context, builder, rows, args[0], args[1], WIDTH), lanes.vector)

    return signature(lanes, rows, types.intp), build


@intrinsic
def store(typing_context, rows, row, value):
    """Write lanes to a row of a C-contiguous array in rows of four; to int32 rounded towards zero."""

    def build(context, builder, sig, args):
        vector = ir.VectorType(context.get_value_type(rows.dtype), WIDTH)
        numbers = builder.fptosi(args[2], vector) if rows.dtype == types.int32 else args[2]
        place = _row(context, builder, rows, args[0], args[1], WIDTH)
        instruction = builder.store(numbers, builder.bitcast(place, vector.as_pointer()))
        instruction.align = rows.dtype.bitwidth // 8
        return context.get_dummy_value()

    return signature(types.void, rows, types.intp, value), build


@intrinsic
def select(typing_context, mask, a, b):
    """Return a where the mask is true, b elsewhere; each of the two lanes or a number. Or all are numbers."""
    lanes = _narrow if _narrow in (a, b) else _lanes

    def build(context, builder, sig, args):
        if mask == _mask:
            args = (args[0], *(_as_lanes(builder, lanes, value) for value in args[1:]))
        return builder.select(*args)

    kinds = (kind if isinstance(kind, _Lanes) else types.float64 for kind in (a, b))
    return signature(lanes if mask == _mask else types.float64, mask, *kinds), build


@intrinsic
def everywhere(typing_context, mask):
    """Return whether the mask is true in all lanes."""

    def build(context, builder, sig, args):
        bits = builder.bitcast(args[0], ir.IntType(WIDTH))
        return builder.icmp_unsigned("==", bits, ir.Constant(bits.type, 2**WIDTH - 1))

    return signature(types.boolean, _mask), build


def _function(name: str) -> Any:
    @intrinsic
    def function(typing_context, value):
        suffix, kind = "f64", ir.DoubleType()
        if isinstance(value, _Lanes):
            suffix, kind = f"v{WIDTH}f{value.number.bitwidth}", value.vector

        def build(context, builder, sig, args):
            called = cgutils.get_or_insert_function(
                builder.module, ir.FunctionType(kind, [kind]), f"llvm.{name}.{suffix}"
            )
            return builder.call(called, args)

        return signature(value, value), build

    function.__doc__ = f"Return {name} of each lane, or of a number."
    return function


square_root = _function("sqrt")
absolute = _function("fabs")
