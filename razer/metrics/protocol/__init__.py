"""Evaluation protocols: one scene by a preset's rules, and the aggregation over scenes."""
