"""Shapes that the evidence and the benchmark generate: nothing here is read from a file."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pyvista as pv

Float64 = npt.NDArray[np.float64]
Int64 = npt.NDArray[np.int64]

#: The cubic surface of Semenova et al., section 5.2, is z = 4x^3 + 6y^3; they give neither domain nor mesh.
#: This half-width, these lines and this shift make the histogram of k that their table 8 starts from.
CUBIC_HALF_WIDTH, CUBIC_LINES, CUBIC_SPACING, CUBIC_SHIFT = 0.565, (42, 39), 1.4, 0.86


def polydata(points: npt.NDArray[np.floating], faces: npt.NDArray[np.integer]) -> pv.PolyData:
    """Return the mesh of `faces`, (m, corners)."""
    return pv.PolyData.from_regular_faces(np.asarray(points), np.asarray(faces))


def grid_triangles(points: Float64, rows: int, columns: int, alternate: bool = False) -> Int64:
    """Triangles of a grid of quadrilaterals: split by the shorter diagonal, or by turns, (2 * cells, 3)."""
    i, j = (index.ravel() for index in np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij"))
    a = i * (columns + 1) + j
    b, c, d = a + columns + 1, a + columns + 2, a + 1
    if alternate:
        other = (i + j) % 2 == 0
    else:
        other = np.linalg.norm(points[a] - points[c], axis=1) > np.linalg.norm(points[b] - points[d], axis=1)
    first = np.where(other, [a, b, d], [a, b, c]).T
    second = np.where(other, [b, c, d], [a, c, d]).T
    return np.concatenate((first, second))


def lines(n: int, ratio: float) -> Float64:
    """Positions 0..1 of n + 1 lines whose gaps are by turns 1 and `ratio`."""
    gaps = np.where(np.arange(n) % 2, ratio, 1.0)
    return np.concatenate(([0.0], np.cumsum(gaps))) / gaps.sum()


def cubic_surface() -> pv.PolyData:
    """Return z = 4x^3 + 6y^3 over a square: 1720 points that lie on it, badly placed."""
    nx, ny = CUBIC_LINES
    x, y = np.meshgrid(2.0 * lines(nx, CUBIC_SPACING) - 1.0, np.linspace(-1.0, 1.0, ny + 1), indexing="ij")
    # Every second line of points is shifted along itself, the others the other way; the boundary is not.
    y[1:-1:2, 1:-1] += CUBIC_SHIFT * 2.0 / ny
    y[2:-1:2, 1:-1] -= CUBIC_SHIFT * 2.0 / ny
    x, y = CUBIC_HALF_WIDTH * x.ravel(), CUBIC_HALF_WIDTH * y.ravel()
    points = np.column_stack((x, y, 4.0 * x**3 + 6.0 * y**3))
    return polydata(points, grid_triangles(points, nx, ny))


def flipped(mesh: pv.PolyData, share: float, seed: int = 0) -> pv.PolyData:
    """Flip a share of the edges of a terrain of triangles, at random; no face turns over."""
    points = np.asarray(mesh.points)
    faces: list[list[int]] = mesh.regular_faces.tolist()
    face = {edge: f for f, corners in enumerate(faces) for edge in _sides(corners)}
    inner = [edge for edge in face if edge[0] < edge[1] and edge[::-1] in face]

    def area(a: int, b: int, c: int) -> float:
        u, v = points[b, :2] - points[a, :2], points[c, :2] - points[a, :2]
        return float(u[0] * v[1] - u[1] * v[0])

    left = round(share * len(inner))
    for a, b in np.random.default_rng(seed).permutation(inner).tolist():
        if left == 0:
            break
        if (a, b) not in face or (b, a) not in face:
            continue
        f, g = face[a, b], face[b, a]
        (c,) = set(faces[f]) - {a, b}
        (d,) = set(faces[g]) - {a, b}
        first, second = area(a, d, c), area(d, b, c)
        if (c, d) in face or (d, c) in face or min(first, second) < 0.05 * abs(first + second):
            continue
        for edge in _sides(faces[f]) + _sides(faces[g]):
            del face[edge]
        for number, corners in ((f, [a, d, c]), (g, [d, b, c])):
            faces[number] = corners
            face.update(dict.fromkeys(_sides(corners), number))
        left -= 1
    return polydata(points, np.array(faces))


def _sides(corners: list[int]) -> list[tuple[int, int]]:
    a, b, c = corners
    return [(a, b), (b, c), (c, a)]


def resampled_scan(scan: pv.PolyData) -> pv.PolyData:
    """Resample the head of a cylindrical scan (27 rings of 189 points), with points badly placed.

    The same surface, but 73 rings of 144 points: columns by turns 1 and 3 apart, every second ring shifted
    along itself by 0.6 columns, and noise of 0.15 columns along the ring; split by turns.
    """
    rings, columns = 72, 144
    u, v = np.meshgrid(np.linspace(0.0, 1.0, rings + 1), lines(columns, 3.06), indexing="ij")
    v[1:-1:2] += 0.6 / columns
    v[2:-1:2] -= 0.6 / columns
    v[1:-1] += np.random.default_rng(0).normal(0.0, 0.146 / columns, (rings - 1, 1))
    points = _on_scan(np.asarray(scan.points, dtype=float).reshape(27, 189, 3), u.ravel(), v.ravel())
    return polydata(points, grid_triangles(points, rings, columns, alternate=True)[:, ::-1])


def _cubic_weights(t: Float64) -> list[Float64]:
    # Catmull and Rom's interpolation between the middle two of four points.
    return [
        (-t + 2 * t**2 - t**3) / 2,
        1 - (5 * t**2 - 3 * t**3) / 2,
        (t + 4 * t**2 - 3 * t**3) / 2,
        (t**3 - t**2) / 2,
    ]


def _on_scan(rings: Float64, u: Float64, v: Float64) -> Float64:
    n, m = rings.shape[:2]
    row = np.minimum((u * (n - 1)).astype(int), n - 2)
    place = (v % 1.0) * m
    column = np.floor(place).astype(int)
    points = np.zeros((len(u), 3))
    for i, along in enumerate(_cubic_weights((u * (n - 1) - row)[:, None])):
        for j, around in enumerate(_cubic_weights((place - column)[:, None])):
            points += along * around * rings[np.clip(row + i - 1, 0, n - 1), (column + j - 1) % m]
    return points


def terrain(side: int = 161, interval: float = 60.0) -> pv.PolyData:
    """Terrain from contour lines: some hills, points where the lines of a grid cross the contours, Delaunay.

    Points come close together along contours and far apart between them, and triangles with all corners
    on one contour are flat, as in terrain made from maps.
    """
    x, y = np.meshgrid(np.linspace(-1.0, 1.0, side), np.linspace(-1.0, 1.0, side))
    height = 900.0 * np.exp(-3.0 * (x**2 + 1.4 * y**2)) + 250.0 * np.sin(3.1 * x + 1.7 * y) * np.cos(2.3 * y)
    height += 320.0 * np.exp(-25.0 * ((x - 0.55) ** 2 + (y + 0.45) ** 2))
    grid = pv.ImageData(dimensions=(side, side, 1), spacing=(8000.0 / (side - 1), 8000.0 / (side - 1), 1.0))
    grid["height"] = height.ravel()
    levels = np.arange(np.floor(height.min()), height.max(), interval) + 0.5 * interval
    contours = grid.contour(levels, scalars="height").clean()
    rim = grid.extract_feature_edges(feature_edges=False, non_manifold_edges=False)
    places = np.concatenate((contours.points[::4, :2], rim.points[::8, :2]))
    heights = np.concatenate((contours["height"][::4], rim["height"][::8]))
    flat = pv.PolyData(np.column_stack((places, np.zeros(len(places))))).delaunay_2d()
    faces = flat.regular_faces
    a, b, c = (places[faces[:, i]] for i in range(3))
    up = (b - a)[:, 0] * (c - a)[:, 1] > (b - a)[:, 1] * (c - a)[:, 0]
    return polydata(np.column_stack((places, heights)), np.where(up[:, None], faces, faces[:, ::-1]))


def pyramid(sides: int = 6, tilt: float = 28.0) -> pv.PolyData:
    """Return a pyramid without its base whose corners and apex, off the axis, lie on the unit sphere.

    The apex is the last point; `tilt` is its angle to the axis, degrees; the base's corners are at 55.
    """
    around = 2.0 * np.pi * np.arange(sides) / sides
    low, high = np.radians(55.0), np.radians(tilt)
    base = np.column_stack(
        (np.sin(low) * np.cos(around), np.sin(low) * np.sin(around), np.full(sides, np.cos(low)))
    )
    points = np.vstack((base, [np.sin(high) * np.cos(0.4), np.sin(high) * np.sin(0.4), np.cos(high)]))
    return polydata(points, np.array([[i, (i + 1) % sides, sides] for i in range(sides)]))


def layers(spacings: tuple[float, ...] = (1.0, 0.5, 0.25, 0.5, 1.0), jitter: float = 0.2) -> pv.PolyData:
    """Return an arched strip of layers of triangles, each of its own size, points inside thrown about.

    The cell array ``Layer`` numbers the layers, the point array ``Border`` is 1 where two of them meet.
    """
    length, depth = 12.0, 4.0
    rows, border, y = [], [], 0.0
    for number, h in enumerate(spacings):
        for row in range(round(depth / h) + 1):
            if row == 0 and number > 0:
                continue
            count = round(length / h)
            finer = min(h, spacings[min(number + 1, len(spacings) - 1)]) if row == round(depth / h) else h
            count = round(length / finer)
            rows.append(
                np.column_stack((np.linspace(0.0, length, count + 1), np.full(count + 1, y + row * h)))
            )
            last = row == round(depth / h) and number + 1 < len(spacings)
            border.append(np.full(count + 1, last))
        y += depth
    places, met = np.concatenate(rows), np.concatenate(border)
    inside = (places[:, 0] > 0) & (places[:, 0] < length) & (places[:, 1] > 0) & (places[:, 1] < y)
    size = np.array(spacings)[np.minimum((places[:, 1] / depth).astype(int), len(spacings) - 1)]
    # The triangles are those of the places before they are thrown: layers are of equal triangles at first.
    shear = places + np.column_stack((1e-3 * places[:, 1], np.zeros(len(places))))
    flat = pv.PolyData(np.column_stack((shear, np.zeros(len(places))))).delaunay_2d()
    faces = flat.regular_faces
    a, b, c = (places[faces[:, i]] for i in range(3))
    up = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    faces = np.where((up > 0.0)[:, None], faces, faces[:, ::-1])[np.abs(up) > 1e-6]
    layer = np.minimum((places[faces].mean(axis=1)[:, 1] / depth).astype(int), len(spacings) - 1)
    push = np.random.default_rng(0).uniform(-jitter, jitter, places.shape)
    places = places + (inside & ~met)[:, None] * size[:, None] * push
    turn = np.pi * (places[:, 0] / length - 0.5) / 2.0
    arch = np.column_stack((np.sin(turn), np.zeros(len(turn)), np.cos(turn))) * (2.0 * length / np.pi)
    mesh = polydata(arch + np.column_stack((0.0 * turn, places[:, 1], 0.0 * turn)), faces)
    mesh["Layer"], mesh["Border"] = layer, met.astype(np.uint8)
    return mesh


def gyroid(samples: int = 58, periods: int = 3, level: float = 1.1) -> pv.PolyData:
    """Return an open marching-cubes gyroid, float64: slivers everywhere, sharp edges at its thin necks."""
    side = 2.0 * np.pi * periods
    grid = pv.ImageData(dimensions=(samples,) * 3, spacing=(side / (samples - 1),) * 3)
    x, y, z = np.asarray(grid.points, dtype=float).T
    grid["gyroid"] = np.sin(x) * np.cos(y) + np.sin(y) * np.cos(z) + np.sin(z) * np.cos(x)
    surface = grid.contour([level], scalars="gyroid", method="flying_edges").clean()
    return polydata(np.asarray(surface.points, dtype=float), surface.regular_faces)


def quad_torus(around: int = 120, across: int = 60, noise: float = 0.3, seed: int = 1) -> pv.PolyData:
    """Return a torus of quadrilaterals whose points are displaced on it, normally by `noise` of a cell."""
    u, v = np.meshgrid(np.arange(around), np.arange(across), indexing="ij")
    random = np.random.default_rng(seed)
    a = 2.0 * np.pi * (u + np.clip(random.normal(0.0, noise, u.shape), -0.45, 0.45)) / around
    b = 2.0 * np.pi * (v + np.clip(random.normal(0.0, noise, v.shape), -0.45, 0.45)) / across
    tube = 2.0 + np.cos(b)
    points = np.stack((tube * np.cos(a), tube * np.sin(a), np.sin(b)), axis=-1).reshape(-1, 3)
    next_u, next_v = (u + 1) % around, (v + 1) % across
    faces = np.stack((u * across + v, next_u * across + v, next_u * across + next_v, u * across + next_v), -1)
    return polydata(points, faces.reshape(-1, 4))


def graded_torus(ratio: float, around: int = 120, across: int = 60) -> tuple[pv.PolyData, Float64]:
    """Return a torus (radii 3 and 1) of triangles whose rows are by turns narrow and `ratio` times as wide.

    And its unit normals, (n, 3).
    """
    u, v = (2.0 * np.pi * lines(count, ratio)[:-1] for count in (around, across))
    u, v = (angle.ravel() for angle in np.meshgrid(u, v, indexing="ij"))
    normals = np.column_stack((np.cos(v) * np.cos(u), np.cos(v) * np.sin(u), np.sin(v)))
    points = normals + 3.0 * np.column_stack((np.cos(u), np.sin(u), np.zeros(len(u))))
    i, j = (index.ravel() for index in np.meshgrid(np.arange(around), np.arange(across), indexing="ij"))
    after_i, after_j = (i + 1) % around, (j + 1) % across
    a, b, c, d = i * across + j, after_i * across + j, after_i * across + after_j, i * across + after_j
    return polydata(points, np.concatenate((np.column_stack((a, b, c)), np.column_stack((a, c, d))))), normals


def sphere(triangles: int, noise: float = 0.0, shuffled: bool = False, seed: int = 0) -> pv.PolyData:
    """Return a unit sphere of about `triangles` triangles, float64: an octahedron, subdivided.

    Parameters
    ----------
    noise : float
        Standard deviation of each coordinate, in mean edge lengths, before points are put back on the sphere.
    shuffled : bool
        Number points and faces at random instead of row after row.
    """
    n = max(2, round(np.sqrt(triangles / 8.0)))
    points, faces = _octahedron(n)
    points /= np.linalg.norm(points, axis=1)[:, None]
    random = np.random.default_rng(seed)
    if noise:
        # A sphere of area 4 pi, cut into equilateral triangles.
        edge = np.sqrt(4.0 * np.pi / len(faces) * 4.0 / np.sqrt(3.0))
        points += random.normal(0.0, noise * edge, points.shape)
        points /= np.linalg.norm(points, axis=1)[:, None]
    if shuffled:
        order = random.permutation(len(points))
        rank = np.empty_like(order)
        rank[order] = np.arange(len(order))
        points, faces = points[order], rank[faces][random.permutation(len(faces))]
    return polydata(points, faces)


def _octahedron(n: int) -> tuple[Float64, Int64]:
    # The faces of an octahedron unfold to a square of 2n by 2n cells, whose boundary is folded together:
    # |x| + |y| <= n above; the corners of the square below.
    i, j = np.meshgrid(np.arange(-n, n + 1), np.arange(-n, n + 1), indexing="ij")
    x, y = i.astype(float), j.astype(float)
    inside = np.abs(i) + np.abs(j) <= n
    z = n - np.abs(x) - np.abs(y)
    fx = np.where(inside, x, np.where(x >= 0, 1, -1) * (n - np.abs(y)))
    fy = np.where(inside, y, np.where(y >= 0, 1, -1) * (n - np.abs(x)))
    points = np.stack((fx, fy, z), axis=-1).reshape(-1, 3)
    a = (np.arange(2 * n)[:, None] * (2 * n + 1) + np.arange(2 * n)).ravel()
    b, c, d = a + 2 * n + 1, a + 2 * n + 2, a + 1
    # Diagonals run along the octahedron's edges.
    row, column = a // (2 * n + 1), a % (2 * n + 1)
    rising = (row < n) == (column < n)
    faces = np.concatenate(
        (np.where(rising, [a, b, d], [a, b, c]).T, np.where(rising, [b, c, d], [a, c, d]).T)
    )
    return _merged(points, faces)


def notched_sphere(n: int, noise: float = 0.25, seed: int = 0) -> pv.PolyData:
    """Return a unit sphere without the octant where all coordinates are positive: Jiao, figure 4.

    Parameters
    ----------
    n : int
        Edges along each quarter of a circle and each straight ridge; the notch has six such ridges.
    noise : float
        Standard deviation of the displacement, in edges: points stay on the sphere, on the flat walls and on
        the ridges that they are on.
    """
    i, j = (index.ravel() for index in np.meshgrid(np.arange(n + 1), np.arange(n + 1), indexing="ij"))
    weights = np.column_stack((n - i, i - j, j))[j <= i]  # of the corners a, b, c of a patch
    row = np.cumsum(np.arange(n + 2))
    faces = [[row[k] + m, row[k + 1] + m, row[k + 1] + m + 1] for k in range(n) for m in range(k + 1)]
    faces += [[row[k] + m, row[k + 1] + m + 1, row[k] + m + 1] for k in range(n) for m in range(k)]
    patches: list[Int64] = []
    triangles: list[Int64] = []
    for signs in np.ndindex(2, 2, 2):
        if any(signs):
            patches.append(weights * (1 - 2 * np.array(signs)))
            triangles.append(np.array(faces)[:, :: -1 if sum(signs) % 2 else 1])
    for axis in range(3):  # the walls, from the middle outwards
        wall = np.zeros_like(weights)
        wall[:, (axis + 1) % 3], wall[:, (axis + 2) % 3] = weights[:, 1], weights[:, 2]
        patches.append(wall)
        triangles.append(np.array(faces))
    of_patch = np.arange(len(patches))[:, None, None] * len(weights)
    lattice, triangles_merged = _merged(
        np.concatenate(patches).astype(float), (np.array(triangles) + of_patch).reshape(-1, 3)
    )
    # |x| + |y| + |z| is n on the sphere, less on the walls.
    length, norm = np.abs(lattice).sum(axis=1), np.linalg.norm(lattice, axis=1)
    points = lattice / np.where(norm > 0, norm, 1.0)[:, None] * (length / n)[:, None]
    wall = (lattice >= 0).all(axis=1) & (lattice == 0).any(axis=1)
    moves = np.random.default_rng(seed).normal(0.0, noise * np.pi / 2 / n, points.shape)
    moves[wall[:, None] & (lattice == 0)] = 0.0  # in the planes and along the straight ridges
    moves[wall & ((lattice == 0).sum(axis=1) >= 2) & ((length == n) | (length == 0))] = 0.0  # the corners
    points += moves
    on_sphere = length == n
    points[on_sphere] /= np.linalg.norm(points[on_sphere], axis=1)[:, None]
    return polydata(points, triangles_merged)


def _merged(points: Float64, faces: Int64) -> tuple[Float64, Int64]:
    # Whole numbers: equal points are exactly equal. The order of first appearance is kept.
    _, first, inverse = np.unique(points, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    return points[np.sort(first)], rank[inverse.ravel()][faces]


def wedge(angle: float, n: int = 20, seed: int = 0) -> tuple[pv.PolyData, Int64]:
    """Two squares that meet at `angle` degrees inside, with points thrown about in their planes.

    Returns
    -------
    mesh : PolyData
    labels : (points,) int64
        0 smooth, 1 ridge, -1 on the boundary.
    """
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(2 * n + 1.0), np.arange(n + 1.0), indexing="ij"))
    boundary = (x == 0) | (x == 2 * n) | (y == 0) | (y == n)
    ridge = (x == n) & ~boundary
    push = np.random.default_rng(seed).uniform(-0.3, 0.3, (2, len(x)))
    x = x + np.where(boundary | ridge, 0.0, push[0])
    y = y + np.where(boundary, 0.0, push[1])
    half = np.radians(angle) / 2.0
    points = np.column_stack((np.abs(x - n) * -np.cos(half), y, (x - n) * np.sin(half)))
    flat = np.column_stack((x, y, np.zeros(len(x))))
    labels = np.where(boundary, -1, np.where(ridge, 1, 0))
    return polydata(points, grid_triangles(flat, 2 * n, n)), labels


def blocks(cells: Float64, n: int = 10, seed: int = 0) -> tuple[pv.PolyData, Int64]:
    """Return the surface of unit cubes at whole `cells`, (c, 3), in steps of 1 / n; labels 0, 1, 2 (corner).

    Points are thrown about in their planes and along their ridges.
    """
    size = (int(cells.max()) + 1) * n
    solid = np.zeros((size + 2, size + 2, size + 2), bool)
    for i, j, k in (cells * n).astype(int) + 1:
        solid[i : i + n, j : j + n, k : k + n] = True
    squares = []
    for axis in range(3):
        # Between a full cell and an empty one stands a square, turned outwards.
        for side in (1, -1):
            i, j, k = np.nonzero(solid & ~np.roll(solid, -side, axis))
            corner = np.stack((i, j, k), -1)
            corner[:, axis] += side == 1
            u, v = np.eye(3, dtype=int)[(axis + 1) % 3], np.eye(3, dtype=int)[(axis + 2) % 3]
            square = [corner, corner + u, corner + u + v, corner + v]
            squares.append(np.stack(square if side == 1 else square[::-1], 1))
    corners = np.concatenate(squares)
    points, faces = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    faces = faces.reshape(-1, 4)
    # How many of the axes the planes round a point are across.
    across = np.zeros((len(points), 3), bool)
    for axis in range(3):
        across[faces[np.ptp(corners[:, :, axis], axis=1) == 0], axis] = True
    labels = across.sum(axis=1) - 1
    random = np.random.default_rng(seed)
    moved = (points + np.where(across, 0.0, random.uniform(-0.3, 0.3, points.shape))) / n
    split = random.random(len(faces)) < 0.5
    first = np.where(split[:, None], faces[:, [0, 1, 2]], faces[:, [0, 1, 3]])
    second = np.where(split[:, None], faces[:, [0, 2, 3]], faces[:, [1, 2, 3]])
    return polydata(moved, np.concatenate((first, second))), labels
