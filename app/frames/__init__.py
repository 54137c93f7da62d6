"""Frames on their way to the map: opened, located and perceived in processes ahead of it, and accounted for."""
