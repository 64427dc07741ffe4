"""Files that end VTK's readers, and the process in which they are read."""

import os
import subprocess
import sys
import threading

import numpy as np
import pytest
import pyvista as pv
from vtkmodules.vtkCommonCore import vtkBitArray, vtkDataArray, vtkStringArray
from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter

from vtksmooth.errors import Cancelled, MeshFileError
from vtksmooth.files import READABLE, WRITABLE, read_surface, vtk_process, vtk_transfer, write_surface
from vtksmooth.files.signatures import OF_VTK
from vtksmooth.files.vtk_readers import READERS


def ball():
    return pv.Sphere(theta_resolution=6, phi_resolution=6)


@pytest.fixture
def path(tmp_path):
    ball().save(tmp_path / "ball.vtp")
    return tmp_path / "ball.vtp"


@pytest.fixture
def deadly(tmp_path):
    """Write files that end VTK's readers by a signal."""
    names = ball()
    names["label"] = [f"point {i}" for i in range(names.n_points)]
    writer = vtkXMLPolyDataWriter()
    writer.SetInputData(names)
    writer.SetFileName(str(tmp_path / "names.vtp"))
    writer.Write()
    data = (tmp_path / "names.vtp").read_bytes()
    start = data.find(b"<AppendedData") + 40
    names.save(tmp_path / "text.vtk", binary=False)
    text = (tmp_path / "text.vtk").read_text()
    late = '<Piece NumberOfPoints="99999999999" NumberOfPolys="1"><Points><DataArray type="Float32" '
    late += 'NumberOfComponents="3" format="ascii">0 0 0</DataArray></Points></Piece></PolyData></VTKFile>'
    contents = {
        "cut.vtp": data[: start + (len(data) - start) // 4],
        "count.vtk": text.replace("POINTS", "FIELD FieldData 1\nff 1 1e308 double\n1 2\nPOINTS", 1).encode(),
        "deep.vtp": b"<VTKFile type='PolyData'>" + b"<a>" * 200000 + b"</a>" * 200000 + b"</VTKFile>",
        "late.vtp": b'<?xml version="1.0"?><VTKFile type="PolyData" version="1.0"><PolyData>'
        + b" " * 70000
        + late.encode(),
    }
    for name, content in contents.items():
        (tmp_path / name).write_bytes(content)
    return [tmp_path / name for name in contents]


def test_files_that_end_the_reader_are_refused_in_a_sentence(path, deadly, capfd):
    for file in deadly:
        with pytest.raises(MeshFileError, match="is damaged") as error:
            read_surface(file)
        assert "\n" not in str(error.value)
        assert read_surface(path)[0].n_points == 26
    assert capfd.readouterr() == ("", "")


def test_a_death_that_an_earlier_file_has_caused_is_not_blamed_on_the_next(path):
    read_surface(path)
    vtk_process._children._idle.kill()
    assert read_surface(path)[0].n_points == 26


def test_reading_ends_in_time(path, monkeypatch):
    vtk_process._children.end()
    monkeypatch.setattr(vtk_process, "_SECONDS", 0.0)
    monkeypatch.setattr(vtk_process, "_SECONDS_PER_BYTE", 0.0)
    monkeypatch.setattr(vtk_process, "_SECONDS_TO_START", 0.0)
    with pytest.raises(MeshFileError, match="had not ended after 0 s"):
        read_surface(path)
    monkeypatch.undo()
    assert read_surface(path)[0].n_points == 26


def test_reading_can_be_cancelled(path):
    vtk_process._children.end()
    with pytest.raises(Cancelled):
        read_surface(path, lambda: True)
    assert read_surface(path)[0].n_points == 26


def test_threads_read_at_once(path):
    found = []
    threads = [
        threading.Thread(target=lambda: found.append(read_surface(path)[0].n_points)) for _ in range(3)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == [26, 26, 26]


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_a_forked_process_reads_with_a_process_of_its_own(path):
    read_surface(path)
    script = (
        "import os, sys\n"
        "from vtksmooth.files import read_surface\n"
        "read_surface(sys.argv[1])\n"
        "child = os.fork()\n"
        "points = [read_surface(sys.argv[1])[0].n_points for _ in range(5)]\n"
        "if child:\n"
        "    assert os.waitpid(child, 0)[1] == 0\n"
        "assert points == [26] * 5\n"
    )
    done = subprocess.run([sys.executable, "-c", script, str(path)], check=False, timeout=60)
    assert done.returncode == 0


@pytest.mark.parametrize("program", ["", "/usr/bin/paraview", "/nowhere/python3"])
def test_without_a_python_to_start_files_are_read_in_the_same_process(path, monkeypatch, program):
    vtk_process._children.end()
    monkeypatch.setattr(sys, "executable", program)
    vtk_process.prepare()
    mesh, notes = read_surface(path)
    assert mesh == ball()
    assert notes == []


def test_the_process_imports_little():
    script = (
        "import sys, vtksmooth.files.vtk_child\n"
        "assert not {'pyvista', 'numba', 'vtksmooth.filters', 'vtksmooth.kernels'} & {*sys.modules}\n"
    )
    subprocess.run([sys.executable, "-c", script], check=True)
    script = "import sys, vtksmooth.files.vtk_process\nassert not {'vtkmodules', 'numpy'} & {*sys.modules}\n"
    subprocess.run([sys.executable, "-c", script], check=True)


def test_every_format_of_vtk_has_a_reader():
    assert {*OF_VTK} == {*READERS}


def test_all_of_a_mesh_comes_over(tmp_path):
    mesh = pv.PolyData(np.random.default_rng(1).random((9, 3)))
    mesh.verts, mesh.lines, mesh.strips = [1, 0, 2, 1, 2], [3, 2, 3, 4], [4, 5, 6, 7, 8]
    mesh.faces = [3, 0, 1, 2, 4, 2, 3, 4, 5]
    for kind in ("i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8", "f4", "f8"):
        mesh[f"x{kind}"] = np.arange(9).astype(kind)
    mesh.GetPointData().GetArray("xf4").GetInformation().Set(vtkDataArray.UNITS_LABEL(), "mm")
    mesh["vector"] = np.arange(27.0).reshape(9, 3)
    mesh.GetPointData().GetArray("vector").SetComponentName(1, "width")
    mesh.set_active_scalars("xu2")
    mesh.set_active_vectors("vector")
    bits, words = vtkBitArray(), vtkStringArray()
    for i in range(mesh.n_cells):
        bits.InsertNextValue(i % 2)
        words.InsertNextValue(f"größe {i}")
    for array, name in ((bits, "bits"), (words, "words")):
        array.SetName(name)
        mesh.GetCellData().AddArray(array)
    mesh.add_field_data(np.arange(3), "field")
    mesh.add_field_data(["a", "b"], "texts")
    before = mesh.copy()
    description, arrays = vtk_transfer.pack(mesh)
    waiting = iter(arrays)
    after = pv.PolyData(vtk_transfer.unpack(description, lambda values: np.copyto(values, next(waiting))))
    assert after == before
    assert after.point_data.active_scalars_name == "xu2"
    assert after.point_data.active_vectors_name == "vector"
    vector = after.GetPointData().GetArray("vector")
    assert vector.GetComponentName(1) == "width"
    assert after.GetPointData().GetArray("xf4").GetInformation().Get(vtkDataArray.UNITS_LABEL()) == "mm"
    for i in range(mesh.GetPointData().GetNumberOfArrays()):
        kinds = [data.GetPointData().GetArray(i).GetDataType() for data in (mesh, after)]
        assert kinds[0] == kinds[1]
    assert after.GetCellData().GetArray("bits").GetDataTypeAsString() == "bit"


def test_names_that_are_not_utf_8_are_taken_as_latin_1(tmp_path):
    lines = "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOINTS 3 float\n0 0 0 1 0 0 0 1 0\n"
    lines += "POLYGONS 1 4\n3 0 1 2\nPOINT_DATA 3\nSCALARS Länge float 1\nLOOKUP_TABLE default\n1 2 3\n"
    (tmp_path / "old.vtk").write_bytes(lines.encode("latin-1"))
    assert read_surface(tmp_path / "old.vtk")[0].point_data.keys() == ["Länge"]


@pytest.mark.skipif(sys.platform != "linux", reason="needs names of files that are no text")
def test_files_whose_names_are_not_utf_8_are_read_and_written(path):
    for extension in set(READABLE) & set(WRITABLE):
        name = path.parent / os.fsdecode(b"L\xe4nge" + extension.encode())
        write_surface(ball(), name)
        assert read_surface(name)[0].n_cells == 48


def test_hdf_files_hold_all_but_texts_and_that_is_said(tmp_path):
    mesh = ball()
    bits = vtkBitArray()
    bits.SetName("bits")
    for i in range(mesh.n_points):
        bits.InsertNextValue(i % 3 == 0)
    mesh.GetPointData().AddArray(bits)
    mesh["a.b"] = np.arange(mesh.n_points)
    mesh["a_b"] = -np.arange(mesh.n_points)
    mesh["label"] = [f"point {i}" for i in range(mesh.n_points)]
    mesh.add_field_data(["in", "mm"], "texts/1")
    names = mesh.array_names
    notes = write_surface(mesh, tmp_path / "a.vtkhdf")
    assert len(notes) == 2
    assert notes[0] == "a.vtkhdf: VTKHDF does not keep the arrays label."
    assert "a.b to a_b_2, texts/1 to texts_1" in notes[1]
    assert mesh.array_names == names
    back = read_surface(tmp_path / "a.vtkhdf")[0]
    assert np.array_equal(back["a_b_2"], mesh["a.b"])
    assert np.array_equal(back["a_b"], mesh["a_b"])
    assert np.array_equal(back["bits"], np.arange(mesh.n_points) % 3 == 0)
    assert [*back.field_data["texts_1"]] == ["in", "mm"]
