"""What one frame shows: its surface, and the masks lifted to 3D detections."""
