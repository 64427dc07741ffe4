"""Points and lines as texts, so that recipes, command lines and scripts can name them.

Points are numbers and ranges, ``0-14,20``; of very many, scattered ones the text is their bits instead. Lines
are chains of points that follow each other, ``3-17-19,40-41``.
"""

from __future__ import annotations

import base64
import binascii
import zlib
from collections.abc import Iterable

import numpy as np
import numpy.typing as npt

from ..errors import ParameterError

Int64 = npt.NDArray[np.int64]

#: All points.
ALL = "all"
#: What a text begins with that stands for points where the name of an array may be.
SELECTION = "points:"
_BITS = "bits:"
#: From this many ranges on bits are tried, which are shorter then.
_MANY = 200


def format_points(points: npt.ArrayLike) -> str:
    """Return point numbers as a text; see :func:`parse_points`.

    Examples
    --------
    >>> format_points([4, 5, 6, 9])
    '4-6,9'
    """
    numbers = np.unique(np.asarray(points, dtype=np.int64))
    breaks = np.flatnonzero(np.diff(numbers) != 1)
    first = numbers[np.concatenate(([0], breaks + 1))] if len(numbers) else numbers
    last = numbers[np.concatenate((breaks, [-1]))] if len(numbers) else numbers
    if len(first) >= _MANY:
        marked = np.zeros(numbers[-1] + 1, np.bool_)
        marked[numbers] = True
        packed = zlib.compress(np.packbits(marked, bitorder="little").tobytes())
        bits = _BITS + base64.urlsafe_b64encode(packed).decode()
        if len(bits) < len(str(numbers[-1])) * len(first):
            return bits
    ranges = zip(first.tolist(), last.tolist(), strict=True)
    return ",".join(str(a) if a == b else f"{a}-{b}" for a, b in ranges)


def format_selection(name: str, points: npt.ArrayLike) -> str:
    """Return points chosen by a mask or by their numbers as a text; see :func:`parse_selection`.

    Examples
    --------
    >>> format_selection("fixed", [True, False, True]), format_selection("fixed", [4, 5, 6])
    ('points:0,2 of 3', 'points:4-6')
    """
    values = np.asarray(points)
    if values.ndim == 1 and values.dtype == np.bool_ and len(values):
        return f"{SELECTION}{format_points(np.flatnonzero(values))} of {len(values)}"
    if values.shape == (0,):
        return SELECTION
    if values.ndim != 1 or values.dtype.kind not in "iu" or (values < 0).any():
        raise ParameterError(
            f"{name} must be the name of a point array, a mask (bool, one value for each point), or "
            "numbers of points from 0 on."
        )
    if len(values) > 2 and values.max() <= 1:
        raise ParameterError(
            f"{name}: an array of 0 and 1 may be a mask or numbers of points; give a mask as bool, by "
            "astype(bool)."
        )
    return f"{SELECTION}{format_points(values)}"


def parse_selection(name: str, text: str, n: int) -> Int64:
    """Return the points that a text of :func:`format_selection` names.

    Raises
    ------
    ParameterError
        The mask has another length than `n`, or there is no such point.

    Examples
    --------
    >>> parse_selection("fixed", "points:0,2 of 3", 3).tolist()
    [0, 2]
    """
    numbers, _, length = text.removeprefix(SELECTION).partition(" of ")
    if length and length != str(n):
        raise ParameterError(f"{name}: the mask has {length} values; the mesh has {n} points.")
    return parse_points(name, numbers, n) if numbers else np.empty(0, np.int64)


def parse_points(name: str, text: str, n: int) -> Int64:
    """Return the points that a text names, in rising order.

    Parameters
    ----------
    name : str
        Name of the parameter, for the message.
    text : str
        Numbers from 0 and ranges of them, "0-14,20"; "all"; or what :func:`format_points` made.
    n : int
        How many points there are.

    Raises
    ------
    ParameterError
        The text is written otherwise, or there is no such point.

    Examples
    --------
    >>> parse_points("fix", "4-6,9", 10).tolist()
    [4, 5, 6, 9]
    """
    if text == ALL:
        return np.arange(n)
    numbers: Int64 | None = None
    try:
        if text.startswith(_BITS):
            numbers = _bits(text.removeprefix(_BITS), n)
            ends = [(int(numbers[0]), int(numbers[-1]))] if len(numbers) else []
        else:
            ends = _ranges(text)
    except (ValueError, binascii.Error, zlib.error):
        raise ParameterError(
            f"{name} must be numbers of points and ranges of them, as 0-14,20, not {_short(text)}."
        ) from None
    for begin, end in ends:  # before they are expanded: short texts can name more points than fit into memory
        _check_numbers(name, begin, end, n)
    return _expanded(ends, n) if numbers is None else numbers


def _expanded(ends: list[tuple[int, int]], n: int) -> Int64:
    begins_less_ends = np.zeros(n + 1, np.int64)
    for begin, end in ends:
        begins_less_ends[begin] += 1
        begins_less_ends[end + 1] -= 1
    return np.flatnonzero(np.cumsum(begins_less_ends))


def _ranges(text: str) -> list[tuple[int, int]]:
    ends = []
    for word in text.split(","):
        first, _, last = word.partition("-")
        begin, end = int(first), int(last or first)
        if begin > end:
            raise ValueError(word)
        ends.append((begin, end))
    return ends


def _bits(text: str, n: int) -> Int64:
    # No more is unpacked than shows a point that is not there.
    unpacking, most = zlib.decompressobj(), (n + 7) // 8 + 1
    packed = unpacking.decompress(base64.urlsafe_b64decode(text), most)
    if len(packed) < most and not unpacking.eof:
        raise ValueError(text)
    return np.flatnonzero(np.unpackbits(np.frombuffer(packed, np.uint8), bitorder="little"))


def format_lines(lines: Iterable[npt.ArrayLike]) -> str:
    """Return chains of points as a text; see :func:`parse_lines`."""
    return ",".join("-".join(str(int(point)) for point in np.asarray(line)) for line in lines)


def parse_lines(name: str, text: str, n: int) -> Int64:
    """Return the edges of the lines that a text names, (k, 2).

    Raises
    ------
    ParameterError
        The text is written otherwise, or there is no such point.

    Examples
    --------
    >>> parse_lines("add_lines", "3-1-2,7-8", 9).tolist()
    [[3, 1], [1, 2], [7, 8]]
    """
    try:
        chains = [np.array([int(word) for word in line.split("-")]) for line in text.split(",")]
        if min(len(chain) for chain in chains) < 2:
            raise ValueError(text)
    except (ValueError, OverflowError):
        raise ParameterError(
            f"{name} must be chains of points, as 3-17-19,40-41, not {_short(text)}."
        ) from None
    pairs = np.concatenate([np.column_stack((chain[:-1], chain[1:])) for chain in chains])
    _check_numbers(name, int(pairs.min()), int(pairs.max()), n)
    return pairs


def _check_numbers(name: str, smallest: int, largest: int, n: int) -> None:
    if smallest < 0 or largest >= n:
        raise ParameterError(
            f"{name}: there is no point {smallest if smallest < 0 else largest}; the points of this mesh "
            f"are numbered 0 to {n - 1}."
        )


def _short(text: str) -> str:
    return repr(text if len(text) <= 40 else f"{text[:40]}…")
