"""Nothing changes or vanishes without being asked, by mouse and keys."""

import shutil

import numpy as np
import pytest

from vtksmooth.files import read_surface, write_surface
from vtksmooth.filters import LaplacianSmoothing, SelfIntersection, SurfaceQuality, TrapeziumDrawing

VALUES = ("value", "currentText")


def value_of(widget):
    return next(getattr(widget, name)() for name in VALUES if hasattr(widget, name))


def fields(widget):
    """All boxes and sliders that can be seen, with the middle of the part that is not scrolled away."""
    from PySide6.QtWidgets import QAbstractSlider, QAbstractSpinBox, QComboBox, QScrollBar

    for cls in (QAbstractSpinBox, QComboBox, QAbstractSlider):
        for one in widget.findChildren(cls):
            seen = one.visibleRegion().boundingRect()
            if not isinstance(one, QScrollBar) and one.isVisible() and one.isEnabled() and seen.isValid():
                yield one, seen.center()


def turn_wheel(user, widget, at, steps=-1):
    """Turn the wheel, as the window system says it."""
    from PySide6.QtCore import QPoint
    from PySide6.QtTest import QTest

    window = widget.window()
    place = widget.mapTo(window, at)
    QTest.wheelEvent(window.windowHandle(), place, QPoint(0, 120 * steps))
    user.qtbot.wait(1)


# -- the wheel -----------------------------------------------------------------------------------------


def test_the_wheel_changes_only_the_field_with_the_focus(user, ant):
    from PySide6.QtCore import Qt

    user.drop(ant)
    user.choose(LaplacianSmoothing, iterations=10)
    for section in user.window.filters.form.sections.values():
        section.setChecked(True)
    with user.qtbot.waitActive(user.window):
        user.window.activateWindow()
    user.window.view.setFocus()
    seen = set()
    bar = user.window.filters.form.verticalScrollBar()
    for panel in ("Regions", "Cross-section", "Layers and filter"):
        user.window.show_panel(panel)
        for place in range(0, bar.maximum() + 1, 200):
            bar.setValue(place)
            user.wait()
            for one, at in list(fields(user.window)):
                bar.setValue(place)
                before = value_of(one)
                for steps in (-1, 1, 1, -1):
                    turn_wheel(user, one, at, steps)
                    assert value_of(one) == before, (one, panel)
                assert not one.hasFocus()
                seen.add(type(one).__name__)
    assert seen >= {"QSpinBox", "NumberBox", "QComboBox", "QSlider"}
    # Over a field the form scrolls; and with the focus the field takes the wheel.
    row = user.window.filters.rows["iterations"].editor
    user.window.filters.form.ensureWidgetVisible(row)
    user.wait()
    start = bar.value()
    turn_wheel(user, row, row.rect().center())
    assert bar.value() > start
    bar.setValue(start)
    user.qtbot.mouseClick(row.lineEdit(), Qt.MouseButton.LeftButton)
    assert row.hasFocus()
    turn_wheel(user, row, row.rect().center(), 1)
    assert row.value() == 11


# -- saving --------------------------------------------------------------------------------------------


def answer_next(user, find, then):
    """Act on the next dialog as soon as it is open."""
    from PySide6.QtCore import QTimer
    from PySide6.QtWidgets import QApplication

    def look():
        dialog = QApplication.activeModalWidget()
        if isinstance(dialog, find):
            timer.stop()
            then(dialog)

    timer = QTimer(user.window, interval=20)
    timer.timeout.connect(look)
    timer.start()
    return timer


def press_button(user, words):
    from PySide6.QtCore import Qt

    def press(box):
        button = next(one for one in box.buttons() if one.text().replace("&", "") == words)
        user.qtbot.mouseClick(button, Qt.MouseButton.LeftButton)

    return press


@pytest.fixture
def qt_dialogs():
    from PySide6.QtCore import Qt
    from PySide6.QtWidgets import QApplication

    QApplication.setAttribute(Qt.ApplicationAttribute.AA_DontUseNativeDialogs)
    yield
    QApplication.setAttribute(Qt.ApplicationAttribute.AA_DontUseNativeDialogs, False)


