"""Measuring in the window: picked by clicks, compared with geometry."""

import numpy as np
import pytest
import pyvista as pv

model = pytest.importorskip("vtksmooth_gui.model")
from vtksmooth.filters import InstallationSpaceSmoothing, LaplacianSmoothing, RegionMarking  # noqa: E402
from vtksmooth_gui.model.layer import Layer  # noqa: E402
from vtksmooth_gui.model.measure import Figure, Kind, Measurement  # noqa: E402
from vtksmooth_gui.model.section import Plane, outline  # noqa: E402
from vtksmooth_gui.model.selection import patch, points_of_faces  # noqa: E402
from vtksmooth_gui.model.state import State  # noqa: E402
from vtksmooth_gui.model.units import powered  # noqa: E402


def place(user, point):
    """Where a point of the world is in the view, as the mouse has it."""
    from PySide6.QtCore import QPoint

    user.window.view.render_now()
    renderer = user.window.view.first_renderer
    renderer.SetWorldPoint(*point, 1.0)
    renderer.WorldToDisplay()
    x, y, _ = renderer.GetDisplayPoint()
    ratio, widget = user.window.view.devicePixelRatioF(), user.window.view.plotter.interactor
    return QPoint(round(x / ratio), round(widget.height() - 1 - y / ratio))


def click(user, point):
    """Click on a point of the mesh, a little inwards of its outline."""
    from PySide6.QtCore import Qt

    at = place(user, 0.96 * np.asarray(point))
    user.qtbot.mouseClick(user.window.view.plotter.interactor, Qt.MouseButton.LeftButton, pos=at)
    user.wait()


def drag(user, start, end):
    """Drag from one point of the world to another."""
    from PySide6.QtCore import Qt

    widget = user.window.view.plotter.interactor
    a, b = place(user, start), place(user, end)
    user.qtbot.mouseMove(widget, a)
    user.qtbot.mousePress(widget, Qt.MouseButton.LeftButton, pos=a)
    for part in (0.3, 0.6, 1.0):
        user.qtbot.mouseMove(widget, a + (b - a) * part)
    user.qtbot.mouseRelease(widget, Qt.MouseButton.LeftButton, pos=b)
    user.wait()


def table(user):
    """The rows of the table of measurements."""
    widget = user.window.measurements.table
    return [[widget.item(row, column).text() for column in range(3)] for row in range(widget.rowCount())]


@pytest.fixture
def plane(tmp_path):
    mesh = pv.Plane(i_size=4, j_size=4, i_resolution=4, j_resolution=4)
    mesh.points[12, 2] = 0.5
    mesh.save(tmp_path / "plane.vtp")
    return tmp_path / "plane.vtp"


# -- the model -----------------------------------------------------------------------------------------


def radii(mesh, vertices):
    state = State(mesh)
    one = Measurement(Kind.RADIUS, Layer("a", state), np.asarray(vertices), state.n_points)
    return {figure.name: figure for figure in one.compute(state)}


def test_a_radius_is_that_of_sphere_and_cylinder():
    turn, z = np.meshgrid(np.linspace(0, 2 * np.pi, 32, endpoint=False), [0.0, 1.0, 2.0])
    tube = pv.PolyData(np.column_stack((3.0 * np.cos(turn.ravel()), 3.0 * np.sin(turn.ravel()), z.ravel())))
    found = radii(tube, np.arange(tube.n_points))
    assert found["radius of cylinder"].value == pytest.approx(3.0, rel=1e-6)
    assert found["radius of cylinder"].rms < 1e-6
    assert found["radius of sphere"].rms > 0.01
    found = radii(pv.Sphere(radius=2.5), np.arange(99))
    assert found["radius of sphere"].value == pytest.approx(2.5, rel=1e-6)


def test_in_a_mesh_with_other_points_there_is_nothing_to_measure():
    one, other = State(pv.Sphere()), State(pv.Cube())
    measured = Measurement(Kind.DISTANCE, Layer("a", one), np.array([0, 1]), one.n_points)
    assert len(measured.compute(one)) == 1
    assert measured.compute(other) == []
    # No sphere goes through a plane: then there is no such figure.
    assert radii(pv.Plane(), np.arange(50)) == {}


