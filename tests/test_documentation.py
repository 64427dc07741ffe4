"""The documentation's pages: their snippets run, and nothing that there is has been left out.

The examples of the gallery, the links between pages and the formulae are checked when the site is built.
"""

import re
import subprocess
import sys
from pathlib import Path

import pytest
from pyvista import examples

import vtksmooth
from vtksmooth import Recipe
from vtksmooth.accessor import method_name
from vtksmooth.filters import FILTERS, SmoothingFilter

DOCS = Path(vtksmooth.__file__).parents[1] / "docs"
ALGORITHMS = sorted(path for path in (DOCS / "algorithms").glob("*.md") if path.name != "index.md")


def blocks(page, language):
    text = (DOCS / page).read_text(encoding="utf-8")
    return re.findall(rf"```{language}\n(.*?)```", text, re.DOTALL)


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "part.ply").write_bytes(Path(examples.antfile).read_bytes())
    return tmp_path


def run(folder, *command):
    done = subprocess.run(
        [sys.executable, *command],
        cwd=folder, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize(
    ("page", "number"),
    [
        (f"start/{path.name}", number)
        for path in sorted((DOCS / "start").glob("*.md"))
        for number in range(len(blocks(f"start/{path.name}", "python")))
    ],
)
def test_python_of_the_quick_starts(folder, page, number):
    code = blocks(page, "python")[number]
    if ".plot(" in code:
        # What is drawn is tested by the gallery; here there may be nothing to draw with.
        code = "import pyvista\npyvista.PolyData.plot = lambda mesh, **_: print(mesh.n_cells)\n" + code
    run(folder, "-W", "error", "-c", code)


def test_pyvista_in_ten_lines():
    install = blocks("start/index.md", "console")[0].splitlines()
    code = blocks("start/pyvista.md", "python")[0].splitlines()
    assert len(install) + sum(1 for line in code if line) <= 10
    for step in ("pv.read(", ".vtksmooth.trapezium_drawing(", "surface_comparison(", ".plot("):
        assert any(step in line for line in code)


def test_command_lines_of_the_quick_start(folder):
    (recipe,) = blocks("start/command_line.md", "json")
    Recipe.from_json(recipe).save(folder / "recipe.json")
    commands = [
        line.removeprefix("$ ").split()
        for text in blocks("start/command_line.md", "console")
        for line in text.splitlines()
    ]
    assert len(commands) == 5
    for program, *arguments in commands:
        assert program == "vtksmooth"
        run(folder, "-c", "import sys; from vtksmooth.cli import main; sys.exit(main())", *arguments)
    assert {"better.vtp", "report.html", "results"} <= {path.name for path in folder.iterdir()}


@pytest.mark.parametrize("cls", FILTERS)
def test_every_filter_is_on_every_list(cls):
    reference = (DOCS / "reference" / "filters.rst").read_text(encoding="utf-8")
    assert f".. autoclass:: vtksmooth.{cls.__name__}\n" in reference
    algorithms = "".join(path.read_text(encoding="utf-8") for path in ALGORITHMS)
    choice = (DOCS / "which_filter.md").read_text(encoding="utf-8")
    if not cls.measures or cls.command == "containment":
        assert f"{{py:class}}`vtksmooth.{cls.__name__}`" in algorithms
    if cls.command != "regions":
        assert re.search(rf"\b{method_name(cls)}\b", choice)


@pytest.mark.parametrize("path", ALGORITHMS, ids=lambda path: path.stem)
def test_algorithms_have_all_sections(path):
    text = path.read_text(encoding="utf-8")
    headings = re.findall(r"^## (.*)$", text, re.MULTILINE)
    assert headings == ["Idea", "Formulae", "Guarantees", "Limits", "Reference"]
    assert "$$" in text
    (example, *_) = re.findall(r"!\[.+\]\(\.\./gallery/images/sphx_glr_(\w+)_\d{3}\.png\)", text)
    assert (DOCS.parent / "examples" / f"{example}.py").exists()


def test_parameters_named_in_the_choice_exist():
    text = (DOCS / "which_filter.md").read_text(encoding="utf-8").partition("## What may be combined")[2]
    given = re.findall(r"`(\w+)=([^`]+)`", text)
    alone = re.findall(r"`([a-z_]+)`", text)
    parameters = SmoothingFilter.parameters()
    assert len(given) > 8
    for name, value in given:
        parameters[name].check(
            {"True": True}.get(value, value.strip('"')) if not value[0].isdigit() else float(value)
        )
    assert len(alone) > 8
    assert set(alone) <= {*parameters, *SmoothingFilter.every_input()}


def test_the_papers_items_name_tests_and_pages_that_there_are():
    rows = [line.split("|")[1:-1] for line in (DOCS / "papers.md").read_text(encoding="utf-8").splitlines()
            if line.startswith("| ") and not line.startswith(("| item", "| ---"))]  # fmt: skip
    assert len(rows) > 20
    for item, where, tests, evidence in rows:
        assert item.strip()
        assert where.strip()
        named = re.findall(r"`(tests/\w+\.py)`", tests)
        assert named, item
        assert all((DOCS.parent / name).is_file() for name in named), item
        pages = re.findall(r"\]\(([\w/]+\.md)\)", evidence)
        assert pages or "*open*" in evidence, item
        assert all((DOCS / name).is_file() for name in pages), item
        for name in re.findall(
            r"`(\w+(?:Smoothing|Drawing|Quality|Comparison|Detection|Regions|Triangulation))", where
        ):
            assert hasattr(vtksmooth, name), name
