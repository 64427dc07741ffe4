"""The whole chain: contained, volume kept, clean parts untouched, and what is bad is said."""

import json
import os
from pathlib import Path

import meshes
import numpy as np
import pytest
import pyvista as pv
from schemes import SCHEMES
from vtkmodules.vtkCommonCore import vtkDoubleArray
from vtkmodules.vtkCommonDataModel import vtkPolyData

from vtksmooth import (
    ContainmentCheck,
    InstallationSpaceSmoothing,
    InvalidMeshError,
    LaplacianSmoothing,
    ParameterError,
    samples,
)
from vtksmooth.cli import main
from vtksmooth.files import read_surface
from vtksmooth.filters.arrays import surface_of
from vtksmooth.filters.signed_distance import SignedDistance
from vtksmooth.kernels.containment.crossings import crossing_triangles
from vtksmooth.kernels.distance.closest_point import ClosestPoint
from vtksmooth.kernels.distance.signed_distance import SignedDistanceTree
from vtksmooth.kernels.mesh.mesh import Mesh
from vtksmooth.kernels.smoothing import loop
from vtksmooth.kernels.smoothing.constraints.blend import Blend
from vtksmooth.kernels.smoothing.constraints.containment import Containment
from vtksmooth.kernels.smoothing.constraints.curvature_bound import CurvatureBound
from vtksmooth.kernels.smoothing.schemes import Scheme
from vtksmooth.kernels.smoothing.schemes.pairwise import Pairwise
from vtksmooth.kernels.smoothing.schemes.umbrella import Umbrella

DATA = os.environ.get("VTKSMOOTH_DATA")


@pytest.fixture(scope="module")
def channel():
    return samples.channel()


def outside_and_crossing(mesh, space):
    check = ContainmentCheck()
    check(mesh, space)
    return check.summary["vertices_outside"], check.summary["triangles_crossing"]


def test_the_channel(channel):
    sim, inst = channel
    smoothing = InstallationSpaceSmoothing()
    result = pv.wrap(smoothing(sim, inst))
    report = smoothing.report
    assert (report.outside, report.crossing) == ((0, 0), (0, 0))
    assert outside_and_crossing(result, inst) == (0, 0)
    assert result.is_all_triangles
    assert result.n_points == sim.n_points
    still = result["BlendWeight"] == 0
    assert result.points[still].tobytes() == sim.points[still].tobytes()
    assert 0 < report.blended < report.fixed == result["Fixed"].sum()
    # Open: nothing is swept.
    assert report.volume is None
    assert abs(report.swept_volume) < 1e-12 * np.prod(np.ptp(sim.points, axis=0))
    assert report.inverted[1] == 0


@pytest.mark.parametrize("refinement", [1, 2])
def test_the_noise_of_the_channel_goes(refinement):
    sim, inst = samples.channel(refinement)
    result = pv.wrap(InstallationSpaceSmoothing()(sim, inst))
    # Away from where nothing may move; in cells.
    inner = (result["Fixed"] == 0) & (sim.points[:, 0] > 1) & (sim.points[:, 0] < 45)
    before, after = (
        np.sqrt(np.mean((refinement * samples.flow_distance(m.points)[inner]) ** 2)) for m in (sim, result)
    )
    assert before > 0.4
    assert after <= 0.10


def test_without_containment_it_would_poke_out(channel):
    sim, inst = channel
    loose = InstallationSpaceSmoothing(containment="none")
    outside, crossing = outside_and_crossing(loose(sim, inst), inst)
    assert loose.report.outside == (0, outside)
    assert outside > 100
    vertices = InstallationSpaceSmoothing(containment="vertices")
    assert outside_and_crossing(vertices(sim, inst), inst)[0] == 0
    assert 0 < vertices.report.crossing[1] < crossing
    assert 0 < vertices.report.distances_asked < 0.2 * vertices.report.moves_checked


