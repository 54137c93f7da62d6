"""Colours of a surface on which instances can be told apart and which still looks like what was recorded."""

from __future__ import annotations

import numpy as np

from app.render.palette import instance_colors
from razer.arrays import Uint8Array
from razer.mesh.labelled_mesh import LabelledMesh

TINT = 0.3  # of an instance's colour; more hides what things look like


def lightly_tinted(mesh: LabelledMesh, untinted: frozenset[int] = frozenset()) -> Uint8Array:
    """The colours (V, 3) of a mesh with a little of those of its instances, but for the `untinted` ones."""
    mixed = (1 - TINT) * mesh.colors + TINT * instance_colors(mesh.instances)
    plain = np.isin(mesh.instances, [0, *untinted])
    return np.where(plain[:, None], mesh.colors, mixed).astype(np.uint8)
