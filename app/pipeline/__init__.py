"""The mapping pipeline: main loop, a run from its first frame to its folder, camera tracking alone."""