def test_angles_are_between_the_sides():
    points = np.array([[2.0, 0, 0], [0, 0, 0], [0, 3.0, 0], [-1, 1e-9, 0]])
    mesh = State(pv.PolyData(points, faces=[4, 0, 1, 2, 3]))
    for vertices, angle in (([0, 1, 2], 90.0), ([0, 1, 3], 180.0), ([2, 1, 3], 90.0), ([1, 0, 2], 56.309932)):
        (figure,) = Measurement(Kind.ANGLE, Layer("a", mesh), np.array(vertices), 4).compute(mesh)
        assert figure.value == pytest.approx(angle, abs=1e-6)
        assert figure.text("mm").endswith("°")
    assert Figure(Kind.DISTANCE, 2.0).text("mm") == "2 mm"


@pytest.mark.parametrize("polygons", [False, True])
def test_the_outline_of_a_cube_is_a_square(polygons):
    cube = pv.Cube(center=(1, 2, 3), x_length=2, y_length=2, z_length=2)
    mesh = State(cube if polygons else cube.triangulate().subdivide(2))
    for axis in np.eye(3):
        found = outline(mesh, Plane.of((1.1, 2.2, 3.3), axis))
        assert found.length == pytest.approx(8.0, rel=1e-6)
        spans = np.ptp(found.segments.reshape(-1, 2), axis=0)
        assert spans == pytest.approx([2.0, 2.0], rel=1e-6)
    # Across a diagonal, through the middle: a regular hexagon.
    found = outline(mesh, Plane.of((1, 2, 3), (1, 1, 1)))
    assert found.length == pytest.approx(6 * np.sqrt(2.0), rel=1e-6)
    corners = found.segments.reshape(-1, 2)
    reach = np.linalg.norm(corners - (corners.max(axis=0) + corners.min(axis=0)) / 2, axis=1)
    assert reach.max() == pytest.approx(np.sqrt(2.0), rel=1e-5)
    assert outline(mesh, Plane.of((9, 9, 9), (1, 1, 1))).segments.shape == (0, 2, 2)


def test_the_axes_of_a_section_are_those_of_the_model_where_they_can_be():
    assert Plane.of((0, 0, 0), (2, 0, 0)).names == ("y", "z")
    assert Plane.of((0, 0, 0), (0, 1, 0)).names == ("-x", "z")
    assert Plane.of((0, 0, 0), (0, 0, 3)).names == ("x", "y")
    assert Plane.of((0, 0, 0), (1, 1, 0)).names == ("right", "z")
    random = np.random.default_rng(0)
    for normal in random.normal(size=(20, 3)):
        frame = Plane.of((0, 0, 0), normal).frame
        np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-15)
        assert np.linalg.det(frame) == pytest.approx(1.0)
        assert frame[2] @ normal == pytest.approx(np.linalg.norm(normal))


def test_a_patch_ends_at_sharp_edges():
    state = State(pv.Cylinder(resolution=24, radius=1.0, height=3.0).triangulate().clean())
    normals = pv.wrap(state.mesh).compute_normals(point_normals=False)["Normals"]
    points = state.points
    for face, normal in enumerate(normals):
        found = points[patch(state, face, 40.0)]
        if abs(normal[0]) > 0.9:  # a cap
            assert np.ptp(found[:, 0]) == pytest.approx(0.0, abs=1e-6)
            assert len(found) == 24
        else:
            assert len(found) == 48
    assert len(patch(state, 0, 10.0)) == 4  # one facet of the side, of two triangles
    faces = np.array([3, 5])
    corners = state.surface.mesh.connectivity.reshape(-1, 3)
    assert points_of_faces(state, faces).tolist() == sorted(set(corners[faces].ravel().tolist()))


# -- in the window -------------------------------------------------------------------------------------


