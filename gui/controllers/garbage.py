"""Garbage: what holds itself by its own references is let go of in the thread of the windows."""

from __future__ import annotations

import gc

from PySide6.QtCore import QObject, QTimer, Slot

#: How often garbage is looked for, milliseconds, and every how many times among what is old too.
_INTERVAL, _OLD = 1000, 10


class Garbage(QObject):
    """Collects garbage, in Python's place.

    Python collects in the thread that happens to make the next object, be it a worker's. What it finds may
    be Qt's or VTK's: windows, timers, contexts of OpenGL. Destroyed in another thread than their own, they
    take the program down, at once or later.
    """

    def __init__(self, parent: QObject) -> None:
        super().__init__(parent)
        gc.disable()
        self._turns = 0
        timer = QTimer(self, interval=_INTERVAL)
        timer.timeout.connect(self._collect)
        timer.start()

    @Slot()
    def _collect(self) -> None:
        if gc.get_count()[0] > gc.get_threshold()[0]:
            self._turns += 1
            gc.collect(2 if self._turns % _OLD == 0 else 1)
