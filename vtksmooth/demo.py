"""The demo: Trapezium Drawing on real meshes, with the paper's tables and a picture of before and after."""

from __future__ import annotations

import json
import os
import shlex
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pyvista as pv
from pyvista import examples

from .errors import MeshFileError
from .files import read_surface, write_surface
from .filters import SurfaceComparison, SurfaceQuality, TrapeziumDrawing
from .kernels.compiled import on_compile
from .kernels.quality import BINS

PASSES = (1, 5)
SUMMARY = "summary.json"

#: Deviation, as a fraction of the diagonal, that one sees in the picture.
_CONSPICUOUS = 0.005

_BIN_NAMES = ["k < 0", *(f"{low:g} <= k < {low + 0.2:.1f}" for low in BINS[:-1]), "0.8 <= k <= 1"]
_NO_PICTURES = (
    "No pictures: drawing without a window does not work here (on Debian and Ubuntu it needs the packages "
    "libegl1 and libgl1)."
)


def run(output: Path, quiet: bool = False, meshes: Sequence[Path] = ()) -> None:
    """Smooth meshes and show what that did.

    Writes for each mesh ``NAME_before.vtp`` and ``NAME_after.vtp`` (five passes) with the measures as
    arrays, and ``NAME.png``; for all of them ``summary.md`` and ``summary.json``. Without a way to draw
    off-screen there are no pictures, and that is said.

    Parameters
    ----------
    output : Path
        Folder for the results; made when missing.
    quiet : bool
        Print nothing.
    meshes : sequence of Path
        Files of surface meshes. When there are none: PyVista's airplane and ant, and a piece of its
        voxel image of river channels.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     run(Path(folder), quiet=True, meshes=[Path(examples.antfile)])
    ...     (Path(folder) / "ant_after.vtp").exists()
    True
    """

    def say(text: str = "") -> None:
        if not quiet:
            print(text, flush=True)

    files = [Path(mesh) for mesh in meshes] or [Path(examples.planefile), Path(examples.antfile)]
    loaded = [(path, *read_surface(path)) for path in files]
    if not meshes:
        loaded.append((Path(examples.channelsfile), _channels(), [_CHANNELS]))
    try:
        output.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise MeshFileError(
            f"cannot make the folder {output}: {error.strerror}; name another with --output."
        ) from error
    results: list[dict[str, Any]] = []
    document = ["# Trapezium Drawing, before and after", ""]
    with _announced(say):
        for path, mesh, notes in loaded:
            result = _smoothed(_unused(path.stem, results), mesh, output)
            results.append(result | {"source": str(path)})
            text = [*_tables(result), "", *notes, _verdict(result), ""]
            document += [*text, f"![{result['name']}: before, after, histogram]({result['name']}.png)", ""]
            say("\n".join(text))
    (output / SUMMARY).write_text(json.dumps({"meshes": results}, indent=2) + "\n", encoding="utf-8")
    say("Drawing the pictures ...")
    problem = _draw_apart(output)
    if problem:
        say(problem)
        document = [line for line in document if not line.startswith("![")] + [problem, ""]
    (output / "summary.md").write_text("\n".join(document), encoding="utf-8")
    say(f"Results are in {output.resolve()}:")
    endings = ["_before.vtp", "_after.vtp", *([] if problem else [".png"])]
    for result in results:
        say("  " + "  ".join(result["name"] + ending for ending in endings))
    say(f"  summary.md  {SUMMARY}")
    say("\nNext, with a mesh of yours (.vtp .vtk .ply .stl .obj .off):")
    command = _command()
    say(f"  {command} demo MESH")
    say(f"  {command} trapezium-drawing MESH RESULT.vtp --iterations 5 --max-deviation-fraction 0.001")
    say(f"  {command} compare MESH RESULT.vtp")


_CHANNELS = (
    "channels.vti is a voxel image; the mesh is made of a part of it by flying edges (marching cubes)."
)


