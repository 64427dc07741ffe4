import importlib.util
import os
import shutil
import subprocess
import sys
import textwrap
from pathlib import Path

import numpy as np
import pytest
import pyvista as pv
from pyvista import examples
from vtkmodules.vtkCommonCore import vtkFloatArray, vtkStringArray, vtkVariantArray
from vtkmodules.vtkCommonDataModel import vtkCellArray

from vtksmooth.errors import MeshFileError
from vtksmooth.files import (
    READABLE,
    WRITABLE,
    check_writable,
    make_folder,
    read_surface,
    write_surface,
    writing,
)
from vtksmooth.filters import LaplacianSmoothing


@pytest.fixture
def mixed():
    """Triangles, quads and a pentagon with every kind of data, in double precision."""
    points = [(0, 0, 0), (1, 0, 0), (2, 0, 0.1), (0, 1, 0), (1, 1, 0.2), (2, 1, 0), (0.5, 2, 0)]
    mesh = pv.PolyData(
        np.array(points, dtype=np.float64) / 3,
        [4, 0, 1, 4, 3, 3, 1, 2, 5, 3, 1, 5, 4, 3, 3, 4, 6],
    )
    mesh.point_data["height"] = np.arange(7) * 0.1
    mesh.point_data["flow"] = np.arange(21).reshape(7, 3) * 0.7
    mesh.cell_data["part"] = np.array([5, 6, 7, 8], dtype=np.int32)
    return mesh


@pytest.fixture(autouse=True)
def needs_trimesh(request):
    """Skip what writes 3MF files where the package for them is not installed."""
    call = getattr(request.node, "callspec", None)
    if call is not None and call.params.get("extension") == ".3mf":
        pytest.importorskip("trimesh")


def leftovers(folder):
    return sorted(p.name for p in folder.iterdir() if p.name.startswith("."))


# ---------------------------------------------------------------------------------------- reading


@pytest.mark.parametrize("extension", [e for e in WRITABLE if e not in writing._TRIANGLES_ONLY])
def test_written_and_read_again_it_is_the_same_surface(tmp_path, mixed, extension):
    write_surface(mixed, tmp_path / f"m{extension}")
    mesh, _ = read_surface(tmp_path / f"m{extension}")
    assert mesh.points.dtype == np.float64
    np.testing.assert_array_equal(mesh.points, mixed.points)
    np.testing.assert_array_equal(mesh.faces, mixed.faces)


@pytest.mark.parametrize("extension", [".vtp", ".vtk", ".vtu", ".vtkhdf", ".ply"])
def test_formats_with_arrays_keep_them(tmp_path, mixed, extension):
    write_surface(mixed, tmp_path / f"m{extension}")
    mesh, _ = read_surface(tmp_path / f"m{extension}")
    np.testing.assert_array_equal(mesh.point_data["height"], mixed.point_data["height"])
    np.testing.assert_array_equal(mesh.cell_data["part"], mixed.cell_data["part"])


@pytest.mark.parametrize("extension", [".obj", ".off", *writing._TRIANGLES_ONLY])
def test_lost_arrays_are_said(tmp_path, mixed, extension):
    assert any("height, flow, part" in note for note in write_surface(mixed, tmp_path / f"m{extension}"))


@pytest.mark.parametrize("extension", writing._TRIANGLES_ONLY)
def test_that_points_were_rounded_and_faces_split_is_said(tmp_path, mixed, extension):
    notes = " ".join(write_surface(mixed, tmp_path / f"m{extension}"))
    assert ("single precision" in notes) == (extension in writing._SINGLE_PRECISION)
    assert "triangles only" in notes


@pytest.mark.parametrize("binary", [True, False])
def test_stl_points_are_merged_and_that_is_said(tmp_path, binary):
    sphere = pv.Sphere()
    sphere.save(tmp_path / "s.stl", binary=binary)
    mesh, notes = read_surface(tmp_path / "s.stl")
    assert mesh.n_points == sphere.n_points
    assert mesh.n_cells == sphere.n_cells
    merged = f"({3 * sphere.n_cells} to {sphere.n_points})"
    assert notes == [f"s.stl: STL has no shared points; equal ones were merged {merged}."]


