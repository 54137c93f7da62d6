"""What is true of a synthetic scene, and which of it a camera saw."""
