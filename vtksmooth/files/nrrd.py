"""NRRD images: read here, as VTK's reader takes the first axis of a volume for components.

The format: https://teem.sourceforge.net/nrrd/format.html.
"""

from __future__ import annotations

import gzip
import re
import zlib
from pathlib import Path

import numpy as np
import numpy.typing as npt
from vtkmodules.vtkCommonDataModel import vtkImageData

from ..errors import MeshFileError
from ..filters.arrays import vtk_array

Float64 = npt.NDArray[np.float64]

#: The types of numbers, by their names in the format.
_TYPES = {
    name: dtype
    for dtype, names in {
        "i1": "signed char,int8,int8_t",
        "u1": "uchar,unsigned char,uint8,uint8_t",
        "i2": "short,short int,signed short,signed short int,int16,int16_t",
        "u2": "ushort,unsigned short,unsigned short int,uint16,uint16_t",
        "i4": "int,signed int,int32,int32_t",
        "u4": "uint,unsigned int,uint32,uint32_t",
        "i8": "longlong,long long,long long int,signed long long,int64,int64_t",
        "u8": "ulonglong,unsigned long long,unsigned long long int,uint64,uint64_t",
        "f4": "float",
        "f8": "double",
    }.items()
    for name in names.split(",")
}

#: A header is no longer than this, bytes.
_LONGEST_HEADER = 1 << 20


def read(path: Path) -> vtkImageData:
    """Read a label image.

    Raises
    ------
    MeshFileError
        The file is damaged, or no image of three dimensions and one number for each voxel.
    """
    content = path.read_bytes()
    end = re.search(rb"\r?\n\r?\n", content[:_LONGEST_HEADER])
    detached = path.suffix.lower() == ".nhdr"
    if not content.startswith(b"NRRD") or (end is None and not detached):
        raise MeshFileError(f"{path} is not a NRRD file, as its extension says; check its name.")
    fields = _fields(content[: end.start() if end else _LONGEST_HEADER].decode("latin-1"))
    try:
        sizes = [int(size) for size in fields["sizes"].split()]
        dtype = np.dtype(_TYPES[fields["type"].lower()])
        encoding = fields["encoding"].lower()
    except (KeyError, ValueError) as error:
        raise MeshFileError(f"{path} has an incomplete header ({error}); export it again.") from error
    if len(sizes) != 3 or min(sizes) < 1:
        raise MeshFileError(
            f"{path} has {len(sizes)} dimensions; export the labels as one image of three dimensions."
        )
    if "data file" in fields or "datafile" in fields:
        data = (path.parent / fields.get("data file", fields.get("datafile", ""))).read_bytes()
    else:
        data = content[end.end() if end else len(content) :]
    if encoding in ("gzip", "gz"):
        try:
            data = gzip.decompress(data)
        except (OSError, EOFError, zlib.error) as error:
            raise MeshFileError(f"{path} is damaged or truncated ({error}); export it again.") from error
    elif encoding != "raw":
        raise MeshFileError(f"{path} has the encoding {encoding}; export it as raw or gzip.")
    if fields.get("endian", "little").lower() == "big":
        dtype = dtype.newbyteorder(">")
    count = int(np.prod(sizes, dtype=np.int64))
    if len(data) < count * dtype.itemsize:
        raise MeshFileError(f"{path} is truncated: it holds {len(data)} bytes of data; export it again.")
    values = np.frombuffer(data, dtype, count).astype(dtype.newbyteorder("="))
    image = vtkImageData(dimensions=sizes)
    _place(path, image, fields)
    image.GetPointData().SetScalars(vtk_array(values, "Labels"))
    return image


def _fields(header: str) -> dict[str, str]:
    lines = (line for line in header.splitlines()[1:] if ":" in line and not line.startswith("#"))
    return {
        key.strip().lower(): value.strip().lstrip("=").strip()
        for key, _, value in (line.partition(":") for line in lines)
    }


def _vectors(text: str) -> Float64:
    rows = re.findall(r"\(([^)]*)\)", text)
    return np.array([[float(value) for value in row.split(",")] for row in rows])


def _place(path: Path, image: vtkImageData, fields: dict[str, str]) -> None:
    """Put the image where the header says that it is."""
    try:
        if "space directions" in fields:
            axes = _vectors(fields["space directions"]).T
            spacing = np.linalg.norm(axes, axis=0)
            image.SetDirectionMatrix((axes / spacing).ravel().tolist())
            image.SetSpacing(spacing.tolist())
        elif "spacings" in fields:
            image.SetSpacing([float(value) for value in fields["spacings"].split()])
        if "space origin" in fields:
            image.SetOrigin(_vectors(fields["space origin"])[0].tolist())
    except (ValueError, IndexError, TypeError) as error:
        raise MeshFileError(
            f"{path} does not say where its voxels are ({error}); export it again."
        ) from error
