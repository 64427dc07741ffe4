"""The scheme of feature-preserving denoising, its neighbourhoods and its noise level, against slow NumPy."""

import meshes
import numpy as np
import pytest
import pyvista as pv

from vtksmooth.filters.arrays import surface_of
from vtksmooth.kernels.measures.aspect_ratio import area_vectors
from vtksmooth.kernels.measures.noise import noise_levels
from vtksmooth.kernels.mesh import adjacency, face_rings
from vtksmooth.kernels.mesh.mesh import Mesh
from vtksmooth.kernels.smoothing import loop
from vtksmooth.kernels.smoothing.schemes.feature_preserving import WHITENESS, FeaturePreserving


def ball(nsub=2, noise=0.0, seed=1):
    """An icosphere of radius 1; noise along its normals, in mean edges."""
    mesh = surface_of(pv.Icosphere(nsub=nsub, radius=1.0)).mesh
    points = mesh.points / np.linalg.norm(mesh.points, axis=1)[:, None]
    edges = np.linalg.norm(points[mesh.connectivity[0::3]] - points[mesh.connectivity[1::3]], axis=1)
    size = noise * edges.mean()
    return mesh.with_points(points * (1.0 + size * np.random.default_rng(seed).normal(size=(len(points), 1))))


def corners_of(mesh):
    return [list(mesh.connectivity[a:b]) for a, b in zip(mesh.offsets, mesh.offsets[1:], strict=False)]


def unit(vectors):
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


# -- by the formulae, one face and one vertex after the other, triangles only -------------------------


