"""Masks of what words name."""
