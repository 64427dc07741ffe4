"""Normals of faces against their definition, and whether four triangles at a time are what each is alone."""

import meshes
import numpy as np
import pytest
import reference

from vtksmooth.kernels.measures.dihedral import face_normals
from vtksmooth.kernels.mesh.mesh import Mesh


@pytest.mark.parametrize("scale", [1e-60, 1.0, 1e60])
@pytest.mark.parametrize("name", meshes.USUAL)
def test_normals_and_areas_by_their_definition(name, scale):
    mesh = meshes.USUAL[name]()
    vectors = reference.area_vectors(mesh)
    areas = np.linalg.norm(vectors, axis=1)
    normals = face_normals(mesh.with_points(mesh.points * scale))
    np.testing.assert_allclose(normals[:, 3], areas * scale**2, rtol=1e-13)
    np.testing.assert_allclose(normals[:, :3], vectors / areas[:, None], atol=1e-13)


def test_the_bits_of_a_face_do_not_depend_on_its_neighbours():
    mesh = meshes.torus(9, 7, "mixed", jitter=0.2)
    mesh.points[:3] = mesh.points[3]  # some have no area
    faces = meshes.lists(mesh)
    alone = np.vstack([face_normals(Mesh.from_faces(mesh.points, [face])) for face in faces])
    np.testing.assert_array_equal(face_normals(mesh), alone)
    triangles = [face for face in faces if len(face) == 3]
    together = face_normals(Mesh.from_faces(mesh.points, triangles))
    assert (together[:, 3] == 0).any()
    np.testing.assert_array_equal(together, alone[[len(face) == 3 for face in faces]])
