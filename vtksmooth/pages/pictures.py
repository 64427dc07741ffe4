"""Pictures of meshes without a window, drawn in a process of its own.

Without a usable OpenGL, VTK may end the process with a segmentation fault; hence the other process, which
gets the meshes on its standard input and gives PNG files on its standard output.
"""

from __future__ import annotations

import io
import json
import os
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import IO, Any

import numpy as np
import numpy.typing as npt

from ..errors import VtksmoothError
from ..filters.arrays import surface_of

#: One colour for each of the papers' bins, dark for poor (matplotlib's magma); inverted faces stand out.
COLOURS = ("#3b0f70", "#8c2981", "#de4968", "#fe9f6d", "#fcfdbf")
INVERTED = "#00c8c8"

#: Above this many faces, edges would cover the colours.
_FACES_WITH_EDGES = 20_000

_WITHOUT = (
    "drawing without a window does not work here (on Debian and Ubuntu it needs the packages libegl1 and "
    "libgl1)"
)


class NoPicturesError(VtksmoothError):
    """Pictures cannot be drawn here."""


@dataclass(frozen=True)
class Camera:
    """Where to look from, and how much of the model's space the picture shows."""

    position: tuple[float, ...]
    focal_point: tuple[float, ...]
    up: tuple[float, ...]
    width: float
    height: float


@dataclass(frozen=True)
class Picture:
    """What to draw: a mesh coloured by k of its faces, seen by a camera.

    Attributes
    ----------
    mesh : vtkPolyData
        With the cell array ``AspectRatio``.
    camera : Camera
    size : int
        Length of the picture's longer side, pixels.
    """

    mesh: Any
    camera: Camera
    size: int = 1200


def camera_of(mesh: Any) -> Camera:
    """Look obliquely at the mesh's broad side, so that it fills the frame."""
    faces = surface_of(mesh).mesh
    points = faces.points[faces.used_points]
    points = points[np.isfinite(points).all(axis=1)]
    centred = points - points.mean(axis=0)
    right, up, towards = np.linalg.eigh(centred.T @ centred)[1].T[::-1]
    if towards[np.abs(towards).argmax()] < 0:
        towards = -towards
    tilt = np.radians(35.0)
    towards, up = (
        np.cos(tilt) * towards - np.sin(tilt) * up,
        np.cos(tilt) * up + np.sin(tilt) * towards,
    )
    right = np.cross(up, towards)
    frame = points @ np.stack((right, up, towards)).T
    low, high = frame.min(axis=0), frame.max(axis=0)
    centre = np.stack((right, up, towards)).T @ ((low + high) / 2)
    extent = (high - low).max() or 1.0
    width, height, depth = (float(x) for x in 1.04 * np.maximum(high - low, 1e-3 * extent))
    position = centre + towards * (depth + width + height)
    return Camera(_tuple(position), _tuple(centre), _tuple(up), width, height)


def _tuple(vector: npt.NDArray[np.float64]) -> tuple[float, ...]:
    return tuple(float(x) for x in vector)


def draw(pictures: Sequence[Picture]) -> list[bytes]:
    """Draw pictures; return each as a PNG file's content.

    Raises
    ------
    NoPicturesError
        There is no usable OpenGL here, or drawing failed.
    """
    environment = dict(os.environ)
    if sys.platform == "linux" and not environment.get("DISPLAY"):
        # VTK looks for an X server first and complains when there is none.
        environment.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")
    done = subprocess.run(
        [sys.executable, "-P", "-m", __name__, str(os.getpid())],
        input=_packed(pictures), env=environment, capture_output=True, check=False,
    )  # fmt: skip
    if done.returncode < 0:
        raise NoPicturesError(_WITHOUT)
    drawn = list(_unpacked(io.BytesIO(done.stdout)))
    if done.returncode or len(drawn) != len(pictures):
        said = done.stderr.decode(errors="replace").strip().splitlines()
        raise NoPicturesError(said[-1] if said else "drawing failed")
    return drawn


def _packed(pictures: Sequence[Picture]) -> bytes:
    arrays: dict[str, Any] = {}
    for i, picture in enumerate(pictures):
        surface = surface_of(picture.mesh)
        mesh = surface.mesh
        arrays |= {
            # Points that no face uses need not be finite, but bounds must.
            f"points{i}": np.nan_to_num(mesh.points, nan=0.0, posinf=0.0, neginf=0.0),
            f"offsets{i}": mesh.offsets,
            f"connectivity{i}": mesh.connectivity,
            f"k{i}": np.asarray(picture.mesh.GetCellData().GetArray("AspectRatio"))[surface.cells],
            f"view{i}": json.dumps({"camera": asdict(picture.camera), "size": picture.size}),
        }
    buffer = io.BytesIO()
    np.savez(buffer, **arrays)
    return buffer.getvalue()


def _unpacked(stream: IO[bytes]) -> Any:
    while head := stream.read(8):
        yield stream.read(struct.unpack("<q", head)[0])


# -- in the other process --------------------------------------------------------------------------


def _end_with(parent: int) -> None:
    """End this process when the one that wants the pictures has ended, however it did."""

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(0.2)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


def _draw_all(source: IO[bytes], target: IO[bytes]) -> None:
    import pyvista as pv

    arrays = np.load(io.BytesIO(source.read()))
    for i in range(len(arrays.files) // 5):
        mesh = pv.PolyData()
        mesh.points = arrays[f"points{i}"]
        mesh.SetPolys(pv.CellArray.from_arrays(arrays[f"offsets{i}"], arrays[f"connectivity{i}"]))
        mesh.cell_data["k"] = arrays[f"k{i}"]
        view = json.loads(str(arrays[f"view{i}"]))
        png = _render(mesh, Camera(**view["camera"]), view["size"])
        target.write(struct.pack("<q", len(png)) + png)


def _render(mesh: Any, camera: Camera, size: int) -> bytes:
    import pyvista as pv

    scale = size / max(camera.width, camera.height)
    window = [max(int(scale * length), size // 4) for length in (camera.width, camera.height)]
    plotter = pv.Plotter(off_screen=True, window_size=window)
    plotter.set_background("white")
    plotter.add_mesh(
        mesh, scalars="k", preference="cell", cmap=list(COLOURS), clim=(0.0, 1.0),
        below_color=INVERTED, show_scalar_bar=False, ambient=0.65, diffuse=0.4, specular=0.0,
        show_edges=mesh.n_cells <= _FACES_WITH_EDGES, edge_color="#202020", line_width=1.5,
    )  # fmt: skip
    plotter.enable_parallel_projection()
    view = plotter.camera
    view.position, view.focal_point, view.up = camera.position, camera.focal_point, camera.up
    view.parallel_scale = camera.height / 2
    plotter.reset_camera_clipping_range()
    plotter.enable_anti_aliasing("ssaa")
    buffer = io.BytesIO()
    plotter.screenshot(buffer, return_img=False)
    plotter.close()
    return buffer.getvalue()


if __name__ == "__main__":
    if sys.platform != "win32":  # where a launcher may stand between the two
        _end_with(int(sys.argv[1]))
    _draw_all(sys.stdin.buffer, sys.stdout.buffer)
