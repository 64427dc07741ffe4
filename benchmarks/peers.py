"""What is timed: one class for each way of smoothing, all called alike.

A case is prepared from arrays (not timed), gets a fresh input before each run (not timed), and runs a number
of iterations (timed, set-up included). Imports happen when a case is made, so that a tool that is missing
is found missing.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]

#: Dihedral angle, degrees, above which the tools that can keep features are told to.
CREASE = 30.0


class Case:
    """One way of smoothing one mesh."""

    #: Bytes of the output's coordinates for a vertex, or 0 where the tool works in place.
    output_bytes = 24
    #: What the last run really did, where the tool tells.
    iterations_done: int | None = None

    def __init__(self, points: Float64, faces: Int32) -> None:
        self.native: Any = None

    def fresh(self) -> Any:
        """Return an input that no run has touched."""
        return self.native

    def run(self, native: Any, iterations: int) -> Any:
        """Smooth, and return the result in the tool's own form."""
        raise NotImplementedError

    def points(self, result: Any) -> Float64:
        """Return the result's points in the input's order."""
        raise NotImplementedError


def _polydata(points: Float64, faces: Int32) -> Any:
    import pyvista as pv

    return pv.PolyData.from_regular_faces(points, faces)


# -- ours ------------------------------------------------------------------------------------------


def ours(name: str, **parameters: Any) -> type[Case]:
    """Return the case of one of our filters."""

    class Ours(Case):
        def __init__(self, points: Float64, faces: Int32) -> None:
            import vtksmooth

            self.filter = getattr(vtksmooth, name)(**parameters)
            self.native = _polydata(points, faces)

        def run(self, native: Any, iterations: int) -> Any:
            self.filter.iterations = iterations
            self.filter.Modified()
            result = self.filter(native)
            self.iterations_done = self.filter.report.iterations
            return result

        def points(self, result: Any) -> Float64:
            from vtkmodules.util.numpy_support import vtk_to_numpy

            return np.asarray(vtk_to_numpy(result.GetPoints().GetData()), dtype=float)

    return Ours


# -- VTK and PyVista -------------------------------------------------------------------------------


class _Vtk(Case):
    def __init__(self, points: Float64, faces: Int32) -> None:
        import os

        from vtkmodules.vtkCommonCore import vtkSMPTools

        # VTK's wheels run sequentially unless told otherwise.
        if len(os.sched_getaffinity(0)) > 1:
            vtkSMPTools.SetBackend("STDThread")
        self.native = _polydata(points, faces)
        self.filter = self.make()

    def make(self) -> Any:
        raise NotImplementedError

    def run(self, native: Any, iterations: int) -> Any:
        self.filter.SetInputData(native)
        self.filter.SetNumberOfIterations(iterations)
        self.filter.Modified()
        self.filter.Update()
        return self.filter.GetOutput()

    def points(self, result: Any) -> Float64:
        from vtkmodules.util.numpy_support import vtk_to_numpy

        return np.asarray(vtk_to_numpy(result.GetPoints().GetData()), dtype=float)


class VtkSmooth(_Vtk):
    """vtkSmoothPolyDataFilter with the relaxation of our umbrella."""

    def make(self) -> Any:
        """Return the filter."""
        from vtkmodules.vtkFiltersCore import vtkSmoothPolyDataFilter

        smoothing = vtkSmoothPolyDataFilter()
        smoothing.SetRelaxationFactor(0.5)
        smoothing.SetConvergence(0.0)
        return smoothing


class VtkSmoothGently(VtkSmooth):
    """vtkSmoothPolyDataFilter with a relaxation that leaves good elements after 50 iterations."""

    def make(self) -> Any:
        """Return the filter."""
        smoothing = super().make()
        smoothing.SetRelaxationFactor(0.1)
        return smoothing


class VtkSmoothOnSource(VtkSmoothGently):
    """The same, points put back on the input."""

    def make(self) -> Any:
        """Return the filter."""
        smoothing = super().make()
        smoothing.SetSourceData(self.native)
        return smoothing


class VtkSmoothFeatures(VtkSmoothOnSource):
    """The same, feature edges kept, with VTK's own relaxation: a larger one inverts faces."""

    def make(self) -> Any:
        """Return the filter."""
        smoothing = super().make()
        smoothing.SetRelaxationFactor(0.01)
        smoothing.SetFeatureEdgeSmoothing(True)
        smoothing.SetFeatureAngle(CREASE)
        return smoothing


class VtkWindowedSinc(_Vtk):
    """vtkWindowedSincPolyDataFilter."""

    def make(self) -> Any:
        """Return the filter."""
        from vtkmodules.vtkFiltersCore import vtkWindowedSincPolyDataFilter

        smoothing = vtkWindowedSincPolyDataFilter()
        smoothing.SetPassBand(0.1)
        smoothing.NormalizeCoordinatesOn()
        return smoothing


class PyVistaSmooth(_Vtk):
    """pyvista.PolyData.smooth."""

    def make(self) -> Any:
        """Return nothing: PyVista makes its own."""

    def run(self, native: Any, iterations: int) -> Any:
        """Smooth."""
        return native.smooth(n_iter=iterations, relaxation_factor=0.5)


