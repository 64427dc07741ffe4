"""Pairs of faces that cross or touch, against rational arithmetic."""

import json
import os
import re
from fractions import Fraction
from pathlib import Path

import meshes
import numpy as np
import pytest
import pyvista as pv

from vtksmooth import SelfIntersection, SurfaceQuality, set_number_of_threads
from vtksmooth.cli import main
from vtksmooth.kernels.containment.self_intersection import (
    APART,
    CROSSING,
    TOUCHING,
    SelfIntersections,
)
from vtksmooth.kernels.mesh import adjacency
from vtksmooth.kernels.mesh.mesh import Mesh

DATA = Path(os.environ.get("VTKSMOOTH_DATA", "nowhere"))


def minus(a, b):
    return tuple(x - y for x, y in zip(a, b, strict=True))


def cross(a, b):
    return tuple(a[i - 2] * b[i - 1] - a[i - 1] * b[i - 2] for i in range(3))


def dot(a, b):
    return sum(x * y for x, y in zip(a, b, strict=True))


def inwards(triangle):
    """Return for each side a function that is linear in the plane, 0 on the side and positive inside."""
    normal = cross(minus(triangle[1], triangle[0]), minus(triangle[2], triangle[0]))
    return normal, [(triangle[i], cross(normal, minus(triangle[i - 2], triangle[i]))) for i in range(3)]


def common_part(start, end, triangle):
    """Return the ends of what of a segment lies in a triangle."""
    normal, sides = inwards(triangle)
    heights = [dot(normal, minus(x, triangle[0])) for x in (start, end)]
    low, high = Fraction(0), Fraction(1)
    limits = [(dot(n, minus(start, p)), dot(n, minus(end, p))) for p, n in sides]
    limits += [(heights[0], heights[1]), (-heights[0], -heights[1])]
    for a, b in limits:
        if a < 0 and b < 0:
            return []
        if a < 0:
            low = max(low, a / (a - b))
        elif b < 0:
            high = min(high, a / (a - b))
    places = (tuple(s + t * (e - s) for s, e in zip(start, end, strict=True)) for t in (low, high))
    return list(places) if low <= high else []


def level_of(points, f, g):
    """Do what the kernel does from the definition: the corners of the intersection, a convex set."""
    one, two = ([tuple(map(Fraction, points[v].tolist())) for v in face] for face in (f, g))
    corners = {
        place
        for t, o in ((one, two), (two, one))
        for i in range(3)
        for place in common_part(t[i - 1], t[i], o)
    }
    if not corners:
        return APART
    middle = tuple(sum(x) / len(corners) for x in zip(*corners, strict=True))
    if all(dot(n, minus(middle, p)) > 0 for t in (one, two) for p, n in inwards(t)[1]):
        return CROSSING
    shared = [tuple(map(Fraction, points[v].tolist())) for v in set(f) & set(g)]

    def known(place):
        if len(shared) == 2:
            a, b = (minus(place, end) for end in shared)
            return not any(cross(a, b)) and dot(a, b) <= 0
        return place in shared

    return APART if all(map(known, corners)) else TOUCHING


def has_area(points, f):
    p = [tuple(map(Fraction, points[v].tolist())) for v in f]
    return any(cross(minus(p[1], p[0]), minus(p[2], p[0])))


def expected(points, triangles):
    proper = [f for f in range(len(triangles)) if has_area(points, triangles[f].tolist())]
    levels = {
        (f, g): level_of(points, triangles[f].tolist(), triangles[g].tolist())
        for f in proper
        for g in proper
        if f < g
    }
    return {pair: what for pair, what in levels.items() if what}, len(triangles) - len(proper)


def found(points, triangles):
    points = np.ascontiguousarray(points, np.float64)
    mesh = Mesh.from_faces(points, triangles)
    looked = SelfIntersections(mesh, adjacency.build(mesh))
    pairs, levels, degenerate = looked.find(points)
    np.testing.assert_array_equal(looked.levels(points, pairs), levels)
    return dict(zip(map(tuple, pairs.tolist()), levels.tolist(), strict=True)), len(degenerate)


def lattice(random, size):
    return random.integers(0, 4, (size, 3)).astype(float)


def flat(random, size):
    points = lattice(random, size)
    points[:, 2] = points[:, 0] - 2.0 * points[:, 1]
    return points


def generic(random, size):
    return random.normal(size=(size, 3))


def nearly_touching(random, size):
    """Return points of which some lie in planes and on edges of others, up to rounding."""
    points = random.normal(size=(size, 3))
    for v in range(3, size):
        if random.random() < 0.7:
            weights = random.dirichlet(np.ones(3)) if random.random() < 0.5 else np.array([0.3, 0.7, 0.0])
            points[v] = weights @ points[random.permutation(v)[:3]]
    return points


