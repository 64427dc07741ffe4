"""Where machine code is kept, and that kernels work where it can be kept nowhere."""

from __future__ import annotations

import ast
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numba
import numpy as np
import pytest

import vtksmooth
from vtksmooth.jit import compiled

PROGRAM = """
import sys
sys.path.insert(0, sys.argv[1])
import vtksmooth.jit.compiled as compiled
from vtksmooth.jit import parallel
from vtksmooth.kernels.smoothing.loop import _carry_out
import numpy as np
starts, ends = parallel.ranges(3)
points = np.zeros((3, 3))
names = []
with compiled.on_compile(names.append):
    moved = _carry_out(starts, ends, np.zeros(3, np.uint8), np.ones((3, 3)), points)
    print(moved, points.sum(), len(names))
"""


def parsed(source: Path) -> set[Path]:
    """What a source imports of the package, by Python's own parser."""
    found = set()
    for node in ast.walk(ast.parse(source.read_bytes())):
        if isinstance(node, ast.ImportFrom) and node.level:
            home = source.parents[node.level - 1].joinpath(*(node.module or "").split("."))
            names = [home / f"{name.name}.py" for name in node.names]
            found |= {home.with_suffix(".py"), home / "__init__.py", *names}
    return {path for path in found if path.is_file()}


def test_all_imports_of_the_sources_are_found() -> None:
    sources = list(Path(vtksmooth.__file__).parent.rglob("*.py"))
    assert len(sources) > 50
    for source in sources:
        assert set(compiled._imported(source)) == parsed(source), source


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    """A copy of the package without any machine code."""
    source = Path(vtksmooth.__file__).parent
    shutil.copytree(source, tmp_path / "vtksmooth", ignore=shutil.ignore_patterns("__pycache__"))
    return tmp_path


def run(folder: Path, **environment: str) -> str:
    usual = {name: value for name, value in os.environ.items() if name != "NUMBA_CACHE_DIR"}
    environment = {**usual, **environment}
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, str(folder)],
        env=environment,
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout.strip()


def test_a_kernel_is_compiled_once_and_again_when_a_source_changes_that_it_depends_on(copy: Path) -> None:
    assert run(copy) == "3 9.0 1"
    assert run(copy) == "3 9.0 0"
    kernels = copy / "vtksmooth" / "kernels"
    # A helper in another file, two imports away: numba itself would not notice.
    for name, times in (("measures/aspect_ratio.py", 1), ("smoothing/constraints/tangent_plane.py", 0)):
        changed = kernels / name
        changed.write_text(changed.read_text() + "\n# changed\n")
        assert run(copy) == f"3 9.0 {times}"
    assert len(list((copy / "vtksmooth" / "jit" / "__pycache__").glob("smoothing.loop-*"))) == 1


def test_kernels_work_where_nothing_can_be_written(copy: Path) -> None:
    # A file where the folder should be: not even the administrator can write there.
    occupied = copy / "occupied"
    occupied.touch()
    for _ in range(2):
        assert run(copy, NUMBA_CACHE_DIR=str(occupied)) == "3 9.0 1"


def test_an_installation_that_cannot_be_written_uses_the_users_cache(copy: Path, tmp_path: Path) -> None:
    (copy / "vtksmooth" / "jit" / "__pycache__").write_text("occupied")
    home = tmp_path / "home"
    names = {"HOME": str(home), "XDG_CACHE_HOME": str(home), "LOCALAPPDATA": str(home)}
    assert run(copy, **names) == "3 9.0 1"
    assert run(copy, **names) == "3 9.0 0"
    assert list((home / "vtksmooth").glob("smoothing.loop-*"))


def test_an_import_compiles_nothing(tmp_path: Path) -> None:
    """Whoever imports need not wait, and is not told to."""
    subprocess.run(
        [sys.executable, "-c", "import vtksmooth.paraview.proxies"],
        env=os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}, check=True,
    )  # fmt: skip
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == []


def test_helpers_that_count_no_references_cannot_make_arrays():
    @compiled.device
    def helper(n):
        return np.zeros(n).sum()

    @numba.njit
    def caller(n):
        return helper(n)

    with pytest.raises(numba.TypingError, match="returning of array"):
        caller(3)
