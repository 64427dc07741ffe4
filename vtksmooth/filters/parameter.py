"""Parameters, declared once.

A filter declares each parameter as a class attribute. From that declaration come the VTK setters and
getters, the snake_case property, the constructor's keyword, the range check, the command line's option,
the accessor's keyword with its type, and the documentation.
"""

from __future__ import annotations

import math
import numbers
from collections.abc import Callable, Mapping
from copy import copy
from typing import Any

import numpy as np

from ..errors import ParameterError
from .point_lists import format_selection

#: Value of a parameter that the filter chooses by the mesh.
AUTO = "auto"

#: For `only`: any value that is not "off".
SET = "set"

#: Groups of parameters, beside the filter's own.
CONSTRAINTS, STOP_RULES, OUTPUT = "constraints", "stop rules", "output"

#: Letters of a wrong value that are shown.
_LONGEST = 60


class Parameter:
    """One parameter of a filter: a descriptor that checks what it is given.

    Parameters
    ----------
    default : int, float, bool, str or None
        Value of a new filter. Its type is the parameter's, unless `type` says otherwise.
    help : str
        One line that says what the parameter does.
    low, high : float, optional
        Smallest and largest value allowed.
    unit : str, optional
        Unit of the value.
    choices : sequence of str, optional
        All values allowed.
    optional : bool
        Whether None is allowed; it means "off".
    automatic : bool
        Whether "auto" is allowed beside numbers; it means that the filter chooses by the mesh.
    type : type, optional
        int, float, bool or str.
    codes : mapping of int to str, optional
        Integers that stand for choices, where VTK has such a convention.
    group : str, optional
        What it belongs to where forms and help texts list it; empty: to what makes the filter.
    text : str
        What a str is that is no array's name, in a word; the help says how it is written.
    points : bool
        Whether a mask or numbers of points are allowed in place of an array's name; they become a text such
        as ``points:0-14,20``.
    only : mapping of str to sequence or "set", optional
        Other parameters and those of their values with which this one has a say, if it has not always; one
        of them is enough. Inputs of the filter may be among them, as "set". Where it has none, only its
        default is accepted.
    every : bool
        Whether all of `only` must be so.

    Examples
    --------
    >>> class Thing:
    ...     angle = Parameter(20.0, "Angle above which an edge is sharp.", low=0, high=180, unit="deg")
    ...     def Modified(self):
    ...         print("modified")
    >>> thing = Thing()
    >>> thing.angle = 30
    modified
    >>> thing.angle
    30.0
    >>> thing.angle = 200
    Traceback (most recent call last):
    vtksmooth.errors.ParameterError: angle must be from 0 to 180 deg, not 200.
    """

    def __init__(
        self,
        default: Any,
        help: str,
        *,
        low: float | None = None,
        high: float | None = None,
        unit: str = "",
        choices: tuple[str, ...] | None = None,
        optional: bool = False,
        automatic: bool = False,
        type: type | None = None,
        codes: Mapping[int, str] | None = None,
        group: str = "",
        text: str = "",
        points: bool = False,
        only: Mapping[str, tuple[Any, ...] | str] | None = None,
        every: bool = False,
    ) -> None:
        self.default, self.help, self.low, self.high, self.unit = default, help, low, high, unit
        self.choices, self.optional, self.codes = choices, optional, dict(codes or {})
        self.automatic, self.group, self.text, self.only = automatic, group, text, dict(only or {})
        self.points, self.every = points, every
        self.type: Callable[[Any], Any] = type or default.__class__
        self.name = ""

    def with_default(self, default: Any) -> Parameter:
        """Return the same declaration with another default, for a subclass of the filter."""
        other = copy(self)
        other.default = default
        return other

    def always(self) -> Parameter:
        """Return the same declaration with a say whatever the others are, for another filter."""
        other = copy(self)
        other.only = {}
        return other

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name

    def __get__(self, instance: Any, owner: type | None = None) -> Any:
        return self if instance is None else instance.__dict__.get(self.name, self.default)

    def __set__(self, instance: Any, value: Any) -> None:
        value = self.check(value)
        if value != self.__get__(instance):
            instance.__dict__[self.name] = value
            instance.Modified()

    @property
    def camel(self) -> str:
        """Name in VTK's style: max_deviation becomes MaxDeviation."""
        return "".join(word.capitalize() for word in self.name.split("_"))

    @property
    def type_name(self) -> str:
        """Name of the type: int, float, bool or str."""
        return str(getattr(self.type, "__name__", self.type))

    @property
    def annotation(self) -> str:
        """The values allowed, as a type checker reads it."""
        literals: list[Any] = [*(self.choices or ()), *self.codes, *([AUTO] if self.automatic else [])]
        words = [] if self.choices else [self.type_name]
        words += ["Sequence[int]", "npt.NDArray[Any]"] if self.points else []
        if literals:
            words.append(f"Literal[{', '.join(map(repr, literals))}]")
        return " | ".join([*words, *(["None"] if self.optional else [])])

    @property
    def range(self) -> str:
        """What is allowed, in words."""
        unit = f" {self.unit}" if self.unit else ""
        if self.choices:
            words = "one of " + ", ".join(self.choices)
        elif self.type is bool:
            words = "true or false"
        elif self.type is str:
            words = self.text or "a name"
        elif self.low is not None and self.high is not None:
            words = f"from {self.low:g} to {self.high:g}{unit}"
        elif self.low is not None:
            words = f"{self.low:g}{unit} or more"
        else:
            words = f"a number{unit and f' ({self.unit})'}"
        words += ", or auto" if self.automatic else ""
        return words + (", or None (off)" if self.optional else "")

    def has_say(self, value_of: Callable[[str], Any]) -> bool:
        """Return whether its value is read, given those of the filter's other parameters."""
        met = [
            value_of(name) is not None if values == SET else value_of(name) in values
            for name, values in self.only.items()
        ]
        return not met or (all(met) if self.every else any(met))

    @property
    def where(self) -> str:
        """Where it has a say, in words; '' if it always has."""
        met = (f"{name} is {_one_of(values)}" for name, values in self.only.items())
        return (" and " if self.every else " or ").join(met)

    def check(self, value: Any) -> Any:
        """Return `value` in the parameter's type.

        Raises
        ------
        ParameterError
            The value is of the wrong type or out of range; the message names the parameter and the range.
        """
        if value is None and self.optional:
            return None
        if isinstance(value, str) and self.automatic and value == AUTO:
            return AUTO
        if self.choices:
            if isinstance(value, numbers.Integral) and not isinstance(value, bool):
                value = self.codes.get(int(value), value)
            if isinstance(value, str) and value in self.choices:
                return str(value)
        elif self.type is str:
            if isinstance(value, str) and value:
                return str(value)
            if self.points and isinstance(value, (list, tuple, range, np.ndarray)):
                return format_selection(self.name, value)
        else:
            number = self._number(value)
            if number is not None:
                return number
        raise ParameterError(f"{self.name} must be {self.range}, not {_told(value)}.")

    def _number(self, value: Any) -> Any:
        """Return `value` in the parameter's type, None where it is no number that is allowed."""
        if isinstance(value, (str, bytes, bytearray)) or getattr(value, "shape", ()) != ():
            return None
        try:
            number = float(value)
            typed = self.type(value)
        except (TypeError, ValueError, OverflowError):
            return None
        if not math.isfinite(number) or float(typed) != number:
            return None
        if (self.low is not None and number < self.low) or (self.high is not None and number > self.high):
            return None
        return typed