class Slow:
    """The algorithm without boundary and without the guard against inversion."""

    def __init__(self, mesh):
        self.faces = corners_of(mesh)
        self.first = mesh.points.copy()
        near = adjacency.build(mesh)
        sets = [set(face) for face in self.faces]
        self.ring = [[g for g, other in enumerate(sets) if other & own] for own in sets]
        self.edges = [
            (f, g) for f in range(len(sets)) for g in range(f) if len(sets[f] & sets[g]) == 2
        ]  # fmt: skip
        self.of_vertex = [[f for f, own in enumerate(sets) if v in own] for v in range(mesh.n_points)]
        self.neighbours = [sorted(set().union(*(sets[f] for f in fs)) - {v})
                           for v, fs in enumerate(self.of_vertex)]  # fmt: skip
        self.levels, self.sigma = noise_levels(mesh, near)
        edge = np.array([np.linalg.norm(self.first[ws] - self.first[v], axis=1).mean()
                         for v, ws in enumerate(self.neighbours)])  # fmt: skip
        edge = self.averaged(edge, 6)
        of_face = edge[self.faces].mean(axis=1)
        self.window = np.clip(1.2 + 6.0 * self.levels[self.faces].mean(axis=1) / of_face, 1.25, 3.0)
        self.window *= of_face / edge.mean()
        _, _, centre = self.measured(self.first)
        reach = 2.0 * self.window * self.distance(centre)
        across = [[a + b - f for a, b in self.edges if f in (a, b)] for f in range(len(sets))]
        self.nearby = []
        for f in range(len(sets)):
            found, waiting = {f}, [f]
            while waiting:
                for g in across[waiting.pop()]:
                    if g not in found and np.linalg.norm(centre[f] - centre[g]) <= reach[f]:
                        found.add(g)
                        waiting.append(g)
            self.nearby.append(sorted(found))

    def averaged(self, values, times):
        for _ in range(times):
            values = 0.25 * values + 0.75 * np.array([values[ws].mean() for ws in self.neighbours])
        return values

    def measured(self, points):
        corners = points[self.faces]
        vectors = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        return unit(vectors), np.linalg.norm(vectors, axis=1), corners.mean(axis=1)

    def distance(self, centre):
        return np.mean([np.linalg.norm(centre[f] - centre[g]) for f, g in self.edges])

    def targets(self, points, i):
        n, area, centre = self.measured(points)
        mean, uneven = np.empty_like(n), np.empty(len(n))
        for f, ring in enumerate(self.ring):
            mean[f] = unit((area[ring, None] * n[ring]).sum(axis=0))
            apart = max(np.linalg.norm(n[a] - n[b]) for a in ring for b in ring)
            inner = [np.linalg.norm(n[a] - n[b]) for a, b in self.edges if a in ring and b in ring]
            uneven[f] = apart * max(inner) / (sum(inner) + 1e-9)
        beta, r = 0.4 + 0.3 * max(0, i - 2), max(0.12, 0.25 * 0.9 ** max(0, i - 2))
        guide = np.empty_like(n)
        for f, ring in enumerate(self.ring):
            weights = ((uneven[ring].min() + 1e-6) / (uneven[ring] + 1e-6)) ** beta
            guide[f] = unit((weights[:, None] * mean[ring]).sum(axis=0))
        s = self.window * self.distance(centre)
        target = np.empty_like(n)
        for f, near in enumerate(self.nearby):
            away = ((centre[f] - centre[near]) ** 2).sum(axis=1)
            apart = ((guide[f] - guide[near]) ** 2).sum(axis=1)
            weights = area[near] * np.exp(-away / (2 * s[f] ** 2) - apart / (2 * r * r))
            target[f] = unit((weights[:, None] * n[near]).sum(axis=0))
        return target

    def followed(self, points, target):
        begin, released = points, set()
        for _ in range(3):
            n, _, centre = self.measured(points)
            moved = points.copy()
            for v, faces in enumerate(self.of_vertex):
                if any(n[f] @ target[f] < 0.2 for f in faces):
                    released.add(v)
                u = self.first[v] - points[v]
                if v in released:
                    u = 0.3 * (points[self.neighbours[v]].mean(axis=0) - points[v])
                middle = unit(target[faces].sum(axis=0))
                u = u - middle * (u @ middle)
                m = np.mean([np.outer(target[f], target[f]) for f in faces], axis=0)
                moved[v] += np.mean(
                    [target[f] * (target[f] @ (centre[f] - points[v])) for f in faces], axis=0
                )
                moved[v] += 0.1 * np.linalg.solve(m + 0.1 * np.eye(3), u)
            points = moved
        n, area, _ = self.measured(points)
        normal = unit(np.array([(area[faces, None] * n[faces]).sum(axis=0) for faces in self.of_vertex]))
        r = ((points - self.first) * normal).sum(axis=1)
        a, b = np.array([r[v] * r[ws].mean() for v, ws in enumerate(self.neighbours)]), r * r
        kept = np.clip((0.06 - self.averaged(a, 12) / self.averaged(b, 12)) / 0.12, 0.0, 1.0)
        return begin + kept[:, None] * (points - begin)


@pytest.fixture(scope="module")
def noisy():
    return ball(noise=0.15)


def test_an_iteration_is_what_the_formulae_say(noisy):
    slow = Slow(noisy)
    expected = slow.followed(noisy.points, slow.targets(noisy.points, 0))
    assert np.abs(expected - noisy.points).max() > 0.02  # else there is nothing to compare
    points, report = loop.smooth(noisy, FeaturePreserving(), iterations=1)
    assert report.noise_level == slow.sigma
    np.testing.assert_allclose(points, expected, atol=1e-12)


@pytest.mark.parametrize("iteration", [0, 4])
def test_target_normals_are_what_the_formulae_say(noisy, iteration):
    found = []

    class Watched(FeaturePreserving):
        def filtered(self, state):
            self.iteration = iteration
            found.append(super().filtered(state))
            return found[-1]

    loop.smooth(noisy, Watched(), iterations=1)
    np.testing.assert_allclose(found[0], Slow(noisy).targets(noisy.points, iteration), atol=1e-12)


