"""Storage of voxels: blocks in pages, found by their keys."""
