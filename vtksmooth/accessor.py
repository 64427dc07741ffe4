"""``mesh.vtksmooth``: the filters as methods of ``pyvista.PolyData``.

PyVista finds the accessor by itself when the package is installed. The methods are made from the
filters' parameter declarations.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable
from contextlib import nullcontext
from typing import Any

import pyvista as pv
from pyvista.core.utilities.observers import ProgressMonitor

from .filters import FILTERS, Filter


def method_name(cls: type[Filter]) -> str:
    """Return the name of a filter's method: TrapeziumDrawing becomes trapezium_drawing."""
    return re.sub(r"(?<!^)(?=[A-Z])", "_", cls.__name__).lower()


def _method(cls: type[Filter]) -> Callable[..., Any]:
    name = method_name(cls)
    others = cls.inputs[1:]
    # What else a filter makes is returned on demand: return_lines=True.
    further = [f"return_{output}" for output in cls.outputs[1:]]

    def method(
        self: VtksmoothAccessor,
        *meshes: Any,
        inplace: bool = False,
        progress_bar: bool = False,
        **parameters: Any,
    ) -> Any:
        given = [*meshes, *(parameters.pop(other) for other in others[len(meshes) :] if other in parameters)]
        if len(given) != len(others):
            raise TypeError(
                f"{name}() takes {len(others)} meshes besides its own: {', '.join(others) or 'none'}"
            )
        wanted = [True, *(parameters.pop(name, False) for name in further)]
        outputs = _apply(cls(**parameters), self._mesh, given, inplace, progress_bar)
        returned = tuple(output for output, want in zip(outputs, wanted, strict=True) if want)
        return returned if len(returned) > 1 else returned[0]

    kind = inspect.Parameter
    method.__name__, method.__qualname__ = name, f"VtksmoothAccessor.{name}"
    # The filter's example shows the filter; this class shows the method.
    method.__doc__ = (cls.__doc__ or "").partition("    Examples\n")[0].rstrip() + "\n"
    method.__signature__ = inspect.Signature(  # type: ignore[attr-defined]
        [
            kind("self", kind.POSITIONAL_OR_KEYWORD),
            *(kind(other, kind.POSITIONAL_OR_KEYWORD) for other in others),
            *(
                kind(p.name, kind.KEYWORD_ONLY, default=p.default, annotation=p.type)
                for p in cls.parameters().values()
            ),
            *(kind(name, kind.KEYWORD_ONLY, default=False, annotation=bool) for name in further),
            kind("inplace", kind.KEYWORD_ONLY, default=False, annotation=bool),
            kind("progress_bar", kind.KEYWORD_ONLY, default=False, annotation=bool),
        ],
        return_annotation=pv.PolyData,
    )
    return method


def _apply(
    algorithm: Filter, mesh: Any, others: list[Any], inplace: bool, progress_bar: bool
) -> list[pv.PolyData]:
    with ProgressMonitor(algorithm, type(algorithm).__name__) if progress_bar else nullcontext():
        algorithm(mesh, *others)
    results = []
    for port in range(len(algorithm.outputs)):
        result = pv.PolyData()
        result.shallow_copy(algorithm.GetOutput(port))
        results.append(result)
    if inplace:
        mesh.copy_from(results[0], deep=False)
        results[0] = mesh
    return results


@pv.register_dataset_accessor("vtksmooth", pv.PolyData)
class VtksmoothAccessor:
    """The filters of vtksmooth on a mesh: ``mesh.vtksmooth.trapezium_drawing(iterations=5)``.

    Each method takes the filter's parameters as keywords and returns a new ``pyvista.PolyData``
    (``inplace=True``: changes the mesh and returns it; ``progress_bar=True``: shows progress). What a
    filter makes beside the mesh is returned on demand (``return_lines=True``), all in a tuple.
    What a filter reports is in the result's field data; a mesh that cannot be worked on raises
    :class:`~vtksmooth.errors.InvalidMeshError`.

    Examples
    --------
    >>> import pyvista as pv
    >>> ant = pv.read(pv.examples.antfile)
    >>> better = ant.vtksmooth.trapezium_drawing(iterations=5)
    >>> better.n_points == ant.n_points
    True
    """

    def __init__(self, mesh: pv.PolyData) -> None:
        self._mesh = mesh


for _filter in FILTERS:
    setattr(VtksmoothAccessor, method_name(_filter), _method(_filter))
