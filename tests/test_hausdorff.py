"""A bound on the distance of surfaces: against analytic distances and a million samples."""

import meshes
import numpy as np
import pytest
import pyvista as pv

from vtksmooth import LaplacianSmoothing, SurfaceComparison, TrapeziumDrawing, set_number_of_threads
from vtksmooth.kernels.distance.closest_point import ClosestPoint, triangles
from vtksmooth.kernels.distance.hausdorff import farthest
from vtksmooth.kernels.mesh.mesh import Mesh


def sampled(mesh, surface, count=1_000_000):
    """Return the largest distance of random points of a mesh from a surface."""
    corners = mesh.points[triangles(mesh)]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    random = np.random.default_rng(0)
    chosen = random.choice(len(corners), count, p=area / area.sum())
    s, t = random.random((2, count))
    s, t = np.where(s + t > 1, 1 - s, s), np.where(s + t > 1, 1 - t, t)
    a, b, c = corners[chosen].transpose(1, 0, 2)
    return surface.query(a + s[:, None] * (b - a) + t[:, None] * (c - a))[1].max()


def test_a_peak_between_all_corners_is_not_missed():
    # A needle of height 1 stands on a large triangle, away from its corners and middle.
    base = [[0, 0, 0], [10, 0, 0], [0, 10, 0]]
    flat = Mesh.from_faces(base, [[0, 1, 2]])
    points = [*base, [2, 3, 0], [2.01, 3, 0], [2, 3.01, 0], [2.003, 3.003, 1.0]]
    needle = Mesh.from_faces(
        points,
        [[3, 4, 6], [4, 5, 6], [5, 3, 6], [0, 1, 3], [1, 4, 3], [1, 2, 4], [2, 5, 4], [2, 0, 5], [0, 3, 5]],
    )
    lower, upper = farthest(needle, ClosestPoint(flat))
    assert lower == pytest.approx(1.0)
    assert 1.0 <= upper <= 1.05 + 1e-9
    # The other way it is no farther than to the needle's foot.
    assert farthest(flat, ClosestPoint(needle)).upper < 0.01


@pytest.mark.parametrize("shift", [0.01, 0.3])
def test_parallel_planes(shift):
    plane = meshes.sheet(8, 8)
    lower, upper = farthest(
        plane.with_points(plane.points + np.array([0.0, 0.0, shift])), ClosestPoint(plane)
    )
    assert lower == pytest.approx(shift)
    assert shift <= upper <= 1.05 * shift


def test_the_same_surface_is_at_no_distance():
    mesh = meshes.torus(20, 12, jitter=0.2)
    assert farthest(mesh, ClosestPoint(mesh)).upper <= 1e-12 * mesh.diagonal


@pytest.mark.parametrize("kind", meshes.KINDS)
def test_bounds_enclose_a_million_samples(kind):
    mesh = meshes.torus(20, 14, kind, jitter=0.25, seed=4)
    random = np.random.default_rng(1)
    for size in (0.02, 0.4):
        other = mesh.with_points(mesh.points + size * random.normal(size=mesh.points.shape))
        for one, two in ((mesh, other), (other, mesh)):
            surface = ClosestPoint(two)
            lower, upper = farthest(one, surface)
            found = sampled(one, surface, 200_000)
            assert found <= upper
            assert upper <= 1.1 * found
            assert lower <= upper <= 1.05 * lower + 1e-12


def test_threads_do_not_matter():
    mesh, other = meshes.torus(40, 30, jitter=0.2), meshes.torus(40, 30, jitter=0.25)
    found = []
    for threads in (1, 2, 3):
        set_number_of_threads(threads)
        found.append(farthest(mesh, ClosestPoint(other)))
    set_number_of_threads(2)
    assert found[0] == found[1] == found[2]


def test_comparison_on_demand():
    ant = pv.read(pv.examples.antfile)
    better = TrapeziumDrawing(max_deviation_fraction=0.002)(ant)
    plain, bounded = SurfaceComparison(), SurfaceComparison(hausdorff=True)
    plain(better, ant)
    result = pv.wrap(bounded(better, ant))
    assert plain.summary["hausdorff"] is None
    figures = bounded.summary["hausdorff"]
    deviation = bounded.summary["deviation"]
    assert figures["upper"] == max(figures["there"]["upper"], figures["back"]["upper"])
    assert figures["there"]["upper"] >= deviation["max"]
    assert figures["back"]["upper"] >= deviation["back"]["max"]
    assert figures["upper"] <= 1.06 * figures["lower"]
    assert result.field_data["HausdorffUpper"][0] == figures["upper"]


def test_comparison_of_what_shrinks():
    sphere = pv.Icosphere(nsub=3)
    comparison = SurfaceComparison(hausdorff=True)
    comparison(LaplacianSmoothing(iterations=10)(sphere), sphere)
    assert comparison.summary["hausdorff"]["lower"] >= 0.999 * comparison.summary["deviation"]["max"]
