"""The filters as ParaView wants them: a class to run, and the definition of its panel.

All is made from the filters' declarations. ParaView knows numbers, texts and lists of choices; what is
optional or automatic becomes a box to tick beside the number.
"""

from __future__ import annotations

import re
import threading
from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import SubElement

from ..errors import ParameterError
from ..filters import FILTERS, Filter, Parameter
from ..filters.parameter import AUTO
from ..jit.compiled import on_compile

#: Where the filters are in ParaView's menu.
CATEGORY = "Surface smoothing"
#: Stands for None in lists of arrays and of choices.
NONE = "None"


def words(name: str) -> str:
    """Return a name in words: TrapeziumDrawing becomes "Trapezium Drawing"."""
    return re.sub(r"(?<=[a-z])(?=[A-Z])", " ", name)


class Proxy(Filter):
    """What a filter does differently in ParaView.

    ParaView sets properties one by one and cannot be told by an exception that a value is not allowed:
    it is said when the filter runs, in one line. Failed runs give empty output.
    """

    def __init__(self) -> None:
        super().__init__()
        self.SetProgressText(type(self).__name__)  # what ParaView shows until the filter says more
        self._pushed: dict[str, Any] = {}
        self._refused: dict[str, ParameterError] = {}

    def push(self, key: str, value: Any) -> None:
        """Take the value of the property `key`: a parameter's name, or one of its boxes."""
        self._pushed[key] = value
        parameter = self.parameters()[key.partition(":")[0]]
        if self._refused.pop(parameter.name, None):
            self.Modified()  # whatever the value is now
        try:
            setattr(self, parameter.name, _value(parameter, self._pushed))
        except ParameterError as error:
            self._refused[parameter.name] = error
            self.Modified()

    def RequestData(self, request: Any, inInfo: Any, outInfo: Any) -> int:
        """Run the filter; say that kernels are being compiled, where the first run waits for it."""
        self.SetAbortExecute(0)  # of an earlier run: VTK's flag sticks
        self._thread = threading.get_ident()
        with on_compile(self._say_compiling):
            super().RequestData(request, inInfo, outInfo)
        # A failure has been told. Marked as one it would be told again by VTK, in many lines, and the
        # filter would run again for everyone who looks at its output.
        self.SetAbortOutput(False)
        self.SetProgressText(type(self).__name__)
        return 1

    def _execute_all(self, sources: list[Any], outputs: list[Any]) -> None:
        for error in self._refused.values():
            raise error
        super()._execute_all(sources, outputs)

    def _say_compiling(self, kernel: str) -> None:
        if threading.get_ident() != self._thread:
            return  # ParaView's windows are for its own thread
        self.SetProgressText("compiling, once per installation")
        self.UpdateProgress(self.GetProgress())


#: What ParaView runs for each filter; it finds the classes in this module, by their names.
PROXIES: dict[type[Filter], type[Proxy]] = {
    cls: type(cls.__name__, (Proxy, cls), {"__module__": __name__}) for cls in FILTERS
}
globals().update({cls.__name__: cls for cls in PROXIES.values()})


def _value(parameter: Parameter, pushed: dict[str, Any]) -> Any:
    """Return the parameter's value that the properties set so far say."""
    name = parameter.name
    given = pushed.get(name, _number(parameter))
    if parameter.choices:
        return _choices(parameter)[given][0]
    if parameter.type is str:
        return None if given in (None, NONE, "") else given
    if parameter.optional and not pushed.get(f"{name}:use", parameter.default is not None):
        return None
    if parameter.automatic and pushed.get(f"{name}:auto", parameter.default == AUTO):
        return AUTO
    return given


def _choices(parameter: Parameter) -> list[tuple[str | None, str]]:
    """Return all values of a parameter with choices, and what ParaView shows for them."""
    choices: list[tuple[str | None, str]] = [(choice, choice) for choice in parameter.choices or ()]
    if parameter.automatic:
        choices.append((AUTO, AUTO))
    if parameter.optional:
        choices.append((None, NONE))
    return choices


def _number(parameter: Parameter) -> Any:
    """Return what ParaView's property holds at first."""
    default = parameter.default
    if parameter.choices:
        return [value for value, _ in _choices(parameter)].index(default)
    if parameter.type is str:
        return ("" if parameter.text else NONE) if default is None else default
    if default is None or default == AUTO:
        # Off, or chosen by the filter: the number that waits behind the box.
        return parameter.type(parameter.low or 0)
    return int(default) if parameter.type is bool else default


# -- definitions -----------------------------------------------------------------------------------


