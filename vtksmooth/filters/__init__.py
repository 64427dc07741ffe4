"""VTK filters: pipelines outside, arrays inside. One filter, one file."""

from __future__ import annotations

from .angle_based_smoothing import AngleBasedSmoothing
from .back_to_surface_smoothing import BackToSurfaceSmoothing
from .base import INPUTS, Filter
from .containment_check import ContainmentCheck
from .equilateral_smoothing import EquilateralSmoothing
from .feature_detection import FeatureDetection
from .feature_preserving_denoising import FeaturePreservingDenoising
from .installation_space_regions import InstallationSpaceRegions
from .installation_space_smoothing import InstallationSpaceSmoothing
from .laplacian_smoothing import LaplacianSmoothing
from .null_space_smoothing import NullSpaceSmoothing
from .parameter import Parameter
from .region_marking import RegionMarking
from .segmentation_surface import SegmentationSurface
from .self_intersection import SelfIntersection
from .smoothing import SmoothingFilter
from .surface_comparison import SurfaceComparison
from .surface_quality import SurfaceQuality
from .trapezium_drawing import TrapeziumDrawing
from .valence_triangulation import ValenceTriangulation

#: All filters, in the order of the documentation.
FILTERS: tuple[type[Filter], ...] = (
    SurfaceQuality,
    SurfaceComparison,
    FeatureDetection,
    RegionMarking,
    TrapeziumDrawing,
    LaplacianSmoothing,
    FeaturePreservingDenoising,
    AngleBasedSmoothing,
    BackToSurfaceSmoothing,
    EquilateralSmoothing,
    NullSpaceSmoothing,
    ValenceTriangulation,
    InstallationSpaceRegions,
    InstallationSpaceSmoothing,
    ContainmentCheck,
    SelfIntersection,
)

#: Filters that make a surface of an image.
OF_IMAGES: tuple[type[Filter], ...] = (SegmentationSurface,)

__all__ = [
    "FILTERS",
    "INPUTS",
    "OF_IMAGES",
    "AngleBasedSmoothing",
    "BackToSurfaceSmoothing",
    "ContainmentCheck",
    "EquilateralSmoothing",
    "FeatureDetection",
    "FeaturePreservingDenoising",
    "Filter",
    "InstallationSpaceRegions",
    "InstallationSpaceSmoothing",
    "LaplacianSmoothing",
    "NullSpaceSmoothing",
    "Parameter",
    "RegionMarking",
    "SegmentationSurface",
    "SelfIntersection",
    "SmoothingFilter",
    "SurfaceComparison",
    "SurfaceQuality",
    "TrapeziumDrawing",
    "ValenceTriangulation",
]
