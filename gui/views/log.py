"""The log: what was done, as the lines of a Python program."""

from __future__ import annotations

from PySide6.QtGui import QFontDatabase
from PySide6.QtWidgets import QPlainTextEdit


class Log(QPlainTextEdit):
    """Lines to read and to copy."""

    def __init__(self) -> None:
        super().__init__(readOnly=True)
        self.setLineWrapMode(QPlainTextEdit.LineWrapMode.NoWrap)
        self.setFont(QFontDatabase.systemFont(QFontDatabase.SystemFont.FixedFont))
        self.setPlaceholderText("What you do appears here as Python.")

    def show_lines(self, lines: list[str]) -> None:
        """Show the program."""
        text = "\n".join(lines)
        if text != self.toPlainText():
            self.setPlainText(text)
            bar = self.verticalScrollBar()
            bar.setValue(bar.maximum())
