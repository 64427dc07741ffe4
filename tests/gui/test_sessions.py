"""Sessions: what is saved is what comes back; nothing unsaved is lost, not even by a crash."""

import json
import shutil
import signal
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest
import pyvista as pv
from vtkmodules.util.numpy_support import vtk_to_numpy

model = pytest.importorskip("vtksmooth_gui.model")
from vtksmooth.errors import MeshFileError  # noqa: E402
from vtksmooth.files import read_surface, write_surface  # noqa: E402
from vtksmooth.filters import FeatureDetection, SurfaceComparison, TrapeziumDrawing  # noqa: E402
from vtksmooth_gui.model import session, session_reader  # noqa: E402
from vtksmooth_gui.model.document import Document  # noqa: E402
from vtksmooth_gui.model.draft import Draft  # noqa: E402
from vtksmooth_gui.model.layer import Role  # noqa: E402
from vtksmooth_gui.model.measure import Kind, Measurement  # noqa: E402
from vtksmooth_gui.model.section import Plane  # noqa: E402

WINDOWS = frozenset({"view"})


def part(folder, name="part.vtp", shift=0.0):
    """A file of quadrilaterals, triangles and a polyline, with arrays of several kinds."""
    points = np.array([[x, y, 0.1 * np.sin(3 * x + y)] for y in range(5) for x in range(6)]) + shift
    faces = [[4, 6 * y + x, 6 * y + x + 1, 6 * y + x + 7, 6 * y + x + 6] for y in range(4) for x in range(4)]
    faces += [[3, 6 * y + 4, 6 * y + 5, 6 * y + 11] for y in range(4)]
    mesh = pv.PolyData(points, faces=np.concatenate(faces), lines=[3, 0, 1, 2])
    mesh.point_data["Fixed"] = (points[:, 0] < 1).astype(np.uint8)
    mesh.point_data["vector"] = points[::-1].astype(np.float32)
    mesh.cell_data["ids"] = np.arange(mesh.n_cells)
    mesh.point_data.active_scalars_name = "Fixed"
    mesh.field_data["made by"] = ["nobody", "by hand"]
    mesh.save(folder / name)
    return folder / name


def opened(document, path):
    return document.open(read_surface(path)[0], path)


def apply(document, layer, cls, *further, **values):
    made, sources = document.step(layer, cls, values, further)
    algorithm = cls(**values)
    algorithm(layer.state.input(), *(state.input() for state in further))
    outputs = [algorithm.GetOutput(port) for port in range(len(cls.outputs))]
    document.apply(layer, outputs, made, sources, cls.__name__, "did it", "it was done")


@pytest.fixture
def document(tmp_path):
    """Two layers, three steps of which one is undone, a measurement, and more."""
    (tmp_path / "a").mkdir()
    document = Document()
    layer = opened(document, part(tmp_path / "a"))
    other = opened(document, part(tmp_path / "a", "other.vtp", 0.5))
    apply(document, layer, TrapeziumDrawing, iterations=2, fixed="Fixed")
    apply(document, layer, SurfaceComparison, layer.opened)
    apply(document, layer, FeatureDetection)
    document.undo()
    document.set_role(other, Role.SPACE)
    document.set_visible(other, False)
    document.set_unit("mm")
    document.compare(layer, other)
    document.measure(Measurement(Kind.DISTANCE, layer, np.array([3, 17]), layer.state.n_points))
    document.plane = Plane((1.0, 2.0, 3.0), (0.0, 0.6, 0.8))
    return document


def reopened(path, located=None):
    document = Document()
    restored = session_reader.restore(session_reader.find(path), located or {})
    session_reader.apply(restored, document, WINDOWS)
    return document, restored


def test_edits_that_have_not_been_run_stay_edits(document, tmp_path):
    draft = Draft(document)
    edited = draft.recipe.changed(0, iterations=7).removed(1)
    draft.set(edited, {"mould": document.layers[1].state})
    snapshot = session.capture(document, {}, draft.every)
    session.save(snapshot, tmp_path / "all.vtksmooth")
    again, restored = reopened(tmp_path / "all.vtksmooth")
    other = Draft(again)
    other.restore(restored.drafts)
    assert other.edited
    assert other.recipe == edited
    assert list(other.sources) == list(draft.sources)
    assert_same_points(other.sources["mould"], document.layers[1].state)


def saved(document, path, **more):
    session.save(session.capture(document, more), path)
    return path


