"""Recipes: one list of steps, and the same points whichever way it is run."""

import json
import runpy
import shlex
import string
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import pyvista as pv
from hypothesis import given, settings
from hypothesis import strategies as st

import vtksmooth
from vtksmooth import MeshFileError, ParameterError, Recipe, RecipeError, Step
from vtksmooth.cli import main
from vtksmooth.files import read_surface, write_surface
from vtksmooth.filters import FILTERS, INPUTS


def noisy_sphere():
    mesh = pv.Icosphere(nsub=2)
    mesh.points += np.random.default_rng(0).normal(scale=0.02, size=mesh.points.shape).astype(np.float32)
    mesh.point_data["Pinned"] = (np.arange(mesh.n_points) % 7 == 0).astype(np.uint8)
    return mesh


def points(mesh):
    return np.array(pv.wrap(mesh).points)


def same(mesh, expected):
    assert points(mesh).dtype == points(expected).dtype
    np.testing.assert_array_equal(points(mesh).view(np.uint8), points(expected).view(np.uint8))
    np.testing.assert_array_equal(pv.wrap(mesh).faces, pv.wrap(expected).faces)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("recipe")
    mesh = noisy_sphere()
    write_surface(mesh, folder / "mesh.vtp")
    write_surface(mesh.scale(1.5), folder / "larger.vtp")
    return folder


def files_for(recipe, folder):
    return dict.fromkeys(recipe.sources, folder / "larger.vtp")


#: A chain that changes, measures, passes over, pins and takes a mesh from a file.
def chain(folder):
    return Recipe(
        [
            Step("trapezium-drawing", {"iterations": 3, "fixed": "Pinned"}),
            Step("compare"),
            Step("laplacian", {"scheme": "cotangent"}, enabled=False),
            Step("laplacian", {"scheme": "taubin", "iterations": 4, "stop_gain": -1e-05}),
            Step("compare", inputs={"original": folder / "mesh.vtp"}),
            Step("quality"),
        ]
    )


# ------------------------------------------------------------------------------- the same numbers


def direct(folder):
    """The chain, written out as calls of filters."""
    mesh = read_surface(folder / "mesh.vtp")[0]
    first = vtksmooth.TrapeziumDrawing(iterations=3, fixed="Pinned")(mesh)
    return vtksmooth.LaplacianSmoothing(scheme="taubin", iterations=4, stop_gain=-1e-05)(first)


def test_a_run_is_the_filters_called_in_turn(folder):
    mesh = read_surface(folder / "mesh.vtp")[0]
    before = mesh.copy()
    results = list(chain(folder).results(mesh))
    assert [result.index for result in results] == [0, 1, 3, 4, 5]
    same(results[-1].mesh, direct(folder))
    assert mesh == before
    comparison = vtksmooth.SurfaceComparison()
    comparison(results[0].mesh, mesh)
    assert results[1].algorithm.figures == comparison.summary
    # Measuring leaves the mesh alone; the arrays are beside it.
    assert results[1].mesh is results[0].mesh
    assert results[1].outputs[0].GetPointData().HasArray("NormalDeviation")
    assert not results[-1].mesh.GetPointData().HasArray("NormalDeviation")
    assert results[0].algorithm.figures["iterations"] == 3


