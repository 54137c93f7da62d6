"""Solids and materials that things are made of."""
