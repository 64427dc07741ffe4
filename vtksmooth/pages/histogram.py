"""The histogram of the aspect ratio k, before and after: counted, and drawn as SVG."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

#: Bins of k from 0 to 1; faces with k < 0 have one of their own before these.
N_BINS = 20

#: Colours of before and after.
BEFORE, AFTER = "#b8b8b8", "#2166ac"

_WIDTH, _HEIGHT, _LEFT, _RIGHT, _TOP, _BOTTOM = 900.0, 280.0, 52.0, 8.0, 26.0, 44.0


def shares(k: npt.NDArray[np.floating[Any]]) -> list[float]:
    """Return how many percent of the faces are in each bin: k < 0, then N_BINS from 0 to 1.

    Parameters
    ----------
    k : (m,) float
        Aspect ratios; not a number counts as below 0.

    Examples
    --------
    >>> import numpy as np
    >>> shares(np.array([-0.5, 0.0, 0.99, 1.0]))[::20]
    [25.0, 50.0]
    """
    bins = np.clip(np.floor(np.nan_to_num(k, nan=-1.0) * N_BINS), -1, N_BINS - 1).astype(np.int64) + 1
    counts = np.bincount(bins, minlength=N_BINS + 1)
    result: list[float] = (100.0 * counts / max(len(k), 1)).tolist()
    return result


def bin_name(i: int) -> str:
    """Return the range of a bin."""
    return "k < 0" if i == 0 else f"{(i - 1) / N_BINS:.2f} to {i / N_BINS:.2f}"


def place(i: int) -> float:
    """Return where a bin begins, in widths of a bin; the first stands apart. `N_BINS + 1` is the end."""
    return i + 0.6 if i else 0.0


def ticks(largest: float) -> list[float]:
    """Return round values from 0 to at least `largest`, at most seven."""
    step = next(step for step in (1.0, 2.0, 5.0, 10.0, 20.0) if step * 6 >= largest)
    return [step * i for i in range(int(np.ceil(max(largest, step) / step)) + 1)]


def svg(before: list[float], after: list[float]) -> str:
    """Draw two lists of shares as bars side by side."""
    marks = ticks(max(*before, *after))
    across, up = _WIDTH - _LEFT - _RIGHT, _HEIGHT - _TOP - _BOTTOM
    pitch = across / place(N_BINS + 1)
    floor = _HEIGHT - _BOTTOM

    def height(share: float) -> float:
        return up * share / marks[-1]

    parts = [
        f'<svg class="histogram" viewBox="0 0 {_WIDTH:g} {_HEIGHT:g}" role="img" '
        'aria-label="Histogram of the aspect ratio k before and after">'
    ]
    for mark in marks:
        y = floor - height(mark)
        parts.append(f'<path class="grid" d="M{_LEFT:g} {y:.1f}H{_WIDTH - _RIGHT:g}"/>')
        parts.append(f'<text x="{_LEFT - 6:g}" y="{y + 4:.1f}" text-anchor="end">{mark:g}</text>')
    for i, pair in enumerate(zip(before, after, strict=True)):
        for side, (name, share) in enumerate(zip(("before", "after"), pair, strict=True)):
            x = _LEFT + pitch * (place(i) + 0.1 + 0.4 * side)
            parts.append(
                f'<rect fill="{(BEFORE, AFTER)[side]}" x="{x:.1f}" y="{floor - height(share):.1f}" '
                f'width="{0.4 * pitch:.1f}" height="{height(share):.1f}">'
                f"<title>{bin_name(i).replace('<', '&lt;')}, {name}: {share:.2f} %</title></rect>"
            )
    parts.append(f'<path class="axis" d="M{_LEFT:g} {floor:g}H{_WIDTH - _RIGHT:g}"/>')
    parts.append(f'<text x="{_LEFT + pitch / 2:.1f}" y="{floor + 16:g}" text-anchor="middle">&lt; 0</text>')
    for i in range(0, N_BINS + 1, N_BINS // 5):
        x = _LEFT + pitch * place(i + 1)
        parts.append(f'<path class="axis" d="M{x:.1f} {floor:g}v4"/>')
        parts.append(f'<text x="{x:.1f}" y="{floor + 16:g}" text-anchor="middle">{i / N_BINS:g}</text>')
    middle = _LEFT + across / 2
    parts.append(f'<text x="{middle:g}" y="{_HEIGHT - 8:g}" text-anchor="middle">aspect ratio k</text>')
    parts.append(f'<text x="{_LEFT:g}" y="12" text-anchor="start">% of the faces</text>')
    for side, name in enumerate(("before", "after")):
        x = _WIDTH - _RIGHT - 140 + 75 * side
        parts.append(f'<rect fill="{(BEFORE, AFTER)[side]}" x="{x:g}" y="3" width="12" height="12"/>')
        parts.append(f'<text x="{x + 17:g}" y="13">{name}</text>')
    return "\n".join([*parts, "</svg>"])
