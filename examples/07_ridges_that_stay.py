"""
Ridges that stay
================

A nut has flat faces and ridges between them, which plain smoothing rounds off. ``equilateral_smoothing``
finds the ridges, lets their points slide along them, holds the corners, and makes the triangles between them
as regular as their connectivity allows.
"""

import numpy as np
import pyvista as pv
from pyvista import examples

nut = pv.read(examples.nutfile)
results = {
    "as it is": nut,
    "PyVista's smooth": nut.smooth(n_iter=50, relaxation_factor=0.1),
    "equilateral_smoothing": nut.vtksmooth.equilateral_smoothing(),
}

# %%
# How sharp a mesh still is, we ask VTK: the length of its edges with a dihedral angle above 40 degrees.


def sharp_edges(mesh: pv.PolyData) -> pv.PolyData:
    """Return the edges with a dihedral angle above 40 degrees."""
    return mesh.extract_feature_edges(
        40, boundary_edges=False, non_manifold_edges=False, manifold_edges=False
    )


measured = {name: mesh.vtksmooth.surface_comparison(nut) for name, mesh in results.items()}
sharp = {name: sharp_edges(mesh) for name, mesh in results.items()}
for name, mesh in measured.items():
    k = mesh["AspectRatio"]
    print(
        f"{name:22} k mean {k.mean():.3f}, least {k.min():+.3f}; sharp edges: {sharp[name].n_cells};"
        f" volume {mesh.volume / nut.volume - 1:+.2%}; farthest {mesh['Deviation'].max() / nut.length:.2%}"
    )

# %%
# Sharp edges are drawn in red.

plotter = pv.Plotter(shape=(1, 3), window_size=(1500, 520))
for column, (name, mesh) in enumerate(measured.items()):
    plotter.subplot(0, column)
    plotter.add_mesh(
        mesh, scalars="AspectRatio", clim=(0, 1), cmap="cividis", n_colors=5, show_edges=True, ambient=0.4,
        scalar_bar_args={"title": "aspect ratio k", "n_labels": 3, "position_y": 0.02},
    )  # fmt: skip
    if sharp[name].n_cells:
        plotter.add_mesh(sharp[name], color="#d62728", line_width=5, render_lines_as_tubes=True)
    plotter.add_text(name, position=(0.02, 0.93), viewport=True, font_size=10)
plotter.link_views()
plotter.view_vector((1.0, 1.3, 0.9), viewup=(0, 1, 0))
plotter.show()

# %%
# What holds: edges above ``crease_angle`` (40 degrees) stay above it, and no face becomes inverted.

before, after = measured["as it is"]["AspectRatio"], measured["equilateral_smoothing"]["AspectRatio"]
assert sharp["equilateral_smoothing"].n_cells >= sharp["as it is"].n_cells
assert sharp["PyVista's smooth"].n_cells < sharp["as it is"].n_cells
assert after.mean() > before.mean()
assert (after < 0).sum() <= (before < 0).sum()
assert np.array_equal(results["equilateral_smoothing"].faces, nut.faces)
