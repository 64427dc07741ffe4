"""InstallationSpaceSmoothing: a voxel skin in, a smooth surface that fits its installation space out."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import numpy as np
import numpy.typing as npt
from vtkmodules.vtkCommonDataModel import vtkPolyData

from ..errors import ParameterError
from ..kernels.containment.crossings import crossing_triangles
from ..kernels.mesh.mesh import Mesh
from ..report import InstallationSpaceReport
from .arrays import output_like, surface_of, vtk_array
from .base import add_field
from .installation_space_regions import InstallationSpaceRegions, classify
from .laplacian_smoothing import LaplacianSmoothing
from .parameter import AUTO, Parameter
from .places import Block
from .signed_distance import Inside, opened, relative, touching_distance, used_points
from .smoothing import BLEND_WEIGHT, FIXED, SmoothingFilter
from .valence_triangulation import ValenceTriangulation


class InstallationSpaceSmoothing(LaplacianSmoothing):
    """Smooth the skin of a flow volume inside its installation space, without changing its volume.

    The chain of the installation-space paper: polygons become triangles with valences near six; parts
    that lie on the space's surface are clean and stay, with a blend to the noisy parts; then sweeps,
    along the flow if there is one, bounded by curvature, with the volume kept by every operation and nothing
    leaving the space; then a count of what is outside. The output has the input's points in the input's
    order, triangles, and the point arrays ``Fixed`` and ``BlendWeight``.

    Guarantees
    ----------
    With the scheme pairwise, the volume (of open meshes: the volume swept) changes by at most 1e-14 of it in
    each iteration, before points are rounded to single precision; ``report`` has it after rounding, too.
    Points with ``BlendWeight`` 0, points of the array `fixed`, and the boundary keep their bits. With
    ``containment="exact"`` no point that was inside is outside by more than the tolerance, none that was
    outside is farther outside than before, and no triangle crosses the space's surface that did not before.
    No faces cross or touch that did not, of the triangles as the output has them. Neither the number of
    threads nor the pose matters. With a gate, `crease_angle`, `max_deviation_fraction` or `max_displacement`
    what :class:`~vtksmooth.LaplacianSmoothing` guarantees of them, at the same time.

    Not guaranteed: that elements do not invert (``report`` counts them), unless ``gate="aspect"``,
    ``gate="floor"`` or `preserve_volume` is set. Vertices where the surface is none, as where voxels touch
    along an edge, do not move.

    Attributes
    ----------
    report : InstallationSpaceReport
        What the last execution did.

    Examples
    --------
    >>> from vtkmodules.vtkFiltersSources import vtkCubeSource, vtkSphereSource
    >>> from vtksmooth import InstallationSpaceSmoothing
    >>> space, part = vtkCubeSource(), vtkSphereSource(radius=0.45)
    >>> _ = space.Update(), part.Update()
    >>> smoothing = InstallationSpaceSmoothing(iterations=3)
    >>> result = smoothing(part.GetOutput(), space.GetOutput())
    >>> smoothing.report.outside, smoothing.report.crossing
    ((0, 0), (0, 0))
    """

    command = "installation-space"
    inputs = ("mesh", "installation")
    optional_inputs = ("source",)

    #: Whether polygons were split into triangles.
    _split = False

    iterations = Parameter(20, "Most iterations to do.", low=0)
    fixed = SmoothingFilter.fixed.with_default(None)
    blend = SmoothingFilter.blend.with_default(None)
    scheme = Parameter(
        "pairwise",
        "Scheme; pairwise keeps the volume by itself, all others with preserve_volume.",
        choices=LaplacianSmoothing.scheme.choices,
    )
    relaxation_factor = LaplacianSmoothing.relaxation_factor.with_default(1.0)
    curvature_radius = SmoothingFilter.curvature_radius.with_default(AUTO)
    self_intersection = SmoothingFilter.self_intersection.with_default("none-new")
    contact_fraction = InstallationSpaceRegions.contact_fraction
    blend_rings = InstallationSpaceRegions.blend_rings
    containment = SmoothingFilter.containment.always()
    tolerance_fraction = SmoothingFilter.tolerance_fraction.always()

    boundary_labels = LaplacianSmoothing.boundary_labels.with_default(None)

    report: InstallationSpaceReport

    def forget(self) -> None:
        """Drop what the last execution reported."""
        super().forget()
        self.report = InstallationSpaceReport()

    def check(self, *inputs: Any) -> None:
        """Refuse arrays that cannot be used, before the faces are triangles."""
        super().check(*inputs)
        if self.boundary_labels is not None:
            raise ParameterError(
                "boundary_labels: a surface between labels cannot be kept inside an installation space; "
                "leave the labels out, or smooth with LaplacianSmoothing."
            )
        self._split = False

    def prepared(self, block: Block) -> vtkPolyData:
        """Return a block with its polygons split into triangles."""
        source = block.data
        if block.index is None:
            # What is wrong with arrays is said of the input, not of what follows from it.
            self.read_arrays(source)
        self.progress(0.0, "triangulating")
        triangles: vtkPolyData = ValenceTriangulation()(source)
        before = source.GetNumberOfPolys() + source.GetNumberOfStrips()
        self._split = self._split or triangles.GetNumberOfPolys() != before
        return triangles

    def execute(self, *inputs: Any) -> vtkPolyData:
        """Smooth one polydata of triangles inside another."""
        source, installation, onto = (*inputs, None)[:3]
        self.progress(0.05, "measuring distances")
        inside, copies = opened(source, installation, self.tolerance_fraction), self.copies(source)
        triangles, held, weights, summary = self._with_regions(source, installation, inside, copies)
        self.progress(0.1, "looking for crossings")
        before = _measured(inside.mesh, inside)
        inside = inside._replace(measured=before)
        low, high = self._share
        self._share = (low + 0.15 * (high - low), low + 0.9 * (high - low))
        output = self.smoothed(triangles, held, weights, inside, onto)
        self._share = (low, high)
        self.progress(0.9, "verifying")
        after = _measured(relative(surface_of(output).mesh, inside.space.origin), inside)
        outside = [int(copies[distances > inside.tolerance].sum()) for distances, _ in (before, after)]
        report = InstallationSpaceReport(
            **asdict(self.report),
            **summary,
            outside=(outside[0], outside[1]),
            crossing=(int(before[1].sum()), int(after[1].sum())),
            notes=inside.space.notes,
        )
        if self._split:
            report.notes.append(
                "Faces were cut into triangles first: k, before as well, is that of triangles."
            )
        if self._vectors is not None and not self._vectors.any():
            report.notes.append("The flow is zero everywhere: smoothing is the same in all directions.")
        self.report = report
        add_field(output, "VerticesOutside", report.outside[1])
        add_field(output, "TrianglesCrossing", report.crossing[1])
        add_field(output, "SweptVolume", report.swept_volume)
        self.progress(1.0)
        return output

    def _with_regions(
        self, source: Any, installation: Any, inside: Inside, copies: npt.NDArray[np.int64]
    ) -> tuple[vtkPolyData, npt.NDArray[Any] | None, npt.NDArray[np.float64], dict[str, Any]]:
        """Return the mesh with its regions, the points that are held, the weights, and how many are what.

        Regions are those of the space, and what the arrays that the parameters name say.
        """
        contact = touching_distance(self.contact_fraction, inside.space.mesh, source, installation)
        fixed, weights, summary = classify(
            inside.mesh, copies, inside.space.tree, contact, self.blend_rings,
            lambda part: self.progress(0.05 + 0.05 * part),
        )  # fmt: skip
        held = self.held_points(source)
        given = self.weights_of_steps(source, held)
        if held is not None:
            fixed = (fixed | (held != 0)).astype(np.uint8)
            weights = np.where(held != 0, 0.0, weights)
        if given is not None:
            weights = weights * given
        triangles = output_like(source)
        triangles.GetPointData().AddArray(vtk_array(fixed, FIXED))
        triangles.GetPointData().AddArray(vtk_array(weights, BLEND_WEIGHT))
        return triangles, held, weights, summary


def _measured(mesh: Mesh, inside: Inside) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.bool_]]:
    """Return the signed distances of points, 0 where no face uses them, and which triangles cross."""
    space, used = inside.space.tree, used_points(mesh)
    distances: npt.NDArray[np.float64] = np.zeros(mesh.n_points)
    distances[used] = space(mesh.points[used])
    return distances, crossing_triangles(
        mesh.points, mesh.connectivity.reshape(-1, 3), space.surface, distances, inside.tolerance
    )