def test_the_first_save_asks_and_leaves_the_source_alone(user, qt_dialogs, ant, tmp_path):
    from PySide6.QtCore import Qt
    from PySide6.QtWidgets import QApplication, QFileDialog, QLineEdit, QMessageBox

    source = tmp_path / "part.ply"
    shutil.copy(ant, source)
    original = source.read_bytes()
    user.drop(source)
    user.apply(TrapeziumDrawing, iterations=2)
    suggested = []

    def accept(dialog, name=""):
        field = dialog.findChild(QLineEdit)
        suggested.append(field.text())
        if name:
            field.setText(name)
        user.qtbot.keyClick(field, Qt.Key.Key_Return)

    answer_next(user, QFileDialog, accept)
    user.press(Qt.Key.Key_S, Qt.KeyboardModifier.ControlModifier)
    user.wait(lambda: not user.document.active.unsaved)
    assert suggested == ["part_smoothed.ply"]
    assert source.read_bytes() == original
    saved = tmp_path / "part_smoothed.ply"
    assert np.array_equal(read_surface(saved)[0].points, user.document.active.state.points)
    # Recipe and script go on naming what was opened.
    user.do("copy_script")
    script = QApplication.clipboard().text()
    assert str(source) in script
    assert str(saved) not in script
    # From now on Save knows where to.
    user.apply(TrapeziumDrawing, iterations=1)
    user.press(Qt.Key.Key_S, Qt.KeyboardModifier.ControlModifier)
    user.wait(lambda: not user.document.active.unsaved)
    assert np.array_equal(read_surface(saved)[0].points, user.document.active.state.points)
    # The source is written over if its name is chosen and the question is answered with yes.
    for words, same in (("No", True), ("Yes", False)):

        def choose(dialog, words=words):
            answer_next(user, QMessageBox, press_button(user, words))
            accept(dialog, str(source))
            if words == "No":
                dialog.reject()

        answer_next(user, QFileDialog, choose)
        user.do("save_as")
        assert (source.read_bytes() == original) is same


def test_what_a_format_drops_is_said_before(user, ant, tmp_path):
    from PySide6.QtWidgets import QMessageBox

    mesh = read_surface(ant)[0]
    mesh.points_to_double()
    mesh["Weight"] = np.arange(mesh.n_points, dtype=float)
    write_surface(mesh, tmp_path / "part.vtp")
    user.drop(tmp_path / "part.vtp")
    path, asked = tmp_path / "part.stl", []

    def read(box):
        asked.append(box.informativeText())
        press_button(user, answers.pop(0))(box)

    answers = ["Cancel", "Save Anyway"]
    for there in (False, True):
        answer_next(user, QMessageBox, read)
        user.application.files.write(user.document.active, path)
        user.wait(lambda there=there: len(asked) == 1 + there)
        assert path.exists() is there
    assert "STL does not keep the arrays Weight." in asked[0]
    assert "single precision" in asked[0]
    assert user.document.active.path == path
    user.do("save")  # what was accepted is not asked again
    assert len(asked) == 2
    assert not list(tmp_path.glob(".*"))


# -- layers --------------------------------------------------------------------------------------------


def click_layer(user, row, dx=60, button="LeftButton"):
    from PySide6.QtCore import QPoint, Qt

    tree = user.window.layers
    box = tree.visualItemRect(tree.topLevelItem(row))
    place = QPoint(box.left() + dx, box.center().y())
    user.qtbot.mouseClick(tree.viewport(), getattr(Qt.MouseButton, button), pos=place)
    user.wait()


@pytest.fixture
def three(user, ant, tmp_path):
    """Three layers, the last an installation space."""
    from vtksmooth_gui.model.layer import Role

    for name in ("one", "two", "space"):
        shutil.copy(ant, tmp_path / f"{name}.ply")
    user.drop(*(tmp_path / f"{name}.ply" for name in ("one", "two", "space")))
    user.document.set_role(user.document.layers[2], Role.SPACE)
    user.wait()
    with user.qtbot.waitActive(user.window):
        user.window.activateWindow()
    return user


