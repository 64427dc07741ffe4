"""Units of length: a document has one, and lengths are shown with it. They are names: nothing is scaled."""

from __future__ import annotations

#: The units that can be chosen, and what they are called; "" where the model has none.
UNITS = {
    "": "Model Units",
    "µm": "Micrometres (µm)",
    "mm": "Millimetres (mm)",
    "cm": "Centimetres (cm)",
    "m": "Metres (m)",
    "in": "Inches (in)",
    "ft": "Feet (ft)",
}

_POWERS = {1: "", 2: "²", 3: "³"}


def powered(unit: str, power: int = 1) -> str:
    """Return the unit of areas (2), of volumes (3) or of curvatures (-1).

    Examples
    --------
    >>> powered("mm", 3), powered("mm", -1), powered("", 2)
    ('mm³', '1/mm', '')
    """
    if not unit:
        return ""
    return f"1/{unit}" if power == -1 else f"{unit}{_POWERS[power]}"


def quantity(text: str, unit: str) -> str:
    """Return a number with its unit; degrees stand close.

    Examples
    --------
    >>> quantity("1.5", "mm"), quantity("90", "°"), quantity("", "mm")
    ('1.5 mm', '90°', '')
    """
    if not text or not unit:
        return text
    return f"{text}{unit}" if unit == "°" else f"{text} {unit}"


def labelled(title: str, unit: str) -> str:
    """Return a title with its unit, for axes and headings.

    Examples
    --------
    >>> labelled("Deviation", "mm"), labelled("k", "")
    ('Deviation [mm]', 'k')
    """
    return f"{title} [{unit}]" if unit else title
