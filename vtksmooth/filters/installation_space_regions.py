"""InstallationSpaceRegions: which parts of a mesh lie on the installation space, and how they blend."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt
from vtkmodules.vtkCommonDataModel import vtkPolyData

from ..kernels.distance.signed_distance import SignedDistanceTree
from ..kernels.mesh.mesh import Mesh
from ..kernels.mesh.regions import blend_weights
from .arrays import output_like, vtk_array
from .base import Filter
from .parameter import Parameter
from .signed_distance import opened, used_points
from .smoothing import BLEND_WEIGHT, FIXED


class InstallationSpaceRegions(Filter):
    """Tell the clean parts of a flow volume's skin, which lie on the installation space, from the noisy.

    Adds the point arrays ``Fixed`` (uint8: 1 on the installation space) and ``BlendWeight`` (float64: 1 at
    free points, falling to 0 within some rings of fixed points), which keeps a ridge from forming where
    clean meets noisy. Source: the installation-space paper, section 4.2.

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

    def execute(self, *inputs: Any) -> vtkPolyData:
        """Classify one polydata."""
        source, installation = inputs
        self.progress(0.0, "measuring distances")
        mesh, space, contact, _ = opened(source, installation, self.contact_fraction)
        self.notes += space.notes
        fixed, weights, self.summary = classify(
            mesh, self.copies(source), space.tree, contact, self.blend_rings, self.progress
        )
        output = output_like(source)
        output.GetPointData().AddArray(vtk_array(fixed, FIXED))
        output.GetPointData().AddArray(vtk_array(weights, BLEND_WEIGHT))
        self.progress(1.0)
        return output


def classify(
    mesh: Mesh,
    copies: npt.NDArray[np.int64],
    space: SignedDistanceTree,
    contact: float,
    rings: int,
    tell: Callable[[float], None],
) -> tuple[npt.NDArray[np.uint8], npt.NDArray[np.float64], dict[str, Any]]:
    """Return what is fixed, (n,), the blend weights, (n,), and how many points are what.

    Parameters
    ----------
    mesh : Mesh
    copies : (n,) int64
        How many points of the input each point is.
    space : SignedDistanceTree
    contact : float
        Points no farther from the space's surface than this are fixed.
    rings : int
        Rings of fixed points over which the weight falls from 1 to 0.
    tell : callable
        Called with the part that is done; it may raise to cancel.
    """
    used = used_points(mesh)
    fixed = np.zeros(mesh.n_points, np.uint8)
    fixed[used] = near = np.isfinite(space(mesh.points[used], contact))
    weights = blend_weights(mesh, fixed, rings, tell)
    return (
        fixed,
        weights,
        {
            "fixed": int(copies[used[near]].sum()),
            "blended": int(copies[used[near & (weights[used] > 0.0)]].sum()),
            "free": int(copies[used[~near]].sum()),
        },
    )
