"""A recipe on many files: which, where to, and what became of each."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from PySide6.QtCore import QRect, QSize, Qt, Signal
from PySide6.QtGui import QColor, QDragEnterEvent, QDropEvent
from PySide6.QtWidgets import (
    QAbstractItemView,
    QComboBox,
    QDialog,
    QFormLayout,
    QHBoxLayout,
    QHeaderView,
    QLabel,
    QLineEdit,
    QListWidget,
    QProgressBar,
    QPushButton,
    QTableWidget,
    QTableWidgetItem,
    QVBoxLayout,
    QWidget,
)

from .wheel import only_with_focus

_FAILED = QColor("#d64a3a")


class BatchDialog(QDialog):
    """It stays beside the window, which can be used meanwhile."""

    recipe_wanted = Signal()
    files_wanted = Signal()
    folder_wanted = Signal()
    output_wanted = Signal()
    start_wanted = Signal()
    cancel_wanted = Signal()
    copy_wanted = Signal()
    #: The result of this row is to be looked at.
    opened = Signal(int)

    def __init__(
        self, head: Sequence[str], formats: Iterable[str], reports: Iterable[str], parent: QWidget
    ) -> None:
        super().__init__(parent)
        self.setWindowTitle("Batch")
        self.setAcceptDrops(True)
        self.recipes = only_with_focus(QComboBox())
        self.recipes.setToolTip("What is done to each mesh")
        self.sources = QListWidget()
        self.sources.setToolTip("Meshes, and folders, of which all meshes are taken; drop them here")
        self.sources.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
        self.sources.setMaximumHeight(84)
        self.output = QLineEdit(placeholderText="a folder; it is made if it is missing")
        self.output.textChanged.connect(self._enable)
        self.format = only_with_focus(QComboBox())
        self.format.addItem("that of each mesh", None)
        for extension in formats:
            self.format.addItem(extension, extension)
        self.report = only_with_focus(QComboBox())
        self.report.addItem("none", None)
        for extension in reports:
            self.report.addItem(f"{extension}, one for each mesh", extension)
        self.table = QTableWidget(0, len(head) + 1)
        self.table.setHorizontalHeaderLabels([head[0], "state", *head[1:]])
        self.table.verticalHeader().hide()
        self.table.verticalHeader().setDefaultSectionSize(22)
        self.table.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.table.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.table.horizontalHeader().setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        self.table.horizontalHeader().setSectionResizeMode(0, QHeaderView.ResizeMode.Stretch)
        self.table.horizontalHeader().setMinimumSectionSize(70)
        self.table.setToolTip("Double-click a file that is done to open its result as a layer")
        self.table.cellDoubleClicked.connect(lambda row, _: self.opened.emit(row))
        self.progress = QProgressBar(maximum=1000, textVisible=False)
        self.progress.setFixedHeight(6)
        self.said = QLabel(" ", wordWrap=True)
        self.start = self._button("Start", self.start_wanted)
        self.cancel = self._button("Cancel", self.cancel_wanted)
        self.copy = self._button("Copy as Markdown", self.copy_wanted)
        self._arrange()
        self.running = False
        self.set_running(False)
        self.copy.setEnabled(False)
        self.resize(1000, 680)

    def _button(self, text: str, signal: Any) -> QPushButton:
        button = QPushButton(text, autoDefault=False)
        button.clicked.connect(signal)
        return button

    def _arrange(self) -> None:
        beside = QVBoxLayout()
        beside.addWidget(self._button("Add Files…", self.files_wanted))
        beside.addWidget(self._button("Add Folder…", self.folder_wanted))
        remove = QPushButton("Remove", autoDefault=False)
        remove.clicked.connect(self._remove)
        beside.addWidget(remove)
        beside.addStretch(1)
        meshes = QHBoxLayout()
        meshes.addWidget(self.sources, 1)
        meshes.addLayout(beside)
        form = QFormLayout()
        form.addRow("Recipe", self._row(self.recipes, self._button("Open…", self.recipe_wanted)))
        form.addRow("Meshes", meshes)
        form.addRow("Results in", self._row(self.output, self._button("Choose…", self.output_wanted)))
        kinds = self._row(self.format)
        kinds.addWidget(QLabel("  Reports"))
        kinds.addWidget(self.report, 1)
        form.addRow("Format", kinds)
        below = QHBoxLayout()
        below.addWidget(self.said, 1)
        for button in (self.copy, self.cancel, self.start):
            below.addWidget(button)
        layout = QVBoxLayout(self)
        layout.addLayout(form)
        layout.addWidget(self.table, 1)
        layout.addWidget(self.progress)
        layout.addLayout(below)

    @staticmethod
    def _row(widget: QWidget, *more: QWidget) -> QHBoxLayout:
        row = QHBoxLayout()
        row.addWidget(widget, 1)
        for one in more:
            row.addWidget(one)
        return row

    # -- what is to be done ------------------------------------------------------------------------

    def offer_recipe(self, text: str, target: Any) -> None:
        """Offer a recipe, and choose it."""
        place = next((i for i in range(self.recipes.count()) if self.recipes.itemData(i) == target), -1)
        if place < 0:
            place = self.recipes.count()
            self.recipes.addItem(text, target)
        self.recipes.setItemText(place, text)
        self.recipes.setCurrentIndex(place)
        self._enable()

    def add_sources(self, paths: Iterable[str | Path]) -> None:
        """Add meshes and folders."""
        known = set(self.paths())
        self.sources.addItems([str(path) for path in paths if Path(path) not in known])
        self._enable()

    def paths(self) -> list[Path]:
        """Return the meshes and folders."""
        return [Path(self.sources.item(row).text()) for row in range(self.sources.count())]

    def _remove(self) -> None:
        for item in self.sources.selectedItems():
            self.sources.takeItem(self.sources.row(item))
        self._enable()

    def dragEnterEvent(self, event: QDragEnterEvent) -> None:  # noqa: N802
        """Take files."""
        if event.mimeData().hasUrls():
            event.acceptProposedAction()

    def dropEvent(self, event: QDropEvent) -> None:  # noqa: N802
        """Add the files dropped."""
        event.acceptProposedAction()
        self.add_sources(url.toLocalFile() for url in event.mimeData().urls() if url.isLocalFile())

    # -- what becomes of it ------------------------------------------------------------------------

    def set_running(self, running: bool) -> None:
        """Show whether a batch runs."""
        self.running = running
        self.cancel.setEnabled(running)
        self.progress.setValue(0)
        self._enable()

    def _enable(self) -> None:
        ready = self.recipes.count() and self.sources.count() and self.output.text().strip()
        self.start.setEnabled(bool(ready) and not self.running)

    def set_progress(self, fraction: float, what: str) -> None:
        """Show how far the batch is, 0 to 1, and what it does."""
        self.progress.setValue(round(1000 * fraction))
        self.said.setText(what)

    def show_files(self, names: Sequence[str]) -> None:
        """List files that wait."""
        self.table.clearSpans()
        self.table.setRowCount(0)
        self.table.setRowCount(len(names))
        for row, name in enumerate(names):
            self.set_cells(row, [name, "waiting"])

    def set_cells(self, row: int, cells: Sequence[str], failed: bool = False) -> None:
        """Show a file, its state and its figures; what failed has a reason in place of the figures."""
        for column, text in enumerate(cells):
            item = QTableWidgetItem(text)
            if failed:
                item.setToolTip(text)
            if column > 1 and not failed:
                item.setTextAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
            if failed and column:
                item.setForeground(_FAILED)
            if failed and column > 1:
                item.setSizeHint(QSize(0, 0))  # it has the room of all that follow: one needs not be wider
            self.table.setItem(row, column, item)
        if failed:
            self.table.setSpan(row, 2, 1, self.table.columnCount() - 2)
            # Those columns may yet grow.
            width = sum(self.table.columnWidth(column) for column in range(2, self.table.columnCount()))
            room = QRect(0, 0, width - 8, 1000)
            words = self.fontMetrics().boundingRect(room, Qt.TextFlag.TextWordWrap, cells[2])
            self.table.setRowHeight(row, max(words.height() + 6, self.table.rowHeight(row)))
        self.table.scrollTo(self.table.model().index(row, 0))
