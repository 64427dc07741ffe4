"""The one loop: schemes propose, constraints dispose.

The loop owns what every run shares: the order of the sweeps, stop rules, progress and cancelling. With
constraints whose promise needs neighbours to stand still (gates) it sweeps *in place*, one set of
independent vertices after another; otherwise all vertices move at the same time. What becomes of proposals
is the business of :mod:`~vtksmooth.kernels.smoothing.phases`.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ...errors import ParameterError
from ...jit import parallel
from ...jit.compiled import kernel
from ...report import RunReport
from ..containment.safe_moves import everywhere
from ..features import detection
from ..measures import aspect_ratio, comparison
from ..measures.label_volumes import label_volumes
from ..mesh import adjacency
from ..mesh.labels import check_closed
from ..mesh.mesh import LARGEST_POLYGON, Mesh
from .constraints import Constraint
from .constraints.boundary import Boundary
from .constraints.displacement_bound import DisplacementBound
from .constraints.fixed import Fixed
from .phases import Disposal
from .rollback import EVERY, roll_back
from .run_state import State
from .schemes import EdgeScheme, Fused, Scheme

Float64 = npt.NDArray[np.float64]
Int64 = npt.NDArray[np.int64]

#: Called with the part done, 0 to 1, and with what is being done. It may raise
#: :class:`~vtksmooth.errors.Cancelled`, which ends the run.
Progress = Callable[[float, str], None]

#: Features, or what finds them.
FindFeatures = Callable[[Mesh, adjacency.Adjacency], detection.Features] | detection.Features

#: Simultaneous sweeps read memory in the mesh's own order. If neighbours are farther apart than this (in
#: the mean, in vertices), they are out of the cache's reach, and putting the mesh in order makes passes
#: several times as fast. Rows of a grid and slices of marching cubes are nearer.
_SCATTERED = 10_000


#: Least time between two measurements for somebody who watches, seconds.
_MEASURE_EVERY = 1.0

#: How often a pass that is judged as a whole is done again without the vertices that must stay.
_WITHDRAWALS = 6


#: Steps below this part of the mesh's diagonal are none.
_NOTHING = 1e-6


@dataclass(frozen=True)
class StopRules:
    """When to stop before all iterations are done. A rule that is None does not act.

    The first four bound what the result may differ from the original; the iteration that would exceed
    a bound is undone, so the result keeps within it.

    Parameters
    ----------
    normal_deviation, dihedral_change : float
        Degrees.
    deviation : float
        Distance of vertices from the original surface, model units.
    volume_percent : float
        Change of the enclosed volume, percent (open meshes: swept volume over that of the bounding box).
    gain : float
        Stop when the mean k grows by less than this in an iteration.
    statistic : {"max", "mean"}
        What of the first three is held against the bound.
    """

    normal_deviation: float | None = None
    dihedral_change: float | None = None
    deviation: float | None = None
    volume_percent: float | None = None
    gain: float | None = None
    statistic: str = "max"

    @property
    def bounding(self) -> bool:
        """Whether any rule bounds what the result may differ by."""
        bounds = (self.normal_deviation, self.dihedral_change, self.deviation, self.volume_percent)
        return any(bound is not None for bound in bounds)


@kernel
def _carry_out(starts, ends, pinned, proposed, points):
    moved = 0
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            if pinned[v]:
                continue  # it may be NaN, which is never equal to itself
            changed = False
            for axis in range(3):
                changed = changed or points[v, axis] != proposed[v, axis]
                points[v, axis] = proposed[v, axis]
            moved += changed
    return moved


def _ignore(fraction: float, what: str) -> None:
    """Progress that nobody watches."""


def smooth(
    mesh: Mesh,
    scheme: Scheme,
    constraints: Sequence[Constraint] = (),
    *,
    iterations: int,
    fixed: npt.ArrayLike | None = None,
    max_displacement: npt.ArrayLike | None = None,
    find_features: FindFeatures = detection.detect,
    stop: StopRules = StopRules(),
    progress: Progress = _ignore,
    watched: bool = False,
    checked: bool = False,
) -> tuple[Float64, RunReport]:
    """Smooth `mesh` and return its new points.

    Parameters
    ----------
    mesh : Mesh
        Is not changed.
    scheme : Scheme
        Proposes where vertices should go.
    constraints : sequence of Constraint
        Decide what becomes of the proposals; in any order. Without a
        :class:`~vtksmooth.kernels.smoothing.constraints.boundary.Boundary` the boundary is fixed.
    iterations : int
        Most iterations to do.
    fixed : (n,) array_like, optional
        Nonzero for points that must stay, bit for bit.
    max_displacement : (n,) array_like, optional
        How far each point may be from its place in `mesh`, model units; 0 for points that must stay.
    find_features : callable or Features
        Returns the features of a mesh with its neighbourhoods, for the constraints that keep them;
        or those features, in the numbering of `mesh`.
    stop : StopRules
    progress : callable
        ``progress(fraction, what)``, called many times per second; may raise to cancel.
    watched : bool
        Whether somebody reads what `progress` is told: then it has the measures so far, each second anew.
    checked : bool
        Whether to measure in the end whether the promises hold, see `RunReport.broken`.

    Returns
    -------
    points : (n, 3) float64
        Points that did not move have the bits they had.
    report : RunReport

    Examples
    --------
    >>> from vtksmooth.kernels.smoothing.constraints.gate import Gate
    >>> from vtksmooth.kernels.smoothing.schemes.trapezium import TrapeziumDrawing
    >>> square = [[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0], [0.5, 0.4, 0]]
    >>> plane = Mesh.from_faces(square, [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]])
    >>> points, report = smooth(plane, TrapeziumDrawing(), [Gate("aspect")], iterations=30)
    >>> points[4].round(3).tolist()
    [1.0, 1.0, 0.0]
    """
    began = time.perf_counter()
    run = _Run(mesh, scheme, constraints, fixed, max_displacement, find_features, stop, progress)
    report = run.report
    run.start()
    if not run.free:
        report.stop_reason = "nothing-to-do"
        iterations = 0
    for iteration in range(iterations):
        run.doing = f"iteration {iteration + 1} of {iterations}{run.so_far() if watched else ''}"
        progress(iteration / iterations, run.doing)
        reason = run.iterate(iteration / iterations, 1.0 / iterations)
        if reason in ("", "gain"):
            report.iterations = iteration + 1
        if reason or iteration + 1 == iterations or (iteration + 1) % EVERY == 0:
            run.look()
        if reason:
            report.stop_reason = reason
            break
    points = run.finish(checked)
    report.seconds = time.perf_counter() - began
    progress(1.0, "done")
    return points, report


def _scattered(near: adjacency.Adjacency) -> bool:
    """Return whether neighbours are far apart in memory, by a sample."""
    if len(near.kinds) < _SCATTERED or not len(near.ring):
        return False
    sample = np.arange(0, len(near.ring), max(1, len(near.ring) // 10_000))
    owner = np.searchsorted(near.ring_offsets, sample, side="right") - 1
    return bool(np.abs(near.ring[sample] - owner).mean() >= _SCATTERED)


class _Run:
    """One call of :func:`smooth`."""

    def __init__(
        self,
        mesh: Mesh,
        scheme: Scheme,
        constraints: Sequence[Constraint],
        fixed: npt.ArrayLike | None,
        max_displacement: npt.ArrayLike | None,
        find_features: FindFeatures,
        stop: StopRules,
        progress: Progress,
    ) -> None:
        self.mesh, self.scheme, self.stop, self.progress = mesh, scheme, stop, progress
        given = list(constraints)
        if not any(constraint.topic == Boundary.topic for constraint in given):
            given.append(Boundary(sliding=False))
        if fixed is not None:
            given.append(Fixed(fixed))
        if max_displacement is not None:
            given.append(DisplacementBound(max_displacement))
        self.on_edges = isinstance(scheme, EdgeScheme)
        guarded = isinstance(scheme, EdgeScheme) and scheme.guarded
        self.disposal = Disposal(given, scheme.keeps, self.on_edges, scheme.closing(), guarded)
        self.find_features = find_features
        self.in_place = self.disposal.in_place
        self.report = RunReport()
        self.doing = self.measures = ""
        self.measured = 0.0
        self.order: npt.NDArray[np.int32] | None = None
        #: Whether gates let no vertex move alone in the last pass.
        self.stalled = False
        #: Whether gates took back steps of that pass that were worth mentioning.
        self.withheld = False
        self._edges: tuple[npt.NDArray[np.int32], npt.NDArray[np.int32]] | None = None

    # -- before the first pass ---------------------------------------------------------------------

    def start(self) -> None:
        """Put the mesh in order, build what the passes need, and let the constraints bind."""
        self.progress(0.0, "building neighbourhoods")
        mesh = self.mesh
        near = adjacency.build(mesh)
        if mesh.face_labels is not None:
            check_closed(mesh, near)
        if self.in_place:
            self.progress(0.0, "colouring")
            self.order, starts, block_colour = adjacency.colour_blocks(
                near, adjacency.breadth_first_order(near)
            )
            self._schedule(starts, block_colour)
        else:
            ordered = self.on_edges or _scattered(near)
            self.order = adjacency.breadth_first_order(near) if ordered else None
            self.ranges = parallel.ranges(mesh.n_points)
        face_order = None
        if self.order is not None:
            self.progress(0.0, "putting the mesh in order")
            del near
            mesh, face_order = adjacency.renumbered(mesh, self.order)
            near = adjacency.build(mesh)
        if self.in_place and not self.on_edges and mesh.only_triangles:
            adjacency.turn_into_cycles(near)
        self.progress(0.0, "measuring")
        reference = aspect_ratio.reference_directions(mesh)
        pinned = (near.kinds == adjacency.UNUSED).astype(np.uint8)
        points = mesh.points if self.order is not None else mesh.points.copy()
        k = aspect_ratio.aspect_ratios(mesh, reference, bounded=False)
        self.state = State(
            mesh, near, reference, points, pinned, float(k.min()), self.in_place, self._first_points,
            self._features,
            self.order,
            face_order,
            # The whole way would swing when all move at once; schemes that go less far do so here, too.
            min(0.5, self.scheme.relaxation),
        )  # fmt: skip
        self._pin_giants()
        if not self.scheme.moves_lines or any(each.holds_lines for each in self.disposal.constraints):
            self.state.pinned[near.kinds >= adjacency.LINE] = 1
        self.disposal.bind(self.state)
        self.scheme.bind(self.state)
        self.good = points.copy() if self.disposal.looks else points
        self.free = int(len(pinned) - np.count_nonzero(pinned))
        self.proposed = np.empty((0, 3))
        self._fuse(k)
        k = np.maximum(k, -1.0)
        report = self.report
        self.mean_k = float(k.mean())
        report.irregular = int(np.count_nonzero(near.kinds == adjacency.NON_MANIFOLD))
        report.mean_aspect_ratio = (self.mean_k, self.mean_k)
        report.min_aspect_ratio = (float(k.min()), float(k.min()))
        report.inverted = (int((k < 0).sum()), int((k < 0).sum()))

    def _fuse(self, k: Float64) -> None:
        self.fused: Fused | None = None
        if self.in_place:
            colours = [starts for _, inner in self.classes for starts, _ in inner]
            self.fused = self.scheme.fuse(self.state, self.disposal.acting, k, np.concatenate(colours))

    def _pin_giants(self) -> None:
        topology = self.state.topology
        for f in np.flatnonzero(topology.face_sizes > LARGEST_POLYGON):
            self.state.pinned[topology.connectivity[topology.offsets[f] : topology.offsets[f + 1]]] = 1

    def _first_points(self) -> Float64:
        return self.mesh.points if self.order is None else self.mesh.points[self.order]

    def _features(self, mesh: Mesh, near: adjacency.Adjacency) -> detection.Features:
        if callable(self.find_features):
            return self.find_features(mesh, near)
        given = self.find_features
        if len(given.classes) != mesh.n_points:
            raise ParameterError(
                f"The features are those of {len(given.classes)} points; the mesh has {mesh.n_points}."
            )
        if self.order is None:
            return given
        # One place more, where "no neighbour", -1, stays what it is.
        rank = np.full(mesh.n_points + 1, -1, np.int32)
        rank[self.order] = np.arange(mesh.n_points, dtype=np.int32)
        edges = np.sort(rank[given.ridge_edges], axis=1)
        return detection.Features(given.classes[self.order], rank[given.ridge_ring[self.order]], edges)

    def _schedule(self, starts: npt.NDArray[np.int32], block_colour: npt.NDArray[np.int32]) -> None:
        # For each block colour: the blocks (their whole ranges), and the ranges of each vertex colour.
        self.classes: list[tuple[tuple[Int64, Int64], list[tuple[Int64, Int64]]]] = []
        wide = starts.astype(np.int64)
        for colour in range(int(block_colour.max()) + 1):
            rows = wide[block_colour == colour]
            inner = [(rows[:, c].copy(), rows[:, c + 1].copy()) for c in range(rows.shape[1] - 1)]
            self.classes.append(((rows[:, 0].copy(), rows[:, -1].copy()), inner))

    def so_far(self) -> str:
        """Return the measures of the mesh as it is, or was a moment ago."""
        if time.perf_counter() - self.measured >= _MEASURE_EVERY:
            k = aspect_ratio.aspect_ratios(self.state.mesh, self.state.reference)
            self.measures = f": k mean {k.mean():.3f}, min {k.min():.3f}, {int((k < 0).sum())} inverted"
            self.measured = time.perf_counter()
        return self.measures

    # -- passes ------------------------------------------------------------------------------------

    def iterate(self, done: float, share: float) -> str:
        """Do one iteration; return why the run must stop, or ''."""
        if self.scheme.finished:
            return self.scheme.finished
        state = self.state
        kept = state.points.copy() if self.stop.bounding or self.disposal.closes else None
        moved = 0
        for attempt in (self._together, self._alone) if self.stalled else (self._alone, self._together):
            if moved := attempt(done, share):
                self.stalled = attempt == self._together
                break
        if moved == 0 and self.withheld and not self.report.iterations:
            return "gate"
        if moved == 0 or (kept is not None and self.disposal.closes and not self.disposal.close(state, kept)):
            return "converged"
        exceeded = self._exceeded() if self.stop.bounding else ""
        if exceeded and kept is not None:
            state.points = kept
            return exceeded
        return self._gained_too_little()

    def look(self) -> None:
        """Take back what the passes since the last look must not have done."""
        if not self.disposal.looks:
            return
        state = self.state
        if taken_back := roll_back(self.disposal, state, self.good):
            if self.stop.bounding and self._exceeded():
                state.points[:] = self.good
                self.disposal.forget(state)
            self.report.taken_back += taken_back
            self._fuse(aspect_ratio.aspect_ratios(state.mesh, state.reference))
        self.good = state.points.copy()

    def _alone(self, done: float, share: float) -> int:
        """Do the passes of an iteration; return how many vertices or edges moved, -1 where nobody counts."""
        state, moved = self.state, -1
        for turn in range(self.scheme.passes):
            if self.fused is not None:
                moved = sum(self._fused(self.fused, done, share))
                continue
            self.scheme.prepare(state, turn)
            self.disposal.prepare(state)
            if self.in_place or self.on_edges:
                moved = max(0, moved) + self._one_by_one(turn, done, share)
            else:
                self._simultaneous(turn)
        return moved

    def _together(self, done: float, share: float) -> int:
        """Do passes that gates judge as a whole, where no vertex may go alone; return how many moved."""
        if not self.disposal.judges_passes:
            return 0
        state, before = self.state, self.state.points.copy()
        pinned = state.pinned.copy()
        self.disposal.judged_alone = False
        moved = 0
        for attempt in range(_WITHDRAWALS):
            for turn in range(self.scheme.passes):
                self.scheme.prepare(state, turn)
                self.disposal.prepare(state)
                moved += self._one_by_one(turn, done, share)
            if attempt == 0:
                free = pinned == 0
                ways = np.abs(state.points[free] - before[free])
                self.withheld = bool(ways.max(initial=0.0) > _NOTHING * self.mesh.diagonal)
            stay = self.disposal.unwelcome(state, before) if moved else np.zeros(len(before), bool)
            if not stay.any():
                break
            moved = 0
            state.points[:] = before
            state.pinned[stay] = 1
        state.pinned[:] = pinned
        self.disposal.judged_alone = True
        if moved:
            self._fuse(aspect_ratio.aspect_ratios(state.mesh, state.reference))
        return moved

    def _simultaneous(self, turn: int) -> None:
        state = self.state
        if self.proposed.shape != state.points.shape:
            self.proposed = np.empty_like(state.points)
        self._propose_and_dispose(turn, *self.ranges)
        state.points, self.proposed = self.proposed, state.points

    def _propose_and_dispose(self, turn: int, starts: Int64, ends: Int64) -> None:
        self.scheme.propose(self.state, turn, starts, ends, self.proposed)
        self.disposal.dispose(self.state, starts, ends, self.proposed)

    def _one_by_one(self, turn: int, done: float, share: float) -> int:
        return sum(self._operations(done, share) if self.on_edges else self._in_place(turn, done, share))

    def _in_place(self, turn: int, done: float, share: float) -> Iterator[int]:
        if self.proposed.shape != self.state.points.shape:
            self.proposed = np.empty_like(self.state.points)
        points = self.state.points
        for number, (_, colours) in enumerate(self.classes):
            for starts, ends in colours:
                self._propose_and_dispose(turn, starts, ends)
                yield sum(parallel.run(_carry_out, starts, ends, self.state.pinned, self.proposed, points))
            self.progress(done + share * (number + 1) / len(self.classes), self.doing)

    def _fused(self, fused: Fused, done: float, share: float) -> Iterator[int]:
        for number, (blocks, _) in enumerate(self.classes):
            yield fused(number == 0, *blocks)
            self.progress(done + share * (number + 1) / len(self.classes), self.doing)

    def _operations(self, done: float, share: float) -> Iterator[int]:
        assert isinstance(self.scheme, EdgeScheme)
        damping = (self.state.pinned == 0).astype(np.float64)
        if self.state.factors is not None:
            damping *= self.state.factors
        guarding = [each for each in self.disposal.constraints if each.guard is not None]
        if not self.scheme.guarded:
            guarding = []
        guard = guarding[0].guard if guarding else everywhere()
        admitted = self.disposal.admitted if self.disposal.judges_ends else None
        for part, moved, checked, asked in self.scheme.sweep(self.state, damping, guard, admitted):
            for constraint in guarding:
                constraint.count(checked, asked)
            yield moved
            self.progress(done + share * part, self.doing)

    # -- stop rules --------------------------------------------------------------------------------

    def _statistic(self, values: Float64) -> float:
        largest, mean = comparison.largest_and_mean(values)
        return largest if self.stop.statistic == "max" else mean

    def _exceeded(self) -> str:
        """Return which bound the mesh exceeds now, or ''."""
        stop, state = self.stop, self.state
        before, after = state.original, state.mesh
        if stop.normal_deviation is not None:
            deviation = comparison.normal_deviation(before, after)
            if self._statistic(deviation) > stop.normal_deviation:
                return "normal-deviation"
        if stop.dihedral_change is not None:
            if self._edges is None:
                self._edges = adjacency.edges(state.near)
            if (
                self._statistic(comparison.dihedral_change(before, after, *self._edges))
                > stop.dihedral_change
            ):
                return "dihedral-change"
        if stop.deviation is not None:
            used = state.near.kinds != adjacency.UNUSED
            distance = state.surface.query(after.points[used])[1]
            if self._statistic(distance) > stop.deviation:
                return "deviation"
        if stop.volume_percent is not None:
            if before.face_labels is not None:
                old = label_volumes(before)
                parts = np.abs(label_volumes(after) - old) / np.abs(old)
                return "volume" if 100.0 * parts.max() > stop.volume_percent else ""
            swept = abs(comparison.swept_volume(before, after))
            if 100.0 * swept > stop.volume_percent * self._whole_volume():
                return "volume"
        return ""

    def _whole_volume(self) -> float:
        original = self.state.original
        if comparison.is_closed(self.state.near):
            return abs(comparison.signed_volume(original))
        used = original.points[original.connectivity]
        return float(np.prod(used.max(axis=0) - used.min(axis=0)))

    def _gained_too_little(self) -> str:
        if self.stop.gain is None:
            return ""
        mean_k = float(aspect_ratio.aspect_ratios(self.state.mesh, self.state.reference).mean())
        gain, self.mean_k = mean_k - self.mean_k, mean_k
        return "gain" if gain < self.stop.gain else ""

    # -- after the last pass -----------------------------------------------------------------------

    def finish(self, checked: bool) -> Float64:
        """Complete the report and return the points in the numbering of the input."""
        state, report = self.state, self.report
        k = aspect_ratio.aspect_ratios(state.mesh, state.reference)
        report.mean_aspect_ratio = (report.mean_aspect_ratio[0], float(k.mean()))
        report.min_aspect_ratio = (report.min_aspect_ratio[0], float(k.min()))
        report.inverted = (report.inverted[0], int((k < 0).sum()))
        for constraint in self.disposal.constraints:
            constraint.tell(report)
        self.scheme.tell(report)
        if checked:
            report.broken = self.disposal.check(state)
        closed = comparison.is_closed(state.near)
        # The neighbourhoods have served, and what follows needs room.
        self.fused = None
        del state.near, state.reference
        # In the run's numbering: the file's may be random, and these read every face.
        before, after = state.topology.with_points(self._first_points()), state.mesh
        # Points that no face uses may be NaN, and NaN differs from itself.
        moved = (before.points != after.points) & ~np.isnan(after.points)
        report.moved = int(np.count_nonzero(moved.any(axis=1)))
        if before.face_labels is not None:
            volumes = label_volumes(before), label_volumes(after)
            report.label_volumes = tuple(
                (number, *both)
                for number, both in enumerate(zip(*map(np.ndarray.tolist, volumes), strict=True))
            )
            report.swept_volume = float(np.abs(volumes[1] - volumes[0]).max())
        else:
            report.swept_volume = comparison.swept_volume(before, after)
        if closed and before.face_labels is None:
            report.volume = (comparison.signed_volume(before), comparison.signed_volume(after))
        if self.order is None:
            return state.points
        points = np.empty_like(state.points)
        points[self.order] = state.points
        return points
