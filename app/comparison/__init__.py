"""Two runs over one recording, beside each other and beside the truth."""
