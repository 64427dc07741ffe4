"""The examples run as a user runs them, and so do the README's snippets; each checks itself.

Those from 06 on take no arguments and draw: building the documentation runs them.
"""

import re
import subprocess
import sys
from pathlib import Path

import pytest
import pyvista as pv
from pyvista import examples

from vtksmooth import Recipe

ROOT = Path(__file__).parents[1]


def run(folder, *command):
    return subprocess.run(
        [sys.executable, *command],
        cwd=folder, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False,
    )  # fmt: skip


@pytest.fixture(scope="session")
def drawing(tmp_path_factory):
    # Without OpenGL, VTK ends the process.
    code = "import pyvista; plotter = pyvista.Plotter(off_screen=True); plotter.screenshot('blank.png')"
    if run(tmp_path_factory.mktemp("drawing"), "-c", code).returncode:
        pytest.skip("drawing without a window needs OpenGL (libegl1 and libgl1)")


def test_every_example_is_tested():
    numbers = [path.name[:2] for path in sorted((ROOT / "examples").glob("*.py"))]
    assert numbers == [f"{number:02}" for number in range(1, 21)]


def test_vtk_pipeline(tmp_path):
    done = run(tmp_path, ROOT / "examples" / "01_vtk_pipeline.py")
    assert done.returncode == 0, done.stderr
    assert "as it should be, refused: fixed: there is no point array 'NoSuchArray'" in done.stdout
    assert "Traceback" not in done.stderr


@pytest.mark.usefixtures("drawing")
def test_pyvista_before_after(tmp_path):
    done = run(tmp_path, ROOT / "examples" / "02_pyvista_before_after.py", "--output", "picture.png")
    assert done.returncode == 0, done.stderr
    image = pv.read(tmp_path / "picture.png")
    assert image.dimensions[:2] == (1400, 700)
    assert image.point_data.active_scalars.std() > 10


def test_batch_of_samples(tmp_path):
    done = run(tmp_path, ROOT / "examples" / "03_batch_folder.py", "--output", tmp_path / "results")
    assert done.returncode == 0, done.stderr
    assert re.search(r"(?m)^\| ant\.ply +\| 0\.004 -> 0\.041 ", done.stdout)
    assert re.search(r"(?m)^broken\.ply ends ", done.stdout)
    assert sorted(path.name for path in (tmp_path / "results").iterdir()) == [
        "airplane.vtp",
        "ant.vtp",
        "smooth.json",
    ]


def test_batch_of_a_folder_of_ones_own(tmp_path):
    (tmp_path / "a.ply").write_text("not a mesh", encoding="utf-8")
    (tmp_path / "b.ply").write_bytes(Path(examples.antfile).read_bytes())
    (tmp_path / "notes.txt").write_text("not to be read", encoding="utf-8")
    done = run(tmp_path, ROOT / "examples" / "03_batch_folder.py", tmp_path)
    assert done.returncode == 1
    assert (tmp_path / "smooth" / "b.vtp").exists()
    assert "notes.txt" not in done.stdout


@pytest.mark.usefixtures("drawing")
def test_moving_front(tmp_path):
    done = run(tmp_path, ROOT / "examples" / "04_moving_front.py", "--steps", "40", "--output", "front.png")
    assert done.returncode == 0, done.stderr
    assert re.search(r"(?m)^conservative +\d\.\d+e-1[4-9] ", done.stdout)
    assert pv.read(tmp_path / "front.png").point_data.active_scalars.std() > 10


def test_installation_space(tmp_path):
    done = run(tmp_path, ROOT / "examples" / "05_installation_space.py")
    assert done.returncode == 0, done.stderr
    assert "outside 0 -> 0 points, crossing 0 -> 0 triangles" in done.stdout


def snippets(language):
    return re.findall(
        rf"```{language}\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.DOTALL
    )


def run_commands(folder, text):
    commands = [line.removeprefix("$ ") for line in text.splitlines() if line.startswith("$ ")]
    for command in commands:
        program, *arguments = command.split()
        assert program == "vtksmooth"
        done = run(folder, "-c", "import sys; from vtksmooth.cli import main; sys.exit(main())", *arguments)
        assert done.returncode == 0, done.stderr
    return commands


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "part.ply").write_bytes(Path(examples.antfile).read_bytes())
    return tmp_path


@pytest.mark.parametrize("number", range(2))
def test_python_snippets_of_the_readme(folder, number):
    found = snippets("python")
    assert len(found) == 3
    done = run(folder, "-W", "error", "-c", found[number])
    assert done.returncode == 0, done.stderr
    assert (folder / "better.vtp").exists()
    assert done.stdout


def test_command_line_snippet_of_the_readme(folder):
    (found,) = [text for text in snippets("console") if "trapezium-drawing" in text]
    assert len(run_commands(folder, found)) >= 3
    assert (folder / "better.vtp").exists()


def test_segmentation_snippet_of_the_readme(folder):
    part = pv.read(examples.frogtissuesfile).extract_subset((180, 260, 150, 230, 40, 80))
    part.save(folder / "frog_tissues.vti")
    (found,) = [text for text in snippets("console") if "vtksmooth segmentation" in text]
    assert run_commands(folder, found) == ["vtksmooth segmentation frog_tissues.vti frog.vtp"]
    assert pv.read(folder / "frog.vtp").cell_data["BoundaryLabels"].shape[1] == 2


def test_recipe_of_the_readme(folder):
    done = run(folder, "-W", "error", "-c", snippets("python")[2])
    assert done.returncode == 0, done.stderr
    (by_hand,) = snippets("json")
    assert Recipe.from_json(by_hand) == Recipe.load(folder / "recipe.json")
    *script, last, compare = done.stdout.splitlines()
    (folder / "script.py").write_text("\n".join(script), encoding="utf-8")
    assert run(folder, "script.py").returncode == 0
    assert last == "vtksmooth trapezium-drawing part.ply better.vtp"
    assert compare == "vtksmooth compare part.ply better.vtp"
    (found,) = [text for text in snippets("console") if "vtksmooth run" in text]
    run_commands(folder, found)
    points = [pv.read(folder / name).points for name in ("better.vtp", "results/part.ply")]
    assert (points[0] == points[1]).all()
    assert (folder / "results" / "part.html").exists()
    assert (folder / "report.pdf").exists()
