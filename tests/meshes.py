"""Generated meshes: every kind of surface that the array layer must cope with."""

from __future__ import annotations

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData

from vtksmooth.kernels.mesh.mesh import Mesh

KINDS = ("triangles", "quads", "mixed")


def polydata(mesh: Mesh) -> vtkPolyData:
    """The same mesh for VTK."""
    points = vtkPoints()
    points.SetData(numpy_to_vtk(mesh.points, deep=1))
    cells = vtkCellArray()
    cells.SetData(
        numpy_to_vtkIdTypeArray(mesh.offsets.astype(np.int64), deep=1),
        numpy_to_vtkIdTypeArray(mesh.connectivity.astype(np.int64), deep=1),
    )
    result = vtkPolyData()
    result.SetPoints(points)
    result.SetPolys(cells)
    return result


def _cells(columns, rows, kind, index):
    """Faces of a grid of cells; index(i, j) is the point at column i and row j."""
    faces = []
    for j in range(rows):
        for i in range(columns):
            a, b, c, d = index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)
            if kind == "quads":
                faces.append([a, b, c, d])
            elif kind == "triangles":
                faces += [[a, b, c], [a, c, d]] if (i + j) % 2 == 0 else [[a, b, d], [b, c, d]]
            elif j % 2 == 1:
                faces += [[a, b, c, d]] if i % 2 == 0 else [[a, b, d], [b, c, d]]
            elif i % 2 == 0:  # a pentagon and a triangle over two cells; `lifted` makes it convex
                faces += [[a, b, index(i + 2, j + 1), c, d], [b, index(i + 2, j), index(i + 2, j + 1)]]
    return faces


def _parameters(columns, rows, kind):
    i, j = np.meshgrid(np.arange(columns), np.arange(rows))
    u, v = i.ravel().astype(float), j.ravel().astype(float)
    if kind == "mixed":
        v = v + 0.35 * ((i % 2 == 1) & (j % 2 == 1)).ravel()
    return u, v


def sheet(columns, rows, kind="triangles", jitter=0.0, bump=0.0, seed=0, boundary_jitter=None):
    """A rectangle of unit cells with straight sides, bulging upwards by `bump`, interior points thrown about.

    For mixed sheets both numbers must be even. Boundary points are thrown along their side only.
    """
    u, v = _parameters(columns + 1, rows + 1, kind)
    z = bump * np.sin(np.pi * u / columns) * np.sin(np.pi * v / rows)
    points = np.column_stack([u, v, z])
    random = np.random.default_rng(seed)
    push = random.uniform(-1.0, 1.0, points.shape)
    inside = (u > 0) & (u < columns) & (v > 0) & (v < rows)
    points[inside] += jitter * push[inside] * [1.0, 1.0, 0.3 if bump else 0.0]
    along = boundary_jitter if boundary_jitter is not None else 0.0
    points[:, 0] += along * push[:, 0] * ((v == 0) | (v == rows)) * ((u > 0) & (u < columns))
    points[:, 1] += along * push[:, 1] * ((u == 0) | (u == columns)) * ((v > 0) & (v < rows))
    return Mesh.from_faces(points, _cells(columns, rows, kind, lambda i, j: j * (columns + 1) + i))


def torus(columns, rows, kind="triangles", jitter=0.0, seed=0):
    """A closed torus of radii 3 and 1, normals outwards."""
    u, v = _parameters(columns, rows, kind)
    random = np.random.default_rng(seed)
    u = 2 * np.pi * (u + jitter * random.uniform(-1, 1, u.shape)) / columns
    v = 2 * np.pi * (v + jitter * random.uniform(-1, 1, v.shape)) / rows
    points = np.column_stack([(3 + np.cos(v)) * np.cos(u), (3 + np.cos(v)) * np.sin(u), np.sin(v)])
    points += 0.1 * jitter * random.uniform(-1, 1, points.shape)
    return Mesh.from_faces(points, _cells(columns, rows, kind, lambda i, j: j % rows * columns + i % columns))


