"""Points that move in given directions only: terrain in plan and in height, turned parts, symmetry planes."""

import meshes
import numpy as np
import pytest
import pyvista as pv

from vtksmooth import (
    BackToSurfaceSmoothing,
    LaplacianSmoothing,
    NullSpaceSmoothing,
    ParameterError,
    TrapeziumDrawing,
)
from vtksmooth.filters import AngleBasedSmoothing


def terrain():
    """A steep terrain of slivers, as contour lines give them; its outline a rectangle in plan."""
    random = np.random.default_rng(5)
    n = 24
    x, y = np.meshgrid(np.linspace(0, 1, n), np.linspace(0, 1, n))
    inner = (x > 0) & (x < 1) & (y > 0) & (y < 1)
    plan = np.column_stack((x.ravel(), y.ravel()))
    plan[inner.ravel()] += random.uniform(-0.48, 0.48, (int(inner.sum()), 2)) / n
    flat = pv.PolyData(np.column_stack((plan, np.zeros(n * n)))).delaunay_2d()
    height = np.sin(9 * plan[:, 0]) * np.cos(7 * plan[:, 1]) + 0.1 * random.random(n * n)
    return pv.PolyData(np.column_stack((plan, height)), flat.faces)


def areas_in_plan(mesh):
    corners = mesh.points[mesh.regular_faces][:, :, :2]
    (ax, ay), (bx, by) = (corners[:, 1] - corners[:, 0]).T, (corners[:, 2] - corners[:, 0]).T
    return ax * by - ay * bx


@pytest.mark.parametrize("boundary", ["fixed", "sliding", "smoothed"])
@pytest.mark.parametrize("make", [TrapeziumDrawing, AngleBasedSmoothing, LaplacianSmoothing])
def test_no_face_of_a_terrain_turns_over_in_plan(make, boundary):
    mesh = terrain()
    before = areas_in_plan(mesh)
    assert (before > 0).all()
    smooth = pv.wrap(make(iterations=30, directions="xy", boundary=boundary)(mesh))
    assert (areas_in_plan(smooth) >= 0).all()
    assert smooth.points[:, 2].tobytes() == mesh.points[:, 2].tobytes()
    assert (smooth.points != mesh.points).any(axis=1).sum() > 300
    # Straight borders of the plan stay straight.
    if boundary == "sliding":
        for axis in (0, 1):
            for side in (0.0, 1.0):
                on = mesh.points[:, axis] == side
                np.testing.assert_allclose(smooth.points[on, axis], side, atol=1e-12)


def test_without_directions_faces_do_turn_over_in_plan():
    # So that the test above is one.
    turned = [(areas_in_plan(pv.wrap(make(iterations=30)(terrain()))) < 0).sum()
              for make in (TrapeziumDrawing, AngleBasedSmoothing, NullSpaceSmoothing)]  # fmt: skip
    assert max(turned) > 0


def test_only_heights_change_and_noise_goes():
    random = np.random.default_rng(2)
    mesh = pv.Plane(i_resolution=30, j_resolution=30).triangulate()
    mesh.points = mesh.points.astype(float)
    mesh.points[:, 2] = 0.01 * random.normal(size=mesh.n_points)
    smooth = pv.wrap(LaplacianSmoothing(directions="z", iterations=20)(mesh))
    assert smooth.points[:, :2].tobytes() == mesh.points[:, :2].tobytes()
    inner = np.abs(mesh.points[:, :2]).max(axis=1) < 0.4
    assert smooth.points[inner, 2].std() < 0.3 * mesh.points[inner, 2].std()


@pytest.mark.parametrize(("axis", "center"), [("z", (0.0, 0.0, 0.0)), ("x", (0.0, 2.0, -1.0))])
def test_turned_parts_keep_their_radii(axis, center):
    part = pv.Cylinder(direction=np.eye(3)["xyz".index(axis)], center=center, resolution=40, capping=False)
    part = part.triangulate().subdivide(2)
    points = part.points.astype(float)
    number = "xyz".index(axis)
    others = [(number + 1) % 3, (number + 2) % 3]
    random = np.random.default_rng(3)
    inner = np.abs(points[:, number] - center[number]) < 0.49
    angle = 0.03 * random.normal(size=len(points)) * inner
    relative = points[:, others] - np.array(center)[others]
    c, s = np.cos(angle), np.sin(angle)
    points[:, others] = np.array(center)[others] + np.column_stack(
        (c * relative[:, 0] - s * relative[:, 1], s * relative[:, 0] + c * relative[:, 1])
    )
    mesh = pv.PolyData(points, part.faces)
    smooth = pv.wrap(
        LaplacianSmoothing(
            directions=f"about-{axis}", rotation_center=",".join(map(str, center)), iterations=20
        )(mesh)
    )
    radii = [np.linalg.norm((each.points - center)[:, others], axis=1) for each in (mesh, smooth)]
    np.testing.assert_allclose(radii[1], radii[0], rtol=1e-13)
    np.testing.assert_array_equal(smooth.points[:, number], mesh.points[:, number])
    assert (smooth.points != mesh.points).any(axis=1).sum() > 100


