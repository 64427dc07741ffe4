"""Recipes: what is done to a mesh, as an ordered list of steps that can be kept, edited and replayed.

A recipe runs the same filters as a script, the command line and the application do, with the same numbers.
It can be written as JSON, as a Python script (a VTK pipeline, or PyVista) and as command lines.
"""

from __future__ import annotations

import dataclasses
import json
import shlex
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from importlib.metadata import version
from pathlib import Path
from types import MappingProxyType
from typing import Any

from .accessor import method_name
from .errors import RecipeError, VtksmoothError
from .files import atomic, read_surface
from .filters import FILTERS, Filter, Parameter

#: The version of the JSON that is written, and the newest that is read.
VERSION = 1
_FORMAT = "vtksmooth recipe"

#: The role of the mesh that a recipe is run on, as it was before the first step.
ORIGINAL = "original"

#: Filters by their command names.
COMMANDS: Mapping[str, type[Filter]] = MappingProxyType({cls.command: cls for cls in FILTERS})

Apply = Callable[..., Any]

#: Letters of a value that people are shown; lists of points may have thousands.
_LONGEST = 60


def shown(value: Any) -> str:
    """Return a parameter's value for people, cut short where it is long.

    Examples
    --------
    >>> shown("0-14,20"), shown("1" * 99) == "1" * 60 + "…"
    ('0-14,20', True)
    """
    text = str(value)
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}…"


@dataclass(frozen=True)
class Step:
    """One step of a recipe: a filter, its parameters and its further inputs. It cannot be changed.

    Parameters
    ----------
    command : str
        The filter's name on the command line.
    parameters : mapping of str to value
        Values by name; those that are the defaults are left out.
    inputs : mapping of str to str or Path
        What the filter's further inputs are, by their names: a Path is a file, a text is a role, whose
        mesh is given when the recipe runs. The role ``"original"`` is the mesh that the recipe is run
        on. An input that is not named has the role of its own name; an optional one is then left out.
    enabled : bool
        Whether the step is done.

    Raises
    ------
    RecipeError
        There is no such filter, input or parameter.
    ParameterError
        A value is not allowed.

    Examples
    --------
    >>> step = Step("trapezium-drawing", {"iterations": 8, "boundary": "fixed"})
    >>> dict(step.parameters)
    {'iterations': 8}
    >>> step.changed(iterations=5) == Step("trapezium-drawing")
    True
    """

    command: str
    parameters: Mapping[str, Any] = field(default_factory=dict)
    inputs: Mapping[str, str | Path] = field(default_factory=dict)
    enabled: bool = True

    def __post_init__(self) -> None:
        if self.command not in COMMANDS:
            known = ", ".join(COMMANDS)
            raise RecipeError(f"There is no filter {self.command!r}; there are: {known}.")
        declared = self.cls.parameters()
        _refuse_unknown(self.command, "parameter", self.parameters, declared)
        _refuse_unknown(self.command, "further input", self.inputs, self.cls.every_input()[1:])
        values = {
            name: parameter.check(self.parameters[name])
            for name, parameter in declared.items()
            if name in self.parameters
        }
        values = {name: value for name, value in values.items() if value != declared[name].default}
        inputs = {name: self.inputs.get(name, name) for name in self.cls.inputs[1:]}
        inputs |= {name: self.inputs[name] for name in self.cls.optional_inputs if name in self.inputs}
        object.__setattr__(self, "parameters", MappingProxyType(values))
        object.__setattr__(self, "inputs", MappingProxyType(inputs))

    def __hash__(self) -> int:
        return hash((self.command, *self.parameters.items(), *self.inputs.items(), self.enabled))

    @classmethod
    def of(cls, algorithm: Filter, inputs: Mapping[str, str | Path] | None = None) -> Step:
        """Return the step that does what `algorithm` does."""
        values = {name: getattr(algorithm, name) for name in algorithm.parameters()}
        return cls(algorithm.command, values, inputs or {})

    @property
    def cls(self) -> type[Filter]:
        """The filter's class."""
        return COMMANDS[self.command]

    @property
    def named_inputs(self) -> dict[str, str | Path]:
        """The inputs that must be named: the others are what they are without."""
        return {
            name: source
            for name, source in self.inputs.items()
            if source != name or name in self.cls.optional_inputs
        }

    def make(self) -> Filter:
        """Return a new filter with the step's parameters."""
        return self.cls(**self.parameters)

    def changed(self, **parameters: Any) -> Step:
        """Return the step with other values of `parameters`."""
        return dataclasses.replace(self, parameters={**self.parameters, **parameters})

    def options(self) -> list[str]:
        """Return the command line's options for the parameters.

        Raises
        ------
        RecipeError
            An array is called "off", which means no array on the command line.
        """
        declared = self.cls.parameters()
        return [_option(declared[name], value) for name, value in self.parameters.items()]

    def __str__(self) -> str:
        inputs = [f"{name}={source}" for name, source in self.named_inputs.items()]
        values = [f"{name}={shown(value)}" for name, value in self.parameters.items()]
        return f"{self.command} {', '.join([*inputs, *values])}".rstrip()


