"""Predictions of other systems, read from their files."""
