"""What other systems predict, read from their files."""
