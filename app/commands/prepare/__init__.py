"""Verbs that prepare recordings, models and settings: inspect, convert, synth, models, config."""
