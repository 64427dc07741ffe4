"""What a report shows, whatever its format."""

from __future__ import annotations

import itertools
import platform
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib.metadata import version
from typing import Any

from ..filters import SurfaceComparison, SurfaceQuality
from ..recipe import Recipe
from ..report import figure
from . import histogram, pictures, tables
from .measures import BeforeAfter

_PARTS = ("vtksmooth", "vtk", "pyvista", "numpy", "numba")


@dataclass(frozen=True)
class Table:
    """A table: what its columns are, and its rows; the first column has the names."""

    head: list[str]
    rows: tables.Rows


@dataclass(frozen=True)
class Page:
    """The content of a report.

    Attributes
    ----------
    title : str
    meshes : list of str
        What the meshes are, one sentence each.
    sentences : list of str
        What got better and what did not; what cannot be said.
    pictures : list of (str, bytes)
        Captions, and PNG files' contents.
    histograms : tuple of list of float
        The shares of :func:`~vtksmooth.pages.histogram.shares` before and after.
    quality, change : Table
    steps : list of (str, str, bool)
        Of each step of the recipe: the filter and its parameters, what it did, whether it is on.
    footer : str
        Date and versions.
    """

    title: str
    meshes: list[str]
    sentences: list[str]
    pictures: list[tuple[str, bytes]]
    histograms: tuple[list[float], list[float]]
    quality: Table
    change: Table
    steps: list[tuple[str, str, bool]]
    footer: str


def make_page(
    measured: BeforeAfter,
    names: tuple[str, str],
    recipe: Recipe | None = None,
    did: Sequence[str] = (),
) -> Page:
    """Collect what a report shows.

    Parameters
    ----------
    measured : BeforeAfter
        The meshes and their measures.
    names : tuple of str
        The names of the files before and after.
    recipe : Recipe, optional
        What made the result of the original.
    did : sequence of str
        What each of the recipe's steps did (see :func:`said`), if that is known.
    """
    before, after = measured.summaries
    sentences = tables.verdict(before, after)
    sentences = ["; ".join([sentences[0][0].upper() + sentences[0][1:], *sentences[1:]]) + "."]
    if not measured.same_faces:
        sentences.append(
            "The result has other points or faces than the original: normals and dihedral angles have no "
            "counterparts; the distances are those of the two surfaces."
        )
    drawn: list[tuple[str, bytes]] = []
    try:
        camera = pictures.camera_of(measured.meshes[0])
        made = pictures.draw([pictures.Picture(mesh, camera, 1000) for mesh in measured.meshes])
        drawn = list(zip(("before", "after"), made, strict=True))
    except pictures.NoPicturesError as error:
        sentences.append(f"There are no pictures: {error}.")
    shares = [histogram.shares(k) for k in measured.aspect_ratios]
    made_by = recipe.steps if recipe else ()
    done = itertools.chain(did, itertools.repeat(""))
    steps = [(str(step), words, step.enabled) for step, words in zip(made_by, done, strict=False)]
    return Page(
        names[0],
        [f"Before: {names[0]}, {tables.counted(before)}", f"After: {names[1]}, {tables.counted(after)}"],
        sentences,
        drawn,
        (shares[0], shares[1]),
        Table(["aspect ratio k (1 is best)", "before", "after"], tables.quality_rows([before, after])),
        Table(["difference from the original", "after"], tables.change_rows([after])),
        steps,
        _footer(),
    )


def said(algorithm: Any) -> str:
    """Say what a step did; what the page measures anyway is not said twice."""
    if isinstance(algorithm, SurfaceQuality | SurfaceComparison):
        return ""
    if hasattr(algorithm, "report"):
        return str(algorithm.report)
    figures = {name.replace("_", " "): value for name, value in algorithm.figures.items()}
    numbers = {name: figure(value, 6) for name, value in figures.items() if isinstance(value, int | float)}
    return ", ".join(f"{name}: {value}" for name, value in numbers.items())


def _footer() -> str:
    versions = [f"{name} {version(name)}" for name in _PARTS]
    versions.append(f"Python {platform.python_version()} on {platform.system()}")
    return f"{datetime.now(UTC):%Y-%m-%d %H:%M} UTC, {', '.join(versions)}"
