"""Notifications: a line or two over the view that say what happened, and get in nobody's way."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QObject, Qt, QTimer
from PySide6.QtWidgets import QFrame, QHBoxLayout, QLabel, QSizePolicy, QToolButton, QWidget

#: What is longer has a button that unfolds it.
_LINES = 2
_ANY_HEIGHT = (1 << 24) - 1  # Qt's QWIDGETSIZE_MAX
_STAY = {"note": 8_000, "warning": 15_000, "error": 0}
_LOOK = {"note": "#0b6fa4", "warning": "#9a6700", "error": "#b3261e"}


class Notification(QFrame):
    """Two lines with a close button; errors stay until they are closed, and are shown whole.

    It lies over the upper edge of a view: a view that made room for it would be drawn anew.
    """

    def __init__(self, view: QWidget) -> None:
        super().__init__(view)
        self._view = view
        view.installEventFilter(self)
        self.label = QLabel(wordWrap=True, alignment=Qt.AlignmentFlag.AlignTop)
        self.label.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
        #: Unfolds what is longer than the view has room for.
        self.more = QToolButton(autoRaise=True)
        self.more.clicked.connect(lambda: self._unfold(not self._whole))
        size = self.more.sizePolicy()
        size.setRetainSizeWhenHidden(True)  # the text has the same width with it and without
        self.more.setSizePolicy(size)
        close = QToolButton(autoRaise=True)
        close.setText("✕")
        close.clicked.connect(self.hide)
        self._line = QHBoxLayout(self)
        self._line.setContentsMargins(10, 4, 6, 4)
        self._line.addWidget(self.label, 1)
        for button in (self.more, close):
            self._line.addWidget(button)
        self._timer = QTimer(self, singleShot=True)
        self._timer.timeout.connect(self.hide)
        self.level = ""
        self._unfold(False)
        self.hide()

    @property
    def text(self) -> str:
        """What is said, or an empty text."""
        return "" if self.isHidden() else self.label.text()

    def say(self, text: str, level: str = "note") -> None:
        """Show a "note", a "warning" or an "error"."""
        self.label.setText(text)
        if level != self.level:  # each time gives the widgets palettes of their own, whose drawings Qt keeps
            self.level = level
            self.setStyleSheet(
                f"Notification {{ background: {_LOOK[level]}; }} QLabel, QToolButton {{ color: white; }}"
            )
        self._unfold(level == "error")
        self.show()
        self.raise_()
        if _STAY[level]:
            self._timer.start(_STAY[level])

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        """Follow the view's width."""
        if event.type() == QEvent.Type.Resize:
            self._place()
        return False

    def _unfold(self, whole: bool) -> None:
        self._whole = whole
        self.more.setText("▴" if whole else "▾")
        self.more.setToolTip("Show less" if whole else "Show all of it")
        self._timer.stop()  # whoever reads takes the time
        self._place()

    def _place(self) -> None:
        width, lines = self._view.width(), _LINES * self.label.fontMetrics().lineSpacing()
        self.label.setMaximumHeight(_ANY_HEIGHT if self._whole else lines)
        self.setGeometry(0, 0, width, self._line.totalHeightForWidth(width))
        self._line.activate()
        self.more.setVisible(self.label.heightForWidth(self.label.width()) > lines)
