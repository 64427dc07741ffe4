"""The ParaView plugin: its definitions against the declarations, and a real ParaView against plain VTK."""

import contextlib
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import numba
import numpy as np
import pytest
import pyvista as pv

import vtksmooth
from vtksmooth.errors import VtksmoothError
from vtksmooth.filters import FILTERS
from vtksmooth.filters.parameter import AUTO
from vtksmooth.filters.usual_measures import USUAL_MEASURES
from vtksmooth.paraview import proxies

PACKAGE = Path(vtksmooth.__file__).parent
PLUGIN = PACKAGE / "paraview" / "plugin" / "vtksmooth_plugin.py"
DEBIAN = PACKAGE / "paraview" / "debian"
NAMES = [cls.__name__ for cls in FILTERS]
PARAMETERS = [(cls, parameter) for cls in FILTERS for parameter in cls.parameters().values()]


# -- definitions, without ParaView -----------------------------------------------------------------


def definition(cls):
    return ElementTree.fromstring(f"<proxy>{proxies.definition(cls)}</proxy>")


def properties(cls):
    """The properties that are pushed, by key."""
    return {p.get("initial_string"): p for p in definition(cls) if p.get("command") == "push"}


def held(element):
    """The value of a property, as ParaView hands it over."""
    kind = {"Int": int, "Double": float, "String": str}[element.tag.removesuffix("VectorProperty")]
    return kind(element.get("default_values"))


def other_value(parameter):
    """An allowed value that is not the default."""
    if parameter.choices:
        return next(choice for choice in reversed(parameter.choices) if choice != parameter.default)
    if parameter.type is bool:
        return not parameter.default
    if parameter.type is str:
        return "Pins"
    low = parameter.low or 0
    high = 2 * low + 4 if parameter.high is None else parameter.high
    return parameter.type(low + 0.75 * (high - low))


def as_properties(parameter, value):
    """The properties of a proxy that stand for a value, as a script in ParaView sets them."""
    if parameter.choices or parameter.type in (str, bool):
        return {parameter.camel: "None" if value is None else value}
    found = {} if value in (None, AUTO) else {parameter.camel: value}
    if parameter.optional:
        found[f"Use{parameter.camel}"] = int(value is not None)
    if parameter.automatic:
        found[f"Automatic{parameter.camel}"] = int(value == AUTO)
    return found


@pytest.mark.parametrize("cls", FILTERS)
def test_a_new_proxy_has_the_defaults(cls):
    proxy = proxies.PROXIES[cls]()
    for key, element in properties(cls).items():
        proxy.push(key, held(element))
    assert repr(proxy) == repr(cls())


@pytest.mark.parametrize(("cls", "parameter"), PARAMETERS)
def test_every_value_can_be_set(cls, parameter):
    proxy = proxies.PROXIES[cls]()
    found = {p.get("name"): (key, p) for key, p in properties(cls).items()}
    values = [*(parameter.choices or [other_value(parameter)])]
    values += [None] * parameter.optional + [AUTO] * parameter.automatic
    for value in [*values, parameter.default]:
        for name, set_to in as_properties(parameter, value).items():
            key, element = found[name]
            entries = {entry.get("text"): int(entry.get("value")) for entry in element.iter("Entry")}
            proxy.push(key, entries.get(set_to, set_to))
        assert getattr(proxy, parameter.name) == value


@pytest.mark.parametrize(("cls", "parameter"), PARAMETERS)
def test_ranges_units_and_help_are_declared_once(cls, parameter):
    element = properties(cls)[parameter.name]
    assert element.findtext("Documentation").startswith(parameter.help)
    span = element.find("IntRangeDomain" if parameter.type is int else "DoubleRangeDomain")
    if span is not None:
        limits = [span.get("min"), span.get("max")]
        assert [limit and float(limit) for limit in limits] == [parameter.low, parameter.high]
        assert parameter.unit in element.get("panel_label", "")
    else:
        assert parameter.choices or parameter.type in (str, bool)


@pytest.mark.parametrize("cls", FILTERS)
def test_inputs_and_outputs_are_named(cls):
    found = definition(cls)
    names = [p.get("name") for p in found.iter("InputProperty")]
    needed = ["Input"] if len(cls.inputs) == 1 else [name.capitalize() for name in cls.inputs]
    assert names == [*needed, *(name.capitalize() for name in cls.optional_inputs)]
    may_be_missing = [
        p.get("name") for p in found.iter("InputProperty") if p.find("Hints/Optional") is not None
    ]
    assert may_be_missing == names[len(needed) :]
    assert [port.get("name").lower() for port in found.iter("OutputPort")] == list(cls.outputs)
    assert found.find("Hints/ShowInMenu").get("category") == "Surface smoothing"
    assert found.find("Documentation").text.startswith(found.find("Documentation").get("short_help")[:-1])


