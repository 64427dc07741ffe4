"""
From a voxel skin to a surface that fits, in VTK
================================================

A voxel skin in, a surface that fits its installation space out: a pure VTK pipeline.

A flow volume made of cells, open at inlet and outlet, lies in an installation space. The pipeline splits
its polygons, tells clean parts from noisy, smooths the noisy ones along the flow without changing the
volume or leaving the space, and checks the result independently.

::

    python examples/05_installation_space.py
"""
# sphinx_gallery_thumbnail_path = "pictures/app_contained.png"

from __future__ import annotations

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkPolyData
from vtkmodules.vtkFiltersCore import vtkPolyDataNormals

from vtksmooth import ContainmentCheck, InstallationSpaceSmoothing, samples

# The two inputs. With files: vtkXMLPolyDataReader in their place, SetInputConnection below.
flow_volume, space = samples.channel()

smoothing = InstallationSpaceSmoothing(iterations=20, flow="Flow", flow_weight=3.0)
smoothing.SetInputDataObject(0, flow_volume)
smoothing.SetInputDataObject(1, space)

# The check shares nothing with the smoothing; native filters go on from there.
check = ContainmentCheck()
check.SetInputConnection(0, smoothing.GetOutputPort())
check.SetInputDataObject(1, space)
normals = vtkPolyDataNormals()
normals.SetInputConnection(check.GetOutputPort())
normals.SplittingOff()
normals.ConsistencyOff()
normals.Update()
result: vtkPolyData = normals.GetOutput()

print(smoothing.report)
print(check.summary)

# The checks.
before = np.asarray(flow_volume.points)
after = vtk_to_numpy(result.GetPoints().GetData())
weights = vtk_to_numpy(result.GetPointData().GetArray("BlendWeight"))
assert check.summary["vertices_outside"] == 0
assert check.summary["triangles_crossing"] == 0
assert abs(smoothing.report.swept_volume) < 1e-9, "an open mesh sweeps no volume"
assert (after[weights == 0] == before[weights == 0]).all(), "clean points stay, bit for bit"
noise = [np.sqrt(np.mean(samples.flow_distance(points[weights == 1]) ** 2)) for points in (before, after)]
print(f"noise of the free points, in cells: {noise[0]:.3f} before, {noise[1]:.3f} after")
assert noise[1] < 0.3 * noise[0]
