"""A report as PDF, drawn by matplotlib, which PyVista brings along: no further dependency is needed."""

from __future__ import annotations

import io
import warnings
from pathlib import Path
from typing import Any

from . import histogram
from .page import Page, Table
from .pictures import COLOURS, INVERTED

#: A4 and its margin, millimetres.
_WIDTH, _HEIGHT, _MARGIN = 210.0, 297.0, 15.0

_GREY = "#555555"


class _Sheet:
    """One sheet of paper that is filled from above; lengths are millimetres, sizes of type points."""

    def __init__(self) -> None:
        from matplotlib.figure import Figure

        self.figure = Figure(figsize=(_WIDTH / 25.4, _HEIGHT / 25.4))
        self.y = _MARGIN

    def room(self, height: float) -> bool:
        """Return whether something of `height` still fits."""
        return self.y + height <= _HEIGHT - _MARGIN

    def text(self, text: str, x: float = _MARGIN, **style: Any) -> None:
        """Write at the present height."""
        # Names of files may have dollars, which are no formulas.
        self.figure.text(x / _WIDTH, 1 - self.y / _HEIGHT, text, va="top", parse_math=False, **style)

    def lines(self, text: str, size: float = 9.0, x: float = _MARGIN, **style: Any) -> None:
        """Write a paragraph."""
        for line in _wrapped(text, _WIDTH - _MARGIN - x, size, style.get("weight", "normal")):
            self.text(line, x, fontsize=size, **style)
            self.y += 0.48 * size

    def axes(self, x: float, width: float, height: float) -> Any:
        """Return axes whose upper side is at the present height."""
        bottom = 1 - (self.y + height) / _HEIGHT
        return self.figure.add_axes((x / _WIDTH, bottom, width / _WIDTH, height / _HEIGHT))

    def rule(self, x: float, width: float, colour: str) -> None:
        """Draw a line at the present height."""
        from matplotlib.lines import Line2D

        ends = (x / _WIDTH, (x + width) / _WIDTH)
        y = 1 - self.y / _HEIGHT
        self.figure.add_artist(Line2D(ends, (y, y), color=colour, linewidth=0.6))


def _wrapped(text: str, width: float, size: float, weight: str) -> list[str]:
    """Break a text into lines of at most `width` millimetres, within words where these are longer."""
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import TextToPath

    measure, font = TextToPath().get_text_width_height_descent, FontProperties(size=size, weight=weight)

    def fits(line: str) -> bool:
        return bool(measure(line, font, ismath=False)[0] * 25.4 / 72 <= width)

    lines = [""]
    for word in text.split():
        longer = f"{lines[-1]} {word}".lstrip()
        if fits(longer):
            lines[-1] = longer
            continue
        lines += [""] if lines[-1] else []
        for letter in word:
            if not fits(lines[-1] + letter):
                lines.append("")
            lines[-1] += letter
    return lines


def write(page: Page, path: Path) -> None:
    """Write `page` to `path`; one sheet, more only for a long recipe."""
    import matplotlib as mpl
    from matplotlib.backends.backend_pdf import PdfPages

    with (
        warnings.catch_warnings(),
        mpl.rc_context({"pdf.fonttype": 42}),  # text that can be searched and copied
        PdfPages(path, metadata={"Title": f"{page.title}: before and after smoothing"}) as file,
    ):
        warnings.simplefilter("ignore")  # letters of a file's name that the font has not
        for figure in figures(page):
            file.savefig(figure)


