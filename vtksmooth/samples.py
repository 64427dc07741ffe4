"""Samples to smooth: a channel in an installation space, made of cells; and skins of voxels.

What they should look like without the noise is known, so that results can be measured. Nothing here uses
the rest of the package. ``python -m vtksmooth.samples FOLDER`` writes them as files.
"""

from __future__ import annotations

import sys
from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pyvista as pv

Bool = npt.NDArray[np.bool_]
Float64 = npt.NDArray[np.float64]
Int = npt.NDArray[np.signedinteger[Any]]

# -- the channel -------------------------------------------------------------------------------------

#: Boxes that the installation space is made of, low and high corner, in cells of the coarsest grid: the
#: inlet duct, a wide part where the flow bends, and the outlet duct in two parts.
_BOXES = (
    ((0, 0, 0), (14, 12, 10)),
    ((14, 0, 0), (30, 22, 16)),
    ((30, 10, 6), (40, 22, 16)),
    ((40, 10, 6), (46, 18, 12)),
)

#: Slanted walls: a . x <= d holds in the space, for the cells of a box. Every one ends where it meets
#: corners of the grid or another wall, so that neighbouring cells agree.
_WALLS = (
    ((-2, 3, 3), 48, (0, 0, 0), (9, 12, 10)),  # a bevel that fades out behind the inlet
    ((1, -2, 0), 22, (22, 0, 0), (30, 4, 16)),  # the outer side of the bend
    ((-3, 0, 4), -2, (14, 0, 10), (22, 22, 16)),  # a ceiling that rises
    ((2, 0, 3), 116, (34, 10, 12), (40, 22, 16)),  # the outlet duct narrows from above
    ((2, 3, 0), 134, (34, 18, 6), (40, 22, 16)),  # and from the side
)

#: The middle of the flow, as control points of a curve, and its radius from inlet to outlet.
_MIDDLE = np.array(
    [[-8, 6, 5], [0, 6, 5], [13, 6, 5], [25, 14, 10], [36, 15.5, 10.5], [46, 14, 9], [54, 13, 8.0]]
)
_RADIUS = (6.3, 3.9)

#: Where the channel is open.
_INLET, _OUTLET = 0, 46


def channel(refinement: int = 1) -> tuple[pv.PolyData, pv.PolyData]:
    """Make a flow volume of cells in an installation space with bends, a narrowing and inner corners.

    As in the paper on installation spaces (section 2.2): the space is cut out of a regular grid,
    cells are cut by its walls, and the skin of all cells that the flow touches is taken. It lies on the
    space's walls where the flow fills the space, and is made of stairs elsewhere.

    Parameters
    ----------
    refinement : int
        Cells along the edge of each cell of the coarsest grid; lengths are in cells of that.

    Returns
    -------
    sim : pyvista.PolyData
        Skin of the cells that the flow touches, 3 to 6 corners a face, open at inlet and outlet; the
        point array ``Flow`` holds the flow's velocity. Some 2300 faces times the refinement's square.
    inst : pyvista.PolyData
        The installation space, closed, normals outwards; it shares its points with `sim`.

    See Also
    --------
    flow_distance

    Examples
    --------
    >>> sim, inst = channel()
    >>> sorted(set(np.diff(sim.GetPolys().GetOffsetsArray()).tolist())), inst.n_open_edges
    ([3, 4, 5, 6], 0)
    """
    grid = _Grid(refinement)
    centres = (np.argwhere(grid.inside) + 0.5) / refinement
    touched = np.zeros_like(grid.inside)
    touched[grid.inside] = flow_distance(centres) < 0.0
    sim = grid.skin(touched)
    sim.point_data["Flow"] = flow(sim.points)
    return sim, grid.skin(None)