def test_obj_points_with_several_texture_indices_stay_one(tmp_path):
    (tmp_path / "m.obj").write_text(
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt .5 .5\nf 1/1 2/2 3/3\nf 1/4 3/1 4/2\n"
    )
    mesh, notes = read_surface(tmp_path / "m.obj")
    assert mesh.n_points == 4
    assert mesh.regular_faces.tolist() == [[0, 1, 2], [0, 2, 3]]
    assert len(notes) == 1
    assert "kept in the field array CornerTCoords only, as they differ at points" in notes[0]
    assert mesh.point_data.keys() == []
    assert LaplacianSmoothing()(mesh).GetFieldData().HasArray("CornerTCoords")
    assert write_surface(mesh, tmp_path / "again.obj") == []
    again, _ = read_surface(tmp_path / "again.obj")
    assert again.n_points == 4
    np.testing.assert_array_equal(again.field_data["CornerTCoords"], mesh.field_data["CornerTCoords"])


def test_obj_without_seams_is_left_alone(tmp_path):
    (tmp_path / "m.obj").write_text("v 0 0 0\nv 0 0 0\nv 1 1 0\nv 0 1 0\nf 1 3 4\nf 2 4 3\n")
    mesh, notes = read_surface(tmp_path / "m.obj")
    assert mesh.n_points == 4  # equal points stay apart: the file says so
    assert notes == []


@pytest.mark.parametrize(
    ("name", "grid"),
    [
        ("g.vtu", pv.ImageData(dimensions=(3, 3, 3)).cast_to_unstructured_grid()),
        ("g.vti", pv.ImageData(dimensions=(3, 3, 3))),
        ("g.vts", pv.ImageData(dimensions=(3, 3, 3)).cast_to_structured_grid()),
        ("g.vtr", pv.ImageData(dimensions=(3, 3, 3)).cast_to_rectilinear_grid()),
        ("g.vtk", pv.ImageData(dimensions=(3, 3, 3)).cast_to_unstructured_grid()),
    ],
)
def test_the_outer_surface_of_a_grid_is_taken_and_that_is_said(tmp_path, name, grid):
    grid.save(tmp_path / name)
    mesh, notes = read_surface(tmp_path / name)
    assert isinstance(mesh, pv.PolyData)
    assert (mesh.n_points, mesh.n_cells) == (26, 24)
    assert mesh.is_manifold
    assert len(notes) == 1
    assert "outer surface" in notes[0]


@pytest.mark.parametrize("name", ["g.vtr", "g.vts"])
def test_a_grid_with_a_negative_number_of_points_is_refused(tmp_path, name):
    grid = pv.ImageData(dimensions=(3, 3, 3))
    grid = grid.cast_to_rectilinear_grid() if name == "g.vtr" else grid.cast_to_structured_grid()
    grid.save(tmp_path / name)
    text = (tmp_path / name).read_bytes()
    assert text.count(b'WholeExtent="0 2 0 2 0 2"') == 1
    (tmp_path / name).write_bytes(text.replace(b'WholeExtent="0 2 0 2 0 2"', b'WholeExtent="0 2 0 2 4 2"'))
    with pytest.raises(MeshFileError, match="damaged"):
        read_surface(tmp_path / name)


def test_blocks_are_combined_and_that_is_said(tmp_path):
    blocks = pv.MultiBlock([pv.Sphere(), None, pv.Cube().cast_to_unstructured_grid()])
    blocks.save(tmp_path / "b.vtm")
    mesh, notes = read_surface(tmp_path / "b.vtm")
    assert mesh.n_cells == pv.Sphere().n_cells + 6
    assert "2 blocks" in notes[0]


@pytest.mark.parametrize("name", [examples.planefile, examples.antfile, examples.nutfile])
def test_bundled_meshes_are_read_as_vtk_reads_them(name):
    mesh, notes = read_surface(name)
    expected = pv.read(name)
    np.testing.assert_array_equal(mesh.points, expected.points)
    np.testing.assert_array_equal(mesh.faces, expected.faces)
    assert notes == []


# ------------------------------------------------------------------------------------ wrong files


@pytest.mark.parametrize("extension", READABLE)
@pytest.mark.parametrize(
    "content",
    [b"", b"\n", bytes(1000), bytes(range(256)) * 40, b"lorem ipsum dolor sit amet\n" * 100],
    ids=["empty", "newline", "zeros", "binary", "text"],
)
def test_what_is_no_mesh_is_refused_in_one_sentence(tmp_path, capfd, extension, content):
    path = tmp_path / f"m{extension}"
    path.write_bytes(content)
    with pytest.raises(MeshFileError) as error:
        read_surface(path)
    assert "\n" not in str(error.value)
    assert ";" in str(error.value)
    assert path.name in str(error.value)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("extension", [".ply", ".stl", ".vtp", ".off", ".vtkhdf", ".vtu"])
