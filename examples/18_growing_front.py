"""
A growing front keeps the books
===============================

A front that gains volume by a source, as in deposition, etching or growth, is moved and smoothed in one
step: ``flux`` names an array of the volume that the surface gains per area. Over 1,000 steps the volume
gained is the flux integrated, to rounding: what rounding leaves over in one step is added to the next.
"""

# %%
# A ball grows faster on top than below, a thousandth of its radius in each step, while the null-space scheme
# keeps its triangles in shape. The books: what was to be gained so far, and what was.

import numpy as np
import pyvista as pv

from vtksmooth import NullSpaceSmoothing

front = pv.Icosphere(radius=1.0, nsub=2)
front.points = front.points.astype(np.float64)  # in single precision rounding is 1e-7
start = front.copy()
first = front.volume
growing = NullSpaceSmoothing(
    iterations=1, relaxation_factor=0.2, flux="Source", gate="none", features="ignore"
)

wanted, gained, remainder, drift = 0.0, 0.0, 0.0, []
for _ in range(1000):
    heights = front.cell_centers().points[:, 2]
    heights = (heights - heights.min()) / np.ptp(heights)
    rate = 5e-4 * (1.0 + heights)
    front.clear_data()
    front["Source"] = rate + remainder / front.area
    grown = pv.wrap(growing(front))
    step = growing.report.flux - remainder
    wanted += step
    gained += growing.report.swept_volume
    remainder = wanted - gained
    drift.append(abs(grown.volume - first - wanted) / wanted)
    front = grown

print(f"volume {first:.6f} -> {front.volume:.6f}; wanted {wanted:.6f}, gained {gained:.6f}")
print(f"the books are off by {abs(wanted - gained) / wanted:.1e} of what was gained")
print(f"smallest k after 1,000 steps: {growing.report.min_aspect_ratio[1]:.3f}")

assert abs(wanted - gained) < 1e-14 * wanted
assert drift[-1] < 1e-12
assert growing.report.min_aspect_ratio[1] > 0.5

# %%
# The front, coloured by what it gains per area in a step.

front.clear_data()
heights = front.cell_centers().points[:, 2]
front["gain per area"] = 5e-4 * (1.0 + (heights - heights.min()) / np.ptp(heights))
plotter = pv.Plotter(window_size=(900, 600))
plotter.add_mesh(front, scalars="gain per area", show_edges=True, cmap="viridis")
plotter.add_mesh(start, color="black", style="wireframe", opacity=0.4)
plotter.camera_position = "xz"
plotter.show()
