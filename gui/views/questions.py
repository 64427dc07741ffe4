"""Questions that must be answered before anything is lost."""

from __future__ import annotations

from collections.abc import Sequence
from enum import StrEnum
from pathlib import Path

from PySide6.QtWidgets import QFileDialog, QMessageBox, QWidget


class Answer(StrEnum):
    """What to do with what is not saved."""

    SAVE = "save"
    DISCARD = "discard"
    CANCEL = "cancel"


_BUTTONS = {
    Answer.SAVE: QMessageBox.StandardButton.Save,
    Answer.DISCARD: QMessageBox.StandardButton.Discard,
    Answer.CANCEL: QMessageBox.StandardButton.Cancel,
}


def ask_unsaved(parent: QWidget, names: Sequence[str], save: str) -> Answer:
    """Ask what to do with changes; `save` says what saving would do."""
    box = QMessageBox(QMessageBox.Icon.Warning, "Unsaved changes", "", parent=parent)
    box.setText(f"{', '.join(names)}: changed, not saved.")
    box.setInformativeText(save)
    for button in _BUTTONS.values():
        box.addButton(button)
    box.setDefaultButton(_BUTTONS[Answer.SAVE])
    box.setEscapeButton(_BUTTONS[Answer.CANCEL])
    given = box.exec()
    return next((answer for answer, button in _BUTTONS.items() if button == given), Answer.CANCEL)


def ask_losses(parent: QWidget, name: str, notes: Sequence[str]) -> bool:
    """Ask whether to write a file that does not hold everything."""
    box = QMessageBox(QMessageBox.Icon.Warning, "Not everything can be saved", "", parent=parent)
    box.setText(f"{name} will not hold all of the mesh.")
    box.setInformativeText("\n".join([*notes, "Cancel, and save as .vtp, to keep everything."]))
    save = box.addButton("Save Anyway", QMessageBox.ButtonRole.AcceptRole)
    box.setDefaultButton(box.addButton(QMessageBox.StandardButton.Cancel))
    box.exec()
    return box.clickedButton() is save


def ask_missing(parent: QWidget, path: Path) -> Path | None:
    """Ask where a mesh is; return its file, or None to do without.

    Raises
    ------
    InterruptedError
        The session shall not be opened.
    """
    box = QMessageBox(QMessageBox.Icon.Warning, "Missing mesh", "", parent=parent)
    box.setText(f"{path.name} is not where it was.")
    box.setInformativeText(f"The session looked for {path}.")
    locate = box.addButton("Locate…", QMessageBox.ButtonRole.AcceptRole)
    skip = box.addButton("Skip", QMessageBox.ButtonRole.DestructiveRole)
    box.addButton(QMessageBox.StandardButton.Cancel)
    box.exec()
    if box.clickedButton() is skip:
        return None
    name = ""
    if box.clickedButton() is locate:
        name, _ = QFileDialog.getOpenFileName(parent, f"Where is {path.name}?", str(path.parent))
    if not name:
        raise InterruptedError
    return Path(name)


def ask_recovery(parent: QWidget, name: str, when: str) -> Answer:
    """Ask whether to recover what an application that ended unexpectedly had not saved.

    SAVE: recover it; DISCARD: throw it away; CANCEL: ask again at the next start.
    """
    box = QMessageBox(QMessageBox.Icon.Question, "Recovery", "", parent=parent)
    box.setText(f"vtksmooth ended unexpectedly with unsaved changes: {name or 'no layers'}, {when}.")
    box.setInformativeText("Recover them? “Later” keeps them until the next start.")
    recover = box.addButton("Recover", QMessageBox.ButtonRole.AcceptRole)
    discard = box.addButton(QMessageBox.StandardButton.Discard)
    box.addButton("Later", QMessageBox.ButtonRole.RejectRole)
    box.setDefaultButton(recover)
    box.exec()
    if box.clickedButton() is recover:
        return Answer.SAVE
    return Answer.DISCARD if box.clickedButton() is discard else Answer.CANCEL
