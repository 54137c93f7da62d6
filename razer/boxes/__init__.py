"""Oriented boxes: from moments, their overlap, and an index of them."""
