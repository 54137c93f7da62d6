"""Verbs that show runs: view, serve, mcp."""