def arrays_of(mesh):
    """Everything that a mesh holds, as arrays and texts."""
    found = {"points": vtk_to_numpy(mesh.GetPoints().GetData())}
    for kind in ("Verts", "Lines", "Polys", "Strips"):
        cells = getattr(mesh, f"Get{kind}")()
        if cells.GetNumberOfCells():
            found[f"{kind} offsets"] = vtk_to_numpy(cells.GetOffsetsArray()).astype(np.int64)
            found[kind] = vtk_to_numpy(cells.GetConnectivityArray()).astype(np.int64)
    for where in ("Point", "Cell", "Field"):
        data = getattr(mesh, "GetFieldData" if where == "Field" else f"Get{where}Data")()
        for i in range(data.GetNumberOfArrays()):
            array = data.GetAbstractArray(i)
            name = f"{where} {array.GetName()} {array.GetClassName()}"
            if "String" in name:
                found[name] = [array.GetValue(j) for j in range(array.GetNumberOfValues())]
            else:
                found[name] = vtk_to_numpy(array)
        if where != "Field":
            active = data.GetScalars()
            found[f"{where} scalars"] = active.GetName() if active else None
    return found


def assert_same_state(a, b):
    assert (a is None) == (b is None)
    if a is None:
        return
    ours, its = arrays_of(a.mesh), arrays_of(b.mesh)
    assert list(ours) == list(its)
    for name, values in ours.items():
        if isinstance(values, np.ndarray):
            assert values.dtype == its[name].dtype, name
            assert values.tobytes() == its[name].tobytes(), name
        else:
            assert values == its[name], name
    assert (a.recipe, a.did) == (b.recipe, b.did)
    assert list(a.sources) == list(b.sources)


def assert_same_document(a, b):
    assert [(x.name, x.role, x.visible, x.path, x.source, x.unsaved) for x in a.every_layer] == [
        (x.name, x.role, x.visible, x.path, x.source, x.unsaved) for x in b.every_layer
    ]
    for ours, its in zip(a.every_layer, b.every_layer, strict=True):
        for name in ("opened", "state", "saved"):
            assert_same_state(getattr(ours, name), getattr(its, name))
    assert a.history.index == b.history.index
    assert a.history.memory == b.history.memory
    assert [(s.title, s.summary, s.settled) for s in a.history.steps] == [
        (s.title, s.summary, s.settled) for s in b.history.steps
    ]
    for ours, its in zip(a.history.steps, b.history.steps, strict=True):
        assert [x.name for x in ours.changes] == [x.name for x in its.changes]
        assert [(x.name, roles) for x, roles in ours.roles.items()] == [
            (x.name, roles) for x, roles in its.roles.items()
        ]
        for mine, other in zip(ours.changes.values(), its.changes.values(), strict=True):
            for one, two in zip(mine, other, strict=True):
                assert_same_state(one, two)
    assert (a.unit, a.plane) == (b.unit, b.plane)
    assert [x.name if x else None for x in (a.active, a.compared)] == [
        x.name if x else None for x in (b.active, b.compared)
    ]
    assert [(m.kind, m.layer.name, m.vertices.tolist(), m.n_points) for m in a.measurements] == [
        (m.kind, m.layer.name, m.vertices.tolist(), m.n_points) for m in b.measurements
    ]


# -- the file ------------------------------------------------------------------------------------------


def test_what_is_saved_comes_back_bit_for_bit(document, tmp_path):
    path = saved(document, tmp_path / "a" / "all.vtksmooth", view={"overlay": "k"})
    again, restored = reopened(path)
    assert restored.notes == []
    assert restored.more == {"view": {"overlay": "k"}}
    assert_same_document(document, again)
    # Undo and redo work on, with the same states.
    document.redo()
    again.redo()
    assert_same_document(document, again)
    while document.history.can_undo:
        document.undo()
        again.undo()
        assert_same_document(document, again)
    # So does saving what was opened.
    again.go(3)
    document.go(3)
    second, _ = reopened(saved(again, tmp_path / "a" / "second.vtksmooth"))
    assert_same_document(document, second)


def test_undo_points_that_were_given_up_stay_so(document, tmp_path):
    document.set_memory_limit(0)
    assert document.history.first > 0
    again, _ = reopened(saved(document, tmp_path / "all.vtksmooth"))
    assert again.history.first == document.history.first
    assert_same_document(document, again)


def test_the_arrays_are_plain_and_those_of_unchanged_meshes_stay_in_their_files(document, tmp_path):
    path = saved(document, tmp_path / "all.vtksmooth")
    with np.load(path, allow_pickle=False) as archive:
        arrays = [archive[name] for name in archive.files if name.startswith("arrays/")]
    assert any(np.array_equal(array, document.active.state.points) for array in arrays)
    assert not any(np.array_equal(array, document.layers[1].state.points) for array in arrays)
    untouched = Document()
    opened(untouched, tmp_path / "a" / "part.vtp")
    with zipfile.ZipFile(saved(untouched, tmp_path / "small.vtksmooth")) as archive:
        assert archive.namelist() == ["session.json"]
        manifest = json.loads(archive.read("session.json"))
    assert manifest["states"][0]["file"]["relative"] == "a/part.vtp"


