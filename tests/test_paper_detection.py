"""Jiao's detection as printed, against a slow second implementation: dictionaries and numpy's eigenvalues."""

from __future__ import annotations

from collections import defaultdict

import meshes
import numpy as np
import pytest
from test_features import roof

from vtksmooth import FeatureDetection
from vtksmooth.kernels.features import detection
from vtksmooth.kernels.mesh import adjacency


def reference(mesh, phi_r=20.0, phi_c=35.0, weight="area"):
    """Return classes and the set of ridge edges; closed and open manifolds of triangles."""
    points = mesh.points
    triangles = mesh.connectivity.reshape(-1, 3)
    phi_r, phi_c = np.radians(phi_r) + 1e-3, np.radians(phi_c) + 1e-3
    chi_r, chi_c = np.tan(phi_r / 2) ** 2, 2 * np.tan(phi_c / 2) ** 2
    vectors = np.cross(
        points[triangles[:, 1]] - points[triangles[:, 0]], points[triangles[:, 2]] - points[triangles[:, 0]]
    )
    areas = np.linalg.norm(vectors, axis=1) / 2
    normals = vectors / (2 * areas[:, None])
    faces_of, corner_angles, sides = defaultdict(list), defaultdict(dict), defaultdict(list)
    for f, triangle in enumerate(triangles):
        for i in range(3):
            v, a, b = (int(triangle[(i + k) % 3]) for k in range(3))
            u, w = points[a] - points[v], points[b] - points[v]
            corner_angles[v][f] = np.arccos(u @ w / np.linalg.norm(u) / np.linalg.norm(w))
            faces_of[v].append(f)
            sides[min(v, a), max(v, a)].append(f)
    ring = defaultdict(set)
    for a, b in sides:
        ring[a].add(b)
        ring[b].add(a)
    border = {edge for edge, faces in sides.items() if len(faces) == 1}
    dihedral = {
        edge: np.arccos(np.clip(normals[faces[0]] @ normals[faces[-1]], -1, 1))
        for edge, faces in sides.items()
    }

    def edge(v, w):
        return min(v, w), max(v, w)

    def tensor(v):
        weights = {f: areas[f] if weight == "area" else corner_angles[v][f] for f in faces_of[v]}
        return sum(w * np.outer(normals[f], normals[f]) for f, w in weights.items()), sum(
            w * normals[f] for f, w in weights.items()
        )

    def classified(v, matrix, total, acute):
        values, axes = np.linalg.eigh(matrix)
        if acute is None:  # told from a vertex' own tensor alone
            first = axes[:, 2] * (1.0 if axes[:, 2] @ total > 0 else -1.0)
            acute = any(normals[f] @ first <= 0 for f in faces_of[v])
        on_border = [w for w in ring[v] if edge(v, w) in border]
        defect = abs((np.pi if on_border else 2 * np.pi) - sum(corner_angles[v].values()))
        if values[0] >= chi_c * values[2] or defect >= np.pi / 2 - 1e-6:
            return 2, set(), acute
        if on_border:
            return 1, set(on_border), acute
        if values[1] < chi_r * values[2] and not acute:
            return 0, set(), acute
        if values[1] < 0.003 * values[2]:
            return 3, set(), acute
        along = {
            w: axes[:, 0] @ (points[w] - points[v]) / np.linalg.norm(points[w] - points[v]) for w in ring[v]
        }
        return 1, {min(along, key=along.get), max(along, key=along.get)}, acute

    def identified(v):
        found = {w for w in ring[v] if edge(v, w) in border}
        beyond = classes[v] >= 2 or bool(found)
        if classes[v] == 1:
            found |= chosen[v]
        return found | {w for w in ring[v] if beyond and dihedral[edge(v, w)] >= phi_r}

    everyone = sorted(ring)
    classes, chosen, acute = {}, {}, {}
    for v in everyone:
        classes[v], chosen[v], acute[v] = classified(v, *tensor(v), None)
    for turn in range(2):
        if turn:
            marked = {v: identified(v) for v in everyone}
            renewed = {}
            for v in everyone:
                if classes[v] != 1:
                    continue
                along = [w for w in ring[v] if classes[w] == 1 and (w in marked[v] or v in marked[w])]
                matrix, total = map(sum, zip(*(tensor(w) for w in (v, *along)), strict=True))
                renewed[v] = classified(v, matrix, total, acute[v])[:2]
            for v, (new, way) in renewed.items():
                classes[v], chosen[v] = new, way
        marked = {v: identified(v) for v in everyone}
        changed = {}
        for v in everyone:
            by = {w for w in ring[v] if v in marked[w]}
            if classes[v] < 2:
                if len(by) > 2:
                    changed[v] = 2, set()
                elif classes[v] == 0 and len(by) == 2:
                    changed[v] = 1, by
                elif classes[v] == 1 and len(by) < 2 and not acute[v]:
                    changed[v] = 0, set()
        for v, (new, way) in changed.items():
            classes[v], chosen[v] = new, way
    marked = {v: identified(v) for v in everyone}
    ridges = {(v, w) for v, w in sides if classes[v] and classes[w] and (w in marked[v] or v in marked[w])}
    return np.array([classes[v] for v in everyone]), ridges


