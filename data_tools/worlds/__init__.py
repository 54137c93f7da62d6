"""Synthetic worlds: furniture, rooms, cameras and sensors."""
