"""Odd meshes: what no smoother likes, and what files and other programs hold nevertheless. Seeded."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import pyvista as pv
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
from vtkmodules.vtkCommonCore import vtkBitArray, vtkPoints, vtkStringArray
from vtkmodules.vtkCommonDataModel import (
    vtkCellArray,
    vtkDataSetAttributes,
    vtkImageData,
    vtkMultiBlockDataSet,
    vtkPolyData,
)

Random = np.random.Generator
Float64 = npt.NDArray[np.float64]
Faces = list[list[int]]
Shape = tuple[Float64, Faces]


@dataclass(frozen=True)
class Odd:
    """An odd mesh.

    Attributes
    ----------
    name : str
        What is odd about it.
    data : vtkPolyData or vtkMultiBlockDataSet
    further : dict
        What filters with a second input take for it, by the input's name.
    """

    name: str
    data: Any
    further: dict[str, Any]


# ------------------------------------------------------------------------------------------ shapes


def _grid(columns: int, rows: int) -> npt.NDArray[np.int64]:
    return np.arange(columns * rows).reshape(rows, columns)


def _split(random: Random, quads: Faces, kind: str) -> Faces:
    faces: Faces = []
    for a, b, c, d in quads:
        if kind == "triangles" or (kind == "mixed" and random.random() < 0.5):
            faces += [[a, b, c], [a, c, d]] if random.random() < 0.5 else [[a, b, d], [b, c, d]]
        else:
            faces.append([a, b, c, d])
    return faces


def _kind(random: Random) -> str:
    return str(random.choice(["triangles", "triangles", "quads", "mixed"]))


def sheet(random: Random) -> Shape:
    """Return a piece of a wavy plane."""
    columns, rows = random.integers(2, 14, 2)
    x, y = np.meshgrid(np.arange(columns), np.arange(rows))
    points = np.column_stack((x.ravel(), y.ravel(), np.zeros(x.size))).astype(float)
    points[:, 2] = random.choice([0.0, 0.3, 2.0]) * np.sin(points[:, 0]) * np.cos(points[:, 1])
    n = _grid(columns, rows)
    quads = np.stack((n[:-1, :-1], n[:-1, 1:], n[1:, 1:], n[1:, :-1]), axis=-1).reshape(-1, 4).tolist()
    return points, _split(random, quads, _kind(random))


def _band(columns: int, rows: int, twisted: bool = False, closed: bool = False) -> Faces:
    quads = []
    for i in range(columns):
        for j in range(rows if closed else rows - 1):
            k = (j + 1) % rows
            a, b, c, d = i, (i + 1) % columns, (i + 1) % columns, i
            turned = twisted and b == 0
            far = [(rows - 1 - row) if turned else row for row in (j, k)]
            quads.append([a * rows + j, b * rows + far[0], c * rows + far[1], d * rows + k])
    return quads


def torus(random: Random) -> Shape:
    """Return a torus."""
    columns, rows = int(random.integers(3, 24)), int(random.integers(3, 12))
    u, v = np.meshgrid(np.arange(columns), np.arange(rows), indexing="ij")
    u, v = 2 * np.pi * u.ravel() / columns, 2 * np.pi * v.ravel() / rows
    r = 2 + 0.7 * np.cos(v)
    points = np.column_stack((r * np.cos(u), r * np.sin(u), 0.7 * np.sin(v)))
    return points, _split(random, _band(columns, rows, closed=True), _kind(random))


def moebius(random: Random) -> Shape:
    """Return a Moebius band, or with an even number of twists a plain one."""
    columns, rows = int(random.integers(5, 30)), int(random.integers(2, 6))
    u, v = np.meshgrid(np.arange(columns), np.arange(rows), indexing="ij")
    u, v = 2 * np.pi * u.ravel() / columns, (v.ravel() / max(1, rows - 1) - 0.5) * 0.8
    r = 2 + v * np.cos(u / 2)
    points = np.column_stack((r * np.cos(u), r * np.sin(u), v * np.sin(u / 2)))
    return points, _split(random, _band(columns, rows, twisted=True), _kind(random))


def ball(random: Random) -> Shape:
    """Return a ball with two poles, now and then of 500 faces."""
    around = int(random.choice([3, 5, 8, 16, 500], p=[0.2, 0.25, 0.3, 0.2, 0.05]))
    down = int(random.integers(2, 9 if around < 100 else 4))
    u = 2 * np.pi * np.arange(around) / around
    rings = [
        np.column_stack((np.sin(t) * np.cos(u), np.sin(t) * np.sin(u), np.full(around, np.cos(t))))
        for t in np.pi * np.arange(1, down) / down
    ]
    points = np.vstack([*rings, [[0, 0, 1], [0, 0, -1]]])
    north, south, n = len(points) - 2, len(points) - 1, around
    quads = [
        [r * n + i, (r + 1) * n + i, (r + 1) * n + (i + 1) % n, r * n + (i + 1) % n]
        for r in range(down - 2)
        for i in range(n)
    ]
    caps = [[north, i, (i + 1) % n] for i in range(n)]
    last = (down - 2) * n
    caps += [[south, last + (i + 1) % n, last + i] for i in range(n)]
    return points, [*_split(random, quads, _kind(random)), *caps]


def box(random: Random) -> Shape:
    """Return a box, its sides split into a few faces each."""
    m = int(random.integers(1, 5))
    ids: dict[tuple[int, ...], int] = {}
    quads = []
    for axis in range(3):
        for side in (0, m):
            for i in range(m):
                for j in range(m):
                    corners = []
                    for a, b in ((0, 0), (1, 0), (1, 1), (0, 1)):
                        place = [0, 0, 0]
                        place[axis], place[(axis + 1) % 3], place[(axis + 2) % 3] = side, i + a, j + b
                        corners.append(ids.setdefault(tuple(place), len(ids)))
                    quads.append(corners if side else corners[::-1])
    points = np.array(list(ids), float) * random.choice([1.0, 0.1, 10.0], 3) / m
    return points, _split(random, quads, _kind(random))


def voxels(random: Random) -> Shape:
    """Return the skin of voxels, which touch along edges and at corners."""
    solid = random.random(random.integers(1, 5, 3)) < 0.6
    solid.ravel()[0] = True
    ids: dict[tuple[int, ...], int] = {}
    quads = []
    for cell in np.argwhere(solid):
        for axis in range(3):
            for side in (0, 1):
                other = cell.copy()
                other[axis] += 2 * side - 1
                if (other >= 0).all() and (other < solid.shape).all() and solid[tuple(other)]:
                    continue
                corners = []
                for a, b in ((0, 0), (1, 0), (1, 1), (0, 1)):
                    place = cell.copy()
                    place[axis] += side
                    place[(axis + 1) % 3] += a
                    place[(axis + 2) % 3] += b
                    corners.append(ids.setdefault(tuple(place.tolist()), len(ids)))
                quads.append(corners if side else corners[::-1])
    return np.array(list(ids), float), _split(random, quads, str(random.choice(["triangles", "quads"])))


def fan(random: Random) -> Shape:
    """Return a fan: one vertex that many faces share."""
    n = int(random.choice([3, 7, 30, 500]))
    u = 2 * np.pi * np.arange(n) / n
    points = np.column_stack((np.cos(u), np.sin(u), np.zeros(n)))
    points = np.vstack((points, [[0, 0, random.choice([0.0, 1.0, -30.0])]]))
    faces = [[n, i, (i + 1) % n] for i in range(n)]
    return points, faces[: -int(random.integers(0, 2)) or None]


def polygon(random: Random) -> Shape:
    """Return one face of any number of corners, plane or not, convex, a star, or crossing itself."""
    n = int(random.choice([1, 2, 3, 4, 5, 6, 12, 64, 65, 200]))
    u = 2 * np.pi * np.arange(n) / n
    r = random.choice([1.0, 0.2], n) if random.random() < 0.4 else np.ones(n)
    points = np.column_stack(
        (r * np.cos(u), r * np.sin(u), random.choice([0.0, 1.0]) * random.normal(size=n))
    )
    if random.random() < 0.2:
        points = points[random.permutation(n)]
    return points, [list(range(n))]


def cylinder(random: Random) -> Shape:
    """Return a cylinder with a polygon for each cap."""
    n = int(random.choice([3, 6, 20, 70]))
    u = 2 * np.pi * np.arange(n) / n
    ring = np.column_stack((np.cos(u), np.sin(u), np.zeros(n)))
    points = np.vstack((ring, ring + np.array([0, 0, 2.0])))
    faces = [[i, (i + 1) % n, n + (i + 1) % n, n + i] for i in range(n)]
    return points, [*faces, list(range(n))[::-1], list(range(n, 2 * n))]


def prism_sheet(random: Random) -> Shape:
    """Return a sheet of hexagons."""
    columns, rows = random.integers(1, 6, 2)
    ids: dict[tuple[float, float], int] = {}
    faces = []
    for i in range(columns):
        for j in range(rows):
            centre = np.array([1.5 * i, np.sqrt(3) * (j + 0.5 * (i % 2))])
            face = []
            for k in range(6):
                x, y = centre + np.array([np.cos(np.pi * k / 3), np.sin(np.pi * k / 3)])
                face.append(ids.setdefault((round(float(x), 6), round(float(y), 6)), len(ids)))
            faces.append(face)
    return np.array([(x, y, 0.2 * np.sin(x)) for x, y in ids]), faces


def book(random: Random) -> Shape:
    """Pages that share one edge: three or more faces at it."""
    n = int(random.integers(3, 7))
    points = [[0.0, 0, 0], [0, 0, 1]]
    faces: Faces = []
    for i in range(n):
        u = 2 * np.pi * i / n
        a = len(points)
        points += [[np.cos(u), np.sin(u), 0], [np.cos(u), np.sin(u), 1]]
        faces += [[0, a, a + 1], [0, a + 1, 1]]
    return np.array(points, float), faces


def tangle(random: Random) -> Shape:
    """Faces between any points, some of which they name twice."""
    n, m = int(random.integers(1, 30)), int(random.integers(1, 60))
    return random.normal(size=(n, 3)), random.integers(0, n, (m, int(random.integers(3, 6)))).tolist()


def two_sided(random: Random) -> Shape:
    """Return a sheet with a face on each side between the same points."""
    points, faces = sheet(random)
    return points, [*faces, *(face[::-1] for face in faces)]


def pair(random: Random) -> Shape:
    """Two bodies: apart, nested, crossing, or touching at a point."""
    a, b = (random.choice(_CLOSED)(random) for _ in range(2))
    shift = random.choice([0.0, 0.3, 1.0, 5.0])
    points = np.vstack((a[0], random.choice([0.2, 1.0]) * b[0] + [shift, 0, 0]))
    faces = [*a[1], *([p + len(a[0]) for p in face] for face in b[1])]
    if random.random() < 0.2:
        faces = [[0 if p == len(a[0]) else p for p in face] for face in faces]
    return points, faces


def spike(random: Random) -> Shape:
    """Return a sheet with a point that is far off."""
    points, faces = sheet(random)
    points[random.integers(len(points)), 2] += float(random.choice([10.0, 1e3, 1e6]))
    return points, faces


_CLOSED: list[Callable[[Random], Shape]] = [torus, ball, box, voxels, cylinder]

SHAPES: list[Callable[[Random], Shape]] = [
    sheet, torus, moebius, ball, box, voxels, fan, polygon, cylinder, prism_sheet, book, tangle, two_sided,
    pair, spike,
]  # fmt: skip


# ----------------------------------------------------------------------------------------- changes


def jittered(random: Random, shape: Shape) -> Shape:
    """Move all points by a part of their spacing."""
    points, faces = shape
    spacing = np.ptp(points, axis=0).max() / max(2.0, len(points) ** 0.5)
    return points + random.choice([0.01, 0.2, 0.5]) * spacing * random.normal(size=points.shape), faces


def flattened(random: Random, shape: Shape) -> Shape:
    """Put all points into a plane, onto a line or into one place."""
    points, faces = shape
    points = points.copy()
    points[:, random.permutation(3)[: int(random.integers(1, 4))]] = 0.1
    return points, faces


def coincident(random: Random, shape: Shape) -> Shape:
    """Put some points where others are."""
    points, faces = shape
    points = points.copy()
    some = random.integers(0, len(points), (2, 1 + len(points) // 8))
    points[some[0]] = points[some[1]]
    return points, faces


def doubled(random: Random, shape: Shape) -> Shape:
    """Name some faces twice."""
    points, faces = shape
    return points, [*faces, *(faces[i] for i in random.integers(0, len(faces), 1 + len(faces) // 6))]


def turned(random: Random, shape: Shape) -> Shape:
    """Reverse the orientation of some faces."""
    points, faces = shape
    return points, [face[::-1] if random.random() < 0.3 else face for face in faces]


def holes(random: Random, shape: Shape) -> Shape:
    """Leave faces out."""
    points, faces = shape
    return points, [face for face in faces if random.random() < 0.8] or faces[:1]


def soup(random: Random, shape: Shape) -> Shape:
    """Give every face points of its own."""
    points, faces = shape
    corners = [p for face in faces for p in face]
    ends = np.cumsum([len(face) for face in faces])
    return points[corners], [
        list(range(end - len(face), end)) for face, end in zip(faces, ends.tolist(), strict=True)
    ]


def seam(random: Random, shape: Shape) -> Shape:
    """Split points between two halves of the faces."""
    points, faces = shape
    middle = np.median(points[:, 0])
    other: dict[int, int] = {}
    made: Faces = []
    for face in faces:
        right = points[face, 0].mean() > middle
        made.append([other.setdefault(p, len(points) + len(other)) if right else p for p in face])
    return np.vstack((points, points[list(other)])) if other else points, made


def isolated(random: Random, shape: Shape) -> Shape:
    """Put points that no face uses before and behind the others, some of them not finite."""
    points, faces = shape
    extra = np.array([[100.0, 0, 0], [np.nan, 0, -0.0], [np.inf, -np.inf, 1], [1e300, 0, 0]])
    extra = extra[: int(random.integers(1, 5))]
    return np.vstack((extra, points, extra)), [[p + len(extra) for p in face] for face in faces]


def degenerate(random: Random, shape: Shape) -> Shape:
    """Add faces of fewer than three corners, and such that name a point more than once."""
    points, faces = shape
    a, b, c = random.integers(0, len(points), 3).tolist()
    more = [[a, a, b], [a, b, a, c], [a, a, a], [a, b], [a], []]
    return points, [*faces, *more[: int(random.integers(1, 7))]]


def not_finite(random: Random, shape: Shape) -> Shape:
    """Make a coordinate NaN or infinite."""
    points, faces = shape
    points = points.copy()
    points[random.integers(len(points)), random.integers(3)] = random.choice([np.nan, np.inf, -np.inf])
    return points, faces


def scaled(random: Random, shape: Shape) -> Shape:
    """Make the mesh very large or very small."""
    points, faces = shape
    return points * 10.0 ** float(
        random.choice([-300, -150, -80, -30, -12, 6, 12, 30, 38, 69, 71, 150])
    ), faces


def far_off(random: Random, shape: Shape) -> Shape:
    """Put the mesh far from the origin."""
    points, faces = shape
    return points + 10.0 ** float(random.choice([3, 6, 9, 15])) * random.normal(size=3), faces


def stretched(random: Random, shape: Shape) -> Shape:
    """Make the mesh long and thin."""
    points, faces = shape
    return points * [1.0, 1.0, float(random.choice([1e-8, 1e-3, 1e3, 1e8]))], faces


def wrong_index(random: Random, shape: Shape) -> Shape:
    """Let a face name a point that is not there."""
    points, faces = shape
    faces = [list(face) for face in faces]
    face = faces[random.integers(len(faces))]
    if face:
        face[0] = int(random.choice([len(points), -1, 2**31 - 1, 10**6]))
    return points, faces


#: What is done to shapes, and how often of 100.
CHANGES: list[tuple[Callable[[Random, Shape], Shape], int]] = [
    (jittered, 45), (flattened, 3), (holes, 8), (turned, 6), (doubled, 6), (soup, 5), (seam, 7),
    (coincident, 6), (isolated, 8), (degenerate, 8), (stretched, 6), (far_off, 6), (scaled, 8),
    (not_finite, 3), (wrong_index, 2),
]  # fmt: skip


# -------------------------------------------------------------------------------------------- data


#: Storage of cells that have equally many corners, of newer versions of VTK.
_FIXED_SIZE = "ConvertToFixedSizeDefaultStorage"


def _cells(lists: Faces, bits: int = 64) -> vtkCellArray:
    cells = vtkCellArray()
    offsets = np.concatenate(([0], np.cumsum([len(one) for one in lists]))).astype(np.int64)
    corners = np.array([p for one in lists for p in one], np.int64)
    cells.SetData(numpy_to_vtkIdTypeArray(offsets, deep=1), numpy_to_vtkIdTypeArray(corners, deep=1))
    if bits == 32:
        cells.ConvertTo32BitStorage()
    elif bits == 0 and len({len(one) for one in lists}) == 1 and hasattr(cells, _FIXED_SIZE):
        getattr(cells, _FIXED_SIZE)()
    return cells


def polydata(
    points: npt.NDArray[Any],
    polys: Faces,
    strips: Faces = (),
    lines: Faces = (),
    verts: Faces = (),
    bits: int = 64,
) -> vtkPolyData:
    """Return a vtkPolyData of points and lists of corners."""
    made = vtkPolyData()
    places = vtkPoints()
    places.SetData(numpy_to_vtk(np.ascontiguousarray(points), deep=1))
    made.SetPoints(places)
    made.SetPolys(_cells(polys, bits))
    for lists, put in ((strips, made.SetStrips), (lines, made.SetLines), (verts, made.SetVerts)):
        if lists:
            put(_cells(lists, bits))
    return made


def add(data: Any, name: str | None, values: npt.NDArray[Any]) -> Any:
    """Add a copy of an array to point, cell or field data; return the VTK array."""
    array = numpy_to_vtk(np.ascontiguousarray(values), deep=1)
    if name is not None:
        array.SetName(name)
    data.AddArray(array)
    return array


def _some(random: Random, n: int, *kinds: Callable[[], npt.NDArray[Any]]) -> npt.NDArray[Any]:
    return kinds[random.integers(len(kinds))]()


def add_arrays(random: Random, mesh: vtkPolyData) -> None:
    """Add arrays that filters read, and odd ones that they must pass on."""
    n, m = mesh.GetNumberOfPoints(), mesh.GetNumberOfCells()
    points, cells, fields = mesh.GetPointData(), mesh.GetCellData(), mesh.GetFieldData()

    def chance(percent: int) -> bool:
        return bool(random.random() < percent / 100)

    if chance(35):
        kinds = (
            lambda: (random.random(n) < 0.2).astype(np.uint8),
            lambda: (random.random(n) < 0.5).astype(np.float32),
            lambda: random.integers(0, 2, n),
            lambda: np.ones(n, np.int8),
            lambda: np.where(random.random(n) < 0.1, np.nan, 0.0),
            lambda: np.zeros((n, 3)),
        )
        add(points, "Fixed", _some(random, n, *kinds[: 6 if chance(20) else 4]))
    if chance(20):
        kinds = (
            lambda: random.random(n),
            lambda: random.random(n).astype(np.float32),
            lambda: np.ones(n),
            lambda: np.zeros(n),
            lambda: random.normal(size=n) * 10,
            lambda: np.full(n, np.nan),
        )
        add(points, "BlendWeight", _some(random, n, *kinds[: 6 if chance(20) else 4]))
    if chance(15):
        kinds = (
            lambda: 0.2 * random.random(n),
            lambda: np.full(n, 0.05, np.float32),
            lambda: np.zeros(n),
            lambda: np.full(n, np.inf),
            lambda: random.normal(size=n),
            lambda: np.full(n, np.nan),
        )
        add(points, "SmoothingConstraints", _some(random, n, *kinds[: 6 if chance(20) else 4]))
    if chance(30):
        home, size = (points, n) if chance(50) else (cells, m)
        kinds = (
            lambda: random.normal(size=(size, 3)),
            lambda: np.tile([1.0, 0.0, 0.0], (size, 1)).astype(np.float32),
            lambda: np.zeros((size, 3)),
            lambda: np.full((size, 3), 1e-200),
            lambda: np.full((size, 3), np.nan),
            lambda: np.zeros(size),
        )
        add(home, "Flow", _some(random, size, *kinds[: 6 if chance(20) else 4]))
    if chance(6) and n:
        add(points, "FeatureClass", random.integers(0, 4 if chance(80) else 9, n).astype(np.uint8))
        add(
            points,
            "RidgeNeighbours",
            random.integers(-1, n if chance(80) else 2 * n, (n, 2)).astype(np.int32),
        )
    if chance(8) and n:
        name = "AddedFeatureEdges" if chance(50) else "RemovedFeatureEdges"
        add(fields, name, random.integers(0, n if chance(50) else n + 3, (3, 2)))
    if chance(20):
        kind = (np.float32, np.float64)[random.integers(2)]
        normals = random.normal(size=(n, 3)).astype(kind)
        points.SetActiveAttribute(add(points, "Normals", normals).GetName(), vtkDataSetAttributes.NORMALS)
    if chance(10):
        normals = random.normal(size=(m, 3)).astype(np.float32)
        cells.SetActiveAttribute(add(cells, "Normals", normals).GetName(), vtkDataSetAttributes.NORMALS)
    if chance(8):
        add(points, "vtkGhostType", (random.random(n) < 0.2).astype(np.uint8))
    if chance(8):
        add(cells, "vtkGhostType", (random.random(m) < 0.2).astype(np.uint8))
    if chance(15):
        add(points, "TCoords", random.random((n, 2)).astype(np.float32))
        points.SetActiveAttribute("TCoords", vtkDataSetAttributes.TCOORDS)
    if chance(10):
        points.SetGlobalIds(numpy_to_vtkIdTypeArray(np.arange(n), deep=1))
    if chance(25):
        _add_oddities(random, points, n)
    if chance(25):
        _add_oddities(random, cells, m)
    if chance(15):
        _add_oddities(random, fields, 2)


def _add_oddities(random: Random, data: Any, n: int) -> None:
    kind = random.integers(10)
    if kind == 0:
        texts = vtkStringArray()
        texts.SetName("labels")
        texts.SetNumberOfValues(n)
        for i in range(n):
            texts.SetValue(i, f"é {i}")
        data.AddArray(texts)
    elif kind == 1:
        bits = vtkBitArray()
        bits.SetName("bits")
        bits.SetNumberOfValues(n)
        for i in range(n):
            bits.SetValue(i, i % 2)
        data.AddArray(bits)
    elif kind == 2:
        add(data, None, np.arange(n))
    elif kind == 3:
        add(data, "", np.arange(n, dtype=np.uint16))
    elif kind == 4:
        add(data, "Ünïcode µ\n", np.full(n, np.nan))
    elif kind == 5:
        add(data, "tensor", random.random((n, 9)))
    elif kind == 6:
        add(data, "many", random.integers(0, 255, (n, 40)).astype(np.uint8))
    elif kind == 7:
        add(data, "AspectRatio", np.full(n, 7.0))
    elif kind == 8:
        add(data, "OriginalCell", np.arange(n, dtype=np.int8))
    else:
        add(data, "huge", np.full((n, 2), np.finfo(np.float64).max))


# ---------------------------------------------------------------------------------------- all of it


def _strip(random: Random, faces: Faces) -> tuple[Faces, Faces]:
    """Return faces without some triangles, and these as strips."""
    strips = [face for face in faces if len(face) == 3 and random.random() < 0.5]
    taken = {id(face) for face in strips}
    if random.random() < 0.3 and strips:
        strips[0] = [*strips[0], *strips[-1]]
    return [face for face in faces if id(face) not in taken], strips


def one(random: Random) -> tuple[str, vtkPolyData]:
    """Return an odd polydata and what is odd about it."""
    number = random.random()
    if number < 0.01:
        return "empty", vtkPolyData()
    shape = SHAPES[random.integers(len(SHAPES))]
    words = [shape.__name__]
    points, faces = shape(random)
    if number < 0.025:
        words, faces = ["points only"], []
    for change, percent in CHANGES:
        if random.random() < percent / 100 and faces:
            points, faces = change(random, (points, faces))
            words.append(change.__name__)
    strips: Faces = []
    lines: Faces = []
    verts: Faces = []
    n = len(points)
    if random.random() < 0.06:
        faces, strips = _strip(random, faces)
        words.append("strips")
    if random.random() < 0.06:
        lines = [random.integers(0, n, int(random.integers(1, 5))).tolist() for _ in range(3)]
        words.append("lines")
    if random.random() < 0.06:
        verts = [[int(random.integers(n))] for _ in range(3)]
        words.append("verts")
    bits = int(random.choice([64, 64, 32, 0]))
    single = bool(random.random() < 0.4)
    with np.errstate(over="ignore", invalid="ignore"):
        mesh = polydata(points.astype(np.float32) if single else points, faces, strips, lines, verts, bits)
    words += [f"{bits or 'fixed-size'} ids", "float32" if single else "float64"]
    if random.random() < 0.6:
        add_arrays(random, mesh)
    return ", ".join(words), mesh


def _blocks(random: Random) -> tuple[str, Any]:
    blocks = vtkMultiBlockDataSet()
    names = []
    for i in range(int(random.integers(0, 4))):
        kind = random.random()
        if kind < 0.15:
            blocks.SetBlock(i, None)
            names.append("nothing")
        elif kind < 0.3:
            blocks.SetBlock(i, vtkPolyData())
            names.append("empty")
        elif kind < 0.33:
            blocks.SetBlock(i, vtkImageData())
            names.append("image")
        elif kind < 0.4:
            inner = vtkMultiBlockDataSet()
            name, mesh = one(random)
            inner.SetBlock(0, mesh)
            blocks.SetBlock(i, inner)
            names.append(f"block of {name}")
        else:
            name, mesh = one(random)
            blocks.SetBlock(i, mesh)
            names.append(name)
    return f"blocks ({'; '.join(names)})", blocks


def _original(random: Random, mesh: Any) -> Any:
    if not isinstance(mesh, vtkPolyData) or random.random() < 0.1:
        return one(random)[1] if random.random() < 0.3 else mesh
    original = vtkPolyData()
    original.DeepCopy(mesh)
    if mesh.GetPoints() is not None and random.random() < 0.8:
        points = pv.wrap(original).points
        points += (0.1 * np.nanstd(points) * random.normal(size=points.shape)).astype(points.dtype)
    return original


def _space(random: Random, mesh: Any) -> Any:
    number = random.random()
    if number < 0.1:
        return one(random)[1]
    if number < 0.15:
        return mesh
    bounds = np.array([0, 1, 0, 1, 0, 1.0])
    if mesh.GetNumberOfPoints():
        mesh.GetBounds(bounds)
    low, high = bounds[::2], bounds[1::2]
    if not np.isfinite(bounds).all() or (high < low).any():
        low, high = np.zeros(3), np.ones(3)
    centre, size = (low + high) / 2, np.maximum(high - low, 1e-3 * max(1e-30, float((high - low).max())))
    grown = float(random.choice([0.5, 1.0, 1.0, 1.2, 3.0]))
    points, faces = random.choice([box, box, ball, cylinder])(random)
    points = points - (points.min(axis=0) + points.max(axis=0)) / 2
    points = centre + grown * size * points / np.maximum(np.ptp(points, axis=0), 1e-30)
    for change, share in ((holes, 0.1), (turned, 0.05), (soup, 0.1), (doubled, 0.05), (jittered, 0.1)):
        if random.random() < share:
            points, faces = change(random, (points, faces))
    if random.random() < 0.1:  # nested or overlapping
        points = np.vstack((points, centre + 0.7 * (points - centre) + random.choice([0.0, 0.3]) * size))
        n = len(points) // 2
        faces = [*faces, *([p + n for p in face] for face in faces)]
    return polydata(points, faces)


def odd(random: Random) -> Odd:
    """Return an odd mesh, or odd composite data, and second inputs for it."""
    name, data = _blocks(random) if random.random() < 0.04 else one(random)
    return Odd(name, data, {"original": _original(random, data), "installation": _space(random, data)})
