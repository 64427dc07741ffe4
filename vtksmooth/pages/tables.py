"""Figures as words and rows: the papers' tables of quality and of differences."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..kernels.measures.aspect_ratio import BINS
from ..report import figure

_BIN_NAMES = ["k < 0", *(f"{low:g} <= k < {low + 0.2:.1f}" for low in BINS[:-1]), "0.8 <= k <= 1"]

Summary = dict[str, Any]
Rows = list[list[str]]


def counted(summary: Summary) -> str:
    """Return how many points and faces a mesh has."""
    kinds = [f"{count} {kind}s" for kind, count in summary["cells"].items() if count]
    return f"{summary['points']} points, {', '.join(kinds)}, {'closed' if summary['closed'] else 'open'}"


def quality_rows(states: Sequence[Summary]) -> Rows:
    """Return the distribution of k, one column for each state (the papers' first table)."""
    ratios = [state["aspect_ratio"] for state in states]
    return [
        *(
            [f"{name}, % of the faces", *(f"{ratio['histogram'][i]:.2f}" for ratio in ratios)]
            for i, name in enumerate(_BIN_NAMES)
        ),
        ["mean k", *(f"{ratio['mean']:.3f}" for ratio in ratios)],
        ["smallest k", *(f"{ratio['min']:.4f}" for ratio in ratios)],
        ["inverted faces", *(str(state["inverted"]) for state in states)],
        ["volume", *(volume(state) for state in states)],
    ]


def change_rows(states: Sequence[Summary]) -> Rows:
    """Return the differences from the original, one column for each state (the papers' second table)."""

    def row(name: str, key: str, part: str) -> list[str]:
        return [name, *(number(state[key][part]) for state in states)]

    ways = [
        ("result to original", [state["deviation"] for state in states]),
        ("original to result", [state["deviation"]["back"] for state in states]),
    ]
    return [
        row("dihedral angles, largest change, degrees", "dihedral_change", "max"),
        row("dihedral angles, mean change, degrees", "dihedral_change", "mean"),
        row("vertex normals, largest change, degrees", "normal_deviation", "max"),
        row("vertex normals, mean change, degrees", "normal_deviation", "mean"),
        ["volume, change in %", *(volume_change(state) for state in states)],
        *(
            [f"{which} distance, {way}, % of the diagonal", *(number(one[part], 100.0) for one in figures)]
            for way, figures in ways
            for which, part in (("largest", "max_relative"), ("mean", "mean_relative"))
        ),
    ]


def number(value: float | None, factor: float = 1.0) -> str:
    """Return a figure with three decimals; a dash where there is none."""
    return "-" if value is None else f"{factor * value:.3f}"


def volume(summary: Summary) -> str:
    """Return the volume, if there is one."""
    return "open" if summary["volume"] is None else figure(summary["volume"], 6)


def volume_change(summary: Summary) -> str:
    """Return by how much the volume has changed, in percent."""
    change = summary["volume_change_percent"]
    return "open" if change is None else f"{change:+.3f}"


def markdown(head: list[str], rows: Rows) -> list[str]:
    """Return the lines of a table in Markdown, which a terminal can show as well."""
    widths = [max(len(row[i]) for row in (head, *rows)) for i in range(len(head))]

    def line(cells: list[str]) -> str:
        padded = [cells[0].ljust(widths[0])]
        padded += [cell.rjust(width) for cell, width in zip(cells[1:], widths[1:], strict=True)]
        return f"| {' | '.join(padded)} |"

    rule = ["-" * widths[0], *("-" * (width - 1) + ":" for width in widths[1:])]
    return [line(head), line(rule), *map(line, rows)]


def verdict(before: Summary, after: Summary) -> list[str]:
    """Say what got better and what did not, from the figures alone."""
    old, new = before["aspect_ratio"], after["aspect_ratio"]

    def compared(name: str, old: float, new: float, digits: int) -> str:
        a, b = f"{old:.{digits}f}", f"{new:.{digits}f}"
        if a == b:
            return f"{name} stayed at {a}"
        return f"{name} {'rose' if new > old else 'fell'} from {a} to {b}"

    return [
        compared("the share of poor faces (k < 0.2)", poor(before), poor(after), 1) + " %",
        compared("the mean k", old["mean"], new["mean"], 3),
        compared("the smallest k", old["min"], new["min"], 3),
        "the result's points are at most {} % of the diagonal from the original surface, the original's "
        "at most {} % from the result".format(*(figure(100 * part, 2) for part in largest_deviations(after))),
    ]


def largest_deviations(summary: Summary) -> tuple[float, float]:
    """Return the largest distance from the result to the original and back, in parts of the diagonal."""
    deviation = summary["deviation"]
    return deviation["max_relative"], deviation["back"]["max_relative"]


def poor(summary: Summary) -> float:
    """Return the share of faces with k < 0.2, in percent."""
    return float(sum(summary["aspect_ratio"]["histogram"][:2]))