def moebius(columns=24, rows=4):
    """A strip of triangles that closes with a half turn: no orientation fits all its faces."""
    i, j = np.meshgrid(np.arange(columns), np.arange(rows + 1))
    angle, across = 2 * np.pi * i.ravel() / columns, j.ravel() / rows - 0.5
    radius = 2 + across * np.cos(angle / 2)
    points = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), across * np.sin(angle / 2)])

    def index(i, j):
        return j * columns + i if i < columns else (rows - j) * columns + i - columns

    return Mesh.from_faces(points, _cells(columns, rows, "triangles", index))


def icosphere(subdivisions=2, radius=1.0):
    golden = (1 + 5**0.5) / 2
    points = [(-1, golden, 0), (1, golden, 0), (-1, -golden, 0), (1, -golden, 0)]
    points += [(z, x, y) for x, y, z in points] + [(y, z, x) for x, y, z in points]
    points = [np.array(p, float) / np.linalg.norm(p) for p in points]
    near = np.linalg.norm(points[0] - np.array(points), axis=1)
    edge = np.sort(near)[1] * 1.01
    faces = [
        [a, b, c]
        for a in range(12)
        for b in range(a + 1, 12)
        for c in range(b + 1, 12)
        if max(np.linalg.norm(points[p] - points[q]) for p, q in ((a, b), (b, c), (c, a))) < edge
    ]
    faces = [
        f
        if np.dot(np.cross(points[f[1]] - points[f[0]], points[f[2]] - points[f[0]]), points[f[0]]) > 0
        else f[::-1]
        for f in faces
    ]
    for _ in range(subdivisions):
        middle = {}

        def half(p, q, middle=middle):
            key = (min(p, q), max(p, q))
            if key not in middle:
                middle[key] = len(points)
                points.append((points[p] + points[q]) / np.linalg.norm(points[p] + points[q]))
            return middle[key]

        finer = []
        for a, b, c in faces:
            d, e, f = half(a, b), half(b, c), half(c, a)
            finer += [[a, d, f], [d, b, e], [f, e, c], [d, e, f]]
        faces = finer
    return Mesh.from_faces(radius * np.array(points), faces)


def voxels(cells, triangles=False):
    """The surface of a union of unit cubes, given by their integer corners: quads (or halves), outwards."""
    cells = {tuple(cell) for cell in cells}
    numbers, faces = {}, []
    for cell in sorted(cells):
        for axis in range(3):
            for side in (0, 1):
                step = [0, 0, 0]
                step[axis] = 2 * side - 1
                if tuple(np.add(cell, step)) in cells:
                    continue
                u, v = (axis + 1) % 3, (axis + 2) % 3
                square = []
                for du, dv in ((0, 0), (1, 0), (1, 1), (0, 1)):
                    corner = list(cell)
                    corner[axis] += side
                    corner[u] += du
                    corner[v] += dv
                    square.append(numbers.setdefault(tuple(corner), len(numbers)))
                a, b, c, d = square if side else square[::-1]
                faces += [[a, b, c], [a, c, d]] if triangles else [[a, b, c, d]]
    return Mesh.from_faces(np.array(list(numbers), float), faces)


def cube(n=1, triangles=False):
    """A cube of side n in unit squares."""
    return voxels(np.ndindex(n, n, n), triangles)


def tube(length=4):
    """A square tube along x, open at both ends, normals outwards."""
    ring = [[0, 0], [1, 0], [1, 1], [0, 1]]
    points = [[x, *place] for x in range(length + 1) for place in ring]
    sides = [(4 * i + j, 4 * i + (j + 1) % 4) for i in range(length) for j in range(4)]
    return Mesh.from_faces(points, [[a, b, b + 4, a + 4] for a, b in sides])


def l_shape(triangles=False):
    """Three unit cubes round a concave edge, from (1, 1, 0) to (1, 1, 1)."""
    return voxels([(0, 0, 0), (1, 0, 0), (0, 1, 0)], triangles)


