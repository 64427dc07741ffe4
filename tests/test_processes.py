"""Work shared among processes: forked, spawned or by workers of other packages; same points, flat memory."""

import multiprocessing
import subprocess
import sys
from pathlib import Path

import pytest

#: A program as people write it: one run in the parent, then a pool of processes, each with threads.
POOL = """
import hashlib, multiprocessing, sys
from concurrent.futures import ProcessPoolExecutor
import pyvista as pv
from vtksmooth import LaplacianSmoothing
from vtksmooth.jit import parallel

def smooth(resolution):
    parallel.set_number_of_threads(3)
    mesh = pv.Sphere(theta_resolution=resolution, phi_resolution=resolution)
    return hashlib.sha256(pv.wrap(LaplacianSmoothing(iterations=3)(mesh)).points.tobytes()).hexdigest()

def with_pool(sizes):
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context(sys.argv[1])) as pool:
        return list(pool.map(smooth, sizes))

def with_joblib(sizes):
    from joblib import Parallel, delayed
    return Parallel(n_jobs=2)(delayed(smooth)(size) for size in sizes)

def with_dask(sizes):
    import dask
    tasks = [dask.delayed(smooth)(size) for size in sizes]
    return list(dask.compute(*tasks, scheduler="processes", num_workers=2))

if __name__ == "__main__":
    sizes = [20, 250, 21, 251]
    expected = [smooth(size) for size in sizes]
    work = {"joblib": with_joblib, "dask": with_dask}.get(sys.argv[1], with_pool)
    assert work(sizes) == expected
    print("the same")
"""

#: By how many MB a forked child grows from its first 20 runs to its next 20, and how many threads it has.
FORKED = """
import gc, os, threading
import pyvista as pv
from vtksmooth import LaplacianSmoothing
from vtksmooth.jit import parallel

parallel.set_number_of_threads(3)
mesh = pv.Sphere(theta_resolution=300, phi_resolution=300)

def memory(runs):
    for _ in range(runs):
        LaplacianSmoothing(iterations=2)(mesh)
    gc.collect()
    return int(open("/proc/self/statm").read().split()[1]) * os.sysconf("SC_PAGE_SIZE") >> 20

memory(1)
if child := os.fork():
    raise SystemExit(os.waitpid(child, 0)[1])
measured = [memory(5) for _ in range(8)]
helpers = sum(thread.name.startswith("vtksmooth") for thread in threading.enumerate())
print(min(measured[4:]) - max(measured[:4]), helpers, flush=True)
os._exit(0)
"""

#: VTK up to 9.5 ended the process after one to ten runs, when views of its memory were handed back to it.
AGAIN = """
from vtksmooth import InstallationSpaceSmoothing, samples
for _ in range(20):
    InstallationSpaceSmoothing()(*samples.channel())
print("twenty")
"""


def run(*arguments: object) -> str:
    command = [sys.executable, *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize("way", [*multiprocessing.get_all_start_methods(), "joblib", "dask"])
def test_workers_give_the_same_points(way: str, tmp_path: Path) -> None:
    if way in ("joblib", "dask"):
        pytest.importorskip(way)
    program = tmp_path / "program.py"
    program.write_text(POOL, encoding="utf-8")
    assert run(program, way) == "the same\n"


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="memory is read from /proc")
def test_a_forked_child_has_threads_of_its_own_and_keeps_no_arrays() -> None:
    grown, threads = map(int, run("-c", FORKED).split())
    assert grown < 100  # 700 where tasks, and with them arrays, wait for threads that do not exist
    assert threads == 2


def test_twenty_runs_in_an_installation_space_end_well() -> None:
    assert run("-c", AGAIN) == "twenty\n"
