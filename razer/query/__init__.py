"""Instances by words or pictures."""