def test_a_distance_is_picked_by_two_clicks_and_followed(user, plane):
    user.drop(plane)
    user.do("view_pz")
    user.do("measure_distance")
    assert "first point" in user.window.measurements.hint.text()
    points = user.document.active.state.points.astype(float)
    click(user, points[0])
    assert "second point" in user.window.measurements.hint.text()
    click(user, points[12])
    expected = np.linalg.norm(points[12] - points[0])
    assert table(user) == [["1  distance, plane", f"{expected:.5g}", f"{expected:.5g}"]]
    assert user.document.measurements[0].vertices.tolist() == [0, 12]
    user.do("unit_mm")
    assert table(user)[0][2] == f"{expected:.5g} mm"
    labels = [label.GetInput() for label in user.application.measuring._marks.labels]
    assert labels == [f"{expected:.5g} mm"]
    # Smoothed, it is another one; before stays.
    user.apply(LaplacianSmoothing, iterations=5)
    points = user.document.active.state.points.astype(float)
    after = np.linalg.norm(points[12] - points[0])
    assert after < expected
    assert table(user) == [["1  distance, plane", f"{expected:.5g} mm", f"{after:.5g} mm"]]
    user.do("remove_measurements")
    assert table(user) == []
    assert user.application.measuring._marks.labels == []


def test_an_angle_is_picked_by_three_clicks_and_dragging_picks_nothing(user, plane):
    user.drop(plane)
    user.do("view_pz")
    user.do("measure_angle")
    points = user.document.active.state.points
    click(user, points[0])
    drag(user, points[10], points[13])  # turns the camera
    assert user.application.measuring._picked == [0]
    user.do("view_pz")
    click(user, points[4])
    click(user, points[14])
    assert table(user) == [["1  angle, plane", "90°", "90°"]]
    # The same again ends it: clicks pick nothing then.
    user.do("measure_angle")
    assert not user.window.action("measure_angle").isChecked()
    click(user, points[0])
    assert user.application.measuring._picked == []
    assert user.window.measurements.hint.isHidden()


def test_a_radius_is_picked_by_one_click(user, tmp_path):
    pv.Cylinder(resolution=32, radius=2.0, height=3.0).triangulate().clean().save(tmp_path / "tube.ply")
    user.drop(tmp_path / "tube.ply")
    user.do("view_pz")
    user.do("unit_in")
    user.do("measure_radius")
    click(user, (0.1, 0.1, 2.0))
    rows = {name: after for name, _, after in table(user)}
    assert rows["1  radius of cylinder, tube"].startswith("2 (± ")
    assert rows["1  radius of cylinder, tube"].endswith(" in")
    assert len(user.document.measurements[0].vertices) == 64


def test_the_radius_of_what_the_brush_selects(user, tmp_path):
    pv.Sphere(radius=2.0).save(tmp_path / "ball.ply")
    user.drop(tmp_path / "ball.ply")
    user.window.histogram.set_brush((0.0, 0.7))
    user.wait(lambda: user.display.selected is not None)
    expected = points_of_faces(user.document.active.state, user.display.selected)
    user.do("measure_radius")
    assert not user.window.action("measure_radius").isChecked()
    assert table(user)[0][2].startswith("2 (± ")
    assert np.array_equal(user.document.measurements[0].vertices, expected)


def test_nothing_cannot_be_measured(user, plane):
    user.drop(plane)
    user.application.measuring._add(Kind.RADIUS, [])
    assert "no points" in user.said
    assert user.document.measurements == []


def test_all_that_can_be_measured_is_offered_in_a_small_window(user, plane):
    from PySide6.QtWidgets import QToolBar

    user.window.resize(1280, 800)
    user.drop(plane)
    user.do("measure_distance")
    tools = user.window.measurements.findChild(QToolBar)
    for command in ("measure_distance", "measure_angle", "measure_radius", "remove_measurements"):
        assert tools.widgetForAction(user.window.action(command)).isVisible(), command
    assert tools.widgetForAction(user.window.menus["Measure > Unit"].menuAction()).isVisible()


def test_the_radius_of_fixed_points(user, tmp_path):
    pv.Sphere(radius=2.0).save(tmp_path / "ball.ply")
    user.drop(tmp_path / "ball.ply")
    user.do("fixed_radius")
    assert "Fix points first" in user.said
    user.apply(RegionMarking, fix="20-80")
    user.do("fixed_radius")
    assert user.document.measurements[0].vertices.tolist() == list(range(20, 81))
    assert table(user)[0][2].startswith("2 (± ")


def test_measuring_asks_before_it_is_lost(user, plane):
    user.drop(plane)
    user.do("view_pz")
    user.do("measure_distance")
    points = user.document.active.state.points
    click(user, points[0])
    click(user, points[24])
    asked = []
    user.application.sessions.ask_unsaved = lambda names, save: asked.append(names)
    user.window.close()
    assert asked == [["Measurements"]]
    assert user.window.isVisible()


