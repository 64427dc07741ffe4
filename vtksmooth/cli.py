"""The command line: ``vtksmooth COMMAND ...``.

The options of a command are made from its filter's parameter declarations. Imports are late, so that
help and wrong usage answer at once.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import signal
import sys
import threading
import time
import warnings
from collections.abc import Callable, Sequence
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from .errors import Cancelled, ParameterError, VtksmoothError, sentence
from .other_names import OTHER_NAMES, advice, snake
from .report import figure

if TYPE_CHECKING:
    from collections.abc import Iterator

    from .filters import Filter, Parameter

#: The commands, and what each does.
COMMANDS = {
    "demo": "improve real meshes, with tables and pictures of before and after",
    "quality": "measure the quality of every face: k and the usual measures",
    "compare": "measure what smoothing changed",
    "report": "show a mesh before and after on a page, as HTML or PDF",
    "run": "run a recipe on many meshes",
    "features": "find ridges, corners and cusps, and the ridge lines",
    "mark": "fix or free points, soften their edges, add or remove feature lines",
    "trapezium-drawing": "improve the worst elements, close to the surface",
    "laplacian": "smooth with a Laplacian scheme, plain, smart or constrained",
    "denoise": "remove noise, keep edges and the volume",
    "angle-based": "smooth by turning spokes onto bisectors",
    "back-to-surface": "smart Laplacian that stays on the original surface",
    "equilateral": "elements as regular as can be on the same surface, features kept",
    "null-space": "redistribute points, keeping ridges, corners and the volume",
    "segmentation": "turn a label image into smooth surfaces, the volume of every label kept",
    "triangulate": "split polygons into triangles with vertex valences near six",
    "regions": "tell the parts that lie on the installation space from the free ones",
    "installation-space": "smooth a flow volume inside its installation space, volume kept",
    "containment": "count what of a mesh is outside its installation space",
    "self-intersection": "find faces that cross or touch others",
    "gui": "open meshes in the desktop app",
    "warm-up": "compile all kernels now, so that no later run waits",
}

#: What does not stop within this time when asked to (VTK's readers, the compiler) is left, seconds.
_GRACE = 0.3

_BINS = ("k<0", "0-.2", ".2-.4", ".4-.6", ".6-.8", ".8-1")


# ------------------------------------------------------------------------------------------ usage


class _Parser(argparse.ArgumentParser):
    """A parser whose errors are one line."""

    def error(self, message: str) -> NoReturn:
        self.exit(2, f"vtksmooth: error: {message}; see {self.prog} --help\n")


def _parser(command: str | None) -> _Parser:
    """Return the parser, with the options of `command` only: those of others would need imports."""
    parser = _Parser(
        prog="vtksmooth",
        description="Smoothing of surface meshes that keeps the surface.",
        allow_abbrev=False,
    )
    parser.add_argument("--version", action=_Version, nargs=0, help="print the version and exit")
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", required=True, parser_class=_Parser)
    for name, text in COMMANDS.items():
        sub = commands.add_parser(name, help=text, allow_abbrev=False)
        if name == command:
            _add_arguments(sub, name)
    return parser


class _Version(argparse.Action):
    def __call__(self, parser: argparse.ArgumentParser, *_: Any) -> None:
        from importlib.metadata import version

        print(f"vtksmooth {version('vtksmooth')}")
        parser.exit()


def _add_arguments(parser: _Parser, command: str) -> None:
    parser.description = f"{COMMANDS[command].capitalize()}."
    if command == "demo":
        parser.add_argument(
            "meshes", nargs="*", type=Path, metavar="MESH", help="meshes (default: PyVista's)"
        )
        parser.add_argument(
            "--output", type=Path, metavar="DIR", default=Path("demo-output"),
            help="folder for the results (default: %(default)s)",
        )  # fmt: skip
    elif command == "gui":
        parser.add_argument("meshes", nargs="*", type=Path, metavar="MESH", help="files to open as layers")
    elif command == "run":
        _add_run(parser)
    elif command == "report":
        parser.add_argument("original", type=Path, metavar="ORIGINAL", help="file from before smoothing")
        parser.add_argument("result", type=Path, metavar="RESULT", help="file from after smoothing")
        parser.add_argument("output", type=Path, metavar="OUT", help="page to write, .html or .pdf")
        parser.add_argument("--recipe", type=Path, metavar="FILE", help="recipe to show, as JSON")
    elif command in _filters():
        cls = _filters()[command]
        parser.description = (cls.__doc__ or "").split("\n\n")[0]
        _add_files(parser, cls)
        groups: dict[str, argparse._ArgumentGroup] = {}
        for parameter in cls.parameters().values():
            name = parameter.group or "parameters"
            if name not in groups:
                groups[name] = parser.add_argument_group(name)
            _add_option(groups[name], parameter)
    general = parser.add_argument_group("general")
    if command not in ("demo", "gui"):
        general.add_argument("--json", action="store_true", help="print the result as JSON on stdout")
    general.add_argument("--quiet", action="store_true", help="no notes, no progress, no report; errors only")
    general.add_argument("--debug", action="store_true", help="show the traceback of an error")
    general.add_argument(
        "--threads", type=_threads, metavar="N", default=0, help="threads to use (default: 0, all)"
    )


def _add_run(parser: _Parser) -> None:
    parser.add_argument("recipe", type=Path, metavar="RECIPE", help="recipe to run, as JSON")
    parser.add_argument(
        "files", type=Path, nargs="+", metavar="FILE", help="meshes, and folders of meshes, to run it on"
    )
    parser.add_argument(
        "--output", type=Path, metavar="DIR", required=True, help="folder for the results; made if missing"
    )
    parser.add_argument(
        "--format", type=_extension, metavar="EXT",
        help="format of the results (default: that of each mesh where it can be written, else vtp)",
    )  # fmt: skip
    parser.add_argument(
        "--input", type=_role, metavar="ROLE=FILE", action="append", default=[],
        help="a further mesh that steps of the recipe ask for by a role, such as an installation space",
    )  # fmt: skip
    parser.add_argument(
        "--report", nargs="?", const=".html", choices=(".html", ".pdf"), type=_extension, metavar="FORMAT",
        help="write a page of before and after for each mesh as well, html (default) or pdf",
    )  # fmt: skip


def _extension(text: str) -> str:
    return f".{text.lower().removeprefix('.')}"


def _role(text: str) -> tuple[str, Path]:
    role, equals, path = text.partition("=")
    if not (role and equals and path):
        raise argparse.ArgumentTypeError(f"must be ROLE=FILE, not {text!r}")
    return role, Path(path)


def _add_files(parser: _Parser, cls: type[Filter]) -> None:
    """Add the files a filter reads and writes."""
    from .filters import INPUTS

    for name in cls.arguments or cls.inputs:
        parser.add_argument(
            name, type=Path,
            help="file to read" if len(cls.inputs) == 1 else f"file of the {INPUTS[name].title}",
            metavar="IN" if name in ("mesh", "image") and not cls.measures else name.upper(),
        )  # fmt: skip
    for name in cls.optional_inputs:
        parser.add_argument(
            f"--{name}", type=Path, metavar="FILE",
            help=f"file of the {INPUTS[name].title}, if there is one",
        )  # fmt: skip
    if not cls.measures:
        parser.add_argument(
            "output", type=Path, metavar="OUT", help="file to write; its extension is the format"
        )
        for name in cls.outputs[1:]:
            parser.add_argument(
                f"--{name}", type=Path, metavar="FILE", help=f"file to write the {name} to as well"
            )


def _filters() -> dict[str, type[Filter]]:
    from .filters import FILTERS, OF_IMAGES

    return {cls.command: cls for cls in (*FILTERS, *OF_IMAGES)}


def _threads(text: str) -> int:
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"must be 0 (all) or more, not {text!r}")
    return int(text)


def _add_option(group: argparse._ArgumentGroup, parameter: Parameter) -> None:
    """Add the option for a parameter."""

    def value(text: str) -> Any:
        if parameter.optional and text == "off":
            return None
        try:
            number = parameter.type(text) if parameter.type in (int, float) else text
        except ValueError:
            number = text  # check() says what is allowed
        try:
            return parameter.check(number)
        except ParameterError as error:
            raise argparse.ArgumentTypeError(str(error).rstrip(".")) from None

    flag = "--" + parameter.name.replace("_", "-")
    default = "off" if parameter.default is None else parameter.default
    text = parameter.help.replace("%", "%%")
    if parameter.type is bool:
        group.add_argument(
            flag, action=argparse.BooleanOptionalAction, default=parameter.default,
            help=f"{text} Default: {'on' if default else 'off'}.",
        )  # fmt: skip
        return
    allowed = f" {parameter.range[0].upper()}{parameter.range[1:]}."
    group.add_argument(
        flag,
        type=value,
        default=parameter.default,
        metavar="{" + ",".join(parameter.choices) + "}" if parameter.choices else _metavar(parameter),
        help=text
        + ("" if parameter.choices else allowed.replace("None (off)", "off"))
        + f" Default: {default}.",
    )


def _metavar(parameter: Parameter) -> str:
    if parameter.type is str:
        return parameter.text.upper() or "ARRAY"
    number = "DEG" if parameter.unit == "deg" else "N" if parameter.type is int else "X"
    return f"{number}|auto" if parameter.automatic else number


# ------------------------------------------------------------------------------------ interruption


class _Interruption:
    """While open, Ctrl-C and SIGTERM stop the run within a fraction of a second.

    Python runs signal handlers between two of its own instructions, which a reader or a kernel may
    keep waiting for long; hence a thread of its own, woken by the signal itself. It asks the running
    filter to stop; what cannot stop is left by ending the process, after removing what is half written.
    """

    def __init__(self) -> None:
        self.received = 0
        self.running: Any = None  # a filter that can be asked to stop
        self.committed = False  # the output is in place: too late to cancel
        self.kept = "nothing written"
        self._over = threading.Event()
        self._active = threading.current_thread() is threading.main_thread()

    def __enter__(self) -> _Interruption:
        if self._active:
            self._read, self._write = os.pipe()
            os.set_blocking(self._write, False)
            self._handlers = {
                number: signal.signal(number, lambda *_: None) for number in (signal.SIGINT, signal.SIGTERM)
            }
            self._wakeup = signal.set_wakeup_fd(self._write, warn_on_full_buffer=False)
            threading.Thread(target=self._watch, name="vtksmooth-interruption", daemon=True).start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        if self._active:
            signal.set_wakeup_fd(self._wakeup)
            for number, handler in self._handlers.items():
                signal.signal(number, handler)
            os.close(self._write)

    def _watch(self) -> None:
        # The pipe's end of file: the run is over.
        while (received := os.read(self._read, 1)) and received[0] not in self._handlers:
            pass
        if received and not self._over.is_set():
            self.received = received[0]
            if self.running is not None:
                self.running.SetAbortExecute(1)
            while not self._over.wait(_GRACE):
                if not self.committed:
                    _end_process(self.exit_code, self.message)
        os.close(self._read)

    @property
    def exit_code(self) -> int:
        """The exit code for the signal received."""
        return 130 if self.received == signal.SIGINT else 1

    @property
    def message(self) -> str:
        """What the user is told."""
        return f"vtksmooth: cancelled, {self.kept}"

    def check(self) -> None:
        """Raise Cancelled if a signal has been received."""
        if self.received:
            raise Cancelled("cancelled")


def _end_process(code: int, message: str) -> NoReturn:
    try:
        # While the module is being imported it is there without its names, and nothing is unfinished.
        remove = getattr(sys.modules.get("vtksmooth.files.writing"), "remove_unfinished", None)
        if remove is not None:
            remove()
        os.write(2, f"{_CLEAR if sys.stderr.isatty() else ''}{message}\n".encode())
    finally:
        os._exit(code)


_CLEAR = "\r\x1b[K"


# ----------------------------------------------------------------------------------------- talking


class _Talk:
    """What a run tells on stderr: notes, progress on a terminal, kernels being compiled."""

    def __init__(self, quiet: bool) -> None:
        self.quiet = quiet
        self.terminal = not quiet and sys.stderr.isatty()
        self.kernels = 0
        self._shown = 0.0
        self.subject = ""  # what the progress is of

    def note(self, text: str) -> None:
        if not self.quiet:
            self.clear()
            print(f"vtksmooth: note: {text}", file=sys.stderr)

    def item(self, done: str, error: str) -> None:
        """Tell what has become of one of many; errors are told by a quiet run too."""
        if error or not self.quiet:
            self.clear()
            print(f"{self.subject}{error or done}", file=sys.stderr, flush=True)

    def compiling(self, kernel: str) -> None:
        self.kernels += 1
        text = f"compiling kernel {self.kernels} ({kernel}), once per installation"
        if self.terminal:
            self._line(text)
        elif not self.quiet:
            print(f"vtksmooth: {text}", file=sys.stderr, flush=True)

    def progress(self, fraction: float, what: str) -> None:
        now = time.monotonic()
        if self.terminal and (now - self._shown > 0.1 or fraction >= 1.0):
            self._shown = now
            done = round(30 * min(max(fraction, 0.0), 1.0))
            self._line(f"[{'#' * done}{'.' * (30 - done)}] {100 * fraction:3.0f} % {self.subject}{what}")

    def _line(self, text: str) -> None:
        print(f"{_CLEAR}{text[:100]}", end="", file=sys.stderr, flush=True)

    def clear(self) -> None:
        if self.terminal:
            print(_CLEAR, end="", file=sys.stderr, flush=True)


# ---------------------------------------------------------------------------------------- commands


class _Run:
    """One run of a command."""

    def __init__(self, options: argparse.Namespace, interruption: _Interruption) -> None:
        self.options, self.interruption = options, interruption
        self.talk = _Talk(options.quiet)
        self.exit_code = 0

    def execute(self) -> int:
        """Run the command; return the exit code."""
        from .jit.compiled import on_compile
        from .jit.parallel import set_number_of_threads

        set_number_of_threads(self.options.threads)
        command = self.options.command
        method: Callable[[], None] = {
            "demo": self.demo,
            "quality": self.quality,
            "compare": self.compare,
            "gui": self.gui,
            "run": self.run,
            "report": self.report,
            "warm-up": self.warm_up,
        }.get(command, self.filter)
        # The demo announces its kernels itself.
        with nullcontext() if command == "demo" else on_compile(self.talk.compiling):
            try:
                method()
            finally:
                self.talk.clear()
        return self.exit_code

    def demo(self) -> None:
        from . import demo

        demo.run(self.options.output, self.options.quiet, self.options.meshes)

    def quality(self) -> None:
        from .filters import SurfaceQuality

        options = self.options
        algorithm = SurfaceQuality(**{name: getattr(options, name) for name in SurfaceQuality.parameters()})
        summary = self._filtered(algorithm, self._read(options.mesh))[0].summary
        if not self._json(summary):
            _print_table([(options.mesh.name, summary)])
            _print_usual_measures(summary.get("usual_measures", {}))
            for key, count in summary.get("self_intersections", {}).items():
                print(f"{key.replace('_', ' '):<22}{count:>12}")

    def compare(self) -> None:
        from .filters import SurfaceComparison, SurfaceQuality

        original, result = self._read(self.options.original), self._read(self.options.result)
        summary = self._filtered(SurfaceComparison(), result, original)[0].summary
        if self._json(summary):
            return
        before = self._filtered(SurfaceQuality(usual_measures=False), original)[0].summary
        _print_table([(self.options.original.name, before), (self.options.result.name, summary)])
        _print_changes(summary)

    def filter(self) -> None:
        from .files import check_writable, write_surface

        options, cls = self.options, _filters()[self.options.command]
        paths = (
            [] if cls.measures else [options.output, *(getattr(options, name) for name in cls.outputs[1:])]
        )
        targets = {port: path for port, path in enumerate(paths) if path is not None}
        for port, path in targets.items():
            check_writable(path, lines=cls.outputs[port] == "lines")
        if len({path.resolve() for path in targets.values()}) < len(targets):
            raise ParameterError(f"{options.output} cannot take all results; name a file for each.")
        algorithm: Any = cls(**{name: getattr(options, name) for name in cls.parameters()})
        given = {name: getattr(options, name) for name in cls.every_input()}
        self._filtered(
            algorithm,
            *(
                None if path is None else self._read(path, image=name == "image")
                for name, path in given.items()
            ),
        )
        self.interruption.check()
        for port, path in targets.items():
            for place, output in _files_of(algorithm.GetOutput(port), path):
                notes = write_surface(output, place)
                self.interruption.committed = True
                for note in notes:
                    self.talk.note(note)
        for note in algorithm.notes:
            self.talk.note(note)
        if not self._json(algorithm.figures) and not self.options.quiet:
            self.talk.clear()
            print(getattr(algorithm, "report", None) or _lines(algorithm.figures))

    def gui(self) -> None:
        from importlib import import_module

        # Ctrl-C closes the window, which asks about what is not saved.
        self.interruption.committed = True
        # By name: the application is above the command line, and need not be installed.
        import_module("vtksmooth_gui.app").start(self.options.meshes)

    def run(self) -> None:
        from . import batch
        from .files import make_folder
        from .recipe import Recipe

        options = self.options
        recipe = Recipe.load(options.recipe)
        files = dict(options.input)
        kept = [options.recipe, *files.values(), *(path for path in recipe.sources if isinstance(path, Path))]
        jobs = batch.plan(options.files, options.output, options.format, kept)
        inputs = recipe.read_inputs(files, self._read)
        make_folder(options.output)
        outcomes: list[batch.Outcome] = []
        try:
            for number, job in enumerate(jobs, 1):
                self.interruption.kept = f"{len(outcomes)} of {len(jobs)} files done"
                self.interruption.check()
                self.talk.subject = f"{number} of {len(jobs)}, {job.source.name}: "
                outcome = batch.attempt(
                    recipe, job, inputs, self._filtered, report=options.report,
                    failures=VtksmoothError if options.debug else Exception,
                )  # fmt: skip
                outcomes.append(outcome)
                for note in outcome.notes:
                    self.talk.note(note)
                self.talk.item(f"{outcome.seconds:.2f} s", outcome.error)
        finally:
            failed = sum(bool(outcome.error) for outcome in outcomes)
            self.talk.clear()
            summary = {
                "recipe": str(options.recipe),
                "files": [outcome.figures for outcome in outcomes],
                "done": len(outcomes) - failed,
                "failed": failed,
            }
            if outcomes and not self._json(summary) and not options.quiet:
                print("\n".join(batch.table(outcomes)))
        self.exit_code = 1 if failed else 0

    def report(self) -> None:
        from .pages.measures import measure
        from .pages.page import make_page
        from .pages.writing import check_format, write_page
        from .recipe import Recipe

        options = self.options
        check_format(options.output)
        recipe = Recipe.load(options.recipe) if options.recipe else None
        measured = measure(self._read(options.original), self._read(options.result), self._filtered)
        page = make_page(measured, (options.original.name, options.result.name), recipe)
        self.interruption.check()
        write_page(page, options.output)
        self.interruption.committed = True
        before, after = measured.summaries
        figures = {"before": before, "after": after, "pictures": bool(page.pictures)}
        if not self._json(figures) and not options.quiet:
            print("\n".join(page.sentences))

    def warm_up(self) -> None:
        from . import warm_up

        def progress(fraction: float, what: str) -> None:
            self.interruption.check()
            self.talk.progress(fraction, what)

        start = time.perf_counter()
        count = warm_up.run(progress)
        seconds = time.perf_counter() - start
        if not self._json({"compiled": count, "seconds": seconds}) and not self.options.quiet:
            self.talk.clear()
            print(
                f"{count} kernels compiled in {seconds:.1f} s."
                if count
                else "All kernels were compiled already."
            )

    def _read(self, path: Path, image: bool = False) -> Any:
        from .files import read_image, read_surface

        mesh, notes = (read_image if image else read_surface)(path)
        self.interruption.check()
        for note in notes:
            self.talk.note(note)
        return mesh

    def _filtered(self, algorithm: Any, *meshes: Any) -> tuple[Any, Any]:
        """Run a filter so that it shows progress and can be interrupted; return it and its output."""
        algorithm.AddObserver(
            "ProgressEvent",
            lambda *_: self.talk.progress(algorithm.GetProgress(), algorithm.GetProgressText() or ""),
        )
        self.interruption.running = algorithm
        try:
            # Here and not only before: the signal may have come before there was something to stop.
            self.interruption.check()
            return algorithm, algorithm(*meshes)
        finally:
            self.interruption.running = None
            self.talk.clear()

    def _json(self, value: dict[str, Any]) -> bool:
        if self.options.json:
            print(json.dumps(_finite(value)))
        return bool(self.options.json)


def _files_of(output: Any, path: Path) -> list[tuple[Path, Any]]:
    """Return the files to write and what goes into each: of blocks one for each, with its name."""
    if not output.IsA("vtkMultiBlockDataSet"):
        return [(path, output)]
    names = [output.GetMetaData(i).Get(output.NAME()) for i in range(output.GetNumberOfBlocks())]
    return [
        (path.with_name(f"{path.stem}_{name}{path.suffix}"), output.GetBlock(i))
        for i, name in enumerate(names)
    ]


def _finite(value: Any) -> Any:
    """Return `value` with null in place of numbers that JSON does not know."""
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _lines(summary: dict[str, Any], indent: str = "") -> str:
    """Return a summary as one line for each figure."""
    return "\n".join(
        f"{indent}{name.replace('_', ' ')}:\n{_lines(value, indent + '  ')}"
        if isinstance(value, dict)
        else f"{indent}{name.replace('_', ' ')}: {figure(value, 6)}"
        if isinstance(value, float)
        else f"{indent}{name.replace('_', ' ')}: {value}"
        for name, value in summary.items()
    )


def _print_table(rows: Sequence[tuple[str, dict[str, Any]]]) -> None:
    """Print quality summaries as one table, with the papers' bins of the aspect ratio k."""
    for name, summary in rows:
        cells = (
            ", ".join(f"{count} {kind}s" for kind, count in summary["cells"].items() if count) or "no faces"
        )
        shape = "closed" if summary["closed"] else "open"
        if "labels" in summary:
            shape += f", {len(summary['labels'])} labels"
        elif summary["closed"]:
            shape += f", volume {figure(summary['volume'], 6)}"
        print(f"{name}: {summary['points']} points, {cells}; {shape}")
    width = max(len(name) for name, _ in rows)
    heads = "".join(f"{head:>8}" for head in _BINS)
    print(f"\n{'k, % of the faces':<{max(width, 17)}}{heads}{'min k':>9}{'mean k':>9}{'inverted':>10}")
    for name, summary in rows:
        ratio = summary["aspect_ratio"]
        shares = "".join(f"{share:8.2f}" for share in ratio["histogram"])
        print(
            f"{name:<{max(width, 17)}}{shares}{ratio['min']:9.3f}{ratio['mean']:9.3f}"
            f"{summary['inverted']:10d}"
        )


