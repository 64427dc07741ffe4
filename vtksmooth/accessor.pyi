"""Made by ``python -m vtksmooth.accessor_stub`` from the filters' declarations; do not edit."""

from collections.abc import Sequence
from typing import Any, Literal, overload

import numpy.typing as npt
import pyvista as pv

from .filters import Filter

def method_name(cls: type[Filter]) -> str:
    """Return the name of a filter's method: TrapeziumDrawing becomes trapezium_drawing."""

class VtksmoothAccessor:
    """The filters of vtksmooth on a mesh: ``mesh.vtksmooth.trapezium_drawing(iterations=5)``.

    Each method takes the filter's parameters as keywords and returns a new ``pyvista.PolyData``
    (``inplace=True``: changes the mesh and returns it; ``progress_bar=True``: shows progress). What a
    filter makes beside the mesh is returned on demand (``return_lines=True``), all in a tuple.
    Of an unstructured grid the surface is taken, with a warning; a MultiBlock gives a MultiBlock.
    What a filter reports is in the result's field data; a mesh that cannot be worked on raises
    :class:`~vtksmooth.errors.InvalidMeshError`.

    To type checkers ``mesh.vtksmooth`` is anything, as PyVista has it. ``VtksmoothAccessor(mesh)`` is the
    same with types.

    Examples
    --------
    >>> import pyvista as pv
    >>> ant = pv.read(pv.examples.antfile)
    >>> better = ant.vtksmooth.trapezium_drawing(iterations=5)
    >>> better.n_points == ant.n_points
    True
    """

    def __init__(self, mesh: pv.PolyData | pv.UnstructuredGrid | pv.MultiBlock) -> None: ...

    def surface_quality(
        self,
        *,
        boundary_labels: str | None = 'BoundaryLabels',
        usual_measures: bool = True,
        self_intersections: bool = False,
        inplace: bool = False,
        progress_bar: bool = False,
    ) -> pv.PolyData:
        """Add the cell array ``AspectRatio``: k of every face, signed (Semenova et al., sections 2.1, 3.1).

        1 for the equilateral triangle, the square and regular plane polygons, and less for all other faces: bent
        ones too. 0 for degenerate faces, negative for concave quadrilaterals and polygons, and for faces turned
        against the surface round them (the sum of their vertices' area-weighted normals); -1 at least.
        Cells that are no faces (verts, lines) have 1 and do not enter the summary.

        The usual measures, of triangles and quadrilaterals, are those of VTK's Verdict, cell arrays too:
        ``MinAngle`` and ``MaxAngle`` in degrees, ``EdgeRatio`` and ``RadiusRatio`` (1 is best, larger is worse),
        ``Skewness`` (of angles: 0 is best, 1 is worst) and ``ScaledJacobian`` (1 is best, 0 and less is
        degenerate or concave). Other cells have NaN.

        Parameters
        ----------
        boundary_labels : str, default 'BoundaryLabels'
            Cell array of the labels on the two sides of each face, normals from the first to the second (or of one label, the other is 0); absent, the surface is one between two sides.
        usual_measures : bool, default True
            Add the smallest and largest angle, edge ratio, radius ratio, skewness and scaled Jacobian as well.
        self_intersections : bool, default False
            Count the faces that cross or touch each other as well.
        inplace : bool, default False
            Change the mesh itself and return it.
        progress_bar : bool, default False
            Show progress.

        Returns
        -------
        pyvista.PolyData
            The result; figures are in its field data.

        Examples
        --------
        >>> import pyvista as pv
        >>> ant = pv.read(pv.examples.antfile)
        >>> k = ant.vtksmooth.surface_quality()["AspectRatio"]
        >>> len(k) == ant.n_cells, bool(k.max() <= 1.0)
        (True, True)
        """

    def surface_comparison(
        self,
        original: pv.PolyData,
        *,
        boundary_labels: str | None = 'BoundaryLabels',
        hausdorff: bool = False,
        inplace: bool = False,
        progress_bar: bool = False,
    ) -> pv.PolyData:
        """Measure a result against its original (Semenova et al., section 4).

        Adds to the result the point arrays ``NormalDeviation`` (angle between vertex normals, degrees),
        ``DihedralChange`` (largest change of the signed dihedral angle of the edges at the point, degrees),
        ``Displacement`` (vector) and ``Deviation`` (distance of the point to the original surface, which
        ``max_deviation_fraction`` bounds), and the cell array ``AspectRatio``, signed against the original's
        directions. Both meshes must have the same points and faces.

        Maximum and mean of the dihedral change are those of the edges that have a dihedral angle: edges of
        exactly two faces that agree on the orientation and have an area in both meshes. Edges of the boundary and
        non-manifold edges do not count. In the same way those of the normal deviation are over the points that
        have a normal in both. Points without such an edge, or without a normal, have 0 in the arrays.

        Parameters
        ----------
        original : pyvista.PolyData
            The mesh from before, with the same points and faces.
        boundary_labels : str, default 'BoundaryLabels'
            Cell array of the labels on the two sides of each face, normals from the first to the second (or of one label, the other is 0); absent, the surface is one between two sides.
        hausdorff : bool, default False
            Bound the distance of the surfaces both ways, at all their points (the Hausdorff distance).
        inplace : bool, default False
            Change the mesh itself and return it.
        progress_bar : bool, default False
            Show progress.

        Returns
        -------
        pyvista.PolyData
            The result; figures are in its field data.

        Examples
        --------
        >>> import pyvista as pv
        >>> ant = pv.read(pv.examples.antfile)
        >>> better = ant.vtksmooth.trapezium_drawing(max_deviation_fraction=0.001)
        >>> difference = better.vtksmooth.surface_comparison(ant)
        >>> bool(difference["Deviation"].max() <= 0.02 * ant.length)
        True
        """

    @overload
    def feature_detection(
        self,
        *,
        method: Literal['robust', 'paper'] = 'robust',
        ridge_angle: float | Literal['auto'] = 'auto',
        corner_angle: float | Literal['auto'] = 'auto',
        added_edges: str | None = 'AddedFeatureEdges',
        removed_edges: str | None = 'RemovedFeatureEdges',
        weight: Literal['area', 'angle'] = 'area',
        denoise: bool = True,
        eigenvalue_ratios: bool = False,
        return_lines: Literal[False] = False,
        inplace: bool = False,
        progress_bar: bool = False,
    ) -> pv.PolyData:
        """Find the vertices on ridges, at corners and at cusps, and the ridge lines (Jiao, section 4).

        Adds to the mesh the point arrays ``FeatureClass`` (uint8: 0 smooth, 1 ridge, 2 corner, 3 cusp) and
        ``RidgeNeighbours`` (int32, two components: the neighbours along the ridge, -1 where there is none). The
        second output, ``lines``, holds the ridge lines as polylines from corner to corner or round closed
        loops, with the cell arrays ``LineClass`` (uint8: 0 ridge, 1 boundary, 2 non-manifold) and ``Length``,
        and the point arrays ``PointIds`` (the points' numbers in the mesh) and ``FeatureClass``. Boundary and
        non-manifold edges are ridges. Edges that the field arrays ``AddedFeatureEdges`` and
        ``RemovedFeatureEdges`` name, as pairs of points, are or are no ridges, whatever their angle: lines
        given by hand. Smoothing filters can hold these features or slide along them.

        Parameters
        ----------
        method : {'robust', 'paper'}, default 'robust'
            robust: filtered normals, thresholds that rise with noise; paper: Jiao's detection as printed.
        ridge_angle : float, default 'auto'
            Dihedral angle above which an edge is a ridge; auto: 20, or more amid noise. Allowed: from 0 to 180 deg, or auto.
        corner_angle : float, default 'auto'
            Turning angle above which a tip is a corner, on boundaries their own; auto: 35, or more amid noise. Allowed: from 0 to 180 deg, or auto.
        added_edges : str, default 'AddedFeatureEdges'
            Field array of pairs of points: edges that are ridges, whatever their angle.
        removed_edges : str, default 'RemovedFeatureEdges'
            Field array of pairs of points: edges that are no ridges, whatever their angle.
        weight : {'area', 'angle'}, default 'area'
            What weighs a face at a vertex: its area, or its angle (better on badly graded meshes).
        denoise : bool, default True
            Filter the faces' normals first, as far as the mesh's own noise asks. Only where method is robust.
        eigenvalue_ratios : bool, default False
            Add EigenvalueRatios: second and third over first eigenvalue of each metric tensor, unfiltered.
        return_lines : bool, default False
            Return a tuple of the mesh and the lines.
        inplace : bool, default False
            Change the mesh itself and return it.
        progress_bar : bool, default False
            Show progress.

        Returns
        -------
        pyvista.PolyData
            The result; figures are in its field data. With ``return_lines`` a tuple of it and the lines.

        Guarantees
        ----------
        The result does not depend on the number of threads; turning, moving and scaling the mesh change it
        only where an angle equals a threshold to rounding. On clean polyhedra with ridges above the ridge
        angle every vertex gets its class, every edge is found, and none is found that is not there.

        Not guaranteed: that noise is told from features as small as the noise.

        Examples
        --------
        >>> import pyvista as pv
        >>> cylinder = pv.Cylinder(resolution=36).triangulate().clean()
        >>> found, lines = cylinder.vtksmooth.feature_detection(return_lines=True)
        >>> int((found["FeatureClass"] == 1).sum()), lines.n_lines
        (72, 2)
        """

    @overload
    def feature_detection(
        self,
        *,
        method: Literal['robust', 'paper'] = 'robust',
        ridge_angle: float | Literal['auto'] = 'auto',
        corner_angle: float | Literal['auto'] = 'auto',
        added_edges: str | None = 'AddedFeatureEdges',
        removed_edges: str | None = 'RemovedFeatureEdges',
        weight: Literal['area', 'angle'] = 'area',
        denoise: bool = True,
        eigenvalue_ratios: bool = False,
        return_lines: Literal[True],
        inplace: bool = False,
        progress_bar: bool = False,
    ) -> tuple[pv.PolyData, pv.PolyData]:
        """Find the vertices on ridges, at corners and at cusps, and the ridge lines (Jiao, section 4).

        Adds to the mesh the point arrays ``FeatureClass`` (uint8: 0 smooth, 1 ridge, 2 corner, 3 cusp) and
        ``RidgeNeighbours`` (int32, two components: the neighbours along the ridge, -1 where there is none). The
        second output, ``lines``, holds the ridge lines as polylines from corner to corner or round closed
        loops, with the cell arrays ``LineClass`` (uint8: 0 ridge, 1 boundary, 2 non-manifold) and ``Length``,
        and the point arrays ``PointIds`` (the points' numbers in the mesh) and ``FeatureClass``. Boundary and
        non-manifold edges are ridges. Edges that the field arrays ``AddedFeatureEdges`` and
        ``RemovedFeatureEdges`` name, as pairs of points, are or are no ridges, whatever their angle: lines
        given by hand. Smoothing filters can hold these features or slide along them.

        Parameters
        ----------
        method : {'robust', 'paper'}, default 'robust'
            robust: filtered normals, thresholds that rise with noise; paper: Jiao's detection as printed.
        ridge_angle : float, default 'auto'
            Dihedral angle above which an edge is a ridge; auto: 20, or more amid noise. Allowed: from 0 to 180 deg, or auto.
        corner_angle : float, default 'auto'
            Turning angle above which a tip is a corner, on boundaries their own; auto: 35, or more amid noise. Allowed: from 0 to 180 deg, or auto.
        added_edges : str, default 'AddedFeatureEdges'
            Field array of pairs of points: edges that are ridges, whatever their angle.
        removed_edges : str, default 'RemovedFeatureEdges'
            Field array of pairs of points: edges that are no ridges, whatever their angle.
        weight : {'area', 'angle'}, default 'area'
            What weighs a face at a vertex: its area, or its angle (better on badly graded meshes).
        denoise : bool, default True
            Filter the faces' normals first, as far as the mesh's own noise asks. Only where method is robust.
        eigenvalue_ratios : bool, default False
            Add EigenvalueRatios: second and third over first eigenvalue of each metric tensor, unfiltered.
        return_lines : bool, default False
            Return a tuple of the mesh and the lines.
        inplace : bool, default False
            Change the mesh itself and return it.
        progress_bar : bool, default False
            Show progress.

        Returns
        -------
        pyvista.PolyData
            The result; figures are in its field data. With ``return_lines`` a tuple of it and the lines.

        Guarantees
        ----------
        The result does not depend on the number of threads; turning, moving and scaling the mesh change it
        only where an angle equals a threshold to rounding. On clean polyhedra with ridges above the ridge
        angle every vertex gets its class, every edge is found, and none is found that is not there.

        Not guaranteed: that noise is told from features as small as the noise.

        Examples
        --------
        >>> import pyvista as pv
        >>> cylinder = pv.Cylinder(resolution=36).triangulate().clean()
        >>> found, lines = cylinder.vtksmooth.feature_detection(return_lines=True)
        >>> int((found["FeatureClass"] == 1).sum()), lines.n_lines
        (72, 2)
        """

    def region_marking(
        self,
        *,
        clear: Literal['nothing', 'region', 'lines', 'all'] = 'nothing',
        free: str | None = None,
        fix: str | None = None,
        invert: bool = False,
        grow: int = 0,
        shrink: int = 0,
        blend_rings: int | None = None,
        blend_distance: float | None = None,
        add_lines: str | None = None,
        remove_lines: str | None = None,
        inplace: bool = False,
        progress_bar: bool = False,
    ) -> pv.PolyData:
        """Mark by hand what smoothing may do: points that stay, soft edges round them, feature lines.

        The point array ``Fixed`` (uint8) says which points stay; ``BlendWeight`` (float64), which part of its
        steps a point takes; the field arrays ``AddedFeatureEdges`` and ``RemovedFeatureEdges`` (pairs of points)
        say which edges are features, and which are none, whatever a detection finds. All smoothing filters go by
        these arrays. What is asked for is done in the order of the parameters, to the marks that are there.
        Points are numbers and ranges, ``0-14,20``; lines are chains of points along edges, ``3-17-19,40-41``.

        Parameters
        ----------
        clear : {'nothing', 'region', 'lines', 'all'}, default 'nothing'
            What to forget first: the region (fixed points and their weights), the lines, or all.
        free : str, default None
            Points to free: numbers and ranges, as 0-14,20, or all.
        fix : str, default None
            Points to fix: numbers and ranges, as 0-14,20, or all.
        invert : bool, default False
            Free what is fixed, and fix what is free.
        grow : int, default 0
            Fix this many rings of points round the fixed ones. Allowed: 0 or more.
        shrink : int, default 0
            Free this many rings of fixed points, from the free ones on. Allowed: 0 or more.
        blend_rings : int, default None
            Rings of points round the fixed ones over which weights rise to 1; 0: no weights. Allowed: 0 or more, or None (off).
        blend_distance : float, default None
            Way along edges from the fixed points over which weights rise evenly to 1. Allowed: 0 model units or more, or None (off).
        add_lines : str, default None
            Lines along edges that are features, as 3-17-19,40-41.
        remove_lines : str, default None
            Lines along edges that are no features, as 3-17-19,40-41.
        inplace : bool, default False
            Change the mesh itself and return it.
        progress_bar : bool, default False
            Show progress.

        Returns
        -------
        pyvista.PolyData
            The result; figures are in its field data.

        Guarantees
        ----------
        Points, cells and all other data stay. The weight of every fixed point is 0.

        Examples
        --------
        >>> import pyvista as pv
        >>> plane = pv.Plane(i_resolution=4, j_resolution=4)
        >>> marked = plane.vtksmooth.region_marking(fix="0-4", grow=1, blend_rings=1)
        >>> int(marked["Fixed"].sum()), int((marked["BlendWeight"] < 1.0).sum())
        (10, 15)
        """

    def trapezium_drawing(
        self,
        *,
        installation: pv.PolyData | None = None,
        source: pv.PolyData | None = None,
        iterations: int = 5,
        fixed: str | Sequence[int] | npt.NDArray[Any] | None = 'Fixed',
        blend: str | None = 'BlendWeight',
        max_displacement: str | None = 'SmoothingConstraints',
        boundary_labels: str | None = 'BoundaryLabels',
        boundary: Literal['fixed', 'sliding', 'smoothed'] = 'fixed',
        boundary_corner_angle: float = 30.0,
        features: Literal['ignore', 'hold', 'slide'] = 'ignore',
        ridge_angle: float | Literal['auto'] = 'auto',
        corner_angle: float | Literal['auto'] = 'auto',
        added_edges: str | None = 'AddedFeatureEdges',
        removed_edges: str | None = 'RemovedFeatureEdges',
        crease_angle: float | None = None,
        gate: Literal['none', 'angle', 'aspect', 'floor'] = 'aspect',
        gate_floor: float = 0.6,
        max_deviation_fraction: float | None = None,
        null_space: bool = False,
        tensor_weight: Literal['area', 'angle'] = 'area',
        corrections: int = 0,
        preserve_volume: bool = False,
        containment: Literal['none', 'vertices', 'exact'] = 'exact',
        tolerance_fraction: float = 1e-06,
        directions: Literal['all', 'x', 'y', 'z', 'xy', 'xz', 'yz', 'about-x', 'about-y', 'about-z'] = 'all',
        rotation_center: str = '0,0,0',
        symmetry_planes: str | None = None,
        curvature_radius: float | Literal['auto'] | None = None,
        curvature_ramp: float = 0.0,
        self_intersection: Literal['ignore', 'none-new'] = 'ignore',
        stop_normal_deviation: float | None = None,
        stop_dihedral_change: float | None = None,
        stop_deviation_fraction: float | None = None,
        stop_volume_percent: float | None = None,
        stop_gain: float | None = None,
        stop_statistic: Literal['max', 'mean'] = 'max',
        output_points_precision: Literal['default', 'single', 'double', 0, 1, 2] = 'default',
        inplace: bool = False,
        progress_bar: bool = False,
    ) -> pv.PolyData:
        """Improve the worst elements round every vertex, staying close to the surface that the mesh means.

        Each neighbour of a vertex, with the neighbour across, asks for the point on a parallel to the line
        between the two where a triangle with them is isosceles; the vertex goes to the mean of these points
        if that improves the worst element round it. Source: I. B. Semenova, V. V. Savchenko, I. Hagiwara,
        "Improvement of Triangular and Quadrilateral Surface Meshes", sections 2 and 3.

        Parameters
        ----------
        installation : pyvista.PolyData, optional
            The installation space, its normals outwards.
        source : pyvista.PolyData, optional
            A surface that points are put and kept on, such as a CAD tessellation or a scan.
        iterations : int, default 5
            Most iterations to do. Allowed: 0 or more.
        fixed : str, default 'Fixed'
            Point array; points with a nonzero value stay fixed. If it is missing, no point is. In Python also a mask or numbers of points; as text points:0-14,20.
        blend : str, default 'BlendWeight'
            Point array of the part of each step that a point takes, 0 to 1; absent, all of it.
        max_displacement : str, default 'SmoothingConstraints'
            Point array of how far each point may go from its place, in model units; absent, any distance.
        boundary_labels : str, default 'BoundaryLabels'
            Cell array of the labels on the two sides of each face, normals from the first to the second (or of one label, the other is 0); absent, the surface is one between two sides.
        boundary : {'fixed', 'sliding', 'smoothed'}, default 'fixed'
            Whether boundary points stay, slide along it, or smooth it as a curve that keeps its area.
        boundary_corner_angle : float, default 30.0
            Boundary points that may move stay where the boundary turns by more than this. Allowed: from 0 to 180 deg. Only where boundary is sliding or smoothed.
        features : {'ignore', 'hold', 'slide'}, default 'ignore'
            Whether points on ridges move like all others, are held, or slide along the ridge; corners stay.
        ridge_angle : float, default 'auto'
            Dihedral angle from which an edge is a ridge, where no arrays say what the features are. Allowed: from 0 to 180 deg, or auto. Only where features is hold or slide or null_space is on.
        corner_angle : float, default 'auto'
            Turning angle from which a ridge or a cone has a corner, where no arrays say it. Allowed: from 0 to 180 deg, or auto. Only where features is hold or slide or null_space is on.
        added_edges : str, default 'AddedFeatureEdges'
            Field array of pairs of points: edges that are ridges, whatever their angle. Only where features is hold or slide or null_space is on.
        removed_edges : str, default 'RemovedFeatureEdges'
            Field array of pairs of points: edges that are no ridges, whatever their angle. Only where features is hold or slide or null_space is on.
        crease_angle : float, default None
            Edges with a dihedral angle above this stay above it. Allowed: from 0 to 180 deg, or None (off).
        gate : {'none', 'angle', 'aspect', 'floor'}, default 'aspect'
            What must improve round a vertex for it to move: nothing, the smallest angle, the smallest aspect ratio, or (floor) that below gate_floor and the mean above it.
        gate_floor : float, default 0.6
            Of the gate with a floor: aspect ratio that is good enough. Allowed: from 0 to 1. Only where gate is floor.
        max_deviation_fraction : float, default None
            Keep every point within this distance of the original surface. Allowed: 0 diagonals or more, or None (off).
        null_space : bool, default False
            Keep of each step what goes across the surface or along its ridges; corners do not slide.
        tensor_weight : {'area', 'angle'}, default 'area'
            What weighs a face in a vertex' tensor: its area, or its angle (better on badly graded meshes). Only where null_space is on.
        corrections : int, default 0
            Corrections in each pass of the volume that is swept round every point; 0 is none. Allowed: from 0 to 100.
        preserve_volume : bool, default False
            End each pass with an equal step of all points that closes the volume of every body, or of every label, exactly.
        containment : {'none', 'vertices', 'exact'}, default 'exact'
            What must stay inside the installation space: nothing, vertices, or (exact) triangles too. Only where installation is set.
        tolerance_fraction : float, default 1e-06
            How far outside counts as inside; never less than what the points' precision makes of it. Allowed: 0 diagonals or more. Only where installation is set.
        directions : {'all', 'x', 'y', 'z', 'xy', 'xz', 'yz', 'about-x', 'about-y', 'about-z'}, default 'all'
            Coordinates that may change (xy: in plan, where no face turns over), or an axis to turn about.
        rotation_center : str, default '0,0,0'
            A point on the axis about which points turn, in model units: its three coordinates. Only where directions is about-x, about-y or about-z.
        symmetry_planes : str, default None
            Planes on which points stay that are on them at the start, such as x=0,z=2.5; model units.
        curvature_radius : float, default None
            Leave points where the surface is as flat as a sphere of this radius; auto: by the noise. Allowed: 0 model units or more, or auto, or None (off).
        curvature_ramp : float, default 0.0
            Steps grow from nothing to full length between 1 and 1 + this times the bound. Allowed: 0 or more. Only where curvature_radius is set.
        self_intersection : {'ignore', 'none-new'}, default 'ignore'
            Whether faces may come to cross or touch others that they did not at the start.
        stop_normal_deviation : float, default None
            Stop before vertex normals turn by more than this. Allowed: from 0 to 180 deg, or None (off).
        stop_dihedral_change : float, default None
            Stop before dihedral angles change by more than this. Allowed: from 0 to 360 deg, or None (off).
        stop_deviation_fraction : float, default None
            Stop before points are farther from the original surface than this. Allowed: 0 diagonals or more, or None (off).
        stop_volume_percent : float, default None
            Stop before the enclosed volume changes by more than this. Allowed: 0 percent or more, or None (off).
        stop_gain : float, default None
            Stop when an iteration raises the mean aspect ratio by less than this. Allowed: a number, or None (off).
        stop_statistic : {'max', 'mean'}, default 'max'
            What of normals, dihedral angles and distances the stop rules look at. Only where stop_normal_deviation is set or stop_dihedral_change is set or stop_deviation_fraction is set.
        output_points_precision : {'default', 'single', 'double'}, default 'default'
            Precision of the output's points; default keeps the input's.
        inplace : bool, default False
            Change the mesh itself and return it.
        progress_bar : bool, default False
            Show progress.

        Returns
        -------
        pyvista.PolyData
            The result; figures are in its field data.

        Guarantees
        ----------
        With ``gate="aspect"``, before the output's points are rounded to single precision: no iteration
        lowers the smallest k of the mesh or makes more faces inverted, both against the input's directions.
        Fixed points keep their bits. Topology is the input's. The result does not depend on the number of
        threads.

        Not guaranteed: the *mean* of k; nor k of a ring whose own vertex did not move.

        Examples
        --------
        >>> import pyvista as pv
        >>> ant = pv.read(pv.examples.antfile)
        >>> better = ant.vtksmooth.trapezium_drawing(iterations=5)
        >>> before = ant.vtksmooth.surface_quality()["AspectRatio"].min()
        >>> after = better.vtksmooth.surface_comparison(ant)["AspectRatio"].min()
        >>> bool(after >= before)
        True
        """

    def laplacian_smoothing(
        self,
        *,
        installation: pv.PolyData | None = None,
        source: pv.PolyData | None = None,
        iterations: int = 10,
        fixed: str | Sequence[int] | npt.NDArray[Any] | None = 'Fixed',
        blend: str | None = 'BlendWeight',
        max_displacement: str | None = 'SmoothingConstraints',
        boundary_labels: str | None = 'BoundaryLabels',
        boundary: Literal['fixed', 'sliding', 'smoothed'] = 'fixed',
        boundary_corner_angle: float = 30.0,
        features: Literal['ignore', 'hold', 'slide'] = 'ignore',
        ridge_angle: float | Literal['auto'] = 'auto',
        corner_angle: float | Literal['auto'] = 'auto',
        added_edges: str | None = 'AddedFeatureEdges',
        removed_edges: str | None = 'RemovedFeatureEdges',
        crease_angle: float | None = None,
        gate: Literal['none', 'angle', 'aspect', 'floor'] = 'none',
        gate_floor: float = 0.6,
        max_deviation_fraction: float | None = None,
        null_space: bool = False,
        tensor_weight: Literal['area', 'angle'] = 'area',
        corrections: int = 0,
        preserve_volume: bool = False,
        containment: Literal['none', 'vertices', 'exact'] = 'exact',
        tolerance_fraction: float = 1e-06,
        directions: Literal['all', 'x', 'y', 'z', 'xy', 'xz', 'yz', 'about-x', 'about-y', 'about-z'] = 'all',
        rotation_center: str = '0,0,0',
        symmetry_planes: str | None = None,
        curvature_radius: float | Literal['auto'] | None = None,
        curvature_ramp: float = 0.0,
        self_intersection: Literal['ignore', 'none-new'] = 'ignore',
        stop_normal_deviation: float | None = None,
        stop_dihedral_change: float | None = None,
        stop_deviation_fraction: float | None = None,
        stop_volume_percent: float | None = None,
        stop_gain: float | None = None,
        stop_statistic: Literal['max', 'mean'] = 'max',
        output_points_precision: Literal['default', 'single', 'double', 0, 1, 2] = 'default',
        scheme: Literal['umbrella', 'scale-dependent', 'cotangent', 'thin-plate', 'taubin', 'area-weighted', 'angle-weighted', 'odt', 'low-pass', 'pairwise'] = 'umbrella',
        weights: Literal['umbrella', 'scale-dependent', 'cotangent'] = 'umbrella',
        flow: str | None = None,
        flow_weight: float = 3.0,
        relaxation_factor: float = 0.5,
        implicit_step: float | None = None,
        pass_band: float = 0.1,
        wavelength: float | Literal['auto'] = 'auto',
        tangent_plane: bool = False,
        back_to_surface: bool = False,
        inplace: bool = False,
        progress_bar: bool = False,
    ) -> pv.PolyData:
        """Move every vertex towards a weighted mean of its one-ring or of the faces round it.

        Umbrella: equal weights. Scale-dependent: ``1/|e|`` (Fujiwara). Cotangent: Desbrun et al., negative
        weights clamped. Thin plate: the umbrella operator twice (Kobbelt et al.). Taubin: ``lambda|mu``, which
        hardly shrinks or grows. Area-weighted and angle-weighted: the centroids of the faces round the vertex;
        odt: their circumcentres, weighted by area (optimal Delaunay triangulation). Low-pass: where a filter of
        the whole surface puts each vertex, which removes waves shorter than `wavelength` as far as they are
        noise; it is there after two or three iterations. Pairwise: both ends of an edge at once, so that the
        volume stays (Liu et al.), for triangles. ``gate="angle"`` makes it the smart Laplacian. With a flow,
        weights of neighbours are ``w_ij (1 + flow_weight cos^2 theta)``, theta between the flow and the edge in
        the tangent plane. With an implicit step each iteration solves one sparse system, which is as good as
        many small steps: for umbrella, scale-dependent, cotangent and thin-plate, with and without a flow, and
        with every constraint that these have.

        Parameters
        ----------
        installation : pyvista.PolyData, optional
            The installation space, its normals outwards.
        source : pyvista.PolyData, optional
            A surface that points are put and kept on, such as a CAD tessellation or a scan.
        iterations : int, default 10
            Most iterations to do. Allowed: 0 or more.
        fixed : str, default 'Fixed'
            Point array; points with a nonzero value stay fixed. If it is missing, no point is. In Python also a mask or numbers of points; as text points:0-14,20.
        blend : str, default 'BlendWeight'
            Point array of the part of each step that a point takes, 0 to 1; absent, all of it.
        max_displacement : str, default 'SmoothingConstraints'
            Point array of how far each point may go from its place, in model units; absent, any distance.
        boundary_labels : str, default 'BoundaryLabels'
            Cell array of the labels on the two sides of each face, normals from the first to the second (or of one label, the other is 0); absent, the surface is one between two sides.
        boundary : {'fixed', 'sliding', 'smoothed'}, default 'fixed'
            Whether boundary points stay, slide along it, or smooth it as a curve that keeps its area.
        boundary_corner_angle : float, default 30.0
            Boundary points that may move stay where the boundary turns by more than this. Allowed: from 0 to 180 deg. Only where boundary is sliding or smoothed.
        features : {'ignore', 'hold', 'slide'}, default 'ignore'
            Whether points on ridges move like all others, are held, or slide along the ridge; corners stay.
        ridge_angle : float, default 'auto'
            Dihedral angle from which an edge is a ridge, where no arrays say what the features are. Allowed: from 0 to 180 deg, or auto. Only where features is hold or slide or null_space is on.
        corner_angle : float, default 'auto'
            Turning angle from which a ridge or a cone has a corner, where no arrays say it. Allowed: from 0 to 180 deg, or auto. Only where features is hold or slide or null_space is on.
        added_edges : str, default 'AddedFeatureEdges'
            Field array of pairs of points: edges that are ridges, whatever their angle. Only where features is hold or slide or null_space is on.
        removed_edges : str, default 'RemovedFeatureEdges'
            Field array of pairs of points: edges that are no ridges, whatever their angle. Only where features is hold or slide or null_space is on.
        crease_angle : float, default None
            Edges with a dihedral angle above this stay above it. Allowed: from 0 to 180 deg, or None (off).
        gate : {'none', 'angle', 'aspect', 'floor'}, default 'none'
            What must improve round a vertex for it to move: nothing, the smallest angle, the smallest aspect ratio, or (floor) that below gate_floor and the mean above it.
        gate_floor : float, default 0.6
            Of the gate with a floor: aspect ratio that is good enough. Allowed: from 0 to 1. Only where gate is floor.
        max_deviation_fraction : float, default None
            Keep every point within this distance of the original surface. Allowed: 0 diagonals or more, or None (off).
        null_space : bool, default False
            Keep of each step what goes across the surface or along its ridges; corners do not slide.
        tensor_weight : {'area', 'angle'}, default 'area'
            What weighs a face in a vertex' tensor: its area, or its angle (better on badly graded meshes). Only where null_space is on.
        corrections : int, default 0
            Corrections in each pass of the volume that is swept round every point; 0 is none. Allowed: from 0 to 100.
        preserve_volume : bool, default False
            End each pass with an equal step of all points that closes the volume of every body, or of every label, exactly.
        containment : {'none', 'vertices', 'exact'}, default 'exact'
            What must stay inside the installation space: nothing, vertices, or (exact) triangles too. Only where installation is set.
        tolerance_fraction : float, default 1e-06
            How far outside counts as inside; never less than what the points' precision makes of it. Allowed: 0 diagonals or more. Only where installation is set.
        directions : {'all', 'x', 'y', 'z', 'xy', 'xz', 'yz', 'about-x', 'about-y', 'about-z'}, default 'all'
            Coordinates that may change (xy: in plan, where no face turns over), or an axis to turn about.
        rotation_center : str, default '0,0,0'
            A point on the axis about which points turn, in model units: its three coordinates. Only where directions is about-x, about-y or about-z.
        symmetry_planes : str, default None
            Planes on which points stay that are on them at the start, such as x=0,z=2.5; model units.
        curvature_radius : float, default None
            Leave points where the surface is as flat as a sphere of this radius; auto: by the noise. Allowed: 0 model units or more, or auto, or None (off).
        curvature_ramp : float, default 0.0
            Steps grow from nothing to full length between 1 and 1 + this times the bound. Allowed: 0 or more. Only where curvature_radius is set.
        self_intersection : {'ignore', 'none-new'}, default 'ignore'
            Whether faces may come to cross or touch others that they did not at the start.
        stop_normal_deviation : float, default None
            Stop before vertex normals turn by more than this. Allowed: from 0 to 180 deg, or None (off).
        stop_dihedral_change : float, default None
            Stop before dihedral angles change by more than this. Allowed: from 0 to 360 deg, or None (off).
        stop_deviation_fraction : float, default None
            Stop before points are farther from the original surface than this. Allowed: 0 diagonals or more, or None (off).
        stop_volume_percent : float, default None
            Stop before the enclosed volume changes by more than this. Allowed: 0 percent or more, or None (off).
        stop_gain : float, default None
            Stop when an iteration raises the mean aspect ratio by less than this. Allowed: a number, or None (off).
        stop_statistic : {'max', 'mean'}, default 'max'
            What of normals, dihedral angles and distances the stop rules look at. Only where stop_normal_deviation is set or stop_dihedral_change is set or stop_deviation_fraction is set.
        output_points_precision : {'default', 'single', 'double'}, default 'default'
            Precision of the output's points; default keeps the input's.
        scheme : {'umbrella', 'scale-dependent', 'cotangent', 'thin-plate', 'taubin', 'area-weighted', 'angle-weighted', 'odt', 'low-pass', 'pairwise'}, default 'umbrella'
            Which weights.
        weights : {'umbrella', 'scale-dependent', 'cotangent'}, default 'umbrella'
            Weights of the schemes thin-plate, taubin and pairwise. Only where scheme is thin-plate, taubin or pairwise.
        flow : str, default None
            Array of vectors along which to smooth more than across. Only where scheme is umbrella, scale-dependent, cotangent, thin-plate, taubin or pairwise.
        flow_weight : float, default 3.0
            How much more neighbours along the flow weigh; 0 is as much as all others. Allowed: 0 or more. Only where flow is set.
        relaxation_factor : float, default 0.5
            Part of the proposed step that is taken (thin-plate diverges above 0.55). Allowed: from 0 to 1. Only where implicit_step is off and scheme is umbrella, scale-dependent, cotangent, thin-plate, taubin, area-weighted, angle-weighted, odt or pairwise.
        implicit_step : float, default None
            Solve for the end of a step of this size, which is stable for any; off: explicit steps of relaxation_factor. Allowed: from 0 to 10000, or None (off). Only where scheme is umbrella, scale-dependent, cotangent or thin-plate.
        pass_band : float, default 0.1
            Taubin's k_PB = 1/lambda + 1/mu: frequencies below it are kept, so lower smooths more. Allowed: from 0.001 to 0.9. Only where scheme is taubin.
        wavelength : float, default 'auto'
            Waves of this length lose half of their height, shorter ones more; auto: 15 voxels, or 13 edges. Allowed: 0 model units or more, or auto. Only where scheme is low-pass.
        tangent_plane : bool, default False
            Move vertices only across the surface, not off it.
        back_to_surface : bool, default False
            Put every vertex back on the original surface.
        inplace : bool, default False
            Change the mesh itself and return it.
        progress_bar : bool, default False
            Show progress.

        Returns
        -------
        pyvista.PolyData
            The result; figures are in its field data.

        Guarantees
        ----------
        Fixed points and, unless it slides, the boundary keep their bits. The pairwise scheme keeps the volume (of
        open meshes: the volume swept is 0) to 1e-14 of it in each iteration, with all gates and bounds: it moves
        the ends of an edge only where these accept both. With `preserve_volume` or `corrections` it inverts no
        face. Constraints that turn the step of one vertex, or put it on a surface, are refused with it: tangent
        plane, back to surface, null space, boundaries that are not fixed, features that slide. The flow's size
        and sign do not matter. Implicit steps s are solved to 1e-14 (1 + 2 s) of the longest explicit step of
        that size; however large, they leave no point outside the box of the input's points (thin-plate may).
        Taubin's filter, as long as all vertices move at once, amplifies no frequency above `pass_band`, and none
        below it by more than 1.5 %: before it would, the run stops (``stop_reason`` "pass-band"). With
        ``self_intersection="none-new"`` no faces cross or touch that did not, of the points as they are written,
        and every other promise is kept. With ``gate="aspect"`` what TrapeziumDrawing guarantees. Plain Laplacian
        schemes, explicit or implicit, shrink closed surfaces unless `preserve_volume` is set; none keeps elements
        from inverting without a gate.

        Examples
        --------
        >>> import pyvista as pv
        >>> sphere = pv.Sphere()
        >>> sphere.vtksmooth.laplacian_smoothing(iterations=20).volume < 0.8 * sphere.volume
        True
        >>> taubin = sphere.vtksmooth.laplacian_smoothing(iterations=20, scheme="taubin")
        >>> abs(taubin.volume / sphere.volume - 1.0) < 0.02
        True
        """

    def feature_preserving_denoising(
        self,
        *,
        installation: pv.PolyData | None = None,
        source: pv.PolyData | None = None,
        iterations: int = 20,
        fixed: str | Sequence[int] | npt.NDArray[Any] | None = 'Fixed',
        blend: str | None = 'BlendWeight',
        max_displacement: str | None = 'SmoothingConstraints',
        boundary_labels: str | None = 'BoundaryLabels',
        boundary: Literal['fixed', 'sliding', 'smoothed'] = 'fixed',
        boundary_corner_angle: float = 30.0,
        features: Literal['ignore', 'hold', 'slide'] = 'ignore',
        ridge_angle: float | Literal['auto'] = 'auto',
        corner_angle: float | Literal['auto'] = 'auto',
        added_edges: str | None = 'AddedFeatureEdges',
        removed_edges: str | None = 'RemovedFeatureEdges',
        crease_angle: float | None = None,
        gate: Literal['none', 'angle', 'aspect', 'floor'] = 'none',
        gate_floor: float = 0.6,
        max_deviation_fraction: float | None = None,
        null_space: bool = False,
        tensor_weight: Literal['area', 'angle'] = 'area',
        corrections: int = 0,
        preserve_volume: bool = True,
        containment: Literal['none', 'vertices', 'exact'] = 'exact',
        tolerance_fraction: float = 1e-06,
        directions: Literal['all', 'x', 'y', 'z', 'xy', 'xz', 'yz', 'about-x', 'about-y', 'about-z'] = 'all',
        rotation_center: str = '0,0,0',
        symmetry_planes: str | None = None,
        curvature_radius: float | Literal['auto'] | None = None,
        curvature_ramp: float = 0.0,
        self_intersection: Literal['ignore', 'none-new'] = 'ignore',
        stop_normal_deviation: float | None = None,
        stop_dihedral_change: float | None = None,
        stop_deviation_fraction: float | None = None,
        stop_volume_percent: float | None = None,
        stop_gain: float | None = None,
        stop_statistic: Literal['max', 'mean'] = 'max',
        output_points_precision: Literal['default', 'single', 'double', 0, 1, 2] = 'default',
        strength: Literal['gentle', 'normal', 'strong'] = 'normal',
        inplace: bool = False,
        progress_bar: bool = False,
    ) -> pv.PolyData:
        """Remove the noise of a scan or of a measured surface, and keep its edges, its shape and its volume.

        The filter measures the noise level, filters the face normals under a guide that tells creases from
        noise, and lets the points follow. It watches what it removes: where neighbouring points have moved the
        same way, that is shape, and comes back; when what was removed is white noise, the run ends by itself.
        Sources: W. Zhang et al., "Guided Mesh Normal Filtering" (2015), doi:10.1111/cgf.12742; X. Sun et al.,
        "Fast and Effective Feature-Preserving Mesh Denoising" (2007), doi:10.1109/TVCG.2007.1065.

        Parameters
        ----------
        installation : pyvista.PolyData, optional
            The installation space, its normals outwards.
        source : pyvista.PolyData, optional
            A surface that points are put and kept on, such as a CAD tessellation or a scan.
        iterations : int, default 20
            Most iterations to do; 3 to 8 are needed. Allowed: 0 or more.
        fixed : str, default 'Fixed'
            Point array; points with a nonzero value stay fixed. If it is missing, no point is. In Python also a mask or numbers of points; as text points:0-14,20.
        blend : str, default 'BlendWeight'
            Point array of the part of each step that a point takes, 0 to 1; absent, all of it.
        max_displacement : str, default 'SmoothingConstraints'
            Point array of how far each point may go from its place, in model units; absent, any distance.
        boundary_labels : str, default 'BoundaryLabels'
            Cell array of the labels on the two sides of each face, normals from the first to the second (or of one label, the other is 0); absent, the surface is one between two sides.
        boundary : {'fixed', 'sliding', 'smoothed'}, default 'fixed'
            Whether boundary points stay, slide along it, or smooth it as a curve that keeps its area.
        boundary_corner_angle : float, default 30.0
            Boundary points that may move stay where the boundary turns by more than this. Allowed: from 0 to 180 deg. Only where boundary is sliding or smoothed.
        features : {'ignore', 'hold', 'slide'}, default 'ignore'
            Whether points on ridges move like all others, are held, or slide along the ridge; corners stay.
        ridge_angle : float, default 'auto'
            Dihedral angle from which an edge is a ridge, where no arrays say what the features are. Allowed: from 0 to 180 deg, or auto. Only where features is hold or slide or null_space is on.
        corner_angle : float, default 'auto'
            Turning angle from which a ridge or a cone has a corner, where no arrays say it. Allowed: from 0 to 180 deg, or auto. Only where features is hold or slide or null_space is on.
        added_edges : str, default 'AddedFeatureEdges'
            Field array of pairs of points: edges that are ridges, whatever their angle. Only where features is hold or slide or null_space is on.
        removed_edges : str, default 'RemovedFeatureEdges'
            Field array of pairs of points: edges that are no ridges, whatever their angle. Only where features is hold or slide or null_space is on.
        crease_angle : float, default None
            Edges with a dihedral angle above this stay above it. Allowed: from 0 to 180 deg, or None (off).
        gate : {'none', 'angle', 'aspect', 'floor'}, default 'none'
            What must improve round a vertex for it to move: nothing, the smallest angle, the smallest aspect ratio, or (floor) that below gate_floor and the mean above it.
        gate_floor : float, default 0.6
            Of the gate with a floor: aspect ratio that is good enough. Allowed: from 0 to 1. Only where gate is floor.
        max_deviation_fraction : float, default None
            Keep every point within this distance of the original surface. Allowed: 0 diagonals or more, or None (off).
        null_space : bool, default False
            Keep of each step what goes across the surface or along its ridges; corners do not slide.
        tensor_weight : {'area', 'angle'}, default 'area'
            What weighs a face in a vertex' tensor: its area, or its angle (better on badly graded meshes). Only where null_space is on.
        corrections : int, default 0
            Corrections in each pass of the volume that is swept round every point; 0 is none. Allowed: from 0 to 100.
        preserve_volume : bool, default True
            End each pass with an equal step of all points that closes the volume of every body, or of every label, exactly.
        containment : {'none', 'vertices', 'exact'}, default 'exact'
            What must stay inside the installation space: nothing, vertices, or (exact) triangles too. Only where installation is set.
        tolerance_fraction : float, default 1e-06
            How far outside counts as inside; never less than what the points' precision makes of it. Allowed: 0 diagonals or more. Only where installation is set.
        directions : {'all', 'x', 'y', 'z', 'xy', 'xz', 'yz', 'about-x', 'about-y', 'about-z'}, default 'all'
            Coordinates that may change (xy: in plan, where no face turns over), or an axis to turn about.
        rotation_center : str, default '0,0,0'
            A point on the axis about which points turn, in model units: its three coordinates. Only where directions is about-x, about-y or about-z.
        symmetry_planes : str, default None
            Planes on which points stay that are on them at the start, such as x=0,z=2.5; model units.
        curvature_radius : float, default None
            Leave points where the surface is as flat as a sphere of this radius; auto: by the noise. Allowed: 0 model units or more, or auto, or None (off).
        curvature_ramp : float, default 0.0
            Steps grow from nothing to full length between 1 and 1 + this times the bound. Allowed: 0 or more. Only where curvature_radius is set.
        self_intersection : {'ignore', 'none-new'}, default 'ignore'
            Whether faces may come to cross or touch others that they did not at the start.
        stop_normal_deviation : float, default None
            Stop before vertex normals turn by more than this. Allowed: from 0 to 180 deg, or None (off).
        stop_dihedral_change : float, default None
            Stop before dihedral angles change by more than this. Allowed: from 0 to 360 deg, or None (off).
        stop_deviation_fraction : float, default None
            Stop before points are farther from the original surface than this. Allowed: 0 diagonals or more, or None (off).
        stop_volume_percent : float, default None
            Stop before the enclosed volume changes by more than this. Allowed: 0 percent or more, or None (off).
        stop_gain : float, default None
            Stop when an iteration raises the mean aspect ratio by less than this. Allowed: a number, or None (off).
        stop_statistic : {'max', 'mean'}, default 'max'
            What of normals, dihedral angles and distances the stop rules look at. Only where stop_normal_deviation is set or stop_dihedral_change is set or stop_deviation_fraction is set.
        output_points_precision : {'default', 'single', 'double'}, default 'default'
            Precision of the output's points; default keeps the input's.
        strength : {'gentle', 'normal', 'strong'}, default 'normal'
            How much of what is removed may be shape: the weaker, the more noise stays.
        inplace : bool, default False
            Change the mesh itself and return it.
        progress_bar : bool, default False
            Show progress.

        Returns
        -------
        pyvista.PolyData
            The result; figures are in its field data.

        Guarantees
        ----------
        No face that is not inverted becomes inverted, against the input's directions. With `preserve_volume`:
        the volume of every closed body is that of the input to rounding, and what open surfaces sweep is 0 to
        rounding. Fixed points and, unless it moves, the boundary keep their bits. All before the output's points
        are rounded to single precision. Topology is the input's. The result does not depend on the number of
        threads. ``report.noise_level`` is the noise level that was found.

        Not guaranteed: that inverted faces are mended (most are), and the quality of elements.

        Examples
        --------
        >>> import pyvista as pv
        >>> import numpy as np
        >>> cube = pv.Box(level=15).triangulate().clean()
        >>> cube.points += np.random.default_rng(1).normal(0.0, 0.01, cube.points.shape)
        >>> better = cube.vtksmooth.feature_preserving_denoising(output_points_precision="double")
        >>> abs(better.volume / cube.volume - 1.0) < 1e-12
        True
        """

    def angle_based_smoothing(
        self,
        *,
        installation: pv.PolyData | None = None,
        source: pv.PolyData | None = None,
        iterations: int = 10,
        fixed: str | Sequence[int] | npt.NDArray[Any] | None = 'Fixed',
        blend: str | None = 'BlendWeight',
        max_displacement: str | None = 'SmoothingConstraints',
        boundary_labels: str | None = 'BoundaryLabels',
        boundary: Literal['fixed', 'sliding', 'smoothed'] = 'fixed',
        boundary_corner_angle: float = 30.0,
        features: Literal['ignore', 'hold', 'slide'] = 'ignore',
        ridge_angle: float | Literal['auto'] = 'auto',
        corner_angle: float | Literal['auto'] = 'auto',
        added_edges: str | None = 'AddedFeatureEdges',
        removed_edges: str | None = 'RemovedFeatureEdges',
        crease_angle: float | None = None,
        gate: Literal['none', 'angle', 'aspect', 'floor'] = 'none',
        gate_floor: float = 0.6,
        max_deviation_fraction: float | None = None,
        null_space: bool = False,
        tensor_weight: Literal['area', 'angle'] = 'area',
        corrections: int = 0,
        preserve_volume: bool = False,
        containment: Literal['none', 'vertices', 'exact'] = 'exact',
        tolerance_fraction: float = 1e-06,
        directions: Literal['all', 'x', 'y', 'z', 'xy', 'xz', 'yz', 'about-x', 'about-y', 'about-z'] = 'all',
        rotation_center: str = '0,0,0',
        symmetry_planes: str | None = None,
        curvature_radius: float | Literal['auto'] | None = None,
        curvature_ramp: float = 0.0,
        self_intersection: Literal['ignore', 'none-new'] = 'ignore',
        stop_normal_deviation: float | None = None,
        stop_dihedral_change: float | None = None,
        stop_deviation_fraction: float | None = None,
        stop_volume_percent: float | None = None,
        stop_gain: float | None = None,
        stop_statistic: Literal['max', 'mean'] = 'max',
        output_points_precision: Literal['default', 'single', 'double', 0, 1, 2] = 'default',
        weighted: bool = False,
        inplace: bool = False,
        progress_bar: bool = False,
    ) -> pv.PolyData:
        """Turn each spoke onto the bisector of the angle at its outer end, in the tangent plane.

        Plain: T. Zhou, K. Shimada, "An Angle-Based Approach to Two-Dimensional Mesh Smoothing" (2000).
        Weighted with 1/angle^2: V. Surazhsky, C. Gotsman, "High Quality Compatible Triangulations" (2002).

        Parameters
        ----------
        installation : pyvista.PolyData, optional
            The installation space, its normals outwards.
        source : pyvista.PolyData, optional
            A surface that points are put and kept on, such as a CAD tessellation or a scan.
        iterations : int, default 10
            Most iterations to do. Allowed: 0 or more.
        fixed : str, default 'Fixed'
            Point array; points with a nonzero value stay fixed. If it is missing, no point is. In Python also a mask or numbers of points; as text points:0-14,20.
        blend : str, default 'BlendWeight'
            Point array of the part of each step that a point takes, 0 to 1; absent, all of it.
        max_displacement : str, default 'SmoothingConstraints'
            Point array of how far each point may go from its place, in model units; absent, any distance.
        boundary_labels : str, default 'BoundaryLabels'
            Cell array of the labels on the two sides of each face, normals from the first to the second (or of one label, the other is 0); absent, the surface is one between two sides.
        boundary : {'fixed', 'sliding', 'smoothed'}, default 'fixed'
            Whether boundary points stay, slide along it, or smooth it as a curve that keeps its area.
        boundary_corner_angle : float, default 30.0
            Boundary points that may move stay where the boundary turns by more than this. Allowed: from 0 to 180 deg. Only where boundary is sliding or smoothed.
        features : {'ignore', 'hold', 'slide'}, default 'ignore'
            Whether points on ridges move like all others, are held, or slide along the ridge; corners stay.
        ridge_angle : float, default 'auto'
            Dihedral angle from which an edge is a ridge, where no arrays say what the features are. Allowed: from 0 to 180 deg, or auto. Only where features is hold or slide or null_space is on.
        corner_angle : float, default 'auto'
            Turning angle from which a ridge or a cone has a corner, where no arrays say it. Allowed: from 0 to 180 deg, or auto. Only where features is hold or slide or null_space is on.
        added_edges : str, default 'AddedFeatureEdges'
            Field array of pairs of points: edges that are ridges, whatever their angle. Only where features is hold or slide or null_space is on.
        removed_edges : str, default 'RemovedFeatureEdges'
            Field array of pairs of points: edges that are no ridges, whatever their angle. Only where features is hold or slide or null_space is on.
        crease_angle : float, default None
            Edges with a dihedral angle above this stay above it. Allowed: from 0 to 180 deg, or None (off).
        gate : {'none', 'angle', 'aspect', 'floor'}, default 'none'
            What must improve round a vertex for it to move: nothing, the smallest angle, the smallest aspect ratio, or (floor) that below gate_floor and the mean above it.
        gate_floor : float, default 0.6
            Of the gate with a floor: aspect ratio that is good enough. Allowed: from 0 to 1. Only where gate is floor.
        max_deviation_fraction : float, default None
            Keep every point within this distance of the original surface. Allowed: 0 diagonals or more, or None (off).
        null_space : bool, default False
            Keep of each step what goes across the surface or along its ridges; corners do not slide.
        tensor_weight : {'area', 'angle'}, default 'area'
            What weighs a face in a vertex' tensor: its area, or its angle (better on badly graded meshes). Only where null_space is on.
        corrections : int, default 0
            Corrections in each pass of the volume that is swept round every point; 0 is none. Allowed: from 0 to 100.
        preserve_volume : bool, default False
            End each pass with an equal step of all points that closes the volume of every body, or of every label, exactly.
        containment : {'none', 'vertices', 'exact'}, default 'exact'
            What must stay inside the installation space: nothing, vertices, or (exact) triangles too. Only where installation is set.
        tolerance_fraction : float, default 1e-06
            How far outside counts as inside; never less than what the points' precision makes of it. Allowed: 0 diagonals or more. Only where installation is set.
        directions : {'all', 'x', 'y', 'z', 'xy', 'xz', 'yz', 'about-x', 'about-y', 'about-z'}, default 'all'
            Coordinates that may change (xy: in plan, where no face turns over), or an axis to turn about.
        rotation_center : str, default '0,0,0'
            A point on the axis about which points turn, in model units: its three coordinates. Only where directions is about-x, about-y or about-z.
        symmetry_planes : str, default None
            Planes on which points stay that are on them at the start, such as x=0,z=2.5; model units.
        curvature_radius : float, default None
            Leave points where the surface is as flat as a sphere of this radius; auto: by the noise. Allowed: 0 model units or more, or auto, or None (off).
        curvature_ramp : float, default 0.0
            Steps grow from nothing to full length between 1 and 1 + this times the bound. Allowed: 0 or more. Only where curvature_radius is set.
        self_intersection : {'ignore', 'none-new'}, default 'ignore'
            Whether faces may come to cross or touch others that they did not at the start.
        stop_normal_deviation : float, default None
            Stop before vertex normals turn by more than this. Allowed: from 0 to 180 deg, or None (off).
        stop_dihedral_change : float, default None
            Stop before dihedral angles change by more than this. Allowed: from 0 to 360 deg, or None (off).
        stop_deviation_fraction : float, default None
            Stop before points are farther from the original surface than this. Allowed: 0 diagonals or more, or None (off).
        stop_volume_percent : float, default None
            Stop before the enclosed volume changes by more than this. Allowed: 0 percent or more, or None (off).
        stop_gain : float, default None
            Stop when an iteration raises the mean aspect ratio by less than this. Allowed: a number, or None (off).
        stop_statistic : {'max', 'mean'}, default 'max'
            What of normals, dihedral angles and distances the stop rules look at. Only where stop_normal_deviation is set or stop_dihedral_change is set or stop_deviation_fraction is set.
        output_points_precision : {'default', 'single', 'double'}, default 'default'
            Precision of the output's points; default keeps the input's.
        weighted : bool, default False
            Weigh each neighbour with 1/angle^2, so that small angles count more.
        inplace : bool, default False
            Change the mesh itself and return it.
        progress_bar : bool, default False
            Show progress.

        Returns
        -------
        pyvista.PolyData
            The result; figures are in its field data.

        Guarantees
        ----------
        Fixed points and, unless it slides, the boundary keep their bits. With ``gate="aspect"`` what
        TrapeziumDrawing guarantees; without a gate elements may invert.

        Examples
        --------
        >>> import pyvista as pv
        >>> disk = pv.Disc(r_res=4, c_res=12).triangulate()
        >>> better = disk.vtksmooth.angle_based_smoothing(weighted=True, gate="aspect")
        >>> better.n_points == disk.n_points
        True
        """

    def back_to_surface_smoothing(
        self,
        *,
        installation: pv.PolyData | None = None,
        source: pv.PolyData | None = None,
        iterations: int = 10,
        fixed: str | Sequence[int] | npt.NDArray[Any] | None = 'Fixed',
        blend: str | None = 'BlendWeight',
        max_displacement: str | None = 'SmoothingConstraints',
        boundary_labels: str | None = 'BoundaryLabels',
        boundary: Literal['fixed', 'sliding', 'smoothed'] = 'fixed',
        boundary_corner_angle: float = 30.0,
        features: Literal['ignore', 'hold', 'slide'] = 'ignore',
        ridge_angle: float | Literal['auto'] = 'auto',
        corner_angle: float | Literal['auto'] = 'auto',
        added_edges: str | None = 'AddedFeatureEdges',
        removed_edges: str | None = 'RemovedFeatureEdges',
        crease_angle: float | None = None,
        gate: Literal['none', 'angle', 'aspect', 'floor'] = 'angle',
        gate_floor: float = 0.6,
        max_deviation_fraction: float | None = None,
        null_space: bool = False,
        tensor_weight: Literal['area', 'angle'] = 'area',
        corrections: int = 0,
        preserve_volume: bool = False,
        containment: Literal['none', 'vertices', 'exact'] = 'exact',
        tolerance_fraction: float = 1e-06,
        directions: Literal['all', 'x', 'y', 'z', 'xy', 'xz', 'yz', 'about-x', 'about-y', 'about-z'] = 'all',
        rotation_center: str = '0,0,0',
        symmetry_planes: str | None = None,
        curvature_radius: float | Literal['auto'] | None = None,
        curvature_ramp: float = 0.0,
        self_intersection: Literal['ignore', 'none-new'] = 'ignore',
        stop_normal_deviation: float | None = None,
        stop_dihedral_change: float | None = None,
        stop_deviation_fraction: float | None = None,
        stop_volume_percent: float | None = None,
        stop_gain: float | None = None,
        stop_statistic: Literal['max', 'mean'] = 'max',
        output_points_precision: Literal['default', 'single', 'double', 0, 1, 2] = 'default',
        relaxation_factor: float = 1.0,
        inplace: bool = False,
        progress_bar: bool = False,
    ) -> pv.PolyData:
        """Keep vertices on the original *discrete* surface while improving the smallest angles.

        The "BDS" that Semenova et al. compare with (section 5.2): the mean of the one-ring in the tangent
        plane, put back to the closest point of the original mesh, accepted if the smallest angle grows.

        Parameters
        ----------
        installation : pyvista.PolyData, optional
            The installation space, its normals outwards.
        source : pyvista.PolyData, optional
            A surface that points are put and kept on, such as a CAD tessellation or a scan.
        iterations : int, default 10
            Most iterations to do. Allowed: 0 or more.
        fixed : str, default 'Fixed'
            Point array; points with a nonzero value stay fixed. If it is missing, no point is. In Python also a mask or numbers of points; as text points:0-14,20.
        blend : str, default 'BlendWeight'
            Point array of the part of each step that a point takes, 0 to 1; absent, all of it.
        max_displacement : str, default 'SmoothingConstraints'
            Point array of how far each point may go from its place, in model units; absent, any distance.
        boundary_labels : str, default 'BoundaryLabels'
            Cell array of the labels on the two sides of each face, normals from the first to the second (or of one label, the other is 0); absent, the surface is one between two sides.
        boundary : {'fixed', 'sliding', 'smoothed'}, default 'fixed'
            Whether boundary points stay, slide along it, or smooth it as a curve that keeps its area.
        boundary_corner_angle : float, default 30.0
            Boundary points that may move stay where the boundary turns by more than this. Allowed: from 0 to 180 deg. Only where boundary is sliding or smoothed.
        features : {'ignore', 'hold', 'slide'}, default 'ignore'
            Whether points on ridges move like all others, are held, or slide along the ridge; corners stay.
        ridge_angle : float, default 'auto'
            Dihedral angle from which an edge is a ridge, where no arrays say what the features are. Allowed: from 0 to 180 deg, or auto. Only where features is hold or slide or null_space is on.
        corner_angle : float, default 'auto'
            Turning angle from which a ridge or a cone has a corner, where no arrays say it. Allowed: from 0 to 180 deg, or auto. Only where features is hold or slide or null_space is on.
        added_edges : str, default 'AddedFeatureEdges'
            Field array of pairs of points: edges that are ridges, whatever their angle. Only where features is hold or slide or null_space is on.
        removed_edges : str, default 'RemovedFeatureEdges'
            Field array of pairs of points: edges that are no ridges, whatever their angle. Only where features is hold or slide or null_space is on.
        crease_angle : float, default None
            Edges with a dihedral angle above this stay above it. Allowed: from 0 to 180 deg, or None (off).
        gate : {'none', 'angle', 'aspect', 'floor'}, default 'angle'
            What must improve round a vertex for it to move: nothing, the smallest angle, the smallest aspect ratio, or (floor) that below gate_floor and the mean above it.
        gate_floor : float, default 0.6
            Of the gate with a floor: aspect ratio that is good enough. Allowed: from 0 to 1. Only where gate is floor.
        max_deviation_fraction : float, default None
            Keep every point within this distance of the original surface. Allowed: 0 diagonals or more, or None (off).
        null_space : bool, default False
            Keep of each step what goes across the surface or along its ridges; corners do not slide.
        tensor_weight : {'area', 'angle'}, default 'area'
            What weighs a face in a vertex' tensor: its area, or its angle (better on badly graded meshes). Only where null_space is on.
        corrections : int, default 0
            Corrections in each pass of the volume that is swept round every point; 0 is none. Allowed: from 0 to 100.
        preserve_volume : bool, default False
            End each pass with an equal step of all points that closes the volume of every body, or of every label, exactly.
        containment : {'none', 'vertices', 'exact'}, default 'exact'
            What must stay inside the installation space: nothing, vertices, or (exact) triangles too. Only where installation is set.
        tolerance_fraction : float, default 1e-06
            How far outside counts as inside; never less than what the points' precision makes of it. Allowed: 0 diagonals or more. Only where installation is set.
        directions : {'all', 'x', 'y', 'z', 'xy', 'xz', 'yz', 'about-x', 'about-y', 'about-z'}, default 'all'
            Coordinates that may change (xy: in plan, where no face turns over), or an axis to turn about.
        rotation_center : str, default '0,0,0'
            A point on the axis about which points turn, in model units: its three coordinates. Only where directions is about-x, about-y or about-z.
        symmetry_planes : str, default None
            Planes on which points stay that are on them at the start, such as x=0,z=2.5; model units.
        curvature_radius : float, default None
            Leave points where the surface is as flat as a sphere of this radius; auto: by the noise. Allowed: 0 model units or more, or auto, or None (off).
        curvature_ramp : float, default 0.0
            Steps grow from nothing to full length between 1 and 1 + this times the bound. Allowed: 0 or more. Only where curvature_radius is set.
        self_intersection : {'ignore', 'none-new'}, default 'ignore'
            Whether faces may come to cross or touch others that they did not at the start.
        stop_normal_deviation : float, default None
            Stop before vertex normals turn by more than this. Allowed: from 0 to 180 deg, or None (off).
        stop_dihedral_change : float, default None
            Stop before dihedral angles change by more than this. Allowed: from 0 to 360 deg, or None (off).
        stop_deviation_fraction : float, default None
            Stop before points are farther from the original surface than this. Allowed: 0 diagonals or more, or None (off).
        stop_volume_percent : float, default None
            Stop before the enclosed volume changes by more than this. Allowed: 0 percent or more, or None (off).
        stop_gain : float, default None
            Stop when an iteration raises the mean aspect ratio by less than this. Allowed: a number, or None (off).
        stop_statistic : {'max', 'mean'}, default 'max'
            What of normals, dihedral angles and distances the stop rules look at. Only where stop_normal_deviation is set or stop_dihedral_change is set or stop_deviation_fraction is set.
        output_points_precision : {'default', 'single', 'double'}, default 'default'
            Precision of the output's points; default keeps the input's.
        relaxation_factor : float, default 1.0
            Part of the proposed step that is taken. Allowed: from 0 to 1.
        inplace : bool, default False
            Change the mesh itself and return it.
        progress_bar : bool, default False
            Show progress.

        Returns
        -------
        pyvista.PolyData
            The result; figures are in its field data.

        Guarantees
        ----------
        Every vertex that moved lies on the original mesh (to rounding). Fixed points and, unless it slides,
        the boundary keep their bits.

        Examples
        --------
        >>> import pyvista as pv
        >>> ant = pv.read(pv.examples.antfile)
        >>> better = ant.vtksmooth.back_to_surface_smoothing(iterations=3)
        >>> distances = better.compute_implicit_distance(ant)["implicit_distance"]
        >>> bool(abs(distances).max() < 1e-6 * ant.length)
        True
        """

    def equilateral_smoothing(
        self,
        *,
        installation: pv.PolyData | None = None,
        source: pv.PolyData | None = None,
        iterations: int = 50,
        fixed: str | Sequence[int] | npt.NDArray[Any] | None = 'Fixed',
        blend: str | None = 'BlendWeight',
        max_displacement: str | None = 'SmoothingConstraints',
        boundary_labels: str | None = 'BoundaryLabels',
        boundary: Literal['fixed', 'sliding', 'smoothed'] = 'sliding',
        boundary_corner_angle: float = 30.0,
        features: Literal['ignore', 'hold', 'slide'] = 'slide',
        ridge_angle: float | Literal['auto'] = 40.0,
        corner_angle: float | Literal['auto'] = 'auto',
        added_edges: str | None = 'AddedFeatureEdges',
        removed_edges: str | None = 'RemovedFeatureEdges',
        crease_angle: float | None = 40.0,
        gate: Literal['none', 'angle', 'aspect', 'floor'] = 'floor',
        gate_floor: float = 0.6,
        max_deviation_fraction: float | None = None,
        null_space: bool = False,
        tensor_weight: Literal['area', 'angle'] = 'area',
        corrections: int = 0,
        preserve_volume: bool = False,
        containment: Literal['none', 'vertices', 'exact'] = 'exact',
        tolerance_fraction: float = 1e-06,
        directions: Literal['all', 'x', 'y', 'z', 'xy', 'xz', 'yz', 'about-x', 'about-y', 'about-z'] = 'all',
        rotation_center: str = '0,0,0',
        symmetry_planes: str | None = None,
        curvature_radius: float | Literal['auto'] | None = None,
        curvature_ramp: float = 0.0,
        self_intersection: Literal['ignore', 'none-new'] = 'none-new',
        stop_normal_deviation: float | None = None,
        stop_dihedral_change: float | None = None,
        stop_deviation_fraction: float | None = None,
        stop_volume_percent: float | None = None,
        stop_gain: float | None = None,
        stop_statistic: Literal['max', 'mean'] = 'max',
        output_points_precision: Literal['default', 'single', 'double', 0, 1, 2] = 'default',
        relaxation_factor: float = 1.0,
        tangent_plane: bool = True,
        inplace: bool = False,
        progress_bar: bool = False,
    ) -> pv.PolyData:
        """Make elements as regular as their connectivity allows, on the surface as it is.

        Each face of a vertex asks for the apex that would make it equilateral (a polygon: its corner regular);
        the vertex takes the tangential part of the mean. Points on ridges and boundaries slide along them,
        corners stay, creases stay creases. A point moves only where no element becomes worse that is not good
        enough anyway, and then if the worst or the mean gains: see ``gate="floor"``.

        Parameters
        ----------
        installation : pyvista.PolyData, optional
            The installation space, its normals outwards.
        source : pyvista.PolyData, optional
            A surface that points are put and kept on, such as a CAD tessellation or a scan.
        iterations : int, default 50
            Most iterations to do. Allowed: 0 or more.
        fixed : str, default 'Fixed'
            Point array; points with a nonzero value stay fixed. If it is missing, no point is. In Python also a mask or numbers of points; as text points:0-14,20.
        blend : str, default 'BlendWeight'
            Point array of the part of each step that a point takes, 0 to 1; absent, all of it.
        max_displacement : str, default 'SmoothingConstraints'
            Point array of how far each point may go from its place, in model units; absent, any distance.
        boundary_labels : str, default 'BoundaryLabels'
            Cell array of the labels on the two sides of each face, normals from the first to the second (or of one label, the other is 0); absent, the surface is one between two sides.
        boundary : {'fixed', 'sliding', 'smoothed'}, default 'sliding'
            Whether boundary points stay, slide along it, or smooth it as a curve that keeps its area.
        boundary_corner_angle : float, default 30.0
            Boundary points that may move stay where the boundary turns by more than this. Allowed: from 0 to 180 deg. Only where boundary is sliding or smoothed.
        features : {'ignore', 'hold', 'slide'}, default 'slide'
            Whether points on ridges move like all others, are held, or slide along the ridge; corners stay.
        ridge_angle : float, default 40.0
            Dihedral angle from which an edge is a ridge, where no arrays say what the features are. Allowed: from 0 to 180 deg, or auto. Only where features is hold or slide or null_space is on.
        corner_angle : float, default 'auto'
            Turning angle from which a ridge or a cone has a corner, where no arrays say it. Allowed: from 0 to 180 deg, or auto. Only where features is hold or slide or null_space is on.
        added_edges : str, default 'AddedFeatureEdges'
            Field array of pairs of points: edges that are ridges, whatever their angle. Only where features is hold or slide or null_space is on.
        removed_edges : str, default 'RemovedFeatureEdges'
            Field array of pairs of points: edges that are no ridges, whatever their angle. Only where features is hold or slide or null_space is on.
        crease_angle : float, default 40.0
            Edges with a dihedral angle above this stay above it. Allowed: from 0 to 180 deg, or None (off).
        gate : {'none', 'angle', 'aspect', 'floor'}, default 'floor'
            What must improve round a vertex for it to move: nothing, the smallest angle, the smallest aspect ratio, or (floor) that below gate_floor and the mean above it.
        gate_floor : float, default 0.6
            Of the gate with a floor: aspect ratio that is good enough. Allowed: from 0 to 1. Only where gate is floor.
        max_deviation_fraction : float, default None
            Keep every point within this distance of the original surface. Allowed: 0 diagonals or more, or None (off).
        null_space : bool, default False
            Keep of each step what goes across the surface or along its ridges; corners do not slide.
        tensor_weight : {'area', 'angle'}, default 'area'
            What weighs a face in a vertex' tensor: its area, or its angle (better on badly graded meshes). Only where null_space is on.
        corrections : int, default 0
            Corrections in each pass of the volume that is swept round every point; 0 is none. Allowed: from 0 to 100.
        preserve_volume : bool, default False
            End each pass with an equal step of all points that closes the volume of every body, or of every label, exactly.
        containment : {'none', 'vertices', 'exact'}, default 'exact'
            What must stay inside the installation space: nothing, vertices, or (exact) triangles too. Only where installation is set.
        tolerance_fraction : float, default 1e-06
            How far outside counts as inside; never less than what the points' precision makes of it. Allowed: 0 diagonals or more. Only where installation is set.
        directions : {'all', 'x', 'y', 'z', 'xy', 'xz', 'yz', 'about-x', 'about-y', 'about-z'}, default 'all'
            Coordinates that may change (xy: in plan, where no face turns over), or an axis to turn about.
        rotation_center : str, default '0,0,0'
            A point on the axis about which points turn, in model units: its three coordinates. Only where directions is about-x, about-y or about-z.
        symmetry_planes : str, default None
            Planes on which points stay that are on them at the start, such as x=0,z=2.5; model units.
        curvature_radius : float, default None
            Leave points where the surface is as flat as a sphere of this radius; auto: by the noise. Allowed: 0 model units or more, or auto, or None (off).
        curvature_ramp : float, default 0.0
            Steps grow from nothing to full length between 1 and 1 + this times the bound. Allowed: 0 or more. Only where curvature_radius is set.
        self_intersection : {'ignore', 'none-new'}, default 'none-new'
            Whether faces may come to cross or touch others that they did not at the start.
        stop_normal_deviation : float, default None
            Stop before vertex normals turn by more than this. Allowed: from 0 to 180 deg, or None (off).
        stop_dihedral_change : float, default None
            Stop before dihedral angles change by more than this. Allowed: from 0 to 360 deg, or None (off).
        stop_deviation_fraction : float, default None
            Stop before points are farther from the original surface than this. Allowed: 0 diagonals or more, or None (off).
        stop_volume_percent : float, default None
            Stop before the enclosed volume changes by more than this. Allowed: 0 percent or more, or None (off).
        stop_gain : float, default None
            Stop when an iteration raises the mean aspect ratio by less than this. Allowed: a number, or None (off).
        stop_statistic : {'max', 'mean'}, default 'max'
            What of normals, dihedral angles and distances the stop rules look at. Only where stop_normal_deviation is set or stop_dihedral_change is set or stop_deviation_fraction is set.
        output_points_precision : {'default', 'single', 'double'}, default 'default'
            Precision of the output's points; default keeps the input's.
        relaxation_factor : float, default 1.0
            Part of the proposed step that is taken. Allowed: from 0 to 1.
        tangent_plane : bool, default True
            Move vertices only across the surface, not off it.
        inplace : bool, default False
            Change the mesh itself and return it.
        progress_bar : bool, default False
            Show progress.

        Returns
        -------
        pyvista.PolyData
            The result; figures are in its field data.

        Guarantees
        ----------
        With the default gate, before the output's points are rounded to single precision: no iteration makes more
        faces inverted, nor lowers the smallest k of the mesh below ``gate_floor`` or, where it is below that, at
        all; both against the input's directions. Edges with a dihedral angle above ``crease_angle`` stay above
        it. No faces cross or touch that did not. Straight ridges and boundaries stay straight, flat faces of
        polyhedra flat, and corners keep their bits. Fixed points keep their bits. Topology is the input's. The
        result does not depend on the number of threads.

        Not guaranteed: a bound of the deviation (set ``max_deviation_fraction``); curved ridges and boundaries
        change by what sliding parallel to the chord of the neighbours makes.

        Examples
        --------
        >>> import pyvista as pv
        >>> nut = pv.read(pv.examples.nutfile)
        >>> better = nut.vtksmooth.equilateral_smoothing(iterations=10)
        >>> mean = [mesh.vtksmooth.surface_quality()["AspectRatio"].mean() for mesh in (nut, better)]
        >>> bool(mean[1] > mean[0])
        True
        """

    def null_space_smoothing(
        self,
        *,
        installation: pv.PolyData | None = None,
        source: pv.PolyData | None = None,
        iterations: int = 10,
        fixed: str | Sequence[int] | npt.NDArray[Any] | None = 'Fixed',
        blend: str | None = 'BlendWeight',
        max_displacement: str | None = 'SmoothingConstraints',
        boundary_labels: str | None = 'BoundaryLabels',
        boundary: Literal['fixed', 'sliding', 'smoothed'] = 'fixed',
        boundary_corner_angle: float = 30.0,
        features: Literal['ignore', 'hold', 'slide'] = 'slide',
        ridge_angle: float | Literal['auto'] = 'auto',
        corner_angle: float | Literal['auto'] = 'auto',
        added_edges: str | None = 'AddedFeatureEdges',
        removed_edges: str | None = 'RemovedFeatureEdges',
        crease_angle: float | None = None,
        gate: Literal['none', 'angle', 'aspect', 'floor'] = 'floor',
        gate_floor: float = 0.6,
        max_deviation_fraction: float | None = None,
        null_space: bool = True,
        tensor_weight: Literal['area', 'angle'] = 'area',
        corrections: int = 2,
        preserve_volume: bool = True,
        containment: Literal['none', 'vertices', 'exact'] = 'exact',
        tolerance_fraction: float = 1e-06,
        directions: Literal['all', 'x', 'y', 'z', 'xy', 'xz', 'yz', 'about-x', 'about-y', 'about-z'] = 'all',
        rotation_center: str = '0,0,0',
        symmetry_planes: str | None = None,
        curvature_radius: float | Literal['auto'] | None = None,
        curvature_ramp: float = 0.0,
        self_intersection: Literal['ignore', 'none-new'] = 'ignore',
        stop_normal_deviation: float | None = None,
        stop_dihedral_change: float | None = None,
        stop_deviation_fraction: float | None = None,
        stop_volume_percent: float | None = None,
        stop_gain: float | None = None,
        stop_statistic: Literal['max', 'mean'] = 'max',
        output_points_precision: Literal['default', 'single', 'double', 0, 1, 2] = 'default',
        scheme: Literal['umbrella', 'scale-dependent', 'cotangent', 'thin-plate', 'taubin', 'area-weighted', 'angle-weighted', 'odt', 'equilateral', 'trapezium-drawing', 'angle-based', 'weighted-angle-based'] = 'umbrella',
        relaxation_factor: float = 0.5,
        flux: str | None = None,
        inplace: bool = False,
        progress_bar: bool = False,
    ) -> pv.PolyData:
        """Redistribute the points of a surface that is to stay as it is: for simulations that smooth every step.

        A scheme proposes; of its step smooth points keep what lies in their tangent plane, ridge points move
        along the ridge, corners stay. The volume that this sweeps is given back round every point along the
        surface's direction there, in a few corrections, and the rest by an equal step of all points. Source:
        X. Jiao, "Volume and Feature Preservation in Surface Mesh Optimization", sections 2 to 4.

        Parameters
        ----------
        installation : pyvista.PolyData, optional
            The installation space, its normals outwards.
        source : pyvista.PolyData, optional
            A surface that points are put and kept on, such as a CAD tessellation or a scan.
        iterations : int, default 10
            Most iterations to do. Allowed: 0 or more.
        fixed : str, default 'Fixed'
            Point array; points with a nonzero value stay fixed. If it is missing, no point is. In Python also a mask or numbers of points; as text points:0-14,20.
        blend : str, default 'BlendWeight'
            Point array of the part of each step that a point takes, 0 to 1; absent, all of it.
        max_displacement : str, default 'SmoothingConstraints'
            Point array of how far each point may go from its place, in model units; absent, any distance.
        boundary_labels : str, default 'BoundaryLabels'
            Cell array of the labels on the two sides of each face, normals from the first to the second (or of one label, the other is 0); absent, the surface is one between two sides.
        boundary : {'fixed', 'sliding', 'smoothed'}, default 'fixed'
            Whether boundary points stay, slide along it, or smooth it as a curve that keeps its area.
        boundary_corner_angle : float, default 30.0
            Boundary points that may move stay where the boundary turns by more than this. Allowed: from 0 to 180 deg. Only where boundary is sliding or smoothed.
        features : {'ignore', 'hold', 'slide'}, default 'slide'
            Whether points on ridges move like all others, are held, or slide along the ridge; corners stay.
        ridge_angle : float, default 'auto'
            Dihedral angle from which an edge is a ridge, where no arrays say what the features are. Allowed: from 0 to 180 deg, or auto. Only where features is hold or slide or null_space is on.
        corner_angle : float, default 'auto'
            Turning angle from which a ridge or a cone has a corner, where no arrays say it. Allowed: from 0 to 180 deg, or auto. Only where features is hold or slide or null_space is on.
        added_edges : str, default 'AddedFeatureEdges'
            Field array of pairs of points: edges that are ridges, whatever their angle. Only where features is hold or slide or null_space is on.
        removed_edges : str, default 'RemovedFeatureEdges'
            Field array of pairs of points: edges that are no ridges, whatever their angle. Only where features is hold or slide or null_space is on.
        crease_angle : float, default None
            Edges with a dihedral angle above this stay above it. Allowed: from 0 to 180 deg, or None (off).
        gate : {'none', 'angle', 'aspect', 'floor'}, default 'floor'
            What must improve round a vertex for it to move: nothing, the smallest angle, the smallest aspect ratio, or (floor) that below gate_floor and the mean above it.
        gate_floor : float, default 0.6
            Of the gate with a floor: aspect ratio that is good enough. Allowed: from 0 to 1. Only where gate is floor.
        max_deviation_fraction : float, default None
            Keep every point within this distance of the original surface. Allowed: 0 diagonals or more, or None (off).
        null_space : bool, default True
            Keep of each step what goes across the surface or along its ridges; corners do not slide.
        tensor_weight : {'area', 'angle'}, default 'area'
            What weighs a face in a vertex' tensor: its area, or its angle (better on badly graded meshes). Only where null_space is on.
        corrections : int, default 2
            Corrections in each pass of the volume that is swept round every point; 0 is none. Allowed: from 0 to 100.
        preserve_volume : bool, default True
            End each pass with an equal step of all points that closes the volume of every body, or of every label, exactly.
        containment : {'none', 'vertices', 'exact'}, default 'exact'
            What must stay inside the installation space: nothing, vertices, or (exact) triangles too. Only where installation is set.
        tolerance_fraction : float, default 1e-06
            How far outside counts as inside; never less than what the points' precision makes of it. Allowed: 0 diagonals or more. Only where installation is set.
        directions : {'all', 'x', 'y', 'z', 'xy', 'xz', 'yz', 'about-x', 'about-y', 'about-z'}, default 'all'
            Coordinates that may change (xy: in plan, where no face turns over), or an axis to turn about.
        rotation_center : str, default '0,0,0'
            A point on the axis about which points turn, in model units: its three coordinates. Only where directions is about-x, about-y or about-z.
        symmetry_planes : str, default None
            Planes on which points stay that are on them at the start, such as x=0,z=2.5; model units.
        curvature_radius : float, default None
            Leave points where the surface is as flat as a sphere of this radius; auto: by the noise. Allowed: 0 model units or more, or auto, or None (off).
        curvature_ramp : float, default 0.0
            Steps grow from nothing to full length between 1 and 1 + this times the bound. Allowed: 0 or more. Only where curvature_radius is set.
        self_intersection : {'ignore', 'none-new'}, default 'ignore'
            Whether faces may come to cross or touch others that they did not at the start.
        stop_normal_deviation : float, default None
            Stop before vertex normals turn by more than this. Allowed: from 0 to 180 deg, or None (off).
        stop_dihedral_change : float, default None
            Stop before dihedral angles change by more than this. Allowed: from 0 to 360 deg, or None (off).
        stop_deviation_fraction : float, default None
            Stop before points are farther from the original surface than this. Allowed: 0 diagonals or more, or None (off).
        stop_volume_percent : float, default None
            Stop before the enclosed volume changes by more than this. Allowed: 0 percent or more, or None (off).
        stop_gain : float, default None
            Stop when an iteration raises the mean aspect ratio by less than this. Allowed: a number, or None (off).
        stop_statistic : {'max', 'mean'}, default 'max'
            What of normals, dihedral angles and distances the stop rules look at. Only where stop_normal_deviation is set or stop_dihedral_change is set or stop_deviation_fraction is set.
        output_points_precision : {'default', 'single', 'double'}, default 'default'
            Precision of the output's points; default keeps the input's.
        scheme : {'umbrella', 'scale-dependent', 'cotangent', 'thin-plate', 'taubin', 'area-weighted', 'angle-weighted', 'odt', 'equilateral', 'trapezium-drawing', 'angle-based', 'weighted-angle-based'}, default 'umbrella'
            Which steps are proposed.
        relaxation_factor : float, default 0.5
            Part of the proposed step that is taken. Allowed: from 0 to 1. Only where scheme is umbrella, scale-dependent, cotangent, thin-plate, taubin, area-weighted, angle-weighted, odt or equilateral.
        flux : str, default None
            Cell or point array of volume per area that the surface is to gain along its normals in the run. Only where preserve_volume is on.
        inplace : bool, default False
            Change the mesh itself and return it.
        progress_bar : bool, default False
            Show progress.

        Returns
        -------
        pyvista.PolyData
            The result; figures are in its field data.

        Guarantees
        ----------
        With ``preserve_volume``: the volume of every closed body is that of the input to rounding, after any
        number of iterations; what open surfaces sweep is 0 to rounding. A pass that cannot close the volume
        of a body leaves it where it was. No iteration inverts a face that is not inverted already, against the
        input's directions. Fixed points keep their bits. On polyhedra flat faces stay flat, straight ridges
        straight, and corners where they were, to rounding. All before the output's points are rounded to single
        precision. Topology is the input's. The result does not depend on the number of threads.

        With the gate, the smallest k does not fall below `gate_floor` or, where it is below, at all. It moves
        points one after another, each with the volume kept up to rounding. With ``gate="none"`` points move at
        the same time, as in the paper: in half the time, but the worst elements may become worse.

        With a `flux` the volume of every closed body grows by the integral of the array over its area at the
        start, to rounding, in equal parts in each iteration; ``report.flux`` is that of the whole surface, and
        ``report.swept_volume`` what was gained: a simulation that calls once per time step adds what is left of
        the one to the next. Round each point what it sweeps answers to the flux there as far as `corrections` go.

        Examples
        --------
        >>> import pyvista as pv
        >>> nut = pv.read(pv.examples.nutfile)
        >>> better = nut.vtksmooth.null_space_smoothing(iterations=50, output_points_precision="double")
        >>> abs(better.volume / nut.volume - 1.0) < 1e-12
        True
        """

    def valence_triangulation(
        self,
        *,
        inplace: bool = False,
        progress_bar: bool = False,
    ) -> pv.PolyData:
        """Split polygons into triangles so that vertices have about six neighbours.

        Smoothing works evenly where valences are even. All points stay, with their data; the triangles take
        the data of their polygons' cells. Verts and lines pass; faces with fewer than three corners go.
        Adds the cell array ``OriginalCell`` (int64): the number of the cell that each cell was or is part of.
        Source: the installation-space paper, section 4.1.

        Parameters
        ----------
        inplace : bool, default False
            Change the mesh itself and return it.
        progress_bar : bool, default False
            Show progress.

        Returns
        -------
        pyvista.PolyData
            The result; figures are in its field data.

        Guarantees
        ----------
        Triangles stay as they are. No triangle of a polygon with an area is degenerate or turned against the
        polygon, concave polygons included. The result does not depend on the pose, nor on anything but the
        order of the cells and their corners where choices are equal.

        Not guaranteed: a valence of six. Polygons that cross themselves are refused.

        Examples
        --------
        >>> import pyvista as pv
        >>> plane = pv.Plane(i_resolution=4, j_resolution=4)
        >>> triangles = plane.vtksmooth.valence_triangulation()
        >>> triangles.n_cells, triangles.is_all_triangles
        (32, True)
        """

    def installation_space_regions(
        self,
        installation: pv.PolyData,
        *,
        contact_fraction: float = 1e-06,
        blend_rings: int = 3,
        inplace: bool = False,
        progress_bar: bool = False,
    ) -> pv.PolyData:
        """Tell the clean parts of a flow volume's skin, which lie on the installation space, from the noisy.

        Adds the point arrays ``Fixed`` (uint8: 1 on the installation space) and ``BlendWeight`` (float64: 1 at
        free points, falling to 0 within some rings of fixed points), which keeps a ridge from forming where
        clean meets noisy. Source: the installation-space paper, section 4.2.

        Parameters
        ----------
        installation : pyvista.PolyData
            The installation space, its normals outwards.
        contact_fraction : float, default 1e-06
            Points no farther from the installation space than this part of its diagonal are fixed. Allowed: 0 diagonals or more.
        blend_rings : int, default 3
            Rings of fixed points over which the weight falls from 1 to 0. Allowed: 0 or more.
        inplace : bool, default False
            Change the mesh itself and return it.
        progress_bar : bool, default False
            Show progress.

        Returns
        -------
        pyvista.PolyData
            The result; figures are in its field data.

        Guarantees
        ----------
        Points, cells and their data stay. A weight is 1 at every free point and 0 at every fixed point that is
        more than ``blend_rings`` edges from the nearest free one.

        Examples
        --------
        >>> import pyvista as pv
        >>> space, part = pv.Cube(), pv.Cube(x_length=0.5)
        >>> bool(part.vtksmooth.installation_space_regions(space)["Fixed"].all())
        True
        """

    def installation_space_smoothing(
        self,
        installation: pv.PolyData,
        *,
        source: pv.PolyData | None = None,
        iterations: int = 20,
        fixed: str | Sequence[int] | npt.NDArray[Any] | None = None,
        blend: str | None = None,
        max_displacement: str | None = 'SmoothingConstraints',
        boundary_labels: str | None = None,
        boundary: Literal['fixed', 'sliding', 'smoothed'] = 'fixed',
        boundary_corner_angle: float = 30.0,
        features: Literal['ignore', 'hold', 'slide'] = 'ignore',
        ridge_angle: float | Literal['auto'] = 'auto',
        corner_angle: float | Literal['auto'] = 'auto',
        added_edges: str | None = 'AddedFeatureEdges',
        removed_edges: str | None = 'RemovedFeatureEdges',
        crease_angle: float | None = None,
        gate: Literal['none', 'angle', 'aspect', 'floor'] = 'none',
        gate_floor: float = 0.6,
        max_deviation_fraction: float | None = None,
        null_space: bool = False,
        tensor_weight: Literal['area', 'angle'] = 'area',
        corrections: int = 0,
        preserve_volume: bool = False,
        containment: Literal['none', 'vertices', 'exact'] = 'exact',
        tolerance_fraction: float = 1e-06,
        directions: Literal['all', 'x', 'y', 'z', 'xy', 'xz', 'yz', 'about-x', 'about-y', 'about-z'] = 'all',
        rotation_center: str = '0,0,0',
        symmetry_planes: str | None = None,
        curvature_radius: float | Literal['auto'] | None = 'auto',
        curvature_ramp: float = 0.0,
        self_intersection: Literal['ignore', 'none-new'] = 'none-new',
        stop_normal_deviation: float | None = None,
        stop_dihedral_change: float | None = None,
        stop_deviation_fraction: float | None = None,
        stop_volume_percent: float | None = None,
        stop_gain: float | None = None,
        stop_statistic: Literal['max', 'mean'] = 'max',
        output_points_precision: Literal['default', 'single', 'double', 0, 1, 2] = 'default',
        scheme: Literal['umbrella', 'scale-dependent', 'cotangent', 'thin-plate', 'taubin', 'area-weighted', 'angle-weighted', 'odt', 'low-pass', 'pairwise'] = 'pairwise',
        weights: Literal['umbrella', 'scale-dependent', 'cotangent'] = 'umbrella',
        flow: str | None = None,
        flow_weight: float = 3.0,
        relaxation_factor: float = 1.0,
        implicit_step: float | None = None,
        pass_band: float = 0.1,
        wavelength: float | Literal['auto'] = 'auto',
        tangent_plane: bool = False,
        back_to_surface: bool = False,
        contact_fraction: float = 1e-06,
        blend_rings: int = 3,
        inplace: bool = False,
        progress_bar: bool = False,
    ) -> pv.PolyData:
        """Smooth the skin of a flow volume inside its installation space, without changing its volume.

        The chain of the installation-space paper: polygons become triangles with valences near six; parts
        that lie on the space's surface are clean and stay, with a blend to the noisy parts; then sweeps,
        along the flow if there is one, bounded by curvature, with the volume kept by every operation and nothing
        leaving the space; then a count of what is outside. The output has the input's points in the input's
        order, triangles, and the point arrays ``Fixed`` and ``BlendWeight``.

        Parameters
        ----------
        installation : pyvista.PolyData
            The installation space, its normals outwards.
        source : pyvista.PolyData, optional
            A surface that points are put and kept on, such as a CAD tessellation or a scan.
        iterations : int, default 20
            Most iterations to do. Allowed: 0 or more.
        fixed : str, default None
            Point array; points with a nonzero value stay fixed. If it is missing, no point is. In Python also a mask or numbers of points; as text points:0-14,20.
        blend : str, default None
            Point array of the part of each step that a point takes, 0 to 1; absent, all of it.
        max_displacement : str, default 'SmoothingConstraints'
            Point array of how far each point may go from its place, in model units; absent, any distance.
        boundary_labels : str, default None
            Cell array of the labels on the two sides of each face, normals from the first to the second (or of one label, the other is 0); absent, the surface is one between two sides.
        boundary : {'fixed', 'sliding', 'smoothed'}, default 'fixed'
            Whether boundary points stay, slide along it, or smooth it as a curve that keeps its area.
        boundary_corner_angle : float, default 30.0
            Boundary points that may move stay where the boundary turns by more than this. Allowed: from 0 to 180 deg. Only where boundary is sliding or smoothed.
        features : {'ignore', 'hold', 'slide'}, default 'ignore'
            Whether points on ridges move like all others, are held, or slide along the ridge; corners stay.
        ridge_angle : float, default 'auto'
            Dihedral angle from which an edge is a ridge, where no arrays say what the features are. Allowed: from 0 to 180 deg, or auto. Only where features is hold or slide or null_space is on.
        corner_angle : float, default 'auto'
            Turning angle from which a ridge or a cone has a corner, where no arrays say it. Allowed: from 0 to 180 deg, or auto. Only where features is hold or slide or null_space is on.
        added_edges : str, default 'AddedFeatureEdges'
            Field array of pairs of points: edges that are ridges, whatever their angle. Only where features is hold or slide or null_space is on.
        removed_edges : str, default 'RemovedFeatureEdges'
            Field array of pairs of points: edges that are no ridges, whatever their angle. Only where features is hold or slide or null_space is on.
        crease_angle : float, default None
            Edges with a dihedral angle above this stay above it. Allowed: from 0 to 180 deg, or None (off).
        gate : {'none', 'angle', 'aspect', 'floor'}, default 'none'
            What must improve round a vertex for it to move: nothing, the smallest angle, the smallest aspect ratio, or (floor) that below gate_floor and the mean above it.
        gate_floor : float, default 0.6
            Of the gate with a floor: aspect ratio that is good enough. Allowed: from 0 to 1. Only where gate is floor.
        max_deviation_fraction : float, default None
            Keep every point within this distance of the original surface. Allowed: 0 diagonals or more, or None (off).
        null_space : bool, default False
            Keep of each step what goes across the surface or along its ridges; corners do not slide.
        tensor_weight : {'area', 'angle'}, default 'area'
            What weighs a face in a vertex' tensor: its area, or its angle (better on badly graded meshes). Only where null_space is on.
        corrections : int, default 0
            Corrections in each pass of the volume that is swept round every point; 0 is none. Allowed: from 0 to 100.
        preserve_volume : bool, default False
            End each pass with an equal step of all points that closes the volume of every body, or of every label, exactly.
        containment : {'none', 'vertices', 'exact'}, default 'exact'
            What must stay inside the installation space: nothing, vertices, or (exact) triangles too.
        tolerance_fraction : float, default 1e-06
            How far outside counts as inside; never less than what the points' precision makes of it. Allowed: 0 diagonals or more.
        directions : {'all', 'x', 'y', 'z', 'xy', 'xz', 'yz', 'about-x', 'about-y', 'about-z'}, default 'all'
            Coordinates that may change (xy: in plan, where no face turns over), or an axis to turn about.
        rotation_center : str, default '0,0,0'
            A point on the axis about which points turn, in model units: its three coordinates. Only where directions is about-x, about-y or about-z.
        symmetry_planes : str, default None
            Planes on which points stay that are on them at the start, such as x=0,z=2.5; model units.
        curvature_radius : float, default 'auto'
            Leave points where the surface is as flat as a sphere of this radius; auto: by the noise. Allowed: 0 model units or more, or auto, or None (off).
        curvature_ramp : float, default 0.0
            Steps grow from nothing to full length between 1 and 1 + this times the bound. Allowed: 0 or more. Only where curvature_radius is set.
        self_intersection : {'ignore', 'none-new'}, default 'none-new'
            Whether faces may come to cross or touch others that they did not at the start.
        stop_normal_deviation : float, default None
            Stop before vertex normals turn by more than this. Allowed: from 0 to 180 deg, or None (off).
        stop_dihedral_change : float, default None
            Stop before dihedral angles change by more than this. Allowed: from 0 to 360 deg, or None (off).
        stop_deviation_fraction : float, default None
            Stop before points are farther from the original surface than this. Allowed: 0 diagonals or more, or None (off).
        stop_volume_percent : float, default None
            Stop before the enclosed volume changes by more than this. Allowed: 0 percent or more, or None (off).
        stop_gain : float, default None
            Stop when an iteration raises the mean aspect ratio by less than this. Allowed: a number, or None (off).
        stop_statistic : {'max', 'mean'}, default 'max'
            What of normals, dihedral angles and distances the stop rules look at. Only where stop_normal_deviation is set or stop_dihedral_change is set or stop_deviation_fraction is set.
        output_points_precision : {'default', 'single', 'double'}, default 'default'
            Precision of the output's points; default keeps the input's.
        scheme : {'umbrella', 'scale-dependent', 'cotangent', 'thin-plate', 'taubin', 'area-weighted', 'angle-weighted', 'odt', 'low-pass', 'pairwise'}, default 'pairwise'
            Scheme; pairwise keeps the volume by itself, all others with preserve_volume.
        weights : {'umbrella', 'scale-dependent', 'cotangent'}, default 'umbrella'
            Weights of the schemes thin-plate, taubin and pairwise. Only where scheme is thin-plate, taubin or pairwise.
        flow : str, default None
            Array of vectors along which to smooth more than across. Only where scheme is umbrella, scale-dependent, cotangent, thin-plate, taubin or pairwise.
        flow_weight : float, default 3.0
            How much more neighbours along the flow weigh; 0 is as much as all others. Allowed: 0 or more. Only where flow is set.
        relaxation_factor : float, default 1.0
            Part of the proposed step that is taken (thin-plate diverges above 0.55). Allowed: from 0 to 1. Only where implicit_step is off and scheme is umbrella, scale-dependent, cotangent, thin-plate, taubin, area-weighted, angle-weighted, odt or pairwise.
        implicit_step : float, default None
            Solve for the end of a step of this size, which is stable for any; off: explicit steps of relaxation_factor. Allowed: from 0 to 10000, or None (off). Only where scheme is umbrella, scale-dependent, cotangent or thin-plate.
        pass_band : float, default 0.1
            Taubin's k_PB = 1/lambda + 1/mu: frequencies below it are kept, so lower smooths more. Allowed: from 0.001 to 0.9. Only where scheme is taubin.
        wavelength : float, default 'auto'
            Waves of this length lose half of their height, shorter ones more; auto: 15 voxels, or 13 edges. Allowed: 0 model units or more, or auto. Only where scheme is low-pass.
        tangent_plane : bool, default False
            Move vertices only across the surface, not off it.
        back_to_surface : bool, default False
            Put every vertex back on the original surface.
        contact_fraction : float, default 1e-06
            Points no farther from the installation space than this part of its diagonal are fixed. Allowed: 0 diagonals or more.
        blend_rings : int, default 3
            Rings of fixed points over which the weight falls from 1 to 0. Allowed: 0 or more.
        inplace : bool, default False
            Change the mesh itself and return it.
        progress_bar : bool, default False
            Show progress.

        Returns
        -------
        pyvista.PolyData
            The result; figures are in its field data.

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

        Examples
        --------
        >>> import pyvista as pv
        >>> from vtksmooth import samples
        >>> skin, space = samples.channel()
        >>> smooth = skin.vtksmooth.installation_space_smoothing(space, iterations=3, flow="Flow")
        >>> check = smooth.vtksmooth.containment_check(space)
        >>> int(check.field_data["VerticesOutside"][0]), int(check.field_data["TrianglesCrossing"][0])
        (0, 0)
        """

    def containment_check(
        self,
        installation: pv.PolyData,
        *,
        tolerance_fraction: float = 1e-06,
        inplace: bool = False,
        progress_bar: bool = False,
    ) -> pv.PolyData:
        """Count the vertices of a mesh outside its installation space, and the triangles that cross it.

        Adds the point array ``SignedDistance`` (float64, negative inside). Distances are VTK's, with signs by
        angle-weighted pseudonormals; where compiled code finds another sign, at slivers, and in spaces of solids
        that overlap or touch, the winding number decides: inside is where it is 1 or more. Lids close the
        openings of an open space, and count as its walls. A triangle whose corners are all inside may still be
        pierced, by a concave corner of the space; that is tested triangle against triangle. Polygons count as the
        triangles that ValenceTriangulation makes of them. Source: the installation-space paper, section 6, and
        beyond it.

        Parameters
        ----------
        installation : pyvista.PolyData
            The installation space, its normals outwards.
        tolerance_fraction : float, default 1e-06
            Distance that counts as touching; never less than what the points' precision makes of it. Allowed: 0 diagonals or more.
        inplace : bool, default False
            Change the mesh itself and return it.
        progress_bar : bool, default False
            Show progress.

        Returns
        -------
        pyvista.PolyData
            The result; figures are in its field data.

        Guarantees
        ----------
        Verdicts are independent of how the mesh was made: this filter shares no state with the smoothing.
        Touching within the tolerance counts neither as outside nor as crossing.

        Not guaranteed: that a closed mesh is inside which goes *round* a part of the space without crossing it
        (a void of the space that the mesh encloses).

        Examples
        --------
        >>> import pyvista as pv
        >>> space, part = pv.Cube(), pv.Cube(x_length=0.5, y_length=0.5, z_length=1.5)
        >>> check = part.vtksmooth.containment_check(space)
        >>> float(check["SignedDistance"].max()), int(check.field_data["TrianglesCrossing"][0])
        (0.25, 8)
        """

    def self_intersection(
        self,
        *,
        inplace: bool = False,
        progress_bar: bool = False,
    ) -> pv.PolyData:
        """Find the faces of a mesh that cross or touch each other.

        Adds the cell array ``SelfIntersection`` (uint8): 2 for faces that cross another one, 1 for those that
        only touch one, 0 for all others. Adds the field arrays ``CrossingCells`` and ``TouchingCells`` (int64,
        two components): the numbers of the cells of each pair. Two faces cross if their interiors share a point,
        in one plane too: faces that cover each other cross. They touch if they share points beyond their common
        vertices and edges, but none of the interiors. Quadrilaterals count as two triangles, cut along
        the shorter diagonal inside, larger polygons as triangles by clipping ears; triangles of one polygon are
        not compared.

        Parameters
        ----------
        inplace : bool, default False
            Change the mesh itself and return it.
        progress_bar : bool, default False
            Show progress.

        Returns
        -------
        pyvista.PolyData
            The result; figures are in its field data.

        Guarantees
        ----------
        The result is exact for the coordinates as they are (other than 0 and above 1e-90 of the largest): signs
        that rounding leaves open are computed in exact arithmetic. There is no tolerance. The number of threads
        does not matter.

        Not guaranteed: anything about faces without area. They are counted, and belong to no pair.

        Examples
        --------
        >>> import pyvista as pv
        >>> pair = pv.Cube() + pv.Cube(x_length=0.5, y_length=0.5, z_length=1.5)
        >>> check = pair.vtksmooth.self_intersection()
        >>> int(check.field_data["CrossingPairs"][0]), check["SelfIntersection"].tolist()
        (8, [0, 0, 0, 0, 2, 2, 2, 2, 2, 2, 0, 0])
        """

