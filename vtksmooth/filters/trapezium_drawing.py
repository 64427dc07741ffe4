"""TrapeziumDrawing: better triangles and quadrilaterals by moving points (Semenova et al.)."""

from __future__ import annotations

from ..kernels.smoothing.schemes import Scheme
from ..kernels.smoothing.schemes.trapezium import TrapeziumDrawing as Trapezium
from .parameter import Parameter
from .smoothing import SmoothingFilter


class TrapeziumDrawing(SmoothingFilter):
    """Improve the worst elements round every vertex, staying close to the surface that the mesh means.

    Each neighbour of a vertex, with the neighbour across, asks for the point on a parallel to the line
    between the two where a triangle with them is isosceles; the vertex goes to the mean of these points
    if that improves the worst element round it. Source: I. B. Semenova, V. V. Savchenko, I. Hagiwara,
    "Improvement of Triangular and Quadrilateral Surface Meshes", sections 2 and 3.

    Guarantees
    ----------
    With ``gate="aspect"``, before the output's points are rounded to single precision: no iteration
    lowers the smallest k of the mesh or makes more faces inverted, both against the input's directions.
    Fixed points keep their bits. Topology is the input's. The result does not depend on the number of
    threads.

    Not guaranteed: the *mean* of k; nor k of a ring whose own vertex did not move.

    Examples
    --------
    >>> from vtkmodules.vtkFiltersSources import vtkDiskSource
    >>> from vtksmooth import TrapeziumDrawing
    >>> disk = vtkDiskSource(radial_resolution=4, circumferential_resolution=12)
    >>> smoothing = TrapeziumDrawing(iterations=3)
    >>> smoothing.SetInputConnection(disk.GetOutputPort())
    >>> _ = smoothing.Update()
    >>> smoothing.report.inverted
    (0, 0)
    """

    command = "trapezium-drawing"

    iterations = Parameter(5, "Most iterations to do.", low=0)
    gate = SmoothingFilter.gate.with_default("aspect")

    def make_scheme(self) -> Scheme:
        """Return Trapezium Drawing."""
        return Trapezium()
