"""InstallationSpaceRegions: which parts of a mesh lie on the installation space, and how they blend."""

from __future__ import annotations

from typing import Any

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkPolyData

from ..kernels.regions import blend_weights
from .arrays import surface_of, vtk_array
from .base import Filter, output_like
from .parameter import Parameter
from .signed_distance import SignedDistance, check_sizes, touching_distance
from .smoothing import FIXED

BLEND_WEIGHT = "BlendWeight"


class InstallationSpaceRegions(Filter):
    """Tell the clean parts of a flow volume's skin, which lie on the installation space, from the noisy.

    Adds the point arrays ``Fixed`` (uint8: 1 on the installation space) and ``BlendWeight`` (float64: 1 at
    free points, falling to 0 within some rings of fixed points), which keeps a ridge from forming where
    clean meets noisy. Source: paper B, section 4.2.

    Guarantees
    ----------
    Points, cells and their data stay. A weight is 1 at every free point and 0 at every fixed point that is
    more than ``blend_rings`` edges from the nearest free one.

    Attributes
    ----------
    summary : dict
        How many points are ``fixed``, ``blended`` (fixed, with a weight above 0) and ``free``.
    notes : list of str
        What is unusual about the installation space.

    Examples
    --------
    >>> from vtkmodules.vtkFiltersSources import vtkCubeSource
    >>> from vtksmooth import InstallationSpaceRegions
    >>> space, inner = vtkCubeSource(), vtkCubeSource(x_length=0.5)
    >>> _ = space.Update(), inner.Update()
    >>> regions = InstallationSpaceRegions()
    >>> result = regions(inner.GetOutput(), space.GetOutput())
    >>> regions.summary["fixed"], regions.summary["free"]
    (24, 0)
    """

    command = "regions"
    inputs = ("mesh", "installation")

    contact_fraction = Parameter(
        1e-6, "Points no farther from the installation space than this part of its diagonal are fixed.",
        low=0.0, unit="diagonals",
    )  # fmt: skip
    blend_rings = Parameter(3, "Rings of fixed points over which the weight falls from 1 to 0.", low=0)

    def __init__(self, **parameters: Any) -> None:
        super().__init__(**parameters)
        self.summary: dict[str, Any] = {}
        self.notes: list[str] = []

    def execute(self, *inputs: Any) -> vtkPolyData:
        """Classify one polydata."""
        source, installation = inputs
        self.progress(0.0, "measuring distances")
        mesh = surface_of(source).mesh
        space = SignedDistance(installation)
        self.notes = [*space.notes, *check_sizes(mesh, space.mesh)]
        contact = touching_distance(self.contact_fraction, space.mesh, source, installation)
        used = np.unique(mesh.connectivity)
        fixed = np.zeros(mesh.n_points, np.uint8)
        distances = space(mesh.points[used], lambda part: self.progress(0.1 + 0.7 * part))
        near = np.abs(distances) <= contact
        fixed[used] = near
        self.progress(0.8, "blending")
        weights = blend_weights(mesh, fixed, self.blend_rings)
        self.summary = {
            "fixed": int(near.sum()),
            "blended": int((fixed[used].astype(bool) & (weights[used] > 0.0)).sum()),
            "free": int(len(used) - near.sum()),
        }
        output = output_like(source)
        output.GetPointData().AddArray(vtk_array(fixed, FIXED))
        output.GetPointData().AddArray(vtk_array(weights, BLEND_WEIGHT))
        self.progress(1.0)
        return output
