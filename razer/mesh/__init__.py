"""The surface of a map as triangles with an instance for each vertex; it loads neither Open3D nor torch."""
