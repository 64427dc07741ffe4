"""The benchmark: our filters beside those people use today, in the same run.

python benchmarks/speed.py [--sizes 10k,160k,1M,4M] [--data FOLDER] [--output docs/benchmark.md]

Every case runs in a process of its own. Run it on an idle machine.
"""

from __future__ import annotations

import argparse
import datetime
import itertools
import json
import os
import platform
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

sys.path.insert(0, str(Path(__file__).parent))

import peers

Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]

#: Standard deviation of the spheres' coordinates before they are put back on the sphere, in mean edges.
NOISE = 0.2

#: A long run should take this much longer than a short one, seconds.
_LONG = 0.3

#: These converge: the long run must not be long.
_GATED = ("TD", "smart Laplacian", "BDS")

#: Iterations tried for the time to a quality.
_LADDER = (1, 2, 3, 5, 8, 12, 20, 35, 60, 100)
QUALITY, SHARE = 0.6, 95.0

#: How vertices are numbered.
ORDERS = ("in order", "shuffled")

#: Largest deviation allowed on the way to the quality, part of the diagonal.
BOUNDS = {"sphere": 0.0001, "real": 0.001}


# -- in the process of a case ----------------------------------------------------------------------


def _status(field: str) -> int:
    # Bytes; VmRSS now, VmHWM the highest since the process began or since the mark was reset.
    for line in Path("/proc/self/status").read_text(encoding="ascii").splitlines():
        if line.startswith(field):
            return 1024 * int(line.split()[1])
    raise OSError(f"/proc/self/status has no {field}")


def _load(path: str) -> tuple[Float64, Int32]:
    with np.load(path) as arrays:
        return arrays["points"], arrays["faces"]


def _seconds(case: peers.Case, iterations: int) -> tuple[float, Any]:
    native = case.fresh()
    began = time.perf_counter()
    result = case.run(native, iterations)
    return time.perf_counter() - began, result


def _warm(make: Callable[[Float64, Int32], peers.Case]) -> None:
    # Imports, compilers and pools of threads, on a mesh that is too small to matter.
    import shapes

    mesh = shapes.sphere(800, NOISE)
    case = make(np.asarray(mesh.points), mesh.regular_faces.astype(np.int32))
    for iterations in (1, 2):
        _seconds(case, iterations)


def speed_case(tool: str, paths: dict[str, str], repeats: int) -> dict[str, Any]:
    """Time per vertex and iteration for each order of vertices; set-up and memory for the first."""
    make = peers.TOOLS[tool].make
    _warm(make)
    result: dict[str, Any] = {}
    for order, path in paths.items():
        points, faces = _load(path)
        n = len(points)
        case = make(points, faces)
        native = case.fresh()
        memory = _peak(case, native)
        if not result:
            result = {"vertices": n, "memory": memory / n - case.output_bytes}
        del native
        more, short, long = _enough(tool, case, n)
        rates, setups = [], []
        for repeat in range(repeats):
            if repeat:
                short = _seconds(case, 1)[0]
                long = _seconds(case, 1 + more)[0]
            done = (case.iterations_done or 1 + more) - 1
            each = (long - short) / max(done, 1)
            rates.append(1e9 * each / n)
            setups.append(short - each)
        result[order] = (float(np.median(rates)), float(np.min(rates)))
        result.setdefault("setup", max(0.0, float(np.median(setups))))
    return result


def _enough(tool: str, case: peers.Case, vertices: int) -> tuple[int, float, float]:
    """Return after how many iterations more a run takes clearly longer than its set-up varies.

    And the times of a short and of such a long run. Not too many: gates converge.
    """
    most = 200 if tool not in _GATED else 20 if vertices < 1_000_000 else 5
    _seconds(case, 1)
    short = _seconds(case, 1)[0]
    more = 5
    while True:
        long = _seconds(case, 1 + more)[0]
        if more == most or long - short > max(_LONG, 0.7 * short):
            return more, short, long
        more = min(4 * more, most)


