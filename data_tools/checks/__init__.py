"""What one can tell about a recording before mapping it."""
