"""What can go wrong, as exceptions that say in one sentence what to do."""

from __future__ import annotations


class VtksmoothError(Exception):
    """Root of everything this package raises on purpose."""

    def __str__(self) -> str:
        # Names of arrays and files, which messages quote, may hold line breaks.
        return " ".join(super().__str__().split())


class InvalidMeshError(VtksmoothError, ValueError):
    """The mesh cannot be worked on as it is."""


class ParameterError(VtksmoothError, ValueError):
    """A parameter is out of range, of the wrong type, or unknown."""


class MeshFileError(VtksmoothError, OSError):
    """A mesh file cannot be read or written."""


class RecipeError(VtksmoothError, ValueError):
    """A recipe cannot be read or run."""


class Cancelled(VtksmoothError):
    """The run was stopped from outside; nothing of it was kept."""


def sentence(error: Exception) -> str:
    """Return what to tell a user about any exception: one line, with what to do."""
    text = " ".join(str(error).split()).rstrip(".")
    if isinstance(error, VtksmoothError):
        return text
    if isinstance(error, MemoryError):
        return "out of memory; use a smaller mesh or a larger machine"
    if isinstance(error, OSError):
        return f"{text}; check the path and the disk"
    return f"unexpected {type(error).__name__}: {text}; run again with --debug and report what it shows"
