"""Files of a map: mesh, instances, embeddings, volume and settings. Each format carries its version."""
