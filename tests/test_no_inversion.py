import meshes
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from schemes import SCHEMES
from test_invariants import surfaces

from vtksmooth.kernels.measures import aspect_ratio
from vtksmooth.kernels.mesh.mesh import Mesh
from vtksmooth.kernels.smoothing import loop
from vtksmooth.kernels.smoothing.constraints import Constraint
from vtksmooth.kernels.smoothing.constraints.gate import Gate
from vtksmooth.kernels.smoothing.constraints.no_inversion import NoInversion
from vtksmooth.kernels.smoothing.schemes import Scheme


class To(Scheme):
    """Proposes places that are given."""

    def __init__(self, places):
        self.places = places

    def propose(self, state, turn, starts, ends, proposed):
        places = state.in_order(self.places)
        for start, end in zip(starts, ends, strict=True):
            proposed[start:end] = np.where(
                state.pinned[start:end, None] != 0, state.points[start:end], places[start:end]
            )


class OneByOne(Constraint):
    in_place = True


@pytest.mark.parametrize("one_by_one", [False, True])
@pytest.mark.parametrize(("way", "kept"), [(0.9, 0.9), (1.6, 0.8), (3.0, 0.75), (7.0, 0.875), (9.0, 0.0)])
def test_steps_are_halved_three_times_then_refused(way, kept, one_by_one):
    # The middle of a square goes beyond its right side, which is 1 away.
    corners = [[1, -1, 0], [1, 1, 0], [-1, 1, 0], [-1, -1, 0]]
    mesh = Mesh.from_faces([[0, 0, 0], *corners], [[0, 1 + i, 1 + (i + 1) % 4] for i in range(4)])
    places = mesh.points.copy()
    places[0] = [way, 0, 0]
    constraints = [NoInversion(), *[OneByOne()] * one_by_one]
    points, report = loop.smooth(mesh, To(places), constraints, iterations=1)
    np.testing.assert_array_equal(points[0], [kept, 0, 0])
    np.testing.assert_array_equal(points[1:], mesh.points[1:])
    assert report.inverted == (0, 0)


def test_neighbours_that_change_places_are_shortened_together():
    mesh = meshes.sheet(5, 4)
    places = mesh.points.copy()
    places[14, 0] += 1.2
    places[15, 0] -= 1.2
    points, report = loop.smooth(mesh, To(places), [NoInversion()], iterations=1)
    assert report.inverted == (0, 0)
    # Halved once they would still have changed places.
    np.testing.assert_allclose(points - mesh.points, (places - mesh.points) / 4)
    loose, report = loop.smooth(mesh, To(places), iterations=1)
    np.testing.assert_array_equal(loose, places)
    assert report.inverted[1] > 0


@given(
    mesh=surfaces(),
    scheme=st.sampled_from(list(SCHEMES.values())),
    gate=st.sampled_from([[], [OneByOne()], [Gate("angle")]]),
)
@settings(max_examples=150)
def test_no_face_that_is_not_inverted_becomes_so(mesh, scheme, gate):
    directions = aspect_ratio.reference_directions(mesh)
    before = aspect_ratio.aspect_ratios(mesh, directions)
    for passes in range(1, 5):
        points, report = loop.smooth(mesh, scheme, [NoInversion(), *gate], iterations=passes)
        after = aspect_ratio.aspect_ratios(mesh.with_points(points), directions)
        assert not ((after < 0) & (before >= 0)).any()
        assert report.inverted[1] <= report.inverted[0]
        before = after


@pytest.mark.parametrize("name", meshes.HOSTILE)
@pytest.mark.parametrize("one_by_one", [False, True])
def test_hostile_meshes(name, one_by_one):
    mesh = meshes.HOSTILE[name]()
    constraints = [NoInversion(), *[OneByOne()] * one_by_one]
    _, report = loop.smooth(mesh, SCHEMES["umbrella"], constraints, iterations=3)
    assert report.inverted[1] <= report.inverted[0]
