"""Slow, obvious versions of what the kernels compute: written from the definitions, face by face."""

from __future__ import annotations

from collections import defaultdict
from itertools import pairwise

import numpy as np
from meshes import lists

# -- neighbourhoods --------------------------------------------------------------------------------


def directed_edges(mesh):
    """{(p, q): faces that run from p to q}."""
    found = defaultdict(list)
    for number, face in enumerate(lists(mesh)):
        for i, p in enumerate(face):
            found[p, face[(i + 1) % len(face)]].append(number)
    return found


def fans(faces, v):
    """Into how many fans the triangles round v fall: they are in one fan if they share an edge at v."""
    fan = list(range(len(faces)))
    for i, face in enumerate(faces):
        for j, other in enumerate(faces):
            if len(set(face) & set(other) - {v}) > 0:
                fan = [fan[i] if number == fan[j] else number for number in fan]
    return len(set(fan))


def one_rings(mesh):
    rings = [set() for _ in range(mesh.n_points)]
    for p, q in directed_edges(mesh):
        if p != q:
            rings[p].add(q)
            rings[q].add(p)
    return rings


def stars(mesh):
    result = [set() for _ in range(mesh.n_points)]
    for face in lists(mesh):
        for p in face:
            result[p].update(face)
    return [star - {p} for p, star in enumerate(result)]


def boundaries(mesh):
    """Per point: kind (0 interior, 1 boundary, 2 non-manifold, 3 unused), the two next on the boundary."""
    edges, rings = directed_edges(mesh), one_rings(mesh)
    used, bad = set(mesh.connectivity.tolist()), set()
    for face in lists(mesh):
        for p in face:
            if len(face) < 3 or face.count(p) > 1:
                bad.add(p)
        # Going out and coming back along one edge makes the point in between irregular.
        bad.update(p for i, p in enumerate(face) if face[i - 1] == face[(i + 1) % len(face)])
    kinds, along = [], []
    for p, ring in enumerate(rings):
        before = [q for q in ring if len(edges[q, p]) == 1 and not edges[p, q]]
        after = [q for q in ring if len(edges[p, q]) == 1 and not edges[q, p]]
        inner = [q for q in ring if len(edges[p, q]) == 1 and len(edges[q, p]) == 1]
        regular = p not in bad and len(before) + len(after) + len(inner) == len(ring)
        if p not in used:
            kinds.append(3)
        elif regular and not before and not after:
            kinds.append(0)
        elif regular and len(before) == 1 and len(after) == 1:
            kinds.append(1)
        else:
            kinds.append(2)
        along.append((before[0], after[0]) if kinds[-1] == 1 else (-1, -1))
    return kinds, along


# -- quality and measures --------------------------------------------------------------------------


def triangle_area_vector(a, b, c):
    return 0.5 * np.cross(b - a, c - a)


def area_vectors(mesh):
    zero = np.zeros(3)
    return np.array(
        [
            sum(
                (triangle_area_vector(zero, a, b) for a, b in zip(p, np.roll(p, -1, axis=0), strict=True)),
                zero,
            )
            if len(p)
            else zero
            for p in (mesh.points[face] - (mesh.points[face[0]] if face else 0.0) for face in lists(mesh))
        ]
    )


def vertex_normals(mesh):
    """Area-weighted, not of unit length."""
    normals = np.zeros((mesh.n_points, 3))
    for face, area in zip(lists(mesh), area_vectors(mesh), strict=True):
        for p in face:
            normals[p] += area
    return normals


def reference_directions(mesh):
    normals = vertex_normals(mesh)
    return np.array([normals[face].sum(axis=0) for face in lists(mesh)])


