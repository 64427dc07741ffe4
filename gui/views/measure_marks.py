"""Measurements in the view: points, lines between them, and what was measured beside them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from vtkmodules.vtkCommonDataModel import vtkPolyData
from vtkmodules.vtkRenderingCore import vtkActor, vtkBillboardTextActor3D, vtkPolyDataMapper

from vtksmooth.filters.arrays import vtk_cells, vtk_points

from .mesh_view import MeshView
from .theme import Theme

_COLOUR = (0.80, 0.0, 0.45)


@dataclass(frozen=True, eq=False)
class Mark:
    """What is drawn of one measurement.

    Attributes
    ----------
    places : (k, 3) float64
        Points, joined in their order by lines if `joined`.
    joined : bool
    text : str
    at : (3,) float64
        Where the text stands.
    """

    places: npt.NDArray[np.float64]
    joined: bool
    text: str
    at: npt.NDArray[np.float64]


class MeasureMarks:
    """Marks drawn over everything else."""

    def __init__(self, view: MeshView) -> None:
        self._view = view
        self._data = vtkPolyData()
        mapper = vtkPolyDataMapper()
        mapper.SetInputData(self._data)
        self.actor = vtkActor()
        self.actor.SetMapper(mapper)
        self.actor.PickableOff()
        look = self.actor.GetProperty()
        look.SetColor(*_COLOUR)
        look.LightingOff()
        scale = view.devicePixelRatioF()
        look.SetLineWidth(2.5 * scale)
        look.SetPointSize(8.0 * scale)
        look.RenderPointsAsSpheresOn()
        self.labels: list[vtkBillboardTextActor3D] = []
        self._ink, self._paper = (0.1, 0.1, 0.1), (1.0, 1.0, 1.0)
        view.top.AddActor(self.actor)

    def show_marks(self, marks: Sequence[Mark]) -> None:
        """Show marks in place of those before."""
        for label in self.labels:
            self._view.top.RemoveViewProp(label)
        self.labels = [self._label(mark) for mark in marks if mark.text]
        every = [mark.places for mark in marks if len(mark.places)]
        data = vtkPolyData()
        if every:
            counts = [len(places) for places in every]
            firsts = np.concatenate(([0], np.cumsum(counts)))
            data.SetPoints(vtk_points(np.concatenate(every)))
            data.SetVerts(vtk_cells(np.arange(firsts[-1] + 1), np.arange(firsts[-1])))
            joined = [
                np.arange(first, first + count)
                for first, count, mark in zip(
                    firsts, counts, (m for m in marks if len(m.places)), strict=False
                )
                if mark.joined and count > 1
            ]
            if joined:
                offsets = np.concatenate(([0], np.cumsum([len(line) for line in joined])))
                data.SetLines(vtk_cells(offsets, np.concatenate(joined)))
        self._data.ShallowCopy(data)
        self._view.render_soon()

    def set_theme(self, theme: Theme) -> None:
        """Show light or dark."""
        self._ink, self._paper = theme.text, theme.bottom
        for label in self.labels:
            self._dress(label)

    def _label(self, mark: Mark) -> vtkBillboardTextActor3D:
        label = vtkBillboardTextActor3D()
        label.SetInput(mark.text)
        label.SetPosition(*mark.at)
        label.SetDisplayOffset(6, 6)
        label.PickableOff()
        self._dress(label)
        self._view.top.AddViewProp(label)
        return label

    def _dress(self, label: vtkBillboardTextActor3D) -> None:
        look = label.GetTextProperty()
        look.SetFontSize(15)  # points, of which VTK knows how many pixels they are
        look.BoldOn()
        look.SetColor(*self._ink)
        look.SetBackgroundColor(*self._paper)
        look.SetBackgroundOpacity(0.75)
