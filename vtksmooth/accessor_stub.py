"""The accessor's stub, which type checkers and editors read: made from the filters' declarations.

``python -m vtksmooth.accessor_stub`` writes it anew.
"""

from __future__ import annotations

import inspect
import itertools
import textwrap
from collections.abc import Iterator
from pathlib import Path

from .accessor import VtksmoothAccessor, VtksmoothImageAccessor, method_name
from .filters import FILTERS, OF_IMAGES, Filter

#: Where the stub belongs.
PATH = Path(__file__).with_name("accessor.pyi")

_HEAD = '''"""Made by ``python -m vtksmooth.accessor_stub`` from the filters' declarations; do not edit."""

from collections.abc import Sequence
from typing import Any, Literal, overload

import numpy.typing as npt
import pyvista as pv

from .filters import Filter

def method_name(cls: type[Filter]) -> str:
    """{method_name}"""

class VtksmoothAccessor:
    """{accessor}
    """

    def __init__(self, mesh: pv.PolyData | pv.UnstructuredGrid | pv.MultiBlock) -> None: ...
'''

_IMAGES = '''
class VtksmoothImageAccessor:
    """{accessor}
    """

    def __init__(self, image: pv.ImageData) -> None: ...
'''


def stub() -> str:
    """Return the stub.

    Examples
    --------
    >>> "def trapezium_drawing(" in stub()
    True
    """
    head = _HEAD.format(method_name=method_name.__doc__, accessor=(VtksmoothAccessor.__doc__ or "").rstrip())
    images = _IMAGES.format(accessor=(VtksmoothImageAccessor.__doc__ or "").rstrip())
    of_meshes, of_images = ("".join(map("".join, map(_definitions, each))) for each in (FILTERS, OF_IMAGES))
    return head + of_meshes + images + of_images


def _definitions(cls: type[Filter]) -> Iterator[str]:
    """Yield a method's definition; where flags decide what is returned, one for each choice."""
    method = getattr(VtksmoothImageAccessor if cls in OF_IMAGES else VtksmoothAccessor, method_name(cls))
    signature = inspect.signature(method)
    flags = [f"return_{output}" for output in cls.outputs[1:]]
    document = textwrap.indent(inspect.getdoc(method) or "", "    ").lstrip()
    for choice in itertools.product((False, True), repeat=len(flags)):
        chosen = dict(zip(flags, choice, strict=True))
        lines = ["@overload"] if flags else []
        lines += [f"def {method.__name__}(", "    self,"]
        keywords = False
        for parameter in list(signature.parameters.values())[1:]:
            if parameter.kind is parameter.KEYWORD_ONLY and not keywords:
                lines.append("    *,")
                keywords = True
            annotation, default = parameter.annotation, f" = {parameter.default!r}"
            if parameter.name in chosen:
                annotation = f"Literal[{chosen[parameter.name]}]"
                default = "" if chosen[parameter.name] else default
            if parameter.default is parameter.empty:
                default = ""
            lines.append(f"    {parameter.name}: {annotation}{default},")
        meshes = [str(signature.return_annotation)] * (1 + sum(choice))
        returned = meshes[0] if len(meshes) == 1 else f"tuple[{', '.join(meshes)}]"
        lines += [f") -> {returned}:", f'    """{document}\n    """', ""]
        yield "\n" + textwrap.indent("\n".join(lines), "    ")


if __name__ == "__main__":
    PATH.write_text(stub(), encoding="utf-8")
    print(PATH)
