"""Reports: what is on the page is what was measured, and it needs nothing from outside."""

import re
import subprocess
import sys
from html.parser import HTMLParser
from xml.etree import ElementTree

import numpy as np
import pytest
import pyvista as pv
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from vtksmooth import MeshFileError, Recipe, Step, SurfaceComparison, SurfaceQuality
from vtksmooth.cli import main
from vtksmooth.files import write_surface
from vtksmooth.pages import histogram, html, pdf, pictures, tables
from vtksmooth.pages.measures import measure
from vtksmooth.pages.page import make_page, said
from vtksmooth.pages.writing import FORMATS, write_page
from vtksmooth.report import RunReport, figure

SVG = "{http://www.w3.org/2000/svg}"
NAMES = ("<b>&\"'$x_1$ é.ply", "better.ply")
RECIPE = Recipe([Step("trapezium-drawing", {"iterations": 2}), Step("laplacian", enabled=False)])


def grid(z=0.0, triangles=False):
    mesh = pv.Plane(i_resolution=6, j_resolution=4).translate((0, 0, z))
    return mesh.triangulate() if triangles else mesh


@pytest.fixture(scope="module")
def ant():
    return pv.read(pv.examples.antfile)


@pytest.fixture(scope="module")
def page(ant):
    results = list(RECIPE.results(ant))
    return make_page(measure(ant, results[-1].mesh), NAMES, RECIPE, [said(results[0].algorithm)])


@pytest.fixture
def blind(monkeypatch):
    def crash(command, **_):
        return subprocess.CompletedProcess(command, -11, b"", b"")

    monkeypatch.setattr(pictures.subprocess, "run", crash)


# ---------------------------------------------------------------------------------------- measures


def test_the_same_faces_are_compared_by_the_filters(ant):
    result = RECIPE.run(ant)
    measured = measure(ant, result)
    quality, comparison = SurfaceQuality(usual_measures=False), SurfaceComparison()
    quality(ant)
    comparison(result, ant)
    assert measured.same_faces
    assert measured.summaries == (quality.summary, comparison.summary)
    for k, algorithm in zip(measured.aspect_ratios, (quality, comparison), strict=True):
        np.testing.assert_array_equal(k, pv.wrap(algorithm.GetOutput())["AspectRatio"])


def test_other_faces_are_compared_as_surfaces():
    measured = measure(grid(), grid(0.5, triangles=True))
    assert not measured.same_faces
    after = measured.summaries[1]
    assert after["cells"] == {"triangle": 48, "quad": 0, "polygon": 0}
    assert after["deviation"]["max"] == pytest.approx(0.5)
    assert after["deviation"]["mean"] == pytest.approx(0.5)
    assert after["deviation"]["max_relative"] == pytest.approx(0.5 / np.sqrt(2.0))
    assert after["volume_change_percent"] is None
    assert after["dihedral_change"] == {"max": None, "mean": None}
    cube = pv.Cube().clean()
    assert measure(cube, cube.triangulate()).summaries[1]["deviation"]["max"] == 0
    larger = measure(cube, cube.scale(2.0).triangulate()).summaries[1]
    assert larger["volume_change_percent"] == pytest.approx(700.0)
    # Corner to corner, the far way: from the larger cube's corner to the smaller one.
    assert larger["deviation"]["max"] == pytest.approx(np.sqrt(0.75))


def test_deviation_of_other_faces_is_of_both_ways():
    piece = grid(triangles=True).clip("x", origin=(0, 0, 0)).extract_surface(algorithm="dataset_surface")
    for pair, way in (((grid(), piece), (0.0, 0.5)), ((piece, grid()), (0.5, 0.0))):
        found = measure(*pair).summaries[1]["deviation"]
        assert (found["max"], found["back"]["max"]) == pytest.approx(way)


# --------------------------------------------------------------------------------------- histogram


