"""The evidence and the benchmark run, at sizes that take seconds; nothing here looks at a clock."""

import os
from pathlib import Path

import numpy as np
import pytest
import pyvista as pv

from vtksmooth.files import writing
from vtksmooth.filters.arrays import surface_of
from vtksmooth.kernels.smoothing import loop
from vtksmooth.kernels.smoothing.constraints.containment import Containment
from vtksmooth.kernels.smoothing.constraints.deviation_bound import DeviationBound
from vtksmooth.kernels.smoothing.constraints.null_space import NullSpace
from vtksmooth.kernels.smoothing.schemes.umbrella import Umbrella

FOLDER = Path(__file__).parents[1] / "benchmarks"


def test_evidence_on_generated_shapes(program, tmp_path):
    program("evidence").make(tmp_path, data=None, quick=True)
    page = (tmp_path / "evidence.md").read_text(encoding="utf-8")
    assert "TD inverts 0 triangles on the surface and 0 in the plan." in page
    assert "## Pyramid: figure 1" in page
    assert "| layers | TD | 20 |" in page
    assert "/" + tmp_path.name not in page


def test_a_pyramid_and_layers_of_known_sizes(program):
    shapes = program("shapes")
    pyramid = shapes.pyramid()
    np.testing.assert_allclose(np.linalg.norm(pyramid.points, axis=1), 1.0, atol=1e-12)
    assert pyramid.n_open_edges == 6
    assert (pyramid.face_normals[:, 2] > 0).all()
    plain = shapes.layers(jitter=0.0)
    sizes = program("evidence")._sizes(plain)
    for number, h in enumerate((1.0, 0.5, 0.25, 0.5, 1.0)):
        # The median face of a layer is half a square of its edges; all add up to the strip.
        assert np.median(sizes[np.asarray(plain["Layer"]) == number]) == pytest.approx(h / 2**0.5, rel=0.02)
    assert plain.area == pytest.approx(12.0 * 20.0, rel=0.01)


def test_how_far_sizes_are_kept(program):
    evidence, shapes = program("evidence"), program("shapes")
    graded = shapes.layers()
    larger = graded.copy()
    larger.points = 3.0 * graded.points
    np.testing.assert_allclose(evidence._kept(graded, larger), (1.0, 1.0, 3.0))
    assert evidence._kept(graded, graded) == pytest.approx((1.0, 1.0, 1.0))


def test_features_on_generated_shapes(program, tmp_path, monkeypatch):
    features = program("features")
    monkeypatch.setattr(features, "SEEDS", 1)
    monkeypatch.setattr(features, "LEVELS", (0.0, 0.05))
    features.make(tmp_path, data=None, size=8)
    page = (tmp_path / "features.md").read_text(encoding="utf-8")
    assert "| cube (from 90°) | 1.000 (1.00/1.00) |" in page
    assert (tmp_path / "pictures" / "features_L block.png").exists()
    assert "/" + tmp_path.name not in page


def test_labels_of_generated_shapes(program):
    shapes = program("shapes")
    # Three points inside each unit of a ridge; the L's 22 units meet at four points that are no corners.
    for cells, corners, ridges in (([[0, 0, 0]], 8, 36), ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], 12, 70)):
        mesh, labels = shapes.blocks(np.array(cells, float), 4)
        assert mesh.is_manifold
        assert mesh.volume == pytest.approx(len(cells))
        assert (labels == 2).sum() == corners
        assert (labels == 1).sum() == ridges
    mesh, labels = shapes.wedge(60.0, 6)
    assert (labels == 1).sum() == 5
    np.testing.assert_allclose(mesh.points[labels == 1][:, [0, 2]], 0.0, atol=1e-12)


def test_page_on_installation_spaces(program, tmp_path):
    program("installation_space").make(tmp_path, quick=True)
    page = (tmp_path / "installation_space.md").read_text(encoding="utf-8")
    (channel,) = [line.split("|") for line in page.splitlines() if "containment vertices" in line]
    assert channel[4].strip() == "0"
    assert "frog, tissue 1" in page


def test_page_on_labels(program, tmp_path):
    program("labels").main(["--quick", "--output", str(tmp_path)])
    page = (tmp_path / "labels.md").read_text(encoding="utf-8")
    rows = [line for line in page.splitlines() if "SegmentationSurface**" in line]
    assert len(rows) == 2
    assert all("e-1" in line.split("|")[2] for line in rows)
    assert "tissue 17, contacts as lines | 0 |" in page


