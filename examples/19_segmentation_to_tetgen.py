"""
Segmentation to tetrahedra
==========================

A label image in, a volume mesh out: one surface between all labels that TetGen accepts as it is, and
tetrahedra whose volumes, label by label, are those of the voxels.
"""

# %%
# A part of PyVista's bundled frog. Smoothing keeps every label's volume, and takes back the few steps by
# which thin walls would pass through each other.

import numpy as np
import pyvista as pv
import tetgen
from pyvista import examples

from vtksmooth import SegmentationSurface, SelfIntersection

image = pv.read(examples.frogtissuesfile).extract_subset((200, 260, 170, 250, 50, 90))
segmentation = SegmentationSurface(iterations=20)
surface = pv.wrap(segmentation(image))
print(f"{surface.n_cells} triangles, {segmentation.report.taken_back} steps taken back")

check = SelfIntersection()
check(surface)
print(check.summary)

# %%
# TetGen fills all labels at once. The walls between them stay as they are (``nobisect``), and so do their
# points.

mesher = tetgen.TetGen(pv.PolyData(surface.points, surface.faces))
points, tetrahedra, region, _ = mesher.tetrahedralize(
    plc=True, nobisect=True, quality=False, regionattrib=True
)
region = region.ravel().astype(int) - 1

# %%
# A wall knows the labels on both of its sides, the second is where its normal points to. So the walls of a
# region say what it is.

corners = surface.regular_faces
wall = dict(zip(map(tuple, np.sort(corners, axis=1).tolist()), range(len(corners)), strict=True))
votes = np.zeros((region.max() + 1, max(each.label for each in segmentation.report.labels) + 1), int)
for left_out in range(4):
    sides = np.delete(tetrahedra, left_out, axis=1)
    found = np.array([wall.get(key, -1) for key in map(tuple, np.sort(sides, axis=1).tolist())])
    beside = np.flatnonzero(found >= 0)
    a, b, c = points[corners[found[beside]]].transpose(1, 0, 2)
    ahead = np.einsum("ij,ij->i", np.cross(b - a, c - a), points[tetrahedra[beside, left_out]] - a) > 0
    side = surface.cell_data["BoundaryLabels"][found[beside], ahead.astype(int)]
    np.add.at(votes, (region[beside], side), 1)
label = votes.argmax(axis=1)

a, b, c, d = points[tetrahedra].transpose(1, 0, 2)
volume = np.abs(np.einsum("ij,ij->i", b - a, np.cross(c - a, d - a))) / 6
of_labels = np.bincount(label[region], volume)
counts = np.bincount(label[region])

print(f"{'label':>5} {'voxels':>12} {'tetrahedra':>12} {'change':>9} {'number':>8}")
voxel = float(np.prod(image.spacing))
for each in segmentation.report.labels:
    wanted, got = each.voxels * voxel, of_labels[each.label]
    print(f"{each.label:5} {wanted:12.2f} {got:12.2f} {got / wanted - 1:9.1e} {counts[each.label]:8}")

# %%
# Cut open: the tetrahedra of neighbours share the points of their wall.

grid = pv.UnstructuredGrid({pv.CellType.TETRA: tetrahedra}, points)
grid.cell_data["label"] = label[region]
inside = grid.extract_cells(grid.cell_data["label"] != 0)
half = inside.extract_cells(inside.cell_centers().points[:, 1] > np.mean(inside.bounds[2:4]))

plotter = pv.Plotter(window_size=(1400, 700))
plotter.add_mesh(half, scalars="label", cmap="tab20", show_edges=True, show_scalar_bar=False)
plotter.view_vector((0.3, -1.0, 0.4))
plotter.camera.zoom(1.3)
plotter.show()

# %%
# What holds: nothing crosses, every label of the surface has the volume of its voxels to rounding, and its
# tetrahedra have it but for what TetGen cuts off where it must put a point of its own into a wall.

assert check.summary["crossing_pairs"] == check.summary["touching_pairs"] == 0
for each in segmentation.report.labels:
    assert abs(each.volume / (each.voxels * voxel) - 1.0) < 1e-12
    assert abs(of_labels[each.label] / (each.voxels * voxel) - 1.0) < 1e-5
