from itertools import pairwise

import meshes
import numpy as np
import pytest
import reference
from vtkmodules.vtkFiltersCore import vtkFeatureEdges

from vtksmooth.kernels.mesh import adjacency
from vtksmooth.kernels.mesh.mesh import Mesh

EVERY = {
    **meshes.USUAL,
    **meshes.HOSTILE,
    "a face that comes back": lambda: Mesh.from_faces([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 0, 2]]),
}


def rows(offsets, values):
    return [values[a:b].tolist() for a, b in pairwise(offsets)]


@pytest.fixture(params=EVERY, scope="module")
def mesh(request):
    return EVERY[request.param]()


@pytest.fixture(scope="module")
def near(mesh):
    return adjacency.build(mesh)


def test_corners(mesh, near):
    faces = meshes.lists(mesh)
    expected = [[] for _ in range(mesh.n_points)]
    corner = 0
    for face in faces:
        for p in face:
            expected[p].append(corner)
            corner += 1
    assert rows(near.corner_offsets, near.corners) == expected
    assert near.corner_face.tolist() == [f for f, face in enumerate(faces) for _ in face]


def test_one_rings_and_stars(mesh, near):
    for found, expected in (
        (rows(near.ring_offsets, near.ring), reference.one_rings(mesh)),
        (rows(near.star_offsets, near.star), reference.stars(mesh)),
    ):
        assert [set(row) for row in found] == expected
        assert all(len(row) == len(set(row)) for row in found)


def test_borders(mesh, near):
    kinds, along = reference.boundaries(mesh)
    assert near.kinds.tolist() == kinds
    assert [tuple(row) for row in near.boundary_ring.tolist()] == along


def test_edges(mesh, near):
    directed, rings = reference.directed_edges(mesh), reference.one_rings(mesh)
    expected = {}
    for p, ring in enumerate(rings):
        for q in ring:
            if p < q:
                there, back = directed.get((p, q), []), directed.get((q, p), [])
                one_each = len(there) < 2 and len(back) < 2
                expected[p, q] = ((there or [-1])[0], (back or [-1])[0]) if one_each else (-1, -1)
    ends, faces = adjacency.edges(near)
    found = dict(zip(map(tuple, ends.tolist()), map(tuple, faces.tolist()), strict=True))
    assert len(found) == len(ends)
    assert found == expected


def test_boundary_loops_are_chains_of_boundary_edges(mesh, near):
    directed = reference.directed_edges(mesh)
    loops = adjacency.boundary_loops(near)
    on_loops = [p for loop in loops for p in loop.tolist()]
    assert sorted(on_loops) == np.flatnonzero(near.kinds == adjacency.BOUNDARY).tolist()
    for loop in loops:
        for p, q in pairwise(loop.tolist()):
            assert len(directed[p, q]) == 1
            assert (q, p) not in directed


