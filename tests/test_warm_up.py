"""Warm-up: every kernel is reached, by every process that needs it."""

import json
import subprocess
import sys

_MISSED = """
import importlib, json, pkgutil
from numba.core.dispatcher import Dispatcher
import vtksmooth
from vtksmooth import warm_up

warm_up.run()
kernels_found, called = {}, set()
for info in pkgutil.walk_packages(vtksmooth.__path__, "vtksmooth."):
    if info.name.startswith(("vtksmooth.paraview", "vtksmooth.__main__")):
        continue
    module = importlib.import_module(info.name)
    for name, found in vars(module).items():
        if isinstance(found, Dispatcher) and found.py_func.__module__ == info.name:
            called.update(found.py_func.__code__.co_names)
            if not found.targetoptions.get("forceinline"):
                kernels_found[name] = found
# What other kernels call is part of their machine code.
missed = [n for n, found in kernels_found.items() if not found.signatures and n not in called]
assert len(kernels_found) > 50
print(json.dumps(missed))
"""


def test_no_kernel_is_missed():
    done = subprocess.run([sys.executable, "-c", _MISSED], capture_output=True, text=True, check=True)
    assert json.loads(done.stdout) == []
