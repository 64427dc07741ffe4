"""The demo: Trapezium Drawing on real meshes, with the paper's tables and a picture of before and after."""

from __future__ import annotations

import io
import json
import shlex
import shutil
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pyvista as pv
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.image import imread
from pyvista import examples

from .files import make_folder, read_surface, write_surface
from .filters import SurfaceComparison, SurfaceQuality, TrapeziumDrawing
from .jit.compiled import on_compile
from .kernels.measures.aspect_ratio import BINS
from .pages import pictures, tables
from .pages.pictures import COLOURS, INVERTED, NoPicturesError, Picture, camera_of

PASSES = (1, 5)
SUMMARY = "summary.json"

#: Deviation, as a fraction of the diagonal, that one sees in the picture.
_CONSPICUOUS = 0.005


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
    make_folder(output)
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
    problem = _draw(results, output)
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
    quality = SurfaceQuality(usual_measures=False)
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
    heads = ["before", "1st pass", "5th pass"]
    quality = tables.quality_rows([before, *passes])
    return [
        f"## {result['name']}: {tables.counted(before)}",
        "",
        *tables.markdown(["signed aspect ratio k (1 is best)", *heads], quality),
        "",
        *tables.markdown(["difference from the original", *heads[1:]], tables.change_rows(passes)),
    ]


def _verdict(result: dict[str, Any]) -> str:
    """Say what got better and what did not, from the figures alone."""
    before, after = result["before"], result["passes"][str(PASSES[-1])]
    text = f"After {PASSES[-1]} passes {'; '.join(tables.verdict(before, after))}."
    if after["aspect_ratio"]["mean"] <= before["aspect_ratio"]["mean"] and tables.poor(after) < tables.poor(
        before
    ):
        text += (
            " A vertex moves only if the worst face round it improves, so the poor faces become fewer while"
            " the mean hardly changes."
        )
    if max(tables.largest_deviations(after)) > _CONSPICUOUS:
        text += (
            " Sharp tips and edges are not held: pin their points by a point array (--fixed), or bound the"
            " motion (--max-deviation-fraction)."
        )
    return text


# -- pictures --------------------------------------------------------------------------------------


def _draw(results: list[dict[str, Any]], folder: Path) -> str:
    """Draw ``NAME.png`` for each result; return what went wrong."""
    pairs = [
        [pv.read(folder / f"{result['name']}_{state}.vtp") for state in ("before", "after")]
        for result in results
    ]
    jobs = [Picture(mesh, camera_of(pair[0])) for pair in pairs for mesh in pair]
    try:
        images = [imread(io.BytesIO(png)) for png in pictures.draw(jobs)]
    except NoPicturesError as error:
        return f"No pictures: {error}."
    for i, result in enumerate(results):
        _compose(result, images[2 * i : 2 * i + 2], folder)
    return ""


def _compose(result: dict[str, Any], views: list[Any], folder: Path) -> None:
    """Write views of a mesh before and after, with a histogram, as one picture."""
    name, last = result["name"], PASSES[-1]
    colours = ListedColormap(list(COLOURS)).with_extremes(under=INVERTED)
    figure = Figure(figsize=(13.5, 5.4), layout="constrained", dpi=110)
    FigureCanvasAgg(figure)
    *places, bars = figure.subplots(1, 3, width_ratios=[1.25, 1.25, 1.0])
    for axes, view, title in zip(places, views, ("before", f"after {last} passes"), strict=True):
        axes.imshow(view)
        axes.set_title(f"{name}, {title}")
        axes.axis("off")
    figure.colorbar(
        ScalarMappable(BoundaryNorm([*BINS, 1.0], len(COLOURS)), colours),
        ax=places, location="bottom", shrink=0.6, aspect=40, extend="min", extendfrac=0.1,
        label="signed aspect ratio k (1: equilateral; below 0: inverted)",
    )  # fmt: skip
    passes = result["passes"]
    histograms = {"before": result["before"]} | {f"pass {count}": passes[str(count)] for count in PASSES}
    bins = np.arange(len(BINS) + 1)
    for i, (label, state) in enumerate(histograms.items()):
        shade = ("#bbbbbb", "#6baed6", "#08519c")[i]
        bars.bar(bins + 0.27 * (i - 1), state["aspect_ratio"]["histogram"], 0.27, label=label, color=shade)
    bars.set_xticks(bins, ["< 0", *(f"{low:g}-{low + 0.2:.1f}" for low in BINS)])
    bars.set_xlabel("k")
    bars.set_ylabel("% of the faces")
    bars.set_title("histogram")
    bars.legend(frameon=False)
    bars.spines[["top", "right"]].set_visible(False)
    figure.savefig(folder / f"{name}.png")