@dataclass(frozen=True)
class Result:
    """What a step did.

    Attributes
    ----------
    index : int
        Number of the step in the recipe, from 0.
    step : Step
    mesh : vtkPolyData
        The mesh after the step. A step that only measures leaves it as it was; `outputs` has the arrays.
    outputs : tuple of vtkPolyData
        All that the filter made.
    algorithm : Filter
        The filter that ran, with its ``figures``.
    seconds : float
    """

    index: int
    step: Step
    mesh: Any
    outputs: tuple[Any, ...]
    algorithm: Filter
    seconds: float


@dataclass(frozen=True)
class Recipe:
    r"""Steps in their order. It cannot be changed: what edits it returns another one.

    Parameters
    ----------
    steps : iterable of Step

    Guarantees
    ----------
    Running a recipe, calling its filters one after the other, the scripts and the command lines made from
    it give the same points, bit for bit. Writing it as JSON and reading it gives an equal recipe.

    Examples
    --------
    >>> from vtkmodules.vtkFiltersSources import vtkSphereSource
    >>> sphere = vtkSphereSource()
    >>> _ = sphere.Update()
    >>> recipe = Recipe([Step("trapezium-drawing"), Step("compare")])
    >>> for result in recipe.results(sphere.GetOutput()):
    ...     print(result.step)
    trapezium-drawing
    compare
    >>> print(*recipe.command_lines("part.ply", "better.ply"), sep="\n")
    vtksmooth trapezium-drawing part.ply better.ply
    vtksmooth compare part.ply better.ply
    """

    steps: tuple[Step, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "steps", tuple(self.steps))

    def __len__(self) -> int:
        return len(self.steps)

    # -- editing -----------------------------------------------------------------------------------

    def added(self, step: Step, index: int | None = None) -> Recipe:
        """Return the recipe with `step` before the one numbered `index`, or at the end."""
        steps = list(self.steps)
        steps.insert(len(steps) if index is None else index, step)
        return Recipe(tuple(steps))

    def removed(self, index: int) -> Recipe:
        """Return the recipe without a step."""
        return Recipe(self.steps[:index] + self.steps[index + 1 :])

    def replaced(self, index: int, step: Step) -> Recipe:
        """Return the recipe with `step` in place of another one."""
        return Recipe((*self.steps[:index], step, *self.steps[index + 1 :]))

    def moved(self, index: int, to: int) -> Recipe:
        """Return the recipe with a step moved, so that it has the number `to`."""
        return self.removed(index).added(self.steps[index], to)

    def switched(self, index: int, enabled: bool) -> Recipe:
        """Return the recipe with a step switched on or off."""
        return self.replaced(index, dataclasses.replace(self.steps[index], enabled=enabled))

    def changed(self, index: int, **parameters: Any) -> Recipe:
        """Return the recipe with other values of a step's parameters."""
        return self.replaced(index, self.steps[index].changed(**parameters))

    def first_difference(self, other: Recipe) -> int:
        """Return the number of the first step that `other` does not share: what to run again from."""
        shared = zip(self.steps, other.steps, strict=False)
        return next((i for i, (a, b) in enumerate(shared) if a != b), min(len(self), len(other)))

    # -- running -----------------------------------------------------------------------------------

    @property
    def enabled(self) -> list[tuple[int, Step]]:
        """The steps that are switched on, with their numbers."""
        return [(index, step) for index, step in enumerate(self.steps) if step.enabled]

    @property
    def sources(self) -> list[str | Path]:
        """Roles and files that the enabled steps need beside the mesh itself, each once."""
        every = [source for _, step in self.enabled for source in step.inputs.values()]
        return [source for source in dict.fromkeys(every) if source != ORIGINAL]

    def read_inputs(
        self,
        files: Mapping[str, str | Path] | None = None,
        read: Callable[[Path], Any] = lambda path: read_surface(path)[0],
    ) -> dict[str | Path, Any]:
        """Read what the enabled steps need beside the mesh itself.

        Parameters
        ----------
        files : mapping of str to path
            The files of roles.
        read : callable
            Reads one mesh.

        Returns
        -------
        dict
            Meshes by role or path, as :meth:`results` takes them.

        Raises
        ------
        RecipeError
            A role has no file, or a file has a role that no step has.
        MeshFileError
            A file cannot be read.
        """
        return {source: read(path) for source, path in self._files(files or {}).items()}

    def results(
        self,
        mesh: Any,
        inputs: Mapping[str | Path, Any] | None = None,
        *,
        start: int = 0,
        current: Any = None,
        apply: Apply = Filter.__call__,
    ) -> Iterator[Result]:
        """Run the enabled steps one by one, and yield what each of them did.

        Parameters
        ----------
        mesh : vtkPolyData
            The mesh to work on; it is not changed.
        inputs : mapping of str or Path to vtkPolyData
            The meshes of roles, and of files that have been read already; other files are read.
        start : int
            The first step to do. The steps before it have been done by the caller.
        current : vtkPolyData, optional
            What the steps before `start` have made of `mesh`.
        apply : callable
            Called with each filter and its inputs, to run it: ``apply(algorithm, *inputs)``.

        Raises
        ------
        RecipeError
            The mesh of a role is missing.
        InvalidMeshError, ParameterError, Cancelled
            What ended the run.
        """
        given = {ORIGINAL: mesh, **(inputs or {})}
        for source in self.sources:
            if source not in given:
                if not isinstance(source, Path):
                    raise _missing(source)
                given[source] = read_surface(source)[0]
        current = mesh if current is None else current
        for index, step in self.enabled:
            if index < start:
                continue
            algorithm: Any = step.make()
            begin = time.perf_counter()
            apply(algorithm, current, *(given[source] for source in step.inputs.values()))
            seconds = time.perf_counter() - begin
            outputs = tuple(algorithm.GetOutput(port) for port in range(len(step.cls.outputs)))
            if not step.cls.measures:
                current = outputs[0]
            yield Result(index, step, current, outputs, algorithm, seconds)

    def run(self, mesh: Any, inputs: Mapping[str | Path, Any] | None = None) -> Any:
        """Run the enabled steps and return the mesh that they make; see :meth:`results`.

        Examples
        --------
        >>> import pyvista as pv
        >>> Recipe([Step("laplacian", {"iterations": 2})]).run(pv.Sphere()).GetNumberOfPoints()
        842
        """
        for result in self.results(mesh, inputs):
            mesh = result.mesh
        return mesh

    # -- JSON --------------------------------------------------------------------------------------

    def to_json(self, folder: Path | None = None) -> str:
        """Return the recipe as JSON; files inside `folder` are named relative to it."""

        def place(source: str | Path) -> dict[str, str]:
            if not isinstance(source, Path):
                return {"role": source}
            path = source.expanduser().absolute()
            inside = folder is not None and path.is_relative_to(folder.absolute())
            return {"path": (path.relative_to(folder.absolute()) if folder and inside else path).as_posix()}

        def entry(step: Step) -> dict[str, Any]:
            inputs = {name: place(source) for name, source in step.named_inputs.items()}
            return {
                "filter": step.command,
                **({"parameters": dict(step.parameters)} if step.parameters else {}),
                **({"inputs": inputs} if inputs else {}),
                **({} if step.enabled else {"enabled": False}),
            }

        document = {"format": _FORMAT, "version": VERSION, "vtksmooth": version("vtksmooth")}
        return json.dumps(document | {"steps": [entry(step) for step in self.steps]}, indent=2) + "\n"

    @classmethod
    def from_json(cls, text: str, folder: Path | None = None) -> Recipe:
        """Return the recipe that a JSON text holds; relative paths in it are taken from `folder`.

        Raises
        ------
        RecipeError
            The text is no recipe, is one of a newer version, or has filters or parameters that this
            version does not know or allow.
        """
        try:
            document = json.loads(text)
        except (ValueError, RecursionError) as error:
            raise RecipeError(f"It is no JSON ({error}).") from error
        if not isinstance(document, dict) or document.get("format") != _FORMAT:
            raise RecipeError(f'It is no recipe: it does not say "format": "{_FORMAT}".')
        number = document.get("version")
        if type(number) is not int or number < 1:
            raise RecipeError(f"Its version must be a whole number from 1 to {VERSION}, not {number!r}.")
        if number > VERSION:
            maker = document.get("vtksmooth", "a newer version")
            raise RecipeError(
                f"It is a recipe of version {number}, written by vtksmooth {maker}; this vtksmooth "
                f"({version('vtksmooth')}) reads up to version {VERSION}, update it."
            )
        _check_keys(document, {"format": str, "version": int, "vtksmooth": str, "steps": list}, "The recipe")
        steps = []
        for place, entry in enumerate(document.get("steps", []), 1):
            try:
                steps.append(_step(entry, folder or Path()))
            except VtksmoothError as error:
                raise RecipeError(f"Step {place}: {error}") from error
        return cls(tuple(steps))

    def save(self, path: str | Path) -> None:
        """Write the recipe as JSON, completely or not at all; files beside it are named relative to it.

        Raises
        ------
        MeshFileError
            The file cannot be written.
        """
        path = Path(path).expanduser()
        with atomic(path) as temporary:
            temporary.write_text(self.to_json(path.absolute().parent), encoding="utf-8")

    @classmethod
    def load(cls, path: str | Path) -> Recipe:
        """Read a recipe that :meth:`save` has written.

        Raises
        ------
        RecipeError
            The file cannot be read, or see :meth:`from_json`.
        """
        path = Path(path).expanduser()
        try:
            return cls.from_json(path.read_text(encoding="utf-8-sig"), path.absolute().parent)
        except RecipeError as error:
            raise RecipeError(f"{path}: {error}") from error
        except UnicodeDecodeError as error:
            raise RecipeError(f"{path}: It is no JSON (not UTF-8); name a recipe.") from error
        except OSError as error:
            raise RecipeError(f"cannot read {path}: {error.strerror or error}; check the path.") from error

    # -- command lines and scripts -----------------------------------------------------------------

    def command_lines(
        self, source: str | Path, target: str | Path, files: Mapping[str, str | Path] | None = None
    ) -> list[str]:
        """Return command lines (for a POSIX shell) that make `target` of `source`.

        Between two steps the mesh is in a VTP file beside `target`, which keeps its points bit for bit.

        Parameters
        ----------
        source, target : path
            The mesh file to read, and the one to write.
        files : mapping of str to path
            The files of roles.

        Raises
        ------
        RecipeError
            A role has no file; or see :meth:`Step.options`.
        """
        paths: dict[str | Path, str | Path] = {**self._files(files or {}), ORIGINAL: source}
        changing = [index for index, step in self.enabled if not step.cls.measures]
        current, target = Path(source), Path(target)
        lines = []
        for index, step in self.enabled:
            names = {step.cls.inputs[0]: current, **{n: paths[s] for n, s in step.inputs.items()}}
            words = [str(names[name]) for name in step.cls.arguments or step.cls.inputs]
            if not step.cls.measures:
                between = target.with_name(f"{target.stem}.step{index + 1}.vtp")
                current = target if index == changing[-1] else between
                words.append(str(current))
            words = [f"./{word}" if word.startswith("-") else word for word in words]
            words += [f"--{name}={names[name]}" for name in step.cls.optional_inputs if name in names]
            lines.append(shlex.join(["vtksmooth", step.command, *words, *step.options()]))
        return lines

    def vtk_script(
        self,
        source: str | Path = "mesh.vtp",
        target: str | Path = "result.vtp",
        files: Mapping[str, str | Path] | None = None,
    ) -> str:
        """Return a Python script that does the same in a VTK pipeline; see :meth:`command_lines`."""
        paths = self._files(files or {})
        names = _names(paths)
        last = ""
        body: list[str] = []
        used: set[str] = set()
        for number, step in enumerate(self.steps, 1):
            body += ["", _heading(number, step)]
            if not step.enabled:
                continue
            name = step.command.replace("-", "_")
            name = f"{name}_{number}" if name in used else name
            used.add(name)
            body.append(f"{name} = {step.cls.__name__}()")
            for key, value in step.parameters.items():
                body.append(f"{name}.Set{step.cls.parameters()[key].camel}({_literal(value)})")
            body.append(
                f"{name}.SetInputConnection({last}.GetOutputPort())" if last else f"{name}.SetInputData(mesh)"
            )
            for further, given in step.inputs.items():
                port = step.cls.every_input().index(further)
                body.append(f"{name}.SetInputData({port}, {names[given]})")
            body += [f"{name}.Update()", f'print("{step.command}:", {name}.figures)']
            if not step.cls.measures:
                last = name
        body += ["", f"write_surface({f'{last}.GetOutput()' if last else 'mesh'}, target)"]
        imports = ", ".join(sorted({step.cls.__name__ for _, step in self.enabled}))
        head = [f"from vtksmooth.filters import {imports}"] if imports else []
        return _script("VTK pipeline", source, target, paths, head, body)

    def pyvista_script(
        self,
        source: str | Path = "mesh.vtp",
        target: str | Path = "result.vtp",
        files: Mapping[str, str | Path] | None = None,
    ) -> str:
        """Return a Python script that does the same with PyVista; see :meth:`command_lines`."""
        paths = self._files(files or {})
        names = _names(paths)
        body = ["result = mesh"]
        for number, step in enumerate(self.steps, 1):
            body += ["", _heading(number, step)]
            if not step.enabled:
                continue
            arguments = [
                f"{further}={names[one]}" if further in step.cls.optional_inputs else names[one]
                for further, one in step.inputs.items()
            ]
            arguments += [f"{key}={_literal(value)}" for key, value in step.parameters.items()]
            name = "measured" if step.cls.measures else "result"
            call = f"{name} = result.vtksmooth.{method_name(step.cls)}("
            line = f"{call}{', '.join(arguments)})"
            if len(line) > 88:
                line = "\n".join([call, *(f"    {argument}," for argument in arguments), ")"])
            told = f"{{key: value.tolist() for key, value in {name}.field_data.items()}}"
            body += [line, f'print("{step.command}:", {told})']
        body += ["", "write_surface(result, target)"]
        return _script("PyVista script", source, target, paths, [], body)

    def _files(self, files: Mapping[str, str | Path]) -> dict[str | Path, Path]:
        """Return the path of each source."""
        for role in files:
            if role not in self.sources:
                roles = ", ".join(str(s) for s in self.sources if not isinstance(s, Path)) or "none"
                raise RecipeError(f"No step needs a mesh of the role {role!r}; the roles are: {roles}.")
        paths = {}
        for source in self.sources:
            if not isinstance(source, Path) and source not in files:
                raise _missing(source)
            paths[source] = source if isinstance(source, Path) else Path(files[source])
        return paths


