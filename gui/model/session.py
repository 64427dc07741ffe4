"""Sessions: everything as it was, kept as JSON and arrays.

A session is a zip file of ``session.json`` and ``arrays/NAME.npy`` (so that ``numpy.load`` opens its arrays
too); while it is being worked on, a folder of the same files. An array has the digest of its content as its
name: states that share arrays share them in the file, and a change costs what it changes. Meshes that are as
they were opened are referred to by the paths of their files.
"""

from __future__ import annotations

import hashlib
import json
import os
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any
from weakref import WeakKeyDictionary, WeakValueDictionary

import numpy as np
import numpy.typing as npt
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import VTK_BIT, VTK_UNSIGNED_CHAR, vtkDataArray, vtkStringArray

from vtksmooth import recipe
from vtksmooth.files import atomic
from vtksmooth.filters.arrays import cells_of, points_of

from .document import Document
from .history import Step
from .layer import Layer
from .measure import Measurement
from .state import Source, State

#: The version that is written, and the newest that is known.
VERSION = 1
#: How a session file is called.
SUFFIX = ".vtksmooth"

FORMAT = "vtksmooth session"
JSON, ARRAYS = "session.json", "arrays"
CELLS = ("Verts", "Lines", "Polys", "Strips")
DATA = {"point_data": "GetPointData", "cell_data": "GetCellData", "field_data": "GetFieldData"}
Values = npt.NDArray[Any]
JSONEntry = dict[str, Any]
#: Recipes with edits, and the meshes of their sources.
Drafts = Mapping[Layer, tuple[recipe.Recipe, Mapping[Source, State]]]
#: Told how far it is, 0 to 1; what it raises ends the work.
Tell = Callable[[float], None]

#: What other versions have said about things, to be said again when they are saved.
unknown: WeakKeyDictionary[Any, dict[str, Any]] = WeakKeyDictionary()
#: Arrays that only other versions know.
members_of: WeakKeyDictionary[Document, dict[str, bytes]] = WeakKeyDictionary()
#: Recipes, and what they did and took, that this version does not understand.
foreign: WeakKeyDictionary[State, tuple[Any, Any, list[tuple[Any, State]]]] = WeakKeyDictionary()
#: The arrays that have a name, so that equal ones are kept once.
_arrays: WeakValueDictionary[str, Values] = WeakValueDictionary()
#: The JSON and the arrays of states, which never change.
_described: WeakKeyDictionary[State, tuple[dict[str, Any], dict[str, Values]]] = WeakKeyDictionary()


@dataclass
class Snapshot:
    """A document at one moment; a worker may write it while the document goes on.

    Attributes
    ----------
    manifest : dict
        What becomes the JSON, without the states; files are Paths in it.
    states : list of State
    files : dict
        Of states that are in a file: that file, by their numbers.
    arrays : dict
        Arrays beside those of the states, by name.
    members : dict
        Arrays of other versions, as they are in their files.
    """

    manifest: dict[str, Any]
    states: list[State]
    files: dict[int, Path]
    arrays: dict[str, Values]
    members: dict[str, bytes]

    def contents(self, folder: Path) -> tuple[str, dict[str, Values]]:
        """Return the JSON and the arrays; `folder` is where relative paths begin."""
        arrays, entries = dict(self.arrays), []
        for number, state in enumerate(self.states):
            entry, needed = describe(state)
            entry = {**unknown.get(state, {}), **entry, **self.manifest["states"][number]}
            if number in self.files:
                entry["file"] = self.files[number]
            else:
                arrays |= needed
            entries.append(entry)
        manifest = {**self.manifest, "states": entries}
        return json.dumps(manifest, indent=1, default=lambda path: _place(path, folder)) + "\n", arrays


