"""Asking a finished run."""
