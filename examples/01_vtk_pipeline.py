"""
A pure VTK pipeline
===================

Trapezium Drawing between native VTK filters.

An isosurface (native filters) has slivers; TrapeziumDrawing improves them, SurfaceQuality measures every
face, and another native filter takes the faces that are still poor. Observers show progress and errors,
as with any VTK filter.

::

    python examples/01_vtk_pipeline.py
"""
# sphinx_gallery_thumbnail_path = "pictures/demo_channels.png"

from __future__ import annotations

from vtkmodules.vtkCommonDataModel import vtkQuadric
from vtkmodules.vtkFiltersCore import vtkFlyingEdges3D, vtkThreshold
from vtkmodules.vtkImagingHybrid import vtkSampleFunction

from vtksmooth import ParameterError, SurfaceQuality, TrapeziumDrawing

# Sources and native filters: an ellipsoid from a voxel image, as marching cubes gives it.
ellipsoid = vtkQuadric()
ellipsoid.SetCoefficients(1.0, 2.0, 3.0, 0, 0, 0, 0, 0, 0, -1.0)
image = vtkSampleFunction()
image.SetImplicitFunction(ellipsoid)
image.SetModelBounds(-1.2, 1.2, -1.2, 1.2, -1.2, 1.2)
image.SetSampleDimensions(40, 40, 40)
isosurface = vtkFlyingEdges3D()
isosurface.SetInputConnection(image.GetOutputPort())
isosurface.SetValue(0, 0.0)

# Ours, between native filters. Parameters are keywords, properties, or VTK's Set and Get.
smoothing = TrapeziumDrawing(iterations=5)
smoothing.SetInputConnection(isosurface.GetOutputPort())
quality = SurfaceQuality()
quality.SetInputConnection(smoothing.GetOutputPort())

poor = vtkThreshold()
poor.SetInputConnection(quality.GetOutputPort())
poor.SetInputArrayToProcess(0, 0, 0, 1, "AspectRatio")  # 1: of the cells
poor.SetThresholdFunction(vtkThreshold.THRESHOLD_LOWER)
poor.SetLowerThreshold(0.4)

# Progress, as a window or a log would show it.
fractions: list[float] = []
smoothing.AddObserver("ProgressEvent", lambda *_: fractions.append(smoothing.GetProgress()))

poor.Update()
print(f"progress was reported {len(fractions)} times, at the end {fractions[-1]:.0%}")
print(smoothing.report)
print(f"faces with k < 0.4 after 5 iterations: {poor.GetOutput().GetNumberOfCells()}")

# Another value: only what lies downstream of it runs again.
few = poor.GetOutput().GetNumberOfCells()
smoothing.SetIterations(0)
poor.Update()
many = poor.GetOutput().GetNumberOfCells()
print(f"faces with k < 0.4 in the isosurface itself: {many}")

# Errors: an ErrorEvent for observers and, in Python, an exception from the filter's Update.
messages: list[str] = []


def note(caller: object, event: str, message: str) -> None:
    """Keep what an ErrorEvent says."""
    messages.append(message)


note.CallDataType = "string0"  # type: ignore[attr-defined]  # VTK: hand the text to the observer
smoothing.AddObserver("ErrorEvent", note)
smoothing.SetIterations(5)
smoothing.SetFixed("NoSuchArray")
try:
    smoothing.Update()
except ParameterError as error:
    print(f"as it should be, refused: {error}")

# The checks.
smoothing.SetFixed(None)
smoothing.Update()
before, after = smoothing.report.min_aspect_ratio
assert after >= before, "the smallest k of the mesh never falls"
assert smoothing.report.inverted[1] <= smoothing.report.inverted[0], "inverted faces never become more"
assert few < many, "poor faces became fewer"
assert len(messages) == 1, "the error was told once"
assert "NoSuchArray" in messages[0]
assert fractions[-1] == 1.0