def test_a_voxel_torus_in_a_box_keeps_its_volume_and_loses_its_noise():
    sim = samples.voxel_torus(5.0, 12.0)
    box = pv.Box(np.array(sim.bounds) + np.tile([-2, 2], 3)).triangulate()
    smoothing = InstallationSpaceSmoothing()
    result = pv.wrap(smoothing(sim, box))
    before, after = smoothing.report.volume
    assert abs(after - before) < 1e-13 * before
    assert smoothing.report.volume_rounded == pytest.approx(before, rel=1e-6)
    assert np.sqrt(np.mean(samples.torus_distance(result.points, 5.0, 12.0) ** 2)) <= 0.10


def test_the_flow_s_size_and_sign_do_not_matter_and_it_may_be_on_cells(channel):
    sim, inst = channel
    sim = sim.copy()
    sim["Turned"] = -1e-3 * sim["Flow"] * (1 + np.arange(sim.n_points) % 7)[:, None]
    sim["Zero"] = np.zeros((sim.n_points, 3))
    results = {
        flow: pv.wrap(
            InstallationSpaceSmoothing(iterations=2, flow=flow, containment="none")(sim, inst)
        ).points
        for flow in ("Flow", "Turned", "Zero", None)
    }
    np.testing.assert_allclose(results["Turned"], results["Flow"], atol=1e-9)
    np.testing.assert_allclose(results["Zero"], results[None], atol=1e-12)
    assert np.abs(results["Flow"] - results[None]).max() > 1e-2
    sim.cell_data["OnCells"] = np.tile([1.0, 0.0, 0.0], (sim.n_cells, 1))
    sim["OnPoints"] = np.tile([1.0, 0.0, 0.0], (sim.n_points, 1))
    on_cells, on_points = (
        pv.wrap(InstallationSpaceSmoothing(iterations=2, flow=name)(sim, inst)).points
        for name in ("OnCells", "OnPoints")
    )
    np.testing.assert_allclose(on_cells, on_points, atol=1e-9)


def test_bad_flows_are_said(channel):
    sim, inst = channel
    sim = sim.copy()
    with pytest.raises(ParameterError, match=r"no array 'Wind'.* the mesh has: Flow\."):
        InstallationSpaceSmoothing(flow="Wind")(sim, inst)
    sim["Still"] = np.zeros((sim.n_points, 3))
    smoothing = InstallationSpaceSmoothing(flow="Still", iterations=0)
    smoothing(sim, inst)
    assert "flow is zero everywhere" in str(smoothing.report)
    sim["One"] = np.zeros(sim.n_points)
    with pytest.raises(InvalidMeshError, match="vector for each"):
        InstallationSpaceSmoothing(flow="One")(sim, inst)
    sim["Flow"][3] = np.nan
    with pytest.raises(InvalidMeshError, match="NaN"):
        InstallationSpaceSmoothing(flow="Flow")(sim, inst)
    sphere = pv.Sphere()
    sphere["Wind"] = np.ones((sphere.n_points, 3))
    with pytest.raises(ParameterError, match="flow='Wind' has no effect with scheme='odt'"):
        LaplacianSmoothing(scheme="odt", flow="Wind")(sphere)


def test_who_is_outside_at_the_start_does_not_get_worse(channel):
    sim, _ = channel
    # Much of the flow volume does not fit in this box.
    box = pv.Box((20.0, 26.0, 8.0, 14.0, 4.0, 12.0)).triangulate().clean()
    smoothing = InstallationSpaceSmoothing()
    result = pv.wrap(smoothing(sim, box))
    measure = SignedDistanceTree(SignedDistance(box).mesh)
    before, after = measure(sim.points), measure(result.points)
    tolerance = 1e-6 * box.length
    assert smoothing.report.outside[0] == (before > tolerance).sum() > 100
    assert (after <= np.maximum(before, tolerance) * (1 + 1e-12)).all()
    assert smoothing.report.outside[1] <= smoothing.report.outside[0]
    assert smoothing.report.crossing[1] <= smoothing.report.crossing[0]


