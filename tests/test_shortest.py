"""The text of a number is the one that Python gives."""

import random
import struct

import numpy as np

from vtksmooth.files.shortest import table_lines


def _numbers(count):
    rng = random.Random(0)
    for _ in range(count):
        yield struct.unpack("d", rng.randbytes(8))[0]
        yield rng.gauss(0, 1) * 10.0 ** rng.randint(-10, 20)
        yield float(rng.getrandbits(rng.randint(1, 70)))
        yield round(rng.random(), rng.randint(1, 8))
        yield float(np.float32(rng.random()))
    yield from (0.0, -0.0, np.inf, -np.inf, np.nan, -np.nan, 1.7976931348623157e308, 2.2250738585072014e-308)
    yield from (9007199254740993.0, 1e16, 1e17, 123456789012345678.0, 1e-4, 1e-5, 0.00012345, 1e22, 1e23)
    yield from (sign * 2.0**i for i in range(-1074, 1024) for sign in (1, -1))
    yield from (10.0**i for i in range(-323, 309))


def test_the_text_of_every_number_is_that_of_python():
    numbers = [*_numbers(5000)]
    text = table_lines(b"", np.array(numbers)[:, None]).tobytes().decode()
    assert text == "".join(f"{number!r}\n" for number in numbers)


def test_rows_become_lines_behind_a_word():
    table = np.array([[1, 0.5, -2e-9], [1e300, np.nan, 3]])
    assert table_lines(b"vn", table).tobytes() == b"vn 1.0 0.5 -2e-09\nvn 1e+300 nan 3.0\n"
    assert table_lines(b"", table[:1, :2].astype(np.float32)).tobytes() == b"1.0 0.5\n"
    assert table_lines(b"v", table[:0]).tobytes() == b""