def test_points_stay_on_symmetry_planes():
    half = pv.Sphere(theta_resolution=24, phi_resolution=24).clip("x", origin=(0, 0, 0)).triangulate().clean()
    half = half.extract_surface(algorithm="dataset_surface")
    points = half.points.astype(float)
    points[np.abs(points[:, 0]) < 1e-6, 0] = 0.0
    free = points[:, 0] != 0.0
    points[free] += 0.01 * np.random.default_rng(4).normal(size=(int(free.sum()), 3))
    mesh = pv.PolyData(points, half.faces)
    on = points[:, 0] == 0.0
    assert on.sum() > 10
    smooth = pv.wrap(LaplacianSmoothing(symmetry_planes="x=0", boundary="smoothed", iterations=10)(mesh))
    assert (smooth.points[on, 0] == 0.0).all()
    assert (smooth.points[on] != mesh.points[on]).any()
    plain = pv.wrap(LaplacianSmoothing(iterations=10)(mesh))
    np.testing.assert_array_equal(plain.points[on], mesh.points[on])


def test_slopes_that_are_straight_stay_straight():
    # On a straight line in space that is not level, moving in plan leaves the line: its points stay.
    sheet = meshes.sheet(8, 8, "triangles", jitter=0.3, seed=1)
    points = sheet.points.copy()
    points[:, 2] = 0.5 * points[:, 0]
    mesh = pv.PolyData(
        points, np.column_stack((np.full(sheet.n_faces, 3), sheet.connectivity.reshape(-1, 3)))
    )
    smooth = pv.wrap(TrapeziumDrawing(directions="xy", boundary="sliding", iterations=5)(mesh))
    np.testing.assert_array_equal(smooth.points[:, 2], points[:, 2])
    border = points[:, 1] == points[:, 1].min()
    np.testing.assert_allclose(smooth.points[border, 2], 0.5 * smooth.points[border, 0], atol=1e-12)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"symmetry_planes": "q=1"}, "symmetry_planes must be planes such as x=0,z=2.5, not 'q=1'"),
        ({"symmetry_planes": "x=nan"}, "must be planes"),
        ({"directions": "about-z", "rotation_center": "0,1"}, "must be three coordinates"),
        ({"rotation_center": "0,1,2"}, "has no effect"),
        ({"directions": "xy", "tangent_plane": True}, "cannot go together"),
        ({"directions": "z", "preserve_volume": True}, "cannot go together"),
    ],
)
def test_what_cannot_be_is_refused(values, message):
    with pytest.raises(ParameterError, match=message):
        LaplacianSmoothing(**values)(pv.Sphere())


@pytest.mark.parametrize(
    ("make", "values", "advice"),
    [
        (
            BackToSurfaceSmoothing,
            {"directions": "xy"},
            r"Leave out directions \(directions, symmetry_planes\), or",
        ),
        (BackToSurfaceSmoothing, {"symmetry_planes": "x=0"}, "another filter than BackToSurfaceSmoothing"),
        (BackToSurfaceSmoothing, {"preserve_volume": True}, "Leave out a local volume .*, or choose another"),
        (
            TrapeziumDrawing,
            {"directions": "xy", "corrections": 1},
            r"\(corrections\): .* Leave one of them out",
        ),
        (
            LaplacianSmoothing,
            {"directions": "xy", "tangent_plane": True},
            r"\(tangent_plane\): .* Leave one of",
        ),
    ],
)
def test_refusals_advise_only_parameters_that_the_filter_has(make, values, advice):
    with pytest.raises(ParameterError, match=advice) as refusal:
        make(**values)(pv.Sphere())
    named = {name for name in ("tangent_plane", "back_to_surface") if name in str(refusal.value)}
    assert named <= set(make.parameters())