def test_a_mesh_that_was_overwritten_is_in_the_session(document, tmp_path):
    layer = document.active
    write_surface(layer.state.input(), layer.path)
    document.set_saved(layer, layer.state, layer.path)
    again, restored = reopened(saved(document, tmp_path / "all.vtksmooth"))
    assert restored.notes == []
    assert_same_document(document, again)


def test_moved_meshes_are_found_beside_the_session(document, tmp_path):
    saved(document, tmp_path / "a" / "all.vtksmooth")
    shutil.move(tmp_path / "a", tmp_path / "b")
    again, _ = reopened(tmp_path / "b" / "all.vtksmooth")
    assert [layer.path for layer in again.layers] == [tmp_path / "b" / n for n in ("part.vtp", "other.vtp")]
    assert_same_state(again.layers[1].state, document.layers[1].state)
    # The session alone: they are where they were.
    shutil.move(tmp_path / "b", tmp_path / "a")
    (tmp_path / "c" / "d").mkdir(parents=True)
    shutil.move(tmp_path / "a" / "all.vtksmooth", tmp_path / "c" / "d")
    assert session_reader.find(tmp_path / "c" / "d" / "all.vtksmooth").missing == []


def test_missing_meshes_are_named_located_or_left_out(document, tmp_path):
    path = saved(document, tmp_path / "a" / "all.vtksmooth")
    for name in ("part.vtp", "other.vtp"):
        shutil.move(tmp_path / "a" / name, tmp_path / f"moved {name}")
    missing = session_reader.find(path).missing
    assert missing == [tmp_path / "a" / "part.vtp", tmp_path / "a" / "other.vtp"]
    again, restored = reopened(path, {gone: tmp_path / f"moved {gone.name}" for gone in missing})
    assert restored.notes == []
    for ours, its in zip(document.layers, again.layers, strict=True):
        assert_same_points(ours.state, its.state)
    recipe = again.layers[0].state.recipe
    assert all(source in again.layers[0].state.sources or source == "original" for source in recipe.sources)
    # Without the space: it is left out. Without the part: its result is there, what it was made of is not.
    again, restored = reopened(path, dict.fromkeys(missing))
    assert [layer.name for layer in again.layers] == ["part"]
    assert "other" in restored.notes[0]
    assert_same_points(again.layers[0].state, document.layers[0].state)
    assert again.history.first > 0
    saved(again, tmp_path / "again.vtksmooth")


def assert_same_points(a, b):
    assert a.points.tobytes() == b.points.tobytes()


def test_a_mesh_that_has_changed_since_is_told(document, tmp_path):
    path = saved(document, tmp_path / "a" / "all.vtksmooth")
    part(tmp_path / "a", "other.vtp", 0.75)
    again, restored = reopened(path)
    assert "other.vtp has changed" in restored.notes[0]
    assert again.layers[1].state.points[0, 0] == 0.75
    assert_same_points(again.layers[0].state, document.layers[0].state)


def edited(path, edit):
    """Rewrite a session's JSON."""
    with zipfile.ZipFile(path) as archive:
        content = {name: archive.read(name) for name in archive.namelist()}
    manifest = json.loads(content["session.json"])
    edit(manifest)
    content["session.json"] = json.dumps(manifest).encode()
    with zipfile.ZipFile(path, "w") as archive:
        for name, data in content.items():
            archive.writestr(name, data)


def test_a_newer_session_opens_as_far_as_it_is_known_and_keeps_the_rest(document, tmp_path):
    path = saved(document, tmp_path / "all.vtksmooth")

    def newer(manifest):
        manifest |= {"version": 99, "vtksmooth": "7.5", "lights": [1, 2]}
        manifest["layers"][0]["material"] = "steel"
        manifest["states"][1]["weather"] = "fine"
        manifest["history"]["steps"][0]["author"] = "me"
        manifest["measurements"][0]["note"] = "wide"
        manifest["measurements"].append({"kind": "volume", "layer": 0, "vertices": "?", "n_points": 1})
        for state in manifest["states"]:
            for step in state["recipe"]:
                step["filter"] = "levitate"

    edited(path, newer)
    with zipfile.ZipFile(path, "a") as archive, archive.open("arrays/light.npy", "w") as file:
        np.save(file, np.arange(3))
    again, restored = reopened(path)
    assert "newer vtksmooth (7.5)" in restored.notes[0]
    for ours, its in zip(document.layers, again.layers, strict=True):
        assert_same_points(ours.state, its.state)
    saved(again, path)
    with zipfile.ZipFile(path) as archive:
        manifest = json.loads(archive.read("session.json"))
        assert np.array_equal(np.load(archive.open("arrays/light.npy")), np.arange(3))
    assert manifest["version"] == session.VERSION
    assert manifest["lights"] == [1, 2]
    assert manifest["layers"][0]["material"] == "steel"
    assert "fine" in [state.get("weather") for state in manifest["states"]]
    assert manifest["history"]["steps"][0]["author"] == "me"
    assert manifest["measurements"][0]["note"] == "wide"
    assert {step["filter"] for state in manifest["states"] for step in state["recipe"]} == {"levitate"}


