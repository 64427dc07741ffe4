"""3MF files: points and triangles are those of the mesh."""

import importlib.util
import xml.etree.ElementTree as ET
import zipfile

import numpy as np
import pytest
import pyvista as pv

from vtksmooth.errors import MeshFileError
from vtksmooth.files import check_writable, write_surface

NAMESPACE = "{http://schemas.microsoft.com/3dmanufacturing/core/2015/02}"


def read(path):
    with zipfile.ZipFile(path) as archive:
        model = ET.fromstring(archive.read("3D/3dmodel.model"))
    (item,) = model.iter(f"{NAMESPACE}object")
    points = [[float(one.get(axis)) for axis in "xyz"] for one in item.iter(f"{NAMESPACE}vertex")]
    faces = [
        [int(one.get(corner)) for corner in ("v1", "v2", "v3")] for one in item.iter(f"{NAMESPACE}triangle")
    ]
    return model.get("unit"), np.array(points), faces


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e30])
def test_points_and_triangles_are_those_of_the_mesh(tmp_path, dtype, scale):
    pytest.importorskip("trimesh")
    mesh = pv.Sphere(theta_resolution=9, phi_resolution=8)
    mesh.points = (mesh.points.astype(np.float64) * scale / 3).astype(dtype)
    assert write_surface(mesh, tmp_path / "m.3mf") == ["m.3mf: 3MF does not keep the arrays Normals."]
    unit, points, faces = read(tmp_path / "m.3mf")
    assert unit == "millimeter"
    np.testing.assert_array_equal(points, mesh.points)
    assert faces == mesh.regular_faces.tolist()


def test_equal_points_and_points_of_no_face_stay(tmp_path):
    pytest.importorskip("trimesh")
    mesh = pv.PolyData(
        np.array([[0, 0, 0], [0, 0, 0], [1, 0, 0], [0, 1, 0], [5.0, 5, 5]]), [3, 0, 2, 3, 3, 1, 3, 2]
    )
    assert write_surface(mesh, tmp_path / "m.3mf") == []
    _, points, faces = read(tmp_path / "m.3mf")
    np.testing.assert_array_equal(points, mesh.points)
    assert faces == mesh.regular_faces.tolist()


def test_triangles_with_two_equal_corners_are_left_out_and_that_is_said(tmp_path):
    pytest.importorskip("trimesh")
    mesh = pv.PolyData(np.eye(3, dtype=np.float32), [3, 0, 1, 2, 3, 0, 1, 1])
    assert write_surface(mesh, tmp_path / "m.3mf") == [
        "m.3mf: 1 triangles with two equal corners were left out."
    ]
    assert read(tmp_path / "m.3mf")[2] == [[0, 1, 2]]


def test_without_the_package_it_is_said_what_to_do(tmp_path, monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(MeshFileError, match=r"pip install trimesh lxml networkx.*or write \.stl"):
        check_writable(tmp_path / "m.3mf")
