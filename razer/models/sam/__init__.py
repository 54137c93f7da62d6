"""Models of SAM's family."""
