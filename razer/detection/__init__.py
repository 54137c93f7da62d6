"""3D object detection in one frame: observed surface, and masks lifted to clusters with oriented boxes."""
