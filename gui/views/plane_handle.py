"""The plane of a cross-section in the view: dragged along its normal, turned by its arrow."""

from __future__ import annotations

from typing import Any

from PySide6.QtCore import QObject, Signal
from vtkmodules.vtkInteractionWidgets import vtkImplicitPlaneRepresentation, vtkImplicitPlaneWidget2

from ..model.section import Plane
from .mesh_view import MeshView
from .theme import Theme

_PLANE = (0.9, 0.62, 0.0)


class PlaneHandle(QObject):
    """A plane to be dragged.

    Dragging the plane moves it along its normal, dragging the arrow turns it, dragging the point moves the
    point that it is turned about.
    """

    #: The plane has been moved.
    moved = Signal(object)

    def __init__(self, view: MeshView) -> None:
        super().__init__(view)
        self._view = view
        self._bounds: tuple[float, ...] = ()
        self.shape = vtkImplicitPlaneRepresentation()
        self.shape.SetPlaceFactor(1.0)
        self.shape.SetOutlineTranslation(False)
        self.shape.SetScaleEnabled(False)
        self.shape.SetTubing(False)
        self.shape.SetEdgeColor(*_PLANE)
        planes = (self.shape.GetPlaneProperty(), 0.25), (self.shape.GetSelectedPlaneProperty(), 0.45)
        for look, opacity in planes:
            look.SetColor(*_PLANE)
            look.SetOpacity(opacity)
            look.LightingOff()
        self.widget = vtkImplicitPlaneWidget2()
        self.widget.SetInteractor(view.plotter.render_window.GetInteractor())
        self.widget.SetDefaultRenderer(view.first_renderer)
        self.widget.SetRepresentation(self.shape)
        self.widget.AddObserver("InteractionEvent", self._moved)

    def show_plane(self, plane: Plane, bounds: tuple[float, ...]) -> None:
        """Show a plane inside a box."""
        on = bool(self.widget.GetEnabled())
        if bounds != self._bounds:
            self._bounds = bounds
            self.shape.PlaceWidget([*bounds])
        self.shape.SetOrigin(*plane.origin)
        self.shape.SetNormal(*plane.frame[2])
        if not on:
            self.widget.On()
        self._view.render_soon()

    def hide(self) -> None:
        """Take it out of the view."""
        if self.widget.GetEnabled():
            self.widget.Off()
            self._view.render_soon()

    def set_theme(self, theme: Theme) -> None:
        """Show light or dark."""
        # The outline has its own property only after the handle was touched; this is the one before, and
        # the plane's.
        self.shape.SetForegroundColor(*theme.text)
        self.shape.GetPlaneProperty().SetColor(*_PLANE)
        for look in (self.shape.GetOutlineProperty(), self.shape.GetNormalProperty()):
            look.SetColor(*theme.text)

    def _moved(self, *_: Any) -> None:
        self.moved.emit(Plane.of(self.shape.GetOrigin(), self.shape.GetNormal()))
        self._view.render_soon()