@pytest.mark.parametrize("part", [0.1, 0.4, 0.7, 0.97])
def test_truncated_files_are_refused(tmp_path, capfd, extension, part):
    path = tmp_path / f"m{extension}"
    write_surface(pv.Sphere(theta_resolution=12, phi_resolution=12), path)
    data = path.read_bytes()
    path.write_bytes(data[: int(part * len(data))])
    with pytest.raises(MeshFileError):
        read_surface(path)
    assert capfd.readouterr() == ("", "")


def test_truncated_ascii_stl_is_refused(tmp_path):
    facet = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
    # Cut where VTK sees nothing wrong.
    (tmp_path / "s.stl").write_text(f"solid x\n{facet}{facet[:-46]}")
    with pytest.raises(MeshFileError, match="endsolid"):
        read_surface(tmp_path / "s.stl")


def test_faces_that_refer_to_no_point_are_refused(tmp_path):
    texts = {
        "m.off": "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 9\n",
        "m.obj": "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 10\n",
        "m.vtk": "# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\nPOINTS 3 float\n0 0 0 1 0 0 0 1 0\n"
        "POLYGONS 1 4\n3 0 1 9\n",
    }
    for name, text in texts.items():
        (tmp_path / name).write_text(text)
        # In OBJ, points are numbered from 1 on.
        with pytest.raises(MeshFileError, match=f"refers to point {10 if name == 'm.obj' else 9}"):
            read_surface(tmp_path / name)


@pytest.mark.parametrize(("number", "kind"), [(3, 12), (3, 253), (2, 5)])
def test_cells_that_do_not_fit_their_type_are_refused(tmp_path, number, kind):
    corners = " ".join(map(str, range(number)))
    (tmp_path / "m.vtk").write_text(
        "# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 3 float\n0 0 0 1 0 0 0 1 0\n"
        f"CELLS 1 {number + 1}\n{number} {corners}\nCELL_TYPES 1\n{kind}\n"
    )
    with pytest.raises(MeshFileError, match=f"type {kind}"):
        read_surface(tmp_path / "m.vtk")


def test_points_without_faces_are_refused(tmp_path):
    pv.PolyData(np.eye(3)).save(tmp_path / "p.vtp")
    with pytest.raises(MeshFileError, match="no faces"):
        read_surface(tmp_path / "p.vtp")


def test_faces_of_two_corners_are_left_out_and_that_is_said(tmp_path):
    (tmp_path / "m.off").write_text("OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n2 0 1\n3 0 1 2\n")
    mesh, notes = read_surface(tmp_path / "m.off")
    assert mesh.regular_faces.tolist() == [[0, 1, 2]]
    assert "1 faces with less than three corners" in notes[0]


def test_absurd_counts_do_not_end_the_process(tmp_path):
    path = tmp_path / "m.vtp"
    write_surface(pv.Sphere(), path)
    path.write_bytes(path.read_bytes().replace(b'NumberOfPoints="842"', b'NumberOfPoints="842000000000"'))
    with pytest.raises(MeshFileError, match="842000000000"):
        read_surface(path)


def test_huge_files_that_are_no_meshes_are_refused_at_once(tmp_path):
    for extension in READABLE:
        path = tmp_path / f"huge{extension}"
        with path.open("wb") as file:
            file.truncate(2 << 30)  # sparse: takes no room
        with pytest.raises(MeshFileError):
            read_surface(path)


@pytest.mark.parametrize(
    ("name", "what"),
    [("none.ply", "check the path"), ("", "folder"), ("m.xyz", "not known"), ("m", "not known")],
)
def test_paths_that_are_no_mesh_files(tmp_path, name, what):
    if name.startswith("m"):
        (tmp_path / name).write_text("x")
    with pytest.raises(MeshFileError, match=what):
        read_surface(tmp_path / name)


@pytest.mark.parametrize("name", ["a\0.ply", "~no such user/a.ply", "\ud800.ply"])
def test_paths_that_can_be_none_are_refused(name):
    for function in (check_writable, read_surface, lambda path: write_surface(pv.Sphere(), path)):
        with pytest.raises(MeshFileError, match="can be no path"):
            function(name)
    with pytest.raises(MeshFileError, match="cannot make the folder"):
        make_folder(Path("a\0b"))


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs named pipes")
def test_a_pipe_is_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "m.ply")
    with pytest.raises(MeshFileError, match="regular file"):
        read_surface(tmp_path / "m.ply")


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may do everything")
def test_missing_permissions(tmp_path):
    path = tmp_path / "m.vtp"
    write_surface(pv.Sphere(), path)
    path.chmod(0)
    with pytest.raises(MeshFileError, match="permissions"):
        read_surface(path)
    with pytest.raises(MeshFileError, match="write-protected"):
        check_writable(path)
    tmp_path.chmod(0o500)
    with pytest.raises(MeshFileError, match="not writable"):
        check_writable(tmp_path / "other.vtp")
    tmp_path.chmod(0o700)


