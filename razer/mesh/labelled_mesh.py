"""Labelled mesh: vertices with colours and instances."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from razer.arrays import Float32Array, Int32Array, Uint8Array


@dataclass(frozen=True)
class LabelledMesh:
    """vertices (V, 3) float32 metres, colors (V, 3) uint8, instances (V,) int32 with 0 = nobody,
    triangles (T, 3) int32."""

    vertices: Float32Array
    colors: Uint8Array
    instances: Int32Array
    triangles: Int32Array

    @classmethod
    def empty(cls) -> LabelledMesh:
        """A mesh of nothing."""
        none = np.zeros((0, 3))
        return cls(none.astype(np.float32), none.astype(np.uint8), np.zeros(0, np.int32), none.astype(np.int32))
