"""The form of a filter, made from its declarations."""

from __future__ import annotations

import re
from typing import Any

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QAction
from PySide6.QtWidgets import (
    QComboBox,
    QFormLayout,
    QFrame,
    QHBoxLayout,
    QLabel,
    QProgressBar,
    QPushButton,
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


def summary(cls: type[Filter]) -> str:
    """Return the first sentence of a filter's documentation, as people read it."""
    text = " ".join((cls.__doc__ or "").split("\n\n")[0].split())
    return re.sub(r"\s*\([^()]*et al\.[^()]*\)", "", text.replace("``", ""))


def _is_own(cls: type[Filter], parameter: Parameter) -> bool:
    """Return whether a parameter belongs to the filter itself, or says how often; the rest is common."""
    inherited = parameter.name not in vars(cls)
    return not inherited or (parameter.type is int and not parameter.optional)


class FilterPanel(QWidget):
    """Choose a filter, set its parameters, apply or preview it."""

    #: Another filter has been chosen.
    chosen = Signal()
    #: A value has changed. True: the user is still moving something.
    edited = Signal(bool)

    def __init__(self, filters: tuple[type[Filter], ...], apply: QAction, cancel: QAction, preview: QAction):
        super().__init__()
        self._filters = filters
        self.rows: dict[str, ParameterRow] = {}
        self.inputs: dict[str, QComboBox] = {}
        self._names: list[str] = []
        self._targets: list[tuple[str, Any]] = []
        self.choice = QComboBox()
        self.choice.addItems([title(cls) for cls in filters])
        for number, cls in enumerate(filters):
            self.choice.setItemData(number, summary(cls), Qt.ItemDataRole.ToolTipRole)
        self.about = QLabel(wordWrap=True)
        self.form = QScrollArea(widgetResizable=True)
        self.form.setFrameShape(QFrame.Shape.NoFrame)
        self.form.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.progress = QProgressBar(maximum=1000, textVisible=False)
        self.progress.setFixedHeight(6)
        self.doing = QLabel(" ")
        self.doing.setMinimumWidth(10)
        buttons = QHBoxLayout()
        for action, stretch in ((apply, 2), (cancel, 1)):
            button = QPushButton(action.text())
            button.setToolTip(f"{action.toolTip()} ({action.shortcut().toString()})")
            button.clicked.connect(action.trigger)
            button.setEnabled(action.isEnabled())
            action.enabledChanged.connect(button.setEnabled)
            buttons.addWidget(button, stretch)
        live = QToolButton()
        live.setDefaultAction(preview)
        buttons.insertWidget(0, live)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(6, 6, 6, 6)
        layout.addWidget(self.choice)
        layout.addWidget(self.about)
        layout.addWidget(self.form, 1)
        layout.addWidget(self.doing)
        layout.addWidget(self.progress)
        layout.addLayout(buttons)
        self.choice.currentIndexChanged.connect(self._build)
        self.set_progress(None)
        self._build()

    # -- the filter --------------------------------------------------------------------------------

    @property
    def filter(self) -> type[Filter]:
        """The filter chosen."""
        return self._filters[self.choice.currentIndex()]

    def choose(self, cls: type[Filter]) -> None:
        """Choose a filter."""
        self.choice.setCurrentIndex(self._filters.index(cls))

    def values(self) -> dict[str, Any]:
        """Return the parameters that are not the filter's defaults."""
        return {name: row.value for name, row in self.rows.items() if row.value != row.parameter.default}

    def set_values(self, values: dict[str, Any]) -> None:
        """Show parameters; those not named get their defaults."""
        for name, row in self.rows.items():
            row.set_value(values.get(name, row.parameter.default))

    def further_inputs(self) -> list[Any]:
        """Return what has been chosen for the inputs beside the mesh; None where there is nothing."""
        return [box.currentData() for box in self.inputs.values()]

    def _build(self) -> None:
        cls = self.filter
        self.about.setText(summary(cls))
        self.rows, self.inputs = {}, {}
        page = QWidget()
        column = QVBoxLayout(page)
        column.setContentsMargins(0, 0, 4, 0)
        own, common = self._form(), self._form()
        column.addLayout(own)
        for name in cls.inputs[1:]:
            box = QComboBox()
            box.setToolTip(f"The mesh that the filter takes as its {name.replace('_', ' ')}")
            self.inputs[name] = box
            own.addRow(self._label(name.replace("_", " ").capitalize(), box.toolTip()), box)
            box.activated.connect(lambda *_: self.edited.emit(False))
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
        column.addStretch(1)
        self.form.setWidget(page)
        self._offer()
        self.chosen.emit()

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

    # -- what there is to choose from --------------------------------------------------------------

    def set_targets(self, targets: list[tuple[str, Any]], names: list[str]) -> None:
        """Offer meshes for further inputs, the likeliest first, and names of arrays."""
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
            found = next((i for i, (_, target) in enumerate(self._targets) if target is chosen), 0)
            box.setCurrentIndex(found if self._targets else -1)

    # -- while it runs -----------------------------------------------------------------------------

    def set_progress(self, fraction: float | None, what: str = "") -> None:
        """Show how far a run is; None: nothing runs."""
        self.progress.setEnabled(fraction is not None)
        self.progress.setValue(round(1000 * (fraction or 0.0)))
        self.doing.setText(what or " ")
