"""Surfaces between labels: lines and junctions like the definition, volumes of all labels exact."""

from fractions import Fraction

import meshes
import numpy as np
import pytest
import pyvista as pv
import reference
from hypothesis import given, settings
from hypothesis import strategies as st

from vtksmooth.errors import InvalidMeshError
from vtksmooth.filters.arrays import surface_of
from vtksmooth.jit import parallel
from vtksmooth.kernels.distance.signed_distance import SignedDistanceTree
from vtksmooth.kernels.measures import aspect_ratio
from vtksmooth.kernels.measures.label_volumes import label_volumes
from vtksmooth.kernels.mesh import adjacency
from vtksmooth.kernels.mesh.labels import check_closed, labelled, sheets
from vtksmooth.kernels.mesh.mesh import Mesh
from vtksmooth.kernels.mesh.triangulate import triangulate
from vtksmooth.kernels.smoothing import loop
from vtksmooth.kernels.smoothing.constraints.blend import Blend
from vtksmooth.kernels.smoothing.constraints.containment import Containment
from vtksmooth.kernels.smoothing.constraints.creases import Creases
from vtksmooth.kernels.smoothing.constraints.deviation_bound import DeviationBound
from vtksmooth.kernels.smoothing.constraints.displacement_bound import DisplacementBound
from vtksmooth.kernels.smoothing.constraints.gate import Gate
from vtksmooth.kernels.smoothing.constraints.label_volumes import LabelVolumes
from vtksmooth.kernels.smoothing.schemes.pairwise_labels import PairwiseLabels


def quads(voxels):
    return labelled(*meshes.label_walls(voxels))[0]


def triangles(voxels):
    mesh = quads(voxels)
    corners, cell = triangulate(mesh)
    return labelled(Mesh.from_faces(mesh.points, corners), mesh.face_labels[cell])[0]


def exact_volumes(mesh, points):
    """Six times the volume of each label, in rational numbers."""
    p = [[Fraction(x) for x in row] for row in points.tolist()]
    total = [Fraction(0)] * (int(mesh.face_labels.max()) + 1)
    corners = mesh.connectivity.reshape(-1, 3).tolist()
    for (i, j, k), (first, second) in zip(corners, mesh.face_labels.tolist(), strict=True):
        a, b, c = p[i], p[j], p[k]
        volume = (
            a[0] * (b[1] * c[2] - b[2] * c[1])
            + a[1] * (b[2] * c[0] - b[0] * c[2])
            + a[2] * (b[0] * c[1] - b[1] * c[0])
        )
        total[first] += volume
        total[second] -= volume
    return total


VOXELS = st.builds(meshes.speckle, st.just((3, 3, 4)), st.integers(2, 5), st.integers(0, 10_000))


@given(VOXELS, st.booleans())
@settings(max_examples=30)
def test_kinds_and_rows_are_those_of_the_definition(voxels, triangulated):
    mesh = triangles(voxels) if triangulated else quads(voxels)
    near = adjacency.build(mesh)
    lines = reference.line_edges(mesh)
    degree = np.bincount(np.array(sorted(lines), dtype=int).ravel(), minlength=mesh.n_points)
    rows = reference.label_rows(mesh)
    for v in range(mesh.n_points):
        # All labels of voxels close, so nothing is held.
        expected = {0: adjacency.INTERIOR, 2: adjacency.LINE}.get(degree[v], adjacency.JUNCTION)
        assert near.kinds[v] == expected
        assert set(near.row[near.row_offsets[v] : near.row_offsets[v + 1]].tolist()) == rows[v]
    check_closed(mesh, near)


@given(VOXELS)
@settings(max_examples=20)
def test_volumes_are_counts_of_voxels(voxels):
    mesh, names = labelled(*meshes.label_walls(voxels))
    count = np.array([(voxels == name).sum() for name in names])
    volumes = label_volumes(mesh)
    assert abs(volumes[1:] - count[1:]).max(initial=0.0) < 1e-11
    assert volumes[0] == pytest.approx(-count[1:].sum())


def test_without_labels_the_rows_are_the_rings():
    near = adjacency.build(meshes.torus(9, 6))
    assert near.row is near.ring
    assert near.row_offsets is near.ring_offsets


