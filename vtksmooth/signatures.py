"""The list of the kernels that each filter needs, which are compiled ahead: made by running the filters.

``python -m vtksmooth.signatures`` writes it anew.
"""

from __future__ import annotations

import json
import subprocess
import sys
from typing import Any

from vtkmodules.vtkFiltersSources import vtkSphereSource

from .filters import FILTERS
from .jit.compile_ahead import PATH, noted
from .warm_up import bump, space_over

#: The side of the mesh, in points.
_SIZE = 6


def needed(name: str) -> list[list[str]]:
    """Return the kernels that a filter needs by default: modules, names, types of arguments.

    On triangles, closed and open, or where it needs none for these on polygons; in the order of their first
    use; and only those that this process has not used before.
    """
    cls = next(cls for cls in FILTERS if cls.__name__ == name)
    with noted() as found:
        ball = vtkSphereSource(center=(2.0, 2.0, 0.0))
        ball.Update()
        for mesh in ball.GetOutput(), bump(_SIZE, "triangles"), bump(_SIZE, "mixed"):
            if mesh.GetMaxCellSize() == 3 or not found:
                cls()(*(space_over(_SIZE) if name == "installation" else mesh for name in cls.inputs))
    return found


def listed() -> dict[str, Any]:
    """Return the list: the kernels, and for each filter the numbers of those it needs, in order."""
    kernels: list[list[str]] = []
    filters: dict[str, list[int]] = {}
    for cls in FILTERS:
        command = [sys.executable, "-m", f"{__package__}.signatures", cls.__name__]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
        used = json.loads(done.stdout)
        kernels += [kernel for kernel in used if kernel not in kernels]
        filters[cls.__name__] = [kernels.index(kernel) for kernel in used]
    return {"kernels": kernels, "filters": filters}


if __name__ == "__main__":
    if len(sys.argv) > 1:
        print(json.dumps(needed(sys.argv[1])))
    else:
        PATH.write_text(json.dumps(listed(), indent=0) + "\n", encoding="utf-8")
        print(PATH)
