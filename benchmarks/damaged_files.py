"""Damaged files of every format that is read, sessions and recipes among them. Seeded."""

from __future__ import annotations

import base64
import io
import json
import re
import struct
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyvista as pv
from vtkmodules.vtkIOLegacy import vtkDataSetWriter, vtkPolyDataWriter
from vtkmodules.vtkIOXML import (
    vtkXMLImageDataWriter,
    vtkXMLMultiBlockDataWriter,
    vtkXMLPolyDataWriter,
    vtkXMLRectilinearGridWriter,
    vtkXMLStructuredGridWriter,
    vtkXMLUnstructuredGridWriter,
)

from vtksmooth import Recipe, Step
from vtksmooth.files import read_surface, write_surface
from vtksmooth.recipe import COMMANDS
from vtksmooth_gui.model import session
from vtksmooth_gui.model.document import Document
from vtksmooth_gui.model.measure import Kind, Measurement
from vtksmooth_gui.model.section import Plane

Random = np.random.Generator


@dataclass(frozen=True)
class Sample:
    """A good file, with those that it refers to.

    Attributes
    ----------
    name : str
        Its name; the extension is the format.
    files : dict of str to bytes
        All files, by their paths.
    """

    name: str
    files: dict[str, bytes]


# ------------------------------------------------------------------------------------- good files


def _mesh() -> pv.PolyData:
    mesh = pv.Sphere(theta_resolution=7, phi_resolution=6)
    mesh["weight"] = np.linspace(0, 1, mesh.n_points)
    mesh.cell_data["part"] = np.arange(mesh.n_cells) % 3
    mesh["label"] = np.array([f"p{i}" for i in range(mesh.n_points)])
    mesh.field_data["note"] = ["one", "two"]
    return mesh


def _obj() -> bytes:
    mesh = pv.Sphere(theta_resolution=7, phi_resolution=6)
    lines = ["# a comment", "mtllib some.mtl", "o part"]
    lines += [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in mesh.points]
    lines += [f"vt {x:.4f} {y:.4f}" for x, y, _ in mesh.points]
    lines += [f"vn {x:.4f} {y:.4f} {z:.4f}" for x, y, z in mesh.points]
    lines += ["g side", "usemtl steel", "s 1"]
    forms = ["{0}/{0}/{0}", "{0}//{0}", "{0}", "{0}/{0}"]
    for i, face in enumerate(mesh.regular_faces.tolist()):
        lines.append("f " + " ".join(forms[i % 4].format(p + 1) for p in face))
    n = mesh.n_points
    return "\n".join([*lines, f"f -1 -2 -{n}", "l 1 2 3", "p 1", ""]).encode()


def _off(kind: str) -> bytes:
    mesh = pv.Cube().clean()
    lines = [kind, f"{mesh.n_points} {mesh.n_cells} 0"]
    colour = " 255 0 0 255" if kind == "COFF" else ""
    lines += [f"{x} {y} {z}{colour}" for x, y, z in mesh.points]
    lines += ["4 " + " ".join(map(str, face)) + " 0 128 0" for face in mesh.regular_faces.tolist()]
    return "\n".join([*lines, ""]).encode()


def _gltf() -> tuple[bytes, bytes]:
    mesh = pv.Cube().triangulate().clean()
    points, corners = mesh.points.astype("<f4"), mesh.regular_faces.astype("<u2").ravel()
    data = points.tobytes() + corners.tobytes()
    document: dict[str, Any] = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "buffers": [{"byteLength": len(data)}],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": points.nbytes, "target": 34962},
            {"buffer": 0, "byteOffset": points.nbytes, "byteLength": corners.nbytes, "target": 34963},
        ],
        "accessors": [
            {
                "bufferView": 0, "componentType": 5126, "count": len(points), "type": "VEC3",
                "min": points.min(axis=0).tolist(), "max": points.max(axis=0).tolist(),
            },
            {"bufferView": 1, "componentType": 5123, "count": len(corners), "type": "SCALAR"},
        ],
    }  # fmt: skip
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    data += b"\0" * (-len(data) % 4)
    parts = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data
    binary = struct.pack("<4sII", b"glTF", 2, 12 + len(parts)) + parts
    document["buffers"][0]["uri"] = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    return json.dumps(document, indent=1).encode(), binary