@given(arrays.arrays(float, st.integers(1, 50), elements=st.floats(-1, 1)))
def test_shares_count_every_face_once(k):
    shares = histogram.shares(k)
    expected = [(k < 0).sum()]
    for i in range(histogram.N_BINS):
        last = (k == 1) * (i == histogram.N_BINS - 1)
        expected.append(((np.floor(k * histogram.N_BINS) == i) | last).sum())
    np.testing.assert_allclose(shares, 100 * np.array(expected) / len(k))
    assert sum(shares) == pytest.approx(100)


def test_what_is_no_number_counts_as_inverted():
    assert histogram.shares(np.array([np.nan, 0.5]))[0] == 50


@given(st.floats(0.0, 100.0))
def test_ticks_reach_the_largest(largest):
    ticks = histogram.ticks(largest)
    assert ticks[0] == 0
    assert 2 <= len(ticks) <= 7
    assert ticks[-1] >= largest


def test_bars_are_as_high_as_the_shares(page):
    before, after = page.histograms
    root = ElementTree.fromstring(
        histogram.svg(before, after).replace("<svg", '<svg xmlns="http://www.w3.org/2000/svg"')
    )
    bars = [bar for bar in root.iter(f"{SVG}rect") if bar.find(f"{SVG}title") is not None]
    heights = np.array([float(bar.get("height")) for bar in bars]).reshape(-1, 2).T
    shares = np.array([before, after])
    np.testing.assert_allclose(heights / heights.max(), shares / shares.max(), atol=1e-3)
    assert bars[0].find(f"{SVG}title").text == "k < 0, before: 0.00 %"
    assert all(float(bar.get("x")) + float(bar.get("width")) <= 900 for bar in bars)


# -------------------------------------------------------------------------------------- the pages


class Document(HTMLParser):
    """What a page loads, shows and leaves open."""

    def __init__(self):
        super().__init__()
        self.loaded, self.text, self.open, self.tags = [], "", [], set()

    def handle_starttag(self, tag, attributes):
        self.tags.add(tag)
        self.loaded += [value for name, value in attributes if name in ("src", "href")]
        if tag not in ("meta", "img", "br"):
            self.open.append(tag)

    def handle_startendtag(self, tag, attributes):
        pass

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text += data


def test_html_is_whole_and_loads_nothing(page):
    source = html.document(page)
    document = Document()
    document.feed(source)
    document.close()
    assert document.open == []
    assert len(document.loaded) == len(page.pictures)
    assert all(address.startswith("data:image/png;base64,") for address in document.loaded)
    assert not document.tags & {"script", "link", "iframe", "b"}
    assert "url(" not in source
    assert "://" not in source
    assert NAMES[0] in document.text
    for table in (page.quality, page.change):
        for row in [table.head, *table.rows]:
            for cell in row:
                assert cell in document.text
    assert "trapezium-drawing iterations=2" in document.text
    assert "laplacian (switched off)" in document.text
    assert "vtksmooth 0." in document.text
    assert "2 iterations, " in document.text


def test_figures_on_the_page_are_those_of_the_filters(ant, page):
    comparison = SurfaceComparison()
    comparison(RECIPE.run(ant), ant)
    summary = comparison.summary
    rows = {row[0]: row[1:] for row in [*page.quality.rows, *page.change.rows]}
    assert rows["mean k"][1] == f"{summary['aspect_ratio']['mean']:.3f}"
    assert rows["inverted faces"][1] == str(summary["inverted"])
    assert rows["volume, change in %"] == [f"{summary['volume_change_percent']:+.3f}"]
    assert rows["vertex normals, mean change, degrees"] == [f"{summary['normal_deviation']['mean']:.3f}"]


def test_pictures_or_why_there_are_none(page):
    said = any("There are no pictures" in sentence for sentence in page.sentences)
    assert said == (not page.pictures)
    for _, png in page.pictures:
        assert png.startswith(b"\x89PNG")
    if page.pictures:
        before, after = (png for _, png in page.pictures)
        assert before != after


