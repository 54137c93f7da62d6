"""Evaluation metrics of panoptic 3D maps, in numpy and scipy alone."""
