"""The model without a window: history, memory, selections."""

import sys
import threading
import weakref
from pathlib import Path

import numpy as np
import pytest
import pyvista as pv
from hypothesis import given
from hypothesis import strategies as st

model = pytest.importorskip("vtksmooth_gui.model")
from vtksmooth.errors import RecipeError  # noqa: E402
from vtksmooth.filters import LaplacianSmoothing, SurfaceComparison  # noqa: E402
from vtksmooth.recipe import ORIGINAL, Recipe  # noqa: E402
from vtksmooth.recipe import Step as RecipeStep  # noqa: E402
from vtksmooth_gui.model.document import Document  # noqa: E402
from vtksmooth_gui.model.draft import Draft  # noqa: E402
from vtksmooth_gui.model.field import Field  # noqa: E402
from vtksmooth_gui.model.layer import Role  # noqa: E402
from vtksmooth_gui.model.overlays import OVERLAYS, Subject, compute, share  # noqa: E402
from vtksmooth_gui.model.replay import Replay  # noqa: E402
from vtksmooth_gui.model.selection import face_points, faces_as_mesh  # noqa: E402
from vtksmooth_gui.model.state import State  # noqa: E402


def sphere(shift=0.0):
    mesh = pv.Sphere(theta_resolution=8, phi_resolution=8)
    mesh.points += np.float32(shift)
    return mesh


def smooth(document, layer, iterations=1):
    filter = LaplacianSmoothing(iterations=iterations)
    step, sources = document.step(layer, LaplacianSmoothing, {"iterations": iterations}, [])
    document.apply(layer, [filter(layer.state.input())], step, sources, f"{iterations}")
    return layer.state


@given(
    st.lists(st.sampled_from(["smooth", "undo", "redo", "open", "close", "jump"]), max_size=25), st.randoms()
)
def test_going_back_and_forth_gives_the_states_of_that_time(actions, random):
    document = Document()
    document.open(sphere(), Path("a.ply"))
    seen = {document.history.index: [(x, x.state) for x in document.layers]}
    for action in actions:
        if action == "smooth" and document.active is not None:
            smooth(document, document.active)
        elif action == "open":
            document.open(sphere(len(seen)), Path("b.ply"))
        elif action == "close" and document.active is not None:
            document.close(document.active)
        elif action == "undo":
            document.undo()
        elif action == "redo":
            document.redo()
        elif action == "jump":
            document.go(random.randint(0, len(document.history.steps)))
        index, now = document.history.index, [(x, x.state) for x in document.layers]
        if action in ("undo", "redo", "jump"):
            assert now == seen.get(index, now)
        else:
            seen = {i: state for i, state in seen.items() if i < index}
            seen[index] = now
        assert document.active is None or document.active in document.layers
        assert (document.active is None) == (not document.layers)


def test_a_state_shares_what_did_not_change():
    document = Document()
    layer = document.open(sphere(), Path("a.ply"))
    first = layer.state
    second = smooth(document, layer)
    assert second.mesh.GetPolys().GetConnectivityArray() is first.mesh.GetPolys().GetConnectivityArray()
    new = set(second.memory) - set(first.memory)
    # Points and their normals.
    assert sum(second.memory[array] for array in new) == 2 * first.n_points * 3 * 4
    # Neither what is shown nor what was opened counts for the history.
    assert document.history.memory == 0
    smooth(document, layer)
    assert document.history.memory == 2 * first.n_points * 3 * 4


def test_states_with_the_same_faces_share_them_here_too():
    document = Document()
    layer = document.open(sphere(), Path("a.ply"))
    first = layer.state
    second = State.of(LaplacianSmoothing()(first.input()), first)
    assert second.surface.mesh.connectivity is first.surface.mesh.connectivity
    assert np.array_equal(second.surface.mesh.points, second.points)
    other = State.of(sphere(), first)
    assert other.surface.mesh.connectivity is not first.surface.mesh.connectivity
    assert other.has_same_faces(first)


def test_the_memory_limit_gives_up_the_oldest_steps():
    document = Document()
    layer = document.open(sphere(), Path("a.ply"))
    step = 2 * layer.state.n_points * 3 * 4  # points and their normals
    document.set_memory_limit(2 * step)
    first = weakref.ref(smooth(document, layer, 1))
    for iterations in range(2, 7):
        smooth(document, layer, iterations)
        assert document.history.memory <= 2 * step
    assert first() is None
    # Of the states between the first and the last, two fit: those after the fourth and the fifth run.
    assert document.history.first == 5
    last = layer.state
    while document.history.can_undo:
        document.undo()
    assert document.history.index == document.history.first
    with pytest.raises(IndexError, match="from 5 to 7"):
        document.go(1)
    document.go(7)
    assert layer.state is last


