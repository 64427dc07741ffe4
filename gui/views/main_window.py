"""The main window: all widgets in their places, and the actions made from the table of commands."""

from __future__ import annotations

from functools import partial

from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtGui import (
    QAction,
    QActionGroup,
    QCloseEvent,
    QDragEnterEvent,
    QDropEvent,
    QGuiApplication,
    QIcon,
    QKeySequence,
)
from PySide6.QtWidgets import (
    QComboBox,
    QDockWidget,
    QHBoxLayout,
    QLabel,
    QMainWindow,
    QMenu,
    QSizePolicy,
    QSplitter,
    QToolBar,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from vtksmooth.filters import FILTERS

from ..commands import COMMANDS, MENUS, overlay_id
from ..model.measure import Kind
from ..model.overlays import OVERLAYS
from ..settings import Settings
from .action_button import connect_once
from .colour_bar import ColourBar
from .filter_panel import FilterPanel
from .histogram import Histogram
from .history_list import HistoryList
from .layer_list import LayerList
from .log import Log
from .measure_table import MeasureTable
from .mesh_view import MeshView
from .notification import Notification
from .numbers_table import NumbersTable
from .recipe_list import RecipeList
from .region_panel import RegionPanel
from .section_plot import SectionPlot
from .theme import Theme, show_checked
from .wheel import only_with_focus
from .worst_list import WorstList


class MainWindow(QMainWindow):
    """The window."""

    #: Files have been dropped on the window: their paths.
    dropped = Signal(list)
    #: The window is to be closed; whoever listens may call `event.ignore()`.
    closing = Signal(object)

    def __init__(self, settings: Settings) -> None:
        super().__init__()
        self.setWindowTitle("vtksmooth")
        self.setAcceptDrops(True)
        self.settings = settings
        self.actions_by_id: dict[str, QAction] = {}
        self.menus: dict[str, QMenu] = {}
        self.groups: dict[str, QActionGroup] = {}
        self._make_actions()
        self.view = MeshView()
        self.colour_bar = ColourBar()
        self.notification = Notification(self.view)
        action = self.action
        self.layers = LayerList(action("close_layer"), action("frame"), action("save_as"))
        self.filters = FilterPanel(FILTERS, action("apply"), action("cancel"), action("preview"))
        self.regions = RegionPanel(action)
        self.histogram, self.worst = Histogram(), WorstList()
        self.history, self.log = HistoryList(), Log()
        self.numbers = NumbersTable(action("copy_numbers"))
        self.recipe = RecipeList(
            action("run_recipe"), action("revert_recipe"), (action("open_recipe"), action("save_recipe"))
        )
        self.measurements = MeasureTable(
            [action(f"measure_{kind}") for kind in Kind] + [action("remove_measurements")],
            self.menus["Measure > Unit"],
        )
        self.section = SectionPlot([action(f"section{end}") for end in ("", "_x", "_y", "_z", "_view")])
        self.hint = QLabel(
            "Drop a mesh here, or open one with Ctrl+O", alignment=Qt.AlignmentFlag.AlignCenter
        )
        self.hint.setStyleSheet("font-size: 13pt")
        self.overlays = only_with_focus(QComboBox())
        self.overlays.setToolTip("What is shown on the mesh")
        self._arrange()
        self._make_tool_bar()
        for button in self.findChildren(QToolButton):
            if not button.defaultAction():
                continue
            connect_once(button)
            if button.isCheckable():
                button.toggled.connect(partial(show_checked, button))
                show_checked(button, button.isChecked())
        self.resize(QSize(1600, 950).boundedTo(QGuiApplication.primaryScreen().availableSize()))
        geometry, state = settings.layout("geometry"), settings.layout("state")
        if geometry is not None and state is not None:
            self.restoreGeometry(geometry)
            self.restoreState(state)

    def action(self, id: str) -> QAction:
        """Return the action of a command."""
        return self.actions_by_id[id]

    # -- making it ---------------------------------------------------------------------------------

    def _make_actions(self) -> None:
        for menu in MENUS:
            self.menus[menu] = self.menuBar().addMenu(menu)
        for command in COMMANDS:
            action = QAction(command.title, self)
            action.setObjectName(command.id)
            if command.key:
                # The key of that name beside the letters, and the one beside the digits.
                keys = dict.fromkeys((command.key, command.key.replace("Return", "Enter")))
                action.setShortcuts([QKeySequence(key) for key in keys])
            tip = command.tip or command.title.rstrip("…")
            key = action.shortcut().toString(QKeySequence.SequenceFormat.NativeText)
            action.setToolTip(f"{tip} ({key})" if key else tip)
            action.setStatusTip(tip)
            if command.checked is not None:
                action.setCheckable(True)
                action.setChecked(command.checked)
            if command.group:
                group = self.groups.setdefault(command.group, QActionGroup(self))
                group.addAction(action)
            self._menu(command.menu).addAction(action)
            self.actions_by_id[command.id] = action
            self.addAction(action)
        self.recent = QMenu("Open Recent", self)
        self.menus["File"].insertMenu(self.action("save"), self.recent)

    def _menu(self, path: str) -> QMenu:
        if path not in self.menus:
            parent, _, name = path.rpartition(" > ")
            self.menus[path] = self._menu(parent).addMenu(name)
        return self.menus[path]

    def _make_tool_bar(self) -> None:
        bar = QToolBar("Tools")
        bar.setObjectName("tools")
        bar.setMovable(False)
        bar.setIconSize(QSize(16, 16))
        for one in (None, *OVERLAYS):
            id = overlay_id(one.id if one else "none")
            self.overlays.addItem(one.title if one else "Plain", id)
        self.overlays.activated.connect(lambda row: self.action(self.overlays.itemData(row)).trigger())
        self.groups["overlay"].triggered.connect(
            lambda action: self.overlays.setCurrentIndex(self.overlays.findData(action.objectName()))
        )
        checked = self.groups["overlay"].checkedAction()
        self.overlays.setCurrentIndex(self.overlays.findData(checked.objectName() if checked else None))
        menu = ""
        for command in COMMANDS:
            if not command.tool:
                continue
            if menu and command.menu != menu:
                bar.addSeparator()
            if menu == "Edit" and command.menu == "View":
                bar.addWidget(QLabel(" Overlay "))
                bar.addWidget(self.overlays)
                bar.addSeparator()
            menu = command.menu
            bar.addAction(self.action(command.id))
        self.addToolBar(bar)

    def _arrange(self) -> None:
        centre = QWidget()
        column = QVBoxLayout(centre)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        row = QHBoxLayout()
        row.setSpacing(0)
        row.addWidget(self.view, 1)
        self.view.put_over(self.hint)
        row.addWidget(self.colour_bar)
        column.addLayout(row, 1)
        self.probe = QLabel(" ")
        self.probe.setContentsMargins(6, 2, 6, 2)
        # However long the text: it must not push the view about.
        self.probe.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)
        column.addWidget(self.probe)
        self.setCentralWidget(centre)
        left = QSplitter(Qt.Orientation.Vertical)
        left.addWidget(self.layers)
        left.addWidget(self.filters)
        left.setStretchFactor(1, 1)
        left.setSizes([130, 700])
        area = Qt.DockWidgetArea
        self.setCorner(Qt.Corner.BottomLeftCorner, area.LeftDockWidgetArea)
        self.setCorner(Qt.Corner.BottomRightCorner, area.RightDockWidgetArea)
        self.docks = {
            name: self._dock(name, widget, where)
            for name, widget, where in (
                ("Layers and filter", left, area.LeftDockWidgetArea),
                ("Regions", self.regions, area.LeftDockWidgetArea),
                ("History", self.history, area.RightDockWidgetArea),
                ("Numbers", self.numbers, area.RightDockWidgetArea),
                ("Recipe", self.recipe, area.RightDockWidgetArea),
                ("Log", self.log, area.RightDockWidgetArea),
                ("Histogram", self.histogram, area.BottomDockWidgetArea),
                ("Worst faces", self.worst, area.BottomDockWidgetArea),
                ("Cross-section", self.section, area.BottomDockWidgetArea),
                ("Measurements", self.measurements, area.BottomDockWidgetArea),
            )
        }
        docks = self.docks
        self.tabifyDockWidget(docks["Numbers"], docks["Recipe"])
        docks["Numbers"].raise_()
        for first, second in (("Histogram", "Cross-section"), ("Worst faces", "Measurements")):
            self.tabifyDockWidget(docks[first], docks[second])
            docks[first].raise_()
        self.tabifyDockWidget(docks["Layers and filter"], docks["Regions"])
        docks["Layers and filter"].raise_()
        self.resizeDocks(
            [docks["Layers and filter"], docks["History"]], [310, 340], Qt.Orientation.Horizontal
        )
        self.resizeDocks(
            [docks["History"], docks["Numbers"], docks["Log"]], [170, 420, 150], Qt.Orientation.Vertical
        )
        self.resizeDocks([docks["Histogram"], docks["Worst faces"]], [470, 460], Qt.Orientation.Horizontal)
        self.resizeDocks([docks["Histogram"]], [190], Qt.Orientation.Vertical)
        windows = self.menus["View"].addMenu("Panels")
        for dock in docks.values():
            windows.addAction(dock.toggleViewAction())
        self.figures = QLabel()
        self.figures.setMinimumWidth(1)
        self.figures.setContentsMargins(0, 0, 6, 0)
        self.statusBar().addPermanentWidget(self.figures)

    def _dock(self, name: str, widget: QWidget, area: Qt.DockWidgetArea) -> QDockWidget:
        dock = QDockWidget(name, self)
        dock.setObjectName(name)
        dock.setWidget(widget)
        self.addDockWidget(area, dock)
        return dock

    def show_panel(self, name: str) -> None:
        """Show one of the panels, before those that share its place."""
        self.docks[name].show()
        self.docks[name].raise_()

    # -- its own doings ----------------------------------------------------------------------------

    def set_theme(self, theme: Theme) -> None:
        """Show light or dark."""
        self.view.set_theme(theme)
        self.histogram.set_theme(theme)
        # Behind it is what a tool bar has no room for; its picture is black in the dark, too.
        for button in self.findChildren(QToolButton, "qt_toolbar_ext_button"):
            button.setIcon(QIcon())
            button.setText("»")

    def dragEnterEvent(self, event: QDragEnterEvent) -> None:  # noqa: N802
        """Take files."""
        if event.mimeData().hasUrls():
            event.acceptProposedAction()

    def dropEvent(self, event: QDropEvent) -> None:  # noqa: N802
        """Hand over the files dropped."""
        paths = [url.toLocalFile() for url in event.mimeData().urls() if url.isLocalFile()]
        event.acceptProposedAction()
        self.dropped.emit(paths)

    def closeEvent(self, event: QCloseEvent) -> None:  # noqa: N802
        """Ask whether the window may close, and let go of the graphics."""
        self.closing.emit(event)
        if event.isAccepted():
            self.settings.set_layout("geometry", self.saveGeometry())
            self.settings.set_layout("state", self.saveState())
            self.settings.save()
            self.view.close_view()
