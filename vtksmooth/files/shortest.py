"""Numbers as text, each the shortest that reads back the same: the text that Python gives, in less time.

Reference: R. Giulietti, "The Schubfach way to render doubles", 2020.
"""

from __future__ import annotations

import functools

import numpy as np
import numpy.typing as npt

from ..jit.compiled import device, kernel
from .numerals import product

#: Exponents of ten whose power is in the table.
_FIRST, _LAST = -292, 324

#: No number and its blank take more characters.
_WIDEST = 25

_0, _1, _2, _4, _10, _40 = (np.uint64(i) for i in (0, 1, 2, 4, 10, 40))
_52, _63, _HIDDEN = np.uint64(52), np.uint64(63), np.uint64(1 << 52)
_EXPONENT, _INFINITE = np.uint64(0x7FF), np.uint64(0x7FF << 52)
_TENS = np.array([10**i for i in range(17)], np.uint64)
_SIGNLESS = np.uint64((1 << 63) - 1)


@functools.cache
def _powers() -> npt.NDArray[np.uint64]:
    """Return the leading 128 bits of the powers of ten, rounded up; upper and lower half: (n, 2)."""
    rows = []
    for exponent in range(_FIRST, _LAST + 1):
        shift = 127 - (exponent * 1741647 >> 19)  # less the logarithm to the base 2
        above, below = 10 ** max(exponent, 0) << max(shift, 0), 10 ** max(-exponent, 0) << max(-shift, 0)
        value = -(-above // below)
        rows.append((value >> 64, value & ((1 << 64) - 1)))
    return np.array(rows, np.uint64)


@device
def _to_odd(high, low, value):
    # The upper 64 bits of a product with 128; the last is 1 where anything follows.
    carried, _ = product(low, value)
    upper, lower = product(high, value)
    total = lower + carried
    if total < lower:
        upper = upper + _1
    if total > _1:
        upper = upper | _1
    return upper


@device
def _decimal(bits, powers):
    # The digits and the exponent of ten of a finite number above 0.
    fraction = bits & (_HIDDEN - _1)
    exponent = np.int64((bits >> _52) & _EXPONENT)
    c, q = fraction, np.int64(-1074)
    if exponent != 0:
        c, q = _HIDDEN | fraction, exponent - 1075
        if -53 < q <= 0 and c & ((_1 << np.uint64(-q)) - _1) == _0:
            return c >> np.uint64(-q), np.int64(0)
    closer = fraction == _0 and exponent > 1
    k = (q * 1262611 - (524031 if closer else 0)) >> 22
    shift = np.uint64(q + ((-k * 1741647) >> 19) + 1)
    high, low = powers[-k - _FIRST, 0], powers[-k - _FIRST, 1]
    odd = c & _1
    lower = _to_odd(high, low, (_4 * c - _2 + (_1 if closer else _0)) << shift) + odd
    middle = _to_odd(high, low, (_4 * c) << shift)
    upper = _to_odd(high, low, (_4 * c + _2) << shift) - odd
    s = middle // _4
    if s >= _10:
        short = s // _10
        below, above = lower <= _40 * short, _40 * short + _40 <= upper
        if below != above:
            return short + (_1 if above else _0), k + 1
    below, above = lower <= _4 * s, _4 * s + _4 <= upper
    if below != above:
        return s + (_1 if above else _0), k
    half = _4 * s + _2
    return s + (_1 if middle > half or (middle == half and s & _1 == _1) else _0), k


@device
def _put(bits, powers, out, at):
    # Write a number; return where it ends.
    positive = bits & _SIGNLESS
    if positive > _INFINITE:
        out[at], out[at + 1], out[at + 2] = 110, 97, 110
        return at + 3
    if bits >> _63 == _1:
        out[at] = 45
        at += 1
    if positive == _INFINITE:
        out[at], out[at + 1], out[at + 2] = 105, 110, 102
        return at + 3
    if positive == _0:
        out[at], out[at + 1], out[at + 2] = 48, 46, 48
        return at + 3
    digits, exponent = _decimal(positive, powers)
    while digits % _10 == _0:
        digits = digits // _10
        exponent += 1
    n = 17
    while n > 1 and digits < _TENS[n - 1]:
        n -= 1
    point = n + exponent  # so many digits are before it
    scientific = point <= -4 or point > 16
    if scientific:
        split = 1
    elif point <= 0:
        out[at], out[at + 1] = 48, 46
        at += 2
        for _ in range(-point):
            out[at] = 48
            at += 1
        split = n
    else:
        split = point
    for j in range(n - 1, -1, -1):
        rest = digits // _10
        out[at + j + (1 if j >= split else 0)] = 48 + np.int64(digits - rest * _10)
        digits = rest
    if n > split:
        out[at + split] = 46
        at += 1
    at += n
    if scientific:
        power = point - 1
        out[at], out[at + 1] = 101, 43 if power >= 0 else 45
        at += 2
        power = abs(power)
        if power >= 100:
            out[at] = 48 + power // 100
            at += 1
        out[at], out[at + 1] = 48 + power // 10 % 10, 48 + power % 10
        at += 2
    elif point > 0 and split >= n:
        for _ in range(split - n):
            out[at] = 48
            at += 1
        out[at], out[at + 1] = 46, 48
        at += 2
    return at


@kernel
def _write(table, word, powers, out):
    at = 0
    for i in range(table.shape[0]):
        for code in word:
            out[at] = code
            at += 1
        for j in range(table.shape[1]):
            if j > 0 or word.size > 0:
                out[at] = 32
                at += 1
            at = _put(table[i, j], powers, out, at)
        out[at] = 10
        at += 1
    return at


def table_lines(word: bytes, table: npt.NDArray[np.float64]) -> npt.NDArray[np.uint8]:
    """Return the text of lines, one for each row of a table: a word and the numbers, with blanks between."""
    out = np.empty(len(table) * (len(word) + _WIDEST * table.shape[1] + 1), np.uint8)
    bits = np.ascontiguousarray(table, np.float64).view(np.uint64)
    return out[: _write(bits, np.frombuffer(word, np.uint8), _powers(), out)]
