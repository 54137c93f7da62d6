"""What ICP's iterations are made of: the equations of depth and of matched features, and where steps lead."""
