"""STL files as other programs write them."""

import io
import struct

import numpy as np
import pytest

from vtksmooth.errors import MeshFileError
from vtksmooth.files import stl
from vtksmooth.files.polygons import Polygons

FACET = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
TRIANGLE = struct.pack("<12f", 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0)


def binary(count, body, head=b"made elsewhere"):
    return head.ljust(80) + struct.pack("<I", count) + body


def read(tmp_path, data):
    path = tmp_path / "mesh.stl"
    path.write_bytes(data.encode() if isinstance(data, str) else data)
    return stl.read(path)


@pytest.mark.parametrize(
    ("data", "note"),
    [
        (f"solid x\n{FACET}endsolid x\n", None),
        (f"\ufeffsolid x\n{FACET}endsolid", None),
        (f"SOLID X\n{FACET.upper()}ENDSOLID X\n", None),
        (f"solid facet vertex endsolid\n{FACET}end solid facet\n", None),
        (
            f"solid x\n{FACET}endsolid x\n".replace("endloop", "end loop").replace("endfacet", "end facet"),
            None,
        ),
        (f"solid x\n{FACET}endsolid x\n".replace("\n", "\r\n"), None),
        (f"solid x {FACET}endsolid x".replace("\n", " "), None),
        (f"solid x\n{FACET}endsolid x\n".replace("\n", "\n\t  "), None),
        (f"solid x\n{FACET.replace('1 0 0', '1,0 0,0 0,0')}endsolid x\n", "decimal commas"),
        (f"solid x\n{FACET.replace('1 0 0', '1.D0 0.d-3 -0')}endsolid x\n", None),
        (f"{FACET}endsolid", None),
        (binary(1, TRIANGLE + b"\0\0"), None),
        (binary(1, TRIANGLE + b"\0\0", b"solid facet endsolid"), None),
        (binary(0, TRIANGLE + b"\0\0"), "announces 0 triangles and holds 1"),
        (binary(2**32 - 1, TRIANGLE + b"\0\0"), "announces 4294967295 triangles and holds 1"),
        (binary(1, TRIANGLE + b"\0\0abc"), "3 bytes behind the triangles"),
        (binary(1, TRIANGLE + b"\3\0abc"), "attribute bytes"),
    ],
)
def test_variants_give_the_same_mesh(tmp_path, data, note):
    mesh, notes = read(tmp_path, data)
    np.testing.assert_array_equal(mesh.points, [[0, 0, 0], [1, 0, 0], [0, 1, 0]])
    assert mesh.points.dtype == np.float32
    assert mesh.connectivity.tolist() == [0, 1, 2]
    assert "(3 to 3)" in notes[0]
    assert len(notes) == 1 + bool(note)
    assert note is None or note in notes[1]


@pytest.mark.parametrize(
    ("data", "what"),
    [
        (f"solid x\n{FACET}{FACET[:60]}", "endsolid"),
        (f"solid x\n{FACET.replace('vertex 1 0 0', 'vertex 1 0')}endsolid\n", "line of vertex 2"),
        (f"solid x\n{FACET.replace('vertex 1 0 0', 'vertex 1 0 x')}endsolid\n", "line of vertex 2 .'1 0 x'"),
        (f"solid x\n{FACET.replace('vertex 1 0 0', '')}endsolid\n", "facet 1 has 2 vertices"),
        (f"solid x\nvertex 1 2 3\n{FACET}endsolid\n", "before the first facet"),
        (binary(3, (TRIANGLE + b"\0\0") * 2), "announces 3 triangles in 184 bytes"),
        (binary(0, b""), "no triangles"),
        (binary(0, b"\0" * 900), "no triangles"),
        (binary(0, TRIANGLE), "goes on for 48 bytes"),
        (b"solid", "not an STL file"),
        (b"\0" * 84, "no triangles"),
    ],
)
def test_what_is_wrong_is_said_in_one_sentence(tmp_path, data, what):
    with pytest.raises(MeshFileError, match=what) as error:
        read(tmp_path, data)
    assert "\n" not in str(error.value)


def test_polygons_and_flat_triangles(tmp_path):
    square = FACET.replace("endloop", "vertex 1 1 0\nendloop")
    flat = FACET.replace("vertex 0 1 0", "vertex 1 0 0")
    mesh, notes = read(tmp_path, f"solid\n{FACET}{flat}{square}endsolid\n")
    assert mesh.sizes.tolist() == [3, 4]
    assert "1 triangles with two equal corners left out" in notes[0]


def test_solids_survive(tmp_path):
    far = FACET.replace("1", "2")
    text = f"solid inlet\n{FACET}endsolid inlet\nsolid\n{FACET}{far}endsolid\nsolid inlet\n{far}endsolid\n"
    mesh, notes = read(tmp_path, text)
    assert mesh.cell_data["SolidIds"].tolist() == [0, 1, 1, 2]
    assert [*mesh.field_data["SolidNames"]] == ["inlet", "", "inlet"]
    assert "has 3 solids" in notes[1]
    file = io.BytesIO()
    kept = stl.write(file, mesh)
    assert kept.cell_data == {"SolidIds"}
    assert kept.field_data == {"SolidNames"}
    back, _ = read(tmp_path, file.getvalue())
    assert back.cell_data["SolidIds"].tolist() == [0, 1, 1, 2]
    assert [*back.field_data["SolidNames"]] == ["inlet", "", "inlet"]
    np.testing.assert_array_equal(back.points[back.connectivity], mesh.points[mesh.connectivity])


@pytest.mark.parametrize("solids", [False, True])
def test_every_bit_of_single_precision_survives(tmp_path, solids):
    points = np.random.default_rng(0).normal(size=(300, 3)).astype(np.float32) * np.float32(1e-9)
    cell_data = (
        {"SolidIds": np.arange(100) % 2} if solids else {"StlAttribute": np.arange(100, dtype=np.uint16)}
    )
    file = io.BytesIO()
    stl.write(file, Polygons(points, np.full(100, 3), np.arange(300), {}, cell_data))
    back, _ = read(tmp_path, file.getvalue())
    order = np.argsort(np.arange(100) % 2, kind="stable") if solids else np.arange(100)
    np.testing.assert_array_equal(back.points[back.connectivity].reshape(-1, 9), points.reshape(-1, 9)[order])
    name = "SolidIds" if solids else "StlAttribute"
    np.testing.assert_array_equal(back.cell_data[name], cell_data[name][order])


def test_coordinates_beyond_single_precision_stay(tmp_path):
    facet = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1e39 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
    (tmp_path / "m.stl").write_text(f"solid\n{facet}endsolid\n")
    mesh, _ = stl.read(tmp_path / "m.stl")
    assert mesh.points.max() == 1e39
