"""The names that VTK and PyVista have for what parameters here do, for errors that name ours.

``docs/switching.md`` shows the same table; a test compares the two.
"""

from __future__ import annotations

import re
from collections.abc import Container
from typing import NamedTuple


class Ours(NamedTuple):
    """What a parameter of VTK or PyVista is here: the name, "" if there is none, and what else to know."""

    name: str
    advice: str


#: By the names of VTK and PyVista, in words with underscores.
OTHER_NAMES = {
    "number_of_iterations": Ours("iterations", ""),
    "n_iter": Ours("iterations", ""),
    "convergence": Ours("stop_gain", "it is a gain in quality, not a distance"),
    "boundary_smoothing": Ours("boundary", "'sliding' or 'smoothed' is on, 'fixed' is off"),
    "feature_edge_smoothing": Ours("features", "'slide' is on; 'hold' keeps ridges where they are"),
    "feature_smoothing": Ours("features", "'slide' is on; 'hold' keeps ridges where they are"),
    "feature_angle": Ours("ridge_angle", ""),
    "edge_angle": Ours("corner_angle", ""),
    "generate_error_scalars": Ours("", "SurfaceComparison measures displacements and distances"),
    "generate_error_vectors": Ours("", "SurfaceComparison measures displacements and distances"),
    "normalize_coordinates": Ours("", "results do not depend on scale; leave it out"),
    "non_manifold_smoothing": Ours("", "points of non-manifold edges stay; leave it out"),
    "window_function": Ours("", "scheme='taubin' has no window; leave it out"),
    "constraint_distance": Ours("max_displacement", "it names a point array, which may be constant"),
    "constraint_box": Ours("", "points are bounded by spheres, see max_displacement"),
    "constraint_strategy": Ours("", "points are bounded by spheres, see max_displacement"),
}


def snake(name: str) -> str:
    """Return a name in words with underscores.

    Examples
    --------
    >>> snake("NumberOfIterations"), snake("--feature-angle")
    ('number_of_iterations', 'feature_angle')
    """
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name.lstrip("-")).replace("-", "_").lower()


def advice(name: str, known: Container[str], prefix: str = "") -> str:
    """Return what to use in place of a parameter of VTK or PyVista, as the end of a sentence.

    Parameters
    ----------
    name : str
        The name, in anyone's style.
    known : container of str
        Names of the parameters that there are.
    prefix : {"", "Set", "Get", "--"}
        How ours is shown: as a keyword, a method, or an option.

    Returns
    -------
    str
        "" if it is no such name, or what it is here is not among `known`.

    Examples
    --------
    >>> advice("FeatureAngle", ["ridge_angle"])
    'use ridge_angle'
    >>> advice("n_iter", ["boundary"])
    ''
    """
    word = snake(name)
    ours = OTHER_NAMES.get(word)
    if ours is None or word in known or (ours.name and ours.name not in known):
        return ""
    camel = ours.name.title().replace("_", "")
    shown = prefix + {"": ours.name, "--": ours.name.replace("_", "-")}.get(prefix, camel)
    return ": ".join(part for part in (ours.name and f"use {shown}", ours.advice) if part)


def advice_for_method(name: str, known: Container[str]) -> str:
    """Return :func:`advice` for a method of VTK that sets or gets a parameter.

    Examples
    --------
    >>> advice_for_method("SetNumberOfIterations", ["iterations"])
    'use SetIterations'
    """
    found = re.fullmatch(r"[SG]et([A-Z]\w*?)(?:Data|Connection)?|([A-Z]\w*)(?:On|Off)", name)
    return advice(found[1] or found[2], known, "Get" if name.startswith("Get") else "Set") if found else ""