class PyVistaTaubin(PyVistaSmooth):
    """pyvista.PolyData.smooth_taubin."""

    def run(self, native: Any, iterations: int) -> Any:
        """Smooth."""
        return native.smooth_taubin(n_iter=iterations, pass_band=0.1)


# -- others ----------------------------------------------------------------------------------------


class MeshLibRelax(Case):
    """MeshLib's relax: float32, in place."""

    output_bytes = 0
    function = "relax"

    def __init__(self, points: Float64, faces: Int32) -> None:
        from meshlib import mrmeshnumpy, mrmeshpy

        self.library, self.numpy = mrmeshpy, mrmeshnumpy
        self.native = mrmeshnumpy.meshFromFacesVerts(faces, points)

    def fresh(self) -> Any:
        """Return a copy: relaxing is in place."""
        return self.library.Mesh(self.native)

    def run(self, native: Any, iterations: int) -> Any:
        """Relax in place."""
        getattr(self.library, self.function)(native, self.settings(iterations))
        return native

    def settings(self, iterations: int) -> Any:
        """Return the settings of a run."""
        settings = self.library.MeshRelaxParams()
        settings.iterations = iterations
        settings.force = 0.5
        return settings

    def points(self, result: Any) -> Float64:
        """Return the points."""
        return np.asarray(self.numpy.getNumpyVerts(result), dtype=float)


class MeshLibRelaxKeepVolume(MeshLibRelax):
    """MeshLib's relaxKeepVolume."""

    function = "relaxKeepVolume"


class MeshLibRelaxKeepVolumeCreases(MeshLibRelax):
    """MeshLib's relaxKeepVolume with the vertices of creases held."""

    function = "relaxKeepVolume"

    def __init__(self, points: Float64, faces: Int32) -> None:
        super().__init__(points, faces)
        mesh = _polydata(points, faces)
        mesh["number"] = np.arange(len(points))
        free = np.ones(len(points), bool)
        free[mesh.extract_feature_edges(CREASE, manifold_edges=False)["number"]] = False
        self.free = self.numpy.vertBitSetFromBools(free)

    def settings(self, iterations: int) -> Any:
        """Return the settings of a run."""
        settings = super().settings(iterations)
        settings.region = self.free
        return settings


class MmgsMoves(Case):
    """mmgs that may move points only: it does as many sweeps as it sees fit."""

    def __init__(self, points: Float64, faces: Int32) -> None:
        import mmgpy

        self.library = mmgpy
        self.arrays = (points, faces)

    def fresh(self) -> Any:
        """Return a mesh."""
        return self.library.MmgMeshS(*self.arrays)

    def run(self, native: Any, iterations: int) -> Any:
        """Move points."""
        native.remesh(noinsert=1, noswap=1, ar=CREASE, verbose=-1)
        return native

    def points(self, result: Any) -> Float64:
        """Return the points."""
        return np.asarray(result.get_vertices(), dtype=float)


class MeshLabLaplacian(Case):
    """pymeshlab's Laplacian smoothing, equal weights, in place."""

    output_bytes = 0

    def __init__(self, points: Float64, faces: Int32) -> None:
        import pymeshlab

        self.library = pymeshlab
        self.arrays = (points, faces)

    def fresh(self) -> Any:
        """Return a mesh set with the mesh."""
        meshes = self.library.MeshSet()
        meshes.add_mesh(self.library.Mesh(*self.arrays))
        return meshes

    def run(self, native: Any, iterations: int) -> Any:
        """Smooth in place."""
        native.apply_coord_laplacian_smoothing(stepsmoothnum=iterations, cotangentweight=False)
        return native

    def points(self, result: Any) -> Float64:
        """Return the points."""
        return np.asarray(result.current_mesh().vertex_matrix(), dtype=float)


class MeshLabTaubin(MeshLabLaplacian):
    """pymeshlab's Taubin smoothing."""

    def run(self, native: Any, iterations: int) -> Any:
        """Smooth in place."""
        native.apply_coord_taubin_smoothing(stepsmoothnum=iterations)
        return native


class MeshLabIsotropic(MeshLabLaplacian):
    """pymeshlab's isotropic remeshing that may only smooth and put points back on the input."""

    def run(self, native: Any, iterations: int) -> Any:
        """Smooth in place."""
        native.meshing_isotropic_explicit_remeshing(
            iterations=iterations, featuredeg=CREASE, checksurfdist=False,
            splitflag=False, collapseflag=False, swapflag=False,
        )  # fmt: skip
        return native


class TrimeshLaplacian(Case):
    """trimesh's Laplacian, which keeps the volume by scaling; in place."""

    output_bytes = 0
    function = "filter_laplacian"

    def __init__(self, points: Float64, faces: Int32) -> None:
        import trimesh

        self.library = trimesh
        self.native = trimesh.Trimesh(points, faces, process=False)

    def fresh(self) -> Any:
        """Return a copy."""
        return self.library.Trimesh(self.native.vertices.copy(), self.native.faces.copy(), process=False)

    def run(self, native: Any, iterations: int) -> Any:
        """Smooth in place."""
        return getattr(self.library.smoothing, self.function)(native, iterations=iterations)

    def points(self, result: Any) -> Float64:
        """Return the points."""
        return np.asarray(result.vertices, dtype=float)