def _channels() -> pv.PolyData:
    """Make the surface of some river channels as one does: mask, blur, every other sample, contour.

    The part ends below the channels' flat tops, whose triangles would be regular.
    """
    image = pv.read(examples.channelsfile).extract_subset([0, 90, 170, 250, 53, 72]).cells_to_points()
    image["facies"] = (image["facies"] > 0).astype(np.float32)
    image = image.gaussian_smooth(std_dev=2.0)
    image = image.extract_subset(image.extent, rate=(2, 2, 2))
    surface = image.contour([0.5], method="flying_edges").connectivity("largest")
    surface.clear_data()
    return surface


@contextmanager
def _announced(say: Callable[[str], None]) -> Iterator[None]:
    """Tell the user, once, why the compiler makes them wait."""
    told = False

    def tell(kernel: str) -> None:
        nonlocal told
        if not told:
            say("Compiling the kernels; this happens once per installation and takes some seconds ...\n")
        told = True

    with on_compile(tell):
        yield


def _command() -> str:
    """Return what to type for ``vtksmooth``: the bare word only where the shell finds it."""
    beside = Path(sys.executable).with_name("vtksmooth")
    return "vtksmooth" if shutil.which("vtksmooth") else shlex.quote(str(beside))


def _unused(stem: str, results: list[dict[str, Any]]) -> str:
    names = {result["name"] for result in results}
    candidates = [stem, *(f"{stem}-{i}" for i in range(2, len(names) + 2))]
    return next(name for name in candidates if name not in names)


def _smoothed(name: str, mesh: pv.PolyData, output: Path) -> dict[str, Any]:
    """Smooth from the original for each number of passes; return and write all that was measured."""
    quality = SurfaceQuality()
    before = quality(mesh)
    result: dict[str, Any] = {"name": name, "before": quality.summary, "passes": {}}
    after = before
    for passes in PASSES:
        comparison = SurfaceComparison()
        after = comparison(TrapeziumDrawing(iterations=passes)(mesh), mesh)
        result["passes"][str(passes)] = comparison.summary
    write_surface(before, output / f"{name}_before.vtp")
    write_surface(after, output / f"{name}_after.vtp")
    return result


# -- words -----------------------------------------------------------------------------------------


def _tables(result: dict[str, Any]) -> list[str]:
    """Return the paper's two tables (its 1 and 2, say) in Markdown, which a terminal can show as well."""
    before, passes = result["before"], list(result["passes"].values())
    cells = before["cells"]
    kinds = [f"{count} {kind}s" for kind, count in cells.items() if count]
    title = f"{result['name']}: {before['points']} points, {', '.join(kinds)}, "
    title += "closed" if before["closed"] else "open"
    ratios = [state["aspect_ratio"] for state in (before, *passes)]
    heads = ["before", "1st pass", "5th pass"]
    quality = [
        *(
            [f"{name}, % of the faces", *(f"{ratio['histogram'][i]:.2f}" for ratio in ratios)]
            for i, name in enumerate(_BIN_NAMES)
        ),
        ["mean k", *(f"{ratio['mean']:.3f}" for ratio in ratios)],
        ["smallest k", *(f"{ratio['min']:.4f}" for ratio in ratios)],
    ]

    def row(name: str, key: str, part: str, factor: float = 1.0) -> list[str]:
        return [name, *(f"{factor * state[key][part]:.3f}" for state in passes)]

    volumes = [state["volume_change_percent"] for state in passes]
    change = [
        row("dihedral angles, largest change, degrees", "dihedral_change", "max"),
        row("dihedral angles, mean change, degrees", "dihedral_change", "mean"),
        row("vertex normals, largest change, degrees", "normal_deviation", "max"),
        row("vertex normals, mean change, degrees", "normal_deviation", "mean"),
        ["volume, change in %", *("open" if volume is None else f"{volume:+.3f}" for volume in volumes)],
        row("largest deviation, % of the diagonal", "deviation", "max_relative", 100.0),
    ]
    return [
        f"## {title}",
        "",
        *_table(["signed aspect ratio k (1 is best)", *heads], quality),
        "",
        *_table(["difference from the original", *heads[1:]], change),
    ]


