"""Oracle models: ground truth with simulated errors, which separate the map's errors from a model's."""
