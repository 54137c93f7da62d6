"""Verbs that show something as it is: view, inspect, config."""
