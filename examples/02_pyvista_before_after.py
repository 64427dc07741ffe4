"""
Before and after, from PyVista
==============================

Trapezium Drawing from PyVista, with a picture of before and after.

PyVista finds the accessor ``mesh.vtksmooth`` by itself when the package is installed.

::

    python examples/02_pyvista_before_after.py                     opens a window
    python examples/02_pyvista_before_after.py --output FILE.png   writes a picture
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
import pyvista as pv
from pyvista import examples

parser = argparse.ArgumentParser(description="Smooth PyVista's ant and draw it before and after.")
parser.add_argument("--output", type=Path, help="picture to write instead of opening a window")
options = parser.parse_args()

mesh = pv.read(examples.antfile)
original = mesh.copy()

# Every filter is a method; its parameters are keywords. The bound keeps the tips of legs and antennae.
result = mesh.vtksmooth.trapezium_drawing(iterations=5, max_deviation_fraction=0.002)
compared = result.vtksmooth.surface_comparison(mesh)  # adds AspectRatio, NormalDeviation, Displacement ...
measured = mesh.vtksmooth.surface_quality()

plotter = pv.Plotter(shape=(1, 2), off_screen=True if options.output else None, window_size=[1400, 700])
for column, (state, title) in enumerate([(measured, "before"), (compared, "after 5 iterations")]):
    plotter.subplot(0, column)
    plotter.add_mesh(
        state, scalars="AspectRatio", clim=(0, 1), cmap="cividis", n_colors=5, show_edges=True, ambient=0.4,
        scalar_bar_args={"title": f"k {title}", "n_labels": 3, "width": 0.32, "position_x": 0.64},
    )  # fmt: skip
plotter.link_views()
plotter.view_xz()
plotter.camera.zoom(1.3)
plotter.show(screenshot=options.output)

mean = [state["AspectRatio"].mean() for state in (measured, compared)]
print(f"mean k {mean[0]:.3f} -> {mean[1]:.3f}")
print(f"vertex normals turned by {compared['NormalDeviation'].mean():.1f} degrees in the mean")

# The checks.
assert mesh == original, "the input is never touched"
assert result.n_points == mesh.n_points, "points stay the same points"
assert np.array_equal(result.faces, mesh.faces), "the topology stays"
distances = np.abs(result.compute_implicit_distance(mesh)["implicit_distance"])
assert distances.max() <= 0.002 * mesh.length * (1 + 1e-6), "every point keeps to the bound"
assert mean[1] > mean[0], "the faces of this mesh became better"
