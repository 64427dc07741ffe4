import meshes
import numba
import numpy as np
import pytest
import reference

from vtksmooth.kernels.measures import comparison, swept_volume
from vtksmooth.kernels.mesh import adjacency

#: Abscissae and weights of Gauss' rule on [0, 1], exact for what is cubic in time.
TIMES, WEIGHTS = (np.polynomial.legendre.leggauss(2)[0] + 1) / 2, np.array([0.5, 0.5])


def shares(before, after, faces):
    """By corners of `faces`: the integral over time and face of the normal speed times the hat function.

    A polygon is the fan round the mean of its corners, which hands its share on to them in equal parts.
    """
    result = []
    for face in faces:
        p, d = before[face], after[face] - before[face]
        n = len(face)
        of_face = np.zeros(n)
        if n > 3:
            p, d = np.vstack([p, p.mean(axis=0)]), np.vstack([d, d.mean(axis=0)])
        fan = [(0, 1, 2)] if n == 3 else [(n, i, (i + 1) % n) for i in range(n)]
        for time, weight in zip(TIMES, WEIGHTS, strict=True):
            for triangle in map(list, fan if n > 2 else []):
                area = reference.triangle_area_vector(*(p + time * d)[triangle])
                speed = d[triangle] @ area
                # The integral of two hat functions: 1/6 of the area if they are the same, or 1/12.
                for corner, share in zip(triangle, weight * (speed + speed.sum()) / 12, strict=True):
                    if corner < n:
                        of_face[corner] += share
                    else:
                        of_face += share / n
        result.append(of_face)
    return np.concatenate(result)


def swept(mesh, after):
    result = np.empty(len(mesh.connectivity))
    ends = np.array([mesh.n_faces])
    comparison._swept_volumes(
        np.zeros(1, int), ends, mesh.points, after, mesh.offsets, mesh.connectivity, result
    )
    return result


@pytest.mark.parametrize("kind", meshes.KINDS)
def test_shares_of_the_corners_by_their_definition(kind):
    mesh = meshes.torus(8, 6, kind, jitter=0.2)
    after = mesh.points + np.random.default_rng(1).normal(0, 0.3, mesh.points.shape)
    expected = shares(mesh.points, after, meshes.lists(mesh))
    np.testing.assert_allclose(swept(mesh, after), expected, atol=1e-14)


@pytest.mark.parametrize("kind", meshes.KINDS)
def test_the_sum_over_a_closed_mesh_is_the_change_of_its_volume(kind):
    mesh = meshes.torus(8, 6, kind, jitter=0.2)
    after = mesh.points + np.random.default_rng(2).normal(0, 0.3, mesh.points.shape)
    change = reference.volume(mesh.with_points(after)) - reference.volume(mesh)
    assert swept(mesh, after).sum() == pytest.approx(change, rel=1e-12)


def test_faces_with_too_few_corners_sweep_nothing():
    mesh = meshes.degenerate_faces()
    after = mesh.points + 1.0
    few = np.repeat(mesh.face_sizes < 3, mesh.face_sizes)
    assert few.any()
    assert (swept(mesh, after)[few] == 0).all()


@numba.njit
def gradients(points, near):
    result = np.empty(points.shape)
    for v in range(len(points)):
        result[v] = swept_volume.volume_gradient(points, near, v)
    return result


@pytest.mark.parametrize("kind", meshes.KINDS)
def test_what_one_vertex_sweeps_is_linear_in_its_step(kind):
    mesh = meshes.torus(8, 6, kind, jitter=0.2)
    gradient = gradients(mesh.points, adjacency.build(mesh))
    for v, step in enumerate(np.random.default_rng(3).normal(0, 2.0, mesh.points.shape)):
        after = mesh.points.copy()
        after[v] += step
        change = reference.volume(mesh.with_points(after)) - reference.volume(mesh)
        assert gradient[v] @ step == pytest.approx(change, abs=1e-12)
