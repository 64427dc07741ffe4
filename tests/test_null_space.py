"""The null space by its definition, and what it promises for polyhedra."""

import meshes
import numpy as np
import pytest
import reference
from schemes import SCHEMES

from vtksmooth.kernels.features import detection
from vtksmooth.kernels.mesh import adjacency
from vtksmooth.kernels.mesh.mesh import Mesh
from vtksmooth.kernels.smoothing import loop
from vtksmooth.kernels.smoothing.constraints.boundary import Boundary
from vtksmooth.kernels.smoothing.constraints.gate import Gate
from vtksmooth.kernels.smoothing.constraints.local_volume import LocalVolume
from vtksmooth.kernels.smoothing.constraints.null_space import NullSpace
from vtksmooth.kernels.smoothing.schemes.umbrella import Umbrella

SMOOTH, RIDGE, CORNER = 0, 1, 2


def all_axes(mesh, weight="area"):
    """Eigenvectors of the metric tensor of each vertex, as columns, those of the largest eigenvalue first."""
    tensors = np.zeros((mesh.n_points, 3, 3))
    for face, area in zip(meshes.lists(mesh), reference.area_vectors(mesh), strict=True):
        size = np.linalg.norm(area)
        out = mesh.points[np.roll(face, -1)] - mesh.points[face]
        back = -np.roll(out, 1, axis=0)
        angles = np.arccos(
            (out * back).sum(axis=1) / np.linalg.norm(out, axis=1) / np.linalg.norm(back, axis=1)
        )
        angles = np.where(np.cross(out, back) @ area < 0, 2 * np.pi - angles, angles)
        weights = angles if weight == "angle" else np.full(len(face), size)
        tensors[face] += weights[:, None, None] * np.outer(area, area) / size**2
    return np.linalg.eigh(tensors)[1][:, :, ::-1]


@pytest.mark.parametrize("weight", ["area", "angle"])
@pytest.mark.parametrize("kind", meshes.KINDS)
def test_steps_by_their_definition(kind, weight):
    mesh = meshes.joined(
        meshes.torus(24, 16, kind, jitter=0.1),
        meshes.l_shape(kind == "triangles"),
        meshes.cube(3, kind == "triangles"),
    )
    near = adjacency.build(mesh)
    found = detection.detect(mesh, near)
    proposed, _ = loop.smooth(mesh, Umbrella(0.7), iterations=1)
    points, _ = loop.smooth(mesh, Umbrella(0.7), [NullSpace(weight)], iterations=1)
    assert {SMOOTH, RIDGE, CORNER} <= set(found.classes.tolist())
    axes = all_axes(mesh, weight)
    for v, kind_of_vertex in enumerate(found.classes):
        step = proposed[v] - mesh.points[v]
        null = axes[v][:, 1 + kind_of_vertex :]
        neighbours = found.ridge_ring[v]
        if kind_of_vertex == RIDGE and (neighbours >= 0).all():
            step = (mesh.points[neighbours].mean(axis=0) - mesh.points[v]) / 2
        np.testing.assert_allclose(points[v] - mesh.points[v], null @ null.T @ step, atol=1e-13)


def grid_box(size, cells, kind, move, seed=0):
    """A box whose faces are grids, its inner points moved in their faces, those of edges along these."""
    lattice = {}
    points, faces = [], []

    def number(place):
        return lattice.setdefault(place, len(lattice))

    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for side in (0, cells[axis]):
            for i in range(cells[u]):
                for j in range(cells[v]):
                    square = []
                    for a, b in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)):
                        place = [0, 0, 0]
                        place[axis], place[u], place[v] = side, a, b
                        square.append(number(tuple(place)))
                    square = square if side else square[::-1]
                    split = kind == "triangles" or (kind == "mixed" and (i + j) % 2)
                    faces += [square[:3], [square[0], *square[2:]]] if split else [square]
    points = np.array(list(lattice), float)
    inner = (points > 0) & (points < np.array(cells))
    points += move * np.random.default_rng(seed).uniform(-1, 1, points.shape) * inner
    return Mesh.from_faces(points / cells * size, faces)


def wedge(kind, move):
    """A box that is sheared and bevelled: its edges are 50, 76, 90, 104 and 130 degrees."""
    box = grid_box([2.0, 3.0, 2.0], [4, 5, 4], kind, move)
    shear = np.array([[1.0, 0.25, 0.0], [0.0, 1.0, 0.0], [0.8, 0.0, 1.0]])
    return box.with_points(box.points @ shear)


