"""Compiling ahead: the list is what filters need, and what it names is not compiled again."""

import importlib
import json
import os
import subprocess
import sys

import numpy as np
import pytest
from numba import typeof, types

from vtksmooth.filters import FILTERS
from vtksmooth.jit import compile_ahead, parallel
from vtksmooth.jit.caching import KernelCache
from vtksmooth.jit.compile_ahead import compiling_ahead, spelled, understood
from vtksmooth.jit.compiled import device
from vtksmooth.kernels.mesh import adjacency
from vtksmooth.kernels.mesh.mesh import Mesh

LIST = json.loads(compile_ahead.PATH.read_text(encoding="utf-8"))

_COMPILED = """
import pyvista as pv
from vtksmooth import SurfaceQuality
from vtksmooth.jit.compiled import on_compile

with on_compile(print):
    SurfaceQuality()(pv.Sphere())
"""


def python(*arguments, **environment):
    environment = {**os.environ, **environment}
    done = subprocess.run([sys.executable, *arguments], capture_output=True, text=True, env=environment)
    assert done.returncode == 0, done.stderr
    return done


@pytest.mark.parametrize("cls", FILTERS)
def test_the_list_is_up_to_date(cls):
    needed = json.loads(python("-m", "vtksmooth.signatures", cls.__name__).stdout)
    listed = [LIST["kernels"][number] for number in LIST["filters"][cls.__name__]]
    assert listed == needed, "run: python -m vtksmooth.signatures"


def test_types_are_read_as_they_are_written():
    points = np.eye(3)
    mesh = Mesh.from_faces(points, np.array([[0, 1, 2]]))
    kinds = (
        types.float64, types.boolean, typeof(points), typeof(np.zeros(2, bool)),
        typeof(adjacency.build(mesh)), typeof((1.0, 2.0)), typeof((points, 1)),
    )  # fmt: skip
    assert understood("".join(f"{spelled(kind)}," for kind in kinds)) == kinds


def test_what_kernels_must_not_take_is_not_written():
    with pytest.raises(ValueError, match="C-contiguous"):
        spelled(typeof(np.eye(3)[:, :2]))


def test_what_was_compiled_ahead_is_not_compiled_again(tmp_path):
    cache = {"NUMBA_CACHE_DIR": str(tmp_path), "VTKSMOOTH_THREADS": "1"}
    command = [sys.executable, "-m", "vtksmooth.jit.compile_ahead", "SurfaceQuality", "1"]
    pipes = dict.fromkeys(("stdin", "stdout", "stderr"), subprocess.PIPE)
    with subprocess.Popen(command, env={**os.environ, **cache}, **pipes) as helper:  # type: ignore[call-overload]
        assert helper.wait() == 0
        assert helper.stdout.read() + helper.stderr.read() == b""
    assert python("-c", _COMPILED, **cache).stdout == ""


@pytest.mark.parametrize("cls", FILTERS)
def test_helpers_begin_with_other_kernels_and_come_to_all(cls):
    kernels = [LIST["kernels"][number] for number in LIST["filters"][cls.__name__]]
    functions = [getattr(importlib.import_module(module), name).py_func for module, name, _ in kernels]
    orders = [compile_ahead.order(functions, part) for part in range(3)]
    assert all(sorted(order) == list(range(len(functions))) for order in orders)
    assert len({tuple(order[:1]) for order in orders}) == max(1, min(len(functions), 3))


@device
def _shared(x):
    return x * x * x * x * x * x * x * x * x * x * x * x


def _one(x):
    return _shared(x)


def _small(x):
    return x


def _biggest(x):
    return x + _shared(x) + x


def _larger(x):
    return x + x + x


def test_what_shares_most_of_its_code_is_compiled_together():
    functions = [_one, _small, _biggest, _larger]
    assert compile_ahead.order(functions, 0) == [0, 2, 3, 1]
    assert compile_ahead.order(functions, 1) == [3, 2, 1, 0]


def test_helpers_end_with_the_process_that_started_them(tmp_path):
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    command = [sys.executable, "-m", "vtksmooth.jit.compile_ahead", "", "0"]
    helper = subprocess.Popen(command, env=environment, stdin=subprocess.PIPE)
    helper.stdin.close()  # as the operating system does, however the process ends
    assert helper.wait(60) == 0
    assert not list(tmp_path.rglob("*.nbc"))


@pytest.fixture
def two_threads():
    parallel.set_number_of_threads(2)
    yield
    parallel.set_number_of_threads(0)


def test_helpers_end_with_the_filter(two_threads):
    ahead = compiling_ahead("")
    with ahead:
        ahead._begin("a kernel")
        helpers = list(ahead._helpers)
        assert len(helpers) == 1
        with compiling_ahead("") as within:  # a filter that uses a filter
            assert within is None
        assert ahead._helpers == helpers
        assert KernelCache.meanwhile == ahead._compile_another
    assert not ahead._helpers
    assert KernelCache.meanwhile is None
    assert helpers[0].returncode is not None


def test_one_thread_and_other_programs_have_no_helpers(two_threads, monkeypatch):
    ahead = compiling_ahead("")
    with ahead:
        parallel.set_number_of_threads(1)
        ahead._begin("a kernel")
        parallel.set_number_of_threads(2)
        for program in ("/usr/bin/pvpython", "", None):
            monkeypatch.setattr(sys, "executable", program)
            ahead._begin("a kernel")
        assert not ahead._helpers
