"""Surfaces between labels: which label is on either side of each face."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ...errors import InvalidMeshError
from ...jit.compiled import kernel
from . import adjacency
from .lines import edge_kinds
from .mesh import Mesh

Int32 = npt.NDArray[np.int32]


@kernel
def _turn(offsets, labels, connectivity):
    for f in range(offsets.size - 1):
        if labels[f, 0] > labels[f, 1]:
            labels[f, 0], labels[f, 1] = labels[f, 1], labels[f, 0]
            a = offsets[f]
            b = offsets[f + 1] - 1
            while a < b:
                connectivity[a], connectivity[b] = connectivity[b], connectivity[a]
                a += 1
                b -= 1


def labelled(mesh: Mesh, values: npt.NDArray[np.integer]) -> tuple[Mesh, npt.NDArray[np.integer]]:
    """Return `mesh` with the labels of the two sides of each face, and the value of each label.

    Normals run from the first label to the second. Where the second has the lower value, the face is turned
    over and its labels swapped, so that all faces between two labels have the same orientation.

    Parameters
    ----------
    mesh : Mesh
    values : (m, 2) or (m,) int
        Labels on the two sides, any integers. With one for each face the other is 0.

    Raises
    ------
    InvalidMeshError
        There is another number of labels, they are no integers, or a face has the same on both sides.

    Examples
    --------
    >>> wall = Mesh.from_faces([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    >>> mesh, labels = labelled(wall, np.array([[7, -1]]))
    >>> mesh.face_labels.tolist(), labels.tolist(), mesh.connectivity.tolist()
    ([[0, 1]], [-1, 7], [2, 1, 0])
    """
    values = np.asarray(values)
    if values.dtype.kind == "f" and np.isfinite(values).all() and (values == np.round(values)).all():
        values = values.astype(np.int64)
    if values.dtype.kind not in "iub":
        raise InvalidMeshError(f"Labels must be integers, not {values.dtype}; convert the array.")
    if values.ndim == 1:
        values = np.column_stack((values, np.zeros_like(values)))
    if values.shape != (mesh.n_faces, 2):
        raise InvalidMeshError(
            f"Labels must be a pair for each of the {mesh.n_faces} faces, not have the shape {values.shape}."
        )
    same = np.flatnonzero(values[:, 0] == values[:, 1])
    if len(same):
        raise InvalidMeshError(
            f"{len(same)} faces have the same label on both sides, the first is face {same[0]}; remove them: "
            "they bound nothing."
        )
    names, inverse = np.unique(values, return_inverse=True)
    labels = np.ascontiguousarray(inverse.reshape(-1, 2), dtype=np.int32)
    connectivity = mesh.connectivity
    if (labels[:, 0] > labels[:, 1]).any():
        connectivity = connectivity.copy()
        _turn(mesh.offsets, labels, connectivity)
    return Mesh(mesh.points, mesh.offsets, connectivity, labels), names


def check_closed(mesh: Mesh, near: adjacency.Adjacency) -> None:
    """Raise where labels do not close, on a mesh with labels; an edge of one face is a boundary.

    Raises
    ------
    InvalidMeshError
    """
    assert mesh.face_labels is not None
    _, counts = edge_kinds(
        near.offsets, near.connectivity, near.corner_offsets, near.corners, near.corner_face,
        mesh.face_labels, near.ring_offsets, near.ring,
    )  # fmt: skip
    if counts.turned:
        raise InvalidMeshError(
            f"At {counts.turned} edges the orientation of faces disagrees with their labels: normals must "
            "run from the first label to the second; swap the labels of faces that are turned over."
        )
    if counts.unclosed:
        raise InvalidMeshError(
            f"At {counts.unclosed} edges labels do not close: a label changes where no wall begins; add the "
            "missing walls, or correct the labels."
        )


@kernel
def _apart(near, labels, after, before, root, sheet, vertex):
    # Corners at a vertex belong together if a chain of regular edges joins their faces.
    count = 0
    for v in range(near.corner_offsets.size - 1):
        first = near.corner_offsets[v]
        size = near.corner_offsets[v + 1] - first
        for i in range(size):
            c = near.corners[first + i]
            f = near.corner_face[c]
            after[i] = near.connectivity[c + 1 if c + 1 < near.offsets[f + 1] else near.offsets[f]]
            before[i] = near.connectivity[c - 1 if c > near.offsets[f] else near.offsets[f + 1] - 1]
            root[i] = i
        for i in range(size):
            f = near.corner_face[near.corners[first + i]]
            partner = -1
            for k in range(size):
                if before[k] == after[i]:
                    partner = k if partner == -1 else -2
                if k != i and after[k] == after[i]:
                    partner = -2
            if partner < 0:
                continue
            g = near.corner_face[near.corners[first + partner]]
            if labels[f, 0] == labels[g, 0] and labels[f, 1] == labels[g, 1]:
                old = root[partner]
                for k in range(size):
                    if root[k] == old:
                        root[k] = root[i]
        for i in range(size):
            c = near.corners[first + i]
            if root[i] == i:
                sheet[c] = count
                vertex[count] = v
                count += 1
        for i in range(size):
            sheet[near.corners[first + i]] = sheet[near.corners[first + root[i]]]
    return count


def sheets(mesh: Mesh) -> tuple[Mesh, Int32]:
    """Cut a mesh with labels along its lines.

    Returns
    -------
    Mesh
        The same faces, which share points only within a sheet: where an edge of two faces between the same
        two labels joins them.
    vertex : (p,) int32
        For each of its points the point of `mesh`.

    Examples
    --------
    >>> corners = [[0, 0, 0], [0, 0, 1], [1, 0, 0], [0, 1, 0], [-1, -1, 0]]
    >>> three = Mesh.from_faces(corners, [[0, 1, 2], [0, 1, 3], [0, 1, 4]])
    >>> cut, vertex = sheets(labelled(three, np.array([[0, 1], [1, 2], [2, 0]]))[0])
    >>> cut.n_points, sorted(vertex.tolist())
    (9, [0, 0, 0, 1, 1, 1, 2, 3, 4])
    """
    assert mesh.face_labels is not None
    near = adjacency.build(mesh)
    widest = int(np.diff(near.corner_offsets).max())
    sheet, vertex = (np.empty(len(mesh.connectivity), np.int32) for _ in range(2))
    room = np.empty((3, widest), np.int32)
    count = _apart(near, mesh.face_labels, *room, sheet, vertex)
    vertex = vertex[:count].copy()
    return Mesh(mesh.points[vertex], mesh.offsets, sheet, mesh.face_labels), vertex