def _peak(case: peers.Case, native: Any) -> int:
    # Bytes over what is there before a run of one iteration.
    baseline = _status("VmRSS")
    try:
        Path("/proc/self/clear_refs").write_text("5", encoding="ascii")
    except OSError:  # the mark cannot be reset everywhere; then only what exceeds it is seen
        baseline = max(baseline, _status("VmHWM"))
    result = case.run(native, 1)
    peak = _status("VmHWM")
    del result
    return peak - baseline


def quality_case(tool: str, path: str, bound: float) -> dict[str, Any]:
    """Least time in which a run from the start reaches the quality within the bound."""
    from vtksmooth.kernels.distance.closest_point import ClosestPoint
    from vtksmooth.kernels.measures import aspect_ratio
    from vtksmooth.kernels.mesh.mesh import Mesh

    make = peers.TOOLS[tool].make
    _warm(make)
    points, faces = _load(path)
    offsets = 3 * np.arange(len(faces) + 1, dtype=np.int32)
    mesh = Mesh.from_arrays(points, offsets, faces.ravel())
    directions = aspect_ratio.reference_directions(mesh)
    surface, diagonal = ClosestPoint(mesh), mesh.diagonal
    case = make(points, faces)
    start = aspect_ratio.aspect_ratios(mesh, directions)
    best = (100.0 * float((start >= QUALITY).mean()), 0)
    strikes = 0
    for iterations in _LADDER:
        seconds, result = _seconds(case, iterations)
        after = case.points(result)
        good = 100.0 * float(
            (aspect_ratio.aspect_ratios(mesh.with_points(after), directions) >= QUALITY).mean()
        )
        deviation = float(surface.query(after)[1].max()) / diagonal
        if deviation > bound:
            # Windowed sinc is far off after a single iteration and near again after two.
            strikes += 1
            if strikes == 3:
                break
            continue
        best = max(best, (good, iterations))
        if good >= SHARE:
            seconds = min(seconds, _seconds(case, iterations)[0])
            return {"reached": True, "seconds": seconds, "iterations": iterations, "deviation": deviation}
    why = "deviation" if strikes else "quality"
    return {"reached": False, "share": best[0], "iterations": best[1], "why": why}


def ratio_case(path: str, repeats: int) -> dict[str, Any]:
    """Pairs that are compared with each other, run by turns in one process."""
    from vtkmodules.vtkCommonDataModel import vtkPolyData

    from vtksmooth.kernels.mesh import adjacency
    from vtksmooth.kernels.mesh.mesh import Mesh

    points, faces = _load(path)
    n = len(points)
    result: dict[str, Any] = {"vertices": n}
    for name, pair in {
        "td": ("TD", "vtkSmoothPolyDataFilter"),
        "umbrella": ("umbrella", "MeshLib relax"),
    }.items():
        try:
            for tool in pair:
                _warm(peers.TOOLS[tool].make)
            cases = [peers.TOOLS[tool].make(points, faces) for tool in pair]
        except ImportError:
            continue
        rates: list[list[float]] = [[], []]
        whole: list[list[float]] = [[], []]
        counts = [_enough(tool, case, n)[0] for tool, case in zip(pair, cases, strict=True)]
        for _ in range(repeats):
            for case, more, rate, all_in in zip(cases, counts, rates, whole, strict=True):
                # The other tool had the caches and the allocator: the first run after it is not counted.
                _seconds(case, 1)
                short, ten, long = (_seconds(case, count)[0] for count in (1, 10, 1 + more))
                done = case.iterations_done or 1 + more
                rate.append(1e9 * (long - short) / max(done - 1, 1) / n)
                all_in.append(1e9 * ten / 10 / n)
        result[name] = [float(np.median(rate)) for rate in rates]
        result[f"{name} in all"] = [float(np.median(rate)) for rate in whole]
        if name == "umbrella":
            result["pass"] = result[name][0] * n / 1e9
    polydata = peers.VtkSmooth(points, faces).native
    mesh = Mesh.from_arrays(points, 3 * np.arange(len(faces) + 1, dtype=np.int32), faces.ravel())
    times: dict[str, list[float]] = {"build": [], "links": []}
    for _ in range(max(repeats, 2) + 1):
        began = time.perf_counter()
        adjacency.build(mesh)
        times["build"].append(time.perf_counter() - began)
        # Another vtkPolyData, so that nothing is left from before.
        plain = vtkPolyData()
        plain.SetPoints(polydata.GetPoints())
        plain.SetPolys(polydata.GetPolys())
        began = time.perf_counter()
        plain.BuildLinks()
        times["links"].append(time.perf_counter() - began)
    return result | {name: float(np.median(values[1:])) for name, values in times.items()}


