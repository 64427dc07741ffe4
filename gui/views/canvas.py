"""The widget that VTK draws into."""

from __future__ import annotations

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

    def paintGL(self) -> None:  # noqa: N802
        """Draw."""
        interactor = self.render_window.GetInteractor()
        self._painting = True
        interactor.EnableRenderOn()
        try:
            super().paintGL()
        finally:
            interactor.EnableRenderOff()
            self._painting = False
