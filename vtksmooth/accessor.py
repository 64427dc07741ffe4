"""``mesh.vtksmooth``, ``image.vtksmooth``: the filters as methods of PyVista's datasets.

PyVista finds the accessor by itself when the package is installed. The methods are made from the
filters' parameter declarations; so is ``accessor.pyi``, which type checkers and editors read, by
``python -m vtksmooth.accessor_stub``.
"""

from __future__ import annotations

import inspect
import re
import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from typing import Any

import numpy as np
import pyvista as pv
from vtkmodules.vtkFiltersGeometry import vtkDataSetSurfaceFilter

from .filters import FILTERS, INPUTS, OF_IMAGES, Filter
from .filters.point_lists import format_selection, parse_selection

#: Length of the progress bar, letters.
_BAR = 30

#: An example for each method; they follow on ``import pyvista as pv``.
_EXAMPLES = {
    "surface_quality": """
>>> ant = pv.read(pv.examples.antfile)
>>> k = ant.vtksmooth.surface_quality()["AspectRatio"]
>>> len(k) == ant.n_cells, bool(k.max() <= 1.0)
(True, True)
""",
    "surface_comparison": """
>>> ant = pv.read(pv.examples.antfile)
>>> better = ant.vtksmooth.trapezium_drawing(max_deviation_fraction=0.001)
>>> difference = better.vtksmooth.surface_comparison(ant)
>>> bool(difference["Deviation"].max() <= 0.02 * ant.length)
True
""",
    "feature_detection": """
>>> cylinder = pv.Cylinder(resolution=36).triangulate().clean()
>>> found, lines = cylinder.vtksmooth.feature_detection(return_lines=True)
>>> int((found["FeatureClass"] == 1).sum()), lines.n_lines
(72, 2)
""",
    "region_marking": """
>>> plane = pv.Plane(i_resolution=4, j_resolution=4)
>>> marked = plane.vtksmooth.region_marking(fix="0-4", grow=1, blend_rings=1)
>>> int(marked["Fixed"].sum()), int((marked["BlendWeight"] < 1.0).sum())
(10, 15)
""",
    "trapezium_drawing": """
>>> ant = pv.read(pv.examples.antfile)
>>> better = ant.vtksmooth.trapezium_drawing(iterations=5)
>>> before = ant.vtksmooth.surface_quality()["AspectRatio"].min()
>>> after = better.vtksmooth.surface_comparison(ant)["AspectRatio"].min()
>>> bool(after >= before)
True
""",
    "laplacian_smoothing": """
>>> sphere = pv.Sphere()
>>> sphere.vtksmooth.laplacian_smoothing(iterations=20).volume < 0.8 * sphere.volume
True
>>> taubin = sphere.vtksmooth.laplacian_smoothing(iterations=20, scheme="taubin")
>>> abs(taubin.volume / sphere.volume - 1.0) < 0.02
True
""",
    "feature_preserving_denoising": """
>>> import numpy as np
>>> cube = pv.Box(level=15).triangulate().clean()
>>> cube.points += np.random.default_rng(1).normal(0.0, 0.01, cube.points.shape)
>>> better = cube.vtksmooth.feature_preserving_denoising(output_points_precision="double")
>>> abs(better.volume / cube.volume - 1.0) < 1e-12
True
""",
    "angle_based_smoothing": """
>>> disk = pv.Disc(r_res=4, c_res=12).triangulate()
>>> better = disk.vtksmooth.angle_based_smoothing(weighted=True, gate="aspect")
>>> better.n_points == disk.n_points
True
""",
    "back_to_surface_smoothing": """
>>> ant = pv.read(pv.examples.antfile)
>>> better = ant.vtksmooth.back_to_surface_smoothing(iterations=3)
>>> distances = better.compute_implicit_distance(ant)["implicit_distance"]
>>> bool(abs(distances).max() < 1e-6 * ant.length)
True
""",
    "equilateral_smoothing": """
>>> nut = pv.read(pv.examples.nutfile)
>>> better = nut.vtksmooth.equilateral_smoothing(iterations=10)
>>> mean = [mesh.vtksmooth.surface_quality()["AspectRatio"].mean() for mesh in (nut, better)]
>>> bool(mean[1] > mean[0])
True
""",
    "null_space_smoothing": """
>>> nut = pv.read(pv.examples.nutfile)
>>> better = nut.vtksmooth.null_space_smoothing(iterations=50, output_points_precision="double")
>>> abs(better.volume / nut.volume - 1.0) < 1e-12
True
""",
    "valence_triangulation": """
>>> plane = pv.Plane(i_resolution=4, j_resolution=4)
>>> triangles = plane.vtksmooth.valence_triangulation()
>>> triangles.n_cells, triangles.is_all_triangles
(32, True)
""",
    "installation_space_regions": """
>>> space, part = pv.Cube(), pv.Cube(x_length=0.5)
>>> bool(part.vtksmooth.installation_space_regions(space)["Fixed"].all())
True
""",
    "installation_space_smoothing": """
>>> from vtksmooth import samples
>>> skin, space = samples.channel()
>>> smooth = skin.vtksmooth.installation_space_smoothing(space, iterations=3, flow="Flow")
>>> check = smooth.vtksmooth.containment_check(space)
>>> int(check.field_data["VerticesOutside"][0]), int(check.field_data["TrianglesCrossing"][0])
(0, 0)
""",
    "containment_check": """
>>> space, part = pv.Cube(), pv.Cube(x_length=0.5, y_length=0.5, z_length=1.5)
>>> check = part.vtksmooth.containment_check(space)
>>> float(check["SignedDistance"].max()), int(check.field_data["TrianglesCrossing"][0])
(0.25, 8)
""",
    "self_intersection": """
>>> pair = pv.Cube() + pv.Cube(x_length=0.5, y_length=0.5, z_length=1.5)
>>> check = pair.vtksmooth.self_intersection()
>>> int(check.field_data["CrossingPairs"][0]), check["SelfIntersection"].tolist()
(8, [0, 0, 0, 0, 2, 2, 2, 2, 2, 2, 0, 0])
""",
    "segmentation_surface": """
>>> frog = pv.read(pv.examples.frogtissuesfile).extract_subset((200, 240, 170, 210, 50, 80))
>>> surface = frog.vtksmooth.segmentation_surface()
>>> surface.is_all_triangles, surface["BoundaryLabels"].shape[1]
(True, 2)
""",
}


