"""Feature-preserving denoising: face normals are filtered under a guide, then points follow them.

A guide that takes each face's normal from the most uniform patch around it tells creases from noise (Zhang et
al. 2015); here patches have weights instead of one being chosen. What has been removed is watched: noise is
white, neighbours differ; where neighbours have gone the same way, shape has been removed, and it comes back.
"""

from __future__ import annotations

import numpy as np

from ....jit import parallel
from ....jit.compiled import device, kernel
from ....report import RunReport
from ...measures.aspect_ratio import area_vector
from ...measures.noise import noise_levels
from ...mesh import face_rings
from ...mesh.adjacency import Adjacency
from ..run_state import State
from . import Float64, Int64, Scheme

#: The autocorrelation of what has been removed at which there is no more to remove, by strength. Noise has
#: less; 0 would be white, but the fitting of normals to it makes neighbours differ more than chance does.
WHITENESS = {"gentle": -0.12, "normal": -0.077, "strong": -0.05}

#: Half the width of the ramp, about `_CENTRE` for normal strength, along which what was removed comes back.
_RAMP, _CENTRE = 0.06, 0.0

#: Averagings of the local autocorrelation and of the local edge length; part of a vertex itself in each.
_AVERAGINGS, _EDGE_AVERAGINGS, _OWN = 12, 6, 0.25

#: Passes of the vertices for one filtering of the normals.
VERTEX_PASSES = 3

#: Weight of the return to the first place, along directions that no target normal sees.
_RETURN = 0.1

#: Cosine to its target normal below which a face is taken for folded, and its vertices are released: part of
#: the way to the middle of their neighbours that they go then.
_FOLDED, _RELEASED = 0.2, 0.3

#: Width of the window in distances between centres of faces: without noise, growth with noise over edge
#: length, least and largest.
_WINDOW = 1.2, 6.0, 1.25, 3.0

#: Width of the bell for differences of guides; part of it left by each iteration after the second; least.
_BELL, _NARROWING, _NARROWEST = 0.25, 0.9, 0.12

#: Exponent of the uniformity of patches in the guide, and its growth with each iteration after the second.
_EXPONENT, _GROWTH = 0.4, 0.3

#: Farthest that a vertex goes from its place, in noise levels.
_FARTHEST = 16.0

#: Halvings of steps that turn faces over before they are refused.
_HALVINGS = 4

_TINY = 1e-6


@kernel
def _mean_edges(starts, ends, points, near, edge):
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            edge[v, 0] = 0.0
            size = near.ring_offsets[v + 1] - near.ring_offsets[v]
            for r in range(near.ring_offsets[v], near.ring_offsets[v + 1]):
                square = 0.0
                for axis in range(3):
                    square += (points[near.ring[r], axis] - points[v, axis]) ** 2
                edge[v, 0] += np.sqrt(square) / size


@kernel
def _mean_at_faces(starts, ends, near, values, means):
    for part in range(starts.size):
        for f in range(starts[part], ends[part]):
            total = 0.0
            for c in range(near.offsets[f], near.offsets[f + 1]):
                total += values[near.connectivity[c]]
            means[f] = total / max(1, near.offsets[f + 1] - near.offsets[f])


@kernel
def _measure(starts, ends, points, near, normal, area, centre):
    for part in range(starts.size):
        for f in range(starts[part], ends[part]):
            x, y, z = area_vector(points, near.offsets, near.connectivity, f)
            length = np.sqrt(x * x + y * y + z * z)
            inverse = 1.0 / length if length > 0.0 else 0.0
            area[f] = length
            normal[f, 0] = x * inverse
            normal[f, 1] = y * inverse
            normal[f, 2] = z * inverse
            first = near.offsets[f]
            size = near.offsets[f + 1] - first
            for axis in range(3):
                centre[f, axis] = 0.0
                for c in range(first, first + size):
                    centre[f, axis] += points[near.connectivity[c], axis] / size


