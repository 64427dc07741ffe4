"""Separating planes: a triangle that has them does not cross; and they hold as long as they are kept."""

from functools import partial

import meshes
import numba
import numpy as np
import pytest

from vtksmooth.jit import parallel
from vtksmooth.kernels.containment.crossings import (
    LIFT,
    crossing_triangles,
    faces_near,
    no_box,
    scratch,
    widen,
)
from vtksmooth.kernels.containment.separating_planes import BEFORE, FREE, PLANES, separate
from vtksmooth.kernels.distance.signed_distance import SignedDistanceTree
from vtksmooth.kernels.mesh.mesh import Mesh
from vtksmooth.kernels.smoothing import loop
from vtksmooth.kernels.smoothing.constraints.containment import Containment
from vtksmooth.kernels.smoothing.schemes import pairwise
from vtksmooth.kernels.smoothing.schemes.pairwise import Pairwise
from vtksmooth.kernels.smoothing.schemes.umbrella import Umbrella


@numba.njit
def separated(tree, normals, points, triangles, tolerance):
    """For each triangle how many planes separate it from the faces near, how many faces, and the planes."""
    count = np.zeros(len(triangles), np.int64)
    near = np.zeros(len(triangles), np.int64)
    planes = np.zeros((len(triangles), PLANES, 6))
    stack, found, box = scratch()
    for t in range(len(triangles)):
        p, q, r = triangles[t]
        no_box(box)
        for v in triangles[t]:
            widen(box, points, v)
        stack[0] = 0
        near[t], more = faces_near(tree, box, tolerance, stack, 1, found)
        if more == 0:
            count[t] = separate(points, p, q, r, tree, normals, found, 0, near[t], tolerance, planes, t)
    return count, near, planes


def blade():
    """A space that is nearly all edge: two faces turned against each other."""
    return Mesh.from_faces(
        [[0, 0, -2], [0, 0, 2], [4, 0.3, 0], [4, -0.3, 0]], [[0, 1, 2], [1, 0, 3], [0, 2, 3], [1, 3, 2]]
    )


@pytest.mark.parametrize(
    ("space", "least"),
    [
        (meshes.cube(2, triangles=True), 0.2),
        (meshes.l_shape(triangles=True), 0.2),
        (meshes.torus(14, 8, jitter=0.2), 0.1),
        (meshes.icosphere(2), 0.02),
        (blade(), 0.05),
    ],
)
def test_triangles_with_separating_planes_cross_nothing(space, least):
    # Triangles that lie on faces, stick out by parts of the tolerance, or go through.
    tolerance, count = 0.05, 12_000
    random = np.random.default_rng(7)
    tree = SignedDistanceTree(space)
    corners = space.points[space.connectivity.reshape(-1, 3)]
    own = random.integers(0, len(corners), count)
    at = np.einsum("sc,scx->sx", random.dirichlet([0.5] * 3, count), corners[own])
    points = np.repeat(at[:, None], 3, axis=1)
    points[:, 1:] += random.choice([0.1, 0.4], count)[:, None, None] * random.normal(size=(count, 2, 3))
    flat = points.reshape(-1, 3)
    # Most points are brought back onto the surface, or to within some of the tolerance of it.
    closest, _ = tree.surface.query(flat)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    back = random.random(len(flat)) < np.repeat(random.choice([0.5, 1.0], count), 3)
    height = random.choice([-1.0, -0.1, 0.0, 0.05, 0.5], len(flat))
    flat[back] = (closest + tolerance * height[:, None] * np.repeat(normals[own], 3, axis=0))[back]
    triangles = np.arange(3 * count, dtype=np.int32).reshape(-1, 3)
    planes, near, _ = separated(tree.tree, tree.normals, flat, triangles, tolerance)
    crossed = crossing_triangles(flat, triangles, tree.surface, np.full(len(flat), np.inf), tolerance)
    assert not ((planes > 0) & crossed).any()
    assert crossed.sum() > 20
    assert ((planes > 0) & (near > 0)).mean() >= least


