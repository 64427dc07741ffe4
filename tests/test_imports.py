"""Imports run one way: jit <- kernels, by rooms <- filters <- accessor, files, recipe <- demo and cli."""

import ast
import graphlib
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import vtksmooth

PACKAGE = Path(vtksmooth.__file__).parent
ROOT = PACKAGE.parent

_COMPUTING = {"filelock", "numpy", "llvmlite", "numba", "scipy"}
#: The layers from below: what is in each (rooms of kernels side by side know nothing of each other), and
#: what it may import besides the standard library and the layers below it.
LAYERS = [
    ({"errors", "other_names", "report"}, set()),
    ({"jit"}, _COMPUTING),
    ({"kernels.mesh"}, _COMPUTING),
    ({"kernels.measures"}, _COMPUTING),
    ({"kernels.features", "kernels.distance"}, _COMPUTING),
    ({"kernels.containment"}, _COMPUTING),
    ({"kernels.smoothing"}, _COMPUTING),
    ({"filters"}, {"numpy", "vtkmodules"}),
    ({"paraview"}, {"numpy", "vtkmodules", "paraview"}),
    ({"accessor", "files", "recipe"}, {"numpy", "vtkmodules", "pyvista", "trimesh"}),
]
#: What is on top may import.
_ON_TOP = {"numpy", "vtkmodules", "pyvista", "matplotlib"}

GUI = ROOT / "gui"
#: What each part of the application may import besides itself, numpy and the standard library.
GUI_PARTS = {
    "model": {
        "vtkmodules",
        "vtksmooth.errors",
        "vtksmooth.files",
        "vtksmooth.filters",
        "vtksmooth.kernels",
        "vtksmooth.recipe",
        "vtksmooth.report",
    },
    "views": {
        "vtkmodules",
        "PySide6",
        "vtksmooth.jit",
        "pyvistaqt",
        "pyqtgraph",
        "vtksmooth.filters",
        "vtksmooth.kernels",
        "vtksmooth.recipe",
        "vtksmooth.report",
    },
    "controllers": {"PySide6", "vtksmooth"},
    "": {"PySide6", "pyvista", "vtksmooth"},
}
#: Which other parts it may import.
GUI_BELOW = {
    "model": set(),
    "views": {"model", "commands", "settings"},
    "controllers": {"model", "views", "commands", "settings"},
    "": {"", "app", "later", "model", "views", "controllers", "settings", "start"},
}


def place(module):
    """The layer of a dotted name within the package, and the room there; what is not named is on top."""
    name = module.partition(".")[2]
    for layer, (rooms, _) in enumerate(LAYERS):
        for room in rooms:
            if name == room or name.startswith(room + "."):
                return layer, room
    return (len(LAYERS), name.partition(".")[0]) if name not in ("", "kernels") else (0, name)


def module_of(file):
    if file.is_relative_to(GUI):
        file = ROOT / "vtksmooth_gui" / file.relative_to(GUI)
    parts = file.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def imports_of(source, module, is_package):
    """Every module that a source names in an import, wherever it stands, as absolute dotted names."""
    found = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ""
            if node.level:
                parents = module.split(".")
                parents = parents[: len(parents) - node.level + is_package]
                base = ".".join([*parents, *([base] if base else [])])
            # "from . import quality" names modules, "from .quality import k" their content.
            found |= {f"{base}.{alias.name}" for alias in node.names} if base in PACKAGES else {base}
    return found


FILES = sorted(PACKAGE.rglob("*.py"))
GUI_FILES = sorted(GUI.rglob("*.py"))
PACKAGES = {module_of(file) for file in (*FILES, *GUI_FILES) if file.name == "__init__.py"}
NAMES = {module_of(file) for file in FILES}
MODULES = [file for file in FILES if file != PACKAGE / "__init__.py"]


def violations(source, module, is_package=False):
    layer, room = place(module)
    foreign = LAYERS[layer][1] if layer < len(LAYERS) else _ON_TOP
    for name in sorted(imports_of(source, module, is_package)):
        top = name.split(".")[0]
        if top == "vtksmooth":
            above, other = place(name)
            if above > layer:
                yield f"{module} imports {name}, which is above it"
            elif above == layer and other != room and room.startswith("kernels"):
                yield f"{module} imports {name}, which is beside it"
        elif top not in sys.stdlib_module_names and top not in foreign:
            yield f"{module} imports {name}"


@pytest.mark.parametrize("file", MODULES, ids=module_of)
def test_imports_run_one_way(file):
    source = file.read_text(encoding="utf-8")
    assert list(violations(source, module_of(file), file.name == "__init__.py")) == []