def test_the_highlighted_layer_is_the_one_that_is_worked_on_and_closed(three):
    from PySide6.QtCore import Qt

    def highlighted():
        item = three.window.layers.currentItem()
        assert item.isSelected()
        assert item.font(0).bold()
        return item.text(0)

    assert highlighted() == three.document.active.name == "one"
    for row, name in ((2, "space"), (1, "two")):
        click_layer(three, row)
        assert highlighted() == three.document.active.name == name
    three.qtbot.keyClick(three.window.layers, Qt.Key.Key_Down)
    three.wait()
    assert highlighted() == three.document.active.name == "space"
    three.do("close_layer")
    assert [layer.name for layer in three.document.layers] == ["one", "two"]
    assert highlighted() == three.document.active.name
    click_layer(three, 1)
    three.window.layers.setFocus()
    three.qtbot.keyClick(three.window.layers, Qt.Key.Key_Delete)
    three.wait()
    assert [layer.name for layer in three.document.layers] == ["one"]
    three.do("undo")
    assert [layer.name for layer in three.document.layers] == ["one", "two"]


def test_the_tick_hides_a_layer_and_works_on_no_other(three):
    click_layer(three, 2, dx=8)
    assert not three.document.layers[2].visible
    assert three.document.active.name == "one"
    click_layer(three, 2, dx=8)
    assert three.document.layers[2].visible


def test_layers_have_a_context_menu(three):
    from PySide6.QtCore import Qt, QTimer
    from PySide6.QtGui import QContextMenuEvent
    from PySide6.QtWidgets import QApplication

    click_layer(three, 1, button="RightButton")
    tree, found = three.window.layers, []

    def choose():
        menu = QApplication.activePopupWidget()
        found.extend(action.text() for action in menu.actions())
        three.qtbot.mouseClick(
            menu, Qt.MouseButton.LeftButton, pos=menu.actionGeometry(menu.actions()[-1]).center()
        )

    QTimer.singleShot(100, choose)
    at = tree.visualItemRect(tree.topLevelItem(1)).center()
    event = QContextMenuEvent(QContextMenuEvent.Reason.Mouse, at, tree.viewport().mapToGlobal(at))
    QApplication.sendEvent(tree.viewport(), event)
    three.wait(lambda: bool(found))
    assert found == ["Frame", "Save As…", "Close Layer"]
    assert [layer.name for layer in three.document.layers] == ["one", "space"]


# -- the history ---------------------------------------------------------------------------------------


def undo(user):
    from PySide6.QtCore import Qt

    user.press(Qt.Key.Key_Z, Qt.KeyboardModifier.ControlModifier)
    user.wait()


def redo(user):
    from PySide6.QtCore import Qt

    user.press(Qt.Key.Key_Z, Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.ShiftModifier)
    user.wait()


@pytest.mark.parametrize("check", [SurfaceQuality, SelfIntersection], ids=lambda cls: cls.command)
def test_a_check_leaves_what_was_undone(user, ant, check):
    user.drop(ant)
    layer = user.document.active
    opened = layer.state
    user.apply(TrapeziumDrawing, iterations=1)
    first = layer.state
    user.apply(TrapeziumDrawing, iterations=2)
    second = layer.state
    undo(user)
    undo(user)
    user.apply(check)
    checked = layer.state
    assert checked.shares_geometry(opened)
    assert user.window.history.list.count() == 5
    for state in (first, second):
        redo(user)
        assert layer.state is state
    assert not user.window.action("redo").isEnabled()
    for state in (first, checked, opened):
        undo(user)
        assert layer.state is state
    # What changes the mesh ends what was undone, as ever.
    redo(user)
    user.apply(TrapeziumDrawing, iterations=3)
    assert not user.window.action("redo").isEnabled()


