import meshes
import numpy as np
import pytest
import reference

from vtksmooth.jit import parallel
from vtksmooth.kernels.measures import aspect_ratio
from vtksmooth.kernels.measures.shifted_volume import ShiftedVolume
from vtksmooth.kernels.mesh import adjacency

NAMES = [*meshes.USUAL, *(name for name in meshes.HOSTILE if name != "all_points_the_same")]


def shifted(mesh, seed, reach, origin=(0.0, 0.0, 0.0), anywhere=False):
    near = adjacency.build(mesh)
    direction = np.random.default_rng(seed).normal(size=mesh.points.shape)
    pinned = np.zeros(mesh.n_points, np.uint8) if anywhere else (near.kinds != 0).astype(np.uint8)
    direction[pinned != 0] = 0.0
    area = np.empty((mesh.n_faces, 3))
    frozen = aspect_ratio.reference_directions(mesh)
    volume = ShiftedVolume(mesh, near, pinned, frozen, np.array(origin))
    volume.along(direction)
    return *volume(mesh.points, reach, area), direction, area


def cones(mesh):
    """The volume of the cones from the origin over all faces, fans round the mean of the corners."""
    total = 0.0
    for face in meshes.lists(mesh):
        corners = mesh.points[face]
        for i in range(len(face) if len(face) > 2 else 0):
            total += np.linalg.det([corners.mean(axis=0), corners[i - 1], corners[i]]) / 6
    return total


@pytest.mark.parametrize("anywhere", [False, True])
@pytest.mark.parametrize("name", NAMES)
def test_the_cubic_is_the_volume_of_the_shifted_mesh(name, anywhere):
    # Vertices shift where the faces round them close up, or wherever they are.
    mesh = {**meshes.USUAL, **meshes.HOSTILE}[name]()
    cubic, _, direction, area = shifted(mesh, 1, 0.0, anywhere=anywhere)
    size = np.abs(mesh.points[mesh.used_points]).max()
    for step in (0.0, 0.1, -0.7, 2.0):
        after = mesh.with_points(mesh.points + step * direction)
        expected = cones(after)
        largest = np.abs(after.points[mesh.used_points]).max() ** 3 * mesh.n_faces
        assert abs(np.polyval(cubic[::-1], step) - expected) <= 1e-14 * largest
    np.testing.assert_allclose(area, 2.0 * reference.area_vectors(mesh), atol=1e-13 * size**2)


@pytest.mark.parametrize("kind", ["triangles", "quads"])
def test_without_doubt_no_shift_within_reach_inverts(kind):
    trusted = 0
    for seed in range(60):
        reach = 10.0 ** np.random.default_rng(seed).uniform(-4, -0.5)
        mesh = meshes.torus(9, 6, kind, jitter=0.02 * (seed % 20))
        _, doubtful, direction, _ = shifted(mesh, seed, reach)
        if doubtful:
            continue
        trusted += 1
        frozen = aspect_ratio.reference_directions(mesh)
        for step in np.linspace(-reach, reach, 9):
            after = mesh.with_points(mesh.points + step * direction)
            assert (aspect_ratio.aspect_ratios(after, frozen) > 0).all()
    assert 10 < trusted < 60


def test_inverted_faces_are_doubtful():
    for kind in ("triangles", "quads"):
        mesh = meshes.sheet(9, 7, kind, jitter=0.9)
        frozen = aspect_ratio.reference_directions(meshes.sheet(9, 7, kind))
        still = np.zeros_like(mesh.points)
        near = adjacency.build(mesh)
        volume = ShiftedVolume(mesh, near, (near.kinds != 0).astype(np.uint8), frozen, np.zeros(3))
        volume.along(still)
        doubtful = volume(mesh.points, 0.0, np.empty((0, 3)))[1]
        inverted = int((aspect_ratio.aspect_ratios(mesh, frozen) < 0).sum())
        assert 0 < inverted <= doubtful < mesh.n_faces


@pytest.mark.parametrize("kind", meshes.KINDS)
def test_the_number_of_threads_does_not_matter(kind, monkeypatch):
    monkeypatch.setattr(parallel, "SMALLEST_SHARE", 1)
    mesh = meshes.torus(60, 40, kind, jitter=0.1)
    found = []
    for threads in (1, 3):
        monkeypatch.setattr(parallel, "number_of_threads", lambda threads=threads: threads)
        found.append(shifted(mesh, 3, 0.01))
    assert (found[0][0] == found[1][0]).all()
    assert found[0][1] == found[1][1]
