"""
Noise gone, edges kept
======================

Scans are noisy, and parts have edges. ``feature_preserving_denoising`` finds by itself how much noise there
is and when it is gone; Taubin's filter, beside it, takes the edges along.
"""

import numpy as np
import pyvista as pv

import vtksmooth.accessor  # noqa: F401 (gives meshes `vtksmooth`)

clean = pv.Box(level=31).triangulate().clean()
edge = 2.0 / 32
scan = clean.copy()
scan.points += 0.25 * edge * np.random.default_rng(1).normal(size=scan.points.shape)

denoised = scan.vtksmooth.feature_preserving_denoising()
results = {
    "scan": scan,
    "Taubin": scan.vtksmooth.laplacian_smoothing(scheme="taubin", iterations=30),
    "feature_preserving_denoising": denoised,
}

# %%
# How far the normals of the faces are from the true ones, in the mean.

truth = clean.face_normals
errors = {}
for name, mesh in results.items():
    cosines = (mesh.face_normals * truth).sum(axis=1)
    mesh["error"] = np.degrees(np.arccos(np.clip(cosines, -1.0, 1.0)))
    errors[name] = mesh["error"].mean()
    print(f"{name:30}{errors[name]:6.2f} degrees, volume {mesh.volume / scan.volume - 1.0:+.1e}")
print("noise level", denoised.field_data["SmoothingNoiseLevel"][0], "of", 0.25 * edge)

plotter = pv.Plotter(shape=(1, 3), window_size=(1500, 540))
for column, (name, mesh) in enumerate(results.items()):
    plotter.subplot(0, column)
    plotter.add_mesh(mesh, color="white", ambient=0.2)
    plotter.add_text(f"{name}: {errors[name]:.1f}°", position=(0.02, 0.92), viewport=True, font_size=10)
plotter.link_views()
plotter.view_vector((1.0, 0.7, 0.6))
plotter.show()

# %%
# Most of the error is gone, and the volume is that of the scan.

assert errors["feature_preserving_denoising"] < 0.15 * errors["scan"]
assert errors["feature_preserving_denoising"] < 0.5 * errors["Taubin"]
assert abs(denoised.volume / scan.volume - 1.0) < 1e-6
