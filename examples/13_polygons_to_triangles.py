"""
Polygons into triangles with even valences
==========================================

Smoothing works evenly where points have about six neighbours. ``valence_triangulation`` splits polygons
with that in mind; fans and ear clipping leave points with three neighbours beside points with ten.
"""

import numpy as np
import pyvista as pv

from vtksmooth import samples

skin, _ = samples.channel()  # squares, cut by the slanted walls: 3 to 6 corners
sizes = np.diff(skin.GetPolys().GetOffsetsArray())
print({corners: int((sizes == corners).sum()) for corners in np.unique(sizes).tolist()})

# %%
# The valence of a point is the number of edges that end there.


def valences(mesh: pv.PolyData) -> np.ndarray:
    """Return the number of edges at each point of a mesh of triangles."""
    faces = mesh.regular_faces
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    return np.bincount(np.unique(edges, axis=0).ravel(), minlength=mesh.n_points)


results = {
    "PyVista's triangulate": skin.triangulate(),
    "valence_triangulation": skin.vtksmooth.valence_triangulation(),
}
for mesh in results.values():
    mesh["valence"] = valences(mesh)

plotter = pv.Plotter(shape=(1, 2), window_size=(1400, 620))
for column, (name, mesh) in enumerate(results.items()):
    plotter.subplot(0, column)
    plotter.add_mesh(
        mesh, scalars="valence", clim=(3, 9), cmap="RdBu_r", n_colors=7, show_edges=True,
        line_width=0.5, ambient=0.3, interpolate_before_map=False,
        scalar_bar_args={"n_labels": 7, "fmt": "%.0f"},
    )  # fmt: skip
    plotter.add_text(name, position=(0.02, 0.93), viewport=True, font_size=10)
plotter.link_views()
plotter.view_vector((-0.6, -1.0, 0.6))
plotter.camera.zoom(1.4)
plotter.show()

# %%
# All points stay, with their data; the triangles know which polygon they are of.

inner = valences(results["valence_triangulation"])
for name, mesh in results.items():
    counts = np.bincount(mesh["valence"], minlength=11)
    print(
        f"{name:22}", {valence: int(count) for valence, count in enumerate(counts) if count and valence > 2}
    )
far = {name: (np.abs(mesh["valence"] - 6) > 2).mean() for name, mesh in results.items()}
assert far["valence_triangulation"] < 0.3 * far["PyVista's triangulate"]
assert np.array_equal(results["valence_triangulation"].points, skin.points)
assert results["valence_triangulation"]["OriginalCell"].max() == skin.n_cells - 1
