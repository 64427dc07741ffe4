"""Reading sessions: layers, states, history and the rest, as far as they are there and understood."""

from __future__ import annotations

import contextlib
import dataclasses
import json
import lzma
import os
import struct
import tokenize
import zipfile
import zlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from vtkmodules.util.numpy_support import get_numpy_array_type, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkDataArray, vtkPoints, vtkStringArray
from vtkmodules.vtkCommonDataModel import vtkPolyData

from vtksmooth import recipe
from vtksmooth.errors import RecipeError, VtksmoothError
from vtksmooth.files import read_surface
from vtksmooth.filters.arrays import vtk_cells, vtk_points

from .document import Document
from .history import Step
from .layer import Layer, Role
from .measure import PICKS, Kind, Measurement
from .section import Plane
from .session import (
    ARRAYS,
    CELLS,
    DATA,
    FORMAT,
    JSON,
    VERSION,
    Drafts,
    Tell,
    Values,
    describe,
    digest,
    foreign,
    members_of,
    unknown,
)
from .state import Source, State

#: What a file that is not what it should be makes Python say.
_DAMAGE = (
    LookupError, TypeError, ValueError, AttributeError, EOFError, ArithmeticError, MemoryError, RuntimeError,
    SyntaxError, tokenize.TokenError, struct.error, zlib.error, lzma.LZMAError, zipfile.BadZipFile,
)  # fmt: skip


class SessionError(VtksmoothError, ValueError):
    """A session cannot be read."""


@dataclass(eq=False)
class Stored:
    """A session that has been found, and read as far as its JSON.

    Attributes
    ----------
    path : Path
        The file or folder.
    manifest : dict
    newer : bool
        Whether a newer version has written it.
    """

    path: Path
    manifest: dict[str, Any]
    newer: bool

    @property
    def name(self) -> str:
        """The layers, as a short text.

        Raises
        ------
        SessionError
            The session is damaged.
        """
        try:
            names = [str(layer.get("name", "")) for layer in self.manifest.get("layers", [])]
        except _DAMAGE as error:
            raise self.damage(error) from error
        return ", ".join(names[:3]) + (" …" if len(names) > 3 else "")

    @property
    def missing(self) -> list[Path]:
        """The meshes that are not where they were, each once."""
        try:
            places = [entry["file"] for entry in self.manifest["states"] if "file" in entry]
            paths = dict.fromkeys(self.find(place) for place in places)
        except _DAMAGE as error:
            raise self.damage(error) from error
        return [path for path in paths if not path.is_file()]

    def find(self, place: Mapping[str, str]) -> Path:
        """Return the file that a path in the JSON means: seen from the session, else as it was."""
        folder = self.path.absolute() if self.path.is_dir() else self.path.absolute().parent
        beside = Path(os.path.normpath(folder / place["relative"]))
        before = Path(place["absolute"])
        return before if before.is_file() and not beside.is_file() else beside

    def damage(self, error: BaseException) -> SessionError:
        """Return what to say of a session that cannot be understood."""
        if self.newer:
            maker, number = self.manifest.get("vtksmooth", "version"), self.manifest.get("version")
            return SessionError(
                f"{self.path.name} was saved by a newer vtksmooth ({maker}, sessions of version {number}; "
                f"this one knows up to {VERSION}) and cannot be opened here; update vtksmooth."
            )
        reason = f"{type(error).__name__}: {error}".strip(": ").split("\n")[0]
        reason = reason if len(reason) <= 300 else f"{reason[:300]}…"  # it may hold names of any length
        return SessionError(f"{self.path.name} is damaged ({reason}); open a copy, or the meshes.")


@contextlib.contextmanager
def _files(path: Path) -> Iterator[Any]:
    """Give the place of the session's files, in a folder or a zip file."""
    if path.is_dir():
        yield path
        return
    with zipfile.ZipFile(path) as archive:
        yield zipfile.Path(archive)


def find(path: Path) -> Stored:
    """Read the JSON of a session file or folder.

    Raises
    ------
    SessionError
        It is no session, is damaged, or cannot be read.
    """
    try:
        with _files(path) as root:
            manifest = json.loads((root / JSON).read_text(encoding="utf-8-sig"))
    except OSError as error:
        if path.exists() and not isinstance(error, PermissionError):
            raise SessionError(f"{path.name} is no session of vtksmooth; open it as a mesh.") from error
        raise SessionError(f"cannot read {path}: {error.strerror or error}; check the path.") from error
    except _DAMAGE as error:
        raise SessionError(f"{path.name} is damaged or no session of vtksmooth ({error}).") from error
    if not isinstance(manifest, dict) or manifest.get("format") != FORMAT:
        raise SessionError(f"{path.name} is no session of vtksmooth.")
    number = manifest.get("version")
    return Stored(path, manifest, isinstance(number, int) and number > VERSION)


