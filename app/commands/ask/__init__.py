"""Verbs that ask a finished map: query, label."""