# -- neighbourhoods ------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", meshes.KINDS)
def test_faces_are_near_that_share_vertices_or_edges(kind):
    mesh = meshes.sheet(8, 6, kind, jitter=0.3, bump=1.0)
    near, faces = adjacency.build(mesh), corners_of(mesh)
    offsets, rings = face_rings.rings(near)
    beyond = face_rings.across(near)
    for f, own in enumerate(faces):
        expected = {g for g, other in enumerate(faces) if set(other) & set(own)}
        row = rings[offsets[f] : offsets[f + 1]].tolist()
        assert row[0] == f
        assert sorted(row) == sorted(expected)
        for i, c in enumerate(range(mesh.offsets[f], mesh.offsets[f + 1])):
            edge = {own[i], own[(i + 1) % len(own)]}
            others = [g for g, other in enumerate(faces) if g != f and edge <= set(other)]
            assert beyond[c] == (others[0] if others else -1)


def test_nearby_faces_are_connected_within_the_distance():
    # Two sheets, one over the other: what is near across the gap does not count.
    one = meshes.sheet(6, 6)
    points = np.concatenate((one.points, one.points + np.array([0.0, 0.0, 0.1])))
    faces = corners_of(one)
    mesh = Mesh.from_faces(points, faces + [[v + one.n_points for v in face] for face in faces])
    centre = np.array([points[face].mean(axis=0) for face in corners_of(mesh)])
    near = adjacency.build(mesh)
    reach = np.full(mesh.n_faces, 1.5)
    offsets, nearby = face_rings.nearby(near, face_rings.across(near), centre, reach)
    for f in range(mesh.n_faces):
        away = np.linalg.norm(centre - centre[f], axis=1)
        same = (np.arange(mesh.n_faces) < one.n_faces) == (f < one.n_faces)
        assert sorted(nearby[offsets[f] : offsets[f + 1]]) == np.flatnonzero((away <= 1.5) & same).tolist()


def test_the_pole_of_a_sphere_has_no_more_than_the_most():
    mesh = surface_of(pv.Sphere(theta_resolution=500, phi_resolution=5)).mesh
    near = adjacency.build(mesh)
    offsets, _ = face_rings.rings(near)
    assert np.diff(offsets).max() == face_rings.MOST_IN_RING
    points, _ = loop.smooth(mesh, FeaturePreserving(), iterations=2)
    assert np.isfinite(points).all()


# -- noise level ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("noise", [0.05, 0.2, 0.5])
def test_the_noise_level_of_a_ball_is_that_of_the_noise(noise):
    clean, mesh = ball(5), ball(5, noise)
    truth = (np.linalg.norm(mesh.points, axis=1) - 1.0).std()
    levels, level = noise_levels(mesh, adjacency.build(mesh))
    assert level == pytest.approx(truth, rel=0.1)
    assert np.sqrt((levels**2).mean()) == pytest.approx(truth, rel=0.2)
    assert noise_levels(clean, adjacency.build(clean))[1] < 0.01 * truth


def test_the_noise_level_is_that_of_least_squares():
    # One patch: a vertex with its two-ring.
    mesh = meshes.sheet(4, 4)
    mesh.points[:, 2] = 0.1 * np.random.default_rng(3).normal(size=mesh.n_points)
    near = adjacency.build(mesh)
    variances = []
    areas = np.zeros_like(mesh.points)
    for face in corners_of(mesh):
        areas[face] += 0.5 * np.cross(*(mesh.points[face[1:]] - mesh.points[face[0]]))
    rows = [set(near.ring[a:b]) for a, b in zip(near.ring_offsets, near.ring_offsets[1:], strict=False)]
    for v in np.flatnonzero(near.kinds == adjacency.INTERIOR):
        two = sorted({v}.union(rows[v], *(rows[w] for w in rows[v])))
        normal = unit(areas[two].sum(axis=0))
        across = np.linalg.svd(normal[None])[2][1:]
        off = mesh.points[two] - mesh.points[v]
        (x, y), z = (off @ across.T).T, off @ normal
        terms = np.column_stack((np.ones_like(x), x, y, x * x, x * y, y * y))
        left = z - terms @ np.linalg.lstsq(terms, z, rcond=None)[0]
        if len(two) > 6:
            variances.append(left @ left / (len(two) - 6))
    assert noise_levels(mesh, near)[1] == pytest.approx(np.sqrt(np.quantile(variances, 0.4)), rel=1e-9)


