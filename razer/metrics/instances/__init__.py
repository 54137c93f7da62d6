"""Instances against true ones: matching, AP, panoptic quality, retrieval."""
