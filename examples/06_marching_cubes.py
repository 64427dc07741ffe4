"""
Better triangles for a marching-cubes surface
=============================================

Surfaces of images have slivers wherever the surface passes close to a grid point. Trapezium Drawing moves
the points so that the worst triangle round each of them becomes better, and keeps close to the surface that
the triangles mean.
"""

# %%
# The mesh: river channels of a voxel image that PyVista brings along, contoured as one does it: mask, blur,
# take every other sample, contour.

import numpy as np
import pyvista as pv
from pyvista import examples

image = pv.read(examples.channelsfile).extract_subset([0, 90, 170, 250, 53, 72]).cells_to_points()
image["facies"] = (image["facies"] > 0).astype(np.float32)
image = image.gaussian_smooth(std_dev=2.0)
image = image.extract_subset(image.extent, rate=(2, 2, 2))
surface = image.contour([0.5], method="flying_edges").connectivity("largest")
surface.clear_data()

# %%
# Smooth, and measure against the original. The aspect ratio k is 1 for equilateral triangles, 0 for
# degenerate and negative for inverted ones.

better = surface.vtksmooth.trapezium_drawing(iterations=5)
before = surface.vtksmooth.surface_quality()
after = better.vtksmooth.surface_comparison(surface)
for name, mesh in (("before", before), ("after", after)):
    k = mesh["AspectRatio"]
    print(f"{name}: k at least {k.min():.3f}, mean {k.mean():.3f}; poor (k < 0.2): {(k < 0.2).mean():.1%}")
print(f"farthest point: {after['Deviation'].max() / surface.length:.2%} of the diagonal")

# %%
# The same part before and after, and the histograms.

colours = {"scalars": "AspectRatio", "clim": (0, 1), "cmap": "cividis", "n_colors": 5, "ambient": 0.4}
bar = {"title": "aspect ratio k", "n_labels": 3, "position_y": 0.02}
plotter = pv.Plotter(shape=(1, 3), window_size=(1500, 500))
for column, (name, mesh) in enumerate((("before", before), ("after", after))):
    plotter.subplot(0, column)
    plotter.add_mesh(mesh, show_edges=True, scalar_bar_args=bar, **colours)
    plotter.add_text(name, position=(0.02, 0.93), viewport=True, font_size=10)
plotter.link_views([0, 1])
plotter.camera_position = "xy"
plotter.camera.zoom(2.5)
plotter.subplot(0, 2)
chart = pv.Chart2D(x_label="k", y_label="% of the faces")
edges = np.linspace(0, 1, 11)
for name, mesh, colour in (("before", before, "#d95f02"), ("after", after, "#08519c")):
    shares = 100 * np.histogram(mesh["AspectRatio"], edges)[0] / mesh.n_cells
    chart.line(np.repeat(edges, 2)[1:-1], np.repeat(shares, 2), color=colour, width=3.0, label=name)
chart.y_range = (0, 70)
plotter.add_chart(chart)
plotter.show()

# %%
# What holds: with the default gate the smallest k of the mesh never falls and no face becomes inverted, in
# any iteration.

assert after["AspectRatio"].min() >= before["AspectRatio"].min()
assert (after["AspectRatio"] < 0.2).mean() < 0.1 * (before["AspectRatio"] < 0.2).mean()
assert np.array_equal(better.faces, surface.faces)