@pytest.mark.usefixtures("blind")
@pytest.mark.parametrize("extension", FORMATS)
def test_without_opengl_the_page_says_so(ant, tmp_path, extension):
    page = make_page(measure(ant, ant), NAMES)
    assert page.pictures == []
    assert "libegl1" in page.sentences[-1]
    write_page(page, tmp_path / f"page{extension}")
    assert (tmp_path / f"page{extension}").stat().st_size > 1000


def test_a_defect_in_drawing_is_named(ant, monkeypatch):
    def fail(command, **_):
        return subprocess.CompletedProcess(command, 1, b"", b"Traceback\nValueError: no such colour\n")

    monkeypatch.setattr(pictures.subprocess, "run", fail)
    page = make_page(measure(ant, ant), NAMES)
    assert page.sentences[-1] == "There are no pictures: ValueError: no such colour."


def sheets_of(page):
    """The sheets of a PDF; nothing on them may stick out, nor lie on other text."""
    sheets = pdf.figures(page)
    for sheet in sheets:
        sheet.canvas.draw()
        whole = sheet.bbox
        boxes = [text.get_window_extent() for text in sheet.texts]
        for box in boxes:
            assert whole.x0 <= box.x0
            assert box.x1 <= whole.x1
            assert whole.y0 <= box.y0
            assert box.y1 <= whole.y1
        for i, box in enumerate(boxes):
            for other in boxes[:i]:
                apart = max(other.x0 - box.x1, box.x0 - other.x1, other.y0 - box.y1, box.y0 - other.y1)
                assert apart > -0.5
    return sheets


def test_pdf_is_one_page(page, tmp_path):
    assert len(sheets_of(page)) == 1
    write_page(page, tmp_path / "page.pdf")
    content = (tmp_path / "page.pdf").read_bytes()
    assert content.startswith(b"%PDF")
    assert len(re.findall(rb"/Type /Page\b", content)) == 1


@pytest.mark.usefixtures("blind")
def test_pdf_of_a_name_in_letters_that_the_font_has_not(tmp_path):
    write_page(make_page(measure(grid(), grid()), ("漢字.ply", "better.ply")), tmp_path / "page.pdf")
    assert (tmp_path / "page.pdf").exists()


@pytest.mark.usefixtures("blind")
def test_a_long_recipe_goes_on_on_further_sheets(ant):
    steps = [Step("laplacian", {"iterations": i + 1, "scheme": "taubin"}) for i in range(60)]
    page = make_page(measure(ant, ant), ("x" * 150, "y" * 150), Recipe(steps))
    sheets = sheets_of(page)
    assert len(sheets) > 1
    texts = [text.get_text() for sheet in sheets for text in sheet.texts]
    assert all(f"{i + 1}." in texts for i in range(60))


@pytest.mark.usefixtures("blind")
@pytest.mark.parametrize("extension", FORMATS)
def test_pages_of_meshes_with_other_faces(tmp_path, extension):
    page = make_page(measure(grid(), grid(triangles=True)), NAMES)
    assert "other points or faces" in page.sentences[1]
    write_page(page, tmp_path / f"page{extension}")
    assert ["dihedral angles, largest change, degrees", "-"] in page.change.rows


# ---------------------------------------------------------------------------------------- pictures


def test_cameras_see_all_faces_and_no_loose_points():
    mesh = pv.Sphere()
    camera = pictures.camera_of(mesh)
    loose = mesh.copy()
    loose.points = np.vstack([loose.points, [[np.nan, 0, 0], [1e6, 0, 0]]])
    np.testing.assert_allclose(pictures.camera_of(loose).focal_point, camera.focal_point, atol=1e-6)
    assert camera.width == pytest.approx(1.04 * 1.0, rel=0.02)
    flat = pictures.camera_of(grid())
    assert min(flat.width, flat.height) > 0


