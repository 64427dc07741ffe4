"""What is remembered from one start to the next."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from PySide6.QtCore import QByteArray, QSettings, QStandardPaths

_RECENT = 10


class Settings:
    """Typed access to QSettings: everything but the window's layout is kept as JSON.

    Parameters
    ----------
    file : path-like, optional
        File to keep the settings in, with the state in a folder beside it; without, the usual places
        of the system.
    """

    def __init__(self, file: Path | None = None) -> None:
        places = QStandardPaths.StandardLocation
        if file is None:
            self._store = QSettings("vtksmooth", "vtksmooth-gui")
            self._folder = Path(QStandardPaths.writableLocation(places.GenericStateLocation)) / "vtksmooth"
        else:
            self._store = QSettings(str(file), QSettings.Format.IniFormat)
            self._folder = file.with_suffix(".state")

    def get(self, key: str, default: Any) -> Any:
        """Return the value kept under `key`, or the default."""
        text = self._store.value(key)
        try:
            return default if text is None else json.loads(str(text))
        except ValueError:
            return default  # written by another version

    def set(self, key: str, value: Any) -> None:
        """Keep a value that JSON can hold."""
        self._store.setValue(key, json.dumps(value))

    def layout(self, key: str) -> QByteArray | None:
        """Return a layout of the window."""
        value = self._store.value(f"layout/{key}")
        return value if isinstance(value, QByteArray) else None

    def set_layout(self, key: str, value: QByteArray) -> None:
        """Keep a layout of the window."""
        self._store.setValue(f"layout/{key}", value)

    @property
    def state_folder(self) -> Path:
        """Where to keep what a crash must not destroy."""
        return self._folder

    @property
    def recent(self) -> list[str]:
        """The files opened last, the last first."""
        return [str(path) for path in self.get("recent", [])]

    def add_recent(self, path: Path) -> None:
        """Put a file first among the recent ones."""
        name = str(path.resolve())
        self.set("recent", [name, *(other for other in self.recent if other != name)][:_RECENT])

    def remove_recent(self, path: Path) -> None:
        """Forget a file that could not be opened."""
        self.set("recent", [other for other in self.recent if other != str(path.resolve())])

    def save(self) -> None:
        """Write everything to disk."""
        self._store.sync()
