"""Synthetic worlds: things, rooms, cameras and sensors."""
