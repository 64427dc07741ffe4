"""About the application: versions, for a report of a defect."""

from __future__ import annotations

import platform
from importlib.metadata import PackageNotFoundError, version

from PySide6.QtGui import QFontDatabase, QGuiApplication
from PySide6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QLabel,
    QPlainTextEdit,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from vtksmooth.jit.parallel import number_of_threads

_PACKAGES = ("vtksmooth", "vtk", "pyvista", "pyvistaqt", "PySide6-Essentials", "pyqtgraph", "numpy", "numba")


def versions(graphics: str) -> str:
    """Return what a report of a defect needs to say about this installation."""
    lines = []
    for package in _PACKAGES:
        try:
            lines.append(f"{package} {version(package)}")
        except PackageNotFoundError:
            lines.append(f"{package} (not found)")
    lines += [
        f"Python {platform.python_version()}, {platform.platform()}",
        f"{number_of_threads()} threads",
        graphics,
    ]
    return "\n".join(line for line in lines if line)


class About(QDialog):
    """Versions to read and to copy."""

    def __init__(self, graphics: str, parent: QWidget) -> None:
        super().__init__(parent)
        self.setWindowTitle("About vtksmooth")
        self.text = versions(graphics)
        layout = QVBoxLayout(self)
        layout.addWidget(QLabel("<h2>vtksmooth</h2>Smoothing of surface meshes that keeps the surface."))
        layout.addWidget(QLabel("Please put these lines into a report of a defect:"))
        box = QPlainTextEdit(self.text, readOnly=True)
        box.setFont(QFontDatabase.systemFont(QFontDatabase.SystemFont.FixedFont))
        layout.addWidget(box)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        copy = QPushButton("Copy")
        copy.clicked.connect(lambda: QGuiApplication.clipboard().setText(self.text))
        buttons.addButton(copy, QDialogButtonBox.ButtonRole.ActionRole)
        buttons.rejected.connect(self.reject)
        layout.addWidget(buttons)
        self.resize(520, 380)
