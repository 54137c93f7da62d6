"""Rendered images of maps, and meshes for other viewers."""