def test_a_reference_with_the_same_points_is_what_before_means():
    document = Document()
    layer = document.open(sphere(), Path("a.ply"))
    other = document.open(sphere(1.0), Path("b.ply"))
    assert document.active is other  # what was opened last
    document.activate(layer)
    assert document.before is layer.opened
    document.set_role(other, Role.REFERENCE)
    assert document.before is other.state
    document.set_role(layer, Role.SPACE)
    assert document.space is layer


def test_states_share_fields_while_a_worker_computes_more():
    known = State.of(sphere())
    other = State.of(known.input())
    ended = threading.Event()

    def work():
        while not ended.is_set():
            for number in range(1000):
                known.fields["aspect-ratio", number] = known.summaries["quality", number] = None
            known.fields.clear()
            known.summaries.clear()

    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    worker = threading.Thread(target=work)
    worker.start()
    try:
        for _ in range(300):
            share(known, other)
    finally:
        ended.set()
        worker.join()
        sys.setswitchinterval(interval)
    assert other.fields


def test_names_of_layers_are_unique():
    document = Document()
    names = [document.open(sphere(), Path("a.ply")).name for _ in range(3)]
    assert names == ["a", "a 2", "a 3"]


# -- recipes -------------------------------------------------------------------------------------------


def compare(document, layer, with_state):
    return document.step(layer, SurfaceComparison, {}, [with_state])


def test_a_state_knows_the_recipe_that_made_it():
    document = Document()
    layer = document.open(sphere(), Path("a.ply"))
    made = [layer.state, smooth(document, layer, 1), smooth(document, layer, 2)]
    for count, state in enumerate(made):
        assert [step.parameters["iterations"] for step in state.recipe.steps] == [1, 2][:count]
        assert np.array_equal(pv.wrap(state.recipe.run(layer.opened.mesh)).points, state.points)
    document.undo()
    assert layer.state.recipe is made[1].recipe


def test_further_inputs_have_names_that_mean_one_mesh():
    document = Document()
    layer = document.open(sphere(), Path("a.ply"))
    other = document.open(sphere(1.0), Path("b.ply"))
    smooth(document, layer)
    step, sources = compare(document, layer, layer.opened)
    assert (step.inputs["original"], sources) == (ORIGINAL, {})
    step, sources = compare(document, layer, other.state)
    assert (step.inputs["original"], sources) == (
        Path("b.ply").absolute(),
        {Path("b.ply").absolute(): other.opened},
    )
    # What was changed is no file any more, and what was changed once more is another mesh.
    for role in ("b", "b 2"):
        smooth(document, other)
        step, sources = compare(document, layer, other.state)
        assert (step.inputs["original"], sources) == (role, {role: other.state})
        document.apply(layer, [layer.state.mesh], step, sources, "compared")
    assert list(layer.state.sources) == ["b", "b 2"]
    named = document.open(sphere(2.0), Path("original.ply"))
    smooth(document, named)
    assert compare(document, layer, named.state)[0].inputs["original"] == "original 2"


EDITS = [
    ("switched", 0, False), ("switched", 1, False), ("switched", 2, False), ("moved", 0, 2), ("moved", 2, 1),
    ("removed", 0), ("removed", 2), ("changed", 1), ("changed", 2), ("added",),
]  # fmt: skip


def edit(recipe, kind, *arguments):
    if kind == "changed":
        return recipe.changed(*arguments, iterations=7)
    if kind == "added":
        return recipe.added(RecipeStep("laplacian", {"iterations": 4}))
    return getattr(recipe, kind)(*arguments)


@pytest.mark.parametrize("change", EDITS, ids=lambda change: " ".join(map(str, change)))
def test_running_again_begins_where_nothing_has_changed(change):
    document = Document()
    layer = document.open(sphere(), Path("a.ply"))
    for iterations in (1, 2, 3):
        smooth(document, layer, iterations)
    wanted = edit(layer.state.recipe, *change)
    first, begin = document.reached(layer, wanted, {})
    shared = wanted.first_difference(layer.state.recipe)
    assert first == min(shared, len(wanted))
    mesh = begin.mesh
    for result in wanted.results(layer.opened.mesh, start=first, current=begin.mesh):
        mesh = result.mesh
    assert np.array_equal(pv.wrap(mesh).points, pv.wrap(wanted.run(layer.opened.mesh)).points)