# ---------------------------------------------------------------------------------------- writing


@pytest.mark.parametrize(
    ("name", "what"),
    [
        ("m.xyz", "no format"),
        ("m", "no format"),
        ("none/m.vtp", "no folder"),
        ("folder.vtp", "it is a folder"),
        ("n" * 300 + ".vtp", "cannot write"),
    ],
)
def test_unwritable_paths_are_refused_before(tmp_path, name, what):
    (tmp_path / "folder.vtp").mkdir()
    for function in (check_writable, lambda path: write_surface(pv.Sphere(), path)):
        with pytest.raises(MeshFileError, match=what):
            function(tmp_path / name)
    assert leftovers(tmp_path) == []


@pytest.mark.parametrize("extension", WRITABLE)
def test_a_failing_disk_leaves_the_old_file(tmp_path, mixed, extension):
    """The size limit of a process acts as a full disk."""
    path = tmp_path / f"m{extension}"
    write_surface(mixed, path)
    before = path.read_bytes()
    script = """
        import resource, signal, sys
        import pyvista as pv
        from vtksmooth.errors import MeshFileError
        from vtksmooth.files import write_surface
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (3000, 3000))
        try:
            write_surface(pv.Sphere(), sys.argv[1])
        except MeshFileError as error:
            print(error)
    """
    pytest.importorskip("resource")
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(script), str(path)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.stdout.startswith("cannot write")
    assert len(done.stdout.splitlines()) == 1
    assert path.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


@pytest.mark.parametrize("failure", [KeyboardInterrupt, RuntimeError, MemoryError])
def test_an_interrupted_write_leaves_the_old_file(tmp_path, monkeypatch, failure):
    path = tmp_path / "m.ply"
    path.write_text("old")

    def half(file, mesh):
        file.write(b"ply\n")
        raise failure

    monkeypatch.setitem(writing._WRITE_POLYGONS, ".ply", half)
    with pytest.raises(failure):
        write_surface(pv.Sphere(), path)
    assert path.read_text() == "old"
    assert leftovers(tmp_path) == []


def test_permissions_and_links_stay(tmp_path):
    target, link = tmp_path / "m.vtp", tmp_path / "link.vtp"
    write_surface(pv.Sphere(), target)
    umask = os.umask(0)
    os.umask(umask)
    assert target.stat().st_mode & 0o777 == 0o666 & ~umask
    target.chmod(0o640)
    link.symlink_to(target)
    write_surface(pv.Cube(), link)
    assert link.is_symlink()
    assert target.stat().st_mode & 0o777 == 0o640
    assert read_surface(target)[0].n_cells == 6


def test_writing_does_not_change_the_mesh(tmp_path, mixed):
    before = mixed.copy()
    for extension in WRITABLE:
        if extension == ".3mf" and importlib.util.find_spec("trimesh") is None:
            continue
        write_surface(mixed, tmp_path / f"m{extension}")
    assert mixed == before
    assert mixed.array_names == before.array_names


# ------------------------------------------------------------------------------- files of others

DATA = os.environ.get("VTKSMOOTH_DATA")


@pytest.mark.skipif(not DATA, reason="VTKSMOOTH_DATA names no folder of meshes")
@pytest.mark.parametrize(
    ("name", "points", "cells"),
    [
        ("beetle_bad.obj", 1148, 2053),
        ("penguin_control_mesh.obj", 201, 221),
        ("rocker_quads.ply", 13500, 13500),
        ("suzanne.obj", 507, 500),
        ("bunny.off", 3485, 6966),
        ("conrod_bad.stl", 3223, 6442),
        ("multi_collapse.stl", 11, 13),
    ],
)
def test_meshes_of_others(tmp_path, name, points, cells):
    shutil.copy(Path(DATA) / name, tmp_path)
    mesh, _ = read_surface(tmp_path / name)
    assert (mesh.n_points, mesh.n_cells) == (points, cells)


