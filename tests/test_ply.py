import io
import struct

import numpy as np
import pytest
import pyvista as pv

from vtksmooth.errors import MeshFileError
from vtksmooth.files import ply
from vtksmooth.files.polygons import Polygons

HEADER = (
    "ply\nformat {} 1.0\ncomment by hand\nelement vertex 4\nproperty float x\nproperty float y\n"
    "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
    "element face 2\nproperty list uchar int vertex_indices\nproperty short part\nend_header\n"
)
POINTS = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
FACES = [((0, 1, 2, 3), 7), ((0, 2, 3), -8)]


def encode(kind):
    if kind == "ascii":
        rows = [" ".join(map(str, (*p, 1, 2, 3))) for p in POINTS]
        rows += [f"{len(f)} {' '.join(map(str, f))} {part}" for f, part in FACES]
        return (HEADER.format(kind) + "\n".join(rows) + "\n").encode()
    order = {"binary_little_endian": "<", "binary_big_endian": ">"}[kind]
    body = b"".join(struct.pack(f"{order}3f3B", *p, 1, 2, 3) for p in POINTS)
    body += b"".join(struct.pack(f"{order}B{len(f)}ih", len(f), *f, part) for f, part in FACES)
    return HEADER.format(kind).encode() + body


def read(tmp_path, data):
    path = tmp_path / "mesh.ply"
    path.write_bytes(data)
    return ply.read(path)


KINDS = ["ascii", "binary_little_endian", "binary_big_endian"]


@pytest.mark.parametrize("kind", KINDS)
def test_encodings(tmp_path, kind):
    mesh, notes = read(tmp_path, encode(kind))
    assert notes == []
    assert mesh.points.dtype == np.float32
    np.testing.assert_array_equal(mesh.points, POINTS)
    assert mesh.sizes.tolist() == [4, 3]
    assert mesh.connectivity.tolist() == [0, 1, 2, 3, 0, 2, 3]
    assert mesh.cell_data["part"].tolist() == [7, -8]
    assert mesh.point_data["RGB"].tolist() == [[1, 2, 3]] * 4


@pytest.mark.parametrize("kind", KINDS)
def test_truncation_anywhere_is_noticed(tmp_path, kind):
    data = encode(kind)
    # The last two bytes of the text are a digit and the line's end.
    for end in range(len(data) - (1 if kind != "ascii" else 3)):
        with pytest.raises(MeshFileError):
            read(tmp_path, data[:end])


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("vertex 4", "vertex 400000000000000"),
        ("face 2", "face 4000000000"),
        ("float x", "floaty x"),
        ("list uchar int", "list float int"),
        ("format ascii", "format morse"),
        ("property float z\n", ""),
        ("vertex_indices", "corners"),
        ("element face", "element patch"),
        ("end_header", "end"),
        ("ply\n", "plywood\n"),
        ("1 1 0", "1 one 0"),
    ],
)
def test_damaged_files_are_refused(tmp_path, old, new):
    text = encode("ascii").decode()
    assert old in text
    with pytest.raises(MeshFileError):
        read(tmp_path, text.replace(old, new, 1).encode())


VERTEX = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
FACE = "element face 1\nproperty list uchar int vertex_indices\n"
BODY = "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"


@pytest.mark.parametrize(
    ("text", "what"),
    [
        (VERTEX + FACE + "element vertex 1\nproperty float x\n" + BODY + "7\n", "element 'vertex' twice"),
        (VERTEX + "property float x\n" + FACE + BODY, "property 'x' twice"),
        (VERTEX.replace("float y", "list uchar float y") + FACE + BODY, "no points with x, y and z"),
        (VERTEX + FACE.replace("list uchar int", "int") + BODY.replace("3 0 1 2", "3"), "no faces"),
    ],
)
def test_headers_that_say_something_else_are_refused(tmp_path, text, what):
    with pytest.raises(MeshFileError, match=what):
        read(tmp_path, f"ply\nformat ascii 1.0\n{text}".encode())