def flow(points: npt.ArrayLike) -> Float64:
    """Return the flow's velocity at `points` (q, 3): along the middle, faster where it is narrow."""
    radius, along, distance = _middle(points)
    profile = np.maximum(1.0 - (distance / (1.5 * radius)) ** 2, 0.05)
    return np.asarray(along * (profile * (_RADIUS[0] / radius) ** 2)[:, None])


def flow_distance(points: npt.ArrayLike) -> Float64:
    """Return the signed distance of `points` (q, 3) to the flow's true surface, negative inside.

    The flow's surface is a round tube of slowly falling radius; the installation space is not considered.
    """
    radius, _, distance = _middle(points)
    return distance - radius


def _middle(points: npt.ArrayLike) -> tuple[Float64, Float64, Float64]:
    """Return the flow's radius and direction where its middle is next to each point, and how far that is."""
    points = np.asarray(points, dtype=np.float64).reshape(-1, 3)
    places, directions, radii = _curve()
    nearest = np.empty(len(points), np.int64)
    for first in range(0, len(points), 4096):
        part = points[first : first + 4096]
        square = (places**2).sum(axis=1) - 2.0 * part @ places.T
        nearest[first : first + 4096] = square.argmin(axis=1)
    # From the nearest sample on along the curve's direction there.
    step = ((points - places[nearest]) * directions[nearest]).sum(axis=1)
    foot = places[nearest] + step[:, None] * directions[nearest]
    distance = np.linalg.norm(points - foot, axis=1)
    return radii[nearest], directions[nearest], distance


def _curve(samples: int = 120) -> tuple[Float64, Float64, Float64]:
    """Sample a Catmull-Rom curve through the control points: places, unit directions, radii."""
    parts = []
    t = np.arange(samples)[:, None] / samples
    for a, b, c, d in zip(_MIDDLE, _MIDDLE[1:], _MIDDLE[2:], _MIDDLE[3:], strict=False):
        parts.append(
            0.5 * (2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * t**2 + (3 * b - a - 3 * c + d) * t**3)
        )
    places = np.concatenate(parts)
    directions = np.gradient(places, axis=0)
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    part = np.clip((places[:, 0] - _INLET) / (_OUTLET - _INLET), 0.0, 1.0)[:, None]
    radii = _RADIUS[0] + (_RADIUS[1] - _RADIUS[0]) * part[:, 0] ** 2
    return places, directions, radii


