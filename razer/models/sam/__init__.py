"""Promptable segmentation: SAM, SAM 2 and their kin."""
