"""Text files: which of their lines is what, and the numbers on them, without a loop over the lines."""

from __future__ import annotations

import itertools
import re
import warnings
from collections.abc import Iterator
from typing import IO, Any, NamedTuple

import numpy as np
import numpy.typing as npt

Ints = npt.NDArray[np.int64]
Text = bytes | bytearray
Codes = npt.NDArray[np.uint8]

_NO_LINES: Ints = np.empty(0, np.int64)

_BLANK = 32  # this code and those below it separate words

_BLOCK = 1 << 20

_LARGE = 1 << 22  # a text of this size is worth a compiled kernel

_INDENTED = 64  # so many characters before the first word are passed over without copying the text

_AT_ONCE = 10000  # lines written at once, which bounds the memory

_MANY = 100000  # so many numbers to be written are worth a compiled kernel

#: What the C library of one compiler writes for what is no number.
_NO_NUMBER = re.compile(rb"(?i)1\.#(inf|qnan|snan|ind)0*")


def unified(raw: bytes) -> bytes:
    """Return the text without a byte-order mark and with one kind of line ends."""
    raw = raw.removeprefix(b"\xef\xbb\xbf")
    if b"\r" in raw:
        raw = raw.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    return raw


def without_comments(text: Text) -> Text:
    """Return the text without what follows a #, line by line."""
    return re.sub(rb"#[^\n]*", b"", text) if b"#" in text else text


def decoded(word: Text) -> str:
    """Return a name in a file as text: UTF-8 where it is, else Latin-1, which anything is."""
    try:
        return word.decode("utf-8")
    except UnicodeDecodeError:
        return word.decode("latin-1")


def quoted(line: Text) -> str:
    """Return the beginning of a line for a message."""
    text = decoded(line.strip()[:40])
    return repr("".join(c if c.isprintable() else "?" for c in text))


def blocks(text: bytes) -> Iterator[bytes]:
    """Cut a text into blocks of whole lines: what is made of a block stays in the processor's cache."""
    at = 0
    while at < len(text):
        end = text.find(b"\n", at + _BLOCK) + 1 or len(text)
        yield text[at:end]
        at = end


def _parsed(text: Text) -> tuple[npt.NDArray[np.float64], Ints] | None:
    """Return the numbers of a text, and how many each line holds; None when something else is among them."""
    if len(text) >= _LARGE:
        # NumPy is slower, but there is nothing to be compiled before.
        from .numerals import parsed

        return parsed(text)
    codes = np.frombuffer(text, np.uint8)
    word = codes > _BLANK
    word[1:] &= codes[:-1] <= _BLANK
    starts = np.flatnonzero(word)
    values = np.empty(0)
    if len(starts):
        with warnings.catch_warnings():
            # NumPy announces text that is no number as a deprecation, and returns what came before it.
            warnings.simplefilter("error", DeprecationWarning)
            try:
                values = np.fromstring(bytes(text), dtype=np.float64, sep=" ")  # type: ignore[call-overload]
            except (DeprecationWarning, ValueError):
                return None
    if len(values) != len(starts):  # "1-2" is two numbers to NumPy, and none to us
        return None
    ends = np.flatnonzero(codes == ord("\n"))
    if not text.endswith(b"\n"):
        ends = np.append(ends, len(text))
    return values, np.diff(np.searchsorted(starts, ends), prepend=0)


class Rows(NamedTuple):
    """The numbers of a text, line by line.

    Attributes
    ----------
    values : (k,) float64
    counts : (n,) int64
        How many of them each line holds; lines without any are counted, too.
    commas : bool
        Whether decimal commas were taken for points.
    """

    values: npt.NDArray[np.float64]
    counts: Ints
    commas: bool

    @property
    def starts(self) -> Ints:
        """Where in `values` each line begins."""
        starts: Ints = np.cumsum(self.counts) - self.counts
        return starts

    def columns(self, count: int) -> npt.NDArray[np.float64]:
        """Return the first numbers of each line, (n, count); 0 where a line has fewer."""
        if len(self.counts) * count == len(self.values) and (self.counts == count).all():
            return self.values.reshape(-1, count)
        table = np.zeros((len(self.counts), count))
        starts = self.starts
        for i in range(count):
            there = self.counts > i
            table[there, i] = self.values[starts[there] + i]
        return table


def rows(text: Text) -> Rows | None:
    """Parse numbers between white space; None when something else is among them.

    Exponents may have a D, and decimal commas are understood where the text has no decimal point.
    """
    found, commas = _parsed(text), False
    if found is None:
        plain = re.sub(rb"(?<=[\d.])[dD](?=[-+\d])", b"e", text)
        plain = _NO_NUMBER.sub(lambda found: b"inf" if found[1].lower() == b"inf" else b"nan", plain)
        commas = b"," in plain and b"." not in plain
        found = _parsed(plain.replace(b",", b".") if commas else plain)
    return None if found is None else Rows(*found, commas)


def corner_numbers(text: Text) -> tuple[Ints, Ints] | None:
    """Return how many corners each line of a large text has, and their numbers, (3, k), 0 where missing.

    None where the text is small, or holds something else.
    """
    if len(text) < _LARGE:
        return None
    from .corners import read

    return read(text)


def first_bad_line(text: Text) -> tuple[int, bytes]:
    """Return the number and the text of the first line with something else than numbers."""
    for number, line in enumerate(bytes(text).split(b"\n")):
        if rows(line) is None:
            return number, line
    return 0, bytes(text).split(b"\n", 1)[0]