def test_what_types_do_not_hold_and_what_follows_is_said(tmp_path):
    text = VERTEX + "property uchar red\nproperty float big\n" + FACE + BODY.replace(" 0\n", " 0 300 1e99\n")
    mesh, notes = read(tmp_path, f"ply\nformat ascii 1.0\n{text}4 5\n".encode())
    assert mesh.sizes.tolist() == [3]
    assert [note.split(": ", 1)[1] for note in notes] == [
        "2 numbers behind the last element left out.",
        "numbers that the types in the header do not hold were changed: big, red.",
    ]


def test_arrays_of_edges_that_faces_lack_are_kept(tmp_path):
    text = (
        VERTEX
        + FACE
        + "element edge 1\nproperty int vertex1\nproperty int vertex2\nproperty int width\n"
        + BODY
    )
    mesh, notes = read(tmp_path, f"ply\nformat ascii 1.0\n{text}0 2 9\n".encode())
    assert notes == []
    assert mesh.cell_data["width"].tolist() == [9, 0]


def test_lists_besides_the_faces_are_left_out_and_said(tmp_path):
    text = encode("ascii").decode().replace("property short part", "property list uchar float texcoord")
    mesh, notes = read(tmp_path, text.replace(" 7\n", " 2 0.5 0.5\n").replace(" -8\n", " 0\n").encode())
    assert mesh.sizes.tolist() == [4, 3]
    assert len(notes) == 1
    assert "texcoord" in notes[0]


def test_writing_and_reading_keep_points_and_arrays(tmp_path):
    random = np.random.default_rng(1)
    mesh = Polygons(
        random.normal(size=(9, 3)),
        np.array([3, 4, 3, 5]),
        random.integers(0, 9, 15),
        {"Normals": random.normal(size=(9, 3)), "big": np.arange(9) * 2**40, "a b": np.arange(9) > 4},
        {"id": np.arange(4), "v": random.normal(size=(4, 2)).astype(np.float32)},
    )
    file = io.BytesIO()
    ply.write(file, mesh)
    again, notes = read(tmp_path, file.getvalue())
    assert notes == []
    assert again.points.dtype == np.float64
    for field in ("points", "sizes", "connectivity"):
        np.testing.assert_array_equal(getattr(again, field), getattr(mesh, field))
    np.testing.assert_array_equal(again.point_data["Normals"], mesh.point_data["Normals"])
    np.testing.assert_array_equal(again.point_data["big"], mesh.point_data["big"])
    np.testing.assert_array_equal(again.point_data["a_b"], mesh.point_data["a b"])
    np.testing.assert_array_equal(again.cell_data["id"], mesh.cell_data["id"])
    np.testing.assert_array_equal(again.cell_data["v_1"], mesh.cell_data["v"][:, 1])


@pytest.mark.parametrize("n", [3, 200])
def test_texture_coordinates_of_corners_survive(tmp_path, n):
    points = np.random.default_rng(0).random((n, 3))
    corners = np.concatenate((np.arange(n), [2, 1, 0]))
    table = np.column_stack((corners, np.arange(2 * len(corners)).reshape(-1, 2)))
    mesh = Polygons(
        points, np.array([n, 3]), corners, {}, {"id": np.arange(2)}, field_data={"CornerTCoords": table}
    )
    file = io.BytesIO()
    assert ply.write(file, mesh).field_data == {"CornerTCoords"}
    back, notes = read(tmp_path, file.getvalue())
    assert len(notes) == 1
    assert "kept in the field array CornerTCoords only, as they differ" in notes[0]
    np.testing.assert_array_equal(back.field_data["CornerTCoords"], table)
    assert back.cell_data["id"].tolist() == [0, 1]
    file = io.BytesIO()
    assert ply.write(file, mesh._replace(connectivity=np.roll(corners, 1))).field_data == set()


@pytest.mark.parametrize("binary", [True, False])
def test_vtk_and_we_understand_each_other(tmp_path, binary):
    sphere = pv.Sphere(theta_resolution=8, phi_resolution=8)
    sphere.save(tmp_path / "vtk.ply", binary=binary)
    mesh, _ = ply.read(tmp_path / "vtk.ply")
    np.testing.assert_allclose(mesh.points, sphere.points, atol=1e-6)
    np.testing.assert_array_equal(mesh.connectivity, sphere.regular_faces.ravel())
    with (tmp_path / "ours.ply").open("wb") as file:
        ply.write(file, mesh)
    np.testing.assert_array_equal(pv.read(tmp_path / "ours.ply").points, mesh.points)