def test_planes_are_between_the_triangle_and_the_faces():
    # Triangles inside a cube, some in a corner of it: one plane for each of the sides near.
    space = meshes.cube(2, triangles=True)
    tree, tolerance = SignedDistanceTree(space), 1e-6
    random = np.random.default_rng(0)
    points = np.clip(random.uniform(-0.3, 2.3, (3000, 1, 3)) + random.uniform(-0.5, 0.5, (3000, 3, 3)), 0, 2)
    flat = points.reshape(-1, 3)
    triangles = np.arange(9000, dtype=np.int32).reshape(-1, 3)
    count, near, planes = separated(tree.tree, tree.normals, flat, triangles, tolerance)
    assert (count[near > 0] > 0).all()
    assert set(count) == {0, 1, 2, 3}
    heights = np.einsum("tcpx,tpx->tcp", points[:, :, None] - planes[:, None, :, :3], planes[..., 3:])
    assert heights.max() <= BEFORE * LIFT * tolerance


# -- in a run -----------------------------------------------------------------------------------------


def stairs_in_a_space():
    """Voxels in a space that leaves out corners: they touch its walls, its edges, convex and concave."""
    mesh = meshes.voxels([cell for cell in np.ndindex(6, 6, 6) if sum(cell) < 12], triangles=True)
    space = meshes.voxels([c for c in np.ndindex(6, 6, 6) if max(c) < 6 and min(c) < 4], triangles=True)
    return mesh, SignedDistanceTree(space)


class Watched(Containment):
    """Looks at what is kept before every pass."""

    def prepare(self, state):
        self.look(state)
        super().prepare(state)
        self.look(state)

    def look(self, state):
        kept = self.guard.separation
        used = np.flatnonzero(kept.row > FREE)
        for t in used[kept.held[kept.row[used]] > 0]:
            row, corners = kept.row[t], kept.triangles[t]
            planes = kept.planes[row, : kept.held[row]]
            heights = ((state.points[corners][:, None] - planes[:, :3]) * planes[:, 3:]).sum(axis=2)
            assert heights.max() <= 5 / 8 * LIFT * self.tolerance + 1e-15
            # Nobody may go farther than to the first plane of any of its triangles.
            if isinstance(self.scheme, Pairwise):
                assert (self.guard.slack[corners] <= np.maximum(-heights, 0).min(axis=1) + 1e-12).all()
            faces = kept.faces[kept.first[row] : kept.last[row]]
            others = self.space.tree[0][self.space.tree[1][faces]]
            before = ((others[:, :, None] - planes[:, :3]) * planes[:, 3:]).sum(axis=3).min(axis=1)
            assert (before.max(axis=1) >= -LIFT * self.tolerance).all()


@pytest.mark.parametrize("scheme", [Pairwise(1.0), Umbrella()])
def test_what_is_kept_is_true(scheme):
    mesh, space = stairs_in_a_space()
    watched = Watched(space, 1e-6, exact=True)
    watched.scheme = scheme
    points, report = loop.smooth(mesh, scheme, [watched], iterations=8)
    assert report.moved > 20
    distances = space(points)
    assert distances.max() <= 1e-6
    triangles = mesh.connectivity.reshape(-1, 3)
    assert not crossing_triangles(points, triangles, space.surface, distances, 1e-6).any()


def test_the_number_of_threads_does_not_matter(monkeypatch):
    monkeypatch.setattr(pairwise, "edges_of", partial(pairwise.edges_of, block_size=16))
    ranges = parallel.ranges
    monkeypatch.setattr(parallel, "ranges", lambda n, size=16: ranges(n, size))
    monkeypatch.setattr(parallel, "SMALLEST_SHARE", 1)
    mesh, space = stairs_in_a_space()
    results = []
    try:
        for threads in (1, 2, 3):
            parallel.set_number_of_threads(threads)
            points, _ = loop.smooth(mesh, Pairwise(1.0), [Containment(space, 1e-6, exact=True)], iterations=5)
            results.append(points.tobytes())
    finally:
        parallel.set_number_of_threads(0)
    assert results[0] == results[1] == results[2]
