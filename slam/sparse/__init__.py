"""Few pictures far apart, in any order: matched all with all, and solved at once."""
