"""What all recordings are made of: cameras, images, poses, registration, and the sequence they make up."""
