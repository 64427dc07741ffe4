"""Blend weights: against the definition, vertex by vertex."""

import meshes
import numpy as np
import pytest
import reference

from vtksmooth.kernels.regions import blend_weights


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
