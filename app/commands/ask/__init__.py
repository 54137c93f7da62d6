"""Verbs that query and correct a finished map: query, label, edit."""