@kernel
def _measure_edges(starts, ends, near, across, normal, centre, bend, distance):
    # At each corner the difference of the normals across its edge, and the distance of the centres.
    for part in range(starts.size):
        for f in range(starts[part], ends[part]):
            for c in range(near.offsets[f], near.offsets[f + 1]):
                g = across[c]
                bend[c] = 0.0
                distance[c] = 0.0
                if g >= 0:
                    turn = 0.0
                    way = 0.0
                    for axis in range(3):
                        turn += (normal[f, axis] - normal[g, axis]) ** 2
                        way += (centre[f, axis] - centre[g, axis]) ** 2
                    bend[c] = np.sqrt(turn)
                    distance[c] = np.sqrt(way)


@kernel
def _find_patches(starts, ends, near, across, offsets, rings, normal, area, bend, exponent, patch):
    # The mean normal of each face's ring, times its weight as a guide.
    inside = np.full(area.size, -1, np.int32)
    for part in range(starts.size):
        for f in range(starts[part], ends[part]):
            first = offsets[f]
            last = offsets[f + 1]
            x = 0.0
            y = 0.0
            z = 0.0
            for i in range(first, last):
                g = rings[i]
                inside[g] = f
                x += area[g] * normal[g, 0]
                y += area[g] * normal[g, 1]
                z += area[g] * normal[g, 2]
            widest = 0.0
            for i in range(first, last):
                g = rings[i]
                for j in range(i + 1, last):
                    h = rings[j]
                    dx = normal[g, 0] - normal[h, 0]
                    dy = normal[g, 1] - normal[h, 1]
                    dz = normal[g, 2] - normal[h, 2]
                    widest = max(widest, dx * dx + dy * dy + dz * dz)
            sharpest = 0.0
            total = 0.0
            for i in range(first, last):
                g = rings[i]
                for c in range(near.offsets[g], near.offsets[g + 1]):
                    h = across[c]
                    if h > g and inside[h] == f:
                        sharpest = max(sharpest, bend[c])
                        total += bend[c]
            unevenness = np.sqrt(widest) * sharpest / (total + 1e-9)
            length = np.sqrt(x * x + y * y + z * z)
            weight = (unevenness + _TINY) ** -exponent / length if length > 0.0 else 0.0
            patch[f, 0] = weight * x
            patch[f, 1] = weight * y
            patch[f, 2] = weight * z


@kernel
def _guide(starts, ends, offsets, rings, patch, normal, guide):
    for part in range(starts.size):
        for f in range(starts[part], ends[part]):
            x = 0.0
            y = 0.0
            z = 0.0
            for i in range(offsets[f], offsets[f + 1]):
                x += patch[rings[i], 0]
                y += patch[rings[i], 1]
                z += patch[rings[i], 2]
            length = np.sqrt(x * x + y * y + z * z)
            guide[f, 0] = x / length if length > 0.0 else normal[f, 0]
            guide[f, 1] = y / length if length > 0.0 else normal[f, 1]
            guide[f, 2] = z / length if length > 0.0 else normal[f, 2]


@kernel
def _filter(starts, ends, offsets, nearby, centre, area, normal, guide, width, bell, target):
    for part in range(starts.size):
        for f in range(starts[part], ends[part]):
            near_by = 0.5 / (width[f] * width[f])
            alike = 0.5 / (bell * bell)
            x = 0.0
            y = 0.0
            z = 0.0
            for i in range(offsets[f], offsets[f + 1]):
                h = nearby[i]
                away = 0.0
                apart = 0.0
                for axis in range(3):
                    away += (centre[f, axis] - centre[h, axis]) ** 2
                    apart += (guide[f, axis] - guide[h, axis]) ** 2
                weight = area[h] * np.exp(-away * near_by - apart * alike)
                x += weight * normal[h, 0]
                y += weight * normal[h, 1]
                z += weight * normal[h, 2]
            length = np.sqrt(x * x + y * y + z * z)
            target[f, 0] = x / length if length > 0.0 else normal[f, 0]
            target[f, 1] = y / length if length > 0.0 else normal[f, 1]
            target[f, 2] = z / length if length > 0.0 else normal[f, 2]


