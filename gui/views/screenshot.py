"""What a screenshot shall be like."""

from __future__ import annotations

from PySide6.QtWidgets import QCheckBox, QDialog, QDialogButtonBox, QFormLayout, QSpinBox, QWidget

from .wheel import only_with_focus


class ScreenshotDialog(QDialog):
    """Size and background of a picture."""

    def __init__(self, width: int, height: int, parent: QWidget) -> None:
        super().__init__(parent)
        self.setWindowTitle("Screenshot")
        self.width_box, self.height_box = only_with_focus(QSpinBox()), only_with_focus(QSpinBox())
        for box, value in ((self.width_box, width), (self.height_box, height)):
            box.setRange(16, 16384)
            box.setSuffix(" px")
            box.setValue(value)
        self.transparent = QCheckBox("Transparent background")
        self.with_bar = QCheckBox("With the colour bar")
        self.with_bar.setChecked(True)
        buttons = QDialogButtonBox(
            QDialogButtonBox.StandardButton.Save | QDialogButtonBox.StandardButton.Cancel
        )
        buttons.accepted.connect(self.accept)
        buttons.rejected.connect(self.reject)
        form = QFormLayout(self)
        form.addRow("Width", self.width_box)
        form.addRow("Height", self.height_box)
        form.addRow(self.transparent)
        form.addRow(self.with_bar)
        form.addRow(buttons)