def far(random, size):
    return nearly_touching(random, size) + np.array([1e6, -3e7, 1e5 / 3.0])


def turned(random, size):
    """Return points of a lattice that rounding has moved off its planes."""
    axes = np.linalg.qr(random.normal(size=(3, 3)))[0]
    return lattice(random, size) @ axes + (0.1 if random.random() < 0.5 else 1e9)


def long_numbers(random, size):
    """Return points with 50 bits, of which some are the fourth corners of parallelograms, exactly."""
    points = random.integers(-(2**47), 2**47, (size, 3)).astype(float)
    for v in range(3, size):
        if random.random() < 0.8:
            a, b, c = points[random.permutation(min(v, 4))[:3]]
            points[v] = a + b - c if random.random() < 0.7 else 2.0 * a - b
    return points


KINDS = [lattice, flat, generic, nearly_touching, far, turned, long_numbers]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("common", [0, 1, 2])
def test_pairs_of_triangles_are_those_of_rational_arithmetic(kind, common):
    random = np.random.default_rng([common, KINDS.index(kind)])
    seen = set()
    for _ in range(300):
        points = kind(random, 6 - common)
        triangles = np.array([[0, 1, 2], [*range(common), *range(3, 6 - common)]], np.int32)
        triangles = np.array([random.permutation(t) for t in triangles], np.int32)
        if kind is not long_numbers:
            points *= 10.0 ** random.integers(-3, 4)
        wanted = expected(points, triangles)
        assert found(points, triangles) == wanted, (points.tolist(), triangles.tolist())
        seen.add(wanted[0].get((0, 1), APART))
    assert seen >= ({APART} if common == 2 else {APART, CROSSING})
    if kind in (lattice, flat):
        assert seen == {APART, CROSSING} if common == 2 else seen == {APART, TOUCHING, CROSSING}


@pytest.mark.parametrize("kind", KINDS)
def test_soups(kind):
    random = np.random.default_rng(KINDS.index(kind))
    for _ in range(3):
        points = kind(random, 12)
        triangles = np.array([random.permutation(12)[:3] for _ in range(24)], np.int32)
        triangles[0, 1] = triangles[0, 0]
        assert found(points, triangles) == expected(points, triangles)


@pytest.mark.parametrize("name", ["conrod_bad.stl", "rocker-arm.obj", "egr_cooler.stl"])
def test_real_meshes(name):
    if not (DATA / name).exists():
        pytest.skip(f"needs {name} in VTKSMOOTH_DATA")
    mesh = pv.read(DATA / name).triangulate().clean()
    points, triangles = mesh.points.astype(float), mesh.regular_faces.astype(np.int32)
    pairs, _ = found(points, triangles)
    low, high = points[triangles].min(axis=1), points[triangles].max(axis=1)
    random = np.random.default_rng(5)
    chosen = {*random.integers(0, len(triangles), 40).tolist(), *(f for f, _ in sorted(pairs)[:20])}
    proper = [has_area(points, f) for f in triangles.tolist()]
    for f in chosen:
        for g in np.flatnonzero((low <= high[f]).all(axis=1) & (high >= low[f]).all(axis=1)).tolist():
            if f != g and proper[f] and proper[g]:
                wanted = level_of(points, triangles[f].tolist(), triangles[g].tolist())
                assert pairs.get((min(f, g), max(f, g)), APART) == wanted, (f, g)


def as_dictionary(pairs, levels, _):
    return dict(zip(map(tuple, pairs.tolist()), levels.tolist(), strict=True))


@pytest.mark.parametrize("noise", [0.1, 0.4, 0.8])
@pytest.mark.parametrize("make", [lambda: meshes.icosphere(3), lambda: meshes.sheet(20, 20), meshes.moebius])
def test_fans_are_told_from_crumpled_ones(make, noise):
    mesh = make()
    edge = np.linalg.norm(
        np.diff(mesh.points[mesh.connectivity.reshape(-1, 3)[:, :2]], axis=1), axis=2
    ).mean()
    random = np.random.default_rng(7)
    looked, anew = SelfIntersections(mesh, adjacency.build(mesh)), SelfIntersections(mesh)
    for _ in range(4):
        points = mesh.points + noise * edge * random.normal(size=mesh.points.shape)
        all_pairs = as_dictionary(*anew.find(points))
        assert as_dictionary(*looked.find(points)) == all_pairs
        asked = random.random(mesh.n_faces) < 0.2
        some = {pair: what for pair, what in all_pairs.items() if asked[list(pair)].any()}
        assert as_dictionary(*looked.find(points, asked)) == some
    assert (noise < 0.4) or all_pairs


# -- the filter ----------------------------------------------------------------------------------------


def crossed_boxes():
    return pv.Cube() + pv.Cube(x_length=0.5, y_length=0.5, z_length=1.5)