@kernel
def _move(starts, ends, points, near, pinned, normal, centre, target, anchor, released, moved):
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            for axis in range(3):
                moved[v, axis] = points[v, axis]
            first = near.corner_offsets[v]
            last = near.corner_offsets[v + 1]
            if pinned[v] or first == last:
                continue
            # M = mean of T T^t, its upper half; what Sun's update asks for; and the sum of the T.
            xx = 0.0
            xy = 0.0
            xz = 0.0
            yy = 0.0
            yz = 0.0
            zz = 0.0
            sx = 0.0
            sy = 0.0
            sz = 0.0
            nx = 0.0
            ny = 0.0
            nz = 0.0
            for row in range(first, last):
                f = near.corner_face[near.corners[row]]
                x = target[f, 0]
                y = target[f, 1]
                z = target[f, 2]
                if normal[f, 0] * x + normal[f, 1] * y + normal[f, 2] * z < _FOLDED:
                    released[v] = 1
                off = (
                    (centre[f, 0] - points[v, 0]) * x
                    + (centre[f, 1] - points[v, 1]) * y
                    + (centre[f, 2] - points[v, 2]) * z
                )
                sx += off * x
                sy += off * y
                sz += off * z
                nx += x
                ny += y
                nz += z
                xx += x * x
                xy += x * y
                xz += x * z
                yy += y * y
                yz += y * z
                zz += z * z
            count = np.float64(last - first)
            ux = anchor[v, 0] - points[v, 0]
            uy = anchor[v, 1] - points[v, 1]
            uz = anchor[v, 2] - points[v, 2]
            if released[v]:
                ux = 0.0
                uy = 0.0
                uz = 0.0
                size = near.ring_offsets[v + 1] - near.ring_offsets[v]
                for r in range(near.ring_offsets[v], near.ring_offsets[v + 1]):
                    w = near.ring[r]
                    ux += _RELEASED * (points[w, 0] - points[v, 0]) / size
                    uy += _RELEASED * (points[w, 1] - points[v, 1]) / size
                    uz += _RELEASED * (points[w, 2] - points[v, 2]) / size
            square = nx * nx + ny * ny + nz * nz
            if square > 0.0:
                along = (ux * nx + uy * ny + uz * nz) / square
                ux -= along * nx
                uy -= along * ny
                uz -= along * nz
            # (M + mu I)^-1 u by the adjugate: positive definite.
            xx = xx / count + _RETURN
            yy = yy / count + _RETURN
            zz = zz / count + _RETURN
            xy /= count
            xz /= count
            yz /= count
            axx = yy * zz - yz * yz
            axy = xz * yz - xy * zz
            axz = xy * yz - xz * yy
            ayy = xx * zz - xz * xz
            ayz = xy * xz - xx * yz
            azz = xx * yy - xy * xy
            scale = _RETURN / (xx * axx + xy * axy + xz * axz)
            moved[v, 0] += sx / count + scale * (axx * ux + axy * uy + axz * uz)
            moved[v, 1] += sy / count + scale * (axy * ux + ayy * uy + ayz * uz)
            moved[v, 2] += sz / count + scale * (axz * ux + ayz * uy + azz * uz)


@kernel
def _find_removed(starts, ends, points, first, near, normal, area, removed):
    # How far each vertex has gone along the normal where it is.
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            removed[v] = 0.0
            x = 0.0
            y = 0.0
            z = 0.0
            for row in range(near.corner_offsets[v], near.corner_offsets[v + 1]):
                f = near.corner_face[near.corners[row]]
                x += area[f] * normal[f, 0]
                y += area[f] * normal[f, 1]
                z += area[f] * normal[f, 2]
            length = np.sqrt(x * x + y * y + z * z)
            if length > 0.0:
                dx = points[v, 0] - first[v, 0]
                dy = points[v, 1] - first[v, 1]
                dz = points[v, 2] - first[v, 2]
                removed[v] = (dx * x + dy * y + dz * z) / length


@kernel
def _correlate(starts, ends, near, pinned, removed, products, squares, pairs):
    # r times the mean of the neighbours' r, and r^2; and r times the sum over free neighbours, and how many.
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            total = 0.0
            free = 0.0
            count = 0
            first = near.ring_offsets[v]
            last = near.ring_offsets[v + 1]
            for r in range(first, last):
                w = near.ring[r]
                total += removed[w]
                if not pinned[w]:
                    free += removed[w]
                    count += 1
            products[v, 0] = removed[v] * total / max(1, last - first)
            products[v, 1] = removed[v] * removed[v]
            squares[v] = 0.0 if pinned[v] else removed[v] * free
            pairs[v] = 0 if pinned[v] else count