def fan(valence, height=0.0):
    """A disc of triangles round one point that is off the middle."""
    angle = 2 * np.pi * np.arange(valence) / valence
    rim = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(valence)])
    faces = [[0, 1 + i, 1 + (i + 1) % valence] for i in range(valence)]
    return Mesh.from_faces(np.vstack([[0.3, 0.1, height], rim]), faces)


def joined(*parts):
    """Several meshes in one, as separate components."""
    points, faces, first = [], [], 0
    for mesh in parts:
        faces += [[first + p for p in face] for face in lists(mesh)]
        points.append(mesh.points)
        first += mesh.n_points
    return Mesh.from_faces(np.vstack(points), faces)


def lists(mesh):
    """The faces as lists."""
    return [mesh.connectivity[a:b].tolist() for a, b in zip(mesh.offsets[:-1], mesh.offsets[1:], strict=True)]


def two_components():
    return joined(
        sheet(6, 4, jitter=0.3), icosphere(1).with_points(icosphere(1).points + np.array([20.0, 0.0, 0.0]))
    )


def non_manifold_edge():
    """Three sheets of triangles that meet in one line."""
    first = sheet(4, 4, jitter=0.2)
    second = first.points @ np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]]) + 0.0
    third = first.points * [-1.0, 1.0, 1.0]
    points, numbers, faces = [], {}, []
    for sheet_points, flip in ((first.points, 1), (second, 1), (third, -1)):
        for face in lists(first):
            corners = [numbers.setdefault(tuple(np.round(sheet_points[p], 9)), len(numbers)) for p in face]
            faces.append(corners[::flip])
    points = np.array(list(numbers))
    return Mesh.from_faces(points, faces)


def bow_tie():
    """Two open fans that share nothing but one point."""
    points = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [-1, 0, 0], [-1, -1, 0], [0, -1, 0]]
    return Mesh.from_faces(points, [[0, 1, 2], [0, 2, 3], [0, 4, 5], [0, 5, 6]])


def hourglass():
    """Two closed tetrahedra that share nothing but one point."""
    points = [[0, 0, 0], [1, 0, 1], [-1, 1, 1], [-1, -1, 1], [1, 0, -1], [-1, 1, -1], [-1, -1, -1]]
    faces = [[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3], [0, 4, 5], [0, 5, 6], [0, 6, 4], [4, 6, 5]]
    return Mesh.from_faces(points, faces)


def misoriented(seed=0):
    """A jittered sheet, a third of its faces turned round."""
    mesh = sheet(8, 8, jitter=0.25, bump=1.0)
    turned = np.random.default_rng(seed).random(mesh.n_faces) < 1 / 3
    return Mesh.from_faces(
        mesh.points, [f[::-1] if t else f for f, t in zip(lists(mesh), turned, strict=True)]
    )


def isolated_points():
    """A sheet with points that no face uses, some of them not finite, among and after its own."""
    mesh = sheet(5, 5, jitter=0.3)
    extra = np.array([[100.0, 0, 0], [np.nan, 0, -0.0], [np.inf, -np.inf, 1]])
    points = np.vstack([extra, mesh.points, extra])
    return Mesh.from_faces(points, [[p + 3 for p in face] for face in lists(mesh)])


def duplicate_points():
    """A sheet of unmerged triangles: every corner has its own point."""
    mesh = sheet(4, 4, jitter=0.2)
    return Mesh.from_faces(mesh.points[mesh.connectivity], np.arange(len(mesh.connectivity)).reshape(-1, 3))


def degenerate_faces():
    """A sheet where some points coincide (edges of no length), others lie in line (faces of no area),
    and faces name a point twice or have fewer than three corners."""
    mesh = sheet(6, 6, jitter=0.2, bump=0.5)
    points = mesh.points.copy()
    points[16] = points[17]
    points[24] = 0.5 * (points[23] + points[25])
    points[30:33] = points[31]
    return Mesh.from_faces(points, [*lists(mesh), [0, 0, 1], [8, 9, 8], [2, 3], [4], [], [5, 5, 5]])


def all_points_the_same():
    return sheet(3, 3).with_points(np.full((16, 3), 0.1))