def test_one_command_makes_all_pages_of_evidence(program, tmp_path, monkeypatch):
    pages, asked = program("pages"), {}
    for name in ("evidence", "features", "volume", "quality"):
        monkeypatch.setattr(
            program(name), "main", lambda arguments, name=name: asked.update({name: arguments})
        )
    pages.main(["--data", "meshes", "--output", str(tmp_path)])
    folder = ["--data", "meshes", "--output", str(tmp_path)]
    assert asked == {
        **dict.fromkeys(("evidence", "features", "volume"), folder),
        "quality": [*folder[:3], str(tmp_path / "quality.md")],
    }


def test_costs_on_small_meshes(program, tmp_path):
    program("costs").make(tmp_path, quick=True)
    page = (tmp_path / "costs.md").read_text(encoding="utf-8")
    assert page.count("| sweep, containment") == 6
    assert page.count("| conservative iteration") == 2


def test_volume_on_the_generated_shape(program, tmp_path):
    program("volume").make(tmp_path, data=None, quick=True)
    page = (tmp_path / "volume.md").read_text(encoding="utf-8")
    assert "null space alone" in page
    assert (tmp_path / "pictures" / "volume_orders.png").stat().st_size > 5000


def test_the_notched_sphere_lies_on_its_shape(program):
    sphere = program("shapes").notched_sphere(6, noise=0.2)
    assert sphere.is_manifold
    assert sphere.n_open_edges == 0
    exact = 7 / 8 * 4 / 3 * np.pi
    assert 0.9 * exact < sphere.volume < exact
    length = np.linalg.norm(sphere.points, axis=1)
    on_wall = (np.abs(sphere.points) < 1e-12).any(axis=1) & (sphere.points > -1e-12).all(axis=1)
    assert ((np.abs(length - 1) < 1e-12) | on_wall).all()


def test_variants_as_the_paper_has_it_agree_with_the_filter(program):
    # A regular mesh with one point displaced: no order of the sweep can matter.
    import pyvista as pv

    from vtksmooth import TrapeziumDrawing
    from vtksmooth.filters.arrays import surface_of

    plane = pv.Plane(i_resolution=4, j_resolution=4).triangulate()
    plane.points = plane.points.astype(float)
    plane.points[12] += [0.06, 0.02, 0.0]
    fixed = np.ones(plane.n_points)
    fixed[12] = 0
    plane["Fixed"] = fixed
    mesh = surface_of(plane).mesh
    alone = mesh.with_points(mesh.points.copy())
    expected = np.asarray(pv.wrap(TrapeziumDrawing(iterations=1)(plane)).points)
    variants = program("variants")
    points = variants.smooth(alone, 1, order="file")
    assert not np.array_equal(points[12], mesh.points[12])
    np.testing.assert_allclose(points[12], expected[12], atol=1e-14)


def test_shapes_are_what_they_say(program):
    shapes = program("shapes")
    sphere = shapes.sphere(2000, noise=0.2)
    np.testing.assert_allclose(np.linalg.norm(sphere.points, axis=1), 1.0)
    assert sphere.is_manifold
    assert sphere.volume > 0
    shuffled = shapes.sphere(2000, noise=0.2, shuffled=True)
    assert shuffled.volume == pytest.approx(sphere.volume)
    cubic = shapes.cubic_surface().points
    np.testing.assert_allclose(cubic[:, 2], 4 * cubic[:, 0] ** 3 + 6 * cubic[:, 1] ** 3)


def test_speed_of_a_few_tools(program, tmp_path, monkeypatch):
    one = {min(os.sched_getaffinity(0))}
    monkeypatch.setattr(os, "sched_getaffinity", lambda process: one)
    output = tmp_path / "benchmark.md"
    arguments = ["--sizes", "1k", "--output", str(output), "--repeats", "1"]
    program("speed").main([*arguments, "--tools", "TD,trimesh Taubin"])
    page = output.read_text(encoding="utf-8")
    rows = [line for line in page.splitlines() if line.startswith("| TD |")]
    assert len(rows) == 2
    assert "failed" not in "".join(rows)
    assert str(tmp_path) not in page


def test_quality_of_a_small_gyroid(program, tmp_path, monkeypatch):
    quality = program("quality")
    monkeypatch.setattr(program("peers"), "KEEPING", {"vtkSmooth": program("peers").KEEPING["vtkSmooth"]})
    monkeypatch.setattr(quality, "SCHEMES", {name: quality.SCHEMES[name] for name in ("odt", "equilateral")})
    monkeypatch.delenv("VTKSMOOTH_DATA", raising=False)
    quality.main(["--output", str(tmp_path / "quality.md")])
    page = (tmp_path / "quality.md").read_text(encoding="utf-8")
    rows = [line for line in page.splitlines() if line.startswith("| **EquilateralSmoothing** |")]
    assert len(rows) == 1
    assert str(tmp_path) not in page