def test_roles_are_undone_and_leave_what_was_undone(user, ant):
    from PySide6.QtCore import Qt

    from vtksmooth_gui.model.layer import Role

    user.drop(ant)
    user.apply(TrapeziumDrawing, iterations=1)
    layer, smoothed = user.document.active, user.document.active.state
    undo(user)
    tree = user.window.layers
    box = tree.itemWidget(tree.topLevelItem(0), 1)
    box.setFocus()
    user.qtbot.keyClick(box, Qt.Key.Key_Down)
    user.wait()
    assert layer.role is Role.REFERENCE
    assert user.window.history.list.currentItem().text() == "ant: reference"
    undo(user)
    assert layer.role is Role.MESH
    assert box.currentText() == "mesh"
    redo(user)
    assert layer.role is Role.REFERENCE
    redo(user)
    assert layer.state is smoothed


def test_undo_says_when_it_closes_a_mesh(user, ant):
    user.drop(ant)
    undo(user)
    assert user.document.layers == []
    assert user.said == "Closed ant; Redo opens it again."
    redo(user)
    assert [layer.name for layer in user.document.layers] == ["ant"]
    user.do("close_layer")
    undo(user)
    redo(user)
    assert user.said == "Closed ant; Undo opens it again."


# -- what is said --------------------------------------------------------------------------------------


def test_what_is_said_belongs_to_the_mesh_and_the_overlay_on_the_screen(three, tmp_path):
    from PySide6.QtCore import QPoint, Qt

    window = three.window
    view = window.view.plotter.interactor

    def point():
        for attempt in range(20):  # a move to where the pointer is already is none
            three.qtbot.mouseMove(view, view.rect().center() + QPoint(attempt % 2, 0))
            three.qtbot.wait(300)
            if window.probe.text() != " ":
                break
        assert "face " in window.probe.text()

    three.do("frame")
    point()
    click_layer(three, 1)
    assert window.probe.text() == " "
    point()
    three.press(Qt.Key.Key_0)
    assert window.probe.text() == " "
    # The reason why an overlay is not shown goes with the overlay.
    three.document.close(three.document.layers[2])
    three.do("overlay_signed_distance")
    assert "installation space" in three.said
    three.press(Qt.Key.Key_1)
    three.wait()
    assert three.said == ""
    # What a filter did goes with the mesh that it made.
    three.apply(TrapeziumDrawing, iterations=1)
    assert three.said.startswith("Trapezium")
    three.press(Qt.Key.Key_0)
    three.wait()
    assert three.said.startswith("Trapezium")
    click_layer(three, 0)
    assert three.said == ""
    click_layer(three, 1)
    three.apply(TrapeziumDrawing, iterations=1)
    assert three.said.startswith("Trapezium")
    undo(three)
    assert three.said == ""
    assert window.statusBar().currentMessage() == ""


def test_why_a_mesh_has_no_values_is_said(user, ant, tmp_path):
    mesh = read_surface(ant)[0]
    mesh.points[7] = np.nan
    write_surface(mesh, tmp_path / "hole.vtp")
    user.drop(tmp_path / "hole.vtp")
    assert "1 of the points used by faces have NaN" in user.said


def test_the_deviation_is_one_number_and_its_place_is_found(user, ant):
    from PySide6.QtCore import Qt

    from vtksmooth.report import figure

    user.drop(ant)
    user.apply(LaplacianSmoothing, iterations=5)
    user.press(Qt.Key.Key_5)
    user.wait()
    largest = figure(float(user.display.fields[0].values.max()))
    assert f"largest deviation {largest} " in user.window.figures.text().replace("  │", " ")
    assert user.window.worst.item(0, 1).text() == largest
    rows = user.window.numbers.table
    shown = {rows.item(row, 0).text(): rows.item(row, 2).text() for row in range(rows.rowCount())}
    assert next(value for name, value in shown.items() if name.startswith("deviation, max")) == largest
    user.press(Qt.Key.Key_W)
    user.wait()
    face = user.display.fields[0].worst[0]
    assert user.window.worst.item(user.window.worst.currentRow(), 0).text() == f"{face}"
    assert user.window.view._marks["worst"].actor.GetVisibility()