POLYHEDRA = {
    "cube": lambda kind, move: grid_box([1.0, 1.0, 1.0], [5, 5, 5], kind, move),
    "slab": lambda kind, move: grid_box([4.0, 3.0, 0.5], [6, 5, 3], kind, move),
    "wedge": wedge,
}


def planes_of(mesh):
    """For each point the unit normals of the planes that meet there."""
    found = [[] for _ in range(mesh.n_points)]
    for face, area in zip(meshes.lists(mesh), reference.area_vectors(mesh), strict=True):
        normal = area / np.linalg.norm(area)
        for p in face:
            if not any(abs(normal @ other) > 1 - 1e-9 for other in found[p]):
                found[p].append(normal)
    return found


@pytest.mark.parametrize("gate", ["none", "aspect"])
@pytest.mark.parametrize("kind", meshes.KINDS)
@pytest.mark.parametrize("name", POLYHEDRA)
def test_on_polyhedra_faces_stay_flat_ridges_straight_and_corners_where_they_were(name, kind, gate):
    mesh = POLYHEDRA[name](kind, 0.25)
    planes = planes_of(mesh)
    assert [sum(len(p) == n for p in planes) for n in (2, 3)] == [
        (np.array([len(p) for p in planes]) == 2).sum(), 8,
    ]  # fmt: skip
    for scheme in (SCHEMES["umbrella"], SCHEMES["trapezium-drawing"], SCHEMES["cotangent"]):
        constraints = [NullSpace(), LocalVolume(2)] + [Gate("aspect")] * (gate == "aspect")
        points, report = loop.smooth(mesh, scheme, constraints, iterations=200)
        assert report.moved > 0
        off = [
            abs(normal @ (p - q)) for p, q, n in zip(points, mesh.points, planes, strict=True) for normal in n
        ]
        assert max(off) <= 1e-10 * mesh.diagonal
        assert report.volume[1] == pytest.approx(report.volume[0], rel=1e-12)
        assert report.inverted[1] == 0
    if gate == "none":
        # They did move, along ridges too.
        moved = np.linalg.norm(points - mesh.points, axis=1)
        assert max(m for m, n in zip(moved, planes, strict=True) if len(n) == 1) > 0.01
        assert max(m for m, n in zip(moved, planes, strict=True) if len(n) == 2) > 0.01


def test_without_it_the_cube_would_lose_its_ridges():
    mesh = POLYHEDRA["cube"]("triangles", 0.25)
    points, _ = loop.smooth(mesh, Umbrella(), iterations=5)
    ridge = np.array([len(p) for p in planes_of(mesh)]) == 2
    assert np.abs(points - mesh.points)[ridge].max() > 0.01


@pytest.mark.parametrize("kind", meshes.KINDS)
def test_the_boundary_is_left_to_the_boundary(kind):
    mesh = meshes.sheet(10, 8, kind, jitter=0.2, bump=2.0, seed=7, boundary_jitter=0.3)
    kinds = np.array(reference.boundaries(mesh)[0]) == 1
    fixed, _ = loop.smooth(mesh, Umbrella(), [NullSpace()], iterations=3)
    assert fixed[kinds].tobytes() == mesh.points[kinds].tobytes()
    slid, _ = loop.smooth(mesh, Umbrella(), [NullSpace(), Boundary(sliding=True)], iterations=1)
    alone, _ = loop.smooth(mesh, Umbrella(), [Boundary(sliding=True)], iterations=1)
    np.testing.assert_array_equal(slid[kinds], alone[kinds])
    assert (slid != mesh.points).any(axis=1)[kinds].any()


@pytest.mark.parametrize("name", meshes.HOSTILE)
def test_hostile_meshes(name):
    mesh = meshes.HOSTILE[name]()
    for constraints in ([NullSpace()], [NullSpace(), Gate("aspect")]):
        points, _ = loop.smooth(mesh, Umbrella(), constraints, iterations=3)
        used = np.unique(mesh.connectivity)
        assert np.isfinite(points[used]).all()
    if name == "single_triangle":
        np.testing.assert_array_equal(points, mesh.points)


def test_all_corners_stay():
    mesh = meshes.cube(1, triangles=True)
    points, report = loop.smooth(mesh, Umbrella(), [NullSpace(), LocalVolume(3)], iterations=5)
    np.testing.assert_array_equal(points, mesh.points)
    assert report.moved == 0