@pytest.mark.parametrize("extension", [".vtp", ".vtu"])
def test_names_of_arrays_that_are_no_xml(tmp_path, extension):
    mesh = pv.Sphere(theta_resolution=4, phi_resolution=4)
    mesh.clear_data()
    names = ["T<300 & p>1", 'in "quotes"', "</DataArray>", "two\nlines", "it's", "plain"]
    for i, name in enumerate(names):
        mesh.point_data[name] = np.full(mesh.n_points, float(i))
        mesh.cell_data[name] = np.full(mesh.n_cells, float(i))
        mesh.field_data[name] = [float(i)]
    mesh.field_data["texts <"] = ["a < b", "c"]
    mesh.set_active_scalars(names[0])
    assert write_surface(mesh, tmp_path / f"a{extension}") == [
        f"a{extension}: VTU holds no polygonal data; the faces were written as an unstructured grid."
    ] * (extension == ".vtu")
    again = pv.read(tmp_path / f"a{extension}")
    for data in (again.point_data, again.cell_data):
        assert sorted(data.keys()) == sorted(names)
        assert all((data[name] == i).all() for i, name in enumerate(names))
    assert sorted(again.field_data.keys()) == sorted([*names, "texts <"])
    assert list(again.field_data["texts <"]) == ["a < b", "c"]
    assert again.active_scalars_name == names[0]
    assert sorted(mesh.point_data.keys()) == sorted(names)


def test_control_characters_in_names_become_question_marks(tmp_path):
    mesh = pv.Sphere(theta_resolution=4, phi_resolution=4)
    mesh.point_data["a\x01b"] = np.arange(float(mesh.n_points))
    notes = write_surface(mesh, tmp_path / "a.vtp")
    assert notes == ["a.vtp: XML keeps no control characters in names; they became ? in a?b."]
    assert "a?b" in pv.read(tmp_path / "a.vtp").point_data


@pytest.mark.parametrize("extension", [".vtp", ".vtu"])
@pytest.mark.parametrize("home", ["point_data", "cell_data", "field_data"])
def test_texts_with_null_characters_are_left_out_of_xml_files(tmp_path, extension, home):
    mesh = pv.Sphere(theta_resolution=7, phi_resolution=6)
    arrays = getattr(mesh, home)
    n = {"point_data": mesh.n_points, "cell_data": mesh.n_cells, "field_data": 3}[home]
    for name, values in (("good", [f"é {i}" for i in range(n)]), ("broken", ["a", *["\0" * 60] * (n - 1)])):
        texts = vtkStringArray()
        texts.SetName(name)
        for value in values:
            texts.InsertNextValue(value)
        arrays.VTKObject.AddArray(texts)
    notes = write_surface(mesh, tmp_path / f"a{extension}")
    assert f"a{extension}: VTK's XML files keep no texts with null characters; left out broken." in notes
    made, _ = read_surface(tmp_path / f"a{extension}")
    kept = getattr(made, home).VTKObject.GetAbstractArray("good")
    assert [kept.GetValue(i) for i in range(n)] == [f"é {i}" for i in range(n)]
    assert "broken" not in getattr(made, home)
    assert "broken" in getattr(mesh, home)


def _faces(*cells):
    mesh = pv.PolyData()
    mesh.points = np.eye(3)
    polys = vtkCellArray()
    for cell in cells:
        polys.InsertNextCell(len(cell), cell)
    mesh.SetPolys(polys)
    return mesh


@pytest.mark.parametrize("extension", WRITABLE)
def test_broken_meshes_are_refused_before_they_are_written(tmp_path, extension):
    short = vtkFloatArray()
    short.SetName("short")
    short.SetNumberOfTuples(2)
    mesh = _faces([0, 1, 2])
    mesh.GetPointData().AddArray(short)
    for broken, what in ((mesh, "short has 2 values for 3"), (_faces([0, 1, 9]), "refers to point 9")):
        with pytest.raises(MeshFileError, match=f"cannot write m{extension}.*{what}.*mend it first"):
            write_surface(broken, tmp_path / f"m{extension}")
    assert [*tmp_path.iterdir()] == []


@pytest.mark.parametrize("extension", writing._WRITE_POLYGONS)
def test_what_no_format_holds_is_left_out_and_said(tmp_path, extension):
    if extension == ".3mf":
        pytest.importorskip("trimesh")
    mesh = _faces([0, 1], [0, 1, 2], [])
    variants = vtkVariantArray()
    variants.SetName("any")
    variants.SetNumberOfValues(3)
    mesh.GetPointData().AddArray(variants)
    notes = " ".join(write_surface(mesh, tmp_path / f"m{extension}"))
    assert "neither numbers nor texts left out: any" in notes
    assert "2 faces with less than three corners were left out" in notes
    if extension in READABLE:
        assert read_surface(tmp_path / f"m{extension}")[0].n_cells == 1


@pytest.mark.parametrize("extension", writing._TRIANGLES_ONLY)
def test_meshes_without_faces_are_refused(tmp_path, extension):
    with pytest.raises(MeshFileError, match=r"the mesh has no faces; use \.vtp"):
        write_surface(pv.PolyData(), tmp_path / f"m{extension}")