def start_case(path: str) -> dict[str, Any]:
    """Time what a fresh process waits for."""
    began = time.perf_counter()
    import pyvista as pv

    after_pyvista = time.perf_counter()
    import vtksmooth

    after_package = time.perf_counter()
    smoothing = vtksmooth.TrapeziumDrawing(iterations=5)
    points, faces = _load(path)
    mesh = pv.PolyData.from_regular_faces(points, faces)
    times = [after_pyvista - began, after_package - after_pyvista]
    for _ in range(2):
        began = time.perf_counter()
        smoothing.Modified()
        smoothing(mesh)
        times.append(time.perf_counter() - began)
    return dict(zip(("pyvista", "vtksmooth", "first", "second"), times, strict=True))


_CASES: dict[str, Callable[..., dict[str, Any]]] = {
    "speed": speed_case,
    "quality": quality_case,
    "ratio": ratio_case,
    "start": start_case,
}


# -- running cases ---------------------------------------------------------------------------------


class Runner:
    """Runs cases in processes of their own, within the time there is.

    Parameters
    ----------
    timeout : float
        Seconds for one case.
    budget : float
        Seconds for everything; what does not fit is not run, and that is said.
    """

    NO_TIME = "no time left"

    def __init__(self, timeout: float, budget: float) -> None:
        self.timeout, self.end = timeout, time.monotonic() + budget

    def __call__(self, kind: str, threads: int, **arguments: Any) -> dict[str, Any]:
        """Return what the case returns, or ``{"failed": why}``."""
        left = self.end - time.monotonic()
        if left < 1.0:
            return {"failed": self.NO_TIME}
        environment = os.environ | {"VTKSMOOTH_THREADS": str(threads), "OMP_NUM_THREADS": str(threads)}
        processors = sorted(os.sched_getaffinity(0))[:threads]
        command = [
            sys.executable, str(Path(__file__).resolve()),
            "--case", json.dumps({"kind": kind, "processors": processors, **arguments}),
        ]  # fmt: skip
        print(f"{left:.0f} s left: {kind} {arguments.get('tool', '')} {threads}", file=sys.stderr, flush=True)
        try:
            done = subprocess.run(
                command, env=environment, capture_output=True, text=True, check=False,
                timeout=min(self.timeout, left),
            )  # fmt: skip
        except subprocess.TimeoutExpired:
            return {"failed": f"over {self.timeout:.0f} s" if left > self.timeout else self.NO_TIME}
        if done.returncode != 0:
            lines = done.stderr.strip().splitlines() or [f"ended with {done.returncode}"]
            print("\n".join(lines[-5:]), file=sys.stderr)
            known = {"ModuleNotFoundError": "not installed", "ImportError": "cannot be loaded"}
            return {"failed": known.get(lines[-1].split(":")[0], "failed")}
        result: dict[str, Any] = json.loads(done.stdout.strip().splitlines()[-1])
        return result


def _in_case(text: str) -> None:
    arguments = json.loads(text)
    kind = arguments.pop("kind")
    # Before anything counts processors.
    os.sched_setaffinity(0, arguments.pop("processors"))
    print(json.dumps(_CASES[kind](**arguments)))


# -- the page --------------------------------------------------------------------------------------


def machine() -> str:
    """Describe the machine in words."""
    text = Path("/proc/cpuinfo").read_text(encoding="utf-8")
    match = re.search(r"model name\s*:\s*(.+)", text)
    name = match[1].strip() if match else platform.machine()
    cores = len(os.sched_getaffinity(0))
    words = {1: "one core", 2: "two cores", 4: "four cores", 8: "eight cores"}
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30
    load = os.getloadavg()[0]
    return (
        f"{words.get(cores, f'{cores} cores')} of an {name}, {memory:.0f} GB of memory, "
        f"{platform.system()}; load average at the start {load:.1f}"
    )


