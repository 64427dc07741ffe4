"""Lines of elements in OBJ files: corners of one to three numbers, as in 1, 1/2, 1//3 and 1/2/3."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ..jit.compiled import device, kernel

Ints = npt.NDArray[np.int64]

#: Digits that a number may have.
_LONGEST = 15


@kernel
def _read(codes, sizes, corners):
    # Return the number of corners; -1 where the text holds something else.
    at = line = count = 0
    while at < codes.size:
        code = codes[at]
        if code <= 32:
            if code == 10:
                line += 1
            at += 1
            continue
        place = 0
        while True:
            negative = codes[at] == 45
            if codes[at] == 45 or codes[at] == 43:
                at += 1
            digits, number = 0, np.int64(0)
            while 48 <= codes[at] <= 57:
                number = number * 10 + np.int64(codes[at] - 48)
                digits += 1
                at += 1
            # Only behind a slash a number may be missing, and its sign with it.
            if digits > _LONGEST or (digits == 0 and (place == 0 or negative or codes[at - 1] == 43)):
                return -1
            if place < 3:
                corners[place, count] = -number if negative else number
            if codes[at] != 47:
                break
            place += 1
            at += 1
        if codes[at] > 32:
            return -1
        sizes[line] += 1
        count += 1
    return count


def read(text: bytes | bytearray) -> tuple[Ints, Ints] | None:
    """Return how many corners each line has, and their numbers, (3, k), 0 where missing.

    None where the text holds something else.
    """
    text = text if text.endswith(b"\n") else text + b"\n"
    sizes = np.zeros(text.count(b"\n"), np.int64)
    corners = np.zeros((3, len(text) // 2 + 1), np.int64)  # memory that is not written to takes no place
    count = _read(np.frombuffer(text, np.uint8), sizes, corners)
    return None if count < 0 else (sizes, corners[:, :count])


@device
def _put(number, out, at):
    n, rest = 1, number // 10
    while rest > 0:
        rest //= 10
        n += 1
    for j in range(n - 1, -1, -1):
        rest = number // 10
        out[at + j] = 48 + number - 10 * rest
        number = rest
    return at + n


@kernel
def _write(sizes, corners, word, out):
    at = corner = 0
    for i in range(sizes.size):
        for code in word:
            out[at] = code
            at += 1
        for _ in range(sizes[i]):
            out[at] = 32
            at += 1
            last = corners.shape[1] - 1
            while last > 0 and corners[corner, last] < 1:
                last -= 1
            for j in range(last + 1):
                if j > 0:
                    out[at] = 47
                    at += 1
                if corners[corner, j] > 0:
                    at = _put(corners[corner, j], out, at)
            corner += 1
        out[at] = 10
        at += 1
    return at


def write(word: bytes, sizes: Ints, corners: Ints) -> npt.NDArray[np.uint8]:
    """Return the lines of elements with so many corners each, of the numbers (k, 1 to 3), 0 where missing."""
    widest = len(str(int(corners.max(initial=0)))) + 1
    out = np.empty(len(sizes) * (len(word) + 1) + widest * corners.size, np.uint8)
    return out[: _write(sizes, corners, np.frombuffer(word, np.uint8), out)]
