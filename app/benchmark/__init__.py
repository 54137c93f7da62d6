"""Benchmarks of the mapping pipeline and of what is done beside 2D models: the figures of `razer bench`."""
