"""Panoptic TSDF volume: distances, label histograms, and the surface extracted from them."""
