"""Numbers of a text are the same as those that Python reads, bit by bit."""

import random
import struct

import numpy as np
import pytest

from vtksmooth.files import numerals, text

ODD = """
9007199254740993 9007199254740992.5 4503599627370496.5 4503599627370497.5 1e23 8.5e22 0.5 -0 -0.0 +1 1. 0.1e-1
.5 5e-324 2.2250738585072011e-308 1.7976931348623157e308 1e400 -1e-400 0e999 1e99999999 inf 1E+2 -2e-3
0000000000000000000000000000001.5 0.00000000000000000000000000000000012 123456789012345678901234567890e-9
"""


def _words(count):
    rng = random.Random(0)
    for _ in range(count):
        yield repr(struct.unpack("d", rng.randbytes(8))[0])
        yield f"{rng.gauss(0, 1):.{rng.randint(1, 25)}g}"
        yield f"{rng.getrandbits(rng.randint(1, 63))}e{rng.randint(-345, 310)}"
        yield repr(rng.random() * 10.0 ** rng.randint(-10, 10))
        yield f"{2 * (rng.getrandbits(53) | 1 << 52) + 1}e{rng.randint(-5, 5)}"  # half way between two
        yield str(rng.randint(-(10**9), 10**9))


def test_every_number_is_the_nearest_there_is():
    words = [*_words(5000), *ODD.split()]
    values, counts = numerals.parsed(" ".join(words).encode())
    assert counts.tolist() == [len(words)]
    expected = np.array([float(word) for word in words])
    number = ~np.isnan(expected)
    np.testing.assert_array_equal(values.view(np.uint64)[number], expected.view(np.uint64)[number])
    assert np.isnan(values[~number]).all()


@pytest.mark.parametrize(
    "word", ["1-2", "1e", "e5", ".", "-", "--1", "1.2.3", "0x10", "1_0", "1,5", "1/2", "1e5.5"]
)
def test_what_is_no_number_is_refused(word):
    assert numerals.parsed(f"1 {word} 2\n".encode()) is None


@pytest.mark.parametrize(
    "content", ["", "\n", "1", "1 2\n\n3\n", " \t1\n2 3 4", "1,5 2\n3", "1.#IND 1.d3\n\n2"]
)
def test_large_texts_are_read_as_small_ones(content, monkeypatch):
    small = text.rows(content.encode())
    monkeypatch.setattr(text, "_LARGE", 0)
    large = text.rows(content.encode())
    np.testing.assert_array_equal(large.values, small.values)
    assert large.counts.tolist() == small.counts.tolist()
    assert large.commas == small.commas