def _table(head: list[str], rows: list[list[str]]) -> list[str]:
    widths = [max(len(row[i]) for row in (head, *rows)) for i in range(len(head))]

    def line(cells: list[str]) -> str:
        padded = [cells[0].ljust(widths[0])]
        padded += [cell.rjust(width) for cell, width in zip(cells[1:], widths[1:], strict=True)]
        return f"| {' | '.join(padded)} |"

    rule = ["-" * widths[0], *("-" * (width - 1) + ":" for width in widths[1:])]
    return [line(head), line(rule), *map(line, rows)]


def _verdict(result: dict[str, Any]) -> str:
    """Say what got better and what did not, from the figures alone."""
    before = result["before"]["aspect_ratio"]
    last = result["passes"][str(PASSES[-1])]
    after = last["aspect_ratio"]
    poor, still_poor = sum(before["histogram"][:2]), sum(after["histogram"][:2])

    def compared(name: str, old: float, new: float, digits: int) -> str:
        a, b = f"{old:.{digits}f}", f"{new:.{digits}f}"
        if a == b:
            return f"{name} stayed at {a}"
        return f"{name} {'rose' if new > old else 'fell'} from {a} to {b}"

    sentences = [
        compared("the share of poor faces (k < 0.2)", poor, still_poor, 1) + " %",
        compared("the mean k", before["mean"], after["mean"], 3),
        compared("the smallest k", before["min"], after["min"], 3),
        f"the surface deviates by at most {100 * last['deviation']['max_relative']:.2g} % of the diagonal",
    ]
    text = f"After {PASSES[-1]} passes {'; '.join(sentences)}."
    if after["mean"] <= before["mean"] and still_poor < poor:
        text += (
            " A vertex moves only if the worst face round it improves, so the poor faces become fewer while"
            " the mean hardly changes."
        )
    if last["deviation"]["max_relative"] > _CONSPICUOUS:
        text += (
            " Sharp tips and edges are not held: pin their points by a point array (--fixed), or bound the"
            " motion (--max-deviation-fraction)."
        )
    return text


# -- pictures --------------------------------------------------------------------------------------


def _draw_apart(folder: Path) -> str:
    """Draw in a process of its own; return what went wrong.

    Without a usable OpenGL, VTK may end the process with a segmentation fault.
    """
    environment = dict(os.environ)
    if sys.platform == "linux" and not environment.get("DISPLAY"):
        # VTK looks for an X server first and complains when there is none.
        environment.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")
    done = subprocess.run(
        [sys.executable, "-P", "-m", "vtksmooth.demo", str(folder)],
        env=environment, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False,
    )  # fmt: skip
    if done.returncode == 0:
        return ""
    if done.returncode < 0:
        return _NO_PICTURES
    return f"No pictures: {(done.stderr.strip().splitlines() or ['drawing failed'])[-1]}"


def draw(folder: Path) -> None:
    """Draw ``NAME.png`` for each mesh of the summary in `folder`."""
    for result in json.loads((folder / SUMMARY).read_text(encoding="utf-8"))["meshes"]:
        _draw(result, folder)


#: One colour for each of the papers' bins, dark for poor (matplotlib's magma); inverted faces stand out.
_COLOURS = ("#3b0f70", "#8c2981", "#de4968", "#fe9f6d", "#fcfdbf")
_INVERTED = "#00c8c8"

#: Above this many faces, edges would cover the colours.
_FACES_WITH_EDGES = 20_000