def replay(document, layer, recipe):
    made = Replay(document, layer, recipe, {})
    made.run(LaplacianSmoothing.__call__, lambda filter: f"{filter.iterations}")
    document.replay(layer, made.states, "")
    return made.todo


def test_what_a_step_did_goes_with_it():
    document = Document()
    layer = document.open(sphere(), Path("a.ply"))
    recipe = Recipe([RecipeStep("laplacian", {"iterations": i}) for i in (1, 2)])
    assert replay(document, layer, recipe) == [0, 1]
    assert layer.state.did == ("1", "2")
    off = RecipeStep("laplacian", {"iterations": 3}, enabled=False)
    assert replay(document, layer, recipe.added(off, 0)) == []
    assert layer.state.did == ("", "1", "2")
    assert replay(document, layer, recipe.added(off, 0).changed(2, iterations=4)) == [2]
    assert layer.state.did == ("", "1", "4")


@given(st.data())
def test_whatever_is_done_a_state_is_what_its_recipe_makes(data):
    document = Document()
    layer = document.open(sphere(), Path("a.ply"))
    draft = Draft(document)
    document.set_memory_limit(data.draw(st.sampled_from([0, 3, 100])) * layer.opened.n_points * 12)
    for _ in range(data.draw(st.integers(1, 8))):
        action = data.draw(st.sampled_from(["smooth", "edit", "edit", "run", "run", "undo", "redo"]))
        count = len(draft.recipe)
        if action == "smooth":
            smooth(document, layer, data.draw(st.integers(1, 3)))
        elif action == "edit":
            kinds = [("added",), *(one for one in EDITS if len(one) > 1 and max(one[1:]) < count)]
            draft.set(edit(draft.recipe, *data.draw(st.sampled_from(kinds))))
        elif action == "run":
            replay(document, layer, draft.recipe)
            draft.drop(layer)
        elif action == "undo":
            document.undo()
        else:
            document.redo()
        state = layer.state
        if state is None:
            document.redo()
            continue
        assert np.array_equal(state.points, pv.wrap(state.recipe.run(layer.opened.mesh)).points)
        for step, did in zip(state.recipe.steps, state.did, strict=True):
            assert did in ("", f"{step.make().iterations}")
            assert not did or step.enabled


def test_other_meshes_are_other_results():
    document = Document()
    layer = document.open(sphere(), Path("a.ply"))
    others = [document.open(sphere(shift), Path("b.ply")) for shift in (1.0, 2.0)]
    recipe = Recipe([RecipeStep("compare", {}, {"original": "b"}), RecipeStep("laplacian")])
    state = State(sphere(), recipe=recipe, sources={"b": others[0].state})
    document.replay(layer, [state], "")
    assert document.reached(layer, recipe, {"b": others[0].state}) == (2, state)
    assert document.reached(layer, recipe, {"b": others[1].state}) == (0, layer.opened)
    assert document.reached(layer, recipe, {}) == (0, layer.opened)


def test_what_only_measures_is_nothing_to_begin_at():
    document = Document()
    layer = document.open(sphere(), Path("a.ply"))
    recipe = Recipe([RecipeStep("laplacian"), RecipeStep("quality")])
    smoothed = State(sphere(), recipe=Recipe(recipe.steps[:1]))
    document.replay(layer, [smoothed, State(sphere(), recipe=recipe)], "")
    assert document.reached(layer, recipe, {}) == (1, smoothed)


def test_edits_stay_with_their_layer_until_they_are_dropped():
    document = Document()
    draft = Draft(document)
    assert (len(draft.recipe), draft.edited) == (0, False)
    layer = document.open(sphere(), Path("a.ply"))
    other = document.open(sphere(), Path("b.ply"))
    document.activate(layer)
    smooth(document, layer)
    draft.set(draft.recipe.changed(0, iterations=5))
    assert (draft.edited, draft.first_to_run) == (True, 0)
    document.activate(other)
    assert (len(draft.recipe), draft.edited) == (0, False)
    document.activate(layer)
    smooth(document, layer, 2)
    assert draft.recipe.steps[0].parameters["iterations"] == 5
    draft.set(layer.state.recipe)
    assert not draft.edited
    draft.set(draft.recipe.removed(0))
    draft.drop(layer)
    assert draft.recipe is layer.state.recipe


