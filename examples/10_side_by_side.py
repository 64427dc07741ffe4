"""
The filters side by side
========================

The same mesh, every filter that improves elements, ten iterations each. What they improve differs, and so
does what they pay for it: no filter is best at everything.
"""

# %%
# The mesh: an organ of PyVista's bundled frog, contoured at half the resolution.

import numpy as np
import pyvista as pv
from pyvista import examples

image = pv.read(examples.frogtissuesfile)
organ = (image["MetaImage"] == 6).astype(np.float32)
image.clear_data()
image["organ"] = organ
places = np.stack(np.unravel_index(np.flatnonzero(organ), image.dimensions, order="F"))
box = np.column_stack((places.min(axis=1) - 5, places.max(axis=1) + 5)).ravel()
image = image.extract_subset(box)
image = image.gaussian_smooth(std_dev=1.5)
image = image.extract_subset(image.extent, rate=(2, 2, 2))
organ = image.contour([0.5], method="flying_edges").connectivity("largest")
organ.clear_data()
assert organ.n_open_edges == 0
smooth = organ.vtksmooth
results = {
    "as it is": organ,
    "laplacian_smoothing": smooth.laplacian_smoothing(iterations=10),
    "angle_based_smoothing": smooth.angle_based_smoothing(iterations=10),
    "back_to_surface_smoothing": smooth.back_to_surface_smoothing(iterations=10),
    "trapezium_drawing": smooth.trapezium_drawing(iterations=10),
    "equilateral_smoothing": smooth.equilateral_smoothing(iterations=10),
}

# %%
# All are measured against the original: aspect ratio, inverted faces, volume, distance.

measured = {name: mesh.vtksmooth.surface_comparison(organ) for name, mesh in results.items()}
print(f"{'':28}{'k least':>9}{'k mean':>9}{'inverted':>10}{'volume':>10}{'farthest':>10}")
for name, mesh in measured.items():
    k, far = mesh["AspectRatio"], mesh["Deviation"].max() / organ.length
    volume = mesh.volume / organ.volume - 1
    print(f"{name:28}{k.min():9.3f}{k.mean():9.3f}{(k < 0).sum():10}{volume:10.1%}{far:10.2%}")

plotter = pv.Plotter(shape=(2, 3), window_size=(1500, 1000))
for i, (name, mesh) in enumerate(measured.items()):
    plotter.subplot(*divmod(i, 3))
    plotter.add_mesh(
        mesh, scalars="AspectRatio", clim=(0, 1), cmap="cividis", n_colors=5, show_edges=True, ambient=0.3,
        scalar_bar_args={"title": "aspect ratio k", "n_labels": 3, "position_y": 0.02},
    )  # fmt: skip
    plotter.add_text(name, position=(0.02, 0.93), viewport=True, font_size=10)
plotter.link_views()
plotter.view_vector((1.0, -1.0, 0.6))
plotter.camera.zoom(1.2)
plotter.show()

# %%
# What holds: filters with a gate make no face inverted, and with ``gate="aspect"`` the smallest k never
# falls.

least = {name: mesh["AspectRatio"].min() for name, mesh in measured.items()}
inverted = {name: (mesh["AspectRatio"] < 0).sum() for name, mesh in measured.items()}
assert least["trapezium_drawing"] >= least["as it is"]
assert inverted["trapezium_drawing"] == inverted["equilateral_smoothing"] == 0
moved = np.linalg.norm(measured["back_to_surface_smoothing"]["Displacement"], axis=1) > 0
distances = results["back_to_surface_smoothing"].compute_implicit_distance(organ)["implicit_distance"]
assert np.abs(distances[moved]).max() < 1e-5 * organ.length
