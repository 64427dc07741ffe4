"""The figures of a mesh, before and after, for the panel, the status bar and Markdown."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from vtksmooth.report import figure

from .difference import PERCENTILES
from .overlays import Subject
from .units import labelled, powered, quantity

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
    return figure(value)


def rows(subject: Subject, unit: str = "") -> list[Row]:
    """Return all figures that have been computed; the names of lengths and volumes name their unit."""
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
            ("smallest k", lambda s: s["aspect_ratio"]["min"]),
            ("mean k", lambda s: s["aspect_ratio"]["mean"]),
            ("inverted", lambda s: s["inverted"]),
        )
    ]
    volumes = [number(s.get("volume")) for s in (before, after)]
    found.insert(5, Row(labelled("volume", powered(unit, 3)), *volumes))
    states = (subject.before if changed else None, subject.state)
    containment = [s.summaries.get(("containment", subject.space), {}) if s else {} for s in states]
    if containment[1]:
        found += [
            Row(name, *(number(summary.get(key)) for summary in containment))
            for name, key in (
                ("vertices outside the space", "vertices_outside"),
                ("triangles crossing it", "triangles_crossing"),
            )
        ]
    for bin, name in enumerate(_BIN_NAMES):
        share = [f"{s['aspect_ratio']['histogram'][bin]:.2f} %" if s else "" for s in (before, after)]
        found.append(Row(f"faces, {name}", *share))
    comparison = subject.state.summaries.get(("comparison", subject.before))
    if comparison and changed:
        volume = comparison["volume_change_percent"]
        found += [
            Row("volume change", "", "" if volume is None else f"{figure(volume, 4, '+')} %"),
            Row(labelled("swept volume", powered(unit, 3)), "", number(comparison["swept_volume"])),
            Row("normals, max", "", f"{figure(comparison['normal_deviation']['max'])}°"),
            Row("normals, mean", "", f"{figure(comparison['normal_deviation']['mean'])}°"),
            Row("dihedral angles, max", "", f"{figure(comparison['dihedral_change']['max'])}°"),
            Row("dihedral angles, mean", "", f"{figure(comparison['dihedral_change']['mean'])}°"),
            *(
                row
                for way, figures in (
                    ("deviation", comparison["deviation"]),
                    ("deviation back", comparison["deviation"]["back"]),
                )
                for row in (
                    Row(labelled(f"{way}, max", unit), "", number(figures["max"])),
                    Row(labelled(f"{way}, mean", unit), "", number(figures["mean"])),
                    Row(f"{way}, max, of the diagonal", "", f"{figure(100 * figures['max_relative'])} %"),
                )
            ),
        ]
    found = [*_difference(subject, unit), *found]
    rare = ("quadrilaterals", "larger polygons")
    return [
        row
        for row in found
        if (row.before or row.after) and not (row.name in rare and {row.before, row.after} <= {"", "0"})
    ]


def _length(value: float | None, unit: str, power: int = 1) -> str:
    return quantity(number(value), powered(unit, power))


def _difference(subject: Subject, unit: str) -> list[Row]:
    """Return how far the mesh, and the one before, are from another layer."""
    states = (subject.before if subject.before is not subject.state else None, subject.state)
    sides = [s.summaries.get(("difference", subject.other), {}) if s else {} for s in states]
    if not sides[1]:
        return []
    how = "point by point" if sides[1]["point_by_point"] else "to its surface"
    figures = {
        "mean": [side.get("mean") for side in sides],
        "RMS": [side.get("rms") for side in sides],
        **{
            f"{share} %": [side["percentiles"][share] if side else None for side in sides]
            for share in PERCENTILES
        },
        "max": [side.get("max") for side in sides],
        "back, max": [side.get("back") for side in sides],
    }
    return [
        Row("other layer", "", how),
        *(
            Row(labelled(f"other layer, {name}", unit), *map(number, values))
            for name, values in figures.items()
        ),
    ]


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


def status(subject: Subject, unit: str = "") -> list[str]:
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
            drift = f" ({figure(comparison['volume_change_percent'], 3, '+')} %)"
        found.append(f"closed, volume {_length(quality['volume'], unit, 3)}{drift}")
    else:
        found.append("open")
    found.append(f"worst k {quality['aspect_ratio']['min']:.3f}")
    found.append(f"{number(quality['inverted'])} inverted")
    if comparison:
        found.append(f"largest deviation {_length(comparison['deviation']['max'], unit)}")
    found.append(f"lengths in {unit or 'model units'}")
    return found
