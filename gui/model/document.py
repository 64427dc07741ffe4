"""The document: layers, which of them is worked on, and their history."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from vtksmooth import recipe
from vtksmooth.filters import Filter

from . import overlays
from .event import Event
from .history import History, Step
from .layer import Layer, Role
from .measure import Measurement
from .section import Plane
from .state import Source, State


class Document:
    """What is open.

    Attributes
    ----------
    active : Layer or None
        The layer that filters work on and overlays show.
    history : History
    unit : str
        The unit of lengths, see :data:`~vtksmooth_gui.model.units.UNITS`.
    compared : Layer or None
        The layer that the active one is compared with, whatever its faces.
    measurements : list of Measurement
    plane : Plane or None
        The plane of the cross-section.
    changed : Event
        Meshes, layers or their properties have changed.
    """

    def __init__(self) -> None:
        self._layers: list[Layer] = []
        self.active: Layer | None = None
        self.history = History()
        self.unit = ""
        self.compared: Layer | None = None
        self.measurements: list[Measurement] = []
        self.plane: Plane | None = None
        self.changed = Event()

    @property
    def layers(self) -> list[Layer]:
        """The open layers, in the order in which they were opened."""
        return [layer for layer in self._layers if layer.state is not None]

    @property
    def every_layer(self) -> list[Layer]:
        """The layers that are open, or that undo or redo can bring back."""
        return list(self._layers)

    @property
    def content(self) -> tuple[Any, ...]:
        """What is lost if it is not saved; equal as long as nothing has changed."""
        layers = [(layer, layer.name, layer.role) for layer in self._layers]
        return (
            *layers, *self.history.steps, self.history.index, self.unit, self.compared, *self.measurements
        )  # fmt: skip

    @property
    def other(self) -> Layer | None:
        """What the active layer is compared with: the layer chosen for that, else the only other one."""
        others = [layer for layer in self.layers if layer is not self.active]
        if self.compared in others:
            return self.compared
        return others[0] if len(others) == 1 else None

    @property
    def space(self) -> Layer | None:
        """The installation space: the last layer of that role."""
        spaces = [layer for layer in self.layers if layer.role is Role.SPACE]
        return spaces[-1] if spaces else None

    @property
    def before(self) -> State | None:
        """What the active layer is compared with: a reference with its points, or as it was opened."""
        layer = self.active
        if layer is None or layer.state is None:
            return None
        for other in reversed(self.layers):
            if (
                other is not layer
                and other.role is Role.REFERENCE
                and other.state is not None
                and other.state.n_points == layer.state.n_points
            ):
                return other.state
        return layer.opened

    def open(self, mesh: Any, path: Path) -> Layer:
        """Add a mesh, or its state, that has been read from `path`, and work on it."""
        state = State.of(mesh)
        layer = self._new_layer(path.stem, state)
        layer.source, layer.path, layer.saved = path, path, state
        self._do(Step(f"Open {path.name}", {layer: (None, state)}))
        self.active = layer
        self.changed.emit()
        return layer

    def step(
        self, layer: Layer, cls: type[Filter], values: Mapping[str, Any], further: Sequence[State | None]
    ) -> tuple[recipe.Step, dict[Source, State]]:
        """Return a filter as a step of the recipe of `layer`, and the meshes of its `further` inputs.

        None is an optional input that is none; those at the end may be missing.
        """
        assert layer.state is not None
        taken: dict[Source, State] = {recipe.ORIGINAL: layer.opened, **layer.state.sources}
        inputs: dict[str, Source] = {}
        given = [*further, *[None] * (len(cls.every_input()) - 1 - len(further))]
        for name, state in zip(cls.every_input()[1:], given, strict=True):
            if state is not None:
                inputs[name] = self.source(state, taken)
                taken[inputs[name]] = state
        used = {source: taken[source] for source in inputs.values() if source != recipe.ORIGINAL}
        return recipe.Step(cls.command, values, inputs), used

    def source(self, state: State, taken: Mapping[Source, State]) -> Source:
        """Return what a recipe calls a mesh: the file it was opened from, else a role.

        Names that are `taken` by other meshes are not used.
        """
        known = next((source for source, other in taken.items() if other is state), None)
        if known is not None:
            return known
        owner = next((layer for layer in self._layers if state in (layer.state, layer.opened)), None)
        if owner is not None and owner.source is not None and state is owner.opened:
            path = owner.source.absolute()
            if path not in taken:
                return path
        word = "mesh" if owner is None else owner.name
        names = itertools.chain([word], (f"{word} {number}" for number in itertools.count(2)))
        return next(name for name in names if name not in taken)

    def apply(
        self,
        layer: Layer,
        outputs: Sequence[Any],
        step: recipe.Step,
        sources: Mapping[Source, State],
        title: str,
        did: str = "",
        summary: str = "",
    ) -> None:
        """Give `layer` the first output of a recipe's step; further outputs become layers.

        Parameters
        ----------
        outputs : sequence of vtkPolyData or State
        step, sources
            As :meth:`step` makes them.
        did, summary : str
            What it did: for reports, and for the history.
        """
        before = layer.state
        assert before is not None
        after = State.of(outputs[0])
        after.recipe = before.recipe.added(step)
        after.sources = {**before.sources, **sources}
        after.did = (*before.did, did)
        changes: dict[Layer, tuple[State | None, State | None]] = {layer: (before, after)}
        for name, mesh in zip(step.cls.outputs[1:], outputs[1:], strict=True):
            state = State.of(mesh)
            added = self._new_layer(f"{layer.name} {name}", state)
            added.role = Role.REFERENCE
            changes[added] = (None, state)
        self._do(Step(title, changes, summary), keep_undone=step.cls.measures)
        self.changed.emit()

    def replay(self, layer: Layer, states: Sequence[State], title: str, summary: str = "") -> None:
        """Give `layer` the last of the `states` that a recipe made, one after the other."""
        self._do(Step(title, {layer: (layer.state, states[-1])}, summary, tuple(states[:-1])))
        self.changed.emit()

    def reached(
        self, layer: Layer, wanted: recipe.Recipe, sources: Mapping[Source, State]
    ) -> tuple[int, State]:
        """Return the first step of a recipe that has to be run, and the mesh that it is to be run on.

        What has been made of `layer` before by the same steps of the same meshes is not made again.
        """
        steps = wanted.enabled
        best, mesh = 0, layer.opened
        for step in self.history.steps:
            for state in (*step.changes[layer], *step.between) if layer in step.changes else ():
                if state is None:
                    continue
                done = [one for _, one in state.recipe.enabled]
                if (
                    best < len(done) <= len(steps)
                    and not done[-1].cls.measures
                    and done == [one for _, one in steps[: len(done)]]
                    and all(
                        source == recipe.ORIGINAL or state.sources[source] is sources.get(source)
                        for one in done
                        for source in one.inputs.values()
                    )
                ):
                    best, mesh = len(done), state
        return (steps[best - 1][0] + 1 if best else 0), mesh

    def close(self, layer: Layer) -> None:
        """Take a layer out; undo brings it back."""
        self._do(Step(f"Close {layer.name}", {layer: (layer.state, None)}))
        self.changed.emit()

    def undo(self) -> None:
        """Undo the last step."""
        if self.history.can_undo:
            self.go(self.history.index - 1)

    def redo(self) -> None:
        """Do again what was undone last."""
        if self.history.can_redo:
            self.go(self.history.index + 1)

    def go(self, index: int) -> None:
        """Go back or forth in the history until `index` steps are in effect."""
        self._set(self.history.go(index))
        self.changed.emit()

    def activate(self, layer: Layer) -> None:
        """Work on `layer`."""
        if layer is not self.active:
            self.active = layer
            self.changed.emit()

    def set_role(self, layer: Layer, role: Role) -> None:
        """Change what a layer is for."""
        if role is layer.role:
            return
        self.history.insert(Step(f"{layer.name}: {role}", roles={layer: (layer.role, role)}))
        layer.role = role
        if role is not Role.MESH and layer is self.active:
            self.active = next((other for other in self.layers if other.role is Role.MESH), layer)
        self.changed.emit()

    def set_visible(self, layer: Layer, visible: bool) -> None:
        """Show or hide a layer."""
        layer.visible = visible
        self.changed.emit()

    def set_saved(self, layer: Layer, state: State, path: Path) -> None:
        """Note that `state` of `layer` has been written to `path`."""
        layer.saved, layer.path = state, path
        self.changed.emit()

    def set_unit(self, unit: str) -> None:
        """Choose the unit of lengths."""
        self.unit = unit
        self.changed.emit()

    def compare(self, layer: Layer, other: Layer) -> None:
        """Work on `layer`, and compare it with `other`."""
        self.active, self.compared = layer, other
        self.changed.emit()

    def measure(self, one: Measurement) -> None:
        """Add a measurement."""
        self.measurements = [*self.measurements, one]
        self.changed.emit()

    def forget(self, gone: Iterable[Measurement]) -> None:
        """Take measurements out."""
        left = set(gone)
        self.measurements = [one for one in self.measurements if one not in left]
        self.changed.emit()

    def restore(self, layers: list[Layer], active: Layer | None, steps: list[Step], index: int) -> None:
        """Be what a session holds."""
        self._layers = list(layers)
        self.history.steps, self.history.index = list(steps), index
        self.history.settle()
        self.active = active
        self._choose_active()
        self.changed.emit()

    def set_memory_limit(self, limit: int) -> None:
        """Set how many bytes the history may take."""
        self.history.limit = limit
        self.history.settle()
        self.changed.emit()

    def _new_layer(self, name: str, state: State) -> Layer:
        taken = {layer.name for layer in self._layers}
        unique, number = name, 2
        while unique in taken:
            unique, number = f"{name} {number}", number + 1
        return Layer(unique, state)

    def _do(self, step: Step, keep_undone: bool = False) -> None:
        self._layers += [layer for layer in step.changes if layer not in self._layers]
        self._set({layer: after for layer, (_, after) in step.changes.items()})
        (self.history.insert if keep_undone else self.history.push)(step)
        # Layers of steps that were undone and then overwritten cannot come back.
        known = {layer for other in self.history.steps for layer in other.changes}
        self._layers = [layer for layer in self._layers if layer in known]

    def _set(self, states: dict[Layer, State | None]) -> None:
        for layer, state in states.items():
            left, layer.state = layer.state, state
            if left is not None and state is not None:
                overlays.share(left, state)
            if left is not None and left is not layer.opened:
                # What overlays computed is large, and computed again when somebody comes back.
                left.fields.clear()
                left.summaries.clear()
        self._choose_active()

    def _choose_active(self) -> None:
        if self.active is None or self.active.state is None:
            mesh_first = sorted(self.layers, key=lambda layer: layer.role is not Role.MESH)
            self.active = mesh_first[0] if mesh_first else None
