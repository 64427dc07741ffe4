"""Layers: the meshes of a document."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

from .state import State


class Role(StrEnum):
    """What a layer is for."""

    MESH = "mesh"
    REFERENCE = "reference"
    SPACE = "installation space"


@dataclass(eq=False, repr=False)
class Layer:
    """A mesh in the window, through all of its states.

    Attributes
    ----------
    name : str
    source : Path or None
        File that it was opened from.
    path : Path or None
        File that it came from, or was saved to last.
    opened : State
        As it was opened: what "before" means.
    state : State or None
        As it is now; None when the layer is closed.
    saved : State or None
        As it is in its file.
    """

    name: str
    opened: State
    source: Path | None = None
    path: Path | None = None
    role: Role = Role.MESH
    visible: bool = True
    state: State | None = None
    saved: State | None = None

    @property
    def unsaved(self) -> bool:
        """Whether something has changed since the last save."""
        return self.state is not None and self.state is not self.saved