def section(user):
    return user.window.section.outlines


def test_a_cross_section_shows_the_original_over_the_result(user, tmp_path):
    pv.Cube(x_length=2, y_length=2, z_length=4).triangulate().subdivide(3).clean().save(tmp_path / "cube.vtp")
    user.drop(tmp_path / "cube.vtp")
    user.do("section")
    assert user.document.plane.normal == (0.0, 0.0, 1.0)  # across its length
    assert section(user)[0] is None
    assert section(user)[1].length == pytest.approx(8.0, rel=1e-5)
    user.apply(LaplacianSmoothing, iterations=10)
    before, after = section(user)
    assert before.length == pytest.approx(8.0, rel=1e-5)
    assert after.length < 7.9
    plot = user.window.section.plot
    shown = {item.name(): item.getData()[0] for item in plot.listDataItems()}
    assert sorted(shown) == ["after", "before"]
    assert len(shown["before"]) == 2 * len(before.segments)
    user.do("unit_cm")
    assert plot.getAxis("bottom").labelText == "x [cm]"
    assert "before, 8 cm long" in user.window.section.lengths.text()
    # The slider goes from one end to the other.
    slider = user.window.section.slider
    slider.setValue(1000)
    user.wait()
    assert user.document.plane.origin[2] == pytest.approx(user.display.subject.state.bounds[5])
    slider.setValue(0)
    slider.setValue(300)
    user.wait()
    low, high = user.display.subject.state.bounds[4:]
    assert user.document.plane.origin[2] == pytest.approx(low + 0.3 * (high - low))
    user.do("section_x")
    assert plot.getAxis("bottom").labelText == "y [cm]"
    assert section(user)[0].length == pytest.approx(12.0, rel=1e-5)
    user.do("section")
    assert section(user) == (None, None)
    assert not user.application.measuring.handle.widget.GetEnabled()


def test_the_plane_is_dragged_in_the_view(user, tmp_path):
    pv.Sphere(radius=2.0).save(tmp_path / "ball.ply")
    user.drop(tmp_path / "ball.ply")
    user.do("section_z")
    view = user.window.view
    view.look_from((1.0, -0.2, 0.4), (0, 0, 1))
    user.do("frame")
    camera = view.camera.GetPosition()
    drag(user, (1.2, 1.2, 0.0), (1.2, 1.2, 0.8))
    assert view.camera.GetPosition() == camera
    height = user.document.plane.origin[2]
    assert 0.2 < height < 1.5
    assert user.document.plane.normal == pytest.approx((0.0, 0.0, 1.0))
    radius = np.sqrt(4.0 - height**2)
    assert section(user)[1].length == pytest.approx(2 * np.pi * radius, rel=0.02)
    assert user.window.section.slider.value() == pytest.approx(1000 * (height + 2.0) / 4.0, abs=5)


def test_the_unit_stands_wherever_a_length_does(user, plane):
    unit = "mm"
    user.drop(plane)
    user.apply(LaplacianSmoothing, iterations=2)
    assert "lengths in model units" in user.window.figures.text()
    user.do(f"unit_{unit}")
    assert user.document.unit == unit
    assert user.window.action(f"unit_{unit}").isChecked()
    assert f"lengths in {unit}" in user.window.figures.text()
    rows = {row.name: row.after for row in user.window.numbers.rows}
    assert {f"deviation, max [{unit}]", f"deviation back, max [{unit}]", f"swept volume [{unit}³]"} <= set(
        rows
    )
    assert "%" in rows["deviation, max, of the diagonal"]
    for overlay, shown in (("deviation", unit), ("mean_curvature", powered(unit, -1)), ("aspect_ratio", "")):
        user.do(f"overlay_{overlay}")
        label = user.window.histogram.plot.getAxis("bottom").labelText
        assert label.endswith(f"[{shown}]") if shown else "[" not in label
        assert user.window.colour_bar.title == label
    user.choose(InstallationSpaceSmoothing)
    suffixes = [
        row.editor.suffix() for row in user.window.filters.rows.values() if hasattr(row.editor, "suffix")
    ]
    assert " mm" in suffixes
    assert " model units" not in suffixes
