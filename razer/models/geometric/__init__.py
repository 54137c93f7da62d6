"""Geometric segmentation of RGB-D frames, without weights."""