def definition(cls: type[Filter]) -> str:
    """Return the content of a filter's proxy definition, XML for ParaView's server manager."""
    root = ElementTree.Element("root")
    text = re.split(r"\n *(?:Parameters|Attributes|Guarantees|Examples)\n", cls.__doc__ or "")[0]
    text = " ".join(text.replace("``", "").split())
    SubElement(root, "Documentation", short_help=text.partition(". ")[0].rstrip(".") + ".").text = text
    for port, name in enumerate(cls.every_input()):
        _add_input(root, cls, port, name)
    for parameter in cls.parameters().values():
        _add_parameter(root, cls, parameter)
    for port, name in enumerate(cls.outputs):
        SubElement(root, "OutputPort", name=name.capitalize(), index=str(port), id=f"port{port}")
    SubElement(SubElement(root, "Hints"), "ShowInMenu", category=CATEGORY)
    return "".join(ElementTree.tostring(child, encoding="unicode") for child in root)


def input_name(cls: type[Filter], port: int) -> str:
    """Return the name of an input's property: ParaView calls the only one that is needed Input."""
    return "Input" if port == 0 and len(cls.inputs) == 1 else cls.every_input()[port].capitalize()


def _add_input(root: Any, cls: type[Filter], port: int, name: str) -> None:
    element = SubElement(
        root, "InputProperty",
        name=input_name(cls, port), command="SetInputConnection", port_index=str(port),
    )  # fmt: skip
    groups = SubElement(element, "ProxyGroupDomain", name="groups")
    for group in ("sources", "filters"):
        SubElement(groups, "Group", name=group)
    types = SubElement(element, "DataTypeDomain", name="input_type", composite_data_supported="1")
    SubElement(types, "DataType", value="vtkPolyData")
    SubElement(element, "InputArrayDomain", name="point_arrays", attribute_type="point", optional="1")
    SubElement(element, "Documentation").text = f"The {name}: polygonal data."
    if name in cls.optional_inputs:
        SubElement(SubElement(element, "Hints"), "Optional")


def _add_parameter(root: Any, cls: type[Filter], parameter: Parameter) -> None:
    name, camel = parameter.name, parameter.camel
    text = parameter.help if parameter.choices else f"{parameter.help} Allowed: {parameter.range}."
    shown = _is_shown(cls, parameter)
    if parameter.choices:
        element = _add_property(root, "Int", camel, name, _number(parameter), text, shown)
        domain = SubElement(element, "EnumerationDomain", name="enum")
        for index, (_, entry) in enumerate(_choices(parameter)):
            SubElement(domain, "Entry", text=entry, value=str(index))
    elif parameter.type is str:
        element = _add_property(root, "String", camel, name, _number(parameter), text, shown)
        if parameter.text:
            return
        domain = SubElement(
            element, "ArrayListDomain", name="array_list", none_string=NONE, input_domain_name="point_arrays"
        )
        SubElement(
            SubElement(domain, "RequiredProperties"), "Property", name=input_name(cls, 0), function="Input"
        )
        # Without this ParaView takes what array it finds first.
        SubElement(SubElement(element, "Hints"), "NoDefault")
    elif parameter.type is bool:
        _add_box(root, camel, name, bool(parameter.default), text, shown)
    else:
        boxes = []
        if parameter.optional:
            boxes.append(("Use", "use", parameter.default is not None))
        if parameter.automatic:
            boxes.append(("Automatic", "auto", parameter.default == AUTO))
        for word, key, on in boxes:
            _add_box(root, word + camel, f"{name}:{key}", on, text, shown)
        kind = "Int" if parameter.type is int else "Double"
        element = _add_property(root, kind, camel, name, _number(parameter), text, shown)
        if parameter.unit:
            element.set("panel_label", f"{words(camel)} ({parameter.unit})")
        limits = {"min": parameter.low, "max": parameter.high}
        SubElement(
            element, f"{kind}RangeDomain", {"name": "range"}
            | {key: repr(parameter.type(limit)) for key, limit in limits.items() if limit is not None},
        )  # fmt: skip
        hints = SubElement(element, "Hints")
        for word, key, _ in boxes:
            SubElement(
                hints, "PropertyWidgetDecorator", type="GenericDecorator",
                mode="enabled_state", property=word + camel, value=str(int(key == "use")),
            )  # fmt: skip


def _is_shown(cls: type[Filter], parameter: Parameter) -> bool:
    """Return whether a panel shows a parameter at first: the filter's own, counts and arrays."""
    own = parameter.name in vars(cls)
    count = parameter.type is int and not parameter.optional
    return own or count or (parameter.type is str and not parameter.choices)


def _add_property(root: Any, kind: str, name: str, key: str, default: Any, text: str, shown: bool) -> Any:
    element = SubElement(
        root, f"{kind}VectorProperty",
        name=name, command="push", initial_string=key, number_of_elements="1", default_values=str(default),
        panel_visibility="default" if shown else "advanced",
    )  # fmt: skip
    SubElement(element, "Documentation").text = text
    return element


def _add_box(root: Any, name: str, key: str, on: bool, text: str, shown: bool) -> None:
    element = _add_property(root, "Int", name, key, int(on), text, shown)
    SubElement(element, "BooleanDomain", name="bool")