def method_name(cls: type[Filter]) -> str:
    """Return the name of a filter's method: TrapeziumDrawing becomes trapezium_drawing."""
    return re.sub(r"(?<!^)(?=[A-Z])", "_", cls.__name__).lower()


def _method(cls: type[Filter]) -> Callable[..., Any]:
    name = method_name(cls)
    others, optional = cls.inputs[1:], cls.optional_inputs
    of_image = cls in OF_IMAGES
    # What else a filter makes is returned on demand: return_lines=True.
    further = [f"return_{output}" for output in cls.outputs[1:]]

    def method(
        self: VtksmoothAccessor | VtksmoothImageAccessor,
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
        given += [parameters.pop(name, None) for name in optional]
        mesh = self._mesh
        if not (of_image or isinstance(mesh, pv.PolyData)):
            if inplace:
                raise TypeError(
                    f"{name}() cannot change a {type(mesh).__name__} in place; leave out inplace=True."
                )
            mesh = _surfaces(mesh, parameters)
        wanted = [True, *(parameters.pop(name, False) for name in further)]
        outputs = _apply(cls(**parameters), mesh, given, inplace, progress_bar)
        returned = tuple(output for output, want in zip(outputs, wanted, strict=True) if want)
        return returned if len(returned) > 1 else returned[0]

    kind = inspect.Parameter
    home = "VtksmoothImageAccessor" if of_image else "VtksmoothAccessor"
    method.__name__, method.__qualname__ = name, f"{home}.{name}"
    method.__doc__ = _documentation(cls)
    method.__signature__ = inspect.Signature(  # type: ignore[attr-defined]
        [
            kind("self", kind.POSITIONAL_OR_KEYWORD),
            *(kind(other, kind.POSITIONAL_OR_KEYWORD, annotation="pv.PolyData") for other in others),
            *(kind(o, kind.KEYWORD_ONLY, default=None, annotation="pv.PolyData | None") for o in optional),
            *(
                kind(p.name, kind.KEYWORD_ONLY, default=p.default, annotation=p.annotation)
                for p in cls.parameters().values()
            ),
            *(
                kind(name, kind.KEYWORD_ONLY, default=False, annotation="bool")
                for name in (*further, *([] if of_image else ["inplace"]), "progress_bar")
            ),
        ],
        return_annotation="pv.PolyData | pv.MultiBlock" if of_image else "pv.PolyData",
    )
    return method


def _documentation(cls: type[Filter]) -> str:
    """Return the method's documentation: the filter's, with the method's own parameters and example."""
    text, *parts = re.split(r"\n\n(\w+)\n-+\n", inspect.cleandoc(cls.__doc__ or ""))
    sections = dict(zip(parts[::2], parts[1::2], strict=True))
    parameters = [f"{name} : pyvista.PolyData\n    {INPUTS[name].description}" for name in cls.inputs[1:]]
    parameters += [
        f"{name} : pyvista.PolyData, optional\n    {INPUTS[name].description}" for name in cls.optional_inputs
    ]
    parameters += [sections["Parameters"]] if "Parameters" in sections else []
    returned = "The result; figures are in its field data."
    for output in cls.outputs[1:]:
        parameters.append(
            f"return_{output} : bool, default False\n    Return a tuple of the mesh and the {output}."
        )
        returned += f" With ``return_{output}`` a tuple of it and the {output}."
    if cls not in OF_IMAGES:
        parameters.append("inplace : bool, default False\n    Change the mesh itself and return it.")
    parameters.append("progress_bar : bool, default False\n    Show progress.")
    kind = "pyvista.PolyData or pyvista.MultiBlock" if cls in OF_IMAGES else "pyvista.PolyData"
    shown = {
        "Parameters": "\n".join(parameters),
        "Returns": f"{kind}\n    {returned}",
        "Guarantees": sections.get("Guarantees"),
        "Examples": f">>> import pyvista as pv{_EXAMPLES[method_name(cls)].rstrip()}",
    }
    return text + "".join(f"\n\n{name}\n{'-' * len(name)}\n{body}" for name, body in shown.items() if body)


def _apply(
    algorithm: Filter, mesh: Any, others: list[Any], inplace: bool, progress_bar: bool
) -> list[pv.PolyData]:
    with _progress_bar(algorithm) if progress_bar else nullcontext():
        algorithm(mesh, *others)
    results = []
    for port in range(len(algorithm.outputs)):
        output = algorithm.GetOutput(port)
        result = pv.wrap(output.NewInstance())
        result.ShallowCopy(output)
        if isinstance(result, pv.MultiBlock):
            result.wrap_nested()
        results.append(result)
    if inplace:
        mesh.copy_from(results[0], deep=False)
        results[0] = mesh
    return results


def _surfaces(mesh: Any, parameters: dict[str, Any]) -> Any:
    """Return the surface of a grid, or those of a MultiBlock's blocks, with a warning that says so.

    A mask or numbers in `parameters` that choose points of a grid then choose those of its surface.
    """
    if isinstance(mesh, pv.PolyData) or mesh is None:
        return mesh
    if isinstance(mesh, pv.MultiBlock):
        return pv.MultiBlock({mesh.get_block_name(i): _surfaces(mesh[i], {}) for i in range(mesh.n_blocks)})
    extraction = vtkDataSetSurfaceFilter()
    extraction.PassThroughPointIdsOn()
    extraction.PassThroughCellIdsOn()
    extraction.SetInputDataObject(mesh)
    extraction.Update()
    surface = pv.wrap(extraction.GetOutput())
    warnings.warn(
        f"The surface of the {type(mesh).__name__} is taken: {surface.n_points} of {mesh.n_points} points; "
        "vtkOriginalPointIds are their numbers.",
        stacklevel=3,
    )
    fixed = parameters.get("fixed")
    if fixed is not None and not isinstance(fixed, str):
        chosen = np.zeros(mesh.n_points, np.bool_)
        text = format_selection("fixed", fixed)
        chosen[parse_selection("fixed", text, mesh.n_points)] = True
        parameters["fixed"] = chosen[surface.point_data["vtkOriginalPointIds"]]
    return surface


@contextmanager
def _progress_bar(algorithm: Filter) -> Iterator[None]:
    # Not PyVista's, which needs tqdm, takes Ctrl-C away and gives nothing back.
    def show(*_: Any) -> None:
        done = algorithm.GetProgress()
        bar = "#" * round(_BAR * done)
        print(
            f"\r{type(algorithm).__name__} [{bar:.<{_BAR}}] {done:4.0%}", end="", file=sys.stderr, flush=True
        )

    tag = algorithm.AddObserver("ProgressEvent", show)
    try:
        yield
    finally:
        algorithm.RemoveObserver(tag)
        print(file=sys.stderr)


@pv.register_dataset_accessor("vtksmooth", pv.MultiBlock)
@pv.register_dataset_accessor("vtksmooth", pv.UnstructuredGrid)
@pv.register_dataset_accessor("vtksmooth", pv.PolyData)
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

    def __init__(self, mesh: pv.PolyData | pv.UnstructuredGrid | pv.MultiBlock) -> None:
        self._mesh = mesh


for _filter in FILTERS:
    setattr(VtksmoothAccessor, method_name(_filter), _method(_filter))


@pv.register_dataset_accessor("vtksmooth", pv.ImageData)
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

    def __init__(self, image: pv.ImageData) -> None:
        self._mesh = image


for _filter in OF_IMAGES:
    setattr(VtksmoothImageAccessor, method_name(_filter), _method(_filter))
