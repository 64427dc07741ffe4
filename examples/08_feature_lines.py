"""
Ridges and corners, amid noise too
==================================

``feature_detection`` says of every point whether it lies on a ridge, at a corner or at a cusp, and returns
the ridge lines. Its thresholds fit the mesh's own noise, so that the same call serves for a clean model and
for a scanned one.
"""

import numpy as np
import pyvista as pv
from pyvista import examples

nut = pv.read(examples.nutfile)
found, lines = nut.vtksmooth.feature_detection(return_lines=True)
print(f"ridge angle {found.field_data['RidgeAngle'][0]:.1f} degrees, {lines.n_lines} lines")

# %%
# A block, and the same with noise of a tenth of the edge length on every coordinate.

block = pv.Box(level=9).triangulate().clean()
edge = 2.0 / 10
noisy = block.copy()
noisy.points = block.points + 0.1 * edge * np.random.default_rng(3).standard_normal(block.points.shape)
clean_block, clean_lines = block.vtksmooth.feature_detection(return_lines=True)
noisy_block, noisy_lines = noisy.vtksmooth.feature_detection(return_lines=True)
by_angle = noisy.extract_feature_edges(
    30, boundary_edges=False, non_manifold_edges=False, manifold_edges=False
)

# %%
# Ridge lines are tubes, corners red. Beside ours what a dihedral angle of 30 degrees alone would find.

plotter = pv.Plotter(shape=(1, 3), window_size=(1500, 520))
shown = (
    ("a nut", found, lines),
    (f"noise: {noisy_lines.n_lines} lines", noisy_block, noisy_lines),
    ("the same noise, edges above 30 degrees", noisy, by_angle),
)
for column, (name, mesh, edges) in enumerate(shown):
    plotter.subplot(0, column)
    plotter.add_mesh(mesh, color="#dddddd", show_edges=True, edge_color="#aaaaaa")
    plotter.add_mesh(edges, color="#1f78b4", line_width=6, render_lines_as_tubes=True)
    if "FeatureClass" in mesh.point_data:
        corners = mesh.points[mesh["FeatureClass"] >= 2]
        if len(corners):
            plotter.add_points(corners, color="#d62728", point_size=14, render_points_as_spheres=True)
    plotter.add_text(name, position=(0.02, 0.93), viewport=True, font_size=10)
    plotter.view_vector((1.0, 1.3, 0.9), viewup=(0, 1, 0))
plotter.show()

# %%
# On the block the truth is known: 12 edges, 8 corners. Noise must not change that much.

truth = (np.isclose(np.abs(block.points), 1.0).sum(axis=1) >= 2).astype(int)
right = {
    name: ((mesh["FeatureClass"] > 0) == truth).mean()
    for name, mesh in (("clean", clean_block), ("noisy", noisy_block))
}
print({name: f"{share:.1%} of the points classified right" for name, share in right.items()})
assert clean_lines.n_lines == 12
assert (clean_block["FeatureClass"] == 2).sum() == 8
assert right["clean"] == 1.0
assert right["noisy"] > 0.97
assert by_angle.n_cells > 2 * noisy_lines.n_lines