def test_a_newer_session_that_cannot_be_understood_says_to_update(document, tmp_path):
    path = saved(document, tmp_path / "all.vtksmooth")

    def newer(manifest):
        manifest |= {"version": 2, "vtksmooth": "0.9", "layers": {"by": "name"}}

    edited(path, newer)
    with pytest.raises(session_reader.SessionError, match=r"newer vtksmooth \(0.9.*update vtksmooth"):
        reopened(path)


@pytest.mark.parametrize(
    "damage",
    [
        lambda manifest: manifest.pop("layers"),
        lambda manifest: manifest["history"].update(index=77),
        lambda manifest: manifest["states"][1].update(points="missing"),
        lambda manifest: manifest["states"][1].update(points=manifest["states"][1]["cells"]["Polys"][0]),
        lambda manifest: manifest["states"][1]["cells"]["Polys"].reverse(),
        lambda manifest: manifest["states"][1]["cells"].update(Polys=manifest["states"][1]["cells"]["Lines"]),
        lambda manifest: manifest["measurements"][0].update(n_points=2),
        lambda manifest: manifest["measurements"][0].update(kind="angle"),
        lambda manifest: manifest["layers"][0].update(state=99),
        lambda manifest: manifest["states"].__setitem__(0, None),
        # VTK ends the process where a text is none, or where there are too few.
        lambda manifest: manifest["states"][1]["point_data"].append({"name": "t", "text": [None] * 99}),
        lambda manifest: manifest["states"][1]["point_data"].append({"name": "t", "text": ["a"]}),
        lambda manifest: manifest["states"][1]["field_data"].append({"name": "t", "text": [{}]}),
        lambda manifest: manifest["states"][1]["field_data"].append({"name": None, "text": ["\ud800"]}),
    ],
)
def test_damage_is_one_sentence(document, tmp_path, damage):
    path = saved(document, tmp_path / "all.vtksmooth")
    edited(path, damage)
    with pytest.raises(session_reader.SessionError, match="damaged"):
        reopened(path)