def _print_usual_measures(measures: dict[str, dict[str, float | None]]) -> None:
    """Print the range and the mean of Verdict's measures, where faces have them."""
    known = {key: values for key, values in measures.items() if values["mean"] is not None}
    if known:
        print(f"\n{'triangles and quads':<22}{'min':>12}{'mean':>12}{'max':>12}")
    for key, values in known.items():
        name = key.replace("_", " ") + (", deg" if "angle" in key else "")
        shown = (figure(value) for value in values.values() if value is not None)
        print(f"{name:<22}{''.join(f'{value:>12}' for value in shown)}")


def _print_changes(summary: dict[str, Any]) -> None:
    normal, dihedral, deviation = (
        summary[key] for key in ("normal_deviation", "dihedral_change", "deviation")
    )
    print(f"\n{'':<30}{'max':>12}{'mean':>12}")
    print(f"{'normal deviation, deg':<30}{figure(normal['max']):>12}{figure(normal['mean']):>12}")
    print(f"{'dihedral change, deg':<30}{figure(dihedral['max']):>12}{figure(dihedral['mean']):>12}")
    for way, figures in (("result to original", deviation), ("original to result", deviation["back"])):
        print(f"{way:<30}{figure(figures['max']):>12}{figure(figures['mean']):>12}")
        relative = (100 * figures[f"{part}_relative"] for part in ("max", "mean"))
        print(f"{'  in % of the diagonal':<30}{''.join(f'{figure(value):>12}' for value in relative)}")
    bounds = summary.get("hausdorff")
    if bounds is not None:
        print(f"{'Hausdorff distance, at most':<30}{figure(bounds['upper']):>12}")
        print(f"{'Hausdorff distance, at least':<30}{figure(bounds['lower']):>12}")
    volume = summary["volume_change_percent"]
    if volume is not None:
        print(f"{'volume change, %':<30}{figure(volume):>12}")
    elif "labels" in summary:
        for each in summary["labels"]:
            name = f"volume change of label {each['label']}, %"
            print(f"{name:<30}{figure(each.get('change_percent')):>12}")
    elif "swept_volume" in summary:
        print(f"{'swept volume (open mesh)':<30}{figure(summary['swept_volume']):>12}")