def noisy(mesh, level, seed=0):
    push = np.random.default_rng(seed).normal(0.0, level, mesh.points.shape)
    return mesh.with_points(mesh.points + push)


CASES = {
    "cube": lambda: noisy(meshes.cube(6, triangles=True), 0.001),
    "noisy cube": lambda: noisy(meshes.cube(8, triangles=True), 0.05),
    "noisier cube": lambda: noisy(meshes.cube(8, triangles=True), 0.08, 1),
    "sphere": lambda: noisy(meshes.icosphere(3), 0.005),
    "roof": lambda: noisy(roof(60.0)[0], 0.01),
    "sheet": lambda: noisy(meshes.sheet(9, 7), 0.06),
}


@pytest.mark.parametrize("weight", ["area", "angle"])
@pytest.mark.parametrize("name", CASES)
def test_as_a_second_implementation(name, weight):
    mesh = CASES[name]()
    expected, ridges = reference(mesh, weight=weight)
    found = detection.detect(mesh, adjacency.build(mesh), weight=weight, method="paper")
    np.testing.assert_array_equal(found.classes, expected)
    assert set(map(tuple, found.ridge_edges.tolist())) == ridges


def test_angles_and_the_filter():
    mesh = meshes.cube(5, triangles=True)
    found = detection.detect(mesh, adjacency.build(mesh), method="paper")
    on_sides = ((mesh.points == 0) | (mesh.points == 5)).sum(axis=1) - 1
    np.testing.assert_array_equal(found.classes, on_sides)
    assert (found.ridge_angle, found.corner_angle, len(found.ridge_edges)) == (20.0, 35.0, 60)


@pytest.mark.parametrize(("ridge_angle", "there"), [(50.0, True), (70.0, False)])
def test_ridge_angle_decides(ridge_angle, there):
    mesh, on_ridge = roof(60.0)
    found = detection.detect(mesh, adjacency.build(mesh), ridge_angle=ridge_angle, method="paper")
    inner = np.ones(mesh.n_points, bool)
    inner[found.ridge_edges[found.edge_kinds == detection.BOUNDARY]] = False
    assert (found.classes[on_ridge & inner] == there).all()
    assert not found.classes[inner & ~on_ridge].any()


def test_a_flat_two_sided_disc_has_cusps_on_its_rim():
    rim = [[np.cos(a), np.sin(a), 0.0] for a in np.arange(12) * np.pi / 6]
    points = [*rim, [0.0, 0.0, 0.001], [0.0, 0.0, -0.001]]
    faces = [[i, (i + 1) % 12, 12] for i in range(12)] + [[(i + 1) % 12, i, 13] for i in range(12)]
    mesh = meshes.Mesh.from_faces(points, faces)
    found = detection.detect(mesh, adjacency.build(mesh), corner_angle=170.0, method="paper")
    assert (found.classes[:12] == detection.CUSP).all()


@pytest.mark.parametrize("name", meshes.HOSTILE)
def test_hostile_meshes(name):
    mesh = meshes.HOSTILE[name]()
    found = detection.detect(mesh, adjacency.build(mesh), method="paper")
    assert len(found.classes) == mesh.n_points
    assert (found.classes[found.ridge_edges] > 0).all()


def test_the_filter_hands_the_method_on():
    from test_feature_detection import detect

    mesh = noisy(meshes.cube(8, triangles=True), 0.08, 1)
    expected = detection.detect(mesh, adjacency.build(mesh), method="paper")
    robust = detection.detect(mesh, adjacency.build(mesh))
    assert (expected.classes != robust.classes).any()
    found = detect(mesh, method="paper")[1]
    np.testing.assert_array_equal(found["FeatureClass"], expected.classes)
    assert FeatureDetection().method == "robust"
