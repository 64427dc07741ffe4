import meshes
import numpy as np
import pytest

from vtksmooth.kernels.mesh import adjacency
from vtksmooth.kernels.mesh.mesh import Mesh
from vtksmooth.kernels.smoothing import loop
from vtksmooth.kernels.smoothing.constraints.gate import Gate
from vtksmooth.kernels.smoothing.constraints.smoothed_boundary import SmoothedBoundary
from vtksmooth.kernels.smoothing.schemes.umbrella import Umbrella


def rim_of(mesh):
    """The vertices of the boundary, in order, from the corner at the lowest place."""
    near = adjacency.build(mesh)
    rim = np.flatnonzero(near.kinds == adjacency.BOUNDARY)
    order = [int(rim[np.argmin(mesh.points[rim].sum(axis=1))])]
    while (after := int(near.boundary_ring[order[-1], 1])) != order[0]:
        order.append(after)
    return np.array(order)


def turns(points):
    came = points - np.roll(points, 1, axis=0)
    goes = np.roll(points, -1, axis=0) - points
    return np.degrees(np.arctan2(np.linalg.norm(np.cross(came, goes), axis=1), (came * goes).sum(axis=1)))


def area(points):
    return 0.5 * np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0)


def zigzag(kind, turned=False):
    """A square sheet whose outline goes to and fro."""
    mesh = meshes.sheet(24, 24, kind)
    rim = rim_of(mesh)
    points = mesh.points.copy()
    x, y = points[rim, 0], points[rim, 1]
    outwards = np.column_stack(((x == x.max()) * 1.0 - (x == 0), (y == y.max()) * 1.0 - (y == 0), 0 * x))
    outwards[np.abs(outwards).sum(axis=1) != 1] = 0.0  # the corners stay where they are
    points[rim] += 0.3 * outwards * (-1.0) ** np.arange(len(rim))[:, None]
    if turned:
        rotation, _ = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))
        points = points @ rotation.T + 7.0
    return mesh.with_points(points), rim


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("kind", meshes.KINDS)
def test_a_zigzag_becomes_straight_with_its_corners_and_its_area(kind, turned):
    mesh, rim = zigzag(kind, turned)
    points, _ = loop.smooth(mesh, Umbrella(0.5), [SmoothedBoundary(60.0)], iterations=60)
    before, after = turns(mesh.points[rim]), turns(points[rim])
    corners = np.argsort(after)[-4:]
    assert before.mean() > 55.0
    assert np.delete(after, corners).mean() < 3.0
    assert (points[rim[corners]] == mesh.points[rim[corners]]).all()
    assert np.linalg.norm(area(points[rim]) - area(mesh.points[rim])) < 1e-11 * 24**2


def test_a_circle_stays():
    mesh = meshes.fan(100)
    rim = rim_of(mesh)
    points, report = loop.smooth(mesh, Umbrella(0.5), [SmoothedBoundary()], iterations=200)
    assert report.iterations == 200
    radius = np.linalg.norm(points[rim] - points[rim].mean(axis=0), axis=1)
    was = np.linalg.norm(mesh.points[rim] - mesh.points[rim].mean(axis=0), axis=1)
    np.testing.assert_allclose(radius, was, rtol=1e-12)


def test_a_loop_on_a_tube_keeps_its_area_and_becomes_plane():
    """Where normals of the surface cancel, the loop's own plane is what counts."""
    turn, height = np.meshgrid(np.arange(40), np.arange(9.0))
    angle = np.pi * turn / 20
    number = turn + 40 * height.astype(int)
    faces = np.stack((number[:-1], np.roll(number, -1, 1)[:-1], np.roll(number, -1, 1)[1:], number[1:]), -1)
    points = np.stack((6 * np.cos(angle), 6 * np.sin(angle), height), -1).reshape(-1, 3)
    mesh = Mesh.from_faces(points, faces.reshape(-1, 4))
    near = adjacency.build(mesh)
    first = np.flatnonzero(
        (near.kinds == adjacency.BOUNDARY) & (mesh.points[:, 2] < mesh.points[:, 2].mean())
    )
    points = mesh.points.copy()
    points[first, 2] += 0.3 * np.random.default_rng(0).uniform(-1, 1, len(first))
    mesh = mesh.with_points(points)
    order = [int(first[0])]
    while (after := int(near.boundary_ring[order[-1], 1])) != order[0]:
        order.append(after)
    smooth, _ = loop.smooth(mesh, Umbrella(0.5), [SmoothedBoundary(180.0)], iterations=100)
    normal = area(points[order]) / np.linalg.norm(area(points[order]))
    assert abs(area(smooth[order]) @ normal - area(points[order]) @ normal) < 1e-12 * len(order)
    assert np.ptp(smooth[order, 2]) < 0.3 * np.ptp(points[order, 2])


def test_with_a_gate_nothing_inverts_and_without_relaxation_nothing_moves():
    mesh, _ = zigzag("triangles")
    _, report = loop.smooth(mesh, Umbrella(0.5), [SmoothedBoundary(60.0), Gate("aspect")], iterations=20)
    assert report.inverted == (0, 0)
    assert report.min_aspect_ratio[1] >= report.min_aspect_ratio[0]
    points, _ = loop.smooth(mesh, Umbrella(0.0), [SmoothedBoundary(60.0)], iterations=2)
    assert (points == mesh.points).all()
