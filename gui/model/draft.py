"""Drafts: the recipe of a layer as it is edited, until it is run."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from weakref import WeakKeyDictionary

from vtksmooth.errors import RecipeError
from vtksmooth.recipe import ORIGINAL, Recipe

from .document import Document
from .event import Event
from .layer import Layer
from .state import Source, State

#: The role that the layer of the installation space has by itself.
_INSTALLATION = "installation"


class Draft:
    """The recipe of the active layer: what was done to it, with the edits that have not been run.

    Edits stay with their layer, whatever is done meanwhile, until they are run or dropped.

    Attributes
    ----------
    changed : Event
        There are other edits.
    """

    def __init__(self, document: Document) -> None:
        self._document = document
        self._edits: WeakKeyDictionary[Layer, tuple[Recipe, dict[Source, State]]] = WeakKeyDictionary()
        self.changed = Event()

    @property
    def state(self) -> State | None:
        """The active layer's mesh."""
        layer = self._document.active
        return None if layer is None else layer.state

    @property
    def _edit(self) -> tuple[Recipe, dict[Source, State]] | None:
        layer = self._document.active
        return None if layer is None else self._edits.get(layer)

    @property
    def edited(self) -> bool:
        """Whether there are edits that have not been run."""
        return self._edit is not None

    @property
    def recipe(self) -> Recipe:
        """The recipe with its edits."""
        if self._edit is not None:
            return self._edit[0]
        return Recipe() if self.state is None else self.state.recipe

    @property
    def sources(self) -> dict[Source, State]:
        """The meshes that have been given to the recipe."""
        given = {} if self.state is None else dict(self.state.sources)
        return given if self._edit is None else given | self._edit[1]

    @property
    def first_to_run(self) -> int:
        """The number of the first step that is not in effect as it is shown."""
        return self.recipe.first_difference(Recipe() if self.state is None else self.state.recipe)

    @property
    def every(self) -> dict[Layer, tuple[Recipe, dict[Source, State]]]:
        """All recipes with edits that have not been run, and the meshes of their sources, by layer."""
        return dict(self._edits)

    def restore(self, edits: Mapping[Layer, tuple[Recipe, Mapping[Source, State]]]) -> None:
        """Have these edits, and no others."""
        self._edits.clear()
        self._edits.update({layer: (recipe, dict(sources)) for layer, (recipe, sources) in edits.items()})
        self.changed.emit()

    # -- editing -----------------------------------------------------------------------------------

    def set(self, recipe: Recipe, sources: Mapping[Source, State] | None = None) -> None:
        """Edit the recipe, and give it further meshes."""
        layer, state = self._document.active, self.state
        if layer is None or state is None:
            return
        given = {**self.sources, **(sources or {})}
        same = all(given.get(source) is state.sources.get(source) for source in recipe.sources)
        if recipe == state.recipe and same:
            self._edits.pop(layer, None)
        else:
            self._edits[layer] = (recipe, given)
        self.changed.emit()

    def drop(self, layer: Layer | None) -> None:
        """Forget the edits of a layer."""
        if layer is not None:
            self._edits.pop(layer, None)
        self.changed.emit()

    # -- meshes ------------------------------------------------------------------------------------

    def offers(self) -> list[tuple[str, Source, State | None]]:
        """Return what a further input may be: a name to show, what the recipe calls it, and its mesh."""
        layer = self._document.active
        if layer is None:
            return []
        given: dict[Source, State] = {ORIGINAL: layer.opened, **self.sources}
        found: list[tuple[str, Source, State | None]] = [(f"{layer.name} as opened", ORIGINAL, layer.opened)]
        for other in self._document.layers:
            if other is not layer and other.state is not None:
                found.append((other.name, self._document.source(other.state, given), other.state))
        listed = {source for _, source, _ in found}
        for step in self.recipe.steps:
            for source in step.inputs.values():
                if source not in listed:
                    listed.add(source)
                    found.append((_shown(source), source, given.get(source)))
        return found

    def meshes(self, recipe: Recipe | None = None) -> dict[Source, State]:
        """Return the meshes of what a recipe needs; files that are not open are left out.

        Raises
        ------
        RecipeError
            There is no mesh for a role.
        """
        found = {}
        for source in (self.recipe if recipe is None else recipe).sources:
            state = self.sources.get(source) or self._open(source)
            if state is not None:
                found[source] = state
            elif not isinstance(source, Path):
                raise RecipeError(
                    f"The recipe needs a mesh of the role {source!r}; open it as a layer, and choose it in "
                    "the form of the step."
                )
        return found

    def _open(self, source: Source) -> State | None:
        """Return the mesh that a source means by itself."""
        document = self._document
        for layer in document.layers:
            if isinstance(source, Path):
                if layer.source is not None and layer.source.absolute() == source:
                    return layer.opened
            elif layer.name == source and layer is not document.active:
                return layer.state
        space = document.space
        if source == _INSTALLATION and space is not None and space is not document.active:
            return space.state
        return None


def _shown(source: Source) -> str:
    return source.name if isinstance(source, Path) else f"a mesh of the role “{source}”"