# ------------------------------------------------------------------------------------------ helpers


def _refuse_unknown(command: str, kind: str, given: Any, known: Any) -> None:
    for name in given:
        if name not in known:
            names = ", ".join(known) or "none"
            raise RecipeError(f"The filter {command} has no {kind} {name!r}; it has: {names}.")


def _missing(role: str) -> RecipeError:
    return RecipeError(f"The recipe needs a mesh of the role {role!r}; give one.")


def _option(parameter: Parameter, value: Any) -> str:
    name = parameter.name.replace("_", "-")
    if parameter.type is bool:
        return f"--{name}" if value else f"--no-{name}"
    if value == "off" and parameter.optional:
        raise RecipeError(
            f"{parameter.name}: 'off' means no array on the command line; give the array another name."
        )
    return f"--{name}={'off' if value is None else value}"


def _literal(value: Any) -> str:
    # JSON's texts are Python's too, in the usual quotes.
    return json.dumps(value, ensure_ascii=False) if isinstance(value, str) else repr(value)


def _heading(number: int, step: Step) -> str:
    return f"# Step {number}" if step.enabled else f"# Step {number} ({step.command}) is switched off."


def _names(paths: Mapping[str | Path, Path]) -> dict[str | Path, str]:
    """Return the variable of each source in a script."""
    return {ORIGINAL: "mesh", **{source: f"input_{i}" for i, source in enumerate(paths, 1)}}