class VtksmoothImageAccessor:
    """The filters that make a surface of an image: ``image.vtksmooth.segmentation_surface()``.

    Parameters are keywords, as those of :class:`VtksmoothAccessor`; figures are in the result's field data.

    Examples
    --------
    >>> import numpy as np
    >>> import pyvista as pv
    >>> image = pv.ImageData(dimensions=(8, 8, 8))
    >>> labels = np.zeros((8, 8, 8), np.uint8)
    >>> labels[2:6, 2:6, 2:4], labels[2:6, 2:6, 4:6] = 1, 2
    >>> image["labels"] = labels.ravel(order="F")
    >>> surface = image.vtksmooth.segmentation_surface(iterations=5)
    >>> surface.field_data["LabelVolumes"].round(12).tolist()
    [32.0, 32.0]
    """

    def __init__(self, image: pv.ImageData) -> None: ...

    def segmentation_surface(
        self,
        *,
        scalars: str | None = None,
        labels: str = 'all',
        background: int = 0,
        border: Literal['closed', 'open'] = 'closed',
        iterations: int = 20,
        relaxation_factor: float = 0.2,
        self_intersection: Literal['ignore', 'none-new'] = 'none-new',
        separate: bool = False,
        progress_bar: bool = False,
    ) -> pv.PolyData | pv.MultiBlock:
        """Turn a label image into smooth surfaces that fit together; every label keeps its volume.

        VTK's SurfaceNets, without its smoothing, takes one surface between all labels from the voxels; points
        that coincide are merged; its quadrilaterals are split into triangles; and pairs of points move such that
        the volumes of all labels stay (see the scheme ``pairwise``). Lines where several labels meet, and the
        junctions of these lines, move like all other points.

        The output has the cell array ``BoundaryLabels`` with the labels on both sides of each triangle; normals
        run from the first to the second, which is the background wherever that is one of them. With `separate`
        the output is a multi-block dataset with one closed surface for each label, named by the label: on common
        walls the surfaces have the same points, bit for bit.

        Parameters
        ----------
        scalars : str, default None
            Array of the labels; off, the active scalars or the only array.
        labels : str, default 'all'
            Labels to take, such as 1,3,5-9; all others are background.
        background : int, default 0
            Label of what is around the others, and outside of the image. Allowed: a number.
        border : {'closed', 'open'}, default 'closed'
            Whether surfaces are closed along the border of the image, or left open there.
        iterations : int, default 20
            Sweeps of smoothing; 0 leaves the stairs of the voxels. Allowed: 0 or more.
        relaxation_factor : float, default 0.2
            Part of the umbrella step that each operation on a pair takes. Allowed: from 0 to 1.
        self_intersection : {'ignore', 'none-new'}, default 'none-new'
            Whether faces may come to cross or touch others that they did not at the start.
        separate : bool, default False
            Return one closed surface for each label instead of one surface between all.
        progress_bar : bool, default False
            Show progress.

        Returns
        -------
        pyvista.PolyData or pyvista.MultiBlock
            The result; figures are in its field data.

        Guarantees
        ----------
        The volume of every label is that of its voxels to 1e-12 of it, in double precision (that of the
        output). No triangle turns over, and no two triangles cross or touch that did not before they were
        smoothed (unless ``self_intersection="ignore"``). Where no steps were taken back for that
        (``report.taken_back``), no quality k falls below 0.2 that has not been there. No label is lost.

        Examples
        --------
        >>> import pyvista as pv
        >>> frog = pv.read(pv.examples.frogtissuesfile).extract_subset((200, 240, 170, 210, 50, 80))
        >>> surface = frog.vtksmooth.segmentation_surface()
        >>> surface.is_all_triangles, surface["BoundaryLabels"].shape[1]
        (True, 2)
        """
