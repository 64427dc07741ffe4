"""Vicinities: what they say of distances is true, and they say something wherever walls are near."""

import meshes
import numba
import numpy as np
import pytest

from vtksmooth.filters.signed_distance import SignedDistance
from vtksmooth.kernels.containment import nearby_faces
from vtksmooth.kernels.distance.signed_distance import SignedDistanceTree
from vtksmooth.kernels.mesh import adjacency
from vtksmooth.kernels.mesh.mesh import Mesh
from vtksmooth.kernels.smoothing import loop
from vtksmooth.kernels.smoothing.constraints.containment import Containment
from vtksmooth.kernels.smoothing.schemes.pairwise import Pairwise
from vtksmooth.kernels.smoothing.schemes.umbrella import Umbrella

TOLERANCE = 1e-4


@numba.njit
def ask(kept, tree, normals, winding, places, limit):
    """Return for each vertex and each of its places how far it may go, and the distance if that was found."""
    answers = np.empty((places.shape[0], places.shape[1], 2))
    for v in range(places.shape[0]):
        for i in range(places.shape[1]):
            x, y, z = places[v, i]
            answers[v, i] = nearby_faces.room_in_vicinity(kept, tree, normals, winding, v, x, y, z, limit)
    return answers


def spike():
    """A space that narrows to a needle: three planes, no two of them against each other."""
    angles = np.arange(3) * 2 * np.pi / 3
    base = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(3)])
    return Mesh.from_faces([*base, [0, 0, 9]], [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])


def blade():
    """A space that is nearly all edge."""
    return Mesh.from_faces(
        [[0, 0, -2], [0, 0, 2], [4, 0.3, 0], [4, -0.3, 0]], [[0, 1, 2], [1, 0, 3], [0, 2, 3], [1, 3, 2]]
    )


def gap():
    """Two bodies with a gap between them no wider than the tolerance."""
    cube = meshes.cube(1, triangles=True)
    return meshes.joined(cube, cube.with_points(cube.points + np.array([1 + 0.5 * TOLERANCE, 0, 0])))


#: A space, and the least part of the vertices near its walls that find planes.
SPACES = {
    "cube": (meshes.cube(2, triangles=True), 0.9),
    "with a concave edge": (meshes.l_shape(triangles=True), 0.6),
    "torus": (meshes.torus(14, 8, jitter=0.2), 0.02),
    "fine sphere": (meshes.icosphere(3), 0.0),
    "blade": (blade(), 0.05),
    "spike": (spike(), 0.05),
    "gap": (gap(), 0.05),
}


@pytest.mark.parametrize("name", SPACES)
def test_what_is_said_is_true(name):
    mesh, least = SPACES[name]
    tree, vtk = SignedDistanceTree(mesh), SignedDistance(meshes.polydata(mesh))
    random, count = np.random.default_rng(3), 400
    # Vertices on the walls, nearly on them, and some way off; the ends of their edges do not matter.
    corners = mesh.points[mesh.connectivity.reshape(-1, 3)]
    chosen = corners[random.integers(0, len(corners), count)]
    at = np.einsum("sc,scx->sx", random.dirichlet([0.4] * 3, count), chosen)
    normals = np.cross(chosen[:, 1] - chosen[:, 0], chosen[:, 2] - chosen[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    edge = 0.3
    off = random.choice([0.0, -1e-9, 0.5 * TOLERANCE, -edge], count) * random.random(count)
    points = at + off[:, None] * normals
    ends = [points + edge * direction for direction in np.eye(3)[:2]]
    stars = Mesh.from_faces(
        np.concatenate([points, *ends]), np.arange(3 * count).reshape(3, count).T.astype(np.int32)
    )
    known = np.column_stack([stars.points, tree(stars.points)])
    kept = nearby_faces.no_vicinities(stars.n_points)
    kept.wanted[:count] = 1
    kept = nearby_faces.refreshed(
        kept, stars.points, adjacency.build(stars), known, tree, TOLERANCE, TOLERANCE
    )
    planes = kept.held[kept.row[:count]] > 0
    assert planes.mean() >= least
    # Places near, many of them along the walls and just over them.
    steps = random.normal(size=(count, 200, 3)) * (edge * random.choice([0.01, 0.1, 0.5], (count, 200, 1)))
    along = (steps * normals[:, None]).sum(axis=2, keepdims=True) * normals[:, None]
    over = TOLERANCE * random.choice([-1.0, 0.0, 0.03, 0.5, 0.9, 1.1, 2.0], (count, 200, 1))
    steps = np.where(random.random((count, 200, 1)) < 0.5, steps - along + over * normals[:, None], steps)
    places = points[:, None] + steps
    answers = ask(kept, tree.tree, tree.normals, tree.winding, places, TOLERANCE)
    room, found = answers[..., 0], answers[..., 1]
    true = vtk(places.reshape(-1, 3)).reshape(room.shape)
    told = ~np.isnan(room)
    assert told.mean() >= 0.5
    assert not kept.wanted[:count][told.all(axis=1)].any()
    assert kept.wanted[:count][~told.all(axis=1)].all()
    # Who may be there is inside, and so is everything as far off as is said; who may not, is outside.
    assert true[told & (room >= 0)].max() <= TOLERANCE
    assert (room >= 0).sum() > 1000
    assert true[told & (room < 0)].min() > TOLERANCE * 0.95
    asked = ~np.isnan(found)
    np.testing.assert_allclose(np.abs(found[asked]), np.abs(true[asked]), atol=1e-12)
    directions = random.normal(size=(*room.shape, 3))
    directions /= np.linalg.norm(directions, axis=2, keepdims=True)
    farther = places + np.where(told & (room > 0), room, 0.0)[..., None] * directions
    assert vtk(farther[told & (room >= 0)]).max() <= TOLERANCE * (1 + 1e-9)


# -- in a run -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("scheme", [Pairwise(1.0), Umbrella()])
@pytest.mark.parametrize("exact", [False, True])
def test_hardly_a_distance_is_asked_for(scheme, exact):
    mesh = meshes.voxels([cell for cell in np.ndindex(6, 6, 6) if sum(cell) < 12], triangles=True)
    space = meshes.voxels([c for c in np.ndindex(6, 6, 6) if max(c) < 6 and min(c) < 4], triangles=True)
    containment = Containment(SignedDistanceTree(space), 1e-6, exact=exact)
    points, report = loop.smooth(mesh, scheme, [containment], iterations=10)
    assert report.moved > 20
    assert containment.asked < 0.1 * containment.checked
    assert SignedDistance(meshes.polydata(space))(points).max() <= 1e-6
