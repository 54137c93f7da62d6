"""Benchmark of pose estimation in a hard world: the figures of `razer bench poses`."""