_PIECES = b"""<?xml version="1.0"?>
<VTKFile type="PUnstructuredGrid" version="0.1" byte_order="LittleEndian">
  <PUnstructuredGrid GhostLevel="0">
    <PPoints><PDataArray type="Float32" Name="Points" NumberOfComponents="3"/></PPoints>
    <Piece Source="g.vtu"/>
    <Piece Source="g.vtu"/>
  </PUnstructuredGrid>
</VTKFile>
"""


def _written(writer: Any, data: Any, folder: Path, name: str) -> Sample:
    place = folder / name.replace(".", "_")
    place.mkdir()
    writer.SetFileName(str(place / name))
    writer.SetInputDataObject(data)
    writer.Write()
    paths = sorted(path for path in place.rglob("*") if path.is_file())
    return Sample(name, {str(path.relative_to(place)): path.read_bytes() for path in paths})


def samples(folder: Path) -> list[Sample]:
    """Return good files of every format; `folder` is for scratch."""
    made = [Sample("hand.obj", {"hand.obj": _obj()})]
    made += [Sample(f"{kind}.off", {f"{kind}.off": _off(kind)}) for kind in ("OFF", "COFF")]
    text, binary = _gltf()
    made += [Sample("a.gltf", {"a.gltf": text}), Sample("a.glb", {"a.glb": binary})]
    mesh, polygons = _mesh(), pv.Cube().clean()
    for name in ("own.obj", "own.off", "own.ply", "own.stl", "own.vtk", "own.vtp", "own.vtu", "own.vtkhdf"):
        path = folder / name
        write_surface(polygons if name in ("own.obj", "own.vtkhdf") else mesh, path)
        made.append(Sample(name, {name: path.read_bytes()}))
    for name, binary_ in (("text.ply", False), ("text.stl", False)):
        mesh.save(folder / name, binary=binary_)
        made.append(Sample(name, {name: (folder / name).read_bytes()}))
    for i, mode in enumerate(("Ascii", "Binary", "Appended")):
        for compressed in (False, True):
            writer = vtkXMLPolyDataWriter()
            getattr(writer, f"SetDataModeTo{mode}")()
            writer.SetEncodeAppendedData(int(compressed))
            if not compressed:
                writer.SetCompressorTypeToNone()
            made.append(_written(writer, mesh, folder, f"x{i}{int(compressed)}.vtp"))
    solid = pv.ImageData(dimensions=(3, 3, 3))
    kinds = [
        (vtkXMLUnstructuredGridWriter(), solid.cast_to_unstructured_grid(), "g.vtu"),
        (vtkXMLStructuredGridWriter(), solid.cast_to_structured_grid(), "g.vts"),
        (vtkXMLRectilinearGridWriter(), solid.cast_to_rectilinear_grid(), "g.vtr"),
        (vtkXMLImageDataWriter(), solid, "g.vti"),
        (vtkXMLMultiBlockDataWriter(), pv.MultiBlock([mesh, polygons, None]), "b.vtm"),
        (vtkXMLMultiBlockDataWriter(), pv.MultiBlock([polygons]), "b.vtmb"),
    ]
    made += [_written(writer, data, folder, name) for writer, data, name in kinds]
    piece = next(one for one in made if one.name == "g.vtu").files["g.vtu"]
    made.append(Sample("p.pvtu", {"p.pvtu": _PIECES, "g.vtu": piece}))
    for i, (data, writer) in enumerate(
        [
            (mesh, vtkPolyDataWriter()),
            (polygons.strip(), vtkPolyDataWriter()),
            (solid.cast_to_unstructured_grid(), vtkDataSetWriter()),
            (solid.cast_to_structured_grid(), vtkDataSetWriter()),
            (solid, vtkDataSetWriter()),
        ]
    ):
        for version in (42, 51):
            writer.SetFileVersion(version)
            for binary_ in (False, True):
                writer.SetFileTypeToBinary() if binary_ else writer.SetFileTypeToASCII()
                made.append(_written(writer, data, folder, f"l{i}{version}{int(binary_)}.vtk"))
    return [sample for sample in made if sample.name in sample.files]


