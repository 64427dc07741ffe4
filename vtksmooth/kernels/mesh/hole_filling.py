"""Hole filling: lids of least area over the holes of a surface."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ...jit.compiled import kernel

Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]

#: A rim with more corners is cut in two along a short chord first: the time grows with the third power.
_LARGEST_RIM = 400

#: Weight of squared lengths of sides beside the area: of lids with the same area, as over flat rims, those of
#: compact triangles.
_COMPACT = 1e-9


@kernel
def _least(points, rim, cost, middle):
    # cost[i, j]: the least one of what is between the chord from i to j and the rim; middle[i, j]: the third
    # corner of the triangle on that chord.
    n = rim.size
    for i in range(n - 1):
        cost[i, i + 1] = 0.0
    for span in range(2, n):
        for i in range(n - span):
            j = i + span
            best = np.inf
            for m in range(i + 1, j):
                square = 0.0
                ux = points[rim[m], 0] - points[rim[i], 0]
                uy = points[rim[m], 1] - points[rim[i], 1]
                uz = points[rim[m], 2] - points[rim[i], 2]
                vx = points[rim[j], 0] - points[rim[i], 0]
                vy = points[rim[j], 1] - points[rim[i], 1]
                vz = points[rim[j], 2] - points[rim[i], 2]
                square += (uy * vz - uz * vy) ** 2
                square += (uz * vx - ux * vz) ** 2
                square += (ux * vy - uy * vx) ** 2
                long = vx * vx + vy * vy + vz * vz
                total = cost[i, m] + cost[m, j] + 0.5 * np.sqrt(square) + _COMPACT * long
                if total < best:
                    best = total
                    middle[i, j] = m
            cost[i, j] = best


def rims(boundaries: npt.NDArray[np.integer]) -> list[Int32]:
    """Return the closed lines that directed edges form, as lists of points; each passes a point once.

    Parameters
    ----------
    boundaries : (b, 2) integers
        From where to where; at every point as many must end as begin.
    """
    waiting: dict[int, list[int]] = {}
    for start, end in boundaries[::-1].tolist():
        waiting.setdefault(start, []).append(end)
    found = []
    for first in waiting:
        while waiting[first]:
            line, place = [first], {first: 0}
            while True:
                point = waiting[line[-1]].pop()
                if point not in place:
                    place[point] = len(line)
                    line.append(point)
                    continue
                loop = line[place[point] :]
                found.append(np.array(loop, np.int32))
                if point == first:
                    break
                for passed in loop[1:]:
                    del place[passed]
                del line[place[point] + 1 :]
    return found


def _halves(points: Float64, rim: Int32) -> tuple[Int32, Int32]:
    """Cut a long rim along the shortest chord that leaves a third of it or more on either side."""
    n = len(rim)
    i = np.arange(0, n, max(1, n // 500))
    steps = np.arange(n // 3, n // 2 + 1, max(1, n // 1500))
    j = (i[:, None] + steps) % n
    length = np.linalg.norm(points[rim[j]] - points[rim[i]][:, None], axis=2)
    row, column = np.unravel_index(length.argmin(), length.shape)
    first, second = sorted((int(i[row]), int(j[row, column])))
    return rim[first : second + 1], np.concatenate((rim[second:], rim[: first + 1]))


def lid(points: Float64, rim: Int32) -> Int32:
    """Return triangles between the points of a closed line, (k - 2, 3) int32, that turn as it does.

    Those of least area: G. Barequet, M. Sharir, "Filling Gaps in the Boundary of a Polyhedron" (1995),
    DOI 10.1016/0167-8396(94)00011-G. Over a flat rim they lie flat within it.

    Parameters
    ----------
    points : (n, 3) float64
    rim : (k,) int32
        Where it passes more than 400 points it is cut in two first.

    Examples
    --------
    >>> import numpy as np
    >>> square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    >>> lid(square, np.arange(4, dtype=np.int32)).tolist()
    [[0, 1, 3], [1, 2, 3]]
    """
    n = len(rim)
    if n > _LARGEST_RIM:
        return np.concatenate([lid(points, half) for half in _halves(points, rim)])
    cost, middle = np.empty((n, n)), np.empty((n, n), np.int32)
    _least(points, rim, cost, middle)
    found, waiting = [], [(0, n - 1)]
    while waiting:
        i, j = waiting.pop()
        if j - i > 1:
            m = int(middle[i, j])
            found.append((i, m, j))
            waiting += [(m, j), (i, m)]
    return rim[np.array(found, np.int32).reshape(-1, 3)]