def _draw(result: dict[str, Any], folder: Path) -> None:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import BoundaryNorm, ListedColormap
    from matplotlib.figure import Figure

    name, last = result["name"], PASSES[-1]
    colours = ListedColormap(list(_COLOURS)).with_extremes(under=_INVERTED)
    states = [pv.read(folder / f"{name}_{state}.vtp") for state in ("before", "after")]
    camera = _camera(states[0])
    figure = Figure(figsize=(13.5, 5.4), layout="constrained", dpi=110)
    FigureCanvasAgg(figure)
    *views, bars = figure.subplots(1, 3, width_ratios=[1.25, 1.25, 1.0])
    for axes, state, title in zip(views, states, ("before", f"after {last} passes"), strict=True):
        axes.imshow(_render(state, camera, colours))
        axes.set_title(f"{name}, {title}")
        axes.axis("off")
    figure.colorbar(
        ScalarMappable(BoundaryNorm([*BINS, 1.0], len(_COLOURS)), colours),
        ax=views, location="bottom", shrink=0.6, aspect=40, extend="min", extendfrac=0.1,
        label="signed aspect ratio k (1: equilateral; below 0: inverted)",
    )  # fmt: skip
    passes = result["passes"]
    histograms = {"before": result["before"]} | {f"pass {count}": passes[str(count)] for count in PASSES}
    places = np.arange(len(_BIN_NAMES))
    for i, (label, state) in enumerate(histograms.items()):
        shade = ("#bbbbbb", "#6baed6", "#08519c")[i]
        bars.bar(places + 0.27 * (i - 1), state["aspect_ratio"]["histogram"], 0.27, label=label, color=shade)
    bars.set_xticks(places, ["< 0", *(f"{low:g}-{low + 0.2:.1f}" for low in BINS)])
    bars.set_xlabel("k")
    bars.set_ylabel("% of the faces")
    bars.set_title("histogram")
    bars.legend(frameon=False)
    bars.spines[["top", "right"]].set_visible(False)
    figure.savefig(folder / f"{name}.png")


def _camera(mesh: pv.PolyData) -> dict[str, Any]:
    """Look obliquely at the mesh's broad side, so that it fills the frame."""
    points = np.asarray(mesh.points, dtype=float)
    centred = points - points.mean(axis=0)
    right, up, towards = np.linalg.eigh(centred.T @ centred)[1].T[::-1]
    if towards[np.abs(towards).argmax()] < 0:
        towards = -towards
    tilt = np.radians(35.0)
    towards, up = (
        np.cos(tilt) * towards - np.sin(tilt) * up,
        np.cos(tilt) * up + np.sin(tilt) * towards,
    )
    right = np.cross(up, towards)
    frame = points @ np.stack((right, up, towards)).T
    low, high = frame.min(axis=0), frame.max(axis=0)
    centre = np.stack((right, up, towards)).T @ ((low + high) / 2)
    width, height, depth = 1.04 * np.maximum(high - low, 1e-3 * (high - low).max())
    return {
        "position": centre + towards * (depth + width + height),
        "focal_point": centre,
        "up": up,
        "width": width,
        "height": height,
    }


def _render(mesh: pv.PolyData, camera: dict[str, Any], colours: Any) -> np.ndarray:
    width, height = camera["width"], camera["height"]
    size = 1200 / max(width, height)
    plotter = pv.Plotter(
        off_screen=True, window_size=[max(int(size * width), 300), max(int(size * height), 300)]
    )
    plotter.add_mesh(
        mesh, scalars="AspectRatio", preference="cell", cmap=list(_COLOURS), clim=(0.0, 1.0),
        below_color=_INVERTED, show_scalar_bar=False, ambient=0.65, diffuse=0.4, specular=0.0,
        show_edges=mesh.n_cells <= _FACES_WITH_EDGES, edge_color="#202020", line_width=1.5,
    )  # fmt: skip
    plotter.enable_parallel_projection()
    view = plotter.camera
    view.position, view.focal_point, view.up = camera["position"], camera["focal_point"], camera["up"]
    view.parallel_scale = height / 2
    plotter.reset_camera_clipping_range()
    plotter.enable_anti_aliasing("ssaa")
    image = plotter.screenshot(None, return_img=True)
    plotter.close()
    return np.asarray(image)


if __name__ == "__main__":
    draw(Path(sys.argv[1]))
