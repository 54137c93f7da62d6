"""Verbs that measure: eval, compare, reproduce, ablate, bench."""
