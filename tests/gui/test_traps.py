"""Nothing changes or vanishes without being asked, by mouse and keys."""

from vtksmooth.filters import LaplacianSmoothing

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
