"""The figures of a mesh, before and after, for the panel, the status bar and Markdown."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from .overlays import Subject

#: The papers' bins of k.
BINS = (-1.0, 0.0, 0.2, 0.4, 0.6, 0.8, 1.0)
_BIN_NAMES = ("k < 0", "0 to 0.2", "0.2 to 0.4", "0.4 to 0.6", "0.6 to 0.8", "0.8 to 1")


@dataclass(frozen=True)
class Row:
    """A figure: its name, before and after ("" where it does not exist)."""

    name: str
    before: str
    after: str


def number(value: Any) -> str:
    """Return a number as people read it."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int):
        return f"{value:,}"
    return f"{value:.4g}"


def rows(subject: Subject) -> list[Row]:
    """Return all figures that have been computed."""
    after = subject.state.summaries.get(("quality", subject.reference))
    if after is None:
        return []
    changed = subject.before is not None and subject.before is not subject.state
    before: dict[str, Any] = subject.before.summaries.get(("quality", None), {}) if changed else {}  # type: ignore[union-attr]
    found = [
        Row(name, number(get(before)) if before else "", number(get(after)))
        for name, get in (
            ("points", lambda s: s["points"]),
            ("triangles", lambda s: s["cells"]["triangle"]),
            ("quadrilaterals", lambda s: s["cells"]["quad"]),
            ("larger polygons", lambda s: s["cells"]["polygon"]),
            ("closed", lambda s: s["closed"]),
            ("volume", lambda s: s["volume"]),
            ("smallest k", lambda s: s["aspect_ratio"]["min"]),
            ("mean k", lambda s: s["aspect_ratio"]["mean"]),
            ("inverted", lambda s: s["inverted"]),
        )
    ]
    containment = subject.state.summaries.get(("containment", subject.space))
    if containment:
        found += [
            Row("vertices outside the space", "", number(containment["vertices_outside"])),
            Row("triangles crossing it", "", number(containment["triangles_crossing"])),
        ]
    for bin, name in enumerate(_BIN_NAMES):
        share = [f"{s['aspect_ratio']['histogram'][bin]:.2f} %" if s else "" for s in (before, after)]
        found.append(Row(f"faces, {name}", *share))
    comparison = subject.state.summaries.get(("comparison", subject.before))
    if comparison and changed:
        volume = comparison["volume_change_percent"]
        found += [
            Row("volume change", "", "" if volume is None else f"{volume:+.4g} %"),
            Row("swept volume", "", number(comparison["swept_volume"])),
            Row("normals, max", "", f"{comparison['normal_deviation']['max']:.4g}°"),
            Row("normals, mean", "", f"{comparison['normal_deviation']['mean']:.4g}°"),
            Row("dihedral angles, max", "", f"{comparison['dihedral_change']['max']:.4g}°"),
            Row("dihedral angles, mean", "", f"{comparison['dihedral_change']['mean']:.4g}°"),
            Row("deviation, max", "", number(comparison["deviation"]["max"])),
            Row("of the diagonal", "", f"{100 * comparison['deviation']['max_relative']:.4g} %"),
        ]
    return [row for row in found if row.before or row.after]


def line(figures: dict[str, Any]) -> str:
    """Return the figures of a filter in one line."""
    words = []
    for name, value in figures.items():
        if isinstance(value, dict):
            words.append(f"{name} ({line(value)})")
        elif isinstance(value, (int, float)):
            words.append(f"{name} {number(value)}")
    return ", ".join(words).replace("_", " ")


def markdown(name: str, figures: list[Row]) -> str:
    """Return the figures as a Markdown table."""
    lines = [f"| {name} | before | after |", "| --- | ---: | ---: |"]
    return "\n".join(lines + [f"| {row.name} | {row.before} | {row.after} |" for row in figures]) + "\n"


def status(subject: Subject) -> list[str]:
    """Return the figures of the status bar."""
    state = subject.state
    found = [f"{number(state.n_points)} points", f"{number(state.n_faces)} faces"]
    quality = state.summaries.get(("quality", subject.reference))
    if quality is None:
        return found
    changed = subject.before is not state
    comparison = state.summaries.get(("comparison", subject.before)) if changed else None
    if quality["closed"]:
        drift = ""
        if comparison and comparison["volume_change_percent"] is not None:
            drift = f" ({comparison['volume_change_percent']:+.3g} %)"
        found.append(f"closed, volume {number(quality['volume'])}{drift}")
    else:
        found.append("open")
    found.append(f"worst k {quality['aspect_ratio']['min']:.3f}")
    found.append(f"{number(quality['inverted'])} inverted")
    if comparison:
        found.append(f"largest deviation {number(comparison['deviation']['max'])}")
    found.append("lengths in model units")
    return found
