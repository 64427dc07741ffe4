"""The row of one parameter, made from its declaration."""

from __future__ import annotations

import math
from typing import Any

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QValidator
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QDoubleSpinBox,
    QHBoxLayout,
    QSlider,
    QSpinBox,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from vtksmooth.filters.parameter import AUTO, Parameter

from .wheel import only_with_focus

#: The unit of parameters that are lengths.
LENGTH = "model units"
_LARGEST = 2**31 - 1
#: Sliders have this many steps for floats.
_STEPS = 1000


class NumberBox(QDoubleSpinBox):
    """A spin box for floats of any size, written as short as they can be."""

    def __init__(self) -> None:
        super().__init__()
        self.setDecimals(15)
        self.setKeyboardTracking(False)

    def stepBy(self, steps: int) -> None:  # noqa: N802
        """Step by a tenth of the number's own size."""
        size = abs(self.value()) or min(1.0, self.maximum())
        self.setValue(self.value() + steps * 10.0 ** (math.ceil(math.log10(size)) - 2))

    def textFromValue(self, value: float) -> str:  # noqa: N802
        """Return the shortest text that is this number."""
        return f"{value:.12g}"

    def valueFromText(self, text: str) -> float:  # noqa: N802
        """Return the number of a text."""
        return float(text.removesuffix(self.suffix()).strip())

    def validate(self, text: str, position: int) -> tuple[QValidator.State, str, int]:
        """Accept every way to write a number."""
        try:
            value = float(text.removesuffix(self.suffix()).strip())
        except ValueError:
            return QValidator.State.Intermediate, text, position
        inside = self.minimum() <= value <= self.maximum()
        return (QValidator.State.Acceptable if inside else QValidator.State.Intermediate), text, position


def _slider_span(parameter: Parameter) -> tuple[float, float] | None:
    """Return the ends of the slider, or None where there is no sensible one."""
    if parameter.low is not None and parameter.high is not None:
        return parameter.low, parameter.high
    if parameter.type is int and parameter.low is not None and isinstance(parameter.default, int):
        return parameter.low, max(20, 5 * parameter.default)
    return None