@pytest.mark.parametrize("block_size", [7, 32, 2048])
def test_blocks_and_colours_are_independent(mesh, near, block_size):
    breadth_first = adjacency.breadth_first_order(near)
    order, starts, block_colour = adjacency.colour_blocks(near, breadth_first, block_size)
    assert sorted(order.tolist()) == list(range(mesh.n_points))
    assert len(starts) == len(block_colour) == -(-mesh.n_points // block_size)
    block, colour = np.empty(mesh.n_points, int), np.empty(mesh.n_points, int)
    for b, row in enumerate(starts):
        assert (np.diff(row) >= 0).all()
        low, high = b * block_size, min(mesh.n_points, (b + 1) * block_size)
        assert (row[0], row[-1]) == (low, high)
        assert set(order[low:high].tolist()) == set(breadth_first[low:high].tolist())
        block[order[low:high]] = b
        for c, (first, last) in enumerate(pairwise(row)):
            colour[order[first:last]] = c
            sizes = np.diff(near.star_offsets)[order[first:last]]
            assert (np.diff(np.minimum(sizes, 15)) >= 0).all()
    for p, star in enumerate(reference.stars(mesh)):
        for q in star:
            if block[p] == block[q]:
                assert colour[p] != colour[q]
            else:
                assert block_colour[block[p]] != block_colour[block[q]]


@pytest.mark.parametrize("name", [name for name in EVERY if EVERY[name]().only_triangles])
def test_cycles_have_each_triangle_between_two_neighbours(name):
    mesh = EVERY[name]()
    near, before = adjacency.build(mesh), adjacency.build(mesh)
    adjacency.turn_into_cycles(near)
    for v, (corners, ring) in enumerate(
        zip(rows(near.corner_offsets, near.corners), rows(near.ring_offsets, near.ring), strict=True)
    ):
        first, last = before.corner_offsets[v : v + 2]
        assert sorted(corners) == before.corners[first:last].tolist()
        first, last = before.ring_offsets[v : v + 2]
        assert sorted(ring) == sorted(before.ring[first:last].tolist())
        faces = [mesh.connectivity[c - c % 3 : c - c % 3 + 3].tolist() for c in corners]
        turned = [[*face[face.index(v) :], *face[: face.index(v)]] for face in faces]
        if near.kinds[v] == adjacency.INTERIOR and reference.fans(faces, v) == 1:
            assert turned == [[v, *pair] for pair in zip(ring, ring[1:] + ring[:1], strict=True)]
            assert corners[0] == min(corners)
        else:
            assert corners == before.corners[before.corner_offsets[v] : before.corner_offsets[v + 1]].tolist()


def test_breadth_first_order(mesh, near):
    order = adjacency.breadth_first_order(near)
    assert sorted(order.tolist()) == list(range(mesh.n_points))
    rings, seen, previous = reference.one_rings(mesh), {}, 0
    for p in order.tolist():
        # Either the first point of another component, or one step farther than a point met before.
        distance = min((seen[q] + 1 for q in rings[p] if q in seen), default=0)
        assert distance >= previous or distance == 0
        seen[p] = previous = distance


def test_renumbered_is_the_same_mesh(mesh):
    order = np.random.default_rng(3).permutation(mesh.n_points).astype(np.int32)
    other, faces = adjacency.renumbered(mesh, order)
    np.testing.assert_array_equal(other.points, mesh.points[order])
    assert sorted(faces.tolist()) == list(range(mesh.n_faces))
    old = meshes.lists(mesh)
    assert [order[face].tolist() for face in meshes.lists(other)] == [old[f] for f in faces]
    smallest = [min(face, default=mesh.n_points) for face in meshes.lists(other)]
    assert smallest == sorted(smallest)


def test_loops_of_known_meshes():
    def lengths(mesh):
        return sorted(len(loop) for loop in adjacency.boundary_loops(adjacency.build(mesh)))

    assert lengths(meshes.sheet(5, 3)) == [16]
    assert lengths(meshes.icosphere(1)) == []
    assert lengths(meshes.joined(meshes.sheet(2, 2), meshes.sheet(1, 1))) == [4, 8]
    assert lengths(meshes.duplicate_points()) == [3] * 32
    assert lengths(meshes.bow_tie()) == [3, 3]  # cut where the fans touch


def test_a_loop_runs_along_its_faces():
    loop = adjacency.boundary_loops(adjacency.build(meshes.sheet(1, 1)))[0].tolist()
    at = loop.index(0)
    assert loop[at:] + loop[:at] == [0, 1, 3, 2]


@pytest.mark.parametrize("name", ["sheet of triangles", "mixed torus", "cube of quads", "two_components"])
def test_boundary_edges_like_vtk(name):
    mesh = EVERY[name]()
    filter = vtkFeatureEdges()
    filter.SetInputData(meshes.polydata(mesh))
    filter.FeatureEdgesOff()
    filter.NonManifoldEdgesOff()
    filter.Update()
    loops = adjacency.boundary_loops(adjacency.build(mesh))
    assert sum(map(len, loops)) == filter.GetOutput().GetNumberOfLines()