def test_labels_may_be_any_integers_on_either_side():
    mesh, sides = meshes.label_walls(meshes.grains(7, 3))
    values = np.array([-(2**62), 5, -7, 2**62])
    random = np.random.default_rng(0)
    turned = random.random(mesh.n_faces) < 0.5
    corners = mesh.connectivity.reshape(-1, 4).copy()
    corners[turned] = corners[turned, ::-1]
    given_sides = values[sides]
    given_sides[turned] = given_sides[turned, ::-1]
    result, names = labelled(Mesh.from_faces(mesh.points, corners), given_sides)
    assert names.tolist() == sorted(values.tolist())
    check_closed(result, adjacency.build(result))
    volumes = dict(zip(names.tolist(), label_volumes(result), strict=True))
    voxels = meshes.grains(7, 3)
    assert volumes[5] == pytest.approx((voxels == 1).sum())
    assert volumes[-7] == pytest.approx((voxels == 2).sum())


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda corners, sides: (corners[:, ::-1], sides), "disagrees"),
        (lambda corners, sides: (corners, np.where(sides == 2, 1, sides)), "same label"),
        (lambda corners, sides: (corners, sides[:-1]), "a pair for each"),
        (lambda corners, sides: (corners, sides + 0.5), "integers"),
    ],
)
def test_bad_labels_are_refused(spoil, message):
    mesh, sides = meshes.label_walls(meshes.grains(7, 3))
    corners = mesh.connectivity.reshape(-1, 4).copy()
    some = np.arange(len(corners)) < 20
    other_corners, other_sides = spoil(corners, sides)
    if message == "disagrees":
        other_corners = np.where(some[:, None], other_corners, corners)

    def attempt():
        result, _ = labelled(Mesh.from_faces(mesh.points, other_corners), other_sides)
        check_closed(result, adjacency.build(result))

    with pytest.raises(InvalidMeshError, match=message):
        attempt()


def test_missing_walls_are_refused_and_open_borders_are_not():
    voxels = np.zeros((2, 1, 1), int)
    voxels[:, 0, 0] = 1, 2
    mesh, sides = meshes.label_walls(voxels)
    corners = mesh.connectivity.reshape(-1, 4)
    for remove, closes in ((sides.min(axis=1) == 1, False), (sides.max(axis=1) == 2, True)):
        result, _ = labelled(Mesh.from_faces(mesh.points, corners[~remove]), sides[~remove])
        near = adjacency.build(result)
        if closes:
            check_closed(result, near)
            assert (near.kinds == adjacency.BOUNDARY).any()
        else:
            with pytest.raises(InvalidMeshError, match="do not close"):
                check_closed(result, near)


@given(VOXELS)
@settings(max_examples=20)
def test_sheets_share_no_points_across_lines(voxels):
    mesh = triangles(voxels)
    cut, vertex = sheets(mesh)
    assert (vertex[cut.connectivity] == mesh.connectivity).all()
    # Regular edges stay as they are, and nothing else is open.
    edges = reference.directed_edges(cut)
    open_edges = {tuple(sorted(vertex[list(edge)].tolist())) for edge in edges if edge[::-1] not in edges}
    assert open_edges <= reference.line_edges(mesh)
    assert sum(edge[::-1] in edges for edge in edges) >= 2 * (
        len(adjacency.build(mesh).ring) // 2 - len(reference.line_edges(mesh))
    )
    # Of voxels every face looks the way of its sheet.
    assert (aspect_ratio.aspect_ratios(mesh, aspect_ratio.reference_directions(mesh)) > 0.8).all()


def test_quads_with_two_line_edges_at_a_corner_are_split_there():
    mesh = quads(meshes.grains(9, 5))
    lines = reference.line_edges(mesh)
    corners, cell = triangulate(mesh)

    def on_lines(face):
        return [tuple(sorted((face[i], face[(i + 1) % len(face)]))) in lines for i in range(len(face))]

    flat = [sum(on_lines(face)) > 1 for face in corners.tolist()]
    # Only where three or four sides of the quadrilateral are on lines is there no other way.
    sides = np.array([sum(on_lines(face)) for face in mesh.connectivity.reshape(-1, 4).tolist()])
    assert (sides[cell[flat]] > 2).all()
    assert (sides == 2).sum() > 20
    plain = Mesh(mesh.points, mesh.offsets, mesh.connectivity)
    without = [sum(on_lines(face)) > 1 for face in triangulate(plain)[0].tolist()]
    assert sum(without) > sum(flat)


CASES = {
    "grains": lambda: meshes.grains(9, 5),
    "speckle": lambda: meshes.speckle((5, 5, 5), 4),
    "touching": lambda: np.eye(2, dtype=int)[:, :, None] * np.ones((1, 1, 3), int),
}


