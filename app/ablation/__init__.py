"""What each part of the method contributes: mappers and queries with one thing changed."""