class TrimeshTaubin(TrimeshLaplacian):
    """trimesh's Taubin."""

    function = "filter_taubin"


class TrimeshHumphrey(TrimeshLaplacian):
    """trimesh's Humphrey."""

    function = "filter_humphrey"


class Open3DLaplacian(Case):
    """Open3D's Laplacian."""

    #: Coordinates, and copies of triangles (12 bytes each, two for a vertex).
    output_bytes = 48

    def __init__(self, points: Float64, faces: Int32) -> None:
        import open3d

        vector = open3d.utility
        self.native = open3d.geometry.TriangleMesh(
            vector.Vector3dVector(points), vector.Vector3iVector(faces)
        )

    def run(self, native: Any, iterations: int) -> Any:
        """Smooth."""
        return native.filter_smooth_laplacian(number_of_iterations=iterations, lambda_filter=0.5)

    def points(self, result: Any) -> Float64:
        """Return the points."""
        return np.asarray(result.vertices, dtype=float)


class Open3DTaubin(Open3DLaplacian):
    """Open3D's Taubin."""

    def run(self, native: Any, iterations: int) -> Any:
        """Smooth."""
        return native.filter_smooth_taubin(number_of_iterations=iterations)


# -- the list --------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Tool:
    """An entry of the benchmark.

    Attributes
    ----------
    make : callable
        Makes the case from points (n, 3) float64 and triangles (m, 3) int32.
    package : str
        Distribution it comes from.
    threads : bool
        Whether it uses more than one thread at all; others are run on one only.
    prime : bool
        Whether every combination is run at the large sizes too.
    """

    make: Callable[[Float64, Int32], Case]
    package: str
    threads: bool = True
    prime: bool = False


TOOLS: dict[str, Tool] = {
    "TD": Tool(ours("TrapeziumDrawing"), "vtksmooth", prime=True),
    "umbrella": Tool(ours("LaplacianSmoothing"), "vtksmooth", prime=True),
    "scale-dependent": Tool(ours("LaplacianSmoothing", scheme="scale-dependent"), "vtksmooth"),
    "cotangent": Tool(ours("LaplacianSmoothing", scheme="cotangent"), "vtksmooth"),
    "thin plate": Tool(ours("LaplacianSmoothing", scheme="thin-plate"), "vtksmooth"),
    "Taubin": Tool(ours("LaplacianSmoothing", scheme="taubin"), "vtksmooth"),
    "smart Laplacian": Tool(ours("LaplacianSmoothing", gate="angle"), "vtksmooth"),
    "angle-based": Tool(ours("AngleBasedSmoothing"), "vtksmooth"),
    "weighted angle-based": Tool(ours("AngleBasedSmoothing", weighted=True), "vtksmooth"),
    "BDS": Tool(ours("BackToSurfaceSmoothing"), "vtksmooth"),
    "vtkSmoothPolyDataFilter": Tool(VtkSmooth, "vtk", threads=False, prime=True),
    "vtkWindowedSincPolyDataFilter": Tool(VtkWindowedSinc, "vtk", prime=True),
    "pyvista smooth": Tool(PyVistaSmooth, "pyvista", threads=False),
    "pyvista smooth_taubin": Tool(PyVistaTaubin, "pyvista"),
    "MeshLib relax": Tool(MeshLibRelax, "meshlib", prime=True),
    "MeshLib relaxKeepVolume": Tool(MeshLibRelaxKeepVolume, "meshlib"),
    "MeshLab Laplacian": Tool(MeshLabLaplacian, "pymeshlab", threads=False),
    "MeshLab Taubin": Tool(MeshLabTaubin, "pymeshlab", threads=False),
    "trimesh Laplacian": Tool(TrimeshLaplacian, "trimesh", threads=False),
    "trimesh Taubin": Tool(TrimeshTaubin, "trimesh", threads=False),
    "trimesh Humphrey": Tool(TrimeshHumphrey, "trimesh", threads=False),
    "Open3D Laplacian": Tool(Open3DLaplacian, "open3d"),
    "Open3D Taubin": Tool(Open3DTaubin, "open3d"),
}

#: Ways to better elements that keep to the surface: tool, package, and whether it is made to keep features.
KEEPING: dict[str, tuple[type[Case], str, bool]] = {
    "vtkSmooth, features + Source": (VtkSmoothFeatures, "vtk", True),
    "MeshLab isotropic, smooth + reproject only": (MeshLabIsotropic, "pymeshlab", True),
    "mmgs, moves only": (MmgsMoves, "mmgpy", True),
    "MeshLib relaxKeepVolume, creases held": (MeshLibRelaxKeepVolumeCreases, "meshlib", True),
    "vtkSmooth + Source": (VtkSmoothOnSource, "vtk", False),
    "vtkSmooth": (VtkSmoothGently, "vtk", False),
}
