"""Profiling of a run: time per stage, memory, cores."""