def test_a_refused_value_ends_the_run_and_not_the_program(caplog):
    proxy = proxies.PROXIES[vtksmooth.TrapeziumDrawing]()
    proxy.SetInputData(pv.read(pv.examples.antfile))
    proxy.push("iterations", -3)
    proxy.GetExecutive().Update()  # the way that ParaView takes
    assert proxy.GetOutput().GetNumberOfPoints() == 0
    assert [*caplog.messages] == ["TrapeziumDrawing: iterations must be 0 or more, not -3."]
    proxy.push("iterations", proxy.iterations)
    proxy.GetExecutive().Update()
    assert proxy.GetOutput().GetNumberOfPoints() == 486


# -- in ParaView -----------------------------------------------------------------------------------


def environment(*paths, **more):
    """Nothing of the tests' own Python, except what is named."""
    kept = {key: value for key, value in os.environ.items() if not key.startswith(("PYTHON", "PV_"))}
    return kept | {"PYTHONPATH": os.pathsep.join(map(str, paths))} | more


def pvpython(*arguments, env):
    command = [shutil.which("pvpython"), *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, env=env, timeout=900)


def missing(what):
    """Skip for want of something; fail where it must be there."""
    (pytest.fail if os.environ.get("VTKSMOOTH_NEED_PARAVIEW") else pytest.skip)(what)


@pytest.fixture(scope="module")
def packages(tmp_path_factory):
    """A folder with this environment's numba for ParaView: the sources stay where they are."""
    if not shutil.which("pvpython"):
        missing("pvpython is missing; on Debian: apt-get install paraview python3-paraview")
    done = pvpython("-c", "import sys; print(*sys.version_info[:2])", env=environment())
    assert done.returncode == 0, done.stderr
    if done.stdout.split() != [str(number) for number in sys.version_info[:2]]:
        missing(f"ParaView runs Python {'.'.join(done.stdout.split())}, which needs another numba")
    folder = tmp_path_factory.mktemp("packages")
    for package in ("numba", "llvmlite", "filelock"):
        (folder / package).symlink_to(Path(numba.__file__).parents[1] / package)
    metadata = folder / "vtksmooth-0.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text(f"Name: vtksmooth\nVersion: {vtksmooth.__version__}\n")
    return folder


class ParaView:
    """Sessions of pvpython in one folder."""

    def __init__(self, folder, packages):
        self.folder = folder
        self.env = environment(PACKAGE.parent, packages, DEBIAN)
        self.mesh = str(folder / "mesh.vtp")
        self.original = str(folder / "original.vtp")
        self.blocks = str(folder / "blocks.vtm")

    def session(self, *steps, jobs=(), plugin=str(PLUGIN), **env):
        """Run steps of paraview_session.py; return its answers and what was printed, by job."""
        asked = {"steps": steps, "jobs": jobs, "plugin": plugin, "names": NAMES, "mesh": self.mesh}
        asked["screen"] = "DISPLAY" in env
        (self.folder / "asked.json").write_text(json.dumps(asked))
        (self.folder / "answers.json").unlink(missing_ok=True)
        script = Path(__file__).with_name("paraview_session.py")
        done = pvpython(script, self.folder, env=self.env | env)
        assert done.returncode == 0, done.stderr
        answers = json.loads((self.folder / "answers.json").read_text())
        parts = re.split(r"^<(.*)>\n", done.stderr, flags=re.MULTILINE)
        return answers, dict(zip(parts[1::2], parts[2::2], strict=True))


@pytest.fixture(scope="module")
def paraview(packages, tmp_path_factory):
    """A ParaView, with PyVista's meshes in the files that it reads best."""
    paraview = ParaView(tmp_path_factory.mktemp("paraview"), packages)
    mesh = pv.read(pv.examples.antfile)
    mesh.point_data["Pins"] = (np.arange(mesh.n_points) % 7 == 0).astype(np.uint8)
    mesh.cell_data["Number"] = np.arange(mesh.n_cells)
    mesh.save(paraview.mesh)
    mesh.scale(1.5).save(paraview.original)
    plane = pv.read(pv.examples.planefile)
    pv.MultiBlock([mesh, plane.point_data.clear() or plane]).save(paraview.blocks)
    return paraview


