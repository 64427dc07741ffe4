"""Replays: a recipe run on a layer, from the first step on whose result is not known."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from vtksmooth.files import read_surface
from vtksmooth.recipe import Apply, Recipe

from .document import Document
from .layer import Layer
from .state import Source, State


class Replay:
    """A recipe that is to be run on a layer; to be made where the document is, and run anywhere.

    Parameters
    ----------
    sources : mapping of str or Path to State
        The meshes of the recipe's further inputs; files that are not among them are read.

    Attributes
    ----------
    before : State or None
        The layer as it was.
    begin : State
        The mesh to begin with.
    todo : list of int
        The numbers of the steps that are run.
    states : list of State
        What came out of each of them; the last is what the whole recipe makes.
    """

    def __init__(
        self, document: Document, layer: Layer, recipe: Recipe, sources: Mapping[Source, State]
    ) -> None:
        self.layer, self.recipe, self.before = layer, recipe, layer.state
        self.sources = dict(sources)
        self.first, self.begin = document.reached(layer, recipe, sources)
        self.todo = [index for index, _ in recipe.enabled if index >= self.first]
        self.states: list[State] = []

    def run(self, apply: Apply, said: Callable[[Any], str]) -> Replay:
        """Run it; `apply` runs each filter, and `said` tells what a filter did."""
        for source in self.recipe.sources:
            if isinstance(source, Path) and source not in self.sources:
                self.sources[source] = State.of(read_surface(source)[0])
        did = [""] * len(self.recipe)
        # The steps that need not be run may have other numbers among others that are switched off.
        for (index, _), (known, _) in zip(self.recipe.enabled, self.begin.recipe.enabled, strict=False):
            did[index] = self.begin.did[known]
        meshes = {source: state.input() for source, state in self.sources.items()}
        for result in self.recipe.results(
            self.layer.opened.input(), meshes, start=self.first, current=self.begin.input(), apply=apply
        ):
            did[result.index] = said(result.algorithm)
            self._add(result.outputs[0], result.index + 1, did)
        last = self.states.pop() if self.states else self.begin
        self._add(last.mesh, len(self.recipe), did)
        return self

    def _add(self, mesh: Any, steps: int, did: list[str]) -> None:
        recipe = Recipe(self.recipe.steps[:steps])
        made = State.of(mesh, self.begin, recipe=recipe, sources=self.sources, did=tuple(did[:steps]))
        self.states.append(made)
