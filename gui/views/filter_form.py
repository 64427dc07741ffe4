"""The form of a filter, made from its declarations."""

from __future__ import annotations

import re
from functools import partial
from typing import Any

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import (
    QComboBox,
    QFormLayout,
    QFrame,
    QLabel,
    QScrollArea,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from vtksmooth.filters import INPUTS, Filter

from .parameter_row import ParameterRow
from .theme import share_palette
from .wheel import only_with_focus


def title(cls: type[Filter]) -> str:
    """Return a filter's name in words: TrapeziumDrawing becomes Trapezium Drawing."""
    return re.sub(r"(?<!^)(?=[A-Z])", " ", cls.__name__)


class FilterForm(QScrollArea):
    """The parameters and the further inputs of one filter.

    Attributes
    ----------
    rows : dict of str to ParameterRow
    inputs : dict of str to QComboBox
        What to choose the further inputs with.
    sections : dict of str to QToolButton
        What unfolds the groups of parameters.
    """

    #: A parameter has changed. True: the user is still moving something.
    edited = Signal(bool)
    #: The user has chosen another mesh for the input of this name.
    input_chosen = Signal(str)

    def __init__(self) -> None:
        super().__init__(widgetResizable=True)
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.filter: type[Filter] | None = None
        self.rows: dict[str, ParameterRow] = {}
        self.inputs: dict[str, QComboBox] = {}
        self.sections: dict[str, QToolButton] = {}
        self._unfolded: set[str] = set()
        self._names: list[str] = []
        self._unit = ""
        self._targets: list[tuple[str, Any]] = []

    def show_filter(self, cls: type[Filter] | None) -> None:
        """Show the form of a filter with its defaults, or nothing."""
        self.filter, self.rows, self.inputs, self.sections = cls, {}, {}, {}
        self._labels: dict[str, QLabel] = {}
        page = QWidget()
        column = QVBoxLayout(page)
        column.setContentsMargins(0, 0, 4, 0)
        if cls is not None:
            self._fill(column, cls)
        column.addStretch(1)
        self.setWidget(page)
        share_palette(page)
        self._offer()
        self._make_room()

    def _fill(self, column: QVBoxLayout, cls: type[Filter]) -> None:
        forms = {"": self._form()}
        column.addLayout(forms[""])
        for name in cls.every_input()[1:]:
            box = only_with_focus(QComboBox())
            box.setMinimumContentsLength(8)
            box.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
            box.setToolTip(INPUTS[name].description)
            self.inputs[name] = box
            forms[""].addRow(self._label(INPUTS[name].title.capitalize(), box.toolTip()), box)
            box.activated.connect(partial(self._chosen, name))
            box.currentIndexChanged.connect(self._follow)
        for name, parameter in cls.parameters().items():
            row = ParameterRow(parameter, self._names)
            row.set_unit(self._unit)
            row.changed.connect(self.edited)
            row.changed.connect(self._follow)
            self.rows[name] = row
            if parameter.group not in forms:
                forms[parameter.group] = self._section(column, parameter.group)
            label = self._label(row.label, row.tip)
            self._labels[name] = label
            forms[parameter.group].addRow(label, row)
        self._follow()

    def _section(self, column: QVBoxLayout, group: str) -> QFormLayout:
        """Add a form that can be folded."""
        self.sections[group] = button = QToolButton(autoRaise=True)
        button.setCheckable(True)
        button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        button.setArrowType(Qt.ArrowType.RightArrow)
        rows = QWidget()
        form = self._form()
        rows.setLayout(form)
        rows.hide()
        button.toggled.connect(partial(self._unfold, group, rows))
        button.setChecked(group in self._unfolded)
        column.addWidget(button)
        column.addWidget(rows)
        return form

    def _unfold(self, group: str, rows: QWidget, on: bool) -> None:
        rows.setVisible(on)
        self.sections[group].setArrowType(Qt.ArrowType.DownArrow if on else Qt.ArrowType.RightArrow)
        (self._unfolded.add if on else self._unfolded.discard)(group)
        self._make_room()

    def _make_room(self) -> None:
        # There is no horizontal scroll bar: what is narrower would cut the buttons at the end of the rows.
        if (page := self.widget()) is not None:
            bar = self.verticalScrollBar().sizeHint().width()
            self.setMinimumWidth(page.minimumSizeHint().width() + bar)

    def _has_say(self, name: str) -> bool:
        return self.rows[name].parameter.has_say(
            lambda other: self.inputs[other].currentData() if other in self.inputs else self.rows[other].value
        )

    def _follow(self) -> None:
        """Grey the parameters that have no effect with what is chosen.

        And tell on each section how many of its parameters are not the defaults: folded, they act as well.
        """
        for name, row in self.rows.items():
            if row.parameter.only and row.isEnabled() != (say := self._has_say(name)):
                row.setEnabled(say)
                self._labels[name].setEnabled(say)
                where = f"<p>Has an effect where {row.parameter.where}.</p>"
                self._labels[name].setToolTip(row.tip + ("" if say else where))
        changed = [self.rows[name].parameter.group for name in self.values()]
        for group, button in self.sections.items():
            count = changed.count(group)
            button.setText(group.capitalize() + (f" ({count} changed)" if count else ""))

    @staticmethod
    def _form() -> QFormLayout:
        form = QFormLayout()
        form.setContentsMargins(0, 0, 0, 0)
        form.setRowWrapPolicy(QFormLayout.RowWrapPolicy.WrapLongRows)
        form.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.AllNonFixedFieldsGrow)
        return form

    @staticmethod
    def _label(text: str, tip: str) -> QLabel:
        label = QLabel(text)
        label.setToolTip(tip)
        return label

    # -- what is chosen ----------------------------------------------------------------------------

    def values(self) -> dict[str, Any]:
        """Return the parameters that are not the filter's defaults, and have an effect."""
        return {
            name: row.value
            for name, row in self.rows.items()
            if row.value != row.parameter.default and self._has_say(name)
        }

    def set_values(self, values: dict[str, Any]) -> None:
        """Show parameters; those not named get their defaults."""
        for name, row in self.rows.items():
            value = values.get(name, row.parameter.default)
            if row.value != value:
                row.set_value(value)
        self._follow()

    def choose_input(self, name: str, target: Any) -> None:
        """Show that a further input is `target`, one of those that are offered; None: there is none."""
        self.inputs[name].setCurrentIndex(self._place(name, target))

    def _chosen(self, name: str, *_: Any) -> None:
        self.input_chosen.emit(name)

    # -- what there is to choose from --------------------------------------------------------------

    def set_unit(self, unit: str) -> None:
        """Show lengths with the unit of the document."""
        self._unit = unit
        for row in self.rows.values():
            row.set_unit(unit)

    def set_targets(self, targets: list[tuple[str, Any]], names: list[str]) -> None:
        """Offer meshes for further inputs, the likeliest first, and names of arrays."""
        if targets == self._targets and names == self._names:
            return  # somebody may just be typing in one of the rows
        self._targets, self._names = targets, names
        self._offer()
        for row in self.rows.values():
            row.set_names(names)

    def _offer(self) -> None:
        for name, box in self.inputs.items():
            chosen = box.currentData()
            box.clear()
            for words, target in self._offered(name):
                box.addItem(words, target)
            box.setCurrentIndex(max(self._place(name, chosen), 0) if box.count() else -1)

    def _offered(self, name: str) -> list[tuple[str, Any]]:
        optional = self.filter is not None and name in self.filter.optional_inputs
        return [("none", None), *self._targets] if optional else self._targets

    def _place(self, name: str, target: Any) -> int:
        return next((i for i, (_, other) in enumerate(self._offered(name)) if other == target), -1)
