"""The history: what changed meshes, in order, to go back and forth in."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

from .layer import Layer, Role
from .state import State

#: Memory that states may take before the oldest are given up, bytes.
DEFAULT_LIMIT = 2 << 30


@dataclass(eq=False)
class Step:
    """One step: for each layer that it touched the state before and after; None is "not there".

    Attributes
    ----------
    title : str
    changes : dict
    summary : str
        What it did, in one line.
    between : tuple of State
        What a recipe made on the way, to begin there when it is run again.
    roles : dict
        For each layer whose role it changed the role before and after.
    """

    title: str
    changes: dict[Layer, tuple[State | None, State | None]] = field(default_factory=dict)
    summary: str = ""
    between: tuple[State, ...] = ()
    roles: dict[Layer, tuple[Role, Role]] = field(default_factory=dict)
    #: The states have been given up for memory: it cannot be undone any more.
    settled: bool = False

    def settle(self) -> None:
        """Give up the states."""
        self.changes = dict.fromkeys(self.changes, (None, None))
        self.between = ()
        self.settled = True

    def states(self) -> Iterator[State]:
        """Yield the states that the step holds."""
        for change in self.changes.values():
            yield from (state for state in change if state is not None)
        yield from self.between


class History:
    """Steps, and how many of them are in effect.

    Attributes
    ----------
    steps : list of Step
    index : int
        How many of the steps are in effect.
    limit : int
        Bytes that the states of the history may take.
    """

    def __init__(self, limit: int = DEFAULT_LIMIT) -> None:
        self.steps: list[Step] = []
        self.index = 0
        self.limit = limit

    def push(self, step: Step) -> None:
        """Add a step that has been done; what had been undone is forgotten."""
        del self.steps[self.index :]
        self.insert(step)

    def insert(self, step: Step) -> None:
        """Add a step that has been done and leaves alone what had been undone: that can be done again."""
        self.steps.insert(self.index, step)
        self.index += 1
        for layer, (_, after) in step.changes.items():
            later = next((other for other in self.steps[self.index :] if layer in other.changes), None)
            if later is not None:
                later.changes[layer] = (after, later.changes[layer][1])
        self.settle()

    @property
    def first(self) -> int:
        """Smallest index that can be gone back to."""
        return max((i + 1 for i, step in enumerate(self.steps) if step.settled), default=0)

    @property
    def can_undo(self) -> bool:
        """Whether there is a step to undo."""
        return self.index > self.first

    @property
    def can_redo(self) -> bool:
        """Whether there is a step to redo."""
        return self.index < len(self.steps)

    def go(self, index: int) -> dict[Layer, State | None]:
        """Make `index` steps be in effect; return the states that layers get by that. Roles are set.

        Raises
        ------
        IndexError
            The memory of states there has been given up, or there are not so many steps.
        """
        if not self.first <= index <= len(self.steps):
            raise IndexError(f"The history goes from {self.first} to {len(self.steps)}, not to {index}.")
        states: dict[Layer, State | None] = {}
        for step in reversed(self.steps[index : self.index]):
            states |= {layer: before for layer, (before, _) in step.changes.items()}
            for layer, (role, _) in step.roles.items():
                layer.role = role
        for step in self.steps[self.index : index]:
            states |= {layer: after for layer, (_, after) in step.changes.items()}
            for layer, (_, role) in step.roles.items():
                layer.role = role
        self.index = index
        return states

    def states(self) -> Iterable[State]:
        """Yield the states that the history holds; some come several times."""
        for step in self.steps:
            for state in step.states():
                yield state
                yield from state.sources.values()

    def needed(self) -> Iterable[State]:
        """Yield the states that must be there whatever the history does."""
        for step in self.steps:
            for layer in step.changes:
                yield layer.opened
                if layer.state is not None:
                    yield layer.state
                    yield from layer.state.sources.values()

    @property
    def memory(self) -> int:
        """Bytes that would be free without the history."""
        held: dict[str, int] = {}
        for state in self.states():
            held |= state.memory
        for state in self.needed():
            for array in state.memory:
                held.pop(array, None)
        return sum(held.values())

    def settle(self) -> None:
        """Give up the oldest states until the rest is within the limit."""
        while self.memory > self.limit and self.can_undo:
            self.steps[self.first].settle()
