"""glTF files: what VTK's writer makes of a mesh comes back."""

import json

import numpy as np
import pytest
import pyvista as pv

from vtksmooth.errors import MeshFileError
from vtksmooth.files import read_surface, write_surface


@pytest.fixture
def sphere():
    mesh = pv.Sphere(theta_resolution=9, phi_resolution=8).compute_normals(cell_normals=False)
    mesh["uv"] = np.random.default_rng(0).random((mesh.n_points, 2)).astype(np.float32)
    mesh.GetPointData().SetActiveTCoords("uv")
    return mesh


@pytest.mark.parametrize(
    ("name", "dtype", "width"), [("RGB", np.uint8, 3), ("RGBA", np.uint8, 4), ("RGBA", np.float32, 4)]
)
def test_normals_colours_and_texture_coordinates_survive(tmp_path, sphere, name, dtype, width):
    colours = np.random.default_rng(1).random((sphere.n_points, width))
    sphere[name] = (255 * colours).astype(dtype) if dtype == np.uint8 else colours.astype(dtype)
    assert write_surface(sphere, tmp_path / "m.glb") == []
    back, notes = read_surface(tmp_path / "m.glb")
    assert notes == []
    np.testing.assert_array_equal(back.points, sphere.points)
    np.testing.assert_array_equal(back.faces, sphere.faces)
    np.testing.assert_array_equal(back["Normals"], sphere["Normals"])
    np.testing.assert_allclose(back["TCoords"], sphere["uv"], atol=1e-7)
    assert back.point_data.active_texture_coordinates_name == "TCoords"
    assert back.point_data.active_normals_name == "Normals"
    assert back[name].dtype == dtype
    np.testing.assert_array_equal(back[name], sphere[name])


def test_texture_coordinates_begin_at_the_top_in_the_file(tmp_path, sphere):
    write_surface(sphere, tmp_path / "m.glb")
    raw = (tmp_path / "m.glb").read_bytes()
    length = int.from_bytes(raw[12:16], "little")
    scene, values = json.loads(raw[20 : 20 + length]), raw[28 + length :]
    at = scene["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"]
    start = scene["bufferViews"][scene["accessors"][at]["bufferView"]]["byteOffset"]
    u, v = np.frombuffer(values, "<f4", 2 * sphere.n_points, start).reshape(-1, 2).T
    np.testing.assert_array_equal(u, sphere["uv"][:, 0])
    np.testing.assert_array_equal(v, 1 - sphere["uv"][:, 1])


def test_several_rounds_turn_no_texture_upside_down(tmp_path, sphere):
    mesh = sphere
    for i in range(3):
        write_surface(mesh, tmp_path / f"{i}.glb")
        mesh, _ = read_surface(tmp_path / f"{i}.glb")
    np.testing.assert_allclose(mesh["TCoords"], sphere["uv"], atol=1e-6)


@pytest.mark.parametrize("extension", [".glb", ".stl"])
@pytest.mark.parametrize("value", [1e39, -1e300])
def test_what_single_precision_does_not_hold_is_refused(tmp_path, extension, value):
    mesh = pv.PolyData(np.array([[0, 0, 0], [1, 0, 0], [0, value, 0]]), [3, 0, 1, 2])
    with pytest.raises(MeshFileError, match=r"single precision only, which ends at 3\.4e38; scale"):
        write_surface(mesh, tmp_path / f"m{extension}")
    assert [*tmp_path.iterdir()] == []


@pytest.mark.parametrize("extension", [".glb", ".3mf"])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_what_is_no_number_is_refused(tmp_path, extension, value):
    if extension == ".3mf":
        pytest.importorskip("trimesh")
    mesh = pv.PolyData(np.array([[0, 0, 0], [1, 0, 0], [0, value, 0]]), [3, 0, 1, 2])
    with pytest.raises(MeshFileError, match="finite coordinates only; remove"):
        write_surface(mesh, tmp_path / f"m{extension}")
    assert [*tmp_path.iterdir()] == []
