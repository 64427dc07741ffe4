"""
A flow channel that fits its installation space
===============================================

A flow volume comes out of a simulation as the skin of cells: clean where it lies on the walls of the space
it has to fit in, stairs elsewhere. ``installation_space_smoothing`` smooths the stairs, keeps the clean
parts and the volume, and lets nothing out of the space.
"""

import numpy as np
import pyvista as pv

from vtksmooth import ContainmentCheck, InstallationSpaceSmoothing, samples

skin, space = samples.channel()

# %%
# What is clean, and how far its surroundings may follow the noisy parts: ``BlendWeight`` falls from 1 to 0
# within three rings.

regions = skin.vtksmooth.installation_space_regions(space)
smoothing = InstallationSpaceSmoothing(iterations=20)
result = pv.wrap(smoothing(skin, space))
print(smoothing.report)

view = (-0.7, -1.0, 0.7)
plotter = pv.Plotter(shape=(1, 2), window_size=(1500, 620))
plotter.subplot(0, 0)
plotter.add_mesh(regions, scalars="BlendWeight", cmap="viridis", show_edges=True, line_width=0.5)
plotter.add_text("0 is clean, on the walls; 1 is noisy", position=(0.02, 0.93), viewport=True, font_size=10)
plotter.subplot(0, 1)
plotter.add_mesh(result, color="#a6bddb", show_edges=True, line_width=0.5)
plotter.add_mesh(space.extract_feature_edges(20), color="black", line_width=2)
plotter.add_text("smooth, in its space", position=(0.02, 0.93), viewport=True, font_size=10)
plotter.link_views()
plotter.view_vector(view)
plotter.camera.zoom(1.3)
plotter.show()

# %%
# The check shares nothing with the smoothing. Any other smoother, for comparison: points outside in red.

others = skin.triangulate().smooth_taubin(n_iter=20)
counts = {}
plotter = pv.Plotter(shape=(1, 2), window_size=(1500, 620))
for column, (name, mesh) in enumerate((("smooth_taubin", others), ("installation_space_smoothing", result))):
    check = ContainmentCheck()
    checked = pv.wrap(check(mesh, space))
    counts[name] = check.summary
    plotter.subplot(0, column)
    plotter.add_mesh(
        checked, scalars="SignedDistance", clim=(-1, 1), cmap="coolwarm",
        scalar_bar_args={"title": "signed distance, cells"},
    )  # fmt: skip
    outside = checked.points[checked["SignedDistance"] > 1e-4]
    if len(outside):
        plotter.add_points(outside, color="#d62728", point_size=7, render_points_as_spheres=True)
    plotter.add_text(
        f"{name}: {check.summary['vertices_outside']} points outside, "
        f"{check.summary['triangles_crossing']} triangles crossing",
        position=(0.02, 0.93), viewport=True, font_size=10,
    )  # fmt: skip
plotter.link_views()
plotter.view_vector(view)
plotter.camera.zoom(1.3)
plotter.show()

# %%
# What holds: nothing outside, nothing crossing, clean points bit for bit, and no volume swept.

print(counts)
ours = counts["installation_space_smoothing"]
assert ours["vertices_outside"] == ours["triangles_crossing"] == 0
assert counts["smooth_taubin"]["vertices_outside"] > 0
clean = result["BlendWeight"] == 0
assert np.array_equal(result.points[clean], skin.points[clean])
assert abs(smoothing.report.swept_volume) < 1e-9
