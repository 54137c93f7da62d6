"""Readers: one file for each dataset layout, all ending in a sequence."""
