"""The general Laplacian approximation ``L(p_i) = sum_j w_ij (p_j - p_i)``: its weights, as compressed rows.

Schemes whose weights are cheap compute them on the fly; this is for those that need the weights as
such: directional smoothing, implicit steps, and operations on edges.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from ...errors import ParameterError
from ...jit import parallel
from ...jit.compiled import device, kernel
from ..measures.aspect_ratio import ring_normal
from ..mesh.adjacency import Adjacency
from .run_state import State
from .schemes.cotangent import cotangent_weights

Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]

UMBRELLA, SCALE_DEPENDENT, COTANGENT = 0, 1, 2

#: Names of the weights: equal, 1/|e| (Fujiwara 1995), cotangents (Desbrun et al. 1999), clamped at 0.
KINDS = {"umbrella": UMBRELLA, "scale-dependent": SCALE_DEPENDENT, "cotangent": COTANGENT}

#: Squares of projections below this part of the vector's own are rounding errors: it has no direction there.
_VANISHED = 1e-20


@device
def _direct(points, near, v, flow, flow_weight, first, last, neighbours, weights):
    # w_ij (1 + mu cos^2 theta), theta between the flow and the edge in the tangent plane at v.
    largest = max(abs(flow[v, 0]), max(abs(flow[v, 1]), abs(flow[v, 2])))
    nx, ny, nz = ring_normal(points, near, v)
    square = nx * nx + ny * ny + nz * nz
    if largest == 0.0 or square == 0.0:
        return
    # Neither the size nor the sign of the flow matters; squares of it might leave float64.
    fx = flow[v, 0] / largest
    fy = flow[v, 1] / largest
    fz = flow[v, 2] / largest
    whole = fx * fx + fy * fy + fz * fz
    off = (fx * nx + fy * ny + fz * nz) / square
    fx -= off * nx
    fy -= off * ny
    fz -= off * nz
    ff = fx * fx + fy * fy + fz * fz
    if ff <= _VANISHED * whole:
        return
    for r in range(first, last):
        w = neighbours[r]
        ex = points[w, 0] - points[v, 0]
        ey = points[w, 1] - points[v, 1]
        ez = points[w, 2] - points[v, 2]
        whole = ex * ex + ey * ey + ez * ez
        off = (ex * nx + ey * ny + ez * nz) / square
        ex -= off * nx
        ey -= off * ny
        ez -= off * nz
        ee = ex * ex + ey * ey + ez * ez
        if ee > _VANISHED * whole:
            along = ex * fx + ey * fy + ez * fz
            weights[r] *= 1.0 + flow_weight * (along * along / (ee * ff))


@kernel
def _weights(starts, ends, points, near, kind, offsets, neighbours, flow, flow_weight, weights):
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            first = offsets[v]
            last = offsets[v + 1]
            if kind == 2:
                cotangent_weights(points, near, v, weights, first)
            for r in range(first, last):
                w = neighbours[r]
                if kind == 0:
                    weights[r] = 1.0
                elif kind == 1:
                    ex = points[w, 0] - points[v, 0]
                    ey = points[w, 1] - points[v, 1]
                    ez = points[w, 2] - points[v, 2]
                    length = np.sqrt(ex * ex + ey * ey + ez * ez)
                    weights[r] = 1.0 / length if length > 0.0 else 0.0
                else:
                    weights[r] = max(0.0, weights[r])
            if flow.size > 0:
                _direct(points, near, v, flow, flow_weight, first, last, neighbours, weights)
            total = 0.0
            for r in range(first, last):
                total += weights[r]
            for r in range(first, last):
                weights[r] = weights[r] / total if total > 0.0 else 0.0


@kernel
def _apply(starts, ends, points, offsets, neighbours, weights, laplacian):
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            sx = 0.0
            sy = 0.0
            sz = 0.0
            for r in range(offsets[v], offsets[v + 1]):
                w = neighbours[r]
                sx += weights[r] * (points[w, 0] - points[v, 0])
                sy += weights[r] * (points[w, 1] - points[v, 1])
                sz += weights[r] * (points[w, 2] - points[v, 2])
            laplacian[v, 0] = sx
            laplacian[v, 1] = sy
            laplacian[v, 2] = sz


@dataclass(frozen=True)
class Weights:
    """Which weights the Laplacian has.

    Parameters
    ----------
    kind : {"umbrella", "scale-dependent", "cotangent"}
    flow : (n, 3) float64, optional
        A vector at each point, in the order of the points that smoothing is given. Its direction counts,
        neither its size nor its sign.
    flow_weight : float
        mu_flow: how much more a neighbour along the flow weighs, ``w_ij (1 + mu_flow cos^2 theta)``, theta
        between flow and edge in the tangent plane at i. 0 is isotropic, large is along the flow only.
        Where the projected flow vanishes the weights are isotropic.

    Notes
    -----
    Section 5.2 of the installation-space paper. Rows sum to 1; a row without any weight is 0.

    In a ring of six equilateral triangles cos^2 leaves a quarter of ``sum_j w_ij |e|^2`` across the flow,
    wherever the edges point: however great mu_flow, L smooths long waves along the flow at most three times
    as fast as those across it, and operations on edges, whose energy is its square, nine times.
    """

    kind: str = "umbrella"
    flow: Float64 | None = None
    flow_weight: float = 0.0

    @property
    def directional(self) -> bool:
        """Whether the flow has a say."""
        return self.flow is not None and self.flow_weight > 0.0

    @property
    def constant(self) -> bool:
        """Whether the weights do not depend on where the points are."""
        return self.kind == "umbrella" and not self.directional

    def rows(self, near: Adjacency) -> tuple[Int32, Int32]:
        """Return offsets and neighbours of the rows; cotangents belong to the fans of triangles."""
        if self.kind == "cotangent":
            return near.star_offsets, near.star
        return near.row_offsets, near.row

    def in_run(self, state: State) -> Weights:
        """Return the same weights for the run's numbering."""
        if self.flow is None:
            return self
        if self.flow.shape != state.points.shape:
            raise ParameterError(
                f"The flow must hold a vector for each of the {len(state.points)} points, "
                f"not have the shape {self.flow.shape}."
            )
        return replace(self, flow=np.ascontiguousarray(state.in_order(self.flow)))

    def compute(self, points: Float64, near: Adjacency, out: Float64 | None = None) -> Float64:
        """Return the weights where the points are now, aligned with :meth:`rows`."""
        offsets, neighbours = self.rows(near)
        weights = np.empty(len(neighbours)) if out is None else out
        if self.constant:
            size = np.diff(offsets)
            weights[:] = np.repeat(1.0 / np.maximum(size, 1), size)
            return weights
        flow = self.flow if self.flow is not None and self.directional else np.empty((0, 3))
        parallel.run(
            _weights, *parallel.ranges(len(points)),
            points, near, KINDS[self.kind], offsets, neighbours, flow, self.flow_weight, weights,
        )  # fmt: skip
        return weights

    def apply(self, points: Float64, near: Adjacency, weights: Float64, out: Float64) -> None:
        """Write L(p) of all `points` (or of any other three-component field) to `out`, (n, 3)."""
        parallel.run(_apply, *parallel.ranges(len(points)), points, *self.rows(near), weights, out)