class _Capture:
    """What a snapshot is made of, while it is being made.

    Attributes
    ----------
    layers, states : dict
        Numbers of the layers, and of the states that have been met so far.
    arrays : dict
        Arrays beside those of the states, by name.
    """

    def __init__(self, layers: list[Layer]) -> None:
        self.layers = {layer: number for number, layer in enumerate(layers)}
        self.states: dict[State, int] = {}
        self.arrays: dict[str, Values] = {}

    def number(self, state: State | None) -> int | None:
        """Return the number of a state, which gets one if it has none."""
        return None if state is None else self.states.setdefault(state, len(self.states))

    def layer(self, layer: Layer, draft: tuple[recipe.Recipe, Mapping[Source, State]] | None) -> JSONEntry:
        """Return the entry of a layer, with the edits of its recipe."""
        return {
            **unknown.get(layer, {}),
            "name": layer.name,
            "role": layer.role.value,
            "visible": layer.visible,
            "source": layer.source,
            "path": layer.path,
            "opened": self.number(layer.opened),
            "state": self.number(layer.state),
            "saved": self.number(layer.saved),
            "draft": None if draft is None else self.recipe(*draft),
        }

    def step(self, step: Step) -> JSONEntry:
        """Return the entry of a step of the history."""
        return {
            **unknown.get(step, {}),
            "title": step.title,
            "summary": step.summary,
            "settled": step.settled,
            "changes": [
                [self.layers[layer], self.number(before), self.number(after)]
                for layer, (before, after) in step.changes.items()
                if layer in self.layers
            ],
            "between": [self.number(state) for state in step.between],
            "roles": [
                [self.layers[layer], before.value, after.value]
                for layer, (before, after) in step.roles.items()
                if layer in self.layers
            ],
        }

    def measurement(self, one: Measurement) -> JSONEntry:
        """Return the entry of a measurement."""
        name = digest(one.vertices)
        self.arrays[name] = one.vertices
        return {
            **unknown.get(one, {}),
            "kind": one.kind.value,
            "layer": self.layers[one.layer],
            "vertices": name,
            "n_points": one.n_points,
        }

    def recipe(self, steps: recipe.Recipe, sources: Mapping[Source, State]) -> JSONEntry:
        """Return the entry of a recipe and the meshes of its further inputs."""
        return {
            "recipe": json.loads(steps.to_json())["steps"],
            "sources": [
                [name if isinstance(name, Path) else {"role": name}, self.number(state)]
                for name, state in sources.items()
            ],
        }

    def made(self, state: State) -> JSONEntry:
        """Return what made a state."""
        if state in foreign:
            steps, did, sources = foreign[state]
            return {
                "recipe": steps,
                "did": did,
                "sources": [[name, self.number(source)] for name, source in sources],
            }
        return {**self.recipe(state.recipe, state.sources), "did": [*state.did]}

    def made_all(self) -> list[JSONEntry]:
        """Return what made each state; to be called last, as sources of states are states as well."""
        entries: list[JSONEntry] = []
        while len(entries) < len(self.states):
            entries.append(self.made([*self.states][len(entries)]))
        return entries


def capture(document: Document, more: Mapping[str, Any], drafts: Drafts | None = None) -> Snapshot:
    """Take a snapshot of a document, and of what the windows want to have kept.

    Parameters
    ----------
    document : Document
    more : mapping
        Further entries of the JSON.
    drafts : mapping of Layer to (Recipe, sources)
        Recipes with edits that have not been run.
    """
    layers, plane, drafts = document.every_layer, document.plane, drafts or {}
    taken = _Capture(layers)
    manifest = {
        **unknown.get(document, {}),
        "format": FORMAT,
        "version": VERSION,
        "vtksmooth": version("vtksmooth"),
        "unit": document.unit,
        "layers": [taken.layer(layer, drafts.get(layer)) for layer in layers],
        "active": taken.layers.get(document.active),  # type: ignore[arg-type]
        "compared": taken.layers.get(document.compared),  # type: ignore[arg-type]
        "history": {
            "index": document.history.index,
            "steps": [taken.step(step) for step in document.history.steps],
        },
        "measurements": [
            taken.measurement(one) for one in document.measurements if one.layer in taken.layers
        ],
        "plane": None if plane is None else {"origin": [*plane.origin], "normal": [*plane.normal]},
        **more,
        "states": taken.made_all(),
    }
    overwritten = {layer.path for layer in layers if layer.saved is not layer.opened}
    files = {
        taken.states[layer.opened]: layer.source
        for layer in layers
        if layer.source is not None and layer.source not in overwritten
    }
    return Snapshot(manifest, [*taken.states], files, taken.arrays, members_of.get(document, {}))


