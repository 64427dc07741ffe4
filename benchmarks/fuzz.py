"""Run odd meshes through every filter and damaged files through the command line; say what goes wrong.

    python benchmarks/fuzz.py [--meshes N] [--files N] [--batch N] [--sessions N] [--only KIND] [--first N]
        [--seed N] [--jobs N] [--minutes N] [--journal FILE] [--output FILE]

Every case follows from its kind, the seed and its number: ``--only files --first 4711 --files 1`` does one
again and prints what was wrong. Cases run in processes of their own, with a limit on time and memory; a
process that dies or hangs is ended with all that it started, and is one finding. With a journal a run
that was stopped goes on where it ended, and cases in which something was wrong are done again. Writes
docs/fuzz.md; ends with status 1 where something was wrong. Linux only.
"""

from __future__ import annotations

import argparse
import contextlib
import ctypes
import faulthandler
import io
import json
import multiprocessing
import os
import platform
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
import warnings
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, field
from importlib import metadata
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))

import tables

#: The kinds of cases, how many there are of each by default, and what they are.
KINDS = {
    "meshes": (10_000, "odd mesh, through every filter with random parameters"),
    "files": (10_000, "damaged file, through a command of the command line"),
    "batch": (300, "folder of good and damaged files, through `vtksmooth run`"),
    "sessions": (1_000, "damaged session or recipe"),
}
#: Seconds that a filter or a command may take before it counts as hanging.
PATIENCE = 120.0
#: Bytes of address space that a process may ask for; what it starts, as many again.
_MEMORY = 6 << 30
#: Words of errors that are none of ours.
_UNEXPECTED = re.compile(r"Traceback|unexpected \w*(Error|Exception)")
#: Of so many files one goes through a process of its own, as users start it.
_REAL = 50
#: Points from which on memory may well run out.
_HUGE = 10_000_000

#: Columns of the table, and the findings that count there; all others are broken guarantees.
COLUMNS = {
    "deaths": ("death",),
    "hangs": ("hang",),
    "unexpected exceptions": ("unexpected exception", "traceback", "cancelled"),
    "silent empties": ("silent empty",),
    "inputs changed": ("input changed",),
    "arrays or topology lost": (
        "array lost", "array changed", "array length", "topology", "topology changed", "structure",
        "precision",
    ),
    "NaN": ("NaN",),
    "messages": ("no sentence", "message", "exit status", "VTK's words"),
    "guarantees": (),
}  # fmt: skip


def column_of(kind: str) -> str:
    """Return the column in which a finding counts."""
    return next((column for column, kinds in COLUMNS.items() if kind in kinds), "guarantees")


@dataclass
class Outcome:
    """What came of a case.

    Attributes
    ----------
    kind : str
    number : int
    runs, refused : int
        Filters or commands that ran, and those of them that refused in a sentence.
    seconds : float
    findings : list of dict
        See :class:`fuzz_checks.Finding`.
    """

    kind: str
    number: int
    runs: int = 0
    refused: int = 0
    seconds: float = 0.0
    findings: list[dict[str, Any]] = field(default_factory=list)


# ---------------------------------------------------------------------------- in processes of their own


