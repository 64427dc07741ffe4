"""
Smooth voxels, same volume
==========================

A segmentation is made of voxels, and its skin of stairs. Laplacian schemes take the stairs away; they
differ in what becomes of the body: the plain one shrinks it, Taubin's nearly keeps its volume, the pairwise
one keeps it to rounding.
"""

# %%
# One organ of PyVista's bundled frog, as the skin of its voxels: squares, which become triangles.

import numpy as np
import pyvista as pv
from pyvista import examples

from vtksmooth import samples

image = pv.read(examples.frogtissuesfile)
labels = np.asarray(image["MetaImage"]).reshape(image.dimensions, order="F")
tissue = labels == 6
low, high = np.argwhere(tissue).min(axis=0), np.argwhere(tissue).max(axis=0) + 1
tissue = tissue[tuple(slice(a, b) for a, b in zip(low, high, strict=True))]
voxels = samples.voxel_skin(tissue, spacing=image.spacing).connectivity("largest")
voxels.clear_data()
skin = voxels.vtksmooth.valence_triangulation()

# %%
# Three schemes, 20 iterations each. ``report`` of the filters and field data of the results tell more.

results = {"voxels": skin}
for scheme in ("umbrella", "taubin", "pairwise"):
    results[scheme] = skin.vtksmooth.laplacian_smoothing(
        scheme=scheme, iterations=20, output_points_precision="double"
    )
change = {name: mesh.volume / skin.volume - 1.0 for name, mesh in results.items()}
for name, relative in change.items():
    print(f"{name:10} volume {relative:+.1e}")

plotter = pv.Plotter(shape=(2, 2), window_size=(1400, 1000))
for i, (name, mesh) in enumerate(results.items()):
    plotter.subplot(*divmod(i, 2))
    plotter.add_mesh(mesh, color="#a6bddb", specular=0.4)
    plotter.add_text(
        name if mesh is skin else f"{name}: volume {change[name]:+.1e}",
        position=(0.02, 0.93),
        viewport=True,
        font_size=10,
    )
plotter.link_views()
plotter.view_vector((1.0, -1.0, 0.6))
plotter.camera.zoom(1.3)
plotter.show()

# %%
# What holds: the pairwise scheme keeps the volume to rounding.

assert abs(change["pairwise"]) < 1e-12
assert abs(change["taubin"]) < 0.2 * abs(change["umbrella"])
assert change["umbrella"] < -0.001
