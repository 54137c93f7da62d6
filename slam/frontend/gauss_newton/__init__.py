"""What ICP's iterations are made of: the equations of depth, and where steps lead."""