@kernel
def _average(starts, ends, near, values, averaged):
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            first = near.ring_offsets[v]
            last = near.ring_offsets[v + 1]
            for k in range(values.shape[1]):
                total = 0.0
                for r in range(first, last):
                    total += values[near.ring[r], k]
                mean = total / (last - first) if last > first else values[v, k]
                averaged[v, k] = _OWN * values[v, k] + (1.0 - _OWN) * mean


@kernel
def _hold(starts, ends, begin, first, pinned, correlation, low, high, farthest, part_kept, points):
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            if pinned[v]:
                continue
            if correlation[v, 1] > 0.0:
                ratio = correlation[v, 0] / correlation[v, 1]
                part_kept[v] = min(part_kept[v], max(0.0, min(1.0, (high - ratio) / (high - low))))
            away = 0.0
            for axis in range(3):
                points[v, axis] = begin[v, axis] + part_kept[v] * (points[v, axis] - begin[v, axis])
                away += (points[v, axis] - first[v, axis]) ** 2
            if away > farthest[v] * farthest[v]:
                share = farthest[v] / np.sqrt(away)
                for axis in range(3):
                    points[v, axis] = first[v, axis] + share * (points[v, axis] - first[v, axis])


@device
def _beside(points, near, across, f):
    # The cosine, times lengths that do not matter, of a face's normal and the mean of those beyond its edges.
    x, y, z = area_vector(points, near.offsets, near.connectivity, f)
    sx = 0.0
    sy = 0.0
    sz = 0.0
    for c in range(near.offsets[f], near.offsets[f + 1]):
        if across[c] >= 0:
            ax, ay, az = area_vector(points, near.offsets, near.connectivity, across[c])
            length = np.sqrt(ax * ax + ay * ay + az * az)
            if length > 0.0:
                sx += ax / length
                sy += ay / length
                sz += az / length
    return x * sx + y * sy + z * sz


@device
def _against(points, near, reference, f):
    x, y, z = area_vector(points, near.offsets, near.connectivity, f)
    return x * reference[f, 0] + y * reference[f, 1] + z * reference[f, 2]


@device
def _turned_over(before, after, near, across, reference, f):
    if _against(after, near, reference, f) < 0.0 and not _against(before, near, reference, f) < 0.0:
        return True
    return _beside(after, near, across, f) < 0.0 and not _beside(before, near, across, f) < 0.0


@kernel
def _find_turned(starts, ends, before, after, near, across, reference, found):
    for part in range(starts.size):
        for f in range(starts[part], ends[part]):
            found[f] = _turned_over(before, after, near, across, reference, f)


@device
def _step_back(before, after, near, f, halved, shortened, vertices):
    # Halve the steps of the vertices of f that have not been halved in this round; returns the vertices that
    # have, and whether there was a step.
    any_step = False
    for c in range(near.offsets[f], near.offsets[f + 1]):
        v = near.connectivity[c]
        if halved[v] >= 128:
            any_step = True
            continue
        still = True
        for axis in range(3):
            still = still and after[v, axis] == before[v, axis]
        if still:
            continue
        any_step = True
        shortened[vertices] = v
        vertices += 1
        halved[v] += 1
        share = 0.5 if halved[v] <= _HALVINGS else 0.0
        halved[v] += 128
        for axis in range(3):
            step = share * (after[v, axis] - before[v, axis])
            after[v, axis] = before[v, axis] + step if step != 0.0 else before[v, axis]
    return vertices, any_step