def save(snapshot: Snapshot, path: Path, tell: Tell = lambda fraction: None) -> None:
    """Write a session file, completely or not at all.

    Raises
    ------
    MeshFileError
        It cannot be written.
    """
    text, arrays = snapshot.contents(path.absolute().parent)
    with (
        atomic(path) as temporary,
        zipfile.ZipFile(temporary, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive,
    ):
        archive.writestr(JSON, text)
        for number, (name, values) in enumerate(arrays.items()):
            tell(number / len(arrays))
            with archive.open(f"{ARRAYS}/{name}.npy", "w", force_zip64=True) as member:
                np.lib.format.write_array(member, values, allow_pickle=False)
        for name, content in snapshot.members.items():
            if name not in arrays:
                archive.writestr(f"{ARRAYS}/{name}.npy", content)


def update(snapshot: Snapshot, folder: Path, tell: Tell = lambda fraction: None) -> None:
    """Bring the session in a folder up to date; whenever the process dies, what was there before is whole.

    Raises
    ------
    MeshFileError
        It cannot be written.
    """
    text, arrays = snapshot.contents(folder)
    place = folder / ARRAYS
    place.mkdir(parents=True, exist_ok=True)
    for number, (name, values) in enumerate(arrays.items()):
        tell(number / len(arrays))
        path = place / f"{name}.npy"
        if not path.exists():
            with atomic(path) as temporary, temporary.open("wb") as file:
                np.lib.format.write_array(file, values, allow_pickle=False)
    for name, content in snapshot.members.items():
        if not (place / f"{name}.npy").exists():
            with atomic(place / f"{name}.npy") as temporary:
                temporary.write_bytes(content)
    with atomic(folder / JSON) as temporary:
        temporary.write_text(text, encoding="utf-8")
    for path in place.iterdir():
        if path.stem not in arrays and path.stem not in snapshot.members:
            path.unlink()


def describe(state: State) -> tuple[dict[str, Any], dict[str, Values]]:
    """Return a state's mesh as JSON that names arrays, and those arrays."""
    found = _described.get(state)
    if found is not None:
        return found
    arrays: dict[str, Values] = {}

    def keep(values: Values) -> str:
        name = digest(values)
        arrays[name] = _arrays.setdefault(name, values)
        return name

    mesh = state.mesh
    entry: dict[str, Any] = {"points": keep(points_of(mesh)) if state.n_points else None, "cells": {}}
    for kind in CELLS:
        cells = getattr(mesh, f"Get{kind}")()
        if cells.GetNumberOfCells():
            entry["cells"][kind] = [keep(values) for values in cells_of(cells)]
    for key, get in DATA.items():
        data = getattr(mesh, get)()
        entry[key] = [
            one for i in range(data.GetNumberOfArrays()) if (one := _array_entry(data, i, keep)) is not None
        ]
    _described[state] = entry, arrays
    return entry, arrays


def _array_entry(data: Any, i: int, keep: Callable[[Values], str]) -> dict[str, Any] | None:
    array = data.GetAbstractArray(i)
    if isinstance(array, vtkStringArray):
        return {
            "name": array.GetName(),
            "text": [array.GetValue(j) for j in range(array.GetNumberOfValues())],
        }
    if not isinstance(array, vtkDataArray):
        return None
    kind = array.GetDataType()
    try:
        values = vtk_to_numpy(array)
    except (AttributeError, TypeError, ValueError, AssertionError):
        # Implicit storage: VTK has no buffer to share.
        plain = vtkDataArray.CreateDataArray(kind)
        plain.DeepCopy(array)
        values = vtk_to_numpy(plain)
    kind = VTK_UNSIGNED_CHAR if kind == VTK_BIT else kind
    entry = {"name": array.GetName(), "array": keep(values), "type": kind}
    if hasattr(data, "IsArrayAnAttribute"):
        entry["attribute"] = data.IsArrayAnAttribute(i)
    return entry


def digest(values: Values) -> str:
    """Return the name of an array: the same for the same values, type and shape."""
    values = np.ascontiguousarray(values)
    found = hashlib.blake2b(f"{values.dtype.str} {values.shape}".encode(), digest_size=16)
    found.update(values.reshape(-1).view(np.uint8).data)
    return found.hexdigest()


def _place(path: Any, folder: Path) -> dict[str, str]:
    assert isinstance(path, Path), path
    absolute = Path(os.path.abspath(path.expanduser()))
    try:
        relative = Path(os.path.relpath(absolute, folder)).as_posix()
    except ValueError:  # on another drive
        relative = absolute.as_posix()
    return {"relative": relative, "absolute": absolute.as_posix()}
