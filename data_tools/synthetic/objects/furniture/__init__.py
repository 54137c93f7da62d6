"""Furniture and appliances, one maker per class."""
