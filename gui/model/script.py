"""What was done to the meshes, as the lines of a Python program that does the same."""

from __future__ import annotations

from .document import Document
from .history import Filtered, Opened, Step
from .state import State


class _Names:
    """Names of variables: each state of a layer has one of its own."""

    def __init__(self) -> None:
        self.names: dict[State, str] = {}
        self.counts: dict[str, int] = {}

    def of(self, state: State, word: str) -> str:
        if state not in self.names:
            count = self.counts.get(word, 0)
            self.counts[word] = count + 1
            self.names[state] = f"{word}_{count}"
        return self.names[state]


def call(made_by: Filtered) -> str:
    """Return a filter with its parameters as a Python expression."""
    given = ", ".join(f"{name}={value!r}" for name, value in made_by.parameters.items())
    return f"{made_by.cls.__name__}({given})"


def _lines(step: Step, names: _Names) -> list[str]:
    results = [(layer, after) for layer, (_, after) in step.changes.items() if after is not None]
    targets = ", ".join(names.of(after, layer.variable) for layer, after in results)
    if isinstance(step.made_by, Opened):
        return [f"{targets}, notes = read_surface({str(step.made_by.path)!r})"]
    if isinstance(step.made_by, Filtered):
        inputs = ", ".join(names.names.get(state, "missing") for state in step.made_by.inputs)
        return [f"{targets} = {call(step.made_by)}({inputs})"]
    return [f"# {step.title}"]


def script(document: Document) -> list[str]:
    """Return the program for the steps that are in effect.

    The last state of each layer is the value of the last variable named after it.
    """
    names = _Names()
    steps = document.history.steps[: document.history.index]
    filters = sorted({s.made_by.cls.__name__ for s in steps if isinstance(s.made_by, Filtered)})
    lines = []
    if any(isinstance(step.made_by, Opened) for step in steps):
        lines.append("from vtksmooth.files import read_surface, write_surface")
    if filters:
        lines.append(f"from vtksmooth.filters import {', '.join(filters)}")
    if lines:
        lines.append("")
    for step in steps:
        lines += _lines(step, names)
    return lines
