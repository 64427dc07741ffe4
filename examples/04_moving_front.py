"""
A moving front keeps its volume
===============================

What becomes of the volume of a moving front that is smoothed after every step.

A sphere is carried by a flow that draws it out and, in the second half, brings it back (LeVeque's
deformation; no volume is made or lost). Every step moves the points with the flow; then one iteration of
smoothing keeps the triangles in shape, as simulations with moving boundaries do. What smoothing adds to the
volume is summed up over all steps, for plain Laplacian, Taubin's, null-space and conservative smoothing.

::

    python examples/04_moving_front.py [--steps 200] [--output FILE.png]
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pyvista as pv

from vtksmooth import LaplacianSmoothing, NullSpaceSmoothing
from vtksmooth.filters import SmoothingFilter

Float64 = npt.NDArray[np.float64]

#: How each is drawn.
COLOURS = {"Laplacian": "#d95f02", "Taubin": "#7570b3", "null space": "#1f78b4", "conservative": "#1b9e77"}


def velocity(points: Float64, time: float) -> Float64:
    """Return LeVeque's flow in the unit cube; it turns round at time 1/2. Its divergence is 0."""
    s, c = np.sin(np.pi * points), np.cos(np.pi * points)
    x, y, z = s[:, 0], s[:, 1], s[:, 2]
    xx, yy, zz = (2.0 * s[:, i] * c[:, i] for i in range(3))
    field = np.column_stack((2.0 * x**2 * yy * zz, -xx * y**2 * zz, -xx * yy * z**2))
    return 0.6 * np.cos(np.pi * time) * field


def carried(points: Float64, time: float, step: float) -> Float64:
    """Return where the flow takes points in a step (Runge and Kutta's method of fourth order)."""
    k1 = velocity(points, time)
    k2 = velocity(points + 0.5 * step * k1, time + 0.5 * step)
    k3 = velocity(points + 0.5 * step * k2, time + 0.5 * step)
    k4 = velocity(points + step * k3, time + step)
    return points + step / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)


def evolve(front: pv.PolyData, smoothing: SmoothingFilter, steps: int) -> tuple[pv.PolyData, Float64, float]:
    """Carry the front through the flow; return it, what smoothing added to the volume, and the worst k."""
    front = front.copy()
    added, worst = np.zeros(steps), 1.0
    for i in range(steps):
        front.points = carried(front.points, i / steps, 1.0 / steps)
        front.points = pv.wrap(smoothing(front)).points
        before, after = smoothing.report.volume
        added[i] = after - before
        worst = min(worst, smoothing.report.min_aspect_ratio[1])
    return front, np.cumsum(added), worst


parser = argparse.ArgumentParser(
    description="The volume of a moving front that is smoothed after every step."
)
parser.add_argument("--steps", type=int, default=200)
parser.add_argument("--output", type=Path, help="picture to write instead of opening a window")
options = parser.parse_args()

# Double precision: in single, rounding alone changes the volume by some 1e-8.
sphere = pv.Icosphere(radius=0.15, center=(0.35, 0.35, 0.35), nsub=3)
sphere.points = sphere.points.astype(np.float64)
volume = sphere.volume

ways: dict[str, SmoothingFilter] = {
    "Laplacian": LaplacianSmoothing(iterations=1, relaxation_factor=0.1),
    "Taubin": LaplacianSmoothing(iterations=1, relaxation_factor=0.1, scheme="taubin"),
    "null space": NullSpaceSmoothing(
        iterations=1, relaxation_factor=0.1, corrections=0, preserve_volume=False, gate="none"
    ),
    "conservative": NullSpaceSmoothing(iterations=1, relaxation_factor=0.1, corrections=2, gate="none"),
}
chart = pv.Chart2D()
chart.title = "Volume that smoothing adds to a moving front"
chart.x_label, chart.y_label = "steps", "relative change of the volume"
chart.y_axis.log_scale = True
drift: dict[str, float] = {}
fronts: dict[str, pv.PolyData] = {}
print(f"{'smoothing':14} {'volume added, relative':>24} {'smallest k on the way':>22}")
for name, way in ways.items():
    fronts[name], added, worst = evolve(sphere, way, options.steps)
    relative = np.abs(added) / volume
    drift[name] = float(relative.max())
    print(f"{name:14} {relative[-1]:24.2e} {worst:22.3f}")
    chart.line(
        np.arange(1, options.steps + 1),
        np.maximum(relative, 1e-17),
        label=name,
        color=COLOURS[name],
        width=2.0,
    )

plotter = pv.Plotter(off_screen=True if options.output else None, shape=(1, 2), window_size=(1500, 620))
plotter.subplot(0, 0)
plotter.add_mesh(fronts["conservative"], color=COLOURS["conservative"], show_edges=True, opacity=0.4)
plotter.add_mesh(fronts["Laplacian"], color=COLOURS["Laplacian"], show_edges=True)
plotter.add_mesh(sphere.extract_all_edges(), color="black", opacity=0.15)
plotter.add_text("back again: conservative, and plain Laplacian", font_size=9)
plotter.subplot(0, 1)
plotter.add_chart(chart)
plotter.show(screenshot=options.output)

# The checks: conservative smoothing adds nothing but rounding, and each way is better than the one before.
assert drift["conservative"] < 1e-11
assert drift["conservative"] < 1e-3 * drift["null space"]
assert drift["null space"] < 0.1 * drift["Laplacian"]
assert drift["Taubin"] < drift["Laplacian"]
