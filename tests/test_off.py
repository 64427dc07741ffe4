import io

import numpy as np
import pytest

from vtksmooth.errors import MeshFileError
from vtksmooth.files import off
from vtksmooth.files.polygons import Polygons

SQUARE = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n"


def read(tmp_path, text):
    path = tmp_path / "mesh.off"
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return off.read(path)[0]


@pytest.mark.parametrize(
    "text",
    [
        f"OFF\n4 2 0\n{SQUARE}3 0 1 2\n3 0 2 3\n",
        f"OFF 4 2 0\n{SQUARE}3 0 1 2\n3 0 2 3\n",
        f"OFF\n4 2\n{SQUARE}3 0 1 2\n3 0 2 3",
        f"OFF4 2 0\n{SQUARE}3 0 1 2\n3 0 2 3\n",
        f"off\n4 2 0\n{SQUARE}3 0 1 2\n3 0 2 3\n",
        f"\ufeffOFF\n4\n2\n1\n{SQUARE}3 0 1 2\n3 0 2 3\n",
        f"4 2 0\n{SQUARE}3 0 1 2\n3 0 2 3\n",
        f"OFF 4 2 0 {SQUARE}3 0 1 2 3 0 2 3\n".replace("\n", " "),
        f"OFF\n4 2 0\n{SQUARE.replace('1', '1,0')}3 0 1 2\n3 0 2 3\n",
        "STOFF\n4 2 0\n0 0 0 9 9\n1 0 0 9 9\n1 1 0 9 9\n0 1 0 9 9\n3 0 1 2\n3 0 2 3\n",
        f"# made by hand\nOFF\n# counts\n4 2 0 # here\n\n{SQUARE}\n# faces\n3 0 1 2 # one\n3 0 2 3\n",
        f"OFF\r\n4 2 0\r\n{SQUARE}3 0 1 2\r\n3 0 2 3\r\n".replace("\n", "\r\n").replace("\r\r", "\r"),
        f"OFF\n4 2 0\n{SQUARE}3 0 1 2 255 0 0\n3 0 2 3 0 255 0\n",
        f"OFF\n4 2 0\n{SQUARE}3 0 1 2 0.5 0.5 0.5 1\n3 0 2 3\n",
        "COFF\n4 2 0\n0 0 0 9 9 9 1\n1 0 0 9 9 9 1\n1 1 0 9 9 9 1\n0 1 0 9 9 9 1\n3 0 1 2\n3 0 2 3\n",
        "NOFF\n4 2 0\n0 0 0 0 0 1\n1 0 0 0 0 1\n1 1 0 0 0 1\n0 1 0 0 0 1\n3 0 1 2\n3 0 2 3\n",
        "COFF\n4 2 0\n0 0 0 9 9 9\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n",
    ],
)
def test_variants_give_the_same_mesh(tmp_path, text):
    mesh = read(tmp_path, text)
    np.testing.assert_array_equal(mesh.points, [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    assert mesh.sizes.tolist() == [3, 3]
    assert mesh.connectivity.tolist() == [0, 1, 2, 0, 2, 3]


def test_polygons_of_any_size(tmp_path):
    mesh = read(tmp_path, f"OFF\n5 3 0\n{SQUARE}.5 2 0\n3 0 1 2\n5 0 1 2 4 3\n4 0 1 2 3\n")
    assert mesh.sizes.tolist() == [3, 5, 4]
    assert mesh.connectivity.tolist() == [0, 1, 2, 0, 1, 2, 4, 3, 0, 1, 2, 3]


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("3 1 0\n", "too short"),
        ("v 1 0 0\n", "does not begin with OFF"),
        ("solid\n", "does not begin with OFF"),
        ("OFFICE\n", "does not begin with OFF"),
        ("4OFF\n4 2 0\n", "another dimension"),
        ("nOFF\n3\n4 2 0\n", "another dimension"),
        ("OFF BINARY\n\0\0\0\4", "binary"),
        ("OFF\nfour two\n", "no line with the numbers"),
        ("OFF\n4000000000000 2 0\n0 0 0\n", "truncated"),
        (f"OFF\n4 2 0\n{SQUARE}3 0 1 2\n", "truncated"),
        (f"OFF\n4 2 0\n{SQUARE.replace('1 1 0', '1 x 0')}3 0 1 2\n3 0 2 3\n", "line of point 2"),
        (f"OFF\n4 2 0\n{SQUARE}3 0 1 2\n3 0 2\n", "line of face 1"),
        (f"OFF\n4 2 0\n{SQUARE}3 0 1 2\n3 0 2 3.5\n", "line of face 1"),
        (f"OFF\n4 2 0\n{SQUARE}3 0 1 2\nthree 0 2 3\n", "line of face 1"),
        (b"OFF\n4 2 0\n" + bytes(range(128, 256)) * 20, "truncated|line of point 0"),
    ],
)
def test_what_is_wrong_is_said(tmp_path, text, what):
    with pytest.raises(MeshFileError, match=what):
        read(tmp_path, text)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_writing_keeps_every_bit(tmp_path, dtype):
    points = np.random.default_rng(0).normal(size=(20, 3)).astype(dtype) * dtype(1e-7)
    sizes, connectivity = np.array([3, 5]), np.array([0, 1, 2, 7, 8, 9, 10, 19])
    file = io.BytesIO()
    off.write(file, Polygons(points, sizes, connectivity, {}, {}))
    mesh = read(tmp_path, file.getvalue())
    np.testing.assert_array_equal(mesh.points, points)
    assert mesh.sizes.tolist() == [3, 5]
    np.testing.assert_array_equal(mesh.connectivity, connectivity)