class Cases:
    """Does cases, in the process that it is made in."""

    def __init__(self, seed: int, folder: Path, tell: Callable[[str], None]) -> None:
        import damaged_files

        self.seed, self.folder, self.tell = seed, folder, tell
        scratch = folder / "samples"
        scratch.mkdir()
        self.samples = damaged_files.samples(scratch)
        self.good = scratch / "good.ply"
        self.good.write_bytes(next(one for one in self.samples if one.name == "own.ply").files["own.ply"])
        self.recipe_text = damaged_files.sample_recipe()
        self.session = damaged_files.sample_session(scratch)
        self.recipe = scratch / "recipe.json"
        self.recipe.write_text(self.recipe_text, encoding="utf-8")
        self.outcome = Outcome("", 0)
        self._words = 0

    def do(self, kind: str, number: int) -> Outcome:
        """Do a case."""
        self.outcome = Outcome(kind, number)
        self.place = self.folder / "case"
        shutil.rmtree(self.place, ignore_errors=True)
        self.place.mkdir()
        begin = time.perf_counter()
        getattr(self, kind)(number)
        self.outcome.seconds = time.perf_counter() - begin
        return self.outcome

    def random(self, number: int, purpose: int = 0) -> Any:
        """Return random numbers of a case, for one purpose."""
        import numpy as np

        return np.random.default_rng([self.seed, number, purpose])

    def say(self, kind: str, where: str, text: str, meets: bool = False, case: str = "") -> None:
        """Note a finding."""
        self.outcome.findings.append(
            {"kind": kind, "where": where, "text": text[:400], "meets": meets, "case": case[:1500]}
        )

    # -- meshes

    def meshes(self, number: int) -> None:
        """Run every filter on an odd mesh."""
        import fuzz_checks
        import odd_meshes

        odd = odd_meshes.odd(self.random(number))
        for cls, parameters in fuzz_checks.every_filter(self.random(number, 1), odd):
            case = f"{odd.name}; {parameters}"
            self.tell(f"{cls.__name__}: {case}")
            self.outcome.runs += 1
            with _words() as words:
                result, findings = fuzz_checks.exercise(cls, odd, parameters)
            self.outcome.refused += result == "refused"
            for one in findings:
                self.say(one.kind, one.where, one.text, one.meets, case)
            if words[0]:
                self.say("VTK's words", cls.__name__, words[0], case=case)

    # -- files

    def files(self, number: int) -> None:
        """Run a command, or open in the app, a damaged file."""
        import damaged_files

        random = self.random(number)
        sample = self.samples[random.integers(len(self.samples))]
        stem = str(random.choice(["a", "a", "a", "with blank", "é", "-x"]))
        name = f"{stem}{Path(sample.name).suffix}"
        for path, content in damaged_files.damaged_sample(random, sample).items():
            target = self.place / (name if path == sample.name else path)
            target.parent.mkdir(exist_ok=True)
            target.write_bytes(content)
        if random.random() < 0.15:
            self.open_file(self.place / name, sample.name)
        else:
            self.command(random, self.place / name, sample.name, number % _REAL == 0)

    def open_file(self, path: Path, what: str) -> None:
        """Open a file as the app does, smooth it, and go back."""
        from vtksmooth.errors import VtksmoothError
        from vtksmooth.files import read_surface
        from vtksmooth.recipe import COMMANDS
        from vtksmooth_gui.model.document import Document

        self.tell(f"app: {what}")
        self.outcome.runs += 1
        try:
            document = Document()
            layer = document.open(read_surface(path)[0], path)
            step, sources = document.step(layer, COMMANDS["laplacian"], {"iterations": 2}, [])
            made = step.make()(layer.state.input())
            document.apply(layer, [made], step, sources, "Smooth", "smoothed", "2 iterations")
            document.undo()
            document.redo()
        except VtksmoothError as error:
            self.outcome.refused += 1
            if "\n" in str(error) or len(str(error)) > 1000:
                self.say("no sentence", "app", str(error), case=what)
        except Exception as error:
            self.say("unexpected exception", "app", f"{type(error).__name__}: {error}", case=what)
        else:
            if not layer.state.n_points:
                self.say("silent empty", "app", "a layer without points", case=what)

    def command(self, random: Any, source: Path, what: str, real: bool) -> None:
        """Run a command on a file and judge what it says and leaves behind."""
        output = self.place / f"out{random.choice(['.ply', '.vtp', '.obj', '.stl', '.off', '.vtk', '.vtu'])}"
        smooth = str(
            random.choice(["trapezium-drawing", "laplacian", "equilateral", "null-space", "back-to-surface"])
        )
        commands = [
            ["quality", source, "--json"],
            ["quality", source],
            [smooth, source, output, "--iterations", "2"],
            [smooth, source, output, "--iterations", "1", "--json", "--quiet"],
            ["compare", source, source, "--json"],
            ["compare", self.good, source],
            ["features", source, output],
            ["mark", source, output, "--fix", "0"],
            ["triangulate", source, output],
            ["regions", source, self.good, output],
            ["containment", self.good, source, "--json"],
            ["installation-space", source, self.good, output, "--iterations", "1"],
            ["run", self.recipe, source, "--output", self.place / "results"],
        ]
        chosen = commands[random.choice(len(commands), p=_shares(len(commands)))]
        arguments = [str(word) for word in chosen]
        self.judge(arguments, what, output if output in chosen else None, source, real)

    def judge(self, arguments: list[str], what: str, output: Path | None, source: Path, real: bool) -> None:
        """Run the command line; see that its exit, its words and its files fit."""
        before = source.read_bytes()
        case = f"{what}: vtksmooth {' '.join(arguments)}"
        self.tell(case)
        self.outcome.runs += 1
        code, out, err = _real_process(arguments) if real else _long_lived(arguments)
        where = arguments[0]
        if code < 0:
            self.say("death", where, f"signal {-code}", case=case)
            return
        lines = [
            line for line in err.splitlines() if line.strip() and not line.startswith("vtksmooth: note:")
        ]
        lines = [line for line in lines if not re.match(r"vtksmooth:? compil", line)]
        self.outcome.refused += code != 0
        if _UNEXPECTED.search(err + out):
            self.say("traceback", where, (lines or out.splitlines()[-1:] or [err])[-1], case=case)
        elif code not in (0, 1):
            self.say("exit status", where, f"{code}: {lines[-1:]}", case=case)
        elif (
            code == 1
            and where != "run"
            and not (len(lines) == 1 and lines[0].startswith("vtksmooth: error:"))
        ):
            self.say("message", where, f"{len(lines)} lines: {lines[:3]}", case=case)
        elif code == 0 and where != "run" and lines:
            self.say("VTK's words", where, lines[0], case=case)
        if re.search("make room|out of memory|does not fit into memory", err + out) and not _huge(source):
            self.say("message", where, f"reason that is none: {(lines or ['?'])[-1]}", case=case)
        if source.read_bytes() != before:
            self.say("input changed", where, "", case=case)
        if output is not None:
            self.result(code, output, where, case)
        if code == 0 and "--json" in arguments:
            try:
                json.loads(
                    out, parse_constant=lambda word: self.say("NaN", where, f"JSON has {word}", case=case)
                )
            except ValueError:
                self.say("message", where, f"no JSON: {out[:80]}", case=case)
        left = [path.name for path in self.place.iterdir() if re.search(r"tmp|\.part|^\.", path.name)]
        if left:
            self.say("message", where, f"left behind: {left}", case=case)

    def result(self, code: int, output: Path, where: str, case: str) -> None:
        """See that there is a whole result, or none."""
        import numpy as np

        from vtksmooth.errors import VtksmoothError
        from vtksmooth.files import read_surface

        if output.exists() != (code == 0):
            self.say(
                "silent empty",
                where,
                f"exit {code}, result {'there' if output.exists() else 'missing'}",
                case=case,
            )
        if code or not output.exists():
            return
        try:
            made = read_surface(output)[0]
        except VtksmoothError as error:
            self.say("silent empty", where, f"own result cannot be read: {error}", case=case)
            return
        if made.n_points and not np.isfinite(made.points).all():
            self.say("NaN", where, "points of the result", case=case)

    # -- batch

    def batch(self, number: int) -> None:
        """Run a batch on a folder of good and damaged files."""
        import damaged_files

        random = self.random(number)
        folder, results = self.place / "in", self.place / "results"
        folder.mkdir()
        for name in ("a.ply", "m.ply", "z.ply"):
            shutil.copy(self.good, folder / name)
        for i in range(int(random.integers(1, 5))):
            sample = self.samples[random.integers(len(self.samples))]
            for path, content in damaged_files.damaged_sample(random, sample).items():
                suffix = Path(path).suffix if path == sample.name else None
                target = folder / (f"{'bknx'[i]}{suffix}" if suffix else path)
                target.parent.mkdir(exist_ok=True)
                target.write_bytes(content)
        arguments = ["run", str(self.recipe), str(folder), "--output", str(results), "--json"]
        case = f"{sorted(path.name for path in folder.iterdir())}"
        self.tell(f"run: {case}")
        self.outcome.runs += 1
        code, out, err = _real_process(arguments) if number % 10 == 0 else _long_lived(arguments)
        if code < 0:
            self.say("death", "run", f"signal {-code}", case=case)
            return
        missing = [name for name in ("a.ply", "m.ply", "z.ply") if not (results / name).exists()]
        if missing:
            self.say("silent empty", "run", f"results missing: {missing}", case=case)
        if _UNEXPECTED.search(err + out):
            self.say("traceback", "run", err[-300:], case=case)
        try:
            figures = json.loads(out)
        except ValueError:
            self.say("message", "run", f"no JSON: {out[:80]} {err[-200:]}", case=case)
            return
        self.outcome.refused += code != 0
        failed = [one for one in figures["files"] if one["error"]]
        if (code == 1) != bool(failed) or code not in (0, 1):
            self.say("exit status", "run", f"{code}, {len(failed)} failed", case=case)
        for one in figures["files"]:
            if one["output"] and not Path(one["output"]).exists():
                self.say("silent empty", "run", f"{one['output']} is missing", case=case)
            if one["error"] and ("\n" in one["error"] or len(one["error"]) < 15):
                self.say("no sentence", "run", one["error"], case=case)

    # -- sessions

    def sessions(self, number: int) -> None:
        """Open a damaged session, or every third time run a damaged recipe."""
        import damaged_files

        random = self.random(number)
        if number % 3 == 0:
            text = self.recipe_text
            content = (
                damaged_files.damaged_json(random, text).encode("utf-8", "replace")
                if random.random() < 0.8
                else damaged_files.damaged(random, text.encode())
            )
            recipe = self.place / "recipe.json"
            recipe.write_bytes(content)
            arguments = [
                "run",
                str(recipe),
                str(self.good),
                "--output",
                str(self.place / "results"),
                "--json",
            ]
            self.judge(arguments, "damaged recipe", None, recipe, False)
            return
        path = self.place / "damaged.session"
        path.write_bytes(damaged_files.damaged_session(random, self.session))
        shutil.copy(self.folder / "samples" / "layer.vtp", self.place / "layer.vtp")
        self.open_session(path)

    def open_session(self, path: Path) -> None:
        """Open a session, look at what it holds, and save it again."""
        from vtksmooth.errors import VtksmoothError
        from vtksmooth_gui.model import session, session_reader
        from vtksmooth_gui.model.document import Document

        self.tell("session")
        self.outcome.runs += 1
        try:
            stored = session_reader.find(path)
            restored = session_reader.restore(stored, dict.fromkeys(stored.missing))
        except VtksmoothError as error:
            self.outcome.refused += 1
            if "\n" in str(error) or len(str(error)) > 1000:
                self.say("no sentence", "session", str(error))
            return
        except Exception as error:
            self.say("unexpected exception", "session: read", f"{type(error).__name__}: {error}")
            return
        try:
            document = Document()
            session_reader.apply(restored, document, frozenset())
            document.undo()
            document.redo()
            session.save(
                session.capture(document, restored.more, restored.drafts), self.place / "again.session"
            )
        except VtksmoothError as error:
            self.say("unexpected exception", "session: use", f"{type(error).__name__}: {error}")
        except Exception as error:
            self.say("unexpected exception", "session: use", f"{type(error).__name__}: {error}")


