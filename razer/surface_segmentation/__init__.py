"""Segmentation of the fused surface: things and planes of structure on the mesh of a map, without weights."""