@pytest.mark.parametrize("containment", ["vertices", "exact"])
def test_constraints_and_containment_at_the_same_time(channel, containment):
    sim, inst = channel
    sim = sim.copy()
    sim["Radius"] = np.where(np.arange(sim.n_points) % 3, 0.4, np.inf)
    unbounded, bound = InstallationSpaceSmoothing(iterations=5), 0.002
    smoothing = InstallationSpaceSmoothing(
        iterations=5, containment=containment, gate="floor", gate_floor=0.5, crease_angle=85.0,
        max_deviation_fraction=bound, max_displacement="Radius", preserve_volume=True,
    )  # fmt: skip
    distances = {}
    surface = ClosestPoint(surface_of(sim.triangulate()).mesh)
    for one in unbounded, smoothing:
        result = pv.wrap(one(sim, inst))
        travelled = np.linalg.norm(result.points - sim.points, axis=1)
        deviation = surface.query(np.asarray(result.points, float))[1].max()
        distances[one] = deviation, (travelled - sim["Radius"]).max()
    assert distances[unbounded][0] > bound * sim.length
    assert distances[unbounded][1] > 0.01
    assert distances[smoothing][0] <= bound * sim.length * (1 + 1e-5)
    assert distances[smoothing][1] <= 1e-6
    report = smoothing.report
    assert outside_and_crossing(result, inst) == (report.outside[1], report.crossing[1])
    assert report.outside[1] == 0
    assert report.crossing[1] == 0 or containment == "vertices"
    assert abs(report.swept_volume) < 1e-12 * np.prod(np.ptp(sim.points, axis=0))
    assert report.min_aspect_ratio[1] >= min(0.5, report.min_aspect_ratio[0])
    assert report.inverted[1] <= report.inverted[0]
    assert report.moved > 0.5 * unbounded.report.moved


@pytest.mark.parametrize("name", [*SCHEMES, "pairwise"])
@pytest.mark.parametrize("exact", [False, True])
def test_every_scheme_stays_inside(name, exact):
    mesh = meshes.voxels([cell for cell in np.ndindex(6, 6, 6) if sum(cell) < 12], triangles=True)
    # The space leaves out a corner of the cube: concave edges.
    space_mesh = meshes.voxels([c for c in np.ndindex(6, 6, 6) if max(c) < 6 and min(c) < 4], triangles=True)
    space_mesh = space_mesh.with_points(
        np.where(space_mesh.points > 5, space_mesh.points + 0.05, space_mesh.points)
    )
    space = SignedDistanceTree(space_mesh)
    tolerance = 1e-6
    start = space(mesh.points)
    weights = np.where(np.arange(mesh.n_points) % 5, 1.0, 0.5)
    scheme = Pairwise() if name == "pairwise" else SCHEMES[name]
    constraints = [Blend(weights), CurvatureBound(100.0), Containment(space, tolerance, exact)]
    points, report = loop.smooth(mesh, scheme, constraints, iterations=5)
    assert report.moved > 20
    assert (space(points) <= np.maximum(start, tolerance) + 1e-12).all()


class Outwards(Scheme):
    """Proposes to go as far again from the origin."""

    def propose(self, state, turn, starts, ends, proposed):
        for start, end in zip(starts, ends, strict=True):
            proposed[start:end] = 2.0 * state.points[start:end]


@pytest.mark.parametrize("exact", [False, True])
def test_of_a_step_the_largest_part_is_taken_that_stays_inside(exact):
    sphere = meshes.icosphere(2)
    box = meshes.cube(1)
    for half, least, most in ((1.5, 0.5 - 1 / 16, 0.5), (1.02, 0.0, 0.02), (1.1, 1 / 16, 0.1)):
        space = SignedDistanceTree(box.with_points((2.0 * box.points - 1.0) * half))
        points, report = loop.smooth(
            sphere, Outwards(), [Containment(space, 1e-6, exact)], iterations=1, checked=True
        )
        assert not report.broken
        parts = np.linalg.norm(points - sphere.points, axis=1)
        # Those that go towards the middle of a side, which have the shortest way.
        first = np.abs(sphere.points).max(axis=1) > 1.0 - 1e-9
        assert first.sum() >= 6
        assert (parts[first] >= least - 1e-12).all()
        assert (parts[first] <= most + 2e-6).all()
        # And none stays that could take a part.
        assert (parts[np.abs(sphere.points).max(axis=1) * (1 + 1 / 16) < half] > 0.0).all()