class Lines:
    """The lines of a text, each without the white space before its first word.

    Parameters
    ----------
    text : bytes
        See :func:`unified`.

    Attributes
    ----------
    text : bytes
    starts, ends : (n,) int64
        Where each line begins, and where its line end stands.
    """

    def __init__(self, text: bytes) -> None:
        text = text if text.endswith(b"\n") else text + b"\n"
        self._split(text)
        for _ in range(_INDENTED):
            indented = np.flatnonzero((self._first <= _BLANK) & (self._first != ord("\n")))
            if not len(indented):
                return
            self.starts[indented] += 1
            self._first[indented] = self.codes[self.starts[indented]]
        self._split(re.sub(rb"\n[^\S\n]+", b"\n", b"\n" + text)[1:])

    def _split(self, text: bytes) -> None:
        self.text = text
        self.codes: Codes = np.frombuffer(text, np.uint8)
        self.ends: Ints = np.flatnonzero(self.codes == ord("\n"))
        self.starts: Ints = np.concatenate(([0], self.ends[:-1] + 1))
        self._first = self.codes[self.starts]
        self._beginning: dict[int, Ints | None] = {}

    def beginning(self, word: bytes) -> Ints:
        """Return the numbers of the lines whose first word is this one."""
        if not self._beginning:
            self._beginning = dict.fromkeys(np.flatnonzero(np.bincount(self._first)).tolist())
        found = self._beginning.get(word[0], _NO_LINES)
        if found is None:
            found = self._beginning[word[0]] = np.flatnonzero(self._first == word[0])
        for i, code in enumerate(word[1:], 1):
            found = found[self.codes[self.starts[found] + i] == code]
        found = found[self.codes[self.starts[found] + len(word)] <= _BLANK]
        return found

    def after(self, lines: Ints, skip: int) -> Text:
        """Return the text of some lines, in rising order, without their first `skip` characters."""
        begins, ends = self.starts[lines] + skip, self.ends[lines] + 1
        if len(lines) and lines[-1] - lines[0] == len(lines) - 1:
            shift = self.starts[lines[0]]
            text = bytearray(memoryview(self.text)[shift : ends[-1]])
            codes = np.frombuffer(text, np.uint8)
            for i in range(skip):
                codes[begins - shift - i - 1] = _BLANK
            return text
        change = np.zeros(len(self.text) + 1, np.int8)
        change[begins] += 1
        change[ends] -= 1
        inside = np.cumsum(change[:-1], dtype=np.int8).astype(bool)
        return bytes(self.codes[inside])

    def words(self, lines: Ints, skip: int) -> list[bytes]:
        """Return the text of each of some lines behind its first `skip` characters, stripped."""
        begins, ends = (self.starts[lines] + skip).tolist(), self.ends[lines].tolist()
        return [self.text[a:b].strip() for a, b in zip(begins, ends, strict=True)]


def write_table(file: IO[bytes], word: str, table: npt.NDArray[Any]) -> None:
    """Write a line for each row of a table, a word and the numbers, which read back the same."""
    if table.size >= _MANY and table.dtype.kind == "f":
        from .shortest import table_lines

        for a in range(0, len(table), _AT_ONCE):
            file.write(table_lines(word.encode(), table[a : a + _AT_ONCE]).data)
        return
    # The text of a Python float is the shortest that reads back the same.
    line = f"{word}{' %r' * table.shape[1]}\n".lstrip(" ")
    for a in range(0, len(table), _AT_ONCE):
        part = table[a : a + _AT_ONCE]
        file.write(((line * len(part)) % tuple(part.ravel().tolist())).encode())


def write_elements(
    file: IO[bytes], word: str, sizes: Ints, corners: npt.NDArray[np.int64], before: dict[int, str]
) -> None:
    """Write a line for each of some elements of an OBJ file.

    Parameters
    ----------
    file : binary file
    word : str
        The first word of the lines.
    sizes : (n,) int64
        How many of the corners belong to each element.
    corners : (sum(sizes), 1 to 3) int64
        The numbers of each corner's point, texture coordinates and normal, from 1 on; 0 where missing.
    before : dict of int to str
        Lines to be written before an element.
    """
    begins = np.concatenate(([0], np.cumsum(sizes)))
    large = corners.size >= _MANY
    cuts = sorted({*range(0, len(sizes), _AT_ONCE), *before, len(sizes)})
    for a, b in itertools.pairwise(cuts):
        file.write(before.get(a, "").encode())
        part = sizes[a:b], corners[begins[a] : begins[b]]
        if large:
            from .corners import write

            file.write(write(word.encode(), *part).data)
        else:
            file.write(_element_lines(word, *part).encode())


def _element_lines(word: str, sizes: Ints, corners: npt.NDArray[np.int64]) -> str:
    texts = ["/".join(str(number or "") for number in row).rstrip("/") for row in corners.tolist()]
    ends = np.cumsum(sizes).tolist()
    return "".join(f"{word} {' '.join(texts[a:b])}\n" for a, b in zip([0, *ends], ends, strict=False))


def write_cells(file: IO[bytes], sizes: Ints, values: npt.NDArray[Any], lines: dict[int, str]) -> None:
    """Write a line for each of some cells.

    Parameters
    ----------
    file : binary file
    sizes : (n,) int64
        How many of the values belong to each cell.
    values : (sum(sizes),) array
    lines : dict of int to str
        The line of a cell with so many values, with a place for each in the style of %.
    """
    begins = np.concatenate(([0], np.cumsum(sizes)))
    for a in range(0, len(sizes), _AT_ONCE):
        b = min(a + _AT_ONCE, len(sizes))
        template = "".join([lines[size] for size in sizes[a:b].tolist()])
        file.write((template % tuple(values[begins[a] : begins[b]].tolist())).encode())
