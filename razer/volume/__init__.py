"""The voxel volume: TSDF, labels and their histograms, and the surface in it."""
