"""Verbs that prepare recordings and models: convert, synth, models."""