@pytest.mark.parametrize(
    ("module", "source"),
    [
        ("vtksmooth.errors", "from .kernels import mesh"),
        ("vtksmooth.kernels.smoothing.loop", "from ...filters import Filter"),
        ("vtksmooth.kernels.containment.crossings", "from ..smoothing import loop"),
        ("vtksmooth.kernels.features.detection", "from ..distance import ray"),
        ("vtksmooth.jit.parallel", "from ..kernels.mesh import mesh"),
        ("vtksmooth.kernels.smoothing.loop", "import vtkmodules"),
        ("vtksmooth.kernels.smoothing.schemes.taubin", "def f():\n    from ....accessor import method_name"),
        ("vtksmooth.filters.base", "import pyvista as pv"),
        ("vtksmooth.filters.base", "from .. import files"),
        ("vtksmooth.paraview.proxies", "import pyvista as pv"),
        ("vtksmooth.accessor", "import vtk"),
        ("vtksmooth.files.reading", "from ..cli import main"),
    ],
)
def test_the_contract_notices(module, source):
    assert len(list(violations(source, module))) == 1


def gui_violations(source, module, is_package=False):
    parts = module.split(".")
    part = parts[1] if len(parts) > 2 or is_package else ""
    for name in sorted(imports_of(source, module, is_package)):
        names = name.split(".")
        if names[0] == "vtksmooth_gui":
            if len(names) > 1 and names[1] not in GUI_BELOW[part] | {part}:
                yield f"{module} imports {name}"
        elif names[0] in sys.stdlib_module_names or names[0] == "numpy":
            continue
        elif not {names[0], ".".join(names[:2])} & GUI_PARTS[part]:
            yield f"{module} imports {name}"
        elif part == "model" and name.startswith("vtkmodules.vtkRendering"):
            yield f"{module} draws with {name}"


@pytest.mark.parametrize("file", GUI_FILES, ids=module_of)
def test_the_application_keeps_its_layers(file):
    is_package = file.name == "__init__.py" and file.parent != GUI
    assert list(gui_violations(file.read_text(encoding="utf-8"), module_of(file), is_package)) == []


@pytest.mark.parametrize(
    ("module", "source"),
    [
        ("vtksmooth_gui.model.history", "from PySide6.QtCore import QObject"),
        ("vtksmooth_gui.model.history", "from vtkmodules.vtkRenderingCore import vtkActor"),
        ("vtksmooth_gui.model.history", "from ..views import scale"),
        ("vtksmooth_gui.model.history", "import pyvista"),
        ("vtksmooth_gui.views.log", "from ..controllers.jobs import Jobs"),
    ],
)
def test_the_layers_of_the_application_notice(module, source):
    assert len(list(gui_violations(source, module))) == 1


def test_arrays_are_handed_to_vtk_in_one_place():
    """Elsewhere a view of VTK's memory could be handed back to VTK, see ``vtk_array``."""
    names = {"numpy_to_vtk", "numpy_to_vtkIdTypeArray", "SetVoidArray", "dsa", "dataset_adapter"}
    users = set()
    for file in (*FILES, *GUI_FILES):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            used = {getattr(node, key, None) for key in ("id", "attr", "name")}
            if names & used:
                users.add(module_of(file))
    assert users == {"vtksmooth.filters.arrays"}


def module_imported(name):
    """The module that a dotted name is, or that it is found in."""
    while name not in NAMES:
        name = name.rpartition(".")[0]
    return name


def test_no_module_imports_itself_by_way_of_others():
    graph = {}
    for file in MODULES:
        module = module_of(file)
        found = imports_of(file.read_text(encoding="utf-8"), module, file.name == "__init__.py")
        own = {module_imported(name) for name in found if name.split(".")[0] == "vtksmooth"}
        graph[module] = own - {"vtksmooth"}
    order = [*graphlib.TopologicalSorter(graph).static_order()]
    assert order.index("vtksmooth.files.off") < order.index("vtksmooth.files.reading")


@pytest.mark.parametrize(
    ("module", "unwanted"),
    [
        ("vtksmooth", {"numpy", "llvmlite", "numba", "vtkmodules", "pyvista"}),
        ("vtksmooth.filters", {"vtk", "pyvista", "matplotlib"}),
        ("vtksmooth.kernels.smoothing.loop", {"vtkmodules", "pyvista"}),
        ("vtksmooth.accessor", {"vtksmooth.cli", "vtksmooth.demo"}),
    ],
)
def test_importing_loads_nothing_from_above(module, unwanted):
    done = subprocess.run(
        [sys.executable, "-c", f"import sys, {module}; print(*sys.modules)"],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert unwanted & set(done.stdout.split()) == set()


def test_every_package_is_installed():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    assert set(project["tool"]["setuptools"]["packages"]) == PACKAGES


def test_no_paths_of_a_machine_are_mentioned():
    texts = [*PACKAGE.rglob("*.py")]
    for folder in ("examples", "docs", "benchmarks", "gui"):
        texts += [path for path in (ROOT / folder).rglob("*") if path.suffix in (".py", ".md", ".json")]
    texts += [
        path for path in ROOT.iterdir() if path.suffix in (".md", ".toml", ".yaml") or path.name == "run"
    ]
    paths = re.compile(r"/work/|\.\./shared|/root/|/home/")
    found = [path.name for path in texts if paths.search(path.read_text(encoding="utf-8"))]
    assert found == []
    assert PACKAGE / "__init__.py" in texts
