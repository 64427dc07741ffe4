"""
Segmentations, surfaces that fit together
=========================================

A label image becomes one surface between all labels. It is smoothed as a whole, so no gaps open between
neighbours, and every label keeps the volume of its voxels.
"""

# %%
# A part of PyVista's bundled frog: three organs that touch each other.

import numpy as np
import pyvista as pv
from pyvista import examples

from vtksmooth import SegmentationSurface

image = pv.read(examples.frogtissuesfile).extract_subset((180, 330, 150, 300, 40, 100))

# %%
# The filter takes the image. Its report holds the volume of every label before and after.

segmentation = SegmentationSurface(iterations=20)
smooth = pv.wrap(segmentation(image))
rough = pv.wrap(SegmentationSurface(iterations=0)(image))
print(segmentation.report)

# %%
# Each triangle knows the labels on both of its sides; normals run from the first to the second.

plotter = pv.Plotter(shape=(1, 2), window_size=(1400, 650))
for column, (mesh, title) in enumerate(((rough, "voxels"), (smooth, "smooth, all volumes kept"))):
    plotter.subplot(0, column)
    colours = mesh.copy()
    colours.cell_data["label"] = colours.cell_data["BoundaryLabels"][:, 0]
    plotter.add_mesh(
        colours, scalars="label", cmap="tab20", show_scalar_bar=False, specular=0.3, copy_mesh=True
    )
    plotter.add_text(title, font_size=11)
plotter.link_views()
plotter.view_vector((1.0, -1.0, 0.8))
plotter.camera.zoom(1.2)
plotter.show()

# %%
# What holds: every label has the volume of its voxels, and no triangle has turned over.

voxel = float(np.prod(image.spacing))
for each in segmentation.report.labels:
    assert abs(each.volume / (each.voxels * voxel) - 1.0) < 1e-12
assert segmentation.report.inverted == (0, 0)
