"""What is true of a scene, and the files datasets keep it in."""
