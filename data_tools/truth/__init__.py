"""Ground truth of a scene, and the files in which datasets keep it."""
