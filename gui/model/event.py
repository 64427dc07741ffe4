"""Events: how the model tells whoever listens that it has changed."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any


class Event:
    """A list of functions to call.

    Examples
    --------
    >>> changed = Event()
    >>> changed.connect(print)
    >>> changed.emit("now")
    now
    """

    def __init__(self) -> None:
        self._listeners: list[Callable[..., Any]] = []

    def connect(self, listener: Callable[..., Any]) -> None:
        """Call `listener` whenever this event is emitted."""
        self._listeners.append(listener)

    def emit(self, *arguments: Any) -> None:
        """Call all listeners."""
        for listener in list(self._listeners):
            listener(*arguments)