def sample_session(folder: Path) -> bytes:
    """Return a good session: a layer from a file, one of another mesh, steps and a selection."""
    document = Document()
    path = folder / "layer.vtp"
    write_surface(_mesh(), path)
    layer = document.open(read_surface(path)[0], path)
    cls = COMMANDS["laplacian"]
    step, sources = document.step(layer, cls, {"iterations": 2}, [])
    document.apply(
        layer, [step.make()(layer.state.input())], step, sources, "Smooth", "smoothed", "2 iterations"
    )
    document.open(_mesh(), folder / "other.stl")
    document.measure(Measurement(Kind.DISTANCE, layer, np.array([0, 5]), layer.state.n_points))
    document.plane = Plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    saved = folder / "good.session"
    session.save(session.capture(document, {"view": {"camera": [1.0, 2.0, 3.0]}}), saved)
    return saved.read_bytes()


def sample_recipe() -> str:
    """Return a good recipe."""
    steps = (
        Step("mark", {"fix": "0-4,7", "grow": 1}),
        # It converges, whatever number of iterations a damaged recipe asks for.
        Step("trapezium-drawing", {"iterations": 2, "crease_angle": 60.0}),
        Step("compare", {}, {"original": "original"}),
    )
    return Recipe(steps).to_json()


# ----------------------------------------------------------------------------------------- damage


_COUNTS = [
    b"0", b"-1", b"1", b"2", b"255", b"65536", b"99999999", b"2147483647", b"2147483648", b"4294967295",
    b"9223372036854775807", b"9223372036854775808", b"1e308", b"1e-320", b"nan", b"inf", b"-inf", b"1,5",
    b"+3", b"0x10", b"007", b"1_000", b"", b"1.5", b"99999999999999999999999999",
]  # fmt: skip
_WORDS = [
    b"nan", b"<a>", b"</DataArray>", b"end_header", b"CELLS 5 20", b"POINTS 10 double", b"METADATA", b"#",
    b"\xe9\xff", b"\xc3\xa9", b"\0", b"\x1a", b"//", b"\\", b"{}", b"[", b"null", b"-", b"f 1 2 3", b"v",
    b"%s%n",
]  # fmt: skip


def _truncate(random: Random, data: bytes) -> bytes:
    return data[: int(len(data) * random.random() ** random.choice([0.2, 1.0]))]


def _flip(random: Random, data: bytes) -> bytes:
    made = bytearray(data)
    for _ in range(int(random.choice([1, 1, 3, 20]))):
        if made:
            made[random.integers(len(made))] = random.integers(256)
    return bytes(made)


def _numbers(data: bytes) -> list[re.Match[bytes]]:
    return list(re.finditer(rb"-?\d+(\.\d+)?(e[-+]?\d+)?", data[:200_000]))


def _count(random: Random, data: bytes) -> bytes:
    found = _numbers(data)
    if not found:
        return data
    # Those that announce what follows stand at the beginning.
    match = found[int(len(found) * random.random() ** random.choice([1, 4]))]
    return data[: match.start()] + _COUNTS[random.integers(len(_COUNTS))] + data[match.end() :]


def _digit(random: Random, data: bytes) -> bytes:
    places = [match.start() for match in re.finditer(rb"\d", data[:200_000])]
    if not places:
        return data
    place = places[random.integers(len(places))]
    return data[:place] + str(random.integers(10)).encode() + data[place + 1 :]


def _lines(random: Random, data: bytes) -> bytes:
    lines = data.split(b"\n")
    i, j = random.integers(0, len(lines), 2)
    kind = random.integers(5)
    if kind == 0:
        del lines[i]
    elif kind == 1:
        lines.insert(i, lines[j])
    elif kind == 2:
        lines[i], lines[j] = lines[j], lines[i]
    elif kind == 3:
        lines.insert(i, _WORDS[random.integers(len(_WORDS))])
    else:
        lines[i] = b""
    return b"\n".join(lines)


def _words(random: Random, data: bytes) -> bytes:
    words = list(re.finditer(rb"[A-Za-z]{2,}", data[:200_000]))
    if not words:
        return data
    match = words[int(len(words) * random.random() ** random.choice([1, 3]))]
    other = words[random.integers(len(words))].group()
    new = [other, match.group().swapcase(), b"", _WORDS[random.integers(len(_WORDS))]][random.integers(4)]
    return data[: match.start()] + new + data[match.end() :]


