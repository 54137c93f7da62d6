"""Verbs that query a finished map: query, label."""