def versions() -> str:
    """Name the versions of everything that is compared."""
    found = [f"Python {platform.python_version()}"]
    packages = ["vtksmooth", "numpy", "numba", "vtk", "pyvista", "meshlib", "pymeshlab", "mmgpy"]
    packages += ["trimesh", "open3d"]
    for package in packages:
        try:
            found.append(f"{package} {metadata.version(package)}")
        except metadata.PackageNotFoundError:
            found.append(f"{package} not installed" if package != "vtksmooth" else "vtksmooth (source tree)")
    return ", ".join(found)


def sizes_of(text: str) -> dict[str, int]:
    """Read ``10k,160k,1M`` as numbers of triangles by their names."""
    factors = {"k": 1_000, "M": 1_000_000}
    return {
        name: int(float(name[:-1]) * factors[name[-1]]) if name[-1] in factors else int(name)
        for name in text.split(",")
    }


def _write_mesh(path: Path, mesh: Any) -> str:
    np.savez(path, points=np.asarray(mesh.points, dtype=float), faces=mesh.regular_faces.astype(np.int32))
    return str(path)


def _threads(tool: peers.Tool, triangles: int, all_threads: int) -> list[int]:
    """Return the numbers of threads that are worth their time at this size."""
    counts = sorted({1, all_threads}) if tool.threads else [1]
    return counts if tool.prime or triangles <= 500_000 else counts[-1:]


def _extent(
    tool: peers.Tool, triangles: int, threads: int, all_threads: int, repeats: int
) -> tuple[Sequence[str], int]:
    """Return the orders of vertices and the repeats that are worth their time."""
    if triangles <= 500_000:
        return ORDERS, repeats
    if not tool.prime:
        return ORDERS[:1], 1
    if triangles <= 2_000_000:
        return ORDERS, min(repeats, 2)
    return (ORDERS if threads == all_threads or not tool.threads else ORDERS[:1]), 1


def _speeds(
    run: Runner, sizes: dict[str, int], folder: Path, repeats: int, labels: Sequence[str]
) -> dict[tuple[str, str, int], dict[str, Any]]:
    """Run all speed cases, those that matter most first; return them by size, tool and threads."""
    all_threads = len(os.sched_getaffinity(0))
    results: dict[tuple[str, str, int], dict[str, Any]] = {}
    hopeless: set[str] = set()
    for prime in (True, False):
        for name, triangles in sizes.items():
            for label in labels:
                tool = peers.TOOLS[label]
                if tool.prime != prime or label in hopeless:
                    continue
                for threads in _threads(tool, triangles, all_threads):
                    orders, few = _extent(tool, triangles, threads, all_threads, repeats)
                    paths = {order: str(folder / f"{name}-{order}.npz") for order in orders}
                    result = run("speed", threads, tool=label, paths=paths, repeats=few)
                    results[name, label, threads] = result
                    if result.get("failed") not in (None, "failed", Runner.NO_TIME):
                        # Missing, or too slow: larger meshes will not help.
                        hopeless.add(label)
                        for larger in list(sizes)[list(sizes).index(name) :]:
                            for count in (1, all_threads):
                                results.setdefault((larger, label, count), result)
                        break
    return results


def _speed_section(
    results: dict[tuple[str, str, int], dict[str, Any]], sizes: Sequence[str], labels: Sequence[str]
) -> list[str]:
    import tables

    all_threads = len(os.sched_getaffinity(0))
    counts = sorted({1, all_threads})
    lines: list[str] = []
    for name in sizes:
        rows = []
        for label in labels:
            row = [label]
            for order in ORDERS:
                for threads in counts:
                    result = results.get((name, label, threads), {})
                    row.append(str(result.get("failed", "")))
                    if order in result:
                        median, least = result[order]
                        # Set-up varied by more than the iterations took.
                        row[-1] = f"{median:.1f} ({least:.1f})" if least > 0 else "not resolved"
            most = results.get((name, label, all_threads)) or results.get((name, label, 1), {})
            row += [f"{most['setup']:.3f}", f"{most['memory']:.0f}"] if "setup" in most else ["", ""]
            rows.append(row)
        words = [f"{count} thread{'s' if count > 1 else ''}" for count in counts]
        head = [f"{name} triangles", *(f"{order}, {word}" for order in ORDERS for word in words)]
        head += ["set-up, s", "memory, bytes/vertex"]
        vertices = max((r.get("vertices", 0) for key, r in results.items() if key[0] == name), default=0)
        lines += [f"### {name} triangles, {vertices:,} vertices", "", *tables.table(head, rows)]
    return lines


