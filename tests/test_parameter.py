"""Parameters are declared once; everything else is made from the declaration."""

import numpy as np
import pytest

from vtksmooth.errors import ParameterError
from vtksmooth.filters import FILTERS, TrapeziumDrawing
from vtksmooth.filters.parameter import Parameter

ALL = [(cls, parameter) for cls in FILTERS for parameter in cls.parameters().values()]


@pytest.mark.parametrize(("cls", "parameter"), ALL, ids=lambda value: getattr(value, "__name__", None))
def test_every_parameter_has_all_its_faces(cls: type, parameter: Parameter) -> None:
    algorithm = cls(**{parameter.name: parameter.default})
    assert getattr(algorithm, parameter.name) == parameter.default
    assert getattr(algorithm, f"Get{parameter.camel}")() == parameter.default
    getattr(algorithm, f"Set{parameter.camel}")(parameter.default)
    assert parameter.help.endswith(".")
    assert f"{parameter.name} : " in (cls.__doc__ or "")
    if parameter.type is bool:
        getattr(algorithm, f"{parameter.camel}On")()
        assert getattr(algorithm, parameter.name) is True
        getattr(algorithm, f"{parameter.camel}Off")()
        assert getattr(algorithm, parameter.name) is False


@pytest.mark.parametrize(("cls", "parameter"), ALL, ids=lambda value: getattr(value, "__name__", None))
def test_what_is_out_of_range_is_refused_by_name(cls: type, parameter: Parameter) -> None:
    wrong: list[object] = [
        object(),
        [1.5] if parameter.points else [1],
        np.array([1.0, 2.0]),
        np.array(["default", "auto"]),
        10**5000,
        "no such value" if parameter.type is not str or parameter.choices else "",
    ]
    if not parameter.optional:
        wrong.append(None)
    if parameter.low is not None:
        wrong.append(parameter.low - 1)
    if parameter.high is not None:
        wrong.append(parameter.high + 1)
    if parameter.type is float:
        wrong += [float("nan"), float("inf")]
    if parameter.type is int:
        wrong.append(1.5)
    for value in wrong:
        algorithm = cls()
        with pytest.raises(ParameterError, match=parameter.name) as caught:
            setattr(algorithm, parameter.name, value)
        assert len(str(caught.value)) < 400
        assert getattr(algorithm, parameter.name) == parameter.default


def test_modified_only_on_change() -> None:
    algorithm = TrapeziumDrawing()
    before = algorithm.GetMTime()
    algorithm.iterations = algorithm.iterations
    algorithm.SetStopGain(None)
    assert algorithm.GetMTime() == before
    algorithm.SetIterations(algorithm.iterations + 1)
    assert algorithm.GetMTime() > before


def test_unknown_keyword_names_the_known_ones() -> None:
    with pytest.raises(ParameterError, match=r"no parameter 'iteration'.*iterations"):
        TrapeziumDrawing(iteration=3)


def test_filters_do_not_share_values() -> None:
    one, other = TrapeziumDrawing(), TrapeziumDrawing()
    one.iterations = 99
    assert other.iterations == TrapeziumDrawing.parameters()["iterations"].default


def test_vtks_precision_codes_are_understood() -> None:
    algorithm = TrapeziumDrawing()
    algorithm.SetOutputPointsPrecision(1)
    assert algorithm.output_points_precision == "double"


def test_auto_stands_beside_numbers():
    class Thing:
        angle = Parameter("auto", "Angle.", automatic=True, type=float, low=0, high=90, unit="deg")

        def Modified(self):  # noqa: N802
            pass

    thing = Thing()
    assert thing.angle == "auto"
    thing.angle = 20
    assert thing.angle == 20.0
    thing.angle = "auto"
    assert thing.angle == "auto"
    for wrong in ("Auto", 91, None, "twenty"):
        with pytest.raises(ParameterError, match="angle must be from 0 to 90 deg, or auto"):
            thing.angle = wrong