def _huge(source: Path) -> bool:
    # Damage to its dimensions can make a few bytes an image of any size; then that is the true reason.
    from vtksmooth.errors import VtksmoothError
    from vtksmooth.files import read_surface

    try:
        return bool(read_surface(source)[0].n_points > _HUGE)
    except VtksmoothError:
        return False


def _shares(n: int) -> list[float]:
    # Reading is what differs: the commands that do little else come most often.
    weights = [4.0, 2.0, 3.0, *[1.0] * (n - 3)]
    return [weight / sum(weights) for weight in weights]


@contextlib.contextmanager
def _words() -> Iterator[list[str]]:
    """Collect what is written to the process's stderr and stdout, by C++ too."""
    sys.stderr.flush()
    words = [""]
    with tempfile.TemporaryFile() as file:
        kept = os.dup(2)
        os.dup2(file.fileno(), 2)
        try:
            yield words
        finally:
            sys.stderr.flush()
            os.dup2(kept, 2)
            os.close(kept)
            file.seek(0)
            text = file.read().decode("utf-8", "replace")
            lines = [
                line for line in text.splitlines() if line.strip() and "compiles its kernels" not in line
            ]
            words[0] = "\n".join(lines[:4])


def _long_lived(arguments: list[str]) -> tuple[int, str, str]:
    """Run the command line in this process; return its status, and what it wrote."""
    from vtksmooth import cli

    streams = sys.stdout, sys.stderr
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        kept = os.dup(1), os.dup(2)
        os.dup2(out.fileno(), 1)
        os.dup2(err.fileno(), 2)
        sys.stdout = io.TextIOWrapper(os.fdopen(os.dup(1), "wb"), encoding="utf-8")
        sys.stderr = io.TextIOWrapper(os.fdopen(os.dup(2), "wb"), encoding="utf-8", line_buffering=True)
        try:
            code = cli.main(arguments)
        except BaseException as error:
            code = 1
            print(f"Traceback: {type(error).__name__}: {error}", file=sys.stderr)
        finally:
            sys.stdout.close()
            sys.stderr.close()
            sys.stdout, sys.stderr = streams
            for number, one in zip((1, 2), kept, strict=True):
                os.dup2(one, number)
                os.close(one)
        texts = []
        for file in (out, err):
            file.seek(0)
            texts.append(file.read().decode("utf-8", "replace"))
    return code, texts[0], texts[1]


