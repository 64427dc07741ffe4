"""Regions: against the definitions, vertex by vertex and face by face."""

import meshes
import numpy as np
import pytest
import reference
from hypothesis import given
from hypothesis import strategies as st

from vtksmooth.kernels.mesh import adjacency
from vtksmooth.kernels.mesh.regions import (
    blend_weights,
    components,
    grown,
    marked_faces,
    patches,
    rings_of,
    shrunk,
)


def diffused(mesh, fixed, steps):
    rings = reference.one_rings(mesh)
    weights = [0.0 if held else 1.0 for held in fixed]
    for _ in range(steps):
        weights = [
            np.mean([weights[q] for q in rings[v]]) if fixed[v] and rings[v] else weights[v]
            for v in range(mesh.n_points)
        ]
    return np.array(weights)


@pytest.mark.parametrize("name", ["mixed sheet", "torus of triangles"])
@pytest.mark.parametrize("steps", [0, 1, 4])
def test_like_the_definition(name, steps):
    mesh = meshes.USUAL[name]()
    fixed = (mesh.points[:, 0] > 1.5).astype(np.uint8)
    np.testing.assert_allclose(blend_weights(mesh, fixed, steps), diffused(mesh, fixed, steps), atol=1e-15)


def test_weights_end_where_the_steps_end():
    mesh = meshes.sheet(12, 6, "quads")
    column = mesh.points[:, 0]
    weights = blend_weights(mesh, column > 4, 3)
    assert (weights[column <= 4] == 1).all()
    assert ((weights[(column > 4) & (column <= 7)] > 0) & (weights[(column > 4) & (column <= 7)] < 1)).all()
    assert (weights[column > 7] == 0).all()
    by_column = [weights[column == x].mean() for x in range(13)]
    assert by_column == sorted(by_column, reverse=True)


@pytest.mark.parametrize("name", meshes.HOSTILE)
def test_hostile_meshes(name):
    mesh = meshes.HOSTILE[name]()
    fixed = np.arange(mesh.n_points) % 3 > 0
    weights = blend_weights(mesh, fixed, 2)
    np.testing.assert_allclose(weights, diffused(mesh, fixed, 2), atol=1e-12)
    assert (weights[~fixed] == 1).all()


EVERY = {**meshes.USUAL, **meshes.HOSTILE}


@pytest.mark.parametrize("name", EVERY)
def test_growing_takes_the_neighbours_and_shrinking_is_growing_the_rest(name):
    mesh = EVERY[name]()
    rings = reference.one_rings(mesh)
    marked = np.random.default_rng(1).random(mesh.n_points) < 0.2
    expected = [marked[v] or any(marked[w] for w in rings[v]) for v in range(mesh.n_points)]
    assert grown(rings_of(mesh), marked, 1).tolist() == expected
    twice = grown(rings_of(mesh), grown(rings_of(mesh), marked, 1), 1)
    np.testing.assert_array_equal(grown(rings_of(mesh), marked, 2), twice)
    np.testing.assert_array_equal(shrunk(rings_of(mesh), marked, 2), ~grown(rings_of(mesh), ~marked, 2))


@given(st.integers(0, 10_000), st.integers(0, 3))
def test_opening_and_closing_never_leave_their_side(seed, steps):
    rings = rings_of(meshes.torus(9, 7))
    marked = np.random.default_rng(seed).random(63) < 0.5
    assert (shrunk(rings, grown(rings, marked, steps), steps) >= marked).all()
    assert (grown(rings, shrunk(rings, marked, steps), steps) <= marked).all()


def flooded(neighbours):
    """The smallest member of each part, by walking."""
    labels = [-1] * len(neighbours)
    for first in range(len(neighbours)):
        waiting = [first] if labels[first] < 0 else []
        while waiting:
            v = waiting.pop()
            if labels[v] < 0:
                labels[v] = first
                waiting += neighbours[v]
    return labels


@pytest.mark.parametrize("name", EVERY)
def test_components_as_by_walking(name):
    mesh = EVERY[name]()
    neighbours = [set() for _ in range(mesh.n_points)]
    for face in meshes.lists(mesh):
        for v in face:
            neighbours[v] |= set(face)
    assert components(mesh).tolist() == flooded([list(near) for near in neighbours])


@pytest.mark.parametrize("name", EVERY)
def test_patches_as_by_walking(name):
    mesh = EVERY[name]()
    near = adjacency.build(mesh)
    ends, faces = adjacency.edges(near)
    lines = ends[np.random.default_rng(2).random(len(ends)) < 0.6]
    blocked = {tuple(pair) for pair in lines.tolist()}
    neighbours = [[] for _ in range(mesh.n_faces)]
    for pair, (f, g) in zip(ends.tolist(), faces.tolist(), strict=True):
        if tuple(pair) not in blocked and f >= 0 and g >= 0:
            neighbours[f].append(g)
            neighbours[g].append(f)
    assert patches(near, lines[:, ::-1]).tolist() == flooded(neighbours)


def test_the_edges_of_a_cube_cut_it_into_its_six_sides():
    mesh = meshes.cube(4, triangles=True)
    near = adjacency.build(mesh)
    ends, _ = adjacency.edges(near)
    on_two = ((mesh.points[ends] == mesh.points[ends][:, ::-1]) & np.isin(mesh.points[ends], (0, 4))).all(
        axis=1
    )
    labels = patches(near, ends[on_two.sum(axis=1) == 2])
    assert sorted(np.unique(labels, return_counts=True)[1]) == [32] * 6
    side = np.unique(mesh.connectivity.reshape(-1, 3)[labels == labels[0]])
    assert len(side) == 25
    assert (np.ptp(mesh.points[side], axis=0) == 0).sum() == 1


def test_faces_between_marked_points():
    mesh = meshes.USUAL["mixed sheet"]()
    marked = mesh.points[:, 0] <= 2
    expected = [f for f, face in enumerate(meshes.lists(mesh)) if all(marked[v] for v in face)]
    assert marked_faces(mesh, marked).tolist() == expected