@pytest.mark.skipif(sys.platform == "win32", reason="POSIX processes")
def test_drawing_ends_with_the_process_that_wants_it():
    child = "import os, time; from vtksmooth.pages import pictures; pictures._end_with(os.getppid()); "
    child += "print(1, flush=True); time.sleep(100)"
    parent = f"""
import os, subprocess, sys
subprocess.Popen([sys.executable, "-c", {child!r}], stdout=subprocess.PIPE).stdout.readline()
os._exit(0)
"""
    # The child keeps stderr open as long as it lives.
    done = subprocess.run([sys.executable, "-c", parent], stderr=subprocess.PIPE, timeout=60, check=False)
    assert (done.returncode, done.stderr) == (0, b"")


# ------------------------------------------------------------------------------------ command line


@pytest.mark.usefixtures("blind")
@pytest.mark.parametrize("extension", FORMATS)
def test_report_command(ant, tmp_path, extension, capsys):
    write_surface(ant, tmp_path / "before.vtp")
    write_surface(RECIPE.run(ant), tmp_path / "after.vtp")
    RECIPE.save(tmp_path / "r.json")
    out = tmp_path / f"page{extension}"
    arguments = ["report", *map(str, (tmp_path / "before.vtp", tmp_path / "after.vtp", out))]
    assert main([*arguments, "--recipe", str(tmp_path / "r.json")]) == 0
    assert capsys.readouterr().out.startswith("The share of poor faces (k < 0.2) fell from 13.4 to ")
    assert out.exists()
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(
        ["before.vtp", "after.vtp", "r.json", out.name]
    )


def test_report_is_refused_before_anything_is_read(tmp_path, capsys):
    assert main(["report", "none.ply", "none.ply", str(tmp_path / "page.doc")]) == 1
    assert "no format of reports" in capsys.readouterr().err
    assert main(["report", "none.ply", "none.ply", str(tmp_path / "none" / "page.pdf")]) == 1
    assert "no folder" in capsys.readouterr().err


def test_a_page_that_cannot_be_laid_out_leaves_the_old_one(page, tmp_path, monkeypatch):
    path = tmp_path / "page.html"
    path.write_text("old")

    def fail(page, path):
        path.write_text("half")
        raise OSError(28, "No space left on device")

    monkeypatch.setitem(FORMATS, ".html", fail)
    with pytest.raises(MeshFileError, match="No space left"):
        write_page(page, path)
    assert path.read_text() == "old"
    assert [entry.name for entry in tmp_path.iterdir()] == ["page.html"]


def test_tables_for_a_terminal():
    lines = tables.markdown(["name", "value"], [["a", "1"], ["longer", "22.5"]])
    assert lines == [
        "| name   | value |",
        "| ------ | ----: |",
        "| a      |     1 |",
        "| longer |  22.5 |",
    ]


# ------------------------------------------------------------------------------------------ figures


@pytest.mark.parametrize(
    ("value", "digits", "expected"),
    [
        (-100.0, 2, "-100"), (99.6, 2, "100"), (12.34, 2, "12"), (0.0012345, 3, "0.00123"),
        (0.001, 2, "0.001"), (999_999.4, 4, "999999"), (999_999.6, 6, "1000000"), (12345.6, 4, "12346"),
        (2.5e7, 4, "2.5e+07"), (1.5e-14, 2, "1.5e-14"), (0.0, 2, "0"), (1_234_567, 4, "1234567"),
    ],
)  # fmt: skip
def test_figures_have_exponents_only_where_they_must(value, digits, expected):
    assert figure(value, digits) == expected


def test_reports_say_percent_as_people_do():
    report = str(RunReport(volume=(123456.0, 0.0), swept_volume=-123456.0))
    assert "volume 123456 -> 0 (-100 %)" in report
    assert "volume swept 12346;" in str(RunReport(swept_volume=12345.6))
