"""A report as one HTML file that needs nothing else."""

from __future__ import annotations

from base64 import b64encode
from html import escape
from pathlib import Path

from . import histogram
from .page import Page, Table
from .pictures import COLOURS, INVERTED

_STYLE = """
@page { size: A4; margin: 12mm; }
body { font: 14px/1.4 system-ui, "Segoe UI", Helvetica, Arial, sans-serif; color: #1a1a1a; background: #fff;
  max-width: 940px; margin: 24px auto; padding: 0 16px; }
h1 { font-size: 24px; margin: 0 0 4px; overflow-wrap: anywhere; }
h2 { font-size: 16px; margin: 22px 0 6px; }
p { margin: 2px 0 8px; overflow-wrap: anywhere; }
.meshes, footer, figcaption, .did { color: #555; }
.pictures { display: flex; gap: 12px; }
.pictures figure { flex: 1; margin: 8px 0 0; min-width: 0; text-align: center; }
.pictures img { width: 100%; max-height: 360px; object-fit: contain; }
.key { display: flex; justify-content: center; margin: 6px 0 0; font-size: 12px; }
.key span { width: 80px; boundary-top: 12px solid; text-align: center; }
svg { width: 100%; font: 12px system-ui, sans-serif; }
.grid { stroke: #e4e4e4; } .axis { stroke: #555; }
.tables { display: flex; flex-wrap: wrap; gap: 0 36px; align-items: start; }
table { boundary-collapse: collapse; margin: 6px 0; font-size: 13px; }
th, td { padding: 2px 8px; text-align: right; font-variant-numeric: tabular-nums; }
th:first-child, td:first-child { text-align: left; padding-left: 0; }
thead th { boundary-bottom: 1px solid #555; font-weight: 600; }
tbody td { boundary-bottom: 1px solid #eee; }
ol { margin: 0; padding-left: 22px; overflow-wrap: anywhere; }
.off { color: #888; text-decoration: line-through; }
footer { boundary-top: 1px solid #ccc; margin-top: 20px; padding-top: 6px; font-size: 12px; }
@media print {
  body { margin: 0; padding: 0; font-size: 11px; max-width: none; print-color-adjust: exact; }
  h1 { font-size: 18px; } h2 { font-size: 13px; margin-top: 10px; }
  .pictures img { max-height: 60mm; } svg { max-height: 46mm; }
  .tables { flex-wrap: nowrap; gap: 24px; } table { font-size: 10px; }
  td, th { padding: 1px 6px; white-space: nowrap; }
}
"""


def write(page: Page, path: Path) -> None:
    """Write `page` to `path`."""
    path.write_text(document(page), encoding="utf-8")


def document(page: Page) -> str:
    """Return the HTML of a page."""
    body = [f"<h1>{escape(page.title)}: before and after smoothing</h1>"]
    body += [f'<p class="meshes">{"<br>".join(escape(mesh) for mesh in page.meshes)}</p>']
    body += [f"<p>{escape(sentence)}</p>" for sentence in page.sentences]
    if page.pictures:
        body.append('<div class="pictures">')
        for caption, png in page.pictures:
            data = b64encode(png).decode("ascii")
            image = f'<img alt="The mesh {caption}" src="data:image/png;base64,{data}">'
            body.append(f"<figure>{image}<figcaption>{caption}</figcaption></figure>")
        body += ["</div>", _key()]
    body += ["<h2>Aspect ratios of the faces</h2>", histogram.svg(*page.histograms)]
    body += ['<div class="tables">', _table(page.quality), _table(page.change), "</div>"]
    if page.steps:
        body += ["<h2>Recipe</h2>", "<ol>"]
        for text, did, on in page.steps:
            line = escape(text) if on else f'<span class="off">{escape(text)}</span> (switched off)'
            body.append(
                f"<li>{line}" + (f'<br><span class="did">{escape(did)}</span>' if did else "") + "</li>"
            )
        body.append("</ol>")
    body.append(f"<footer>{escape(page.footer)}</footer>")
    head = [
        "<!DOCTYPE html>",
        '<html lang="en">',
        '<head><meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f"<title>{escape(page.title)}: before and after smoothing</title>",
        f"<style>{_STYLE}</style></head>",
        "<body>",
    ]
    return "\n".join([*head, *body, "</body>", "</html>", ""])


def _key() -> str:
    names = ["k &lt; 0", *(f"{i / 5:g} to {(i + 1) / 5:g}" for i in range(5))]
    colours = (INVERTED, *COLOURS)
    parts = [f'<span style="boundary-color: {c}">{n}</span>' for n, c in zip(names, colours, strict=True)]
    return f'<div class="key">{"".join(parts)}</div>'


def _table(table: Table) -> str:
    head = "".join(f"<th>{escape(cell)}</th>" for cell in table.head)
    rows = ["".join(f"<td>{escape(cell)}</td>" for cell in row) for row in table.rows]
    body = "\n".join(f"<tr>{row}</tr>" for row in rows)
    return f"<table><thead><tr>{head}</tr></thead>\n<tbody>{body}</tbody></table>"
