"""ContainmentCheck: whether anything of a mesh is outside its installation space."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from vtkmodules.vtkCommonDataModel import vtkPolyData

from ..kernels.containment.crossings import crossing_triangles
from ..kernels.mesh.mesh import LARGEST_COORDINATE
from ..kernels.mesh.triangulate import triangulate
from .arrays import output_like, vtk_array
from .base import Filter, add_field
from .parameter import Parameter
from .places import Joined
from .signed_distance import SignedDistance, opened

SIGNED_DISTANCE = "SignedDistance"


def _settle_signs(
    space: SignedDistance,
    points: npt.NDArray[np.float64],
    distances: npt.NDArray[np.float64],
    tolerance: float,
) -> None:
    far = np.flatnonzero(np.abs(distances) > tolerance)  # and not NaN
    doubtful = far[(space.tree(points[far]) > 0.0) != (distances[far] > 0.0)]
    distances[doubtful] = space.with_signs(points[doubtful], distances[doubtful])


def _add_fields(output: vtkPolyData, verdict: dict[str, Any]) -> None:
    for name, key in (
        ("VerticesOutside", "vertices_outside"),
        ("MaxOutside", "max_outside"),
        ("TrianglesCrossing", "triangles_crossing"),
    ):
        add_field(output, name, verdict[key])


class ContainmentCheck(Filter):
    """Count the vertices of a mesh outside its installation space, and the triangles that cross it.

    Adds the point array ``SignedDistance`` (float64, negative inside). Distances are VTK's, with signs by
    angle-weighted pseudonormals; where compiled code finds another sign, at slivers, and in spaces of solids
    that overlap or touch, the winding number decides: inside is where it is 1 or more. Lids close the
    openings of an open space, and count as its walls. A triangle whose corners are all inside may still be
    pierced, by a concave corner of the space; that is tested triangle against triangle. Polygons count as the
    triangles that ValenceTriangulation makes of them. Source: the installation-space paper, section 6, and
    beyond it.

    Guarantees
    ----------
    Verdicts are independent of how the mesh was made: this filter shares no state with the smoothing.
    Touching within the tolerance counts neither as outside nor as crossing.

    Not guaranteed: that a closed mesh is inside which goes *round* a part of the space without crossing it
    (a void of the space that the mesh encloses).

    Attributes
    ----------
    summary : dict
        ``vertices_outside`` (points of the mesh, as in the array), ``max_outside`` (largest signed distance,
        0 if none is positive; model units) and ``triangles_crossing``, the figures of
        ``vtksmooth containment --json``; also in field data.
    notes : list of str
        What is unusual about the installation space.

    Examples
    --------
    >>> from vtkmodules.vtkFiltersSources import vtkCubeSource
    >>> from vtksmooth import ContainmentCheck
    >>> space, part = vtkCubeSource(), vtkCubeSource(x_length=0.5, y_length=0.5, z_length=1.5)
    >>> _ = space.Update(), part.Update()
    >>> check = ContainmentCheck()
    >>> result = check(part.GetOutput(), space.GetOutput())
    >>> check.summary
    {'vertices_outside': 24, 'max_outside': 0.25, 'triangles_crossing': 8}
    """

    command = "containment"
    inputs = ("mesh", "installation")
    measures = True

    tolerance_fraction = Parameter(
        1e-6, "Distance that counts as touching; never less than what the points' precision makes of it.",
        low=0.0, unit="diagonals",
    )  # fmt: skip

    def spread(self, results: tuple[Any, ...], whole: Joined) -> list[tuple[Any, ...]]:
        """Return the blocks, each with its own verdict in its field data."""
        outputs = super().spread(results, whole)
        for (output,), verdict in zip(outputs, self._verdicts, strict=True):
            _add_fields(output, verdict)
        return outputs

    def execute(self, *inputs: Any) -> vtkPolyData:
        """Check one polydata."""
        source, installation = inputs
        self.progress(0.0, "measuring distances")
        mesh, space, tolerance, _ = opened(source, installation, self.tolerance_fraction)
        triangles, face = triangulate(mesh)
        self.notes += space.notes
        distances = np.full(mesh.n_points, np.nan)
        # Points of no face may be anywhere.
        there = (np.abs(mesh.points) <= LARGEST_COORDINATE).all(axis=1)
        distances[there] = space(mesh.points[there], lambda part: self.progress(0.1 + 0.6 * part))
        _settle_signs(space, mesh.points, distances, tolerance)
        self.progress(0.7, "looking for crossings")
        crossing = crossing_triangles(mesh.points, triangles, space.tree.surface, distances, tolerance)

        def verdict(chosen: npt.NDArray[np.bool_], copies: npt.NDArray[np.int64]) -> dict[str, Any]:
            used = np.unique(triangles[chosen])
            return {
                "vertices_outside": int(copies[used[distances[used] > tolerance]].sum()),
                "max_outside": float(max(0.0, distances[used].max(initial=0.0))),
                "triangles_crossing": int(crossing[chosen].sum()),
            }

        self.summary = verdict(np.ones(len(triangles), np.bool_), self.copies(source))
        if self.whole is not None:
            block = self.whole.block_of_faces[face]
            self._verdicts = [
                verdict(block == number, self.whole.copies(number))
                for number in range(len(self.whole.blocks))
            ]
        output = output_like(source)
        output.GetPointData().AddArray(vtk_array(distances, SIGNED_DISTANCE))
        _add_fields(output, self.summary)
        self.progress(1.0)
        return output
