"""The bilateral filter of face normals, on shapes whose normals are known."""

from __future__ import annotations

import meshes
import numpy as np
import pytest

from vtksmooth.kernels.features.normal_filter import NoiseMeter, filter_normals
from vtksmooth.kernels.measures.dihedral import face_normals
from vtksmooth.kernels.mesh import adjacency


def noisy_cube(level, n=12, seed=0):
    mesh = meshes.cube(n, triangles=True)
    push = np.random.default_rng(seed).normal(0.0, level, mesh.points.shape)
    return mesh, mesh.with_points(mesh.points + push)


def mean_error(normals, truth):
    return np.degrees(np.arccos(np.clip((normals[:, :3] * truth[:, :3]).sum(axis=1), -1, 1))).mean()


@pytest.mark.parametrize("name", ["cube of triangles", "cube of quads"])
def test_clean_polyhedra_have_no_noise_and_stay(name):
    mesh = meshes.USUAL[name]()
    normals, meter = face_normals(mesh), NoiseMeter(mesh.points, adjacency.build(mesh))
    noise = meter.measure(normals)
    assert noise < 1e-3
    assert filter_normals(meter, normals, np.array([noise])) is normals


def test_noise_is_the_lower_quartile_of_the_dihedral_angles():
    _, mesh = noisy_cube(0.1)
    near, normals = adjacency.build(mesh), face_normals(mesh)
    _, faces = adjacency.edges(near)
    between = (normals[faces[:, 0], :3] * normals[faces[:, 1], :3]).sum(axis=1)
    expected = np.quantile(np.arccos(np.clip(between, -1, 1)), 0.25)
    assert NoiseMeter(mesh.points, near).measure(normals) == pytest.approx(expected, abs=1e-3)


def test_noise_about_each_vertex_is_that_of_its_side():
    clean, mesh = noisy_cube(0.1)
    noisy = clean.points[:, 2] > 6.0
    half = clean.with_points(np.where(noisy[:, None], mesh.points, clean.points))
    near = adjacency.build(half)
    meter, normals = NoiseMeter(half.points, near), face_normals(half)
    everywhere = NoiseMeter(mesh.points, near).measure(face_normals(mesh))
    assert meter.measure(normals) < 1e-3
    assert meter.is_uneven(normals, meter.measure(normals))
    about, height = meter.local(normals), clean.points[:, 2]
    # The rim is some four rings wide on the quiet side; creases do not count as noise.
    assert np.abs(about[height > 6.0] / everywhere - 1.0).max() < 0.6
    assert about[height < 1.5].max() < 1e-3


@pytest.mark.parametrize("level", [0.0, 0.05, 0.1, 0.2])
def test_noise_that_is_everywhere_is_even(level):
    _, mesh = noisy_cube(level)
    meter, normals = NoiseMeter(mesh.points, adjacency.build(mesh)), face_normals(mesh)
    assert not meter.is_uneven(normals, meter.measure(normals))


@pytest.mark.parametrize("level", [0.05, 0.1, 0.2])
def test_noise_goes_and_creases_stay(level):
    clean, mesh = noisy_cube(level)
    meter, normals, truth = (
        NoiseMeter(mesh.points, adjacency.build(mesh)),
        face_normals(mesh),
        face_normals(clean),
    )
    kept = normals.copy()
    filtered = filter_normals(meter, normals, np.array([meter.measure(normals)]))
    assert mean_error(filtered, truth) < 0.4 * mean_error(normals, truth)
    np.testing.assert_allclose(np.linalg.norm(filtered[:, :3], axis=1), 1.0, atol=1e-12)
    np.testing.assert_array_equal(filtered[:, 3], normals[:, 3])
    np.testing.assert_array_equal(normals, kept)


@pytest.mark.parametrize("name", meshes.HOSTILE)
def test_hostile_meshes(name):
    mesh = meshes.HOSTILE[name]()
    meter, normals = NoiseMeter(mesh.points, adjacency.build(mesh)), face_normals(mesh)
    filtered = filter_normals(meter, normals, np.array([meter.measure(normals)]))
    about = meter.local(normals)
    assert ((about >= 0.0) & (about <= np.pi)).all()
    lengths = np.linalg.norm(filtered[:, :3], axis=1)
    assert ((np.abs(lengths - 1.0) < 1e-12) | (lengths == 0.0)).all()