# -------------------------------------------------------------------------------------------- main


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line and return the exit code: 0 done, 1 the run failed, 2 wrong usage.

    Examples
    --------
    >>> main(["quality", "missing.ply", "--quiet"])
    1
    """
    arguments = sys.argv[1:] if argv is None else list(argv)
    with _Interruption() as interruption, _stdout_for_any_name():
        try:
            return _main(arguments, interruption)
        except BrokenPipeError:
            # Whoever read our output has left. Python would complain once more when it flushes.
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            return 1


def _prepare_reading(options: argparse.Namespace) -> None:
    """Start the process that reads files for VTK while this one is importing what it needs."""
    from .files.signatures import OF_VTK
    from .files.vtk_process import prepare

    given = [value for name, value in vars(options).items() if name != "output"]
    paths = [path for value in given for path in (value if isinstance(value, list) else [value])]
    if any(isinstance(path, Path) and path.suffix.lower() in OF_VTK for path in paths):
        prepare()


@contextmanager
def _stdout_for_any_name() -> Iterator[None]:
    """Let names of files be printed that the terminal's encoding cannot show."""
    if hasattr(sys.stdout, "reconfigure"):
        before = sys.stdout.errors
        sys.stdout.reconfigure(errors="backslashreplace")
        yield
        sys.stdout.reconfigure(errors=before)
    else:
        yield


