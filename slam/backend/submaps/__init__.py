"""Submaps: where an unanchored one lies, when that is certain enough to merge it, and when a merge was wrong."""
