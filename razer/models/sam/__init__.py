"""Promptable segmentation: SAM, SAM 2 and similar models."""