def _refuse_other_names(parser: _Parser, command: str | None, arguments: list[str]) -> None:
    """Refuse options by the names of VTK and PyVista, telling ours: before argparse takes their values."""
    words = [word.partition("=")[0] for word in arguments if word.startswith("--")]
    words = [word for word in words if snake(word.replace("--no-", "--", 1)) in OTHER_NAMES]
    if not words or command not in _filters():
        return
    for word in words:
        known = _filters()[command].parameters()
        if instead := advice(word.replace("--no-", "--", 1), known, "--"):
            parser.error(f"there is no option {word}; {instead}")


def _main(arguments: list[str], interruption: _Interruption) -> int:
    try:
        command = next((word for word in arguments if not word.startswith("-")), None)
        parser = _parser(command)
        _refuse_other_names(parser, command, arguments)
        options = parser.parse_args(arguments)
    except SystemExit as exit_:  # argparse has said why
        return int(exit_.code or 0)
    try:
        with warnings.catch_warnings():
            if not options.debug:
                warnings.simplefilter("ignore")
            _prepare_reading(options)
            code = _Run(options, interruption).execute()
        sys.stdout.flush()
    except BrokenPipeError:
        raise
    except Cancelled:
        print(interruption.message, file=sys.stderr)
        return interruption.exit_code
    except Exception as error:
        if options.debug:
            raise
        print(f"vtksmooth: error: {sentence(error)}", file=sys.stderr)
        return 1
    return code