@pytest.mark.parametrize("way", ["vtk", "pyvista"])
def test_scripts_run_as_they_are(folder, tmp_path, way):
    recipe = chain(folder)
    script = tmp_path / "script.py"
    target = tmp_path / "out.vtp"
    write = {"vtk": recipe.vtk_script, "pyvista": recipe.pyvista_script}[way]
    script.write_text(write(folder / "mesh.vtp", target), encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-W", "error", script], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("trapezium-drawing: ")
    same(read_surface(target)[0], direct(folder))


def test_command_lines_give_the_same(folder, tmp_path, capsys):
    lines = chain(folder).command_lines(folder / "mesh.vtp", tmp_path / "out.vtp")
    assert [line.split()[1] for line in lines] == [
        "trapezium-drawing",
        "compare",
        "laplacian",
        "compare",
        "quality",
    ]
    for line in lines:
        program, *words = shlex.split(line)
        assert program == "vtksmooth"
        assert main([*words, "--quiet"]) == 0, capsys.readouterr().err
    same(read_surface(tmp_path / "out.vtp")[0], direct(folder))


@pytest.mark.parametrize("cls", FILTERS, ids=lambda cls: cls.command)
def test_every_filter_gives_the_same_in_every_way(cls, folder, tmp_path, capsys, monkeypatch):
    parameters = {"iterations": 2} if "iterations" in cls.parameters() else {}
    recipe = Recipe([Step(cls.command, parameters)])
    files = files_for(recipe, folder)
    mesh = read_surface(folder / "mesh.vtp")[0]
    further = [
        mesh if source == "original" else read_surface(files[source])[0]
        for source in recipe.steps[0].inputs.values()
    ]
    algorithm = cls(**parameters)
    algorithm(mesh, *further)
    expected = mesh if cls.measures else algorithm.GetOutput()
    same(recipe.run(mesh, recipe.read_inputs(files)), expected)
    target = tmp_path / "out.vtp"
    for script in (recipe.vtk_script, recipe.pyvista_script):
        path = tmp_path / "script.py"
        path.write_text(script("never.vtp", "read.vtp", files), encoding="utf-8")
        monkeypatch.setattr(sys, "argv", [str(path), str(folder / "mesh.vtp"), str(target)])
        runpy.run_path(str(path))
        same(read_surface(target)[0], expected)
        target.unlink()
    (line,) = recipe.command_lines(folder / "mesh.vtp", target, files)
    assert main([*shlex.split(line)[1:], "--quiet"]) == 0, capsys.readouterr().err
    if not cls.measures:
        same(read_surface(target)[0], expected)


def test_run_again_from_a_step_on(folder):
    mesh = read_surface(folder / "mesh.vtp")[0]
    recipe = chain(folder)
    first = next(recipe.results(mesh))
    changed = recipe.changed(3, iterations=1)
    start = changed.first_difference(recipe)
    assert start == 3
    results = list(changed.results(mesh, start=start, current=first.mesh))
    assert [result.index for result in results] == [3, 4, 5]
    same(results[-1].mesh, changed.run(mesh))


def test_the_caller_may_run_the_filters(folder):
    seen = []

    def apply(algorithm, *inputs):
        seen.append((type(algorithm).__name__, len(inputs)))
        return algorithm(*inputs)

    mesh = read_surface(folder / "mesh.vtp")[0]
    recipe = Recipe([Step("laplacian"), Step("compare")])
    results = list(recipe.results(mesh, apply=apply))
    assert seen == [("LaplacianSmoothing", 1), ("SurfaceComparison", 2)]
    same(results[-1].mesh, recipe.run(mesh))


def test_no_steps_leave_the_mesh(folder, tmp_path, monkeypatch):
    mesh = read_surface(folder / "mesh.vtp")[0]
    recipe = Recipe([Step("laplacian", enabled=False)])
    assert recipe.run(mesh) is mesh
    assert recipe.command_lines("a.vtp", "b.vtp") == []
    for text in (recipe.vtk_script(), recipe.pyvista_script()):
        (tmp_path / "script.py").write_text(text, encoding="utf-8")
        monkeypatch.setattr(sys, "argv", ["script.py", str(folder / "mesh.vtp"), str(tmp_path / "o.vtp")])
        runpy.run_path(str(tmp_path / "script.py"))
        same(read_surface(tmp_path / "o.vtp")[0], mesh)


# ----------------------------------------------------------------------------- further inputs


def test_roles_and_files(folder):
    mesh, larger = (read_surface(folder / f"{name}.vtp")[0] for name in ("mesh", "larger"))
    by_role = Recipe([Step("compare", inputs={"original": "reference"})])
    by_file = Recipe([Step("compare", inputs={"original": folder / "larger.vtp"})])
    assert by_role.sources == ["reference"]
    assert by_file.sources == [folder / "larger.vtp"]
    assert Recipe([Step("compare")]).sources == []
    figures = [
        next(iter(results)).algorithm.figures
        for results in (
            by_role.results(mesh, {"reference": larger}),
            by_file.results(mesh),
            by_role.results(mesh, by_role.read_inputs({"reference": folder / "larger.vtp"})),
        )
    ]
    assert figures[0] == figures[1] == figures[2]
    assert figures[0]["deviation"]["max"] > 0.1
    for incomplete in (
        lambda: list(by_role.results(mesh)),
        by_role.read_inputs,
        lambda: by_role.command_lines("a.vtp", "b.vtp"),
        by_role.vtk_script,
        by_role.pyvista_script,
    ):
        with pytest.raises(RecipeError, match="'reference'"):
            incomplete()
    with pytest.raises(RecipeError, match="roles are: reference"):
        by_role.read_inputs({"reference": folder / "larger.vtp", "refrence": folder / "mesh.vtp"})


def test_files_beside_the_recipe_move_with_it(tmp_path):
    (tmp_path / "a").mkdir()
    recipe = Recipe(
        [
            Step("compare", inputs={"original": tmp_path / "a" / "part.ply"}),
            Step("compare", inputs={"original": tmp_path.parent / "elsewhere.ply"}),
        ]
    )
    recipe.save(tmp_path / "a" / "r.json")
    assert Recipe.load(tmp_path / "a" / "r.json") == recipe
    (tmp_path / "a").rename(tmp_path / "b")
    moved = Recipe.load(tmp_path / "b" / "r.json")
    assert moved.sources == [tmp_path / "b" / "part.ply", tmp_path.parent / "elsewhere.ply"]


# ------------------------------------------------------------------------------------ round trips


def values(parameter):
    """All that a declaration allows."""
    if parameter.choices:
        some = st.sampled_from(parameter.choices)
    elif parameter.type is bool:
        some = st.booleans()
    elif parameter.type is str:
        some = st.text(string.printable, min_size=1).filter(lambda name: name != "off")
    else:
        low, high = parameter.low, parameter.high
        if parameter.type is int:
            some = st.integers(0 if low is None else int(low), 10**6 if high is None else int(high))
        else:
            some = st.floats(low, high, allow_nan=False, allow_infinity=False)
    if parameter.optional:
        some = some | st.none()
    return some | st.just("auto") if parameter.automatic else some


@st.composite
def steps(draw):
    cls = draw(st.sampled_from(FILTERS))
    names = draw(st.sets(st.sampled_from(list(cls.parameters())))) if cls.parameters() else set()
    parameters = {name: draw(values(cls.parameters()[name])) for name in sorted(names)}
    source = st.sampled_from(["original", "space", Path("part.ply").absolute(), Path("/x y/é.vtp")])
    inputs = {name: draw(source) for name in cls.every_input()[1:] if draw(st.booleans())}
    return Step(cls.command, parameters, inputs, draw(st.booleans()))


recipes = st.lists(steps(), max_size=5).map(Recipe)


@given(recipes)
def test_json_is_a_round_trip(recipe):
    text = recipe.to_json()
    again = Recipe.from_json(text)
    assert again == recipe
    assert hash(again) == hash(recipe)
    assert again.to_json() == text
    # What JSON holds are only departures from the defaults.
    for entry in json.loads(text)["steps"]:
        for name, value in entry.get("parameters", {}).items():
            assert value != Step(entry["filter"]).cls.parameters()[name].default


@settings(max_examples=50)
@given(recipes)
def test_command_lines_and_scripts_have_the_same_parameters(recipe):
    from vtksmooth.cli import _parser

    files = {role: "space.vtp" for role in recipe.sources if isinstance(role, str)}
    enabled = [step for _, step in recipe.enabled]
    lines = recipe.command_lines("-in.vtp", "out dir/o.vtp", files)
    assert len(lines) == len(enabled)
    for line, step in zip(lines, enabled, strict=True):
        _, command, *words = shlex.split(line)
        options = _parser(command).parse_args([command, *words])
        for name, parameter in step.cls.parameters().items():
            assert getattr(options, name) == step.parameters.get(name, parameter.default)

    made = []

    class Recorder:
        """Stands for a mesh, and for its accessor."""

        vtksmooth = field_data = property(lambda self: self)
        items = {}.items

        def __getattr__(self, method):
            def call(*meshes, **parameters):
                made.append({k: v for k, v in parameters.items() if k not in INPUTS})
                return self

            return call

    script = recipe.pyvista_script("a", "b", files)
    body = script[script.index("result = mesh") : script.index("write_surface(result")]
    exec(compile(body, "script", "exec"), {"mesh": Recorder(), "input_1": None, "input_2": None} |
         {f"input_{i}": None for i in range(9)} | {"print": lambda *_: None})  # fmt: skip
    assert made == [dict(step.parameters) for step in enabled]

    # The VTK script with its pipeline taken out: filters are made and set, none is run.
    kept = [
        line
        for line in recipe.vtk_script("a", "b", files).splitlines()
        if (" = " in line and line.endswith("()")) or (".Set" in line and ".SetInput" not in line)
    ]
    scope = {cls.__name__: cls for cls in FILTERS}
    exec("\n".join(kept), scope)
    filters = [value for value in scope.values() if isinstance(value, vtksmooth.filters.Filter)]
    assert [Step.of(f).parameters for f in filters] == [step.parameters for step in enabled]


def test_an_array_called_off_cannot_be_said_on_the_command_line():
    recipe = Recipe([Step("laplacian", {"fixed": "off"})])
    with pytest.raises(RecipeError, match="another name"):
        recipe.command_lines("a.vtp", "b.vtp")


def test_a_step_of_a_filter_is_what_the_filter_does():
    algorithm = vtksmooth.LaplacianSmoothing(scheme="taubin", iterations=3)
    step = Step.of(algorithm)
    assert step == Step("laplacian", {"iterations": 3, "scheme": "taubin"})
    assert repr(step.make()) == repr(algorithm)
    assert str(step) == "laplacian iterations=3, scheme=taubin"


# ---------------------------------------------------------------------------------------- editing


@given(recipes.filter(len), st.data())
def test_edits_make_new_recipes(recipe, data):
    before = recipe.to_json()
    place = st.integers(0, len(recipe) - 1)
    i, j = data.draw(place), data.draw(place)
    step = recipe.steps[i]
    assert recipe.moved(i, j).moved(j, i) == recipe
    assert recipe.moved(i, j).steps[j] == step
    assert recipe.removed(i).added(step, i) == recipe
    assert recipe.added(step).steps == (*recipe.steps, step)
    off = recipe.switched(i, False)
    assert not off.steps[i].enabled
    assert off.switched(i, step.enabled) == recipe
    assert recipe.first_difference(recipe.switched(i, not step.enabled)) == i
    assert recipe.first_difference(recipe) == len(recipe)
    assert recipe.first_difference(recipe.removed(len(recipe) - 1)) == len(recipe) - 1
    defaults = {name: parameter.default for name, parameter in step.cls.parameters().items()}
    assert recipe.changed(i, **defaults).steps[i].parameters == {}
    assert recipe.to_json() == before


def test_steps_cannot_be_changed():
    step = Step("laplacian", {"iterations": 3})
    with pytest.raises(TypeError):
        step.parameters["iterations"] = 4
    with pytest.raises(AttributeError):
        step.command = "quality"


# ----------------------------------------------------------------------------------------- errors


def document(**changes):
    base = {"format": "vtksmooth recipe", "version": 1, "vtksmooth": "0.1.0", "steps": []}
    return json.dumps({key: value for key, value in (base | changes).items() if value is not None})


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("{", "no JSON"),
        ("[" * 100_000, "no JSON"),
        ("[]", "no recipe"),
        ("{}", "no recipe"),
        (document(format="other"), "no recipe"),
        (document(version=2, vtksmooth="9.1"), r"version 2, written by vtksmooth 9\.1.*update"),
        (document(version=None), "whole number"),
        (document(version=True), "whole number"),
        (document(version="1"), "whole number"),
        (document(version=0), "whole number"),
        (document(steps={}), "'steps'; it must be a list"),
        (document(stpes=[]), "unknown key 'stpes'"),
        (document(steps=["laplacian"]), "Step 1: It must be an object"),
        (document(steps=[{}]), "Step 1: It names no filter"),
        (document(steps=[{"filter": "magic"}]), "Step 1: There is no filter 'magic'; there are: quality"),
        (document(steps=[{"filter": "quality"}, {"filter": 3}]), "Step 2: It has 3 as 'filter'"),
        (document(steps=[{"filter": "quality", "enabled": 1}]), "'enabled'; it must be true or false"),
        (document(steps=[{"filter": "laplacian", "parameters": {"magic": 1}}]), "no parameter 'magic'"),
        (document(steps=[{"filter": "laplacian", "parameters": {"iterations": -1}}]), "0 or more"),
        (document(steps=[{"filter": "laplacian", "parameters": {"iterations": [1]}}]), "0 or more"),
        (document(steps=[{"filter": "laplacian", "parameters": {"scheme": {}}}]), "scheme must be one of"),
        (document(steps=[{"filter": "quality", "inputs": {"space": {"role": "x"}}}]), "no further input"),
        (document(steps=[{"filter": "compare", "inputs": {"original": "x.ply"}}]), "must be an object"),
        (document(steps=[{"filter": "compare", "inputs": {"original": {}}}]), "either a path or a role"),
    ],
)
def test_what_is_no_recipe_is_one_sentence(text, what, tmp_path):
    with pytest.raises(RecipeError, match=what) as caught:
        Recipe.from_json(text)
    assert "\n" not in str(caught.value)
    path = tmp_path / "r.json"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(RecipeError, match=what) as caught:
        Recipe.load(path)
    assert str(caught.value).startswith(str(path))


def test_files_that_cannot_be_read_or_written(tmp_path):
    with pytest.raises(RecipeError, match="cannot read"):
        Recipe.load(tmp_path / "none.json")
    (tmp_path / "r.json").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(RecipeError, match="no JSON"):
        Recipe.load(tmp_path / "r.json")
    with pytest.raises(MeshFileError, match="no folder"):
        Recipe().save(tmp_path / "none" / "r.json")
    assert [path.name for path in tmp_path.iterdir()] == ["r.json"]


def test_wrong_steps():
    with pytest.raises(RecipeError, match="no filter 'magic'"):
        Step("magic")
    with pytest.raises(RecipeError, match="no parameter 'magic'"):
        Step("laplacian", {"magic": 1})
    with pytest.raises(ParameterError, match="iterations must be 0 or more"):
        Step("laplacian", {"iterations": -1})


def test_a_byte_order_mark_is_passed_over(tmp_path):
    text = '{"format": "vtksmooth recipe", "version": 1, "steps": [{"filter": "laplacian"}]}'
    (tmp_path / "r.json").write_text(text, encoding="utf-8-sig")
    assert len(Recipe.load(tmp_path / "r.json").steps) == 1