def test_quadrilaterals_that_cross():
    check = SelfIntersection()
    result = pv.wrap(check(crossed_boxes()))
    assert result["SelfIntersection"].tolist() == [0, 0, 0, 0, 2, 2, 2, 2, 2, 2, 0, 0]
    assert sorted(map(tuple, result.field_data["CrossingCells"].tolist())) == [
        (roof, wall) for roof in (4, 5) for wall in (6, 7, 8, 9)
    ]
    assert result.field_data["TouchingCells"].shape in ((0, 2), (0,))
    assert check.summary == {
        "crossing_pairs": 8, "touching_pairs": 0, "crossing_faces": 6, "touching_faces": 0,
        "degenerate_triangles": 0,
    }  # fmt: skip
    assert result.field_data["CrossingFaces"].tolist() == [6]


def test_boxes_that_share_part_of_a_wall_touch_and_cross():
    check = SelfIntersection()
    beside = pv.Cube(center=(1.0, 0.0, 0.0), y_length=0.5, z_length=0.5)
    result = pv.wrap(check(pv.Cube() + beside))
    # The walls lie on each other; those around the smaller one stand on the larger one.
    assert check.summary["crossing_pairs"] == 1
    assert check.summary["touching_pairs"] == 4
    assert sorted(result["SelfIntersection"].tolist()) == [0] * 6 + [1] * 4 + [2] * 2


def test_a_good_mesh_has_none():
    check = SelfIntersection()
    result = check(pv.Sphere())
    assert check.summary["crossing_pairs"] == check.summary["touching_pairs"] == 0
    assert not pv.wrap(result)["SelfIntersection"].any()


def test_lines_and_strips_are_counted_as_cells():
    strip = pv.PolyData()
    strip.points = np.array(
        [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [0.2, 0.2, -1], [0.3, 0.3, 1], [2, 2, 0.0]]
    )
    strip.lines = [2, 0, 3]
    strip.faces = [3, 4, 5, 6]
    strip.strips = [4, 0, 1, 2, 3]
    result = pv.wrap(SelfIntersection()(strip))
    assert result["SelfIntersection"].tolist() == [0, 2, 2]
    assert result.field_data["CrossingCells"].tolist() == [[1, 2]]


def test_faces_without_area_are_counted_and_nothing_else():
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.2, 0.2, -1], [0.2, 0.2, 1], [0.2, 0.2, 3.0]])
    check = SelfIntersection()
    check(pv.PolyData(points, [3, 0, 1, 2, 3, 3, 4, 5]))
    assert check.summary["degenerate_triangles"] == 1
    assert check.summary["crossing_pairs"] == 0


def test_blocks_have_pairs_of_their_own_cells():
    check = SelfIntersection()
    other = pv.Cube(center=(0.5, 0.5, 0.5))
    blocks = check(pv.MultiBlock([crossed_boxes(), other]))
    first, second = (pv.wrap(blocks.GetBlock(number)) for number in range(2))
    assert len(first.field_data["CrossingCells"]) == 8
    assert len(second.field_data["CrossingCells"]) == 0
    assert (second["SelfIntersection"] > 0).any()
    assert check.summary["crossing_pairs"] > 8


def test_results_do_not_depend_on_the_number_of_threads():
    random = np.random.default_rng(1)
    points = random.random((3000, 3))
    points[1:] = points[:-1] + 0.1 * points[1:]
    triangles = random.integers(0, 2998, (2000, 1)) + np.arange(3)
    mesh = pv.PolyData.from_regular_faces(points, triangles)
    results = []
    for count in (1, 3):
        set_number_of_threads(count)
        results.append(pv.wrap(SelfIntersection()(mesh)).field_data["CrossingCells"])
    set_number_of_threads(0)
    assert len(results[0]) > 100
    assert np.array_equal(*results)


def test_faces_of_two_corners_are_no_triangles():
    line = pv.PolyData(np.array([[0.0, 0, 0], [1, 0, 0]]), [2, 0, 1])
    check = SelfIntersection()
    check(line)
    assert check.summary["crossing_pairs"] == check.summary["degenerate_triangles"] == 0


def test_quality_counts_on_demand(tmp_path, capsys):
    check, quality = SelfIntersection(), SurfaceQuality(self_intersections=True)
    check(crossed_boxes())
    quality(crossed_boxes())
    assert quality.summary["self_intersections"] == check.summary
    plain = SurfaceQuality()
    plain(crossed_boxes())
    assert "self_intersections" not in plain.summary
    crossed_boxes().save(tmp_path / "boxes.vtp")
    assert main(["quality", str(tmp_path / "boxes.vtp"), "--self-intersections", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["self_intersections"] == check.summary
    assert main(["quality", str(tmp_path / "boxes.vtp"), "--self-intersections"]) == 0
    assert re.search(r"crossing pairs +8", capsys.readouterr().out)