@kernel
def _step_back_from(before, after, near, across, reference, found):
    # Only what lies around the faces `found` is looked at, again and again; hence no threads.
    seen = np.zeros(near.offsets.size - 1, np.uint8)
    halved = np.zeros(before.shape[0], np.uint8)
    shortened = np.empty(before.shape[0], np.int32)
    waiting = np.empty(near.offsets.size - 1, np.int32)
    faces = found.size
    waiting[:faces] = found
    while faces > 0:
        vertices = 0
        for i in range(faces):
            f = waiting[i]
            vertices, own = _step_back(before, after, near, f, halved, shortened, vertices)
            if not own:  # then its neighbours have turned
                for c in range(near.offsets[f], near.offsets[f + 1]):
                    if across[c] >= 0:
                        vertices, own = _step_back(
                            before, after, near, across[c], halved, shortened, vertices
                        )
        faces = 0
        for i in range(vertices):
            v = shortened[i]
            halved[v] -= 128
            for row in range(near.corner_offsets[v], near.corner_offsets[v + 1]):
                f = near.corner_face[near.corners[row]]
                for c in range(near.offsets[f] - 1, near.offsets[f + 1]):
                    g = f if c < near.offsets[f] else across[c]
                    if g >= 0 and not seen[g] and _turned_over(before, after, near, across, reference, g):
                        seen[g] = 1
                        waiting[faces] = g
                        faces += 1
        for i in range(faces):
            seen[waiting[i]] = 0


@kernel
def _propose(starts, ends, targets, proposed):
    for part in range(starts.size):
        for v in range(starts[part], ends[part]):
            for axis in range(3):
                proposed[v, axis] = targets[v, axis]


