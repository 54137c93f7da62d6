"""Verbs that show runs, recordings and settings: view, inspect, config."""