def _insert(random: Random, data: bytes) -> bytes:
    place = int(random.integers(len(data) + 1))
    more = random.choice([1, 7, 500])
    filling = [bytes(random.integers(0, 256, more).astype(np.uint8)), b"\0" * more, b" " * more, b"\n" * more]
    return data[:place] + filling[random.integers(4)] + data[place:]


def _cut_out(random: Random, data: bytes) -> bytes:
    a, b = sorted(random.integers(0, len(data) + 1, 2).tolist())
    return data[:a] + data[min(b, a + int(random.choice([1, 4, 50, 10**6]))) :]


def _ends(random: Random, data: bytes) -> bytes:
    kind = random.integers(7)
    if kind == 0:
        return data.replace(b"\n", b"\r\n")
    if kind == 1:
        return data.replace(b"\n", b"\r")
    if kind == 2:
        return b"\xef\xbb\xbf" + data
    if kind == 3:
        return data.decode("latin-1").encode("utf-16")
    if kind == 4:
        return data.rstrip()
    if kind == 5:
        return data + data
    return data.replace(b".", b",")


def _few(random: Random, data: bytes) -> bytes:
    return [b"", b"\n", b"\0" * 100, data[:20], b"<VTKFile type='PolyData'>" + b"<a>" * 3000][
        random.integers(5)
    ]


_DAMAGES: list[tuple[Callable[[Random, bytes], bytes], int]] = [
    (_truncate, 4), (_flip, 4), (_count, 5), (_digit, 3), (_lines, 3), (_words, 3), (_insert, 2),
    (_cut_out, 2), (_ends, 2), (_few, 1),
]  # fmt: skip


def damaged(random: Random, data: bytes) -> bytes:
    """Return data with one damage or a few."""
    weights = np.array([weight for _, weight in _DAMAGES], float)
    for _ in range(int(random.choice([1, 1, 1, 2, 4]))):
        damage = _DAMAGES[random.choice(len(_DAMAGES), p=weights / weights.sum())][0]
        data = damage(random, data)
    return data


def damaged_sample(random: Random, sample: Sample) -> dict[str, bytes]:
    """Return the files of a sample, one of them damaged."""
    name = sample.name if random.random() < 0.6 else str(random.choice(list(sample.files)))
    return {**sample.files, name: damaged(random, sample.files[name])}


#: What stands in the place of a value.
_VALUES = [
    None, True, -1, 0, 1, 2**31, 2**63, 10**400, 1.5, 1e308, float("nan"), float("inf"), "", "x",
    "é\ud800", "a" * 10**5, [], [[]], {}, {"a": 1}, [1, 2, 3], "0-99999999999", "../../etc/passwd", "\0",
]  # fmt: skip


def damaged_json(random: Random, text: str) -> str:
    """Return JSON in which some values are others, missing, or under another name."""
    tree = json.loads(text)
    for _ in range(int(random.choice([1, 1, 2, 5]))):
        places: list[tuple[Any, Any]] = []
        stack = [tree]
        while stack:
            node = stack.pop()
            keys = (
                list(node) if isinstance(node, dict) else range(len(node)) if isinstance(node, list) else []
            )
            for key in keys:
                places.append((node, key))
                stack.append(node[key])
        if not places:
            break
        node, key = places[random.integers(len(places))]
        kind = random.integers(4)
        if kind == 0:
            del node[key]
        elif kind == 1 and isinstance(node, dict):
            node[str(random.choice(["x", "é", "", "version"]))] = node.pop(key)
        elif kind == 2 and isinstance(node, list):
            node.append(node[key])
        else:
            node[key] = _VALUES[random.integers(len(_VALUES))]
    return json.dumps(tree)


def damaged_session(random: Random, data: bytes) -> bytes:
    """Return a session whose file, JSON or arrays are damaged."""
    if random.random() < 0.25:
        return damaged(random, data)
    made = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(data)) as old, zipfile.ZipFile(made, "w") as new:
        names = old.namelist()
        hit = names[random.integers(len(names))] if random.random() < 0.5 else session.JSON
        for name in names:
            content = old.read(name)
            if name == hit and name == session.JSON and random.random() < 0.8:
                content = damaged_json(random, content.decode()).encode()
            elif name == hit:
                if random.random() < 0.1:
                    continue
                content = damaged(random, content)
            new.writestr(name, content)
    return made.getvalue()