class FeaturePreserving(Scheme):
    """Filter the face normals under a soft guide, and let the points follow, until what went is white.

    An iteration filters the normals once and moves all vertices three times (Sun et al. 2007), with a return
    to the first place along directions that no target normal sees. What it proposes turns no face over.

    Parameters
    ----------
    whiteness : float
        Autocorrelation of what has been removed at which the run ends, see :data:`WHITENESS`.

    Attributes
    ----------
    noise : float
        Noise level of the input, model units.
    """

    def __init__(self, whiteness: float = WHITENESS["normal"]) -> None:
        self.whiteness = whiteness
        self.noise = 0.0

    def bind(self, state: State) -> None:
        near, first = state.near, state.original
        n, m = len(state.points), len(near.offsets) - 1
        self._state, self.iteration = state, 0
        level, self.noise = noise_levels(first, near)
        self._first = first.points
        self._anchor, self._kept = first.points.copy(), np.ones(n)
        self._faces, self._vertices = parallel.ranges(m), parallel.ranges(n)
        self._normal, self._area, self._centre = np.empty((m, 3)), np.empty(m), np.empty((m, 3))
        self._bend, self._distance = np.empty(len(near.connectivity)), np.empty(len(near.connectivity))
        self._across = face_rings.across(near)
        self._rings = face_rings.rings(near)
        self._measure(state, first.points)
        edge = self._edges(state)
        of_faces, mean = self._at_faces(near, edge), float(edge.mean()) if n else 0.0
        constant, growth, least, largest = _WINDOW
        with np.errstate(invalid="ignore", divide="ignore"):
            window = constant + growth * self._at_faces(near, level) / of_faces
        # Where the mesh is graded, a window is so many of the distances there.
        self._window = np.clip(np.nan_to_num(window, nan=least), least, largest)
        if mean > 0.0:
            self._window *= of_faces / mean
        self._nearby = face_rings.nearby(
            near, self._across, self._centre, 2.0 * self._window * self._mean_distance()
        )
        self._farthest = _FARTHEST * level
        self._targets, self._released = first.points.copy(), np.zeros(n, np.uint8)

    def _edges(self, state: State) -> Float64:
        """Return the mean edge length about each vertex, (n,)."""
        near, n = state.near, len(state.points)
        edge, averaged = np.zeros((n, 1)), np.empty((n, 1))
        parallel.run(_mean_edges, *self._vertices, self._first, near, edge)
        for _ in range(_EDGE_AVERAGINGS):
            parallel.run(_average, *self._vertices, near, edge, averaged)
            edge, averaged = averaged, edge
        return edge[:, 0]

    def _at_faces(self, near: Adjacency, values: Float64) -> Float64:
        """Return the means of the values at the vertices, (n,), over the corners of each face, (m,)."""
        means = np.empty(len(near.offsets) - 1)
        parallel.run(_mean_at_faces, *self._faces, near, values, means)
        return means

    def _mean_distance(self) -> float:
        inner = self._across >= 0
        return float(self._distance[inner].mean()) if inner.any() else 0.0

    def _measure(self, state: State, points: Float64) -> None:
        near = state.near
        parallel.run(_measure, *self._faces, points, near, self._normal, self._area, self._centre)
        parallel.run(
            _measure_edges, *self._faces, near, self._across, self._normal, self._centre, self._bend,
            self._distance,
        )  # fmt: skip

    @property
    def finished(self) -> str:
        # Of the points where they are: constraints may have let them go part of the way.
        state = self._state
        if not self.iteration:
            return ""
        return "white" if self._correlated(state, state.points)[1] >= self.whiteness else ""

    def tell(self, report: RunReport) -> None:
        report.noise_level = self.noise

    def prepare(self, state: State, turn: int) -> None:
        freed = self._released != 0
        self._anchor[freed] = state.points[freed]
        self._released[:] = 0
        target = self.filtered(state)
        self.iteration += 1
        self._targets = self._followed(state, target)

    def filtered(self, state: State) -> Float64:
        """Return the normals that the faces should have, (m, 3)."""
        m, near, rings = len(self._area), state.near, self._rings
        late = max(0, self.iteration - 2)
        self._measure(state, state.points)
        patch, guide, target = np.empty((m, 3)), np.empty((m, 3)), np.empty((m, 3))
        parallel.run(
            _find_patches, *self._faces, near, self._across, *rings, self._normal, self._area, self._bend,
            _EXPONENT + _GROWTH * late, patch, smallest_share=parallel.COSTLY,
        )  # fmt: skip
        parallel.run(_guide, *self._faces, *rings, patch, self._normal, guide)
        bell = max(_NARROWEST, _BELL * _NARROWING**late)
        parallel.run(
            _filter, *self._faces, *self._nearby, self._centre, self._area, self._normal, guide,
            self._window * self._mean_distance(), bell, target, smallest_share=parallel.COSTLY,
        )  # fmt: skip
        return target

    def _followed(self, state: State, target: Float64) -> Float64:
        """Return where points go after the target normals."""
        near, vertices = state.near, self._vertices
        points, moved = state.points.copy(), np.empty_like(state.points)
        for turn in range(VERTEX_PASSES):
            if turn:
                parallel.run(_measure, *self._faces, points, near, self._normal, self._area, self._centre)
            parallel.run(
                _move, *vertices, points, near, state.pinned, self._normal, self._centre, target,
                self._anchor, self._released, moved,
            )  # fmt: skip
            points, moved = moved, points
        correlation, _ = self._correlated(state, points)
        averaged = np.empty_like(correlation)
        for _ in range(_AVERAGINGS):
            parallel.run(_average, *vertices, near, correlation, averaged)
            correlation, averaged = averaged, correlation
        centre = _CENTRE + self.whiteness - WHITENESS["normal"]
        parallel.run(
            _hold, *vertices, state.points, self._first, state.pinned, correlation, centre - _RAMP,
            centre + _RAMP, self._farthest, self._kept, points,
        )  # fmt: skip
        found = np.empty(len(self._area), np.bool_)
        guard = state.points, points, near, self._across, state.reference
        parallel.run(_find_turned, *self._faces, *guard, found)
        if found.any():
            _step_back_from(*guard, np.flatnonzero(found))
        return points

    def _correlated(self, state: State, points: Float64) -> tuple[Float64, float]:
        """Return local terms of the autocorrelation of what has been removed, (n, 2), and the whole."""
        near, vertices, n = state.near, self._vertices, len(points)
        parallel.run(_measure, *self._faces, points, near, self._normal, self._area, self._centre)
        removed, pairs, products = np.empty(n), np.empty(n, np.int64), np.empty(n)
        terms = np.empty((n, 2))
        parallel.run(_find_removed, *vertices, points, self._first, near, self._normal, self._area, removed)
        parallel.run(_correlate, *vertices, near, state.pinned, removed, terms, products, pairs)
        free = state.pinned == 0
        square, count = float((removed[free] ** 2).mean()) if free.any() else 0.0, int(pairs.sum())
        whole = float(products.sum()) / count / square if count and square > 0.0 else np.inf
        return terms, whole

    def propose(self, state: State, turn: int, starts: Int64, ends: Int64, proposed: Float64) -> None:
        parallel.run(_propose, starts, ends, self._targets, proposed)