def test_triangles_that_cross_at_the_start_do_not_hold_their_points():
    part = samples.voxel_torus(5.0, 12.0)
    space = pv.ParametricTorus(ringradius=12.0, crosssectionradius=5.2, u_res=61, v_res=31, w_res=2)
    space = space.clean().triangulate().compute_normals(auto_orient_normals=True)
    for scheme in ({"scheme": "thin-plate", "implicit_step": 10.0}, {}):
        smoothing = InstallationSpaceSmoothing(iterations=5, **scheme)
        result = pv.wrap(smoothing(part, space))
        crossing = [
            crossing_triangles(
                np.asarray(mesh.points, float), result.regular_faces.astype(np.int32),
                SignedDistanceTree(SignedDistance(space).mesh).surface, np.full(part.n_points, np.inf), 1e-4,
            )
            for mesh in (part, result)
        ]  # fmt: skip
        assert (crossing[1] <= crossing[0]).all()
        assert crossing[1].sum() < 0.5 * crossing[0].sum()
        error = [np.sqrt(np.mean(samples.torus_distance(m.points, 5.0, 12.0) ** 2)) for m in (part, result)]
        assert error[1] < 0.4 * error[0]


def test_blend_weights_and_the_curvature_bound_in_the_vertex_wise_schemes():
    mesh = meshes.torus(20, 10, jitter=0.3)
    free = loop.smooth(mesh, Umbrella(), iterations=1)[0] - mesh.points
    weights = np.random.default_rng(0).choice([0.0, 0.25, 1.0], mesh.n_points)
    part = loop.smooth(mesh, Umbrella(), [Blend(weights)], iterations=1)[0]
    np.testing.assert_allclose(part - mesh.points, weights[:, None] * free, atol=1e-14)
    assert part[weights == 0].tobytes() == mesh.points[weights == 0].tobytes()
    # A sphere of radius 2 has the curvature 1/2 everywhere.
    sphere = meshes.icosphere(2, radius=2.0)
    for radius, moves in ((1.9, False), (2.1, True)):
        points, report = loop.smooth(sphere, Umbrella(), [CurvatureBound(radius)], iterations=1)
        assert (report.moved == sphere.n_points) is moves
    bound = CurvatureBound(4.0, ramp=2.0)  # 1/2 is twice the bound: half way up the ramp
    points, _ = loop.smooth(sphere, Umbrella(), [bound], iterations=1)
    whole = loop.smooth(sphere, Umbrella(), iterations=1)[0] - sphere.points
    np.testing.assert_allclose(points - sphere.points, 0.5 * whole, atol=1e-3)


@pytest.mark.parametrize("weights", [[0.5], np.full(200, 1.5), np.full(200, np.nan)])
def test_bad_blend_weights(weights):
    with pytest.raises(ParameterError, match="Blend weights"):
        loop.smooth(meshes.torus(20, 10), Umbrella(), [Blend(weights)], iterations=1)


def test_bad_input(channel):
    sim, inst = channel
    with pytest.raises(InvalidMeshError, match="apart"):
        InstallationSpaceSmoothing()(sim, inst.translate((1000.0, 0, 0)))
    with pytest.raises(InvalidMeshError, match="installation space"):
        InstallationSpaceSmoothing()(sim, pv.PolyData())
    with pytest.raises(ParameterError, match="operations on edges"):
        InstallationSpaceSmoothing(tangent_plane=True)(sim, inst)
    turned = inst.flip_faces()
    smoothing = InstallationSpaceSmoothing(iterations=3)
    expected = pv.wrap(InstallationSpaceSmoothing(iterations=3)(sim, inst)).points
    np.testing.assert_allclose(pv.wrap(smoothing(sim, turned)).points, expected, atol=1e-9)
    assert "inside out" in " ".join(smoothing.report.notes)


