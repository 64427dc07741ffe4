"""The volume of every label of a surface between labels."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ..mesh.mesh import Mesh
from .comparison import face_volumes


def label_volumes(mesh: Mesh) -> npt.NDArray[np.float64]:
    """Return the volume that the faces of each label enclose, (labels,), model units cubed.

    ``V_l = sum_f s(f, l) det(f) / 6``, s = +1 where l is the first label of f and -1 where it is the second.
    Of what lies outside of everything it is the volume of all else, negative; all of them sum to 0. Where
    the surface is open the figure depends on the origin: use differences.
    """
    assert mesh.face_labels is not None
    count = int(mesh.face_labels.max()) + 1
    volumes = face_volumes(mesh)
    first, second = (np.bincount(mesh.face_labels[:, side], volumes, count) for side in range(2))
    return np.asarray(first - second)