def test_roles_are_found_among_the_layers():
    document = Document()
    draft = Draft(document)
    document.open(sphere(), Path("a.ply"))
    draft.set(Recipe([RecipeStep("containment")]))
    with pytest.raises(RecipeError, match="role 'installation'"):
        draft.meshes()
    space = document.open(sphere(), Path("b.ply"))
    document.set_role(space, Role.SPACE)
    assert draft.meshes() == {"installation": space.state}
    by_name = Recipe([RecipeStep("compare", {}, {"original": "b"})])
    assert draft.meshes(by_name) == {"b": space.state}
    by_file = Recipe([RecipeStep("compare", {}, {"original": Path("b.ply").absolute()})])
    assert draft.meshes(by_file) == {Path("b.ply").absolute(): space.opened}
    elsewhere = Recipe([RecipeStep("compare", {}, {"original": Path("c.ply")})])
    assert draft.meshes(elsewhere) == {}
    assert [source for _, source, _ in draft.offers()][:2] == [ORIGINAL, Path("b.ply").absolute()]


@pytest.mark.parametrize("kind", ["triangles", "mixed"])
def test_faces_as_a_mesh_have_the_same_corners(kind):
    faces = [3, 0, 1, 2, 5, 0, 2, 3, 4, 5, 4, 5, 6, 7, 8, 3, 1, 2, 8]
    points = np.random.default_rng(0).normal(size=(9, 3))
    mesh = sphere() if kind == "triangles" else pv.PolyData(points, faces=faces)
    state = State(mesh)
    faces = np.array([3, 0, 2])
    found = pv.wrap(faces_as_mesh(state, faces))
    for number, face in enumerate(faces):
        assert np.array_equal(found.get_cell(number).points, mesh.get_cell(face).points)
        assert np.allclose(face_points(state, face), mesh.get_cell(face).points)
    assert faces_as_mesh(state, np.empty(0, int)).GetNumberOfCells() == 0


@given(
    st.lists(st.floats(-1, 1) | st.just(float("nan")), min_size=1, max_size=40),
    st.booleans(),
    st.floats(-1, 1),
)
def test_fields_find_what_a_plain_loop_finds(values, low_is_bad, low):
    values = np.array(values)
    points = np.zeros((len(values) + 2, 3))
    points[:, 0] = np.arange(len(points))
    mesh = pv.PolyData(points, faces=np.array([[3, i, i + 1, i + 2] for i in range(len(values))]).ravel())
    surface = State(mesh).surface
    field = Field(values, False, surface, low_is_bad)
    key = lambda i: (np.isnan(values[i]), values[i] if low_is_bad else -values[i], i)  # noqa: E731
    order = sorted((i for i in range(len(values))), key=key)
    real = [i for i in order if not np.isnan(values[i])]
    assert field.worst.tolist()[: len(real)] == real
    assert field.faces_between(low, 0.5).tolist() == [i for i, v in enumerate(values) if low <= v <= 0.5]
    assert field.histogram(np.array([-1.0, 0.0, 1.0])).sum() == pytest.approx(100.0 if real else 0.0)
    at_points = np.arange(float(len(points)))
    field = Field(at_points, True, surface, low_is_bad)
    expected = [
        min(c) if low_is_bad else max(c) for c in zip(at_points, at_points[1:], at_points[2:], strict=False)
    ]
    assert field.of_faces.tolist() == expected
    assert field.faces_between(1.0, 1.0).tolist() == [i for i in range(len(values)) if i <= 1]


@pytest.mark.parametrize("one", [one for one in OVERLAYS if one.source == "usual-measures"])
def test_usual_measures_are_overlays_with_thresholds(one):
    def run(algorithm, *meshes):
        algorithm(*meshes)
        return algorithm

    sliver = pv.PolyData(
        [[0.0, 0, 0], [1, 0, 0], [0.5, 0.75**0.5, 0], [0.02, -0.002, 0]], [3, 0, 1, 2, 3, 1, 0, 3]
    )
    state = State(sliver)
    field = compute(one, Subject(state), run)
    good, warning, bad = one.default_thresholds(Subject(state), field)
    assert (good > warning > bad) == one.low_is_bad
    assert field.faces_beyond(bad).tolist() == field.worst[:1].tolist() == [1]
    assert not one.low_is_bad or field.values[0] >= good