def folded_quads():
    """Quads of which some are folded over, concave or crossed."""
    mesh = sheet(6, 6, "quads", jitter=0.1)
    points = mesh.points.copy()
    points[16] += [1.6, 0.9, 0.0]
    points[[24, 25]] = points[[25, 24]]
    return mesh.with_points(points)


#: Meshes that no smoother likes, and what must come out of each is a right result.
HOSTILE = {
    "moebius": moebius,
    "two_components": two_components,
    "non_manifold_edge": non_manifold_edge,
    "bow_tie": bow_tie,
    "hourglass": hourglass,
    "misoriented": misoriented,
    "isolated_points": isolated_points,
    "duplicate_points": duplicate_points,
    "degenerate_faces": degenerate_faces,
    "all_points_the_same": all_points_the_same,
    "folded_quads": folded_quads,
    "high_valence": lambda: fan(3000),
    "single_triangle": lambda: Mesh.from_faces([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]),
    "three_faces_at_an_edge": lambda: Mesh.from_faces(
        [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 1, 2], [0, 2, 1], [0, 3, 1]]
    ),
    "two_sided": lambda: Mesh.from_faces([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 1]]),
}

#: Meshes that anyone may have.
USUAL = {
    "sheet of triangles": lambda: sheet(9, 7, "triangles", jitter=0.3, bump=2.0),
    "sheet of quads": lambda: sheet(9, 7, "quads", jitter=0.25, bump=2.0),
    "mixed sheet": lambda: sheet(8, 6, "mixed", jitter=0.2, bump=2.0),
    "torus of triangles": lambda: torus(18, 8, "triangles", jitter=0.2),
    "torus of quads": lambda: torus(18, 8, "quads", jitter=0.2),
    "mixed torus": lambda: torus(18, 8, "mixed", jitter=0.1),
    "sphere": lambda: icosphere(2),
    "cube of quads": lambda: cube(3),
    "cube of triangles": lambda: cube(3, triangles=True),
}


def label_walls(labels):
    """The squares between voxels of different labels, with the labels on both sides; the border is closed.

    Returns the mesh and the (m, 2) labels: normals run from the first to the second. `labels` is a 3-D array.
    """
    around = np.pad(np.asarray(labels), 1)
    size = np.array(around.shape) + 1
    corners, sides = [], []
    for axis in range(3):
        low = np.moveaxis(around, axis, 0)[:-1]
        high = np.moveaxis(around, axis, 0)[1:]
        cells = np.argwhere(low != high)
        sides.append(np.column_stack((low[low != high], high[low != high])))
        one, two = np.eye(3, dtype=int)[(axis + 1) % 3], np.eye(3, dtype=int)[(axis + 2) % 3]
        at = cells.copy()
        at[:, 0] += 1
        at = at[:, np.argsort([axis, *[a for a in range(3) if a != axis]])]
        corners.append(np.stack((at, at + one, at + one + two, at + two), axis=1))
    corners = np.concatenate(corners)
    numbers = np.ravel_multi_index(corners.reshape(-1, 3).T, size)
    used, faces = np.unique(numbers, return_inverse=True)
    points = np.column_stack(np.unravel_index(used, size)).astype(float) - 1.0
    return Mesh.from_faces(points, faces.reshape(-1, 4)), np.concatenate(sides)


def grains(n=9, count=5, seed=0):
    """Voronoi cells in a ball of voxels, 0 outside."""
    random = np.random.default_rng(seed)
    places = np.argwhere(np.ones((n, n, n), bool)) - (n - 1) / 2
    seeds = random.uniform(-0.35 * n, 0.35 * n, (count, 3))
    labels = 1 + ((places[:, None] - seeds) ** 2).sum(axis=2).argmin(axis=1)
    labels[(places**2).sum(axis=1) > (0.45 * n) ** 2] = 0
    return labels.reshape(n, n, n)


def speckle(shape=(4, 5, 4), count=3, seed=0):
    """Voxels of labels at random: walls that touch along edges and at corners in every way."""
    return np.random.default_rng(seed).integers(0, count, shape)
