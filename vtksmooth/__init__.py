"""Smoothing of surface meshes that keeps the surface.

The filters are VTK algorithms; they are imported when first asked for, so ``import vtksmooth`` is quick.
"""

from __future__ import annotations

import importlib
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

from .errors import Cancelled, InvalidMeshError, MeshFileError, ParameterError, RecipeError, VtksmoothError

if TYPE_CHECKING:
    from .filters import (
        AngleBasedSmoothing,
        BackToSurfaceSmoothing,
        ContainmentCheck,
        EquilateralSmoothing,
        FeatureDetection,
        FeaturePreservingDenoising,
        InstallationSpaceRegions,
        InstallationSpaceSmoothing,
        LaplacianSmoothing,
        NullSpaceSmoothing,
        RegionMarking,
        SegmentationSurface,
        SelfIntersection,
        SurfaceComparison,
        SurfaceQuality,
        TrapeziumDrawing,
        ValenceTriangulation,
    )
    from .jit.parallel import number_of_threads, set_number_of_threads
    from .recipe import Recipe, Step

__version__ = version("vtksmooth")

_HOMES = {
    "Recipe": "vtksmooth.recipe",
    "Step": "vtksmooth.recipe",
    "number_of_threads": "vtksmooth.jit.parallel",
    "set_number_of_threads": "vtksmooth.jit.parallel",
}

__all__ = [
    "AngleBasedSmoothing",
    "BackToSurfaceSmoothing",
    "Cancelled",
    "ContainmentCheck",
    "EquilateralSmoothing",
    "FeatureDetection",
    "FeaturePreservingDenoising",
    "InstallationSpaceRegions",
    "InstallationSpaceSmoothing",
    "InvalidMeshError",
    "LaplacianSmoothing",
    "MeshFileError",
    "NullSpaceSmoothing",
    "ParameterError",
    "Recipe",
    "RecipeError",
    "RegionMarking",
    "SegmentationSurface",
    "SelfIntersection",
    "Step",
    "SurfaceComparison",
    "SurfaceQuality",
    "TrapeziumDrawing",
    "ValenceTriangulation",
    "VtksmoothError",
    "number_of_threads",
    "set_number_of_threads",
]


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module 'vtksmooth' has no attribute {name!r}")
    return getattr(importlib.import_module(_HOMES.get(name, "vtksmooth.filters")), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
