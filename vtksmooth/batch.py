"""A recipe on many files: one that fails does not stop the rest, and no input is ever overwritten."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from .errors import Cancelled, MeshFileError, sentence
from .files import READABLE, WRITABLE, read_surface, write_surface
from .filters import Filter
from .pages import tables
from .pages.measures import BeforeAfter, measure
from .pages.page import make_page, said
from .pages.writing import write_page
from .recipe import Recipe, Result


@dataclass(frozen=True)
class Job:
    """A file to read, and the one to write."""

    source: Path
    target: Path


@dataclass
class Outcome:
    """What became of a job.

    Attributes
    ----------
    job : Job
    error : str
        Why it failed, in a sentence; empty when it did not.
    notes : list of str
        What reading and writing changed.
    seconds : float
        Time of reading, the recipe's steps, measuring and writing.
    steps : list of dict
        The figures of the recipe's steps.
    results : list of Result
        What the steps did, until :meth:`release`.
    measured : BeforeAfter or None
        The meshes and their measures.
    page : Path or None
        The report, if one was written.
    """

    job: Job
    error: str = ""
    notes: list[str] = field(default_factory=list)
    seconds: float = 0.0
    steps: list[dict[str, Any]] = field(default_factory=list)
    results: list[Result] = field(default_factory=list)
    measured: BeforeAfter | None = None
    page: Path | None = None

    @property
    def figures(self) -> dict[str, Any]:
        """What the command line's ``--json`` shows."""
        before, after = self.measured.summaries if self.measured else (None, None)
        return {
            "file": str(self.job.source),
            "output": str(self.job.target) if self.measured else None,
            "error": self.error or None,
            "seconds": self.seconds,
            "before": before,
            "after": after,
            "steps": self.steps,
            "report": str(self.page) if self.page else None,
        }

    def write_page(self, recipe: Recipe, path: Path) -> None:
        """Write a report of the result; the extension of `path` chooses the format."""
        assert self.measured is not None, "the job was done"
        names = self.job.source.name, self.job.target.name
        done = {result.index: said(result.algorithm) for result in self.results}
        did = [done.get(index, "") for index in range(len(recipe))]
        write_page(make_page(self.measured, names, recipe, did), path)
        self.page = path

    def release(self) -> None:
        """Drop the meshes and keep the figures, so that a large batch fits into memory."""
        self.results = []
        if self.measured is not None:
            self.measured = BeforeAfter((None, None), self.measured.summaries, self.measured.same_faces)


def plan(
    sources: Iterable[Path], output: Path, extension: str | None = None, keep: Iterable[Path] = ()
) -> list[Job]:
    """Say which files will be written for which.

    Parameters
    ----------
    sources : iterable of Path
        Mesh files, and folders, of which all files of readable formats are taken.
    output : Path
        Folder for the results.
    extension : str, optional
        Format of the results; by default that of each source where it can be written, else ``.vtp``.
    keep : iterable of Path
        Further files that must not be overwritten.

    Raises
    ------
    MeshFileError
        A folder has no mesh files or cannot be read, the format cannot be written, the output is no
        folder, or a result would overwrite an input.

    Examples
    --------
    >>> [job.target.name for job in plan([Path("a/part.ply"), Path("b/part.gltf")], Path("out"))]
    ['part.ply', 'part-2.vtp']
    """
    if extension is not None and extension not in WRITABLE:
        raise MeshFileError(
            f"{extension!r} is no format that can be written; use one of {' '.join(WRITABLE)}."
        )
    if output.exists() and not output.is_dir():
        raise MeshFileError(f"{output} is not a folder; name another one for the results.")
    files = [file for source in sources for file in (_meshes_in(source) if source.is_dir() else [source])]
    taken: set[str] = set()
    jobs = []
    for source in files:
        suffix = extension or (source.suffix.lower() if source.suffix.lower() in WRITABLE else ".vtp")
        names = (f"{source.stem}{f'-{i}' if i > 1 else ''}" for i in range(1, len(files) + 2))
        # Some file systems do not tell capitals from small letters.
        name = next(name for name in names if name.casefold() not in taken)
        taken.add(name.casefold())
        jobs.append(Job(source, output / f"{name}{suffix}"))
    inputs = {_identity(path) for path in (*files, *keep)}
    for job in jobs:
        if _identity(job.target) in inputs:
            raise MeshFileError(
                f"{job.target} is an input and would be overwritten; name another folder for the results."
            )
    return jobs


