"""The application: the document, its window, and what joins them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from PySide6.QtCore import QObject, Slot
from PySide6.QtGui import QCloseEvent, QColor, QGuiApplication, QImage, QPainter
from PySide6.QtWidgets import QDialog, QFileDialog, QInputDialog

from ..commands import COMMANDS
from ..model import numbers
from ..model.document import Document
from ..model.layer import Layer, Role
from ..settings import Settings
from ..views.about import About
from ..views.cheat_sheet import CheatSheet
from ..views.main_window import MainWindow
from ..views.questions import Answer
from ..views.screenshot import ScreenshotDialog
from .batches import Batches
from .comparing import Comparing
from .display import Display
from .files import Files
from .filtering import Filtering
from .garbage import Garbage
from .jobs import Jobs
from .measuring import Measuring
from .recipes import Recipes
from .regions import Regions
from .sessions import Sessions

#: Switches whose position is remembered.
_REMEMBERED = ("dark", "edges", "bands", "parallel", "bad_faces", "papers_bins")


class Application(QObject):
    """Everything, made and joined."""

    def __init__(self, settings: Settings) -> None:
        super().__init__()
        self.settings = settings
        self._garbage = Garbage(self)
        self.document = Document()
        self.document.history.limit = int(settings.get("memory", self.document.history.limit))
        self.window = MainWindow(settings)
        self.jobs = Jobs(self)
        self.files = Files(self.document, self.window, self.jobs, settings)
        self.filtering = Filtering(self.document, self.window, self.jobs, settings)
        self.display = Display(self.document, self.window, self.jobs, settings)
        self.recipes = Recipes(self.document, self.window, self.jobs, settings)
        self.batches = Batches(self.recipes.draft, self.window, self.jobs, settings)
        self.regions = Regions(self.document, self.window, self.jobs, self.display, settings)
        self.measuring = Measuring(self.document, self.window, self.jobs, self.display)
        self.comparing = Comparing(self.document, self.window, self.display)
        self.sessions = Sessions(
            self.document, self.window, self.jobs, settings, self.files, self.filtering, self.display,
            self.recipes.draft,
        )  # fmt: skip
        self.filtering.previewed.connect(self.display.set_preview)
        self.batches.opened.connect(self.files.open_paths)
        self.files.opened.connect(self.display.bring_into_view)
        self.files.recipe_asked.connect(self.recipes.load)
        own = {**self.display.commands(), **self.measuring.commands()}
        for command in COMMANDS:
            if command.id not in own:
                self.window.action(command.id).triggered.connect(self._handler(command.id))
        window = self.window
        window.closing.connect(self._closing)
        window.layers.activated_layer.connect(self.document.activate)
        window.layers.visibility_asked.connect(self.document.set_visible)
        window.layers.role_asked.connect(self._set_role)
        window.history.asked.connect(self._go)
        self.document.changed.connect(self.refresh)
        self.sessions.changed.connect(self._show_title)
        self._dialogs: dict[str, QDialog] = {}
        self.refresh()

    def _handler(self, id: str) -> Callable[..., Any]:
        own = self, self.files, self.filtering, self.display, self.recipes, self.batches
        for controller in (*own, self.regions, self.measuring, self.comparing, self.sessions):
            method = getattr(controller, id, None)
            if method is not None:
                return lambda *_: method()
        raise LookupError(f"No controller has the command {id}.")

    def refresh(self) -> None:
        """Show layers and history as they are now."""
        document, window = self.document, self.window
        layer = document.active
        window.layers.show_layers(document.layers, layer)
        window.history.show_history(document.history)
        window.action("undo").setEnabled(document.history.can_undo)
        window.action("redo").setEnabled(document.history.can_redo)
        for id in ("save", "save_as", "close_layer", "copy_numbers", "screenshot"):
            window.action(id).setEnabled(layer is not None)
        self._show_title()

    @Slot()
    def _show_title(self) -> None:
        self.window.setWindowTitle(self.sessions.title())

    # -- commands ----------------------------------------------------------------------------------

    def undo(self) -> None:
        """Undo the last step."""
        self._go(self.document.history.index - 1)

    def redo(self) -> None:
        """Do again what was undone."""
        self._go(self.document.history.index + 1)

    def close_layer(self) -> None:
        """Close the active layer."""
        layer = self.document.active
        if layer is None:
            return
        if layer.unsaved and self.sessions.modified:
            answer = self.sessions.ask_unsaved([layer.name], "Save writes the mesh to a file.")
            if answer is Answer.SAVE:
                self.files.save(lambda: self._close(layer))
            if answer is not Answer.DISCARD:
                return
        self._close(layer)

    def _close(self, layer: Layer) -> None:
        self.jobs.cancel("apply")
        self.document.close(layer)

    def quit(self) -> None:
        """Close the window."""
        self.window.close()

    def copy_numbers(self) -> None:
        """Put the figures on the clipboard, as Markdown."""
        layer, subject = self.document.active, self.display.subject
        if layer is not None and subject is not None:
            figures = numbers.rows(subject, self.document.unit)
            QGuiApplication.clipboard().setText(numbers.markdown(layer.name, figures))
            self.window.notification.say("The numbers are on the clipboard, as a Markdown table.")

    def memory_limit(self) -> None:
        """Ask how much memory the history may take."""
        history = self.document.history
        value, given = QInputDialog.getInt(
            self.window, "Memory of the history", "Megabytes, beyond which the oldest steps stay done:",
            history.limit >> 20, 1, 1 << 20,
        )  # fmt: skip
        if given:
            self.settings.set("memory", value << 20)
            self.document.set_memory_limit(value << 20)

    def cheat_sheet(self) -> None:
        """Show all keys, or hide them."""
        self._toggle("cheat_sheet", lambda: CheatSheet(self.window))

    def about(self) -> None:
        """Show the versions."""
        window = self.window.view.plotter.render_window
        lines = [line.strip() for line in window.ReportCapabilities().splitlines()]
        graphics = [line for line in lines if line.startswith(("OpenGL renderer", "OpenGL version"))]
        self._toggle("about", lambda: About("\n".join(graphics), self.window))

    def _toggle(self, name: str, make: Callable[[], QDialog]) -> None:
        open_now = self._dialogs.get(name)
        if open_now is not None and open_now.isVisible():
            open_now.close()
            return
        self._dialogs[name] = make()
        self._dialogs[name].show()

    def screenshot(self) -> None:
        """Ask for size and file, and write a picture of the view."""
        size = self.window.view.plotter.render_window.GetSize()
        dialog = ScreenshotDialog(size[0], size[1], self.window)
        if dialog.exec() != QDialog.DialogCode.Accepted:
            return
        name, _ = QFileDialog.getSaveFileName(
            self.window, "Save picture", "vtksmooth.png", "Pictures (*.png *.jpg)"
        )
        if name:
            self.write_picture(
                Path(name), dialog.width_box.value(), dialog.height_box.value(),
                dialog.transparent.isChecked(), dialog.with_bar.isChecked(),
            )  # fmt: skip

    def picture(self, width: int, height: int, transparent: bool = False, with_bar: bool = True) -> QImage:
        """Return a picture of the view, with the colour bar drawn into it."""
        image = self.window.view.picture(width, height, transparent)
        bar = self.window.colour_bar
        if with_bar and bar.isVisibleTo(self.window):
            painter = QPainter(image)
            painter.setRenderHint(QPainter.RenderHint.Antialiasing)
            factor = height / max(1, self.window.view.height())
            painter.scale(factor, factor)
            painter.translate(width / factor - bar.width(), 0)
            dark = self.window.action("dark").isChecked() and not transparent
            bar.draw(painter, QColor("#f0f0f0" if dark else "#15171a"))
            painter.end()
        return image

    def write_picture(self, path: Path, width: int, height: int, transparent: bool, with_bar: bool) -> None:
        """Write a picture of the view."""
        if self.picture(width, height, transparent, with_bar).save(str(path)):
            self.window.notification.say(f"Wrote {path.name}.")
        else:
            self.window.notification.say(
                f"Cannot write {path}; choose another folder, and .png or .jpg.", "error"
            )

    # -- the list of layers and the history --------------------------------------------------------

    @Slot(object, object)
    def _set_role(self, layer: Layer, role: Role) -> None:
        self.document.set_role(layer, role)

    @Slot(int)
    def _go(self, index: int) -> None:
        history = self.document.history
        if index == history.index or not history.first <= index <= len(history.steps):
            return
        self.jobs.cancel("apply")
        layers, forth = self.document.layers, index > history.index
        self.document.go(index)
        gone = [layer.name for layer in layers if layer.state is None]
        if gone:
            way = "Undo" if forth else "Redo"
            self.window.notification.say(f"Closed {', '.join(gone)}; {way} opens it again.", "warning")

    # -- the end -----------------------------------------------------------------------------------

    @Slot(object)
    def _closing(self, event: QCloseEvent) -> None:
        if not self.sessions.may_lose(self.window.close):
            event.ignore()
            return
        for id in _REMEMBERED:
            self.settings.set(id, self.window.action(id).isChecked())
        self.filtering.remember()
        self.window.hide()  # what a worker is in the middle of may take a second to end
        self.jobs.close()
        self.sessions.close()