def room_round(mesh):
    """A space whose walls touch the outermost points of a mesh."""
    low, high = mesh.points.min(axis=0), mesh.points.max(axis=0)
    box = pv.Box(tuple(np.column_stack((low, high)).ravel())).triangulate()
    return SignedDistanceTree(surface_of(box).mesh)


LIMITS = {
    "gate": lambda mesh: [Gate("aspect")],
    "floor": lambda mesh: [Gate("floor", 0.6)],
    "deviation": lambda mesh: [DeviationBound(0.2)],
    "displacement": lambda mesh: [DisplacementBound(np.full(mesh.n_points, 0.2))],
    "creases": lambda mesh: [Creases(50.0)],
    "space": lambda mesh: [Containment(room_round(mesh), 1e-6)],
    "exact space": lambda mesh: [Containment(room_round(mesh), 1e-6, exact=True)],
    "all": lambda mesh: [
        Gate("floor", 0.6),
        DeviationBound(0.3),
        Containment(room_round(mesh), 1e-6, exact=True),
    ],
}


@pytest.mark.parametrize("limit", LIMITS)
@pytest.mark.parametrize("name", ["grains", "speckle"])
def test_pairwise_between_labels_keeps_limits_and_gates(name, limit):
    mesh = triangles(CASES[name]())
    constraints = [*LIMITS[limit](mesh), LabelVolumes()]
    points, report = loop.smooth(mesh, PairwiseLabels(), constraints, iterations=5, checked=True)
    assert report.broken == []
    assert report.moved > 0
    # Gates and bounds act; what is in a room that it fills leaves it without the limit.
    assert not np.array_equal(points, loop.smooth(mesh, PairwiseLabels(), iterations=5)[0])


@pytest.mark.parametrize("name", CASES)
def test_pairwise_keeps_the_volume_of_every_label(name):
    mesh = triangles(CASES[name]())
    blend = np.random.default_rng(0).choice([0.0, 0.3, 1.0], mesh.n_points, p=[0.1, 0.2, 0.7])
    before = exact_volumes(mesh, mesh.points)
    for constraints in ([], [Blend(blend)]):
        points, report = loop.smooth(mesh, PairwiseLabels(), constraints, iterations=20)
        assert report.moved > 0.5 * mesh.n_points
        for old, new in zip(before, exact_volumes(mesh, points), strict=True):
            assert abs(float((new - old) / old)) < 1e-13
        if constraints:
            assert points[blend == 0].tobytes() == mesh.points[blend == 0].tobytes()
        assert report.inverted == (0, 0)
        assert report.min_aspect_ratio[1] >= 0.2


SMALL = {
    "grains": lambda: meshes.grains(6, 3),
    "speckle": lambda: meshes.speckle((3, 3, 2), 4),
    "touching": CASES["touching"],
}


@pytest.mark.parametrize("name", SMALL)
def test_one_sweep_like_the_definition(name):
    mesh = triangles(SMALL[name]())
    order = adjacency.breadth_first_order(adjacency.build(mesh))
    scheme = PairwiseLabels(0.2)
    points, _ = loop.smooth(mesh, scheme, iterations=1)
    edges = order[scheme.ends]
    assert (
        len({tuple(sorted(edge)) for edge in edges.tolist()})
        == len(edges)
        == len(adjacency.build(mesh).ring) // 2
    )
    expected, taken = reference.pairwise_labels(
        mesh, edges, 0.2, aspect_ratio.reference_directions(mesh).astype(float)
    )
    assert taken > 0.6 * len(edges)
    assert abs(points - expected).max() < 1e-6


def test_threads_make_no_difference():
    mesh = triangles(meshes.grains(24, 9))
    results = []
    for threads in (1, 3):
        parallel.set_number_of_threads(threads)
        results.append(loop.smooth(mesh, PairwiseLabels(), iterations=3)[0])
    parallel.set_number_of_threads(0)
    assert results[0].tobytes() == results[1].tobytes()


def test_two_labels_on_a_manifold_smooth_like_any_surface():
    mesh = meshes.icosphere(2)
    noisy = mesh.with_points(
        mesh.points * (1 + 0.05 * np.random.default_rng(0).standard_normal((mesh.n_points, 1)))
    )
    both, _ = labelled(noisy, np.tile([1, 0], (noisy.n_faces, 1)))
    points, _ = loop.smooth(both, PairwiseLabels(), iterations=20)
    radius = np.linalg.norm(points, axis=1)
    assert np.std(radius) < 0.25 * np.std(np.linalg.norm(noisy.points, axis=1))
    assert abs(label_volumes(both.with_points(points)) / label_volumes(both) - 1).max() < 1e-13
