"""
Parts that stay
===============

Points where a point array called ``Fixed`` is not zero keep their coordinates, bit for bit; so do boundary
points, unless they may slide. Here the wing tips and the tail of an airplane: coarse, thin parts that
smoothing would change most.
"""

import numpy as np
import pyvista as pv
from pyvista import examples

airplane = pv.read(examples.planefile)
free = airplane.vtksmooth.trapezium_drawing(iterations=5)

# %%
# Which parts change? The comparison says it for every point; we hold those that go farthest, with their
# neighbours.

deviation = free.vtksmooth.surface_comparison(airplane)["Deviation"]
held = deviation > 0.001 * airplane.length
faces = airplane.regular_faces
held[np.unique(faces[held[faces].any(axis=1)])] = True
airplane["Fixed"] = held.astype(np.uint8)
careful = airplane.vtksmooth.trapezium_drawing(iterations=5)
print(f"{held.sum()} of {airplane.n_points} points are held")

measured = {
    "all points free": free.vtksmooth.surface_comparison(airplane),
    "some points held": careful.vtksmooth.surface_comparison(airplane),
}
for name, mesh in measured.items():
    k = mesh["AspectRatio"]
    print(
        f"{name}: poor faces {(k < 0.2).mean():.1%}, farthest {mesh['Deviation'].max() / airplane.length:.2%}"
    )

plotter = pv.Plotter(shape=(1, 2), window_size=(1400, 600))
for column, (name, mesh) in enumerate(measured.items()):
    mesh["deviation, % of the diagonal"] = 100 * mesh["Deviation"] / airplane.length
    plotter.subplot(0, column)
    plotter.add_mesh(
        mesh,
        scalars="deviation, % of the diagonal",
        clim=(0, 0.5),
        cmap="Reds",
        ambient=0.2,
    )
    plotter.add_text(name, position=(0.02, 0.93), viewport=True, font_size=10)
plotter.subplot(0, 1)
plotter.add_points(airplane.points[held], color="#1f78b4", point_size=6, render_points_as_spheres=True)
plotter.link_views()
plotter.view_vector((-1.0, -1.0, 1.2))
plotter.camera.zoom(1.7)
plotter.show()

# %%
# What holds.

assert np.array_equal(careful.points[held], airplane.points[held]), "bit for bit"
assert measured["some points held"]["Deviation"].max() < measured["all points free"]["Deviation"].max()
