"""The widget that VTK draws into."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from typing import Any

from pyvistaqt import QtInteractor


class Canvas(QtInteractor):
    """A QtInteractor that draws each frame once: when Qt paints.

    Otherwise VTK draws when something changes or the camera is turned, and once more when Qt paints the
    widget because of that.
    """

    def __init__(self, *arguments: Any, **keywords: Any) -> None:
        super().__init__(*arguments, **keywords)
        self.setAcceptDrops(False)  # files dropped here are for the window
        self._painting = False
        # With this off VTK tells its observers instead of drawing.
        self.iren.interactor.EnableRenderOff()
        self.iren.interactor.AddObserver("RenderEvent", self._paint_soon)

    def _paint_soon(self, *_: Any) -> None:
        if not self._painting:
            self.update()

    @contextlib.contextmanager
    def drawing(self) -> Iterator[None]:
        """While this context is open, VTK draws when it is told to."""
        interactor = self.render_window.GetInteractor()
        self._painting = True
        interactor.EnableRenderOn()
        try:
            yield
        finally:
            interactor.EnableRenderOff()
            self._painting = False

    def paintGL(self) -> None:  # noqa: N802
        """Draw."""
        with self.drawing():
            super().paintGL()