def _unscaled(corners, direction):
    """Smallest corner area over root of the squared sides and longest diagonal, along the vector area."""
    vector = np.cross(corners, np.roll(corners, -1, axis=0)).sum(axis=0) / 2
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=1)
    longest = max(np.linalg.norm(p - q) for p in corners for q in corners)
    bottom = np.sqrt((sides**2).sum()) * longest
    if bottom == 0:
        return 0.0
    size = np.linalg.norm(vector)
    axis = (
        direction
        if size < 1e-13 * (sides**2).sum()
        else vector / size * (-1 if vector @ direction < 0 else 1)
    )
    if not axis.any():
        return 0.0
    # Corners in the plane across the axis.
    across = np.linalg.svd(axis[None])[2][1:]
    flat = corners @ (across if np.linalg.det([*across, axis]) > 0 else across[::-1]).T
    areas = [
        np.linalg.det([flat[(i + 1) % len(flat)] - flat[i], flat[i - 1] - flat[i]]) / 2
        for i in range(len(flat))
    ]
    return min(areas) * np.linalg.norm(axis) / bottom


def isoperimetric(corners):
    """4 tan(pi / n) of the vector area over the sum of squared sides: 1 for the regular polygon."""
    vector = np.cross(corners, np.roll(corners, -1, axis=0)).sum(axis=0) / 2
    squares = ((corners - np.roll(corners, 1, axis=0)) ** 2).sum()
    return 4 * np.tan(np.pi / len(corners)) * np.linalg.norm(vector) / squares if squares > 0 else 0.0


def regular_polygon(n):
    angle = 2 * np.pi * np.arange(n) / n
    return np.column_stack([np.cos(angle), np.sin(angle), np.zeros(n)])


def aspect_ratio(corners, direction):
    """k of one face; polygons like quadrilaterals, scaled to 1 for the regular one; between -1 and 1."""
    return max(-1.0, _aspect_ratio(corners, direction))


def _aspect_ratio(corners, direction):
    if len(corners) < 3:
        return 0.0
    if len(corners) == 3:
        vector = triangle_area_vector(*corners)
        squares = ((corners - np.roll(corners, 1, axis=0)) ** 2).sum()
        sign = -1 if vector @ direction < 0 else 1
        return 4 * np.sqrt(3) * sign * np.linalg.norm(vector) / squares if squares > 0 else 0.0
    if len(corners) == 4:
        return 4 * np.sqrt(2) * _unscaled(corners, direction)
    scaled = _unscaled(corners, direction) / _unscaled(regular_polygon(len(corners)), np.array([0.0, 0, 1]))
    if scaled <= 0:
        return scaled
    vector = np.cross(corners, np.roll(corners, -1, axis=0)).sum(axis=0)
    seen = corners - corners.mean(axis=0)
    thickness = np.linalg.norm(seen @ vector / np.linalg.norm(vector)) / np.linalg.norm(seen)
    return min(scaled, isoperimetric(corners)) / (1 + 4 * thickness) ** 2


def aspect_ratios(mesh, reference):
    return np.array([aspect_ratio(mesh.points[f], r) for f, r in zip(lists(mesh), reference, strict=True)])


def corner_angles(mesh):
    """All angles of all faces, degrees."""
    angles = []
    for face in lists(mesh):
        for i, p in enumerate(face):
            a, b = (
                mesh.points[face[i - 1]] - mesh.points[p],
                mesh.points[face[(i + 1) % len(face)]] - mesh.points[p],
            )
            angles.append(np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b)))
    return np.array(angles)


def metric_tensors(mesh, weight):
    """A and b of every vertex, by Jiao's definition."""
    tensors, sums = np.zeros((mesh.n_points, 3, 3)), np.zeros((mesh.n_points, 3))
    angles = iter(np.radians(corner_angles(mesh)))
    for face, area in zip(lists(mesh), area_vectors(mesh), strict=True):
        size = np.linalg.norm(area)
        normal = area / size if size > 0 else area
        for p in face:
            angle = next(angles)
            w = angle if weight == "angle" else size
            tensors[p] += w * np.outer(normal, normal)
            sums[p] += w * normal
    return tensors, sums


