"""Markdown tables and pictures, for the evidence and the benchmark."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyvista as pv
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure

from vtksmooth.kernels.measures.aspect_ratio import BINS

BIN_NAMES = ["k < 0", *(f"{low:.1f} <= k < {low + 0.2:.1f}" for low in BINS[:-1]), "0.8 <= k <= 1.0"]

#: One colour a bin, dark for poor; inverted faces stand out.
_COLOURS = ListedColormap(["#3b0f70", "#8c2981", "#de4968", "#fe9f6d", "#fcfdbf"]).with_extremes(
    under="#00c8c8"
)


def table(head: Sequence[str], rows: Sequence[Sequence[Any]]) -> list[str]:
    """Return a Markdown table and the empty line after it; columns after the first stand right."""
    lines = [head, ["---", *["---:"] * (len(head) - 1)], *rows]
    return ["| " + " | ".join(str(cell) for cell in line) + " |" for line in lines] + [""]


def number(value: float | None, digits: int = 3) -> str:
    """Return a number with `digits` significant digits, never in scientific notation; a dash for None."""
    if value is None:
        return "-"
    if abs(value) < 1e-9:
        return "0"
    decimals = max(0, digits - 1 - int(np.floor(np.log10(abs(value)))))
    return f"{value:.{decimals}f}"


def picture(
    meshes: Sequence[tuple[str, pv.PolyData]],
    path: Path,
    camera: Sequence[Sequence[float]] | str = "iso",
    zoom: float = 1.3,
    parallel: bool = True,
) -> None:
    """Draw meshes with their edges side by side, faces coloured by their cell array AspectRatio."""
    figure = Figure(figsize=(5.2 * len(meshes), 5.4), layout="constrained", dpi=100)
    FigureCanvasAgg(figure)
    views = np.atleast_1d(figure.subplots(1, len(meshes)))
    for view, (title, mesh) in zip(views, meshes, strict=True):
        plotter = pv.Plotter(off_screen=True, window_size=(900, 840))
        plotter.add_mesh(
            mesh, scalars="AspectRatio", cmap=_COLOURS, clim=(0.0, 1.0), show_scalar_bar=False,
            show_edges=True, line_width=0.6, edge_color="#303030", lighting=True, diffuse=0.35, ambient=0.7,
            below_color="#00c8c8",
        )  # fmt: skip
        plotter.camera_position = camera
        if parallel:
            plotter.enable_parallel_projection()
        plotter.camera.zoom(zoom)
        plotter.enable_anti_aliasing("ssaa")
        view.imshow(plotter.screenshot(None, return_img=True))
        plotter.close()
        view.set_title(title, fontsize=10)
        view.axis("off")
    figure.colorbar(
        ScalarMappable(BoundaryNorm([*BINS, 1.0], 5), _COLOURS), ax=list(views),
        location="bottom", shrink=0.5, aspect=40, extend="min", extendfrac=0.1,
        label="signed aspect ratio k (below 0: inverted)",
    )  # fmt: skip
    save(figure, path)


def save(figure: Figure, path: Path) -> None:
    """Write a figure as a small PNG."""
    figure.canvas.draw()
    from PIL import Image

    image = Image.fromarray(np.asarray(figure.canvas.buffer_rgba())).convert("RGB")  # type: ignore[attr-defined]
    path.parent.mkdir(parents=True, exist_ok=True)
    # Without this method rare colours vanish: those of inverted faces.
    image.quantize(128, method=Image.Quantize.MAXCOVERAGE).save(path, optimize=True)
