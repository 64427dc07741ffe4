"""How the files of each format begin: what is no such file is refused before VTK sees it."""

from __future__ import annotations

import re

#: The XML formats of VTK, by extension.
XML = (".vtp", ".vtu", ".vts", ".vtr", ".vti", ".vtm", ".vtmb", ".pvtu")

#: The formats that readers of VTK read, by extension.
OF_VTK = (".vtk", ".vtkhdf", *XML, ".glb", ".gltf")


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
    elif extension == ".gltf" and not start.startswith(b"{"):
        return "is not a glTF file, as its extension says; check its name"
    return None
