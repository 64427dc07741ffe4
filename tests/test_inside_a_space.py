"""Every smoothing filter inside an installation space, which is an optional second input."""

import meshes
import numpy as np
import pytest
import pyvista as pv
from test_installation_space_smoothing import outside_and_crossing
from vtkmodules.vtkCommonDataModel import vtkMultiBlockDataSet

from vtksmooth import (
    EquilateralSmoothing,
    InstallationSpaceSmoothing,
    InvalidMeshError,
    LaplacianSmoothing,
    NullSpaceSmoothing,
    ParameterError,
    TrapeziumDrawing,
    samples,
)
from vtksmooth.cli import main
from vtksmooth.filters import FILTERS, SmoothingFilter
from vtksmooth.filters.laplacian_smoothing import SCHEMES
from vtksmooth.recipe import Recipe, Step

FREE = [cls for cls in FILTERS if issubclass(cls, SmoothingFilter) and cls is not InstallationSpaceSmoothing]

RUNS = [
    *((cls, {}) for cls in FREE),
    *((LaplacianSmoothing, {"scheme": name, "flow": "Flow"}) for name, row in SCHEMES.items() if row.flow),
    *(
        (LaplacianSmoothing, {"scheme": n, "implicit_step": 20.0})
        for n, row in SCHEMES.items()
        if row.implicit
    ),
    *((LaplacianSmoothing, {"scheme": name}) for name, row in SCHEMES.items() if not row.flow),
    (TrapeziumDrawing, {"gate": "none", "boundary": "sliding", "features": "slide"}),
    (EquilateralSmoothing, {"max_deviation_fraction": 0.01, "curvature_radius": 50.0}),
    (NullSpaceSmoothing, {"scheme": "trapezium-drawing", "gate": "none"}),
]


@pytest.fixture(scope="module")
def part():
    """A skin of cells as triangles, and the space that it fits in to rounding."""
    skin, space = samples.channel()
    return skin.triangulate(), space


@pytest.mark.parametrize(("cls", "parameters"), RUNS, ids=lambda it: getattr(it, "command", None))
@pytest.mark.parametrize("containment", ["vertices", "exact"])
def test_none_leaves(part, cls, parameters, containment):
    skin, space = part
    smoothing = cls(iterations=4, containment=containment, **parameters)
    result = pv.wrap(smoothing(skin, space))
    outside, crossing = outside_and_crossing(result, space)
    assert outside == 0
    assert crossing == 0 or containment == "vertices"
    assert smoothing.report.moved > 50
    assert smoothing.report.moves_checked > 100


def test_without_it_they_leave(part):
    skin, space = part
    left = {cls: outside_and_crossing(cls(iterations=4)(skin), space)[1] for cls in FREE}
    assert min(left.values()) > 0, left
    # And "none" is as good as no space, but for the origin that coordinates are relative to.
    loose = pv.wrap(TrapeziumDrawing(containment="none")(skin, space))
    np.testing.assert_allclose(loose.points, pv.wrap(TrapeziumDrawing()(skin)).points, atol=1e-5)


def test_all_faces_give_the_same(part, tmp_path, capsys):
    skin, space = part
    expected = pv.wrap(TrapeziumDrawing(iterations=3, containment="vertices")(skin, space)).points
    values = {"iterations": 3, "containment": "vertices"}
    np.testing.assert_array_equal(
        skin.vtksmooth.trapezium_drawing(installation=space, **values).points, expected
    )
    skin.save(tmp_path / "skin.vtp")
    space.save(tmp_path / "space.vtp")
    source, target, other = (str(tmp_path / name) for name in ("skin.vtp", "out.vtp", "space.vtp"))
    options = ["--iterations", "3", "--containment", "vertices", "--installation", other]
    assert main(["trapezium-drawing", source, target, *options]) == 0
    np.testing.assert_array_equal(pv.read(target).points, expected)
    pipeline = TrapeziumDrawing(**values)
    pipeline.SetInputData(0, skin)
    pipeline.SetInputData(1, space)
    pipeline.Update()
    np.testing.assert_array_equal(pv.wrap(pipeline.GetOutput()).points, expected)
    # Recipes: a role, of any name, or a file; none where it is not named.
    for role in ("installation", "box", tmp_path / "space.vtp"):
        recipe = Recipe([Step("trapezium-drawing", values, {"installation": role})])
        assert Recipe.from_json(recipe.to_json()) == recipe
        assert recipe.sources == [role]
        given = {} if role == tmp_path / "space.vtp" else {role: space}
        np.testing.assert_array_equal(pv.wrap(recipe.run(skin, given)).points, expected)
        (line,) = recipe.command_lines("skin.vtp", "out.vtp", dict.fromkeys(given, "space.vtp"))
        assert "space.vtp" in line.partition(" --installation=")[2]
        for script in (recipe.vtk_script, recipe.pyvista_script):
            text = script(source, target, dict.fromkeys(given, other))
            exec(compile(text.replace("sys.argv[1:]", "None"), "script", "exec"), {})
            np.testing.assert_array_equal(pv.read(target).points, expected)
    assert Recipe([Step("trapezium-drawing")]).sources == []