def _one_of(values: tuple[Any, ...] | str) -> str:
    words = [values] if isinstance(values, str) else ["off" if v in (None, False) else str(v) for v in values]
    words = ["on" if word == "True" else word for word in words]
    return ", ".join(words[:-1]) + " or " * (len(words) > 1) + words[-1]


def _told(value: Any) -> str:
    """Return what to say of a wrong value, on one line; arrays and long numbers are cut short."""
    try:
        text = " ".join(repr(value).split())
    except ValueError:  # Python writes no numbers of thousands of digits
        text = f"a number of {value.bit_length()} bits"
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}…"


def parameters_of(cls: type) -> dict[str, Parameter]:
    """Return the parameters of a class in the order of declaration, those of its bases first."""
    found: dict[str, Parameter] = {}
    for base in reversed(cls.__mro__):
        found.update({name: value for name, value in vars(base).items() if isinstance(value, Parameter)})
    return found


def add_vtk_access(cls: type) -> None:
    """Give `cls` SetX and GetX for each of its parameters x, and XOn and XOff for the booleans."""

    def access(name: str, camel: str, boolean: bool) -> dict[str, Any]:
        def setter(self: Any, value: Any) -> None:
            setattr(self, name, value)

        def getter(self: Any) -> Any:
            return getattr(self, name)

        def on(self: Any) -> None:
            setattr(self, name, True)

        def off(self: Any) -> None:
            setattr(self, name, False)

        methods = {f"Set{camel}": setter, f"Get{camel}": getter}
        return methods | {f"{camel}On": on, f"{camel}Off": off} if boolean else methods

    for parameter in parameters_of(cls).values():
        for name, method in access(parameter.name, parameter.camel, parameter.type is bool).items():
            method.__name__, method.__qualname__ = name, f"{cls.__qualname__}.{name}"
            method.__doc__ = f"{parameter.help} ({parameter.name}: {parameter.range}.)"
            setattr(cls, name, method)


def documentation(cls: type) -> str:
    """Return the numpydoc "Parameters" section of a class, made from its declarations."""
    lines = ["Parameters", "----------"]
    for parameter in parameters_of(cls).values():
        kind = (
            "{" + ", ".join(map(repr, parameter.choices)) + "}" if parameter.choices else parameter.type_name
        )
        default = f"default {parameter.default!r}"
        lines.append(f"{parameter.name} : {kind}, {default}")
        span = f" Allowed: {parameter.range}." if parameter.type in (int, float) else ""
        where = f" Only where {parameter.where}." if parameter.only else ""
        lines.append(f"    {parameter.help}{span}{where}")
    return "\n".join(lines)
