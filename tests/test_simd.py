"""Lanes do what NumPy does to each of four numbers, to the last bit."""

import operator

import numpy as np
import pytest

from vtksmooth.jit import simd
from vtksmooth.jit.compiled import kernel
from vtksmooth.jit.simd import (
    absolute,
    everywhere,
    gather,
    load,
    narrow,
    pack,
    select,
    spread,
    square_root,
    store,
    unpack,
)

A = np.array([[1.0, 5.0, 0.0, -7.5], [0.1, np.nan, np.inf, 1e-310]])
B = np.array([[3.0, -2.0, 0.0, 4.25], [0.3, 1.0, np.inf, 1e-20]])


@kernel
def _arithmetic(a, b, found):
    for i in range(len(a)):
        x = load(a, i)
        y = load(b, i)
        store(found[0], i, x + y)
        store(found[1], i, x - y)
        store(found[2], i, x * y)
        store(found[3], i, x / y)
        store(found[4], i, -x)
        store(found[5], i, absolute(x))
        store(found[6], i, square_root(y))
        store(found[7], i, 0.5 - x * 3.0)
        x += y
        x *= 2.0
        x -= 0.25
        x /= y
        store(found[8], i, x)


def test_arithmetic_has_the_bits_of_numpy():
    found = np.empty((9, *A.shape))
    with np.errstate(all="ignore"):
        _arithmetic(A, B, found)
        expected = np.array(
            [
                *(f(A, B) for f in (operator.add, operator.sub, operator.mul, operator.truediv)),
                -A, abs(A), np.sqrt(B), 0.5 - A * 3.0, ((A + B) * 2.0 - 0.25) / B,
            ]
        )  # fmt: skip
    np.testing.assert_array_equal(found, expected)


@kernel
def _choose(a, b, found):
    for i in range(len(a)):
        x = load(a, i)
        y = load(b, i)
        store(found[0], i, select(x < y, x, y))
        store(found[1], i, select(x <= y, 1.0, y))
        store(found[2], i, select(x > y, x, 2.0))
        store(found[3], i, select((x >= y) | (x == y), 1.0, 0.0))
        store(found[4], i, select((x < y) & (x > 0.5), 1.0, 0.0))


def test_choices_are_those_of_numpy():
    found = np.empty((5, *A.shape))
    _choose(A, B, found)
    expected = [
        np.where(A < B, A, B),
        np.where(A <= B, 1.0, B),
        np.where(A > B, A, 2.0),
        (A >= B) | (A == B),
        (A < B) & (A > 0.5),
    ]
    np.testing.assert_array_equal(found, np.array(expected, float))


@kernel
def _narrowly(a, b, found, whole):
    for i in range(len(a)):
        x = narrow(load(a, i))
        y = narrow(load(b, i))
        store(found[0], i, x + y)
        store(found[1], i, 1.0 / square_root(y))
        store(found[2], i, select(x < y, x, 0.1))
        store(found[3], i, -absolute(x) * 0.3)
        x *= 1.1
        x -= y
        store(found[4], i, load(found[0], i) / x)
        store(whole, i, y * 2.5)


def test_narrow_lanes_are_float32():
    found = np.empty((5, *A.shape), np.float32)
    whole = np.empty(A.shape, np.int32)
    with np.errstate(all="ignore"):
        a = A.astype(np.float32)
        b = np.array([[3.0, -2.0, 0.0, 4.25], [0.3, 1.0, 7.7, 1e-20]])
        _narrowly(A, b, found, whole)
        b = b.astype(np.float32)
        one, tenth, three = np.float32([1.0, 0.1, 0.3])
        expected = [a + b, one / np.sqrt(b), np.where(a < b, a, tenth), -abs(a) * three]
        expected.append(expected[0] / (a * np.float32(1.1) - b))
    np.testing.assert_array_equal(found, expected)
    np.testing.assert_array_equal(whole, (b * np.float32(2.5)).astype(np.int32))


@kernel
def _everywhere(a, b):
    return everywhere(load(a, 0) < load(b, 0))


def test_a_mask_is_true_everywhere_or_not():
    assert _everywhere(np.zeros((1, 4)), np.ones((1, 4)))
    for lane in range(simd.WIDTH):
        a = np.zeros((1, 4))
        a[0, lane] = 2.0
        assert not _everywhere(a, np.ones((1, 4)))


@kernel
def _gather(numbers, found):
    store(found, 0, pack(numbers[3], numbers[0], numbers[2], numbers[1]))
    store(found, 1, spread(4.5))


@pytest.mark.parametrize("precision", [np.float32, np.float64])
def test_numbers_become_lanes(precision):
    numbers = np.array([0.1, -2.0, 1e-30, 7.0], precision)
    found = np.empty((2, simd.WIDTH))
    _gather(numbers, found)
    np.testing.assert_array_equal(found, [numbers[[3, 0, 2, 1]].astype(float), [4.5] * 4])


@kernel
def _transpose(rows, found):
    x, y, z = gather(rows, 4, 0, 2, 2)
    found[0] = unpack(x)
    found[1] = unpack(y)
    found[2] = unpack(z)


@pytest.mark.parametrize("precision", [np.float32, np.float64])
def test_rows_become_lanes_and_lanes_numbers(precision):
    rows = np.random.default_rng(0).normal(size=(5, 3)).astype(precision)
    found = np.empty((3, simd.WIDTH))
    _transpose(rows, found)
    np.testing.assert_array_equal(found, rows[[4, 0, 2, 2]].T.astype(float))


@kernel
def _of_numbers(a, b):
    return select(a < b, square_root(b), absolute(a))


def test_functions_for_lanes_take_numbers():
    assert _of_numbers(-2.0, 9.0) == 3.0
    assert _of_numbers(-2.0, -9.0) == 2.0