@dataclass
class Restored:
    """What a session holds.

    Attributes
    ----------
    layers : list of Layer
    steps : list of Step
    index : int
    active, compared : Layer or None
    unit : str
    measurements : list of Measurement
    plane : Plane or None
    drafts : dict
        Recipes with edits that had not been run, and their meshes, by layer.
    more : dict
        What the windows had kept, and what no version so far knows.
    members : dict
        Arrays that this version does not know.
    notes : list of str
        What a user should know.
    """

    layers: list[Layer]
    steps: list[Step]
    index: int
    active: Layer | None
    compared: Layer | None
    unit: str
    measurements: list[Measurement]
    plane: Plane | None
    drafts: Drafts
    more: dict[str, Any]
    members: dict[str, bytes] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)


_KNOWN = frozenset(
    [
        "format",
        "version",
        "vtksmooth",
        "unit",
        "layers",
        "active",
        "compared",
        "history",
        "measurements",
        "plane",
        "states",
    ]
)


def restore(
    stored: Stored, located: Mapping[Path, Path | None], tell: Tell = lambda fraction: None
) -> Restored:
    """Read a session.

    Parameters
    ----------
    stored : Stored
    located : mapping
        Where the files are that were missing; None: do without.
    tell : callable

    Raises
    ------
    SessionError
        It is damaged, or of a newer version and not to be understood.
    MeshFileError
        A mesh that it refers to cannot be read.
    """
    try:
        with _files(stored.path) as root:
            return _Reader(stored, root, located, tell).read()
    except VtksmoothError:
        raise
    except (*_DAMAGE, OSError) as error:
        raise stored.damage(error) from error


def apply(restored: Restored, document: Document, known: frozenset[str]) -> None:
    """Make a document be what a session holds; `known` are the keys that the windows know."""
    unknown[document] = {key: value for key, value in restored.more.items() if key not in known}
    members_of[document] = restored.members
    document.measurements = restored.measurements
    document.unit, document.plane, document.compared = restored.unit, restored.plane, restored.compared
    document.restore(restored.layers, restored.active, restored.steps, restored.index)


