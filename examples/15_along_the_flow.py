"""
Smoothing along a flow
======================

With a field of vectors the neighbours along it weigh more than those across: streaks along the flow stay,
noise along it goes. Size and sign of the vectors do not matter.
"""

import numpy as np
import pyvista as pv

from vtksmooth import samples

# %%
# A torus of voxels in a flow round its axis.

torus = samples.voxel_torus(tube=8, ring=24).vtksmooth.valence_triangulation()
x, y, _ = torus.points.T
torus["Flow"] = np.column_stack((-y, x, np.zeros_like(x)))

results = {"voxels": torus}
for weight in (0.0, 3.0, 100.0):
    results[f"flow weight {weight:g}"] = torus.vtksmooth.laplacian_smoothing(
        scheme="pairwise", iterations=3, relaxation_factor=0.3, flow="Flow", flow_weight=weight
    )

# %%
# What remains of the stairs: the distance to the torus that the voxels stand for.

plotter = pv.Plotter(shape=(2, 2), window_size=(1300, 1000))
for i, (name, mesh) in enumerate(results.items()):
    mesh["distance to the true torus"] = samples.torus_distance(mesh.points, tube=8, ring=24)
    plotter.subplot(*divmod(i, 2))
    plotter.add_mesh(
        mesh, scalars="distance to the true torus", clim=(-0.8, 0.8), cmap="coolwarm", specular=0.5
    )
    plotter.add_text(name, position=(0.02, 0.93), viewport=True, font_size=10)
plotter.link_views()
plotter.view_vector((0.3, -0.7, 1.0))
plotter.camera.zoom(1.4)
plotter.show()

# %%
# Roughness along the flow and across it: the difference of height between the ends of edges.


def roughness(mesh: pv.PolyData) -> tuple[float, float]:
    """Return the difference of height between the ends of edges, RMS: along the flow, across it."""
    faces = mesh.regular_faces
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    heights = mesh["distance to the true torus"][edges]
    steps = torus.points[edges[:, 1]] - torus.points[edges[:, 0]]
    flow = torus["Flow"][edges[:, 0]]
    cosine = np.abs((steps * flow).sum(axis=1))
    cosine /= np.linalg.norm(steps, axis=1) * np.linalg.norm(flow, axis=1)
    difference = np.diff(heights, axis=1)[:, 0] ** 2
    return tuple(float(np.sqrt(difference[part].mean())) for part in (cosine > 0.9, cosine < 0.3))


rough = {name: roughness(mesh) for name, mesh in results.items()}
for name, (along, across) in rough.items():
    print(f"{name:18} along {along:.3f}, across {across:.3f} voxels")
assert rough["flow weight 100"][1] > rough["flow weight 0"][1], "streaks across the flow are kept"
assert rough["flow weight 3"][0] < rough["flow weight 0"][0] < rough["voxels"][0], "noise along it goes"
volumes = [mesh.volume for mesh in results.values()]
assert np.ptp(volumes) < 1e-5 * volumes[0], "in single precision"