def jobs():
    """Every filter with its defaults and with other values, on one mesh and on composite data."""
    for cls in FILTERS:
        needed = [proxies.input_name(cls, port) for port in range(len(cls.inputs))]
        every = [proxies.input_name(cls, port) for port in range(len(cls.every_input()))]
        others = {parameter.name: other_value(parameter) for parameter in cls.parameters().values()}
        for kind, names, files, values in (
            ("defaults", needed, ("mesh", "original"), {}),
            ("others", every, ("mesh", "original"), others),
            ("blocks", needed, ("blocks", "blocks"), {}),
        ):
            yield cls, kind, dict(zip(names, files, strict=False)), values


@pytest.fixture(scope="module")
def ran(paraview):
    asked = []
    for cls, kind, inputs, values in jobs():
        found = {}
        for name, value in values.items():
            found |= as_properties(cls.parameters()[name], value)
        inputs = {name: getattr(paraview, file) for name, file in inputs.items()}
        job = {"id": f"{cls.__name__}-{kind}", "filter": cls.__name__, "inputs": inputs, "properties": found}
        asked.append(job)
    return paraview.session("run", "watch", jobs=asked)


def same(result, expected):
    """Every array bit for bit, but for the time it took, and what VTK measures: ParaView has another VTK."""
    if isinstance(expected, pv.MultiBlock):
        assert len(result) == len(expected)
        for one, other in zip(result, expected, strict=True):
            same(one, other)
        return
    np.testing.assert_array_equal(result.points, expected.points, strict=True)
    for cells in ("verts", "lines", "faces", "strips"):
        np.testing.assert_array_equal(getattr(result, cells), getattr(expected, cells))
    for kind in ("point_data", "cell_data", "field_data"):
        data, wanted = getattr(result, kind), getattr(expected, kind)
        assert set(data.keys()) == set(wanted.keys())
        for name in set(wanted.keys()) - {"SmoothingSeconds"}:
            if name.startswith(tuple(USUAL_MEASURES)):
                np.testing.assert_allclose(data[name], wanted[name], rtol=1e-12, atol=0.0)
            else:
                np.testing.assert_array_equal(data[name], wanted[name])


@pytest.mark.parametrize(
    ("cls", "kind", "inputs", "values"),
    [pytest.param(*job, id=f"{job[0].__name__}-{job[1]}") for job in jobs()],
)
def test_paraview_gives_what_vtk_gives(paraview, ran, cls, kind, inputs, values):
    answers, printed = ran
    name = f"{cls.__name__}-{kind}"
    results = [file and pv.read(file) for file in answers[name]]
    assert len(results) == len(cls.outputs)
    meshes = [pv.read(getattr(paraview, file)) for file in inputs.values()]
    filter = cls(**values)
    with contextlib.suppress(VtksmoothError):
        filter(*meshes)
    error = filter.last_error
    assert printed[name].strip() == ("" if error is None else f"{cls.__name__}: {error}")
    for port, result in enumerate(results):
        if result is None:
            assert filter.GetOutput(port).GetNumberOfPoints() == 0
        else:
            same(result, pv.wrap(filter.GetOutput(port)))


def test_no_name_is_taken_in_paraview(ran):
    assert ran[0]["taken"] == []


def test_progress_reaches_paraviews_bar(ran):
    progress = ran[0]["progress"]
    assert np.diff(progress["sent"]).min() > -1e-12
    assert progress["sent"][-1] == 1
    assert progress["shown"][0] == ["TrapeziumDrawing", 0]
    assert max(percent for _, percent in progress["shown"]) == 100


def test_an_aborted_run_is_empty_and_the_next_one_works(ran):
    assert ran[0]["aborted"] == 0
    assert ran[0]["after"] == 486
    assert ran[1]["watch"].strip() == ""


@pytest.fixture
def display():
    """A display of the test's own: without one ParaView's pictures end in a crash."""
    if not shutil.which("Xvfb"):
        missing("Xvfb is missing; on Debian: apt-get install xvfb")
    reading, writing = os.pipe()
    # Otherwise it begins anew when its last client has gone, and refuses whoever comes meanwhile; ParaView
    # comes twice.
    options = ["-noreset", "-nolisten", "tcp", "-screen", "0", "800x600x24"]
    command = ["Xvfb", "-displayfd", str(writing), *options]
    with subprocess.Popen(command, pass_fds=[writing], stderr=subprocess.DEVNULL) as server:
        os.close(writing)
        with open(reading) as answer:
            yield f":{answer.readline().strip()}"
        server.terminate()