def _real_process(arguments: list[str]) -> tuple[int, str, str]:
    """Run the command line as users do."""
    done = subprocess.run([sys.executable, "-m", "vtksmooth", *arguments], capture_output=True, check=False)
    return done.returncode, done.stdout.decode("utf-8", "replace"), done.stderr.decode("utf-8", "replace")


def _end_with_parent() -> None:
    """Have Linux end this process when the one that started it ends, however that comes."""
    die_with_parent = 1  # PR_SET_PDEATHSIG
    ctypes.CDLL(None).prctl(die_with_parent, signal.SIGKILL)


def _work(connection: Any, seed: int, threads: int) -> None:
    """Do the cases that come through a pipe, until there are no more."""
    os.setsid()  # so that it and all that it starts can be ended together
    _end_with_parent()
    resource.setrlimit(resource.RLIMIT_AS, (_MEMORY, _MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    os.environ["OMP_NUM_THREADS"] = str(threads)
    warnings.simplefilter("ignore")
    log = os.open(os.devnull, os.O_WRONLY)
    os.dup2(log, 1)
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        cases = Cases(seed, Path(folder), lambda text: connection.send(("step", text)))
        connection.send(("ready", None))
        while (task := connection.recv()) is not None:
            connection.send(("done", cases.do(*task)))


# ---------------------------------------------------------------------------------------- the command


class Worker:
    """A worker process for cases, restarted when it dies or hangs."""

    def __init__(self, seed: int, patience: float) -> None:
        self.seed, self.patience = seed, patience
        self.start()

    def start(self) -> None:
        """Start the process."""
        context = multiprocessing.get_context("spawn")
        self.connection, other = context.Pipe()
        self.process = context.Process(target=_work, args=(other, self.seed, 1), daemon=False)
        self.process.start()
        other.close()
        try:
            self.connection.recv()
        except EOFError:
            raise SystemExit("A process that is to do the cases does not start.") from None

    def do(self, kind: str, number: int) -> Outcome:
        """Have a case done; that it ends the process, or does not end, is a finding."""
        step = "the beginning"
        begin = time.perf_counter()
        self.connection.send((kind, number))
        while True:
            wrong = "hang"
            if self.connection.poll(self.patience):
                try:
                    word, value = self.connection.recv()
                except (EOFError, ConnectionResetError):
                    wrong = "death"
                else:
                    if word == "done":
                        return value
                    step = value
                    continue
            self.kill()
            code = self.process.exitcode or 0
            text = f"no end within {self.patience:.0f} s" if wrong == "hang" else _death(code)
            self.start()
            finding = {
                "kind": wrong,
                "where": step.partition(":")[0],
                "text": text,
                "meets": False,
                "case": step[:1500],
            }
            return Outcome(kind, number, 1, 0, time.perf_counter() - begin, [finding])

    def kill(self) -> None:
        """End the process and all that it started."""
        # By the group: readers and commands that it waits for would go on without it.
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self.process.pid, signal.SIGKILL)
        self.process.join()

    def end(self) -> None:
        """End the process when it has done its case."""
        with contextlib.suppress(BrokenPipeError):
            self.connection.send(None)
        self.process.join(10)
        self.kill()


def _death(code: int) -> str:
    return signal.Signals(-code).name if code < 0 else f"exit {code}"


def tasks(counts: dict[str, int], first: int) -> list[tuple[str, int]]:
    """Return the cases, the kinds mixed as their numbers are."""
    order = [(i / count, kind, first + i) for kind, count in counts.items() for i in range(count)]
    return [(kind, number) for _, kind, number in sorted(order)]


def run(
    todo: list[tuple[str, int]],
    seed: int,
    jobs: int,
    seconds: float,
    patience: float,
    tell: Callable[[Outcome], None],
) -> list[Outcome]:
    """Do cases in some processes, as far as the time goes."""
    lock, waiting, outcomes = threading.Lock(), iter(todo), []
    deadline = time.monotonic() + seconds

    def work() -> None:
        worker = Worker(seed, patience)
        while time.monotonic() < deadline:
            with lock:
                task = next(waiting, None)
            if task is None:
                break
            outcome = worker.do(*task)
            with lock:
                outcomes.append(outcome)
                tell(outcome)
        worker.end()

    threads = [threading.Thread(target=work) for _ in range(jobs)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return outcomes


# ------------------------------------------------------------------------------------------- the page


def page(outcomes: Sequence[Outcome], seed: int) -> list[str]:
    """Return the page."""
    lines = [
        "# Odd meshes and damaged files",
        "",
        "`python benchmarks/fuzz.py` makes odd meshes and damaged files at random and looks for what must",
        "never happen: a process that dies or hangs, an exception that is no sentence of ours, an empty",
        "result, a changed input, lost data, NaN, a broken guarantee. It checks guarantees from outside,",
        "with NumPy where that is possible. A refusal in one sentence is right.",
        "",
        f"Seed {seed}; {_versions()}.",
        "",
    ]
    head = ["cases", "number", "runs", "refused", *COLUMNS, "where constraints meet"]
    rows: list[list[Any]] = []
    for kind in KINDS:
        mine = [one for one in outcomes if one.kind == kind]
        if not mine:
            continue
        counts = Counter(column_of(one["kind"]) for case in mine for one in case.findings if not one["meets"])
        meets = sum(one["meets"] for case in mine for one in case.findings)
        runs, refused = sum(case.runs for case in mine), sum(case.refused for case in mine)
        numbers = [len(mine), runs, refused, *(counts[column] for column in COLUMNS), meets]
        rows.append([kind, *(f"{number:,}" for number in numbers)])
    lines += tables.table(head, rows)
    lines += [f"- **{kind}**: {text}." for kind, (_, text) in KINDS.items()]
    lines += [
        "",
        "The last column counts broken promises of runs in which several constraints acted at the same time.",
        "",
    ]
    groups: dict[tuple[bool, str, str], list[tuple[Outcome, dict[str, Any]]]] = {}
    for case in sorted(outcomes, key=lambda one: (one.kind, one.number)):
        for one in case.findings:
            groups.setdefault((one["meets"], one["kind"], one["where"]), []).append((case, one))
    for meets, title in ((False, "Findings"), (True, "Where constraints meet")):
        found = [[kind, where, len(all_), f"{all_[0][0].kind} {all_[0][0].number}", _cell(all_[0][1]["text"])]
                 for (meeting, kind, where), all_ in groups.items() if meeting == meets]  # fmt: skip
        if found:
            lines += [f"## {title}", ""]
            found.sort(key=lambda row: -row[2])
            lines += tables.table(["what", "where", "how often", "first case", "it says"], found)
    cases = len(outcomes)
    lines += [f"{cases:,} cases, {sum(one.seconds for one in outcomes) / 60:.0f} minutes of computing."]
    return lines


def _cell(text: str) -> str:
    return " ".join(text.replace("|", "/").replace("<", "&lt;").split())[:100]


def _versions() -> str:
    names = ("numpy", "numba", "vtk", "pyvista")
    return ", ".join(
        [f"Python {platform.python_version()}", *(f"{name} {metadata.version(name)}" for name in names)]
    )


def _read_journal(path: Path | None, seed: int) -> list[Outcome]:
    """Return what came of each case when it was done last."""
    if path is None or not path.exists():
        return []
    entries = [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]
    outcomes = {}
    for entry in entries:
        if entry["seed"] == seed:
            outcome = Outcome(**entry["outcome"])
            outcomes[outcome.kind, outcome.number] = outcome
    return list(outcomes.values())


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line."""
    parser = argparse.ArgumentParser(description="Odd meshes and damaged files at random.")
    for kind, (count, text) in KINDS.items():
        parser.add_argument(f"--{kind}", type=int, metavar="N", default=count, help=f"how many of: {text}")
    parser.add_argument("--only", choices=tuple(KINDS), help="cases of this kind only")
    parser.add_argument("--first", type=int, default=0, help="number of the first case of each kind")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="processes to use")
    parser.add_argument("--minutes", type=float, default=float("inf"), help="stop after this time")
    parser.add_argument("--patience", type=float, default=PATIENCE, help="seconds after which a run hangs")
    parser.add_argument("--journal", type=Path, help="file of the cases done; a run goes on where it ends")
    parser.add_argument("--output", type=Path, default=Path(__file__).parents[1] / "docs" / "fuzz.md")
    options = parser.parse_args(arguments)
    counts = {kind: getattr(options, kind) for kind in KINDS if options.only in (None, kind)}
    done = _read_journal(options.journal, options.seed)
    known = {(one.kind, one.number) for one in done if not one.findings}
    todo = [task for task in tasks(counts, options.first) if task not in known]
    begin = time.monotonic()

    with contextlib.ExitStack() as stack:
        journal = (
            stack.enter_context(options.journal.open("a", encoding="utf-8")) if options.journal else None
        )
        told = [0]

        def tell(outcome: Outcome) -> None:
            for one in outcome.findings:
                meets = " (constraints meet)" if one["meets"] else ""
                print(f"{outcome.kind} {outcome.number}: {one['kind']}{meets}, {one['where']}: {one['text']}")
                print(f"    {one['case']}", flush=True)
            if journal is not None:
                journal.write(json.dumps({"seed": options.seed, "outcome": asdict(outcome)}) + "\n")
                journal.flush()
            told[0] += 1
            if told[0] % 200 == 0:
                print(f"{told[0]} of {len(todo)} cases, {time.monotonic() - begin:.0f} s", flush=True)

        again = run(todo, options.seed, options.jobs, 60 * options.minutes, options.patience, tell)
    done = list({(one.kind, one.number): one for one in (*done, *again)}.values())
    lines = page(done, options.seed)
    print("\n".join(lines))
    options.output.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return int(any(not one["meets"] for case in done for one in case.findings))


if __name__ == "__main__":
    faulthandler.enable()
    sys.exit(main())