COLOURS = {
    "uint8": np.array([[0, 1, 255], [7, 8, 9], [1, 1, 1], [0, 0, 0]], np.uint8),
    "dark": np.array([[0, 1, 1], [1, 0, 0], [1, 1, 1], [0, 0, 0]], np.uint8),
    "with alpha": np.array([[0, 1, 255, 128], [7, 8, 9, 255], [1, 1, 1, 0], [0, 0, 0, 1]], np.uint8),
}


@pytest.mark.parametrize("kind", COLOURS)
def test_colours_normals_and_texture_coordinates_survive(tmp_path, kind):
    rng = np.random.default_rng(0)
    colours = COLOURS[kind]
    name = "RGB" if colours.shape[1] == 3 else "RGBA"
    point_data = {
        "Normals": rng.normal(size=(4, 3)).astype(np.float32),
        name: colours,
        "TCoords": rng.random((4, 2)).astype(np.float32),
        "heat": rng.random(4),
    }
    cell_data = {name: colours[:2], "part": np.arange(2)}
    points = rng.random((4, 3))
    mesh = Polygons(points, np.array([3, 4]), np.array([0, 1, 2, 0, 1, 2, 3]), point_data, cell_data)
    file = io.BytesIO()
    kept = off.write(file, mesh)
    assert kept.point_data == {"Normals", name, "TCoords"}
    assert kept.cell_data == {name}
    back = read(tmp_path, file.getvalue())
    np.testing.assert_array_equal(back.points, points)
    for array in kept.point_data:
        np.testing.assert_array_equal(back.point_data[array], point_data[array])
        assert back.point_data[array].dtype == point_data[array].dtype
    np.testing.assert_array_equal(back.cell_data[name], colours[:2])


def test_what_the_header_does_not_announce_is_said(tmp_path):
    path = tmp_path / "mesh.off"
    path.write_text(
        f"OFF\n4 2 0\n{SQUARE.replace('0 0 0', '0 0 0 5')}3 0 1 2 1 0 0\n3 0 2 3\nmore 1\n".replace(
            "more ", ""
        )
    )
    mesh, notes = off.read(path)
    assert mesh.point_data == mesh.cell_data == {}
    assert [note for note in notes if "does not announce" in note]
    assert [note for note in notes if "colours of faces left out" in note]
    assert [note for note in notes if "1 lines behind the faces" in note]