def _quality_section(
    run: Runner, meshes: Sequence[tuple[str, str, float]], labels: Sequence[str]
) -> list[str]:
    import tables

    threads = len(os.sched_getaffinity(0))
    rows = []
    for label in labels:
        row = [label]
        for _, path, bound in meshes:
            result = run("quality", threads, tool=label, path=path, bound=bound)
            if "failed" in result:
                row.append(result["failed"])
            elif result["reached"]:
                row.append(f"{result['seconds']:.3f} s, {result['iterations']} iterations")
            else:
                why = "too far off" if result["why"] == "deviation" else "not better"
                row.append(f"never: {result['share']:.1f} % after {result['iterations']}, then {why}")
        rows.append(row)
    return tables.table(["time to the quality", *(name for name, _, _ in meshes)], rows)


def _ratio(pair: Sequence[float], digits: int = 0) -> str:
    if min(pair) <= 0.0:
        return "not resolved"
    return f"{pair[0]:.{digits}f} : {pair[1]:.{digits}f} = {pair[0] / pair[1]:.2f}"


def _ratio_section(run: Runner, sizes: dict[str, int], folder: Path, repeats: int) -> list[str]:
    import tables

    threads = len(os.sched_getaffinity(0))
    rows = []
    for size, order in itertools.product(sizes, ORDERS):
        if sizes[size] > 2_000_000 and order != ORDERS[0]:
            continue  # that took more than four minutes
        name, path = f"{size}, {order}", str(folder / f"{size}-{order}.npz")
        # Large meshes once, with all threads: set-up dominates there.
        large = sizes[size] > 500_000
        for count in [threads] if large else sorted({1, threads}):
            r = run("ratio", count, path=path, repeats=1 if large else repeats)
            if "failed" in r:
                rows.append([name, count, r["failed"], "", "", ""])
                continue
            allowed = r["links"] + r.get("pass", 0.0)
            rows.append([
                name, count, _ratio(r["td"]), _ratio(r["td in all"]),
                _ratio(r["umbrella"], 1) if "umbrella" in r else "not installed",
                _ratio([1e3 * r["build"], 1e3 * allowed], 1),
            ])  # fmt: skip
    head = [
        "mesh", "threads", "TD : vtkSmoothPolyDataFilter, ns", "the same with set-up, 10 iterations",
        "umbrella : MeshLib relax, ns", "neighbourhoods : BuildLinks + one umbrella pass, ms",
    ]  # fmt: skip
    return tables.table(head, rows)


def _start_section(run: Runner, path: str, repeats: int) -> list[str]:
    import tables

    threads = len(os.sched_getaffinity(0))
    results = [run("start", threads, path=path) for _ in range(max(3, repeats))]
    good = [result for result in results if "failed" not in result]
    if not good:
        return ["The fresh process failed.", ""]
    median = {key: float(np.median([result[key] for result in good])) for key in good[0]}
    rows = [
        ["import pyvista", f"{median['pyvista']:.2f}"],
        ["import vtksmooth after it", f"{median['vtksmooth']:.3f}"],
        ["first result, TD, 5 passes", f"{median['first']:.3f}"],
        ["second result", f"{median['second']:.3f}"],
        ["first - second", f"{median['first'] - median['second']:.3f}"],
    ]
    return tables.table(["fresh process, smallest mesh", "s"], rows)


def _real_mesh(data: Path | None) -> tuple[str, Any]:
    import pyvista as pv
    from pyvista import examples

    if data is not None and (data / "rocker-arm.obj").is_file():
        return "Rocker Arm (alecjacobson/common-3d-test-models)", pv.read(data / "rocker-arm.obj")
    return "PyVista's airplane", pv.read(examples.planefile)