def test_files_that_are_no_sessions_are_refused(document, tmp_path):
    path = saved(document, tmp_path / "all.vtksmooth")
    whole = path.read_bytes()
    for number, content in enumerate((b"", b"solid", whole[: len(whole) // 2], whole[100:200])):
        wrong = tmp_path / f"{number}.vtksmooth"
        wrong.write_bytes(content)
        with pytest.raises(session_reader.SessionError, match=r"no session|damaged"):
            reopened(wrong)
    with zipfile.ZipFile(tmp_path / "other.vtksmooth", "w") as archive:
        archive.writestr("session.json", '{"format": "another"}')
    with pytest.raises(session_reader.SessionError, match="no session"):
        reopened(tmp_path / "other.vtksmooth")
    with pytest.raises(session_reader.SessionError, match="check the path"):
        reopened(tmp_path / "nowhere.vtksmooth")


#: What may stand in a damaged JSON instead of anything.
WRONG = [
    None,
    -1,
    10**30,
    float("inf"),
    float("nan"),
    0.5,
    True,
    "",
    "\ud800",
    "a\0b",
    [],
    {},
    [[]],
    [None],
    99999,
]


def places(value, place=()):
    """Every place in a JSON, as keys from the outside in; of lists, the first two."""
    yield place
    inner = value if isinstance(value, dict) else range(min(2, len(value))) if isinstance(value, list) else ()
    for key in inner:
        yield from places(value[key], (*place, key))


def rewritten(path, damage):
    """Rewrite the files in a session; `damage` takes and gives name and content."""
    with zipfile.ZipFile(path) as archive:
        content = [damage(name, archive.read(name)) for name in archive.namelist()]
    with zipfile.ZipFile(path, "w") as archive:
        for name, data in content:
            archive.writestr(name, data)


def opens_or_says_why(path):
    said = None
    try:
        stored = session_reader.find(path)
        assert isinstance(stored.name, str)
        restored = session_reader.restore(stored, dict.fromkeys(stored.missing))
    except session_reader.SessionError as error:
        said = str(error)
    if said is not None:
        assert "\n" not in said
        return False
    document = Document()
    session_reader.apply(restored, document, WINDOWS)
    session.save(session.capture(document, restored.more, restored.drafts), path.with_name("again.vtksmooth"))
    return True


def test_whatever_stands_in_the_json_the_session_opens_or_it_is_said_why(document, tmp_path):
    path = saved(document, tmp_path / "all.vtksmooth")
    whole = path.read_bytes()
    with zipfile.ZipFile(path) as archive:
        manifest = json.loads(archive.read("session.json"))
    outcomes = []
    for number, place in enumerate([*places(manifest)][1:]):
        changed = inner = json.loads(json.dumps(manifest))
        for key in place[:-1]:
            inner = inner[key]
        if number % 4:
            inner[place[-1]] = WRONG[number % len(WRONG)]
        else:
            del inner[place[-1]]
        text = json.dumps(changed)
        path.write_bytes(whole)
        rewritten(path, lambda name, data, text=text: (name, text if name == "session.json" else data))
        outcomes.append(opens_or_says_why(path))
    assert len(outcomes) > 100
    assert {*outcomes} == {True, False}


def header(text, version=b"\x01\x00"):
    return b"\x93NUMPY" + version + len(text).to_bytes(2, "little") + text.encode()


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"\x93NUM",
        b"no array",
        header("{'descr': '<f8', 'fortran_order': False, 'shape': (1000000000000, 3), }\n"),
        header(f"{{'descr': '<f8', 'fortran_order': False, 'shape': ({10**30},), }}\n"),
        header("{'descr': '<f8', 'fortran_order': False, 'shape': (-3, 3), }\n"),
        header("{'descr': '<f8', 'fortran_order': False, 'shape': (3, 3), }\n"),
        header("{'descr': '<f8', 'fortran_order': False, 'shape': 'many', }\n"),
        header("{'descr': '|O', 'fortran_order': False, 'shape': (3,), }\n"),
        header("{'descr': 'of nothing', 'fortran_order': 0, 'shape': (), }\n"),
        header("{'descr': [('a', '<f8'), ('a', '<f8')], 'fortran_order': False, 'shape': (1,), }\n"),
        header("{'descr': ((((\n"),
        header("(" * 5000),
        header('"""'),
        header("\0" * 9),
        header("{}"),
        header("", b"\x09\x09"),
        b"\x93NUMPY\x02\x00\xff\xff\xff\x7f{}",
    ],
)
def test_whatever_stands_in_an_array_it_is_said_to_be_damaged(document, tmp_path, content):
    path = saved(document, tmp_path / "all.vtksmooth")
    rewritten(path, lambda name, data: (name, content if name.endswith(".npy") else data))
    assert not opens_or_says_why(path)


@pytest.mark.parametrize(
    "content",
    [
        b"[" * 100_000,
        b'{"a":' * 100_000,
        b"9" * 10_000,
        b"\xff\xfe{\0}\0",
        b"{",
        b"\0",
        b"null",
        b"{}",
        b'"' * 3,
    ],
)
def test_whatever_stands_instead_of_the_json_it_is_refused(document, tmp_path, content):
    path = saved(document, tmp_path / "all.vtksmooth")
    rewritten(path, lambda name, data: (name, content if name == "session.json" else data))
    assert not opens_or_says_why(path)


@pytest.mark.parametrize(
    "method", [zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA]
)
@pytest.mark.parametrize("damage", ["flags", "method", "content", "sizes", "half"])
def test_whatever_is_wrong_with_the_archive_it_is_said(document, tmp_path, method, damage):
    path = saved(document, tmp_path / "all.vtksmooth")
    with zipfile.ZipFile(path) as archive:
        content = {name: archive.read(name) for name in archive.namelist()}
    with zipfile.ZipFile(path, "w", method) as archive:
        for name, data in content.items():
            archive.writestr(name, data)
        infos = archive.infolist()
    data = bytearray(path.read_bytes())
    entry = data.rindex(b"PK\x01\x02", 0, data.rindex(b"session.json"))
    if damage == "flags":
        data[entry + 8] |= 1  # encrypted
    elif damage == "method":
        data[entry + 10] = 97
    elif damage == "content":
        start = infos[0].header_offset + 30 + len(infos[0].filename)
        data[start : start + infos[0].compress_size] = b"\xa5" * infos[0].compress_size
    elif damage == "sizes":
        data[entry + 20 : entry + 28] = b"\xff\xff\xff\x7f" * 2
    else:
        del data[len(data) // 2 :]
    path.write_bytes(data)
    opened = opens_or_says_why(path)
    assert not opened or damage == "sizes"  # which not all methods look at


def test_arrays_with_objects_are_refused(document, tmp_path):
    path = saved(document, tmp_path / "all.vtksmooth")
    with zipfile.ZipFile(path) as archive:
        name = json.loads(archive.read("session.json"))["states"][1]["points"]
        content = {each: archive.read(each) for each in archive.namelist()}
    with zipfile.ZipFile(path, "w") as archive:
        for each, data in content.items():
            if each != f"arrays/{name}.npy":
                archive.writestr(each, data)
        with archive.open(f"arrays/{name}.npy", "w") as file:
            np.lib.format.write_array(file, np.array([{"a": 1}]), allow_pickle=True)
    with pytest.raises(session_reader.SessionError, match="damaged"):
        reopened(path)


def test_a_failed_save_leaves_the_file_as_it_was(document, tmp_path):
    path = saved(document, tmp_path / "all.vtksmooth")
    before = path.read_bytes()

    def stop(fraction):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        session.save(session.capture(document, {}), path, stop)
    assert path.read_bytes() == before
    assert [file.name for file in tmp_path.iterdir() if file.is_file()] == ["all.vtksmooth"]
    with pytest.raises(MeshFileError, match="create it first"):
        saved(document, tmp_path / "nowhere" / "all.vtksmooth")


def test_a_folder_is_brought_up_to_date_by_what_has_changed(document, tmp_path):
    folder = tmp_path / "kept"
    folder.mkdir()
    session.update(session.capture(document, {}), folder)
    assert_same_document(document, reopened(folder)[0])
    times = {path.name: path.stat().st_mtime_ns for path in (folder / "arrays").iterdir()}
    apply(document, document.active, TrapeziumDrawing, iterations=1)
    session.update(session.capture(document, {}), folder)
    assert_same_document(document, reopened(folder)[0])
    now = {path.name: path.stat().st_mtime_ns for path in (folder / "arrays").iterdir()}
    shared = set(times) & set(now)
    assert shared
    assert {name: times[name] for name in shared} == {name: now[name] for name in shared}
    assert set(times) - set(now)  # what was undone is forgotten, in memory and here


def test_an_update_that_is_interrupted_loses_nothing(document, tmp_path):
    folder = tmp_path / "kept"
    folder.mkdir()
    session.update(session.capture(document, {}), folder)
    before, _ = reopened(folder)
    apply(document, document.active, TrapeziumDrawing, iterations=1)
    for stop_at in range(0, 200, 2):
        calls = iter(range(stop_at))

        def tell(fraction, calls=calls):
            if next(calls, None) is None:
                raise KeyboardInterrupt

        try:
            session.update(session.capture(document, {}), folder, tell)
        except KeyboardInterrupt:
            assert_same_document(before, reopened(folder)[0])
        else:
            break
    assert 0 < stop_at < 198
    assert_same_document(document, reopened(folder)[0])


# -- in the window -------------------------------------------------------------------------------------


def answer(user, given, asked=None):
    """Let the question about unsaved changes be answered."""

    def reply(names, save):
        from vtksmooth_gui.views.questions import Answer

        if asked is not None:
            asked.append(names)
        return Answer(given)

    user.application.sessions.ask_unsaved = reply


def write(user, path):
    user.application.sessions.write(path)
    user.wait()
    assert user.window.notification.level == "note", user.said


def test_everything_is_as_it_was(user, ant, tmp_path, open_window):
    user.drop(ant)
    user.apply(TrapeziumDrawing, iterations=3)
    user.apply(TrapeziumDrawing, iterations=1)
    user.do("undo")
    user.do("overlay_deviation")
    user.window.colour_bar.set_threshold(2, 2 * user.window.colour_bar.thresholds[2])
    user.do("split")
    user.do("unit_mm")
    user.do("bands")
    user.choose(TrapeziumDrawing, iterations=9)
    user.window.view.look_from((0.3, 0.4, 0.5), (0, 1, 0))
    user.window.view.camera.Zoom(2.0)
    user.window.histogram.set_brush((0.0, 1e-3))
    user.wait()
    assert user.window.windowTitle() == "ant * - vtksmooth"
    write(user, tmp_path / "study.vtksmooth")
    assert user.window.windowTitle() == "ant (study.vtksmooth) - vtksmooth"
    thresholds, camera = user.window.colour_bar.thresholds, user.window.view.camera
    user.application.settings.set("thresholds", {})
    again = open_window()
    again.do("dark")
    again.drop(ant)
    again.drop(tmp_path / "study.vtksmooth")
    assert again.said == "Opened study.vtksmooth."
    assert again.window.windowTitle() == "ant (study.vtksmooth) - vtksmooth"
    assert_same_document(user.document, again.document)
    assert again.display.overlay.id == "deviation"
    assert again.window.colour_bar.thresholds == thresholds
    assert again.window.view.mode == "split"
    assert again.window.action("split").isChecked()
    assert again.window.action("bands").isChecked()
    assert again.window.action("dark").isChecked()
    assert again.window.filters.values() == {"iterations": 9}
    assert again.display._brush == pytest.approx((0.0, 1e-3))
    for get in ("GetPosition", "GetFocalPoint", "GetViewUp", "GetViewAngle", "GetParallelScale"):
        assert getattr(again.window.view.camera, get)() == pytest.approx(getattr(camera, get)()), get
    again.do("redo")
    again.application.files._list_recent()
    assert again.window.recent.actions()[0].text().endswith("study.vtksmooth")
    assert again.window.windowTitle() == "ant * (study.vtksmooth) - vtksmooth"
    # A session and meshes: the meshes come to what the session holds.
    again.drop(ant, tmp_path / "study.vtksmooth")
    assert [layer.name for layer in again.document.layers] == ["ant", "ant 2"]


def test_unsaved_changes_are_asked_about_wherever_they_could_be_lost(user, ant, tmp_path):
    asked = []
    user.drop(ant)
    write(user, tmp_path / "empty.vtksmooth")
    user.apply(TrapeziumDrawing, iterations=1)
    answer(user, "cancel", asked)
    state = user.document.active.state
    user.do("close_layer")
    assert user.document.active.state is state
    user.drop(tmp_path / "empty.vtksmooth")
    assert user.document.active.state is state
    user.window.close()
    assert user.window.isVisible()
    assert asked == [["ant"], ["empty.vtksmooth"], ["empty.vtksmooth"]]
    answer(user, "discard")
    user.drop(tmp_path / "empty.vtksmooth")
    assert len(user.document.history.steps) == 1
    answer(user, "cancel", asked)
    user.window.close()
    assert not user.window.isVisible()
    assert len(asked) == 3


def test_save_on_closing_saves_first(user, ant, tmp_path):
    user.drop(ant)
    write(user, tmp_path / "study.vtksmooth")
    user.apply(TrapeziumDrawing, iterations=1)
    answer(user, "save")
    user.window.close()
    assert user.window.isVisible()
    user.qtbot.waitUntil(lambda: not user.window.isVisible(), timeout=20_000)
    again, _ = reopened(tmp_path / "study.vtksmooth")
    assert_same_document(user.document, again)


def test_save_on_closing_a_layer_writes_its_mesh(user, ant, tmp_path, monkeypatch):
    from PySide6.QtWidgets import QFileDialog

    shutil.copy(ant, tmp_path / "copy.ply")
    user.drop(tmp_path / "copy.ply")
    user.apply(TrapeziumDrawing, iterations=1)
    points = user.document.active.state.points.copy()
    answer(user, "save")
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda parent, title, start, kinds: (start, ""))
    user.do("close_layer")
    assert user.document.layers == []
    assert np.array_equal(read_surface(tmp_path / "copy_smoothed.ply")[0].points, points)


def test_a_missing_mesh_is_asked_for(user, ant, tmp_path):
    (tmp_path / "a").mkdir()
    for name in ("one.ply", "two.ply"):
        shutil.copy(ant, tmp_path / "a" / name)
    user.drop(tmp_path / "a" / "one.ply", tmp_path / "a" / "two.ply")
    path = tmp_path / "study.vtksmooth"
    write(user, path)
    shutil.move(tmp_path / "a", tmp_path / "b")
    asked = []

    def cancel(missing):
        raise InterruptedError

    user.application.sessions.ask_missing = cancel
    user.drop(path)
    assert len(user.document.layers) == 2

    def locate(missing):
        asked.append(missing.name)
        return tmp_path / "b" / missing.name

    user.application.sessions.ask_missing = locate
    user.drop(path)
    assert asked == ["one.ply"]  # the other one is beside it
    assert [layer.path for layer in user.document.layers] == [
        tmp_path / "b" / n for n in ("one.ply", "two.ply")
    ]
    user.application.sessions.ask_missing = lambda missing: None
    user.drop(path)
    assert user.document.layers == []
    assert "left out" in user.said


def test_a_session_that_cannot_be_opened_changes_nothing(user, ant, tmp_path):
    user.drop(ant)
    wrong = tmp_path / "wrong.vtksmooth"
    wrong.write_text("this is no session")
    user.drop(wrong)
    assert "wrong.vtksmooth" in user.said
    assert user.window.notification.level == "error"
    assert [layer.name for layer in user.document.layers] == ["ant"]


def kept_in(settings_file):
    place = settings_file.with_suffix(".state") / "autosave"
    return [folder for folder in place.glob("*") if (folder / "session.json").exists()]


def keep_now(user):
    with user.qtbot.waitSignal(user.application.sessions.kept, timeout=20_000):
        user.application.sessions._keep()


def test_what_is_not_saved_is_kept_until_it_is(user, ant, tmp_path, settings_file):
    user.drop(ant)
    user.qtbot.waitUntil(lambda: not user.application.sessions._timer.isActive(), timeout=20_000)
    assert kept_in(settings_file) == []  # there is nothing to lose
    user.apply(TrapeziumDrawing, iterations=1)
    with user.qtbot.waitSignal(user.application.sessions.kept, timeout=20_000):
        pass  # by itself
    assert len(kept_in(settings_file)) == 1
    write(user, tmp_path / "study.vtksmooth")
    user.qtbot.waitUntil(lambda: kept_in(settings_file) == [], timeout=20_000)
    user.do("undo")
    keep_now(user)
    user.window.close()
    assert kept_in(settings_file) == []


CRASH = """
import sys, time
from pathlib import Path
from vtksmooth_gui import start
from vtksmooth_gui.controllers.application import Application
from vtksmooth_gui.settings import Settings
from vtksmooth.filters import TrapeziumDrawing
qt = start.set_up()
application = Application(Settings(Path(sys.argv[1])))
application.window.show()
files, sessions = application.files, application.sessions

def opened():
    application.window.filters.choose(TrapeziumDrawing)
    application.window.filters.set_values({"iterations": 3})
    application.filtering.apply()

files.opened.connect(opened)
application.filtering.applied.connect(lambda: application.document.set_unit("mm"))
sessions.kept.connect(lambda: print("kept", flush=True))
files.open_paths([Path(sys.argv[2])])
qt.exec()
"""


@pytest.fixture
def crashed(ant, settings_file, open_window, qtbot):
    """An application that was killed with changes that it had not saved."""
    process = subprocess.Popen(
        [sys.executable, "-c", CRASH, str(settings_file), str(ant)], stdout=subprocess.PIPE, text=True
    )
    try:
        assert process.stdout.readline() == "kept\n"
        assert len(kept_in(settings_file)) == 1
        # A window that is there leaves it alone as long as its owner lives.
        user = open_window()
        user.application.sessions.ask_recovery = lambda name, when: pytest.fail("it is still at work")
        user.application.sessions.offer_recovery()
    finally:
        process.send_signal(signal.SIGKILL)
        process.wait()
        process.stdout.close()
    return user


def recover(user, given):
    """Answer what is asked when the next application starts; return what was asked about."""
    from vtksmooth_gui.views.questions import Answer

    asked = []

    def reply(name, when):
        asked.append(name)
        return Answer(given)

    user.application.sessions.ask_recovery = reply
    user.application.sessions.offer_recovery()
    return asked


def test_after_a_crash_everything_is_there_again(crashed, ant, settings_file, open_window):
    assert recover(crashed, "cancel") == ["ant"]
    assert len(kept_in(settings_file)) == 1  # later
    # Of two that crashed, one is recovered, the other waits for the next start.
    folder = kept_in(settings_file)[0]
    shutil.copytree(folder, folder.with_name("second"))
    assert recover(crashed, "save") == ["ant"]
    crashed.wait()
    expected = TrapeziumDrawing(iterations=3)(read_surface(ant)[0])
    points = vtk_to_numpy(expected.GetPoints().GetData())
    assert np.array_equal(crashed.document.active.state.points, points)
    assert crashed.document.unit == "mm"
    assert crashed.window.windowTitle() == "ant * - vtksmooth"
    assert len(crashed.document.history.steps) == 2
    # It is still not saved: a second crash would not lose it either.
    keep_now(crashed)
    assert len(kept_in(settings_file)) == 2
    crashed.do("undo")
    assert not crashed.document.active.unsaved
    crashed.do("redo")
    crashed.window.close()
    assert len(kept_in(settings_file)) == 1
    again = open_window()
    # What cannot be read is no reason to lose it: it waits for a version that can.
    (kept,) = kept_in(settings_file)
    text = (kept / "session.json").read_text()
    (kept / "session.json").write_text(text.replace('"states"', '"pieces"'))
    assert recover(again, "save") == ["ant"]
    again.wait()
    assert "damaged" in again.said
    assert kept_in(settings_file) == [kept]
    assert recover(again, "discard") == ["ant"]
    assert again.document.layers == []
    assert not list(Path(settings_file.with_suffix(".state"), "autosave").iterdir())
