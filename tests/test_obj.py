"""OBJ files as other programs write them."""

import io

import numpy as np
import pytest

from vtksmooth.errors import MeshFileError
from vtksmooth.files import obj
from vtksmooth.files import text as text_module
from vtksmooth.files.polygons import Polygons

POINTS = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
FACES = "f 1 2 3\nf 1 3 4\nf 1 4 2\nf 2 4 3\n"
CORNERS = [0, 1, 2, 0, 2, 3, 0, 3, 1, 1, 3, 2]


@pytest.fixture(autouse=True, params=["small", "large"])
def size(request, monkeypatch):
    """Large files are read and written by kernels."""
    if request.param == "large":
        monkeypatch.setattr(text_module, "_LARGE", 0)
        monkeypatch.setattr(text_module, "_MANY", 0)


def read(tmp_path, text):
    path = tmp_path / "mesh.obj"
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return obj.read(path)


@pytest.mark.parametrize(
    "text",
    [
        POINTS + FACES,
        FACES + POINTS,
        "\ufeff" + POINTS + FACES,
        (POINTS + FACES).replace("\n", "\r\n"),
        (POINTS + FACES).replace("\n", "\r"),
        (POINTS + FACES).replace(" ", "\t ").replace("\n", " \n  ")[:-2],
        POINTS + FACES.replace("\n", " # a face\n").rstrip(),
        POINTS + FACES.replace("f 1 2 3", "f 1 2 \\\n 3"),
        POINTS + FACES.replace("f", "fo"),
        POINTS + FACES.replace(" 2", " +2"),
        POINTS + FACES.replace("1", "-4").replace("2", "-3").replace("3\n", "-2\n", 1),
        POINTS + FACES.replace(" 3", " 3/").replace(" 4", " 4//"),
        POINTS + "vn 0 0 1\n" + FACES.replace(" 3", " 3//1"),
        POINTS + FACES.replace(" 3", " 3/7/8/9"),
        POINTS + FACES.replace(" 3", " 3/2147483647/-2147483648"),
        POINTS.replace("v 1 0 0", "v 1.D0 0.d-7 -0") + FACES,
        POINTS + "s off\nmg 1\nlod 2\n" + FACES,
    ],
)
def test_variants_give_the_same_mesh(tmp_path, text):
    mesh, _ = read(tmp_path, text)
    np.testing.assert_array_equal(mesh.points, [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    assert mesh.sizes.tolist() == [3, 3, 3, 3]
    assert mesh.connectivity.tolist() == CORNERS
    assert mesh.point_data == {}


def test_negative_indices_count_back_from_their_line(tmp_path):
    part = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\n"
    mesh, _ = read(tmp_path, part + part)
    assert mesh.connectivity.tolist() == [0, 1, 2, 3, 4, 5]


def test_lines_points_and_polygons(tmp_path):
    mesh, notes = read(tmp_path, POINTS + "f 1 2 3 4\np 1 2\nl 1/1 2/1 3\nf 1 2 3\np 3\n")
    assert notes == []
    assert [array.tolist() for array in mesh.verts] == [[2, 1], [0, 1, 2]]
    assert [array.tolist() for array in mesh.lines] == [[3], [0, 1, 2]]
    assert mesh.sizes.tolist() == [4, 3]


def test_parts_have_names_in_any_encoding(tmp_path):
    head = f"mtllib a b.mtl\n{POINTS}f 1 2 3\nusemtl\nf 1 3 4\no x\ng a b\nusemtl ".encode()
    mesh, notes = read(
        tmp_path, head + "größe\nf 1 4 2\n".encode("latin-1") + "usemtl größe\nf 2 4 3".encode()
    )
    assert notes == []
    assert mesh.cell_data["MaterialIds"].tolist() == [0, 0, 1, 1]
    assert [*mesh.field_data["MaterialNames"]] == ["default", "größe"]
    assert mesh.cell_data["GroupIds"].tolist() == mesh.cell_data["ObjectIds"].tolist() == [0, 0, 1, 1]
    assert [*mesh.field_data["GroupNames"]] == ["default", "a b"]
    assert [*mesh.field_data["MaterialLibraries"]] == ["a b.mtl"]


@pytest.mark.parametrize(
    ("more", "kind", "note"),
    [
        ("vt 0 0\nvt 1 0\nvt 0 1\nvt 1 1\n" + FACES, "TCoords", None),  # one for each point
        ("vt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n", "TCoords", None),
        ("vn 0 0 1\nf 1//1 2//1 3//1\n", "Normals", None),
        ("vt 0 0\n" + FACES, None, "no face refers to them"),
        ("vn 0 0 1\nf 1//1 2//1 3\n", None, "not every corner has one"),
        ("vn 0 0 1\nvn 0 1 0\nf 1//1 2//1 3//1\nf 1//2 3//2 4//2\n", None, "differ at points"),
        ("vn 0 0 x\nf 1//1 2//1 3//1\n", None, "not all numbers"),
        ("cstype bezier\ncurv 0 1 1 2\nend\n" + FACES, None, "free form"),
        ("wrong\n" + FACES, None, "1 lines that are not of the format"),
        ("s 1\n" + FACES, None, "smoothing groups"),
    ],
)
def test_what_points_have_is_kept_or_said_to_be_lost(tmp_path, more, kind, note):
    mesh, notes = read(tmp_path, POINTS + more)
    assert [*mesh.point_data] == ([kind] if kind else [])
    assert len(notes) == bool(note)
    assert note is None or note in notes[0]


@pytest.mark.parametrize(
    ("text", "what"),
    [
        (POINTS + "f 0 1 2\n", "point 0, but the points are numbered 1 to 4"),
        (POINTS + "f 1 2 5\n", "point 5, but"),
        (POINTS + "f -1 -2 -5\n", "point -5, but"),
        (POINTS + FACES + "l 1 9\n", "point 9, but"),
        (
            POINTS + "vt 0 0\nf 1/1 2/1 3/2\n",
            "number 2 of its texture coordinates, which are numbered 1 to 1",
        ),
        (POINTS + "vn 0 0 1\nf 1//1 2//1 3//-2\n", "number -2 of its normals, which are numbered 1 to 1"),
        (POINTS + "f 1 2 99999999999999999999999\n", "line of an element"),
        (POINTS + "f 1 2 3.5\n", "line of an element"),
        (POINTS + "f 1 2 nan\n", "line of an element"),
        (POINTS + "f /1 2 3\n", "line of an element"),
        (POINTS + "f a b c\n", "'a b c'"),
        (POINTS + "v 1 2\n" + FACES, "point 5 has 2 numbers instead of 3"),
        (POINTS + "v 1 x 2\n" + FACES, "'1 x 2'"),
        (b"\xff\xd8\xff" + bytes(range(1, 256)) * 9, "not an OBJ file"),
        (b"v\0", "not an OBJ file"),
        ("# nothing\n", "not an OBJ file"),
        (" \n", "not an OBJ file"),
    ],
)
def test_what_is_wrong_is_said_in_one_sentence(tmp_path, text, what):
    with pytest.raises(MeshFileError, match=what) as error:
        read(tmp_path, text)
    assert "\n" not in str(error.value)


def test_texture_coordinates_of_corners_survive(tmp_path):
    text = (
        POINTS + "vt 0 0\nvt 1 0\nvt .5 1e-3\nf 1/1 2/2 3/3\nf 1/2 3/3 4/1\nf 1 4 2\nf 2/1/ 4/2/ 3\nl 1 2\n"
    )
    mesh, notes = read(tmp_path, text)
    assert mesh.point_data == {}
    (note,) = notes
    assert note.endswith("kept in the field array CornerTCoords only, as not every corner has one.")
    u, v = [0, 1, 0.5], [0, 0, np.float32(1e-3)]
    which = [0, 1, 2, 1, 2, 0, None, None, None, 0, 1, None]
    expected = [
        [c, u[i], v[i]] if i is not None else [c, np.nan, np.nan] for c, i in zip(CORNERS, which, strict=True)
    ]
    np.testing.assert_array_equal(mesh.field_data["CornerTCoords"], expected)
    file = io.BytesIO()
    assert obj.write(file, mesh).field_data == {"CornerTCoords"}
    assert file.getvalue().count(b"vt ") == 3
    back, _ = read(tmp_path, file.getvalue())
    np.testing.assert_array_equal(back.field_data["CornerTCoords"], expected)
    # Those of other faces are lost.
    changed = mesh._replace(connectivity=mesh.connectivity[::-1])
    file = io.BytesIO()
    assert obj.write(file, changed).field_data == set()
    assert b"vt" not in file.getvalue()


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_what_is_written_comes_back(tmp_path, dtype):
    rng = np.random.default_rng(0)
    points = (rng.normal(size=(9, 3)) * 1e-7).astype(dtype)
    colours = rng.integers(0, 256, (9, 3)).astype(np.uint8)
    point_data = {
        "RGB": colours,
        "Normals": rng.normal(size=(9, 3)).astype(np.float32),
        "heat": rng.random(9),
    }
    point_data["TCoords"] = rng.random((9, 2)).astype(np.float32)
    cell_data = {"MaterialIds": np.array([0, 1, 1, 2, 1]), "SolidIds": np.array([0, 0, 0, 0, 1])}
    names = {"MaterialNames": np.array(["steel", "", "100%"], object)}
    names["SolidNames"] = np.array(["inlet", "a  wall"], object)
    verts, lines = (np.array([2]), np.array([3, 4])), (np.array([3, 2]), np.array([0, 1, 2, 5, 6]))
    faces = np.array([3, 4]), np.array([0, 1, 2, 5, 6, 7, 8])
    file = io.BytesIO()
    kept = obj.write(file, Polygons(points, *faces, point_data, cell_data, verts, lines, names))
    assert kept.point_data == {"RGB", "Normals", "TCoords"}
    assert kept.cell_data == {"MaterialIds", "SolidIds"}
    back, notes = read(tmp_path, file.getvalue())
    assert notes == []
    np.testing.assert_array_equal(back.points, points)
    for name in kept.point_data:
        np.testing.assert_array_equal(back.point_data[name], point_data[name])
    for here, there in ((verts, back.verts), (lines, back.lines), (faces, (back.sizes, back.connectivity))):
        assert [array.tolist() for array in here] == [array.tolist() for array in there]
    assert back.cell_data["MaterialIds"].tolist() == [0, 1, 1, 2, 1]
    assert [*back.field_data["MaterialNames"]] == ["steel", "part_1", "100%"]
    assert [*back.field_data["GroupNames"]] == ["inlet", "a wall"]
