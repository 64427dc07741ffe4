"""Every scheme with its usual parameters, for tests of what holds for each of them."""

from vtksmooth.kernels.laplacian import Weights
from vtksmooth.kernels.schemes.angle_based import AngleBased
from vtksmooth.kernels.schemes.angle_weighted import AngleWeighted
from vtksmooth.kernels.schemes.area_weighted import AreaWeighted
from vtksmooth.kernels.schemes.cotangent import Cotangent
from vtksmooth.kernels.schemes.equilateral import Equilateral
from vtksmooth.kernels.schemes.implicit import Implicit
from vtksmooth.kernels.schemes.optimal_delaunay import OptimalDelaunay
from vtksmooth.kernels.schemes.scale_dependent import ScaleDependent
from vtksmooth.kernels.schemes.taubin import Taubin
from vtksmooth.kernels.schemes.thin_plate import ThinPlate
from vtksmooth.kernels.schemes.trapezium import TrapeziumDrawing
from vtksmooth.kernels.schemes.umbrella import Umbrella

SCHEMES = {
    "umbrella": Umbrella(),
    "scale-dependent": ScaleDependent(),
    "cotangent": Cotangent(),
    "thin-plate": ThinPlate(),
    "taubin": Taubin(),
    "trapezium-drawing": TrapeziumDrawing(),
    "angle-based": AngleBased(),
    "weighted angle-based": AngleBased(weighted=True),
    "area-weighted": AreaWeighted(),
    "angle-weighted": AngleWeighted(),
    "odt": OptimalDelaunay(),
    "equilateral": Equilateral(),
    "implicit": Implicit(Weights("scale-dependent"), 4.0),
    "implicit thin plate": Implicit(Weights(), 2.0, thin_plate=True),
}
