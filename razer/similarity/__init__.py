"""Similarity calibration: what the cosines of an embedder are worth."""
