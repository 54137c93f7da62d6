"""Ground truth of a synthetic scene, and which of it a camera saw."""
