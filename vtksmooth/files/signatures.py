"""How the files of each format begin: what is no such file is refused before VTK sees it."""

from __future__ import annotations

import re

#: The XML formats of VTK, by extension.
XML = (".vtp", ".vtu", ".vts", ".vtr", ".vti", ".vtm", ".vtmb", ".pvtu")

#: The formats that readers of VTK read, by extension.
OF_VTK = (".vtk", ".vtkhdf", *XML, ".glb", ".gltf", ".obj", ".stl")

#: Keywords that lines of an OBJ file may begin with.
_OBJ_KEYWORDS = re.compile(
    rb"(v|vt|vn|vp|f|fo|l|p|g|s|o|mg|usemtl|usemap|mtllib|maplib|cstype|deg|curv|curv2|surf|bevel|c_interp"
    rb"|d_interp|lod|shadow_obj|trace_obj)(\s|$)"
)


def wrong_signature(extension: str, head: bytes, size: int) -> str | None:
    """Return what shows that a file is not what its extension says, or None.

    Readers of VTK search garbage for a mesh at length, or end the process when a count is absurd.
    """
    start = head.lstrip(b"\xef\xbb\xbf \t\r\n")
    if extension in XML:
        if not start.startswith(b"<") or b"<VTKFile" not in head:
            return "is not an XML file of VTK, as its extension says; check its name"
        # Compression makes no more than some 1000 out of one.
        counts = [int(count) for count in re.findall(rb"NumberOf\w+=\"(\d{1,30})\"", head)]
        if max(counts, default=0) > 1100 * size:
            return f"announces {max(counts)} elements in {size} bytes; it is damaged, export it again"
    elif extension == ".vtk":
        # The version decides how the rest is read; an unknown one has ended the process.
        if not re.match(rb"# vtk DataFile Version [1-5]\.\d+\s", head):
            return "is not a legacy file of VTK, as its extension says; check its name"
    elif extension == ".vtkhdf":
        if not head.startswith(b"\x89HDF\r\n\x1a\n"):
            return "is not an HDF file, as its extension says; check its name"
    elif extension == ".glb":
        if not head.startswith(b"glTF"):
            return "is not a binary glTF file, as its extension says; check its name"
    elif extension == ".gltf":
        if not start.startswith(b"{"):
            return "is not a glTF file, as its extension says; check its name"
    elif extension == ".obj":
        lines = (line.strip() for line in head.split(b"\n"))
        first = next((line for line in lines if line and not line.startswith(b"#")), b"v")
        if b"\0" in head or not _OBJ_KEYWORDS.match(first):
            return "is not an OBJ file, as its extension says; check its name"
    elif extension == ".stl":
        return _wrong_stl(head, size)
    return None


def stl_triangles(head: bytes, size: int) -> int | None:
    """Return the number of triangles of a binary STL file, None of a text file.

    Some binary files begin with "solid", too; their size gives them away.
    """
    count = int.from_bytes(head[80:84], "little")
    if head.lstrip()[:5].lower() == b"solid" and size != 84 + 50 * count:
        return None
    return count


def _wrong_stl(head: bytes, size: int) -> str | None:
    count = stl_triangles(head, size)
    if count is None:
        if b"\0" in head or not re.search(rb"(?i)\bfacet\b|\bendsolid\b", head):
            return "is not an STL file, as its extension says; check its name"
    elif size < 84 + 50 * count or len(head) < 84:
        return (
            f"is not an STL file, or truncated (it announces {count} triangles in {size} bytes); "
            "check its name, or export it again"
        )
    elif size != 84 + 50 * count:
        return (
            f"is not an STL file (it announces {count} triangles and goes on for "
            f"{size - 84 - 50 * count} bytes after them); check its name, or export it again"
        )
    return None
