"""Comparison of two runs over one recording, with each other and with the ground truth."""