class ParameterRow(QWidget):
    """Widgets for one parameter; its value is always one that the filter accepts."""

    #: The value has changed. True: the user is still moving something.
    changed = Signal(bool)

    def __init__(self, parameter: Parameter, names: list[str]) -> None:
        super().__init__()
        self.parameter = parameter
        self.label = parameter.name.replace("_", " ").capitalize()
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(1)
        line = QHBoxLayout()
        line.setSpacing(4)
        layout.addLayout(line)
        self.slider: QSlider | None = None
        self.switch: QCheckBox | None = None
        self.automatic: QCheckBox | None = None
        self.editor = self._editor(names)
        if parameter.optional:
            self.switch = QCheckBox()
            self.switch.setToolTip("On or off")
            self.switch.toggled.connect(self._changed)
            line.addWidget(self.switch)
        line.addWidget(self.editor, 1)
        if parameter.automatic:
            self.automatic = QCheckBox("auto")
            self.automatic.setToolTip("Let the filter choose by the mesh")
            self.automatic.toggled.connect(self._changed)
            line.addWidget(self.automatic)
        self.reset = QToolButton(autoRaise=True)
        self.reset.setText("↺")
        self.reset.setToolTip("Reset to the default")
        self.reset.clicked.connect(self.set_default)
        line.addWidget(self.reset)
        if self.slider is not None:
            layout.addWidget(self.slider)
        unit = f" ({parameter.unit})" if parameter.unit else ""
        allowed = "" if parameter.choices else f"<br>Allowed: {parameter.range.replace('None (off)', 'off')}."
        default = "off" if parameter.default is None else parameter.default
        self.tip = f"<p><b>{self.label}</b>{unit}<br>{parameter.help}{allowed}<br>Default: {default}.</p>"
        self.setToolTip(self.tip)
        self.set_default()

    # -- making the widgets ------------------------------------------------------------------------

    def _editor(self, names: list[str]) -> QWidget:
        parameter = self.parameter
        if parameter.type is bool:
            box = QCheckBox()
            box.toggled.connect(self._changed)
            return box
        if parameter.choices or parameter.type is str:
            choice = only_with_focus(QComboBox())
            choice.setMinimumContentsLength(8)
            choice.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
            choice.addItems(list(parameter.choices or ([] if parameter.text else names)))
            choice.setEditable(not parameter.choices)
            choice.currentTextChanged.connect(self._changed)
            return choice
        spin: Any = only_with_focus(QSpinBox() if parameter.type is int else NumberBox())
        largest = _LARGEST if parameter.type is int else 1e300
        spin.setRange(
            -largest if parameter.low is None else parameter.type(parameter.low),
            largest if parameter.high is None else parameter.type(parameter.high),
        )
        unit = {"deg": "°", "percent": " %", "": ""}.get(parameter.unit, f" {parameter.unit}")
        spin.setSuffix(unit)
        spin.valueChanged.connect(self._typed)
        self._add_slider(spin)
        return spin  # type: ignore[no-any-return]

    def _add_slider(self, spin: Any) -> None:
        span = _slider_span(self.parameter)
        if span is None:
            return
        self._span = span
        self.slider = only_with_focus(QSlider(Qt.Orientation.Horizontal))
        steps = round(span[1] - span[0]) if self.parameter.type is int else _STEPS
        self.slider.setRange(0, steps)
        self.slider.valueChanged.connect(self._slid)
        self.slider.sliderReleased.connect(self._changed)

    # -- its value ---------------------------------------------------------------------------------

    @property
    def value(self) -> Any:
        """The value, as the filter takes it."""
        if self.switch is not None and not self.switch.isChecked():
            return None
        if self.automatic is not None and self.automatic.isChecked():
            return AUTO
        if isinstance(self.editor, QCheckBox):
            return self.editor.isChecked()
        if isinstance(self.editor, QComboBox):
            return self.editor.currentText() or self.parameter.default
        return self.parameter.check(self.editor.value())  # type: ignore[attr-defined]

    def set_value(self, value: Any) -> None:
        """Show a value; what the parameter does not accept is not taken."""
        try:
            value = self.parameter.check(value)
        except ValueError:
            return
        self.blockSignals(True)
        if self.switch is not None:
            self.switch.setChecked(value is not None)
        if self.automatic is not None:
            self.automatic.setChecked(value == AUTO)
        if isinstance(self.editor, QCheckBox):
            self.editor.setChecked(bool(value))
        elif isinstance(self.editor, QComboBox):
            self.editor.setCurrentText(value or "")
        elif value is not None and value != AUTO:
            self.editor.setValue(value)  # type: ignore[attr-defined]
        self.blockSignals(False)
        self._changed()

    def set_default(self) -> None:
        """Go back to the default."""
        self.set_value(self.parameter.default)

    def set_unit(self, unit: str) -> None:
        """Show a length with the unit of the document."""
        if self.parameter.unit == LENGTH and isinstance(self.editor, (QSpinBox, QDoubleSpinBox)):
            self.editor.setSuffix(f" {unit or LENGTH}")

    def set_names(self, names: list[str]) -> None:
        """Offer names of arrays."""
        if self.parameter.type is not str or self.parameter.choices or self.parameter.text:
            return
        assert isinstance(self.editor, QComboBox)
        value = self.editor.currentText()
        self.editor.blockSignals(True)
        self.editor.clear()
        self.editor.addItems(names)
        self.editor.setCurrentText(value)
        self.editor.blockSignals(False)

    def _typed(self, value: float) -> None:
        if self.slider is not None:
            low, high = self._span
            place = round((value - low) / (high - low) * self.slider.maximum())
            self.slider.blockSignals(True)
            self.slider.setValue(min(max(place, 0), self.slider.maximum()))
            self.slider.blockSignals(False)
        self._changed()

    def _slid(self, place: int) -> None:
        assert self.slider is not None
        low, high = self._span
        value = low + place * (high - low) / self.slider.maximum()
        self.editor.blockSignals(True)
        self.editor.setValue(round(value) if self.parameter.type is int else float(f"{value:.4g}"))  # type: ignore[attr-defined]
        self.editor.blockSignals(False)
        if self.automatic is not None:
            self.automatic.setChecked(False)
        self._changed()

    def _changed(self, *_: Any) -> None:
        on = self.switch is None or self.switch.isChecked()
        auto = self.automatic is not None and self.automatic.isChecked()
        self.editor.setEnabled(on and not auto)
        if self.automatic is not None:
            # In place of a number that nobody has given.
            self.editor.setSpecialValueText("by the mesh" if auto else "")  # type: ignore[attr-defined]
        if self.automatic is not None:
            self.automatic.setEnabled(on)
        if self.slider is not None:
            self.slider.setEnabled(on)
        self.reset.setEnabled(self.value != self.parameter.default)
        self.changed.emit(self.slider is not None and self.slider.isSliderDown())