def test_state(paraview):
    saved, _ = paraview.session("state")
    reloaded, _ = paraview.session("reload")
    assert reloaded["properties"] == {
        "Iterations": 4, "Scheme": "taubin", "TangentPlane": 1, "Fixed": "Pins", "PassBand": 0.25,
    }  # fmt: skip
    results = [pv.read(answer[0]) for answer in (saved["saved"], reloaded["reloaded"])]
    mesh = pv.read(paraview.mesh)
    filter = vtksmooth.LaplacianSmoothing(
        iterations=4, scheme="taubin", tangent_plane=True, fixed="Pins", stop_normal_deviation=170,
        pass_band=0.25,
    )  # fmt: skip
    for result in results:
        same(result, pv.wrap(filter(mesh)))
    assert filter.report.iterations == 4
    pinned = mesh["Pins"] == 1
    np.testing.assert_array_equal(results[1].points[pinned], mesh.points[pinned])


def test_picture(paraview, display):
    paraview.session("state", DISPLAY=display)
    picture = pv.read(paraview.folder / "picture.png")
    assert picture.dimensions == (400, 300, 1)
    assert picture["PNGImage"].std() > 10


def test_found_by_the_plugin_path(paraview):
    job = {"id": "path", "filter": "SurfaceQuality", "inputs": {"Input": paraview.mesh}, "properties": {}}
    answers, _ = paraview.session("run", jobs=[job], plugin=None, PV_PLUGIN_PATH=str(PLUGIN.parent))
    same(pv.read(answers["path"][0]), pv.wrap(vtksmooth.SurfaceQuality()(pv.read(paraview.mesh))))


def test_missing_packages_are_said(packages, tmp_path):
    copy = tmp_path / "vtksmooth"
    shutil.copytree(PACKAGE, copy, ignore=shutil.ignore_patterns("__pycache__"))
    plugin = copy / PLUGIN.relative_to(PACKAGE)
    code = f"from paraview.simple import *; LoadPlugin({str(plugin)!r}, remote=False)"
    done = pvpython("-c", code, env=environment(DEBIAN))
    assert "vtksmooth cannot be loaded: " in done.stderr
    assert str(tmp_path) in done.stderr
    assert done.returncode in (0, 1)  # no crash


def test_instructions_word_for_word(paraview, tmp_path):
    """What docs/paraview.md says for Debian, in a copy of the repository and another home."""
    try:
        debian = "bookworm" in Path("/etc/os-release").read_text()
    except FileNotFoundError:
        debian = False
    if not debian:
        pytest.skip("not Debian 12")
    root = PACKAGE.parent
    clone, home = tmp_path / "clone", tmp_path / "home"
    home.mkdir()
    for name in ("vtksmooth", "gui"):
        shutil.copytree(root / name, clone / name, ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(root / name, clone)
    text = (root / "docs" / "paraview.md").read_text(encoding="utf-8").partition("## Debian 12")[2]
    install, pip, *exports, program = re.search(r"```sh\n(.*?)\n```", text, re.DOTALL)[1].splitlines()
    assert install.startswith("sudo apt-get install paraview ")
    assert program == "paraview"
    env = environment() | {"HOME": str(home)}
    del env["PYTHONPATH"]
    installed = subprocess.run(["bash", "-c", pip], cwd=clone, env=env, capture_output=True, text=True)
    if installed.returncode:
        missing(f"pip has failed: {installed.stderr.strip().splitlines()[-1]}")
    code = (
        "from paraview.simple import *; quality = SurfaceQuality(Input=Sphere()); quality.UpdatePipeline(); "
        "import vtksmooth; print(vtksmooth.__file__, quality.CellData.keys()[0])"
    )
    script = "\n".join([*exports, f'pvpython -c "{code}"'])
    done = subprocess.run(["bash", "-c", script], cwd=home, env=env, capture_output=True, text=True)
    assert "compiles its kernels" not in done.stderr  # it is said by the progress bar
    assert done.stdout.split() == [f"{home}/vtksmooth-paraview/vtksmooth/__init__.py", "AspectRatio"], done