def volume(mesh):
    """Tetrahedra from the middle; quadrilaterals as the mean of both ways to cut them."""
    points = mesh.points - mesh.points[np.unique(mesh.connectivity)].mean(axis=0)
    total = 0.0
    for face in lists(mesh):
        p = points[face]
        if len(face) == 3:
            cuts = [[(0, 1, 2)]]
        elif len(face) == 4:
            cuts = [[(0, 1, 2), (0, 2, 3)], [(0, 1, 3), (1, 2, 3)]]
        else:
            p = np.vstack([p, p.mean(axis=0)])
            cuts = [[(len(face), i, (i + 1) % len(face)) for i in range(len(face))]]
        total += sum(np.linalg.det(p[list(t)]) / 6 for cut in cuts for t in cut) / len(cuts)
    return total


def dihedral_angles(mesh):
    """{(p, q): signed angle in degrees} for edges with two faces that agree; p < q."""
    area, edges = area_vectors(mesh), directed_edges(mesh)
    result = {}
    for (p, q), faces in list(edges.items()):
        back = edges.get((q, p), [])
        if p < q and len(faces) == 1 and len(back) == 1:
            m, n = (area[f] / np.linalg.norm(area[f]) for f in (faces[0], back[0]))
            angle = np.degrees(np.arccos(np.clip(m @ n, -1, 1)))
            result[p, q] = np.copysign(angle, np.cross(m, n) @ (mesh.points[q] - mesh.points[p]))
    return result


def triangles(mesh):
    """Fans; quadrilaterals along the shorter diagonal."""
    result = []
    for face in lists(mesh):
        p = mesh.points[face]
        if len(face) == 4 and np.linalg.norm(p[1] - p[3]) < np.linalg.norm(p[0] - p[2]):
            face = face[1:] + face[:1]
        result += [[face[0], face[i], face[i + 1]] for i in range(1, len(face) - 1)]
    return result


def closest_on_segment(a, b, q):
    length = (b - a) @ (b - a)
    s = np.clip((q - a) @ (b - a) / length, 0, 1) if length > 0 else 0.0
    return a + s * (b - a)


def distance_to_triangle(a, b, c, q):
    """The least of the distances to the three sides and, where the foot is inside, to the plane."""
    best = min(np.linalg.norm(closest_on_segment(*side, q) - q) for side in ((a, b), (b, c), (c, a)))
    normal = np.cross(b - a, c - a)
    square = normal @ normal
    if square > 0:
        inside = [np.cross(t - s, q - s) @ normal for s, t in ((a, b), (b, c), (c, a))]
        if min(inside) >= 0:
            best = min(best, abs((q - a) @ normal) / np.sqrt(square))
    return best


# -- schemes: the proposal for one vertex ------------------------------------------------------------


def mean_step(points, v, neighbours, weights, relaxation):
    total = sum(weights)
    if total == 0:
        return points[v]
    step = sum(w * (points[q] - points[v]) for q, w in zip(neighbours, weights, strict=True)) / total
    return points[v] + relaxation * step


def umbrella(points, v, ring, relaxation):
    return mean_step(points, v, ring, [1.0] * len(ring), relaxation)


def scale_dependent(points, v, ring, relaxation):
    ring = [q for q in ring if (points[q] != points[v]).any()]
    return mean_step(points, v, ring, [1 / np.linalg.norm(points[q] - points[v]) for q in ring], relaxation)


def cotangent_weights(mesh, v):
    """Faces as fans from v; the weight of an edge is the sum over its faces, negative ones count as 0."""
    points, weight = mesh.points, defaultdict(float)

    def cot(at, one, other):
        a, b = points[one] - points[at], points[other] - points[at]
        area = np.linalg.norm(np.cross(a, b))
        return a @ b / area if area > 0 else 0.0

    for face in lists(mesh):
        if v in face:
            at = face.index(v)
            rest = face[at + 1 :] + face[:at]
            for p, q in pairwise(rest):
                weight[p] += cot(q, v, p)
                weight[q] += cot(p, v, q)
    return {q: w for q, w in weight.items() if w > 0}


def cotangent(mesh, v, relaxation):
    weight = cotangent_weights(mesh, v)
    return mean_step(mesh.points, v, list(weight), list(weight.values()), relaxation)