def figures(page: Page) -> list[Any]:
    """Return the sheets as matplotlib's figures."""
    sheet = _Sheet()
    sheets = [sheet]
    sheet.lines(f"{page.title}: before and after smoothing", 15, weight="bold")
    sheet.y += 1
    for mesh in page.meshes:
        sheet.lines(mesh, 8, color=_GREY)
    sheet.y += 1.5
    for sentence in page.sentences:
        sheet.lines(sentence)
    if page.pictures:
        sheet.y += 2
        _pictures(sheet, page)
    sheet.y += 5
    sheet.lines("Aspect ratios of the faces", 11, weight="bold")
    sheet.y += 3
    _histogram(sheet, page)
    top = sheet.y
    _table(sheet, page.quality, _MARGIN, 88)
    bottom, sheet.y = sheet.y, top
    _table(sheet, page.change, _MARGIN + 98, 82)
    sheet.y = max(bottom, sheet.y) + 5
    if page.steps:
        sheet.lines("Recipe", 11, weight="bold")
        sheet.y += 1
    for number, (text, did, on) in enumerate(page.steps, 1):
        if not sheet.room(6 if not did else 12):
            sheet = _Sheet()
            sheets.append(sheet)
        sheet.text(f"{number}.", fontsize=8.5)
        sheet.lines(
            text if on else f"{text} (switched off)", 8.5, _MARGIN + 6, color="black" if on else _GREY
        )
        if did:
            sheet.lines(did, 7.5, _MARGIN + 6, color=_GREY)
        sheet.y += 1
    sheet.y = _HEIGHT - _MARGIN + 2
    sheet.rule(_MARGIN, _WIDTH - 2 * _MARGIN, "#cccccc")
    sheet.y += 1.5
    sheet.lines(page.footer, 7, color=_GREY)
    return [sheet.figure for sheet in sheets]


def _pictures(sheet: _Sheet, page: Page) -> None:
    from matplotlib.image import imread

    width, gap = (_WIDTH - 2 * _MARGIN - 6) / 2, 6.0
    images = [imread(io.BytesIO(png)) for _, png in page.pictures]
    height = min(max(width * image.shape[0] / image.shape[1] for image in images), 66.0)
    places = [_MARGIN + i * (width + gap) for i in range(len(images))]
    for x, image in zip(places, images, strict=True):
        axes = sheet.axes(x, width, height)
        axes.imshow(image)
        axes.axis("off")
    sheet.y += height + 1
    for x, (caption, _) in zip(places, page.pictures, strict=True):
        sheet.text(caption, x + width / 2, fontsize=8, color=_GREY, ha="center")
    sheet.y += 5
    names = ["k < 0", *(f"{i / 5:g} to {(i + 1) / 5:g}" for i in range(5))]
    key = sheet.axes(_WIDTH / 2 - 54, 108, 3)
    key.axis("off")
    key.set_xlim(0, 6)
    for i, (name, colour) in enumerate(zip(names, (INVERTED, *COLOURS), strict=True)):
        key.barh(0, 1, left=i, color=colour, height=1)
        key.text(i + 0.5, -0.75, name, ha="center", va="top", fontsize=7)
    sheet.y += 6


def _histogram(sheet: _Sheet, page: Page) -> None:
    height = 38.0
    axes = sheet.axes(_MARGIN + 8, _WIDTH - 2 * _MARGIN - 8, height)
    places = [histogram.place(i) for i in range(histogram.N_BINS + 1)]
    for side, (name, shares) in enumerate(zip(("before", "after"), page.histograms, strict=True)):
        colour = (histogram.BEFORE, histogram.AFTER)[side]
        axes.bar([p + 0.3 + 0.4 * side for p in places], shares, 0.4, color=colour, label=name)
    edges = range(0, histogram.N_BINS + 1, histogram.N_BINS // 5)
    labels = ["< 0", *(f"{edge / histogram.N_BINS:g}" for edge in edges)]
    axes.set_xticks([0.5, *(histogram.place(edge + 1) for edge in edges)], labels)
    axes.set_yticks(histogram.ticks(max(map(max, page.histograms))))
    axes.set_xlim(0, histogram.place(histogram.N_BINS + 1))
    axes.tick_params(labelsize=7.5)
    axes.set_xlabel("aspect ratio k", fontsize=8)
    axes.set_ylabel("% of the faces", fontsize=8)
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(axis="y", color="#e4e4e4", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.legend(frameon=False, fontsize=8, ncols=2, loc="upper right", bbox_to_anchor=(1.0, 1.16))
    sheet.y += height + 12


def _table(sheet: _Sheet, table: Table, x: float, width: float) -> None:
    columns = [x + width - 20.0 * i for i in reversed(range(len(table.head) - 1))]
    for i, row in enumerate([table.head, *table.rows]):
        sheet.text(row[0], x, fontsize=7.5, weight="bold" if i == 0 else "normal")
        for place, cell in zip(columns, row[1:], strict=True):
            sheet.text(cell, place, fontsize=7.5, ha="right", weight="bold" if i == 0 else "normal")
        sheet.y += 3.7
        sheet.rule(x, width, _GREY if i == 0 else "#eeeeee")
        sheet.y += 0.7
