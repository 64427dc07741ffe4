"""Points of a mesh as they stand on a screen: where, which of them are seen, which lie under a stroke."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ...jit import parallel
from ...jit.compiled import kernel

Bool = npt.NDArray[np.bool_]
Float32 = npt.NDArray[np.float32]

#: How far behind what is drawn there a point may be to count as seen, pixels: what is rough on the scale of a
#: pixel has depths that no pixel shows.
_BEHIND = 3.0


@kernel
def _project(starts, ends, points, matrix, x0, y0, width, height, behind, places):
    # Clip coordinates are linear: a step up by s changes y by s |up|, a step away from the eye changes depth
    # and w. Without perspective w is 1 everywhere.
    up = np.sqrt(matrix[1, 0] ** 2 + matrix[1, 1] ** 2 + matrix[1, 2] ** 2)
    row = 3 if matrix[3, 0] != 0.0 or matrix[3, 1] != 0.0 or matrix[3, 2] != 0.0 else 2
    size = np.sqrt(matrix[row, 0] ** 2 + matrix[row, 1] ** 2 + matrix[row, 2] ** 2)
    away_depth = 0.0
    away_w = 0.0
    for axis in range(3):
        away_depth += matrix[2, axis] * matrix[row, axis] / size
        away_w += matrix[3, axis] * matrix[row, axis] / size
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            x = points[v, 0]
            y = points[v, 1]
            z = points[v, 2]
            w = matrix[3, 0] * x + matrix[3, 1] * y + matrix[3, 2] * z + matrix[3, 3]
            if not w > 0.0:  # behind the eye, or NaN
                for column in range(4):
                    places[v, column] = np.nan
                continue
            a = (matrix[0, 0] * x + matrix[0, 1] * y + matrix[0, 2] * z + matrix[0, 3]) / w
            b = (matrix[1, 0] * x + matrix[1, 1] * y + matrix[1, 2] * z + matrix[1, 3]) / w
            places[v, 0] = x0 + 0.5 * (a + 1.0) * width
            places[v, 1] = y0 + 0.5 * (b + 1.0) * height
            depth = matrix[2, 0] * x + matrix[2, 1] * y + matrix[2, 2] * z + matrix[2, 3]
            places[v, 2] = depth / w
            step = behind * 2.0 * w / (height * up)
            places[v, 3] = (depth - step * away_depth) / (w - step * away_w)


def project(
    points: npt.NDArray[np.float64], matrix: npt.ArrayLike, viewport: tuple[float, float, float, float]
) -> Float32:
    """Return where points stand on the screen.

    Parameters
    ----------
    points : (n, 3) float64
    matrix : (4, 4) array_like
        From the world to the view: x and y from -1 to 1, depth from 0 (near) to 1.
    viewport : tuple of float
        Left, bottom, width and height, pixels.

    Returns
    -------
    (n, 4) float32
        Pixels from the left and from the bottom, the depth, and the depth three pixels nearer to the eye;
        NaN behind it.

    Examples
    --------
    >>> import numpy as np
    >>> project(np.array([[0.5, 0.0, 0.25]]), np.eye(4), (0, 0, 200, 100))[:, :3].tolist()
    [[150.0, 50.0, 0.25]]
    """
    places = np.empty((len(points), 4), np.float32)
    parallel.run(
        _project, *parallel.ranges(len(points)), points, np.ascontiguousarray(matrix, dtype=np.float64),
        *(float(value) for value in viewport), _BEHIND, places,
    )  # fmt: skip
    return places


@kernel
def _seen(starts, ends, places, depths, found):
    rows, columns = depths.shape
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            found[v] = False
            if not (0.0 <= places[v, 0] < columns and 0.0 <= places[v, 1] < rows and places[v, 2] >= 0.0):
                continue
            row = int(places[v, 1])
            column = int(places[v, 0])
            # A pixel's depth is that at its centre: where the surface is steep, a neighbour's is nearer to
            # that of the point.
            farthest = np.float32(0.0)
            for i in range(max(0, row - 1), min(rows, row + 2)):
                for j in range(max(0, column - 1), min(columns, column + 2)):
                    farthest = max(farthest, depths[i, j])
            found[v] = places[v, 3] <= farthest


def seen(places: Float32, depths: Float32) -> Bool:
    """Return which points are in the picture and not hidden by what is drawn before them.

    Parameters
    ----------
    places : (n, 4) float32
        What :func:`project` returned.
    depths : (rows, columns) float32
        The depth buffer, its first row at the bottom.
    """
    found = np.empty(len(places), np.bool_)
    buffer = np.ascontiguousarray(depths, dtype=np.float32)
    parallel.run(_seen, *parallel.ranges(len(places)), places, buffer, found)
    return found


@kernel
def _under_stroke(starts, ends, places, allowed, ax, ay, bx, by, radius, found):
    dx = bx - ax
    dy = by - ay
    square = dx * dx + dy * dy
    new = 0
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            x = places[v, 0] - ax
            y = places[v, 1] - ay
            t = 0.0
            if square > 0.0:
                t = min(1.0, max(0.0, (x * dx + y * dy) / square))
            x -= t * dx
            y -= t * dy
            if x * x + y * y <= radius * radius and allowed[v] and not found[v]:
                found[v] = True
                new += 1
    return new


def add_stroke(
    places: Float32,
    allowed: Bool,
    start: tuple[float, float],
    end: tuple[float, float],
    radius: float,
    found: Bool,
) -> int:
    """Mark in `found` the points that a round brush touches on its way from `start` to `end`.

    Every point is looked at: that takes less time than a picture, and needs nothing built beforehand.

    Parameters
    ----------
    places : (n, 4) float32
        What :func:`project` returned.
    allowed : (n,) bool
        Points that may be marked.
    start, end : tuple of float
        Pixels.
    radius : float
        Pixels.
    found : (n,) bool
        Is changed.

    Returns
    -------
    int
        How many points have been marked that were not.
    """
    way = (*(float(value) for value in (*start, *end)), float(radius))
    return sum(parallel.run(_under_stroke, *parallel.ranges(len(places)), places, allowed, *way, found))


@kernel
def _inside(starts, ends, places, allowed, outline, low, high, found):
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            x = places[v, 0]
            y = places[v, 1]
            inside = False
            if allowed[v] and low[0] <= x <= high[0] and low[1] <= y <= high[1]:
                j = outline.shape[0] - 1
                for i in range(outline.shape[0]):
                    if (outline[i, 1] > y) != (outline[j, 1] > y):
                        part_way = (y - outline[i, 1]) / (outline[j, 1] - outline[i, 1])
                        if x < outline[i, 0] + part_way * (outline[j, 0] - outline[i, 0]):
                            inside = not inside
                    j = i
            found[v] = inside


def inside_outline(places: Float32, allowed: Bool, outline: npt.ArrayLike) -> Bool:
    """Return which of the allowed points lie inside a closed outline on the screen (even-odd rule).

    Parameters
    ----------
    places : (n, 4) float32
        What :func:`project` returned.
    allowed : (n,) bool
    outline : (k, 2) array_like
        Pixels; the last corner is joined to the first.
    """
    corners = np.ascontiguousarray(outline, dtype=np.float64)
    found = np.zeros(len(places), np.bool_)
    if len(corners) >= 3:
        parallel.run(
            _inside, *parallel.ranges(len(places)), places, allowed, corners, corners.min(axis=0),
            corners.max(axis=0), found,
        )  # fmt: skip
    return found
