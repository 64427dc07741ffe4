"""Every scheme with its usual parameters, for tests of what holds for each of them."""

from vtksmooth.kernels.smoothing.schemes.angle_based import AngleBased
from vtksmooth.kernels.smoothing.schemes.angle_weighted import AngleWeighted
from vtksmooth.kernels.smoothing.schemes.area_weighted import AreaWeighted
from vtksmooth.kernels.smoothing.schemes.cotangent import Cotangent
from vtksmooth.kernels.smoothing.schemes.equilateral import Equilateral
from vtksmooth.kernels.smoothing.schemes.feature_preserving import FeaturePreserving
from vtksmooth.kernels.smoothing.schemes.implicit import Implicit
from vtksmooth.kernels.smoothing.schemes.low_pass import LowPass
from vtksmooth.kernels.smoothing.schemes.optimal_delaunay import OptimalDelaunay
from vtksmooth.kernels.smoothing.schemes.scale_dependent import ScaleDependent
from vtksmooth.kernels.smoothing.schemes.taubin import Taubin
from vtksmooth.kernels.smoothing.schemes.thin_plate import ThinPlate
from vtksmooth.kernels.smoothing.schemes.trapezium import TrapeziumDrawing
from vtksmooth.kernels.smoothing.schemes.umbrella import Umbrella
from vtksmooth.kernels.smoothing.weights import Weights

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
    "feature-preserving": FeaturePreserving(),
    "low-pass": LowPass(),
    "implicit": Implicit(Weights("scale-dependent"), 4.0),
    "implicit thin plate": Implicit(Weights(), 2.0, thin_plate=True),
}