def test_a_space_is_that_of_one_call(part):
    skin, space = part
    smoothing = TrapeziumDrawing(iterations=2)
    inside, free = (pv.wrap(smoothing(*given)).points for given in ((skin, space), (skin,)))
    assert (inside != free).any()
    np.testing.assert_array_equal(free, pv.wrap(TrapeziumDrawing(iterations=2)(skin)).points)
    with pytest.raises(TypeError, match="takes 3 inputs: mesh, installation, source; installation may be"):
        smoothing(skin, space, skin, space)


@pytest.mark.parametrize("values", [{"containment": "vertices"}, {"tolerance_fraction": 0.1}])
def test_without_a_space_it_has_no_effect_and_is_refused(part, values):
    for cls in FREE:
        with pytest.raises(ParameterError, match="no effect with installation=None"):
            cls(**values)(part[0])


def test_polygons_contain_their_vertices_only():
    torus = meshes.torus(16, 10, "quads", jitter=0.25)
    low, high = torus.points.min(axis=0), torus.points.max(axis=0)
    space = meshes.polydata(meshes.cube(1).with_points(low + meshes.cube(1).points * (high - low)))
    with pytest.raises(InvalidMeshError, match=r"Exact containment needs triangles; triangulate .*vertices"):
        TrapeziumDrawing()(meshes.polydata(torus), space)
    smoothing = TrapeziumDrawing(containment="vertices", gate="none")
    result = pv.wrap(smoothing(meshes.polydata(torus), space))
    assert (result.points >= low - 1e-5).all()
    assert (result.points <= high + 1e-5).all()
    assert smoothing.report.moved > 50


def test_points_in_one_place_and_blocks_are_one_surface_inside(part):
    skin, space = part
    whole = pv.wrap(TrapeziumDrawing(iterations=3)(skin, space))
    cut = skin.cell_centers().points[:, 0] < 20
    blocks = vtkMultiBlockDataSet()
    for number, cells in enumerate((cut, ~cut)):
        blocks.SetBlock(number, skin.extract_cells(cells).extract_surface(algorithm="dataset_surface"))
    result = pv.wrap(TrapeziumDrawing(iterations=3)(blocks, space)).combine()
    result = result.extract_surface(algorithm="dataset_surface").clean(tolerance=0.0)
    assert result.n_points == whole.n_points
    assert outside_and_crossing(result, space) == (0, 0)


def test_what_is_flat_stays_with_a_curvature_radius_in_any_filter():
    skin, _ = samples.channel()
    bounded = pv.wrap(EquilateralSmoothing(curvature_radius="auto")(skin))
    free = pv.wrap(EquilateralSmoothing()(skin))
    stays = (bounded.points == skin.points).all(axis=1)
    assert (free.points == skin.points).all(axis=1).sum() < stays.sum() < skin.n_points


def test_far_away_moved_points_are_those_that_are_elsewhere_in_the_output():
    # So far that coordinates are multiples of 1/4096, and most steps of an almost regular sphere are less.
    sphere = meshes.icosphere(3)
    lattice = np.round(sphere.points * 4096.0) / 4096.0 + 2.0**40
    part = meshes.polydata(sphere.with_points(lattice))
    cube = meshes.cube(1, triangles=True)
    box = meshes.polydata(cube.with_points(2.0**40 - 2.0 + 4.0 * cube.points))
    smoothing = LaplacianSmoothing(iterations=1, relaxation_factor=0.01)
    result = pv.wrap(smoothing(part, box))
    moved = int((np.asarray(result.points) != lattice).any(axis=1).sum())
    assert smoothing.report.moved == moved
    assert moved < 0.8 * sphere.n_points