class _Reader:
    """Makes layers, states and steps of a session."""

    def __init__(self, stored: Stored, root: Any, located: Mapping[Path, Path | None], tell: Tell) -> None:
        self.stored, self.located, self.tell = stored, located, tell
        self.manifest, self.root = stored.manifest, root
        self.notes: list[str] = []
        #: Arrays by name, and what VTK makes of them: one for all states.
        self.arrays: dict[str, Values] = {}
        self.made: dict[Any, Any] = {}
        self.states: list[State | None] = []
        self.drafts: dict[Layer, tuple[recipe.Recipe, Mapping[Source, State]]] = {}

    def read(self) -> Restored:
        manifest = self.manifest
        if self.stored.newer:
            self.notes.append(
                f"{self.stored.path.name} was saved by a newer vtksmooth ({manifest.get('vtksmooth')}): "
                "what this one does not know is kept, and not shown."
            )
        self._read_states()
        layers: list[Layer | None] = [self._layer(entry) for entry in manifest["layers"]]
        steps, index = self._history(layers)
        shown = [layer for layer in layers if layer is not None]

        def layer(number: int | None) -> Layer | None:
            return None if number is None else layers[number]

        measurements = []
        for entry in manifest.get("measurements", []):
            on = layer(entry["layer"])
            if on is not None and entry["kind"] in [*Kind]:
                vertices = self._array(entry["vertices"]).astype(np.int64)
                kind = Kind(entry["kind"])
                if len(vertices) < 1 or len(vertices) != PICKS.get(kind, len(vertices)):
                    raise ValueError("a measurement has too few points, or too many")
                if not 0 <= vertices.min() <= vertices.max() < entry["n_points"]:
                    raise ValueError("a measurement refers to points that are not there")
                one = Measurement(kind, on, vertices, entry["n_points"])
                self._keep_unknown(one, entry, "kind layer vertices n_points")
                measurements.append(one)
        plane = manifest.get("plane")
        members = {
            Path(member.name).stem: member.read_bytes()
            for member in ((self.root / ARRAYS).iterdir() if (self.root / ARRAYS).exists() else ())
            if member.name.endswith(".npy") and Path(member.name).stem not in self.arrays
        }
        return Restored(
            shown,
            steps,
            index,
            layer(manifest.get("active")),
            layer(manifest.get("compared")),
            str(manifest.get("unit", "")),
            measurements,
            None if plane is None else Plane.of(plane["origin"], plane["normal"]),
            self.drafts,
            {key: value for key, value in manifest.items() if key not in _KNOWN},
            members,
            self.notes,
        )

    # -- states ------------------------------------------------------------------------------------

    def _read_states(self) -> None:
        entries = self.manifest["states"]
        files = {i: self._file(entry["file"]) for i, entry in enumerate(entries) if "file" in entry}
        opened: dict[Path, State] = {}
        for path in files.values():
            if path is not None and path not in opened:
                opened[path] = State.of(read_surface(path)[0])
                self.arrays |= describe(opened[path])[1]
        for i, entry in enumerate(entries):
            self.tell(i / len(entries))
            if i not in files:
                self.states.append(self._state(entry))
                continue
            path = files[i]
            if path is None:
                self.states.append(None)
                continue
            now = describe(opened[path])[0]
            if all(entry[key] == now[key] for key in ("points", "cells")):
                self.states.append(self._state(entry))
            else:
                self.notes.append(
                    f"{path.name} has changed since the session was saved; it is shown as it is."
                )
                self.states.append(opened[path])
        for state, entry in zip(self.states, entries, strict=True):
            if state is not None:
                self._made_by(state, entry)
                self._keep_unknown(state, entry, "points cells file recipe did sources", *DATA)

    def _file(self, place: Mapping[str, str]) -> Path | None:
        path = self.stored.find(place)
        return self.located.get(path) if path in self.located else path

    def _made_by(self, state: State, entry: dict[str, Any]) -> None:
        """Say what made a state, where it can be said."""
        try:
            found = self._recipe(entry)
        except RecipeError as error:
            named = [(name if "role" in name else self._now(name), n) for name, n in entry["sources"]]
            sources = [(name, its) for name, n in named if (its := self.states[n]) is not None]
            foreign[state] = entry["recipe"], entry.get("did", []), sources
            self.notes.append(f"A recipe in the session cannot be changed here: {error}")
            return
        if found is not None:
            state.recipe, state.sources = found
            # One for each step, whatever the file says.
            did, steps = [str(words) for words in entry.get("did", ())], len(state.recipe)
            state.did = (*did, *[""] * steps)[:steps]

    def _recipe(self, entry: dict[str, Any]) -> tuple[recipe.Recipe, dict[Source, State]] | None:
        """Return a recipe and the meshes of its sources; None if one of these is missing."""
        sources: dict[Source, State] = {}
        moved = {}
        for name, number in entry.get("sources", []):
            source = self.states[number]
            if source is None:
                return None
            if "role" in name:
                sources[name["role"]] = source
            else:
                moved[Path(name["absolute"])] = path = self._now(name)
                sources[path] = source
        text = json.dumps({"format": "vtksmooth recipe", "version": 1, "steps": entry.get("recipe", [])})
        steps = recipe.Recipe.from_json(text).steps
        return recipe.Recipe(tuple(_moved(step, moved) for step in steps)), sources

    def _now(self, place: Mapping[str, str]) -> Path:
        """Return where a file is now, or where it should be."""
        return self._file(place) or self.stored.find(place)

    def _state(self, entry: dict[str, Any]) -> State:
        mesh = vtkPolyData()
        points = None if entry["points"] is None else self._array(entry["points"])
        n_points = 0 if points is None else len(points)
        if points is not None:
            if points.ndim != 2 or points.shape[1] != 3 or points.dtype.kind != "f":
                raise ValueError("points are no coordinates")
            mesh.SetPoints(self._once(("points", entry["points"]), lambda: vtk_points(points)))
        else:
            mesh.SetPoints(vtkPoints())
        for kind, (offsets, corners) in entry["cells"].items():
            arrays = self._array(offsets), self._array(corners)
            cells = self._once((offsets, corners, n_points), partial(_cells, *arrays, n_points))
            if kind in CELLS:
                getattr(mesh, f"Set{kind}")(cells)
        for key, get in DATA.items():
            data = getattr(mesh, get)()
            size = {"point_data": n_points, "cell_data": mesh.GetNumberOfCells()}.get(key)
            for one in entry.get(key, []):
                self._add_array(data, one, size)
        return State.of(mesh)

    def _add_array(self, data: Any, entry: dict[str, Any], size: int | None) -> None:
        if "text" in entry:
            words = entry["text"]
            # VTK ends the process where a text is none, or cannot be written as UTF-8.
            if not all(isinstance(word, str) for word in words):
                raise ValueError(f"the array {entry['name']!r} holds other than texts")
            "".join(words).encode()  # a ValueError where one cannot be
            components = max(1, len(words) // size) if size else 1
            if size is not None and len(words) != components * size:
                raise ValueError(f"the array {entry['name']!r} has {len(words)} values for {size}")
            text = vtkStringArray()
            text.SetNumberOfComponents(components)
            if entry["name"] is not None:
                text.SetName(entry["name"])
            for word in words:
                text.InsertNextValue(word)
            data.AddArray(text)
            return
        values = self._array(entry["array"])
        if size is not None and len(values) != size:
            raise ValueError(f"the array {entry['name']!r} has {len(values)} values for {size}")

        def make() -> Any:
            get_numpy_array_type(entry["type"])  # a KeyError where VTK would take another
            array = vtkDataArray.CreateDataArray(entry["type"])
            array.SetNumberOfComponents(1 if values.ndim == 1 else values.shape[1])
            array.SetNumberOfTuples(len(values))
            if len(values):
                vtk_to_numpy(array)[...] = values
            if entry["name"] is not None:
                array.SetName(entry["name"])
            return array

        added = data.AddArray(self._once((entry["array"], entry["type"], entry["name"]), make))
        if entry.get("attribute", -1) >= 0 and size is not None:
            data.SetActiveAttribute(added, entry["attribute"])

    def _once(self, key: Any, make: Callable[[], Any]) -> Any:
        if key not in self.made:
            self.made[key] = make()
        return self.made[key]

    def _array(self, name: str) -> Values:
        if name not in self.arrays:
            with (self.root / ARRAYS / f"{name}.npy").open("rb") as file:
                values = np.lib.format.read_array(file, allow_pickle=False)
            if digest(values) != name:
                raise ValueError(f"the array {name} has other content than its name says")
            self.arrays[name] = values
        return self.arrays[name]

    # -- layers and steps --------------------------------------------------------------------------

    def _layer(self, entry: dict[str, Any]) -> Layer | None:
        opened, state, saved = (
            None if entry[key] is None else self.states[entry[key]] for key in ("opened", "state", "saved")
        )
        first = opened or state or saved
        if first is None:
            self.notes.append(f"The layer {entry['name']} was left out: its mesh is missing.")
            return None
        layer = Layer(entry["name"], first)
        layer.state, layer.saved, layer.visible = state, saved, bool(entry.get("visible", True))
        layer.source, layer.path = (
            None if entry.get(key) is None else self._now(entry[key]) for key in ("source", "path")
        )
        if entry.get("role") in [*Role]:
            layer.role = Role(entry["role"])
        if entry.get("draft") is not None:
            with contextlib.suppress(RecipeError):  # the recipe itself has been told of
                found = self._recipe(entry["draft"])
                if found is not None:
                    self.drafts[layer] = found
        self._keep_unknown(layer, entry, "name role visible source path opened state saved draft")
        return layer

    def _history(self, layers: list[Layer | None]) -> tuple[list[Step], int]:
        history = self.manifest["history"]
        steps, index = [], int(history["index"])
        for place, entry in enumerate(history["steps"]):
            whole, changes = True, {}
            for number, *ends in entry["changes"]:
                layer, sides = layers[number], [None if end is None else self.states[end] for end in ends]
                whole &= [side is None for side in sides] == [end is None for end in ends]
                if layer is not None:
                    changes[layer] = (sides[0], sides[1])
            between = [self.states[number] for number in entry.get("between", [])]
            if not whole and place >= index:
                break  # what was undone and cannot be done again
            step = Step(
                entry["title"],
                changes,
                entry.get("summary", ""),
                tuple(state for state in between if state is not None),
            )
            for number, before, after in entry.get("roles", []):
                layer = layers[number]
                if layer is not None and before in [*Role] and after in [*Role]:
                    step.roles[layer] = (Role(before), Role(after))
            if entry.get("settled") or not whole:
                step.settle()
            self._keep_unknown(step, entry, "title summary settled changes between roles")
            steps.append(step)
        if not 0 <= index <= len(steps):
            raise ValueError("the history has fewer steps than are in effect")
        return steps, index

    @staticmethod
    def _keep_unknown(what: Any, entry: dict[str, Any], known: str, *more: str) -> None:
        left = {key: value for key, value in entry.items() if key not in (*known.split(), *more)}
        if left:
            unknown[what] = {**unknown.get(what, {}), **left}


def _moved(step: recipe.Step, moved: Mapping[Path, Path]) -> recipe.Step:
    """Return a step whose files are where they are now."""
    inputs = {
        name: moved.get(Path(os.path.abspath(source)), source) if isinstance(source, Path) else source
        for name, source in step.inputs.items()
    }
    return dataclasses.replace(step, inputs=inputs)


def _cells(offsets: Values, corners: Values, n_points: int) -> Any:
    """Return cells, checked: VTK would read foreign memory."""
    if (
        (offsets.ndim, corners.ndim) != (1, 1) or {offsets.dtype.kind, corners.dtype.kind} - {*"iu"}
        or offsets[0] != 0 or offsets[-1] != len(corners) or (np.diff(offsets.astype(np.int64)) < 0).any()
        or (len(corners) and not 0 <= corners.min() <= corners.max() < n_points)
    ):  # fmt: skip
        raise ValueError("cells refer to points that are not there")
    return vtk_cells(offsets, corners)
