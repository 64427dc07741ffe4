"""A parameter has an effect or is refused; schemes of one name are one operator."""

import meshes
import numpy as np
import pytest
import pyvista as pv
from vtkmodules.util.numpy_support import vtk_to_numpy

from vtksmooth import LaplacianSmoothing, ParameterError
from vtksmooth.filters import FILTERS
from vtksmooth.filters.laplacian_smoothing import SCHEMES
from vtksmooth.filters.parameter import AUTO, SET
from vtksmooth.kernels.mesh import adjacency
from vtksmooth.kernels.smoothing import loop
from vtksmooth.kernels.smoothing.schemes.directional import Directional
from vtksmooth.kernels.smoothing.schemes.thin_plate import ThinPlate
from vtksmooth.kernels.smoothing.weights import KINDS, Weights


def _values_without_a_say():
    """Every parameter that has not always a say, with values of others that take it away."""
    for cls in FILTERS:
        declared = cls.parameters()
        for name, parameter in declared.items():
            if parameter.only:
                off = {}
                for other, values in parameter.only.items():
                    if other in cls.every_input():
                        off[other] = None
                        continue
                    choices = declared[other].choices or (
                        (False,) if declared[other].type is bool else (None, 1.0)
                    )
                    free = [c for c in choices if (c is None if values == SET else c not in values)]
                    off[other] = free[0] if free else None
                yield pytest.param(cls, name, off, id=f"{cls.__name__}.{name}")


@pytest.mark.parametrize(("cls", "name", "off"), list(_values_without_a_say()))
def test_parameters_without_a_say_are_refused(cls, name, off):
    declared = cls.parameters()
    parameter = declared[name]
    choices = parameter.choices or (AUTO, True, "Other", 3, 0.25, False)
    for value in choices:
        filter = cls(
            **{k: v for k, v in off.items() if k in declared and (v is not None or declared[k].optional)}
        )
        try:
            setattr(filter, name, value)
        except ParameterError:
            continue
        if getattr(filter, name) == parameter.default:
            continue
        with pytest.raises(ParameterError, match=f"^{name}=.* has no effect with {next(iter(off))}="):
            filter(*(pv.Sphere() for _ in cls.inputs))
        return
    raise AssertionError("no value was tried")


def test_what_has_a_say_changes_the_result():
    # The declarations of `only` are true: where they hold, another value gives another surface.
    ball = pv.Sphere(theta_resolution=12, phi_resolution=12)
    ball.points += 0.02 * np.random.default_rng(1).normal(size=ball.points.shape).astype(np.float32)
    ball["Flow"] = np.tile([1.0, 0.0, 0.0], (ball.n_points, 1))
    for scheme, row in SCHEMES.items():
        plain = {"scheme": scheme, "iterations": 2}

        def result(**values):
            return LaplacianSmoothing(**values)(ball).GetPoints().GetData()

        def differ(one, other):
            return (vtk_to_numpy(one) != vtk_to_numpy(other)).any()

        first = result(**plain)
        for ability, values in (
            (row.weights, {"weights": "cotangent"}),
            (row.flow, {"flow": "Flow"}),
            (row.implicit, {"implicit_step": 3.0}),
            (scheme != "low-pass", {"relaxation_factor": 0.3}),
            (scheme == "low-pass", {"wavelength": 1.0}),
            (scheme == "taubin", {"pass_band": 0.5}),
        ):
            if ability:
                assert differ(first, result(**plain, **values)), (scheme, values)
            else:
                with pytest.raises(ParameterError, match="has no effect"):
                    result(**plain, **values)


def test_thin_plates_of_all_weights_are_one_operator():
    # By its definition: p - r L(L(p)) / nu, nu = 1 + sum w_ij w_ji, L on the boundary taken as 0.
    mesh = meshes.sheet(7, 6, "triangles", jitter=0.3, bump=1.0, seed=2)
    near = adjacency.build(mesh)
    free = np.isin(near.kinds, (adjacency.INTERIOR,))
    for kind in KINDS:
        weights = Weights(kind)
        values = weights.compute(mesh.points, near)
        offsets, neighbours = weights.rows(near)
        w = np.zeros((mesh.n_points, mesh.n_points))
        for v in range(mesh.n_points):
            w[v, neighbours[offsets[v] : offsets[v + 1]]] = values[offsets[v] : offsets[v + 1]]
        laplacian = w - np.diag(w.sum(axis=1))
        inner = free[:, None] * (laplacian @ mesh.points)
        nu = 1.0 + (w * w.T).sum(axis=1)
        expected = mesh.points - 0.4 * free[:, None] * (laplacian @ inner) / nu[:, None]
        points, _ = loop.smooth(mesh, Directional(weights, (0.4,), thin_plate=True), iterations=1)
        np.testing.assert_allclose(points, expected, atol=1e-13)
        if kind == "umbrella":
            quick, _ = loop.smooth(mesh, ThinPlate(0.4), iterations=1)
            np.testing.assert_allclose(quick, expected, atol=1e-13)
