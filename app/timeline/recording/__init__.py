"""Recordings as Rerun has them: what is logged, in which parts, and how it is laid out."""
