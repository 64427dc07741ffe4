"""The ParaView plugin: its definitions against the declarations, and a real ParaView against plain VTK."""

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
    assert names == (["Input"] if len(cls.inputs) == 1 else [name.capitalize() for name in cls.inputs])
    assert [port.get("name").lower() for port in found.iter("OutputPort")] == list(cls.outputs)
    assert found.find("Hints/ShowInMenu").get("category") == "Surface smoothing"
    assert found.find("Documentation").text.startswith(found.find("Documentation").get("short_help")[:-1])


def test_a_refused_value_ends_the_run_and_not_the_program(capfd):
    proxy = proxies.PROXIES[vtksmooth.TrapeziumDrawing]()
    proxy.SetInputData(pv.read(pv.examples.planefile))
    proxy.push("iterations", -3)
    consumer = pv.PolyData()  # nothing raises on the way that ParaView takes
    proxy.GetExecutive().Update()
    consumer.shallow_copy(proxy.GetOutput())
    assert consumer.n_points == 0
    assert capfd.readouterr().err.count("TrapeziumDrawing: iterations must be 0 or more, not -3.") == 1
    proxy.push("iterations", 1)
    assert proxy.iterations == 1
    proxy.Update()
    assert proxy.GetOutput().GetNumberOfPoints() == 1335


# -- in ParaView -----------------------------------------------------------------------------------


def environment(*paths, **more):
    """Nothing of the tests' own Python, except what is named."""
    kept = {key: value for key, value in os.environ.items() if not key.startswith(("PYTHON", "PV_"))}
    return kept | {"PYTHONPATH": os.pathsep.join(map(str, paths))} | more


def pvpython(*arguments, env):
    command = [shutil.which("pvpython"), *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, env=env, timeout=900)


def screen():
    """Without a display ParaView's pictures end in a crash: what gives it one."""
    return bool(os.environ.get("DISPLAY")) or bool(shutil.which("xvfb-run") and shutil.which("xauth"))


@pytest.fixture(scope="module")
def packages(tmp_path_factory):
    """A folder with this environment's numba for ParaView: the sources stay where they are."""
    if not shutil.which("pvpython"):
        pytest.skip("pvpython is missing; on Debian: apt-get install paraview python3-paraview")
    done = pvpython("-c", "import sys; print(*sys.version_info[:2])", env=environment())
    assert done.returncode == 0, done.stderr
    if done.stdout.split() != [str(number) for number in sys.version_info[:2]]:
        pytest.skip(f"ParaView runs Python {'.'.join(done.stdout.split())}, which needs another numba")
    folder = tmp_path_factory.mktemp("packages")
    for package in ("numba", "llvmlite"):
        (folder / package).symlink_to(Path(numba.__file__).parents[1] / package)
    return folder