def thin_plate(points, rings, kinds, v, relaxation):
    def laplacian(q):
        return points[list(rings[q])].mean(axis=0) - points[q] if kinds[q] == 0 else np.zeros(3)

    ring = rings[v]
    second = np.mean([laplacian(q) for q in ring], axis=0) - laplacian(v)
    nu = 1 + np.mean([1 / len(rings[q]) for q in ring])
    return points[v] - relaxation / nu * second


def trapezium(points, v, neighbours):
    """ALGORITHMS section 1, word by word."""
    p0 = points[v]
    wanted = []
    neighbours = [q for q in neighbours if (points[q] != p0).any()]
    for i in neighbours:
        others = [j for j in neighbours if j != i]
        if not others:
            continue

        def cosine(j, i=i):
            a, b = points[i] - p0, points[j] - p0
            return a @ b / np.linalg.norm(a) / np.linalg.norm(b)

        j = min(others, key=cosine)
        chord = points[i] - points[j]
        length = np.linalg.norm(chord)
        u = chord / length if length > 0 else np.zeros(3)
        middle = (points[i] + points[j]) / 2
        wanted.append(p0 + ((middle - p0) @ u) * u)
    return np.mean(wanted, axis=0) if wanted else p0


def angle_based(mesh, v, weighted):
    """In the plane z = 0: every spoke turned about its outer end onto the bisector there; the mean."""
    points = mesh.points[:, 0] + 1j * mesh.points[:, 1]
    after, before = {}, {}
    for face in lists(mesh):
        if v in face:
            at, n = face.index(v), len(face)
            after[face[(at + 1) % n]] = face[(at + 2) % n]
            before[face[at - 1]] = face[at - 2]
    wanted, weights = [], []
    for q in after.keys() & before.keys():
        spoke = points[v] - points[q]
        right = np.angle((points[before[q]] - points[q]) / spoke)  # anticlockwise from the spoke
        left = np.angle((points[after[q]] - points[q]) / spoke)  # clockwise, so negative
        wanted.append(points[q] + spoke * np.exp(0.5j * (right + left)))
        weights.append(1 / (right - left) ** 2 if weighted else 1.0)
    place = np.average(wanted, weights=weights)
    return np.array([place.real, place.imag, 0.0])


def _corners_at(mesh, v):
    """Number and corners of each face at v, v first, in the face's direction."""
    for number, face in enumerate(lists(mesh)):
        if v in face:
            i = face.index(v)
            yield number, mesh.points[face[i:] + face[:i]]


def _towards(start, targets, weights, factor):
    total = sum(weights)
    if total == 0:
        return start
    return start + factor * (sum(w * t for w, t in zip(weights, targets, strict=True)) / total - start)


def equilateral(mesh, v, directions, factor):
    """Mean of the apexes that make the corner at v one of a regular polygon."""
    targets = []
    for number, corners in _corners_at(mesh, v):
        first, last = corners[1], corners[-1]
        side, middle = last - first, 0.5 * (first + last)
        height = corners[0] - closest_on_line(first, last, corners[0])
        if height @ np.cross(directions[number], side) < 0:
            height = -height
        # The regular corner's angle is pi - 2 pi / n; half of it stands over half of the side.
        half = np.pi / 2 - np.pi / len(corners)
        length = 0.5 * np.linalg.norm(side) / np.tan(half)
        targets.append(middle + length * height / np.linalg.norm(height))
    return _towards(mesh.points[v], targets, [1.0] * len(targets), factor)


def closest_on_line(a, b, q):
    return a + (q - a) @ (b - a) / ((b - a) @ (b - a)) * (b - a)


def area_weighted(mesh, v, factor):
    areas = np.linalg.norm(area_vectors(mesh), axis=1)
    faces = list(_corners_at(mesh, v))
    centres = [corners.mean(axis=0) for _, corners in faces]
    return _towards(mesh.points[v], centres, [areas[number] for number, _ in faces], factor)


def _angle(a, b):
    return np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b)


