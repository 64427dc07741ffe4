"""Low-pass filter of the surface as a signal: what is shorter than a wavelength goes, as weakly as it may."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt
from numpy.polynomial.chebyshev import chebinterpolate

from ....jit import parallel
from ....jit.compiled import kernel
from ....report import RunReport
from ...measures.aspect_ratio import area_vectors, ring_normals
from ...measures.comparison import swept_at_corners
from ...mesh.adjacency import INTERIOR, LINE
from ...mesh.mesh import Mesh
from ..run_state import State
from ..weights import Weights
from . import Float64, Int64, Scheme

Int32 = npt.NDArray[np.int32]

#: Strengths of the filter: multiples of the frequency at which half of a wave is left.
STRENGTHS = (1.0, 2.0, 4.0, 8.0, 16.0)

#: Frequency at half height where the mesh says it: a wavelength of 13 edges (root mean square), 15 voxels.
USUAL_FREQUENCY = 0.06

#: Degree of the polynomials that stand for the filters, at the usual frequency.
_DEGREE = 30

#: Largest degree; by it the longest wavelength is 300 voxels.
_LARGEST_DEGREE = 600

#: Bounds on the height that is swept, in edges, over balls of some four edges: by one strength against the
#: start, and against weaker strengths.
_SWEPT, _APART = 0.15, 0.03

#: Where the height that is swept is below this, in edges, it is left; above, it is given back.
_LEFT = 0.06

#: Iterations by which what was shortened at first may go on.
_TURNS = 2


@kernel
def _step(
    starts, ends, offsets, neighbours, weights, moves, field, factor, share, coefficients, before, sums
):
    # (I - K) field times `factor`, less `share` of what is in `before`, put there; K is diag(moves) (I - W).
    # And that times each coefficient added to each of the sums.
    width = field.shape[1]
    mean = np.empty(width)
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            mean[:] = 0.0
            for r in range(offsets[v], offsets[v + 1]):
                w = neighbours[r]
                for axis in range(width):
                    mean[axis] += weights[r] * (field[w, axis] - field[v, axis])
            for axis in range(width):
                term = factor * (field[v, axis] + moves[v] * mean[axis]) - share * before[v, axis]
                before[v, axis] = term
                for i in range(coefficients.size):
                    sums[i, v, axis] += coefficients[i] * term


@kernel
def _go(starts, ends, points, start, target, pinned, factors, proposed):
    # Of the way from the start each vertex takes its factor in all, whatever it has taken of it.
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            factor = factors[v] if factors.size > 0 else 1.0
            for axis in range(3):
                proposed[v, axis] = points[v, axis]
                if factor == 1.0 and not pinned[v]:
                    proposed[v, axis] = target[v, axis]
                elif factor > 0.0 and not pinned[v]:
                    aim = start[v, axis] + factor * (target[v, axis] - start[v, axis])
                    proposed[v, axis] += (aim - points[v, axis]) / factor


def half_height(frequency: float, strength: float) -> Callable[[Float64], Float64]:
    """Return the filter 1 / (1 + (k / (strength frequency))^2)."""
    return lambda k: 1.0 / (1.0 + (k / (frequency * strength)) ** 2)


def diffusion(time: float) -> Callable[[Float64], Float64]:
    """Return the filter exp(-time k)."""
    return lambda k: np.exp(-time * k)


def coefficients(response: Callable[[Float64], Float64], degree: int) -> Float64:
    """Return the coefficients of a filter's response in the polynomials T_n(1 - k), 0 <= k <= 2.

    Their sum, the response at k = 0, is exactly 1.
    """
    interpolate: Any = chebinterpolate  # of any function of arrays
    found = np.asarray(interpolate(lambda x: response(1.0 - x), degree), dtype=np.float64)
    found /= found.sum()
    return found


class Graph:
    """The Laplacian I - W of the edges, and filters of it.

    Parameters
    ----------
    offsets, neighbours : int32
    weights : (k,) float64
        Rows that sum to 1; each proportional to a symmetric matrix, whose rows sum to `sums`.
    sums : (n,) float64
    """

    def __init__(self, offsets: Int32, neighbours: Int32, weights: Float64, sums: Float64) -> None:
        self.offsets, self.neighbours, self.weights, self.sums = offsets, neighbours, weights, sums
        self.ranges = parallel.ranges(len(sums))

    def filtered(self, field: Float64, moves: Float64, series: Float64) -> Float64:
        """Return several filters of a field, (f, n, c), each given by its coefficients, (f, degree + 1).

        Where `moves` is 0 the field stays, elsewhere it goes as far as that says.
        """
        term, spare = field.copy(), field.copy()
        sums = series[:, 0, None, None] * field
        for degree in range(1, series.shape[1]):
            first = degree == 1
            parallel.run(
                _step, *self.ranges, self.offsets, self.neighbours, self.weights, moves, term,
                1.0 if first else 2.0, 0.0 if first else 1.0, np.ascontiguousarray(series[:, degree]), spare,
                sums,
            )  # fmt: skip
            term, spare = spare, term
        return sums

    def spread(self, amounts: Float64, time: float) -> Float64:
        """Return amounts at the vertices, (n, c), spread out to their neighbours; their sums stay."""
        everywhere = np.ones(len(self.sums))
        series = coefficients(diffusion(time), 4 + int(3.0 * math.sqrt(time)))
        size = np.maximum(self.sums, 1e-300)[:, None]
        spread: Float64 = self.filtered(amounts / size, everywhere, series[None])[0]
        spread *= size
        return spread


class LowPass(Scheme):
    """Go where a low-pass filter of the points puts each vertex, filtered as strongly as the place allows.

    Five strengths of one filter are taken of the points at the start. At each vertex the strongest one counts
    whose surface is nowhere near farther from the start, and from what weaker ones make, than noise explains
    (Lepski's rule; heights are volumes swept over areas, both spread out over some four edges). What is left
    of the volume swept is given back locally, as far as it is more than the rule lets pass.

    Parameters
    ----------
    wavelength : float, optional
        Of the waves of which the strongest filter leaves half; model units. None: 13 edges (root mean
        square), which are 15 voxels on a voxel skin.
    """

    def __init__(self, wavelength: float | None = None) -> None:
        self.asked = wavelength
        #: The wavelength that was used, and the frequency that it is on the mesh.
        self.wavelength = self.frequency = 0.0

    def bind(self, state: State) -> None:
        self._turn = 0
        near = state.near
        weights = Weights()
        offsets, neighbours = weights.rows(near)
        size = np.diff(offsets).astype(np.float64)
        self._graph = Graph(offsets, neighbours, weights.compute(state.points, near), size)
        owner = np.repeat(np.arange(len(size)), np.diff(offsets))
        edges = np.linalg.norm(state.points[neighbours] - state.points[owner], axis=1)
        square = float(np.mean(edges**2)) if len(edges) else 0.0
        # The smallest edges of a voxel skin are the voxels'; of all edges some are diagonals.
        self._edge = float(np.quantile(edges, 0.1)) if len(edges) else 0.0
        # A wave of length L has the frequency k = (2 pi / L)^2 <e^2> / 4, whichever way it runs.
        self.frequency = USUAL_FREQUENCY
        if self.asked is not None:
            lowest = USUAL_FREQUENCY * (_DEGREE / _LARGEST_DEGREE) ** 2
            self.frequency = max(lowest, math.pi**2 * square / min(max(self.asked, 1e-150), 1e150) ** 2)
        self.wavelength = math.pi * math.sqrt(square / self.frequency)

    @property
    def finished(self) -> str:
        return "target" if self._turn == _TURNS else ""

    def tell(self, report: RunReport) -> None:
        report.wavelength = self.wavelength

    def prepare(self, state: State, turn: int) -> None:
        if self._turn == 0:
            self._start, self._target = state.points.copy(), self._filtered(state)
        self._turn += 1

    def _filtered(self, state: State) -> Float64:
        kinds, graph = state.near.kinds, self._graph
        moves = ((state.pinned == 0) & ((kinds == INTERIOR) | (kinds >= LINE))).astype(np.float64)
        if not moves.any() or not self._edge:
            return state.points.copy()
        # Far from the origin sums of points would lose digits that differences have.
        used = state.points[state.near.connectivity]
        middle = 0.5 * (used.min(axis=0) + used.max(axis=0))
        points = np.where(np.isfinite(state.points), state.points - middle, 0.0)
        start = state.topology.with_points(points)
        strengths = [each for each in STRENGTHS if self.frequency * each <= 2.0] or [1.0]
        degree = math.ceil(_DEGREE * math.sqrt(USUAL_FREQUENCY / min(self.frequency, USUAL_FREQUENCY)))
        series = np.array([coefficients(half_height(self.frequency, each), degree) for each in strengths])
        candidates = graph.filtered(points, moves, series)
        areas = _vertex_areas(start)
        result = self._chosen(start, candidates, areas)
        for _ in range(2):
            self._give_back(start, result, moves, areas * moves)
        result += middle
        return result

    def _heights(self, start: Mesh, candidates: Float64, time: float, areas: Float64) -> Float64:
        """Return the heights between the start and other surfaces, spread out; in edges, (n, c)."""
        n = start.n_points
        swept = [
            np.bincount(start.connectivity, swept_at_corners(start, start.with_points(each)), n)
            for each in candidates
        ]
        below = self._graph.spread(areas[:, None], time)[:, 0]
        volume = self._graph.spread(np.column_stack(swept), time)
        floor = 1e-6 * float(areas.mean())
        return volume / np.maximum(below, floor)[:, None] / self._edge

    def _chosen(self, start: Mesh, candidates: Float64, areas: Float64) -> Float64:
        """Return for each vertex the strongest filter's point that its neighbourhood allows."""
        heights = self._heights(start, candidates, 12.0, areas)
        result = start.points.copy()
        everywhere = np.ones(len(result))
        lazy = coefficients(lambda k: (1.0 - 0.5 * k) ** 8, 8)[None]
        for level in reversed(range(len(candidates))):
            off = np.abs(heights[:, level]) / _SWEPT
            for weaker in range(level + 1, len(candidates)):
                off = np.maximum(off, np.abs(heights[:, level] - heights[:, weaker]) / _APART)
            part = np.clip(2.0 - off, 0.0, 1.0)[:, None]
            part = np.minimum(part, self._graph.filtered(part, everywhere, lazy)[0])
            result += part * (candidates[level] - result)
        return result

    def _give_back(self, start: Mesh, result: Float64, moves: Float64, areas: Float64) -> None:
        """Move `result` along its normals by what it has swept locally, as far as that is not noise."""
        height = self._heights(start, result[None], 24.0, areas)[:, 0]
        height = np.clip(height**3 / (height**2 + _LEFT**2), -0.25, 0.25)
        normals = ring_normals(start.with_points(result))
        length = np.linalg.norm(normals, axis=1, keepdims=True)
        normals = np.divide(normals, length, out=np.zeros_like(normals), where=length > 0.0)
        result -= (moves * height * self._edge)[:, None] * normals

    def propose(self, state: State, turn: int, starts: Int64, ends: Int64, proposed: Float64) -> None:
        factors = np.empty(0) if state.factors is None else state.factors
        parallel.run(
            _go, starts, ends, state.points, self._start, self._target, state.pinned, factors, proposed
        )


def _vertex_areas(mesh: Mesh) -> Float64:
    """Return the part of each face's area that a vertex stands for, (n,)."""
    areas = np.linalg.norm(area_vectors(mesh), axis=1) / np.maximum(mesh.face_sizes, 1)
    of_corners = np.repeat(areas, mesh.face_sizes)
    return np.bincount(mesh.connectivity, of_corners, mesh.n_points).astype(np.float64)
