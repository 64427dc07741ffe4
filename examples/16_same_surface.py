"""
Points move, the surface stays
==============================

Simulations that smooth in every step need points that move across the surface and not off it.
``null_space_smoothing`` takes of each step what lies in the tangent plane (on ridges: along the ridge),
gives back the volume that is swept all the same, and holds corners.
"""

# %%
# An L-shaped block, its points thrown about on its faces.

import numpy as np
import pyvista as pv

from vtksmooth import LaplacianSmoothing, NullSpaceSmoothing

points = np.stack(np.meshgrid(*[np.linspace(0, 2, 13)] * 3, indexing="ij"), axis=-1)
cells = pv.StructuredGrid(*np.moveaxis(points, -1, 0)).cast_to_unstructured_grid()
centres = cells.cell_centers().points
block = cells.extract_cells((centres[:, 0] < 1) | (centres[:, 2] < 1)).extract_surface(
    algorithm="dataset_surface"
)
block = block.triangulate().clean()
block.points = block.points.astype(np.float64)
block.clear_data()
found = block.vtksmooth.feature_detection(corner_angle=35)
step = 0.03 * np.random.default_rng(5).standard_normal(block.points.shape)
thrown = block.copy()
normals = block.point_normals
smooth = found["FeatureClass"] == 0
step -= (step * normals).sum(axis=1, keepdims=True) * normals
thrown.points = block.points + np.where(smooth[:, None], step, 0.0)

# %%
# 200 iterations of the plain Laplacian, and of the same in the null space.

ways = {
    "plain Laplacian": LaplacianSmoothing(iterations=200),
    "null space": NullSpaceSmoothing(iterations=200),
}
results = {"thrown about": thrown} | {name: pv.wrap(way(thrown)) for name, way in ways.items()}
plotter = pv.Plotter(shape=(1, 3), window_size=(1500, 520))
for column, (name, mesh) in enumerate(results.items()):
    k = mesh.vtksmooth.surface_quality()["AspectRatio"]
    print(f"{name:16} k mean {k.mean():.3f}; volume {mesh.volume / block.volume - 1:+.1e}")
    plotter.subplot(0, column)
    plotter.add_mesh(mesh, color="#a6bddb", show_edges=True)
    plotter.add_text(name, position=(0.02, 0.93), viewport=True, font_size=10)
plotter.link_views()
plotter.view_vector((1.0, -1.2, 0.9))
plotter.show()

# %%
# What holds: volume to rounding, faces flat, corners where they were.

before, after = ways["null space"].report.volume
assert abs(after / before - 1) < 1e-13
assert ways["null space"].report.inverted[1] <= ways["null space"].report.inverted[0]
corners = found["FeatureClass"] == 2
assert corners.sum() == 12
assert np.allclose(results["null space"].points[corners], block.points[corners], rtol=0, atol=1e-12)
walls = np.isclose(block.points, 0.0)
assert np.abs(results["null space"].points[walls]).max() < 1e-12
k = [
    results[name].vtksmooth.surface_quality()["AspectRatio"].mean() for name in ("thrown about", "null space")
]
assert k[1] > k[0]