def angle_weighted(mesh, v, factor):
    faces = [corners for _, corners in _corners_at(mesh, v)]
    angles = [_angle(corners[1] - corners[0], corners[-1] - corners[0]) for corners in faces]
    return _towards(mesh.points[v], [corners.mean(axis=0) for corners in faces], angles, factor)


def optimal_delaunay(mesh, v, factor):
    """Circumcentres by their barycentric coordinates sin(2 angle), 0 at obtuse corners."""
    centres, areas = [], []
    for _, corners in _corners_at(mesh, v):
        for i in range(1, len(corners) - 1):
            triangle = corners[[0, i, i + 1]]
            angles = [
                _angle(triangle[(j + 1) % 3] - triangle[j], triangle[j - 1] - triangle[j]) for j in range(3)
            ]
            share = np.maximum(0, np.sin(2 * np.array(angles)))
            centres.append(share @ triangle / share.sum())
            areas.append(np.linalg.norm(triangle_area_vector(*triangle)))
    return _towards(mesh.points[v], centres, areas, factor)


# -- surfaces between labels -----------------------------------------------------------------------


def label_volumes(mesh, points=None):
    """The volume of each label: pyramids from the origin over triangles."""
    p = (mesh.points if points is None else points)[mesh.connectivity.reshape(-1, 3)]
    volumes = np.einsum("ij,ij->i", p[:, 0], np.cross(p[:, 1], p[:, 2])) / 6
    first, second = mesh.face_labels.T
    return np.bincount(first, volumes, second.max() + 1) - np.bincount(second, volumes, second.max() + 1)


def line_edges(mesh):
    """The edges where other than two faces meet, or two that lie between other labels."""
    edges = defaultdict(list)
    for (p, q), faces in directed_edges(mesh).items():
        edges[min(p, q), max(p, q)] += faces
    pairs = {edge: {tuple(mesh.face_labels[f].tolist()) for f in faces} for edge, faces in edges.items()}
    return {edge for edge, faces in edges.items() if len(faces) != 2 or len(pairs[edge]) > 1}


def label_rows(mesh):
    """The neighbours that the Laplacian of each vertex goes by, where all labels close."""
    rings = one_rings(mesh)
    along = [set() for _ in rings]
    for p, q in line_edges(mesh):
        along[p].add(q)
        along[q].add(p)
    return [line if len(line) > 1 else ring for line, ring in zip(along, rings, strict=True)]


def pairwise_labels(mesh, edges, relaxation, reference):
    """One sweep over `edges`: umbrella steps of both ends, then the shortest steps that keep all volumes."""
    points = mesh.points.copy()
    rows = label_rows(mesh)

    def volumes(points):
        return label_volumes(mesh, points)

    def ratios(points, ends):
        faces = [f for f, face in enumerate(lists(mesh)) if set(face) & set(ends)]
        return np.array([aspect_ratio(points[lists(mesh)[f]], reference[f]) for f in faces])

    kept = volumes(points)
    taken = 0
    for ends in edges.tolist():
        step = np.array([relaxation * (points[list(rows[v])].mean(axis=0) - points[v]) for v in ends])
        wanted = (step**2).sum()

        def after(step, ends=ends, points=points):
            there = points.copy()
            there[ends] += step
            return there

        for _ in range(8):
            left = volumes(after(step)) - kept
            # The volumes are bilinear in the two steps: differences over any length are derivatives.
            here = volumes(after(step))
            matrix = [volumes(after(step + unit.reshape(2, 3))) - here for unit in np.eye(6)]
            step = step - (np.linalg.pinv(np.column_stack(matrix), rcond=1e-8) @ left).reshape(2, 3)
        closed = np.abs(volumes(after(step)) - kept).max() < 1e-10
        before, now = ratios(points, ends), ratios(after(step), ends)
        worse = now.min() < 0.2 and (now.min() < before.min() or ((now < 0) & (before >= 0)).any())
        if closed and not worse and 1e-12 * wanted < (step**2).sum() <= 4 * wanted:
            points = after(step)
            taken += 1
    return points, taken