def test_the_command(channel, tmp_path, capsys):
    sim, inst = channel
    sim.save(tmp_path / "sim.vtp")
    inst.save(tmp_path / "inst.vtp")
    arguments = [str(tmp_path / name) for name in ("sim.vtp", "inst.vtp", "out.vtp")]
    options = [
        "--iterations",
        "3",
        "--flow",
        "Flow",
        "--flow-weight",
        "2",
        "--curvature-radius",
        "50",
        "--json",
    ]
    assert main(["installation-space", *arguments, *options]) == 0
    figures = json.loads(capsys.readouterr().out)
    assert figures["outside"] == figures["crossing"] == [0, 0]
    assert figures["curvature_radius"] == 50
    smoothing = InstallationSpaceSmoothing(iterations=3, flow="Flow", flow_weight=2.0, curvature_radius=50.0)
    expected = pv.wrap(smoothing(pv.read(arguments[0]), inst))
    np.testing.assert_array_equal(pv.read(arguments[2]).points, expected.points)


# -- input as people have it: a right result, or one clear error -------------------------------------


def smoothed(mesh, space, **parameters):
    """Return the filter and its points; whatever comes in, nothing may get worse."""
    smoothing = InstallationSpaceSmoothing(iterations=4, **parameters)
    result = pv.wrap(smoothing(pv.PolyData(meshes.polydata(mesh)), pv.PolyData(meshes.polydata(space))))
    report = smoothing.report
    assert report.outside[1] <= report.outside[0]
    assert report.crossing[1] <= report.crossing[0]
    assert outside_and_crossing(result, meshes.polydata(space)) == (report.outside[1], report.crossing[1])
    assert abs(report.swept_volume) < 1e-13 * np.prod(np.ptp(mesh.points, axis=0))
    assert report.moved > 0
    return smoothing, result


def box_round(mesh, margin=0.0):
    low, high = mesh.points.min(axis=0) - margin, mesh.points.max(axis=0) + margin
    return meshes.cube(1).with_points(low + meshes.cube(1).points * (high - low))


def test_an_open_space(channel):
    sim, inst = channel
    # Without its ends, which the flow goes through.
    ends = np.isin(inst.cell_centers().points[:, 0], (0, 46))
    smoothing = InstallationSpaceSmoothing(iterations=3)
    result = pv.wrap(smoothing(sim, inst.extract_cells(~ends).extract_surface(algorithm="dataset_surface")))
    assert smoothing.report.outside == smoothing.report.crossing == (0, 0)
    assert "is open" in " ".join(smoothing.report.notes)
    assert outside_and_crossing(result, inst) == (0, 0)


@pytest.mark.parametrize("second", [(3, 3, 0), (3, 3, 3)])
def test_cells_and_spaces_that_touch_along_an_edge_or_in_a_corner(second):
    cells = np.array(list(np.ndindex(3, 3, 3)))
    block = meshes.voxels(np.vstack([cells, cells + second]))
    smoothing, result = smoothed(block, box_round(block, 1.0))
    assert smoothing.report.volume == pytest.approx((54, 54), rel=1e-13)
    held = {(3.0, 3.0, z) for z in ((0, 1, 2, 3) if second[2] == 0 else (3,))}
    assert held <= set(map(tuple, result.points.tolist()))
    # The space is the two blocks, and part of one is the mesh.
    part = meshes.voxels([c for c in cells.tolist() if c not in ([0, 0, 0], [2, 2, 2], [1, 2, 2])])
    smoothing, _ = smoothed(part, block)
    assert smoothing.report.outside == smoothing.report.crossing == (0, 0)


