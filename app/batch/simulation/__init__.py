"""What a batch would take elsewhere."""