def _meshes_in(folder: Path) -> list[Path]:
    try:
        entries = sorted(folder.iterdir())
    except OSError as error:
        raise MeshFileError(
            f"cannot read the folder {folder}: {error.strerror}; change its permissions."
        ) from error
    meshes = [
        path for path in entries if path.suffix.lower() in READABLE and path.name[0] != "." and path.is_file()
    ]
    if not meshes:
        raise MeshFileError(f"{folder} holds no mesh files ({' '.join(READABLE)}); name another folder.")
    return meshes


def _identity(path: Path) -> object:
    """Return what is the same for two names of one file."""
    try:
        status = path.stat()
    except OSError:
        return path.resolve()
    return status.st_dev, status.st_ino


def run(
    recipe: Recipe,
    job: Job,
    inputs: Mapping[str | Path, Any] | None = None,
    apply: Callable[..., Any] = Filter.__call__,
) -> Outcome:
    """Read a mesh, run a recipe on it, measure what that changed, and write the result.

    Parameters
    ----------
    recipe : Recipe
    job : Job
    inputs : mapping of str or Path to vtkPolyData, optional
        The meshes of roles and files, as :meth:`~vtksmooth.Recipe.results` takes them.
    apply : callable
        Called with each filter and its inputs, to run it.

    Raises
    ------
    MeshFileError, InvalidMeshError, ParameterError, Cancelled
        What ended the run; nothing is written then.
    """
    begin = time.perf_counter()
    mesh, notes = read_surface(job.source)
    results = list(recipe.results(mesh, inputs, apply=apply))
    made = results[-1].mesh if results else mesh
    measured = measure(mesh, made, apply)
    notes += write_surface(made, job.target)
    steps = [{"filter": result.step.command, **result.algorithm.figures} for result in results]
    return Outcome(job, "", notes, time.perf_counter() - begin, steps, results, measured)


def attempt(
    recipe: Recipe,
    job: Job,
    inputs: Mapping[str | Path, Any] | None = None,
    apply: Callable[..., Any] = Filter.__call__,
    *,
    report: str | None = None,
    failures: type[Exception] = Exception,
) -> Outcome:
    """Do a job as :func:`run` does; what goes wrong is in the outcome, which keeps no mesh.

    Parameters
    ----------
    report : str, optional
        Extension of a report to write beside the result.
    failures : type
        What counts as the file's failure; other exceptions are raised.

    Raises
    ------
    Cancelled
        A filter has been asked to abort.
    """
    outcome = Outcome(job)
    begin = time.perf_counter()
    try:
        outcome = run(recipe, job, inputs, apply)
        if report is not None:
            outcome.write_page(recipe, job.target.with_suffix(report))
    except Cancelled:
        raise
    except failures as error:
        outcome.error, outcome.seconds = sentence(error), time.perf_counter() - begin
    outcome.release()
    return outcome


#: The columns of a table of outcomes.
HEAD = ["file", "min k", "mean k", "inverted", "deviation, %", "volume", "change, %", "seconds"]


def row(outcome: Outcome) -> list[str]:
    """Return what a table of outcomes says of one of them; see :data:`HEAD`."""
    name, seconds = outcome.job.source.name, f"{outcome.seconds:.2f}"
    if outcome.measured is None:
        return [name, "failed", *["-"] * (len(HEAD) - 3), seconds]
    before, after = outcome.measured.summaries
    a, b = before["aspect_ratio"], after["aspect_ratio"]
    return [
        name,
        f"{a['min']:.3f} -> {b['min']:.3f}",
        f"{a['mean']:.3f} -> {b['mean']:.3f}",
        f"{before['inverted']} -> {after['inverted']}",
        tables.number(after["deviation"]["max_relative"], 100.0),
        f"{tables.volume(before)} -> {tables.volume(after)}" if before["closed"] else "open",
        tables.volume_change(after),
        seconds,
    ]


def table(outcomes: Sequence[Outcome]) -> list[str]:
    """Return a table of all outcomes in Markdown, and what went wrong under it."""
    # What files are to blame for names them already.
    names = [f"{o.job.source.name}: " * (o.job.source.name not in o.error) for o in outcomes]
    failed = [f"{name}{o.error}" for name, o in zip(names, outcomes, strict=True) if o.error]
    return [
        *tables.markdown(HEAD, [row(outcome) for outcome in outcomes]),
        *([""] if failed else []),
        *failed,
    ]