def test_figures_of_known_changes(program):
    quality = program("quality")

    def roof(angle, height=0.0):
        # Two equilateral triangles that meet along the x axis, their normals `angle` apart.
        half, top = np.radians(angle) / 2, np.sqrt(0.75)
        side = [0.5, top * np.cos(half), height - top * np.sin(half)]
        return np.array([[0, 0, height], [1, 0, height], side, [side[0], -side[1], side[2]]])

    faces = np.array([[0, 1, 2], [1, 0, 3]], np.int32)
    judge = quality.Judge(roof(60.0), faces)
    same = judge.figures(judge.points)
    assert (same.kept, same.still_sharp, same.inverted) == (100.0, 100.0, 0)
    assert (same.mean, same.least) == (pytest.approx(1.0), pytest.approx(1.0))
    assert same.deviation == pytest.approx(0.0, abs=1e-12)
    for angle, kept, still_sharp in ((35.0, 100.0, 0.0), (25.0, 0.0, 0.0), (45.0, 100.0, 100.0)):
        figures = judge.figures(roof(angle))
        assert (figures.kept, figures.still_sharp) == (kept, still_sharp)
    flat = quality.Judge(roof(0.0), faces)
    assert flat.figures(roof(0.0, 0.25)).deviation == pytest.approx(25.0 / flat.mesh.diagonal)
    assert flat.figures(roof(0.0)).kept is None


def test_an_unknown_tool_is_refused(program, capsys):
    with pytest.raises(SystemExit) as refused:
        program("speed").main(["--tools", "magic"])
    assert refused.value.code == 2
    assert "no tool magic" in capsys.readouterr().err


def test_a_data_folder_without_the_meshes_is_refused(program, tmp_path, capsys):
    with pytest.raises(SystemExit) as refused:
        program("evidence").main(["--data", str(tmp_path)])
    assert refused.value.code == 2
    assert "mannequin_scan.ply" in capsys.readouterr().err


def test_the_page_on_formats_tells_what_comes_back(program, tmp_path):
    pytest.importorskip("trimesh")
    program("formats").main(["--output", str(tmp_path / "formats.md")])
    page = (FOLDER.parent / "docs" / "formats.md").read_text(encoding="utf-8")
    assert (tmp_path / "formats.md").read_text(encoding="utf-8") == page, "run: python benchmarks/formats.py"


def test_what_is_lost_without_a_note_is_found(program, tmp_path, monkeypatch):
    formats = program("formats")
    monkeypatch.setattr(formats, "write_surface", lambda mesh, path: writing.write_surface(mesh, path) and [])
    lines = next(feature for feature in formats.FEATURES if feature.title == "lines")
    with pytest.raises(RuntimeError, match=r"\.off loses lines without a note"):
        formats.outcome(".off", lines, tmp_path, set())


def test_what_a_mesher_accepts_is_judged(program):
    mesher = program("mesher")
    ball = pv.Icosphere(nsub=2)
    good, bad = mesher.judge(ball), mesher.judge(ball + pv.Icosphere(nsub=2, center=(0.5, 0.1, 0.2)))
    assert (good.crossing, good.touching) == (0, 0)
    assert good.accepted in ("yes", "-")
    assert bad.crossing > 10
    assert bad.accepted in ("no", "-")


def test_exact_containment_forgets_what_it_allowed_where_another_bound_refuses(program):
    # What separates a triangle from the walls was found for corners that then did not go there.
    promises = program("promises")
    mesh = surface_of(promises.random_mesh(np.random.default_rng((0, 3787)))).mesh
    constraints = [
        Containment(promises._space(mesh), 1e-9 * mesh.diagonal, exact=True),
        NullSpace(),
        DeviationBound(0.0003312202039362485),
    ]
    _, report = loop.smooth(mesh, Umbrella(), constraints, iterations=1, checked=True)
    assert report.broken == []
    assert report.moved > 0


def test_the_page_on_promises_tells_what_is_declared(program, tmp_path):
    promises = program("promises")
    page = (FOLDER.parent / "docs" / "promises.md").read_text(encoding="utf-8")
    assert "\n".join(promises.declared()) in page, "run: python benchmarks/promises.py"
    with pytest.raises(SystemExit) as ended:
        promises.main(["--runs", "40", "--output", str(tmp_path / "promises.md")])
    assert ended.value.code == 0
    assert "| all |" in (tmp_path / "promises.md").read_text(encoding="utf-8")


def test_the_page_on_voxel_skins(program, tmp_path):
    program("voxels").make(tmp_path, quick=True)
    rows = [line.split(" | ") for line in (tmp_path / "voxels.md").read_text(encoding="utf-8").splitlines()]
    rms = {row[1]: float(row[2]) for row in rows if len(row) == 7 and row[2][0].isdigit()}
    assert rms["low-pass, preserve_volume"] < 0.044 < rms["pairwise, 20 sweeps"]
    assert len(rms) == 4