def _script(
    kind: str,
    source: str | Path,
    target: str | Path,
    paths: Mapping[str | Path, Path],
    head: list[str],
    body: list[str],
) -> str:
    names = _names(paths)
    lines = [
        f'"""{kind} of a vtksmooth recipe.',
        "",
        "    python SCRIPT [IN OUT]",
        '"""',
        "",
        "import sys",
        "",
        "from vtksmooth.files import read_surface, write_surface",
        *head,
        "",
        f"source, target = sys.argv[1:] or ({_literal(str(source))}, {_literal(str(target))})",
        "mesh, notes = read_surface(source)",
        *(f"{names[key]}, notes = read_surface({_literal(str(path))})" for key, path in paths.items()),
        *body,
    ]
    return "\n".join([*lines, ""])


def _check_keys(entry: Any, known: Mapping[str, type], what: str) -> None:
    if not isinstance(entry, dict):
        raise RecipeError(f"{what} must be an object with the keys {', '.join(known)}.")
    for key, value in entry.items():
        if key not in known:
            raise RecipeError(f"{what} has the unknown key {key!r}; known are {', '.join(known)}.")
        if type(value) is not known[key]:
            names = {str: "a text", dict: "an object", list: "a list", bool: "true or false"}
            raise RecipeError(f"{what} has {value!r} as {key!r}; it must be {names.get(known[key])}.")


def _step(entry: Any, folder: Path) -> Step:
    _check_keys(entry, {"filter": str, "parameters": dict, "inputs": dict, "enabled": bool}, "It")
    if "filter" not in entry:
        raise RecipeError("It names no filter.")
    inputs: dict[str, str | Path] = {}
    for name, source in entry.get("inputs", {}).items():
        _check_keys(source, {"path": str, "role": str}, f"Its input {name!r}")
        if len(source) != 1:
            raise RecipeError(f"Its input {name!r} must have either a path or a role.")
        inputs[name] = source["role"] if "role" in source else folder / Path(source["path"])
    return Step(entry["filter"], entry.get("parameters", {}), inputs, entry.get("enabled", True))
