"""The recipe of the active layer, to be edited and run again."""

from __future__ import annotations

from typing import Any

from PySide6.QtCore import QSignalBlocker, Qt, Signal, Slot
from PySide6.QtGui import QAction, QKeySequence, QShortcut
from PySide6.QtWidgets import (
    QAbstractItemView,
    QHBoxLayout,
    QLabel,
    QListWidget,
    QListWidgetItem,
    QProgressBar,
    QSplitter,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from vtksmooth.recipe import Recipe, Step, shown

from .action_button import action_button
from .filter_form import FilterForm, title


def parameters(step: Step) -> str:
    """Return the parameters of a step that are not the defaults, as people read them."""
    return ", ".join(f"{name.replace('_', ' ')} {shown(value)}" for name, value in step.parameters.items())


class RecipeList(QWidget):
    """Steps in their order, and the form of the one that is selected.

    A step's tick switches it on or off; it is dragged to another place, or moved by the buttons. Steps
    that will be run, as they are not in effect the way they are shown, are in italics.
    """

    #: A step is to be switched on or off.
    switched = Signal(int, bool)
    #: A step is to have another number.
    moved = Signal(int, int)
    removed = Signal(int)
    #: A step is to have other parameters.
    changed = Signal(int, object)
    #: A further input of a step is to be another mesh: number, name, what was offered.
    input_changed = Signal(int, str, object)
    #: Another step is selected.
    selected = Signal()

    def __init__(self, run: QAction, revert: QAction, more: tuple[QAction, ...]) -> None:
        super().__init__()
        self.recipe = Recipe()
        self.list = QListWidget()
        self.list.setWordWrap(True)
        self.list.setSpacing(1)
        self.list.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.list.setDragDropMode(QAbstractItemView.DragDropMode.InternalMove)
        self.list.itemChanged.connect(self._ticked)
        self.list.currentRowChanged.connect(self._select)
        # Later: the list has to end its own dealing with the drop first.
        self.list.model().rowsMoved.connect(self._dropped, Qt.ConnectionType.QueuedConnection)
        self.form = FilterForm()
        self.form.edited.connect(self._edited)
        self.form.input_chosen.connect(self._input_chosen)
        self.form.show_filter(None)
        self.about = QLabel("Steps that are applied to the mesh are listed here.", wordWrap=True)
        self.progress = QProgressBar(maximum=1000, textVisible=False)
        self.progress.setFixedHeight(6)
        self.up = self._button("▲", "Do the step earlier", lambda: self._shift(-1))
        self.down = self._button("▼", "Do the step later", lambda: self._shift(1))
        self.remove = self._button("✕", "Take the step out (Del)", lambda: self.removed.emit(self.row))
        # Not the standard key, which on Linux is Ctrl+D as well: that is a command's.
        delete = QShortcut(QKeySequence(Qt.Key.Key_Delete), self.list)
        delete.setContext(Qt.ShortcutContext.WidgetShortcut)
        delete.activated.connect(self.remove.click)
        tools = QHBoxLayout()
        for widget in (self.up, self.down, self.remove):
            tools.addWidget(widget)
        tools.addStretch(1)
        for action in more:
            button = QToolButton(autoRaise=True)
            button.setDefaultAction(action)
            tools.addWidget(button)
        buttons = QHBoxLayout()
        for action, stretch in ((run, 2), (revert, 1)):
            buttons.addWidget(action_button(action), stretch)
        above = QWidget()
        column = QVBoxLayout(above)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(self.list)
        column.addLayout(tools)
        halves = QSplitter(Qt.Orientation.Vertical)
        halves.addWidget(above)
        halves.addWidget(self.form)
        halves.setSizes([150, 250])
        layout = QVBoxLayout(self)
        layout.setContentsMargins(4, 4, 4, 4)
        layout.addWidget(halves, 1)
        layout.addWidget(self.about)
        layout.addWidget(self.progress)
        layout.addLayout(buttons)
        self.show_recipe(Recipe(), 0, False)

    @staticmethod
    def _button(text: str, tip: str, do: Any) -> QToolButton:
        button = QToolButton(autoRaise=True)
        button.setText(text)
        button.setToolTip(tip)
        button.clicked.connect(do)
        return button

    # -- showing -----------------------------------------------------------------------------------

    @property
    def row(self) -> int:
        """The number of the step that is selected, or -1."""
        return self.list.currentRow()

    def show_recipe(self, recipe: Recipe, first: int, edited: bool, did: tuple[str, ...] = ()) -> None:
        """Show a recipe, whose steps before `first` are in effect.

        Parameters
        ----------
        edited : bool
            Whether it is another recipe than the one that has been run.
        did : tuple of str
            What the steps that are in effect did.
        """
        row = self.row
        self.recipe = recipe
        with QSignalBlocker(self.list):
            # Items that are there stay: one of them may just be telling that it was ticked.
            while self.list.count() > len(recipe):
                self.list.takeItem(self.list.count() - 1)
            while self.list.count() < len(recipe):
                self.list.addItem(QListWidgetItem())
            for number, step in enumerate(recipe.steps):
                said = did[number] if number < min(first, len(did)) else ""
                self._show(number, step, number >= first, said)
            self.list.setCurrentRow(min(max(row, 0), len(recipe) - 1) if len(recipe) else -1)
        self.about.setText("Edited; not run yet." if edited else "")
        self.about.setVisible(edited)
        self._select()

    def _show(self, number: int, step: Step, to_run: bool, did: str) -> None:
        words = parameters(step)
        item = self.list.item(number)
        item.setText(f"{number + 1}  {title(step.cls)}" + (f"\n     {words}" if words else ""))
        item.setFlags(
            Qt.ItemFlag.ItemIsEnabled
            | Qt.ItemFlag.ItemIsSelectable
            | Qt.ItemFlag.ItemIsUserCheckable
            | Qt.ItemFlag.ItemIsDragEnabled
        )
        item.setCheckState(Qt.CheckState.Checked if step.enabled else Qt.CheckState.Unchecked)
        item.setData(Qt.ItemDataRole.UserRole, number)
        font = item.font()
        font.setItalic(to_run)
        font.setStrikeOut(not step.enabled)
        item.setFont(font)
        grey = None if step.enabled else self.palette().placeholderText()
        item.setData(Qt.ItemDataRole.ForegroundRole, grey)
        item.setToolTip(did or ("It will be run." if to_run and step.enabled else ""))

    def set_progress(self, fraction: float | None, what: str = "") -> None:
        """Show how far a run is; None: nothing runs."""
        self.progress.setValue(round(1000 * (fraction or 0.0)))
        self.progress.setToolTip(what)

    def show_targets(self, targets: list[tuple[str, Any]], names: list[str]) -> None:
        """Offer meshes for further inputs, by what the recipe calls them, and names of arrays."""
        with QSignalBlocker(self.form):
            self.form.set_targets(targets, names)
            if 0 <= self.row < len(self.recipe):
                for name in self.form.inputs:
                    self.form.choose_input(name, self.recipe.steps[self.row].inputs.get(name))

    # -- what the user does ------------------------------------------------------------------------

    @Slot(int)
    def _select(self, *_: int) -> None:
        row, last = self.row, len(self.recipe) - 1
        self.up.setEnabled(row > 0)
        self.down.setEnabled(0 <= row < last)
        self.remove.setEnabled(row >= 0)
        step = self.recipe.steps[row] if 0 <= row <= last else None
        cls = None if step is None else step.cls
        with QSignalBlocker(self.form):
            self.form.setVisible(cls is not None)
            if cls is not None and self.form.filter is not cls:
                self.form.show_filter(cls)
            if step is not None and self.form.values() != dict(step.parameters):
                self.form.set_values(dict(step.parameters))
        self.selected.emit()

    def _ticked(self, item: QListWidgetItem) -> None:
        on = item.checkState() == Qt.CheckState.Checked
        self.switched.emit(self.list.row(item), on)

    def _shift(self, by: int) -> None:
        row = self.row
        with QSignalBlocker(self.list):
            self.list.setCurrentRow(row + by)
        self.moved.emit(row, row + by)

    @Slot()
    def _dropped(self) -> None:
        # One step has been taken out and put in elsewhere, and is the current one.
        row = self.row
        number = self.list.item(row).data(Qt.ItemDataRole.UserRole)
        if number != row:
            self.moved.emit(number, row)

    @Slot(bool)
    def _edited(self, sliding: bool) -> None:
        if self.row >= 0:
            self.changed.emit(self.row, {name: row.value for name, row in self.form.rows.items()})

    @Slot(str)
    def _input_chosen(self, name: str) -> None:
        if self.row >= 0:
            self.input_changed.emit(self.row, name, self.form.inputs[name].currentData())
