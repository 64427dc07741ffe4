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

from vtksmooth.filters import Filter, Parameter

from .parameter_row import ParameterRow


def title(cls: type[Filter]) -> str:
    """Return a filter's name in words: TrapeziumDrawing becomes Trapezium Drawing."""
    return re.sub(r"(?<!^)(?=[A-Z])", " ", cls.__name__)


def _is_own(cls: type[Filter], parameter: Parameter) -> bool:
    """Return whether a parameter belongs to the filter itself, or says how often; the rest is common."""
    inherited = parameter.name not in vars(cls)
    return not inherited or (parameter.type is int and not parameter.optional)


class FilterForm(QScrollArea):
    """The parameters and the further inputs of one filter.

    Attributes
    ----------
    rows : dict of str to ParameterRow
    inputs : dict of str to QComboBox
        What to choose the further inputs with.
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
        self._names: list[str] = []
        self._targets: list[tuple[str, Any]] = []

    def show_filter(self, cls: type[Filter] | None) -> None:
        """Show the form of a filter with its defaults, or nothing."""
        self.filter, self.rows, self.inputs = cls, {}, {}
        page = QWidget()
        column = QVBoxLayout(page)
        column.setContentsMargins(0, 0, 4, 0)
        if cls is not None:
            self._fill(column, cls)
        column.addStretch(1)
        self.setWidget(page)
        self._offer()

    def _fill(self, column: QVBoxLayout, cls: type[Filter]) -> None:
        own, common = self._form(), self._form()
        column.addLayout(own)
        for name in cls.inputs[1:]:
            box = QComboBox()
            box.setMinimumContentsLength(8)
            box.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
            box.setToolTip(f"The mesh that the filter takes as its {name.replace('_', ' ')}")
            self.inputs[name] = box
            own.addRow(self._label(name.replace("_", " ").capitalize(), box.toolTip()), box)
            box.activated.connect(partial(self._chosen, name))
        for name, parameter in sorted(cls.parameters().items(), key=lambda item: not _is_own(cls, item[1])):
            row = ParameterRow(parameter, self._names)
            row.changed.connect(self.edited)
            self.rows[name] = row
            form = own if _is_own(cls, parameter) else common
            form.addRow(self._label(row.label, row.tip), row)
        if common.rowCount():
            more = QToolButton(autoRaise=True)
            more.setText("Limits and stop rules")
            more.setCheckable(True)
            more.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
            more.setArrowType(Qt.ArrowType.RightArrow)
            further = QWidget()
            further.setLayout(common)
            further.hide()
            more.toggled.connect(further.setVisible)
            more.toggled.connect(
                lambda on: more.setArrowType(Qt.ArrowType.DownArrow if on else Qt.ArrowType.RightArrow)
            )
            column.addWidget(more)
            column.addWidget(further)

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
        """Return the parameters that are not the filter's defaults."""
        return {name: row.value for name, row in self.rows.items() if row.value != row.parameter.default}

    def set_values(self, values: dict[str, Any]) -> None:
        """Show parameters; those not named get their defaults."""
        for name, row in self.rows.items():
            row.set_value(values.get(name, row.parameter.default))

    def choose_input(self, name: str, target: Any) -> None:
        """Show that a further input is `target`, one of those that are offered."""
        self.inputs[name].setCurrentIndex(self._place(target))

    def _chosen(self, name: str, *_: Any) -> None:
        self.input_chosen.emit(name)

    # -- what there is to choose from --------------------------------------------------------------

    def set_targets(self, targets: list[tuple[str, Any]], names: list[str]) -> None:
        """Offer meshes for further inputs, the likeliest first, and names of arrays."""
        if targets == self._targets and names == self._names:
            return  # somebody may just be typing in one of the rows
        self._targets, self._names = targets, names
        self._offer()
        for row in self.rows.values():
            row.set_names(names)

    def _offer(self) -> None:
        for box in self.inputs.values():
            chosen = box.currentData()
            box.clear()
            for name, target in self._targets:
                box.addItem(name, target)
            box.setCurrentIndex(max(self._place(chosen), 0) if self._targets else -1)

    def _place(self, target: Any) -> int:
        return next((i for i, (_, other) in enumerate(self._targets) if other == target), -1)