def test_polygons_that_are_not_plane_or_concave():
    torus = meshes.torus(16, 10, "quads", jitter=0.25)
    smoothing, result = smoothed(torus, box_round(torus, 0.5))
    assert result.is_all_triangles
    # What the report says of before is not what the input would be measured as.
    assert "cut into triangles" in str(smoothing.report)
    triangles = meshes.torus(16, 10, "triangles")
    smoothing, _ = smoothed(triangles, box_round(triangles, 0.5))
    assert "cut into triangles" not in str(smoothing.report)
    # An L, from 6-gons of which two are concave, beside quads.
    ring = np.array([[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]], float)
    points = np.array([[*corner, z] for z in range(4) for corner in ring])
    sides = [
        [6 * k + i, 6 * k + (i + 1) % 6, 6 * k + 6 + (i + 1) % 6, 6 * k + 6 + i]
        for k in range(3)
        for i in range(6)
    ]
    prism = Mesh.from_faces(points, [*sides, range(5, -1, -1), range(18, 24)])
    smoothing, _ = smoothed(prism, box_round(prism, 0.5))
    assert smoothing.report.volume == pytest.approx((9, 9), rel=1e-13)
    assert smoothing.report.inverted[0] == 0


def test_polygons_that_cross_themselves():
    quads = meshes.folded_quads()
    for command in (InstallationSpaceSmoothing(), ContainmentCheck()):
        with pytest.raises(InvalidMeshError) as caught:
            command(meshes.polydata(quads), meshes.polydata(meshes.cube(9)))
        # One sentence: which, and what to do.
        assert str(caught.value).startswith("2 of the polygons cross themselves, the first is face 15 at (")
        assert str(caught.value).endswith("; put their corners in order, or remove them.")


def test_hanging_nodes():
    # The top of a block as one square: the points on its sides hang.
    block = meshes.cube(4)
    top = (block.points[block.connectivity.reshape(-1, 4)][:, :, 2] == 4).all(axis=1)
    corners = [
        np.flatnonzero((block.points == c).all(axis=1))[0]
        for c in ((0, 0, 4), (4, 0, 4), (4, 4, 4), (0, 4, 4))
    ]
    faces = [face for face, of_top in zip(meshes.lists(block), top, strict=True) if not of_top]
    mesh = Mesh.from_faces(block.points, [*faces, corners])
    smoothing, result = smoothed(mesh, box_round(mesh, 1.0))
    rim = block.points[:, 2] == 4
    np.testing.assert_array_equal(result.points[rim], block.points[rim])
    assert smoothing.report.volume is None  # the top's sides are open, if by nothing


def test_components_keep_their_volumes_each():
    first, second = meshes.cube(4), meshes.l_shape()
    second = second.with_points(2 * second.points + [10.0, 0, 0])
    mesh = meshes.joined(first, second)
    _, result = smoothed(mesh, box_round(mesh, 0.5))
    volumes = sorted(
        body.extract_surface(algorithm="dataset_surface").volume for body in result.split_bodies()
    )
    assert volumes == pytest.approx([24, 64], rel=1e-13)


def test_a_space_that_is_no_surface_is_refused(channel):
    sim, inst = channel
    turned = inst.triangulate().regular_faces.copy()
    turned[::3] = turned[::3, ::-1]
    with pytest.raises(InvalidMeshError, match="orient its faces"):
        InstallationSpaceSmoothing()(sim, pv.PolyData.from_regular_faces(inst.points, turned))


def test_units_that_do_not_match_and_flows_of_the_wrong_length(channel):
    sim, inst = channel
    with pytest.raises(InvalidMeshError, match=r"far larger .* units"):
        InstallationSpaceSmoothing()(sim.scale(1000.0), inst)
    tiny = sim.scale(1e-3).translate((20, 10, 8))
    smoothing = InstallationSpaceSmoothing(iterations=1)
    smoothing(tiny, inst)
    assert "far smaller" in " ".join(smoothing.report.notes)
    short = vtkDoubleArray()
    short.SetName("Short")
    short.SetNumberOfComponents(3)
    short.SetNumberOfTuples(sim.n_points - 1)
    short.Fill(1.0)
    mesh = vtkPolyData()
    mesh.ShallowCopy(sim)
    mesh.GetPointData().AddArray(short)
    with pytest.raises(InvalidMeshError, match=rf"'Short' has the shape .*{sim.n_points} points"):
        InstallationSpaceSmoothing(flow="Short")(mesh, inst)