class _Grid:
    """The installation space's cells. Coordinates are whole numbers of fine cells: decisions are exact."""

    def __init__(self, refinement: int) -> None:
        self.scale = refinement
        shape = refinement * np.max([high for _, high in _BOXES], axis=0)
        self.inside = np.zeros(shape, np.bool_)
        for low, high in _BOXES:
            self.inside[self._cells(low, high)] = True
        #: The walls that really cut a cell, by the cell.
        self.walls: dict[tuple[int, ...], list[tuple[Int, int]]] = defaultdict(list)
        corners = np.stack(np.meshgrid(*[(0, 1)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
        for normal, offset, low, high in _WALLS:
            a, d = np.array(normal), refinement * offset
            region = np.zeros_like(self.inside)
            region[self._cells(low, high)] = True
            cells = np.argwhere(region & self.inside)
            heights = cells @ a - d
            lowest, highest = (corners @ a).min(), (corners @ a).max()
            self.inside[tuple(cells[heights + lowest >= 0].T)] = False
            for cell in cells[(heights + lowest < 0) & (heights + highest > 0)].tolist():
                self.walls[tuple(cell)].append((a, d))

    def _cells(self, low: Any, high: Any) -> tuple[slice, ...]:
        return tuple(slice(self.scale * a, self.scale * b) for a, b in zip(low, high, strict=True))

    def skin(self, touched: Bool | None) -> pv.PolyData:
        """Return the skin of the touched cells, open at inlet and outlet; or that of the whole space."""
        cells = self.inside if touched is None else touched
        squares, owners = _squares(cells)
        if touched is not None:
            ends = np.isin(squares[:, :, 0], (self.scale * _INLET, self.scale * _OUTLET)).all(axis=1)
            squares, owners = squares[~ends], owners[~ends]
        cut = np.zeros_like(cells)
        cut[tuple(np.array(list(self.walls)).T)] = True
        at_walls = cut[tuple(owners.T)]
        polygons = _cut_faces(self.walls, cells)
        for polygon, owner in zip(squares[at_walls], owners[at_walls].tolist(), strict=True):
            for a, d in self.walls[tuple(owner)]:
                polygon = _clipped(polygon, a, d)
            polygons.append(polygon)
        polygons = [polygon for polygon in polygons if _has_area(polygon)]
        return _joined(squares[~at_walls], polygons, 1.0 / self.scale)


def _squares(cells: Bool) -> tuple[Int, Int]:
    """Return the faces between cells that are in and that are not, (m, 4, 3), and the cells they bound."""
    padded = np.pad(cells, 1)
    squares, owners = [], []
    for axis in range(3):
        for side in (0, 1):
            other = np.roll(padded, -1 if side else 1, axis=axis)
            owner = np.argwhere(padded & ~other) - 1
            u, v = np.zeros(3, int), np.zeros(3, int)
            u[(axis + 1) % 3] = v[(axis + 2) % 3] = 1
            first = owner.copy()
            first[:, axis] += side
            square = np.stack([first, first + u, first + u + v, first + v], axis=1)
            squares.append(square if side else square[:, ::-1])
            owners.append(owner)
    return np.concatenate(squares), np.concatenate(owners)


def _clipped(polygon: Float64, a: Int, d: int) -> Float64:
    """Return the part of a polygon (m, 3) where a . x <= d (Sutherland and Hodgman)."""
    heights = polygon @ a - d
    kept = []
    for p, q, hp, hq in zip(
        polygon, np.roll(polygon, -1, axis=0), heights, np.roll(heights, -1), strict=True
    ):
        if hp <= 0:
            kept.append(p)
        if hp * hq < 0:
            kept.append(p + hp / (hp - hq) * (q - p))
    return np.array(kept).reshape(-1, 3)


def _cut_faces(walls: dict[tuple[int, ...], list[tuple[Int, int]]], cells: Bool) -> list[Float64]:
    """Return the faces that walls make in cells: where each cuts one, as far as the others leave that."""
    cube = np.stack(np.meshgrid(*[(0, 1)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    edges = [(i, i + axis) for axis in (1, 2, 4) for i in range(8) if not i & axis]
    faces = []
    for cell, own in walls.items():
        corners = np.array(cell) + cube
        for a, d in own if cells[cell] else ():
            heights = corners @ a - d
            found = [corners[i] for i in np.flatnonzero(heights == 0)]
            for i, j in edges:
                if heights[i] * heights[j] < 0:
                    part = heights[i] / (heights[i] - heights[j])
                    found.append(corners[i] + part * (corners[j] - corners[i]))
            # In their order round the wall's normal.
            points = np.array(found, dtype=float)
            centred = points - points.mean(axis=0)
            u = np.cross(a, centred[0])
            polygon = points[np.argsort(np.arctan2(centred @ np.cross(a, u), centred @ u))]
            for b, e in own:
                polygon = polygon if b is a else _clipped(polygon, b, e)
            faces.append(polygon)
    return faces


def _has_area(polygon: Float64) -> bool:
    if len(polygon) < 3:
        return False
    spokes = polygon[1:] - polygon[0]
    return bool(np.abs(np.cross(spokes[:-1], spokes[1:]).sum(axis=0)).max() > 1e-9)


def _joined(squares: Int, polygons: list[Float64], size: float) -> pv.PolyData:
    """Return a polydata of squares (m, 4, 3) and polygons whose corners are joined where they coincide."""
    corners = np.concatenate([squares.reshape(-1, 3), *polygons])
    # One whole number for each place, in 1024th of a cell: far finer than walls cut them.
    lattice = np.round((corners - corners.min(axis=0)) * 1024).astype(np.int64)
    _, first, number = np.unique(
        np.ravel_multi_index(lattice.T, lattice.max(axis=0) + 1), return_index=True, return_inverse=True
    )
    faces = [np.column_stack([np.full(len(squares), 4), number[: squares.size // 3].reshape(-1, 4)]).ravel()]
    start = squares.size // 3
    for polygon in polygons:
        face = number[start : start + len(polygon)]
        start += len(polygon)
        face = face[face != np.roll(face, 1)]  # a wall that passes through a corner names it twice
        faces += [np.array([len(face)]), face]
    return pv.PolyData(size * corners[first], np.concatenate(faces))


# -- voxels ------------------------------------------------------------------------------------------


def voxel_skin(cells: npt.ArrayLike, origin: Any = (0.0, 0.0, 0.0), spacing: Any = 1.0) -> pv.PolyData:
    """Return the skin of voxels as quadrilaterals, normals outwards.

    Parameters
    ----------
    cells : (a, b, c) array_like
        Nonzero in the voxels whose skin is wanted.
    origin : (3,) array_like
        The first voxel's low corner.
    spacing : float or (3,) array_like
        Size of a voxel.

    Examples
    --------
    >>> round(voxel_skin(np.ones((1, 2, 3))).volume, 9)
    6.0
    """
    squares, _ = _squares(np.asarray(cells) != 0)
    skin = _joined(squares, [], 1.0)
    skin.points = np.asarray(origin) + skin.points * np.asarray(spacing, dtype=float)
    return skin


def voxel_torus(tube: float = 14.0, ring: float = 40.0, quarter: bool = False) -> pv.PolyData:
    """Return the skin of a torus of voxels of size 1, its axis along z.

    Parameters
    ----------
    tube, ring : float
        Radius of the tube, and of the circle that its middle runs on.
    quarter : bool
        Take only the quarter with positive x and y: a duct, open at both ends.

    See Also
    --------
    torus_distance
    """
    reach = int(np.ceil(ring + tube)) + 1
    low = np.array([0 if quarter else -reach] * 2 + [-int(np.ceil(tube)) - 1])
    shape = [reach - low[0], reach - low[1], -2 * low[2]]
    x, y, z = np.ogrid[tuple(slice(start, start + size) for start, size in zip(low, shape, strict=True))]
    squares, _ = _squares(_torus_distance(x + 0.5, y + 0.5, z + 0.5, tube, ring) < 0.0)
    squares += low
    if quarter:
        squares = squares[~(squares[:, :, :2] == 0).all(axis=1).any(axis=1)]
    return _joined(squares, [], 1.0)


def torus_distance(points: npt.ArrayLike, tube: float = 14.0, ring: float = 40.0) -> Float64:
    """Return the signed distance of `points` (q, 3) to the torus of :func:`voxel_torus`, negative inside."""
    x, y, z = np.asarray(points, dtype=np.float64).T
    return _torus_distance(x, y, z, tube, ring)


def _torus_distance(x: Float64, y: Float64, z: Float64, tube: float, ring: float) -> Float64:
    return np.asarray(np.hypot(np.hypot(x, y) - ring, z) - tube)


def write(folder: Path) -> list[Path]:
    """Write ``channel_sim.vtp``, ``channel_inst.vtp`` and ``voxel_torus.vtp``; return their paths."""
    folder.mkdir(parents=True, exist_ok=True)
    sim, inst = channel()
    meshes = {"channel_sim": sim, "channel_inst": inst, "voxel_torus": voxel_torus()}
    paths = []
    for name, mesh in meshes.items():
        paths.append(folder / f"{name}.vtp")
        mesh.save(paths[-1])
    return paths


if __name__ == "__main__":
    for path in write(Path(sys.argv[1] if len(sys.argv) > 1 else "samples")):
        print(path)