def test_the_noise_of_a_part_is_found_there_and_nowhere_else():
    clean, mesh = ball(5), ball(5, 0.2)
    noisy = clean.points[:, 2] > 0.3
    points = np.where(noisy[:, None], mesh.points, clean.points)
    truth = (np.linalg.norm(points[noisy], axis=1) - 1.0).std()
    near = adjacency.build(clean)
    levels, level = noise_levels(clean.with_points(points), near)
    assert level == pytest.approx(truth, rel=0.15)
    assert (levels[noisy] > 0.5 * truth).all()
    assert (levels[clean.points[:, 2] < 0.1] < 0.02 * truth).all()
    smooth, _ = loop.smooth(clean.with_points(points), FeaturePreserving(), iterations=20)
    off = np.abs(np.linalg.norm(smooth, axis=1) - 1.0)
    assert off[noisy].mean() < 0.5 * np.abs(np.linalg.norm(points[noisy], axis=1) - 1.0).mean()
    still = clean.points[:, 2] < 0.0
    assert np.linalg.norm(smooth[still] - points[still], axis=1).max() < 0.1 * truth


# -- runs ----------------------------------------------------------------------------------------------


def test_the_run_ends_by_itself_and_the_stronger_it_is_the_more_goes():
    mesh, moved = ball(4, 0.3), []
    for name in ("gentle", "normal", "strong"):
        points, report = loop.smooth(mesh, FeaturePreserving(WHITENESS[name]), iterations=20)
        if name != "strong":  # that may use all iterations
            assert report.stop_reason == "white"
            assert 0 < report.iterations < 15
        moved.append(np.linalg.norm(points - mesh.points, axis=1).mean())
    assert moved[0] < moved[1] < moved[2]


def test_where_the_mesh_is_graded_the_window_is_too():
    # Points of a ball drawn to one pole: edges there are a tenth of those at the other, and so is the noise.
    even, random = ball(5), np.random.default_rng(2)
    turn = np.arctan2(even.points[:, 1], even.points[:, 0])
    rise = 2.0 * np.arctan(np.tan(0.5 * np.arccos(np.clip(even.points[:, 2], -1.0, 1.0))) / np.sqrt(10.0))
    points = np.column_stack((np.sin(rise) * np.cos(turn), np.sin(rise) * np.sin(turn), np.cos(rise)))
    near = adjacency.build(even)
    owner = np.repeat(np.arange(len(points)), np.diff(near.ring_offsets))
    lengths = np.linalg.norm(points[near.ring] - points[owner], axis=1)
    edge = np.bincount(owner, lengths) / np.diff(near.ring_offsets)
    assert edge.max() > 9.0 * edge.min()
    noisy = even.with_points(points * (1.0 + 0.25 * edge * random.normal(size=len(points)))[:, None])
    smooth, report = loop.smooth(noisy, FeaturePreserving(), iterations=20)
    assert report.stop_reason == "white"
    truth = unit(points[corners_of(even)].mean(axis=1))
    for part in (edge < np.quantile(edge, 0.3), edge > np.quantile(edge, 0.7)):
        faces = part[even.connectivity].reshape(-1, 3).all(axis=1)
        before, after = (
            np.arccos((unit(area_vectors(even.with_points(p))) * truth).sum(axis=1))[faces].mean()
            for p in (noisy.points, smooth)
        )
        assert after < 0.12 * before


def test_a_clean_polyhedron_stays():
    box = surface_of(pv.Box(level=15).triangulate().clean()).mesh
    points, report = loop.smooth(box, FeaturePreserving(), iterations=20)
    assert report.iterations < 20
    np.testing.assert_allclose(points, box.points, atol=1e-12)
