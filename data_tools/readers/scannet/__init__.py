"""Readers of ScanNet: extracted scenes and .sens files."""
