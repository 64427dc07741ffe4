"""Numbers of a text, each the nearest float64 there is.

NumPy and Python take two to ten times as long, which is what large files wait for. Reference: D. Lemire,
"Number parsing at a gigabyte per second", Software: Practice and Experience 51 (2021), doi:10.1002/spe.2984.
"""

from __future__ import annotations

import functools

import numpy as np
import numpy.typing as npt

from ..jit.compiled import device, kernel

#: Exponents of ten whose power is in the table; with up to 19 digits, all beyond is 0 or infinite.
_FIRST, _LAST = -342, 308

#: So many words may be none that the kernel understands: more digits than 19, tiny numbers, nan, slips.
_ODD = 1 << 16

_LOW, _32 = np.uint64(0xFFFFFFFF), np.uint64(32)
_ONE, _TWO, _THREE, _NINE, _TEN = (np.uint64(i) for i in (1, 2, 3, 9, 10))
_REST = np.uint64(0x1FF)
_HIDDEN, _52, _63 = np.uint64(1 << 52), np.uint64(52), np.uint64(63)
_FULL = np.uint64(0xFFFFFFFFFFFFFFFF)


@functools.cache
def _powers() -> npt.NDArray[np.uint64]:
    """Return the leading 128 bits of the powers of five, upper and lower half: (n, 2)."""
    rows = []
    for exponent in range(_FIRST, _LAST + 1):
        if exponent < 0:
            power = 5**-exponent
            bits = power.bit_length()
            # Rounded up, as the reference has it; scaled to 128 bits.
            value = (1 << (bits + 127)) // power + 1
            value >>= max(0, value.bit_length() - 128)
        else:
            power = 5**exponent
            value = power << 128 >> power.bit_length()
        rows.append((value >> 64, value & ((1 << 64) - 1)))
    return np.array(rows, np.uint64)


@device
def product(a, b):
    """Return the 128 bits of a product, upper and lower half."""
    a1, a0, b1, b0 = a >> _32, a & _LOW, b >> _32, b & _LOW
    low = a0 * b0
    middle = a1 * b0 + (low >> _32)
    other = a0 * b1 + (middle & _LOW)
    return a1 * b1 + (middle >> _32) + (other >> _32), (other << _32) | (low & _LOW)


@device
def _bits(digits, exponent, powers):
    # The bits of digits * 10**exponent; all ones where another way must be taken.
    if digits == np.uint64(0):
        return np.uint64(0)
    if exponent < _FIRST or exponent > _LAST:
        return _FULL
    zeros = 0
    while digits >> _63 == np.uint64(0):
        digits = digits << _ONE
        zeros += 1
    high, low = product(digits, powers[exponent - _FIRST, 0])
    if high & _REST == _REST:
        more, _ = product(digits, powers[exponent - _FIRST, 1])
        low = low + more
        if low < more:
            high = high + _ONE
    if low == _FULL and (exponent < -27 or exponent > 55):
        return _FULL
    upper = high >> _63
    mantissa = high >> (upper + _NINE)
    binary = ((217706 * exponent) >> 16) + 63 + np.int64(upper) - zeros + 1023
    if binary <= 0 or binary >= 2046:
        return _FULL
    # Half way between two numbers: to the even one.
    exact = mantissa << (upper + _NINE) == high and low <= _ONE and -4 <= exponent <= 23
    if exact and mantissa & _THREE == _ONE:
        mantissa = mantissa - _ONE
    mantissa = (mantissa + (mantissa & _ONE)) >> _ONE
    if mantissa >= _HIDDEN << _ONE:
        mantissa = _HIDDEN
        binary += 1
    return (mantissa - _HIDDEN) | (np.uint64(binary) << _52)


@kernel
def _parse(codes, powers, bits, counts, odd):
    # Return the numbers of words and of odd words, which are left to others: (begin, end, word).
    n = codes.size
    at = line = word = strange = 0
    while at < n:
        code = codes[at]
        if code <= 32:
            if code == 10:
                line += 1
            at += 1
            continue
        begin = at
        negative = code == 45
        if code == 45 or code == 43:
            at += 1
        digits = np.uint64(0)
        many, read, exponent = 0, 0, np.int64(0)
        while at < n and 48 <= codes[at] <= 57:
            digits = digits * _TEN + np.uint64(codes[at] - 48)
            many += digits != np.uint64(0)
            read += 1
            at += 1
        if at < n and codes[at] == 46:
            at += 1
            while at < n and 48 <= codes[at] <= 57:
                digits = digits * _TEN + np.uint64(codes[at] - 48)
                many += digits != np.uint64(0)
                exponent -= 1
                read += 1
                at += 1
        fine = read > 0 and many <= 19
        if at < n and (codes[at] == 101 or codes[at] == 69):
            at += 1
            down = at < n and codes[at] == 45
            if at < n and (codes[at] == 45 or codes[at] == 43):
                at += 1
            given, power = 0, np.int64(0)
            while at < n and 48 <= codes[at] <= 57:
                if power < 10000:
                    power = power * 10 + np.int64(codes[at] - 48)
                given += 1
                at += 1
            fine = fine and given > 0
            exponent += -power if down else power
        if at < n and codes[at] > 32:
            fine = False
            while at < n and codes[at] > 32:
                at += 1
        value = _FULL
        if fine:
            value = _bits(digits, exponent, powers)
        if value == _FULL:
            if strange == odd.shape[0]:
                return word, strange + 1
            odd[strange, 0] = begin
            odd[strange, 1] = at
            odd[strange, 2] = word
            strange += 1
        elif negative:
            value = value | (_ONE << _63)
        bits[word] = value
        counts[line] += 1
        word += 1
    return word, strange


def parsed(text: bytes | bytearray) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]] | None:
    """Return the numbers of a text, and how many each of its lines holds; None where it holds other words."""
    values = np.empty(len(text) // 2 + 1)  # memory that is not written to takes no place
    counts = np.zeros(text.count(b"\n") + (not text.endswith(b"\n")), np.int64)
    odd = np.empty((_ODD, 3), np.int64)
    codes = np.frombuffer(text, np.uint8)
    words, strange = _parse(codes, _powers(), values.view(np.uint64), counts, odd)
    if strange > len(odd):
        return None
    for begin, end, word in odd[:strange].tolist():
        one = text[begin:end]
        try:
            values[word] = float(one)
        except ValueError:
            return None
        if b"_" in one:  # which Python allows
            return None
    return values[:words], counts
