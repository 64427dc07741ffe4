"""Writing a report: the extension chooses the format."""

from __future__ import annotations

from pathlib import Path

from ..errors import MeshFileError
from ..files import atomic, check_place
from . import html, pdf
from .page import Page

#: The formats of reports, by extension.
FORMATS = {".html": html.write, ".pdf": pdf.write}


def check_format(path: Path) -> None:
    """Refuse a path that :func:`write_page` could not write.

    Raises
    ------
    MeshFileError
        The extension is not one of :data:`FORMATS`, or nothing can be written there.
    """
    if path.suffix.lower() not in FORMATS:
        raise MeshFileError(
            f"cannot write {path}: {path.suffix or '(none)'!r} is no format of reports; "
            f"use one of {' '.join(FORMATS)}."
        )
    check_place(path)


def write_page(page: Page, path: Path) -> None:
    """Write a report, completely or not at all; the extension of `path` chooses the format.

    Raises
    ------
    MeshFileError
        See :func:`check_format`; or the disk is full or failed.
    """
    check_format(path)
    with atomic(path) as temporary:
        FORMATS[path.suffix.lower()](page, temporary)
