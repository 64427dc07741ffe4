"""The panel of filters: choose one, set its parameters, apply or preview it."""

from __future__ import annotations

import re
from typing import Any

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QAction
from PySide6.QtWidgets import (
    QComboBox,
    QHBoxLayout,
    QLabel,
    QProgressBar,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from vtksmooth.filters import Filter

from .action_button import action_button
from .filter_form import FilterForm, title
from .parameter_row import ParameterRow
from .wheel import only_with_focus


def summary(cls: type[Filter]) -> str:
    """Return the first sentence of a filter's documentation, as people read it."""
    text = " ".join((cls.__doc__ or "").split("\n\n")[0].split())
    return re.sub(r"\s*\([^()]*et al\.[^()]*\)", "", text.replace("``", ""))


class FilterPanel(QWidget):
    """Choose a filter, set its parameters, apply or preview it."""

    #: Another filter has been chosen.
    chosen = Signal()
    #: A value has changed. True: the user is still moving something.
    edited = Signal(bool)

    def __init__(self, filters: tuple[type[Filter], ...], apply: QAction, cancel: QAction, preview: QAction):
        super().__init__()
        self._filters = filters
        self.choice = only_with_focus(QComboBox())
        self.choice.addItems([title(cls) for cls in filters])
        for number, cls in enumerate(filters):
            self.choice.setItemData(number, summary(cls), Qt.ItemDataRole.ToolTipRole)
        self.about = QLabel(wordWrap=True)
        self.form = FilterForm()
        self.form.edited.connect(self.edited)
        self.form.input_chosen.connect(lambda *_: self.edited.emit(False))
        self.progress = QProgressBar(maximum=1000, textVisible=False)
        self.progress.setFixedHeight(6)
        self.doing = QLabel(wordWrap=True, alignment=Qt.AlignmentFlag.AlignBottom)
        self.doing.setMinimumHeight(2 * self.doing.fontMetrics().lineSpacing())
        buttons = QHBoxLayout()
        for action, stretch in ((apply, 2), (cancel, 1)):
            buttons.addWidget(action_button(action), stretch)
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

    @property
    def rows(self) -> dict[str, ParameterRow]:
        """The rows of the parameters, by name."""
        return self.form.rows

    @property
    def inputs(self) -> dict[str, QComboBox]:
        """The choices of further inputs, by name."""
        return self.form.inputs

    def values(self) -> dict[str, Any]:
        """Return the parameters that are not the filter's defaults."""
        return self.form.values()

    def set_values(self, values: dict[str, Any]) -> None:
        """Show parameters; those not named get their defaults."""
        self.form.set_values(values)

    def further_inputs(self) -> list[Any]:
        """Return what has been chosen for the inputs beside the mesh; None where there is nothing."""
        return [box.currentData() for box in self.inputs.values()]

    def set_targets(self, targets: list[tuple[str, Any]], names: list[str]) -> None:
        """Offer meshes for further inputs, the likeliest first, and names of arrays."""
        self.form.set_targets(targets, names)

    def _build(self) -> None:
        self.about.setText(summary(self.filter))
        self.form.show_filter(self.filter)
        self.chosen.emit()

    # -- while it runs -----------------------------------------------------------------------------

    def set_progress(self, fraction: float | None, what: str = "") -> None:
        """Show how far a run is; None: nothing runs."""
        self.progress.setEnabled(fraction is not None)
        self.progress.setValue(round(1000 * (fraction or 0.0)))
        self.doing.setText(what)