def benchmark(
    sizes: dict[str, int],
    data: Path | None,
    run: Runner,
    repeats: int,
    labels: Sequence[str],
) -> str:
    """Run everything and return the page."""
    import shapes
    import tables  # noqa: F401 - fails early where matplotlib is missing

    began = time.monotonic()
    described = machine()
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        for name, triangles in sizes.items():
            for order in ORDERS:
                print(f"making {name} {order}", file=sys.stderr, flush=True)
                mesh = shapes.sphere(triangles, NOISE, shuffled=order == "shuffled")
                _write_mesh(folder / f"{name}-{order}.npz", mesh)
        names = list(sizes)
        middle = min(names, key=lambda name: abs(sizes[name] - 160_000))
        label, real = _real_mesh(data)
        real_path = _write_mesh(folder / "real.npz", real)
        targets = [
            (f"sphere, {middle}", str(folder / f"{middle}-{ORDERS[0]}.npz"), BOUNDS["sphere"]),
            (label, real_path, BOUNDS["real"]),
        ]
        start = _start_section(run, str(folder / f"{names[0]}-{ORDERS[0]}.npz"), repeats)
        ratios = _ratio_section(run, sizes, folder, repeats)
        reached = _quality_section(run, targets, labels)
        speeds = _speed_section(_speeds(run, sizes, folder, repeats, labels), names, labels)
    minutes = (time.monotonic() - began) / 60.0
    lines = [
        "# Benchmark",
        "",
        f"Made by `python benchmarks/speed.py` on {datetime.date.today():%B %Y}: {described}. "
        f"{versions()}. It took {minutes:.0f} minutes.",
        "",
        "How it is measured is in [benchmarks/README.md](../benchmarks/README.md).",
        "",
        "## Pairs, run by turns in one process",
        "",
        "Nanoseconds per vertex and iteration, and their ratio; milliseconds in the last column.",
        "",
        *ratios,
        "## Starting",
        "",
        *start,
        "## Time to a given quality",
        "",
        f"{SHARE:.0f} % of the faces with k >= {QUALITY}, while no point is farther from the original "
        f"surface than {100 * BOUNDS['sphere']:g} % of the diagonal (sphere) or {100 * BOUNDS['real']:g} % "
        f"({label}). All threads, set-up included, best of two runs. *Never* says how many faces had the "
        "quality after how many iterations, and what ended it: more iterations went too far off the "
        f"surface, or {_LADDER[-1]} of them were not enough.",
        "",
        *reached,
        "## Nanoseconds per vertex and iteration",
        "",
        "Median (least) of the repeats. Set-up and memory belong to vertices in order and all threads; "
        "memory is the peak of a run over its input and output. Empty: not run, because the tool has one "
        "thread only or the combination was left out at this size.",
        "",
        *speeds,
    ]
    return "\n".join(lines).rstrip() + "\n"


def main(arguments: Sequence[str] | None = None) -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description="Time our filters beside others.")
    given = os.environ.get("VTKSMOOTH_DATA")
    parser.add_argument("--sizes", default="10k,160k,1M,4M", help="triangles, separated by commas")
    parser.add_argument("--data", type=Path, default=Path(given) if given else None, help="folder of meshes")
    parser.add_argument("--output", type=Path, default=Path("docs/benchmark.md"))
    parser.add_argument("--timeout", type=float, default=60.0, help="seconds for one case")
    parser.add_argument("--budget", type=float, default=870.0, help="seconds for all cases")
    parser.add_argument("--repeats", type=int, default=3, help="pairs of a short and a long run")
    parser.add_argument("--tools", default="", help="only these, separated by commas")
    parser.add_argument("--case", help=argparse.SUPPRESS)
    options = parser.parse_args(arguments)
    if options.case:
        _in_case(options.case)
        return
    labels = [name for name in options.tools.split(",") if name] or list(peers.TOOLS)
    unknown = set(labels) - set(peers.TOOLS)
    if unknown:
        parser.error(f"no tool {', '.join(sorted(unknown))}; there are {', '.join(peers.TOOLS)}")
    runner = Runner(options.timeout, options.budget)
    page = benchmark(sizes_of(options.sizes), options.data, runner, options.repeats, labels)
    options.output.parent.mkdir(parents=True, exist_ok=True)
    options.output.write_text(page, encoding="utf-8")


if __name__ == "__main__":
    main()