def test_an_empty_mesh(channel):
    with pytest.raises(InvalidMeshError, match="empty"):
        InstallationSpaceSmoothing()(pv.PolyData(), channel[1])


@pytest.mark.skipif(not DATA, reason="VTKSMOOTH_DATA names no folder of meshes")
def test_voxels_inside_a_real_part():
    part, _ = read_surface(Path(str(DATA)) / "egr_cooler.stl")
    space = SignedDistance(part)
    size = part.length / 80
    low = np.array(part.bounds[::2])
    shape = np.ceil(np.ptp(part.points, axis=0) / size).astype(int)
    centres = low + size * (np.moveaxis(np.indices(shape), 0, -1).reshape(-1, 3) + 0.5)
    # Voxels that are as a whole in the ball that is inside.
    cells = (space.tree(centres) < -0.5 * np.sqrt(3) * size).reshape(shape)
    skin = samples.voxel_skin(cells, low, size)
    assert skin.n_cells > 1000
    smoothing = InstallationSpaceSmoothing()
    result = pv.wrap(smoothing(skin, part))
    assert smoothing.report.outside == smoothing.report.crossing == (0, 0)
    assert outside_and_crossing(result, part) == (0, 0)
    assert smoothing.report.volume == pytest.approx([cells.sum() * size**3] * 2, rel=1e-12)
    assert smoothing.report.moved > 0.9 * skin.n_points


@pytest.mark.parametrize("containment", ["none", "vertices", "exact"])
def test_the_pose_does_not_matter(containment):
    for seed in (0, 1, 10, 42):
        random = np.random.default_rng(seed)
        outer = np.zeros((8, 8, 8), bool)
        outer[1:7, 1:7, 1:7] = random.random((6, 6, 6)) < 0.75
        inner = outer & (random.random(outer.shape) < 0.75)
        part, space = (meshes.polydata(meshes.voxels(np.argwhere(cells))) for cells in (inner, outer))
        turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
        turn *= np.sign(np.linalg.det(turn))
        shift = random.normal(size=3)

        def turned(mesh):
            other = pv.wrap(mesh).copy()
            other.points = other.points @ turn.T + shift  # noqa: B023
            return other

        smoothing = InstallationSpaceSmoothing(iterations=10, containment=containment)
        one, two = pv.wrap(smoothing(part, space)), pv.wrap(smoothing(turned(part), turned(space)))
        np.testing.assert_array_equal(one["Fixed"], two["Fixed"])
        np.testing.assert_allclose((two.points - shift) @ turn, one.points, rtol=0, atol=1e-12)


def test_where_the_meshes_are_does_not_matter():
    # All coordinates are multiples of 2^-20, also there: nothing is rounded on the way, only the result.
    sim, inst = samples.channel()
    for mesh in (sim, inst):
        mesh.points = np.round(2.0**20 * mesh.points.astype(np.float64)) / 2**20
    by = np.array([725_000_001.0, -3.0e6, 858_000_003.0])
    found = []
    for shift in (0 * by, by):
        smoothing = InstallationSpaceSmoothing(iterations=5)
        result = smoothing(*(mesh.translate(shift, inplace=False) for mesh in (sim, inst)))
        found.append((pv.wrap(result).points - shift, smoothing.report))
    np.testing.assert_allclose(found[0][0], found[1][0], rtol=0, atol=2.0**-23)
    assert found[0][1].outside == found[1][1].outside == (0, 0)
    assert found[0][1].swept_volume == found[1][1].swept_volume
