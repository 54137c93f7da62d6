"""Labelled mesh: vertices with colours and instances."""

from __future__ import annotations

from dataclasses import dataclass

from razer.arrays import Float32Array, Int32Array, Uint8Array


@dataclass(frozen=True)
class LabelledMesh:
    """vertices (V, 3) float32 metres, colors (V, 3) uint8, instances (V,) int32 with 0 = nobody,
    triangles (T, 3) int32."""

    vertices: Float32Array
    colors: Uint8Array
    instances: Int32Array
    triangles: Int32Array
